"""The constraints of planar joints in absolute coordinates, with their derivatives, at one position or at N.

A position is a list of the coordinates x, y, angle of every moving body: floats, or arrays (N,).  The formulas are the
same for both; floats are five times as fast as arrays of one number.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ....contracts.machine import BodyPoint, Guide, Slot, Stretch
from ...trace import portable


class Arm(NamedTuple):
    """A point of a body."""

    column: int  # of the body's first coordinate; -1: the ground
    x: float  # m, in the body's frame, from its centre of mass
    y: float


class PointMotion(NamedTuple):
    """A point of a body, each field a number or (N,)."""

    x: Any  # m
    y: Any
    lever_x: Any  # derivative by the body's angle
    lever_y: Any
    dx: Any = 0.0  # derivative by the crank's angle
    dy: Any = 0.0
    ddx: Any = 0.0  # its second derivative without those of the coordinates
    ddy: Any = 0.0


class Position:
    """A position of all bodies, and optionally the derivatives of their coordinates by the crank's angle."""

    def __init__(self, q: np.ndarray, q_rates: np.ndarray | None = None):
        """Separate the coordinates `q` and their derivatives, each (3 bodies,) or (N, 3 bodies)."""
        self.q, self.rates = _columns(q), None if q_rates is None else _columns(q_rates)
        self._directions: dict[int, tuple[Any, Any]] = {}  # column of a body -> cosine and sine of its angle

    def direction(self, column: int) -> tuple[Any, Any]:
        """Return cosine and sine of the angle of the body with this first column."""
        if column not in self._directions:
            self._directions[column] = cosine_and_sine(self.q[column + 2])
        return self._directions[column]

    def angle(self, arm: Arm) -> Any:
        """Return the angle (rad) of the body of a point."""
        return self.q[arm.column + 2] if arm.column >= 0 else 0.0

    def rate(self, arm: Arm) -> Any:
        """Return the derivative of this angle."""
        return self.rates[arm.column + 2] if self.rates and arm.column >= 0 else 0.0

    def point(self, arm: Arm) -> PointMotion:
        """Return a point of a body; its derivatives are 0 without those of the coordinates."""
        i, x, y = arm
        if i < 0:
            return PointMotion(x, y, 0.0, 0.0)
        q, rates, (c, s) = self.q, self.rates, self.direction(i)
        arm_x, arm_y = c * x - s * y, s * x + c * y
        if rates is None:
            return PointMotion(q[i] + arm_x, q[i + 1] + arm_y, -arm_y, arm_x)
        rate = rates[i + 2]
        return PointMotion(
            q[i] + arm_x,
            q[i + 1] + arm_y,
            -arm_y,
            arm_x,
            rates[i] - rate * arm_y,
            rates[i + 1] + rate * arm_x,
            -rate * rate * arm_x,
            -rate * rate * arm_y,
        )


class Rows(NamedTuple):
    """Constraints of a joint, from row `row` on."""

    row: int
    name: str  # of the joint
    proximal: Arm
    distal: Arm
    axis: float = 0.0  # rad, of a line in the frame of the proximal body

    def put(self, position: Position, offsets: Mapping, values: list, jacobian: list) -> None:
        """Write the constraints and their derivatives by the coordinates; offsets : see `Closure`."""
        raise NotImplementedError

    def put_curvature(self, position: Position, curvature: list) -> None:
        """Write the terms without accelerations of the constraints' second derivatives, unless they are 0."""

    def ends(self, position: Position) -> tuple[PointMotion, PointMotion]:
        """Return the points that the joint connects."""
        return position.point(self.proximal), position.point(self.distal)

    def moving_ends(self, proximal: PointMotion, distal: PointMotion) -> list[tuple[int, float, PointMotion]]:
        """Return column, sign and point of the ends on moving bodies."""
        signed_ends = ((self.proximal.column, -1.0, proximal), (self.distal.column, 1.0, distal))
        return [end for end in signed_ends if end[0] >= 0]


class Coincident(Rows):
    """Two rows of a pin: the points coincide, except for an offset."""

    def put(self, position: Position, offsets: Mapping, values: list, jacobian: list) -> None:
        """See `Rows`."""
        row, (proximal, distal), (x, y) = self.row, self.ends(position), offsets.get(self.name, (0.0, 0.0))
        values[row], values[row + 1] = distal.x - proximal.x - x, distal.y - proximal.y - y
        for i, sign, point in self.moving_ends(proximal, distal):
            jacobian[row][i] = jacobian[row + 1][i + 1] = sign
            jacobian[row][i + 2], jacobian[row + 1][i + 2] = sign * point.lever_x, sign * point.lever_y

    def put_curvature(self, position: Position, curvature: list) -> None:
        """See `Rows`."""
        proximal, distal = self.ends(position)
        curvature[self.row], curvature[self.row + 1] = distal.ddx - proximal.ddx, distal.ddy - proximal.ddy


