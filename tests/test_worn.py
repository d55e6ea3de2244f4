"""Worn surfaces that act: where they touch, what they do to their bodies, and what becomes of them.

Kernels run as Python here.  Shapes are sums of harmonics m, of which the smoothing leaves exp(-(m WIDTH)^2 / 2).
"""

import math

import numpy as np
import pytest
from law_cases import joint as joint_of
from law_cases import names
from mechanism_cases import changed, slider_crank
from right_grids import grid_of
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

import clearsweep
from clearsweep import grid, simulation
from clearsweep.contracts.case import Wear
from clearsweep.mechanics.coupling.rates import evaluate_motion
from clearsweep.mechanics.joints import dry, registry
from clearsweep.mechanics.joints.contract import every_contact
from clearsweep.mechanics.joints.foundation import (
    EdgeRows,
    OverlapRows,
    arc_at,
    pressure_integral_over_load,
    update_wear_under_arcs,
)
from clearsweep.mechanics.joints.worn import (
    GapWithAngles,
    WornJoint,
    WornOnFoundation,
    generalised_depth,
    nearest,
    worn_load,
)
from clearsweep.mechanics.laws.contract import PRESSED
from clearsweep.mechanics.laws.elastic import elastic_energy, elastic_force
from clearsweep.mechanics.wear import Bins, Worn, local_clearance
from clearsweep.mechanics.wear.arc import POINTS, WORKSPACE_SIZE, workspace_of
from clearsweep.mechanics.wear.shape import (
    CONFORMAL_MARGIN,
    CONFORMAL_WIDTH,
    KNOT_SPACING,
    KNOTS,
    POINT_MARGIN,
    SMOOTHING_WIDTH,
    bin_means,
    conformal_profiles,
    fit_profile,
    least_radius_change,
    point_profiles,
    shape_of,
    smooth_depths,
    spline_through,
    wear_depth_at,
    wear_integral_at,
)
from clearsweep.verify.measured.contact import worn_in_grid

C, BINS = 1e-3, 360  # m, 1: clearance of the reference joint
WORN = Wear("archard", "mean", BINS, {"bearing_coefficient": 2e-14, "journal_coefficient": 2e-14}, evolve=True)
BEDDED = WORN._replace(pressure="winkler")
NOTHING = np.zeros(BINS)


class Wave:
    """h = sum of a_m (1 + cos(m phi + b_m)), its bins, and what smoothing leaves of it; `parts` : m, a_m, b_m.

    width : rad, standard deviation of the Gaussian
    """

    def __init__(self, *parts, width=SMOOTHING_WIDTH):
        self.parts, self.width = parts, width

    def on_springs(self):
        """Return the wave as springs press on it."""
        return Wave(*self.parts, width=CONFORMAL_WIDTH)

    def bins(self, count=BINS):
        edges = np.arange(count + 1) * 2.0 * math.pi / count
        whole = sum(a * (edges + np.sin(m * edges + b) / m) for m, a, b in self.parts)
        return np.diff(whole) * count / (2.0 * math.pi)

    def __call__(self, phi, order=0):
        """Return h or a derivative of it, smoothed."""
        total = sum(a for _, a, _ in self.parts) if order == 0 else 0.0
        for m, a, b in self.parts:
            total = total + a * math.exp(-0.5 * (m * self.width) ** 2) * m**order * np.cos(
                m * phi + b + order * 0.5 * math.pi
            )
        return total


OVAL = Wave((2, 0.1 * C, 0.0))
BEARING, JOURNAL = Wave((2, 0.08 * C, 0.4), (3, 0.02 * C, 1.0)), Wave((2, 0.05 * C, -1.0), (5, 4e-3 * C, 0.3))
ON_SPRINGS = BEARING.on_springs(), JOURNAL.on_springs()


def joint(bearing=NOTHING, journal=NOTHING, wear=WORN, **laws):
    """Return the compiled form of the reference joint with these worn depths and laws."""
    case = joint_of(**({"law": "hertz"} | laws))._replace(wear=wear, clearance=C)
    return registry.compile_joint(case, "rod", Worn(bearing, journal))


def gap(x, y, angles=(0.3, -0.7), rates=(0.0, 0.0, 0.0, 0.0)):
    return GapWithAngles(x, y, rates[0], rates[1], rates[2], rates[3], *angles)


def overlap(x, y, angles, phi, shapes=(BEARING, JOURNAL)):
    """Return e . u - c - h, of the closed forms."""
    h = shapes[0](phi - angles[0]) + shapes[1](phi - angles[1])
    return x * np.cos(phi) + y * np.sin(phi) - C - h


