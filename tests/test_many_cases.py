"""Many cases in turn: each comes to what it comes to alone, whatever goes before it."""

import itertools

import numpy as np
import pytest
from fake_physics import CATALOGUE, grid
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation
from clearsweep.mechanics.observe import BINS
from clearsweep.simulation.running import run
from clearsweep.simulation.setup.start import marks_of, start_of
from clearsweep.tracing.compiled.family import empty_entries
from clearsweep.tracing.compiled.pinned import Layout

CASES = 11
TIMED = {"run_time", "setup_time"}
SETTINGS = {"simulate.revolutions": 0.6, "simulate.tolerance": 1e-7, "save.orbits": "all"}


def cases(*joints, count=CASES, **changes):
    """Return cases of a slider-crank whose clearance, restitution and speed are drawn."""
    drawn, joints = np.random.default_rng(5), joints or ("rod-slider",)
    first = f"joints.{joints[0]}"
    return [
        clearsweep.load_case(
            slider_crank(
                *joints,
                changes=SETTINGS
                | {
                    f"{first}.clearance": drawn.uniform(2e-5, 8e-4),
                    f"{first}.contact.restitution": drawn.uniform(0.4, 0.95),
                    "drive.speed": drawn.uniform(50.0, 500.0),
                }
                | changes,
            )
        ).case
        for _ in range(count)
    ]


def same(first, other):
    """Return whether two trajectories are equal to the last bit, but for the time they took."""
    alike = all(repr(value) == repr(other.summary[name]) for name, value in first.summary.items() if name not in TIMED)
    histories = all(np.array_equal(values, other.channels[name]) for name, values in first.channels.items())
    sections = all(np.array_equal(values, other.poincare[name]) for name, values in first.poincare.items())
    worn = all(map(np.array_equal, sum(first.wear.values(), ()), sum(other.wear.values(), ())))
    text = (first.status, first.message) == (other.status, other.message)
    return alike and histories and sections and worn and text and np.array_equal(first.events, other.events)


def alone(case):
    """Return the result of a case in arrays that no case has used."""
    run.released_runs.clear()
    return simulation.solve(case)


def in_turn(listed):
    """Return the results of cases one after the other, which use the same arrays."""
    run.released_runs.clear()
    return [simulation.solve(case) for case in listed]


def test_a_case_is_the_same_alone_and_among_others_and_in_any_order():
    listed = cases()
    separate = list(map(alone, listed))
    assert all(map(same, separate, in_turn(listed)))
    assert len(run.released_runs) == 1
    assert len({trajectory.summary["steps"] for trajectory in separate}) > CASES // 2  # they do differ from each other
    assert all(map(same, separate, in_turn(listed[::-1])[::-1]))


def test_windows_marks_and_methods_of_one_case_are_independent_of_the_others():
    """Some pass marks and open their windows where others have not begun theirs; one uses the implicit method."""
    settings = {"simulate.revolutions": 2.2, "save.orbits": "none"}
    listed = cases(count=9, **settings)
    for place, case in enumerate(listed):
        method = "implicit" if place == 2 else "auto"
        listed[place] = case._replace(simulate=case.simulate._replace(method=method, discard=0.1 + 0.5 * (place % 3)))
    separate = list(map(alone, listed))
    assert all(map(same, separate, in_turn(listed)))
    assert len({trajectory.summary["rod_slider_force_peak_median"] for trajectory in separate}) == len(listed)


def test_what_happens_to_one_case_does_not_affect_the_others():
    listed = cases(**{"save.orbits": "none"})
    spoiled = listed.copy()
    for place, settings in (
        (3, {"step_budget": 50}),
        (5, {"event_budget": 1}),
        (6, {"revolutions": 1e9, "time_budget": 1e-3}),
        (7, {"error_check": True}),
    ):
        spoiled[place] = listed[place]._replace(simulate=listed[place].simulate._replace(**settings))
    result = in_turn(spoiled)
    assert [result[place].status for place in (3, 5, 6, 7)] == ["step-budget", "event-budget", "time-budget", "ok"]
    assert same(alone(spoiled[7]), result[7])
    untouched = [place for place in range(CASES) if spoiled[place] is listed[place]]
    assert all(same(alone(listed[place]), result[place]) for place in untouched)


def test_an_error_in_one_case_leaves_the_next_as_it_is(monkeypatch):
    def ended(self, status):
        if self.value.joints[0].clearance == unlucky:
            raise MemoryError("no room")
        return through(self, status)

    (*listed, last), through = cases(count=4), run.Run.has_ended
    unlucky = listed[-1].joints[0].clearance
    separate = alone(last)
    in_turn(listed)
    monkeypatch.setattr(run.Run, "has_ended", ended)
    with pytest.raises(MemoryError):
        simulation.solve(listed[-1])
    assert same(separate, simulation.solve(last))


def test_a_crank_that_comes_to_rest_too_early_is_refused(tmp_path):
    table = tmp_path / "speed.csv"
    table.write_text("time,speed\n0,100\n0.1,0\n", encoding="utf-8")
    changes = {"drive.speed": {"table": str(table)}, "simulate.revolutions": 50}
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes)).case
    with pytest.raises(clearsweep.InputError, match="the crank stops before"):
        simulation.solve(case)


def test_a_log_that_is_full_is_taken_away_and_the_motion_continues(monkeypatch):
    listed = cases(count=4)
    whole = [simulation.solve(case).events for case in listed]
    assert max(map(len, whole)) > 8
    monkeypatch.setattr(run.loop, "LOG_ROWS", 4)
    for first, other in zip(whole, in_turn(listed), strict=True):
        assert np.array_equal(first, other.events)


