"""Distance between the points of a joint along a direction, which a constraint keeps at 0."""

from typing import Any

import numpy as np

from ....contracts.machine import GROUND, Slot, Stretch


def put_component(closure: Any, joint: Slot | Stretch, axis: float, motion: tuple, out: tuple, row: int) -> None:
    """Write the distance along `axis` (rad, in the frame of the proximal body) to `row` of the constraints.

    motion : coordinates and their derivatives by the crank's angle, each (..., 3 bodies); out : as in
    `Closure.evaluate`.
    """
    (q, first), (values, jacobian, lacking) = motion, out
    near, far = (closure.end(at, q, first) for at in (joint.proximal, joint.distal))
    turned, rate = closure.angle(joint.proximal.body, q) + axis, closure.angle(joint.proximal.body, first)
    c, s = np.cos(turned), np.sin(turned)
    x, y, dx, dy = far.x - near.x, far.y - near.y, far.dx - near.dx, far.dy - near.dy
    for body, sign, end in ((joint.proximal.body, -1.0, near), (joint.distal.body, 1.0, far)):
        if body == GROUND:
            continue
        i = 3 * closure.index[body]
        jacobian[..., row, i], jacobian[..., row, i + 1] = sign * c, sign * s
        jacobian[..., row, i + 2] = sign * (c * end.lever_x + s * end.lever_y)
        if sign < 0.0:
            jacobian[..., row, i + 2] += c * y - s * x
    values[..., row] = c * x + s * y
    bend = c * (far.ddx - near.ddx) + s * (far.ddy - near.ddy)
    lacking[..., row] = bend + 2.0 * rate * (c * dy - s * dx) - rate**2 * values[..., row]