def test_what_is_worn_keeps_its_volume_and_its_harmonics_and_nothing_stays_nothing():
    for count in (45, 360, 1000):
        spline = spline_through(smooth_depths(BEARING.bins(count), SMOOTHING_WIDTH))
        phi = np.linspace(0.0, 2.0 * math.pi, 701)
        assert spline(phi) == pytest.approx(BEARING(phi), rel=1e-6, abs=1e-7 * C)
        assert spline(phi, 2) == pytest.approx(BEARING(phi, 2), rel=1e-3, abs=1e-4 * C)
    bins = np.random.default_rng(3).random(BINS) * C
    shape = shape_of(point_profiles(bins, NOTHING, C)[0][0])
    assert shape.integral == pytest.approx(bins.mean() * 2.0 * math.pi, rel=1e-12)
    for low, high in ((0.2, 1.7), (-3.0, 8.0), (6.2, 6.4)):
        total = quad(lambda phi: wear_depth_at(shape.table, phi)[0], low, high, limit=500, epsabs=1e-9 * C)[0]
        assert wear_integral_at(shape, high) - wear_integral_at(shape, low) == pytest.approx(total, rel=1e-6)
    (circle, _), width = point_profiles(NOTHING, NOTHING, C)
    circle = shape_of(circle)
    assert width == SMOOTHING_WIDTH
    assert all(wear_depth_at(circle.table, angle) == (0.0, 0.0, 0.0, 0.0) for angle in (0.0, 3.0, 1e4))


@pytest.mark.parametrize("depth", [0.05 * C, C, 20.0 * C])
def test_a_groove_narrower_than_the_journal_is_widened_to_its_bottom(depth):
    bins = np.zeros(BINS)
    bins[40:60] = depth
    profiles, width = point_profiles(bins, np.roll(bins, 100), C)
    bearing, journal = (shape_of(profile) for profile in profiles)
    angles = np.arange(KNOTS) * KNOT_SPACING
    rows = [np.array([wear_depth_at(body.table, angle) for angle in angles]) for body in (bearing, journal)]
    assert C + sum(np.min(row[:, 0] + row[:, 2]) for row in rows) >= POINT_MARGIN * C * (1.0 - 1e-9)
    assert width > SMOOTHING_WIDTH
    assert bearing.integral == pytest.approx(bins.mean() * 2.0 * math.pi, rel=1e-12)


def test_the_deepest_point_of_an_oval_bearing_is_that_of_the_closed_form():
    """e cos(phi) - a (1 + cos 2 phi) is largest at 0 for e > 4 a, and at cos(phi) = e / (4 a) below."""
    worn, a = joint(OVAL.bins()), 0.1 * C * math.exp(-2.0 * SMOOTHING_WIDTH**2)
    for e in (0.3 * C, 0.39 * C, 0.5 * C, 1.3 * C):
        cosine = min(e / (4.0 * a), 1.0)
        expected = e * cosine - 0.1 * C - a * (2.0 * cosine**2 - 1.0) - C
        for turn in (0.0, 0.4, 5.0):  # of all together
            there = nearest(worn, gap(e * math.cos(turn), e * math.sin(turn), (turn, 2.0)))
            assert there.depth == pytest.approx(expected, rel=1e-7)
            assert there.nx * math.cos(turn) + there.ny * math.sin(turn) == pytest.approx(cosine, abs=2e-6)
    upright = nearest(worn, gap(0.0, 1.2 * C, (0.0, 0.0)))
    assert upright.depth == pytest.approx(0.2 * C - (0.1 * C - a), rel=1e-7)
    assert local_clearance(worn, 0.0, 0.0) == pytest.approx(1.1 * C - 3.0 * a, rel=3e-4)
    assert local_clearance(worn, 0.5 * math.pi, 0.0) == pytest.approx(1.1 * C + 3.0 * a, rel=3e-4)


@pytest.mark.parametrize("size", [0.0, 0.02, 0.4, 0.9, 1.15, 1.5])
def test_the_deepest_point_is_the_deepest_of_all_and_turns_with_its_bodies(size):
    worn, phi, angles = joint(BEARING.bins(), JOURNAL.bins()), np.linspace(0.0, 2.0 * math.pi, 20001), (0.3, -0.7)
    for direction in (0.1, 1.9, 4.0):
        x, y = size * C * math.cos(direction), size * C * math.sin(direction)
        place = phi[np.argmax(overlap(x, y, angles, phi))]
        within = minimize_scalar(
            lambda at, x=x, y=y: -overlap(x, y, angles, at), (place - 1e-3, place + 1e-3), tol=1e-15
        )
        there = nearest(worn, gap(x, y, angles))
        far = size < 0.1  # from contact, where several places are about as close
        assert there.depth == pytest.approx(-within.fun, rel=1e-3 if far else 1e-7)
        turned = nearest(worn, gap(-y, x, (angles[0] + 0.5 * math.pi, angles[1] + 0.5 * math.pi)))
        if not far:
            assert (turned.depth, turned.nx, turned.ny) == pytest.approx((there.depth, -there.ny, there.nx), abs=1e-9)


