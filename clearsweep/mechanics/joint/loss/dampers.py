"""Laws that add a damper's force to the elastic force."""

from typing import NamedTuple

from ...compiled import calculus as math
from ..elastic.contract import elastic_force
from .contract import loss_form

# ---------------------------------------------------------------------------------------------- root of the stiffness


class RootDamper(NamedTuple):
    """F = F_elastic + d sqrt(F_elastic / pen) rate; it pulls towards the end until the surfaces part."""

    damping: float  # d, kg^0.5: sqrt(F_elastic / pen) is the root of a stiffness


@loss_form(RootDamper, pulls=True, times_elastic=False)
def _root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root = math.sqrt(force / pen) if pen > 0.0 else 0.0  # the limit, but for a linear spring: of no account at a point
    return force + law.damping * root * rate, force


class ApproachRootDamper(NamedTuple):
    """The same while the bodies approach, the elastic force alone while they part."""

    damping: float  # kg^0.5


@loss_form(ApproachRootDamper, pulls=False, times_elastic=False)
def _approach_root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root = math.sqrt(force / pen) if pen > 0.0 else 0.0
    return force + law.damping * root * max(rate, 0.0), force


# ---------------------------------------------------------------------------------------------- constant damping


def _viscous_spring(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * rate, force


class PullingSpring(NamedTuple):
    """F = F_elastic + c rate; it pulls towards the end until the surfaces part."""

    damping: float  # c, N s/m


loss_form(PullingSpring, pulls=True, times_elastic=False)(_viscous_spring)


class ViscousSpring(NamedTuple):
    """The same, clipped where it would pull."""

    damping: float  # c, N s/m


loss_form(ViscousSpring, pulls=False, times_elastic=False)(_viscous_spring)

# ---------------------------------------------------------------------------------------------- damping over depth


class RootViscous(NamedTuple):
    """F = F_elastic + g sqrt(pen) rate."""

    damping: float  # g, N s/m^1.5


@loss_form(RootViscous, pulls=False, times_elastic=False)
def _root_viscous(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * math.sqrt(pen) * rate, force


class SteppedDamper(NamedTuple):
    """F = F_elastic + c step(pen) rate, with step growing as 3 x^2 - 2 x^3 of x = pen / depth from 0 to 1."""

    damping: float  # c, N s/m
    depth: float  # m


@loss_form(SteppedDamper, pulls=False, times_elastic=False)
def _stepped_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    x = min(pen / law.depth, 1.0)
    return force + law.damping * x * x * (3.0 - 2.0 * x) * rate, force
