"""The histogram of a force over time."""

import numpy as np
import pytest

from clearsweep.mechanics.observe.histogram import BINS, EDGES, WIDTHS, fill, force_exceeded, ramp_of


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
