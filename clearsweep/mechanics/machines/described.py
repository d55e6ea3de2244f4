"""Keys and records that mechanisms share: their bodies, named joints and outputs, drives, housings and vibration."""

import math
from collections.abc import Iterable, Mapping

from ...contracts.case import Case
from ...contracts.catalogue import (
    ANY,
    CHOICE,
    CONDITION,
    GROUND,
    NUMERICS,
    Channel,
    Choice,
    Field,
    JointOutline,
    Keys,
    Mechanism,
    Outline,
    Output,
    ranged,
)
from ...contracts.layout import is_along_output
from ...contracts.machine import Aim, Bending, Body, BodyPoint, Elastic, Guide, Machine, Mount, Pin, Push, Slot
from ...contracts.vibration import FRAME, MAX_ORDERS, NO_SEVERITY, SEVERITIES, Location, PlaceOutline
from ...language.errors import InputError
from . import planar
from .drives import drive_keys, make_drive, visited_angles
from .gears import FLANKED, GEAR_FIELDS, flanked_keys
from .loads import CENTER_TEXT, LoadPoints, along_axes, load_keys, make_loads

# ---------------------------------------------------------------------------------------------- gravity


_GRAVITY = ranged(
    "gravity",
    "m/s^2",
    "acceleration of gravity, along -y; a list of two is the acceleration along x and y",
    "(-inf, inf)",
    default=0.0,
    role=CONDITION,
)
_WEIGHT = "~weight"  # centre of mass of a body, as a point on which gravity along x acts


def gravity_section(outline: Outline) -> Keys:
    """Return the section with the gravity of a planar machine: a number, or a list of two."""
    if not outline.inclined:
        return Keys("mechanism", "", (_GRAVITY,), role=CHOICE)
    fields = along_axes("m/s^2", "acceleration of gravity along {}")
    return Keys("mechanism.gravity", "acceleration of gravity along x and y", fields, role=CONDITION)


def machine_of(
    case: Case, points: LoadPoints, joints: tuple, driven: str, aim: Aim, start: Mapping[str, float]
) -> Machine:
    """Return the machine of a case in the plane, with its drive, loads, housings and the angles that its run visits.

    points : its bodies, to which loads add points.  Gravity along x acts as a force at every centre of mass.
    """
    values, outline = case.mechanism.values, case.outline
    loads, drive = make_loads(case.loads, points), make_drive(case.drive, outline)
    gravity = values["gravity"] if "gravity" in values else -values["gravity.1"]
    parts = points.bodies, joints, driven, drive, gravity, aim, start, loads, mounts_of(values, outline)
    machine = Machine(*parts, visited=visited_angles(drive, case))
    acceleration = values.get("gravity.0", 0.0)
    if acceleration == 0.0:
        return machine
    bodies, weights = dict(machine.bodies), []
    for name, body in machine.bodies.items():
        if name != GROUND:
            bodies[name] = body._replace(points={**body.points, _WEIGHT: body.center})
            weights.append(Push(f"weight of {name}", BodyPoint(name, _WEIGHT), body.mass * acceleration, 0.0, 0.0))
    return machine._replace(bodies=bodies, loads=(*machine.loads, *weights))


# ---------------------------------------------------------------------------------------------- names of a grid


_AXIS = ranged(
    "axis",
    "rad",
    "angle of the line of a guide or slot, through the proximal point, in the frame of the proximal body; not for a "
    "pin",
    "(-inf, inf)",
    default=0.0,
)
#: Numbers of a joint by its type; others are those of a guide.
_FIELDS_BY_TYPE = {
    "revolute": (),
    ANY: (_AXIS, *(field._replace(text=f"of a gear: {field.text}", optional=True) for field in GEAR_FIELDS)),
}
_ALONG = ranged("along", "rad", "direction in which the motion of the point is measured", "(-inf, inf)", default=0.0)


