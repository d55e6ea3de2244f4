"""Walls whose stiffness is spread over the length, the edges of a bore, and a journal that leaves it.

The oracle integrates slices of the length by itself: depths of circles from a search over angles, no code of the
package.
"""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad
from spatial_cases import JOINT, spatial
from spatial_oracle import SlicedOracle, extreme

import clearsweep
from clearsweep.mechanics import observe
from clearsweep.mechanics.coupling import rates as rates_code
from clearsweep.mechanics.coupling.state import kappa_over_root, time_scale
from clearsweep.mechanics.joints import spatial as joints
from clearsweep.mechanics.joints.contract import JointState, Offsets, contact_modes, load, power_lost, power_stored
from clearsweep.mechanics.joints.spatial import spread, strips
from clearsweep.mechanics.laws.contract import ACTS, CLIPPED, FREE, PRESSED
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.machines.contract import gaps, pose_at
from clearsweep.tracing.compiled.vector import Vector

HERTZ = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
THROUGH = {"flange": False, "axial_clearance": None}
LONGER = THROUGH | {"journal_length": 0.03}
STILL = Vector(0.0, 0.0, 0.0)


def joint_of(**keys):
    """Return the compiled form of a joint whose walls are spread, without loss unless asked otherwise."""
    (joint,) = clearsweep.load_case(spatial(**{"walls": "spread", "contact": HERTZ} | keys)).value.joints
    return joint


def gap_of(middle, axis, velocity=STILL, spin=STILL):
    """Return the gap of a journal whose middle and whose bearing's axis are given in its frame."""
    axis = np.array(axis) / np.linalg.norm(axis)
    return joints.SpatialGap(Vector(*middle), Vector(*velocity), Vector(*axis), STILL, Vector(*spin), None)


def loaded(joint, gap, onset=(0.1, 0.1), modes=None):
    """Return the load of a joint whose wall contacts touch where they are deep."""
    y, pairs = np.zeros(8), contact_modes(joint)
    mode = np.array([FREE] * (len(pairs) - 2) + [ACTS, ACTS])
    for c, end in enumerate(joints.ENDS):
        depth = joints.wall_point(joint.end_type, joint, gap, end).depth
        y[c], mode[c] = math.sqrt(max(depth, 0.0)), pairs[c].pressed if depth > 0.0 else pairs[c].apart
    mode[:2] = mode[:2] if modes is None else modes
    return load(joint, gap, Offsets(0, 0, 0, 0), JointState(y, mode, np.array([*onset, *[0.1] * 4]), 0))


# ---------------------------------------------------------------------------------------------- the potential


def ends_of(joint, middle, axis):
    """Return (depth, lean inwards, half of the length that bears) at both ends, and the share of the stiffness."""
    w, result = np.array([0.0, 0.0, 1.0]), []
    longer = not isinstance(joint, joints.Flanged)
    shorter = min(joint.journal_half_length, joint.half_length)
    half = joint.journal_half_length
    if longer:
        half = min(shorter, 0.5 * (joint.journal_half_length + joint.half_length - abs(middle[2])))
    for end in joints.ENDS:
        center = middle + end * joint.journal_half_length * w
        point = extreme(center, joint.journal_radius, np.eye(3)[:2], axis, 1.0)
        if longer and end * (point @ axis) > joint.half_length:
            across = np.cross(axis, [1.0, 0.3, 0.2])
            across /= np.linalg.norm(across)
            edge = end * joint.half_length * axis - middle
            near = extreme(edge, joint.bearing_radius, (across, np.cross(axis, across)), w, -1.0)
            off = -edge + (edge @ w) * w
            depth = joint.journal_radius - np.linalg.norm(near - (near @ w) * w)
            result.append((depth, -end * (off / np.linalg.norm(off)) @ axis))
        else:
            off = center - (center @ axis) * axis
            depth = np.linalg.norm(point - (point @ axis) * axis) - joint.bearing_radius
            result.append((depth, end * (off / np.linalg.norm(off)) @ w))
    return [(depth, lean, half) for depth, lean in result], half / (shorter if longer else joint.journal_half_length)


