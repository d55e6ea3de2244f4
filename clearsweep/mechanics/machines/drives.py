"""Drives of a crank: their keys in a grid, and the records of a machine that they become."""

import math

import numpy as np

from ...contracts import case, machine
from ...contracts.catalogue import ANY, CHOICE, CONDITION, Columns, Field, Keys, Law, Outline, ranged
from ..laws.contract import compile_law
from ..laws.sampled import attempted
from .planar.drives import direction_of, motion_at, motor_torque, no_load_speed

_START_ANGLE = ranged("start_angle", "rad", "crank angle at t = 0; default: 0", "(-inf, inf)", optional=True)
_FREE = (
    ranged("initial_speed", "rad/s", "crank speed at t = 0", "(-inf, inf)", default=0.0),
    ranged(
        "inertia", "kg*m^2", "inertia of a flywheel, added to that of the crank", "[0, inf)", default=0.0, role=CHOICE
    ),
)
_SPEED_TABLE = Columns(
    "table",
    "crank speed as a function of time, linear between the rows and constant outside the table",
    (ranged("time", "s", "time", "(-inf, inf)"),),
    (ranged("speed", "rad/s", "crank speed, negative where it turns clockwise", "(-inf, inf)"),),
    nonzero=("speed",),
)
CRANK_SPEED = ranged(
    "speed",
    "rad/s",
    "constant crank speed, negative for a clockwise crank; other drives have angle, torque, motor or servo instead",
    "(-inf, inf)",
    nonzero=True,
)
_ANGLE_TABLE = Columns(
    "table",
    "crank angle as a function of time, a natural cubic spline through the rows; at constant speed behind the last",
    (ranged("time", "s", "time; the first row is the start, 0 s", "[0, inf)"),),
    (ranged("angle", "rad", "crank angle", "(-inf, inf)"),),
    from_zero=True,
)
_TARGET_TABLE = _ANGLE_TABLE._replace(
    text="target angle of the crank as a function of time, a natural cubic spline through the rows",
    values=(ranged("angle", "rad", "target angle", "(-inf, inf)"),),
)
_TORQUE_TABLE = Columns(
    "table",
    "motor torque as a function of the crank speed, monotone cubic (PCHIP) between the rows and constant outside",
    (ranged("speed", "rad/s", "crank speed", "(-inf, inf)"),),
    (ranged("torque", "N*m", "motor torque", "(-inf, inf)"),),
    nonzero=("torque",),
)
#: Forms of a drive whose numbers are in a section of `drive`, with the table of that section.
_TABLES = {
    "speed-table": ("speed", "the speed over time", _SPEED_TABLE),
    "angle-table": ("angle", "the crank angle over time", _ANGLE_TABLE),
    "motor-table": ("motor", "a motor", _TORQUE_TABLE),
    "servo": ("servo.target", "the target angle over time", _TARGET_TABLE),
}


def _drive(name: str, text: str, formula: str, fields: tuple[Field, ...] = (), notes: str = "") -> Law:
    return Law("drive", name, text, formula, "", fields, notes=notes)


DRIVES = {
    law.name: law
    for law in (
        _drive("speed", "a crank at constant speed", "angle = start_angle + speed t", (CRANK_SPEED, _START_ANGLE)),
        _drive(
            "speed-table",
            "a crank whose speed follows a table over time",
            "angle = start_angle + integral of speed, exactly; speed straight between rows, constant beyond them",
            (_START_ANGLE,),
            "Written speed: {table: runup.csv}, a file with the columns `time [s]` and `speed [rpm]`.",
        ),
        _drive(
            "angle-table",
            "a crank whose angle follows a table over time",
            "angle = natural cubic spline through the rows; its rate and acceleration are those of the crank",
            notes="Written angle: path.csv, a file with the columns `time [s]` and `angle [deg]`.",
        ),
        _drive(
            "torque",
            "a free crank under a constant torque",
            "torque = constant; the crank's angle is a coordinate",
            (ranged("torque", "N*m", "torque on the crank", "(-inf, inf)"), *_FREE, _START_ANGLE),
        ),
        _drive(
            "motor",
            "a free crank under a motor's characteristic",
            "torque = stall_torque (1 - speed / no_load_speed); the crank's angle is a coordinate",
            (
                Field("motor.stall_torque", "N*m", "motor torque at standstill"),
                Field("motor.no_load_speed", "rad/s", "crank speed at which the motor torque is zero"),
                *_FREE,
                _START_ANGLE,
            ),
        ),
        _drive(
            "motor-table",
            "a free crank under a motor whose torque follows a table over the speed",
            "torque = monotone cubic (PCHIP) through the rows, constant outside; the crank's angle is a coordinate",
            (*_FREE, _START_ANGLE),
            "Written motor: {table: motor.csv}, a file with the columns `speed [rpm]` and `torque [N*m]`.",
        ),
        _drive(
            "servo",
            "a free crank under a servo that follows a target angle",
            "torque = stiffness (target - angle) + damping (target rate - rate) + I, at most torque_limit either way; "
            "I' = integral (target - angle) + (torque - the same without limit) / tracking_time; I(0) = 0",
            (
                Field("servo.stiffness", "N*m/rad", "torque per angle behind the target"),
                ranged("servo.damping", "N*m*s/rad", "torque per rate behind that of the target", "[0, inf)"),
                Field("servo.torque_limit", "N*m", "largest torque; default: unlimited", optional=True),
                Field(
                    "servo.integral",
                    "N*m/(rad*s)",
                    "torque per time and angle behind the target; default: no integral",
                    optional=True,
                ),
                Field(
                    "servo.tracking_time",
                    "s",
                    "time in which the integral gives way while the torque is at its limit (anti-windup by "
                    "back-calculation); default: sqrt(damping / integral), without damping stiffness / integral",
                    optional=True,
                ),
                *_FREE,
                _START_ANGLE,
            ),
            "Its target is a file with the columns `time [s]` and `angle [deg]`, or these columns.",
        ),
    )
}


