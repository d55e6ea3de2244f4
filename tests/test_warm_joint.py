"""Dry joints that friction warms: their temperature, clearance, and when they seize."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.simulation.analyses import repeated
from clearsweep.simulation.running.run import Run

ALPHA = {"bearing": 18e-6, "journal": 12e-6}
THERMAL = {"conductance": "2 W/K", "ambient": "30 degC", "expansion": ALPHA}
TIGHT = {"bearing": 12e-6, "journal": 24e-6}
DRY = {
    "joints.rod-slider.friction": {"law": "ambrosio", "coefficient": 0.1, "v0": 1e-4, "v1": 1e-3},
    "joints.rod-slider.clearance": 5e-5,
    "joints.rod-slider.thermal": THERMAL,
    "drive.speed": "600 rpm",
    "mechanism.gravity": 9.81,
    "simulate.revolutions": 3,
    "simulate.discard": 1,
    "simulate.tolerance": 1e-6,
}


def scene(**changes):
    named = {key.replace("__", "."): value for key, value in changes.items()}
    thermal = copy.deepcopy(THERMAL) | named.pop("thermal", {})
    given = copy.deepcopy(DRY) | {"joints.rod-slider.thermal": thermal} | named
    return clearsweep.load_case(slider_crank("rod-slider", changes=given))


def with_losses(monkeypatch, loss):
    """Let the loss (W) of the joint be `loss` of its clearance (m)."""

    def losses(scene, names):
        return repeated.Losses(np.array([loss(scene.case.joints[0].clearance)]), np.zeros(1), repeated.NO_COST)

    monkeypatch.setattr(repeated, "_losses", losses)


def test_a_joint_with_a_constant_loss_settles_where_the_closed_form_says(monkeypatch):
    with_losses(monkeypatch, lambda clearance: 124.0)
    warm, balance = repeated.at_equilibrium(scene())
    assert balance.converged
    temperature = 303.15 + 124.0 / 2.0
    assert balance.temperature["rod_slider"] == pytest.approx(temperature, rel=1e-9)
    wider = (ALPHA["bearing"] - ALPHA["journal"]) * 0.01 * (temperature - 293.15)
    assert warm.case.joints[0].clearance == pytest.approx(5e-5 + wider, rel=1e-9)
    assert warm.value.joints[0].clearance == pytest.approx(5e-5 + wider, rel=1e-9)


def test_a_loss_that_follows_the_clearance_has_its_closed_form_too(monkeypatch):
    slope, pull = 2e6, 0.01 * (ALPHA["bearing"] - ALPHA["journal"])  # W/m, m/K
    with_losses(monkeypatch, lambda clearance: slope * clearance)
    _, balance = repeated.at_equilibrium(scene())
    # T = Ta + slope (c + pull (T - 293.15)) / G
    temperature = (303.15 + slope / 2.0 * (5e-5 - pull * 293.15)) / (1.0 - slope / 2.0 * pull)
    assert balance.temperature["rod_slider"] == pytest.approx(temperature, rel=1e-6)


def test_temperature_clearance_and_power_of_a_run_fit_each_other():
    path = clearsweep.simulate(scene())
    result = path.summary
    power, temperature = result["rod_slider_friction_power"], result["rod_slider_temperature"]
    assert power > 0.01
    assert temperature == pytest.approx(303.15 + power / 2.0, rel=1e-6)
    clearance = 5e-5 + (ALPHA["bearing"] - ALPHA["journal"]) * 0.01 * (temperature - 293.15)
    assert result["rod_slider_clearance_warm"] == pytest.approx(clearance, rel=1e-9)
    cold = scene(**{"joints__rod-slider__clearance": result["rod_slider_clearance_warm"]}).case
    as_wide = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=_without_thermal(cold))))
    assert as_wide.summary["rod_slider_force_peak"] == pytest.approx(result["rod_slider_force_peak"], rel=1e-9)


@pytest.mark.parametrize("change", [{}, {"thermal": {"conductance": "0.1 mW/K", "expansion": TIGHT}}])
def test_the_work_of_a_case_includes_the_runs_of_its_heat_balance(monkeypatch, change):
    def recorded(run, log):
        through(run, log)
        steps.append(int(run.work.counts.steps))

    steps, through = [], Run.conclude
    monkeypatch.setattr(Run, "conclude", recorded)
    summary = clearsweep.simulate(scene(**change)).summary
    assert len(steps) > 2
    assert summary["steps"] == sum(steps)
    assert isinstance(summary["steps"], int)


def _without_thermal(case):
    given = copy.deepcopy(DRY) | {"joints.rod-slider.clearance": case.joints[0].clearance}
    del given["joints.rod-slider.thermal"]
    return given


def test_a_joint_whose_clearance_closes_has_seized():
    tight = {"expansion": TIGHT, "conductance": "0.1 mW/K"}
    path = clearsweep.simulate(scene(thermal=tight))
    assert path.status == "seized"
    assert "rod-slider, with 50 um of clearance" in path.message
    assert path.summary["rod_slider_force_peak"] is None
    assert path.summary["steps"] > 0


def test_a_clearance_that_narrows_without_closing_is_found(monkeypatch):
    # constant loss: c = 50 um - 6e-6 * 0.01 m * (T - 293.15 K); 10 um are left at 960 K
    with_losses(monkeypatch, lambda clearance: 1300.0)
    _, balance = repeated.at_equilibrium(scene(thermal={"expansion": {"bearing": 12e-6, "journal": 18e-6}}))
    assert balance.converged
    assert not balance.seized
    assert balance.temperature["rod_slider"] == pytest.approx(953.15, rel=1e-9)
    with_losses(monkeypatch, lambda clearance: 1700.0)
    _, balance = repeated.at_equilibrium(scene(thermal={"expansion": {"bearing": 12e-6, "journal": 18e-6}}))
    assert balance.seized == ("rod_slider",)


def test_the_remark_uses_the_conductance_that_is_written():
    hot = clearsweep.simulate(scene(thermal={"conductance": "1 mW/K", "expansion": {"bearing": 0.0, "journal": 0.0}}))
    assert "friction-heat: rod-slider" in hot.message
    assert "at 0.001 W/K" in hot.message
    assert "friction-heat" not in clearsweep.simulate(scene()).message


def test_named_materials_bring_their_expansion():
    contact = {"law": "lankarani-nikravesh", "restitution": 0.9, "stiffness": 6.61e10, "exponent": 1.5}
    contact |= {"material": {"bearing": "CuSn8", "journal": "100Cr6"}}
    thermal = {"conductance": "2 W/K", "ambient": "30 degC"}
    changes = copy.deepcopy(DRY) | {"joints.rod-slider.contact": contact, "joints.rod-slider.thermal": thermal}
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes)).case
    assert (case.joints[0].thermal.bearing, case.joints[0].thermal.journal) == pytest.approx((18.2e-6, 12e-6))


def test_without_expansion_the_clearance_stays(monkeypatch):
    with_losses(monkeypatch, lambda clearance: 10.0)
    changes = copy.deepcopy(DRY) | {"joints.rod-slider.thermal": {"conductance": "2 W/K", "ambient": "30 degC"}}
    warm, _ = repeated.at_equilibrium(clearsweep.load_case(slider_crank("rod-slider", changes=changes)))
    assert warm.case.joints[0].clearance == 5e-5
    assert math.isclose(warm.case.joints[0].temperature, 308.15)


# ---------------------------------------------------------------------------------------------- bushes

POM, STEEL = {"young": 2.8e9, "poisson": 0.37}, {"young": 2.1e11, "poisson": 0.3}
CONTACT = {"law": "lankarani-nikravesh", "restitution": 0.9, "stiffness": 6.61e10, "exponent": 1.5}
BUSH = {"bearing": 110e-6, "journal": 12e-6}


def warm_bush(housing, poisson=0.37, **changes):
    """Return the scene of a plastic bush, 20 mm in diameter, on a steel pin."""
    material = {"bearing": POM | {"poisson": poisson}, "journal": STEEL}
    thermal = {"expansion": BUSH} | ({"housing": housing} if housing else {})
    joint = {"joints__rod-slider__contact": CONTACT | {"material": material}}
    return scene(thermal=thermal, **joint, **changes)


def held_bore_rate(wall, poisson, alpha, housing_alpha):
    """Return the rate (m/K) of the bore of a bush whose outside follows the housing, from Lame's u = a r + b / r."""
    inner, outer = 0.01, 0.01 + wall
    free_inside = [1.0 + poisson, -(1.0 - poisson) / inner**2]  # radial stress times (1 - nu^2) / E, no pressure
    a, b = np.linalg.solve([free_inside, [outer, 1.0 / outer]], [(1.0 + poisson) * alpha, housing_alpha * outer])
    return a * inner + b / inner


