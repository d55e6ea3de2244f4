"""Laws of wear: what each takes off, how hard it is pressed, and how their keys are read.

Kernels here run as Python; closed forms are those of steady sliding under a load of fixed direction.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from mechanism_cases import slider_crank
from rubbing import steady, worn_off
from scipy.integrate import quad

from clearsweep import grid, simulation
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.dry import Joint
from clearsweep.mechanics.wear.laws import Archard, Energy, HertzLine, Persson, RunningIn, UniformPressure, Winkler

BINS, LENGTH, LOAD, SPEED = 360, 0.02, 1000.0, 0.3  # 1, m, N, m/s
STEEL = 207e9 / (2.0 * (1.0 - 0.3**2))  # Pa, E* of steel on steel
LINE = HertzLine(math.sqrt(4.0 * 0.19 / (math.pi * STEEL)))
REST = float(BINS), LENGTH, LINE, math.inf


def joint_of(law):
    return Joint(0.5e-3, 0.01, 0.0095, 1.0, (), (), (), law)


def slide(law, *, steps=1, duration=0.1, friction=0.0, pen=1e-6, load=LOAD):
    """Return the depths (m) of the bearing and the account after steady sliding, in `steps` of equal length."""
    history = steady(duration, load, -SPEED, pen, friction * load * SPEED, 0.3)
    depths, _, account, workspace = worn_off(joint_of(law), history, steps)
    assert workspace.step.bearing_angle[0] == pytest.approx(0.3, rel=1e-12)
    return depths, account


def volume(depths):
    """Return the volume (m^3) worn off the bearing."""
    return float(depths.sum()) * 2.0 * math.pi / BINS * 0.01 * LENGTH


def test_the_volume_of_the_energy_law_is_the_coefficient_times_the_work_of_friction():
    mu, alpha = 0.12, 3e-13
    depths, _ = slide(Energy(alpha, 0.0, *REST), friction=mu)
    assert volume(depths) == pytest.approx(alpha * mu * LOAD * SPEED * 0.1, rel=1e-9)
    same, _ = slide(Archard(mu * alpha, 0.0, *REST))
    assert depths == pytest.approx(same, rel=1e-9, abs=1e-25)
    none, _ = slide(Energy(alpha, 0.0, *REST), friction=0.0)
    assert np.all(none == 0.0)


@pytest.mark.parametrize("steps", [1, 20])
def test_running_in_takes_off_the_integral_of_its_falling_coefficient(steps):
    """k = 1e-14 + 4e-14 exp(-s / 10 mm) over 30 mm."""
    law = RunningIn(Archard(1.0, 1.0, *REST), (1e-14, 5e-14), (1e-14, 5e-14), 0.01, *REST)
    depths, account = slide(law, steps=steps)
    way = SPEED * 0.1
    expected = LOAD * (1e-14 * way + 4e-14 * 0.01 * (1.0 - math.exp(-way / 0.01)))
    assert account.sliding_distance == pytest.approx(way, rel=1e-12)
    assert volume(depths) == pytest.approx(expected, rel=1e-6)


def test_running_in_from_the_steady_coefficient_is_archard():
    law = RunningIn(Archard(1.0, 1.0, *REST), (2e-14, 2e-14), (2e-14, 2e-14), 1.0, *REST)
    assert slide(law)[0] == pytest.approx(slide(Archard(2e-14, 2e-14, *REST))[0], rel=1e-12, abs=1e-30)


def test_pressures_of_a_line_contact_are_those_of_hertz():
    """1 kN on 20 mm of steel: largest 97.607400 MPa, mean 76.660673 MPa (Johnson 1985, eq. 4.45 to 4.47)."""
    _, account = slide(Archard(1e-14, 1e-14, *REST))
    assert account.pressure_max == pytest.approx(97.607400e6, rel=1e-7)
    assert account.pressure_time == pytest.approx(76.660673e6 * 0.1, rel=1e-7)
    assert account.pv_max == pytest.approx(97.607400e6 * SPEED, rel=1e-7)


@pytest.mark.parametrize("degrees", [10.0, 30.0, 60.0, 89.0])
def test_an_even_pressure_balances_its_load_and_wears_more_than_it(degrees):
    """Its volume over k F s is theta0 / sin(theta0): 1.0051, 1.0472, 1.2092 at 10, 30 and 60 degrees."""
    theta = math.radians(degrees)
    pen = 0.5e-3 * (1.0 / math.cos(theta) - 1.0)
    depths, account = slide(Archard(1e-14, 1e-14, float(BINS), LENGTH, UniformPressure(), math.inf), pen=pen)
    assert account.pressure_max == pytest.approx(LOAD / (2.0 * 0.01 * LENGTH * math.sin(theta)), rel=1e-9)
    assert volume(depths) / (1e-14 * LOAD * SPEED * 0.1) == pytest.approx(theta / math.sin(theta), rel=1e-9)


def winkler(theta):
    """Return penetration, load (N) and pressure times radius over load per length, over half an arc of theta."""
    scale = theta - math.sin(theta) * math.cos(theta)
    return 0.5e-3 * (1.0 / math.cos(theta) - 1.0), LOAD, lambda phi: (math.cos(phi) - math.cos(theta)) / scale


def conformal(theta):
    """Return the same of Persson's contact of steel bodies, in which the load alone decides the arc."""
    b2 = math.tan(0.5 * theta) ** 2
    load = 2.0 * math.pi * STEEL * 0.5e-3 * LENGTH * b2 * (b2 + 1.0) / (2.0 - math.log(b2 + 1.0) - 2.0 * b2**2)

    def pressure(phi):
        y2 = math.tan(0.5 * phi) ** 2
        r, w = math.sqrt(max(b2 - y2, 0.0)), math.sqrt(b2 + 1.0)
        logarithm = math.log((w + r) / (w - r))
        return 2.0 * r / (math.pi * w * (1.0 + y2)) + logarithm / (2.0 * math.pi * b2 * (1.0 + b2))

    return 1e-6, load, pressure


