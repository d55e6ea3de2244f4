"""A ball in a socket that yields as published for a sphere: its force, what it loses, what a free impact gives back."""

import math

import numpy as np
import pytest
from law_cases import resolved, written
from mechanism_cases import PAIR, changed, slider_crank
from scipy.integrate import quad
from scipy.optimize import brentq

import clearsweep
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.contract import with_internal_state
from clearsweep.mechanics.laws.loss import contact_force

HARDNESS, POISSON, RADIUS = 5e8, 0.3, 10e-3 * 9.5e-3 / 0.5e-3
MODULUS = 207e9 / (2.0 * (1.0 - POISSON**2))  # E*, Pa
PRESSURE = 0.454 + 0.41 * POISSON  # K, of the hardness
YIELD_DEPTH = (math.pi * PRESSURE * HARDNESS / (2.0 * MODULUS)) ** 2 * RADIUS  # m
YIELD_FORCE = 4.0 / 3.0 * MODULUS * math.sqrt(RADIUS) * YIELD_DEPTH**1.5  # N
LAW = "kogut-etsion"
#: Where two neighbours of the three fits and Hertz's force are equal, in yield depths.
JOINS = (1.03 ** (1.0 / 0.075), (1.40 / 1.03) ** (1.0 / 0.162), (3.0 / 1.40 / PRESSURE) ** (1.0 / 0.263))


def force(x, deepest=0.0, part=0):
    """Return the force over that where yielding begins, at `x` yield depths, the deepest before (0: none) likewise."""
    section = written(LAW, hardness=HARDNESS)
    del section["contact"]["stiffness"]  # from the material
    law, elastic = registry.compile_contact(resolved(section))
    assert law.yield_depth == pytest.approx(YIELD_DEPTH, rel=1e-12, abs=0.0)
    now = with_internal_state(law, [deepest * YIELD_DEPTH], 0)
    return contact_force(now, elastic, x * YIELD_DEPTH, -1.0 if deepest else 1.0, 1.0)[part] / YIELD_FORCE


def lost_and_kept(deepest):
    """Return the work lost and that which comes back, by forces alone, over yield force times yield depth."""
    work, _ = quad(force, 0.0, deepest, epsrel=1e-10, points=[x for x in JOINS if x < deepest])
    left = brentq(lambda x: force(x, deepest), 0.0, deepest) if force(0.0, deepest) < 0.0 else 0.0
    back, _ = quad(lambda x: force(x, deepest), left, deepest, epsrel=1e-10)
    return work - back, back


def kept_share(deepest):
    """Return e^2 of a free impact that goes `deepest` yield depths deep, in closed form."""
    ends = ((JOINS[0], 1.0, 1.5), (JOINS[1], 1.03, 1.425), (JOINS[2], 1.4, 1.263))
    work, before, load = 0.0, 0.0, 0.0
    for end, factor, power in ends:  # below full plasticity
        upto = min(end, deepest)
        work += factor * (upto ** (power + 1.0) - before ** (power + 1.0)) / (power + 1.0)
        load, before = factor * upto**power, upto
        if deepest <= end:
            break
    left = deepest * (1.0 - deepest**-0.28) * (1.0 - deepest**-0.69) if deepest > 1.0 else 0.0
    return load * (deepest - left) / (1.0 + 1.5 * max(deepest, 1.0) ** -0.0331) / work


def test_the_force_is_hertz_s_and_then_each_published_fit():
    assert force(0.3) == pytest.approx(0.3**1.5, rel=1e-12)
    for x in (1.5, 3.0, 6.0):
        assert force(x) == pytest.approx(1.03 * x**1.425, rel=1e-12)
    for x in (6.7, 30.0, 110.0):
        assert force(x) == pytest.approx(1.40 * x**1.263, rel=1e-12)
    for x in (150.0, 1000.0):  # full plasticity: the hardness over the area 2 pi R pen
        assert force(x) * YIELD_FORCE == pytest.approx(2.0 * math.pi * RADIUS * x * YIELD_DEPTH * HARDNESS, rel=1e-12)


def test_the_force_is_continuous_and_grows_with_the_penetration():
    forces = np.array([force(x) for x in np.geomspace(1e-3, 1e3, 1001)])
    assert np.all(np.diff(forces) > 0.0)
    for x in (1.0, 6.0, 110.0, *JOINS):
        assert force(x * (1.0 + 1e-9)) == pytest.approx(force(x * (1.0 - 1e-9)), rel=1e-8)
    for deepest in (0.5, 1.5, 10.0, 200.0):
        assert force(deepest, deepest) == pytest.approx(force(deepest), rel=1e-12)


