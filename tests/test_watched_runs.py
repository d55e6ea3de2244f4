"""Runs that are watched: as long as they need, how fast disturbances grow, what a tighter tolerance changes."""

import dataclasses
import math

import numpy as np
import pytest
from mechanism_cases import PAIR, changed, slider_crank

import clearsweep
from clearsweep import grid, report, simulation
from clearsweep.contracts.layout import converging_columns
from clearsweep.contracts.results import TIMINGS
from clearsweep.language import phases
from clearsweep.language.errors import InputError
from clearsweep.simulation.analyses.outcome import window_of
from clearsweep.simulation.analyses.trajectory import peak_revolution
from clearsweep.simulation.figures import catalogue
from clearsweep.simulation.figures.sums import half_width
from clearsweep.simulation.running import observed_run
from clearsweep.simulation.running import run as running
from clearsweep.simulation.setup.start import period_of
from clearsweep.verify.accuracy import all_problems

pytestmark = pytest.mark.heavy

COSTS = ("steps", "steps_rejected", "rhs_evaluations", *TIMINGS)
WORN = {
    "joints.rod-slider.friction": {"law": "tanh", "coefficient": 0.05, "velocity_scale": 1e-3},
    "joints.rod-slider.wear": {"law": "archard", "coefficient": 2e-14},
}
ROUGH = WORN | {"joints.rod-slider.friction": {"law": "tanh", "coefficient": 0.01, "velocity_scale": 1e-3}}  # chaotic
REGULAR = {"joints.rod-slider.clearance": 1e-5, "joints.rod-slider.contact.restitution": 0.1}
LONG = {"simulate.revolutions": 4, "simulate.discard": 1, "simulate.tolerance": 1e-7}


THERMAL = {"conductance": "2 W/K", "ambient": "20 degC", "expansion": {"bearing": 18e-6, "journal": 12e-6}}
HEATED = {"joints.rod-slider.thermal": THERMAL}


def until(figure="rod_slider_force_rms", relative=0.1, most=60):
    return {"simulate.until": {"figure": figure, "relative_ci": relative, "max_revolutions": most}}


def run(*settings, **more):
    changes = {}
    for first in (LONG, *settings):
        changes |= first
    return clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes | more)))


@pytest.mark.slow
def test_a_run_that_reports_how_far_it_is_is_the_same_to_the_last_bit(monkeypatch, capsys):
    for name, seconds in {"FIRST_LINE_DELAY": 0.0, "MAX_INTERVAL": 0.0, "REFRESH_INTERVAL": 1e-4}.items():
        monkeypatch.setattr(phases, name, seconds)
    longer = {"simulate.revolutions": 400}  # a run says how far it is after thousands of steps
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=LONG | WORN | longer))
    message, plain = clearsweep.simulate(scene, progress=True), clearsweep.simulate(scene)
    assert figures(message) == figures(plain)
    assert all(np.array_equal(message[name], plain[name]) for name in plain.channels)
    assert "of 400, " in capsys.readouterr().err


def figures(result):
    return {name: value for name, value in result.summary.items() if name not in COSTS}


# ---------------------------------------------------------------------------------------------- length


@pytest.mark.few("auto-all", "implicit-last")
@pytest.mark.parametrize(
    "orbits", [{"save.orbits": "all"}, {"save.orbits": "last", "save.revolutions": 1.5}], ids=["all", "last"]
)
@pytest.mark.parametrize("method", ["auto", "implicit"])
def test_a_run_that_found_its_length_is_to_the_last_bit_a_run_of_that_length(orbits, method):
    asked = ROUGH | orbits | {"simulate.method": method, "save.samples": 90}
    result = run(until(relative=0.9), asked)
    length = result.summary["revolutions_run"]
    assert 30 < length < 40
    plain = run(asked, {"simulate.revolutions": length})
    assert {name: result.summary[name] for name in figures(plain)} == figures(plain)
    assert plain.channels
    assert all(np.array_equal(result[name], plain[name]) for name in plain.channels)
    assert np.array_equal(result.events, plain.events)
    assert all(np.array_equal(*both) for both in zip(result.wear["rod_slider"], plain.wear["rod_slider"], strict=True))


