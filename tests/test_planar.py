"""Planar machines: their equations of motion against absolute coordinates, closed forms and virtual powers."""

import math
import re

import numpy as np
import pytest
from planar_machines import (
    advanced,
    four_bar,
    guide,
    multiplied,
    open_values,
    pin,
    quick_return,
    read,
    slider_crank,
    some_loads,
    triad,
    v_twin,
    weight_and_loads,
)
from slider_crank_oracle import reactions, slider, torque

from clearsweep.contracts.machine import (
    Aim,
    Body,
    BodyPoint,
    Constant,
    Machine,
    Motor,
    Pin,
    Push,
    Rubbing,
    Schedule,
    Spring,
    TabledPush,
)
from clearsweep.mechanics.joints.contract import JointState, Load, load
from clearsweep.mechanics.joints.guide import Guide
from clearsweep.mechanics.laws.contract import FREE, PRESSED
from clearsweep.mechanics.laws.elastic import PowerThreeHalves
from clearsweep.mechanics.laws.friction import Tanh
from clearsweep.mechanics.laws.hysteresis import Lossless
from clearsweep.mechanics.machines import contract, planar
from clearsweep.mechanics.machines.planar import form
from clearsweep.mechanics.machines.planar.closure import STATIONS, ClosureError, MobilityError
from clearsweep.mechanics.machines.planar.stations import Stations, stations_of
from clearsweep.tracing.compiled.pinned import ArrayHandle
from clearsweep.tracing.objects import machine_code

MACHINES = {
    "slider-crank": slider_crank,
    "four-bar": four_bar,
    "v-twin": v_twin,
    "shaper": quick_return,
    "triad": triad,
}
RNG_SEED = 5


def openings(machine):
    """Return every joint alone, the first one with each other, and none."""
    names = [joint.name for joint in machine.joints]
    return [*((name,) for name in names), *((names[0], name) for name in names[1:]), ()]


CASES = [(name, opened) for name, make in MACHINES.items() for opened in openings(make())]


def some_state(machine, opened, rng):
    """Return a machine built with joints open and a state near its start."""
    pins = [joint.name for joint in machine.joints if isinstance(joint, Pin)]
    offsets = {name: 1e-4 * rng.normal(size=2) for name in opened if name in pins}
    built = planar.build(machine, dict.fromkeys(opened), offsets)
    y, count = built.start.copy(), len(built.lengths)
    y[:count] += 1e-4 * rng.normal(size=count)
    y[count : 2 * count] += rng.normal(size=count)
    y[-1] += 0.013
    return built, y


# ---------------------------------------------------------------------------------------------- equations of motion


@pytest.mark.parametrize(("name", "opened"), CASES, ids=lambda part: part if isinstance(part, str) else "+".join(part))
def test_accelerations_are_those_of_absolute_coordinates_with_multipliers(name, opened):
    machine, rng = MACHINES[name](), np.random.default_rng(RNG_SEED)
    built, y = some_state(machine, opened, rng)
    loads = some_loads(len(opened), rng)
    q, rates, accelerations, motion = advanced(built, y, loads)
    force = weight_and_loads(machine, opened, q, loads)
    expected, torque = multiplied(machine, opened, q, rates, force, 0.0)
    assert accelerations == pytest.approx(expected, rel=1e-7, abs=1e-7 * np.max(np.abs(expected)))
    assert motion.torque == pytest.approx(torque, rel=1e-10, abs=1e-10)
    assert open_values(machine, opened, q) < 1e-15


@pytest.mark.parametrize("name", ["v-twin", "shaper", "triad"])
def test_loops_without_clearance_stay_closed_wherever_the_crank_is(name):
    machine = MACHINES[name]()
    opened = (machine.joints[-1].name,)
    built, y = some_state(machine, opened, np.random.default_rng(RNG_SEED))
    for turns in np.linspace(0.0, 3.0, 40):
        y[-1] = turns * 2.0 * math.pi / machine.drive.speed
        q, _ = read(built, y)
        assert open_values(machine, opened, q) < 3e-16 * 2.0


# ---------------------------------------------------------------------------------------------- powers


