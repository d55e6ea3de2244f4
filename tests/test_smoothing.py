"""How widely worn shapes are smoothed, and when a life says so."""

import math

import numpy as np

from clearsweep.answers.validity import smoothing_remark
from clearsweep.contracts.case import Contact, Joint, Wear
from clearsweep.mechanics.joint import registry
from clearsweep.mechanics.joint.wear.contract import Worn


def test_the_width_of_the_smoothing_is_the_least_that_keeps_one_point_of_contact():
    """Of h = a cos(k phi) it keeps a exp(-(k w)^2 / 2), whose h + h'' is -(k^2 - 1) of that at the least."""
    count, k, clearance = 360, 6, 50e-6
    edges = np.linspace(0.0, 2.0 * np.pi, count + 1)
    for amplitude in (1e-9, 2e-6, 2e-5):
        depths = amplitude * np.diff(np.sin(k * edges)) / (k * np.diff(edges))
        wear = Wear("archard", "mean", count, {"bearing_coefficient": 1e-14, "journal_coefficient": 1e-14}, evolve=True)
        contact = Contact("hertz", "power", {"stiffness": 1e10, "exponent": 1.5})
        joint = Joint("pin", clearance, contact, 0.01, 0.02, wear=wear)
        width = registry.smoothing_width(joint, Worn(depths, np.zeros(count)))
        bend = amplitude * (k * k - 1)
        needed = math.sqrt(max(2.0 * math.log(bend / (0.9 * clearance)), 0.0)) / k if bend > 0.9 * clearance else 0.0
        assert max(needed, math.radians(2.0)) <= 1.01 * width
        assert width <= 1.01 * max(1.1 * needed, math.radians(2.0))
    assert registry.smoothing_width(joint._replace(wear=wear._replace(evolve=False)), Worn(depths, depths)) is None


def test_wide_smoothing_is_reported_and_narrow_is_not():
    message = smoothing_remark([("big", math.radians(11.0)), ("small", math.radians(3.9)), ("fixed", None)])
    assert message.startswith(
        "smoothed: the worn shapes of big are smoothed over 11 deg at the end, at first over 2 deg. "
    )
    assert "small" not in message
    assert "life is unknown and not part of its interval" in message
    assert "12 %" not in message  # of another case
    assert smoothing_remark([("small", math.radians(3.9)), ("fixed", None)]) == ""
