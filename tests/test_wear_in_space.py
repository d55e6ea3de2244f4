"""Wear over angle and length: how a load is spread along a journal that leans, and that nothing of it is lost."""

import math

import numpy as np
import pytest
from mechanism_cases import changed
from spatial_cases import JOINT, spatial
from spatial_oracle import Oracle

import clearsweep
from clearsweep import grid, simulation
from clearsweep.mechanics.joints.spatial import APART, SpatialGap, slices, strips, wall_point
from clearsweep.mechanics.laws.contract import FREE, PRESSED
from clearsweep.mechanics.machines.contract import body_angles, pose_at
from clearsweep.mechanics.observe import (
    DEPTH_ROW,
    FORCE_ROW,
    KAPPA_ROW,
    PARTS,
    QUARTER_POINTS,
    SLIP_ROW,
    STATE_POINTS,
    STEP_VALUE_ROWS,
)
from clearsweep.mechanics.wear import ACCOUNT_SIZE, Account
from clearsweep.mechanics.wear.arc import WORKSPACE_SIZE, workspace_of
from clearsweep.mechanics.wear.bins import (
    BUFFER_ROWS,
    POSITIONS,
    SLOPES,
    AxialRows,
    Instant,
    Step,
    StripRows,
    WearTotals,
    record,
    update_joint_wear,
)
from clearsweep.tracing.compiled.vector import Vector, to_fixed_frame

WEAR = {"law": "archard", "bearing_coefficient": 2e-13, "journal_coefficient": 1e-13, "bins": 90, "length_bins": 10}
EVEN = np.arange(PARTS + 1) / PARTS
LEANING = strips.DepthProfile(0.01, 1e-3, 1e-6)


def joint_of(**keys):
    (joint,) = clearsweep.load_case(spatial(wear=WEAR | keys.pop("wear", {}), **keys)).value.joints
    return joint


def empty(joint):
    """Return a Step in which both walls are pressed over the whole journal without load, and its Worn."""
    stride = int(joint.wear.bins * joint.wear_rows)
    axial = AxialRows(np.zeros((6, AxialRows.SIZE, STATE_POINTS)))
    for j in range(6):
        axial[j].reach[:], axial[j].facing[:] = joint.journal_half_length, 1.0
    step = Step(
        np.zeros((6, STEP_VALUE_ROWS, PARTS + 1)),
        1e-5,
        np.array([PRESSED, PRESSED, FREE, FREE, FREE, FREE]),
        np.zeros((6, POSITIONS + SLOPES, STATE_POINTS)),
        axial,
        StripRows(np.zeros((StripRows.SIZE, PARTS + 1))),
        workspace_of(np.zeros(WORKSPACE_SIZE)),
        np.zeros(BUFFER_ROWS * stride),
    )
    return step, WearTotals(np.zeros(12 * stride), stride, Account(np.zeros((6, ACCOUNT_SIZE))))


def volumes(joint, worn):
    """Return what is worn off bearing and journal (m^3), and the depths (rows, bins) m of both."""
    shape = 2, int(joint.wear_rows), int(joint.wear.bins)
    depths = worn.depths[: math.prod(shape)].reshape(shape)
    cell = 2.0 * math.pi / shape[2] / shape[1]
    round_ = (2.0 * joint.half_length * joint.bearing_radius, 2.0 * joint.journal_half_length * joint.journal_radius)
    return [float(cell * size * depth.sum()) for size, depth in zip(round_, depths, strict=True)], depths