class Parallel(Rows):
    """A row of a guide: the frames of both bodies stay parallel."""

    def put(self, position: Position, offsets: Mapping, values: list, jacobian: list) -> None:
        """See `Rows`."""
        values[self.row] = position.angle(self.distal) - position.angle(self.proximal)
        for arm, sign in ((self.proximal, -1.0), (self.distal, 1.0)):
            if arm.column >= 0:
                jacobian[self.row][arm.column + 2] = sign


class AlongLine(Rows):
    """A row of a slot: the points have no distance along the direction `axis`."""

    def direction(self, position: Position) -> tuple[Any, Any]:
        """Return cosine and sine of the direction."""
        return cosine_and_sine(position.angle(self.proximal) + self.axis)

    def put(self, position: Position, offsets: Mapping, values: list, jacobian: list) -> None:
        """See `Rows`."""
        row, (proximal, distal), (c, s) = self.row, self.ends(position), self.direction(position)
        x, y = distal.x - proximal.x, distal.y - proximal.y
        values[row] = c * x + s * y
        for i, sign, point in self.moving_ends(proximal, distal):
            jacobian[row][i], jacobian[row][i + 1] = sign * c, sign * s
            jacobian[row][i + 2] = sign * (c * point.lever_x + s * point.lever_y)
            if sign < 0.0:
                jacobian[row][i + 2] = jacobian[row][i + 2] + (c * y - s * x)

    def put_curvature(self, position: Position, curvature: list) -> None:
        """See `Rows`."""
        (proximal, distal), (c, s), rate = self.ends(position), self.direction(position), position.rate(self.proximal)
        x, y, dx, dy = distal.x - proximal.x, distal.y - proximal.y, distal.dx - proximal.dx, distal.dy - proximal.dy
        axial_curvature = c * (distal.ddx - proximal.ddx) + s * (distal.ddy - proximal.ddy)
        curvature[self.row] = axial_curvature + 2.0 * rate * (c * dy - s * dx) - rate * rate * (c * x + s * y)


class AcrossLine(AlongLine):
    """A row of a guide: the points have no distance across its line."""

    def direction(self, position: Position) -> tuple[Any, Any]:
        """Return cosine and sine of the direction across the line."""
        c, s = super().direction(position)
        return -s, c


class Extended(AlongLine):
    """The row of a spring at rest: the distance of the points along its line is its extension."""

    def put(self, position: Position, offsets: Mapping, values: list, jacobian: list) -> None:
        """See `Rows`."""
        super().put(position, offsets, values, jacobian)
        values[self.row] = values[self.row] - offsets.get(self.name, 0.0)


def rows_of(joint: Any, row: int, arm_of: Callable[[BodyPoint], Arm]) -> list[Rows]:
    """Return the constraints of a joint, from row `row` on; arm_of : point of a body -> its Arm."""
    ends = arm_of(joint.proximal), arm_of(joint.distal)
    if isinstance(joint, Slot):
        return [AlongLine(row, joint.name, *ends, joint.axis + 0.5 * math.pi)]
    if isinstance(joint, Guide | Stretch):
        return [Parallel(row, joint.name, *ends), AcrossLine(row + 1, joint.name, *ends, joint.axis)]
    return [Coincident(row, joint.name, *ends)]


def assembled(items: list, q: np.ndarray) -> np.ndarray:
    """Return numbers, or numbers and arrays (N,), as one array (items,) or (N, items); q : the coordinates."""
    if q.ndim == 1:
        return np.array(items)
    columns = np.empty((len(items), len(q)))
    for column, item in zip(columns, items, strict=True):
        column[:] = item
    return columns.T


def cosine_and_sine(angle: Any) -> tuple[Any, Any]:
    """Return cosine and sine of an angle (rad), a number or (N,)."""
    return portable.cos(angle), portable.sin(angle)


def _columns(q: np.ndarray) -> list:
    """Return the coordinates (3 bodies,) as floats, or (N, 3 bodies) as arrays (N,)."""
    return q.tolist() if q.ndim == 1 else list(q.T)