def joint_keys(joint: JointOutline, endpoints: tuple[str, ...]) -> Iterable[Keys]:
    """Yield the sections of a joint that can connect the points `endpoints`."""
    path = f"mechanism.joints.{joint.name}"
    type_choice = Choice(
        "type",
        ("revolute", "prismatic", "slot", *FLANKED),
        "kind of the joint; revolute: a pin; prismatic: a guide; slot: a pin in a slot of the proximal body; gear: two "
        "wheels in mesh; coupling: two bodies that turn together",
    )
    if joint.type in FLANKED:
        yield from flanked_keys(joint, dict.fromkeys(end.partition(".")[0] for end in endpoints), type_choice)
        return
    bodies = tuple(filter(None, joint.bodies))
    journal = (Choice("journal", bodies, "body that carries the journal", bodies[-1] if bodies else ANY),)
    choices = (type_choice,) if joint.type in ("prismatic", "slot") else (type_choice, *journal)
    yield Keys(path, "a joint of the mechanism", _FIELDS_BY_TYPE.get(joint.type, (_AXIS,)), words=choices, role=CHOICE)
    texts = ("the proximal point, body.point", "the distal point")
    between = tuple(Choice(str(k), endpoints, text) for k, text in enumerate(texts))
    yield Keys(f"{path}.between", "the two points that the joint connects, the proximal point first", words=between)


def output_keys(outline: Outline) -> Iterable[Keys]:
    """Yield the sections of the start and the output."""
    moving_bodies = tuple(body.name for body in outline.bodies if body.name != GROUND)
    start = tuple(
        ranged(body, "rad", "initial guess of the angle of this body; default: 0", "(-inf, inf)", optional=True)
        for body in moving_bodies
    )
    yield Keys(
        "mechanism.start",
        "initial guesses of body angles, which select one of the two positions in which a loop closes",
        start,
        "implied",
        role=CHOICE,
    )
    body = Choice("body", moving_bodies, "body whose motion is the output")
    all_points = tuple(dict.fromkeys(point for body in outline.bodies for point in body.points))
    point = Choice(
        "point",
        all_points,
        "point of this body whose motion is the output; default: the output is the angle of the body",
    )
    is_point_output = not outline.rotary
    yield Keys(
        "mechanism.output",
        "the output",
        (_ALONG,) if is_point_output else (),
        words=(body, point) if is_point_output else (body,),
        role=CHOICE,
    )


def pair_at(values, path: str) -> tuple[float, float]:
    """Return the first two numbers of a list."""
    return values[f"{path}.0"], values[f"{path}.1"]


def joint_of(values, joint: JointOutline) -> Pin | Guide | Slot:
    """Return a joint of a case."""
    endpoints = [BodyPoint(*endpoint.split(".", 1)) for endpoint in (joint.proximal, joint.distal)]
    if joint.type == "revolute":
        return Pin(joint.name, *endpoints)
    joint_type = Slot if joint.type == "slot" else Guide
    return joint_type(joint.name, *endpoints, values[f"joints.{joint.name}.axis"])


# ---------------------------------------------------------------------------------------------- bodies and outputs


def column_name(name: str) -> str:
    """Return a name in the form used in channels."""
    return name.replace("-", "_")


def with_outline(
    mechanism: Mechanism, outline: Outline, keys: Iterable[Keys], grounded: Iterable[str], names: tuple[str, str, str]
) -> Mechanism:
    """Return a mechanism of fixed bodies with the drive and the loads of a grid.

    keys : its own sections; grounded : its joints at the ground; names : as for `channels_of`
    """
    joints = tuple(site.name for site in mechanism.joints)
    assert mechanism.output is not None  # it has a drive
    return mechanism._replace(
        joints=outline.sites(mechanism.joints),
        keys=(*keys, *keys_of(outline, dict.fromkeys(mechanism.bodies, ()), joints, grounded)),
        channels=channels_of(mechanism.bodies, mechanism.output, names, outline),
        free=outline.free,
        length=outline.length,
    )


