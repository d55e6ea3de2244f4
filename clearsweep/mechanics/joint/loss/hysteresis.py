"""Laws that multiply the elastic force by a factor of the rate over the rate at which the contact began."""

from typing import NamedTuple

from ..elastic.contract import elastic_force
from .contract import loss_form


class Lossless(NamedTuple):
    """The elastic force alone."""


@loss_form(Lossless, pulls=False, times_elastic=True)
def _lossless(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force, force


class Hysteresis(NamedTuple):
    """F = F_elastic (1 + chi rate / onset_rate); the laws of this form differ only in chi(restitution)."""

    factor: float  # chi, 1


@loss_form(Hysteresis, pulls=False, times_elastic=True)
def _hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * (law.factor / onset_rate) * rate, force


class ApproachHysteresis(NamedTuple):
    """The same while the bodies approach, the elastic force alone while they part."""

    factor: float  # chi, 1


@loss_form(ApproachHysteresis, pulls=False, times_elastic=True)
def _approach_hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * (law.factor / onset_rate) * max(rate, 0.0), force
