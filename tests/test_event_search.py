"""The search for events within a step, along given paths: it finds what rises and falls between its stages."""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from clearsweep.mechanics.observe import (
    DEPTH,
    KAPPA,
    NODE_FRACTIONS,
    NODES,
    RATE,
    ROW_COUNT,
    SCRATCH,
    SLIP,
    column_count,
    column_of,
)
from clearsweep.mechanics.solver import collocation, event_search
from clearsweep.mechanics.solver.collocation import COEFFICIENTS, NO_CROSSING, PART, ROWS, VALUES, WHOLE
from clearsweep.mechanics.solver.integration import Method
from clearsweep.mechanics.solver.totals import ContactStep, ContactTotals

MIDDLES = (0.01, 0.07, 0.31, 0.5, 0.53, 0.94, 0.999)


@pytest.fixture
def onset(monkeypatch):
    """Return a function: depth over the share of the step, its slope -> where the search finds the onset."""

    def crossing_of(depth, slope, clearance=1.0):
        o = np.zeros((column_count(1), ROW_COUNT))
        o[KAPPA], o[column_of(0, SLIP)] = 1.0, 1e3

        def look(_, x, row=SCRATCH):
            o[column_of(0, DEPTH), row], o[column_of(0, RATE), row] = depth(x), slope(x)

        for row, x in zip(NODES, NODE_FRACTIONS, strict=True):
            look(None, x, row)
        monkeypatch.setattr(event_search, "evaluate_dense", look)
        contact_steps, polynomials = ContactStep.zeros(1), np.zeros((ROWS, COEFFICIENTS))
        work = SimpleNamespace(o=o, clearance=[clearance], contact_steps=contact_steps, polynomials=polynomials)
        return event_search.find_onset((work,), 0, 1.0)

    return crossing_of


@pytest.mark.parametrize("top", [0.3, 0.01, 1e-4, 1e-8])
@pytest.mark.parametrize("middle", MIDDLES)
def test_a_path_that_only_grazes_the_bearing_between_two_stages_is_found(onset, top, middle):
    x = onset(lambda x: top - 40.0 * (x - middle) ** 2, lambda x: -80.0 * (x - middle))
    begin = middle - math.sqrt(top / 40.0)
    assert x == pytest.approx(max(begin, 0.0), abs=1e-7)


@pytest.mark.parametrize("middle", MIDDLES)
def test_a_path_that_turns_just_before_the_bearing_is_no_contact(onset, middle):
    assert onset(lambda x: -1e-6 - 40.0 * (x - middle) ** 2, lambda x: -80.0 * (x - middle)) == NO_CROSSING


def test_of_several_contacts_the_first_is_found(onset):
    def depth(x):
        return math.sin(4.0 * math.pi * x - 1.0) - 0.5

    def slope(x):
        return 4.0 * math.pi * math.cos(4.0 * math.pi * x - 1.0)

    assert onset(depth, slope) == pytest.approx((1.0 + math.pi / 6.0) / (4.0 * math.pi), abs=1e-7)


def test_a_journal_that_leaves_the_bearing_touches_it_where_it_comes_back(onset):
    x = onset(lambda x: (x - 0.02) * (x - 0.6) * 1.0, lambda x: 2.0 * x - 0.62)
    assert x == pytest.approx(0.6, abs=1e-8)


@pytest.mark.parametrize("begin", [0.0, 1e-15, -1e-15])
def test_a_journal_that_leaves_for_good_does_not_touch(onset, begin):
    path = np.poly1d([0.2, -0.2, 0.5, -1.0, begin])
    assert onset(path, path.deriv()) == NO_CROSSING


def test_a_journal_that_never_quite_left_touches_where_it_turns(onset):
    assert onset(lambda x: 1e-3 + (x - 0.4) ** 2, lambda x: 2.0 * (x - 0.4)) == pytest.approx(0.4, abs=1e-6)


def test_a_journal_in_its_bearing_that_closes_touches_at_once(onset):
    assert onset(lambda x: 1e-9 + x, lambda _: 1.0) == 0.0