def test_below_yield_nothing_stays_and_nothing_is_lost():
    for x in (0.2, 0.6, 0.9):
        assert force(x, 0.95) == pytest.approx(x**1.5, rel=1e-12)
    assert lost_and_kept(0.95)[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("deepest", [2.0, 6.3, 40.0])
def test_the_way_back_is_the_published_fit_from_the_depth_reached(deepest):
    left = deepest * (1.0 - deepest**-0.28) * (1.0 - deepest**-0.69)
    assert 0.0 < left < deepest
    assert force(left, deepest) == pytest.approx(0.0, abs=1e-9)
    assert force(0.9 * left, deepest) < 0.0 == force(0.9 * left, deepest, part=1)
    for x in (0.5 * (left + deepest), 0.99 * deepest):
        fit = force(deepest) * ((x - left) / (deepest - left)) ** (1.5 * deepest**-0.0331)
        assert force(x, deepest) == pytest.approx(fit, rel=1e-10)


@pytest.mark.parametrize("deepest", [1.2, 1.49, 2.0, 6.3, 40.0, 100.0])
def test_a_closed_cycle_loses_what_the_closed_form_says(deepest):
    lost, kept = lost_and_kept(deepest)
    assert kept / (lost + kept) == pytest.approx(kept_share(deepest), rel=1e-8)
    stored, _ = quad(lambda x: force(x, part=1), 0.0, deepest, epsrel=1e-9, points=[1.0, *JOINS[:2]])
    assert stored == pytest.approx(kept, rel=1e-8)


#: Speeds over that of first yield, and restitutions by the published fits of loading (which do not meet) and unloading.
PUBLISHED = ((2.0, 0.975), (5.0, 0.904), (10.0, 0.843), (30.0, 0.717), (60.0, 0.654), (100.0, 0.612), (200.0, 0.559))


@pytest.mark.parametrize(("speed", "restitution"), PUBLISHED)
def test_an_impact_returns_what_the_published_fits_return(speed, restitution):
    """Its energy is 0.4 F_c w_c (v / v_y)^2; at 2 the least of the fits is 3 % below the published one."""
    deepest = brentq(lambda x: sum(lost_and_kept(x)) - 0.4 * speed**2, 1.0, 150.0, xtol=1e-6)
    assert math.sqrt(kept_share(deepest)) == pytest.approx(restitution, abs=0.003)


def impact(speed):
    """Return the summary of a free impact of an effective mass of 0.1 kg in the joint above."""
    contact = {"law": LAW, "hardness": HARDNESS, "material": {"young": 207e9, "poisson": POISSON}}
    pair = {"clearance": 0.5e-3, "bearing_radius": 10e-3, "contact": contact}
    case = changed(PAIR, {"joints.pair": pair, "mechanism.speed": speed, "simulate.impacts": 1})
    return clearsweep.simulate(clearsweep.load_case(case)).summary


@pytest.mark.slow
def test_a_free_impact_gives_back_the_closed_form_and_less_the_faster_it_is():
    returned = []
    for deepest in (0.9, 3.0, 20.0):
        load = lost_and_kept(deepest)
        speed = math.sqrt(2.0 * sum(load) * YIELD_FORCE * YIELD_DEPTH / 0.1)
        result = impact(speed)
        assert result["pair_penetration_max"] == pytest.approx(deepest * YIELD_DEPTH, rel=1e-8, abs=0.0)
        assert result["pair_restitution"] == pytest.approx(math.sqrt(kept_share(deepest)), rel=1e-7)
        assert result["energy_residual"] < 1e-9
        returned.append(result["pair_restitution"])
    assert returned[0] == pytest.approx(1.0, abs=1e-9)
    assert returned[0] > returned[1] > returned[2]


@pytest.mark.slow
def test_a_slider_crank_whose_joint_yields_moves_the_same_by_either_method():
    contact = {"law": LAW, "hardness": HARDNESS, "material": {"young": 207e9, "poisson": POISSON}}
    changes = {"joints.rod-slider.contact": contact, "simulate.revolutions": 0.2}

    def run(method, tolerance):
        more = {"simulate.method": method, "simulate.tolerance": tolerance}
        return clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes | more))).summary

    explicit, implicit = run("explicit", 1e-10), run("implicit", 1e-8)
    assert explicit["rod_slider_penetration_max"] > 10.0 * YIELD_DEPTH
    for figure in ("rod_slider_force_peak", "rod_slider_force_rms", "slider_acceleration_rms"):
        assert implicit[figure] == pytest.approx(explicit[figure], rel=1e-5)
    assert explicit["energy_residual"] < 1e-9
