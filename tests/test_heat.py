"""The heat balance of films: with losses of a closed form in place of runs, then the same of motions."""

import copy
import itertools
import math

import numpy as np
import pytest
from mechanism_cases import changed, slider_crank
from scipy.optimize import brentq

import clearsweep
from clearsweep.answers import validity
from clearsweep.simulation.analyses import repeated
from clearsweep.simulation.figures.sums import half_width
from clearsweep.simulation.running.run import Run

OIL = {"at_40C": "46 mm^2/s", "at_100C": "6.8 mm^2/s", "density": "870 kg/m^3"}
AMBIENT, CONDUCTANCE = 313.15, 1.5  # K, W/K


def a_film(revolutions=6, discard=3):
    thermal = {"conductance": CONDUCTANCE, "ambient": AMBIENT}
    changes = {
        "joints.rod-slider.contact": None,
        "joints.rod-slider.film": {"law": "short", "viscosity": OIL, "thermal": thermal},
        "simulate.revolutions": revolutions,
        "simulate.discard": discard,
    }
    return changed(slider_crank("rod-slider"), changes)


def loss(temperature):
    """Return a loss (W) that falls to a third in 40 K: 100 W at the ambient."""
    return 100.0 * math.exp(-(temperature - AMBIENT) * math.log(3.0) / 40.0)


ACCEPTED = brentq(lambda temperature: AMBIENT + loss(temperature) / CONDUCTANCE - temperature, AMBIENT, 400.0)


def balanced(monkeypatch, width, scatter=0.0):
    """Return the Balance of losses (W) with this half-width, which scatter; and the temperatures that were tried."""
    tried, random = [], np.random.default_rng(3)

    def losses(scene, names):
        tried.append(scene.case.joints[0].film.temperature)
        mean = loss(tried[-1]) + scatter * random.standard_normal()
        return repeated.Losses(np.array([mean]), np.array([width]), repeated.NO_COST)

    monkeypatch.setattr(repeated, "_losses", losses)
    _, balance = repeated.at_equilibrium(clearsweep.load_case(a_film()))
    return balance, tried


@pytest.mark.parametrize("width", [0.0, 54.0, math.inf], ids=["known", "scattered", "one revolution"])
def test_a_film_settles_where_its_loss_is_led_away_despite_scatter(monkeypatch, width):
    """Within 1 % of the rise; a half-width of 36 K does not make the ambient the answer."""
    balance, tried = balanced(monkeypatch, width)
    assert balance.converged
    assert len(tried) > 1
    assert balance.temperature["rod_slider"] == pytest.approx(ACCEPTED, abs=0.01 * (ACCEPTED - AMBIENT))


def test_no_first_guess_is_accepted_even_where_the_film_stays_at_the_ambient(monkeypatch):
    monkeypatch.setitem(globals(), "loss", lambda temperature: 1e-3)
    balance, tried = balanced(monkeypatch, 0.0)
    assert balance.converged
    assert len(tried) == 2


def test_a_loss_that_scatters_is_found_within_its_interval(monkeypatch):
    """4 W of 100 W: no two runs agree within 1 %, but after eight the half-width of 8 W is accepted."""
    balance, _ = balanced(monkeypatch, 8.0, scatter=4.0)
    assert balance.converged
    assert balance.temperature["rod_slider"] == pytest.approx(ACCEPTED, abs=8.0 / CONDUCTANCE)


def test_losses_that_never_agree_within_a_tenth_of_the_rise_settle_nowhere(monkeypatch):
    """25 W more or less in turn, of an unknown interval."""
    signs = itertools.cycle((1.0, -1.0))
    quiet = loss
    monkeypatch.setitem(globals(), "loss", lambda temperature: quiet(temperature) + 25.0 * next(signs))
    balance, tried = balanced(monkeypatch, math.inf)
    assert not balance.converged
    assert len(tried) == repeated.MAX_RUNS


@pytest.mark.parametrize(("width", "known"), [(0.0, True), (1.0, True), (20.0, False), (math.inf, False)])
def test_a_temperature_is_flagged_where_it_is_known_less_than_a_tenth_of_its_rise(monkeypatch, width, known):
    balance, _ = balanced(monkeypatch, width)
    assert (balance.doubtful() == {}) == known
    if not known:
        ((temperature, half, rise),) = balance.doubtful().values()
        assert (temperature - rise, half) == (pytest.approx(AMBIENT), width / CONDUCTANCE)


def observed(times, sums):
    """Return the losses of a joint from its heat (J) at some times (s)."""
    observer = repeated.HeatObserver(None, {})
    observer.times, observer.sums = list(times), [np.array([value]) for value in sums]
    return observer.losses(repeated.NO_COST)


def test_a_loss_has_the_interval_of_revolutions_and_the_mean_of_the_window():
    """A run is observed shortly before each revolution ends, and at its end: there the loss is four times the mean."""
    times, power = [0.0, 0.975, 1.975, 2.975, 3.975, 4.0], [9.0, 10.0, 12.0, 11.0, 40.0]
    result = observed(times, np.concatenate([[0.0], np.cumsum(power * np.diff(times))]))
    assert result.mean == pytest.approx(np.dot(power, np.diff(times)) / 4.0)
    assert result.width == pytest.approx(half_width(np.array([10.0, 12.0, 11.0])))
    assert observed(times[:3], [0.0, 9.0, 19.0]).width == math.inf


def test_the_remark_says_how_far_the_temperature_is_known():
    remark = validity.film_temperature_remark([("the film of rod-slider", 348.83, 36.2, 35.68)])
    assert "the film of rod-slider is at 348.83 K, 35.7 K above ambient, uncertain by 36.2 K (95 %)" in remark
    assert "too few revolutions" in validity.film_temperature_remark([("rod-slider", 348.83, math.inf, 35.68)])
    assert validity.film_temperature_remark([]) == ""


@pytest.mark.slow
def test_a_short_window_finds_the_same_temperature_as_a_long_one():
    """Three revolutions of a film: within 10 % of the rise, where the ambient was accepted before."""
    short, long = (
        clearsweep.simulate(clearsweep.load_case(changed(a_film(*window), {"simulate.tolerance": 1e-7})))
        for window in ((6, 3), (30, 10))
    )
    assert short.status == long.status == "ok"
    result, known = (path.summary["rod_slider_film_temperature"] for path in (short, long))
    rise = known - AMBIENT
    warm = AMBIENT + short.summary["rod_slider_film_loss"] / CONDUCTANCE
    assert rise > 5.0
    assert result == pytest.approx(warm, abs=0.1 * rise)
    assert ("film-unsure" in short.message) == (
        short.summary["rod_slider_film_temperature_ci"] > 0.1 * (result - AMBIENT)
    )


# Dry joints that friction warms: their temperature, clearance, and when they seize.


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