@pytest.mark.parametrize(("wall", "poisson"), [(2e-3, 0.37), (1e-3, 0.46), (8e-3, 0.3)])
def test_a_bush_in_a_housing_moves_as_a_ring_held_at_its_outside(wall, poisson):
    joint = warm_bush({"expansion": 12e-6, "wall": wall}, poisson).case.joints[0]
    rate = held_bore_rate(wall, poisson, 110e-6, 12e-6) - 12e-6 * 0.01
    assert joint.clearance_rate == pytest.approx(rate, rel=1e-12)


def test_a_plastic_bush_closes_in_its_housing_and_opens_without():
    housed = warm_bush({"material": "S355", "wall": "2 mm"}).case.joints[0]
    assert housed.clearance_rate + 12e-6 * 0.01 == pytest.approx(-0.139e-6, rel=3e-3)  # of the bore
    assert 50.0 * housed.clearance_rate == pytest.approx(-13e-6, abs=0.1e-6)
    free = warm_bush(None).case.joints[0]
    assert 50.0 * free.clearance_rate == pytest.approx(49e-6, rel=1e-12)


def test_a_housing_like_the_bush_changes_nothing_and_a_thin_bush_follows_it():
    free, alike, thin = (
        warm_bush(housing).case.joints[0]
        for housing in (None, {"expansion": 110e-6, "wall": 2e-3}, {"expansion": 20e-6, "wall": 1e-9})
    )
    assert alike.clearance_rate == free.clearance_rate
    assert thin.clearance_rate == pytest.approx((20e-6 - 12e-6) * 0.01, rel=1e-5)


def test_a_bush_that_closes_in_its_housing_seizes(monkeypatch):
    with_losses(monkeypatch, lambda clearance: 500.0)  # 280 K of rise
    assert repeated.at_equilibrium(warm_bush(None))[1].seized == ()
    housed = warm_bush({"material": "S355", "wall": "2 mm"})
    assert repeated.at_equilibrium(housed)[1].seized == ("rod_slider",)


def test_a_bearing_that_heat_opens_is_flagged_unless_its_housing_is_known():
    hot = {"conductance": "10 mW/K"}
    free = scene(thermal=hot | {"expansion": BUSH})
    assert "free-bush: rod-slider goes from 0.05 mm" in clearsweep.simulate(free).message
    housed = scene(thermal=hot | {"expansion": BUSH, "housing": {"material": "S355", "wall": "2 mm"}})
    assert "free-bush" not in clearsweep.simulate(housed).message
    assert "free-bush" not in clearsweep.simulate(scene()).message
