"""The mechanism of any topology with bodies that move in space: its keys and its machine."""

from collections.abc import Mapping

from ...contracts.case import Case
from ...contracts.catalogue import CHOICE, GROUND, Choice, Field, Keys, Mechanism, Outline, Output
from ...contracts.machine import Aim, Constant, Machine
from . import described
from .named import joint_keys, joint_of, output_keys
from .spatial import described as space
from .spatial.build import Assembly, Solid
from .spatial.spanning_tree import CYLINDRICAL, REVOLUTE, SPHERICAL


def _keys(outline: Outline) -> tuple[Keys, ...]:
    pins = tuple(joint.name for joint in outline.joints if joint.type != "prismatic")
    endpoints = tuple(f"{body.name}.{point}" for body in outline.bodies for point in body.points)
    pin_choices = tuple(
        Choice(name, (SPHERICAL, CYLINDRICAL, REVOLUTE), "type of this pin without clearance", REVOLUTE)
        for name in pins
        if name not in outline.clearances
    )
    driven = Choice("driven", pins, "the revolute joint that the drive turns; it connects the ground and the crank")
    keys = [
        Keys("mechanism", "", words=(driven,), flags=(space.SPATIAL_FLAG,)),
        space.gravity_keys(),
        Keys("mechanism.bodies", "the bodies by name, `ground` among them; their frames are as in the plane"),
    ]
    for body in outline.bodies:
        path, is_fixed = f"mechanism.bodies.{body.name}", body.name == GROUND
        mass = Field("mass", "kg", "mass of the body")
        keys.append(
            Keys(
                path,
                "the fixed body" if is_fixed else "a body of the mechanism",
                () if is_fixed else (mass,),
                role=CHOICE,
            )
        )
        if not is_fixed:
            inertia_text = "principal moments of inertia about the centre of mass, along the axes of the body frame"
            keys += [
                Keys(f"{path}.inertia", inertia_text, space.along_axes("kg*m^2", "inertia", 0.0, None), role=CHOICE),
                Keys(
                    f"{path}.center",
                    "centre of mass in the frame of the body",
                    space.along_axes("m", "of its frame"),
                    "implied",
                    role=CHOICE,
                ),
            ]
        keys.append(Keys(f"{path}.points", "points of the body, by name", need="implied"))
        keys += [
            Keys(
                f"{path}.points.{point}",
                "position of the point in the frame of its body; z is along the pins",
                space.along_axes("m", "of the body's frame", default=None),
                role=CHOICE,
            )
            for point in body.points
        ]
    keys.append(Keys("mechanism.joints", "the joints between the bodies, by name"))
    for joint in outline.joints:
        keys += joint_keys(joint, endpoints)
    text = (
        "motion that a pin without clearance allows; spherical: all rotations; cylindrical: rotation about the pin and "
        "sliding along it; revolute: rotation about the pin"
    )
    keys.append(Keys("mechanism.ideal", text, words=pin_choices, need="implied"))
    keys += output_keys(outline)
    keys.append(space.speed_keys())
    return tuple(keys)


def mechanism(outline: Outline, planar_mechanism: Mechanism) -> Mechanism:
    """Return the spatial form of the planar mechanism `planar_mechanism` in a grid."""
    output = Output("output", "rad" if outline.rotary else "m")
    moving_names = tuple(described.column_name(body.name) for body in outline.bodies if body.name != GROUND)
    output_channels = described.channels_of((), output, ("place", "rate", "acceleration"))
    torque = "crank/torque" if "crank" in moving_names else "drive/torque"
    return planar_mechanism._replace(
        bodies=tuple(body.name for body in outline.bodies),
        joints=tuple(space.site_of(outline, joint) for joint in outline.joints if joint.type != "prismatic"),
        keys=_keys(outline),
        channels=(
            *(channel._replace(name=torque) if "torque" in channel.name else channel for channel in output_channels),
            *space.body_channels(moving_names),
        ),
        output=output,
        build=space.MechanismBuilder(_assembly, outline),
        machine=space.planar_machine_of(_assembly),
        refusal=refusal,
        spatial=True,
    )


# ---------------------------------------------------------------------------------------------- a case


def _assembly(outline: Outline, values: Mapping, speed: float) -> Assembly:
    """Return the spatial machine of a case."""
    solids, no_vector = {}, (0.0, 0.0, 0.0)
    for body in outline.bodies:
        prefix = f"bodies.{body.name}"
        points = {point: space.vector_at(values, f"{prefix}.points.{point}") for point in body.points}
        inertial = (0.0, no_vector, no_vector)
        if body.name != GROUND:
            inertial = (
                values[f"{prefix}.mass"],
                space.vector_at(values, f"{prefix}.inertia"),
                space.vector_at(values, f"{prefix}.center"),
            )
        solids[body.name] = Solid(*inertial, points)
    joints = tuple(joint_of(values, joint) for joint in outline.joints)
    start = {key.removeprefix("start."): angle for key, angle in values.items() if key.startswith("start.")}
    aim = Aim(values["output.body"], values.get("output.point", ""), values.get("output.along", 0.0))
    gravity = space.vector_at(values, "gravity")
    bodies, loads = space.planar_bodies_and_loads(solids, gravity)
    machine = Machine(bodies, joints, values["driven"], Constant(speed), -gravity[1], aim, start, loads)
    journals = {joint.name: joint.journal or joint.bodies[1] for joint in outline.joints}
    return Assembly(machine, solids, _freedom_of_pins(outline, values), gravity, journals)


def _freedom_of_pins(outline: Outline, values: Mapping) -> dict[str, str]:
    """Return the freedom of the pins without clearance."""
    return {joint.name: values[f"ideal.{joint.name}"] for joint in outline.joints if f"ideal.{joint.name}" in values}


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if a case's machine is impossible in space."""
    driven, freedom = case.mechanism.values["driven"], _freedom_of_pins(case.outline, case.mechanism.values)
    if freedom.get(driven, REVOLUTE) != REVOLUTE:
        return f"ideal.{driven}", f"is {freedom[driven]}, but the drive turns a revolute joint; leave it out"
    return space.refusal(mechanism, case)