def test_one_contact_and_several_are_of_one_form_to_the_loop():
    variants = set()
    for joints in (("rod-slider",), ("ground-crank", "rod-slider")):
        with empty_entries():
            first = run.Run(start_of(simulation.build(cases(*joints, count=1)[0]), np.empty(0)))
        variants.add(repr(Layout(first.work)))
    assert len(variants) == 1


# ---------------------------------------------------------------------------------------------- in the same lane

#: Fields of a Work that the type of a scene decides, and those that are written before they are read.
OF_TYPE = {"apart", "pressed", "reset_by", "contact", "modes", "next_mode", "at_start"}
OF_TYPE |= {"has_histogram", "resultant", "counted", "ends_run", "column", "sign"}
SCRATCH = {
    "end",
    "z",
    "k",
    "o",
    "f",
    "nodes",
    "polynomials",
    "value",
    "step",
    "profiles",
    "bins",
    "part_times",
    "fine_sums",
    "fine_bins",
    "log",
    "control",
}
WORN = {
    "joints.rod-slider.length": 0.02,
    "joints.rod-slider.wear": {"law": "archard", "coefficient": 2e-14, "bins": 36},
}
STICKS = {
    "joints.rod-slider.friction": {
        "law": "lugre",
        "static_coefficient": 0.15,
        "coefficient": 0.1,
        "stribeck_velocity": 0.01,
        "bristle_stiffness": 1e5,
        "bristle_damping": 10.0,
        "viscous": 0.0,
    }
}


def arrays_in(value, name=""):
    """Yield the arrays in nested tuples and the names of their fields."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple):
        for field in getattr(value, "_fields", ()):
            yield from arrays_in(getattr(value, field), field)


@pytest.mark.parametrize("changes", [{}, WORN, STICKS], ids=["plain", "worn", "sticks"])
def test_a_run_that_begins_another_scene_is_as_one_made_for_it(changes):
    with empty_entries():
        first, second = (simulation.build(case) for case in cases(count=2, **changes))
        times, marks = np.linspace(0.0, 1e-3, 5), marks_of(second, 0.6)
        used, new = (run.Run(start_of(scene, times, marks)) for scene in (first, second))
        for name, array in arrays_in(used.work):
            array[...] = array if name in OF_TYPE else 7
        used.totals.bins[:] = BINS - 1  # up to which the histogram was filled
        used.begin(start_of(second, times, marks))
    pairs = zip(arrays_in(used.work), arrays_in(new.work), strict=True)
    differing = [name for (name, was), (_, is_new) in pairs if name not in SCRATCH and not np.array_equal(was, is_new)]
    assert not differing
    assert np.array_equal(used.parameters, new.parameters)
    for numbers in ("reference_rate", "sigma", "max_duration"):
        assert getattr(used.work, numbers) == getattr(new.work, numbers) != getattr(first.value, numbers, 0.0)


# ---------------------------------------------------------------------------------------------- what goes side by side


# The identities of a range of cases are those that the cases have in the whole grid, and cost no more.


LAW = "joints.rod-slider.contact.law"
LOSS = "joints.rod-slider.contact.restitution"
MASS, SPEED = "mechanism.slider.mass", "drive.speed"
SWEEPS = {
    "numbers": {MASS: [0.1, 0.2, 0.3], "mechanism.gravity": [0.0, 1.0], SPEED: [100.0, 200.0, 300.0, 400.0]},
    "laws": {LAW: ["hertz", "lankarani-nikravesh"], LOSS: [0.5, 0.7, 0.9], MASS: [0.1, 0.2]},
    "one": {MASS: [0.1]},
}


@pytest.mark.parametrize("name", SWEEPS)
def test_identities_of_any_range_are_those_of_the_whole(name):
    whole = grids.load(grid(sweep=SWEEPS[name]), CATALOGUE)
    ids, words = list(whole.identities()), list(whole.law_assignments())
    assert [f"{case_id:016x}" for case_id in ids] == [whole.case_id(index) for index in range(len(whole))]
    for first, last in itertools.combinations(range(len(whole) + 1), 2):
        assert list(whole.identities(range(first, last))) == ids[first:last]
        assert list(whole.law_assignments(range(first, last))) == words[first:last]


def test_added_cases_are_behind_the_product_in_a_range_too():
    whole = grids.load(grid(sweep=SWEEPS["numbers"]), CATALOGUE)
    point = whole.point(3) | {MASS: 0.7}
    whole = whole.with_added([point])
    ids = list(whole.identities())
    assert list(whole.identities(range(22, 25))) == ids[22:]
    assert list(whole.identities(range(24, 25))) == [int(whole.case_id(24), 16)]


def test_the_last_of_a_hundred_million_identities_come_at_once():
    many = [float(value) for value in range(1, 501)]
    whole = grids.load(grid(sweep={MASS: many, "mechanism.gravity": many, SPEED: many}), CATALOGUE)
    last = len(whole) - 3
    assert [f"{identity:016x}" for identity in whole.identities(range(last, len(whole)))] == [
        whole.case_id(index) for index in range(last, len(whole))
    ]


def test_a_plain_product_has_no_case_twice_and_says_so():
    plain = grids.load(grid(sweep=SWEEPS["laws"]), CATALOGUE)
    assert not plain.may_repeat
    assert len(set(plain.identities())) == len(plain)
    stepped = {"zip": {MASS: [0.1, 0.2], SPEED: [100.0, 200.0]}}
    assert grids.load(grid(sweep={"mechanism.gravity": [0.0]}, **stepped), CATALOGUE).may_repeat
