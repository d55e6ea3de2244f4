"""Wear over angle and length: how a load is spread along a journal that leans, and that nothing of it is lost."""

import math

import numpy as np
import pytest
from mechanism_cases import changed
from spatial_cases import planar, spatial

import clearsweep
from clearsweep import grid, simulation
from clearsweep.language.errors import InputError
from clearsweep.mechanics.compiled.attitude import in_fixed
from clearsweep.mechanics.compiled.vector import Vector
from clearsweep.mechanics.joint.contract import FREE, PRESSED
from clearsweep.mechanics.joint.spatial import SpatialGap, wall_point
from clearsweep.mechanics.joint.wear import slices
from clearsweep.mechanics.joint.wear.contract import ACCOUNT, SLID, Bins
from clearsweep.mechanics.joint.wear.step import (
    ALONG,
    ANGLES,
    BEARING_START,
    FACING,
    JOURNAL_START,
    LEAN,
    ROOM,
    WHERE,
    Moment,
    Step,
    Worn,
    see,
    wear_joint,
)
from clearsweep.mechanics.mechanism.contract import body_angles, place
from clearsweep.mechanics.observe.between import BETWEEN
from clearsweep.mechanics.observe.histogram import COURSES, DEPTH_COURSE, FORCE, KAPPA_COURSE, PARTS, SLIP_COURSE

WEAR = {"law": "archard", "bearing_coefficient": 2e-13, "journal_coefficient": 1e-13, "bins": 90, "length_bins": 10}
EVEN = np.arange(PARTS + 1) / PARTS
STRIP = slices.Strip(0.01, 1e-3)


def joint_of(**keys):
    (joint,) = clearsweep.load_case(spatial(wear=WEAR | keys.pop("wear", {}), **keys)).value.joints
    return joint


def empty(joint):
    """Return a Step in which nothing happens, both walls pressed, and where its wear is entered."""
    stride = int(joint.wear.bins * joint.wear_rows)
    step = Step(
        np.zeros((6, COURSES, PARTS + 1)),
        1e-5,
        np.array([PRESSED, PRESSED, FREE, FREE, FREE, FREE]),
        np.zeros((6, WHERE, ANGLES)),
        np.zeros((6, ALONG, BETWEEN + 2)),
        np.zeros(PARTS + 1),
        np.zeros(ROOM),
        np.zeros(3 * stride),
    )
    return step, Worn(np.zeros(12 * stride), stride, np.zeros((6, ACCOUNT)))


def volumes(joint, worn):
    """Return what is worn off bearing and journal (m^3), and the depths (rows, bins) m of both."""
    shape = 2, int(joint.wear_rows), int(joint.wear.bins)
    depths = worn.depths[: math.prod(shape)].reshape(shape)
    cell = 2.0 * math.pi / shape[2] / shape[1]
    round_ = (2.0 * joint.half_length * joint.bearing_radius, 2.0 * joint.half_journal * joint.journal_radius)
    return [float(cell * size * each.sum()) for size, each in zip(round_, depths, strict=True)], depths


def test_the_load_goes_with_the_depth_along_the_strip():
    even = slices.Strip(0.01, 0.0)
    assert slices.covered(even, 1e-5) == 0.01
    assert slices.share_of(even, 1e-5, 0.002, 0.005) == pytest.approx(0.3, rel=1e-12)
    assert slices.covered(STRIP, 2e-6) == pytest.approx(2e-3, rel=1e-12)  # the depth is gone after 2 mm
    assert slices.share_of(STRIP, 2e-6, 0.0, 1e-3) == pytest.approx(0.75, rel=1e-12)  # of a triangle, its thicker half
    assert slices.share_of(STRIP, 2e-6, 2e-3, 1e-2) == 0.0
    deeper_inside = slices.Strip(0.01, -1e-3)
    assert slices.share_of(deeper_inside, 1e-5, 0.0, 5e-3) == pytest.approx((10 + 2.5) / (2 * (10 + 5)), rel=1e-12)
    assert slices.share_of(STRIP, 0.0, 0.0, 1e-4) == 1.0  # a point, where it begins


