"""A pin with clearance in a straight slot, against closed forms, a round bearing, and its own powers."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import changed
from planar_machines import CRANK, ground, pin
from right_grids import grid_of
from scipy.integrate import solve_ivp

import clearsweep
from clearsweep.contracts.machine import Aim, Body, BodyPoint, Constant, Machine, Slot
from clearsweep.mechanics import wear as contract_wear
from clearsweep.mechanics.joints import dry
from clearsweep.mechanics.joints.contract import JointState, Offsets, load
from clearsweep.mechanics.joints.guide import GuideGap
from clearsweep.mechanics.joints.slot import SlotJoint
from clearsweep.mechanics.laws.contract import PRESSED
from clearsweep.mechanics.laws.elastic import PowerThreeHalves
from clearsweep.mechanics.laws.friction import Tanh
from clearsweep.mechanics.laws.hysteresis import Hysteresis
from clearsweep.mechanics.machines import contract, planar
from clearsweep.mechanics.wear import NoWear, bins
from clearsweep.report.sections.wear import wear_sections
from clearsweep.report.study import prepare

REACH, FOOT, CRANK_LENGTH, SPEED = 0.15, -0.15, 0.05, 12.0
LEVER = Body(0.4, 2e-3, (0.12, 0.0), {"foot": (0.0, 0.0), "middle": (REACH, 0.0)})
GRID = grid_of("a slot")


def grid(**changes):
    return changed(GRID, **changes)


def machine():
    """Return a quick-return mechanism whose crank pin runs in a slot of the lever."""
    return Machine(
        {"ground": ground(main=(0.0, 0.0), foot=(0.0, FOOT)), "crank": CRANK, "lever": LEVER},
        (
            pin("main", "ground.main", "crank.pivot"),
            pin("foot", "ground.foot", "lever.foot"),
            Slot("slot", BodyPoint("lever", "middle"), BodyPoint("crank", "pin"), 0.0),
        ),
        "main",
        Constant(SPEED),
        0.0,
        Aim("lever"),
        {"lever": 1.4},
    )


def lever(time):
    """Return the angle of the lever without clearance at times (s)."""
    turned = SPEED * time
    return np.arctan2(CRANK_LENGTH * np.sin(turned) - FOOT, CRANK_LENGTH * np.cos(turned))


def test_the_machine_without_clearance_moves_and_presses_as_the_closed_form_says():
    times, h = np.linspace(0.0, 0.5, 51), 1e-4
    result = planar.ideal(machine(), SPEED * times)
    np.testing.assert_allclose(result.position, lever(times), rtol=1e-12)
    spun = (lever(times - h) - 2.0 * lever(times) + lever(times + h)) / h**2
    inertia = 2e-3 + 0.4 * 0.12**2
    x, y = CRANK_LENGTH * np.cos(SPEED * times), CRANK_LENGTH * np.sin(SPEED * times) - FOOT
    pushed = -np.hypot(*result.reactions["slot"].T)
    np.testing.assert_allclose(pushed, -np.abs(inertia * spun / np.hypot(x, y)), rtol=1e-4, atol=1e-5)


LAW, ELASTIC, FRICTION = Hysteresis(0.4), PowerThreeHalves(1e9), Tanh(0.1, 0.01)
JOINT = SlotJoint(5e-5, 6e-3, 1.0, 0.06, LAW, ELASTIC, FRICTION, 6.05e-3 + 0.12 / math.pi, NoWear())


def state(gap, joint=JOINT):
    """Return what a joint does in contact at a gap."""
    depth = math.hypot(gap.x - min(max(gap.x, -0.06), 0.06), gap.y) - joint.clearance
    present = JointState(np.array([math.sqrt(max(depth, 0.0))]), np.array([PRESSED]), np.array([0.2]), 0)
    return load(joint, gap, Offsets(0, 1, 1, 0), present), present


def test_an_end_of_the_slot_is_a_round_bearing():
    round_one = dry.Joint(5e-5, 6e-3 + 5e-5, 6e-3, 1.0, LAW, ELASTIC, FRICTION, NoWear())
    beyond, across = 4e-5, 5e-5
    gap = GuideGap(0.06 + beyond, across, 0.3, 0.1, 0.0, 7.0, 1.0, 0.0, 1.0, 0.0)
    slotted, present = state(gap)
    bearing = load(round_one, dry.Gap(beyond, across, 0.3, 0.1, 0.0, 7.0), Offsets(0, 1, 1, 0), present)
    assert (slotted.fx, slotted.fy) == pytest.approx((bearing.fx, bearing.fy), rel=1e-12)
    assert slotted.moment_distal == pytest.approx(bearing.moment_distal, rel=1e-12)
    assert slotted.contacts[0] == pytest.approx(bearing.contacts[0], rel=1e-12)


def test_the_walls_press_across_wherever_the_pin_is():
    for x in (-0.0599, 0.0, 0.03):
        pull, _ = state(GuideGap(x, 6e-5, 0.5, 0.1, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0))
        contact = pull.contacts[0]
        assert pull.fy == pytest.approx(-contact.normal, rel=1e-14)
        assert pull.fx == pytest.approx(-contact.tangential, rel=1e-14)  # the tangent points backwards along the slot
        assert (contact.rate, contact.slip) == pytest.approx((0.1, -0.5))
        assert contact.depth == pytest.approx(1e-5)


@pytest.mark.parametrize("x", [0.01, 0.06002, -0.06003])
def test_the_powers_on_both_bodies_add_up(x):
    gap = GuideGap(x, -7e-5, 0.4, -0.2, 3.0, -5.0, math.cos(0.3), math.sin(0.3), 1.0, 0.0)
    pull, _ = state(gap)
    c, s = gap.axis_x, gap.axis_y
    place = np.array([c * gap.x - s * gap.y, s * gap.x + c * gap.y])
    seen = np.array([c * gap.vx - s * gap.vy, s * gap.vx + c * gap.vy])
    moving = seen + gap.spin_proximal * np.array([-place[1], place[0]])  # of the pin, the slot's point being at rest
    power = (
        moving @ [pull.fx, pull.fy] + pull.moment_distal * gap.spin_distal + pull.moment_proximal * gap.spin_proximal
    )
    contact = pull.contacts[0]
    assert power == pytest.approx(-contact.normal * contact.rate + contact.tangential * contact.slip, rel=1e-10)


def test_a_machine_with_a_slot_runs_and_its_energies_add_up():
    path = clearsweep.simulate(clearsweep.load_case(grid()))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-7
    assert np.ptp(path["joints/slot/x"]) == pytest.approx(2.0 * CRANK_LENGTH, rel=1e-3)
    assert np.max(np.abs(path["joints/slot/y"])) < 1e-4
    np.testing.assert_allclose(path["lever/angle"], lever(path.t), atol=1e-3)
    inertia = 2e-3 + 0.4 * 0.12**2
    times, h = np.linspace(0.0, 2.0 * math.pi / SPEED, 4001), 1e-4
    spun = (lever(times - h) - 2.0 * lever(times) + lever(times + h)) / h**2
    arm = np.hypot(CRANK_LENGTH * np.cos(SPEED * times), CRANK_LENGTH * np.sin(SPEED * times) - FOOT)
    assert path.summary["slot_force_peak_ideal"] == pytest.approx(np.max(np.abs(inertia * spun / arm)), rel=1e-4)
    assert path.summary["slot_friction_power"] > 0.0


def test_a_slot_that_is_too_short_meets_its_ends(too_short):
    long, short = (
        clearsweep.simulate(clearsweep.load_case(grid(joints__slot__slot_length=size))) for size in (0.12, 0.0998)
    )
    assert short.summary["slot_force_peak"] > 5.0 * long.summary["slot_force_peak"]
    assert short.summary["energy_residual"] < 1e-6


def test_open_and_ideal_machines_agree_under_the_ideal_force():
    made = machine()

    class Clearance:
        clearance = 5e-5

    built = planar.build(made, {"slot": Clearance()}, {})
    ideal = planar.ideal(made, np.array([0.0]))
    force = ideal.reactions["slot"][0]
    pose = contract.pose_at(built.value, built.start)
    (gap,) = contract.gaps(built.value, pose)
    assert gap.y == pytest.approx(0.0, abs=1e-15)
    angle_rate = -(gap.axis_x * gap.x * force[1] - gap.axis_y * gap.x * force[0])  # the slot is pushed where the pin is
    from clearsweep.mechanics.joints.contract import Load

    motion = contract.accelerate(
        built.value, pose, (Load(float(force[0]), float(force[1]), float(angle_rate), 0.0, ()),)
    )
    assert motion.output == pytest.approx(float(ideal.acceleration[0]), rel=1e-9)
    assert motion.torque == pytest.approx(float(ideal.torque[0]), rel=1e-9)


# ---------------------------------------------------------------------------------------------- wear

COEFFICIENTS = {"bearing_coefficient": 1e-14, "journal_coefficient": 4e-14}  # m^2/N
HALF, AROUND = 0.06, 0.24 + 2.0 * math.pi * 6e-3  # m, half of the slot's length, its wall all round
BINS = 180


def worn_grid(**wear):
    made = copy.deepcopy(GRID)
    made["joints"]["slot"] |= {"length": 0.01, "wear": WEAR | wear}
    made["simulate"] |= {"revolutions": 1.2, "discard": 0.2, "tolerance": 1e-7}
    made["save"] = {"orbits": "all", "samples": 40000}
    return made


WEAR = {"law": "archard", **COEFFICIENTS, "pressure_modulus": 110e9, "bins": BINS}


@pytest.fixture(scope="module")
def worn():
    path = clearsweep.simulate(clearsweep.load_case(worn_grid()))
    assert path.status == "ok", path.message
    return path


def way_along(x, y, radius=6e-3):
    """Return the way (m) along the wall from the middle of the end in the direction of the slot, counter-clockwise."""
    nearest = np.clip(x, -HALF, HALF)
    angle = np.arctan2(y, x - nearest) % (2.0 * math.pi)
    return radius * angle + np.where(angle <= math.pi, HALF - nearest, 3.0 * HALF + nearest)


def rubbing(path):
    """Return what each sample wears off per coefficient and length (m^2), the way along the wall, the pin's angle."""
    t, x, y = path.t, path["joints/slot/x"], path["joints/slot/y"]
    counted = t >= 0.2 * 2.0 * math.pi / SPEED
    beyond = x - np.clip(x, -HALF, HALF)
    far = np.hypot(beyond, y)
    nx, ny = beyond / far, y / far
    slip = path["joints/slot/vy"] * nx - path["joints/slot/vx"] * ny
    slip += 5.95e-3 * (path["crank/rate"] - path["lever/rate"])
    work = path["joints/slot/force_normal"] * np.abs(slip) * np.gradient(t) * counted / 0.01
    on_pin = np.arctan2(ny, nx) + path["lever/angle"] - path["crank/angle"]
    return work, way_along(x, y), on_pin


