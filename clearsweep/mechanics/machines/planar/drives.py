"""Drives of a planar machine: motions that are given over time, and torques on a free crank."""

import functools
import itertools
import math
from typing import Any, NamedTuple, cast

import numpy as np

from ....contracts.catalogue import Law
from ....contracts.machine import Constant, Motor, Path, Schedule, Servo
from ....tracing.compiled.choosing import where
from ....tracing.compiled.family import family, inlined, kernel, known
from ....tracing.compiled.pinned import array_handle, cubic_at, cubic_rows
from ...laws.contract import Recipe, require
from ...laws.own import Own, maker
from ...laws.sampled import attempted

# ---------------------------------------------------------------------------------------------- given motions


class Tabled(NamedTuple):
    """A motion from a table, cubic between its rows; where they are speeds, the angle is quadratic."""

    table: float  # address of (rows, 5): s, rad, rad/s, rad/s^2, rad/s^3
    row_count: float


@family
def drive_motion(drive, time):
    """Return angle (rad), rate (rad/s) and angular acceleration (rad/s^2) of a driven crank at `time` (s)."""


drive_motion.member(Constant)(lambda drive, time: (drive.speed * time + drive.start_angle, drive.speed, 0.0))
drive_motion.member(Tabled)(lambda drive, time: cubic_at(drive.table, drive.row_count, time))


# ---------------------------------------------------------------------------------------------- torques


class Free(NamedTuple):
    """A torque that decreases linearly with speed; the crank's angle is a coordinate."""

    torque: float  # N m, at rest
    slope: float  # N m s, decrease of torque per rad/s


class FreeByTable(NamedTuple):
    """A torque over the speed from a table, monotone cubic between its rows and constant outside."""

    curve: tuple  # Tabled: the torque (N m) in place of the angle, over the rate (rad/s)


@family
def torque_at(drive, angle, rate, time, integral):
    """Return the torque (N m) on a free crank at `angle` (rad), `rate` (rad/s) and `time` (s).

    integral : N m, integral part of a Servo that has one
    """


torque_at.member(FreeByTable)(lambda drive, angle, rate, time, integral: drive_motion(drive.curve, rate)[0])


@known
def is_regulated(drive):
    """Return whether a drive is a Servo with an integral part, whose rate is that of a further coordinate."""
    return isinstance(drive, Servo) and type(drive.integral) is not tuple


@torque_at.member(Servo)
def _torque_at_servo(drive, angle, rate, time, integral):
    demand = _demand(drive, angle, rate, time)
    return _limited(drive.torque_limit, demand + integral if is_regulated(drive) else demand)


@inlined
def _demand(servo, angle, rate, time):
    aim, aim_rate, _ = drive_motion(servo.target, time)
    return servo.stiffness * (aim - angle) + servo.damping * (aim_rate - rate)


@inlined
def _limited(limit, torque):
    limited = where(torque > limit, limit + 0.0 * torque, torque)
    return where(limited < -limit, 0.0 * torque - limit, limited)


@kernel
def integral_rate(drive, angle, rate, time, integral):
    """Return the rate (N m/s) of the integral part of a Servo; at the limit it follows the torque."""
    demand = _demand(drive, angle, rate, time) + integral
    excess = _limited(drive.torque_limit, demand) - demand
    return drive.integral * (drive_motion(drive.target, time)[0] - angle) + excess / drive.tracking_time


class FreeByLaw(NamedTuple):
    """A torque by a law of one's own; the crank's angle is a coordinate."""

    law: tuple  # of `motor_torque`


@family
def motor_torque(law, rate, time):
    """Return the torque (N m) of a motor of one's own at `rate` (rad/s) and `time` (s)."""


torque_at.member(FreeByLaw)(lambda drive, angle, rate, time, integral: motor_torque(drive.law, rate, time))


require("motor", motor_torque)


@maker("motor")
def _motor_recipe(own: Own, description: Law) -> Recipe:
    evaluate, kind = own.evaluate, own.type_of("law", ("p",))
    motor_torque.member(kind)(lambda motor, rate, time: evaluate(motor.p, rate, time))

    def make(drive):
        return kind(own.parameters(drive.values))

    def check(drive):
        motor = make(drive)
        own.check_traced(motor.p, 10.0, 0.1)
        own.check_at(functools.partial(motor_torque, motor), speed=(-1e4, -10.0, 0.0, 10.0, 1e4), t=(0.0, 0.1, 10.0))
        return ()

    return Recipe(description, (kind,), make, check=check)


def no_load_speed(law: tuple) -> float:
    """Return the lowest speed (rad/s) of 1 to 1e5 at which a motor of one's own gives no torque at first, or inf."""
    speeds = [10.0 ** (0.02 * i) for i in range(251)]
    for low, high in itertools.pairwise(speeds):
        torques = [attempted(functools.partial(motor_torque, law, speed, 0.0), math.nan) for speed in (low, high)]
        if torques[0] > 0.0 >= torques[1]:
            return high
    return math.inf


torque_at.member(Free)(lambda drive, angle, rate, time, integral: drive.torque - drive.slope * rate)


FREE = Free, FreeByLaw, FreeByTable, Servo  # drives whose crank is free


# ---------------------------------------------------------------------------------------------- drives of a machine