@pytest.mark.parametrize("begin", [0.0, 0.01, 0.3, 0.55])
@pytest.mark.parametrize("wide", [0.003, 0.02, 0.05])
def test_a_journal_pressed_back_between_two_stages_touches_the_bearing(onset, begin, wide):
    path = np.poly1d([begin, begin + wide, begin + 2.0 * wide], r=True) * -1.0
    x = onset(path, path.deriv())
    assert x == pytest.approx(begin + wide, abs=1e-8)


@pytest.mark.parametrize("kink", [0.1, 0.37, 0.62, 0.9])
def test_a_path_with_a_kink_is_followed_in_parts(onset, kink):
    """It bounces off nothing: a worn surface's edge."""
    x = onset(
        lambda x: 0.02 - 3.0 * abs(x - kink) + 0.3 * math.sin(x - kink),
        lambda x: -3.0 * math.copysign(1.0, x - kink) + 0.3 * math.cos(x - kink),
    )
    assert kink - 0.02 / 2.6 < x < kink


def test_a_path_through_the_middle_of_the_bearing_is_smooth_for_the_search(onset):
    """The journal crosses its bearing on a straight line: the eccentricity has a kink, its square has none."""
    x = onset(lambda x: abs(2.2 * x - 1.0) - 1.0, lambda x: math.copysign(2.2, 2.2 * x - 1.0))
    assert x == pytest.approx(2.0 / 2.2, abs=1e-12)


def test_a_path_shorter_than_its_distance_from_the_bearing_does_not_reach_it():
    def arrives(speed):
        o = np.zeros((column_count(1), ROW_COUNT))
        o[KAPPA], o[column_of(0, SLIP)], o[column_of(0, DEPTH)] = 1.0, speed, -2.0
        work = SimpleNamespace(o=o, contact_steps=ContactStep.zeros(1))
        return not event_search.cannot_reach_bearing((work,), 0, 1.0)

    assert arrives(3.4)
    assert not arrives(3.3)


# ---------------------------------------------------------------------------------------------- polynomials


def made_of(path):
    """Return the polynomials of a path over the step."""
    p = np.zeros((ROWS, COEFFICIENTS))
    p[VALUES] = path(NODE_FRACTIONS)
    collocation.set_from_values(p)
    return p


def test_a_polynomial_through_the_stages_lies_within_its_coefficients():
    rng, places = np.random.default_rng(3), np.linspace(0.0, 1.0, 201)
    for _ in range(50):
        path = np.polynomial.Legendre(rng.normal(size=COEFFICIENTS), domain=[0.0, 1.0])
        p = made_of(path)
        values = [collocation.value_and_slope(p, WHOLE, x) for x in places]
        assert [value for value, _ in values] == pytest.approx(path(places), abs=1e-11)
        assert [slope for _, slope in values] == pytest.approx(path.deriv()(places), abs=1e-9)
        assert path(places).max() <= max(p[WHOLE, 0], collocation.upper_bound(p)) + 1e-11
        assert collocation.error_bound(p) == pytest.approx(np.abs(path.coef[-2:]).sum(), abs=1e-11)
        collocation.extract_part(p, 0.25, 0.125)
        assert collocation.value_and_slope(p, PART, 0.3)[0] == pytest.approx(path(0.25 + 0.3 * 0.125), abs=1e-11)


@pytest.mark.parametrize("dip", [1e-3, 1e-5, 1e-7])
def test_a_dip_that_all_stages_miss_is_found(dip):
    """A polynomial that is below zero at every stage, and for `dip` of the step above it between two of them."""
    for left, right in itertools.pairwise(NODE_FRACTIONS):
        middle = 0.5 * (left + right)
        path = np.poly1d([middle - 0.5 * dip, middle + 0.5 * dip], r=True) * np.poly1d([-1.0, -0.5, -3.0])
        path = path * -1.0 if path(middle) < 0.0 else path
        assert (path(NODE_FRACTIONS) < 0.0).all()
        expected = pytest.approx(middle - 0.5 * dip, abs=1e-9 + 1e-16 / dip)
        assert collocation.find_first_crossing(made_of(path)) == expected