KNOTS = np.linspace(0.0, 2.0 * math.pi, 13)
PRESSURE = 16.0 * np.cos(KNOTS) + 2.0 * np.sin(3.0 * KNOTS)
PRESSURE[-1] = PRESSURE[0]
OVER_TIME = np.array([0.0, 0.01, 0.02, 0.04])
LOADS = (
    Push("press", BodyPoint("slider", "pin"), -20.0, 10.0, 3.0),
    TabledPush("gas", BodyPoint("slider", "pin"), "angle", KNOTS, PRESSURE, 0.3 * PRESSURE, 0.01 * PRESSURE, 1.5),
    TabledPush(
        "ramp", BodyPoint("rod", "big"), "time", OVER_TIME, 300.0 * OVER_TIME, -200.0 * OVER_TIME, 3.0 * OVER_TIME
    ),
    Spring("return", BodyPoint("ground", "main"), BodyPoint("slider", "pin"), 80.0, 0.1, 0.5),
    Spring("tie", BodyPoint("crank", "pin"), BodyPoint("slider", "pin"), 50.0, 0.2, 0.2),
    Rubbing("seal", "slider-ground", Tanh(0.2, 1e-2)),
    Rubbing("bush", "crank-rod", Tanh(0.3, 1e-2), 0.01),
)
DRIVES = {
    "constant": Constant(60.0, 0.4),
    "table": Schedule(np.array([0.0, 0.01, 0.05]), np.array([50.0, 80.0, 60.0]), 0.4),
    "motor": Motor(20.0, 150.0, 60.0, 2e-3, 0.4),
    "torque": Motor(2.0, math.inf, 60.0, 0.0, 0.4),
}


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("opened", [(), ("rod-slider",), ("ground-crank", "rod-slider")], ids="+".join)
def test_the_kinetic_energy_grows_by_the_powers_of_drive_gravity_loads_and_joints(drive, opened):
    machine, rng = slider_crank(DRIVES[drive], loads=LOADS), np.random.default_rng(RNG_SEED)
    built, y = some_state(machine, opened, rng)
    loads = some_loads(len(opened), rng)
    pose = contract.pose_at(built.value, y)
    motion = contract.accelerate(built.value, pose, loads)
    power = motion.torque * contract.crank_rate(built.value, pose, math.nan)
    power += contract.energy(built.value, pose)[1] + contract.load_power(built.value, motion)
    for gap, pull in zip(contract.gaps(built.value, pose), loads, strict=True):
        power += pull.fx * gap.vx + pull.fy * gap.vy
        power += pull.moment_proximal * gap.spin_proximal + pull.moment_distal * gap.spin_distal

    def kinetic(moved):
        return contract.energy(built.value, contract.pose_at(built.value, moved))[0]

    assert derivative_along(kinetic, y, motion.accelerations) == pytest.approx(power, rel=1e-7, abs=1e-6)


def derivative_along(function, y, accelerations, step=1e-6):
    """Return the derivative in time of a function of the state, by differences of order four."""
    count = len(accelerations)
    slope = np.array([*y[count : 2 * count], *accelerations, 1.0])
    near, far = (function(y + k * step * slope) - function(y - k * step * slope) for k in (1, 2))
    return (8.0 * near - far) / (12.0 * step)


@pytest.mark.parametrize("drive", DRIVES)
def test_the_ideal_machine_is_the_one_without_open_joints(drive):
    machine = slider_crank(DRIVES[drive], offset=0.01, loads=LOADS)
    built = planar.build(machine, {}, {})
    ideal_machine, angle = planar.ideal_of(machine), np.array([0.9])
    time, rate = ideal_machine.crank_passage(angle, lambda: built.value)
    acceleration, *_ = ideal_machine.balance(ideal_machine.states_at(angle), rate, time)
    free = len(built.lengths)
    y = np.array([*(angle if free else ()), *(rate if free else ()), time[0]])
    pose = contract.pose_at(built.value, y)
    motion, ideal = contract.accelerate(built.value, pose, ()), planar.ideal(machine, angle)
    assert contract.crank_rate(built.value, pose, math.nan) == pytest.approx(rate[0], rel=1e-9)
    assert motion.output == pytest.approx(ideal.acceleration[0], rel=1e-9)
    assert contract.output_error(built.value, pose) == pytest.approx((0.0, 0.0), abs=1e-12)
    if free:
        assert motion.accelerations[0] == pytest.approx(acceleration[0], rel=1e-9)