def stored(joint, middle, axis, stiffness=1e9, power=1.5):
    """Return the energy (J) of fine slices: between the depths of both ends, the line of distances is a hyperbola."""
    ((depth, _, half), (other_depth, _, _)), share = ends_of(joint, middle, axis)
    middle_of_overlap, w = 0.0, np.array([0.0, 0.0, 1.0])
    if not isinstance(joint, joints.Flanged):
        high = min(joint.journal_half_length, joint.half_length - middle[2])
        middle_of_overlap = high - half
    shares = (np.arange(4000) + 0.5) / 4000
    z = middle_of_overlap + half * (2.0 * shares - 1.0)

    def distance(z):
        point = middle + np.atleast_1d(z)[:, None] * w
        across = point - (point @ axis)[:, None] * axis
        size = np.linalg.norm(across, axis=1)
        if not isinstance(joint, joints.Flanged):
            return size
        angle, radius = np.arctan2(across[:, 1], across[:, 0]), joint.journal_radius
        for _ in range(12):  # of the circle: its farthest point from the axis, by Newton's method
            c, s = np.cos(angle), np.sin(angle)
            parallel, turned = axis[0] * c + axis[1] * s, axis[1] * c - axis[0] * s
            slope = across[:, 1] * c - across[:, 0] * s - radius * parallel * turned
            curvature = across[:, 0] * c + across[:, 1] * s + radius * (turned**2 - parallel**2)
            angle = angle + np.clip(slope / np.maximum(curvature, 1e-6), -0.3, 0.3)
        c, s = np.cos(angle), np.sin(angle)
        return across[:, 0] * c + across[:, 1] * s - 0.5 * radius * (axis[0] * c + axis[1] * s) ** 2

    at_ends = distance(middle_of_overlap + half * np.array([1.0, -1.0]))
    sag = shares * at_ends[0] + (1.0 - shares) * at_ends[1] - distance(z)
    deep = np.maximum(shares * depth + (1.0 - shares) * other_depth - sag, 0.0)
    return share * stiffness / (power + 1.0) * np.mean(deep ** (power + 1.0))


POSES = {
    "edge": ({}, [1.9e-4, 5e-5, 1e-5], [5e-3, 1e-3]),
    "both ends": ({}, [2.1e-4, 1e-5, 1e-4], [9e-4, 2e-4]),
    "across": ({}, [1.99e-4, 1e-5, 1e-4], [1e-3, 3e-3]),
    "lifted between the ends": ({}, [1.99e-4, 0.0, 0.0], [1e-4, 3e-3]),
    "jammed": ({}, [2e-6, 1e-5, 0.0], [2.1e-2, 1e-3]),
    "edges of the bore": (LONGER, [1.9e-4, 5e-5, 1e-5], [5e-3, 1e-3]),
    "jammed in the bore": (LONGER, [2e-6, 1e-5, 0.0], [2.1e-2, 1e-3]),
    "one edge, one end": (THROUGH, [2.05e-4, 2e-5, 5e-3], [2e-3, 3e-4]),
    "nearly out": (THROUGH, [2.05e-4, 2e-5, -1.8e-2], [2e-3, 3e-4]),
}


@pytest.mark.parametrize("name", POSES)
def test_force_and_moment_are_the_slopes_of_what_the_slices_store(name):
    keys, middle, lean = POSES[name]
    joint, middle = joint_of(**keys), np.array(middle)
    axis = np.array([*lean, 1.0]) / np.linalg.norm([*lean, 1.0])
    message = loaded(joint, gap_of(middle, axis))

    def turned(vector, k, angle):  # of what the journal, turned by an angle, sees
        about = np.eye(3)[k] * angle
        return vector - np.cross(about, vector) + 0.5 * np.cross(about, np.cross(about, vector))

    def slope(function, h):
        return -(8.0 * (function(h) - function(-h)) - function(2.0 * h) + function(-2.0 * h)) / (12.0 * h)

    force = [slope(lambda h, k=k: stored(joint, middle + h * np.eye(3)[k], axis), 2e-8) for k in range(3)]
    moment = [slope(lambda h, k=k: stored(joint, *(turned(v, k, h) for v in (middle, axis))), 2e-6) for k in range(3)]
    size = np.linalg.norm(force)
    assert size > 0.01
    # a circle, in this view an ellipse, is exact to first order in radius tilt^2 / clearance
    second_order = 2e-5 + 1.5 * joint.journal_radius * (lean[0] ** 2 + lean[1] ** 2) / joint.clearance
    assert np.array(message.force) == pytest.approx(np.array(force), rel=0.0, abs=second_order * size)
    assert np.array(message.journal_moment) == pytest.approx(
        np.array(moment), rel=0.0, abs=second_order * size * joint.half_length
    )
    assert np.array(message.bearing_moment) == pytest.approx(  # what acts on one body acts on the other the other way
        -np.array(message.journal_moment) - np.cross(middle, message.force), rel=0.0, abs=1e-12 * size
    )


@pytest.mark.parametrize("name", POSES)
def test_what_bodies_lose_goes_into_the_walls_to_the_last_digit(name):
    keys, middle, lean = POSES[name]
    joint, velocity, spin = joint_of(**keys), np.array([0.3, -0.2, 0.7]), np.array([3.0, -5.0, 2.0])
    message = loaded(joint, gap_of(middle, [*lean, 1.0], velocity, spin))
    lost = -np.dot(message.force, velocity) - np.dot(message.journal_moment, spin)
    kept = sum(power_stored(contact) for contact in message.contacts)
    assert kept == pytest.approx(lost, rel=1e-12, abs=1e-12 * np.linalg.norm(message.force))
    assert sum(abs(power_lost(contact)) for contact in message.contacts) <= 1e-13 * abs(kept)


