"""Drives of a crank: the keys of each form of drive, and its description in a machine."""

import math

import numpy as np

from ...contracts import case, machine
from ...contracts.catalogue import ANY, CHOICE, CONDITION, Columns, Field, Keys, Law, Outline

_START_ANGLE = Field("start_angle", "rad", "crank angle at t = 0; default: 0", -math.inf, optional=True)
_FREE = (
    Field("initial_speed", "rad/s", "crank speed at t = 0", low_open=False, default=0.0),
    Field(
        "inertia",
        "kg*m^2",
        "inertia of a flywheel, added to that of the crank",
        low_open=False,
        default=0.0,
        role=CHOICE,
    ),
)
_SPEED_TABLE = Columns(
    "table",
    "crank speed as a function of time, linear between the rows and constant outside the table",
    (Field("time", "s", "time", -math.inf),),
    (Field("speed", "rad/s", "crank speed", low_open=False),),
    above_zero=("speed",),
)
DRIVES = {
    law.name: law
    for law in (
        Law(
            "drive",
            "speed",
            "a crank at constant speed",
            "angle = start_angle + speed t",
            "",
            (Field("speed", "rad/s", "constant crank speed"), _START_ANGLE),
        ),
        Law(
            "drive",
            "speed-table",
            "a crank whose speed follows a table over time",
            "angle = start_angle + integral of speed, exactly; speed straight between rows, constant beyond them",
            "",
            (_START_ANGLE,),
            notes="Written speed: {table: runup.csv}, a file with the columns `time [s]` and `speed [rpm]`.",
        ),
        Law(
            "drive",
            "torque",
            "a free crank under a constant torque",
            "torque = constant; the crank's angle is a coordinate",
            "",
            (Field("torque", "N*m", "torque on the crank", -math.inf), *_FREE, _START_ANGLE),
        ),
        Law(
            "drive",
            "motor",
            "a free crank under a motor's characteristic",
            "torque = stall_torque (1 - speed / no_load_speed); the crank's angle is a coordinate",
            "",
            (
                Field("motor.stall_torque", "N*m", "motor torque at standstill"),
                Field("motor.no_load_speed", "rad/s", "crank speed at which the motor torque is zero"),
                *_FREE,
                _START_ANGLE,
            ),
        ),
    )
}


def drive_keys(outline: Outline) -> tuple[Keys, ...]:
    """Return the section `drive` for the grid's form of drive, or the sections of all forms for ANY."""
    fields: dict[str, Field] = {}
    for law in DRIVES.values() if outline.drive == ANY else (DRIVES[outline.drive],):
        fields |= {field.name: field for field in law.fields}
    motor_fields = {name.partition(".")[2]: field for name, field in fields.items() if "." in name}
    sections = [
        Keys("drive", "the drive", tuple(fields[name] for name in fields if "." not in name), "implied", role=CONDITION)
    ]
    if motor_fields:
        motor = tuple(field._replace(name=name) for name, field in motor_fields.items())
        sections.append(
            Keys("drive.motor", "a motor", motor, "optional" if outline.drive == ANY else "required", role=CONDITION)
        )
    if outline.drive in ("speed-table", ANY):
        sections.append(Keys("drive.speed", "the speed over time", tables=(_SPEED_TABLE,)))
    return tuple(sections)


def make_drive(drive: case.Drive, outline: Outline) -> tuple:
    """Return the drive as described in a machine."""
    if outline.free:
        return machine.Motor(drive.torque, drive.no_load_speed, drive.initial_speed, drive.inertia, drive.start_angle)
    if drive.table is None:
        return machine.Constant(drive.speed, drive.start_angle)
    return machine.Schedule(np.array(drive.table["time"]), np.array(drive.table["speed"]), drive.start_angle)
