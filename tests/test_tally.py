"""The histogram of a force over time."""

import numpy as np
import pytest

from clearsweep.mechanics.observe.histogram import BINS, fill_ramp, force_exceeded


@pytest.mark.parametrize("highest", [4.0, 4.0001, 5.3, 4096.0])
def test_a_ramp_is_exceeded_for_the_rest_of_its_duration(highest):
    """Also where it ends at the edge of a bin, in which it then spends no time."""
    time, ramp = np.zeros(BINS), np.zeros(BINS)
    fill_ramp(time, ramp, 0.0, highest, 1.0)
    for share in (0.9, 0.5, 0.1):
        assert force_exceeded(time, ramp, share) == pytest.approx((1.0 - share) * highest, rel=1e-6)


def test_a_histogram_without_contact_exceeds_nothing():
    assert force_exceeded(np.zeros(BINS), np.zeros(BINS), 0.01) == 0.0
