"""Keys and records of joints with play in rotation: gears, couplings, and end stops."""

import math
from collections.abc import Iterable, Mapping

from ...contracts.case import STOPS_SUFFIX
from ...contracts.catalogue import CHOICE, GROUND, Choice, Field, JointOutline, Keys, ranged
from ...contracts.machine import BodyPoint, Guide, Mesh, Pin, Stops
from ...language.errors import InputError
from .loads import LoadPoints

GEAR, COUPLING = "gear", "coupling"
FLANKED = (GEAR, COUPLING)  # types of joints whose play lies between two flanks
WHOLE_TEETH = 1e-9  # of a number of teeth, by which it may differ from a whole one
DISTANCE_TOLERANCE = 1e-6  # of the centre distance, by which it may differ from that of the pitch circles
GEAR_FIELDS = (
    ranged(
        "ratio",
        "1",
        "pitch radius of the second wheel over that of the first; above 0 if both have outer teeth, below 0 if one has "
        "inner teeth; not 0",
        "(-inf, inf)",
    ),
    Field("radius", "m", "pitch radius of the first wheel"),
    Field(
        "pressure_angle",
        "rad",
        "angle between the line of action and the tangent of the pitch circles",
        high=math.pi / 4.0,
        low_open=False,
        default=math.radians(20.0),
    ),
)
#: What friction of the teeth needs: where a pair of them carries the force.
TEETH = (
    Field("teeth", "1", "number of teeth of the first wheel, a whole one; friction needs it", optional=True),
    Field(
        "approach",
        "1",
        "share of the base pitch before the pitch point in which a pair of teeth carries the force; the rest is behind",
        0.0,
        1.0,
        low_open=False,
        high_open=False,
        default=0.5,
    ),
)
#: Distance and direction of the centre of each pitch circle from its pin.
ECCENTRICITIES = tuple(
    field
    for wheel in ("first", "second")
    for field in (
        Field(
            f"{wheel}_eccentricity",
            "m",
            f"distance of the centre of the {wheel} pitch circle from the pin of its wheel",
            low_open=False,
            default=0.0,
        ),
        Field(
            f"{wheel}_phase",
            "rad",
            f"direction of the centre of the {wheel} pitch circle from the pin, in the frame of its wheel",
            -math.inf,
            default=0.0,
        ),
    )
)


def flanked_keys(joint: JointOutline, bodies: Iterable[str], type_choice: Choice) -> Iterable[Keys]:
    """Yield the sections of a gear or a coupling between two of the `bodies`."""
    path, is_gear = f"mechanism.joints.{joint.name}", joint.type == GEAR
    text = "two wheels in mesh" if is_gear else "two bodies that turn together"
    yield Keys(
        path, text, (*GEAR_FIELDS, *TEETH, *ECCENTRICITIES) if is_gear else (), words=(type_choice,), role=CHOICE
    )
    ends = tuple(Choice(str(k), tuple(bodies), f"the {label} body") for k, label in enumerate(("first", "second")))
    yield Keys(f"{path}.between", "the two bodies whose angles the joint connects", words=ends)


def mesh_of(values: Mapping, joint: JointOutline, pins: Iterable[Pin], points: LoadPoints) -> Mesh:
    """Return a gear or coupling of a case; raise InputError if its wheels do not fit.

    pins : the pins of the machine; points : its bodies, to which the centres of a coupling are added
    """
    if joint.type == GEAR:
        return _gear_of(values, joint, list(pins), points)
    return Mesh(joint.name, *map(points.centre_of, joint.bodies), GROUND, -1.0)


def stops_of(joint: Pin | Guide) -> Stops:
    """Return the stops of a joint."""
    guide = joint.name if isinstance(joint, Guide) else ""
    return Stops(f"{joint.name}{STOPS_SUFFIX}", joint.proximal, joint.distal, guide)