def drive_keys(outline: Outline) -> tuple[Keys, ...]:
    """Return the section `drive` for the grid's form of drive, or the sections of all forms for ANY."""
    fields: dict[str, Field] = {}
    form = "torque" if outline.drive == "motor-law" else outline.drive
    for law in DRIVES.values() if form == ANY else (DRIVES[form],):
        fields |= {field.name: field for field in law.fields}
    if outline.drive == "motor-law":
        del fields["torque"]
    sections = [
        Keys("drive", "the drive", tuple(fields[name] for name in fields if "." not in name), "implied", role=CONDITION)
    ]
    if outline.drive == "motor-law":
        sections.append(Keys("drive.motor", "a motor of one's own", family="motor", role=CONDITION))
    need = "optional" if outline.drive == ANY else "required"
    for name, text in (("motor", "a motor"), ("servo", "a servo")):
        inner = tuple(
            field._replace(name=path.partition(".")[2]) for path, field in fields.items() if path.startswith(f"{name}.")
        )
        if inner:
            sections.append(Keys(f"drive.{name}", text, inner, need, role=CONDITION))
    for form, (path, text, columns) in _TABLES.items():
        if outline.drive in (form, ANY):
            form_need = "required" if form in ("speed-table", "servo") else need  # a servo needs its target
            sections.append(Keys(f"drive.{path}", text, tables=(columns,), need=form_need))
    return tuple(sections)


def make_drive(drive: case.Drive, outline: Outline) -> tuple:
    """Return the drive as described in a machine."""
    free = drive.initial_speed, drive.inertia, drive.start_angle
    if drive.law:
        law = compile_law("motor", drive.law, drive)
        return machine.Motor(attempted(lambda: motor_torque(law, 0.0, 0.0), 0.0), no_load_speed(law), *free, law)
    if outline.drive == "servo":
        return machine.Motor(0.0, math.inf, *free, servo=_servo_of(_path_of(drive.table), **drive.values))
    if outline.drive == "motor-table":
        curve = np.array(drive.table["speed"]), np.array(drive.table["torque"])
        return machine.Motor(float(np.interp(0.0, *curve)), _zero_of(*curve), *free, curve=curve)
    if outline.free:
        return machine.Motor(drive.torque, drive.no_load_speed, *free)
    if drive.table is None:
        return machine.Constant(drive.speed, drive.start_angle)
    if "angle" in drive.table:
        return _path_of(drive.table)
    return machine.Schedule(np.array(drive.table["time"]), np.array(drive.table["speed"]), drive.start_angle)


def _path_of(table: case.Table) -> machine.Path:
    """Return the motion of a table of angles."""
    return machine.Path(np.array(table["time"]), np.array(table["angle"]), table["angle"][0])


def _servo_of(target: machine.Path, **values: float) -> machine.Servo:
    """Return a servo; the tracking time follows Astrom & Hagglund 1995, "PID Controllers", 2nd ed., section 3.5.

    They give the geometric mean of the integral and the derivative time, for a PI controller the integral time.
    """
    servo = machine.Servo(target, **values)
    if servo.integral is None or "tracking_time" in values:
        return servo
    times = servo.stiffness / servo.integral, servo.damping / servo.stiffness
    return servo._replace(tracking_time=math.sqrt(times[0] * times[1]) or times[0])


def _zero_of(speeds: np.ndarray, torques: np.ndarray) -> float:
    """Return the least positive speed (rad/s) of a table at which its torque is no longer positive, or inf."""
    for low, high, before, after in zip(speeds, speeds[1:], torques, torques[1:], strict=False):
        if high > 0.0 and before > 0.0 >= after:
            return float(low + (high - low) * before / (before - after))
    return math.inf


_TIMES = 2001  # of a run, at which the angle of a crank with a given motion is computed


def visited_angles(drive: tuple, one_case: case.Case) -> tuple[float, float] | None:
    """Return the crank angles (rad from the start) between which a run stays, None for a whole revolution."""
    settings = one_case.simulate
    if settings.until or one_case.life:
        return None
    if isinstance(drive, machine.Motor):
        return None if settings.period is None else (-math.inf, math.inf)
    if settings.period is None:
        travel = direction_of(drive) * 2.0 * math.pi * settings.revolutions
        low, high = min(travel, 0.0), max(travel, 0.0)
    else:
        assert isinstance(drive, (machine.Constant, machine.Schedule, machine.Path))  # the only other drives
        duration = settings.revolutions * settings.period
        rows = [] if isinstance(drive, machine.Constant) else [time for time in drive.times if 0.0 < time < duration]
        times = np.array(sorted({*np.linspace(0.0, duration, _TIMES).tolist(), *rows}))
        angles = motion_at(drive, times)[0] - drive.start_angle
        low, high = float(np.min(angles)), float(np.max(angles))
    return (low, high) if high - low < 2.0 * math.pi else None