def test_a_free_crank_without_clearance_has_the_energy_that_its_torque_gave_it():
    """Also where it is slowed down by weight, and at angles that it has passed at the start or never reaches."""
    torque, masses = 2.0, np.array([0.3, 0.3, 1e-4, 0.21, 0.21, 2.5e-4, 0.14, 0.14, 0.0])
    machine = slider_crank(Motor(torque, math.inf, 30.0, 0.0, 0.2), gravity=9.81)
    machine = machine._replace(bodies=machine.bodies | {"slider": machine.bodies["slider"]._replace(inertia=0.0)})
    ideal_machine, angles = planar.ideal_of(machine), np.array([0.2, 1.0, 3.0, 9.0, 20.0])
    _, rate = ideal_machine.crank_passage(angles, lambda: planar.build(machine, {}, {}).value)
    there = ideal_machine.states_at(angles)
    energy = 0.5 * (there.derivative**2 @ masses) * rate**2 + 9.81 * (there.q[:, 1::3] @ masses[1::3])
    assert energy - energy[0] == pytest.approx(torque * (angles - 0.2), rel=1e-8, abs=1e-9)
    braked = machine._replace(drive=Motor(-torque, math.inf, 30.0, 0.0, 0.2))
    assert np.isnan(planar.ideal(braked, np.array([0.2, 40.0])).velocity).tolist() == [False, True]


# ---------------------------------------------------------------------------------------------- known motions


def test_a_four_bar_moves_as_published():
    """Physics of a four-bar with a = 0.05, b = 0.12, c = 0.1, d = 0.13 m at 60 degrees and 10 rad/s."""
    machine = four_bar(Constant(10.0))
    turn = planar.ideal_of(machine).states_at(np.array([math.pi / 3.0]))
    coupler, rocker = 5, 8
    assert turn.q[0, [coupler, rocker]] == pytest.approx((0.49208579, 1.56317708), abs=1e-8)
    assert 10.0 * turn.derivative[0, [coupler, rocker]] == pytest.approx((-2.34217099, 3.00230095), abs=1e-8)
    assert 100.0 * turn.second_derivative[0, [coupler, rocker]] == pytest.approx((35.727821, 50.990836), abs=1e-6)


def test_the_ideal_slider_crank_is_the_closed_form():
    angles = np.linspace(-1.0, 9.0, 41)
    bodies = {
        "crank.length": 0.05, "crank.mass": 0.3, "crank.inertia": 1e-4, "crank.center": 0.025, "rod.length": 0.12,
        "rod.mass": 0.21, "rod.inertia": 2.5e-4, "rod.center": 0.06, "slider.mass": 0.14, "gravity": 9.81,
    }  # fmt: skip
    result, forces = planar.ideal(slider_crank(), angles), reactions(bodies, 100.0, angles)
    for mine, theirs in zip(result[:3], slider(0.05, 0.12, angles, 100.0), strict=True):
        assert mine == pytest.approx(theirs, rel=1e-12, abs=1e-12 * np.max(np.abs(theirs)))
    for name, force in forces.items():
        assert result.reactions[name] == pytest.approx(force, rel=1e-11, abs=1e-11 * np.max(np.abs(force)))
    expected = torque(bodies, forces["crank-rod"], angles)
    assert result.torque == pytest.approx(expected, rel=1e-11, abs=1e-11 * np.max(np.abs(expected)))


def test_the_ideal_torque_turns_nothing_in_a_turn_and_does_the_work_of_a_load():
    angles = np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False)
    free = planar.ideal(slider_crank(), angles)
    assert abs(np.mean(free.torque)) < 1e-12 * np.max(np.abs(free.torque))
    pushed = planar.ideal(slider_crank(loads=(Push("push", BodyPoint("slider", "pin"), -50.0, 0.0, 0.0),)), angles)
    work = 50.0 * free.velocity / 100.0  # power over the speed
    assert pushed.torque - free.torque == pytest.approx(work, rel=1e-9, abs=1e-10)


