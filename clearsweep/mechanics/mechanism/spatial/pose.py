"""Where the bodies of a slider-crank in space are, and how journals stand in their bearings."""

from typing import NamedTuple

from ...compiled.attitude import Frame, Turning, frame_of, in_body, spin_of
from ...compiled.calculus import direction
from ...compiled.family import family, kernel
from ...compiled.vector import Vector, along, cross, minus, plus, times
from ...joint.spatial import SpatialGap
from ..contract import body_angles, gaps, place
from .form import Bearing, Cylindrical, SpatialSliderCrank, Spherical

SLIDER, RISE, ANGLE = 0, 1, 2  # where coordinates stand; those of a rod that does not tilt
TURNED, CENTER = 1, 5  # of one that does: the first number of its quaternion, of its centre of mass


class Pose(NamedTuple):
    """Where the bodies are and how they move."""

    c1: float  # cosine of the crank angle
    s1: float
    x: float  # m, slider
    v: float  # m/s
    turning: tuple  # Turning of the rod; () where its angle says it all
    frame: Frame  # of the rod
    spin: Vector  # rad/s, of the rod, in its own frame
    pin: Vector  # m, its first pin in the fixed frame
    pin_velocity: Vector  # m/s, in the frame of the rod


@family
def count(mechanism):
    """Return how many coordinates there are."""


def _constant(number):
    return lambda mechanism: number


#: What may be open, and how many coordinates it leaves.
OPENINGS = (
    ((Bearing, Spherical), 5),
    ((Spherical, Bearing), 5),
    ((Bearing, Bearing), 8),
    ((Bearing, Cylindrical), 3),
    ((Cylindrical, Bearing), 3),
)
for _sites, _number in OPENINGS:
    count.member(SpatialSliderCrank, sites=_sites)(_constant(_number))


class _Stance(NamedTuple):
    """How the rod is turned."""

    turning: tuple
    frame: Frame
    spin: Vector


@family
def _stance(mechanism, y):
    """Return the _Stance of the rod."""


@_stance.member(SpatialSliderCrank, sites=(Cylindrical, None))
@_stance.member(SpatialSliderCrank, sites=(None, Cylindrical))
def _turned_about_z(mechanism, y):
    c, s = direction(y[ANGLE])
    zero, one = 0.0 * c, 0.0 * c + 1.0
    frame = Frame(Vector(c, -s, zero), Vector(s, c, zero), Vector(zero, zero, one))
    return _Stance((), frame, Vector(zero, zero, 1.0 * y[3 + ANGLE]))


@_stance.member(SpatialSliderCrank)
def _turned(mechanism, y):
    n = count(mechanism) + TURNED
    turning = Turning(y[1], y[2], y[3], y[4], y[n], y[n + 1], y[n + 2], y[n + 3])
    return _Stance(turning, frame_of(y[1], y[2], y[3], y[4]), spin_of(turning))


class _Crank(NamedTuple):
    """How the crank is turned."""

    c1: float
    s1: float


@family
def _pin(mechanism, y, crank, stance):
    """Return where the rod's first pin is in the fixed frame, and its velocity in the frame of the rod."""


@kernel
def _from_slider(mechanism, y, stance, rise, rising):
    """Return the same of a rod on the slider's pin, `rise` (m) above it and rising (m/s)."""
    x, v, length = y[SLIDER], y[count(mechanism)], mechanism.rod.length
    frame, spin = stance.frame, stance.spin
    pin = Vector(x - length * frame.x.x, -length * frame.y.x, rise - length * frame.z.x)
    moving = along(times(v, frame.x), rising, frame.z)
    return pin, Vector(moving.x, moving.y - length * spin.z, moving.z + length * spin.y)


@_pin.member(SpatialSliderCrank, sites=(Bearing, Spherical))
def _pin_of_ball_on_slider(mechanism, y, crank, stance):
    return _from_slider(mechanism, y, stance, 0.0 * y[SLIDER], 0.0 * y[SLIDER])


@_pin.member(SpatialSliderCrank, sites=(Bearing, Cylindrical))
def _pin_of_sleeve_on_slider(mechanism, y, crank, stance):
    return _from_slider(mechanism, y, stance, y[RISE], y[3 + RISE])


@kernel
def _from_crank(mechanism, crank, stance, rise, rising):
    """Return the same of a rod on the crank's pin."""
    radius, tip = mechanism.links.crank_length, mechanism.links.crank_length * mechanism.links.speed
    pin = Vector(radius * crank.c1, radius * crank.s1, rise)
    return pin, in_body(stance.frame, Vector(-tip * crank.s1, tip * crank.c1, rising))


@_pin.member(SpatialSliderCrank, sites=(Spherical, Bearing))
def _pin_of_ball_on_crank(mechanism, y, crank, stance):
    return _from_crank(mechanism, crank, stance, 0.0 * y[SLIDER], 0.0 * y[SLIDER])


