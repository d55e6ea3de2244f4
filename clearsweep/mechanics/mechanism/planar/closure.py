"""A planar machine without clearance in absolute coordinates, over a turn of its crank.

The coordinates are x, y of the centre of mass and the angle of every body; the constraints those of all joints and the
angle of the crank, so that positions follow from Newton's method, velocities and accelerations from linear equations,
and the forces in the joints are the multipliers of the constraints (Haug 1989, "Computer Aided Kinematics and
Dynamics", chapters 3 and 6).  Derivatives are by the crank's angle: speeds come in afterwards.
"""

import functools
import math
import pickle
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ....contracts.machine import GROUND, Guide, Machine, Slot, Stretch
from .component import component, dot, left

STATIONS = 720  # of a turn, at which the machine is closed
COARSE = 24  # of them, found one after the other; the others begin between these
FINEST = 4**6  # parts into which the way from one to the next is divided
FAR = 0.1  # rad, by which an angle may differ from the parabola through the last station
NEAR_SINGULAR = 1e-7  # least singular value of the constraints over the largest, lengths measured by the machine's size
CLOSED = 1e-13  # of the machine's size
ATTEMPTS = 40
_SINGULAR = "it is in a singular position, in which it can move in more ways than one"


class ClosureError(ValueError):
    """The machine without clearance cannot be closed, or is singular, at an angle of its crank."""

    def __init__(self, text: str, body: str, angle: float):
        super().__init__(text)
        self.body, self.angle = body, angle  # the angle in rad


class MobilityError(ValueError):
    """The machine is not one that its drive moves in one way."""


class Turn(NamedTuple):
    """The machine without clearance at N angles of its crank; q : x, y (m) and angle (rad) of each body that moves."""

    angles: np.ndarray  # (N,) rad
    q: np.ndarray  # (N, 3 bodies)
    first: np.ndarray  # derivative by the crank's angle
    second: np.ndarray