def test_a_stiff_run_is_watched_without_a_trace():
    """Also where the method changes on the way: that is decided by the steps alone."""
    damped = {"joints.rod-slider.contact": {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 1e6}}
    asked = damped | {"simulate.tolerance": 1e-6, "save.orbits": "last", "save.revolutions": 1, "save.samples": 90}
    result = run(until(relative=0.9), asked)
    plain = run(asked, {"simulate.revolutions": result.summary["revolutions_run"]})
    assert {name: result.summary[name] for name in figures(plain)} == figures(plain)
    assert all(np.array_equal(result[name], plain[name]) for name in plain.channels)
    less = {
        "joints.rod-slider.contact": {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 2e5},
        "drive.speed": "1500 rpm",
        "simulate.tolerance": 1e-6,
    }
    assert figures(run(less)).items() <= figures(run(less, {"simulate.horizon": True})).items()


def test_reported_times_of_ones_own_may_begin_anywhere():
    case = slider_crank("rod-slider", changes=LONG | until(relative=0.9))
    result = clearsweep.simulate(clearsweep.load_case(case), times=[0.0, 0.001, 0.05])
    plain = clearsweep.simulate(
        clearsweep.load_case(
            slider_crank("rod-slider", changes=LONG | {"simulate.revolutions": result.summary["revolutions_run"]})
        ),
        times=[0.0, 0.001, 0.05],
    )
    assert np.array_equal(result["slider/x"], plain["slider/x"])
    with pytest.raises(InputError, match="the run lasts from 0"):
        clearsweep.simulate(clearsweep.load_case(case), times=[1.0])


@pytest.mark.parametrize("save", [{"save.orbits": "none"}, {"save.orbits": "all", "save.samples": 36}])
def test_saved_histories_use_up_no_budget(save):
    """A budget is that of the longest run; the samples are written in a second one."""
    asked = until(relative=1e-3, most=120)
    free = run(REGULAR, asked, save).summary
    budget = math.ceil(1.2 * (free["steps"] + free["steps_rejected"]) / 120)
    assert budget * free["revolutions_run"] < 0.5 * free["steps"]
    result = run(REGULAR, asked, save, {"simulate.step_budget": budget})
    assert (result.status, result.summary["steps"]) == ("ok", free["steps"])


@pytest.mark.few("rough")
@pytest.mark.parametrize("motion", [ROUGH | HEATED, WORN], ids=["rough", "periodic"])
def test_the_largest_peak_of_a_run_that_found_its_length_is_found_again(motion):
    """Also with a heat balance, whose runs are as long as the case asks, and with a budget for the longest run."""
    changes = LONG | until(relative=0.9) | motion | {"simulate.step_budget": 1000}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    summary = clearsweep.simulate(scene).summary
    assert summary["revolutions_run"] > scene.case.simulate.revolutions
    assert (summary["window_from"] > 1.0) == (motion is WORN)
    peak = peak_revolution(scene.case, 0, summary["revolutions_run"], summary["window_from"])
    assert peak.path.summary["rod_slider_force_peak"] == summary["rod_slider_force_peak"]
    assert peak.turns >= summary["window_from"]


def test_a_speed_table_that_ends_before_the_longest_run_is_refused(tmp_path):
    table = tmp_path / "speed.csv"
    table.write_text("time,speed\n0,150\n0.2,150\n0.3,0\n", encoding="utf-8")
    with pytest.raises(clearsweep.InputError, match=r"crank stops before 60 revolutions; .* simulate.until.max_rev"):
        run(until(), {"drive.speed": {"table": str(table)}})


def test_a_periodic_motion_ends_early_and_says_its_period():
    result = run(REGULAR, until(relative=1e-3))
    assert result.status == "ok"
    assert result.summary["period"] == 1
    assert result.summary["settled"] == 1
    assert result.summary["revolutions_run"] < 15
    longer = run(REGULAR, {"simulate.revolutions": 10})
    assert result.summary["rod_slider_force_peak"] == pytest.approx(longer.summary["rod_slider_force_peak"], rel=1e-3)


RUN_IN = {
    "drive.speed": "4000 rpm",
    "mechanism.gravity": 0.0,
    "joints.rod-slider.clearance": 2e-4,
    "joints.rod-slider.contact": {"law": "flores", "stiffness": 1e11, "restitution": 0.8},
    "joints.rod-slider.friction": {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2},
    "joints.rod-slider.wear": WORN["joints.rod-slider.wear"],
    "simulate.tolerance": 1e-6,
}


@pytest.fixture(scope="module")
def limit_cycle():
    """Return the figures of a motion of period 1, of which a run-in of 150 revolutions is left out."""
    return run(RUN_IN, {"simulate.revolutions": 160, "simulate.discard": 150}).summary


