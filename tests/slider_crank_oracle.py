"""The slider-crank without clearance in closed form, with numpy only: reference for planar machines."""

import numpy as np


def slider(crank_length, rod_length, crank_angle, speed):
    """Return position (m), velocity (m/s) and acceleration (m/s^2) of the slider at `crank_angle` (rad; array or
    number).

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


def reactions(bodies, speed, crank_angle) -> dict[str, np.ndarray]:
    """Return the force (..., 2) N on the distal body of each joint at `crank_angle` (rad, array of any shape).

    `bodies` : numbers in SI by key, such as 'crank.length'; `speed` : rad/s.  Newton-Euler for rod, slider and crank.
    """
    angle = np.asarray(crank_angle, dtype=float)
    radius, length, center = bodies["crank.length"], bodies["rod.length"], bodies["rod.center"]
    u1 = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    sin2 = -radius * u1[..., 1] / length
    cos2 = np.sqrt(1.0 - sin2**2)
    u2 = np.stack([cos2, sin2], axis=-1)
    n2 = np.stack([-sin2, cos2], axis=-1)
    rate = -radius * speed * u1[..., 0] / (length * cos2)
    alpha = (radius * speed**2 * u1[..., 1] + length * rate**2 * sin2) / (length * cos2)
    _, _, acceleration = slider(radius, length, angle, speed)
    weight = np.array([0.0, bodies["gravity"]])  # minus the acceleration of gravity
    rod_acceleration = -(speed**2) * radius * u1 + center * (alpha[..., None] * n2 - rate[..., None] ** 2 * u2)
    inertial = bodies["rod.mass"] * (rod_acceleration + weight)
    on_rod_x = -bodies["slider.mass"] * acceleration
    angle_rate = bodies["rod.inertia"] * alpha + center * _cross(u2, inertial)  # about the crank pin
    on_rod_y = (angle_rate / length + sin2 * on_rod_x) / cos2
    at_slider = np.stack([on_rod_x, on_rod_y], axis=-1)
    at_crank = inertial - at_slider
    crank_acceleration = -(speed**2) * bodies["crank.center"] * u1
    at_ground = bodies["crank.mass"] * (crank_acceleration + weight) + at_crank
    at_guide = np.stack([0.0 * on_rod_y, bodies["slider.mass"] * bodies["gravity"] + on_rod_y], axis=-1)
    return {"ground-crank": at_ground, "crank-rod": at_crank, "rod-slider": -at_slider, "slider-ground": at_guide}


def torque(bodies, at_crank: np.ndarray, crank_angle) -> np.ndarray:
    """Return the torque (N m) for constant speed, from the force (..., 2) N of the crank on the rod."""
    angle = np.asarray(crank_angle, dtype=float)
    u1 = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    weight = bodies["crank.mass"] * bodies["gravity"] * bodies["crank.center"] * u1[..., 0]
    return bodies["crank.length"] * _cross(u1, at_crank) + weight


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
