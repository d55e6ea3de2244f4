"""The component of the way from one point of a machine to another along a direction that turns with a body."""

import numpy as np

from ....contracts.machine import GROUND


def component(closure, joint, axis: float, q, first):
    """Return that of a joint's points along an axis (rad, in the frame of the proximal body): (N,) m.

    Behind it stand its derivatives by the coordinates, and what its second derivative lacks.  `closure` is the
    machine's, `first` the first derivative of `q`.
    """
    (p, dp, ddp, lever_p), (d, dd, ddd, lever_d) = (closure.end(at, q, first) for at in (joint.proximal, joint.distal))
    turned, rate = closure.angle(joint.proximal.body, q) + axis, closure.angle(joint.proximal.body, first)
    along = np.stack([np.cos(turned), np.sin(turned)], -1)
    normal, gap, row = left(along), d - p, np.zeros_like(q)
    for body, sign, lever in ((joint.proximal.body, -1.0, lever_p), (joint.distal.body, 1.0, lever_d)):
        if body == GROUND:
            continue
        i = 3 * closure.index[body]
        row[:, i : i + 2] = sign * along
        row[:, i + 2] = sign * dot(along, lever)
        if body == joint.proximal.body:
            row[:, i + 2] += dot(normal, gap)
    lacking = dot(along, ddd - ddp) + 2.0 * rate * dot(normal, dd - dp) - rate**2 * dot(along, gap)
    return dot(along, gap), row, lacking


def left(vector):
    """Return vectors (..., 2) turned by 90 degrees, counter-clockwise."""
    return np.stack([-vector[..., 1], vector[..., 0]], -1)


def dot(a, b):
    """Return the products of vectors (..., 2)."""
    return np.sum(a * b, -1)
