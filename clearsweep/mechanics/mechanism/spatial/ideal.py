"""The nominal planar slider-crank of one in space: what comparisons are with.  Imports numpy and its twin alone."""

import numpy as np

from ..contract import IdealMotion
from ..slider_crank.ideal import slider


def ideal(bodies, drive, angles) -> IdealMotion:
    """Return the motion of the slider and the reactions in the plane without clearance at crank angles (rad).

    Newton-Euler for rod, slider and crank; bodies : numbers in SI by key, drive : rad/s.
    """
    angle = np.asarray(angles, dtype=float)
    radius, length = bodies["crank.length"], bodies["rod.length"]
    x, v, a = slider(radius, length, angle, drive)
    gravity = np.array([bodies["gravity.0"], bodies["gravity.1"]])
    u1, n1 = _axes(np.cos(angle), np.sin(angle))
    sine = -radius * u1[..., 1] / length
    u2, n2 = _axes(np.sqrt(1.0 - sine**2), sine)
    rate = -radius * drive * u1[..., 0] / (length * u2[..., 0])
    alpha = (radius * drive**2 * u1[..., 1] + length * rate**2 * sine) / (length * u2[..., 0])
    center = bodies["rod.center.0"] * u2 + bodies["rod.center.1"] * n2
    swing = alpha[..., None] * _turned(center) - rate[..., None] ** 2 * center
    inertial = bodies["rod.mass"] * (-(drive**2) * radius * u1 + swing - gravity)
    about = bodies["rod.inertia.2"] * alpha + center[..., 0] * inertial[..., 1] - center[..., 1] * inertial[..., 0]
    on_rod_x = -bodies["slider.mass"] * (a - gravity[0])
    at_slider = np.stack([on_rod_x, (about / length + sine * on_rod_x) / u2[..., 0]], axis=-1)
    at_crank = inertial - at_slider
    hub = bodies["crank.center.0"] * u1 + bodies["crank.center.1"] * n1
    at_ground = bodies["crank.mass"] * (-(drive**2) * hub - gravity) + at_crank
    torque = radius * _cross(u1, at_crank) - bodies["crank.mass"] * _cross(hub, gravity)
    return IdealMotion(x, v, a, {"ground-crank": at_ground, "crank-rod": at_crank, "rod-slider": -at_slider}, torque)


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _axes(cosine, sine):
    along = np.stack([cosine, sine], axis=-1)
    return along, _turned(along)


def _turned(a):
    """Return vectors (..., 2) turned by 90 degrees."""
    return np.stack([-a[..., 1], a[..., 0]], axis=-1)
