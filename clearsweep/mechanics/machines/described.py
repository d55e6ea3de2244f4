"""Shared parts of mechanisms that are built as planar machines: keys and channels from the names in a grid."""

import math
from collections.abc import Mapping

from ...contracts.case import Case
from ...contracts.catalogue import CHOICE, GROUND, NUMERICS, Channel, Choice, Field, Keys, Mechanism, Outline, Output
from ...contracts.machine import Constant, Elastic, Machine
from . import drives, loads, planar


def column_name(name: str) -> str:
    """Return a name in the form used in channels."""
    return name.replace("-", "_")


def keys_of(outline: Outline, points: Mapping[str, tuple[str, ...]], joints: tuple[str, ...]) -> tuple[Keys, ...]:
    """Return the sections of drive and loads.

    points : points of each body, or () if none can be chosen; joints : their names
    """
    sections = [*drives.drive_keys(outline)]
    sections.append(Keys("loads", "what acts on the mechanism from outside", need="optional"))
    for load in outline.loads:
        sections += loads.load_keys(load, points, joints)
    return tuple(sections)


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if the machine of a case cannot be closed.

    Return None if it can be closed over the whole revolution of its crank.
    """
    assert mechanism.machine is not None  # only mechanisms with a machine
    machine: Machine = mechanism.machine(case)
    steady_machine = machine._replace(drive=Constant(1.0, machine.drive.start_angle), loads=())
    try:
        planar.ideal_of(steady_machine)
    except planar.ClosureError as error:
        path = f"bodies.{error.body}" if case.outline.bodies else error.body
        start_angles = ", or the start angles near which its loops are closed" if case.outline.bodies else ""
        advice = f"change lengths{start_angles}"
        return path, f"{error}, at crank angle {math.degrees(error.angle):.6g} deg; {advice}"
    except planar.MobilityError as error:
        return "", str(error)
    return None


def elastic_keys(path: str, points: tuple[str, ...] = ()) -> tuple[Keys, ...]:
    """Return the sections of an elastic link; `points`: its points, if its two ends are not fixed."""
    elastic_section = Keys(
        f"{path}.elastic",
        "elasticity along the line of the pins. Without this section, the body is rigid",
        _ELASTIC,
        "optional",
        role=CHOICE,
    )
    if not points:
        return (elastic_section,)
    endpoint_choices = tuple(
        Choice(str(k), points, f"the {label} point") for k, label in enumerate(("first", "second"))
    )
    return elastic_section, Keys(
        f"{path}.elastic.between", "the two points of the body that carry its pins", words=endpoint_choices
    )


def elastic_of(values: Mapping, path: str, endpoints: tuple[str, str] | None = None) -> Elastic | None:
    """Return the compliance of a link between `endpoints`, by default those of the case, or None if it is rigid."""
    elastic_path = f"{path}.elastic"
    if f"{elastic_path}.axial_stiffness" not in values:
        return None
    near_end, far_end = endpoints or (values[f"{elastic_path}.between.0"], values[f"{elastic_path}.between.1"])
    return Elastic(near_end, far_end, *(values[f"{elastic_path}.{field.name}"] for field in _ELASTIC))


def channels_of(
    bodies: tuple[str, ...],
    output: Output,
    names: tuple[str, str, str],
    elastic: frozenset[str] = frozenset(),
) -> tuple[Channel, ...]:
    """Return the time histories in the order of `describe`.

    bodies : bodies, including the ground; names : names of the output's position, rate and acceleration
    elastic : elastic links
    """
    units = (output.unit, f"{output.unit}/s", f"{output.unit}/s^2")
    texts = (f"position of the {output.name} along its output direction", "its rate", "its acceleration")
    if output.unit == "rad":
        texts = (f"angle of the {output.name}, which is its output", *texts[1:])
    moving_bodies = [column_name(body) for body in bodies if body != GROUND]
    extension_channels = {
        column_name(body): (Channel(f"{column_name(body)}/extension", *EXTENSION),) for body in elastic
    }
    return (
        Channel("crank_angle", "rad", "crank angle, unwrapped"),
        Channel("crank/torque" if "crank" in moving_bodies else "drive/torque", "N*m", "drive torque on the crank"),
        *(
            Channel(f"{output.name}/{name}", *unit_and_text)
            for name, *unit_and_text in zip(names, units, texts, strict=True)
        ),
        *(channel for body in moving_bodies for channel in (*body_channels(body), *extension_channels.get(body, ()))),
    )


def body_channels(body: str) -> tuple[Channel, ...]:
    """Return the time histories of every moving body."""
    return tuple(Channel(f"{body}/{name}", unit, text.format(body)) for name, unit, text in BODY)


EXTENSION = ("m", "elongation of the line between its pins")
MAX_SEGMENTS = 24  # more take minutes to compile
_ELASTIC = (
    Field(
        "axial_stiffness", "N/m", "axial stiffness E A / l of the whole link, which is a uniform bar of the given mass"
    ),
    Field(
        "segments",
        "1",
        "number of springs in series that represent the link, with masses between them",
        1,
        MAX_SEGMENTS,
        False,
        False,
        default=4,
        integer=True,
        role=NUMERICS,
    ),
    Field(
        "damping",
        "1",
        "damping ratio of the first axial mode of the link with free ends; the ratio of a mode grows with its "
        "frequency",
        0.0,
        1.0,
        low_open=False,
        default=0.0,
    ),
)
#: The time histories of every moving body.
BODY = (
    ("x", "m", "{}'s centre of mass, x"),
    ("y", "m", "{}'s centre of mass, y"),
    ("vx", "m/s", "velocity of the {}'s centre of mass, x"),
    ("vy", "m/s", "velocity of the {}'s centre of mass, y"),
    ("angle", "rad", "angle of the {}, counter-clockwise"),
    ("rate", "rad/s", "its rate"),
)
