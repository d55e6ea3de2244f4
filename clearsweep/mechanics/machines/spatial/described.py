"""Shared parts of spatial mechanisms: keys, channels, and the underlying planar machine."""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from ....contracts.case import Case
from ....contracts.catalogue import ANY, CONDITION, Channel, Field, JointOutline, JointSite, Keys, Mechanism, Outline
from ....contracts.machine import GROUND, Body, BodyPoint, Push
from .. import described
from ..contract import Built
from .build import Assembly, Solid, build
from .spanning_tree import SpanningTreeError, spanning_tree

AXES = ("x", "y", "z")
_CENTRE = "its centre of mass"  # a point of every body, besides user-defined points

#: The key that makes a mechanism spatial.
SPATIAL_FLAG = ("spatial", "whether the bodies move in space, connected by spatial joints")
#: The time histories of every moving body.
BODY = (
    *((axis, "m", f"{{}}'s centre of mass, {axis}") for axis in AXES),
    *((f"v{axis}", "m/s", f"velocity of the {{}}'s centre of mass, {axis}") for axis in AXES),
    *((f"q{k}", "1", f"quaternion from the {{}}'s frame to the fixed one, {k}") for k in "wxyz"),
    *((f"w{axis}", "rad/s", f"angular velocity of the {{}} in the fixed frame, {axis}") for axis in AXES),
)


def along_axes(unit: str, text: str, low: float = -math.inf, default: float | None = 0.0) -> tuple[Field, ...]:
    """Return the items of a list along the axes of a frame."""
    return tuple(
        Field(str(k), unit, f"{text}, {axis}", low, low_open=low < 0.0, default=default) for k, axis in enumerate(AXES)
    )


def gravity_keys() -> Keys:
    """Return the section of gravity."""
    text = "acceleration of gravity; a single quantity acts along -y"
    return Keys(
        "mechanism.gravity", text, along_axes("m/s^2", "gravity"), "implied", scalar_factors=(0, -1, 0), role=CONDITION
    )


def speed_keys() -> Keys:
    """Return the section of the drive."""
    return Keys("drive", "the drive", (Field("speed", "rad/s", "constant crank speed"),), "implied", role=CONDITION)


def site_kind_of(outline: Outline, joint: str) -> str:
    """Return the kind of a joint's site."""
    return "spatial" if {joint, ANY} & outline.axial else "through"


def site_of(outline: Outline, joint: JointOutline) -> JointSite:
    """Return the site of a joint that a grid describes."""
    return JointSite(joint.name, *joint.bodies, site_kind_of(outline, joint.name), joint.journal)


def body_channels(bodies: tuple[str, ...]) -> tuple[Channel, ...]:
    """Return the time histories of moving bodies, by their names in channels."""
    return tuple(Channel(f"{body}/{name}", unit, text.format(body)) for body in bodies for name, unit, text in BODY)


def planar_bodies_and_loads(
    solids: Mapping[str, Solid], gravity: tuple[float, ...]
) -> tuple[dict[str, Body], tuple[Push, ...]]:
    """Return the planar bodies, and the loads from gravity along x."""
    bodies, loads = {}, []
    for name, solid in solids.items():
        center = solid.center[:2]
        points = {point: position[:2] for point, position in solid.points.items()} | {_CENTRE: center}
        bodies[name] = Body(solid.mass, solid.inertia[2], center, points)
        if name != GROUND and gravity[0] != 0.0:
            loads.append(Push(name, BodyPoint(name, _CENTRE), solid.mass * gravity[0], 0.0, 0.0))
    return bodies, tuple(loads)


def vector_at(values: Mapping, path: str) -> tuple[float, ...]:
    """Return the numbers of a list."""
    return tuple(values[f"{path}.{k}"] for k in range(3))


class MechanismBuilder(NamedTuple):
    """Builds a case's mechanism from its Assembly."""

    assembly: Callable[[Outline, Mapping, float], Assembly]  # of the numbers and words by key, drive : rad/s
    outline: Outline

    def __call__(self, bodies: Mapping, drive: float, joints: Mapping, offsets: Mapping) -> Built:
        """Return the mechanism at crank angle 0; joints : compiled; offsets : unused, spatial joints start centred."""
        return build(self.assembly(self.outline, bodies, drive), joints)


def planar_machine_of(assembly: Callable[[Outline, Mapping, float], Assembly]) -> Callable:
    """Return a function that gives the planar machine of a case, for pictures and comparisons."""

    def machine(case: Case):
        speed = case.drive.speed if case.drive else 0.0
        return assembly(case.outline, case.mechanism.values, speed).machine

    return machine


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if bodies are impossible or cannot be attached."""
    assert isinstance(mechanism.build, MechanismBuilder)  # spatial mechanisms are built in this way
    assembly = mechanism.build.assembly(case.outline, case.mechanism.values, case.drive.speed if case.drive else 0.0)
    for body, solid in assembly.solids.items():
        largest, sum_of_others = max(solid.inertia), sum(solid.inertia) - max(solid.inertia)
        if largest > sum_of_others * (1.0 + 1e-12):
            path = f"bodies.{body}.inertia" if case.outline.bodies else f"{body}.inertia"
            return path, (
                f"found {', '.join(f'{moment:.6g}' for moment in solid.inertia)} kg*m^2; no body has a principal "
                f"moment ({largest:.6g}) above the sum of the two others ({sum_of_others:.6g}): correct the largest one"
            )
    unsound = described.refusal(mechanism, case)
    if unsound:
        return unsound
    try:
        spanning_tree(assembly.machine, [joint.name for joint in case.joints], assembly.ideal)
    except SpanningTreeError as error:
        return f"joints.{error.joint}", str(error)
    return None