def test_the_load_follows_the_depth_along_the_strip():
    joint, whole = joint_of(walls="ends"), (0.0, 0.01)

    def pressed(strip, depth):
        return strips.pressed_part(joint.walls, joint, strip, depth, whole)

    def fraction(strip, depth, low, high):
        total = strips.integrals_of(joint.walls, joint, strip, depth)[0]
        depths = [strips.depth_along(joint.walls, joint, strip, depth, z) for z in (low, high)]
        return strips.load_integral(joint.walls, joint, high - low, depths) / total

    even = strips.DepthProfile(0.01, 0.0, 0.0)
    assert pressed(even, 1e-5) == whole
    assert fraction(even, 1e-5, 0.002, 0.005) == pytest.approx(0.3, rel=1e-12)
    assert pressed(LEANING, 2e-6) == pytest.approx((0.0, 2e-3), rel=1e-12)  # the depth is gone after 2 mm
    assert fraction(LEANING, 2e-6, 0.0, 1e-3) == pytest.approx(0.75, rel=1e-12)  # of a triangle, its thicker half
    assert fraction(LEANING, 2e-6, 2e-3, 1e-2) == 0.0
    deeper_inside = strips.DepthProfile(0.01, -1e-3, 1e-6)
    assert fraction(deeper_inside, 1e-5, 0.0, 5e-3) == pytest.approx((10 + 2.5) / (2 * (10 + 5)), rel=1e-12)


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
def test_a_slice_goes_to_its_bins_and_what_is_beyond_an_end_to_the_last(begin, end, where):
    factors = np.zeros(10)
    slices.add_to_rows(factors, 1.0, slices.AxialRange(begin, end, 0.01, 10))
    expected = np.zeros(10)
    for row, part in where.items():
        expected[row] = part
    assert factors == pytest.approx(expected, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("walls", ["ends", "spread"])
@pytest.mark.parametrize("pressure", ["mean", "hertz-line"])
@pytest.mark.parametrize("rows", [1, 7, 10])
@pytest.mark.parametrize("lean", [0.0, 1e-4, -1e-3, 8e-3])
def test_a_step_loses_nothing_however_the_journal_leans(walls, pressure, rows, lean):
    keys = {"pressure": pressure, "length_bins": rows} | ({"pressure_modulus": 1e11} if pressure != "mean" else {})
    joint = joint_of(wear=keys, walls=walls)
    step, worn = empty(joint)
    load, slip, expected = 800.0 + 300.0 * EVEN, 0.8 + 0.1 * EVEN, 0.0
    for wall, share in ((0, 1.0), (1, 0.5)):
        step.step_values[wall, FORCE_ROW], step.step_values[wall, SLIP_ROW] = share * load, slip * (1.0 - 2.0 * wall)
        step.step_values[wall, KAPPA_ROW], step.step_values[wall, DEPTH_ROW] = 1.0, 4e-6 * (1.0 + EVEN)
        quarters = np.arange(QUARTER_POINTS + 2) / (QUARTER_POINTS + 1)
        step.positions[wall, 0, : QUARTER_POINTS + 2] = 0.3 + 0.02 * quarters + 3.0 * wall
        step.positions[wall, 1, : QUARTER_POINTS + 2] = -3.0 - 0.3 * quarters
        end = 1.0 - 2.0 * wall
        step.axial[wall].lean[: QUARTER_POINTS + 2] = lean * (1.0 + 0.1 * quarters)
        step.axial[wall].bearing_start[:], step.axial[wall].journal_start[:] = end * 0.01 + 1e-4, end * 0.01
        expected += share * step.length * (800.0 * 0.8 + (300.0 * 0.8 + 800.0 * 0.1) / 2.0 + 300.0 * 0.1 / 3.0)
    update_joint_wear(joint, 0, (step, worn))
    (bearing, journal), depths = volumes(joint, worn)
    pressed = 1.0 if pressure == "hertz-line" else bearing / (2e-13 * expected)  # theta0 / sin theta0, for each slice
    deepest = 8e-6 + 0.01 * 1.1 * max(-lean, 0.0)
    widest = math.acos(joint.clearance / (joint.clearance + deepest))
    assert 1.0 <= pressed < widest / math.sin(widest)
    assert bearing == pytest.approx(2e-13 * expected * pressed, rel=1e-9, abs=0.0)
    assert journal == pytest.approx(1e-13 * expected * pressed, rel=1e-9, abs=0.0)
    assert depths.min() >= 0.0
    assert np.all(step.wear_buffer[: 2 * worn.stride] == 0.0)
    way = step.length * 0.85
    assert worn.account[:2].column("sliding_distance") == pytest.approx([way, way], rel=1e-12)


def test_a_leaning_journal_wears_at_its_edge_and_a_parallel_one_evenly():
    joint = joint_of()
    for lean, rows in ((0.0, 5), (4e-3, 1)):  # 8 um deep: gone after one row
        step, worn = empty(joint)
        step.step_values[0, FORCE_ROW], step.step_values[0, SLIP_ROW] = 1000.0, 1.0
        step.step_values[0, KAPPA_ROW], step.step_values[0, DEPTH_ROW] = 1.0, 8e-6
        step.axial[0].lean[:], step.axial[0].bearing_start[:], step.axial[0].journal_start[:] = (
            lean,
            0.01,
            0.01,
        )
        step.mode[1] = FREE
        update_joint_wear(joint, 0, (step, worn))
        (bearing, _), depths = volumes(joint, worn)
        distance = depths[0].sum(axis=1) / depths[0].sum()
        assert distance == pytest.approx(np.where(np.arange(10) >= 10 - rows, 1.0 / rows, 0.0), rel=1e-9, abs=0.0)
        assert bearing == pytest.approx(2e-13 * 1000.0 * 1e-5, rel=2e-2, abs=0.0)


@pytest.mark.parametrize("walls", ["ends", "spread"])
@pytest.mark.parametrize("depth", [0.0, -1e-12])
def test_a_strip_that_is_about_to_touch_wears_by_its_load(walls, depth):
    """Force and depth are two polynomials over a step: the force may be above 0 where the depth is not."""
    joint = joint_of(walls=walls)
    step, worn = empty(joint)
    step.step_values[:2, FORCE_ROW], step.step_values[:2, SLIP_ROW] = 1e-7, 1.0
    step.step_values[:2, KAPPA_ROW], step.step_values[:2, DEPTH_ROW] = 1.0, depth
    update_joint_wear(joint, 0, (step, worn))
    (bearing, journal), depths = volumes(joint, worn)
    assert np.isfinite(depths).all()
    assert np.isfinite(worn.account.numbers).all()
    if walls == "spread" and depth == 0.0:  # over the whole strip, which is parallel
        assert bearing == pytest.approx(2.0 * 2e-13 * 1e-7 * step.length, rel=1e-9, abs=0.0)
        assert journal == pytest.approx(0.5 * bearing, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("keys", [{}, {"flange": False, "axial_clearance": None, "journal_length": 0.03}])
def test_strips_begin_where_the_surfaces_are_deepest_and_lean_as_they_do(keys):
    """The slope of the depth along the body whose circle bears, by moving that circle along it."""
    joint = joint_of(**keys)
    axis = np.array([0.004, -0.003, 1.0])
    axis /= np.linalg.norm(axis)
    gap = SpatialGap(Vector(1.5e-4, 1e-4, 2e-4), None, Vector(*axis), None, None, None)
    step, _ = empty(joint)
    across = np.array([1.0, 0.0, -axis[0] / axis[2]])
    record(joint, gap, Vector(*(across / np.linalg.norm(across))), 0, Instant((), (), 0, step))
    for wall, end in enumerate((1.0, -1.0)):
        point = wall_point(joint.end_type, joint, gap, end)
        size = "journal_half_length" if not keys else "half_length"
        shorter = joint._replace(**{size: getattr(joint, size) - 1e-5})
        lean = (point.depth - wall_point(joint.end_type, shorter, gap, end).depth) / 1e-5
        assert step.axial[wall].lean[0] == pytest.approx(lean, rel=1e-2, abs=1e-7)
        assert step.axial[wall].bearing_start[0] == pytest.approx(np.dot(point.position, axis), rel=1e-3, abs=1e-5)
        assert step.axial[wall].journal_start[0] == pytest.approx(point.position.z - 2e-4, rel=1e-9, abs=0.0)
        assert step.positions[wall, 1, 0] == pytest.approx(math.atan2(point.normal.y, point.normal.x), rel=1e-12)
        assert step.positions[wall, 0, 0] == pytest.approx(
            step.positions[wall, 1, 0], rel=0.0, abs=1e-4
        )  # no turn between


@pytest.mark.parametrize(("opened", "frame"), [("rod-slider", "slider"), ("crank-rod", "crank")])
def test_the_bearings_own_axis_x_is_its_bodys_turned_by_the_tilt(opened, frame):
    tilt = np.array([0.006, -0.003, 0.0])
    scene = clearsweep.load_case(spatial(opened, tilt=list(tilt[:2]), wear=WEAR))
    (site,) = scene.value.mechanism.openings
    known = np.array([1.0, 0.0, 0.0])
    term, turned = known, known.copy()
    for k in range(1, 12):  # the exponential of the rotation vector
        term = np.cross(tilt, term) / k
        turned = turned + term
    assert np.array(site.across) == pytest.approx(turned, rel=1e-12, abs=1e-17)
    assert np.dot(site.across, site.axis) == pytest.approx(0.0, rel=0.0, abs=1e-16)
    state = scene.start.copy()
    state[2 * len(scene.built.lengths)] = 0.004
    pose = pose_at(scene.value.mechanism, state)
    (seen,) = body_angles(scene.value.mechanism, state)
    angle = 0.004 * scene.case.drive.speed if frame == "crank" else 0.0
    c, s = math.cos(angle), math.sin(angle)
    expected = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ turned
    assert np.array(to_fixed_frame(pose.frames[len(site.journal) - 1], seen)) == pytest.approx(
        expected, rel=0.0, abs=1e-15
    )


def test_bins_along_the_length_are_those_of_joints_in_space_alone():
    layout = clearsweep.load_case(spatial(wear=WEAR)).layout
    assert (layout.joints[0].wear_bins, layout.joints[0].wear_rows) == (90, 10)
    assert {"crank_rod_wear_volume", "crank_rod_pv_peak"} <= {column.name for column in layout.columns}
    swept = changed(spatial(wear=WEAR), {"sweep": {"joints.crank-rod.wear.bearing_coefficient": [1e-13, 2e-13]}})
    cases = grid.load(swept, simulation.catalogue())
    assert cases.case(0).joints[0].wear.length_bins == 10
    other = grid.load(changed(swept, {"joints.crank-rod.wear.length_bins": 12}), simulation.catalogue())
    assert cases.case_id(0) != other.case_id(0)


def test_the_strip_of_an_end_that_is_apart_wears_where_what_is_pressed_reaches_it():
    joint = joint_of(walls="spread")
    for force, rows in ((0.0, [5]), (300.0, [4, 5])):
        step, worn = empty(joint)
        step.mode[1] = APART
        step.step_values[:2, SLIP_ROW], step.step_values[:2, KAPPA_ROW] = 1.0, 1.0
        step.step_values[0, FORCE_ROW], step.step_values[1, FORCE_ROW] = 1000.0, force
        step.step_values[0, DEPTH_ROW], step.step_values[1, DEPTH_ROW] = 1.1e-5, -9e-6  # 1 um deep in the middle
        step.axial[0].lean[:], step.axial[1].lean[:] = 1e-3, -1e-3
        step.axial[0].bearing_start[:], step.axial[0].journal_start[:] = 0.01, 0.01
        step.axial[1].bearing_start[:], step.axial[1].journal_start[:] = -0.01, -0.01
        update_joint_wear(joint, 0, (step, worn))
        (bearing, _), depths = volumes(joint, worn)
        assert bearing == pytest.approx(2e-13 * (1000.0 + force) * 1e-5, rel=2e-2, abs=0.0)
        distance = depths[0].sum(axis=1)
        assert np.flatnonzero(distance[:6] > 0.0).tolist() == rows
        assert (worn.account[1].sliding_distance > 0.0) == (force > 0.0)


# ---------------------------------------------------------------------------------------------- depth of slices


HERTZ = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}


def worn_by_quadrature(joint, depths, lean, angle):
    """Return the bearing's wear (rows, bins) m, of one strip; depths : (times,) m, at its end, even in the time.

    At each time and place the elastic force is spread evenly over the arc in which the circles overlap.  The scale of
    the result is arbitrary.
    """
    rows, count, half = int(joint.wear_rows), int(joint.wear.bins), joint.journal_half_length
    edges, result = np.arange(count + 1) * 2.0 * math.pi / count, np.zeros((rows, count))
    positions = (np.arange(200) + 0.5) * half / 200  # from the end inwards
    for depth in depths:
        for z, here in zip(positions, np.maximum(depth - lean * positions, 0.0), strict=True):
            arc = math.acos(joint.clearance / (joint.clearance + here))
            if arc == 0.0:
                continue
            area = here**1.5 * arc / math.sin(arc)
            share = np.diff(np.clip((edges - angle + arc) / (2.0 * arc), 0.0, 1.0))
            row = math.floor((half - z) / (2.0 * half) * rows + 0.5 * rows)
            result[row] += area * share
    return result


@pytest.mark.parametrize(
    ("before", "after", "lean"),
    [
        (1e-6, 1e-16, -2e-4),
        (1e-6, 0.0, -2e-4),
        (1e-6, -1e-16, -2e-4),
        (1e-6, 0.0, 5e-5),
        (0.0, 1e-6, -2e-4),
        (-1e-16, 1e-6, -2e-4),
        (0.0, 1e-6, 5e-5),
        (1e-16, -1e-6, -2e-4),
        (-1e-6, 0.0, -2e-4),
    ],
)
def test_a_step_from_an_onset_or_to_a_separation_wears_like_its_moments(before, after, lean):
    """The depth of an end is 0 while its strip is pressed from the other end (lean below 0), or not (above)."""
    joint = joint_of(walls="spread", contact=HERTZ, wear={"pressure": "mean", "bins": 360})
    step, worn = empty(joint)
    distance, half = np.linspace(before, after, PARTS + 1), joint.journal_half_length
    positions = (np.arange(200) + 0.5) * half / 200
    step.step_values[0, DEPTH_ROW], step.step_values[0, KAPPA_ROW], step.step_values[0, SLIP_ROW] = (
        distance,
        1.0,
        1.0,
    )
    step.step_values[0, FORCE_ROW] = [
        1e9 * float(np.mean(np.maximum(d - lean * positions, 0.0) ** 1.5)) for d in distance
    ]
    step.mode[0] = PRESSED if max(before, after) > 1e-15 else APART
    step.positions[0, 0, : QUARTER_POINTS + 2], step.axial[0].lean[:] = 1.0, lean
    step.axial[0].bearing_start[:], step.axial[0].journal_start[:] = half, half
    update_joint_wear(joint, 0, (step, worn))
    _, depths = volumes(joint, worn)
    result, times = depths[0] / depths[0].sum(), (np.arange(100) + 0.5) / 100
    expected = worn_by_quadrature(joint, before + (after - before) * times, lean, 1.0)
    expected /= expected.sum()
    assert float(np.abs(result - expected).sum()) < 0.08  # arcs of one width for slices whose loads are alike
    assert result.sum(axis=1) == pytest.approx(expected.sum(axis=1), rel=0.0, abs=2e-3)


# ---------------------------------------------------------------------------------------------- partial overlap


@pytest.mark.parametrize("walls", ["ends", "spread"])
@pytest.mark.parametrize(("away", "sliding"), [(0.012, 0.0), (-0.012, 0.0), (0.012, 5e-4)])
def test_a_journal_partly_outside_the_bore_wears_only_where_both_overlap(walls, away, sliding):
    joint = joint_of(
        walls=walls, flange=False, axial_clearance=None, wear={"pressure": "hertz-line", "pressure_modulus": 1e11}
    )
    assert (joint.journal_half_length, joint.half_length) == (0.01, 0.01)
    step, worn = empty(joint)
    depth, still = 5e-6, Vector(0.0, 0.0, 0.0)
    for i in range(QUARTER_POINTS + 2):
        middle = Vector(joint.clearance + depth, 0.0, away + sliding * i / (QUARTER_POINTS + 1))
        gap = SpatialGap(middle, still, Vector(0.0, 0.0, 1.0), still, still, None)
        record(joint, gap, Vector(1.0, 0.0, 0.0), 0, Instant((), (), i, step))
    step.step_values[:2, FORCE_ROW], step.step_values[:2, SLIP_ROW] = 500.0, 1.0
    step.step_values[:2, KAPPA_ROW], step.step_values[:2, DEPTH_ROW] = 1.0, depth
    update_joint_wear(joint, 0, (step, worn))
    (bearing, journal), depths = volumes(joint, worn)
    assert bearing == pytest.approx(2e-13 * 1000.0 * step.length, rel=1e-9, abs=0.0)
    assert journal == pytest.approx(1e-13 * 1000.0 * step.length, rel=1e-9, abs=0.0)
    overlap = 0.02 - abs(away) - 0.5 * sliding  # m, of 10 bins along 20 mm
    even = np.clip(overlap / 0.002 - np.arange(10), 0.0, 1.0) * 0.002 / overlap  # by the bins from the end that bears
    for body, expected in enumerate((even[::-1], even) if away > 0.0 else (even, even[::-1])):
        distance = depths[body].sum(axis=1) / depths[body].sum()
        assert distance == pytest.approx(expected, rel=1e-6 if sliding == 0.0 else 0.05, abs=1e-9)


# ---------------------------------------------------------------------------------------------- peaks of pressure


def bearing_at_ends(law, tilt, revolutions):
    """Return a grid of walls that bear at their ends, with friction and wear."""
    case = spatial(
        contact=JOINT["contact"] | {"law": law, "stiffness": 6.61e10},
        wear={"law": "archard", "coefficient": 2e-14, "bins": 90, "length_bins": 20},
        friction={"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2},
        tilt=tilt,
        walls="ends",
    )
    case["simulate"] |= {"revolutions": revolutions, "discard": 0}
    return case


def peaks_at(tolerance, case):
    """Return the largest pressure (Pa) and pressure times speed (W/m^2) of the crank pin."""
    case["simulate"]["tolerance"] = tolerance
    summary = clearsweep.simulate(clearsweep.load_case(case)).summary
    return np.array([summary["crank_rod_pressure_peak"], summary["crank_rod_pv_peak"]])


def peaks_of_oracle(oracle, times):
    """Return the same of an Oracle: each end's load over half the length, as its depth less its lean, on chords."""
    peaks, half = np.zeros(2), oracle.journal_half_length
    clearance = oracle.bearing - oracle.journal
    for t, y, loads in zip(times, *oracle.run(times)[:2], strict=True):
        seen = oracle.look(t, y)
        turn, _, _, (middle, _, moving, spin), _, (v, w) = seen
        for end, load, (point, normal, depth) in zip((1.0, -1.0), loads, oracle.points(seen), strict=False):
            if load <= 0.0:
                continue
            lean = end * normal @ turn[:, 2]
            reach = min(half, depth / lean) if lean > 0.0 else half
            line_load = load * max(depth, depth - lean * reach) / (reach * (depth - 0.5 * lean * reach))
            cosine = clearance / (clearance + max(depth, depth - lean * reach))
            pressure = line_load / (2.0 * oracle.bearing * math.sqrt(1.0 - cosine * cosine))
            slip = v + np.cross(w, point - y[:3]) - moving - np.cross(spin, point - depth * normal - middle)
            speed = np.linalg.norm(slip - (slip @ normal) * normal)
            peaks = np.maximum(peaks, [pressure, pressure * speed])
    return peaks


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [[0.0, 0.0], [0.005236, 0.0], [0.001, 0.003]], ids=("parallel", "tilted", "across"))
def test_peaks_of_pressure_are_those_of_a_second_program_at_any_tolerance(tilt):
    """Over the first three impacts; later the tilt of a parallel pin grows from rounding, as its motion is unstable."""
    case = bearing_at_ends("lankarani-nikravesh", tilt, 0.04)
    lean = bearing_at_ends("lankarani-nikravesh", [tilt[0] or 1e-7, tilt[1]], 0.04)  # an Oracle has one event at a time
    expected = peaks_of_oracle(Oracle(lean), np.linspace(0.0, 0.0024, 1201))
    for tolerance in (1e-6, 1e-8, 1e-10):
        assert peaks_at(tolerance, case) == pytest.approx(expected, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "tilt", "revolutions"),
    [
        ("lankarani-nikravesh", [0.005236, 0.0], 1.0),
        ("lankarani-nikravesh", [0.010472, 0.0], 0.2),
        ("lankarani-nikravesh", [0.0, 0.0], 0.1),
        ("lankarani-nikravesh-plastic", [0.005236, 0.0], 0.3),
        ("lankarani-nikravesh-plastic", [0.0, 0.005236], 0.2),
        ("lankarani-nikravesh-plastic", [0.0, 0.0], 0.1),
    ],
)
def test_peaks_of_pressure_do_not_follow_the_tolerance(law, tilt, revolutions):
    """A limit at the depth 0 is a quotient of two small numbers."""
    case = bearing_at_ends(law, tilt, revolutions)
    *coarse, finest = (peaks_at(tolerance, case) for tolerance in (1e-6, 1e-7, 1e-8, 1e-9, 1e-10))
    for peaks in coarse:
        assert peaks == pytest.approx(finest, rel=0.05)