def translational(**drive):
    """Return the slider-crank of Flores, Leine and Glocker (2010), table 1."""
    ground = Body(0.0, 0.0, (0.0, 0.0), {"main": (0.0, 0.0)})
    return Machine(
        {
            "ground": ground,
            "crank": Body(0.038, 7.4e-5, (0.0765, 0.0), {"pivot": (0.0, 0.0), "pin": (0.153, 0.0)}),
            "rod": Body(0.038, 5.9e-4, (0.153, 0.0), {"big": (0.0, 0.0), "small": (0.306, 0.0)}),
            "slider": Body(0.076, 2.7e-6, (0.0, 0.0), {"pin": (0.0, 0.0)}),
        },
        (
            pin("ground-crank", "ground.main", "crank.pivot"),
            pin("crank-rod", "crank.pin", "rod.big"),
            pin("rod-slider", "rod.small", "slider.pin"),
            guide("slider-ground", "ground.main", "slider.pin"),
        ),
        "ground-crank",
        Motor(0.0, math.inf, 150.0),
        9.81,
        Aim("slider", "pin"),
    )


BLOCK = Guide(1e-3, 1.0, 0.1, 0.05, Lossless(), PowerThreeHalves(1e9), Tanh(0.1, 1e-2))


def flown(machine, end):
    """Return a free motion up to `end` (s), by scipy: its solution over time, and when the block reaches a wall."""
    from scipy.integrate import solve_ivp

    built, free = planar.build(machine, {"slider-ground": BLOCK}, {}), (Load(0.0, 0.0, 0.0, 0.0, ()),)

    def rates(time, state):
        pose = contract.pose_at(built.value, np.append(state, time))
        return [*state[3:], *contract.accelerate(built.value, pose, free).accelerations]

    def gap(time, state):
        return contract.gaps(built.value, contract.pose_at(built.value, np.append(state, time)))[0]

    def left(time, state):
        return 1e-3 - abs(gap(time, state).y)

    left.terminal = True
    return solve_ivp(
        rates, (0.0, end), built.start[:-1], "DOP853", events=left, dense_output=True, rtol=1e-12, atol=1e-12
    ), gap


def test_a_block_in_a_guide_with_clearance_flies_as_the_oracle_says():
    """The converged figures of a free crank at 150 rad/s: turns, rod angle, their rates, place over clearance."""
    path, gap = flown(translational(), 3e-3)
    assert path.t_events[0] == pytest.approx([2.6925028e-3], abs=5e-11)
    for time, turns, rod, crank_rate, rod_rate, place in (
        (1e-3, 0.023251080, -0.072596395, 139.115876, -68.276294, 0.077487),
        (2e-3, 0.043894044, -0.134949264, 120.463882, -56.473394, 0.494396),
    ):
        state = path.sol(time)
        assert state[:2] == pytest.approx((2.0 * math.pi * turns, rod), abs=4e-9)
        assert state[3:5] == pytest.approx((crank_rate, rod_rate), abs=6e-7)
        assert gap(time, state).y / 1e-3 == pytest.approx(place, abs=6e-7)


@pytest.mark.parametrize("tilted", [0.0, 0.8])
def test_a_corner_presses_where_it_is_and_its_powers_add_up(tilted):
    machine = quick_return(Motor(3.0, math.inf, 12.0)) if tilted else translational()
    name, rng = "slot" if tilted else "slider-ground", np.random.default_rng(RNG_SEED)
    built = planar.build(machine, {name: BLOCK}, {})
    y, count = built.start.copy(), len(built.lengths)
    y[:count] += 1e-3 * rng.normal(size=count)
    y[count : 2 * count] += rng.normal(size=count)
    pose = contract.pose_at(built.value, y)
    (gap,) = contract.gaps(built.value, pose)
    mode, onset = np.array([PRESSED, FREE, PRESSED, PRESSED]), np.full(4, 0.1)
    present = JointState(np.append(y, [0.01, 0.0, 0.02, 0.005]), mode, onset, y.size)
    from clearsweep.mechanics.joints.contract import Offsets

    pull = load(BLOCK, gap, Offsets(0, y.size + 4, 4, 0), present)
    corners = pull.contacts[:4]
    assert [contact.normal for contact in pull.contacts] == pytest.approx([1e3, 0.0, 8e3, 125.0, 7125.0])
    assert math.hypot(pull.contacts[4].normal, pull.contacts[4].tangential) == pytest.approx(
        math.hypot(pull.fx, pull.fy), rel=1e-12
    )
    motion = contract.accelerate(built.value, pose, (pull,))
    taken = sum(contact.normal * contact.rate - contact.tangential * contact.slip for contact in corners)
    given = motion.torque * contract.crank_rate(built.value, pose, math.nan) + contract.energy(built.value, pose)[1]

    def kinetic(moved):
        return contract.energy(built.value, contract.pose_at(built.value, moved))[0]

    def depths(moved):
        (there,) = contract.gaps(built.value, contract.pose_at(built.value, moved))
        return np.array(
            [contact.depth for contact in load(BLOCK, there, Offsets(0, y.size + 4, 4, 0), present).contacts[:4]]
        )

    assert derivative_along(kinetic, y, motion.accelerations) == pytest.approx(given - taken, rel=1e-7)
    rates = [contact.rate for contact in corners]
    assert derivative_along(depths, y, motion.accelerations) == pytest.approx(rates, rel=1e-6, abs=1e-8)


