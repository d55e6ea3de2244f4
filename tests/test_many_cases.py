"""Many cases in turn: each comes to what it comes to alone, whatever goes before it."""

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import simulation
from clearsweep.mechanics.compiled.family import empty_entries
from clearsweep.mechanics.compiled.pinned import Layout
from clearsweep.mechanics.observe.histogram import BINS
from clearsweep.mechanics.solver import loop
from clearsweep.simulation import ensemble, run
from clearsweep.simulation.revolutions import marks_of
from clearsweep.simulation.start import start_of

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


def alone_and_in_turn(listed):
    """Return the results of cases one by one, and those of all of them in turn."""
    result = dict(simulation.solve_each(listed))
    return [simulation.solve(case) for case in listed], [result[place] for place in range(len(listed))]


def test_a_case_is_the_same_alone_and_among_others_and_in_any_order():
    listed = cases()
    alone, neighbour = alone_and_in_turn(listed)
    assert all(map(same, alone, neighbour))
    assert len({trajectory.summary["steps"] for trajectory in alone}) > CASES // 2  # they do differ from each other
    backwards = dict(simulation.solve_each(listed[::-1]))
    assert all(same(first, backwards[CASES - 1 - place]) for place, first in enumerate(alone))


def test_windows_marks_and_methods_of_one_case_are_independent_of_the_others():
    """Some pass marks and open their windows while others are on their way to them; one uses the implicit method."""
    settings = {"simulate.revolutions": 2.2, "save.orbits": "none"}
    listed = cases(count=9, **settings)
    for place, case in enumerate(listed):
        method = "implicit" if place == 2 else "auto"
        listed[place] = case._replace(simulate=case.simulate._replace(method=method, discard=0.1 + 0.5 * (place % 3)))
    alone, neighbour = alone_and_in_turn(listed)
    assert all(map(same, alone, neighbour))
    assert len({trajectory.summary["rod_slider_force_peak_median"] for trajectory in alone}) == len(listed)


def test_a_case_leaves_nothing_to_the_next_one_that_uses_its_arrays():
    """Also where it failed, or went by the implicit method; and what it came to stays as it is."""
    first, second, third, fourth = cases(count=4, **{"save.orbits": "none"})
    failing = second._replace(simulate=second.simulate._replace(step_budget=40))
    implicit = third._replace(simulate=third.simulate._replace(method="implicit"))
    result = []
    for case in (first, failing, first, implicit, first, fourth, first):
        result.append(simulation.solve(case))
        assert len(run._released_runs) == 1
    assert [path.status for path in result] == ["ok", "step-budget", *["ok"] * 5]
    run._released_runs.clear()
    anew = simulation.solve(first)
    assert all(same(path, anew) for path in result[::2])


def test_what_happens_to_one_case_does_not_affect_the_others():
    listed = cases()
    short = listed[3]._replace(simulate=listed[3].simulate._replace(step_budget=50))
    hasty = listed[5]._replace(simulate=listed[5].simulate._replace(event_budget=1))
    checked = listed[7]._replace(simulate=listed[7].simulate._replace(error_check=True))
    broken = listed[8]._replace(mechanism=None)
    spoiled = [*listed[:3], short, listed[4], hasty, listed[6], checked, broken, *listed[9:]]
    result = dict(simulation.solve_each(spoiled))
    assert [result[3].status, result[5].status] == ["step-budget", "event-budget"]
    assert isinstance(result[8], Exception)
    assert same(simulation.solve(checked), result[7])
    untouched = [place for place in range(CASES) if place not in (3, 5, 7, 8)]
    assert all(same(simulation.solve(listed[place]), result[place]) for place in untouched)


def test_a_case_without_time_ends_as_alone_and_leaves_those_beside_it_as_they_are():
    listed = cases(**{"save.orbits": "none"})
    alone = [simulation.solve(case) for case in listed]
    hasty = listed[4]._replace(simulate=listed[4].simulate._replace(revolutions=1e9, time_budget=1e-3))
    result = dict(simulation.solve_each([*listed[:4], hasty, *listed[5:]]))
    assert result[4].status == simulation.solve(hasty).status == "time-budget"
    assert all(same(alone[place], result[place]) for place in range(CASES) if place != 4)


def test_what_goes_wrong_with_one_case_on_the_way_is_its_own(monkeypatch):
    def ended(self, status):
        if self.value.joints[0].clearance == unlucky:
            raise MemoryError("no room")
        return through(self, status)

    listed, through = cases(count=4), run.Run.has_ended
    unlucky = listed[2].joints[0].clearance
    alone = [simulation.solve(case) for case in listed]
    monkeypatch.setattr(run.Run, "has_ended", ended)
    result = dict(simulation.solve_each(listed))
    assert isinstance(result.pop(2), MemoryError)
    assert len(result) == 3
    assert all(same(alone[place], other) for place, other in result.items())


def test_a_crank_that_comes_to_rest_too_early_is_refused_as_it_is_alone(tmp_path):
    table = tmp_path / "speed.csv"
    table.write_text("time,speed\n0,100\n0.1,0\n", encoding="utf-8")
    changes = {"drive.speed": {"table": str(table)}, "simulate.revolutions": 50}
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes)).case
    with pytest.raises(clearsweep.InputError, match="the crank stops before"):
        simulation.solve(case)
    ((_, error),) = simulation.solve_each([case])
    assert "the crank stops before" in str(error)


def test_a_log_that_is_full_is_taken_away_and_the_motion_continues(monkeypatch):
    listed = cases(count=4)
    whole = [simulation.solve(case).events for case in listed]
    assert max(map(len, whole)) > 8
    monkeypatch.setattr(run.loop, "LOG_ROWS", 4)
    alone, neighbour = alone_and_in_turn(listed)
    for first, *others in zip(whole, alone, neighbour, strict=True):
        assert all(np.array_equal(first, other.events) for other in others)


def test_what_has_ended_is_reported_before_others_have_begun_where_they_take_long(monkeypatch):
    began = []

    def slow(*given):
        began.append(1)
        integrate(*given)

    integrate, listed = loop.integrate, cases()
    monkeypatch.setattr(run.loop, "integrate", slow)
    monkeypatch.setattr(ensemble.time, "process_time", lambda: float(len(began)))
    result = simulation.solve_each(listed)
    place, first = next(result)
    early = len(began)
    assert same(simulation.solve(listed[place]), first)
    assert len(list(result)) == CASES - 1
    assert early < len(began) / 2


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
OF_TYPE |= {"counted", "ends_run", "column", "sign"}
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
