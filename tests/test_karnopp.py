"""Surfaces that stick: the force that keeps them, in every mechanism, and where it begins and ends."""

import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.mechanics.coupling.inertia import every_grip, slip_rates, with_sticking_forces
from clearsweep.mechanics.coupling.rates import loads_of
from clearsweep.mechanics.joints.contract import JointState, every_latched
from clearsweep.mechanics.joints.dry import surface_speed
from clearsweep.mechanics.laws.contract import AT_LIMIT_DOWN, AT_LIMIT_UP, PRESSED, STUCK
from clearsweep.mechanics.machines.contract import accelerate, gap_accelerations, gaps, pose_at
from clearsweep.simulation.analyses.outcome import trajectory_of
from clearsweep.simulation.running.run import integration_of

pytestmark = pytest.mark.heavy

KARNOPP = {"law": "karnopp", "coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 1e-2, "band": 1e-3}
JOINTS = ("ground-crank", "crank-rod", "rod-slider")
OPENINGS = [JOINTS[:1], JOINTS[1:2], JOINTS[2:], JOINTS[:2], JOINTS[::2], JOINTS[1:], JOINTS]


def crank(*joints, friction=KARNOPP, **changes):
    """Return the scene of a slow slider-crank that begins at rest in its bearings, with this friction in `joints`."""
    slow = {"drive.speed": "60 rpm", "mechanism.gravity": 9.81, "simulate.start": "seated"}
    written = {f"joints.{joint}.friction": friction for joint in joints}
    changes = {k.replace("__", "."): v for k, v in changes.items()}
    return clearsweep.load_case(slider_crank(*joints, changes=slow | written | changes))


def moving(*joints, seed=1, **changes):
    """Return a scene with all joints in contact, and a state in which all surfaces stick but move a little."""
    made = crank(*joints, **changes)
    y, n = made.start.copy(), len(made.value.coordinates)
    y[n : 2 * n] += np.random.default_rng(seed).normal(0.0, 1e-4, n)
    y[2 * n] = 1e-3
    return made.value, y, np.full(len(joints), STUCK)


def looked_at(scene, y, state):
    """Return pose, Gaps, Loads before anything is kept."""
    pose, first = pose_at(scene.mechanism, y), 2 * len(scene.coordinates) + 1
    relative = gaps(scene.mechanism, pose)
    latched = np.array([1.0] * len(state) + [began for _, began in every_latched(scene.joints)])
    return pose, relative, loads_of(scene.joints, relative, JointState(y, state, latched, first))


# ---------------------------------------------------------------------------------------------- the force that grips


@pytest.mark.parametrize("joints", OPENINGS, ids="+".join)
def test_accelerations_of_gaps_and_slips_are_the_slopes_of_their_speeds(joints):
    scene, y, state = moving(*joints, drive__speed="300 rpm")
    pose, relative, loads = looked_at(scene, y, state)
    motion, n = accelerate(scene.mechanism, pose, loads), len(scene.coordinates)
    flow = np.concatenate([y[n : 2 * n], motion.accelerations, [1.0]])
    ends = []
    for step in (-1e-7, 1e-7):
        there = gaps(scene.mechanism, pose_at(scene.mechanism, y[: 2 * n + 1] + step * flow))
        normals = [
            joint.side * np.array([gap.x, gap.y]) / math.hypot(gap.x, gap.y)
            for joint, gap in zip(scene.joints, there, strict=True)
        ]
        slips = [
            surface_speed(joint, gap, -normal[1], normal[0])
            for joint, gap, normal in zip(scene.joints, there, normals, strict=True)
        ]
        ends.append((np.array([gap[2:] for gap in there]), np.array(slips)))
    (before, slips_before), (after, slips_after) = ends
    scale = np.abs(motion.accelerations).max()
    exact = gap_accelerations(scene.mechanism, y, motion)
    np.testing.assert_allclose(exact, (after - before) / 2e-7, atol=1e-6 * scale)
    rates = slip_rates(scene, y, pose, every_grip(scene.joints, relative, loads, state), loads)
    np.testing.assert_allclose(rates, (slips_after - slips_before) / 2e-7, atol=1e-5 * scale)


@pytest.mark.parametrize("joints", OPENINGS, ids="+".join)
def test_surfaces_that_stick_let_no_sliding_grow(joints):
    strong = KARNOPP | {"static_coefficient": 1e3}
    scene, y, state = moving(*joints, friction=strong)
    pose, relative, loads = looked_at(scene, y, state)
    still = with_sticking_forces(scene, y, pose, relative, loads, state)
    surfaces = every_grip(scene.joints, relative, loads, state)
    for j in range(len(joints)):
        free = abs(slip_rates(scene, y, pose, surfaces, loads)[j])
        expected = -scene.reference_rate * still[j].contacts[0].slip
        assert slip_rates(scene, y, pose, surfaces, still)[j] == pytest.approx(expected, abs=1e-10 * free)
        assert abs(still[j].contacts[0].tangential) < 1e3 * still[j].contacts[0].normal


def after_guards(state, still, static):
    """Return the modes after all guards at the static limit have been passed."""
    changed = state.copy()
    for j, load in enumerate(still):
        limit, needed = static * load.contacts[0].normal, load.contacts[0].stopping_force
        if state[j] == STUCK and abs(needed) > limit:
            changed[j] = AT_LIMIT_UP if needed > 0.0 else AT_LIMIT_DOWN
        elif state[j] in (AT_LIMIT_UP, AT_LIMIT_DOWN) and (needed if state[j] == AT_LIMIT_UP else -needed) < limit:
            changed[j] = STUCK
    return changed


def test_surfaces_bear_no_more_than_they_hold_and_the_others_make_up_for_it():
    bearing = 0
    for seed in range(20):
        scene, y, state = moving(*JOINTS, seed=seed, friction=KARNOPP | {"static_coefficient": 0.12})
        state[seed % 3] = PRESSED
        pose, relative, loads = looked_at(scene, y, state)
        before = None
        while not np.array_equal(state, before):
            still = with_sticking_forces(scene, y, pose, relative, loads, state)
            before, state = state, after_guards(state, still, 0.12)
        surfaces = every_grip(scene.joints, relative, loads, state)
        for j in range(3):
            if state[j] == PRESSED:
                assert still[j].contacts[0].tangential == loads[j].contacts[0].tangential
                continue
            limit = 0.12 * still[j].contacts[0].normal
            slip_error = (
                slip_rates(scene, y, pose, surfaces, still)[j] + scene.reference_rate * still[j].contacts[0].slip
            )
            if state[j] == STUCK:
                assert abs(still[j].contacts[0].tangential) < limit
                assert slip_error == pytest.approx(0.0, abs=1e-9)
            else:
                bearing += 1
                assert abs(still[j].contacts[0].tangential) == pytest.approx(limit, rel=1e-14)
                assert slip_error * still[j].contacts[0].tangential <= 0.0  # more force that way would still be needed
    assert bearing > 0


@pytest.mark.parametrize("joints", OPENINGS[:3], ids="+".join)
def test_the_force_that_surfaces_need_is_the_same_at_their_limit(joints):
    scene, y, state = moving(*joints)
    pose, relative, loads = looked_at(scene, y, state)
    (solved,) = with_sticking_forces(scene, y, pose, relative, loads, state)
    assert solved.contacts[0].stopping_force == pytest.approx(solved.contacts[0].tangential, rel=1e-12)
    for mode, sign in ((AT_LIMIT_UP, 1.0), (AT_LIMIT_DOWN, -1.0)):
        (limited,) = with_sticking_forces(scene, y, pose, relative, loads, np.full(1, mode))
        assert limited.contacts[0].tangential == pytest.approx(sign * 0.15 * limited.contacts[0].normal, rel=1e-14)
        assert limited.contacts[0].stopping_force == pytest.approx(solved.contacts[0].stopping_force, rel=1e-9)


# ---------------------------------------------------------------------------------------------- in a mechanism


@pytest.mark.compiled
def test_surfaces_stick_within_the_band_and_slide_beyond_it():
    made = crank(
        "rod-slider",
        friction=KARNOPP | {"viscous": 2.0},
        simulate__revolutions=1,
        save__orbits="all",
        save__revolutions=1,
        save__samples=20_000,
    )
    run = clearsweep.simulate(made)
    assert run.status == "ok"
    x, y, vx, vy = (run[f"joints/rod_slider/{name}"] for name in ("x", "y", "vx", "vy"))
    slip = (x * vy - y * vx) / np.hypot(x, y) + run["rod/rate"] * 9.5e-3  # the journal sits on the rod
    normal, tangential = run["joints/rod_slider/force_normal"], run["joints/rod_slider/force_tangential"]
    sliding = np.abs(slip) > 1.001e-3
    inside = np.abs(slip) < 0.999e-3
    curve = 0.1 + 0.05 * np.exp(-((slip / 1e-2) ** 2)) + 2.0 * np.abs(slip)
    law = -normal * np.sign(slip) * curve
    np.testing.assert_allclose(tangential[sliding], law[sliding], rtol=1e-9)
    limit = 0.1 + 0.05 * math.exp(-0.01) + 2.0 * 1e-3  # at the edge; a little more than the static coefficient
    assert np.all(np.abs(tangential[inside]) <= limit * normal[inside] * (1.0 + 1e-12))
    assert 0.02 < np.mean(inside) < 0.98
    holding = inside & (np.abs(tangential) < 0.15 * normal)
    assert np.count_nonzero(holding) > 100
    power = tangential * slip
    assert np.all(power[sliding] < 0.0)
    assert np.all(power <= limit * normal * 1.001e-3)


@pytest.mark.slow
@pytest.mark.compiled
def test_smooth_friction_gives_the_same_as_it_gets_steeper():
    plain = {"coefficient": 0.1, "static_coefficient": 0.1, "stribeck_velocity": 1.0, "band": 1e-6}
    kept = {"joints__rod-slider__contact__onset": "first"}
    times = np.linspace(0.0, 0.5, 501)
    exact = clearsweep.simulate(crank("rod-slider", friction={"law": "karnopp", **plain}, **kept), times)[
        "crank/torque"
    ]
    off = []
    for scale in (1e-2, 1e-3, 1e-4):
        tanh = {"law": "tanh", "coefficient": 0.1, "velocity_scale": scale}
        smooth = clearsweep.simulate(crank("rod-slider", friction=tanh, **kept), times)["crank/torque"]
        off.append(np.sqrt(np.mean((smooth - exact) ** 2)))
    assert off[0] > 3.0 * off[1] > 9.0 * off[2]
    assert off[2] < 1e-3 * np.abs(exact).max()


@pytest.mark.compiled
@pytest.mark.few
def test_a_tighter_tolerance_converges_and_energies_balance():
    def run(tolerance):
        made = crank(*JOINTS[1:], simulate__tolerance=tolerance, simulate__method="explicit")
        return clearsweep.simulate(made).summary

    exact, errors = run(1e-11), []
    for tolerance in (1e-6, 1e-8, 1e-10):
        summary = run(tolerance)
        assert summary["energy_residual"] < tolerance
        errors.append(abs(summary["crank_torque_peak"] / exact["crank_torque_peak"] - 1.0))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-8


@pytest.mark.compiled
@pytest.mark.parametrize("joints", [JOINTS[2:], JOINTS[1:]], ids="+".join)
def test_surfaces_that_stick_are_integrated_implicitly(joints):
    explicit, implicit = (
        clearsweep.simulate(crank(*joints, simulate__method=method, simulate__revolutions=0.05))
        for method in ("explicit", "implicit")
    )
    assert explicit.status == implicit.status == "ok"
    force = "rod_slider_force_rms"
    assert implicit.summary[force] == pytest.approx(explicit.summary[force], rel=1e-5)


@pytest.mark.compiled
def test_surfaces_that_let_go_are_not_caught_at_once():
    smooth = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-3}
    steps = [
        clearsweep.simulate(crank("rod-slider", friction=law, simulate__method="explicit")).summary["steps"]
        for law in (KARNOPP | {"viscous": 30.0}, smooth)
    ]
    assert steps[0] < 1.4 * steps[1] < 1.4 * 2000  # with plain sweeps 3,335 and 3,266