def test_the_first_crossing_is_that_of_the_roots():
    rng = np.random.default_rng(5)
    for _ in range(200):
        path = np.polynomial.Legendre(rng.normal(size=COEFFICIENTS), domain=[0.0, 1.0])
        roots = [x.real for x in path.roots() if abs(x.imag) < 1e-12 and 0.0 < x.real < 1.0]
        first = min((x for x in roots if path.deriv()(x) > 0.0), default=NO_CROSSING)
        assert collocation.find_first_crossing(made_of(path)) == pytest.approx(first, abs=1e-9)


def test_a_rise_within_the_error_of_a_polynomial_is_no_crossing():
    def path(x):
        return -1.0 - np.cos(2.0 * math.pi * x) + 1e-3 * np.polynomial.Legendre.basis(8, domain=[0.0, 1.0])(x)

    assert collocation.find_first_crossing(made_of(path)) < 1.0
    assert collocation.find_certain_crossing(made_of(path), 0.0) == NO_CROSSING


# ---------------------------------------------------------------------------------------------- guards


def passage(monkeypatch, function, column=-1, peak=0.0):
    """Return where a guard with this function over the share of the step is located, and how often it was looked at."""
    looks = []

    def look(at, g, x):
        looks.append(x)
        return function(x)

    monkeypatch.setattr(event_search, "guard_value", look)
    value = np.array([[*map(function, NODE_FRACTIONS), 0.0]])
    guards = SimpleNamespace(value=value, contact=[0], column=[column])
    totals = SimpleNamespace(joint=ContactTotals(np.full((1, ContactTotals.SIZE), peak)))
    work = SimpleNamespace(
        guards=guards, totals=totals, method=Method.zeros(), polynomials=np.zeros((ROWS, COEFFICIENTS))
    )
    return event_search.find_passage((work,), 0), len(looks)


@pytest.mark.parametrize(
    ("function", "most"),
    [
        (lambda x: x - 0.3, 1),
        (lambda x: math.tanh(50.0 * (x - 0.3)), 24),
        (lambda x: (x / 0.3) ** 9 - 1.0, 64),
        (lambda x: math.copysign(abs(x - 0.3) ** 1.5, x - 0.3), 64),
        (lambda x: 1.0 if x > 0.3 else -1e-9, 70),
    ],
)
def test_a_guard_is_located_whatever_its_function(monkeypatch, function, most):
    x, looks = passage(monkeypatch, function)
    assert x == pytest.approx(0.3, abs=1e-8, rel=0.0)
    assert looks <= most


def test_a_guard_that_is_passed_between_two_stages_alone_is_located(monkeypatch):
    x, _ = passage(monkeypatch, lambda x: 1e-3 - (x - 0.36) ** 2)
    assert x == pytest.approx(0.36 - math.sqrt(1e-3), abs=1e-9)


def test_a_guard_that_its_polynomial_alone_passes_is_not_passed(monkeypatch):
    def step(x):
        return -1e-3 if x < 0.35 else -1.0

    assert max(np.abs(collocation.TAIL_WEIGHTS @ made_of(np.vectorize(step))[WHOLE])) > 0.0
    assert passage(monkeypatch, step)[0] == NO_CROSSING


@pytest.mark.parametrize(("begin", "crossing_of"), [(0.1, 0.0), (1e-12, NO_CROSSING)])
def test_a_guard_above_zero_at_the_start_is_passed_unless_it_is_leaving(monkeypatch, begin, crossing_of):
    assert passage(monkeypatch, lambda x: begin - 0.2 * x)[0] == crossing_of


@pytest.mark.parametrize(("peak", "crossing_of"), [(1e2, 0.3), (1e4, NO_CROSSING)])
def test_a_force_is_not_clipped_for_what_is_rounding_of_the_largest_force(monkeypatch, peak, crossing_of):
    x, _ = passage(monkeypatch, lambda x: 1e-10 * (x - 0.3), column=0, peak=peak)
    assert x == pytest.approx(crossing_of, abs=1e-9)