@pytest.mark.few("force_p99", "wear_rate_max")
@pytest.mark.parametrize("figure", ["impacts_per_rev", "force_p99", "contact_fraction", "wear_rate_max"])
def test_figures_of_a_periodic_motion_are_those_of_its_limit_cycle(limit_cycle, figure):
    """Its first ten revolutions have no impact; the later ones of its run-in have larger forces."""
    name = f"rod_slider_{figure}"
    result = run(RUN_IN, until(name, relative=0.02, most=300), {"simulate.revolutions": 6, "simulate.discard": 2})
    assert (result.summary["settled"], result.summary["period"]) == (1, 1)
    assert result.summary["window_from"] > 10.0
    assert result.summary[name] == pytest.approx(limit_cycle[name], rel=2e-3)
    assert result.summary["figure_ci"] <= 0.02 * result.summary[name]
    for peak in ("force_peak", "force_peak_median", "force_peak_million"):
        assert result.summary[f"rod_slider_{peak}"] == pytest.approx(limit_cycle["rod_slider_force_peak"], rel=1e-4)
    assert "run-in" not in result.message


def test_the_force_to_expect_of_a_periodic_motion_is_not_that_of_its_run_in(limit_cycle):
    result = run(RUN_IN, {"simulate.revolutions": 52, "simulate.discard": 2})
    peak = limit_cycle["rod_slider_force_peak"]
    assert result.summary["period"] == 1
    assert result.summary["rod_slider_force_peak"] > 1.2 * peak
    assert result.summary["rod_slider_force_peak_million"] == pytest.approx(peak, rel=1e-5)
    assert result.summary["rod_slider_force_peak_million_high"] == pytest.approx(peak, rel=1e-5)
    begin = result.summary["periodic_from"]
    assert 10 < begin < 40
    assert f"run-in: the motion is periodic from revolution {begin:g} on" in result.message
    later = run(RUN_IN, {"simulate.revolutions": begin + 10, "simulate.discard": begin})
    assert later.summary["rod_slider_force_peak"] == pytest.approx(peak, rel=0.02)
    assert "run-in" not in later.message


def test_a_count_of_what_was_not_observed_is_not_settled():
    """The motion is not periodic for long, and no revolution of it has an impact."""
    name = "rod_slider_impacts_per_rev"
    result = run(RUN_IN, until(name, relative=0.5, most=10), {"simulate.revolutions": 6, "simulate.discard": 2}).summary
    assert (result["settled"], result["period"], result["revolutions_run"]) == (0, None, 10.0)
    assert result[name] == 0.0
    assert result["figure_ci"] == pytest.approx(3.0 / 7.0)  # whole revolutions between the first pause and the last


@pytest.mark.parametrize(
    "figure",
    [
        "rod_slider_force_rms",
        "rod_slider_force_p99",
        "rod_slider_impacts_per_rev",
        "rod_slider_wear_rate_max",
        "slider_acceleration_rms",
    ],
)
def test_an_irregular_motion_runs_until_its_figure_is_known(figure):
    result = run(ROUGH, until(figure, relative=0.15, most=300)).summary
    assert result["settled"] == 1
    assert result["period"] is None
    assert 31 <= result["revolutions_run"] < 300
    assert (
        0.0 < result["figure_ci"] <= 0.16 * result[figure]
    )  # the last bit of the last revolution is in the figure only
    assert math.isclose(result["revolutions_run"] % 1.0, 0.0)


def test_a_run_that_does_not_settle_ends_at_its_longest_and_says_so():
    result = run(until(relative=1e-6, most=12.5), {"simulate.discard": 1})
    assert result.status == "ok"
    assert result.summary["settled"] == 0
    assert result.summary["period"] is None
    assert result.summary["revolutions_run"] == 12.0  # whole revolutions after `discard`
    assert result.summary["figure_ci"] > 0.0


def test_a_run_that_fails_on_its_way_is_a_failure():
    result = run(until(), {"simulate.event_budget": 1})
    assert result.status == "event-budget"
    assert result.summary["rod_slider_force_rms"] is None
    assert result.summary["settled"] is None


def test_periods_are_found_and_nothing_else_is():
    turns = np.arange(60.0)
    three = np.column_stack([np.sin(2.0 * math.pi / 3.0 * turns), turns % 3])
    assert period_of(three) == 3
    assert period_of(three[:11]) is None  # three repeats need twelve
    assert period_of(np.ones((4, 2))) == 1
    assert period_of(three + 0.01 * np.random.default_rng(1).normal(size=three.shape)) is None
    assert period_of(np.column_stack([0.1 * turns])) is None
    assert period_of(np.empty((0, 4))) is None