def test_a_pin_wears_the_wall_where_it_slides_along_it(worn):
    bearing, journal = worn.wear["slot"]
    work, way, on_pin = rubbing(worn)
    wall = np.histogram(way % AROUND, BINS, (0.0, AROUND), weights=work)[0] * 1e-14 / (AROUND / BINS)
    assert bearing.sum() == pytest.approx(wall.sum(), rel=2e-3)
    assert bearing == pytest.approx(wall, rel=0.03, abs=0.02 * wall.max())
    pin = work.sum() * 4e-14 / (2.0 * math.pi * 5.95e-3 / BINS)
    assert journal.sum() == pytest.approx(pin, rel=2e-3)
    assert np.count_nonzero(journal > 0.01 * journal.max()) < 0.6 * BINS  # the pin turns with the crank
    assert on_pin.size == work.size
    volume = 0.01 * work.sum() * 5e-14
    assert worn.summary["slot_wear_volume"] == pytest.approx(volume, rel=2e-3)
    assert worn.summary["slot_wear_narrow_arcs"] == 0.0


def seen_at(x, y, axis=0.0):
    """Return the angles on wall and pin that a contact is noted at, with their rates, for a motion along x of 1 m/s."""
    places = np.zeros((1, 6, 1))
    moment = bins.Instant((), (), 0, bins.Step(None, 0.0, np.array([PRESSED]), places, None, None, None, None))
    gap = GuideGap(x, y, 1.0, 0.0, 3.0, 5.0, math.cos(axis), math.sin(axis), 1.0, 0.0)
    bins.record(JOINT, gap, (0.2, 0.7), 0, moment)
    return places[0, :, 0]