class Closure:
    """The constraints of a machine; `offsets` : (2,) m, by which the distal points of some joints are apart."""

    def __init__(self, machine: Machine, offsets: Mapping | None = None):
        self.machine, self.offsets = machine, offsets or {}
        self.names = [name for name in machine.bodies if name != GROUND]
        self.index = {name: i for i, name in enumerate(self.names)}
        self.size = sum(extent(body) for body in machine.bodies.values()) or 1.0  # m
        self.crank = self.index[_driven(machine).distal.body]
        self.held = [
            joint for joint in machine.joints if isinstance(joint, Stretch)
        ]  # not stretched: without clearance
        sizes = [1 if isinstance(joint, Slot) else 2 for joint in machine.joints]
        self.first = np.concatenate([[0], np.cumsum(sizes)])  # row of each joint, and of what comes behind them
        self.rows = int(self.first[-1]) + 1 + len(self.held)
        if self.rows != 3 * len(self.names):
            free = 3 * len(self.names) - self.rows + 1
            raise MobilityError(
                f"without clearance it can move in {free} ways (3 for each body that moves, less 2 for each joint); "
                "the drive needs exactly 1"
            )

    def end(self, at, q, first):
        """Return place, its derivative and what its second derivative has without those of q, and its lever (N, 2)."""
        body = self.machine.bodies[at.body]
        local = np.subtract(body.points[at.point], body.center if at.body != GROUND else (0.0, 0.0))
        if at.body == GROUND:
            zero = np.zeros((len(q), 2))
            return zero + local, zero, zero, zero
        i = 3 * self.index[at.body]
        c, s = np.cos(q[:, i + 2]), np.sin(q[:, i + 2])
        arm = np.stack([c * local[0] - s * local[1], s * local[0] + c * local[1]], -1)
        rate = first[:, i + 2, None]
        return q[:, i : i + 2] + arm, first[:, i : i + 2] + rate * left(arm), -(rate**2) * arm, left(arm)

    def evaluate(self, q, angles, first=None):
        """Return constraints (N, rows), their derivatives (N, rows, 3 bodies), and what the second derivative lacks."""
        first = np.zeros_like(q) if first is None else first
        count, row = len(q), 0
        values, lacking = np.zeros((count, self.rows)), np.zeros((count, self.rows))
        jacobian = np.zeros((count, self.rows, q.shape[1]))
        for joint in self.machine.joints:
            if isinstance(joint, Slot):
                across = component(self, joint, joint.axis + 0.5 * math.pi, q, first)
                values[:, row], jacobian[:, row], lacking[:, row] = across
                row += 1
                continue
            (p, dp, ddp, lever_p), (d, dd, ddd, lever_d) = (
                self.end(at, q, first) for at in (joint.proximal, joint.distal)
            )
            ends = ((joint.proximal.body, -1.0, lever_p), (joint.distal.body, 1.0, lever_d))
            if isinstance(joint, (Guide, Stretch)):
                angle_p, rate = self.angle(joint.proximal.body, q), self.angle(joint.proximal.body, first)
                along = np.stack([np.cos(angle_p + joint.axis), np.sin(angle_p + joint.axis)], -1)
                normal, gap = left(along), d - p
                values[:, row] = self.angle(joint.distal.body, q) - angle_p
                values[:, row + 1] = dot(normal, gap)
                lacking[:, row + 1] = (
                    dot(normal, ddd - ddp) - 2.0 * rate * dot(along, dd - dp) - rate**2 * dot(normal, gap)
                )
                for body, sign, lever in ends:
                    if body == GROUND:
                        continue
                    i = 3 * self.index[body]
                    jacobian[:, row, i + 2] = sign
                    jacobian[:, row + 1, i : i + 2] = sign * normal
                    jacobian[:, row + 1, i + 2] = sign * dot(normal, lever)
                    if body == joint.proximal.body:
                        jacobian[:, row + 1, i + 2] -= dot(along, gap)
            else:
                values[:, row : row + 2] = d - p - np.asarray(self.offsets.get(joint.name, (0.0, 0.0)))
                lacking[:, row : row + 2] = ddd - ddp
                for body, sign, lever in ends:
                    if body == GROUND:
                        continue
                    i = 3 * self.index[body]
                    jacobian[:, row, i] = jacobian[:, row + 1, i + 1] = sign
                    jacobian[:, row : row + 2, i + 2] = sign * lever
            row += 2
        for joint in self.held:
            values[:, row], jacobian[:, row], lacking[:, row] = component(self, joint, joint.axis, q, first)
            row += 1
        values[:, row] = q[:, 3 * self.crank + 2] - angles
        jacobian[:, row, 3 * self.crank + 2] = 1.0
        return values, jacobian, lacking

    def angle(self, body, q):
        """Return the angle of a body (N,) rad, or its derivative."""
        return np.zeros(len(q)) if body == GROUND else q[:, 3 * self.index[body] + 2]

    # ------------------------------------------------------------------------------------------ positions

    def _scaled(self, jacobian):
        """Return the derivatives with lengths measured by the machine's size."""
        scale = np.tile([self.size, self.size, 1.0], len(self.names))
        unit = np.ones(self.rows)
        row = 0
        for joint in self.machine.joints:
            unit[row] = 1.0 if isinstance(joint, (Guide, Stretch)) else self.size
            unit[row + 1] = self.size  # of a slot, the next row's, which is set then
            row += 1 if isinstance(joint, Slot) else 2
        unit[row:-1] = self.size
        return jacobian * scale / unit[:, None]

    def _weakest(self, q, angle) -> tuple[float, str]:
        """Return how far a machine is from being singular, and the body that moves most in the weakest way."""
        _, jacobian, _ = self.evaluate(q[None], np.array([angle]))
        _, values, ways = np.linalg.svd(self._scaled(jacobian[0]))
        share = np.abs(ways[-1]).reshape(-1, 3).max(axis=1)
        return values[-1] / values[0], self.names[int(np.argmax(share))]

    def closed(self, q, angles) -> np.ndarray:
        """Return where the constraints hold, from `q` (N, 3 bodies) near it; nan where that fails."""
        q = q.copy()
        for _ in range(30):
            values, jacobian, _ = self.evaluate(q, angles)
            try:
                step = np.linalg.solve(jacobian, values[..., None])[..., 0]
            except np.linalg.LinAlgError:
                step = np.stack([np.linalg.lstsq(j, v, rcond=None)[0] for j, v in zip(jacobian, values, strict=True)])
            q -= step
            if np.max(np.abs(values)) <= 1e-15 * self.size or not np.all(np.isfinite(q)):
                break
            if np.max(np.abs(step)) < 1e-14 * min(self.size, 1.0):
                break
        values, _, _ = self.evaluate(q, angles)
        return np.where(np.max(np.abs(values), axis=-1, keepdims=True) < 1e-11 * max(self.size, 1.0), q, math.nan)

    def derivatives(self, q, angles) -> tuple[np.ndarray, np.ndarray]:
        """Return first and second derivatives of `q` by the crank's angle."""
        _, jacobian, _ = self.evaluate(q, angles)
        right = np.zeros((len(q), self.rows, 1))
        right[:, -1] = 1.0
        first = np.linalg.solve(jacobian, right)[..., 0]
        _, _, lacking = self.evaluate(q, angles, first)
        return first, np.linalg.solve(jacobian, -lacking[..., None])[..., 0]

    def start(self, angle: float) -> np.ndarray:
        """Return the machine closed at an angle of its crank, near the angles given for that.  Raises ClosureError."""
        rng = np.random.default_rng(0)
        found: list[tuple[float, np.ndarray]] = []
        given = np.array([self.machine.start.get(name, 0.0) for name in self.names])
        told = np.array([name in self.machine.start for name in self.names])
        for attempt in range(ATTEMPTS):
            spread = 0.0 if attempt == 0 else 0.1 + 3.0 * attempt / ATTEMPTS
            angles = given + np.where(told, 0.2 * spread, spread) * rng.uniform(-1.0, 1.0, given.size)
            angles[self.crank] = angle
            q = self._relaxed(self._hung(angles), angle)
            if np.all(np.isfinite(q)):
                turned = np.remainder(q[2::3] - given + math.pi, 2.0 * math.pi) - math.pi
                turned[self.crank] = 0.0
                if attempt == 0 and np.max(np.abs(turned)) < 0.5 * math.pi:
                    return self._near(q, given)
                found.append((float(np.sum(turned**2 * np.where(told, 100.0, 1.0))), q))
        if not found:
            raise ClosureError(
                "its lengths do not let it close where the crank begins", self._farthest(given, angle), angle
            )
        return self._near(min(found, key=lambda item: item[0])[1], given)

    def _near(self, q, given):
        """Return `q` with its angles, but the crank's, within half a turn of those given."""
        q = q.copy()
        for i in range(len(self.names)):
            if i != self.crank:
                q[3 * i + 2] -= 2.0 * math.pi * np.round((q[3 * i + 2] - given[i]) / (2.0 * math.pi))
        return q

    def _hung(self, angles) -> np.ndarray:
        """Return bodies at given angles, each hung on one that is hung before: by a pin if there is one."""
        q = np.zeros(3 * len(self.names))
        q[2::3] = angles
        placed = {GROUND}
        while len(placed) <= len(self.names):
            for guides in (False, True):
                joint = next(
                    (
                        joint
                        for joint in self.machine.joints
                        if isinstance(joint, (Guide, Stretch, Slot)) == guides
                        and (joint.proximal.body in placed) != (joint.distal.body in placed)
                    ),
                    None,
                )
                if joint is not None:
                    break
            if joint is None:
                hanging = next(name for name in self.names if name not in placed)
                raise MobilityError(f"body {hanging!r} hangs nowhere: no joints lead from it to the ground")
            ends = (joint.proximal, joint.distal)
            held, free = ends if joint.proximal.body in placed else ends[::-1]
            rows, zero = q[None], np.zeros((1, q.size))
            i = 3 * self.index[free.body]
            q[i : i + 2] += (self.end(held, rows, zero)[0] - self.end(free, rows, zero)[0])[0]
            placed.add(free.body)
        return q

    def _relaxed(self, q, angle) -> np.ndarray:
        """Return the machine closed from a rough guess: Levenberg's and Marquardt's method; nan where it fails."""
        angles, damping = np.array([angle]), 1e-3
        values, jacobian, _ = self.evaluate(q[None], angles)
        cost = float(np.sum(values**2))
        for _ in range(200):
            gradient = jacobian[0].T @ values[0]
            square = jacobian[0].T @ jacobian[0]
            scale = np.tile([1.0, 1.0, self.size**2], len(self.names))
            step = np.linalg.solve(square + damping * np.diag(scale), -gradient)
            trial, derived, _ = self.evaluate((q + step)[None], angles)
            if np.sum(trial**2) < cost:
                q, values, jacobian, cost = q + step, trial, derived, float(np.sum(trial**2))
                damping = max(0.2 * damping, 1e-15)
            else:
                damping *= 5.0
            if cost < 1e-12 * self.size**2 or damping > 1e10:
                break
        if cost > 1e-8 * self.size**2:
            return np.full_like(q, math.nan)
        return self.closed(q[None], angles)[0]

    def _farthest(self, given, angle) -> str:
        """Return the body whose joint stays open where a machine does not close."""
        angles = given.copy()
        angles[self.crank] = angle
        values, _, _ = self.evaluate(self._hung(angles)[None], np.array([angle]))
        worst = int(np.argmax(np.abs(values[0, : self.first[-1]])))
        joint = self.machine.joints[int(np.searchsorted(self.first, worst, side="right")) - 1]
        return joint.distal.body if joint.distal.body != GROUND else joint.proximal.body

    # ------------------------------------------------------------------------------------------ a turn

    def turn(self, start: float) -> Turn:
        """Return a turn of the crank from the angle `start` on, its end included.  Raises ClosureError."""
        angles = start + 2.0 * math.pi * np.arange(STATIONS + 1) / STATIONS
        every = STATIONS // COARSE
        coarse = np.empty((COARSE + 1, 3 * len(self.names)))
        coarse[0] = self.start(start)
        self._check(coarse[0], start)
        for k in range(COARSE):
            coarse[k + 1] = self._continued(coarse[k], angles[every * k], angles[every * (k + 1)])
        rough = Turn(angles[::every], coarse, *self.derivatives(coarse, angles[::every]))
        q = self.closed(between(rough, angles).q, angles)
        first, second = self.derivatives(q, angles)
        found = Turn(angles, q, first, second)
        self._check_all(found)
        return found

    def _continued(self, q, before: float, after: float) -> np.ndarray:
        """Return the machine at another angle of its crank, by as many steps as that takes."""
        parts = 1
        while parts <= FINEST:
            here, angle, far = q, before, False
            for part in range(parts):
                following = before + (after - before) * (part + 1) / parts
                first, second = self.derivatives(here[None], np.array([angle]))
                step = following - angle
                guess = here + first[0] * step + 0.5 * second[0] * step**2
                there = self.closed(guess[None], np.array([following]))[0]
                far = not np.all(np.isfinite(there)) or np.max(np.abs((there - guess)[2::3])) > FAR
                if far:
                    break
                here, angle = there, following
            if not far:
                self._check(here, after)
                return here
            parts *= 4
            q, before = here, angle
        raise ClosureError("its lengths do not let the crank turn on", self._weakest(here, angle)[1], angle)

    def _check_all(self, found: Turn) -> None:
        """Raise ClosureError where a turn passes a singular position between the stations that were looked at."""
        _, jacobian, _ = self.evaluate(found.q, found.angles)
        signs = np.sign(np.linalg.det(self._scaled(jacobian)))
        steep = np.max(np.abs(found.first[:, 2::3]), axis=1) > 1.0 / NEAR_SINGULAR
        crossed = np.flatnonzero((signs != signs[0]) | steep | ~np.all(np.isfinite(found.q), axis=1))
        if crossed.size:
            angle = float(found.angles[crossed[0]])
            raise ClosureError(_SINGULAR, self._weakest(found.q[crossed[0] - 1], angle)[1], angle)

    def _check(self, q, angle: float) -> None:
        weak, body = self._weakest(q, angle)
        if weak < NEAR_SINGULAR:
            raise ClosureError(_SINGULAR, body, angle)


