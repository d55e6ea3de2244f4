"""Normal contact force: the laws that add a loss to the elastic force."""

from typing import NamedTuple

from ..compiled import calculus as math
from ..compiled.family import family
from .elastic import elastic_force, parity
from .internal_state import memory, recalled

SHALLOW = 1e-12  # m, the least depth that a contact which yields remembers


@family
def contact_force(law, elastic, pen, rate, onset_rate):
    """Return (force, elastic part) in N, the force not yet clipped at `lowest_force`.

    `pen` : penetration, m; `rate` : its rate, m/s, closing positive; `onset_rate` : the closing rate at which this
    contact began, m/s, positive.
    """


@family
def lowest_force(law):
    """Return the force (N) below which the law is clipped: 0, or -inf where it may pull until the surfaces part."""


@family
def sign_beyond(law, elastic):
    """Return the sign with which the force goes on smoothly where a trial step passes the separation.

    The force is a function of the root of the penetration, which goes through zero like a straight line: one of its odd
    powers, such as Hertz's third, changes sign there, an even one does not.  Only trial steps go that far.
    """


class Lossless(NamedTuple):
    """The elastic force alone."""


class Hysteresis(NamedTuple):
    """F = F_elastic (1 + chi rate / onset_rate); the laws of this form differ only in chi(restitution)."""

    factor: float  # chi, 1


class ApproachHysteresis(NamedTuple):
    """The same while the bodies approach, the elastic force alone while they part."""

    factor: float  # chi, 1


class ViscousSpring(NamedTuple):
    """F = F_elastic + c rate."""

    damping: float  # c, N s/m


class PullingSpring(NamedTuple):
    """The same, but it pulls towards the end until the surfaces part."""

    damping: float  # N s/m


class RootDamper(NamedTuple):
    """F = F_elastic + d sqrt(F_elastic / pen) rate; it pulls towards the end until the surfaces part."""

    damping: float  # d, kg^0.5: sqrt(F_elastic / pen) is the root of a stiffness


class ApproachRootDamper(NamedTuple):
    """The same while the bodies approach, the elastic force alone while they part."""

    damping: float  # kg^0.5


class RootViscous(NamedTuple):
    """F = F_elastic + g sqrt(pen) rate."""

    damping: float  # g, N s/m^1.5


class SteppedDamper(NamedTuple):
    """F = F_elastic + c step(pen) rate, with step growing as 3 x^2 - 2 x^3 of x = pen / depth from 0 to 1."""

    damping: float  # c, N s/m
    depth: float  # m


class Plastic(NamedTuple):
    """F = F_elastic(pen) while it deepens, then along the same curve shrunk towards the deepest point.

    Back and forth below the deepest point: F = F_elastic((pen - left) / e^2), left = (1 - e^2) deepest being the
    indentation that stays.  The share e^2 of the work done while it deepens comes back.
    """

    returned_share: float  # e^2, 1
    yield_rate: float  # m/s, onset rate up to which all is elastic
    deepest: float = 0.0  # m, where the contact last turned from deepening to parting; 0 while it deepens


@contact_force.member(Lossless)
def _lossless(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force, force


@contact_force.member(Hysteresis)
def _hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * (law.factor / onset_rate) * rate, force


@contact_force.member(ApproachHysteresis)
def _approach_hysteresis(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + force * (law.factor / onset_rate) * max(rate, 0.0), force


@contact_force.member(ViscousSpring)
@contact_force.member(PullingSpring)
def _viscous_spring(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * rate, force


@contact_force.member(RootDamper)
def _root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root = math.sqrt(force / pen) if pen > 0.0 else 0.0  # the limit, but for a linear spring: of no account at a point
    return force + law.damping * root * rate, force


@contact_force.member(ApproachRootDamper)
def _approach_root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root = math.sqrt(force / pen) if pen > 0.0 else 0.0
    return force + law.damping * root * max(rate, 0.0), force


@contact_force.member(RootViscous)
def _root_viscous(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * math.sqrt(pen) * rate, force


@contact_force.member(SteppedDamper)
def _stepped_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    x = min(pen / law.depth, 1.0)
    return force + law.damping * x * x * (3.0 - 2.0 * x) * rate, force


@contact_force.member(Plastic)
def _plastic(law, elastic, pen, rate, onset_rate):
    share = law.returned_share if onset_rate > law.yield_rate else 1.0
    if law.deepest < SHALLOW:
        force = elastic_force(elastic, pen)
        return force, share * force
    rest = (pen - (1.0 - share) * law.deepest) / share
    force = math.copysign(elastic_force(elastic, abs(rest)), rest)  # below 0 where the indentation is clear
    return force, max(force, 0.0)


@recalled.member(Plastic)
def _plastic_recalled(law, y, place):
    return Plastic(law.returned_share, law.yield_rate, y[place])


@memory.member(Plastic)
def _depth(law):
    return (SHALLOW,)  # changes at events alone; below what the law tells apart, so that no derivative spans the change


def _pushes(law):
    return 0.0


def _pulls(law):
    return -math.inf


for _law in contact_force.members:
    lowest_force.member(_law)(_pulls if _law in (PullingSpring, RootDamper) else _pushes)


def _product(law, elastic):
    return parity(elastic)


def _sum(law, elastic):
    return 1.0


for _law in contact_force.members:
    sign_beyond.member(_law)(_product if _law in (Lossless, Hysteresis, ApproachHysteresis, Plastic) else _sum)