# ---------------------------------------------------------------------------------------------- intervals


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_an_interval_of_blocks_covers_the_mean_as_often_as_stated(memory):
    random, hits = np.random.default_rng(5), 0
    for _ in range(1000):
        noise = random.normal(size=24 * 4 + 50)
        for i in range(1, noise.size):
            noise[i] += memory * noise[i - 1]
        values = noise[50:].reshape(24, 4).mean(axis=1)
        hits += abs(values.mean()) <= half_width(values)
    assert 0.92 < hits / 1000 <= 0.99


@pytest.mark.slow
def test_intervals_at_which_chaotic_runs_ended_hold_the_value_of_a_long_run():
    """Runs that stop when their interval is narrow could stop when it is so at random: they must hold all the same."""
    figure, hits = "rod_slider_force_rms", 0
    truth = run(ROUGH, {"simulate.revolutions": 1500}).summary[figure]
    for place in range(40):
        tolerance = {"simulate.tolerance": 1e-7 * (1 + 0.01 * place)}  # another sample of the same motion
        result = run(ROUGH, until(figure, relative=0.1, most=200), tolerance).summary
        assert result["settled"] == 1
        hits += abs(result[figure] - truth) <= result["figure_ci"]
    assert hits >= 34  # 38 expected


def test_blocks_that_are_all_alike_leave_no_doubt_and_a_single_one_leaves_all():
    assert half_width(np.full(9, 3.0)) == 0.0  # whether they could differ is for `Blocks.interval` to say
    assert half_width(np.ones(1)) == math.inf


class Watch:
    """Records every figure that converges, until the run ends."""

    per_revolution = 1

    def __init__(self, layout):
        known = simulation.catalogue()
        self.names = [
            column.name for column in layout.columns if column.name in converging_columns(known, known.mechanisms[0])
        ]
        self.blocks = catalogue.Blocks(layout, self.names)

    def observe(self, work):
        self.blocks.record(work)
        return False


def test_figures_over_growing_blocks_are_those_of_the_summary():
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=LONG | WORN | {"simulate.revolutions": 71}))
    watch = Watch(scene.layout)
    summary = clearsweep.simulate(scene, observers=(watch,)).summary
    assert len(watch.names) == 8
    for name in watch.names:
        result = watch.blocks.interval(name)
        assert result.value == pytest.approx(summary[name], rel=0.03, abs=1e-12), name
        assert result.blocks == 17  # of four revolutions; 32 would be of two
        assert result.half_width < 0.4 * result.value or summary[name] == 0.0


# ---------------------------------------------------------------------------------------------- horizon


def test_the_twin_grows_like_the_difference_of_two_runs_of_the_reference_problem(monkeypatch):
    twins = []

    class Seen(observed_run.Perturbed):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            twins.append(self)

    monkeypatch.setattr(running, "Perturbed", Seen)
    source = next(problem.grid for problem in all_problems() if problem.name == "b_base")
    scene = clearsweep.load_case(changed(source, {"simulate.tolerance": 1e-12, "simulate.horizon": True}))
    result = clearsweep.simulate(scene).summary
    rate, clearance = scene.value.reference_rate, scene.value.joints[0].clearance
    turn = 2.0 * math.pi / rate
    assert 4e3 < math.exp(result["lyapunov_exponent"] * turn) < 1e6
    expected = math.log(0.01 / 1e-12) / (result["lyapunov_exponent"] * turn)
    assert result["horizon_revolutions"] == pytest.approx(expected, rel=1e-12)

    unit = clearance * np.array([1.0 / 0.12, 1.0, rate / 0.12, rate])
    start = scene.start + 0.5e-9 * np.array([*unit, 0.0, 0.0])  # of the perturbation; halves: four of one length
    paths = [
        clearsweep.simulate(dataclasses.replace(scene, start=first), times=twins[0].times)
        for first in (scene.start, start)
    ]
    states = [
        np.column_stack([path[name] for name in ("rod/angle", "slider/x", "rod/rate", "slider/v")]) for path in paths
    ]
    grown = np.log(np.linalg.norm((states[1] - states[0]) / unit, axis=1) / 1e-9)
    assert len(grown) > 15
    assert max(grown) > 8.0
    off = np.abs(np.diff(twins[0].growths) - np.diff(grown))
    assert np.sum(off > 0.07) <= 3  # where contact grazes, the twin's disturbance is not small
    assert np.median(off) < 0.02