@pytest.mark.parametrize("size", [0.02, 0.4, 0.9, 1.15, 1.5])
def test_the_deepest_point_is_the_same_from_wherever_it_was_found_last(size):
    worn, angles = joint(BEARING.bins(), JOURNAL.bins()), (0.3, -0.7)
    for direction in (0.1, 1.9, 4.0):
        place = gap(size * C * math.cos(direction), size * C * math.sin(direction), angles, (0.02, -0.1, 30.0, -80.0))
        expected = nearest(worn, place)
        starts = (0.0, 3.0, 1e-7, -1e-5, 1e-3, -3e-3, 0.1, math.pi, 2.0 * math.pi)
        for last_angle in (np.array([expected.angle + offset]) for offset in starts):
            for _ in range(2):
                there = nearest(worn, place, last_angle)
                assert there.depth == pytest.approx(expected.depth, abs=1e-12 * C)
                assert (there.nx, there.ny) == pytest.approx((expected.nx, expected.ny), abs=2e-8)
                assert there.rate == pytest.approx(expected.rate, rel=1e-6)
            assert math.remainder(last_angle[0] - there.angle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-15)


def test_the_least_penetration_is_known_far_from_the_eccentricity():
    """Springs find their arc from it: a millionth of the clearance too much, and there is none where they look."""
    grooves, angles = np.zeros((2, BINS)), (0.3, -0.7)
    grooves[0, 40:90], grooves[1, 200:230] = C, 0.1 * C
    worn = joint(*grooves, BEDDED, elastic="winkler")

    def gap_at(x, y, phi):
        h = (
            wear_depth_at(worn.bearing.table, phi - angles[0])[0]
            + wear_depth_at(worn.journal.table, phi - angles[1])[0]
        )
        return x * math.cos(phi) + y * math.sin(phi) - C - h

    far = 0.0
    for direction in np.linspace(0.0, 6.2, 100):
        x, y = 1.5 * C * math.cos(direction), 1.5 * C * math.sin(direction)
        there = nearest(worn, gap(x, y, angles))
        before, here, behind = (gap_at(x, y, there.angle + step) for step in (-1e-5, 0.0, 1e-5))
        far = max(far, abs(math.remainder(there.angle - direction, 2.0 * math.pi)))
        # edges of 1 degree: within the last step, 1e-4 rad, the third derivative may jump by 1e3 C
        assert there.depth == pytest.approx(here, abs=1e-8 * C)
        assert here >= max(before, behind) - 1e-8 * C
    assert far > 0.1


def measure(worn, numbers):
    """Return how deep a joint is at x, y and both angles (of bearing and journal)."""
    place = gap(numbers[0], numbers[1], numbers[2:])
    return generalised_depth(worn, nearest(worn, place), place).depth


@pytest.mark.parametrize("wear", [WORN, BEDDED])
def test_forces_and_moments_are_the_derivatives_of_what_is_stored(wear):
    worn = joint(BEARING.bins(), JOURNAL.bins(), wear, elastic="winkler")
    assert isinstance(worn, WornOnFoundation if wear is BEDDED else WornJoint)
    for state in ([1.5 * C, 0.3 * C, 0.3, -0.7], [-0.6 * C, 1.45 * C, 2.0, 4.0], [-0.4 * C, -1.4 * C, 0.0, 9.0]):
        place = gap(state[0], state[1], state[2:], (0.3, -0.2, 40.0, -90.0))
        pen = measure(worn, state)
        load = worn_load(worn, place, PRESSED, pen, 1.0)
        slopes = []
        for k, step in enumerate((1e-5 * C, 1e-5 * C, 1e-5, 1e-5)):
            near = [
                measure(worn, [value + sign * step * (i == k) for i, value in enumerate(state)]) for sign in (-1, 1)
            ]
            slopes.append((near[1] - near[0]) / (2.0 * step))
        force = elastic_force(worn.elastic, pen)
        done = load.fx, load.fy, load.moment_proximal, load.moment_distal
        assert done == pytest.approx([-force * slope for slope in slopes], rel=1e-6, abs=1e-8 * force * C)
        (contact,) = load.contacts
        power = force * (slopes[0] * 0.3 - slopes[1] * 0.2 + slopes[2] * 40.0 - slopes[3] * 90.0)
        assert contact.rate * force == pytest.approx(power, rel=1e-6)
        assert contact.elastic * contact.generalised_rate == pytest.approx(power, rel=1e-6)
        assert contact.normal == pytest.approx(math.hypot(load.fx, load.fy), rel=1e-12)


def test_an_error_of_the_root_does_not_grow_as_springs_are_relieved():
    """The depth and its rate are those of the surfaces, and the force vanishes with the root.

    A rate that is divided by the force at the root keeps a difference of energies, so that a small error under load
    ended contacts whose springs were still pressed: they stalled.
    """
    worn = joint(BEARING.bins(), JOURNAL.bins(), BEDDED, elastic="winkler")
    angles = (0.3, -0.7)
    touching = C - float(overlap(C, 0.0, angles, np.linspace(-0.5, 0.5, 10001), ON_SPRINGS).max())
    for depth in (3e-7, 1e-5, 1e-4, 1e-3):  # m
        place = gap(touching + depth, 0.0, angles, (0.02, -0.1, 0.0, 0.0))
        settled = measure(worn, [touching + depth, 0.0, *angles])
        (contact,) = worn_load(worn, place, PRESSED, settled, 1.0).contacts
        for pen in (1e-9 * C, 1e-2 * depth, 0.9 * settled):
            (lagging,) = worn_load(worn, place, PRESSED, pen, 1.0).contacts
            assert (lagging.depth, lagging.rate) == (settled, contact.rate)
            share = elastic_force(worn.elastic, pen) / elastic_force(worn.elastic, settled)
            assert lagging.elastic == pytest.approx(share * contact.elastic, rel=1e-12)


