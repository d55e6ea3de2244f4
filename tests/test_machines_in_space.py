"""Machines of any topology in space: their equations against those of the slider-crank, and against Lagrange's."""

import copy

import numpy as np
import pytest
from mechanism_cases import changed
from spatial_cases import JOINT, RPM, spatial

import clearsweep
from clearsweep import grid, simulation
from clearsweep.mechanics.joints.spatial import SpatialLoad
from clearsweep.mechanics.machines.contract import accelerate, energy, gaps, output_error, pose_at
from clearsweep.mechanics.machines.programs import kinds_of
from clearsweep.tracing.compiled.vector import Vector, to_fixed_frame

GRAVITY = [1.0, -9.81, 3.0]
SKEW = {"tilt": [0.004, 0.002], "offset": [1e-5, 2e-5, 3e-5]}


def body(mass, inertia, center, **points):
    return {"mass": mass, "inertia": inertia, "center": center, "points": points}


CRANK = body(0.3, [1e-4] * 3, [0.025, 0.0, 0.0], pivot=[0.0, 0.0, 0.0], pin=[0.05, 0.0, 0.0])
ROD = body(0.21, [2e-5, 2.5e-4, 2.5e-4], [0.06, 0.0, 0.0], big=[0.0, 0.0, 0.0], small=[0.12, 0.0, 0.0])
ROCKER = body(0.25, [2e-5, 2.2e-4, 2.1e-4], [0.05, 0.002, 0.004], foot=[0.0, 0.0, 0.0], pin=[0.1, 0.0, 0.001])


def planar_in_space(bodies, joints, opened, ideal, **more):
    """Return a grid dict of a `planar` mechanism in space."""
    mechanism = {
        "type": "planar",
        "spatial": True,
        "gravity": GRAVITY,
        "bodies": copy.deepcopy(bodies),
        "joints": {name: {"type": "revolute"} | joint for name, joint in joints.items()},
        "driven": "main",
    }
    return {
        "mechanism": mechanism | ({"ideal": ideal} if ideal else {}) | more,
        "drive": {"speed": 1000 * RPM},
        "joints": {name: copy.deepcopy(JOINT | SKEW) for name in opened},
        "simulate": {"revolutions": 0.5, "discard": 0, "tolerance": 1e-12},
        "save": {"orbits": "none"},
    }


def slider_crank(*opened, ideal=""):
    """Return the slider-crank of `spatial_cases` as a machine of bodies and joints."""
    bodies = {
        "ground": {"points": {"main": [0.0, 0.0, 0.0], "rail": [0.0, 0.0, 0.0]}},
        "crank": CRANK,
        "rod": ROD,
        "slider": body(0.14, [1e-4] * 3, [0.0, 0.0, 0.0], pin=[0.0, 0.0, 0.0]),
    }
    joints = {
        "main": {"between": ["ground.main", "crank.pivot"]},
        "crank-rod": {"between": ["crank.pin", "rod.big"]},
        "rod-slider": {"between": ["rod.small", "slider.pin"], "journal": "rod"},
        "guide": {"type": "prismatic", "between": ["ground.rail", "slider.pin"], "axis": 0.0},
    }
    closed = {name: ideal for name in ("crank-rod", "rod-slider") if name not in opened}
    output = {"body": "slider", "point": "pin", "along": 0.0}
    return planar_in_space(bodies, joints, opened, closed, output=output)


def four_bar(*opened, **ideal):
    """Return a four-bar whose rocker is wider than its pins are long."""
    bodies = {
        "ground": {"points": {"main": [0.0, 0.0, 0.0], "foot": [0.13, 0.0, -0.001]}},
        "crank": CRANK,
        "coupler": ROD,
        "rocker": ROCKER,
    }
    joints = {
        "main": {"between": ["ground.main", "crank.pivot"]},
        "crank-coupler": {"between": ["crank.pin", "coupler.big"]},
        "coupler-rocker": {"between": ["coupler.small", "rocker.pin"]},
        "rocker-ground": {"between": ["rocker.foot", "ground.foot"]},
    }
    allowed = {name.replace("_", "-"): word for name, word in ideal.items()}
    output = {"body": "rocker", "point": "pin", "along": 0.3}
    start = {"coupler": 0.9, "rocker": 1.6}
    return planar_in_space(bodies, joints, opened, allowed, output=output, start=start)


def stirred(scene, seed):
    """Return a state in which all of a scene moves, near its start."""
    random, n = np.random.default_rng(seed), len(scene.built.lengths)
    state = scene.start[: 2 * n + 1].copy()
    state[:n] += 1e-2 * random.standard_normal(n)
    state[n : 2 * n] += random.standard_normal(n)
    state[2 * n] = 0.0123
    return state