def turn_of(machine: Machine) -> Turn:
    """Return the turn of a machine from the start of its crank; cases that differ in masses and loads share it."""
    bodies = {name: (tuple(body.center), dict(body.points)) for name, body in machine.bodies.items()}
    joints = [
        each._replace(stiffness=0.0, damping=0.0) if isinstance(each, Stretch) else each for each in machine.joints
    ]
    key = (bodies, joints, machine.driven, dict(machine.start), machine.drive.start_angle)
    return _kept_turn(pickle.dumps(key), Alike(machine))


@functools.lru_cache(maxsize=64)
def _kept_turn(key: bytes, machine: "Alike") -> Turn:
    return Closure(machine.value).turn(machine.value.drive.start_angle)


class Alike:
    """A value that is like any other, so that what is kept of it is found by the key beside it alone."""

    def __init__(self, value: Any):
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Alike)

    def __hash__(self) -> int:
        return 0


def between(turn: Turn, angles: np.ndarray) -> Turn:
    """Return a machine at angles (N,) of its crank as its Turn has it, by quintics between stations."""
    step = 2.0 * math.pi / (len(turn.angles) - 1)
    whole = np.floor((angles - turn.angles[0]) / (2.0 * math.pi))
    along = (angles - turn.angles[0] - 2.0 * math.pi * whole) / step
    k = np.minimum(along.astype(int), len(turn.angles) - 2)
    t = (along - k)[:, None]
    f0, d0, s0, f1, d1, s1 = (part[k + i] for i in (0, 1) for part in (turn.q, turn.first, turn.second))
    d0, d1, s0, s1 = step * d0, step * d1, step * step * s0, step * step * s1
    rise, tilt, bend = f1 - f0 - d0 - 0.5 * s0, d1 - d0 - s0, s1 - s0
    a, b, c = 10 * rise - 4 * tilt + 0.5 * bend, -15 * rise + 7 * tilt - bend, 6 * rise - 3 * tilt + 0.5 * bend
    winding = turn.q[-1] - turn.q[0]
    winding[0::3] = winding[1::3] = 0.0
    q = f0 + t * (d0 + t * (0.5 * s0 + t * (a + t * (b + t * c)))) + whole[:, None] * winding
    first = (d0 + t * (s0 + t * (3 * a + t * (4 * b + t * 5 * c)))) / step
    return Turn(angles, q, first, (s0 + t * (6 * a + t * (12 * b + t * 20 * c))) / step**2)


def _driven(machine: Machine):
    return next(joint for joint in machine.joints if joint.name == machine.driven)


def extent(body) -> float:
    """Return the largest distance (m) between two points of a body, its centre of mass among them."""
    points = np.array([body.center, *body.points.values()])
    return float(np.max(np.hypot(*(points[:, None] - points[None]).T)))