# ---------------------------------------------------------------------------------------------- forces at both ends


def by_slices(depths, rates, chi, onset, length=0.02, stiffness=1e9, power=1.5):
    """Return the forces at both ends, of the sum and the moment of slices with depth and rate linear between them."""

    def force(s):
        depth = max(depths[0] + (depths[1] - depths[0]) * s, 0.0)
        return stiffness * depth**power * (1.0 + chi * (rates[0] + (rates[1] - rates[0]) * s) / onset)

    gone = depths[0] / (depths[0] - depths[1]) if depths[0] * depths[1] < 0.0 else 1.0
    low, high = (0.0, gone) if depths[0] > 0.0 else (gone, 1.0)
    return [
        quad(lambda s: (1.0 - s) * force(s), low, high, epsabs=0.0, epsrel=1e-12)[0],
        quad(lambda s: s * force(s), low, high, epsabs=0.0, epsrel=1e-12)[0],
    ]


@pytest.mark.parametrize("lean", [0.0, 1e-9, 1e-6, 3e-4, 1.2e-3, -8e-3])
@pytest.mark.parametrize("loss", [{}, {"law": "lankarani-nikravesh", "restitution": 0.7}])
def test_in_one_plane_the_ends_bear_what_slices_between_them_come_to(lean, loss):
    joint = joint_of(contact=HERTZ | loss | ({"onset": "first"} if loss else {}))
    middle = 2.1e-4 - (7.5e-5 if abs(lean) > 5e-3 else 0.0)
    velocity, spin = np.array([0.05, 0.0, 0.01]), np.array([0.0, 2.0, 0.0])
    gap = gap_of([middle, 0.0, 0.0], [math.sin(lean), 0.0, math.cos(lean)], velocity, spin)
    points = [joints.wall_point(joint.end_type, joint, gap, end) for end in joints.ENDS]
    moving = [velocity + np.cross(spin, np.array(point.position) - [middle, 0.0, 0.0]) for point in points]
    rates = [np.dot(v, point.normal) for v, point in zip(moving, points, strict=True)]
    message = loaded(joint, gap)
    expected = by_slices([point.depth for point in points], rates, 0.75 * (1.0 - 0.7**2) if loss else 0.0, 0.1)
    result = [contact.end_force for contact in message.contacts[:2]]
    assert result == pytest.approx(expected, rel=2e-5 if abs(lean) > 5e-3 else 1e-7, abs=1e-9)
    assert message.contacts[0].normal + message.contacts[1].normal == pytest.approx(sum(result), rel=1e-14)
    assert message.contacts[-1].normal == pytest.approx(abs(result[0] - result[1]), rel=1e-12, abs=1e-13)


def profile_between(first, last, rise, clearance=2e-4):
    """Return the Profile over 0 to 1 of a distance that is a hyperbola; rise : m^2, its tilt squared."""
    squares = (clearance + first) ** 2, (clearance + last) ** 2
    slope = 0.5 * (squares[1] - squares[0] - rise)
    return strips.Profile(clearance, first * (2.0 * clearance + first), slope, rise)


@pytest.mark.parametrize(
    ("deep", "shallow"), [(1e-5, 4e-6), (1e-5, 9.9999e-6), (1e-5, 1e-5), (1e-5, -3e-5), (2e-7, 0.0)]
)
def test_a_straight_strip_bears_what_the_closed_form_says(deep, shallow):
    joint = joint_of()
    profile = profile_between(deep, shallow, (deep - shallow) ** 2)
    result = strips.integrals_up_to(profile, 1.0, joint.elastic, joint.walls.rule)
    known = quad(lambda s: elastic_force(joint.elastic, max(deep + (shallow - deep) * s, 0.0)), 0.0, 1.0, epsrel=1e-13)
    known = known[0]
    if shallow < 0.99 * deep:
        known = 1e9 * (deep**2.5 - max(shallow, 0.0) ** 2.5) / (2.5 * (deep - shallow))
    assert result[0] == pytest.approx(known, rel=1e-9, abs=0.0)
    assert strips.mean_elastic(joint.elastic, joint.walls.rule, (deep, shallow)) == pytest.approx(known, rel=1e-13)