def compile_drive(drive: Constant | Schedule | Path | Motor) -> tuple:
    """Return the compiled form of a drive."""
    if isinstance(drive, Constant):
        return drive
    if isinstance(drive, (Schedule, Path)):
        table = motion_table(drive)
        return Tabled(array_handle(table), float(len(table)))
    if drive.law is not None:
        return FreeByLaw(drive.law)
    if drive.servo is not None:
        servo: Any = drive.servo._replace(target=cast(Any, compile_drive(drive.servo.target)))
        return servo if servo.integral is not None else servo._replace(integral=(), tracking_time=())
    if drive.curve is not None:
        table = torque_table(*drive.curve)
        return FreeByTable(Tabled(array_handle(table), float(len(table))))
    return Free(
        drive.stall_torque, 0.0 if math.isinf(drive.no_load_speed) else drive.stall_torque / drive.no_load_speed
    )


def motion_table(drive: Schedule | Path) -> np.ndarray:
    """Return the table of a given motion, as in Tabled."""
    return schedule_table(drive) if isinstance(drive, Schedule) else _spline_table(drive)


def schedule_table(drive: Schedule) -> np.ndarray:
    """Return a speed table as in Tabled, the accelerations after each row.

    The speed is constant before the first row and after the last; the angle is `start_angle` at time 0.
    """
    times, speeds = np.asarray(drive.times, dtype=float), np.asarray(drive.speeds, dtype=float)
    if times[0] > 0.0:
        times, speeds = np.append(0.0, times), np.append(speeds[0], speeds)
    steps = np.diff(times)
    angles = np.append(0.0, np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * steps))
    accelerations = np.append(np.diff(speeds) / steps, 0.0)
    table = np.stack([times, angles, speeds, accelerations, 0.0 * times], -1)
    row_time, angle, speed, acceleration, _ = table[max(int(np.searchsorted(times, 0.0, side="right")) - 1, 0)]
    table[:, 1] += drive.start_angle - (angle - row_time * (speed - 0.5 * acceleration * row_time))
    return table


def _spline_table(drive: Path) -> np.ndarray:
    """Return the natural cubic spline of an angle table; behind its last row the speed is constant."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(drive.times, drive.angles, bc_type="natural")
    last = drive.times[-1], drive.angles[-1], float(spline(drive.times[-1], 1)), 0.0, 0.0
    table: np.ndarray = np.vstack([cubic_rows(spline), last])
    table[0, 3] = 0.0
    return table


def torque_table(speeds: np.ndarray, torques: np.ndarray) -> np.ndarray:
    """Return the table of a FreeByTable from speeds (rows,) rad/s and torques (rows,) N m, constant outside them."""
    from scipy.interpolate import PchipInterpolator

    curve = PchipInterpolator(speeds, torques)
    outside = [[place, torque, 0.0, 0.0, 0.0] for place, torque in ((-1e60, torques[0]), (speeds[-1], torques[-1]))]
    return np.vstack([outside[0], cubic_rows(curve), outside[1]])


def motion_at(drive: Constant | Schedule | Path, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return angle (rad), speed (rad/s) and acceleration (rad/s^2) of a crank with a given motion at times (N,) s."""
    if isinstance(drive, Constant):
        return drive.start_angle + drive.speed * times, np.full(len(times), drive.speed), np.zeros(len(times))
    table = motion_table(drive)
    rows = table[np.clip(np.searchsorted(table[:, 0], times, side="right") - 1, 0, len(table) - 1)]
    elapsed, (angle, speed, acceleration, jerk) = times - rows[:, 0], rows[:, 1:].T
    return (
        angle + elapsed * (speed + elapsed * (0.5 * acceleration + jerk * elapsed / 6.0)),
        speed + elapsed * (acceleration + 0.5 * jerk * elapsed),
        acceleration + jerk * elapsed,
    )


def direction_of(drive: tuple) -> float:
    """Return 1 for a crank that turns counter-clockwise in the long run, or -1."""
    if isinstance(drive, Motor):
        return 1.0
    if isinstance(drive, Constant):
        return math.copysign(1.0, drive.speed)
    assert isinstance(drive, (Schedule, Path))  # the only other drives
    last = motion_table(drive)[-1]
    travel = last[2] if last[2] != 0.0 else last[1] - drive.start_angle
    return -1.0 if travel < 0.0 else 1.0


def passage_time(drive: Schedule | Path, angle: float) -> float:
    """Return the time (s) at which a crank first passes an angle (rad), from its start on, or inf if it never does."""
    from scipy.interpolate import PPoly

    table = motion_table(drive)
    last, coefficients = table[-1], (table[:-1, 1:] * (1.0, 1.0, 0.5, 1.0 / 6.0)).T[::-1]
    passages = PPoly(coefficients, table[:, 0]).solve(angle, extrapolate=False)
    passages = passages[np.isfinite(passages) & (passages >= 0.0)]
    if len(passages):
        return float(passages[0])
    behind = (angle - last[1]) / last[2] if last[2] != 0.0 else math.inf
    return float(last[0] + behind) if behind >= 0.0 else math.inf


def scheduled_passage(drive: Schedule, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time (s), speed (rad/s) and acceleration (rad/s^2) when the crank reaches `angles` (rad)."""
    table, sign = schedule_table(drive), direction_of(drive)
    row = table[np.clip(np.searchsorted(sign * table[:, 1], sign * angles, side="right") - 1, 0, len(table) - 1)]
    travel, speed, acceleration = angles - row[:, 1], row[:, 2], row[:, 3]
    end_speed = sign * np.sqrt(np.maximum(speed**2 + 2.0 * acceleration * travel, 0.0))
    elapsed = np.where(travel == 0.0, 0.0, 2.0 * travel / np.where(speed + end_speed == 0.0, 1.0, speed + end_speed))
    return row[:, 0] + elapsed, end_speed, acceleration
