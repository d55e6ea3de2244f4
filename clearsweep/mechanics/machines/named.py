"""Joints, initial state and output of a mechanism of any topology, planar or spatial, as a grid describes them."""

import math
from collections.abc import Iterable

from ...contracts.catalogue import ANY, CHOICE, GROUND, Choice, Field, JointOutline, Keys, Outline
from ...contracts.machine import BodyPoint, Guide, Pin, Slot

_AXIS = Field(
    "axis",
    "rad",
    "angle of the line of a guide or slot, through the proximal point, in the frame of the proximal body; not for a "
    "pin",
    -math.inf,
    default=0.0,
)
_ALONG = Field("along", "rad", "direction in which the motion of the point is measured", -math.inf, default=0.0)


def joint_keys(joint: JointOutline, endpoints: tuple[str, ...]) -> Iterable[Keys]:
    """Yield the sections of a joint that can connect the points `endpoints`."""
    path = f"mechanism.joints.{joint.name}"
    type_choice = Choice(
        "type",
        ("revolute", "prismatic", "slot"),
        "kind of the joint; revolute: a pin; prismatic: a guide; slot: a pin in a slot of the proximal body",
    )
    bodies = tuple(filter(None, joint.bodies))
    journal = (Choice("journal", bodies, "body that carries the journal", bodies[-1] if bodies else ANY),)
    choices = (type_choice,) if joint.type in ("prismatic", "slot") else (type_choice, *journal)
    yield Keys(
        path, "a joint of the mechanism", () if joint.type == "revolute" else (_AXIS,), words=choices, role=CHOICE
    )
    texts = ("the proximal point, body.point", "the distal point")
    between = tuple(Choice(str(k), endpoints, text) for k, text in enumerate(texts))
    yield Keys(f"{path}.between", "the two points that the joint connects, the proximal point first", words=between)


def output_keys(outline: Outline) -> Iterable[Keys]:
    """Yield the sections of the start and the output."""
    moving_bodies = tuple(body.name for body in outline.bodies if body.name != GROUND)
    start = tuple(
        Field(body, "rad", "initial guess of the angle of this body; default: 0", -math.inf, optional=True)
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