def _gear_of(values: Mapping, joint: JointOutline, pins: list[Pin], points: LoadPoints) -> Mesh:
    bodies, path = points.bodies, f"mechanism.joints.{joint.name}"
    ratio, radius, angle = (values[f"joints.{joint.name}.{field.name}"] for field in GEAR_FIELDS)
    if ratio in (0.0, -1.0):
        remedy = (
            "write the pitch radius of the second wheel over that of the first, below 0 if one of them has inner teeth"
            if ratio == 0.0
            else "both pitch circles would be the same; write type: coupling"
        )
        raise InputError(f"{path}.ratio: found {ratio:g}; {remedy}")
    wheels = [
        next((pin.name, *ends) for pin in pins for ends in [_ends(pin, body)] if ends[1:] and ends[1].body == carrier)
        for carrier in _carriers(joint, pins)
        for body in joint.bodies
    ]
    if not wheels:
        first, second = joint.bodies
        raise InputError(
            f"{path}.between: {first} and {second} have no pins on one body; wheels in mesh turn about pins of the "
            "same body, such as the ground, or the arm of a planetary gear"
        )
    (first_pin, first_centre, first_seat), (second_pin, second_centre, second_seat) = wheels[:2]
    carrier = first_seat.body
    (x1, y1), (x2, y2) = (bodies[carrier].points[seat.point] for seat in (first_seat, second_seat))
    distance, expected = math.hypot(x2 - x1, y2 - y1), radius * abs(1.0 + ratio)
    if abs(distance - expected) > DISTANCE_TOLERANCE * expected:
        given, needed = (f"{1e3 * length:.7g} mm" for length in (distance, expected))
        raise InputError(
            f"{path}.radius: the pins of both wheels on {carrier} are {given} apart, but pitch circles of this radius "
            f"and ratio touch at {needed}; change radius, ratio or the points of the pins"
        )
    # the side on which the teeth touch: beyond the first centre if the second wheel is a ring, else towards the second
    across, apart = math.cos(angle) * (-1.0 if ratio < -1.0 else 1.0), math.sin(angle) * (1.0 if ratio > 0.0 else -1.0)
    teeth, approach = values.get(f"joints.{joint.name}.teeth", 0.0), values[f"joints.{joint.name}.approach"]
    if teeth:
        _check_teeth(f"{path}.teeth", teeth, ratio, approach, apart / across)
    sizes = [values[f"joints.{joint.name}.{field.name}"] for field in ECCENTRICITIES]
    offsets = tuple((sizes[k] * math.cos(sizes[k + 1]), sizes[k] * math.sin(sizes[k + 1])) for k in (0, 2))
    eccentricities, centres = offsets if any(sizes[::2]) else (), [first_centre, second_centre]
    for k, offset in enumerate(eccentricities):
        x, y = bodies[centres[k].body].points[centres[k].point]
        centres[k] = points.add_point(centres[k].body, f"~{joint.name}", (x + offset[0], y + offset[1]))
    return Mesh(
        joint.name,
        *centres,
        carrier,
        ratio,
        radius * math.cos(angle),
        math.atan2(y2 - y1, x2 - x1),
        (first_pin, second_pin),
        across,
        apart,
        eccentricities=eccentricities,
        teeth=teeth,
        approach=approach,
    )


def _check_teeth(path: str, teeth: float, ratio: float, approach: float, lever: float) -> None:
    """Raise InputError unless both wheels have whole teeth that touch on their involutes.

    lever : that of friction at the pitch point about the first centre, over the base radius of the first wheel, as the
    path of contact: a base pitch with a share `approach` of it before the pitch point.
    """
    second = teeth * abs(ratio)
    if max(abs(count - round(count)) for count in (teeth, second)) > WHOLE_TEETH * second or teeth < 1.0:
        raise InputError(
            f"{path}: found {teeth:g}, with which the second wheel has {second:.6g}; both numbers must be whole, so "
            "change teeth or ratio"
        )
    begin, end = -2.0 * math.pi / teeth * approach, 2.0 * math.pi / teeth * (1.0 - approach)
    if (lever + begin) * (lever + end) <= 0.0 or (lever * ratio - begin) * (lever * ratio - end) <= 0.0:
        raise InputError(
            f"{path}: {teeth:g} and {second:.6g} teeth would touch within a base circle, where there is no involute; "
            "choose more teeth, a larger pressure_angle, or another approach"
        )


def _carriers(joint: JointOutline, pins: list[Pin]) -> list[str]:
    """Return the bodies that both wheels of a gear have a pin on, the ground first."""
    first, second = ({end.body for pin in pins for end in _ends(pin, body)[1:]} for body in joint.bodies)
    return sorted((first & second) - set(joint.bodies), key=lambda body: body != GROUND)


def _ends(pin: Pin, body: str) -> tuple[BodyPoint, ...]:
    """Return the ends of a pin, that on a body first; () if it is not on that body."""
    ends = pin.proximal, pin.distal
    return ends if ends[0].body == body else ends[::-1] if ends[1].body == body else ()