def keys_of(
    outline: Outline, points: Mapping[str, tuple[str, ...]], joints: tuple[str, ...], grounded: Iterable[str]
) -> tuple[Keys, ...]:
    """Return the sections of drive, mounts, loads and vibration.

    points : points of each body, or () if none can be chosen; joints : their names; grounded : those at the ground
    """
    sections = [*drive_keys(outline), *mount_keys(outline, grounded)]
    sections.append(Keys("loads", "what acts on the mechanism from outside", need="optional"))
    for load in outline.loads:
        sections += load_keys(load, points, joints)
    return (*sections, *vibration_keys(outline, points))


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if the machine of a case cannot be closed.

    Return None if it can be closed over the whole revolution of its crank.
    """
    assert mechanism.machine is not None  # only mechanisms with a machine
    try:
        machine: Machine = mechanism.machine(without_own_forces(case))
    except InputError as error:
        path, _, sentence = str(error).partition(": ")
        return path.removeprefix("mechanism."), sentence
    if problem := planar.problem_of_links(machine):
        path, sentence = problem
        return f"bodies.{path}" if case.outline.bodies else path, sentence
    try:
        planar.ideal_of(planar.without_forces(machine))
    except planar.ClosureError as error:
        return unclosed(error, case)
    except planar.MobilityError as error:
        return "", str(error)
    return None


def without_own_forces(case: Case) -> Case:
    """Return a case whose geometry is known without its law files: a motor and loads of one's own exert nothing."""
    loads = tuple(load._replace(form="force") if load.form == "own" else load for load in case.loads)
    return case._replace(drive=case.drive and case.drive._replace(law=""), loads=loads)


def unclosed(error: planar.ClosureError, case: Case) -> tuple[str, str]:
    """Return the path below `mechanism` at fault, and a sentence with the remedy, for a machine that is not closed."""
    path = f"bodies.{error.body}" if case.outline.bodies else error.body
    start_angles = ", or the start angles near which its loops are closed" if case.outline.bodies else ""
    return path, f"{error}, at crank angle {math.degrees(error.angle):.6g} deg; {error.remedy}{start_angles}"


def elastic_keys(path: str, outline: Outline, points: tuple[str, ...] = ()) -> tuple[Keys, ...]:
    """Return the sections of an elastic link; `points`: its points, if its two ends are not fixed."""
    bending, elastic_path = outline.bending_of(path.rpartition(".")[2]), f"{path}.elastic"
    if bending is None:
        sections = [Keys(elastic_path, _ELASTIC_TEXT, _AXIAL, "optional", role=CHOICE)]
    else:
        stiffness, *others = _AXIAL[:-1]
        axial = (stiffness._replace(optional=True, text=_STIFFNESS_TEXT), *others) if bending.stretches else ()
        fields = (*_SECTION, *axial, _AXIAL[-1])
        sections = [Keys(elastic_path, _ELASTIC_TEXT, fields, "optional", materials=(_MATERIAL,), role=CHOICE)]
        sections.append(Keys(f"{elastic_path}.section", _SECTION_TEXT, _SIDES, "optional", role=CHOICE))
    if bending and bending.fatigue:
        sections.append(Keys(f"{elastic_path}.stress_life", _STRESS_LIFE_TEXT, _STRESS_LIFE, "optional", role=CHOICE))
    if points:
        endpoint_choices = tuple(
            Choice(str(k), points, f"the {label} point") for k, label in enumerate(("first", "second"))
        )
        text = "the two points of the body that carry its pins"
        sections.append(Keys(f"{elastic_path}.between", text, words=endpoint_choices))
    return tuple(sections)