@_pin.member(SpatialSliderCrank, sites=(Cylindrical, Bearing))
def _pin_of_sleeve_on_crank(mechanism, y, crank, stance):
    return _from_crank(mechanism, crank, stance, y[RISE], y[3 + RISE])


@_pin.member(SpatialSliderCrank, sites=(Bearing, Bearing))
def _pin_of_floating_rod(mechanism, y, crank, stance):
    n, center, frame = count(mechanism) + CENTER, mechanism.rod.center, stance.frame
    there = Vector(y[CENTER], y[CENTER + 1], y[CENTER + 2])
    moving = in_body(frame, Vector(y[n], y[n + 1], y[n + 2]))
    return _less(there, frame, center), minus(moving, cross(stance.spin, center))


@kernel
def _less(there, frame, a):
    """Return a place in the fixed frame less a vector in the frame of the rod."""
    return Vector(
        there.x - frame.x.x * a.x - frame.x.y * a.y - frame.x.z * a.z,
        there.y - frame.y.x * a.x - frame.y.y * a.y - frame.y.z * a.z,
        there.z - frame.z.x * a.x - frame.z.y * a.y - frame.z.z * a.z,
    )


@place.member(SpatialSliderCrank)
def _place(mechanism, y):
    n = count(mechanism)
    c1, s1 = direction(mechanism.links.speed * y[2 * n])
    stance = _stance(mechanism, y)
    pin, pin_velocity = _pin(mechanism, y, _Crank(c1, s1), stance)
    return Pose(c1, s1, y[SLIDER], y[n], stance.turning, stance.frame, stance.spin, pin, pin_velocity)


@kernel
def on_crank(p, a):
    """Return a vector in the frame of the crank in the fixed frame."""
    return Vector(p.c1 * a.x - p.s1 * a.y, p.s1 * a.x + p.c1 * a.y, 0.0 * p.c1 + a.z)


@kernel
def crank_bearing(mechanism, p):
    """Return where the middle of the bearing on the crank is in the fixed frame, m."""
    offset = mechanism.sites[0].offset
    return on_crank(p, Vector(mechanism.links.crank_length + offset.x, offset.y, offset.z))


@kernel
def _gap_at_crank(mechanism, p):
    speed, frame, middle = mechanism.links.speed, p.frame, crank_bearing(mechanism, p)
    moving = in_body(frame, Vector(-speed * middle.y, speed * middle.x, 0.0 * middle.z))
    return SpatialGap(
        middle=in_body(frame, minus(p.pin, middle)),
        velocity=minus(p.pin_velocity, moving),
        axis=in_body(frame, on_crank(p, mechanism.sites[0].axis)),
        on_bearing=times(speed, frame.z),
        on_journal=p.spin,
        frame=frame,
    )


@kernel
def _gap_at_slider(mechanism, p):
    frame, bearing, length = p.frame, mechanism.sites[1], mechanism.rod.length
    offset = bearing.offset
    near = in_body(frame, Vector(p.pin.x - p.x - offset.x, p.pin.y - offset.y, p.pin.z - offset.z))
    end = plus(p.pin_velocity, Vector(0.0 * p.spin.x, length * p.spin.z, -length * p.spin.y))
    return SpatialGap(
        middle=Vector(near.x + length, near.y, near.z),
        velocity=along(end, -p.v, frame.x),
        axis=in_body(frame, bearing.axis),
        on_bearing=times(0.0, frame.z),
        on_journal=p.spin,
        frame=frame,
    )


@gaps.member(SpatialSliderCrank, sites=(Bearing, Bearing))
def _at_both_pins(mechanism, p):
    return _gap_at_crank(mechanism, p), _gap_at_slider(mechanism, p)


@gaps.member(SpatialSliderCrank, sites=(Bearing, None))
def _at_crank_pin(mechanism, p):
    return (_gap_at_crank(mechanism, p),)


@gaps.member(SpatialSliderCrank, sites=(None, Bearing))
def _at_slider_pin(mechanism, p):
    return (_gap_at_slider(mechanism, p),)


@body_angles.member(SpatialSliderCrank, sites=(Bearing, Bearing))
def _of_both_bearings(mechanism, y):
    p = place(mechanism, y)
    crank, slider = mechanism.sites
    return in_body(p.frame, on_crank(p, crank.across)), in_body(p.frame, slider.across)


@body_angles.member(SpatialSliderCrank, sites=(Bearing, None))
def _of_bearing_on_crank(mechanism, y):
    p = place(mechanism, y)
    return (in_body(p.frame, on_crank(p, mechanism.sites[0].across)),)


@body_angles.member(SpatialSliderCrank, sites=(None, Bearing))
def _of_bearing_on_slider(mechanism, y):
    return (in_body(place(mechanism, y).frame, mechanism.sites[1].across),)
