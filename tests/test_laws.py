"""Normal and tangential laws against closed forms and the tables of their hysteresis factors."""

import math

import numpy as np
import pytest
from mechanism_cases import PAIR, changed, resolved
from scipy.special import lambertw

import clearsweep
from clearsweep import laws
from clearsweep.kernels.friction import friction_force
from clearsweep.kernels.normal import contact_force, elastic_force

FACTOR_LAWS = ("lankarani-nikravesh", "hunt-crossley", "flores", "exact")
# chi and returned restitution over e = 0.1 ... 0.99, computed from the phase curve of the free impact; four digits
ASKED = (0.10, 0.20, 0.30, 0.40, 0.50, 0.60, 0.70, 0.80, 0.90, 0.95, 0.99)
CHI = {
    "hunt-crossley": (1.35, 1.2, 1.05, 0.9, 0.75, 0.6, 0.45, 0.3, 0.15, 0.075, 0.015),
    "lankarani-nikravesh": (0.7425, 0.72, 0.6825, 0.63, 0.5625, 0.48, 0.3825, 0.27, 0.1425, 0.0731, 0.0149),
    "flores": (14.4, 6.4, 3.7333, 2.4, 1.6, 1.0667, 0.6857, 0.4, 0.1778, 0.0842, 0.0162),
    "exact": (9.9982, 4.9192, 3.0871, 2.0825, 1.4328, 0.9749, 0.6348, 0.3731, 0.1665, 0.0789, 0.0152),
}
RETURNED = {
    "hunt-crossley": (0.5158, 0.5469, 0.5813, 0.6197, 0.6630, 0.7120, 0.7680, 0.8329, 0.9090, 0.9524, 0.9901),
    "lankarani-nikravesh": (0.6653, 0.6723, 0.6842, 0.7016, 0.7252, 0.7561, 0.7960, 0.8471, 0.9132, 0.9535, 0.9901),
    "flores": (0.0694, 0.1555, 0.2562, 0.3629, 0.4704, 0.5773, 0.6832, 0.7885, 0.8939, 0.9468, 0.9893),
    "exact": ASKED,
}


def free_impact(chi):
    """Return the restitution of a free impact with hysteresis factor chi: (1 + W0(-(1+chi) exp(-(1+chi)))) / chi."""
    return 1.0 if chi == 0.0 else float((1.0 + lambertw(-(1.0 + chi) * math.exp(-(1.0 + chi))).real) / chi)


def factor(law, restitution):
    return laws.RECIPES["law", law].make({"restitution": restitution}).factor


def returned(**contact):
    """Return what an impact pair gives back with this contact section."""
    case = changed(PAIR, {"joints.pair.contact": {"stiffness": 6.61e10, **contact}, "simulate.impacts": 1})
    trajectory = clearsweep.simulate(clearsweep.load_case(case))
    assert trajectory.status == "ok"
    return trajectory.summary["pair_restitution"]


@pytest.mark.parametrize("law", FACTOR_LAWS)
def test_hysteresis_factor_has_its_tabulated_values(law):
    assert [factor(law, e) for e in ASKED] == pytest.approx(CHI[law], abs=5.1e-5)


@pytest.mark.parametrize("law", FACTOR_LAWS)
@pytest.mark.parametrize("exponent", [1.0, 1.2, 1.5])
def test_simulated_restitution_is_the_closed_form(law, exponent):
    stiffness = 1e8 if exponent == 1.0 else 6.61e10
    for asked, printed in zip(ASKED, RETURNED[law], strict=True):
        got = returned(law=law, restitution=asked, exponent=exponent, stiffness=stiffness)
        assert got == pytest.approx(free_impact(factor(law, asked)), abs=1e-9)
        assert got == pytest.approx(printed, abs=5.1e-5)


@pytest.mark.parametrize("asked", [0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.99999, 0.999999, 1.0])
def test_exact_law_returns_what_was_asked_for(asked):
    assert returned(law="exact", restitution=asked) == pytest.approx(asked, abs=1e-8)


def test_hertz_gives_everything_back_and_meets_the_elastic_impact():
    case = changed(PAIR, {"joints.pair.contact": {"law": "hertz", "stiffness": 6.610198e10}, "simulate.impacts": 1,
                          "save.orbits": "all"})  # fmt: skip
    trajectory = clearsweep.simulate(clearsweep.load_case(case))
    duration = np.diff(trajectory.events["t"])[0]
    assert trajectory.summary["pair_restitution"] == pytest.approx(1.0, abs=1e-10)
    deepest = (2.5 * 0.1 / (2.0 * 6.610198e10)) ** 0.4  # half the energy of 0.1 kg at 1 m/s goes into K pen^2.5 / 2.5
    assert deepest == pytest.approx(2.0449289e-5, rel=3e-8)
    assert trajectory.summary["pair_penetration_max"] == pytest.approx(deepest, rel=1e-11)
    assert trajectory.summary["pair_force_peak"] == pytest.approx(6.610198e10 * deepest**1.5, rel=1e-11)
    lasts = 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) * deepest
    assert duration == pytest.approx(lasts, rel=1e-9)


