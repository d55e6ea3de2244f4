"""Where the bodies of a slider-crank with clearance are, in minimal coordinates; and of a pair.

Crank, rod and slider hang together at three pins: A (ground-crank), B (crank-rod), C (rod-slider).  The crank turns at
constant speed.  Which pins have clearance decides the coordinates, so each choice is a type of its own:

=======  =======================================  =============================================================
open     coordinates q                            rod
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

from ..compiled.calculus import direction
from ..compiled.family import family, kernel
from ..joint.dry import Gap


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


class Pose(NamedTuple):
    """Where the bodies are and how they move."""

    c1: float  # cosine of the crank angle
    s1: float
    c2: float  # cosine of the rod angle
    s2: float
    rod_rate: float  # rad/s
    ax: float  # m, crank pivot
    ay: float
    avx: float  # m/s
    avy: float
    bx: float  # m, rod's end at the crank pin
    by: float
    bvx: float  # m/s
    bvy: float
    x: float  # m, slider
    v: float  # m/s


class OpenA(NamedTuple):
    """Clearance at ground-crank."""

    links: Links


class OpenB(NamedTuple):
    """Clearance at crank-rod."""

    links: Links


class OpenC(NamedTuple):
    """Clearance at rod-slider."""

    links: Links


class OpenAB(NamedTuple):
    """Clearance at ground-crank and crank-rod."""

    links: Links


class OpenAC(NamedTuple):
    """Clearance at ground-crank and rod-slider."""

    links: Links


class OpenBC(NamedTuple):
    """Clearance at crank-rod and rod-slider."""

    links: Links


class OpenABC(NamedTuple):
    """Clearance at all three joints."""

    links: Links


class Pair(NamedTuple):
    """Two bodies on a line with one gap; the coordinate is the displacement of the second relative to the first."""

    mass: float  # kg, m1 m2 / (m1 + m2)


#: Number of coordinates of each mechanism.
COORDINATES = {OpenA: 2, OpenB: 2, OpenC: 2, OpenAB: 4, OpenAC: 4, OpenBC: 4, OpenABC: 6, Pair: 1}


@family
def pose(mechanism, y):
    """Return the Pose at the state `y`: coordinates, their rates, time."""


@family
def gaps(mechanism, p):
    """Return one Gap per open joint, in the order A, B, C, at the Pose `p`."""


@family
def body_angles(mechanism, y):
    """Return the angles (rad) of the proximal and the distal body of every open joint."""


# ---------------------------------------------------------------------------------------------- poses


@kernel
def _on_slider(mechanism, y, time, ax, ay, avx, avy):
    """Return the Pose with the rod hinged to the slider; coordinates begin with rod angle and slider x."""
    links = mechanism.links
    n = time // 2
    c1, s1 = direction(links.speed * y[time])
    c2, s2 = direction(y[0])
    rate, x, v = y[n], y[1], y[n + 1]
    length = links.rod_length
    bx, by, bvx, bvy = x - length * c2, -length * s2, v + length * rate * s2, -length * rate * c2
    return Pose(c1, s1, c2, s2, rate, ax, ay, avx, avy, bx, by, bvx, bvy, x, v)


@kernel
def _on_crank(mechanism, y, time, ax, ay, avx, avy):
    """Return the Pose with the rod hinged to the crank pin; coordinates begin with rod angle and slider x."""
    links = mechanism.links
    n = time // 2
    c1, s1 = direction(links.speed * y[time])
    c2, s2 = direction(y[0])
    length, tip = links.crank_length, links.crank_length * links.speed
    return Pose(
        c1,
        s1,
        c2,
        s2,
        y[n],
        ax,
        ay,
        avx,
        avy,
        ax + length * c1,
        ay + length * s1,
        avx - tip * s1,
        avy + tip * c1,
        y[1],
        y[n + 1],
    )


@kernel
def _floating(mechanism, y, time, ax, ay, avx, avy):
    """Return the Pose of a rod held by contacts alone; coordinates begin with rod angle, slider x, rod centre x, y."""
    links = mechanism.links
    n = time // 2
    c1, s1 = direction(links.speed * y[time])
    c2, s2 = direction(y[0])
    rate, arm = y[n], links.rod_center
    return Pose(
        c1,
        s1,
        c2,
        s2,
        rate,
        ax,
        ay,
        avx,
        avy,
        y[2] - arm * c2,
        y[3] - arm * s2,
        y[n + 2] + arm * rate * s2,
        y[n + 3] - arm * rate * c2,
        y[1],
        y[n + 1],
    )


@pose.member(OpenC)
def _pose_c(mechanism, y):
    return _on_crank(mechanism, y, 4, 0.0, 0.0, 0.0, 0.0)


@pose.member(OpenB)
def _pose_b(mechanism, y):
    return _on_slider(mechanism, y, 4, 0.0, 0.0, 0.0, 0.0)


@pose.member(OpenA)
def _pose_a(mechanism, y):
    p = _on_slider(mechanism, y, 4, 0.0, 0.0, 0.0, 0.0)
    length, tip = mechanism.links.crank_length, mechanism.links.crank_length * mechanism.links.speed
    return Pose(
        p.c1,
        p.s1,
        p.c2,
        p.s2,
        p.rod_rate,
        p.bx - length * p.c1,
        p.by - length * p.s1,
        p.bvx + tip * p.s1,
        p.bvy - tip * p.c1,
        p.bx,
        p.by,
        p.bvx,
        p.bvy,
        p.x,
        p.v,
    )


@pose.member(OpenAB)
def _pose_ab(mechanism, y):
    return _on_slider(mechanism, y, 8, y[2], y[3], y[6], y[7])


@pose.member(OpenAC)
def _pose_ac(mechanism, y):
    return _on_crank(mechanism, y, 8, y[2], y[3], y[6], y[7])


@pose.member(OpenBC)
def _pose_bc(mechanism, y):
    return _floating(mechanism, y, 8, 0.0, 0.0, 0.0, 0.0)


@pose.member(OpenABC)
def _pose_abc(mechanism, y):
    return _floating(mechanism, y, 12, y[4], y[5], y[10], y[11])


@pose.member(Pair)
def _pose_pair(mechanism, y):
    return Pose(1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, y[0], y[1])


# ---------------------------------------------------------------------------------------------- gaps


@kernel
def _gap_a(links, p):
    return Gap(p.ax, p.ay, p.avx, p.avy, 0.0, links.speed)


@kernel
def _gap_b(links, p):
    length, tip = links.crank_length, links.crank_length * links.speed
    return Gap(
        p.bx - p.ax - length * p.c1,
        p.by - p.ay - length * p.s1,
        p.bvx - p.avx + tip * p.s1,
        p.bvy - p.avy - tip * p.c1,
        links.speed,
        p.rod_rate,
    )


@kernel
def _gap_c(links, p):
    length, tip = links.rod_length, links.rod_length * p.rod_rate
    return Gap(
        p.x - p.bx - length * p.c2,
        -p.by - length * p.s2,
        p.v - p.bvx + tip * p.s2,
        -p.bvy - tip * p.c2,
        p.rod_rate,
        0.0,
    )


@gaps.member(OpenA)
def _gaps_a(mechanism, p):
    return (_gap_a(mechanism.links, p),)


@gaps.member(OpenB)
def _gaps_b(mechanism, p):
    return (_gap_b(mechanism.links, p),)


@gaps.member(OpenC)
def _gaps_c(mechanism, p):
    return (_gap_c(mechanism.links, p),)


@gaps.member(OpenAB)
def _gaps_ab(mechanism, p):
    return (_gap_a(mechanism.links, p), _gap_b(mechanism.links, p))


@gaps.member(OpenAC)
def _gaps_ac(mechanism, p):
    return (_gap_a(mechanism.links, p), _gap_c(mechanism.links, p))


@gaps.member(OpenBC)
def _gaps_bc(mechanism, p):
    return (_gap_b(mechanism.links, p), _gap_c(mechanism.links, p))


@gaps.member(OpenABC)
def _gaps_abc(mechanism, p):
    return (_gap_a(mechanism.links, p), _gap_b(mechanism.links, p), _gap_c(mechanism.links, p))


@gaps.member(Pair)
def _gaps_pair(mechanism, p):
    return (Gap(p.x, 0.0, p.v, 0.0, 0.0, 0.0),)


# ---------------------------------------------------------------------------------------------- angles of the bodies


@body_angles.member(OpenA)
def _angles_a(mechanism, y):
    return ((0.0, mechanism.links.speed * y[4]),)


@body_angles.member(OpenB)
def _angles_b(mechanism, y):
    return ((mechanism.links.speed * y[4], y[0]),)


@body_angles.member(OpenC)
def _angles_c(mechanism, y):
    return ((y[0], 0.0),)


@body_angles.member(OpenAB)
def _angles_ab(mechanism, y):
    crank = mechanism.links.speed * y[8]
    return ((0.0, crank), (crank, y[0]))


@body_angles.member(OpenAC)
def _angles_ac(mechanism, y):
    return ((0.0, mechanism.links.speed * y[8]), (y[0], 0.0))


@body_angles.member(OpenBC)
def _angles_bc(mechanism, y):
    return ((mechanism.links.speed * y[8], y[0]), (y[0], 0.0))


@body_angles.member(OpenABC)
def _angles_abc(mechanism, y):
    crank = mechanism.links.speed * y[12]
    return ((0.0, crank), (crank, y[0]), (y[0], 0.0))


@body_angles.member(Pair)
def _angles_pair(mechanism, y):
    return ((0.0, 0.0),)
