"""Distance between the points of a joint along a direction, which a constraint keeps at 0."""

from typing import Any

from ....contracts.machine import GROUND, Slot, Stretch
from ...trace import portable


def put_component(closure: Any, joint: Slot | Stretch, axis: float, motion: tuple, out: tuple, row: int) -> None:
    """Write the distance along `axis` (rad, in the frame of the proximal body) to `row` of the constraints.

    motion : coordinates and their derivatives by the crank's angle, each (..., 3 bodies); out : as in
    `Closure.evaluate`.
    """
    (q, q_rates), (values, jacobian, lacking) = motion, out
    near_end, far_end = (closure.end(endpoint, q, q_rates) for endpoint in (joint.proximal, joint.distal))
    axis_angle, rate = closure.angle(joint.proximal.body, q) + axis, closure.angle(joint.proximal.body, q_rates)
    c, s = portable.cos(axis_angle), portable.sin(axis_angle)
    x, y, dx, dy = far_end.x - near_end.x, far_end.y - near_end.y, far_end.dx - near_end.dx, far_end.dy - near_end.dy
    for body, sign, body_end in ((joint.proximal.body, -1.0, near_end), (joint.distal.body, 1.0, far_end)):
        if body == GROUND:
            continue
        i = 3 * closure.index[body]
        jacobian[..., row, i], jacobian[..., row, i + 1] = sign * c, sign * s
        jacobian[..., row, i + 2] = sign * (c * body_end.lever_x + s * body_end.lever_y)
        if sign < 0.0:
            jacobian[..., row, i + 2] += c * y - s * x
    values[..., row] = c * x + s * y
    axial_curvature = c * (far_end.ddx - near_end.ddx) + s * (far_end.ddy - near_end.ddy)
    lacking[..., row] = axial_curvature + 2.0 * rate * (c * dy - s * dx) - rate**2 * values[..., row]