@pytest.mark.parametrize(
    ("deep", "other", "rise"),
    [(1e-5, -1e-5, 4e-10), (1e-5, 3e-6, 4e-9), (1e-6, -1e-4, 1e-8), (1e-5, 8e-6, 1.2e-8), (2e-6, 2e-6, 4e-9)],
)
@pytest.mark.parametrize("law", ["hertz", "power", "johnson", "persson", "liu", "compatible", "winkler", "linear"])
def test_slices_of_a_hyperbola_add_up_as_an_adaptive_quadrature_says(law, deep, other, rise):
    contact = {"law": "hertz", "elastic": law, "material": {"young": 2.07e11, "poisson": 0.3}}
    if law == "power":
        contact |= {"stiffness": 1e9, "exponent": 10.0 / 9.0}
    if law == "winkler":
        contact["thickness"] = 1e-3
    if law == "linear":
        contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 0.0}
    joint = joint_of(contact=HERTZ if law == "hertz" else contact)
    profile = profile_between(deep, other, rise)
    result = strips.integrals_up_to(profile, 1.0, joint.elastic, joint.walls.rule)

    def depth(s):
        return math.sqrt(4e-8 + profile.constant + s * (2.0 * profile.product + rise * s)) - 2e-4

    zeros = np.roots([rise, 2.0 * profile.product, profile.constant])
    cuts = [0.0, *sorted(z.real for z in zeros if abs(z.imag) == 0.0 and 0.0 < z.real < 1.0), 1.0]
    known = known_area = 0.0
    for low, high in itertools.pairwise(cuts):
        if depth(0.5 * (low + high)) > 0.0:
            known += quad(lambda s: elastic_force(joint.elastic, max(depth(s), 0.0)), low, high, limit=500)[0]
            known_area += quad(depth, low, high)[0]
    assert result == pytest.approx((known, known_area), rel=5e-4)


# ---------------------------------------------------------------------------------------------- true circles


def on_true_circles(joint, middle, axis, stiffness, count=2000):
    """Return force (N) and moment (N m) on a journal of `count` slices, each at its circle's farthest point."""
    z = (2.0 * (np.arange(count) + 0.5) / count - 1.0) * joint.journal_half_length
    center = middle + z[:, None] * np.array([0.0, 0.0, 1.0])
    across, radius = center - (center @ axis)[:, None] * axis, joint.journal_radius
    angle = np.arctan2(across[:, 1], across[:, 0])
    for _ in range(40):
        d = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
        e = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=1)
        d_across, e_across = (v - (v @ axis)[:, None] * axis for v in (d, e))
        out = across + radius * d_across
        slope = np.sum(out * e_across, axis=1)
        curvature = np.sum(radius * e_across * e_across - out * d_across, axis=1)
        angle = angle - np.clip(slope / np.where(curvature < 0.0, curvature, -1e-30), -0.3, 0.3)
    distance = np.linalg.norm(out, axis=1)
    force = stiffness / count * np.maximum(distance - joint.bearing_radius, 0.0) ** 1.5
    pressing = -force[:, None] * out / distance[:, None]
    arm = np.stack([radius * d[:, 0], radius * d[:, 1], z], axis=1)
    return pressing.sum(axis=0), np.cross(arm, pressing).sum(axis=0)


@pytest.mark.parametrize("direction", [0.0, 30.0, 60.0, 85.0, 90.0])
@pytest.mark.parametrize("tilt", [1e-4, 5e-4, 2e-3, 5e-3])
def test_tilted_walls_bear_what_slices_with_true_circles_bear(direction, tilt):
    """In (0 degrees), across and oblique to the load."""
    joint = joint_of(clearance=1e-4, contact=HERTZ | {"stiffness": 6e9})
    lean = -tilt * np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])
    axis = np.array([*lean, 1.0]) / math.hypot(*lean, 1.0)
    for depth in (2e-6, 5e-6, 2e-5, 5e-5):
        middle = np.array([1e-4 + depth, 0.0, 0.0])
        force, moment = on_true_circles(joint, middle, axis, 6e9)
        message = loaded(joint, gap_of(middle, axis))
        assert np.array(message.force) == pytest.approx(force, rel=0.0, abs=2e-3 * np.linalg.norm(force))
        assert np.array(message.journal_moment) == pytest.approx(moment, rel=0.0, abs=3e-3 * np.linalg.norm(moment))
        if direction == 90.0 and tilt <= 2e-3 and depth >= 1e-5:  # F l^2 b / (12 e), to leading order
            leading = np.linalg.norm(force) * 0.02**2 * tilt / (12.0 * (1e-4 + depth))
            assert np.linalg.norm(message.journal_moment) == pytest.approx(leading, rel=0.1)


# ---------------------------------------------------------------------------------------------- against the ends


def both(middle, lean, **keys):
    """Return the force (N) along x and the moment (N m) about y of a leaning journal, spread and at the ends."""
    result = []
    for walls in ("spread", "ends"):
        joint = joint_of(walls=walls, **keys)
        message = loaded(joint, gap_of([middle, 0.0, 0.0], [-math.sin(lean), 0.0, math.cos(lean)]))
        result.append((-message.force.x, -message.journal_moment.y))
    return result


