"""Where the bodies of a slider-crank with clearance are, in minimal coordinates.

Crank, rod and slider hang together at three pins: A (ground-crank), B (crank-rod), C (rod-slider).  The crank turns at
constant speed.  Which pins have clearance decides the coordinates:

=======  =======================================  =============================================================
open     coordinates                              rod
=======  =======================================  =============================================================
C        rod angle, slider x                      hinged to the crank pin
A, B     rod angle, slider x                      hinged to the slider (A: the crank hangs on the rod)
AB       rod angle, slider x, crank pivot x, y    hinged to the slider, crank floating
AC       rod angle, slider x, crank pivot x, y    hinged to the crank, both floating
BC       rod angle, slider x, rod centre x, y     floating
ABC      rod angle, slider x, rod centre x, y, crank pivot x, y
=======  =======================================  =============================================================
"""

from typing import NamedTuple

from ...compiled.calculus import direction
from ...compiled.family import family, kernel
from ...joint.dry import Gap
from ..contract import Ideal, Open, at_open, body_angles, gaps, place


class Links(NamedTuple):
    """Lengths, masses and the drive."""

    crank_length: float  # m
    crank_center: float  # m, pivot to centre of mass
    crank_mass: float  # kg
    crank_inertia: float  # kg m^2, about the centre of mass
    rod_length: float  # m
    rod_center: float  # m, crank pin to centre of mass
    rod_mass: float  # kg
    rod_inertia: float  # kg m^2, about the centre of mass
    slider_mass: float  # kg
    gravity: float  # m/s^2, along -y
    speed: float  # rad/s


class SliderCrank(NamedTuple):
    """The compiled form: the types of its sites choose the coordinates and the equations."""

    links: Links
    sites: tuple  # Ideal() or Open() at A, B, C


class Point(NamedTuple):
    """Where a point of a body is and how it moves."""

    x: float  # m
    y: float
    vx: float  # m/s
    vy: float


class Turns(NamedTuple):
    """How crank and rod are turned."""

    c1: float  # cosine of the crank angle
    s1: float
    c2: float  # cosine of the rod angle
    s2: float
    rod_rate: float  # rad/s


class Pose(NamedTuple):
    """Where the bodies are and how they move."""

    c1: float  # cosine of the crank angle
    s1: float
    c2: float  # cosine of the rod angle
    s2: float
    rod_rate: float  # rad/s
    pivot: Point  # of the crank, at A
    pin: Point  # the rod's end at B
    x: float  # m, slider
    v: float  # m/s


ROD, SLIDER = 0, 1  # where the coordinates that every opening has stand in the state: rod angle, slider x


class Places(NamedTuple):
    """Where the other coordinates stand, x before y; the rate of each is `count` further, time behind all rates."""

    count: int  # of coordinates
    center: int = 0  # of the rod
    pivot: int = 0  # of the crank


@family
def places(mechanism):
    """Return the Places of the coordinates; what an opening has no coordinates for is of no meaning there."""


def _constant(number):
    return lambda mechanism: number


for _sites, _places in (
    ((Open, Ideal, Ideal), Places(2)),
    ((Open, Open, Open), Places(6, center=2, pivot=4)),
    ((Ideal, Open, Open), Places(4, center=2)),
    ((Open, None, None), Places(4, pivot=2)),
    ((Ideal, None, None), Places(2)),
):
    places.member(SliderCrank, sites=_sites)(_constant(_places))


@place.member(SliderCrank)
def _place(mechanism, y):
    count = places(mechanism).count
    c1, s1 = direction(mechanism.links.speed * y[2 * count])
    c2, s2 = direction(y[ROD])
    rate = y[count + ROD]
    pivot, pin = _ends(mechanism, y, Turns(c1, s1, c2, s2, rate))
    return Pose(c1, s1, c2, s2, rate, pivot, pin, y[SLIDER], y[count + SLIDER])