# ---------------------------------------------------------------------------------------------- what is refused


def lengthened(machine, body, point, place):
    """Return a machine with a point of a body elsewhere."""
    old = machine.bodies[body]
    return machine._replace(bodies={**machine.bodies, body: old._replace(points={**old.points, point: place})})


def test_lengths_that_never_close_are_refused():
    with pytest.raises(ClosureError) as refused:
        planar.build(lengthened(four_bar(), "ground", "foot", (0.4, 0.0)), {}, {})
    assert refused.value.body in ("coupler", "rocker")
    assert refused.value.angle == 0.0


def test_a_crank_that_cannot_turn_on_is_refused_where_it_stops():
    machine = lengthened(four_bar(), "coupler", "small", (0.05, 0.0))  # 0.05 + 0.13 > 0.05 + 0.1: it rocks
    with pytest.raises(ClosureError) as refused:
        planar.build(machine, {}, {})
    reach = math.acos((0.05**2 + 0.13**2 - 0.15**2) / (2.0 * 0.05 * 0.13))  # coupler and rocker in one line
    assert refused.value.angle == pytest.approx(reach, abs=2e-3)


def test_a_singular_position_is_refused_where_it_is():
    machine = lengthened(four_bar(), "coupler", "small", (0.08, 0.0))  # 0.05 + 0.13 = 0.08 + 0.1: folds at half a turn
    with pytest.raises(ClosureError) as refused:
        planar.build(machine, {}, {})
    assert refused.value.angle == pytest.approx(math.pi, abs=0.02)


def four_bar_of(lengths, start):
    """Return a four-bar of ground, crank, coupler and rocker with these lengths (m), and a start angle (rad)."""
    machine = lengthened(four_bar(drive=Constant(10.0, start)), "ground", "foot", (lengths[0], 0.0))
    for (body, point), length in zip(
        (("crank", "pin"), ("coupler", "small"), ("rocker", "pin")), lengths[1:], strict=True
    ):
        machine = lengthened(machine, body, point, (length, 0.0))
        machine.bodies[body] = machine.bodies[body]._replace(center=(0.5 * length, 0.0))
    return machine


def test_a_kite_whose_loops_close_after_two_turns_says_so():
    """Galloway's linkage: the rocker turns once while the crank, as long as the ground, turns twice."""
    with pytest.raises(ClosureError, match="close only after two revolutions of the crank") as refused:
        planar.build(four_bar_of((0.1, 0.1, 0.2, 0.2), 1.0), {}, {})
    assert refused.value.body in ("coupler", "rocker")
    assert refused.value.angle == pytest.approx(2.0 * math.pi, abs=0.02)  # crank and ground are one there


def test_a_start_at_a_change_point_names_a_start_that_runs():
    lengths = (0.4, 0.1, 0.4, 0.1)
    with pytest.raises(ClosureError, match="start in a singular position") as refused:
        planar.build(four_bar_of(lengths, 0.0), {}, {})
    (degrees,) = re.findall(r"drive.start_angle (\S+) deg", refused.value.remedy)
    planar.build(four_bar_of(lengths, math.radians(float(degrees))), {}, {})