def elastic_of(
    values: Mapping, path: str, points: Mapping[str, tuple[float, float]], ends: tuple[str, str] | None = None
) -> Elastic | None:
    """Return the compliance of a link between `ends`, by default those of the case, or None if it is rigid."""
    prefix = f"{path}.elastic."
    given = {key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)}
    if not given:
        return None
    near_end, far_end = ends or (given["between.0"], given["between.1"])
    if "bending" not in given:
        return Elastic(near_end, far_end, *(given[field.name] for field in _AXIAL))
    area, second_moment, edge = (given.get(name, math.nan) for name in ("area", "second_moment", "edge"))
    if "section.0" in given:
        width, height = given["section.0"], given["section.1"]
        area, second_moment, edge = width * height, width * height**3 / 12.0, 0.5 * height
    young = given.get("young", math.nan)
    length = math.dist(points[near_end], points[far_end])
    segments = int(given.get("segments", 0))
    stiffness = given.get("axial_stiffness", young * area / length if segments and length else math.inf)
    bending = Bending(int(given["bending"]), young * second_moment, young, edge, area)
    return Elastic(near_end, far_end, stiffness, segments, given["damping"], bending)


_NO_OUTLINE = Outline()


def channels_of(
    bodies: tuple[str, ...], output: Output, names: tuple[str, str, str], outline: Outline = _NO_OUTLINE
) -> tuple[Channel, ...]:
    """Return the time histories in the order of `describe`.

    bodies : bodies, including the ground; names : names of the output's position, rate and acceleration
    """
    units = (output.unit, f"{output.unit}/s", f"{output.unit}/s^2")
    texts = (f"position of the {output.name} along its output direction", "its rate", "its acceleration")
    if output.unit == "rad":
        texts = (f"angle of the {output.name}, which is its output", *texts[1:])
    moving_bodies = [column_name(body) for body in bodies if body != GROUND]
    link_channels: dict[str, tuple[Channel, ...]] = {}
    for body in bodies if outline.elastic else ():
        bending, name = outline.bending_of(body), column_name(body)
        deflection = (Channel(f"{name}/deflection", *DEFLECTION), Channel(f"{name}/stress", *STRESS)) if bending else ()
        stretches = bending.stretches if bending else body in outline.elastic
        link_channels[name] = (*deflection, *((Channel(f"{name}/extension", *EXTENSION),) if stretches else ()))
    return (
        Channel("crank_angle", "rad", "crank angle, unwrapped"),
        Channel("crank/torque" if "crank" in moving_bodies else "drive/torque", "N*m", "drive torque on the crank"),
        *(
            Channel(f"{output.name}/{name}", *unit_and_text)
            for name, *unit_and_text in zip(names, units, texts, strict=True)
        ),
        *(channel for body in moving_bodies for channel in (*body_channels(body), *link_channels.get(body, ()))),
        *planar.mount_channels(outline.mounts),
    )


def body_channels(body: str) -> tuple[Channel, ...]:
    """Return the time histories of every moving body."""
    return tuple(Channel(f"{body}/{name}", unit, text.format(body)) for name, unit, text in BODY)


