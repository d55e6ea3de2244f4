"""The slider-crank with bodies that move in space: its keys and its machine."""

from collections.abc import Mapping

from ...contracts.case import Case
from ...contracts.catalogue import CHOICE, Choice, Field, JointSite, Keys, Mechanism, Outline
from ...contracts.machine import Aim, BodyPoint, Constant, Guide, Machine, Pin
from . import described
from .spatial import described as space
from .spatial.build import Assembly, Solid
from .spatial.spanning_tree import CYLINDRICAL, REVOLUTE, SPHERICAL

PINS = ("crank-rod", "rod-slider")
_LENGTH = Field("length", "m", "distance between the two pins of the body")
_IDEAL = (
    "motion that a pin without clearance allows; spherical: all rotations; cylindrical: rotation about the pin and "
    "sliding along it; revolute: rotation about the pin"
)


def _center() -> tuple[Field, ...]:
    along_rod, *other_axes = space.along_axes("m", "centre of mass from the first pin")
    return along_rod._replace(default=None, optional=True), *other_axes


def _keys(outline: Outline) -> tuple[Keys, ...]:
    mass = Field("mass", "kg", "mass of the body")
    inertia_text = "principal moments of inertia about the centre of mass, along the axes of the body frame"
    pin_choices = tuple(
        Choice(name, (SPHERICAL, CYLINDRICAL, REVOLUTE), "type of this pin without clearance", REVOLUTE)
        for name in PINS
        if name not in outline.clearances
    )
    center_text = (
        "position of the centre of mass relative to the first pin; a single quantity is a distance along the line of "
        "the pins; default: half the length"
    )
    inertia = space.along_axes("kg*m^2", "inertia", 0.0, None)
    return (
        Keys("mechanism.crank", "the crank", (_LENGTH, mass._replace(low_open=False)), role=CHOICE),
        Keys("mechanism.crank.inertia", inertia_text, inertia, scalar_factors=(1, 1, 1), role=CHOICE),
        Keys("mechanism.crank.center", center_text, _center(), "implied", scalar_factors=(1, 0, 0), role=CHOICE),
        Keys("mechanism.rod", "the rod", (_LENGTH, mass), role=CHOICE),
        Keys(
            "mechanism.rod.inertia",
            inertia_text,
            tuple(field._replace(low_open=True) for field in inertia),
            role=CHOICE,
        ),
        Keys("mechanism.rod.center", center_text, _center(), "implied", scalar_factors=(1, 0, 0), role=CHOICE),
        Keys("mechanism.slider", "the slider", (mass,), role=CHOICE),
        Keys("mechanism", "", flags=(space.SPATIAL_FLAG,)),
        space.gravity_keys(),
        Keys("mechanism.ideal", _IDEAL, words=pin_choices, need="implied"),
        space.speed_keys(),
    )


def mechanism(outline: Outline, planar_mechanism: Mechanism) -> Mechanism:
    """Return the spatial form of the slider-crank `planar_mechanism`."""
    assert planar_mechanism.output is not None  # the slider
    return planar_mechanism._replace(
        joints=(
            JointSite(PINS[0], "crank", "rod", space.site_kind_of(outline, PINS[0])),
            JointSite(PINS[1], "rod", "slider", space.site_kind_of(outline, PINS[1]), journal="rod"),
        ),
        keys=_keys(outline),
        channels=(
            *described.channels_of(("crank",), planar_mechanism.output, ("place", "v", "a"))[:5],
            *space.body_channels(("crank", "rod", "slider")),
        ),
        build=space.MechanismBuilder(_assembly, outline),
        machine=space.planar_machine_of(_assembly),
        refusal=refusal,
        spatial=True,
    )


def _assembly(outline: Outline, values: Mapping, speed: float) -> Assembly:
    """Return the spatial machine of a case."""
    no_vector = (0.0, 0.0, 0.0)
    solids = {
        "ground": Solid(0.0, no_vector, no_vector, {"pivot": no_vector}),
        **{name: _link(values, name) for name in ("crank", "rod")},
        "slider": Solid(values["slider.mass"], no_vector, no_vector, {"pin": no_vector}),
    }
    joints = (
        Pin("ground-crank", BodyPoint("ground", "pivot"), BodyPoint("crank", "near")),
        Pin("crank-rod", BodyPoint("crank", "far"), BodyPoint("rod", "near")),
        Pin("rod-slider", BodyPoint("rod", "far"), BodyPoint("slider", "pin")),
        Guide("slider-ground", BodyPoint("ground", "pivot"), BodyPoint("slider", "pin"), 0.0),
    )
    gravity, aim = space.vector_at(values, "gravity"), Aim("slider", "pin", 0.0)
    bodies, loads = space.planar_bodies_and_loads(solids, gravity)
    machine = Machine(bodies, joints, "ground-crank", Constant(speed), -gravity[1], aim, {}, loads)
    ideal = {name: values[f"ideal.{name}"] for name in PINS if f"ideal.{name}" in values}
    return Assembly(machine, solids, ideal, gravity, dict.fromkeys(PINS, "rod"))


def _link(values: Mapping, name: str) -> Solid:
    points = {"near": (0.0, 0.0, 0.0), "far": (values[f"{name}.length"], 0.0, 0.0)}
    return Solid(
        values[f"{name}.mass"],
        space.vector_at(values, f"{name}.inertia"),
        space.vector_at(values, f"{name}.center"),
        points,
    )


def refusal(mechanism: Mechanism, case: Case) -> tuple[str, str] | None:
    """Return the path below `mechanism` at fault, and a sentence, if a case's rod is impossible or cannot tilt."""
    for name in PINS:
        if case.mechanism.values.get(f"ideal.{name}") == REVOLUTE:
            return "ideal", (
                f"{name} is a revolute joint, as ground-crank is; two revolute joints forbid the rod every tilt and "
                f"shift, so that it moves as in the plane; write ideal: {{{name}: spherical}} or cylindrical, or leave "
                "`spatial` out"
            )
    return space.refusal(mechanism, case)