def test_loops_that_may_branch_go_straight_on():
    """A rod as long as its crank: x = 2 r cos(angle) of the slider; a parallelogram: its rocker turns on."""
    start, speed = 0.3, 100.0
    angles = start + np.linspace(0.0, 4.0 * math.pi, 721)
    folding = lengthened(slider_crank(drive=Constant(speed, start)), "rod", "small", (0.05, 0.0))
    motion = planar.ideal(folding, angles)
    assert motion.position == pytest.approx(0.1 * np.cos(angles), abs=1e-11)
    assert motion.velocity == pytest.approx(-10.0 * np.sin(angles), abs=1e-8)
    assert motion.acceleration == pytest.approx(-1000.0 * np.cos(angles), abs=1e-4)
    passed = np.array(planar.ideal_of(folding).change_points)
    assert np.cos(passed) == pytest.approx(0.0, abs=0.005)
    near = np.min(np.abs(angles[:, None] - passed), axis=1) < 0.005
    assert np.all(np.isnan(motion.reactions["rod-slider"][near]))
    machine = lengthened(four_bar(drive=Constant(speed, start)), "coupler", "small", (0.13, 0.0))
    machine = lengthened(machine, "rocker", "pin", (0.05, 0.0))._replace(start={"rocker": start, "coupler": 0.0})
    y = planar.build(machine, {}, {}).start
    for turns in np.linspace(0.0, 3.0, 50):
        y[-1] = turns * 2.0 * math.pi / speed
        q, rates = read(planar.build(machine, {}, {}), y)
        assert q[8] == pytest.approx(start + 2.0 * math.pi * turns, abs=1e-9)
        assert rates[8] == pytest.approx(speed, rel=1e-9)


@pytest.mark.few("1.0-lengths0", "1.0-lengths2")
@pytest.mark.parametrize(
    "lengths", [(0.1, 0.1, 0.2, 0.2), (0.05, 0.05, 0.12, 0.12), (0.1, 0.1, 0.1, 0.1), (0.2, 0.1, 0.2, 0.1)]
)
@pytest.mark.parametrize("scale", [1e-3, 1.0, 30.0])
def test_a_start_in_which_all_links_are_in_line_is_refused_there(lengths, scale):
    """Newton's method would leave it in any direction."""
    with pytest.raises(ClosureError, match="singular") as refused:
        planar.build(four_bar_of([scale * length for length in lengths], 0.0), {}, {})
    assert refused.value.angle == 0.0


def test_a_free_crank_that_takes_no_step_is_at_its_start():
    motor = Motor(stall_torque=0.001, no_load_speed=math.inf, initial_speed=0.5)
    for angle in (0.0, -0.5):
        motion = planar.ideal(slider_crank(drive=motor), np.array([angle]))
        assert motion.torque == pytest.approx(0.001, rel=1e-9)


@pytest.mark.parametrize("name", MACHINES)
def test_derivatives_of_a_position_are_those_of_differences(name):
    ideal_machine = planar.ideal_of(MACHINES[name]())
    step, angles = 1e-3, ideal_machine.revolution.angles[:-1:37]

    def at(shift):
        return ideal_machine.states_at(angles + shift)

    def difference(values):  # of fourth order
        return (8.0 * (values(step) - values(-step)) - (values(2.0 * step) - values(-2.0 * step))) / (12.0 * step)

    states = at(0.0)
    for exact, values in (
        (states.derivative, lambda shift: at(shift).q),
        (states.second_derivative, lambda shift: at(shift).derivative),
    ):
        assert difference(values) == pytest.approx(exact, rel=0.0, abs=1e-8 * np.max(np.abs(exact)))


def test_a_machine_is_the_same_whatever_else_is_closed_with_it():
    """Its bits, so that a case does not depend on the angles that another one asks for."""
    ideal_machine = planar.ideal_of(four_bar(drive=Constant(10.0)))
    angles, guesses = 0.0087 * np.arange(40), ideal_machine.revolution.q[:40] + 1e-4
    states, _ = ideal_machine.closure.close(guesses, angles)
    for k in (0, 7, 39):
        alone, _ = ideal_machine.closure.close(guesses[k : k + 1], angles[k : k + 1])
        for together, single in zip(states[1:4], alone[1:4], strict=True):
            assert np.array_equal(together[k], single[0])


