"""Cases that are integrated side by side: each comes to what it comes to alone, whatever goes with it."""

from pathlib import Path

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import grid, simulation
from clearsweep.mechanics.compiled.family import NO_ENTRY, empty_entries
from clearsweep.mechanics.compiled.pinned import Pinned, TypeKey
from clearsweep.mechanics.observe.histogram import BINS
from clearsweep.mechanics.solver import loop
from clearsweep.mechanics.solver.choice import COST
from clearsweep.mechanics.solver.event import EVALUATIONS, REJECTED, STEPS
from clearsweep.mechanics.solver.run_control import FAST_STEPS, GOING, OK
from clearsweep.simulation import ensemble, run
from clearsweep.simulation.revolutions import marks_of
from clearsweep.simulation.start import NOWHERE, control_of, start_of

CASES = 11  # no multiple of what a register holds
TIMED = {"run_time", "setup_time"}
SETTINGS = {"simulate.revolutions": 0.6, "simulate.tolerance": 1e-7, "save.orbits": "all"}


@pytest.fixture
def together(monkeypatch):
    """Integrate side by side however few cases there are."""
    monkeypatch.setattr(ensemble, "MANY", 1)


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
    said = (first.status, first.message) == (other.status, other.message)
    return alike and histories and sections and worn and said and np.array_equal(first.events, other.events)


def alone_and_together(listed):
    """Return the results of cases one by one, and those of all of them side by side."""
    result = dict(simulation.solve_each(listed))
    return [simulation.solve(case) for case in listed], [result[place] for place in range(len(listed))]


def test_a_case_is_the_same_alone_beside_others_and_in_any_order(together):
    listed = cases()
    alone, beside = alone_and_together(listed)
    assert all(map(same, alone, beside))
    assert len({trajectory.summary["steps"] for trajectory in alone}) > CASES // 2  # they do differ from each other
    backwards = dict(simulation.solve_each(listed[::-1]))
    assert all(same(first, backwards[CASES - 1 - place]) for place, first in enumerate(alone))


ELASTIC = {"mechanism.rod.elastic": {"axial_stiffness": 4e8, "segments": 2, "damping": 0.02}}
SEALED = {
    "loads": {
        "seal": {
            "on": "slider-ground",
            "friction": {"law": "karnopp", "force": 20, "static_force": 30, "stribeck_velocity": 1, "band": 1e-4},
        }
    }
}


@pytest.mark.slow
@pytest.mark.parametrize("changes", [ELASTIC, SEALED], ids=["elastic rod", "seal that sticks"])
def test_links_that_give_and_guides_that_stick_are_the_same_alone_and_beside_others(together, changes):
    alone, beside = alone_and_together(cases(**changes))
    assert all(map(same, alone, beside))
    assert {trajectory.status for trajectory in alone} == {"ok"}


def test_windows_marks_and_methods_of_one_case_are_not_those_beside_it(together):
    """Some pass marks and open their windows while others are on their way to them; one goes by the implicit method."""
    settings = {"simulate.revolutions": 2.2, "save.orbits": "none"}
    listed = cases(count=9, **settings)
    for place, case in enumerate(listed):
        method = "implicit" if place == 2 else "auto"
        listed[place] = case._replace(simulate=case.simulate._replace(method=method, discard=0.1 + 0.5 * (place % 3)))
    alone, beside = alone_and_together(listed)
    assert all(map(same, alone, beside))
    assert len({trajectory.summary["rod_slider_force_peak_median"] for trajectory in alone}) == len(listed)


def test_a_case_leaves_nothing_to_the_next_one_that_uses_its_arrays():
    """Also where it failed, or went by the implicit method; and what it came to stays as it is."""
    first, second, third, fourth = cases(count=4, **{"save.orbits": "none"})
    failing = second._replace(simulate=second.simulate._replace(step_budget=40))
    implicit = third._replace(simulate=third.simulate._replace(method="implicit"))
    result = []
    for case in (first, failing, first, implicit, first, fourth, first):
        result.append(simulation.solve(case))
        assert len(run._spare) == 1
    assert [path.status for path in result] == ["ok", "step-budget", *["ok"] * 5]
    run._spare.clear()
    anew = simulation.solve(first)
    assert all(same(path, anew) for path in result[::2])


def test_steps_are_taken_side_by_side_where_that_is_possible(together, monkeypatch):
    asked = []

    def watched(model, lot):
        asked.append((len(lot.value.addresses), lot.value.together.code != 0))
        return integrate(model, lot)

    integrate = loop.integrate
    monkeypatch.setattr(ensemble.loop, "integrate", watched)
    list(simulation.solve_each(cases()))
    assert max(asked) == (min(CASES, ensemble.WIDTH), True)


def test_what_happens_to_one_case_happens_to_none_beside_it(together):
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