@pytest.mark.slow
def test_a_contact_relieved_on_worn_springs_takes_no_more_steps_than_another():
    source = worn_in_grid("foundation")
    simulate = source["simulate"] | {"revolutions": 1, "discard": 0, "step_budget": 5000}
    changes = {"life": None, "simulate": simulate, "joints.crank-rod.contact.onset": "renewed"}
    case = grid.load(changed(source, changes), simulation.catalogue()).case(0)
    # um, as worn in, every 20 degrees from 60: on it the root ended with the springs pressed by 0.57 N, in 3000 steps
    scar = [0.0, 0.6, 7.2, 18.6, 31.7, 41.2, 45.7, 44.7, 38.4, 27.7, 14.3, 4.8, 0.4, 0.0]
    bearing = 1e-6 * np.interp(2.0 * np.arange(180), 60.0 + 20.0 * np.arange(14), scar)
    path = clearsweep.simulate(simulation.build(case, {"crank-rod": Worn(bearing, np.zeros(180))}))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-6


def test_springs_store_what_the_integral_over_the_closed_gap_says():
    worn = joint(BEARING.bins(), JOURNAL.bins(), BEDDED, elastic="winkler")
    for state in ([1.5 * C, 0.3 * C, 0.3, -0.7], [-0.6 * C, 1.45 * C, 2.0, 4.0]):
        x, y, *angles = state
        phi = np.linspace(0.0, 2.0 * math.pi, 100001)
        f = np.maximum(overlap(x, y, angles, phi, ON_SPRINGS), 0.0)
        stored = 0.5 * worn.elastic.stiffness * np.trapezoid(f**2, phi)
        pen = measure(worn, state)
        circles = quad(lambda depth: elastic_force(worn.elastic, depth), 0.0, pen, epsrel=1e-12)[0]
        assert circles == pytest.approx(stored, rel=1e-6)
        assert elastic_energy(worn.elastic, pen) == pytest.approx(stored, rel=1e-5)
        load = worn_load(worn, gap(x, y, angles), PRESSED, pen, 1.0)
        for done, unit in ((load.fx, np.cos(phi)), (load.fy, np.sin(phi))):
            assert done == pytest.approx(-worn.elastic.stiffness * np.trapezoid(f * unit, phi), rel=1e-6)


def circles(worn):
    """Return the dry joint with the laws of a worn one."""
    return dry.Joint(*worn[:8])


