"""Distance between the points of a joint along a direction, which a constraint keeps at 0."""

from typing import Any

from ....contracts.machine import GROUND, Slot, Stretch
from ...trace import portable


def put_component(closure: Any, joint: Slot | Stretch, axis: float, motion: tuple, out: tuple, row: int) -> None:
    """Write the distance along `axis` (rad, in the frame of the proximal body) to `row` of the constraints.

    motion : coordinates and their derivatives by the crank's angle, each (..., 3 bodies); out : as in
    `Closure.evaluate`.
    """
    (q, q_rates), (values, jacobian, bias) = motion, out
    proximal, distal = (closure.point_motion(endpoint, q, q_rates) for endpoint in (joint.proximal, joint.distal))
    axis_angle, rate = closure.angle(joint.proximal.body, q) + axis, closure.angle(joint.proximal.body, q_rates)
    c, s = portable.cos(axis_angle), portable.sin(axis_angle)
    x, y, dx, dy = distal.x - proximal.x, distal.y - proximal.y, distal.dx - proximal.dx, distal.dy - proximal.dy
    for body, sign, point in ((joint.proximal.body, -1.0, proximal), (joint.distal.body, 1.0, distal)):
        if body == GROUND:
            continue
        i = 3 * closure.index[body]
        jacobian[..., row, i], jacobian[..., row, i + 1] = sign * c, sign * s
        jacobian[..., row, i + 2] = sign * (c * point.lever_x + s * point.lever_y)
        if sign < 0.0:
            jacobian[..., row, i + 2] += c * y - s * x
    values[..., row] = c * x + s * y
    axial_curvature = c * (distal.ddx - proximal.ddx) + s * (distal.ddy - proximal.ddy)
    bias[..., row] = axial_curvature + 2.0 * rate * (c * dy - s * dx) - rate**2 * values[..., row]
