"""Benchmarks of machines: Andrews' squeezer, and stick-slip of a block on a guide."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from ...contracts.results import Trajectory
from ...mechanics.joints.registry import compile_friction
from ...mechanics.laws.friction import friction_force
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from .points import COLOURS, REFERENCE_STYLE, Benchmark, Row, read_reference, style_axes

# ----------------------------------------------------------------------------------------------------------------------
# Andrews' squeezer: seven bodies, three loops that share a pin, a free crank and a spring.


SQUEEZER = "Andrews' squeezer"
SQUEEZER_TEXT = """\
Seven bodies, ten pins, one spring, a constant torque on the free crank, at rest at first. Links of 7 to
40 mm turn at up to 1424 rad/s. The source gives seven angles and seven rates at 0.03 s to 15 digits. The machine has
no contact: it tests the closure of loops, the free drive and the integrator. Tolerance 1e-11.

* The differences are those of the integrator: at most 2e-9 rad in 16 rad and 6e-7 rad/s in 1424 rad/s.
* The rows "one pin open" have a clearance of 10 um in the pin between crank and link (Lankarani-Nikravesh, 1e9
  N/m^1.5, restitution 0.9). Their differences are no errors. They show what the clearance changes after two and a
  half turns: 0.07 rad of the crank, and the sign of the slow links' rates."""
SQUEEZER_TIME = 0.03  # s
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


def squeezer_grid(clearance: float = 0.0) -> dict[str, Any]:
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
    trajectory = simulate(load_case(squeezer_grid(clearance)), times=np.array([SQUEEZER_TIME]))
    if trajectory.status != "ok":
        raise RuntimeError(f"the squeezer did not run: {trajectory.message}")
    values = {}
    for name, (body, base_body) in ANGLES.items():
        for quantity, channel in (("angle at 0.03 s", "angle"), ("rate at 0.03 s", "rate")):
            base_value = float(trajectory[f"{base_body}/{channel}"][0]) if base_body else 0.0
            values[name, quantity] = float(trajectory[f"{body}/{channel}"][0]) - base_value
    return values


def measure_squeezer(*, quick: bool = False) -> list[Row]:
    """Return the rows of the machine without clearance and with clearance in one pin."""
    table = read_reference(SQUEEZER)
    rows = table.rows(end_state(), "all pins ideal")
    return rows if quick else rows + table.rows(end_state(1e-5), "one pin open")


ANDREWS_SQUEEZER = Benchmark("squeezer", SQUEEZER, SQUEEZER_TEXT, measure_squeezer)


# ----------------------------------------------------------------------------------------------------------------------
# Stick-slip of a block on a guide, pulled by a spring, with friction laws with internal state.


STICK_SLIP = "Stick-slip of the LuGre paper"
STICK_SLIP_TEXT = """\
A block of 1 kg is drawn along a guide through a spring of 2 N/m whose end moves at 0.1 m/s. In the grid
the block is a free body with `initial` in a guide with clearance, pressed on its wall by 1 N, so that coefficients
per load are the forces of the paper: 1 N sliding, 1.5 N static, 0.4 N s/m viscous, bristles 1e5 N/m with sqrt(1e5) N
s/m that do not fall. Nothing is fitted.

* `lugre` is the law of the paper: end state with the bend of its bristles, slips and peak speed. The bend is that with
  which the law gives the friction at 25 s.
* `elasto-plastic` has the same cycle. It does not creep before it breaks away, so it rests a little elsewhere.
* `karnopp` has no bristles: the block rests until the spring draws with 1.5 N. With bristles it creeps before, and
  breaks away 0.1 s earlier."""
END_TIME, TIME_STEP = 25.0, 1e-3  # s
SLIP_SPEED = 1e-3  # m/s: sliding speed from which it slips
DAMPING = 1e5**0.5
LAW = {
    "coefficient": 1.0,
    "static_coefficient": 1.5,
    "stribeck_velocity": 1e-3,
    "shape": 2.0,
    "viscous": 0.4,
    "bristle_stiffness": 1e5,
    "bristle_damping": DAMPING,
    "damping_velocity": 1e6,
}
BRISTLES = {"lugre": LAW, "elasto-plastic": LAW}
LAWS = BRISTLES | {"karnopp": {key: LAW[key] for key in list(LAW)[:5]} | {"band": 1e-5}}
SPRING_LENGTH = 1e4  # m, length of the spring: its direction is nearly constant


