"""What every pressure and every wear law must do, whichever recipes there are; kernels run as Python.

The recipes come from the registry.  A new one has to obey all claims.  It also needs its documented formula in
`PRESSURES` or `AREAS` of `wear_oracle`; the test that fails says which.
"""

import itertools
import math

import numpy as np
import pytest
from law_cases import RECIPES, length_power, names, numbers
from rubbing import History, steady, worn_off
from scipy.integrate import cumulative_trapezoid, quad
from wear_oracle import AREAS, PRESSURES, Sizes, bin_edges, spread

from clearsweep.contracts.case import Contact, Friction, Joint, Material, Materials, Wear
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.elastic import SMALL_ARC
from clearsweep.mechanics.wear import (
    SlidingContact,
    cumulative_pressure,
    half_arc,
    peak_over_mean,
    pressure_integral_over_load,
    smooth_range,
)

CLEARANCE, BEARING, LENGTH = 0.5e-3, 0.01, 0.02  # m
JOURNAL = BEARING - CLEARANCE
STEEL = Material(207e9, 0.3)
COEFFICIENTS = {"bearing_coefficient": 1e-14, "journal_coefficient": 3e-14}
RUNNING_IN = {"bearing_initial": 5e-14, "journal_initial": 4e-14, "distance": 0.01}
#: Line loads (N/m) and penetrations (m): arcs from less than a degree to the widest.
POINTS = [(1e3, 1e-8), (1e4, 1e-6), (1e5, 1e-5), (3e6, 2e-4), (3e7, 2e-3), (3e8, 5e-2)]


def case_of(pressure="mean", wear="archard", running_in=None, bins=720, scale=1.0):
    """Return a steel joint of a case that wears so; `scale` : of its unit of length, 1000 for mm."""
    values, steel = dict(COEFFICIENTS), Materials(*2 * (STEEL._replace(young=STEEL.young / scale),))
    for law in (RECIPES["pressure", pressure].law, RECIPES["wear", wear].law):
        required = [field for field in law.fields if not field.optional]
        values |= {
            key: value * scale ** length_power(unit)
            for (key, value), unit in zip(
                numbers(law._replace(fields=required)).items(), [field.unit for field in required], strict=True
            )
        }
    return Joint(
        "rod-slider",
        CLEARANCE * scale,
        Contact("hertz", "power", {"stiffness": 6.61e10, "exponent": 1.5}, steel),
        BEARING * scale,
        LENGTH * scale,
        friction=Friction("coulomb", {"coefficient": 0.1}),
        wear=Wear(wear, pressure, bins, values, running_in=running_in),
    )


def term_of(case):
    """Return the compiled form of a joint whose journal is on the slider, without its friction."""
    return registry.compile_joint(case._replace(friction=None), "slider")


def sliding(load, depth, clearance=CLEARANCE, **changes):
    """Return the SlidingContact of a line load (N/m) at a penetration (m)."""
    return SlidingContact(load, depth, 0.3, 0.0, 0.0, load, clearance, 0.0)._replace(**changes)


def arcs_of(name):
    """Return the compiled pressure and half of its arcs (rad) at the POINTS."""
    joint = term_of(case_of(name))
    pressure = joint.wear.pressure
    return pressure, [half_arc(pressure, joint, BEARING, sliding(*point)) for point in POINTS]


# ---------------------------------------------------------------------------------------------- pressures


@pytest.mark.parametrize("name", names("pressure"))
def test_the_share_of_a_pressure_before_a_place_grows_from_zero_to_one(name):
    pressure, halves = arcs_of(name)
    positions = np.linspace(-1.3, 1.3, 521)
    for half in halves:
        shares = np.array([cumulative_pressure(pressure, x, half) for x in positions])
        assert np.all(shares[positions <= -1.0] == pytest.approx(0.0, abs=1e-9))
        assert np.all(shares[positions >= 1.0] == pytest.approx(1.0, abs=1e-9))
        assert np.all(np.diff(shares) >= -1e-9)
        assert shares + shares[::-1] == pytest.approx(1.0, abs=1e-8)  # the load is in the middle of the arc
        assert np.all(np.diff(shares[np.abs(positions) < 0.99]) > 0.0)
    assert 0.0 < smooth_range(pressure) <= 1.0


@pytest.mark.parametrize("name", names("pressure"))
def test_the_resultant_of_a_pressure_is_the_load(name):
    """S int cos(psi) dshare = 1, S being the sum over the load; by parts, so that only shares are needed.

    A law that takes the bodies for half-spaces sums the pressure along the load, so that it lacks a cosine, which is
    1 to within half^2 / 2.
    """
    pressure, halves = arcs_of(name)
    flat = SMALL_ARC in RECIPES["pressure", name].law.trusted
    assert min(halves) < 0.05
    for half in halves:
        if flat and half > SMALL_ARC.high:
            continue
        distance = quad(
            lambda x, h=half: math.sin(h * x) * cumulative_pressure(pressure, x, h), -1.0, 1.0, epsrel=1e-9
        )[0]
        resultant = pressure_integral_over_load(pressure, half) * (math.cos(half) + half * distance)
        assert resultant == pytest.approx(1.0, abs=1e-6 + (0.5 * half * half if flat else 0.0))


