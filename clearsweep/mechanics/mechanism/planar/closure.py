"""A planar machine without clearance in absolute coordinates, over a revolution of its crank.

The coordinates are x, y of the centre of mass and the angle of every body; the constraints those of all joints and the
angle of the crank, so that positions follow from Newton's method, velocities and accelerations from linear equations,
and the forces in the joints are the multipliers of the constraints (Haug 1989, "Computer Aided Kinematics and
Dynamics", chapters 3 and 6).  Derivatives are with respect to the crank's angle; speeds are applied afterwards.
"""

import copy
import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from ....contracts.machine import GROUND, BodyPoint, Guide, Machine, Slot, Stretch
from .constraints import Arm, Extended, PointMotion, Position, assembled, rows_of
from .machine_states import MachineStates, interpolate

STATIONS = 720  # of a revolution, at which the machine is closed
FIRST_STATIONS = 24  # of them, closed in sequence; interpolation between these gives guesses for the others
FINEST_STEP = 4**6  # most parts into which an interval between stations is divided
LARGEST_JUMP = 0.1  # rad, by which an angle may differ from the parabola through the last station
NEAR_SINGULAR = 1e-7  # least singular value of the constraints over the largest, lengths measured by the machine's size
QUADRATIC_STEP = 1e-9  # of the machine's size, by which the last step of Newton's method moves
ATTEMPTS = 40
_SINGULAR = "it is in a singular position, in which it has more than one degree of freedom"


class ClosureError(ValueError):
    """The machine without clearance cannot be closed, or is singular, at an angle of its crank."""

    def __init__(self, text: str, body: str, angle: float):
        super().__init__(text)
        self.body, self.angle = body, angle  # the angle in rad


class MobilityError(ValueError):
    """The machine does not have exactly one degree of freedom, that of its drive."""