@pytest.mark.parametrize("degrees", [0.9, 5.0, 30.0, 60.0, 84.0])
@pytest.mark.parametrize(("law", "form"), [(Winkler(), winkler), (Persson(STEEL), conformal)])
def test_conformal_pressures_balance_their_load_and_wear_their_own_shape(law, form, degrees):
    theta = math.radians(degrees)
    pen, load, per_load = form(theta)
    total = 2.0 * quad(per_load, 0.0, theta, epsabs=1e-13, epsrel=1e-13)[0]
    assert 2.0 * quad(lambda phi: per_load(phi) * math.cos(phi), 0.0, theta)[0] == pytest.approx(1.0, rel=1e-8)
    depths, account = slide(Archard(1e-14, 0.0, float(BINS), LENGTH, law, math.inf), pen=pen, load=load)
    scale = load / (0.01 * LENGTH)  # Pa
    assert account.pressure_max == pytest.approx(scale * per_load(0.0), rel=1e-7)
    assert account.pressure_time == pytest.approx(scale * total / (2.0 * theta) * 0.1, rel=1e-7)
    assert account.pv_max == pytest.approx(scale * per_load(0.0) * SPEED, rel=1e-7)
    assert volume(depths) / (1e-14 * load * SPEED * 0.1) == pytest.approx(total, rel=1e-8)
    if degrees == 60.0:
        edges = (np.arange(-BINS // 2, BINS // 2 + 1) * 2.0 * math.pi / BINS - 0.3).clip(-theta, theta)
        contents = np.roll([quad(per_load, *bounds)[0] for bounds in pairwise(edges)], BINS // 2)
        expected = 1e-14 * SPEED * 0.1 * scale * contents * BINS / (2.0 * math.pi)
        assert depths == pytest.approx(expected, rel=1e-6, abs=1e-7 * depths.max())


@pytest.mark.parametrize(("degrees", "peak"), [(5.0, 7.3020828), (30.0, 1.2602886), (60.0, 0.7117214)])
def test_perssons_largest_pressure_is_that_of_the_theory(degrees, peak):
    _, load, _ = conformal(math.radians(degrees))
    _, account = slide(Archard(1e-14, 0.0, float(BINS), LENGTH, Persson(STEEL), math.inf), load=load)
    assert account.pressure_max == pytest.approx(peak * load / (0.01 * LENGTH), rel=1e-7)


def test_springs_over_half_the_bearing_wear_four_over_pi_of_load_times_way():
    depths, _ = slide(Archard(1e-14, 0.0, float(BINS), LENGTH, Winkler(), math.inf), pen=0.5e9)
    assert volume(depths) / (1e-14 * LOAD * SPEED * 0.1) == pytest.approx(4.0 / math.pi, rel=1e-6)


@pytest.mark.parametrize(("limit", "share"), [(29.2e6, 1.0), (29.3e6, 0.0)])
def test_time_beyond_the_limit_of_pressure_times_speed_is_counted(limit, share):
    _, account = slide(Archard(1e-14, 1e-14, float(BINS), LENGTH, LINE, limit))  # 97.6 MPa times 0.3 m/s
    assert account.pv_beyond == pytest.approx(0.1 * share, rel=1e-9)


def case_of(wear, friction=None):
    changes = {"joints.rod-slider.wear": {"law": "archard", **wear}}
    if friction:
        changes["joints.rod-slider.friction"] = friction
    return grid.load(slider_crank("rod-slider", changes=changes), simulation.catalogue())


def term(cases):
    """Return the compiled wear of the first case."""
    return registry.compile_wear(cases.case(0).joints[0])


def test_a_bare_coefficient_next_to_a_hardness_is_that_of_the_hardness():
    assert term(case_of({"coefficient": 4e-5, "hardness": "2 GPa"})).bearing_coefficient == pytest.approx(
        2e-14, rel=1e-15
    )
    assert term(case_of({"coefficient": "2e-14 m^2/N", "hardness": "2 GPa"})).bearing_coefficient == 2e-14
    assert term(case_of({"coefficient": 2e-14})).bearing_coefficient == 2e-14


@pytest.mark.parametrize(
    "wear",
    [
        {"coefficient": 4e-5, "hardness": "2 GPa"},
        {"coefficient": "2e-14 m^2/N", "hardness": "2 GPa"},
        {"bearing_coefficient": 4e-5, "journal_coefficient": 0, "hardness": "2 GPa", "pv_limit": "1.75 MPa*m/s"},
        {"running_in": {"initial": 4e-5, "steady": 2e-5, "distance": "3 m"}, "hardness": "2 GPa"},
    ],
)
def test_a_resolved_grid_says_what_its_coefficients_are_in(wear):
    cases = case_of(wear)
    again = grid.load(cases.resolved(), simulation.catalogue())
    assert list(again.identities()) == list(cases.identities())
    assert term(again) == term(cases)


def test_each_body_has_its_own_running_in():
    running_in = {
        "steady": "1e-14 m^2/N",
        "initial": "5e-14 m^2/N",
        "journal_initial": "3e-14 m^2/N",
        "distance": "2 m",
    }
    law = term(case_of({"running_in": running_in, "journal_coefficient": "2e-14 m^2/N"}))
    assert (law.bearing_coefficients, law.journal_coefficients, law.distance) == ((1e-14, 5e-14), (2e-14, 3e-14), 2.0)


def test_a_swept_coefficient_that_runs_in_is_that_of_both_bodies():
    source = slider_crank(
        "rod-slider",
        changes={
            "joints.rod-slider.wear": {
                "law": "archard",
                "running_in": {"initial": 5e-14, "steady": 1e-14, "distance": 2},
            }
        },
    )
    source["sweep"] = {"joints.rod-slider.wear.running_in.initial": [5e-14, 9e-14]}
    cases = grid.load(source, simulation.catalogue())
    assert [registry.compile_wear(cases.case(k).joints[0]).bearing_coefficients[1] for k in range(2)] == [5e-14, 9e-14]
    assert len(set(cases.identities())) == 2
