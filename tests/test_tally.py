"""The histogram of a force over time."""

from types import SimpleNamespace

import numpy as np
import pytest

from clearsweep.mechanics.observe.along import course_of
from clearsweep.mechanics.observe.histogram import BINS, EDGES, PARTS, WIDTHS, Ramp, fill, force_exceeded, ramp_of
from clearsweep.mechanics.observe.tally import BELOW, enter_course


@pytest.mark.parametrize("highest", [4.0, 4.0001, 5.3, 4096.0])
def test_a_ramp_is_exceeded_for_the_rest_of_its_duration(highest):
    """Also where it ends at the edge of a bin, in which it then spends no time."""
    time, ramp = np.zeros(BINS), np.zeros(BINS)
    fill(time, ramp, ramp_of(0.0, highest, 1.0))
    for share in (0.9, 0.5, 0.1):
        assert force_exceeded(time, ramp, share) == pytest.approx((1.0 - share) * highest, rel=1e-6)


def test_a_histogram_without_contact_exceeds_nothing():
    assert force_exceeded(np.zeros(BINS), np.zeros(BINS), 0.01) == 0.0


@pytest.mark.parametrize("ends", [(3.001, 3.005), (3.001, 3.0079), (3.001, 3.0201), (0.3, 40.0), (40.0, 0.3)])
def test_a_ramp_spends_in_each_bin_the_share_of_its_duration_that_the_bin_covers(ends):
    """Within a bin, across one edge, across a whole bin, and across many, upwards and down."""
    time, ramp = np.zeros(BINS), np.zeros(BINS)
    fill(time, ramp, ramp_of(*ends, 0.7))
    spent = time + np.cumsum(ramp) * WIDTHS
    covered = np.diff(np.clip(EDGES, min(ends), max(ends)))
    assert spent == pytest.approx(0.7 * covered / covered.sum(), rel=1e-9, abs=1e-14)


@pytest.mark.parametrize("force", [1e-3, 1.0, 777.7, 1e6])
def test_a_steady_force_is_resolved_to_a_256th(force):
    time, ramp = np.zeros(BINS), np.zeros(BINS)
    fill(time, ramp, ramp_of(force, force, 1.0))
    assert force_exceeded(time, ramp, 0.5) == pytest.approx(force, rel=1.0 / 256.0, abs=0.0)


@pytest.mark.parametrize(("first", "film", "pulling"), [(0.0, np.inf, 0.0), (-50.0, 1e-6, 1.0 / 3.0)])
def test_the_time_of_a_step_is_that_of_its_force_at_an_even_rate(first, film, pulling):
    """From `first` to 100 N; a film pulls where its force is negative, and that time is one without force."""
    step = np.zeros(course_of(1, 0) + PARTS + 1)
    step[course_of(1, -1) :][: PARTS + 1] = 3.0
    step[course_of(1, 0) :] = np.linspace(first, 100.0, PARTS + 1)
    rows = {"step": step, "mode": np.zeros(1), "film": np.array([[0.0, film]])}
    ledger = SimpleNamespace(**rows, bins=np.zeros((1, 2 * PARTS), int), spent=np.zeros((1, BELOW + 1)))
    enter_course(ledger, 0, 2.0)
    time, ramp = np.zeros(BINS), np.zeros(BINS)
    for i in range(PARTS):
        fill(time, ramp, Ramp(*ledger.bins[0, 2 * i : 2 * i + 2], *ledger.spent[0, 3 * i : 3 * i + 3]))
    spent = time + np.cumsum(ramp) * WIDTHS
    assert spent.sum() + ledger.spent[0, BELOW] == pytest.approx(2.0, rel=1e-12)
    for share in (0.9, 0.5, 0.1):
        exceeded = force_exceeded(time, ramp, 2.0 * (1.0 - pulling) * share)
        assert exceeded == pytest.approx(100.0 * (1.0 - share), rel=1e-6)
