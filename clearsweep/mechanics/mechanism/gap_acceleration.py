"""How the rates of the gaps change: the accelerations of the pins relative to each other."""

from typing import NamedTuple

from ..compiled.dual import alike
from ..compiled.family import family, kernel
from .slider_crank import OpenA, OpenAB, OpenABC, OpenAC, OpenB, OpenBC, OpenC


class Swing(NamedTuple):
    """How the rates of a Gap change."""

    ax: float  # m/s^2
    ay: float
    proximal: float  # rad/s^2
    distal: float


@family
def swings(mechanism, p, m):
    """Return one Swing per open joint, in the order A, B, C, at the Pose `p` and the Motion `m`."""


@kernel
def _turning(p, alpha):
    """Return minus the second derivative of the unit vector along the rod, 1/s^2."""
    rate2 = p.rod_rate * p.rod_rate
    return alpha * p.s2 + rate2 * p.c2, rate2 * p.s2 - alpha * p.c2


@kernel
def _pull(links, p):
    """Return minus the acceleration of the crank pin on a crank that turns about a fixed pivot, m/s^2."""
    pull = links.crank_length * links.speed * links.speed
    return pull * p.c1, pull * p.s1


@kernel
def _at_ground(ax, ay):
    """Return the Swing of ground-crank where the crank's pivot accelerates by (ax, ay)."""
    return Swing(ax, ay, alike(0.0, ax), alike(0.0, ax))


@kernel
def _at_crank(links, p, alpha, ax, ay, bx, by):
    """Return the Swing of crank-rod where the crank's pivot accelerates by (ax, ay) and the rod's end by (bx, by)."""
    pull_x, pull_y = _pull(links, p)
    return Swing(bx - ax + pull_x, by - ay + pull_y, alike(0.0, alpha), alpha)


@kernel
def _at_slider(links, p, alpha, a, bx, by):
    """Return the Swing of rod-slider where the rod's other end accelerates by (bx, by) and the slider by `a`."""
    ux, uy = _turning(p, alpha)
    return Swing(a - bx + links.rod_length * ux, -by + links.rod_length * uy, alpha, alike(0.0, alpha))


@kernel
def _hinged(links, p, alpha, a):
    """Return the acceleration (m/s^2) of the end of a rod whose other end is on the slider."""
    ux, uy = _turning(p, alpha)
    return a + links.rod_length * ux, links.rod_length * uy


@kernel
def _floating(links, p, alpha, gx, gy):
    """Return the acceleration (m/s^2) of the end of a rod whose centre accelerates by (gx, gy)."""
    ux, uy = _turning(p, alpha)
    return gx + links.rod_center * ux, gy + links.rod_center * uy


@swings.member(OpenA)
def _swings_a(mechanism, p, m):
    bx, by = _hinged(mechanism.links, p, m.q0, m.q1)
    pull_x, pull_y = _pull(mechanism.links, p)
    return (_at_ground(bx + pull_x, by + pull_y),)


@swings.member(OpenB)
def _swings_b(mechanism, p, m):
    bx, by = _hinged(mechanism.links, p, m.q0, m.q1)
    return (_at_crank(mechanism.links, p, m.q0, 0.0, 0.0, bx, by),)


@swings.member(OpenC)
def _swings_c(mechanism, p, m):
    pull_x, pull_y = _pull(mechanism.links, p)
    return (_at_slider(mechanism.links, p, m.q0, m.q1, -pull_x, -pull_y),)


@swings.member(OpenAB)
def _swings_ab(mechanism, p, m):
    bx, by = _hinged(mechanism.links, p, m.q0, m.q1)
    return (_at_ground(m.q2, m.q3), _at_crank(mechanism.links, p, m.q0, m.q2, m.q3, bx, by))


@swings.member(OpenAC)
def _swings_ac(mechanism, p, m):
    pull_x, pull_y = _pull(mechanism.links, p)
    at_slider = _at_slider(mechanism.links, p, m.q0, m.q1, m.q2 - pull_x, m.q3 - pull_y)
    return (_at_ground(m.q2, m.q3), at_slider)


@swings.member(OpenBC)
def _swings_bc(mechanism, p, m):
    links = mechanism.links
    bx, by = _floating(links, p, m.q0, m.q2, m.q3)
    return (_at_crank(links, p, m.q0, 0.0, 0.0, bx, by), _at_slider(links, p, m.q0, m.q1, bx, by))


@swings.member(OpenABC)
def _swings_abc(mechanism, p, m):
    links = mechanism.links
    bx, by = _floating(links, p, m.q0, m.q2, m.q3)
    return (
        _at_ground(m.q4, m.q5),
        _at_crank(links, p, m.q0, m.q4, m.q5, bx, by),
        _at_slider(links, p, m.q0, m.q1, bx, by),
    )