def test_the_exponent_is_reproducible_and_leaves_the_figures_alone():
    plain, first, second = run(), run({"simulate.horizon": True}), run({"simulate.horizon": True})
    assert figures(first) == figures(second)
    assert first.summary["lyapunov_exponent"] > 100.0
    assert figures(plain).items() <= figures(first).items()
    assert (
        1.5 * plain.summary["steps"] < first.summary["steps"] < 2.0 * plain.summary["steps"]
    )  # those of the perturbed one, too


def test_the_exponent_does_not_depend_on_the_size_of_the_disturbance(monkeypatch):
    result = []
    for size in (1e-7, 1e-6, 1e-5):
        monkeypatch.setattr(observed_run, "DISTURBANCE", size)
        asked = {"simulate.horizon": True, "simulate.revolutions": 30, "simulate.tolerance": 1e-11}
        result.append(run(asked).summary["lyapunov_exponent"])
    assert len(set(result)) == 3
    assert result == pytest.approx([result[1]] * 3, rel=0.01)


def test_a_regular_motion_forgets_a_disturbance_and_has_no_horizon():
    result = run(REGULAR, {"simulate.horizon": True, "simulate.revolutions": 8}).summary
    assert result["lyapunov_exponent"] < 0.0
    assert result["horizon_revolutions"] is None


SWINGING = {
    "drive.speed": "1500 rpm",
    "mechanism.gravity": 0.0,
    "joints.rod-slider.clearance": 2e-5,
    "joints.rod-slider.friction": {"law": "tanh", "coefficient": 0.02, "velocity_scale": 1e-3},
    "simulate.horizon": True,
    "simulate.revolutions": 30,
    "simulate.discard": 10,
}


@pytest.mark.parametrize(("restitution", "chaotic"), [(0.9, True), (0.5, False)])
def test_chaos_without_impacts_is_a_remark(restitution, chaotic):
    """Two nearby motions of a hinged rod by scipy, with the damping ratio of the restitution, part in the same case."""
    contact = {"law": "lankarani-nikravesh", "stiffness": 6.61e10, "restitution": restitution}
    result = run(SWINGING, {"joints.rod-slider.contact": contact})
    assert result.summary["rod_slider_impacts_per_rev"] == 0.0
    assert (result.summary["lyapunov_exponent"] > 0.0) == chaotic
    assert ("swing: the Lyapunov exponent is" in result.message) == chaotic


@pytest.mark.few("1e-07")
@pytest.mark.parametrize("tolerance", [1e-5, 1e-7])
def test_errors_of_steps_are_not_taken_for_a_disturbance_that_grows(tolerance):
    rolling = {"joints.rod-slider.clearance": 3e-4, "joints.rod-slider.contact.restitution": 0.1, **WORN}
    rolling["joints.rod-slider.contact.onset"] = "first"  # with it contact is never lost, and the motion periodic
    length = {"simulate.horizon": True, "simulate.tolerance": tolerance, "simulate.revolutions": 15}
    assert run(rolling, length).summary["lyapunov_exponent"] < 0.0


def test_a_run_that_is_too_short_has_no_exponent():
    result = run({"simulate.revolutions": 0.02, "simulate.discard": 0, "simulate.horizon": True}).summary
    assert result["lyapunov_exponent"] is None
    assert result["horizon_revolutions"] is None


@pytest.mark.few("joints0")
@pytest.mark.parametrize("joints", [("crank-rod", "rod-slider"), ("ground-crank", "crank-rod", "rod-slider")])
def test_several_joints_with_friction_have_an_exponent(joints):
    friction = {f"joints.{name}.friction": WORN["joints.rod-slider.friction"] for name in joints}
    asked = {"simulate.horizon": True, "drive.speed": "1500 rpm", "mechanism.gravity": 9.81}
    result = clearsweep.simulate(clearsweep.load_case(slider_crank(*joints, changes=friction | asked)))
    assert 100.0 < result.summary["lyapunov_exponent"] < 1500.0


# ---------------------------------------------------------------------------------------------- error check


def test_the_error_check_stores_the_difference_from_a_tenth_of_the_tolerance():
    plain, tighter = run(WORN).summary, run(WORN, {"simulate.tolerance": 1e-8}).summary
    result = run(WORN, {"simulate.error_check": True}).summary
    checked = [name for name in plain if f"{name}_difference" in result]
    assert {"rod_slider_force_peak", "rod_slider_wear_rate_max", "crank_torque_peak"} <= set(checked)
    for name in checked:
        assert result[name] == plain[name]
        values = plain[name], tighter[name]
        assert result[f"{name}_difference"] == (None if None in values else abs(values[0] - values[1]))
    assert result["rod_slider_force_peak_difference"] > 0.0
    assert not any(f"{name}_difference" in result for name in (*COSTS, "energy_residual"))
    assert result["rhs_evaluations"] == plain["rhs_evaluations"] + tighter["rhs_evaluations"]