@pytest.mark.slow
@pytest.mark.compiled
def test_a_fast_mechanism_whose_joints_all_stick_goes_through():
    made = crank(*JOINTS, drive__speed="3000 rpm", simulate__start="centred", simulate__revolutions=0.5)
    summary = clearsweep.simulate(made).summary
    assert summary["energy_residual"] < 1e-9


@pytest.mark.few
@pytest.mark.compiled
def test_a_peak_in_a_step_with_several_extrema_is_found():
    """A crank torque that rises at both ends of a step and has its maximum inside."""
    made = crank("crank-rod", "rod-slider", simulate__revolutions=0.02, simulate__tolerance=1e-7)
    run = clearsweep.simulate(made, times=np.linspace(0.006, 0.0066, 601))
    sampled = np.abs(run["crank/torque"]).max()
    assert 0.0 < sampled == pytest.approx(run.summary["crank_torque_peak"], rel=1e-7)


@pytest.mark.slow
@pytest.mark.compiled
def test_only_joints_with_the_law_stick():
    written = {
        "joints.crank-rod.friction": {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-3},
        "joints.rod-slider.friction": KARNOPP,
        "simulate.revolutions": 0.2,
    }
    made = clearsweep.load_case(slider_crank("crank-rod", "rod-slider", changes=written))
    run = integration_of(made, np.empty(0), 0.2 * 2.0 * math.pi / made.value.reference_rate)
    guards = run.work.guards
    assert set(guards.contact[guards.next_mode == STUCK]) == {1}
    assert np.all(guards.next_mode[guards.contact == 0] != STUCK)
    assert trajectory_of(made, run, 1.0).summary["energy_residual"] < 1e-9