EXTENSION = ("m", "elongation of the line between its pins")
MAX_SEGMENTS = 24  # more take minutes to compile
DEFLECTION = "m", "deflection of its middle from the chord between its pins, to the left of the way to the second pin"
STRESS = (
    "Pa",
    "bending stress at the edge of its middle, positive where it turns counter-clockwise on the way to the second pin",
)
MAX_MODES = 8
_ELASTIC_TEXT = "elasticity along or across the line of the pins. Without this section, the body is rigid"
_STIFFNESS_TEXT = (
    "axial stiffness E A / l of the whole link, which is a uniform bar of the given mass; required unless section and "
    "`segments` determine it"
)
_SECTION_TEXT = (
    "sides of a rectangular section: across the plane, and in the plane; in place of area, second_moment and edge"
)
_STRESS_LIFE_TEXT = "stress-life line of the link: amplitude^exponent x cycles is constant"
_MATERIAL = Choice(
    "material", (), "name of the material, from `clearsweep list materials`; `young` overrides its value"
)
_SIDES = (
    Field("0", "m", "width of the section, across the plane"),
    Field("1", "m", "height of the section, in the plane"),
)
_SECTION = (
    Field("area", "m^2", "area of the section", optional=True),
    Field("second_moment", "m^4", "second moment of area about the axis normal to the plane", optional=True),
    Field("edge", "m", "distance of the edge of the section from its centre, in the plane", optional=True),
    Field("young", "Pa", "Young's modulus; required without `material`", optional=True),
    Field(
        "density",
        "kg/m^3",
        "density; it only checks the mass, which counts as evenly distributed over the length",
        optional=True,
    ),
    Field(
        "bending", "1", "number of bending modes", 1, MAX_MODES, False, False, default=2, integer=True, role=NUMERICS
    ),
)
_STRESS_LIFE = (
    Field("strength", "Pa", "stress amplitude that breaks the link after `cycles`"),
    Field("exponent", "1", "exponent of the stress amplitude"),
    Field("cycles", "1", "number of cycles at that amplitude"),
)
_AXIAL = (
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
    ranged(
        "damping",
        "1",
        "damping ratio of the first axial mode of the link with free ends; the ratio of a mode grows with its "
        "frequency; of a link that bends also that of its first mode with pinned ends",
        "[0, 1)",
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


# ---------------------------------------------------------------------------------------------- housings that yield


_MOUNTS = "mechanism.mounts"
_MASS = Field("mass", "kg", "mass of the housing, which moves with it and does not turn")


_STIFFNESS = along_axes("N/m", "stiffness of the springs along {}", "(0, inf)")
_DAMPING = along_axes("N*s/m", "coefficient of the dampers along {}", "[0, inf)", default=0.0)
_RATIO = along_axes("1", "damping ratio of housing and springs along {}", "[0, inf)")


def mount_keys(outline: Outline, joints: Iterable[str]) -> Iterable[Keys]:
    """Yield the sections of the housings of a mechanism whose `joints` are at the ground."""
    yield Keys(
        _MOUNTS,
        "housings that yield: springs and dampers under the ground's side of a joint, by the name of the joint",
        need="implied" if outline.mounts else "optional",
    )
    for joint in joints:
        if not {joint, ANY} & set(outline.mounts):
            yield Keys(f"{_MOUNTS}.{joint}", "a housing", need="optional")
            continue
        path = f"{_MOUNTS}.{joint}"
        text = (
            "the housing of a joint at the ground; it starts at rest where its springs have no force, and its weight "
            "is carried. Without this section, the joint is fixed"
        )
        yield Keys(path, text, (_MASS,), "optional", role=CHOICE)
        yield _pair(f"{path}.stiffness", "stiffness of the springs along x and y", _STIFFNESS, "required")
        ratio_text = "written in %, it is `damping_ratio`"
        yield _pair(f"{path}.damping", f"dampers along x and y; {ratio_text}", _DAMPING, "implied")
        yield _pair(f"{path}.damping_ratio", "damping over that of which nothing rings", _RATIO, "optional")


def _pair(path: str, text: str, fields: tuple[Field, ...], need: str) -> Keys:
    return Keys(path, text, fields, need, scalar_factors=(1, 1), role=CHOICE)


def mounts_of(values: Mapping, outline: Outline) -> tuple[Mount, ...]:
    """Return the housings of a case."""
    mounts = []
    for joint in outline.mounts:
        path = f"mounts.{joint}"
        mass, stiffness = values[f"{path}.mass"], pair_at(values, f"{path}.stiffness")
        damping: tuple[float, ...] = pair_at(values, f"{path}.damping")
        if f"{path}.damping_ratio.0" in values:
            ratios = pair_at(values, f"{path}.damping_ratio")
            damping = tuple(2.0 * ratio * math.sqrt(k * mass) for ratio, k in zip(ratios, stiffness, strict=True))
        mounts.append(Mount(joint, mass, stiffness, damping))
    return tuple(mounts)


# ---------------------------------------------------------------------------------------------- vibration


_VIBRATION = "vibration"
_ORDERS = Field(
    "orders",
    "1",
    "number of orders of the crank speed whose forces on the frame are columns; default: none",
    1,
    MAX_ORDERS,
    low_open=False,
    high_open=False,
    optional=True,
    integer=True,
)
_BAND = tuple(
    Field(str(k), "rad/s", f"{end} frequency of the band", default=2.0 * math.pi * frequency)
    for k, (end, frequency) in enumerate((("lowest", 10.0), ("highest", 1000.0)))
)
_ZONES = tuple(Field(str(k), "m/s", f"largest velocity (rms) in zone {zone}") for k, zone in enumerate("ABC"))
_ABOUT = along_axes("m", "{} coordinate in the fixed frame")
POSITION = along_axes("m", "{} coordinate in the frame of the body")
_FRAME_MASS = Field("mass", "kg", "mass of the frame; without it the frame does not move", optional=True, role=CHOICE)
_FRAME_STIFFNESS = along_axes("N/m", "stiffness of the mount along {}", "[0, inf)")
_FRAME_DAMPING = ranged("damping", "1", "damping ratio of frame and mount", "[0, inf)", default=0.0)


def vibration_keys(outline: Outline, bodies: Iterable[str]) -> tuple[Keys, ...]:
    """Return the sections of `vibration` for a mechanism of these `bodies`."""
    moving_bodies = tuple(name for name in bodies if name != GROUND)
    severity = Choice(
        "severity",
        tuple(SEVERITIES),
        "standard, group and support that the zones A to D are those of; or write `zones`",
        NO_SEVERITY,
    )
    sections = [
        Keys(
            _VIBRATION,
            "force and moment on the frame, and the vibration of places. Without this section, none is computed",
            (_ORDERS,),
            "optional",
            (severity,),
            role=NUMERICS,
        ),
        Keys(f"{_VIBRATION}.band", "band of frequencies of the velocities", _BAND, "implied", role=CONDITION),
        Keys(f"{_VIBRATION}.zones", "upper bounds of the zones A, B and C", _ZONES, "optional", role=CONDITION),
        Keys(f"{_VIBRATION}.at", "places whose vibration is observed, by name", need="implied"),
    ]
    if outline.vibration is None:
        return tuple(sections)
    for place in outline.vibration.places:
        sections += _frame_keys() if place.name == FRAME else _place_keys(place, moving_bodies)
    return tuple(sections)


def _frame_keys() -> tuple[Keys, ...]:
    path = f"{_VIBRATION}.at.{FRAME}"
    text = "the frame of the machine, as one mass on its mount"
    return (
        Keys(path, text, (_FRAME_MASS,), "optional", role=CHOICE),
        Keys(f"{path}.about", "point of the moment; default: the crank's pivot", _ABOUT, "optional", role=CHOICE),
        Keys(f"{path}.mount", "mount of the frame", (_FRAME_DAMPING,), "optional", role=CHOICE),
        Keys(f"{path}.mount.stiffness", "stiffness along x and y", _FRAME_STIFFNESS, role=CHOICE),
    )


def _place_keys(place: PlaceOutline, bodies: tuple[str, ...]) -> tuple[Keys, ...]:
    path = f"{_VIBRATION}.at.{place.name}"
    body_key = Choice("body", bodies, "body of the place", place.name if place.name in bodies else None)
    text = f"place on the body; default: the pin of a slider, else its {CENTER_TEXT}"
    return (
        Keys(path, "a place", need="optional", words=(body_key,)),
        Keys(f"{path}.point", text, POSITION, "optional", role=CHOICE),
    )


def point_of(place: Location, body: Body) -> tuple[float, float]:
    """Return the point (m) of a place in the frame of its body; the pin of a slider is its centre of mass."""
    return place.point or body.center


def axes_of(place: Location, mechanism: Mechanism) -> int:
    """Return in how many directions a place of a mechanism is observed: along x and y, of its output only along x."""
    return 1 if is_along_output(mechanism, PlaceOutline(place.name, body=place.body, is_whole=not place.point)) else 2


def unreacted_loads(case: Case, machine: Machine) -> tuple[int, ...]:
    """Return the numbers of the loads of a case's machine that its frame does not react, weights along x among them."""
    named = [i for i, load in enumerate(case.loads) if load.values.get("reacted") is False]
    return (*named, *range(len(case.loads), len(machine.loads)))