class Closure:
    """The constraints of a machine, without clearance and with springs at rest except for `offsets`.

    offsets : m, of the distal point of some joints: (2,) in the fixed frame for a pin, the extension for a spring
    """

    def __init__(self, machine: Machine, offsets: Mapping | None = None):
        self.machine, self.offsets = machine, offsets or {}
        self.names = [name for name in machine.bodies if name != GROUND]
        self.index = {name: i for i, name in enumerate(self.names)}
        self.size = math.fsum(extent(body) for body in machine.bodies.values()) or 1.0  # m
        self.crank = self.index[_driven_joint(machine).distal.body]
        row_ends = np.cumsum([1 if isinstance(joint, Slot) else 2 for joint in machine.joints])
        self.first_rows = np.concatenate([[0], row_ends])  # row of each joint, and of what comes behind them
        self.springs = [joint for joint in machine.joints if isinstance(joint, Stretch)]  # springs at rest
        self.rows = int(self.first_rows[-1]) + 1 + len(self.springs)
        self.constraints = [
            constraint
            for row, joint in zip(self.first_rows.tolist(), machine.joints, strict=False)
            for constraint in rows_of(joint, row, self._arm)
        ]
        self.constraints += [
            Extended(row, spring.name, self._arm(spring.proximal), self._arm(spring.distal), spring.axis)
            for row, spring in enumerate(self.springs, int(self.first_rows[-1]))
        ]
        if self.rows != 3 * len(self.names):
            freedoms = 3 * len(self.names) - self.rows + 1
            raise MobilityError(
                f"without clearance it has {freedoms} degrees of freedom (3 per moving body, minus 2 per joint); "
                "the drive needs exactly 1"
            )

    def displaced(self, offsets: Mapping) -> "Closure":
        """Return the constraints with other `offsets`."""
        closure = copy.copy(self)
        closure.offsets = offsets
        return closure

    def _arm(self, endpoint: BodyPoint) -> Arm:
        x, y = self.machine.bodies[endpoint.body].points[endpoint.point]
        if endpoint.body == GROUND:
            return Arm(-1, x, y)
        center = self.machine.bodies[endpoint.body].center
        return Arm(3 * self.index[endpoint.body], x - center[0], y - center[1])

    def point_motion(self, endpoint: BodyPoint, q: np.ndarray, q_rates: np.ndarray) -> PointMotion:
        """Return a point of a body; q, q_rates : (3 bodies,) or (N, 3 bodies)."""
        return Position(q, q_rates).point(self._arm(endpoint))

    def evaluate(self, q, angles):
        """Return constraints (..., rows) and their derivatives (..., rows, 3 bodies).

        q : (3 bodies,) or (N, 3 bodies); angles : of the crank, rad, a number or (N,)
        """
        position, values, jacobian = Position(q), [0.0] * self.rows, [[0.0] * q.shape[-1] for _ in range(self.rows)]
        for constraint in self.constraints:
            constraint.put(position, self.offsets, values, jacobian)
        values[-1], jacobian[-1][3 * self.crank + 2] = position.q[3 * self.crank + 2] - angles, 1.0
        derivatives = assembled([item for row in jacobian for item in row], q)
        return assembled(values, q), derivatives.reshape(*q.shape[:-1], self.rows, q.shape[-1])

    def curvature(self, q, q_rates):
        """Return the terms (..., rows) without accelerations of the constraints' second derivatives."""
        position, curvature = Position(q, q_rates), [0.0] * self.rows
        for constraint in self.constraints:
            constraint.put_curvature(position, curvature)
        return assembled(curvature, q)

    def angle(self, body: str, q: np.ndarray) -> Any:
        """Return the angle (rad) of a body, or its rate, (...)."""
        return 0.0 if body == GROUND else q[..., 3 * self.index[body] + 2]

    # ------------------------------------------------------------------------------------------ positions

    def _scaled(self, jacobian):
        """Return the derivatives with lengths measured by the machine's size."""
        scale, unit = self._units
        return jacobian * scale / unit

    @functools.cached_property
    def _units(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the unit of each coordinate (3 bodies,) and of each row (rows, 1)."""
        scale, unit, row = np.tile([self.size, self.size, 1.0], len(self.names)), np.ones(self.rows), 0
        for joint in self.machine.joints:
            unit[row] = 1.0 if isinstance(joint, (Guide, Stretch)) else self.size
            unit[row + 1] = self.size  # of a slot, the next row's, which is set then
            row += 1 if isinstance(joint, Slot) else 2
        unit[row:-1] = self.size
        return scale, unit[:, None]

    def _singularity(self, jacobian) -> tuple[float, str]:
        """Return the least singular value over the largest, and the body that moves most in its direction."""
        _, values, right_vectors = np.linalg.svd(self._scaled(jacobian))
        body_motion = np.abs(right_vectors[-1]).reshape(-1, 3).max(axis=1)
        return values[-1] / values[0], self.names[int(np.argmax(body_motion))]

    def close(self, q, angles) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates (..., 3 bodies) near `q` that satisfy the constraints, and the derivatives of these.

        The coordinates are nan if there are none.
        """
        q = q.copy()
        for _ in range(30):
            values, jacobian = self.evaluate(q, angles)
            try:
                step = np.linalg.solve(jacobian, values[..., None])[..., 0]
            except np.linalg.LinAlgError:
                step = (np.linalg.pinv(jacobian) @ values[..., None])[..., 0]
            q -= step
            # the error after a step of Newton's method is of the order of its square
            if np.max(np.abs(step)) < QUADRATIC_STEP * min(self.size, 1.0) or not np.all(np.isfinite(q)):
                break
        values, jacobian = self.evaluate(q, angles)
        is_satisfied = np.max(np.abs(values), axis=-1, keepdims=True) < 1e-11 * max(self.size, 1.0)
        return np.where(is_satisfied, q, math.nan), jacobian

    def derivatives(self, q, jacobian) -> tuple[np.ndarray, np.ndarray]:
        """Return first and second derivatives of `q` by the crank's angle; jacobian : of the constraints."""
        right_side = np.zeros((*q.shape[:-1], self.rows, 1))
        right_side[..., -1, :] = 1.0
        q_rates = np.linalg.solve(jacobian, right_side)[..., 0]
        return q_rates, np.linalg.solve(jacobian, -self.curvature(q, q_rates)[..., None])[..., 0]

    def close_at_start(self, angle: float) -> np.ndarray:
        """Return the machine closed at an angle of its crank, near the angles given for that.  Raises ClosureError."""
        rng = np.random.default_rng(0)
        solutions: list[tuple[float, np.ndarray]] = []
        given_angles = np.array([self.machine.start.get(name, 0.0) for name in self.names])
        is_given = np.array([name in self.machine.start for name in self.names])
        for attempt in range(ATTEMPTS):
            spread = 0.0 if attempt == 0 else 0.1 + 3.0 * attempt / ATTEMPTS
            angles = given_angles + np.where(is_given, 0.2 * spread, spread) * rng.uniform(-1.0, 1.0, given_angles.size)
            angles[self.crank] = angle
            q = self._close_roughly(self._assemble(angles), angle)
            if np.all(np.isfinite(q)):
                deviations = np.remainder(q[2::3] - given_angles + math.pi, 2.0 * math.pi) - math.pi
                deviations[self.crank] = 0.0
                if attempt == 0 and np.max(np.abs(deviations)) < 0.5 * math.pi:
                    return self._wrap_angles(q, given_angles)
                solutions.append((float(np.sum(deviations**2 * np.where(is_given, 100.0, 1.0))), q))
        if not solutions:
            raise ClosureError(
                "its loops cannot be closed at the initial crank angle with these lengths",
                self._most_open_body(given_angles, angle),
                angle,
            )
        return self._wrap_angles(min(solutions, key=lambda item: item[0])[1], given_angles)

    def _wrap_angles(self, q, given_angles):
        """Return `q` with all angles, except the crank's, within half a revolution of the given ones."""
        q = q.copy()
        for i in range(len(self.names)):
            if i != self.crank:
                q[3 * i + 2] -= 2.0 * math.pi * np.round((q[3 * i + 2] - given_angles[i]) / (2.0 * math.pi))
        return q

    def _assemble(self, angles) -> np.ndarray:
        """Return the bodies at given angles, each attached to an already placed one, by a pin if there is one."""
        q = np.zeros(3 * len(self.names))
        q[2::3] = angles
        placed = {GROUND}
        while len(placed) <= len(self.names):
            for takes_guide in (False, True):
                joint = next(
                    (
                        joint
                        for joint in self.machine.joints
                        if isinstance(joint, (Guide, Stretch, Slot)) == takes_guide
                        and (joint.proximal.body in placed) != (joint.distal.body in placed)
                    ),
                    None,
                )
                if joint is not None:
                    break
            if joint is None:
                unplaced = next(name for name in self.names if name not in placed)
                raise MobilityError(f"body {unplaced!r} is not connected to the ground by joints")
            endpoints = (joint.proximal, joint.distal)
            placed_endpoint, free_endpoint = endpoints if joint.proximal.body in placed else endpoints[::-1]
            anchor, free_point = (
                self.point_motion(endpoint, q, np.zeros_like(q)) for endpoint in (placed_endpoint, free_endpoint)
            )
            i = 3 * self.index[free_endpoint.body]
            q[i : i + 2] += anchor.x - free_point.x, anchor.y - free_point.y
            placed.add(free_endpoint.body)
        return q

    def _close_roughly(self, q, angle) -> np.ndarray:
        """Return the machine closed from a rough guess by the Levenberg-Marquardt method; nan if it fails."""
        damping = 1e-3
        values, jacobian = self.evaluate(q, angle)
        cost = float(np.sum(values**2))
        for _ in range(200):
            gradient = jacobian.T @ values
            square = jacobian.T @ jacobian
            scale = np.tile([1.0, 1.0, self.size**2], len(self.names))
            step = np.linalg.solve(square + damping * np.diag(scale), -gradient)
            trial, trial_jacobian = self.evaluate(q + step, angle)
            if np.sum(trial**2) < cost:
                q, values, jacobian, cost = q + step, trial, trial_jacobian, float(np.sum(trial**2))
                damping = max(0.2 * damping, 1e-15)
            else:
                damping *= 5.0
            if cost < 1e-12 * self.size**2 or damping > 1e10:
                break
        if cost > 1e-8 * self.size**2:
            return np.full_like(q, math.nan)
        return self.close(q, angle)[0]

    def _most_open_body(self, given_angles, angle) -> str:
        """Return the body whose joint stays open if a machine does not close."""
        angles = given_angles.copy()
        angles[self.crank] = angle
        values, _ = self.evaluate(self._assemble(angles), angle)
        worst_row = int(np.argmax(np.abs(values[: self.first_rows[-1]])))
        joint = self.machine.joints[int(np.searchsorted(self.first_rows, worst_row, side="right")) - 1]
        return joint.distal.body if joint.distal.body != GROUND else joint.proximal.body

    # ------------------------------------------------------------------------------------------ one revolution

    def close_revolution(self, start: float) -> MachineStates:
        """Return a revolution of the crank from the angle `start` (rad), with both ends.  Raises ClosureError."""
        angles = start + 2.0 * math.pi * np.arange(STATIONS + 1) / STATIONS
        stride = STATIONS // FIRST_STATIONS
        coarse = np.empty((FIRST_STATIONS + 1, 3 * len(self.names)))
        coarse[0] = self.close_at_start(start)
        jacobians = [self.evaluate(coarse[0], start)[1]]
        self._check(jacobians[0], start)
        for k in range(FIRST_STATIONS):
            angle_interval = angles[stride * k], angles[stride * (k + 1)]
            coarse[k + 1], jacobian = self._continue_to(coarse[k], jacobians[k], *angle_interval)
            jacobians.append(jacobian)
        coarse_states = MachineStates(angles[::stride], coarse, *self.derivatives(coarse, np.stack(jacobians)))
        q, jacobian = self.close(interpolate(coarse_states, angles).q, angles)
        states = MachineStates(angles, q, *self.derivatives(q, jacobian))
        self._check_all(states, jacobian)
        return states

    def _continue_to(self, q, jacobian, start_angle: float, end_angle: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the machine at another angle of its crank, in as many steps as necessary, with its derivatives."""
        step_count = 1
        while step_count <= FINEST_STEP:
            position, position_jacobian, angle, has_failed = q, jacobian, start_angle, False
            for step_index in range(step_count):
                next_angle = start_angle + (end_angle - start_angle) * (step_index + 1) / step_count
                q_rates, second_derivative = self.derivatives(position, position_jacobian)
                step = next_angle - angle
                guess = position + q_rates * step + 0.5 * second_derivative * step**2
                next_position, next_jacobian = self.close(guess, next_angle)
                has_failed = (
                    not np.all(np.isfinite(next_position))
                    or np.max(np.abs((next_position - guess)[2::3])) > LARGEST_JUMP
                )
                if has_failed:
                    break
                position, position_jacobian, angle = next_position, next_jacobian, next_angle
            if not has_failed:
                self._check(position_jacobian, end_angle)
                return position, position_jacobian
            step_count *= 4
            q, jacobian, start_angle = position, position_jacobian, angle
        raise ClosureError("its lengths do not let the crank turn on", self._singularity(position_jacobian)[1], angle)

    def _check_all(self, states: MachineStates, jacobian) -> None:
        """Raise ClosureError if a revolution passes a singular position between its stations."""
        signs = np.sign(np.linalg.det(self._scaled(jacobian)))
        is_steep = np.max(np.abs(states.derivative[:, 2::3]), axis=1) > 1.0 / NEAR_SINGULAR
        singular_stations = np.flatnonzero((signs != signs[0]) | is_steep | ~np.all(np.isfinite(states.q), axis=1))
        if singular_stations.size:
            angle = float(states.angles[singular_stations[0]])
            raise ClosureError(
                _SINGULAR, self._singularity(self.evaluate(states.q[singular_stations[0] - 1], angle)[1])[1], angle
            )

    def _check(self, jacobian, angle: float) -> None:
        ratio, body = self._singularity(jacobian)
        if ratio < NEAR_SINGULAR:
            raise ClosureError(_SINGULAR, body, angle)


def _driven_joint(machine: Machine):
    return next(joint for joint in machine.joints if joint.name == machine.driven)


def extent(body) -> float:
    """Return the largest distance (m) between two points of a body, its centre of mass among them."""
    points = np.array([body.center, *body.points.values()])
    return float(np.max(np.hypot(*(points[:, None] - points[None]).T)))
