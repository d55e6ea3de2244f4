"""Keys and records of the loads on the bodies of a mechanism."""

import math
from collections.abc import Mapping

import numpy as np

from ...contracts import case, machine
from ...contracts.catalogue import (
    ANY,
    CHOICE,
    CONDITION,
    GROUND,
    SIZES,
    Choice,
    Columns,
    Field,
    Keys,
    LoadOutline,
    declared_law,
    ranged,
)
from ..laws.contract import compile_law

CENTER = "center"  # the name of a body's centre of mass as a point
CENTER_TEXT = "centre of mass"


def along_axes(unit: str, text: str, interval: str = "(-inf, inf)", **further) -> tuple[Field, ...]:
    """Return the items of a list of two, along x and y; text : with {} in place of the axis."""
    return tuple(ranged(str(k), unit, text.format(axis), interval, **further) for k, axis in enumerate("xy"))


_FORCE = along_axes("N", "force along {} of the fixed frame")
_TORQUE = ranged("torque", "N*m", "torque on the body, counter-clockwise", "(-inf, inf)", optional=True, role=CONDITION)
_SCALE = ranged(
    "scale", "1", "factor on all forces and torques of the table", "(-inf, inf)", default=1.0, role=CONDITION
)
_TABLE = Columns(
    "table",
    "force and torque as functions of the crank angle or of time; a table over the crank angle repeats with the period "
    "of its span; a table over time is constant outside its span; monotone cubics (PCHIP) interpolate between the rows",
    (ranged("crank_angle", "rad", "crank angle", "(-inf, inf)"), ranged("time", "s", "time", "(-inf, inf)")),
    (
        ranged("fx", "N", "force along x", "(-inf, inf)"),
        ranged("fy", "N", "force along y", "(-inf, inf)"),
        ranged("torque", "N*m", "torque on the body", "(-inf, inf)"),
        ranged("pressure", "Pa", "pressure on a piston of diameter `bore`", "(-inf, inf)"),
    ),
)
_PISTON = (
    Field("bore", "m", "diameter of the piston on which the `pressure` of the table acts", optional=True, role=CHOICE),
    ranged(
        "ambient",
        "Pa",
        "pressure behind the piston; left out: the table has the difference of both",
        "[0, inf)",
        optional=True,
        role=CONDITION,
    ),
    ranged(
        "direction",
        "rad",
        "direction of the force of a pressure above `ambient`; left out: along -x, towards a crank at the origin",
        "(-inf, inf)",
        optional=True,
        role=CHOICE,
    ),
)
_REACTED = (
    "reacted",
    "whether the frame reacts the load, as a cylinder does the pressure of its gas; false adds it to the force on the "
    "frame, see `vibration`",
)
_ANCHOR = along_axes("m", "{} coordinate of the anchor in the frame of the first body")
_SPRING = (
    ranged("stiffness", "N/m", "stiffness of the spring", "[0, inf)"),
    ranged("free_length", "m", "length of the spring without force", "[0, inf)", default=0.0),
    ranged("damping", "N*s/m", "coefficient of the damper parallel to the spring", "[0, inf)", default=0.0),
)
_TORSION = (
    ranged("torsional_stiffness", "N*m/rad", "torque per angle of the spring", "[0, inf)", default=0.0),
    ranged("torsional_damping", "N*m*s/rad", "torque per rate of the parallel damper", "[0, inf)", default=0.0),
    ranged(
        "free_angle",
        "rad",
        "angle of the second body minus that of the first at which the spring has no torque",
        "(-inf, inf)",
        default=0.0,
    ),
)
_RADIUS = Field("radius", "m", "radius of the pin; a guide does not use it", optional=True)
LOADS = {
    law.name: law
    for law in (
        declared_law(
            "load force: a force of fixed direction and a torque, constant",
            "force: [fx, fy], torque",
            "",
            (*(field._replace(name=f"force.{field.name}", optional=True) for field in _FORCE), _TORQUE),
            notes="Written on: BODY; `point` says where (planar), by default a slider's pin, else the centre of mass.",
        ),
        declared_law(
            "load table: forces and a torque that depend on the crank angle or on time, such as an indicator diagram",
            "scale x table, PCHIP between rows; over the angle periodic in the table's span",
            "Fritsch & Butland 1984, SIAM J. Sci. Stat. Comput. 5:300",
            (_SCALE, *_PISTON),
            notes="Written on: BODY, table: gas.csv with the columns `crank_angle [deg]` or `time [s]`, and any of "
            "`fx [N]`, `fy [N]`, `torque [N*m]`; or `pressure [bar]` with `bore: 60 mm` and `ambient: 1 bar`.",
        ),
        declared_law(
            "load spring: a spring and damper from a point of one body to a point of another",
            "force = stiffness (l - free_length) + damping dl/dt along the line from anchor to point",
            "",
            (*(field._replace(name=f"anchor.{field.name}") for field in _ANCHOR), *_SPRING),
            notes="Written between: [BODY, BODY], anchor: [x, y] on the first.  It acts on the second body at `point` "
            "(planar), by default at a slider's pin, of any other body at the centre of mass.",
        ),
        declared_law(
            "load torsion: a torsion spring and damper between the angles of two bodies",
            "torque = torsional_stiffness (twist - free_angle) + torsional_damping d(twist)/dt",
            "",
            _TORSION,
            notes="Written between: [BODY, BODY], torsional_stiffness: 5 N*m/rad.  The twist is the angle of the "
            "second body minus that of the first.",
        ),
        declared_law(
            "load friction: friction in a joint without clearance",
            "in a pin the torque |reaction| x radius x sin(atan(coefficient)), in a guide the force "
            "coefficient x |reaction|; or a given `torque` or `force`",
            "",
            (_RADIUS,),
            notes="Written on: JOINT, friction: {law, ..., radius}; any friction law.  A blade, a "
            "seal or a brake has friction of a given size.  In a pin write {law, torque: 3 N*m, ...}, speeds in "
            "rad/s; in a guide {law, force: 20 N, ...}.  A law with two coefficients also takes static_torque or "
            "static_force.",
        ),
    )
}