def loads(count, seed=5):
    """Return made-up loads of spatial joints."""
    random = np.random.default_rng(seed)
    three = [[Vector(*(size * random.standard_normal(3))) for size in (100.0, 1.0, 1.0)] for _ in range(count)]
    return tuple(SpatialLoad(*each, ()) for each in three)


@pytest.mark.few("opened0-spherical", "opened1-spherical", "opened2-")
@pytest.mark.parametrize(
    ("opened", "ideal"),
    [
        (("crank-rod",), "spherical"),
        (("rod-slider",), "spherical"),
        (("crank-rod", "rod-slider"), ""),
        (("crank-rod",), "cylindrical"),
    ],
)
def test_a_slider_crank_of_bodies_and_joints_is_the_slider_crank(opened, ideal):
    case = spatial(*opened, ideal=ideal or "spherical", **SKEW)
    case["mechanism"]["gravity"] = GRAVITY
    known, result = clearsweep.load_case(case), clearsweep.load_case(slider_crank(*opened, ideal=ideal))
    first, other = result.value.mechanism, known.value.mechanism
    assert kinds_of(first) == kinds_of(other)
    assert (first.attachments, first.openings, first.aim, first.speed, first.gravity) == (
        (other.attachments, other.openings, other.aim, other.speed, other.gravity)
    )
    still = Vector(1e-4, 1e-4, 1e-4)  # inertia of the slider, which does not turn
    assert [part._replace(inertia=still) if part.mass == 0.14 else part for part in first.parts] == [
        part._replace(inertia=still) if part.mass == 0.14 else part for part in other.parts
    ]
    assert result.start == pytest.approx(known.start, rel=1e-12, abs=1e-13)


def moved_by(state, n, accelerations, h):
    """Return a state a moment h (s) later, to first order."""
    later = state.copy()
    later[:n] += h * state[n : 2 * n]
    later[n : 2 * n] += h * np.array(accelerations)
    later[2 * n] += h
    return later


def lagrange(mechanism, state, n, accelerations, acting):
    """Return what Lagrange's equations leave over, from energies, placements and gaps alone, by differences.

    A coordinate's generalised force is the derivative of the power by its rate, which is linear in the rates as the
    momenta are: differences by rates are exact.
    """

    def kinetic(y):
        return energy(mechanism, pose_at(mechanism, y))[0]

    def power(y):
        pose = pose_at(mechanism, y)
        total = energy(mechanism, pose)[1]
        for gap, load in zip(gaps(mechanism, pose), acting, strict=True):
            total += np.dot(load.force, gap.velocity)
            total += np.dot(load.journal_moment, gap.journal_spin) + np.dot(load.bearing_moment, gap.bearing_spin)
        return total

    def slope(function, i, at, size):
        moved = [at.copy(), at.copy()]
        moved[0][i] -= size
        moved[1][i] += size
        return (function(moved[1]) - function(moved[0])) / (2.0 * size)

    def momenta(y):
        return np.array([slope(kinetic, n + i, y, 1.0) for i in range(n)])

    upcoming, behind = moved_by(state, n, accelerations, 1e-6), moved_by(state, n, accelerations, -1e-6)
    changing = (momenta(upcoming) - momenta(behind)) / 2e-6
    forces = np.array([slope(power, n + i, state, 1.0) for i in range(n)])
    moved = np.array([slope(kinetic, i, state, 1e-5) for i in range(n)])
    return changing - moved - forces, np.abs(changing) + np.abs(moved) + np.abs(forces)


CHAINS = {
    "ball on the rocker": four_bar("crank-coupler", coupler_rocker="spherical"),
    "ball on the crank": four_bar("coupler-rocker", crank_coupler="spherical"),
    "sleeve on the crank": four_bar("coupler-rocker", crank_coupler="cylindrical"),
    "rocker on a sleeve": four_bar("crank-coupler", rocker_ground="cylindrical"),
    "hinge on a ball": four_bar("rocker-ground", crank_coupler="spherical"),
    "sleeve on a ball": four_bar("rocker-ground", crank_coupler="spherical", coupler_rocker="cylindrical"),
    "two open": four_bar("crank-coupler", "coupler-rocker"),
    "three open": four_bar("crank-coupler", "coupler-rocker", "rocker-ground"),
    "slider on a hinge": slider_crank("crank-rod", ideal="spherical"),
}


