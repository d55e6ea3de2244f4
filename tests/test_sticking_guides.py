"""Surfaces that stick in a guide and in a slot with clearance: the forces that grip them, and where they let go."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import changed, slider_crank
from right_grids import grid_of
from scipy.integrate import solve_ivp
from test_slot import GRID as SLOT

import clearsweep
from clearsweep.mechanics.coupling.inertia import every_grip, flatten_once, slip_rates, with_sticking_forces
from clearsweep.mechanics.coupling.rates import loads_of
from clearsweep.mechanics.joints.contract import JointState, every_contact, every_latched
from clearsweep.mechanics.laws.contract import FREE, STUCK
from clearsweep.mechanics.machines.contract import accelerate, gaps, pose_at
from clearsweep.verify.measured import machines

pytestmark = [pytest.mark.heavy, pytest.mark.usefixtures("too_short")]

LAW = {"law": "karnopp", "coefficient": 1.0, "static_coefficient": 1.5, "stribeck_velocity": 1e-3, "band": 1e-6}
STRONG = LAW | {"static_coefficient": 1e7}


# ---------------------------------------------------------------------------------------------- what grips them


def block(friction):
    """Return the scene of a block in a guide with clearance, whose walls turn with the crank."""
    given = {
        "mechanism.gravity": 9.81,
        "mechanism.bodies.block.center": [2e-3, 1e-3],
        "mechanism.bodies.block.initial": {"x": 0.022, "y": 0.011, "vx": -0.3, "vy": 0.6, "rate": 30.0},  # as the crank
        "mechanism.joints.guide.axis": "20 deg",
        "drive.speed": 30.0,
        "joints.guide.friction": friction,
        "simulate": {"revolutions": 1, "discard": 0},
        "save": None,
    }
    return changed(grid_of("a block in a turning guide"), given)


def pin(friction, **changes):
    """Return the scene of a pin in a slot."""
    made = copy.deepcopy(SLOT)
    made["joints"]["slot"] |= {"friction": friction} | changes
    return made


def latched(scene, mode):
    """Return onset rates of 1 m/s and what the laws of a scene begin with."""
    return np.array([1.0] * len(mode) + [began for _, began in every_latched(scene.joints)])


def seen(source, moved, stuck):
    """Return scene, state, modes, pose, Gaps and Loads where the coordinates are `moved` and move."""
    scene = clearsweep.load_case(source).value
    n, contacts = len(scene.coordinates), every_contact(scene.joints)
    y = np.zeros(2 * n + 1 + len(contacts))
    y[: 2 * n + 1] = clearsweep.load_case(source).start[: 2 * n + 1]
    y[: len(moved)] += moved
    y[n : 2 * n] += np.random.default_rng(3).normal(0.0, 2e-4, n)
    y[2 * n + 1 :] = 1e-3
    reporting = [modes.apart for _, modes in contacts[len(stuck) :]]
    mode = np.array([*[STUCK if each else FREE for each in stuck], *reporting])
    pose = pose_at(scene.mechanism, y)
    relative = gaps(scene.mechanism, pose)
    loads = loads_of(scene.joints, relative, JointState(y, mode, latched(scene, mode), 2 * n + 1))
    return scene, y, mode, pose, relative, loads


CASES = {
    "both corners on a wall": (block(STRONG), (0.0, 0.0), (1, 1, 0, 0)),
    "one corner": (block(STRONG), (0.0, 0.0), (0, 0, 1, 0)),
    "jammed": (block(STRONG), (0.0, 0.0), (1, 0, 1, 0)),
    "all corners": (block(STRONG), (0.0, 0.0), (1, 1, 1, 1)),
    "on a wall of a slot": (pin(STRONG), (1e-4,), (1,)),
    "at the end of a slot": (pin(STRONG, slot_length=0.0161), (1e-4,), (1,)),
}


@pytest.mark.parametrize("case", CASES)
def test_slip_rates_are_the_slopes_of_the_slips(case):
    scene, y, mode, pose, relative, loads = seen(*CASES[case])
    grips = every_grip(scene.joints, relative, loads, mode)
    n, motion = len(scene.coordinates), accelerate(scene.mechanism, pose, loads)
    flow = np.concatenate([y[n : 2 * n], motion.accelerations, [1.0]])
    ends = []
    for step in (-1e-7, 1e-7):
        there = y.copy()
        there[: 2 * n + 1] += step * flow
        around = gaps(scene.mechanism, pose_at(scene.mechanism, there))
        pushed = loads_of(scene.joints, around, JointState(there, mode, latched(scene, mode), 2 * n + 1))
        ends.append([grip.slip for grip in flatten_once(every_grip(scene.joints, around, pushed, mode)) if grip.limit])
    rates = [
        rate
        for rate, grip in zip(slip_rates(scene, y, pose, grips, loads), flatten_once(grips), strict=True)
        if grip.limit
    ]
    scale = max(map(abs, motion.accelerations))
    np.testing.assert_allclose(rates, np.diff(ends, axis=0)[0] / 2e-7, rtol=1e-5, atol=1e-7 * scale)


@pytest.mark.parametrize("case", CASES)
def test_what_sticks_lets_no_sliding_grow_and_shares_its_force(case):
    scene, y, mode, pose, relative, loads = seen(*CASES[case])
    still = with_sticking_forces(scene, y, pose, relative, loads, mode)
    grips = every_grip(scene.joints, relative, loads, mode)
    before = slip_rates(scene, y, pose, grips, loads)
    after = slip_rates(scene, y, pose, grips, still)
    free = max(abs(rate) for rate, grip in zip(before, flatten_once(grips), strict=True) if grip.limit)
    for rate, grip in zip(after, flatten_once(grips), strict=True):
        if grip.limit:
            assert rate == pytest.approx(-scene.reference_rate * grip.slip, abs=1e-9 * free)
    shares = [
        contact.tangential / contact.normal
        for contact, state in zip(still[0].contacts, mode, strict=True)
        if state == STUCK
    ]
    for item, other in ((0, 1),) if case == "both corners on a wall" else ():
        assert shares[item] == pytest.approx(shares[other], rel=1e-12)
    assert all(abs(share) < 1e7 for share in shares)


@pytest.mark.parametrize("case", CASES)
def test_the_power_of_what_holds_is_force_times_slip(case):
    """The change of the Load, times the motion of the bodies, is the change of all forces times their slips."""
    scene, y, mode, pose, relative, loads = seen(*CASES[case])
    still = with_sticking_forces(scene, y, pose, relative, loads, mode)
    (gap,), (old,), (new,) = relative, loads, still
    c, s = gap.axis_x, gap.axis_y
    x, vx, vy = c * gap.x - s * gap.y, c * gap.vx - s * gap.vy, s * gap.vx + c * gap.vy
    vx, vy = vx - gap.spin_proximal * (s * gap.x + c * gap.y), vy + gap.spin_proximal * x
    power = vx * (new.fx - old.fx) + vy * (new.fy - old.fy)
    power += gap.spin_proximal * (new.moment_proximal - old.moment_proximal)
    power += gap.spin_distal * (new.moment_distal - old.moment_distal)
    pairs = zip(new.contacts, old.contacts, strict=True)
    assert power == pytest.approx(sum((a.tangential - b.tangential) * a.slip for a, b in pairs), rel=1e-9)


# ---------------------------------------------------------------------------------------------- in motion


def drawn(end):
    """Return where a block of 1 kg is at the end (s) of its first slip, and when that began, by scipy."""

    def pushed(t, y):
        sliding = 1.0 + 0.5 * math.exp(-((y[1] / 1e-3) ** 2)) + 0.4 * y[1]
        return [y[1], 2.0 * (0.1 * t - y[0]) - sliding]

    # it lets go where the spring draws with 1.5 N
    return solve_ivp(pushed, (7.5, end), [0.0, LAW["band"]], "LSODA", rtol=1e-10, atol=1e-13).y[:, -1]


def test_a_block_drawn_by_a_spring_sticks_and_slips_as_scipy_says():
    source = machines.stick_slip_grid(LAW | {"viscous": 0.4})
    source["simulate"]["revolutions"] = 0.5
    end = 9.0
    path = clearsweep.simulate(clearsweep.load_case(source), times=[0.0, 7.4, end, 12.0, 12.5])
    assert path.status == "ok"
    x, v = path["block/x"], path["block/vx"]
    assert abs(x[1]) < 7.4 * LAW["band"]
    assert [x[2], v[2]] == pytest.approx(drawn(end), rel=1e-3)
    assert abs(x[4] - x[3]) < LAW["band"]  # it rests again
    assert path.summary["energy_residual"] < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("source", [block(LAW), pin(LAW), pin(LAW, slot_length=0.0998)], ids=["guide", "slot", "ends"])
def test_what_sticks_now_and_then_keeps_the_ledger(source):
    source = copy.deepcopy(source)
    joint = next(iter(source["joints"].values()))
    joint["friction"] = joint["friction"] | {"coefficient": 0.2, "static_coefficient": 0.3, "band": 1e-4}
    source["simulate"] |= {"revolutions": 1, "tolerance": 1e-9}
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "ok", path.message
    assert path.summary["energy_residual"] < 1e-6


@pytest.mark.slow
def test_a_pin_and_a_guide_of_one_machine_may_stick_together():
    law = {"law": "karnopp", "coefficient": 0.1, "static_coefficient": 0.2, "stribeck_velocity": 0.01, "band": 1e-3}
    guide = {"clearance": 2e-4, "length": 0.06, "height": 0.03, "contact": {"law": "hertz", "stiffness": 1e10}}
    changes = {
        "drive.speed": "300 rpm",
        "mechanism.gravity": 9.81,
        "mechanism.slider.inertia": 1e-4,
        "joints.rod-slider.friction": law,
        "joints.slider-ground": guide | {"friction": law},
        "simulate.revolutions": 0.3,
        "simulate.tolerance": 1e-8,
    }
    summary = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes))).summary
    assert summary["energy_residual"] < 1e-8
    assert summary["slider_ground_friction_power"] > 0.0