def load_keys(load: LoadOutline, points: Mapping[str, tuple[str, ...]], joints: tuple[str, ...]) -> tuple[Keys, ...]:
    """Return the sections of a load.

    points : points of each body by name, or () if none can be chosen; joints : their names
    """
    path, bodies = f"loads.{load.name}", tuple(name for name in points if name != GROUND)
    body_points = tuple(points.get(load.on, ()))
    point_key = (
        Choice(
            "point",
            tuple(dict.fromkeys((*body_points, CENTER))),
            f"point of the body at which the load acts; {CENTER}: the {CENTER_TEXT}",
            CENTER,
        ),
    )
    body_key = Choice("on", bodies, "body on which the load acts; with `friction`: the joint")
    target_keys = (body_key, *(point_key if body_points else ()))
    force = Keys(f"{path}.force", "force along x and y of the fixed frame", _FORCE, "optional", role=CONDITION)
    table = Keys(path, LOADS["table"].summary, (_SCALE, *_PISTON), "optional", target_keys, (_TABLE,), role=CONDITION)
    body_keys = tuple(Choice(str(k), tuple(points), f"the {label} body") for k, label in enumerate(("first", "second")))
    second_point_text = (
        f"at `point`, by default the {CENTER_TEXT}"
        if body_points
        else f"at its pin if that body is a slider, otherwise at its {CENTER_TEXT}"
    )
    between = Keys(
        f"{path}.between",
        f"the two bodies that the spring connects; it acts on the first at `anchor`, on the second {second_point_text}",
        words=body_keys,
    )
    anchor = Keys(
        f"{path}.anchor",
        "point of the first body at which the spring acts, in the frame of that body",
        _ANCHOR,
        role=CHOICE,
    )
    joint_load_keys = Keys(path, LOADS["friction"].summary, (), "optional", (body_key._replace(options=joints),))
    reacted = (_REACTED if load.reacted else (*_REACTED, False),)  # what is written false is part of the case
    table = table._replace(flags=reacted)
    spring_point = point_key if body_points else ()
    by_form = {
        "force": (
            Keys(path, LOADS["force"].summary, (_TORQUE,), "optional", target_keys, flags=reacted, role=CONDITION),
            force,
        ),
        "table": (table,),
        "spring": (
            Keys(path, LOADS["spring"].summary, _SPRING, "optional", spring_point, flags=reacted, role=CHOICE),
            between,
            anchor,
        ),
        "torsion": (
            Keys(path, LOADS["torsion"].summary, _TORSION, "optional", flags=reacted, role=CHOICE),
            between._replace(text="the two bodies that the torsion spring connects"),
        ),
        "friction": (joint_load_keys, _friction_keys(path)[load.given]),
        "own": (
            Keys(
                path, "a load of one's own", (), "optional", target_keys, family="load", flags=reacted, role=CONDITION
            ),
        ),
    }
    if load.form != ANY:
        return by_form[load.form]
    any_form_keys = Keys(
        path,
        "a load on the mechanism",
        (_TORQUE, _SCALE, *_PISTON, *_SPRING, *_TORSION),
        "optional",
        target_keys,
        (_TABLE,),
        flags=reacted,
        role=CHOICE,
    )
    optional_keys = (between, anchor, *_friction_keys(path).values())
    return any_form_keys, force, *(key._replace(need="optional") for key in optional_keys)


def _friction_keys(path: str) -> dict[str, Keys]:
    """Return the section `friction` of the load at `path`: '' for a coefficient, or the size that is given."""
    text = "friction in the joint on which the load acts"
    keys = {"": Keys(f"{path}.friction", text, (_RADIUS,), family="friction", role=CONDITION)}
    return keys | {
        size: Keys(
            f"{path}.friction", f"friction of a given {size}", family="friction", given_size_key=size, role=CONDITION
        )
        for size in SIZES
    }