def test_places_on_the_wall_are_ways_all_round_and_those_on_the_pin_turn_with_it():
    out = 5.06e-5  # m, from the line
    points = [(0.03, out), (-0.05, out), (-0.06 - 0.6 * out, 0.8 * out), (-0.02, -out), (0.06 + 0.6 * out, -0.8 * out)]
    for x, y in points:
        seen = seen_at(x, y, 0.4)
        way = seen[0] * JOINT.bearing_radius
        assert way % (2.0 * math.pi * JOINT.bearing_radius) == pytest.approx(way_along(x, y, 6.05e-3), rel=1e-9)
        # the rate is the slope
        near = [seen_at(x + sign * 1e-9, y, 0.4) for sign in (-1.0, 1.0)]
        assert seen[3] == pytest.approx((near[1][0] - near[0][0]) / 2e-9, rel=1e-3, abs=1e-3)
        spin = (near[1][1] - near[0][1]) / 2e-9
        assert seen[4] == pytest.approx(spin + 3.0 - 5.0, rel=1e-3, abs=1e-3)
    upper = seen_at(0.03, out, 0.4)
    assert upper[1] == pytest.approx(0.5 * math.pi + 0.4 - 0.7)


def test_the_pin_has_its_own_radius_on_a_wall_and_that_of_a_bearing_at_an_end():
    for way, clearance in ((0.0, 5e-5), (0.1, 6.05e-3), (0.135, 5e-5), (0.2, 6.05e-3), (0.275, 5e-5), (-0.1, 6.05e-3)):
        assert contract_wear.local_clearance(JOINT, way / JOINT.bearing_radius, 0.0) == pytest.approx(clearance)