@pytest.mark.parametrize("name", CHAINS)
def test_bodies_that_hang_in_any_way_obey_lagranges_equations(name):
    scene = clearsweep.load_case(CHAINS[name])
    mechanism, n = scene.value.mechanism, len(scene.built.lengths)
    state, acting = stirred(scene, 4), loads(len(scene.value.joints))
    pose = pose_at(mechanism, state)
    motion = accelerate(mechanism, pose, acting)
    left, size = lagrange(mechanism, state, n, motion.accelerations, acting)
    assert np.all(np.abs(left) <= 1e-7 * size.max())
    wrong, _ = lagrange(mechanism, state, n, 1.001 * np.array(motion.accelerations), acting)
    assert np.abs(wrong).max() > 1e-5 * size.max()
    later, before = (moved_by(state, n, motion.accelerations, h) for h in (1e-6, -1e-6))
    gain = (energy(mechanism, pose_at(mechanism, later))[0] - energy(mechanism, pose_at(mechanism, before))[0]) / 2e-6
    outside = energy(mechanism, pose)[1] + motion.torque * scene.case.drive.speed
    for gap, load in zip(gaps(mechanism, pose), acting, strict=True):
        outside += np.dot(load.force, gap.velocity)
        outside += np.dot(load.journal_moment, gap.journal_spin) + np.dot(load.bearing_moment, gap.bearing_spin)
    assert gain == pytest.approx(outside, rel=1e-6, abs=1e-6 * abs(outside))  # the crank's row is the torque's


def test_the_start_is_that_of_the_planar_machine():
    scene = clearsweep.load_case(four_bar("crank-coupler", coupler_rocker="spherical"))
    pose = pose_at(scene.value.mechanism, scene.start)
    (gap,) = gaps(scene.value.mechanism, pose)
    offset = np.array([1e-5, 2e-5, 3e-5])
    assert np.linalg.norm(to_fixed_frame(pose.frames[2], gap.middle)[:2]) == pytest.approx(
        np.linalg.norm(offset[:2]), rel=1e-6
    )
    closed = np.linalg.norm(np.cross([0.0, 0.0, scene.case.drive.speed], offset))  # only the offset's own turning
    assert np.linalg.norm(gap.velocity) == pytest.approx(closed, rel=1e-6)
    assert output_error(scene.value.mechanism, pose) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert simulation.ideal_peaks(scene.case)["crank-coupler"] > 10.0


@pytest.mark.slow
def test_a_slider_crank_of_bodies_and_joints_moves_as_the_slider_crank():
    times = np.linspace(0.0, 0.03, 21)
    case = spatial("crank-rod", **SKEW)
    case["mechanism"]["gravity"] = GRAVITY
    known, result = (
        clearsweep.simulate(clearsweep.load_case(each), times=times)
        for each in (case, slider_crank("crank-rod", ideal="spherical"))
    )
    assert result.status == "ok"
    for name in ("rod/x", "rod/y", "rod/z", "slider/x", "joints/crank_rod/x", "joints/crank_rod/z"):
        assert result[name] == pytest.approx(known[name], rel=0.0, abs=1e-9)
    assert list(result.events["joint"]) == list(known.events["joint"])
    assert result.events["t"] == pytest.approx(known.events["t"], rel=0.0, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("opened", [("crank-coupler",), ("crank-coupler", "coupler-rocker")])
def test_a_four_bar_in_space_loses_nothing_where_impacts_give_all_back(opened):
    ideal = {"coupler_rocker": "spherical"} if len(opened) == 1 else {}
    case = four_bar(*opened, **ideal)
    for name in opened:
        case["joints"][name]["contact"]["restitution"] = 1.0
    result = clearsweep.simulate(clearsweep.load_case(case), times=[0.03])
    assert result.status == "ok"
    assert len(result.events) > 10
    assert result.summary["energy_residual"] < 1e-11


def test_a_planar_grid_keeps_its_keys_and_one_in_space_its_cases():
    flat = grid.load(clearsweep_four_bar(), simulation.catalogue())
    assert "spatial" not in flat.written_case(0)["mechanism"]
    case = changed(
        four_bar("crank-coupler", coupler_rocker="spherical"), {"sweep": {"joints.crank-coupler.tilt.0": [0.0, 0.002]}}
    )
    first = grid.load(case, simulation.catalogue())
    again = grid.load(first.resolved(), simulation.catalogue())
    assert [first.case_id(k) for k in range(2)] == [again.case_id(k) for k in range(2)]
    layout = clearsweep.load_case(four_bar("crank-coupler", coupler_rocker="spherical")).layout
    names = {channel.name for channel in layout.channels}
    assert {"coupler/qw", "rocker/wz", "joints/crank_coupler/tilt", "output/acceleration"} <= names


def clearsweep_four_bar():
    """Return a four-bar in the plane of which the grid names bodies and joints."""
    case = four_bar("crank-coupler")
    mechanism = case["mechanism"]
    del mechanism["spatial"]
    mechanism["gravity"] = 9.81
    for name, part in mechanism["bodies"].items():
        part["points"] = {point: at[:2] for point, at in part["points"].items()}
        if name != "ground":
            part |= {"inertia": part["inertia"][2], "center": part["center"][:2]}
    keys = {key: JOINT[key] for key in ("clearance", "bearing_radius", "length", "contact")}
    return case | {"joints": {"crank-coupler": keys}}
