"""The slider-crank beyond its own equations: with an offset, a start angle, loads, a free crank or an open guide."""

import math

from ....contracts.case import Case
from ....contracts.machine import Aim, At, Body, Guide, Machine, Pin
from ..described import elastic_of
from ..drives import drive_of
from ..loads import Places, loads_of


def machine(case: Case) -> Machine:
    """Return the slider-crank of a case as a machine."""
    values = case.mechanism.values
    radius, length = values["crank.length"], values["rod.length"]
    offset, angle = values.get("slider.offset", 0.0), case.drive.start_angle
    bodies = {
        "ground": Body(0.0, 0.0, (0.0, 0.0), {"pivot": (0.0, 0.0), "line": (0.0, offset)}),
        "crank": _link(values, "crank", radius),
        "rod": _link(values, "rod", length),
        "slider": Body(values["slider.mass"], values.get("slider.inertia", 0.0), (0.0, 0.0), {"pin": (0.0, 0.0)}),
    }
    joints = (
        Pin("ground-crank", At("ground", "pivot"), At("crank", "near")),
        Pin("crank-rod", At("crank", "far"), At("rod", "near")),
        Pin("rod-slider", At("rod", "far"), At("slider", "pin")),
        Guide("slider-ground", At("ground", "line"), At("slider", "pin"), 0.0),
    )
    sine = (offset - radius * math.sin(angle)) / length
    start = {"rod": math.asin(min(max(sine, -1.0), 1.0))}
    loads = loads_of(case.loads, Places(bodies, {"slider": "pin"}))
    drive, aim = drive_of(case.drive, case.outline), Aim("slider", "pin", 0.0)
    return Machine(bodies, joints, "ground-crank", drive, values["gravity"], aim, start, loads)


def _link(values, name: str, length: float) -> Body:
    center = (values[f"{name}.center"], 0.0)
    points = {"near": (0.0, 0.0), "far": (length, 0.0)}
    elastic = elastic_of(values, name, ("near", "far"))
    return Body(values[f"{name}.mass"], values[f"{name}.inertia"], center, points, elastic)