def test_the_report_says_what_the_angle_on_a_slot_is(tmp_path):
    source = worn_grid() | {"name": "slot", "save": {"orbits": "none"}}
    source["simulate"] = source["simulate"] | {"revolutions": 0.3, "discard": 0.0}
    clearsweep.sweep(source, out=tmp_path / "run", executor="serial", show_progress=False)
    (section,) = wear_sections(prepare(clearsweep.open(tmp_path / "run")))
    assert "In a slot, 360° are one circuit of its wall" in section.blocks[0].text


# ---------------------------------------------------------------------------------------------- by other equations


def rattled(end):
    """Return angle and rate of the lever at a time (s), and its onsets, by equations of its own and scipy."""
    contact, friction = GRID["joints"]["slot"]["contact"], GRID["joints"]["slot"]["friction"]
    mass, inertia, arm, gravity = 0.4, 2e-3 + 0.4 * 0.12**2, 0.12, 9.81
    chi, pin = 0.75 * (1.0 - contact["restitution"] ** 2), 5.95e-3

    def seen(t, y):
        place = CRANK_LENGTH * np.array([math.cos(SPEED * t), math.sin(SPEED * t)]) - [0.0, FOOT]
        moving = CRANK_LENGTH * SPEED * np.array([-math.sin(SPEED * t), math.cos(SPEED * t)])
        distance, across = np.array([math.cos(y[0]), math.sin(y[0])]), np.array([-math.sin(y[0]), math.cos(y[0])])
        side = math.copysign(1.0, place @ across)
        last_lines = side * (moving @ across - y[1] * (place @ distance))
        slip = -side * (moving @ distance + y[1] * (place @ across)) + pin * (SPEED - y[1])
        return place, distance, across, side, last_lines, slip

    def depth(t, y):
        place, _, across, side, *_ = seen(t, y)
        return side * (place @ across) - 5e-5

    def slope(t, y, rate):
        place, distance, across, side, last_lines, slip = seen(t, y)
        angle_rate = -mass * gravity * arm * math.cos(y[0])
        if rate:
            normal = max(1e9 * max(depth(t, y), 0.0) ** 1.5 * (1.0 + chi * last_lines / rate), 0.0)
            rubbing = -0.1 * normal * math.tanh(slip / 5e-3)
            push = normal * side * across + rubbing * side * distance  # on the lever
            angle_rate += place[0] * push[1] - place[1] * push[0] - pin * rubbing
        return [y[1], angle_rate / inertia]

    assert friction["coefficient"] == 0.1
    t, onsets, rate = 0.0, [], 0.0
    y = [math.atan2(-FOOT, CRANK_LENGTH), 0.0]
    place, distance, across, *_ = seen(0.0, y)
    y[1] = CRANK_LENGTH * SPEED * across[1] / (place @ distance)
    while t < end:

        def event(now, y, begin=t, touching=rate):
            return depth(now, y) if not touching or now > begin + 1e-9 else 1.0

        event.terminal, event.direction = True, -1.0 if rate else 1.0
        bins = 2e-5 if rate else 1e-3
        settings = {"method": "DOP853", "events": event, "rtol": 1e-11, "atol": 1e-15, "max_step": bins}
        done = solve_ivp(lambda now, y, rate=rate: slope(now, y, rate), (t, end), y, **settings)
        t, y = done.t[-1], done.y[:, -1]
        if done.status == 1:
            rate = 0.0 if rate else max(seen(t, y)[4], 1e-3)
            onsets += [(t, rate)] if rate else []
    return y, onsets


def test_a_lever_on_a_pin_moves_as_equations_of_its_own_say():
    source = grid(mechanism__gravity=9.81, simulate__tolerance=1e-10)
    source["joints"]["slot"]["contact"]["onset"] = "first"
    path = clearsweep.simulate(clearsweep.load_case(source), times=[0.0, 0.018])
    (angle, rate), onsets = rattled(0.018)
    begun = path.events[(path.events["kind"] == "on") & (path.events["t"] <= 0.018)]
    assert len(onsets) == 3
    np.testing.assert_allclose(begun["t"], [time for time, _ in onsets], rtol=1e-8)
    np.testing.assert_allclose(begun["rate"], [pace for _, pace in onsets], rtol=1e-6)
    assert path["lever/angle"][-1] == pytest.approx(angle, rel=1e-8)
    assert path["lever/rate"][-1] == pytest.approx(rate, rel=1e-7)
