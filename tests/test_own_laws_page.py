"""The laws on the page of laws of one's own: each is read from the page and compared with its closed form."""

import math
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from scipy.special import beta
from test_own_laws import CRANK, FLORES, PAIR, catalogue_of, figures_of, joint_of, with_joint

from clearsweep import grid
from clearsweep.contracts.case import OwnFigure
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.contract import compile_law, internal_rates
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.machines.planar.drives import motor_torque
from clearsweep.mechanics.wear import SlidingContact, wear_rate

PAGE = Path(__file__).parents[1] / "docs/howto/own-laws.md"
AZAD = {"law": "azad-featherstone", "k": "1e9 N/m^1.5", "d": "2 kN*s/m^1.5"}
PALMGREN = {"law": "exact", "restitution": 0.7, "elastic": "palmgren", "roller": "20 mm"}
MAKKAR = {"law": "makkar", "g1": 0.05, "g2": "1 s/mm", "g3": "0.1 s/mm", "g4": 0.1, "g5": "0.5 s/mm", "g6": "0.01 s/m"}
CONSTANTINOU = {"law": "constantinou", "f_max": 0.12, "f_min": 0.05, "a": "20 s/m", "y": "5 um"}
USUI = {"law": "usui", "a": "1e-15 m^2/N", "b": "2000 K", "temperature": "400 K"}
KLOSS = {"motor": {"law": "kloss", "breakdown": "5 N*m", "slip": 0.1, "synchronous": "1000 rpm"}}
FREE = KLOSS | {"initial_speed": "500 rpm", "inertia": "1e-3 kg*m^2"}


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    blocks = re.findall(r"```py\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    file = tmp_path_factory.mktemp("page") / "my_laws.py"
    file.write_text("\n\n".join(blocks))
    return catalogue_of(lambda: runpy.run_path(str(file)))


def test_the_page_has_the_law_of_its_beginning_a_curve_six_of_papers_and_a_figure(catalogue):
    assert len([law for law in catalogue.laws if law.origin]) == 9


@pytest.mark.parametrize(("power", "mean"), [(2.0, 0.5), (3.0, 4.0 / (3.0 * math.pi)), (4.0, 0.375)])
def test_the_equivalent_load_of_a_sine_is_its_mean_power(catalogue, power, mean):
    t = np.linspace(0.0, 1.0, 1000, endpoint=False)
    normal, tangential = 800.0 * np.sin(2.0 * math.pi * t), 600.0 * np.sin(2.0 * math.pi * t)
    channels = {"joints/rod_slider/force_normal": normal, "joints/rod_slider/force_tangential": tangential}
    figure = OwnFigure("load", "equivalent-load", {"power": power}, catalogue.own_laws)
    load = compile_law("figure", "equivalent-load", figure)(t, channels)
    assert load == pytest.approx(1000.0 * mean ** (1.0 / power), rel=1e-5)


def test_a_torque_curve_is_linear_between_its_points(catalogue):
    motor = {"motor": {"law": "torque-curve", "scale": 2.0}}
    case = grid.load(
        with_joint(CRANK, contact=FLORES) | {"drive": motor | {"initial_speed": "10 rpm"}}, catalogue
    ).case(0)
    law, speeds = compile_law("motor", "torque-curve", case.drive), (0.0, 20.0, 50.0, 75.0, 115.0, 143.5, 157.0)
    expected = np.interp(speeds, (0.0, 50.0, 100.0, 130.0, 157.0), (6.0, 4.8, 5.6, 4.0, 0.0))
    assert [motor_torque(law, speed, 0.0) for speed in speeds] == pytest.approx(expected, abs=1e-12)


def test_azad_and_featherstone_lose_what_the_work_of_their_damper_over_hertz_is(catalogue):
    result = registry.derived_values(joint_of(with_joint(PAIR, contact=AZAD), catalogue))
    speed, depth = 0.1, (1.25 * 0.1**2 / 1e9) ** 0.4
    expected = 0.8 * beta(0.6, 1.5) * 2e3 * depth**1.5 / speed
    assert expected < 0.02
    assert 1.0 - result["contact.restitution at 0.1 m/s and 1 kg"][0] == pytest.approx(expected, rel=expected)


def test_palmgren_gives_the_approach_of_a_roller(catalogue):
    elastic = compile_law("elastic", "palmgren", joint_of(with_joint(CRANK, contact=PALMGREN), catalogue))
    approach = 3.84e-5 * 5000.0**0.9 / 20.0**0.8  # mm
    assert elastic_force(elastic, 1e-3 * approach) == pytest.approx(5000.0, rel=1e-12)


def test_makkar_has_its_slope_at_rest_and_its_limit_at_speed(catalogue):
    joint = joint_of(with_joint(CRANK, contact=FLORES, friction=MAKKAR), catalogue)
    friction = registry.compile_friction(joint)
    slope = 0.05 * (1000.0 - 100.0) + 0.1 * 500.0 + 0.01
    assert friction_force(friction, 10.0, 1e-9) == pytest.approx(-10.0 * slope * 1e-9, rel=1e-6)
    assert friction_force(friction, 10.0, 3.0) == pytest.approx(-10.0 * (0.1 + 0.01 * 3.0), rel=1e-12)


def test_constantinou_slid_from_rest_carries_the_hyperbolic_tangent_of_its_friction(catalogue):
    joint = joint_of(with_joint(CRANK, contact=FLORES, friction=CONSTANTINOU), catalogue)
    friction, slip, steps = registry.compile_friction(joint), 0.1, 400

    class Sliding:
        normal = 10.0

    Sliding.slip = slip

    def rate(state):
        return internal_rates(friction._replace(state_0=state), Sliding)[0]

    state, step = 0.0, 5e-6 / slip / steps  # up to the distance of yield, by the midpoint rule
    for _ in range(steps):
        state += step * rate(state + 0.5 * step * rate(state))
    assert state == pytest.approx(math.tanh(1.0), rel=1e-5)
    coefficient = 0.12 - 0.07 * math.exp(-2.0)
    assert friction_force(friction._replace(state_0=state), 10.0, slip) == pytest.approx(-10.0 * coefficient * state)


def test_usui_wears_by_the_law_of_arrhenius_and_like_archard_without_it(catalogue):
    sliding = SlidingContact(1e4, 1e-6, 0.3, 0.0, 0.0, 1e4, 1e-4, 0.2)
    for b, share in ((2000.0, math.exp(-5.0)), (0.0, 1.0)):
        joint = joint_of(with_joint(CRANK, contact=FLORES, wear=USUI | {"b": f"{b} K"}), catalogue)
        expected = 1e-15 * 1e4 * 0.3 * share
        assert wear_rate(registry.compile_wear(joint), sliding) == pytest.approx((expected, expected), rel=1e-12)


def test_kloss_gives_its_breakdown_torque_and_none_at_the_synchronous_speed(catalogue):
    case = grid.load(with_joint(CRANK, contact=FLORES) | {"drive": FREE}, catalogue).case(0)
    motor, synchronous = compile_law("motor", "kloss", case.drive), 1000.0 * math.pi / 30.0
    torques = [motor_torque(motor, x * synchronous, 0.0) for x in (0.9, 1.0, 0.5, 0.95)]
    assert torques[:2] == pytest.approx([5.0, 0.0], abs=1e-12)
    assert max(torques) == torques[0]


@pytest.mark.slow
def test_the_laws_of_the_page_move_a_machine(catalogue):
    first = with_joint(CRANK, contact=AZAD, friction=CONSTANTINOU, wear=USUI)
    second = with_joint(CRANK, contact=PALMGREN, friction=MAKKAR) | {"drive": FREE}
    for source in (first, second):
        figures = figures_of(source, catalogue)
        assert abs(figures["energy_residual"]) < 1e-5
        assert np.isfinite(figures["rod_slider_force_peak"])
    assert figures_of(first, catalogue)["rod_slider_wear_depth_max"] > 0.0