def test_a_budget_that_just_suffices_or_just_does_not_comes_to_the_same_beside_others(together):
    listed = cases(**{"save.orbits": "none"})
    taken = [simulation.solve(case).summary for case in listed]
    for place, more in enumerate([0, -1, 1, 0, -1]):
        steps = taken[place]["steps"] + taken[place]["steps_rejected"] + more
        listed[place] = listed[place]._replace(simulate=listed[place].simulate._replace(step_budget=steps))
    alone, beside = alone_and_together(listed)
    assert all(map(same, alone, beside))
    assert {alone[1].status, alone[4].status} == {"step-budget"}
    assert [path.status for place, path in enumerate(alone) if place not in (1, 4)] == ["ok"] * (CASES - 2)


def test_a_case_without_time_ends_as_alone_and_leaves_those_beside_it_as_they_are(together):
    listed = cases(**{"save.orbits": "none"})
    alone = [simulation.solve(case) for case in listed]
    hasty = listed[4]._replace(simulate=listed[4].simulate._replace(revolutions=1e9, time_budget=1e-3))
    result = dict(simulation.solve_each([*listed[:4], hasty, *listed[5:]]))
    assert result[4].status == simulation.solve(hasty).status == "time-budget"
    assert all(same(alone[place], result[place]) for place in range(CASES) if place != 4)


def test_what_goes_wrong_with_one_case_on_the_way_is_its_own(together, monkeypatch):
    def ended(self, status):
        if self.value.joints[0].clearance == unlucky:
            raise MemoryError("no room")
        return through(self, status)

    listed, through = cases(count=4), run.Run.ended
    unlucky = listed[2].joints[0].clearance
    alone = [simulation.solve(case) for case in listed]
    monkeypatch.setattr(run.Run, "ended", ended)
    result = dict(simulation.solve_each(listed))
    assert isinstance(result.pop(2), MemoryError)
    assert len(result) == 3
    assert all(same(alone[place], other) for place, other in result.items())


def test_a_crank_that_comes_to_rest_too_early_is_refused_as_it_is_alone(tmp_path):
    table = tmp_path / "speed.csv"
    table.write_text("time,speed\n0,100\n0.1,0\n", encoding="utf-8")
    changes = {"drive.speed": {"table": str(table)}, "simulate.revolutions": 50}
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes)).case
    with pytest.raises(clearsweep.InputError, match="comes to rest"):
        simulation.solve(case)
    ((_, error),) = simulation.solve_each([case])
    assert "comes to rest" in str(error)


@pytest.mark.slow
def test_values_that_are_zero_make_scenes_of_another_type_which_go_by_themselves(together):
    offsets = [0.0, 0.01, 0.0, 0.01, 0.0]
    listed = [cases(count=1, **{"mechanism.slider.offset": offset})[0] for offset in offsets]
    assert all(map(same, *alone_and_together(listed)))


def test_a_log_that_is_full_is_taken_away_and_the_motion_goes_on(together, monkeypatch):
    listed = cases(count=4)
    whole = [simulation.solve(case).events for case in listed]
    assert max(map(len, whole)) > 8
    monkeypatch.setattr(run.loop, "LOG", 4)
    alone, beside = alone_and_together(listed)
    for first, *others in zip(whole, alone, beside, strict=True):
        assert all(np.array_equal(first, other.events) for other in others)


def test_time_that_went_to_other_cases_does_not_count(together, monkeypatch):
    clock = [0.0]

    def slow(*given):
        clock[0] += 1.0
        integrate(*given)

    integrate = loop.integrate
    monkeypatch.setattr(ensemble.loop, "integrate", slow)
    monkeypatch.setattr(ensemble.time, "process_time", lambda: clock[0])
    monkeypatch.setattr(run.loop, "LOG", 4)  # so that they pause on the way, when they are asked how long they took
    limited = [case._replace(simulate=case.simulate._replace(time_budget=20.0)) for case in cases(count=ensemble.WIDTH)]
    statuses = [trajectory.status for _, trajectory in simulation.solve_each(limited)]
    assert clock[0] > 40.0  # two budgets
    assert statuses == ["ok"] * ensemble.WIDTH


def test_what_has_ended_is_told_before_others_have_begun_where_they_take_long(together, monkeypatch):
    began = []

    def slow(*given):
        began.append(1)
        integrate(*given)

    integrate, listed = loop.integrate, cases()
    monkeypatch.setattr(ensemble.loop, "integrate", slow)
    monkeypatch.setattr(ensemble.time, "process_time", lambda: float(len(began)))
    result = simulation.solve_each(listed)
    place, first = next(result)
    early = len(began)
    assert same(simulation.solve(listed[place]), first)
    assert len(list(result)) == CASES - 1
    assert early < len(began) / 2


def test_cases_go_by_themselves_where_their_step_together_cannot_be_made(together, monkeypatch):
    def unmade(*given):
        raise MemoryError

    monkeypatch.setattr(ensemble, "together_of", unmade)
    listed = cases(count=3)
    assert all(same(simulation.solve(listed[place]), result) for place, result in simulation.solve_each(listed))


