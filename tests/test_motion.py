"""The slider-crank in all its openings: energy, the ideal limit, symmetries, figures against their own samples."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mechanism_cases import changed, check_that_no_contact_passes_unseen, slider_crank
from right_grids import grid_of
from slider_crank_oracle import reactions, slider

import clearsweep

pytestmark = pytest.mark.heavy

NAMES = ("ground-crank", "crank-rod", "rod-slider")
OPENINGS = [joints for count in (1, 2, 3) for joints in itertools.combinations(NAMES, count)]
FRICTION = {"law": "ambrosio", "coefficient": 0.1, "v0": 1e-3, "v1": 1e-2}


def run(*joints, times=None, **changes):
    scene = clearsweep.load_case(slider_crank(*joints, changes={k.replace("__", "."): v for k, v in changes.items()}))
    trajectory = clearsweep.simulate(scene, times=times)
    assert trajectory.status == "ok", trajectory.message
    return trajectory


def with_friction(joints):
    return {f"joints.{name}.friction": FRICTION for name in joints}


@pytest.mark.few("rod-slider", "ground-crank+crank-rod+rod-slider")  # each is a compiled form of its own
@pytest.mark.parametrize("joints", OPENINGS, ids="+".join)
def test_energy_balances_with_gravity_friction_and_impacts_in_any_opening(joints):
    case = slider_crank(
        *joints, changes={"mechanism.gravity": 9.81, "drive.speed": "1500 rpm", **with_friction(joints)}
    )
    trajectory = clearsweep.simulate(clearsweep.load_case(case))
    assert trajectory.status == "ok"
    assert sum(trajectory.summary[f"{name.replace('-', '_')}_impacts_per_rev"] for name in joints) >= 5
    assert trajectory.summary["energy_residual"] < 1000 * 1e-9


def test_a_force_that_is_wrong_by_a_thousandth_upsets_the_energy_balance(monkeypatch):
    from clearsweep.mechanics.joints import dry

    case = slider_crank("rod-slider", changes={"simulate.tolerance": 1e-6, "simulate.revolutions": 0.05})
    scene = clearsweep.load_case(case)
    good = plain(scene)
    true = dry.joint_load

    def wrong(*arguments):  # the bodies feel a normal force that the joint does not account for
        load = true(*arguments)
        return load._replace(fx=1.001 * load.fx)

    monkeypatch.setattr(dry, "joint_load", wrong)
    bad = plain(scene)
    assert good < 1e-7
    assert bad > 100 * good


def plain(scene):
    """Return the energy residual of a scene run as plain Python, where forces can be spoiled."""
    from clearsweep.simulation.running import run
    from clearsweep.tracing.compiled import family

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(family, "_IS_PLAIN", [True])
        patch.setattr(run, "released_runs", [])
        return clearsweep.simulate(scene).summary["energy_residual"]


@pytest.mark.few("rod-slider")
@pytest.mark.parametrize("name", NAMES)
def test_a_vanishing_clearance_gives_the_ideal_mechanism(name):
    trajectory = run(
        name,
        **{
            f"joints__{name}__clearance": 1e-7,
            "mechanism__gravity": 9.81,
            "simulate__start": "seated",
            "simulate__revolutions": 0.25,
            f"joints__{name}__contact__stiffness": 1e13,
            "drive__speed": "300 rpm",
        },
    )
    joint = name.replace("-", "_")
    assert trajectory.summary["slider_error_max"] < 1e-6
    bodies = clearsweep.load_case(slider_crank(name, changes={"mechanism.gravity": 9.81})).case.mechanism.values
    top = np.hypot(*reactions(bodies, 10 * math.pi, np.linspace(0, math.pi / 2, 1001))[name].T).max()
    assert trajectory.summary[f"{joint}_force_rms"] < top
    assert trajectory.summary[f"{joint}_force_peak"] == pytest.approx(top, rel=0.3)


def test_ideal_mechanism_has_its_closed_form_values():
    speed = 5000 * 2 * math.pi / 60
    assert slider(0.05, 0.12, 0.0, speed)[2] == pytest.approx(-19419.3605, rel=1e-8)
    assert slider(0.05, 0.12, math.pi, speed)[2] == pytest.approx(7996.2073, rel=1e-7)
    angles = np.linspace(0, 2 * np.pi, 100001)
    x, v, a = slider(0.05, 0.12, angles, speed)
    assert np.abs(v).max() == pytest.approx(28.4113304, rel=1e-8)
    assert a.max() == pytest.approx(9695.856, rel=1e-6)
    assert np.gradient(x, angles)[1:-1] * speed == pytest.approx(v[1:-1], abs=1e-3)
    assert np.gradient(v, angles)[1:-1] * speed == pytest.approx(a[1:-1], abs=1)
    mechanism = clearsweep.load_case(slider_crank("rod-slider")).case.mechanism.values
    assert reactions(mechanism, speed, 0.0)["rod-slider"][0] == pytest.approx(-2718.71, rel=1e-6)


@settings(max_examples=12)
@given(
    scale=st.sampled_from([0.01, 0.1, 10.0]),
    slow=st.sampled_from([0.1, 3.0]),
    heavy=st.sampled_from([0.01, 5.0]),
)
def test_other_units_of_length_time_and_mass_give_the_same_motion(scale, slow, heavy):
    """Lengths times `scale`, times times `slow`, masses times `heavy`: a contact stiffness scales as its dimension."""
    inertia = heavy * scale**2
    force = heavy * scale / slow**2
    changes = {
        "mechanism.crank.length": 0.05 * scale,
        "mechanism.crank.mass": 0.3 * heavy,
        "mechanism.crank.inertia": 1e-4 * inertia,
        "mechanism.rod.length": 0.12 * scale,
        "mechanism.rod.center": 0.06 * scale,
        "mechanism.rod.mass": 0.21 * heavy,
        "mechanism.rod.inertia": 2.5e-4 * inertia,
        "mechanism.slider.mass": 0.14 * heavy,
        "drive.speed": 500.0 / slow,
        "joints.rod-slider.clearance": 0.5e-3 * scale,
        "joints.rod-slider.bearing_radius": 0.01 * scale,
        "joints.rod-slider.length": 0.02 * scale,
        "joints.rod-slider.contact.stiffness": 6.61e10 * force / scale**1.5,
        "simulate.revolutions": 0.25,
    }
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    same = clearsweep.load_case(
        slider_crank("rod-slider", changes={"drive.speed": 500.0, "simulate.revolutions": 0.25})
    )
    scaled, plainly = clearsweep.simulate(case).summary, clearsweep.simulate(same).summary
    assert scaled["rod_slider_force_peak"] == pytest.approx(plainly["rod_slider_force_peak"] * force, rel=1e-6)
    assert scaled["rod_slider_onset_rate_max"] == pytest.approx(
        plainly["rod_slider_onset_rate_max"] * scale / slow, rel=1e-6
    )
    assert scaled["rod_slider_impacts_per_rev"] == plainly["rod_slider_impacts_per_rev"]


RUBBING = {"law": "coulomb", "coefficient": 0.1, "velocity_scale": 1e-3}


@pytest.mark.few("impacts-1e-09", "friction-0.0001", "both seated-1e-06", "implicit-1e-06")
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize(
    ("joints", "changes"),
    [
        (["rod-slider"], {}),
        (["rod-slider"], {"joints.rod-slider.contact.restitution": 0.3, "drive.speed": "1000 rpm"}),
        (["rod-slider"], {"joints.rod-slider.friction": RUBBING, "drive.speed": "2000 rpm"}),
        (["crank-rod", "rod-slider"], {"drive.speed": "3000 rpm"}),
        (["crank-rod"], {"simulate.start": "seated", "joints.crank-rod.contact.law": "flores"}),
        (["crank-rod", "rod-slider"], {"simulate.start": "seated", "drive.speed": "3000 rpm"}),
        (["crank-rod", "rod-slider"], {"simulate.method": "implicit", "drive.speed": "3000 rpm"}),
    ],
    ids=["impacts", "lasting contact", "friction", "two joints", "seated", "both seated", "implicit"],
)
def test_the_p99_of_a_force_is_that_of_dense_samples(joints, changes, tolerance):
    """To 0.5 %, from whatever steps: three hundred thousand moments, of which one percent have more force."""
    changes = {**changes, "simulate.tolerance": tolerance, "simulate.revolutions": 2}
    scene = clearsweep.load_case(slider_crank(*joints, changes=changes))
    times = np.linspace(0.0, 2 * 2 * math.pi / scene.value.reference_rate, 300001)
    trajectory = clearsweep.simulate(scene, times=times)
    assert trajectory.status == "ok", trajectory.message
    for joint in (name.replace("-", "_") for name in joints):
        exceeded = np.quantile(trajectory[f"joints/{joint}/force_normal"], 0.99)
        assert exceeded > 0.0
        assert trajectory.summary[f"{joint}_force_p99"] == pytest.approx(exceeded, rel=0.005)


def test_figures_are_those_of_the_window_alone():
    """Against dense samples of a window much shorter than what is discarded before it, where most else happens."""
    changes = {"simulate.discard": 3.0, "simulate.revolutions": 3.75, "save.orbits": "last"}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    turn = 60.0 / 5000
    times = np.linspace(3.0 * turn, 3.75 * turn, 300001)
    duration = times[-1] - times[0]
    trajectory = clearsweep.simulate(scene, times=times)
    summary = {name.removeprefix("rod_slider_"): value for name, value in trajectory.summary.items()}
    force = trajectory["joints/rod_slider/force_normal"]
    eccentricity = np.hypot(trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"])
    acceleration = np.abs(trajectory["slider/a"])
    events = trajectory.events
    onsets = events[(events["kind"] == "on") & (events["t"] >= times[0])]
    assert 3 < len(onsets) < 0.3 * np.count_nonzero(events["kind"] == "on")
    mean = {name: np.trapezoid(values, times) / duration for name, values in (("f", force**2), ("a", acceleration**2))}
    assert summary["force_rms"] == pytest.approx(math.sqrt(mean["f"]), rel=1e-4)
    assert summary["force_p99"] == pytest.approx(np.quantile(force, 0.99), rel=0.005)
    assert summary["force_peak"] == pytest.approx(force.max(), rel=1e-4)
    assert summary["contact_fraction"] == pytest.approx(np.mean(eccentricity > 0.5e-3), abs=1e-3)
    assert summary["impacts_per_rev"] == pytest.approx(len(onsets) / 0.75)
    assert summary["onset_rate_max"] == onsets["rate"].max()
    assert force.max() <= summary["force_peak"] * (1 + 1e-12)
    assert acceleration.max() <= summary["slider_acceleration_peak"] * (1 + 1e-12)
    assert summary["penetration_max"] == pytest.approx(eccentricity.max() - 0.5e-3, rel=1e-4)
    x, _, _ = slider(0.05, 0.12, trajectory["crank_angle"], 5000 * 2 * math.pi / 60)
    assert summary["slider_error_max"] == pytest.approx(np.abs(trajectory["slider/x"] - x).max(), rel=1e-4)
    assert summary["eccentricity_max"] == pytest.approx(eccentricity.max(), rel=1e-6)
    assert summary["slider_acceleration_rms"] == pytest.approx(math.sqrt(mean["a"]), rel=1e-4)
    assert summary["slider_acceleration_peak"] == pytest.approx(acceleration.max(), rel=1e-4)
    assert summary["crank_torque_peak"] == pytest.approx(np.abs(trajectory["crank/torque"]).max(), rel=1e-4)


RUNS = {
    "tolerance": st.sampled_from([1e-4, 1e-6, 1e-9]),
    "speed": st.floats(200, 8000),
    "clearance": st.floats(1e-5, 2e-3),
    "restitution": st.floats(0.05, 1.0),
    "gravity": st.sampled_from([0.0, 9.81]),
}


@example(1e-9, 4074.0, 3.8e-5, 0.99, 9.81)  # as soon as speeds between the stages are not bounded
@example(1e-9, 4676.0, 6e-5, 0.99, 9.81)  # these: as soon as steps are not followed in parts
@example(1e-6, 2926.0, 7.9e-5, 0.98, 0.0)
@example(1e-6, 7000.0, 1.1e-4, 0.99, 0.0)
@example(1e-4, 1526.0, 3.5e-5, 1.0, 9.81)
@settings(max_examples=25, derandomize=True)
@given(**RUNS)
def test_no_contact_passes_unseen(tolerance, speed, clearance, restitution, gravity):
    check_that_no_contact_passes_unseen(("rod-slider",), tolerance, speed, clearance, restitution, gravity)


@pytest.mark.slow
@settings(max_examples=25, derandomize=True)
@given(joints=st.sampled_from(OPENINGS), **RUNS)
def test_no_contact_passes_unseen_in_any_opening(joints, tolerance, speed, clearance, restitution, gravity):
    check_that_no_contact_passes_unseen(joints, tolerance, speed, clearance, restitution, gravity)


def test_eccentricity_is_reported_of_a_window_without_contact_too():
    summary = run("rod-slider", simulate__revolutions=0.01, save__revolutions=0.01).summary
    assert summary["rod_slider_penetration_max"] == summary["rod_slider_contact_fraction"] == 0.0
    assert 0.0 < summary["rod_slider_eccentricity_max"] < 0.5e-3


def test_a_run_is_the_same_to_the_bit_every_time_and_whatever_is_reported():
    first = run("crank-rod", "rod-slider")
    again = run("crank-rod", "rod-slider", times=np.linspace(0, 0.012, 7))
    skip = ("run_time", "setup_time", "rhs_evaluations")
    assert {k: v for k, v in first.summary.items() if k not in skip} == {
        k: v for k, v in again.summary.items() if k not in skip
    }


def test_samples_lie_at_exact_crank_angles_with_both_ends():
    trajectory = run("rod-slider", save__orbits="last", save__revolutions=1, save__samples=90, simulate__revolutions=2)
    assert trajectory["crank_angle"] == pytest.approx(2 * np.pi * np.arange(90, 181) / 90, rel=1e-15, abs=0.0)
    assert len(trajectory.t) == 91


def test_the_window_leaves_out_what_is_discarded():
    whole = run("rod-slider", simulate__revolutions=2)
    later = run("rod-slider", simulate__revolutions=2, simulate__discard=1)
    assert later.summary["rod_slider_force_peak"] < whole.summary["rod_slider_force_peak"]
    assert later.summary["rod_slider_impacts_per_rev"] != whole.summary["rod_slider_impacts_per_rev"]


def test_a_seated_start_is_in_contact_and_quiet():
    trajectory = run(
        "rod-slider", simulate__start="seated", simulate__revolutions=0.05, drive__speed="1500 rpm", save__orbits="all"
    )
    assert len(trajectory.events) == 0 or trajectory.events[0]["kind"] == "off"
    bodies = {
        "crank.length": 0.05,
        "crank.mass": 0.3,
        "crank.center": 0.025,
        "rod.length": 0.12,
        "rod.mass": 0.21,
        "rod.inertia": 2.5e-4,
        "rod.center": 0.06,
        "slider.mass": 0.14,
        "gravity": 0.0,
    }
    static = reactions(bodies, 50 * math.pi, 0.0)["rod-slider"]
    assert trajectory["joints/rod_slider/force_normal"][0] == pytest.approx(np.hypot(*static), rel=1e-9)


def test_budgets_end_a_run_with_a_status_and_a_sentence():
    for key, status in (("step_budget", "step-budget"), ("event_budget", "event-budget")):
        scene = clearsweep.load_case(slider_crank("rod-slider", changes={f"simulate.{key}": 10}))
        trajectory = clearsweep.simulate(scene)
        assert trajectory.status == status
        assert f"simulate.{key}" in trajectory.message
        assert trajectory.summary["rod_slider_force_peak"] is None
        assert trajectory.summary["steps"] > 0


def test_events_of_the_whole_run_are_returned_without_histories():
    def events(**changes):
        changes |= {"simulate.revolutions": 2, "simulate.discard": 1}
        return clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes))).events

    without, stored = events(), events(**{"save.orbits": "all"})
    assert len(without) > 10
    assert without["t"][0] < 0.012 < without["t"][-1]  # s, also before the window
    assert without.tobytes() == stored.tobytes()


def long_pendulum(**simulate):
    """Return the grid of a heavy rod that swings on a pin with a clearance of 1 um, 2 m from its centre of mass."""
    made = changed(grid_of("a long pendulum"), {"drive.speed": 0.4 * math.pi})
    return made | {"simulate": {"revolutions": 1, "discard": 0} | simulate}


@pytest.mark.compiled
def test_a_tolerance_below_the_rounding_of_positions_is_the_cause_that_is_said():
    """A rounding of 2e-16 m turns a contact of 1 um by 2e-10 rad, which a tolerance of 1e-9 takes for motion."""
    path = clearsweep.simulate(clearsweep.load_case(long_pendulum(tolerance=1e-9)))
    assert path.status == "rounding"
    assert path.message.startswith("simulate.tolerance is below what positions of this size resolve: ")
    assert "step_budget" not in path.message
    assert path.summary["steps"] < 100_000
    enough = float(path.message.partition("a tolerance of ")[2].partition(",")[0])
    assert clearsweep.simulate(clearsweep.load_case(long_pendulum(tolerance=enough))).status == "ok"


@pytest.mark.compiled
def test_a_small_budget_is_not_taken_for_rounding():
    path = clearsweep.simulate(clearsweep.load_case(long_pendulum(tolerance=1e-5, step_budget=1000)))
    assert path.status == "step-budget"


def test_times_outside_the_run_are_refused():
    scene = clearsweep.load_case(slider_crank("rod-slider"))
    for times in ([-1e-3], [0.02], [2e-3, 1e-3], [[0.0]], [math.nan]):
        with pytest.raises(clearsweep.InputError, match="times"):
            clearsweep.simulate(scene, times=times)