@family
def _ends(mechanism, y, turns):
    """Return the Points of the crank's pivot and of the rod's end at B."""


@family
def _pivot(mechanism, y):
    """Return the Point of the crank's pivot where it is fixed or has coordinates."""


@_pivot.member(SliderCrank, sites=(Ideal, None, None))
def _fixed_pivot(mechanism, y):
    return Point(0.0, 0.0, 0.0, 0.0)


@_pivot.member(SliderCrank, sites=(Open, None, None))
def _floating_pivot(mechanism, y):
    at = places(mechanism).pivot
    rate = places(mechanism).count + at
    return Point(y[at], y[at + 1], y[rate], y[rate + 1])


@kernel
def _pin_of_slider(mechanism, y, turns):
    """Return the Point at B of a rod hinged to the slider."""
    x, v, length = y[SLIDER], y[places(mechanism).count + SLIDER], mechanism.links.rod_length
    c2, s2, rate = turns.c2, turns.s2, turns.rod_rate
    return Point(x - length * c2, -length * s2, v + length * rate * s2, -length * rate * c2)


@_ends.member(SliderCrank, sites=(Open, Ideal, Ideal))
def _hanging_crank(mechanism, y, turns):
    length, c1, s1 = mechanism.links.crank_length, turns.c1, turns.s1
    tip = length * mechanism.links.speed
    pin = _pin_of_slider(mechanism, y, turns)
    return Point(pin.x - length * c1, pin.y - length * s1, pin.vx + tip * s1, pin.vy - tip * c1), pin


@_ends.member(SliderCrank, sites=(None, None, Ideal))
def _rod_on_slider(mechanism, y, turns):
    return _pivot(mechanism, y), _pin_of_slider(mechanism, y, turns)


@_ends.member(SliderCrank, sites=(None, Ideal, Open))
def _rod_on_crank(mechanism, y, turns):
    length, c1, s1 = mechanism.links.crank_length, turns.c1, turns.s1
    tip = length * mechanism.links.speed
    pivot = _pivot(mechanism, y)
    return pivot, Point(pivot.x + length * c1, pivot.y + length * s1, pivot.vx - tip * s1, pivot.vy + tip * c1)


@_ends.member(SliderCrank, sites=(None, Open, Open))
def _floating_rod(mechanism, y, turns):
    at, arm = places(mechanism).center, mechanism.links.rod_center
    rate = places(mechanism).count + at
    c2, s2, spin = turns.c2, turns.s2, turns.rod_rate
    pin = Point(y[at] - arm * c2, y[at + 1] - arm * s2, y[rate] + arm * spin * s2, y[rate + 1] - arm * spin * c2)
    return _pivot(mechanism, y), pin


@gaps.member(SliderCrank)
def _gaps(mechanism, p):
    links, pivot, pin = mechanism.links, p.pivot, p.pin
    crank, tip = links.crank_length, links.crank_length * links.speed
    rod, end = links.rod_length, links.rod_length * p.rod_rate
    at_ground = Gap(pivot.x, pivot.y, pivot.vx, pivot.vy, 0.0, links.speed)
    at_crank = Gap(
        pin.x - pivot.x - crank * p.c1,
        pin.y - pivot.y - crank * p.s1,
        pin.vx - pivot.vx + tip * p.s1,
        pin.vy - pivot.vy - tip * p.c1,
        links.speed,
        p.rod_rate,
    )
    at_slider = Gap(
        p.x - pin.x - rod * p.c2,
        -pin.y - rod * p.s2,
        p.v - pin.vx + end * p.s2,
        -pin.vy - end * p.c2,
        p.rod_rate,
        0.0,
    )
    return at_open(mechanism.sites, (at_ground, at_crank, at_slider))


@body_angles.member(SliderCrank)
def _body_angles(mechanism, y):
    crank = mechanism.links.speed * y[2 * places(mechanism).count]
    return at_open(mechanism.sites, ((0.0, crank), (crank, y[ROD]), (y[ROD], 0.0)))