def test_the_error_check_of_a_run_that_found_its_length_is_as_long():
    result = run(until(relative=0.9), {"simulate.error_check": True}).summary
    tighter = run({"simulate.tolerance": 1e-8, "simulate.revolutions": result["revolutions_run"]}).summary
    name = "rod_slider_force_p99"
    assert result[f"{name}_difference"] == abs(result[name] - tighter[name])


def test_an_impact_pair_can_be_checked():
    result = clearsweep.simulate(clearsweep.load_case(changed(PAIR, {"simulate.error_check": True}))).summary
    assert result["pair_restitution_difference"] < 1e-9


def test_an_error_check_that_fails_says_so():
    asked = {"simulate.tolerance": 1e-8}
    plain = clearsweep.simulate(clearsweep.load_case(changed(PAIR, asked))).summary
    budget = math.ceil(1.01 * (plain["steps"] + plain["steps_rejected"]) / PAIR["simulate"]["impacts"])
    asked |= {"simulate.error_check": True, "simulate.step_budget": budget}
    result = clearsweep.simulate(clearsweep.load_case(changed(PAIR, asked)))
    assert result.status == "ok"
    assert result.summary["pair_restitution_difference"] is None
    assert result.message.startswith("unchecked: the run at a tenth of the tolerance has the status step-budget: ")


def test_the_work_of_an_impact_pair_includes_the_run_that_finds_its_duration():
    plain, sampled = (
        clearsweep.simulate(clearsweep.load_case(changed(PAIR, {"save.orbits": orbits}))).summary["steps"]
        for orbits in ("none", "all")
    )
    assert sampled == 2 * plain


def test_the_window_of_an_impact_pair_ends_with_its_last_separation():
    scene = clearsweep.load_case(changed(PAIR, {"save.orbits": "all", "save.samples": 10}))
    run = running.integration_of(scene, np.empty(0), np.inf)
    assert window_of(scene, run, np.inf).duration == run.events[-1, 0]
    assert clearsweep.simulate(scene).t[-1] == run.events[-1, 0]


# ---------------------------------------------------------------------------------------------- grids and stores


def case_id(**changes):
    source = slider_crank("rod-slider", changes={k.replace("__", "."): v for k, v in changes.items()})
    return grid.load(source, simulation.catalogue()).case_id(0)


def test_unused_settings_are_not_in_the_identity():
    assert case_id(simulate__horizon=False, simulate__error_check=False) == case_id()
    assert len({case_id(), case_id(simulate__horizon=True), case_id(simulate__error_check=True)}) == 3


def test_columns_are_stored_with_their_units_and_can_be_limited(tmp_path):
    source = slider_crank(
        "rod-slider",
        changes=LONG
        | until(relative=0.9)
        | {"simulate.horizon": True, "simulate.error_check": True, "limits": {"lyapunov_exponent": 100.0}},
    )
    source |= {"sweep": {"joints.rod-slider.clearance": [1e-5, 5e-4]}}
    clearsweep.sweep(source, out=tmp_path / "run", executor="serial")
    result = clearsweep.open(tmp_path / "run")
    assert {
        "lyapunov_exponent": "1/s",
        "horizon_revolutions": "1",
        "figure_ci": "N",
        "period": "1",
        "rod_slider_force_rms_difference": "N",
    }.items() <= result.summary.attrs["units"].items()
    assert result.layout.until == "rod_slider_force_rms"
    regular, irregular = (row for _, row in result.summary.sort_values("joints.rod-slider.clearance").iterrows())
    assert irregular["lyapunov_exponent"] > 100.0
    assert regular["lyapunov_exponent"] < 0.0
    assert np.isnan(regular["horizon_revolutions"])  # null in the file
    files = {file.name: file for file in report.tables(result, tmp_path / "tables")}
    head = files["certainty.csv"].read_text(encoding="utf-8").splitlines()[0]
    assert "period,periodic from (rev.),settled,rod_slider_force_rms [N]," in head
    assert "error of force p99 [N]" in head
    assert "How certain the figures are" in report.write(result, tmp_path / "report.html").read_text(encoding="utf-8")