class LoadPoints:
    """Points at which loads act on the bodies of a machine; loads add points as needed."""

    def __init__(self, bodies: dict[str, machine.Body], pins: Mapping[str, str]):
        """Prepare for `bodies`; pins : body -> its default point for loads, otherwise the centre of mass."""
        self.bodies, self.pins = bodies, pins

    def point_of_load(self, body: str, values: Mapping) -> machine.BodyPoint:
        """Return the point of a body at which a load with these values acts."""
        name = values.get("point", self.pins.get(body, CENTER))
        if name not in self.bodies[body].points:
            return self.add_point(body, name, self.bodies[body].center)
        return machine.BodyPoint(body, name)

    def centre_of(self, body: str) -> machine.BodyPoint:
        """Return the centre of mass of a body, or the origin of the ground, as one of its points."""
        return self.add_point(body, CENTER, (0.0, 0.0) if body == GROUND else self.bodies[body].center)

    def add_point(self, body: str, name: str, position: tuple[float, float]) -> machine.BodyPoint:
        """Return a further point of a body, at `position` (m) in its frame."""
        old_body = self.bodies[body]
        self.bodies[body] = old_body._replace(points={**old_body.points, name: position})
        return machine.BodyPoint(body, name)


def make_loads(loads: tuple[case.Load, ...], load_points: LoadPoints) -> tuple:
    """Return the loads as described in a machine."""
    return tuple(_MAKERS[load.form](load, load_points) for load in loads)


def _make_push(load: case.Load, load_points: LoadPoints) -> machine.Push:
    values = load.values
    force = (values.get("force.0", 0.0), values.get("force.1", 0.0))
    return machine.Push(load.name, load_points.point_of_load(values["on"], values), *force, values.get("torque", 0.0))


def _make_tabled_push(load: case.Load, load_points: LoadPoints) -> machine.TabledPush:
    table = {name: np.array(column) for name, column in load.table.items()}
    table_variable = "angle" if "crank_angle" in table else "time"
    knots = table["crank_angle" if table_variable == "angle" else "time"]
    columns = [table.get(name, np.zeros(knots.size)) for name in ("fx", "fy", "torque")]
    if "pressure" in table:
        force = 0.25 * math.pi * load.values["bore"] ** 2 * (table["pressure"] - load.values.get("ambient", 0.0))
        direction = load.values.get("direction")
        cosine, sine = (-1.0, 0.0) if direction is None else (math.cos(direction), math.sin(direction))
        columns[:2] = [cosine * force, sine * force]
    endpoint = load_points.point_of_load(load.values["on"], load.values)
    return machine.TabledPush(load.name, endpoint, table_variable, knots, *columns, load.values["scale"])


def _make_own(load: case.Load, load_points: LoadPoints) -> machine.OwnPush:
    endpoint = load_points.point_of_load(load.values["on"], load.values)
    return machine.OwnPush(load.name, endpoint, compile_law("load", load.values["law"], load))


def _make_spring(load: case.Load, load_points: LoadPoints) -> machine.Spring:
    values = load.values
    anchor_point = load_points.add_point(
        values["between.0"], f"anchor of {load.name}", (values["anchor.0"], values["anchor.1"])
    )
    second = load_points.point_of_load(values["between.1"], values)
    return machine.Spring(
        load.name, anchor_point, second, values["stiffness"], values["free_length"], values["damping"]
    )


def _make_torsion_spring(load: case.Load, load_points: LoadPoints) -> machine.TorsionSpring:
    values = load.values
    first, second = (load_points.centre_of(values[f"between.{k}"]) for k in range(2))
    sizes = (values[field.name] for field in (_TORSION[0], _TORSION[2], _TORSION[1]))
    return machine.TorsionSpring(load.name, first, second, *sizes)


def _make_rubbing(load: case.Load, load_points: LoadPoints) -> machine.Rubbing | machine.Braking:
    given_size = next((size for size in SIZES if size in load.friction.values), "")
    if given_size:
        names = {given_size: "coefficient", f"static_{given_size}": "static_coefficient"}
        values = {names.get(key, key): value for key, value in load.friction.values.items()}
        friction_law = compile_law(
            "friction", load.friction.law, load._replace(friction=load.friction._replace(values=values))
        )
        return machine.Braking(load.name, load.values["on"], friction_law)
    friction_law = compile_law("friction", load.friction.law, load)
    return machine.Rubbing(load.name, load.values["on"], friction_law, load.friction.values.get("radius", 0.0))


def _make_preload(load: case.Load, load_points: LoadPoints) -> machine.Braking:
    friction_law = compile_law("friction", load.friction.law, load)
    return machine.Braking(load.name, load.values["on"], friction_law, load.values["radius"], load.values["preload"])


_MAKERS = {
    "preload": _make_preload,
    "force": _make_push,
    "own": _make_own,
    "table": _make_tabled_push,
    "spring": _make_spring,
    "torsion": _make_torsion_spring,
    "friction": _make_rubbing,
}
