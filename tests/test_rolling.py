"""Rolling bearings: elastic constants, statics, motion against a second program, figures and refusals."""

import copy
import math

import numpy as np
import pytest
from click.testing import CliRunner
from mechanism_cases import changed
from right_grids import grid_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import clearsweep
from clearsweep.cli import verbs
from clearsweep.mechanics.joints.rolling import (
    Rolling,
    element_approaches,
    element_directions,
    element_loads,
    static_position,
)
from clearsweep.mechanics.laws.bearings import ball_stiffness, complete_elliptic, point_stiffness, roller_stiffness
from clearsweep.mechanics.laws.elastic import Power, PowerThreeHalves
from clearsweep.simulation.figures.window import by_joint
from clearsweep.simulation.running.run import integration_of
from clearsweep.simulation.setup.scene import load_case
from clearsweep.simulation.setup.start import arrays_of

STEEL = 210e9 / (2.0 * (1.0 - 0.3**2))  # Pa, E* of two bodies of steel
SHARES = 0.5 * (1.0 - 11.5 / 43.5), 0.5 * (1.0 + 11.5 / 43.5)
BALL = grid_of("a hub in a bearing")["joints"]["bearing"]
UNDAMPED = {"law": "hunt-crossley", "damping_factor": "1e-9 s/m"}
ROLLER = {key: value for key, value in BALL.items() if key != "groove"} | {
    "kind": "roller",
    "elements": 6,
    "element_diameter": "9 mm",
    "length": "13.6 mm",
}
ROD = {"length": "120 mm", "mass": "0.21 kg", "inertia": "2.5e-4 kg*m^2", "center": "60 mm"}
MACHINE = {
    "type": "slider-crank",
    "crank": {"length": "50 mm", "mass": "0.3 kg", "inertia": "1e-4 kg*m^2"},
    "rod": ROD,
    "slider": {"mass": "0.14 kg"},
}


def slider_crank(joints, **simulate):
    """Return the grid of a slider-crank at 1500 rpm with these joints."""
    return {
        "name": "rolling",
        "mechanism": MACHINE,
        "drive": {"speed": "1500 rpm"},
        "joints": copy.deepcopy(joints),
        "simulate": {"revolutions": 0.5, "discard": 0, "tolerance": 1e-10} | simulate,
        "save": {"orbits": "all", "samples": 2000},
    }


def loaded_hub(joint, load, **simulate):
    """Return the grid of a body of 1 kg that a load (x, y) N presses into a bearing of the ground."""
    given = {"loads.pull.force": [f"{component} N" for component in load], "joints.bearing": joint}
    given |= {f"simulate.{key}": value for key, value in simulate.items()}
    return changed(grid_of("a hub in a bearing"), given)


def bearing(elastic, count, clearance):
    """Return the compiled form of a bearing with this diametral clearance (m), for statics."""
    scale = max(0.5 * abs(clearance), 1e-6)
    return Rolling(scale, 1.0, 0.5 * clearance, *SHARES, 0.0, 0.0, (), elastic, (), element_directions(count))


def integrated(grid):
    """Return the Run of a grid of one case to its end, and its sums by joint."""
    scene = load_case(grid)
    run = integration_of(scene, np.empty(0), scene.crank_clock.value_after(scene.case.simulate.revolutions))
    return run, by_joint(run.totals, scene.layout).joint


# ---------------------------------------------------------------------------------------------- elastic constants


@pytest.mark.parametrize("parameter", [0.0, 1e-9, 0.3, 0.99, 1.0 - 1e-9])
def test_elliptic_integrals_are_those_of_scipy(parameter):
    assert complete_elliptic(parameter) == pytest.approx((ellipk(parameter), ellipe(parameter)), rel=1e-14)


def test_stiffness_of_a_ball_is_the_published_one():
    """Of mpmath and of the potential of the pressure without elliptic functions, which agree to 7e-16."""
    stiffness = ball_stiffness(11.5e-3, 43.5e-3, (0.52, 0.53), STEEL)
    assert 1e-3**1.5 * stiffness == pytest.approx(333592.05261, rel=3e-11)


def test_stiffness_of_each_ring_and_its_ellipse_are_the_published_ones():
    of_ball, pitch, diameter = 2.0 / 11.5e-3, 43.5e-3, 11.5e-3
    for ring, radius, published in (
        (2.0 / (pitch - diameter), 0.52, 971990.01531),
        (-2.0 / (pitch + diameter), 0.53, 916452.82397),
    ):
        curvatures = of_ball + ring, of_ball - 1.0 / (radius * diameter)
        assert 1e-3**1.5 * point_stiffness(curvatures, STEEL) == pytest.approx(published, rel=3e-11)


