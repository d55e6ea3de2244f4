"""The search for an onset within a step, along given paths: it finds what rises and falls between its looks."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from clearsweep.mechanics.observe.observables import DEPTH, KAPPA, RATE, SLIP, column_of, columns
from clearsweep.mechanics.observe.stages import END, NODES, PLACES, SCRATCH, SHARES, START
from clearsweep.mechanics.solver import acceptance, event
from clearsweep.mechanics.solver.accumulate.step_sums import FASTEST, step_width, sum_of
from clearsweep.mechanics.solver.span import deepest_between


@pytest.fixture
def onset(monkeypatch):
    """Return a function: depth over the share of the step, its slope -> the share at which the search finds the onset.

    fast : a bound of the slope, which says how far the search may go at once.
    """

    def found(depth, slope, fast):
        o, step = np.zeros((columns(1), PLACES)), np.zeros(step_width(1))
        o[KAPPA], o[column_of(0, SLIP)], step[sum_of(0, FASTEST)] = 1.0, fast, fast

        def look(_, x, row=SCRATCH):
            o[column_of(0, DEPTH), row], o[column_of(0, RATE), row] = depth(x), slope(x)

        look(None, 0.0, START)
        look(None, 1.0, END)
        monkeypatch.setattr(event, "evaluate_dense", look)
        return event.first_onset((SimpleNamespace(o=o, step=step),), 0, 1.0, 1.0)

    return found


@pytest.mark.parametrize("top", [0.3, 0.01, 1e-4, 1e-8])
@pytest.mark.parametrize("middle", [0.07, 0.31, 0.53, 0.94])
def test_a_path_that_only_grazes_the_bearing_between_two_looks_is_found(onset, top, middle):
    x = onset(lambda x: top - 40.0 * (x - middle) ** 2, lambda x: -80.0 * (x - middle), 80.0)
    begin = middle - math.sqrt(top / 40.0)
    assert x == pytest.approx(max(begin, 0.0), abs=1e-8)


@pytest.mark.parametrize("middle", [0.07, 0.31, 0.53, 0.94])
def test_a_path_that_turns_just_before_the_bearing_is_no_contact(onset, middle):
    assert onset(lambda x: -1e-6 - 40.0 * (x - middle) ** 2, lambda x: -80.0 * (x - middle), 80.0) == 2.0


def test_of_several_contacts_the_first_is_found(onset):
    def depth(x):
        return math.sin(4.0 * math.pi * x - 1.0) - 0.5

    def slope(x):
        return 4.0 * math.pi * math.cos(4.0 * math.pi * x - 1.0)

    assert onset(depth, slope, 4.0 * math.pi) == pytest.approx((1.0 + math.pi / 6.0) / (4.0 * math.pi), abs=1e-8)


def test_a_journal_that_leaves_the_bearing_and_comes_back_touches_it_where_it_comes_back(onset):
    x = onset(lambda x: (x - 0.02) * (x - 0.6) * 1.0, lambda x: 2.0 * x - 0.62, 2.0)
    assert x == pytest.approx(0.6, abs=1e-8)


@pytest.mark.parametrize("begin", [0.0, 0.01, 0.3, 0.55])
@pytest.mark.parametrize("wide", [0.02, 0.05])
def test_a_journal_that_leaves_is_pressed_back_and_falls_between_two_looks_touches_the_bearing(onset, begin, wide):
    path = np.poly1d([begin, begin + wide, begin + 2.0 * wide], r=True) * -1.0
    x = onset(path, path.deriv(), 3.0)
    assert x == pytest.approx(begin + wide, abs=1e-8)


def control(path: np.poly1d) -> float:
    """Return the highest control point of the curve above a path whose depths at the stages are exact."""
    o = np.zeros((columns(1), PLACES))
    o[KAPPA] = 2.0
    for row, x in zip(NODES, SHARES, strict=True):
        o[column_of(0, DEPTH), row], o[column_of(0, RATE), row] = path(x), path.deriv()(x)
    return acceptance.highest_control(o, 0, 0.5)


@pytest.mark.parametrize("top", [0.0, 1e-3, 0.1])
@pytest.mark.parametrize("middle", [0.1, 0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize("lean", [-3.0, 0.0, 3.0])
def test_a_path_that_rises_to_the_bearing_between_its_ends_is_searched(top, middle, lean):
    rising = np.poly1d([1.0, -2.0 * middle, middle**2])
    assert control(top - rising * np.poly1d([lean, 4.0]) * np.poly1d([1.0, 1.0])) >= 0.0


@pytest.mark.parametrize("begin", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize("bend", [-1.0, 0.0, 0.5, 0.9])
def test_a_path_that_leaves_the_bearing_for_good_is_not_searched(begin, bend):
    assert control(np.poly1d([0.2, -0.2, bend, -1.0, begin])) < 0.0


def test_a_path_that_is_no_longer_than_its_ends_are_below_the_bearing_does_not_come_to_it():
    assert deepest_between(-1.0, -3.0, 3.9) < 0.0 < deepest_between(-1.0, -3.0, 4.1)


@pytest.mark.parametrize(
    ("function", "most"),
    [
        (lambda x: x - 0.3, 8),
        (lambda x: math.tanh(50.0 * (x - 0.3)), 24),
        (lambda x: (x / 0.3) ** 9 - 1.0, 64),
        (lambda x: 1.0 if x > 0.3 else -1e-9, 64),
        (lambda x: x - 0.3 if x > 0.1 else -math.inf, 64),
    ],
)
def test_an_event_is_located_from_behind_whatever_its_function(monkeypatch, function, most):
    looks = []

    def look(at, kind, j, stop, x):
        looks.append(x)
        return function(x)

    monkeypatch.setattr(event, "event_function", look)
    x = event.crossing(None, (event.SEPARATION, 0, 0.0), 0.0, 1.0)
    assert function(x) >= 0.0
    assert x == pytest.approx(0.3, abs=2.0 * event.FINE, rel=0.0)
    assert len(looks) <= most