def test_a_pressed_journal_is_a_third_as_stiff_in_tilt_as_with_end_walls():
    (force, moment), (at_ends, moment_at_ends) = both(2.1e-4, 1e-8)
    assert force == pytest.approx(at_ends, rel=1e-6)
    assert force == pytest.approx(1e9 * 1e-5**1.5, rel=1e-6)
    spread_evenly = 1e9 * 1.5 * 1e-5**0.5 * 0.02**2 / 12.0 * 1e-8  # F' L^2 / 12
    turned = force * 0.0098 * 1e-8  # the point at which the force acts, off the middle as the force leans
    assert moment + turned == pytest.approx(spread_evenly, rel=1e-4)
    assert (moment_at_ends + turned) / (moment + turned) == pytest.approx(3.0, rel=1e-4)


@pytest.mark.parametrize(("lean", "times", "moments"), [(1e-3, 2.5, 3.5), (5e-3, 12.5, 13.3)])
def test_an_edge_contact_is_softer_by_the_length_that_bears(lean, times, moments):
    middle = 2e-4 + 1e-5 - 0.01 * lean  # 10 um at the one end
    (force, moment), (at_ends, moment_at_ends) = both(middle, lean)
    assert at_ends / force == pytest.approx(times, rel=0.06)
    assert moment_at_ends / moment == pytest.approx(moments, rel=0.06)
    assert force == pytest.approx(1e9 / 0.02 * 1e-5**2.5 / (2.5 * lean), rel=0.06)


def test_a_jammed_journal_bears_on_both_edges_over_the_length_that_is_pressed():
    (_, moment), (_, moment_at_ends) = both(0.0, 0.0208)
    (depth, lean, half), _ = ends_of(joint_of(), np.zeros(3), np.array([-math.sin(0.0208), 0.0, math.cos(0.0208)]))[0]
    assert depth / lean < 0.2 * half
    assert moment_at_ends / moment == pytest.approx(1.25 * 0.02 / (depth / lean), rel=0.02)


def test_a_parallel_journal_is_the_joint_in_the_plane_as_its_lean_vanishes():
    plane = 1e9 * 1e-5**1.5
    for lean in (0.0, 1e-15, 1e-12, 1e-9):
        ((force, _), _) = both(2.1e-4, lean)
        assert force == pytest.approx(plane, rel=3e-10)


def test_an_end_that_pulls_is_clipped_by_itself():
    joint = joint_of(contact=JOINT["contact"])
    gap = gap_of([2.1e-4, 0.0, 0.0], [0.0, 0.0, 1.0], velocity=[-1.0, 0.0, 0.0])
    free = loaded(joint, gap, modes=[PRESSED, PRESSED])
    assert free.contacts[0].raw < 0.0
    first = loaded(joint, gap, modes=[CLIPPED, PRESSED])
    assert first.contacts[0].normal == 0.0
    assert first.contacts[1].normal == pytest.approx(free.contacts[1].normal, rel=1e-14)
    none = loaded(joint, gap, modes=[CLIPPED, CLIPPED])
    assert np.array(none.force) == pytest.approx(np.zeros(3), rel=0.0, abs=1e-15)
    assert np.array(none.journal_moment) == pytest.approx(np.zeros(3), rel=0.0, abs=1e-15)
    assert sum(power_stored(c) + power_lost(c) for c in none.contacts) == pytest.approx(0.0, rel=0.0, abs=1e-12)


@pytest.mark.parametrize(("shift", "lean"), [(0.0, 5e-4), (6e-3, 4e-4)])
def test_force_and_moment_do_not_jump_where_a_strip_begins_to_pull(shift, lean):
    """A jump would end its own cause: clipped, pressed and clipped again without any time going on."""
    joint = joint_of(contact=JOINT["contact"], **THROUGH)
    for spin in (-40.0, 40.0):

        def sides(rate, modes=None, spin=spin):
            gap = gap_of([2.1e-4, 0.0, shift], [lean, 0.0, 1.0], [rate, 0.0, 0.1], [0.0, spin, 0.0])
            message = loaded(joint, gap, modes=modes)
            return message.contacts[0].raw, np.array([*message.force, *(100.0 * np.array(message.journal_moment))])

        low, high = -3.0, 3.0
        for _ in range(80):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if sides(middle)[0] < 0.0 else (low, middle)
        before, after = sides(low), sides(high)
        assert before[0] < 0.0 <= after[0]
        assert before[1] == pytest.approx(after[1], rel=0.0, abs=1e-9)
        depth = joints.wall_point(joint.end_type, joint, gap_of([2.1e-4, 0.0, shift], [lean, 0.0, 1.0]), -1.0).depth
        clipped = [CLIPPED, PRESSED if depth > 0.0 else contact_modes(joint)[1].apart]
        assert sides(high, clipped)[1] == pytest.approx(after[1], rel=0.0, abs=1e-9)