@pytest.mark.parametrize("name", names("pressure"))
def test_the_peak_of_a_pressure_is_the_steepest_of_its_shares(name):
    """Differences across `span` of an arc fall short of the steepest by about span^2 of it."""
    pressure, halves = arcs_of(name)
    span = 2e-3
    for half in halves:
        shares = [cumulative_pressure(pressure, x, half) for x in np.arange(-0.9, 0.9, span)]
        assert peak_over_mean(pressure, half) == pytest.approx(2.0 * np.diff(shares).max() / span, rel=1e-5)


@pytest.mark.parametrize("name", names("pressure"))
def test_an_arc_widens_with_load_and_penetration_and_knows_no_unit(name):
    joint, in_mm = term_of(case_of(name)), term_of(case_of(name, scale=1e3))
    pressure = joint.wear.pressure
    halves = [half_arc(pressure, joint, BEARING, sliding(*point)) for point in POINTS]
    assert all(b >= a > 0.0 for a, b in itertools.pairwise(halves))
    assert halves[3] > halves[0]
    assert halves[-1] <= 0.5 * math.pi + 1e-12
    for (load, depth), half in zip(POINTS, halves, strict=True):
        there = sliding(load, depth * 1e3, CLEARANCE * 1e3)  # mm, kg, s: a load per length keeps its number
        assert half_arc(in_mm.wear.pressure, in_mm, BEARING * 1e3, there) == pytest.approx(half, rel=1e-9)
        wider = half_arc(pressure, joint, BEARING, sliding(load, depth, 0.1 * CLEARANCE))  # surfaces that fit closer
        assert wider >= half * (1.0 - 1e-12)
    assert half_arc(pressure, joint, BEARING, sliding(0.0, 0.0)) == pytest.approx(0.0, abs=1e-12)


SIZES = Sizes(CLEARANCE, BEARING)


def check_balance(name, pressure, half, radius, load):
    """Check that the oracle bears the load: its resultant, of half-spaces its sum."""
    share = np.sin(np.linspace(-0.5 * math.pi, 0.5 * math.pi, 20001))
    distance = 1.0 if SMALL_ARC in RECIPES["pressure", name].law.trusted else np.cos(half * share)
    assert np.trapezoid(radius * pressure(half * share) * distance, half * share) == pytest.approx(load, rel=1e-6)


def documented(formulas, family, name):
    """Return the oracle of a recipe."""
    assert name in formulas, f"write the documented formula of the {family} {name!r} into tests/wear_oracle.py"
    return formulas[name]


@pytest.mark.parametrize("name", names("pressure"))
@pytest.mark.parametrize(("load", "depth"), [(2e3, 2e-5), (6e6, 3e-4)])
def test_the_bins_of_both_bodies_are_the_quadrature_of_the_documented_pressure(name, load, depth):
    case, speed, time = case_of(name), 0.3, 0.1
    joint, modulus = term_of(case), STEEL.young / (2.0 * (1.0 - STEEL.poisson**2))
    history = steady(time, load * LENGTH, -speed, depth, 0.0, 0.3)
    worn = worn_off(joint, history)
    coefficients = COEFFICIENTS.values()
    for depths, radius, coefficient in zip(worn[:2], (BEARING, JOURNAL), coefficients, strict=True):
        edges = bin_edges(0.3, 720)
        half, pressure = documented(PRESSURES, "pressure", name)(load, radius, depth, modulus, SIZES)
        check_balance(name, pressure, half, radius, load)
        sums, total = spread(pressure, half, radius, edges[np.argsort(edges[:, 0]), 0])
        pressed = np.zeros(720)
        pressed[np.argsort(edges[:, 0])[:-1]] = sums
        expected = coefficient * speed * time * pressed / (radius * 2.0 * math.pi / 720)
        assert depths == pytest.approx(expected, rel=0.0, abs=2e-5 * expected.max())
        area = depths.sum() * radius * 2.0 * math.pi / 720
        assert area == pytest.approx(coefficient * speed * time * total, rel=1e-6, abs=0.0)
        if radius == BEARING:
            highest = float(pressure(np.zeros(1))[0])
            assert worn[2].pressure_max == pytest.approx(highest, rel=1e-6)
            assert worn[2].pv_max == pytest.approx(highest * speed, rel=1e-6)
            assert worn[2].pressure_time == pytest.approx(total / (2.0 * radius * half) * time, rel=1e-6)


