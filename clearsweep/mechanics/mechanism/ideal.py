"""The slider-crank without clearance, in closed form: what every comparison is with.  Imports numpy alone."""

import functools
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np


def slider(crank_length, rod_length, crank_angle, speed):
    """Return place (m), velocity (m/s) and acceleration (m/s^2) of the slider at `crank_angle` (rad; array or number).

    `speed` in rad/s.  Derivatives of x = r cos t + sqrt(l^2 - r^2 sin^2 t) at constant speed.
    """
    cos, sin = np.cos(crank_angle), np.sin(crank_angle)
    reach = np.sqrt(rod_length**2 - (crank_length * sin) ** 2)
    x = crank_length * cos + reach
    v = -speed * crank_length * sin * (1.0 + crank_length * cos / reach)
    a = (
        -(speed**2)
        * crank_length
        * (
            cos
            + crank_length * np.cos(2.0 * crank_angle) / reach
            + crank_length**3 * np.sin(2.0 * crank_angle) ** 2 / (4.0 * reach**3)
        )
    )
    return x, v, a


class Reactions(NamedTuple):
    """Forces (N) on the distal body of each joint, arrays (..., 2): on the crank, on the rod, on the slider."""

    ground_crank: np.ndarray
    crank_rod: np.ndarray
    rod_slider: np.ndarray


def reactions(values: Mapping[str, float], speed: float, crank_angle) -> Reactions:
    """Return the joint reactions of the ideal mechanism at `crank_angle` (rad, array of any shape).

    `values` : those of the case's mechanism, SI; `speed` : rad/s.  Newton-Euler for rod, slider and crank.
    """
    angle = np.asarray(crank_angle, dtype=float)
    radius, length, center = values["crank.length"], values["rod.length"], values["rod.center"]
    u1 = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    sin2 = -radius * u1[..., 1] / length
    cos2 = np.sqrt(1.0 - sin2**2)
    u2 = np.stack([cos2, sin2], axis=-1)
    n2 = np.stack([-sin2, cos2], axis=-1)
    rate = -radius * speed * u1[..., 0] / (length * cos2)
    alpha = (radius * speed**2 * u1[..., 1] + length * rate**2 * sin2) / (length * cos2)
    _, _, acceleration = slider(radius, length, angle, speed)
    weight = np.array([0.0, values["gravity"]])  # minus the acceleration of gravity
    rod_acceleration = -(speed**2) * radius * u1 + center * (alpha[..., None] * n2 - rate[..., None] ** 2 * u2)
    inertial = values["rod.mass"] * (rod_acceleration + weight)
    on_rod_x = -values["slider.mass"] * acceleration
    turning = values["rod.inertia"] * alpha + center * _cross(u2, inertial)  # about the crank pin
    on_rod_y = (turning / length + sin2 * on_rod_x) / cos2
    at_slider = np.stack([on_rod_x, on_rod_y], axis=-1)
    at_crank = inertial - at_slider
    crank_acceleration = -(speed**2) * values["crank.center"] * u1
    return Reactions(values["crank.mass"] * (crank_acceleration + weight) + at_crank, at_crank, -at_slider)


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def largest_reactions(values: Mapping[str, float], speed: float) -> dict[str, float]:
    """Return the largest reaction (N) of each joint of the ideal mechanism over a turn of the crank."""
    return _largest_reactions(tuple(sorted(values.items())), speed)


@functools.lru_cache(maxsize=256)  # the cases of a sweep share few mechanisms and speeds
def _largest_reactions(values: tuple, speed: float) -> dict[str, float]:
    count = 720  # with the parabola, exact to about 1e-9
    angles = 2.0 * np.pi * np.arange(count) / count
    result = {}
    for name, forces in reactions(dict(values), speed, angles)._asdict().items():
        size = np.hypot(forces[:, 0], forces[:, 1])
        top = int(np.argmax(size))
        before, here, after = size[top - 1], size[top], size[(top + 1) % count]
        bend = before - 2.0 * here + after
        result[name] = float(here - (after - before) ** 2 / (8.0 * bend) if bend < 0.0 else here)  # parabola
    return result