@pytest.mark.parametrize("zeta", [0.0335184, 0.1, 0.3, 0.6, 0.8, 1.5, 3.0])
def test_clipped_kelvin_voigt_restitution_is_the_closed_form(zeta):
    stiffness, mass = 1e8, 0.1
    root = math.sqrt(abs(1.0 - zeta * zeta))
    if zeta < 1.0:
        expected = math.exp(-zeta / root * math.atan2(2.0 * zeta * root, 2.0 * zeta * zeta - 1.0))
    else:
        expected = ((zeta + root) / (zeta - root)) ** (-zeta / root)
    got = returned(law="kelvin-voigt", stiffness=stiffness, damping=2.0 * zeta * math.sqrt(stiffness * mass))
    assert got == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("law", [name for family, name in laws.RECIPES if family == "law"])
def test_every_normal_law_is_finite_elastic_at_rest_and_dissipates_over_a_cycle(law):
    numbers = {"law": law, "stiffness": 1e8, "restitution": 0.6, "damping": 50.0, "elastic": "power", "exponent": 1.5}
    term, elastic = laws.contact_terms({"contact": numbers})
    assert contact_force(term, elastic, 0.0, 0.0, 1.0) == (0.0, 0.0)
    for pen in (1e-300, 1e-12, 1e-5, 1.0):
        force, stored = contact_force(term, elastic, pen, 0.0, 1.0)
        assert force == stored == elastic_force(elastic, pen) >= 0.0
        assert all(math.isfinite(part) for part in contact_force(term, elastic, pen, 1e3, 1e-3))
    phase = np.linspace(0.0, 2.0 * np.pi, 2001)
    pen, rate = 1e-5 * (1.0 - np.cos(phase)), 1e-2 * np.sin(phase)
    force = [contact_force(term, elastic, p, r, 1.0)[0] for p, r in zip(pen, rate, strict=True)]
    loss = np.trapezoid(np.array(force) * rate, phase)
    assert loss == pytest.approx(0.0, abs=1e-12) if law == "hertz" else loss > 0.0


def test_material_stiffness_has_its_published_value():
    joint = {"bearing_radius": 10e-3, "clearance": 0.5e-3, "contact": {"material": {"young": 207e9, "poisson": 0.3}}}
    assert laws.material_stiffness(joint) == pytest.approx(6.610198e10, rel=1e-7)


@pytest.mark.parametrize(("exponent", "kind"), [(1.5, "PowerThreeHalves"), (1.0, "Linear"), (1.3, "Power")])
def test_the_exponent_chooses_the_cheapest_code_that_gives_the_same_force(exponent, kind):
    elastic = laws.RECIPES["elastic", "power"].make({"stiffness": 3e9, "exponent": exponent})
    assert type(elastic).__name__ == kind
    assert elastic_force(elastic, 2e-5) == pytest.approx(3e9 * 2e-5**exponent, rel=1e-14)


def friction(law, **numbers):
    return laws.RECIPES["friction", law].make(numbers)


def test_friction_laws_have_their_check_values_and_never_push():
    tanh = friction("tanh", coefficient=0.1, velocity_scale=0.01)
    assert friction_force(tanh, 100.0, 0.01) == pytest.approx(-0.761594 * 10.0, rel=1e-6)
    ambrosio = friction("ambrosio", coefficient=0.1, v0=1e-3, v1=3e-3)
    assert friction_force(ambrosio, 100.0, 2e-3) == pytest.approx(-5.0)
    assert friction_force(ambrosio, 100.0, -0.9e-3) == 0.0
    assert friction_force(ambrosio, 100.0, -1.0) == pytest.approx(10.0)
    for law in (tanh, ambrosio):
        for slip in np.linspace(-0.1, 0.1, 101):
            assert friction_force(law, 100.0, slip) * slip <= 0.0


def test_a_law_out_of_its_range_of_restitution_is_refused():
    for law, restitution in (("flores", 0.0), ("exact", 0.0), ("lankarani-nikravesh", 1.01), ("hunt-crossley", -0.1)):
        case = changed(PAIR, {"joints.pair.contact.law": law, "joints.pair.contact.restitution": restitution})
        with pytest.raises(clearsweep.InputError, match="restitution"):
            resolved(case)