def test_the_excess_of_a_moment_that_pulling_slices_cause_is_limited_without_a_kink():
    """As the force vanishes so does the moment; near its bound it changes by the fifth power of the excess."""

    def limited(total, force):
        return spread._limited(total, spread._excess(total, force), force)

    for total in (-3.0, -1e-3, 0.0, 0.5, 1.0, 1.001, 3.0):
        within, excess = min(max(total, 0.0), 1.0), total - min(max(total, 0.0), 1.0)
        assert limited(total, 1.0) == pytest.approx(within + excess / (1.0 + excess**4) ** 0.25, rel=1e-15, abs=1e-300)
        assert abs(limited(total, 1.0) - total) <= 0.25 * abs(excess) ** 5 + 1e-15
        assert abs(limited(total, 1e-9)) <= 2e-9 + 1e-15
        rise, fall = limited(total, 1e-6), limited(total, -1e-6)  # a trial step passes the clipping
        assert rise + fall == pytest.approx(0.0, rel=0.0, abs=1e-11)
    assert limited(0.0, 0.0) == 0.0


# ---------------------------------------------------------------------------------------------- edges of the bore


@pytest.mark.parametrize("walls", ["ends", "spread"])
def test_where_a_journals_end_is_beyond_the_bore_the_edge_of_the_bore_bears(walls):
    joint = joint_of(walls=walls, **THROUGH)
    axis = np.array([1e-3, 5e-4, 1.0]) / np.linalg.norm([1e-3, 5e-4, 1.0])
    middle = np.array([2.1e-4, 0.0, 6e-3])  # its +z end is 6 mm beyond the edge
    gap = gap_of(middle, axis)
    out, inside = (joints.wall_point(joint.end_type, joint, gap, end) for end in joints.ENDS)
    assert np.dot(out.position, axis) == pytest.approx(0.01, abs=1e-6)
    assert out.normal.z == 0.0  # across the journal's axis
    edge = np.array(out.position) - out.depth * np.array(out.normal)
    assert out.depth == pytest.approx(joint.journal_radius - math.hypot(*(edge - middle)[:2]), rel=1e-12)
    assert np.linalg.norm(edge - np.dot(edge, axis) * axis) == pytest.approx(joint.bearing_radius, rel=1e-12)
    assert inside.position.z == pytest.approx(6e-3 - 0.01, rel=1e-12)
    assert np.dot(inside.normal, axis) == pytest.approx(0.0, abs=1e-15)


def test_a_pressed_journal_bears_on_the_length_that_is_in_the_bore():
    force = [
        -loaded(joint_of(**THROUGH), gap_of([2.1e-4, 0.0, shift], [0.0, 0.0, 1.0])).force.x for shift in (0.0, 5e-3)
    ]
    assert force[1] / force[0] == pytest.approx(0.75, rel=1e-12)


# ---------------------------------------------------------------------------------------------- the implicit method


