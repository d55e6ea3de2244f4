"""Stick-slip of a block on a guide, pulled by a spring, with friction laws with internal state."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from ...contracts.results import Trajectory
from ...mechanics.joints.registry import compile_friction
from ...mechanics.laws.friction import friction_force
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from .drawing import COLOURS, REFERENCE_STYLE, style_axes
from .points import Benchmark, Row, read_reference

NAME = "Stick-slip of the LuGre paper"
TEXT = """A block of 1 kg is drawn along a guide through a spring of 2 N/m whose end moves at 0.1 m/s. In the grid
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


def grid(friction: dict[str, Any]) -> dict[str, Any]:
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


def run(law: str) -> Trajectory:
    """Return the run with a law of LAWS.  Raises RuntimeError."""
    times = np.linspace(0.0, END_TIME, round(END_TIME / TIME_STEP) + 1)
    trajectory = simulate(load_case(grid({"law": law, **LAWS[law]})), times=times)
    if trajectory.status != "ok":
        raise RuntimeError(f"a block did not slip: {trajectory.message}")
    return trajectory


def bristle_deflection(law: str, trajectory: Trajectory) -> float:
    """Return the deflection (m) of the bristles at the friction force at the end of a run."""
    (joint,) = load_case(grid({"law": law, **LAWS[law]})).case.joints
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


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of both laws."""
    laws = tuple(LAWS)[: 1 if quick else None]
    return [row for law in laws for row in read_reference(NAME).rows(slip_figures(law, run(law)), law)]


def picture(rows: list[Row]) -> Figure:
    """Draw position and speed over time."""
    page = Figure(figsize=(9.0, 3.2), layout="constrained")
    position_panel, speed_panel = page.subplots(1, 2)
    for law, colour in zip(LAWS, COLOURS, strict=False):
        trajectory = run(law)
        position_panel.plot(trajectory.t, trajectory["block/x"], color=colour, label=law)
        speed_panel.plot(trajectory.t, trajectory["block/vx"], color=colour, label=law)
    table = read_reference(NAME)
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


BENCHMARK = Benchmark("stick_slip", NAME, TEXT, measure, picture)
