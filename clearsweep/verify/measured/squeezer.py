"""Andrews' squeezer: seven bodies, three loops that share a pin, a free crank and a spring."""

from typing import Any

import numpy as np

from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from .points import Benchmark, Row, read_reference

NAME = "Andrews' squeezer"
TEXT = """Seven bodies, ten pins, one spring, a constant torque on the free crank, at rest at first. Links of 7 to
40 mm turn at up to 1424 rad/s. The source gives seven angles and seven rates at 0.03 s to 15 digits. The machine has
no contact: it tests the closure of loops, the free drive and the integrator. Tolerance 1e-11.

* The differences are those of the integrator: at most 2e-9 rad in 16 rad and 6e-7 rad/s in 1424 rad/s.
* The rows "one pin open" have a clearance of 10 um in the pin between crank and link (Lankarani-Nikravesh, 1e9
  N/m^1.5, restitution 0.9). Their differences are no errors. They show what the clearance changes after two and a
  half turns: 0.07 rad of the crank, and the sign of the slow links' rates."""
END_TIME = 0.03  # s
TOLERANCE = 1e-11
START_ANGLES = {"crank": -0.0617138900142764496, "theta": 0.0, "b": 0.455279819163070380, "phi": 0.222668390165885885}
START_ANGLES |= {"delta": 0.487364979543842550, "omega": -0.222668390165885885, "epsilon": 1.23054744454982119}
#: Name in the source -> (body, body from which the source measures its angle; None: the ground).
ANGLES = {
    "beta": ("crank", None),
    "theta": ("link", "crank"),
    "gamma": ("lever", None),
    "phi": ("upper", "left"),
    "delta": ("left", None),
    "omega": ("lower", "right"),
    "epsilon": ("right", None),
}
SPRING = {
    "between": ["ground", "lever"],
    "anchor": [0.014, 0.072],
    "point": "d",
    "stiffness": 4530.0,
    "free_length": 0.07785,
}
CONTACT = {"law": "lankarani-nikravesh", "stiffness": 1e9, "exponent": 1.5, "restitution": 0.9}


def grid(clearance: float = 0.0) -> dict[str, Any]:
    """Return the machine, with a clearance (m) in the pin between crank and link unless that is 0."""
    a, origin = [-0.06934, -0.00227], [0.0, 0.0]
    angles = {
        "crank": START_ANGLES["crank"],
        "link": START_ANGLES["crank"] + START_ANGLES["theta"],
        "lever": START_ANGLES["b"],
        "upper": START_ANGLES["phi"] + START_ANGLES["delta"],
        "left": START_ANGLES["delta"],
        "lower": START_ANGLES["omega"] + START_ANGLES["epsilon"],
        "right": START_ANGLES["epsilon"],
    }
    bodies = {
        "ground": {"points": {"o": origin, "a": a, "b": [-0.03635, 0.03273], "c": [0.014, 0.072]}},
        "crank": _body(0.04325, 2.194e-6, [0.00092, 0.0], o=origin, pin=[0.007, 0.0]),
        "link": _body(0.00365, 4.410e-7, [-0.0115, 0.0], pin=origin, e=[-0.028, 0.0]),
        "lever": _body(0.02373, 5.255e-6, [0.01043, -0.01874], b=origin, e=[0.0, -0.035], d=[0.02, -0.018]),
        "upper": _body(0.00706, 5.667e-7, [0.0, -0.00579], k=origin, e=[0.0, -0.02]),
        "left": _body(0.07050, 1.169e-5, [0.02308, 0.00916], a=origin, k=[0.04, 0.0]),
        "lower": _body(0.00706, 5.667e-7, [0.00579, 0.0], h=origin, e=[0.02, 0.0]),
        "right": _body(0.05498, 1.912e-5, [0.01228, -0.00449], a=origin, h=[0.0, -0.04]),
    }
    pin_ends = ["ground.o crank.o", "crank.pin link.pin", "ground.b lever.b", "ground.a left.a", "ground.a right.a"]
    pin_ends += ["left.k upper.k", "right.h lower.h", "link.e lever.e", "link.e upper.e", "link.e lower.e"]
    pins = {f"p{i}": pin for i, pin in enumerate(pin_ends)} | ({} if clearance else {"rest": "ground.o weight.middle"})
    if not clearance:  # a grid needs a joint with clearance: here that of a body at rest
        bodies["weight"] = _body(1.0, 1.0, origin, middle=origin) | {"initial": {}}
    joint = {"clearance": clearance, "bearing_radius": 2e-3, "contact": CONTACT}
    return {
        "mechanism": {
            "type": "planar",
            "bodies": bodies,
            "joints": {name: {"type": "revolute", "between": pin.split()} for name, pin in pins.items()},
            "driven": "p0",
            "start": {name: angle for name, angle in angles.items() if name != "crank"},
            "output": {"body": "lever"},
        },
        "drive": {"torque": 0.033, "initial_speed": 0.0, "start_angle": START_ANGLES["crank"]},
        "loads": {"spring": SPRING},
        "joints": {"p1": joint} if clearance else {"rest": joint | {"clearance": 1e-3}},
        "simulate": {"revolutions": 2.7, "discard": 0, "tolerance": TOLERANCE, "time_limit": 0.1},
        "save": {"orbits": "all"},
    }


def _body(mass: float, inertia: float, center: list[float], **points: list[float]) -> dict[str, Any]:
    return {"mass": mass, "inertia": inertia, "center": center, "points": points}


def end_state(clearance: float = 0.0) -> dict[tuple[str, str], float]:
    """Return angles and rates at the end, by the names of the source."""
    trajectory = simulate(load_case(grid(clearance)), times=np.array([END_TIME]))
    if trajectory.status != "ok":
        raise RuntimeError(f"the squeezer did not run: {trajectory.message}")
    values = {}
    for name, (body, base_body) in ANGLES.items():
        for quantity, channel in (("angle at 0.03 s", "angle"), ("rate at 0.03 s", "rate")):
            base_value = float(trajectory[f"{base_body}/{channel}"][0]) if base_body else 0.0
            values[name, quantity] = float(trajectory[f"{body}/{channel}"][0]) - base_value
    return values


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of the machine without clearance and with clearance in one pin."""
    table = read_reference(NAME)
    rows = table.rows(end_state(), "all pins ideal")
    return rows if quick else rows + table.rows(end_state(1e-5), "one pin open")


BENCHMARK = Benchmark("squeezer", NAME, TEXT, measure)