@pytest.mark.parametrize("law", names("law"))
def test_where_nothing_is_worn_every_law_does_what_it_does_between_circles(law):
    elastics = names("elastic") if registry.RECIPES["law", law].law.uses_elastic else ["power"]
    for elastic in [elastic for elastic in elastics if elastic != "compatible-fit"]:
        worn = joint(law=law, elastic=elastic, friction="tanh")
        for direction, pen in ((0.0, 1e-6), (0.7, 1e-5), (4.0, 3e-7), (2.0, -1e-9)):
            e = C + pen
            place = gap(e * math.cos(direction), e * math.sin(direction), rates=(0.02, -0.1, 30.0, -80.0))
            a = worn_load(worn, place, PRESSED, pen, 0.2)
            b = dry.joint_load(circles(worn), dry.Gap(*place[:6]), PRESSED, pen, 0.2)
            size = abs(b.contacts[0].normal)
            assert a[:2] == pytest.approx(b[:2], rel=1e-12, abs=1e-12 * size)
            assert a[2:4] == pytest.approx(b[2:4], rel=1e-12, abs=1e-14 * size)
            assert a.contacts[0][:7] == pytest.approx(b.contacts[0][:7], rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("depth", [1e-12, 1e-9, 1e-6, 1e-4, 1e-3])
def test_where_nothing_is_worn_springs_press_as_the_closed_form_of_circles_has_it(depth):
    worn = joint(wear=BEDDED, law="lankarani-nikravesh", elastic="winkler", friction="tanh")
    for direction in (0.0, 0.7, 4.0):
        e = C + depth
        place = gap(e * math.cos(direction), e * math.sin(direction), rates=(0.02, -0.1, 30.0, -80.0))
        a = worn_load(worn, place, PRESSED, depth * (1.0 + 1e-9), 0.2)
        b = dry.joint_load(circles(worn), dry.Gap(*place[:6]), PRESSED, depth * (1.0 + 1e-9), 0.2)
        size = abs(b.contacts[0].normal)
        assert a[:2] == pytest.approx(b[:2], rel=1e-8, abs=1e-8 * size)
        assert a[2:4] == pytest.approx(b[2:4], rel=1e-8, abs=1e-10 * size)
        assert a.contacts[0].depth == pytest.approx(depth, rel=1e-7, abs=1e-18)
        assert a.contacts[0].rate == pytest.approx(b.contacts[0].rate, rel=1e-8)


# ---------------------------------------------------------------------------------------------- wear on springs


def room_at(on_bearing, on_journal, depth):
    """Return what a step knows of a contact that rests still."""
    workspace = workspace_of(np.zeros(WORKSPACE_SIZE))
    workspace.step.bearing_angle[0], workspace.step.journal_angle[0] = on_bearing, on_journal
    workspace.step.penetration[0] = depth
    return workspace


def wear_under(worn, arcs, body, areas, bins):
    """Return the depths (m) of `bins` bins of a body that is worn by `areas` (m rad) under arcs."""
    depths, rows = np.zeros(bins), OverlapRows(np.zeros((OverlapRows.SIZE, POINTS)))
    for i, arc in enumerate(arcs):
        rows.numbers[:8, i] = (*arc[:2], *arc.body_angles, *arc[3:])
    rows.area[: len(arcs)] = areas
    bodys_bins, edge_rows = Bins(depths, 0, bins), EdgeRows(np.zeros((EdgeRows.SIZE, POINTS)))
    update_wear_under_arcs(worn, rows, body, len(arcs), bodys_bins, edge_rows)
    return depths


def test_springs_wear_every_bin_by_how_deep_they_are_pressed_there():
    worn = joint(BEARING.bins(), JOURNAL.bins(), BEDDED, elastic="winkler")
    x, y, angles = 1.5 * C, 0.3 * C, (0.3, -0.7)
    there = nearest(worn, gap(x, y, angles))
    normal = math.atan2(there.ny, there.nx)
    arc = arc_at(worn, room_at(normal - angles[0], normal - angles[1], there.depth), 0.5)
    edges = np.arange(BINS + 1) * 2.0 * math.pi / BINS
    fine = np.linspace(0.0, 2.0 * math.pi, 100 * BINS + 1)
    for body, angle in enumerate(angles):
        depths = wear_under(worn, [arc], body, [2e-9], BINS)
        assert depths.sum() * 2.0 * math.pi / BINS == pytest.approx(2e-9, rel=1e-12)
        before = np.append(
            0.0, np.cumsum(np.maximum(overlap(x, y, angles, fine[:-1] + angle + 0.5 * fine[1], ON_SPRINGS), 0.0))
        )
        expected = np.diff(np.interp(edges, fine, before)) / before[-1] * 2e-9 / edges[1]
        assert depths == pytest.approx(expected, rel=2e-4, abs=1e-6 * depths.max())
    f = np.maximum(overlap(x, y, angles, fine, ON_SPRINGS), 0.0)
    resultant = np.hypot(np.trapezoid(f * np.cos(fine), fine), np.trapezoid(f * np.sin(fine), fine))
    assert pressure_integral_over_load(worn, arc) == pytest.approx(np.trapezoid(f, fine) / resultant, rel=1e-7)


def test_arcs_that_move_wear_each_bin_as_each_of_them_alone():
    """Also one that does not touch, and where both bodies have turned many times."""
    worn, places = joint(BEARING.bins(), JOURNAL.bins(), BEDDED, elastic="winkler"), np.linspace(0.3, 0.9, POINTS)
    rooms = [room_at(40.0 + place, 6.0 * math.pi - 2.0 * place, (place - 0.4) * C) for place in places]
    arcs, areas = [arc_at(worn, workspace, 0.5) for workspace in rooms], np.linspace(1e-9, 3e-9, POINTS)
    areas[places <= 0.4] = 0.0
    assert areas[0] == 0.0 < areas[-1]
    for body in (0, 1):
        alone = [wear_under(worn, [arc], body, [area], BINS) for arc, area in zip(arcs, areas, strict=True) if area]
        together = wear_under(worn, arcs, body, areas, BINS)
        assert together == pytest.approx(np.sum(alone, axis=0), rel=1e-9, abs=1e-9 * together.max())
        assert together.sum() * 2.0 * math.pi / BINS == pytest.approx(areas.sum(), rel=1e-12)


@pytest.mark.parametrize("depth", [1e-6, 1e-5, 1e-4, 1e-2, 0.3])
def test_the_resultant_in_a_scar_is_the_integral_over_all_knots_of_it(depth):
    """Conforming surfaces are pressed by less than their splines vary from knot to knot."""
    edges, journal = np.arange(BINS) * 2.0 * math.pi / BINS, JOURNAL.bins()
    bearing = C * np.maximum(1.7 * np.cos(edges - 1.0) - 1.0, 0.0) * (1.0 - 0.01 * (np.arange(BINS) % 3 == 0))
    worn = joint(bearing, journal, BEDDED, elastic="winkler")
    arc = arc_at(worn, room_at(1.1, 6.0 * math.pi - 0.4, depth * C), 0.5)
    psi = np.linspace(arc.start_angle, arc.stop_angle, 100001)
    f = arc.cos_coefficient * np.cos(psi) + arc.sin_coefficient * np.sin(psi) - C
    for profile, turn in zip(conformal_profiles(bearing, journal, C), arc.body_angles, strict=True):
        f -= spline_through(profile)(psi - turn)
    resultant = np.hypot(np.trapezoid(f * np.cos(psi), psi), np.trapezoid(f * np.sin(psi), psi))
    assert pressure_integral_over_load(worn, arc) == pytest.approx(np.trapezoid(f, psi) / resultant, rel=1e-7)


def run_in(bins, cycles, step=0.035):
    """Return the bearing's depths after cycles of steady sliding under a load that presses new circles half C deep.

    Every cycle takes off `step` clearances times a rad, spread like the pressure: a few hundredths of C.
    """
    depths = np.zeros(bins)
    load = elastic_force(joint(wear=BEDDED, elastic="winkler").elastic, 0.5 * C)
    for _ in range(cycles):
        worn = joint(depths, NOTHING, BEDDED, elastic="winkler")

        def missing(e, worn=worn):
            arc = arc_at(worn, room_at(0.0, 0.0, nearest(worn, gap(e, 0.0, (0.0, 0.0))).depth), 0.5)
            return worn.elastic.stiffness * arc.overlap_integral / pressure_integral_over_load(worn, arc) - load

        e = brentq(missing, C + wear_depth_at(worn.bearing.table, 0.0)[0] + 1e-3 * C, 6.0 * C, xtol=1e-9 * C)
        depth = nearest(worn, gap(e, 0.0, (0.0, 0.0))).depth
        arc = arc_at(worn, room_at(0.0, 0.0, depth), 0.5)
        depths += wear_under(worn, [arc], 0, [step * C], bins)
    return depths


@pytest.mark.slow
def test_a_bearing_run_in_under_springs_continues_as_a_shifted_circle():
    """h = h_m cos(phi): once it has run in, every cycle takes off as much along the load, whatever the place."""
    positions = (np.arange(180) + 0.5) * 2.0 * math.pi / 180
    within = np.cos(positions) > math.cos(math.radians(40.0))
    shift = np.cos(positions[within]) / math.cos(positions[0])
    new, worn = run_in(180, 1), run_in(180, 60)
    taken = run_in(180, 61) - worn
    assert worn[0] > 1.3 * C
    assert np.max(np.abs(new[within] / new[0] - shift)) > 0.3
    assert taken[within] / taken[0] == pytest.approx(shift, abs=0.025)


@pytest.mark.slow
def test_finer_bins_converge_at_second_order_or_better():
    finest = run_in(2880, 8)

    def error(bins):
        return np.max(np.abs(run_in(bins, 8) - finest.reshape(bins, -1).mean(axis=1)))

    coarsest = error(45)
    for bins in (90, 180, 360):  # of two successive ones the finer may be as good by chance
        assert error(bins) < (45 / bins) ** 2 * coarsest


# ---------------------------------------------------------------------------------------------- whole motions

WEAR = {"law": "archard", "coefficient": 2e-14, "bins": BINS, "pressure": "mean", "evolve": True}
SPRINGS = {"law": "hertz", "elastic": "winkler", "thickness": 5e-3, "material": {"young": 207e9, "poisson": 0.3}}
SHAPES = Wave((2, 5e-5, 0.3)), Wave((3, 2e-5, 1.0))  # at a clearance of 0.5 mm


def motion(worn=True, **changes):
    """Return the trajectory of a slider-crank whose small end is worn before."""
    inner = {f"joints.rod-slider.{path.replace('__', '.')}": value for path, value in changes.items()}
    keep = {"save.orbits": "all", "save.samples": 20000, "simulate.revolutions": 0.06, "simulate.discard": 0}
    source = slider_crank("rod-slider", changes=keep | {"joints.rod-slider.wear": WEAR})
    case = grid.load(changed(source, inner), simulation.catalogue()).case(0)
    shapes = Worn(*(shape.bins() for shape in SHAPES))
    path = clearsweep.simulate(simulation.build(case, {"rod-slider": shapes} if worn else None))
    assert path.status == "ok"
    return path


def depths_of(path):
    """Return how deep the surfaces are in each other at the samples of a motion, by the closed form of the shapes."""
    x, y = path["joints/rod_slider/x"], path["joints/rod_slider/y"]
    phi = np.linspace(0.0, 2.0 * math.pi, 4000)[:, None]
    rod = path["rod/angle"]  # the journal is on the rod, the bearing on the slider, which does not turn
    h = SHAPES[0](phi) + SHAPES[1](phi - rod)
    return np.max(x * np.cos(phi) + y * np.sin(phi) - 0.5e-3 - h, axis=0)


@pytest.mark.plain
@pytest.mark.parametrize("contact", [{"law": "hertz", "stiffness": 6.61e10}, SPRINGS])
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_worn_surfaces_lose_no_energy_and_touch_where_their_shapes_do(contact, method):
    pressure = "winkler" if contact is SPRINGS else "mean"
    path = motion(contact=contact, wear__pressure=pressure)
    assert path.summary["energy_residual"] < 1e-9
    touching = path["joints/rod_slider/force_normal"] > 0.0
    deep = depths_of(path)
    assert touching.any()
    assert np.all(deep[touching] > -2e-9)  # m: of the grid of directions
    assert np.all(deep[~touching] < 1e-12)


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("contact", [{"law": "hertz", "stiffness": 6.61e10}, SPRINGS])
def test_the_energy_ledger_of_a_revolution_on_worn_surfaces_closes(contact):
    pressure = "winkler" if contact is SPRINGS else "mean"
    path = motion(contact=contact, wear__pressure=pressure, wear__bins=BINS)
    assert path.summary["energy_residual"] < 1e-9
    assert path.summary["rod_slider_impacts_per_rev"] > 0.0


def test_a_joint_is_worn_as_its_grid_says():
    source = slider_crank("rod-slider", changes={"joints.rod-slider.wear": WEAR})
    scene = simulation.load_case(source)
    assert type(scene.value.joints[0]) is WornJoint
    springs = {"joints.rod-slider.contact": SPRINGS, "joints.rod-slider.wear.pressure": "winkler"}
    assert type(simulation.load_case(changed(source, springs)).value.joints[0]) is WornOnFoundation
    plain = simulation.load_case(changed(source, {"joints.rod-slider.wear.evolve": False}))
    assert type(plain.value.joints[0]) is dry.Joint


@pytest.mark.parametrize("contact", [{"law": "hertz", "stiffness": 6.61e10}, SPRINGS])
def test_a_seated_journal_bears_its_load_where_it_is_worn_too(contact):
    wear = WEAR | {"pressure": "winkler"}
    changes = {"simulate.start": "seated", "joints.rod-slider.wear": wear, "joints.rod-slider.contact": contact}
    case = grid.load(slider_crank("rod-slider", changes=changes), simulation.catalogue()).case(0)
    forces = []
    for worn in (None, {"rod-slider": Worn(*(shape.bins() for shape in SHAPES))}):
        scene = simulation.build(case, worn)
        (load,) = loads_at_the_start(scene)
        forces.append((load.fx, load.fy))
        assert scene.start[-1] ** 2 == pytest.approx(load.contacts[0].depth, rel=1e-6)
    assert math.hypot(*forces[0]) > 1.0
    assert forces[1] == pytest.approx(forces[0], rel=1e-4, abs=1e-4 * math.hypot(*forces[0]))


def loads_at_the_start(scene):
    """Return the Loads of a scene that begins in contact."""
    modes = np.array([modes.pressed for _, modes in every_contact(scene.value.joints)])
    return evaluate_motion(scene.value, scene.start, modes, np.ones(modes.size))[2]


# ---------------------------------------------------------------------------------------------- scars


def test_the_conformal_profile_is_the_nearest_of_its_volume_that_the_journal_fits():
    """Of the convex set of such profiles q it is the nearest to h: (h - q) . (p - q) <= 0 for every other member p."""
    angles = np.arange(KNOTS) * KNOT_SPACING
    groove = np.maximum(2.0 * C * np.cos(angles - 3.0) - 1.2 * C, 0.0) + 0.02 * C * np.cos(40.0 * angles)
    least = (CONFORMAL_MARGIN - 1.0) * C
    assert least_radius_change(groove) < least
    fitted = fit_profile(groove, least)
    assert fitted.mean() == pytest.approx(groove.mean(), rel=1e-10)
    assert least_radius_change(fitted) == pytest.approx(least, rel=1e-6)
    assert np.abs(fitted - groove).max() < 0.1 * C
    chance = np.random.default_rng(5)
    for order in (1, 2, 3, 5, 8):
        other = np.cos(order * angles + chance.uniform(0.0, 6.0)) * chance.uniform(0.0, 1.0) * C / (order**2 + 1)
        other += groove.mean()
        assert least_radius_change(other) >= least
        assert (groove - fitted) @ (other - fitted) <= 1e-9 * C * C
    smooth = 0.1 * C * np.cos(2.0 * angles)
    assert fit_profile(smooth, least) is smooth


SCAR_RADIUS, SCAR_LENGTH, SCAR_LOAD, SCAR_COEFFICIENT, SCAR_CLEARANCE = 0.02, 0.02, 100.0, 1e-14, 1e-4
SCAR_LAYER = 0.6 * 30e6 / (1.4 * 0.2 * 1e-3)  # Pa/m, of the layer in `scar`


def scar_revolutions(depth, *, radius=SCAR_RADIUS, clearance=SCAR_CLEARANCE, load=SCAR_LOAD):
    """Return the turns of a shaft to a scar's depth: a circle of the journal's radius moves into the bearing.

    The pressure varies as cos(phi) over the half-angle t of the scar, cos t = c / (c + h).
    """

    def growth(h):
        t = math.acos(clearance / (clearance + h))
        return t + math.sin(t) * math.cos(t)

    per_depth = SCAR_LENGTH * radius / (SCAR_COEFFICIENT * load * 2.0 * math.pi * (radius - clearance))
    return per_depth * quad(growth, 0.0, depth)[0]


def layer_revolutions(depth, shape, turns=2000.0, bins=720):
    """Return the turns to a scar's depth on springs by Euler's method; shape : bins (m) -> those that are pressed."""
    angles = (np.arange(bins) + 0.5) * 2.0 * math.pi / bins
    cosines, width = np.cos(angles - math.pi), 2.0 * math.pi / bins
    depths, total, e = np.zeros(bins), 0.0, SCAR_CLEARANCE
    while True:
        pressed = shape(depths)

        def missing(e, pressed=pressed):
            f = np.maximum(e * cosines - SCAR_CLEARANCE - pressed, 0.0)
            return SCAR_LAYER * SCAR_RADIUS * SCAR_LENGTH * width * (f @ cosines) - SCAR_LOAD

        e = brentq(missing, SCAR_CLEARANCE, 4.0 * SCAR_CLEARANCE, xtol=1e-16)
        pressure = SCAR_LAYER * np.maximum(e * cosines - SCAR_CLEARANCE - pressed, 0.0)
        rate = SCAR_COEFFICIENT * pressure * 2.0 * math.pi * (SCAR_RADIUS - SCAR_CLEARANCE)
        if depths.max() + turns * rate.max() >= depth:
            return total + (depth - depths.max()) / rate.max()
        depths, total = depths + turns * rate, total + turns


def test_a_scar_under_the_acting_shape_grows_as_the_closed_form():
    """With a Gaussian that widens until the radii differ, the life of a scar of half a clearance is 24 % too short."""
    nothing, exact = np.zeros(720), scar_revolutions(5e-5)

    def acting(depths):
        return bin_means(conformal_profiles(depths, nothing, SCAR_CLEARANCE)[0], 720)

    bare, shaped = layer_revolutions(5e-5, lambda depths: depths), layer_revolutions(5e-5, acting)
    assert bare == pytest.approx(exact, rel=5e-3)
    assert shaped == pytest.approx(bare, rel=5e-3)


def scar(pressure, limit, *, springs=False, clearance=SCAR_CLEARANCE, load=SCAR_LOAD, bins=720):
    """Return the life of a bearing on sliding guides, pressed on a turning shaft by a constant load."""
    layer = {"law": "hunt-crossley", "restitution": 0.5, "elastic": "winkler", "thickness": 1e-3}
    layer |= {"material": {"young": 30e6, "poisson": 0.4}}
    given = {"joints.dry.clearance": clearance, "loads.weight.force": [0.0, -load], "life.limit": limit}
    given |= {"joints.dry.wear.pressure": pressure, "joints.dry.wear.bins": bins}
    given |= {"joints.dry.contact": layer} if springs else {}
    return clearsweep.simulate(simulation.load_case(changed(grid_of("a bush on a turning shaft"), given)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "joint",
    [
        {"springs": True},
        {"springs": True, "limit": 1e-4},
        {"springs": True, "limit": 1e-4, "bins": 180},
        {"springs": True, "load": 40.0},
        {"springs": True, "clearance": 2e-4, "limit": 1e-4},
        {},
        {"limit": 1e-4},
        {"bins": 180},
    ],
)
def test_a_scar_is_a_circle_of_the_journal_and_takes_the_turns_of_the_closed_form(joint):
    """Springs and a force at one point, whose wear is distributed like the overlap of the surfaces."""
    limit, clearance = joint.get("limit", 5e-5), joint.get("clearance", SCAR_CLEARANCE)
    result = scar("winkler", **({"limit": 5e-5} | joint))
    figures = result.summary
    exact = scar_revolutions(limit, clearance=clearance, load=joint.get("load", SCAR_LOAD))
    assert figures["dry_life_revolutions"] == pytest.approx(exact, rel=0.02)
    assert figures["dry_life_low"] < exact < figures["dry_life_high"]
    assert 0.0 < figures["dry_life_shape_error"] < 0.02
    profile = result.history["dry/profile_bearing"][-1]
    angles = (np.arange(profile.size) + 0.5) * 2.0 * math.pi / profile.size - 0.5 * math.pi
    circle = np.maximum((clearance + limit) * np.cos(angles) - clearance, 0.0)
    assert profile == pytest.approx(circle, rel=0.0, abs=0.03 * limit)


@pytest.mark.slow
@pytest.mark.parametrize("pressure", ["mean"])
def test_a_pressure_from_curvatures_ends_where_surfaces_fit_each_other(pressure):
    result = scar(pressure, 5e-5)
    assert result.status == "ok"
    assert result.summary["dry_life_revolutions"] is None
    depth = float(result.history["dry/wear_depth_max"][-1])
    assert 0.0 < depth < 0.25 * SCAR_CLEARANCE
    assert f"conformal: dry is worn {1e3 * depth:.4g} mm deep after" in result.message
    assert "set wear.pressure: winkler" in result.message