# ---------------------------------------------------------------------------------------------- wear laws

#: A load that swells over 0.1 s while the contact travels over both bodies; the sliding does not turn.
TRAVEL = History(
    0.1,
    load=lambda t: 800.0 + 500.0 * np.sin(40.0 * t),
    slip=lambda t: 0.3 + 0.2 * np.cos(30.0 * t),
    depth=lambda t: 2e-5 + 1.5e-5 * np.sin(40.0 * t),
    work=lambda t: 40.0 + 20.0 * np.cos(50.0 * t),
    on_bearing=lambda t: 1.0 + 6.0 * t + 0.1 * np.sin(20.0 * t),
    on_journal=lambda t: -2.0 - 9.0 * t,
)


def quadrature(history, pressure, wear, modulus, running_in=None):
    """Return what 72 bins of bearing and journal lose, by Gauss's rule over 40 spans of the history."""
    nodes, weights = np.polynomial.legendre.leggauss(6)
    spans = history.duration / 40
    times = (spans * (np.arange(40)[:, None] + 0.5 * (nodes + 1.0))).ravel()
    weights = np.tile(0.5 * spans * weights, 40)
    fine = np.linspace(0.0, history.duration, 100_001)
    sliding_distance = np.interp(
        times, fine, np.concatenate([[0.0], cumulative_trapezoid(np.abs(history.slip(fine)), fine)])
    )
    worn = np.zeros((2, 72))
    for body, (radius, angle) in enumerate(((BEARING, history.on_bearing), (JOURNAL, history.on_journal))):
        steady_k = list(COEFFICIENTS.values())[body]
        first = list(RUNNING_IN.values())[body]
        for t, weight, way in zip(times, weights, sliding_distance, strict=True):
            load, depth = history.load(t) / LENGTH, history.depth(t)
            arcs = [PRESSURES[pressure](load, r, depth, modulus, SIZES) for r in (BEARING, radius)]
            on_bearing = spread(arcs[0][1], arcs[0][0], BEARING, np.zeros(1))[1]
            edges = bin_edges(angle(t), 72)
            order = np.argsort(edges[:, 0])
            sums, total = spread(arcs[1][1], arcs[1][0], radius, np.append(edges[order, 0], math.inf))
            shares = np.zeros(72)
            shares[order] = sums / total
            k = steady_k + (first - steady_k) * math.exp(-way / RUNNING_IN["distance"]) if running_in else steady_k
            work = history.work(t) / LENGTH
            area = documented(AREAS, "wear", wear)(k, on_bearing, abs(history.slip(t)), work)
            worn[body] += weight * area * shares / (radius * 2.0 * math.pi / 72)
    return worn


@pytest.mark.few("archard-running in", "energy-run in")
@pytest.mark.parametrize("running_in", [None, RUNNING_IN], ids=["run in", "running in"])
@pytest.mark.parametrize("name", names("wear"))
def test_the_depth_of_a_wear_law_is_its_quadrature_over_a_history(name, running_in):
    case = case_of("mean", name, running_in, bins=72)
    bearing, journal, _, _ = worn_off(term_of(case), TRAVEL, steps=40)
    expected = quadrature(TRAVEL, "mean", name, 0.0, running_in)
    for depths, exact in zip((bearing, journal), expected, strict=True):
        # the way slid is taken as even within a step, which a falling coefficient sees
        assert depths.sum() == pytest.approx(exact.sum(), rel=2e-4 if running_in else 3e-6, abs=0.0)
        assert depths == pytest.approx(exact, rel=0.0, abs=5e-4 * exact.max())


@pytest.mark.parametrize("name", names("wear"))
def test_a_body_wears_by_its_own_coefficient_and_what_does_not_slide_does_not_wear(name):
    still = TRAVEL._replace(slip=lambda t: 0.0 * t, work=lambda t: 0.0 * t)
    for depths in worn_off(term_of(case_of("mean", name, bins=72)), still)[:2]:
        assert np.all(depths == 0.0)
    case = case_of("mean", name, bins=72)
    base = worn_off(term_of(case), TRAVEL)
    for body, key in enumerate(COEFFICIENTS):
        values = case.wear.values | {key: 2.0 * COEFFICIENTS[key]}
        more = worn_off(term_of(case._replace(wear=case.wear._replace(values=values))), TRAVEL)
        assert more[body] == pytest.approx(2.0 * base[body], rel=1e-12, abs=0.0)
        assert np.array_equal(more[1 - body], base[1 - body])
    back = worn_off(term_of(case), TRAVEL._replace(slip=lambda t: -TRAVEL.slip(t)))
    assert np.array_equal(back[0], base[0])
    assert min(base[0].min(), base[1].min()) >= 0.0
