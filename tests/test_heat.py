"""The heat balance of films: with losses of a closed form in place of runs, then the same of motions."""

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