def test_contact_of_equal_curvatures_is_a_sphere_on_a_plane():
    radius = 5e-3
    sphere = 4.0 / 3.0 * STEEL * math.sqrt(radius)
    assert point_stiffness((1.0 / radius, 1.0 / radius), STEEL) == pytest.approx(sphere, rel=1e-14)
    assert point_stiffness((1.0 / radius, 0.9999 / radius), STEEL) == pytest.approx(sphere, rel=1e-4)


def test_stiffness_of_a_roller_is_that_of_the_standard():
    assert 1e-3 ** (10.0 / 9.0) * roller_stiffness(13.6e-3) == pytest.approx(365817.83385, rel=1e-10)


# ---------------------------------------------------------------------------------------------- statics

KIND = {
    "ball": (BALL, (619.61395716, 305.04592192, 0.0, 0.0, 0.0, 0.0, 305.04592192), 1.5110204111e-05),
    "roller": (ROLLER, (683.55626835, 316.44373165, 0.0, 0.0, 0.0, 316.44373165), 3.5023412305e-06),
}


@pytest.mark.few("roller")
@pytest.mark.parametrize("kind", KIND)
def test_a_settled_bearing_has_the_published_loads(kind):
    joint, loads, displacement = KIND[kind]
    damped = {"law": "hunt-crossley", "damping_factor": "20 s/m"}
    trajectory = clearsweep.simulate(
        load_case(loaded_hub(joint | {"clearance": "0 um", "contact": damped}, (1000.0, 0.0)))
    )
    assert trajectory["joints/bearing/x"][-1] == pytest.approx(displacement, rel=1e-9)
    assert trajectory["joints/bearing/y"][-1] == pytest.approx(0.0, abs=1e-15)
    forces = [trajectory[f"joints/bearing/element_{k + 1}_force"][-1] for k in range(len(loads))]
    assert forces == pytest.approx(loads, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("clearance", [0.0, 10e-6, 30e-6, -10e-6])
@pytest.mark.parametrize("count", [3, 7, 9])
@pytest.mark.parametrize("toward", [0.0, 0.2, math.pi / 7.0, math.pi / 9.0, -2.0])
def test_static_position_balances_the_load(clearance, count, toward):
    load = 1000.0 * np.array([math.cos(toward), math.sin(toward)])
    for elastic in (PowerThreeHalves(1.0549e10), Power(7.9e8, 10.0 / 9.0)):
        joint = bearing(elastic, count, clearance)
        position = static_position(joint, tuple(load), 0.1)
        angles = 0.1 + 2.0 * math.pi * np.arange(count) / count
        approaches = np.maximum(position[0] * np.cos(angles) + position[1] * np.sin(angles) - 0.5 * clearance, 0.0)
        balance = elastic.stiffness * approaches ** getattr(elastic, "exponent", 1.5)
        assert balance @ np.cos(angles) == pytest.approx(load[0], abs=1e-8)
        assert balance @ np.sin(angles) == pytest.approx(load[1], abs=1e-8)


def test_load_over_an_element_with_clearance_is_carried_by_it_alone():
    joint = bearing(PowerThreeHalves(1.0549e10), 7, 200e-6)
    distance = brentq(lambda x: 1.0549e10 * (x - 100e-6) ** 1.5 - 1000.0, 100e-6, 200e-6, xtol=1e-18)
    assert static_position(joint, (1000.0, 0.0), 0.0) == pytest.approx((distance, 0.0), rel=1e-10, abs=1e-15)
    assert np.count_nonzero(element_loads(joint, distance, 0.0, 0.0)) == 1


@pytest.mark.few("10 um")
@pytest.mark.parametrize("clearance", ["10 um", "0 um", "-10 um"])
def test_a_seated_start_carries_the_load_of_the_ideal_machine(clearance):
    pin = {"clearance": "5 um", "bearing_radius": "10 mm", "contact": {"law": "hertz", "stiffness": "1e10 N/m^1.5"}}
    short = {"start": "seated", "revolutions": 0.01, "tolerance": 1e-8}
    load = clearsweep.simulate(load_case(slider_crank({"crank-rod": pin}, **short)))["joints/crank_rod/force_normal"][0]
    changes = {"clearance": clearance, "phase": "0.3 rad", "contact": UNDAMPED}
    seated = slider_crank({"crank-rod": BALL | changes}, **short)
    trajectory = clearsweep.simulate(load_case(seated))
    assert trajectory["joints/crank_rod/cage_angle"][0] == pytest.approx(0.3, abs=1e-14)
    assert trajectory["joints/crank_rod/force_normal"][0] == pytest.approx(load, rel=1e-7)


# ---------------------------------------------------------------------------------------------- motion


RADIUS, LENGTH, SPEED = 0.05, 0.12, 50.0 * math.pi  # m, m, rad/s
ROD_MASS, ROD_INERTIA, SLIDER_MASS = 0.21, 2.5e-4, 0.14


def force_of_bearing(stiffness, motion, count=7, damping=0.3, radial=5e-6):
    """Return force (N) on the inner ring, its moments (N m) on inner and outer ring, and approaches (m).

    motion : displacement x, y (m), their rates, and angle and spin of the inner and of the outer ring.
    """
    x, y, vx, vy, inner, inner_spin, outer, outer_spin = motion
    angles = 2.0 * math.pi * np.arange(count) / count + SHARES[0] * inner + SHARES[1] * outer
    c, s = np.cos(angles), np.sin(angles)
    across = y * c - x * s
    approaches = x * c + y * s - radial
    rates = vx * c + vy * s + across * (SHARES[0] * inner_spin + SHARES[1] * outer_spin)
    forces = np.maximum(stiffness * np.maximum(approaches, 0.0) ** 1.5 * (1.0 + damping * rates), 0.0)
    moment = -forces @ across
    return (-forces @ c, -forces @ s), SHARES[0] * moment, SHARES[1] * moment, approaches


def motions_of_bearings(time, state):
    """Return the motions of both bearings of the slider-crank, each with its inner ring on the rod."""
    x, y, angle, slider, vx, vy, spin, slider_speed = state
    c, s, crank = math.cos(angle), math.sin(angle), SPEED * time
    arm_x, arm_y = 0.5 * LENGTH * c, 0.5 * LENGTH * s
    pin_x, pin_y = RADIUS * math.cos(crank), RADIUS * math.sin(crank)
    near = (
        x - arm_x - pin_x,
        y - arm_y - pin_y,
        vx + spin * arm_y + SPEED * pin_y,
        vy - spin * arm_x - SPEED * pin_x,
    )
    far = x + arm_x - slider, y + arm_y, vx - spin * arm_y - slider_speed, vy + spin * arm_x
    return (*near, angle, spin, crank, SPEED), (*far, angle, spin, 0.0, 0.0)


def second_program(stiffness):
    """Return the right-hand side of the slider-crank with a bearing at both ends of its rod."""

    def rates(time, state):
        _, _, angle, _, vx, vy, spin, slider_speed = state
        near, far = (force_of_bearing(stiffness, motion)[:2] for motion in motions_of_bearings(time, state))
        (near_x, near_y), (far_x, far_y) = near[0], far[0]
        arm_x, arm_y = 0.5 * LENGTH * math.cos(angle), 0.5 * LENGTH * math.sin(angle)
        moment = near[1] + far[1] - arm_x * near_y + arm_y * near_x + arm_x * far_y - arm_y * far_x
        accelerations = (near_x + far_x) / ROD_MASS, (near_y + far_y) / ROD_MASS, moment / ROD_INERTIA
        return vx, vy, spin, slider_speed, *accelerations, -far_x / SLIDER_MASS

    return rates


def signed_approaches(time, state):
    """Return the approaches (14,) of the elements of both bearings."""
    pair = motions_of_bearings(time, state)
    return np.concatenate([force_of_bearing(1.0, motion)[3] for motion in pair])


def solved_between_events(rates, span, start, times):
    """Return states at `times` and the list of (time, element, whether it closes), restarted at each of them."""
    time, state, states, events = span[0], np.array(start), [], []
    crossings = [lambda t, y, k=k: signed_approaches(t, y)[k] for k in range(14)]
    for crossing in crossings:
        crossing.terminal = True
    while time < span[1]:
        part = solve_ivp(
            rates,
            (time, span[1]),
            state,
            "DOP853",
            rtol=1e-12,
            atol=1e-16,
            first_step=1e-8,
            max_step=1e-5,
            events=crossings,
            dense_output=True,
        )
        wanted = times[(times >= time) & (times < part.t[-1])]
        states += [part.sol(t) for t in wanted]
        passed = [k for k in range(14) if len(part.t_events[k]) and part.t_events[k][-1] == part.t[-1]]
        time, state = part.t[-1], part.y[:, -1]
        if not passed:
            break
        before = signed_approaches(part.t[-2], part.y[:, -2])
        events += [(time, k, before[k] < 0.0) for k in passed]
        later = time + 1e-12  # off the event, where the force is still 0 but for rounding
        state = state + (later - time) * np.array(rates(time, state))
        time = later
    return np.array(states), events


@pytest.mark.slow
def test_both_pins_rolling_follow_a_second_program():
    """Half a turn: displacements, forces, and all onsets and separations of the elements."""
    scene = load_case(slider_crank({"crank-rod": BALL, "rod-slider": BALL}))
    trajectory = clearsweep.simulate(scene)
    stiffness, spin = scene.value.joints[0].elastic.stiffness, -RADIUS * SPEED / LENGTH
    start = [RADIUS + 0.06, 0.0, 0.0, RADIUS + LENGTH, 0.0, RADIUS * SPEED + 0.06 * spin, spin, 0.0]
    times = np.asarray(trajectory.t)[:-1]
    states, events = solved_between_events(second_program(stiffness), (0.0, math.pi / SPEED), start, times)
    pairs = [motions_of_bearings(t, state) for t, state in zip(times, states, strict=True)]
    for k, name in enumerate(("crank_rod", "rod_slider")):
        displacements = np.array([pair[k][:2] for pair in pairs])
        shown = np.stack([trajectory[f"joints/{name}/{axis}"][:-1] for axis in "xy"], axis=-1)
        assert np.abs(shown - displacements).max() < 1e-6 * np.abs(shown).max()
        forces = np.array([np.hypot(*force_of_bearing(stiffness, pair[k])[0]) for pair in pairs])
        assert np.abs(trajectory[f"joints/{name}/force_normal"][:-1] - forces).max() < 1e-6 * forces.max()
    names = [f"{name}_{k + 1}" for name in ("crank_rod", "rod_slider") for k in range(7)]
    expected = [(names[element], "on" if closes else "off") for _, element, closes in events]
    assert len(expected) > 50
    assert list(zip(trajectory.events["joint"], trajectory.events["kind"], strict=True)) == expected
    assert trajectory.events["t"] == pytest.approx([time for time, _, _ in events], abs=2e-9)


def test_lossless_elements_conserve_energy():
    """The forces turn the rings as the cage carries the elements round, or the energy would drift."""
    run, _ = integrated(slider_crank({"crank-rod": BALL | {"contact": UNDAMPED}}, tolerance=1e-9))
    assert run.totals.mechanism.residual < 1e-7 * run.totals.mechanism.kinetic_max


def test_implicit_steps_give_the_same_motion():
    explicit, _ = integrated(slider_crank({"crank-rod": BALL}, revolutions=0.05))
    implicit, _ = integrated(slider_crank({"crank-rod": BALL}, revolutions=0.05, method="implicit"))
    assert implicit.work.counts.rejected < 0.2 * implicit.work.counts.steps
    assert implicit.work.end[:6] == pytest.approx(explicit.work.end[:6], rel=1e-7, abs=1e-9)


def test_cage_turns_with_the_published_frequency():
    """Inner ring on the crank at 1500 rpm, outer ring at rest: 9.1954022989 Hz; the rings turn once a revolution."""
    grid = slider_crank({"ground-crank": BALL | {"phase": "10 deg"}})
    trajectory = clearsweep.simulate(load_case(grid))
    turned = trajectory["joints/ground_crank/cage_angle"] - math.radians(10.0)
    assert turned == pytest.approx(2.0 * math.pi * 9.1954022989 * trajectory.t, rel=1e-9, abs=1e-12)
    _, (joint,) = integrated(grid)
    assert joint.relative_turn == pytest.approx(math.pi, rel=1e-9)


@pytest.mark.slow
def test_friction_is_the_moment_of_catalogues():
    """0.5 x coefficient x load x bore, against the relative motion of the rings."""
    friction = {"law": "coulomb", "coefficient": 0.0015, "velocity_scale": "1 mm/s"}
    joint = BALL | {"bore": "20 mm", "friction": friction}
    trajectory = clearsweep.simulate(load_case(slider_crank({"ground-crank": joint}, tolerance=1e-8)))
    free = clearsweep.simulate(load_case(slider_crank({"ground-crank": BALL}, tolerance=1e-8)))
    load, tangential = (trajectory[f"joints/ground_crank/force_{name}"] for name in ("normal", "tangential"))
    assert tangential == pytest.approx(-0.0015 * load, rel=1e-9, abs=1e-12)
    torque = trajectory["crank/torque"] - free["crank/torque"]
    assert torque[load > 100.0] == pytest.approx(0.5 * 0.0015 * 0.02 * load[load > 100.0], rel=1e-3)


# ---------------------------------------------------------------------------------------------- figures


def test_figures_of_a_bearing_follow_from_its_histories():
    damped = {"law": "hunt-crossley", "damping_factor": "20 s/m"}
    joint = BALL | {"capacity": {"static": "11.6 kN"}, "contact": damped}
    trajectory = clearsweep.simulate(load_case(slider_crank({"crank-rod": joint}, tolerance=1e-8)))
    summary = trajectory.summary
    forces = np.array([trajectory[f"joints/crank_rod/element_{k + 1}_force"] for k in range(7)])
    assert forces.max() <= summary["crank_rod_element_load_max"] <= 1.05 * forces.max()
    assert summary["crank_rod_elements_loaded_max"] == (forces > 0.0).sum(axis=0).max()
    touching = (forces > 0.0).any(axis=0).mean()
    assert (forces > 0.0).mean(axis=1).max() < touching - 0.1
    assert summary["crank_rod_contact_fraction"] == pytest.approx(touching, abs=5e-3)
    assert summary["crank_rod_static_safety"] == pytest.approx(11600.0 / summary["crank_rod_force_peak"], rel=1e-14)
    distance = np.hypot(trajectory["joints/crank_rod/x"], trajectory["joints/crank_rod/y"])
    assert distance.max() <= summary["crank_rod_eccentricity_max"] <= 1.002 * distance.max()


def test_the_power_of_impacts_is_the_energy_that_the_elements_lose():
    """The fatigue loads of the rings, which are summed next to it, are no power."""
    grid = slider_crank({"crank-rod": BALL}, revolutions=3, tolerance=1e-8) | {"vibration": {}}
    power = clearsweep.simulate(load_case(grid)).summary["impact_power"]
    run, _ = integrated(grid)
    assert power * 3 * 0.04 == pytest.approx(run.totals.mechanism.energy_lost, rel=1e-6)


def test_elastic_loads_follow_from_position_and_cage():
    scene = load_case(slider_crank({"crank-rod": BALL | {"contact": UNDAMPED}}))
    trajectory = clearsweep.simulate(scene)
    histories = [trajectory[f"joints/crank_rod/{name}"] for name in ("x", "y", "cage_angle")]
    loads = element_loads(scene.value.joints[0], *histories)
    for k in range(7):
        shown = trajectory[f"joints/crank_rod/element_{k + 1}_force"]
        assert loads[:, k] == pytest.approx(shown, rel=1e-6, abs=1e-5 * loads.max())
    assert element_approaches(scene.value.joints[0], *histories).shape == loads.shape


def test_step_lengths_by_contacts_do_not_double_with_each_element():
    joint = ROLLER | {"elements": 60, "element_diameter": "2 mm"}
    scene = load_case(slider_crank({"crank-rod": joint}))
    assert arrays_of(scene, 0, np.zeros)["proposals"].size <= 1 << 14


# ---------------------------------------------------------------------------------------------- refusals


def test_a_load_above_the_static_rating_is_a_remark():
    grid = slider_crank({"crank-rod": BALL | {"capacity": {"static": "200 N"}}}, tolerance=1e-8)
    assert "its static rating is 200 N" in clearsweep.simulate(load_case(grid)).message


@pytest.mark.slow
def test_a_run_of_rollers_has_a_report(tmp_path):
    """The record of the run has no grooves, which its reader must not miss."""
    grid = slider_crank({"crank-rod": ROLLER}, revolutions=0.1, tolerance=1e-6) | {"save": {"orbits": "none"}}
    clearsweep.sweep(grid, tmp_path / "run", executor="serial")
    result = CliRunner().invoke(verbs, ["report", str(tmp_path / "run")])
    assert result.exit_code == 0, result.output


@pytest.mark.slow
def test_a_pin_wears_beside_a_bearing():
    """Archard's volume of two bodies is twice the coefficient times friction energy over friction, 0.05."""
    contact = {"law": "hunt-crossley", "stiffness": 6.61e10, "exponent": 1.5, "restitution": 0.8}
    pin = {"clearance": 1e-4, "bearing_radius": 0.01, "length": 0.02, "contact": contact}
    pin["friction"] = {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2}
    pin["wear"] = {"law": "archard", "coefficient": "1e-16 m^2/N", "hardness": 1e9, "bins": 90}
    tree = slider_crank("crank-rod")
    tree["joints"] = {"crank-rod": BALL | {"clearance": 1e-5}, "rod-slider": pin}
    tree["simulate"] = {"revolutions": 1, "discard": 0}
    case = clearsweep.load_case(tree)
    summary = clearsweep.simulate(case).summary
    energy = summary["rod_slider_friction_power"] * 2.0 * math.pi / case.value.reference_rate
    assert summary["rod_slider_wear_volume"] == pytest.approx(2e-16 * energy / 0.05, rel=0.02)
