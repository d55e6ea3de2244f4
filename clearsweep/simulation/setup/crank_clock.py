"""The independent variable of a run and the ends of its revolutions: time, or the angle of a free crank."""

import math
from typing import NamedTuple

import numpy as np

from ...contracts.machine import STARTED_FRACTION, Machine, Motor, Schedule
from ...mechanics.machines import planar

STALL_TURNS = 100.0  # turns at nominal speed after which a free crank that hardly moves counts as stalled


class SteadyClock(NamedTuple):
    """Clock of a crank at constant speed, or of a machine without a crank; it shows time."""

    period: float  # s, of a revolution

    @property
    def free(self) -> bool:
        """Return whether a run is measured along the angle of a free crank."""
        return False

    def value_after(self, revolutions: float) -> float:
        """Return the time (s) after a number of revolutions."""
        return revolutions * self.period

    def values_after(self, revolutions: np.ndarray) -> np.ndarray:
        """Return the times (s) after arrays of revolutions."""
        return revolutions * self.period


class ScheduledClock(NamedTuple):
    """Clock of a crank whose speed follows a table; it shows time."""

    times: np.ndarray  # (rows,) s, first row at 0 or before
    speeds: np.ndarray  # (rows,) rad/s
    angles: np.ndarray  # (rows,) rad, from the start to each row

    @property
    def free(self) -> bool:
        """Return whether a run is measured along the angle of a free crank."""
        return False

    def value_after(self, revolutions: float) -> float:
        """Return the time (s) after a number of revolutions, or inf if the crank comes to rest before."""
        angle = 2.0 * math.pi * revolutions
        row = int(np.searchsorted(self.angles, angle, side="right")) - 1
        row = min(max(row, 0), len(self.times) - 1)
        remaining_angle, speed = angle - self.angles[row], self.speeds[row]
        if remaining_angle == 0.0:
            return float(self.times[row])
        if row == len(self.times) - 1:
            return float(self.times[row] + remaining_angle / speed) if speed > 0.0 else math.inf
        acceleration = (self.speeds[row + 1] - speed) / (self.times[row + 1] - self.times[row])
        end_speed = math.sqrt(max(speed * speed + 2.0 * acceleration * remaining_angle, 0.0))
        return float(self.times[row] + 2.0 * remaining_angle / (speed + end_speed))

    def values_after(self, revolutions: np.ndarray) -> np.ndarray:
        """Return the times (s) after arrays of revolutions."""
        return np.array([self.value_after(turns) for turns in revolutions])


class FreeClock(NamedTuple):
    """Clock of a free crank; it shows the crank angle."""

    start: float  # rad

    @property
    def free(self) -> bool:
        """Return whether a run is measured along the angle of a free crank."""
        return True

    def value_after(self, revolutions: float) -> float:
        """Return the angle (rad) after a number of revolutions."""
        return self.start + 2.0 * math.pi * revolutions

    def values_after(self, revolutions: np.ndarray) -> np.ndarray:
        """Return the angles (rad) after arrays of revolutions."""
        return self.start + 2.0 * math.pi * revolutions


def clock_of(machine: Machine | None, period: float) -> SteadyClock | ScheduledClock | FreeClock:
    """Return the clock of a machine; `period` (s): a revolution at its nominal speed."""
    if machine is None or not isinstance(machine.drive, (Schedule, Motor)):
        return SteadyClock(period)
    if isinstance(machine.drive, Motor):
        return FreeClock(machine.drive.start_angle)
    return scheduled_clock(machine.drive)


def scheduled_clock(schedule: Schedule) -> ScheduledClock:
    """Return the clock of a speed table from t = 0 on; the speed is constant before the first row."""
    is_later = schedule.times > 0.0
    times = np.concatenate([[0.0], schedule.times[is_later]])
    speeds = np.concatenate([[np.interp(0.0, schedule.times, schedule.speeds)], schedule.speeds[is_later]])
    angles = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(times))])
    return ScheduledClock(times, speeds, angles)


def knots_of(machine: Machine | None) -> list[float]:
    """Return the times (s) at which an acceleration or the slope of a load jumps; empty for a free crank."""
    return [] if machine is None or isinstance(machine.drive, Motor) else planar.discontinuity_times(machine)


def start_up(machine: Machine | None) -> tuple[float, float]:
    """Return the speed (rad/s) at which a motor counts as started, and the time (s) of this.

    The speed is 0 for other drives and for constant torque; the time is 0 if the crank starts fast enough, else inf.
    """
    if machine is None or not isinstance(machine.drive, Motor) or math.isinf(machine.drive.no_load_speed):
        return 0.0, math.inf
    speed = STARTED_FRACTION * machine.drive.no_load_speed
    return speed, 0.0 if machine.drive.initial_speed >= speed else math.inf