def test_one_contact_and_several_are_of_one_form_to_the_loop():
    forms = set()
    for joints in (("rod-slider",), ("ground-crank", "rod-slider")):
        with empty_entries():
            first = run.Run(start_of(simulation.build(cases(*joints, count=1)[0]), np.empty(0)))
        forms.add((repr(TypeKey(first.work)), *(repr(TypeKey(arrays)) for arrays in run.shared(first.lane))))
    assert len(forms) == 1


# ---------------------------------------------------------------------------------------------- in the same lane

#: Fields of a Work that the type of a scene decides, and those that are written before they are read.
OF_TYPE = {"apart", "pressed", "ended_by", "contact", "modes", "leads_to", "at_stages", "at_start", "of_state"}
OF_TYPE |= {"counted", "ends_run", "column", "sign"}
SCRATCH = {"end", "z", "k", "o", "f", "step", "bins", "spent", "log", "control"}
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
    assert np.array_equal(used.lane["parameters"], new.lane["parameters"])
    for numbers in ("reference_rate", "sigma", "longest"):
        assert getattr(used.work, numbers) == getattr(new.work, numbers) != getattr(first.value, numbers, 0.0)


def test_a_calm_step_comes_to_what_one_does_that_is_looked_at():
    """A run that pauses after every step looks at each; it only evaluates anew where it goes on, but after the last."""
    _, case = cases(count=2, **{"simulate.tolerance": 1e-4, "simulate.revolutions": 2.2})
    scene = simulation.build(case)
    control = control_of(scene, scene.crank_clock.at(2.2), keep_events=True)
    times, marks, runs, events = np.linspace(0.0, 1e-3, 5), marks_of(scene, 2.2), [], []
    for stretch in (control.stretch, 1):
        runs.append(run.Run(start_of(scene, times, marks)))
        events.append(runs[-1].go(control._replace(stretch=stretch))[1])
    calm, paused = (first.work for first in runs)
    message = {
        "whole",
        "joint",
        "histogram",
        "samples",
        "states",
        "peaks",
        "passed",
        "end",
        "mode",
        "method",
        "proposals",
    }
    message.add("choice")  # of the method, by evaluations
    for (name, first), (_, other) in zip(arrays_in(calm), arrays_in(paused), strict=True):
        assert name not in message or np.array_equal(first, other), name
    assert np.array_equal(*events)
    again = paused.counts - calm.counts
    assert again[EVALUATIONS] == again.sum() == calm.counts[STEPS] - 1 > 100
    assert calm.implicit.choice[COST] > 0.0  # somebody asked
    assert calm.counts[REJECTED] > 0


def test_most_steps_are_calm():
    """What a case in another lane has not counted yet, when one ends, are its fast steps."""
    scenes = [simulation.build(case) for case in cases(count=2, **{"save.orbits": "none"})]
    board = run.board_of(scenes[0])
    runs = [run.Run(start_of(scene, NOWHERE), lane=run.lane_of(board, lane)) for lane, scene in enumerate(scenes)]
    for first, scene in zip(runs, scenes, strict=True):
        run.start(first, control_of(scene, scene.crank_clock.at(0.6), keep_events=False))
    addresses, status, most = np.array([first.kept.address for first in runs]), np.zeros(2, np.int64), 0.0
    lot = Pinned(loop.Lot(addresses, status, NO_ENTRY, *run.shared(runs[0].lane)))
    for end in np.linspace(0.1, 0.5, 40):
        runs[0].heed(control_of(scenes[0], scenes[0].crank_clock.at(end), keep_events=False))
        loop.integrate(runs[0].kept, lot)
        most = max(most, runs[1].work.stepper[FAST_STEPS])
    assert status.tolist() == [OK, GOING]
    assert most > 5.0


# ---------------------------------------------------------------------------------------------- what goes side by side


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"joints.rod-slider.contact.onset": "first"},
        {"joints.rod-slider.contact.exponent": 1.2},
        {"mechanism.gravity": 9.81, "simulate.start": "seated"},
        {"joints.rod-slider.friction": {"law": "tanh", "coefficient": 0.1, "velocity_scale": 0.01}},
        {"joints.rod-slider.friction": {"law": "threlfall", "coefficient": 0.1, "velocity_scale": 0.01}},
        {"joints.rod-slider.wear": {"law": "archard", "coefficient": 1e-15}},
    ],
)
def test_what_can_go_side_by_side_comes_to_the_same(changes, together):
    assert all(map(same, *alone_and_together(cases(**changes))))


@pytest.mark.slow
@pytest.mark.parametrize(
    "joints", [("crank-rod",), ("ground-crank", "rod-slider"), ("ground-crank", "crank-rod", "rod-slider")]
)
def test_any_opening_comes_to_the_same(joints, together):
    assert all(map(same, *alone_and_together(cases(*joints))))


@pytest.mark.parametrize("name", ["lubricated", "worn_slider_crank", "probabilistic", "four_bar"])
def test_lanes_without_a_case_do_no_harm(name, together):
    """Tables are read at addresses that are among the parameters, in every lane."""
    result = grid.load(Path(__file__).parents[1] / "configs" / f"{name}.yaml", simulation.catalogue())
    assert all(map(same, *alone_and_together([result.case(i) for i in range(3)])))
