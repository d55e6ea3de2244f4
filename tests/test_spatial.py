"""Joints in space, and the slider-crank whose rod moves in it."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from mechanism_cases import changed
from scipy.integrate import solve_ivp
from scipy.special import ellipj
from spatial_cases import JOINT, limb, planar, spatial
from spatial_oracle import Oracle

import clearsweep
from clearsweep import grid, simulation
from clearsweep.mechanics.joints import spatial as joints
from clearsweep.mechanics.joints.contract import JointState, Offsets, contact_modes, load, power_lost, power_stored
from clearsweep.mechanics.joints.spatial import farthest_direction
from clearsweep.mechanics.laws.contract import ACTS, FREE, PRESSED
from clearsweep.mechanics.machines.contract import accelerate, energy, gaps, pose_at
from clearsweep.mechanics.machines.spatial.form import Loose, Slide
from clearsweep.tracing.compiled.vector import Frame, Vector, frame_of, to_body_frame, to_fixed_frame

FRICTION = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}
EDGES = {"flange": False, "axial_clearance": None, "journal_length": 0.03}
OPENINGS = {
    "ball on the slider": (("crank-rod",), {"tilt": [0.005, 0.003], "offset": [1e-5, 2e-5, 6e-5]}),
    "ball on the crank": (("rod-slider",), {"tilt": [0.004, -0.006], "offset": [2e-5, 0.0, -5e-5]}),
    "both open": (("crank-rod", "rod-slider"), {"tilt": [0.002, 0.001]}),
    "sleeve on the slider": (("crank-rod",), {"ideal": "cylindrical", "tilt": [0.006, 0.0]}),
    "sleeve on the crank": (("rod-slider",), {"ideal": "cylindrical", "tilt": [0.0, 0.005]}),
    "edges": (("crank-rod",), EDGES | {"tilt": [0.005, 0.003]}),
    "spread, both open": (("crank-rod", "rod-slider"), {"tilt": [0.002, 0.001], "walls": "spread"}),
    "spread, sleeve on the crank": (
        ("rod-slider",),
        {"ideal": "cylindrical", "tilt": [0.0, 0.005], "walls": "spread"},
    ),
    "spread, edges": (("crank-rod",), EDGES | {"tilt": [0.005, 0.003], "walls": "spread"}),
    "spread, part of the length": (
        ("crank-rod",),
        EDGES | {"journal_length": 0.02, "offset": [0.0, 0.0, 4e-3], "tilt": [0.005, 0.003], "walls": "spread"},
    ),
}


def reference():
    """Return the trajectory that was integrated in quadruple precision."""
    file = Path(clearsweep.__file__).parent / "verify" / "references" / "spatial.json"
    return json.loads(file.read_text(encoding="utf-8"))


def built(name):
    """Return a scene of OPENINGS, with gravity and friction."""
    opened, keys = OPENINGS[name]
    case = spatial(*opened, friction=FRICTION, **keys)
    case["mechanism"]["gravity"] = [1.0, -9.81, 3.0]
    return clearsweep.load_case(case)


def stirred(scene, seed=3):
    """Return the state of a scene in a pose that it never takes by itself, all of it moving."""
    random = np.random.default_rng(seed)
    n = len(scene.built.lengths)
    state = scene.start.copy()
    state[:n] += 2e-5 * random.standard_normal(n) / scene.built.lengths
    state[n : 2 * n] += 0.5 * random.standard_normal(n) / scene.built.lengths
    return state


def pressed(scene, state):
    """Return the Present of a state in which all contact points press that are deep, and the state with its roots."""
    value, place_of = scene.value, 2 * len(scene.value.coordinates) + 1
    pose = pose_at(value.mechanism, state)
    modes, rates = [], []
    for joint, gap in zip(value.joints, gaps(value.mechanism, pose), strict=True):
        first = len(modes)
        for point in points(joint, gap):
            c = len(modes)
            modes.append(PRESSED if point.depth > 0.0 else contact_modes(joint)[c - first].apart)
            state[place_of + c] = math.copysign(math.sqrt(abs(point.depth)), point.depth)
        modes += [ACTS, ACTS]
    rates = np.full(len(modes), 0.1)
    return JointState(state, np.array(modes), rates, place_of), state


def points(joint, gap):
    """Return the Points of a joint."""
    flanges = joints.ENDS if isinstance(joint, joints.Flanged) else ()
    walls = [joints.wall_point(joint.end_type, joint, gap, end) for end in joints.ENDS]
    return walls + [joints.flange_point(joint, gap, end) for end in flanges]


def loads_of(scene, present):
    """Return pose and loads of a scene whose joints are one behind the other in the state."""
    pose, first, result = pose_at(scene.value.mechanism, present.y), 0, []
    for joint, gap in zip(scene.value.joints, gaps(scene.value.mechanism, pose), strict=True):
        result.append(load(joint, gap, Offsets(first, 0, 0, 0), present))
        first += len(result[-1].contacts)
    return pose, tuple(result)


# ---------------------------------------------------------------------------------------------- geometry


@pytest.mark.parametrize("radius", [9.5e-3, -10e-3])
@pytest.mark.parametrize("lean", [0.0, 1e-3, 0.05, 0.4])
def test_the_farthest_point_of_a_leaning_circle_is_where_a_search_finds_it(radius, lean):
    random, angles = np.random.default_rng(7), np.linspace(0.0, 2.0 * np.pi, 200_001)
    d = np.array([np.cos(angles), np.sin(angles)])
    for _ in range(5):
        p, k = 2e-4 * random.standard_normal(2), lean * random.standard_normal(2) / math.sqrt(2.0)
        values = p @ d - 0.5 * radius * (k @ d) ** 2
        result = np.array(farthest_direction(*p, *k, radius))
        assert result @ result == pytest.approx(1.0, rel=1e-14, abs=0.0)
        assert p @ result - 0.5 * radius * (k @ result) ** 2 >= values.max() * (1.0 - 1e-9) - 1e-18


def test_a_journal_jams_at_the_tilt_that_its_sizes_give():
    sizes = {"bearing_radius": 0.01, "clearance": 0.5e-3, "length": 0.02}
    (joint,) = clearsweep.load_case(spatial(**sizes)).value.joints
    assert math.degrees(joints.jam_angle(joint)) == pytest.approx(2.93760, rel=2e-6, abs=0.0)
    (short,) = clearsweep.load_case(spatial(**sizes | {"length": 0.004})).value.joints
    assert joints.jam_angle(short) == math.inf


@pytest.mark.parametrize("ends", [{}, EDGES])
def test_at_the_tilt_that_jams_both_walls_just_touch(ends):
    (joint,) = clearsweep.load_case(spatial(**ends)).value.joints
    angle = joints.jam_angle(joint)
    axis = Vector(math.sin(angle) * 0.6, math.sin(angle) * 0.8, math.cos(angle))
    still = Vector(0.0, 0.0, 0.0)
    gap = joints.SpatialGap(still, still, axis, still, still, None)
    for end in joints.ENDS:
        assert abs(joints.wall_point(joint.end_type, joint, gap, end).depth) < 1e-16


@pytest.mark.parametrize("name", OPENINGS)
def test_rates_of_depth_are_the_slopes_of_depth(name):
    scene = built(name)
    state, n, h = stirred(scene), len(scene.built.lengths), 3e-9
    roots = 2 * n + 1
    present = JointState(state, np.full(12, FREE), np.full(12, 1e-3), roots)
    _, result = loads_of(scene, present)
    ends = []
    for sign in (-1.0, 1.0):
        moved = state.copy()
        moved[:n] += sign * h * state[n : 2 * n]
        moved[2 * n] += sign * h
        relative = gaps(scene.value.mechanism, pose_at(scene.value.mechanism, moved))
        ends.append([points(*pair) for pair in zip(scene.value.joints, relative, strict=True)])
    for message, before, after in zip(result, *ends, strict=True):
        for contact, a, b in zip(message.contacts, before, after, strict=False):
            assert contact.rate == pytest.approx((b.depth - a.depth) / (2.0 * h), rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("name", OPENINGS)
def test_the_powers_of_all_forces_make_the_kinetic_energy(name):
    scene = built(name)
    state, n, h = stirred(scene, 5), len(scene.built.lengths), 1e-6
    state[limb(scene, Slide)[1]] += 3.2e-4  # deep in the walls
    present, state = pressed(scene, state)
    assert np.count_nonzero(present.mode == PRESSED) >= 1
    pose, result = loads_of(scene, present)
    motion = accelerate(scene.value.mechanism, pose, result)
    power = motion.torque * scene.built.rate + energy(scene.value.mechanism, pose)[1]
    for message in result:
        for contact in message.contacts:
            power += contact.tangential * contact.slip - power_stored(contact) - power_lost(contact)
    ends = []
    for sign in (-1.0, 1.0):
        moved = state[: 2 * n + 1].copy()
        v, a = state[n : 2 * n], np.array(motion.accelerations)
        moved[:n] += sign * h * v + 0.5 * h * h * a
        moved[n : 2 * n] += sign * h * a
        moved[2 * n] += sign * h
        ends.append(energy(scene.value.mechanism, pose_at(scene.value.mechanism, moved))[0])
    assert (ends[1] - ends[0]) / (2.0 * h) == pytest.approx(
        power, rel=1e-6, abs=1e-6 * abs(motion.torque * scene.built.rate)
    )


# ---------------------------------------------------------------------------------------------- what does not change


def seen(turn, bearing, journal, middle, walls="ends"):
    """Return the load of a joint in the fixed frame, all of it turned by `turn`; the rest as rotation matrices."""
    (joint,) = clearsweep.load_case(spatial(friction=FRICTION, walls=walls)).value.joints
    frame = Frame(*(Vector(*row) for row in turn @ journal))
    at, axis = turn @ middle, turn @ bearing[:, 2]
    moving, spin, other = turn @ [0.02, 0.1, -0.3], turn @ [1.0, 5.0, -40.0], turn @ [0.0, 0.0, 100.0]
    gap = joints.SpatialGap(*(to_body_frame(frame, Vector(*v)) for v in (at, moving, axis, other, spin)), frame)
    y = np.zeros(12)
    for c, point in enumerate(points(joint, gap)):
        y[c] = math.copysign(math.sqrt(abs(point.depth)), point.depth)
    modes = [
        pair.pressed if root > 0.0 else pair.apart for root, pair in zip(y[:4], contact_modes(joint), strict=False)
    ]
    mode = np.array(modes + [ACTS] * 2)
    message = load(joint, gap, Offsets(0, 0, 0, 0), JointState(y, mode, np.full(6, 0.1), 0))
    sides = (message.force, message.journal_moment, message.bearing_moment)
    return mode, np.array([np.array(to_fixed_frame(frame, side)) @ turn for side in sides]), message.contacts


def turned(*vector):
    """Return the rotation matrix of a rotation vector."""
    angle = np.linalg.norm(vector)
    half = math.sin(0.5 * angle) / angle
    return np.array(frame_of(math.cos(0.5 * angle), *(half * x for x in vector)))


ACCEPTED = (turned(0.004, 0.003, 0.0), turned(-0.006, 0.002, 0.7), np.array([1.9e-4, 0.8e-4, 1.8e-4]))


@pytest.mark.parametrize("walls", ["ends", "spread"])
@pytest.mark.parametrize("about", [(0.3, -0.2, 1.1), (0.0, 0.0, 2.0), (3.0, 0.5, -0.2)])
def test_nothing_changes_when_the_whole_assembly_is_turned(about, walls):
    mode, before, _ = seen(np.eye(3), *ACCEPTED, walls)
    _, after, _ = seen(turned(*about), *ACCEPTED, walls)
    assert np.count_nonzero(mode == PRESSED) >= 2
    assert after == pytest.approx(before, rel=1e-10, abs=1e-10 * np.abs(before).max())


@pytest.mark.parametrize("walls", ["ends", "spread"])
def test_nothing_changes_when_the_journal_is_turned_about_its_own_axis(walls):
    bearing, journal, middle = ACCEPTED
    _, before, _ = seen(np.eye(3), *ACCEPTED, walls)
    _, after, _ = seen(np.eye(3), bearing, journal @ turned(0.0, 0.0, 0.9), middle, walls)
    assert after == pytest.approx(before, rel=1e-10, abs=1e-10 * np.abs(before).max())


@pytest.mark.parametrize("walls", ["ends", "spread"])
@pytest.mark.parametrize("ends", [0, 1])
def test_nothing_changes_when_the_axis_of_a_body_is_turned_round(ends, walls):
    bearing, journal, middle = ACCEPTED
    round_ = turned(math.pi, 0.0, 0.0)
    sides = (bearing @ round_, journal) if ends == 0 else (bearing, journal @ round_)
    _, before, contacts = seen(np.eye(3), *ACCEPTED, walls)
    _, after, others = seen(np.eye(3), *sides, middle, walls)
    assert after == pytest.approx(before, rel=1e-10, abs=1e-10 * np.abs(before).max())
    order = (0, 1, 2, 3) if ends == 0 else (1, 0, 3, 2)  # contacts are numbered by the ends of the journal
    for k, other in enumerate(order):
        assert others[other].normal == pytest.approx(contacts[k].normal, rel=1e-9, abs=1e-9)


def test_a_free_body_turns_as_the_elliptic_functions_say():
    inertia, spin = (1.2e-4, 2.0e-4, 2.7e-4), (40.0, 0.0, 60.0)
    case = spatial("crank-rod", "rod-slider")
    case["mechanism"]["rod"]["inertia"] = list(inertia)
    scene = clearsweep.load_case(case)
    mechanism, n = scene.value.mechanism, len(scene.built.lengths)
    zero = Vector(0.0, 0.0, 0.0)
    nothing = joints.SpatialLoad(zero, zero, zero, ())

    def rates(t, y):
        pose = pose_at(mechanism, np.append(y, t))
        return np.concatenate([y[n:], accelerate(mechanism, pose, (nothing, nothing)).accelerations])

    start = scene.start[: 2 * n].copy()
    long = 1.3  # of a quaternion whose length has no meaning
    body, first = limb(scene, Loose)
    rod = slice(first, first + 4)
    start[: 2 * n].reshape(2, n)[:, rod] = [[long, 0.0, 0.0, 0.0], [0.0, *(0.5 * long * w for w in spin)]]
    times = np.linspace(0.0, 0.4, 41)
    path = solve_ivp(rates, (0.0, 0.4), start, "DOP853", times, rtol=1e-12, atol=1e-13).y.T
    a, b, c = inertia
    twice = sum(i * w * w for i, w in zip(inertia, spin, strict=True))
    square = sum((i * w) ** 2 for i, w in zip(inertia, spin, strict=True))
    pace = math.sqrt((c - b) * (square - twice * a) / (a * b * c))
    sn, cn, dn, _ = ellipj(times * pace, (b - a) * (twice * c - square) / ((c - b) * (square - twice * a)))
    known = np.array(
        [
            math.sqrt((twice * c - square) / (a * (c - a))) * cn,
            math.sqrt((twice * c - square) / (b * (c - b))) * sn,
            math.sqrt((square - twice * a) / (c * (c - a))) * dn,
        ]
    ).T
    poses = [pose_at(mechanism, np.append(y, 0.0)) for y in path]
    frames, spins = [pose.frames[body] for pose in poses], [pose.spins[body] for pose in poses]
    result = np.array([to_body_frame(*pair) for pair in zip(frames, spins, strict=True)])
    assert result == pytest.approx(known, rel=1e-9, abs=1e-9 * 60.0)
    momentum = np.array(
        [to_fixed_frame(frame, Vector(*(inertia * w))) for frame, w in zip(frames, result, strict=True)]
    )
    assert momentum == pytest.approx(np.tile(momentum[0], (41, 1)), rel=1e-9, abs=1e-9 * np.linalg.norm(momentum[0]))
    assert np.linalg.norm(path[-1, rod]) == pytest.approx(1.0, rel=1e-9, abs=0.0)


# ---------------------------------------------------------------------------------------------- whole motions


def compared(result, known):
    """Assert that events and time histories are those of the reference, as far as `found` goes."""
    samples, count = known["samples"], len(result.t)
    for kind, name in (("com", "rod/{}"), ("velocity", "rod/v{}"), ("omega", "rod/w{}")):
        there = np.array(samples[f"rod/{kind}"])[:count]
        here = np.array([result[name.format(axis)] for axis in "xyz"]).T
        assert here == pytest.approx(there, rel=1e-6, abs=1e-6 * np.abs(there).max()), kind
    turns = np.array(
        [np.ravel(np.array(frame_of(*q)).T) for q in zip(*(result[f"rod/q{k}"] for k in "wxyz"), strict=True)]
    )
    assert turns == pytest.approx(np.array(samples["rod/R_columns"])[:count], rel=0.0, abs=1e-9)
    for name, key in (("slider/x", "slider/x"), ("slider/a", "slider/a"), ("crank/torque", "crank/torque")):
        there = np.array(samples[key])[:count]
        assert result[name] == pytest.approx(there, rel=1e-6, abs=1e-6 * np.abs(there).max()), name
    gap = np.array([result[f"joints/crank_rod/{axis}"] for axis in "xyz"]).T
    assert gap == pytest.approx(np.array(samples["gap"])[:count], rel=0.0, abs=1e-6 * 2e-4)
    assert result["joints/crank_rod/tilt"] == pytest.approx(np.array(samples["tilt"])[:count], rel=1e-6, abs=1e-10)
    for k in range(4):
        there = np.array(samples["points"][f"crank_rod_{k + 1}"]["force_normal"])[:count]
        assert result[f"joints/crank_rod/force_normal_{k + 1}"] == pytest.approx(there, rel=1e-6, abs=1e-6 * 900.0)
    last = result.t[-1] if count else 0.0
    events = [event for event in known["events"] if event["t"] <= last]
    assert [(e["joint"], e["kind"]) for e in result.events] == [(e["joint"], e["kind"]) for e in events]
    for here, there in zip(result.events, events, strict=True):
        assert here["t"] == pytest.approx(there["t"], rel=0.0, abs=1e-10)
        assert here["rate"] == pytest.approx(there["rate"], rel=1e-6, abs=1e-8)
        assert here["force_peak"] == pytest.approx(there["force_peak"], rel=1e-6, abs=0.0)


@pytest.mark.heavy
def test_half_a_revolution_is_that_of_quadruple_precision():
    known = reference()
    result = clearsweep.simulate(clearsweep.load_case(known["grid"]), times=known["samples"]["t"])
    assert result.status == "ok"
    assert result.summary["energy_residual"] < 1e-12
    compared(result, known)
    tilt = np.array(known["samples"]["tilt"]).max()
    summary = result.summary
    assert tilt < summary["crank_rod_tilt_max"] < summary["crank_rod_tilt_limit"] + 0.002
    peaks = [(event["joint"], event["force_peak"]) for event in known["events"]]
    axial = max(force for joint, force in peaks if joint in ("crank_rod_3", "crank_rod_4"))
    assert summary["crank_rod_axial_force_peak"] == pytest.approx(axial, rel=1e-6, abs=0.0)
    onsets = [event["joint"][-1] for event in known["events"] if event["kind"] == "on"]
    assert summary["crank_rod_impacts_per_rev"] == 2 * sum(end in "12" for end in onsets)
    assert summary["crank_rod_axial_impacts_per_rev"] == 2 * sum(end in "34" for end in onsets)
    assert 0.0 < summary["crank_rod_edge_load_share"] < 1.0


def lasting_events(events):
    """Return the times of events without contacts and flights as short as rounding.

    Of two walls that are left at once, one may be touched again before the other is left.
    """
    times = []
    for joint in np.unique(events["joint"]):
        kept = []
        for time in events["t"][events["joint"] == joint]:
            if kept and time - kept[-1] < 1e-11:
                kept.pop()
            else:
                kept.append(time)
        times += kept
    return sorted(times)


@pytest.mark.slow
@pytest.mark.parametrize("walls", ["ends", "spread"])
def test_a_parallel_journal_moves_as_in_the_plane(walls):
    keys = {"contact": JOINT["contact"] | {"restitution": 0.4}, "wear": {"law": "archard", "coefficient": 1e-13}}
    times = np.linspace(0.0, 0.03, 31)
    flat, deep = (
        clearsweep.simulate(clearsweep.load_case(case), times=times)
        for case in (planar(**keys), spatial(**keys, walls=walls))
    )
    for name in ("slider/x", "joints/crank_rod/x", "joints/crank_rod/y"):
        assert deep[name] == pytest.approx(flat[name], rel=0.0, abs=1e-9 * 2e-4)
    force = "joints/crank_rod/force_normal"
    assert deep[force] == pytest.approx(flat[force], rel=1e-9, abs=1e-9 * flat[force].max())
    assert np.abs(deep["joints/crank_rod/tilt"]).max() < 1e-12
    assert np.abs(deep["rod/z"]).max() < 1e-15
    worn = ("wear_volume", "wear_bins_enough")
    for name in ("force_peak", "force_rms", "penetration_max", "contact_fraction", "force_peak_ideal", *worn):
        assert deep.summary[f"crank_rod_{name}"] == pytest.approx(flat.summary[f"crank_rod_{name}"], rel=1e-9, abs=0.0)
    depths = [made.summary["crank_rod_wear_depth_max"] for made in (deep, flat)]
    assert depths[0] == pytest.approx(depths[1], rel=1e-7, abs=0.0)  # where a contact passes the edges of bins
    assert deep.summary["slider_error_max"] == pytest.approx(flat.summary["slider_error_max"], rel=1e-9, abs=0.0)
    twice = [event for event in flat.events["t"] for _ in range(2)]  # both walls meet it together
    assert lasting_events(deep.events) == pytest.approx(twice, rel=0.0, abs=1e-10)
    assert deep.summary["crank_rod_edge_load_share"] < 1e-9
    for here, there in zip(deep.wear["crank_rod"], flat.wear["crank_rod"], strict=True):
        assert here == pytest.approx(np.tile(there[:, None], (1, 20)), rel=0.0, abs=1e-7 * there.max())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "joint", "changes"),
    [
        (
            "spatial_four_bar",
            "crank-coupler",
            {"joints.crank-coupler.contact.restitution": 0, "simulate.revolutions": 2, "drive.speed": "300 rpm"},
        ),
        (
            "spatial_slider_crank",
            "crank-rod",
            {
                "simulate.tolerance": 1e-12,
                "simulate.revolutions": 1,
                "drive.speed": "500 rpm",
                "joints.crank-rod.axial_clearance": "0.3 mm",
            },
        ),
    ],
)
def test_walls_of_a_parallel_journal_that_part_at_one_moment_leave_finite_figures(name, joint, changes):
    path = Path(__file__).parent.parent / "configs" / f"{name}.yaml"
    changes = changes | {"simulate.discard": 0, f"joints.{joint}.tilt.0": 0}
    result = clearsweep.simulate(clearsweep.load_case(path, changes))
    assert result.status == "ok"
    assert result.summary["energy_residual"] < 1e-7
    assert all(math.isfinite(value) for value in result.summary.values() if isinstance(value, float))
    for depths in result.wear.values():
        assert np.isfinite(depths).all()


@pytest.mark.heavy
def test_nothing_is_lost_where_impacts_give_all_back():
    case = spatial(contact=JOINT["contact"] | {"restitution": 1.0}, tilt=[0.005, 0.003], offset=[0.0, 0.0, 5e-5])
    result = clearsweep.simulate(clearsweep.load_case(case), times=[0.03])
    assert len(result.events) > 20
    assert result.summary["energy_residual"] < 1e-12
    sizes = np.linalg.norm([result[f"rod/q{k}"][-1] for k in "wxyz"])
    assert sizes == pytest.approx(1.0, rel=1e-14, abs=0.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("opened", "keys"),
    [
        (
            "crank-rod",
            {"tilt": [0.005, 0.003], "friction": {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-4, "v1": 1e-2}},
        ),
        ("rod-slider", EDGES | {"tilt": [0.004, -0.002], "offset": [2e-5, 1e-5, -1e-4]}),
        ("crank-rod", {"ideal": "cylindrical", "tilt": [0.006, 0.002], "offset": [0.0, 0.0, 6e-5]}),
    ],
    ids=("friction", "edges", "sleeve"),
)
def test_absolute_coordinates_with_multipliers_give_the_same_motion(opened, keys):
    case = spatial(opened, **keys)
    case["mechanism"]["gravity"] = [1.0, -9.81, 3.0]
    times = np.linspace(0.0, 0.03, 21)
    oracle = Oracle(case)
    states, normals, events = oracle.run(times)
    result = clearsweep.simulate(clearsweep.load_case(case), times=times)
    assert result.status == "ok"
    assert (
        pytest.approx(states[:, :3], rel=0.0, abs=1e-7 * 2e-4) == np.array([result[f"rod/{axis}"] for axis in "xyz"]).T
    )
    assert result["slider/x"] == pytest.approx(states[:, 3], rel=0.0, abs=1e-7 * 2e-4)
    spins = np.array([result[f"rod/w{axis}"] for axis in "xyz"]).T
    assert spins == pytest.approx(states[:, 16:], rel=0.0, abs=1e-7 * np.abs(states[:, 16:]).max())
    column = opened.replace("-", "_")
    for k in range(oracle.count):
        here = result[f"joints/{column}/force_normal_{k + 1}"]
        assert here == pytest.approx(normals[:, k], rel=0.0, abs=1e-7 * normals.max())
    assert [int(event["joint"][-1]) - 1 for event in result.events] == [k for _, k, _ in events]
    assert result.events["t"] == pytest.approx([t for t, _, _ in events], rel=0.0, abs=1e-9)


# ---------------------------------------------------------------------------------------------- grids

AT = "joints.crank-rod"


def test_one_quantity_represents_a_list_as_the_keys_say():
    case = changed(spatial(), {"mechanism.rod.center": 0.05, "mechanism.gravity": "9.81 m/s^2"})
    mechanism = clearsweep.load_case(case).value.mechanism
    assert (0.05, 0.0, 0.0) in [part.center for part in mechanism.parts]
    assert mechanism.gravity == (0.0, -9.81, 0.0)
    middle = changed(spatial(), {"mechanism.rod.center": None})
    assert (0.06, 0.0, 0.0) in [part.center for part in clearsweep.load_case(middle).value.mechanism.parts]


def test_a_grid_in_space_gives_the_same_cases_again_from_what_a_run_keeps():
    swept = changed(spatial(**EDGES), {"sweep": {f"{AT}.tilt.0": [0.0, 0.002], "drive.speed": [50.0, 60.0]}})
    first = grid.load(swept, simulation.catalogue())
    again = grid.load(first.resolved(), simulation.catalogue())
    assert [first.case_id(k) for k in range(4)] == [again.case_id(k) for k in range(4)]
    assert len({*first.identities()}) == 4
    assert first.case(3).joints[0].tilt == (0.002, 0.0)
    assert first.case(0).joints[0].flange is False


def test_a_grid_in_the_plane_has_no_key_more_than_before():
    case = grid.load(planar(), simulation.catalogue()).written_case(0)
    assert set(case["mechanism"]) == {"type", "crank", "rod", "slider", "gravity"}
    assert set(case["joints"]["crank-rod"]) == {"clearance", "bearing_radius", "length", "journal", "contact"}


def test_a_journal_in_space_has_its_points_as_contacts():
    scene = clearsweep.load_case(spatial("crank-rod", "rod-slider"))
    names = [name for name in scene.layout.contacts if name.startswith("crank_rod")]
    assert names[:4] == ["crank_rod_1", "crank_rod_2", "crank_rod_3", "crank_rod_4"]
    channels = {channel.name for channel in scene.layout.channels}
    assert {"rod/qw", "rod/wz", "joints/rod_slider/z", "joints/rod_slider/force_normal_4"} <= channels
    columns = {column.name for column in scene.layout.columns}
    assert {"crank_rod_tilt_max", "crank_rod_edge_load_share", "crank_rod_axial_force_peak"} <= columns
    through = clearsweep.load_case(spatial(**EDGES)).layout
    assert "crank_rod_axial_force_peak" not in {column.name for column in through.columns}
