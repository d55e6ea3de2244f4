"""Drives of a planar machine: compiled forms, and their motion in the ideal machine."""

import math
from typing import NamedTuple

import numpy as np

from ....contracts.machine import Constant, Motor, Schedule
from ....tracing.compiled.dual import plain
from ....tracing.compiled.family import family
from ....tracing.compiled.pinned import array_handle, load_item, row_of

_WIDTH = 4  # numbers in a row of a speed table: time, angle, speed, acceleration


class Steady(NamedTuple):
    """A constant speed."""

    speed: float  # rad/s
    start: float  # rad


class Scheduled(NamedTuple):
    """A speed from a table, linear between its rows, so that the angle is quadratic."""

    table: float  # address of (rows, 4): s, rad, rad/s, rad/s^2
    row_count: float


class Free(NamedTuple):
    """A torque that decreases linearly with speed; the crank's angle is a coordinate."""

    torque: float  # N m, at rest
    slope: float  # N m s, decrease of torque per rad/s


@family
def drive_motion(drive, time):
    """Return angle (rad), rate (rad/s) and angular acceleration (rad/s^2) of a driven crank at `time` (s)."""


@drive_motion.member(Steady)
def _drive_motion_steady(drive, time):
    return drive.speed * time + drive.start, drive.speed, 0.0


@drive_motion.member(Scheduled)
def _drive_motion_scheduled(drive, time):
    row = row_of(drive.table, _WIDTH, int(drive.row_count), plain(time))
    elapsed, speed = time - load_item(drive.table, row), load_item(drive.table, row + 2)
    acceleration = load_item(drive.table, row + 3)
    angle = load_item(drive.table, row + 1) + elapsed * (speed + 0.5 * acceleration * elapsed)
    return angle, speed + acceleration * elapsed, acceleration


@family
def torque_at(drive, rate):
    """Return the torque (N m) on a free crank that turns at `rate` (rad/s)."""


@torque_at.member(Free)
def _torque_at_free(drive, rate):
    return drive.torque - drive.slope * rate


def compile_drive(drive: Constant | Schedule | Motor) -> tuple:
    """Return the compiled form of a drive."""
    if isinstance(drive, Constant):
        return Steady(drive.speed, drive.start_angle)
    if isinstance(drive, Schedule):
        table = schedule_table(drive)
        return Scheduled(array_handle(table), float(len(table)))
    return Free(
        drive.stall_torque, 0.0 if math.isinf(drive.no_load_speed) else drive.stall_torque / drive.no_load_speed
    )


def schedule_table(drive: Schedule) -> np.ndarray:
    """Return a speed table as (rows, 4): time (s), angle (rad), speed (rad/s), acceleration (rad/s^2) after the row.

    The speed is constant before the first row and after the last; the angle is `start_angle` at time 0.
    """
    times, speeds = np.asarray(drive.times, dtype=float), np.asarray(drive.speeds, dtype=float)
    if times[0] > 0.0:
        times, speeds = np.append(0.0, times), np.append(speeds[0], speeds)
    steps = np.diff(times)
    angles = np.append(0.0, np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * steps))
    accelerations = np.append(np.diff(speeds) / steps, 0.0)
    table = np.stack([times, angles, speeds, accelerations], -1)
    row_time, angle, speed, acceleration = table[max(int(np.searchsorted(times, 0.0, side="right")) - 1, 0)]
    table[:, 1] += drive.start_angle - (angle - row_time * (speed - 0.5 * acceleration * row_time))
    return table


def scheduled_passage(drive: Schedule, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time (s), speed (rad/s) and acceleration (rad/s^2) when the crank reaches `angles` (rad)."""
    table = schedule_table(drive)
    row = table[np.clip(np.searchsorted(table[:, 1], angles, side="right") - 1, 0, len(table) - 1)]
    travel, speed, acceleration = angles - row[:, 1], row[:, 2], row[:, 3]
    end_speed = np.sqrt(np.maximum(speed**2 + 2.0 * acceleration * travel, 0.0))
    elapsed = np.where(travel == 0.0, 0.0, 2.0 * travel / np.where(speed + end_speed == 0.0, 1.0, speed + end_speed))
    return row[:, 0] + elapsed, end_speed, acceleration