def stick_slip_grid(friction: dict[str, Any]) -> dict[str, Any]:
    """Return the grid of a block that a spring pulls along a guide."""
    origin, clearance = [0.0, 0.0], 1e-3
    return {
        "mechanism": {
            "type": "planar",
            "bodies": {
                "ground": {"points": {"axle": origin, "rail": origin}},
                "wheel": {"mass": 1.0, "inertia": 1e-4, "points": {"axle": origin}},
                "block": {"mass": 1.0, "inertia": 0.1, "points": {"middle": origin}, "initial": {"y": -clearance}},
            },
            "joints": {
                "axle": {"type": "revolute", "between": ["ground.axle", "wheel.axle"]},
                "guide": {"type": "prismatic", "between": ["ground.rail", "block.middle"]},
            },
            "driven": "axle",
            "output": {"body": "wheel"},
        },
        "drive": {"speed": 2.0 * np.pi / END_TIME},
        "loads": {
            "weight": {"on": "block", "force": [0.0, -1.0]},
            "pull": {"on": "block", "table": {"time [s]": [0.0, END_TIME], "fx [N]": [0.0, 0.2 * END_TIME]}},
            "spring": {
                "between": ["ground", "block"],
                "anchor": [-SPRING_LENGTH, 0.0],
                "point": "middle",
                "stiffness": 2.0,
                "free_length": SPRING_LENGTH,
            },
        },
        "joints": {
            "guide": {
                "clearance": clearance,
                "length": 1.0,
                "height": 1e-3,
                "contact": {"law": "kelvin-voigt", "stiffness": 1e6, "damping": 1.4e3},
                "friction": friction,
            }
        },
        "simulate": {"revolutions": 1, "discard": 0, "tolerance": 1e-9},
        "save": {"orbits": "all"},
    }


def run_stick_slip(law: str) -> Trajectory:
    """Return the run with a law of LAWS.  Raises RuntimeError."""
    times = np.linspace(0.0, END_TIME, round(END_TIME / TIME_STEP) + 1)
    trajectory = simulate(load_case(stick_slip_grid({"law": law, **LAWS[law]})), times=times)
    if trajectory.status != "ok":
        raise RuntimeError(f"a block did not slip: {trajectory.message}")
    return trajectory


def bristle_deflection(law: str, trajectory: Trajectory) -> float:
    """Return the deflection (m) of the bristles at the friction force at the end of a run."""
    (joint,) = load_case(stick_slip_grid({"law": law, **LAWS[law]})).case.joints
    term = compile_friction(joint)
    normal, tangential, slip = (
        float(trajectory[f"joints/guide/{name}"][-1]) for name in ("force_normal", "force_tangential", "vx")
    )
    static_deflection = LAW["static_coefficient"] / LAW["bristle_stiffness"]
    return float(
        brentq(
            lambda z: friction_force(term._replace(bend=z), normal, slip) - tangential,
            -static_deflection,
            static_deflection,
            xtol=1e-16,
        )
    )


def slip_figures(law: str, trajectory: Trajectory) -> dict[tuple[str, str], float]:
    """Return the figures of the reference, for a run."""
    t, x, v = trajectory.t, trajectory["block/x"], trajectory["block/vx"]
    crossings = np.flatnonzero(np.diff((v > SLIP_SPEED).astype(int)))
    crossing_times = t[crossings] + TIME_STEP * (SLIP_SPEED - v[crossings]) / (v[crossings + 1] - v[crossings])
    slip_starts, slip_ends = crossing_times[::2], crossing_times[1::2]
    values = {("at 25 s", "place"): x[-1], ("at 25 s", "velocity"): v[-1], ("all slips", "peak speed"): v.max()}
    for i, (slip_start, slip_end) in enumerate(zip(slip_starts, slip_ends, strict=False), 1):
        values[f"slip {i}", "begins"] = slip_start
        values[f"slip {i}", "ends"] = slip_end
        values[f"slip {i}", "rests at"] = np.interp(slip_end + 0.2, t, x)
    if law in BRISTLES:
        values["at 25 s", "bend of the bristles"] = bristle_deflection(law, trajectory)
    values["slip 1", "spring force where it begins"] = 0.2 * slip_starts[0] - 2.0 * np.interp(slip_starts[0], t, x)
    return {key: float(value) for key, value in values.items()}


def measure_stick_slip(*, quick: bool = False) -> list[Row]:
    """Return the rows of both laws."""
    laws = tuple(LAWS)[: 1 if quick else None]
    return [row for law in laws for row in read_reference(STICK_SLIP).rows(slip_figures(law, run_stick_slip(law)), law)]


def draw_stick_slip(rows: list[Row]) -> Figure:
    """Draw position and speed over time."""
    page = Figure(figsize=(9.0, 3.2), layout="constrained")
    position_panel, speed_panel = page.subplots(1, 2)
    for law, colour in zip(LAWS, COLOURS, strict=False):
        trajectory = run_stick_slip(law)
        position_panel.plot(trajectory.t, trajectory["block/x"], color=colour, label=law)
        speed_panel.plot(trajectory.t, trajectory["block/vx"], color=colour, label=law)
    table = read_reference(STICK_SLIP)
    rests, ends = table.values("rests at"), table.values("ends")
    position_panel.plot(
        [ends[slip] + 0.2 for slip in rests], list(rests.values()), **REFERENCE_STYLE, label="published run"
    )
    position_panel.set(xlabel="time [s]", ylabel="place [m]")
    speed_panel.set(xlabel="time [s]", ylabel="speed [m/s]")
    position_panel.legend(frameon=False)
    for panel in (position_panel, speed_panel):
        style_axes(panel)
    return page


LUGRE_STICK_SLIP = Benchmark("stick_slip", STICK_SLIP, STICK_SLIP_TEXT, measure_stick_slip, draw_stick_slip)