@pytest.mark.parametrize(
    ("begin", "end", "where"),
    [
        (-0.01, -0.008, {0: 1.0}),
        (-0.0085, -0.0065, {0: 0.25, 1: 0.75}),
        (0.009, 0.0105, {9: 0.75}),
        (0.0101, 0.0102, {9: 0.05}),
        (-0.012, -0.0079999999999, {0: 2.0}),
    ],
)
def test_a_slice_goes_to_the_bins_in_which_it_lies_and_what_is_beyond_an_end_to_the_last(begin, end, where):
    bins = Bins(np.zeros(30), 0, 3)
    slices.enter_along(np.array([1.0, 0.0, 2.0]), 1.0, bins, slices.Lies(begin, end, 0.01, 10))
    expected = np.zeros((10, 3))
    for row, part in where.items():
        expected[row] = part * np.array([1.0, 0.0, 2.0])
    assert bins.depths.reshape(10, 3) == pytest.approx(expected, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("pressure", ["mean", "hertz-line"])
@pytest.mark.parametrize("rows", [1, 7, 10])
@pytest.mark.parametrize("lean", [0.0, 1e-4, -1e-3, 8e-3])
def test_a_step_loses_nothing_however_the_journal_leans(pressure, rows, lean):
    keys = {"pressure": pressure, "length_bins": rows} | ({"pressure_modulus": 1e11} if pressure != "mean" else {})
    joint = joint_of(wear=keys)
    step, worn = empty(joint)
    load, slip, expected = 800.0 + 300.0 * EVEN, 0.8 + 0.1 * EVEN, 0.0
    for wall, share in ((0, 1.0), (1, 0.5)):
        step.course[wall, FORCE], step.course[wall, SLIP_COURSE] = share * load, slip * (1.0 - 2.0 * wall)
        step.course[wall, KAPPA_COURSE], step.course[wall, DEPTH_COURSE] = 1.0, 4e-6 * (1.0 + EVEN)
        quarters = np.arange(BETWEEN + 2) / (BETWEEN + 1)
        step.places[wall, 0, : BETWEEN + 2] = 0.3 + 0.02 * quarters + 3.0 * wall
        step.places[wall, 1, : BETWEEN + 2] = -3.0 - 0.3 * quarters
        end = 1.0 - 2.0 * wall
        step.along[wall, LEAN] = lean * (1.0 + 0.1 * quarters)
        step.along[wall, BEARING_START], step.along[wall, JOURNAL_START] = end * 0.01 + 1e-4, end * 0.01
        step.along[wall, FACING] = 1.0
        expected += share * step.length * (800.0 * 0.8 + (300.0 * 0.8 + 800.0 * 0.1) / 2.0 + 300.0 * 0.1 / 3.0)
    wear_joint(joint, 0, (step, worn))
    (bearing, journal), depths = volumes(joint, worn)
    pressed = 1.0 if pressure == "hertz-line" else bearing / (2e-13 * expected)  # theta0 / sin theta0, for each slice
    assert 1.0 <= pressed < 1.02
    assert bearing == pytest.approx(2e-13 * expected * pressed, rel=1e-9, abs=0.0)
    assert journal == pytest.approx(1e-13 * expected * pressed, rel=1e-9, abs=0.0)
    assert depths.min() >= 0.0
    assert np.all(step.scratch[: 2 * worn.stride] == 0.0)
    way = step.length * 0.85
    assert worn.account[:2, SLID] == pytest.approx([way, way], rel=1e-12)


def test_a_leaning_journal_wears_at_its_edge_and_a_parallel_one_evenly():
    joint = joint_of()
    for lean, rows in ((0.0, 5), (4e-3, 1)):  # 8 um deep: gone after one row
        step, worn = empty(joint)
        step.course[0, FORCE], step.course[0, SLIP_COURSE] = 1000.0, 1.0
        step.course[0, KAPPA_COURSE], step.course[0, DEPTH_COURSE] = 1.0, 8e-6
        step.along[0, LEAN], step.along[0, BEARING_START], step.along[0, JOURNAL_START] = lean, 0.01, 0.01
        step.along[0, FACING] = 1.0
        step.mode[1] = FREE
        wear_joint(joint, 0, (step, worn))
        (bearing, _), depths = volumes(joint, worn)
        along = depths[0].sum(axis=1) / depths[0].sum()
        assert along == pytest.approx(np.where(np.arange(10) >= 10 - rows, 1.0 / rows, 0.0), rel=1e-9, abs=0.0)
        assert bearing == pytest.approx(2e-13 * 1000.0 * 1e-5, rel=2e-2, abs=0.0)


@pytest.mark.parametrize("keys", [{}, {"flange": False, "axial_clearance": None, "journal_length": 0.03}])
def test_strips_begin_where_the_surfaces_are_deepest_and_lean_as_they_do(keys):
    """The slope of the depth along the body whose circle bears, by moving that circle along it."""
    joint = joint_of(**keys)
    axis = np.array([0.004, -0.003, 1.0])
    axis /= np.linalg.norm(axis)
    gap = SpatialGap(Vector(1.5e-4, 1e-4, 2e-4), None, Vector(*axis), None, None, None)
    step, _ = empty(joint)
    across = np.array([1.0, 0.0, -axis[0] / axis[2]])
    see(joint, gap, Vector(*(across / np.linalg.norm(across))), 0, Moment((), (), 0, step))
    for wall, end in enumerate((1.0, -1.0)):
        point = wall_point(joint.ends, joint, gap, end)
        size = "half_journal" if not keys else "half_length"
        shorter = joint._replace(**{size: getattr(joint, size) - 1e-5})
        lean = (point.depth - wall_point(joint.ends, shorter, gap, end).depth) / 1e-5
        assert step.along[wall, LEAN, 0] == pytest.approx(lean, rel=1e-2, abs=1e-7)
        assert step.along[wall, BEARING_START, 0] == pytest.approx(np.dot(point.at, axis), rel=1e-3, abs=1e-5)
        assert step.along[wall, JOURNAL_START, 0] == pytest.approx(point.at.z - 2e-4, rel=1e-9, abs=0.0)
        assert step.places[wall, 1, 0] == pytest.approx(math.atan2(point.normal.y, point.normal.x), rel=1e-12)
        assert step.places[wall, 0, 0] == pytest.approx(step.places[wall, 1, 0], rel=0.0, abs=1e-4)  # no turn between


@pytest.mark.parametrize(("opened", "frame"), [("rod-slider", "slider"), ("crank-rod", "crank")])
def test_the_bearings_own_axis_x_is_its_bodys_turned_by_the_tilt(opened, frame):
    tilt = np.array([0.006, -0.003, 0.0])
    scene = clearsweep.load_case(spatial(opened, tilt=list(tilt[:2]), wear=WEAR))
    (site,) = [site for site in scene.value.mechanism.sites if hasattr(site, "across")]
    known = np.array([1.0, 0.0, 0.0])
    term, turned = known, known.copy()
    for k in range(1, 12):  # the exponential of the rotation vector
        term = np.cross(tilt, term) / k
        turned = turned + term
    assert np.array(site.across) == pytest.approx(turned, rel=1e-12, abs=1e-17)
    assert np.dot(site.across, site.axis) == pytest.approx(0.0, rel=0.0, abs=1e-16)
    state = scene.start.copy()
    state[2 * len(scene.built.lengths)] = 0.004
    pose = place(scene.value.mechanism, state)
    (seen,) = body_angles(scene.value.mechanism, state)
    angle = 0.004 * scene.case.drive.speed if frame == "crank" else 0.0
    c, s = math.cos(angle), math.sin(angle)
    expected = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ turned
    assert np.array(in_fixed(pose.frame, seen)) == pytest.approx(expected, rel=0.0, abs=1e-15)


def test_bins_along_the_length_are_those_of_joints_in_space_alone():
    layout = clearsweep.load_case(spatial(wear=WEAR)).layout
    assert (layout.joints[0].wear_bins, layout.joints[0].wear_rows) == (90, 10)
    assert {"crank_rod_wear_volume", "crank_rod_pv_peak"} <= {column.name for column in layout.columns}
    with pytest.raises(InputError, match=r"joints\.crank-rod\.wear\.length_bins: unknown key"):
        clearsweep.load_case(planar(wear=WEAR))
    swept = changed(spatial(wear=WEAR), {"sweep": {"joints.crank-rod.wear.bearing_coefficient": [1e-13, 2e-13]}})
    cases = grid.load(swept, simulation.catalogue())
    assert cases.case(0).joints[0].wear.length_bins == 10
    other = grid.load(changed(swept, {"joints.crank-rod.wear.length_bins": 12}), simulation.catalogue())
    assert cases.case_id(0) != other.case_id(0)