def test_a_machine_that_moves_in_two_ways_or_in_none_is_refused():
    machine = four_bar()
    with pytest.raises(MobilityError, match=r"3 degrees of freedom .* needs `initial`"):
        planar.build(machine._replace(joints=machine.joints[:-1]), {}, {})
    strut = pin("strut", "crank.pin", "ground.foot")
    with pytest.raises(MobilityError, match=r"-1 degrees of freedom .* exactly 1$"):
        planar.build(machine._replace(joints=(*machine.joints, strut)), {}, {})


def test_what_moves_without_mass_is_refused():
    machine = slider_crank()
    bodies = {**machine.bodies, "slider": machine.bodies["slider"]._replace(inertia=0.0)}
    with pytest.raises(MobilityError, match="slider"):
        planar.build(machine._replace(bodies=bodies), {"slider-ground": BLOCK}, {})
    planar.build(machine._replace(bodies=bodies), {"rod-slider": None}, {})


# ---------------------------------------------------------------------------------------------- stations


def case(speed=100.0):
    return slider_crank(drive=Constant(speed))


@pytest.mark.few("8")
@pytest.mark.parametrize("turns", [1, 8])
def test_many_angles_give_the_forces_of_few(turns):
    """At stations of all turns, between them, and where both are asked for at once."""
    start = case().drive.start_angle
    even = start + np.linspace(0.0, 2.0 * math.pi * turns, STATIONS * turns + 1)
    for angles in (even, np.union1d(even, start + np.linspace(0.01, 6.0, 77)), even + 1e-3):
        many = planar.ideal(case(), angles)
        for part in np.array_split(np.arange(len(angles)), 12 * turns):  # fewer than the stations: closed anew
            few = planar.ideal(case(), angles[part])
            for name, force in few.reactions.items():
                largest = np.max(np.abs(many.reactions[name]))
                assert many.reactions[name][part] == pytest.approx(force, rel=0.0, abs=1e-12 * largest)
            for value in ("position", "velocity", "acceleration", "torque"):
                all_of_it = getattr(many, value)
                limit = 1e-12 * np.max(np.abs(all_of_it))
                assert all_of_it[part] == pytest.approx(getattr(few, value), rel=0.0, abs=limit)


def test_only_angles_that_are_no_stations_are_closed(monkeypatch):
    machine, closed = case(), []
    known = planar.ideal_of(machine)
    angles = machine.drive.start_angle + np.linspace(0.0, 4.0 * math.pi, 2 * STATIONS + 1)
    anew = type(known)._close
    monkeypatch.setattr(type(known), "_close", lambda self, at: closed.extend(at) or anew(self, at))
    known.states_at(np.append(angles, [0.12345, 9.87654]))
    assert closed == [0.12345, 9.87654]


def test_machines_that_differ_in_masses_and_speed_share_their_stations():
    assert isinstance(stations_of(case()), Stations)
    body = case().bodies["rod"]
    heavier = case(50.0)._replace(bodies={**case().bodies, "rod": body._replace(mass=2.0 * body.mass)})
    assert stations_of(heavier) is stations_of(case())
    moved = {**body.points, next(iter(body.points)): (1e-4, 0.0)}
    longer = case()._replace(bodies={**case().bodies, "rod": body._replace(points=moved)})
    assert stations_of(longer) is not stations_of(case())


def value_at(quantities, angle):
    return form.evaluate_cycle(quantities, 1, angle)[0]


@pytest.mark.compiled
def test_a_cycle_is_read_within_its_table_whatever_the_angle_of_a_trial_step():
    """Beside the table, whose quantities are constant, memory is nan; integers of compiled code have 64 bits."""
    table, memory = np.zeros((STATIONS + 1, 2, form.WIDTH)), np.full(3_000_000, math.nan)
    table[..., 0] = 1.0
    begin = memory.size // 2
    memory[begin : begin + table.size] = table.ravel()
    address = ArrayHandle(memory[begin:].ctypes.data)
    address.array = memory[begin:]
    quantities, read = form.Cycle(address, float(STATIONS), 2.0, 0.0), machine_code(value_at)
    sizes = np.concatenate([np.logspace(0, 80, 4001), 2.0 * math.pi * 2.0**63 * (1.0 + np.arange(-40, 41) * 2.0**-52)])
    for angle in (*sizes, *-sizes):
        assert read(quantities, float(angle)) == 1.0