@pytest.mark.plain
@pytest.mark.parametrize("keys", [{}, THROUGH | {"journal_length": 0.018, "offset": [0.0, 0.0, 3e-3]}])
def test_the_rates_of_spread_walls_are_differentiated_exactly(keys):
    case = spatial(walls="spread", friction={"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}, **keys)
    scene = clearsweep.load_case(case)
    value, n = scene.value, len(scene.built.lengths)
    state = scene.start.copy()
    state[:n] += 1e-5 * np.random.default_rng(3).standard_normal(n) / scene.built.lengths
    state[n : 2 * n] += 0.1 * np.random.default_rng(4).standard_normal(n) / scene.built.lengths
    state[0] += 2.2e-4  # pressed
    (gap,) = gaps(value.mechanism, pose_at(value.mechanism, state))
    pairs, roots = contact_modes(value.joints[0]), 2 * n + 1
    mode = np.array([pair.apart for pair in pairs])
    for c, end in enumerate(joints.ENDS):
        depth = joints.wall_point(value.joints[0].end_type, value.joints[0], gap, end).depth
        if depth > 0.0:
            state[roots + c], mode[c] = math.sqrt(depth), pairs[c].pressed
    assert PRESSED in mode[:2]
    size, latched = len(state), np.full(len(mode), 0.1)
    jacobian, k = np.zeros((1, size, observe.whole_registers(size))), np.zeros((size, 16))
    rates_code.slopes_entry((value,), state, mode, latched, jacobian, 0)

    def rates(y):
        rates_code.rates(value, y, mode, latched, k, None, 1)
        return k[:, 1].copy()

    scale = np.abs(rates(state)).max()
    for column in range(size):
        h = 3e-6 * max(abs(state[column]), 1e-3 if column < 2 * n else 1e-4)  # smaller ones show rounding
        upcoming, back = state.copy(), state.copy()
        upcoming[column] += h
        back[column] -= h
        known = (rates(upcoming) - rates(back)) / (2.0 * h)
        error = np.abs(jacobian[0, :, column] - known).max()
        assert error <= 2e-5 * np.abs(known).max() + 1e-9 * scale / h * 1e-3, column


# ---------------------------------------------------------------------------------------------- keys


def test_walls_are_spread_unless_said_otherwise_or_the_law_keeps_an_indentation():
    case = spatial(walls=None)
    assert isinstance(clearsweep.load_case(case).value.joints[0].walls, joints.Spread)
    assert isinstance(clearsweep.load_case(spatial()).value.joints[0].walls, joints.EndContacts)
    plastic = HERTZ | {"law": "lankarani-nikravesh-plastic", "restitution": 0.7}
    assert isinstance(
        clearsweep.load_case(spatial(walls=None, contact=plastic)).value.joints[0].walls, joints.EndContacts
    )


# ---------------------------------------------------------------------------------------------- wear


def load_fraction(joint, strip, depth, interval):
    """Return the load fraction of an interval of a strip."""
    total = strips.integrals_of(joint.walls, joint, strip, depth)[0]
    depths = [strips.depth_along(joint.walls, joint, strip, depth, z) for z in interval]
    return strips.load_integral(joint.walls, joint, interval[1] - interval[0], depths) / total


def test_wear_follows_the_elastic_force_over_the_strip():
    joint = joint_of()
    strip = strips.DepthProfile(0.01, 1e-3, 1e-6)
    for low, high in ((0.0, 1e-3), (1e-3, 2e-3), (3e-3, 4e-3)):  # 4 um deep: pressed over 4 mm
        known = ((4e-3 - low) ** 2.5 - (4e-3 - high) ** 2.5) / 4e-3**2.5
        assert load_fraction(joint, strip, 4e-6, (low, high)) == pytest.approx(known, rel=1e-9)
    inside = strips.DepthProfile(0.01, -1e-3, 1e-6)  # of an end that is apart: pressed from 6 mm on
    interval = 0.0, 0.01
    assert strips.pressed_part(joint.walls, joint, inside, -6e-6, interval) == pytest.approx((6e-3, 1e-2))
    assert load_fraction(joint, inside, -6e-6, (0.0, 8e-3)) == pytest.approx(0.5**2.5, rel=1e-9)
    integrals = strips.integrals_of(joint.walls, joint, strip, 4e-6)
    loads = strips.loads_along(joint.walls, joint, strip, 4e-6, (100.0, *integrals))
    assert loads.mean_load == pytest.approx(100.0 / 4e-3, rel=1e-9)
    assert loads.max_load == pytest.approx(2.5 * 100.0 / 4e-3, rel=1e-9)


def test_wear_of_a_journal_tilted_across_the_load_follows_its_hyperbola():
    """Its end is 12 um deep and its middle 0.6 um."""
    joint, tilt, ends = joint_of(), 7e-3, 2e-4 + 12e-6
    lean = tilt**2 * 0.01 / ends
    strip = strips.DepthProfile(0.01, lean, tilt**2)

    def depth(z):
        return math.sqrt(ends**2 - 2.0 * ends * lean * z + (tilt * z) ** 2) - 2e-4

    total = quad(lambda z: max(depth(z), 0.0) ** 1.5, 0.0, 0.01)[0]
    slices = [(k * 1e-3, (k + 1) * 1e-3) for k in range(10)]
    known = [quad(lambda z: max(depth(z), 0.0) ** 1.5, *interval)[0] / total for interval in slices]
    result = [load_fraction(joint, strip, 12e-6, interval) for interval in slices]
    assert result == pytest.approx(known, rel=1e-2, abs=1e-3)
    straight = 1e-2 * (12e-6 - 10e-3 * lean)
    assert depth(0.01) > straight  # the straight line from the end would lift off


# ---------------------------------------------------------------------------------------------- whole motions


def sliding_out(walls):
    """Return the case of a journal without flanges that gravity draws out of its bearing along the axis."""
    case = spatial(ideal="cylindrical", walls=walls, **THROUGH)
    case["mechanism"]["gravity"] = [0.0, 0.0, -9.81]
    case["simulate"] |= {"revolutions": 3.0, "tolerance": 1e-8}
    return case


@pytest.mark.plain
@pytest.mark.parametrize("walls", ["ends", "spread"])
def test_a_journal_that_leaves_its_bearing_ends_the_run_and_says_so(walls):
    result = clearsweep.simulate(clearsweep.load_case(sliding_out(walls)), times=[0.0])
    assert result.status == "left-bearing"
    assert "crank-rod leaves its bearing at" in result.message
    assert "axial distance of their middles is 20 mm" in result.message
    assert "flange: true" in result.message
    assert result.summary["crank_rod_force_peak"] is None
    assert len(result.events) > 0
    time = float(result.message.split(" at ")[1].split(" s")[0])
    falling = math.sqrt(2.0 * 0.02 / 9.81)
    if walls == "ends":  # nothing but gravity along the axis
        assert time == pytest.approx(falling, rel=1e-5)
    else:  # what is stored in the length that is still pressed goes into the motion outwards
        assert 0.9 * falling < time < falling
    assert result.events["t"].max() < time


@pytest.mark.parametrize(
    ("roots", "shares"),
    [
        ((1e-9, 1e-9), [0.5**0.5] * 2),
        ((0.0, 0.0), [0.5**0.5] * 2),
        ((0.0, 1e-9), [1.0, 0.0]),
        ((-3e-9, 4e-9), [0.8, -0.6]),
    ],
)
def test_walls_that_separate_together_have_the_time_scale_of_those_that_nearly_do(roots, shares):
    """1/kappa = sigma sqrt(1/s1^2 + 1/s2^2): of equal roots kappa is 0.71 of each over sigma, down to zero."""
    scene = clearsweep.load_case(spatial(walls="spread", contact=HERTZ)).value
    first_root, pairs = 2 * len(scene.coordinates) + 1, contact_modes(scene.joints[0])
    mode = np.array([pairs[0].pressed, pairs[1].pressed, FREE, FREE, ACTS, ACTS])
    y = np.zeros(first_root + 6)
    y[first_root : first_root + 2] = roots
    kappa = time_scale(scene, y, mode)
    assert kappa == pytest.approx(roots[0] * shares[0] / scene.sigma, rel=1e-15)
    over_roots = [kappa_over_root(scene, y, mode, kappa, c) * scene.sigma for c in range(2)]
    assert over_roots == pytest.approx(shares, rel=1e-15)


def test_a_jammed_journal_without_load_has_no_friction():
    """Where the axes meet in the middle of its length, friction has no direction."""
    joint = joint_of(friction={"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-3})
    jam = joints.jam_angle(joint)
    gap = gap_of([0.0, 0.0, 0.0], [math.sin(jam), 0.0, math.cos(jam)], velocity=Vector(1.0, 0.2, 0.0))
    pairs = contact_modes(joint)
    mode = np.array([pairs[0].pressed, pairs[1].pressed, FREE, FREE, ACTS, ACTS])
    loads = load(joint, gap, Offsets(0, 0, 0, 0), JointState(np.zeros(8), mode, np.full(6, 0.1), 0))
    assert [*loads.force, *loads.journal_moment, *loads.bearing_moment] == [0.0] * 9
    touching = JointState(np.array([1e-9, 0.0, *[0.0] * 6]), mode, np.full(6, 0.1), 0)
    assert np.isfinite([*load(joint, gap, Offsets(0, 0, 0, 0), touching).force]).all()


@pytest.mark.slow
@pytest.mark.heavy
@pytest.mark.compiled
def test_nothing_is_lost_where_spread_walls_give_all_back():
    case = spatial(walls="spread", contact=HERTZ, tilt=[0.005, 0.003], offset=[0.0, 0.0, 5e-5])
    result = clearsweep.simulate(clearsweep.load_case(case), times=[0.03])
    assert result.status == "ok"
    assert len(result.events) > 20
    assert result.summary["energy_residual"] < 1e-12


@pytest.mark.heavy
@pytest.mark.few
@pytest.mark.parametrize("tilt", [[2e-3, 0.0], [4e-3, 0.0], [0.0, 4e-3]])
def test_after_a_contact_a_tilted_rod_turns_as_a_second_program_with_60_slices_says(tilt):
    case = spatial(walls="spread", clearance=1e-4, axial_clearance=2e-3, tilt=tilt, contact=HERTZ | {"stiffness": 6e9})
    rod = {"length": 0.12, "mass": 0.21, "inertia": [3e-5, 2.5e-4, 2.6e-4], "center": [0.05, 0.0, 0.0]}
    case["mechanism"] |= {"rod": rod, "gravity": [0.0, -9.81, 3.0]}
    case["drive"]["speed"] = 100.0
    case["simulate"] |= {"revolutions": 0.024, "tolerance": 1e-9}
    time = 0.024 * 2.0 * math.pi / 100.0
    result = clearsweep.simulate(clearsweep.load_case(case), times=[time])
    known = SlicedOracle(case).move(time)[16:]
    spin = np.array([result[f"rod/w{axis}"][0] for axis in "xyz"])
    if tilt[0] == 2e-3:
        assert known[0] == pytest.approx(4.78, abs=0.01)
    assert spin == pytest.approx(known, rel=0.0, abs=0.02 * np.abs(known[:2]).max())
