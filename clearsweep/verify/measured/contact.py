"""Benchmarks of contact: oblique and elastic impacts, waves in a bar, and the trends of wear."""

import functools
import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...contracts.results import Trajectory
from ...grid.cases import put_values
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from ..text import style_axes
from .points import COLOURS, REFERENCE_STYLE, Benchmark, Row, read_grid, read_reference, read_yaml, run

# ----------------------------------------------------------------------------------------------------------------------
# Measured oblique impacts of a ball on a wall: effect of the friction law on rebound and spin.


OBLIQUE = "Oblique impact of a ball"
RADIUS, SPEED = 2.5e-3, 3.9  # m, m/s
INITIAL_GAP = 1e-6  # m, initial distance of the ball
FREE_FLIGHT_TIME = 20e-6  # s, after the end of the contact
FRICTION_LAWS: dict[str, dict[str, float]] = read_yaml("friction_laws.yaml")
DRAWN_LAWS = ("tanh", "karnopp", "dahl", "lugre", "elasto-plastic")


def oblique_grid(incidence: float, friction: dict[str, Any]) -> dict[str, Any]:
    """Return the grid of an impact at an angle (rad) from the normal, which is the x axis."""
    forward, sideways = SPEED * math.cos(incidence), SPEED * math.sin(incidence)
    duration = FREE_FLIGHT_TIME / math.cos(incidence) ** 0.2 + INITIAL_GAP / forward  # s
    speeds = {"mechanism.bodies.ball.initial.vx": forward, "mechanism.bodies.ball.initial.vy": sideways}
    return read_grid("oblique", speeds | {"drive.speed": 2.0 * math.pi / duration, "joints.wall.friction": friction})


def oblique_impact(incidence: float, friction: dict[str, Any]) -> dict[str, float]:
    """Return the motion of the ball after an impact at an angle (rad) from the normal.  Raises RuntimeError."""
    trajectory = simulate(load_case(oblique_grid(incidence, friction)))
    if trajectory.status != "ok" or [str(event["kind"]) for event in trajectory.events] != ["on", "off"]:
        raise RuntimeError(f"a ball did not rebound once: {trajectory.message or trajectory.events}")
    normal, tangential, spin = (float(trajectory[f"ball/{name}"][-1]) for name in ("vx", "vy", "rate"))
    return {
        "tangential restitution": tangential / (SPEED * math.sin(incidence)),
        "rebound spin": spin,
        "rebound angle of the contact point": math.degrees(math.atan2(tangential + RADIUS * spin, -normal)),
    }


def measure_oblique(*, quick: bool = False) -> list[Row]:
    """Return the rows of every law at every incidence; `quick`: three incidences and two laws."""
    table = read_reference(OBLIQUE)
    angles = {point: math.radians(_incidence(point)) for point in (table.names[2:5] if quick else table.names)}
    rows = []
    for law in ("tanh", "dahl") if quick else FRICTION_LAWS:
        friction = {"law": law, **FRICTION_LAWS[law]}
        rows += table.rows_at({point: oblique_impact(angle, friction) for point, angle in angles.items()}, law)
    return rows


def _incidence(point: str) -> float:
    """Return the angle (deg) of a point."""
    return float(point.split()[1])


def draw_oblique(rows: list[Row]) -> Figure:
    """Draw the three quantities over incidence."""
    page = Figure(figsize=(10.0, 3.6), layout="constrained")
    names = list(dict.fromkeys((row.quantity, row.unit) for row in rows))
    for panel, (quantity, unit) in zip(page.subplots(1, 3), names, strict=True):
        selected = [row for row in rows if row.quantity == quantity]
        for law, colour in zip(DRAWN_LAWS, COLOURS, strict=False):
            values = [(_incidence(row.point), row.computed) for row in selected if row.variant == law]
            panel.plot(*zip(*values, strict=True), color=colour, label=law)
        values = [(_incidence(row.point), row.reference) for row in selected if row.variant == DRAWN_LAWS[0]]
        panel.plot(*zip(*values, strict=True), **REFERENCE_STYLE, label="measured")
        panel.set(xlabel="incidence from the normal [deg]", ylabel=f"{quantity} [{unit}]")
        style_axes(panel)
    page.axes[0].legend(frameon=False, fontsize=8)
    return page


OBLIQUE_IMPACTS = Benchmark("oblique", OBLIQUE, measure_oblique, draw_oblique)


# ----------------------------------------------------------------------------------------------------------------------
# Elastic impacts of balls: depth, force and duration by Hertz.


HERTZ = "Hertz impacts"
PAIR_CLEARANCE = 1e-3  # m: far from the contact, without effect
WALL_MASS_RATIO = 1e12  # times the ball's mass: a wall


def _sphere_mass(radius: float, density: float) -> float:
    """Return the mass (kg) of a ball of a radius (m) and density (kg/m^3)."""
    return 4.0 / 3.0 * math.pi * radius**3 * density


def _hertz_stiffness(radius: float, modulus: float) -> float:
    """Return Hertz's (4/3) E* sqrt(R), N/m^1.5."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius)


def _ball_pair(young: float, poisson: float, density: float) -> tuple[float, list[float], float]:
    """Return stiffness, both masses and speed of two balls of 20 mm that collide at 10 m/s each."""
    mass = _sphere_mass(0.01, density)
    return _hertz_stiffness(0.005, 0.5 * young / (1.0 - poisson**2)), [mass, mass], 20.0


def _ball_on_wall(young: float, poisson: float, density: float) -> tuple[float, list[float], float]:
    """Return stiffness, masses and speed of a ball of 200 mm on a wall of a thousand times its Young's modulus."""
    mass, plane_modulus = _sphere_mass(0.1, density), young / (1.0 - poisson**2)
    return _hertz_stiffness(0.1, plane_modulus / (1.0 + 1e-3)), [mass, WALL_MASS_RATIO * mass], 0.2


#: point -> stiffness (N/m^1.5), both masses (kg), speed of approach (m/s); Young's modulus, Poisson's ratio, density.
PAIRS = {
    "glass on glass": _ball_pair(48e9, 0.2, 2800.0),
    "limestone on limestone": _ball_pair(20e9, 0.25, 2500.0),
    "aluminium on a wall": _ball_on_wall(70e9, 0.3, 2699.0),
    "magnesium on a wall": _ball_on_wall(40e9, 0.35, 1800.0),
}


def hertz_impact(stiffness: float, masses: list[float], speed: float) -> dict[str, float]:
    """Return depth (um), force (kN) and duration (us) of the first impact."""
    contact = {"law": "hertz", "stiffness": stiffness, "exponent": 1.5}
    source = {
        "mechanism": {"type": "impact-pair", "masses": masses, "speed": speed},
        "joints": {"pair": {"clearance": PAIR_CLEARANCE, "contact": contact}},
        "simulate": {"impacts": 1, "tolerance": 1e-11},
    }
    trajectory = simulate(load_case(source))
    onset_time, separation_time = trajectory.events["t"][:2]
    return {
        "depth": 1e6 * trajectory.summary["pair_penetration_max"],
        "force": 1e-3 * trajectory.summary["pair_force_peak"],
        "duration": 1e6 * float(separation_time - onset_time),
    }


def measure_hertz(*, quick: bool = False) -> list[Row]:
    """Return depth, force and duration of four impacts."""
    return read_reference(HERTZ).rows_at({point: hertz_impact(*case) for point, case in PAIRS.items()})


HERTZ_IMPACTS = Benchmark("hertz", HERTZ, measure_hertz)


# ----------------------------------------------------------------------------------------------------------------------
# A mass that strikes the end of an elastic bar axially: waves in the bar, Hertz's law in the contact.


BAR = "Axial impact on an elastic bar"
BAR_SPEEDS = (0.2, 1.0, 4.4)  # m/s


def bar_grid(speed: float) -> dict[str, Any]:
    """Return the grid of a mass that strikes a bar; it ends 0.2 ms after the mass has crossed the clearance."""
    source = read_grid("bar", {"mechanism.bodies.hammer.initial.vx": -speed})
    duration = source["joints"]["face"]["clearance"] / speed + 2e-4  # s
    return put_values(source, {"simulate.revolutions": source["drive"]["speed"] * duration / (2.0 * math.pi)})


def bar_impact(speed: float) -> dict[str, float]:
    """Return force (kN) and duration (us) of the first impact at a speed (m/s)."""
    events = simulate(load_case(bar_grid(speed)), times=[0.0]).events
    first_events = events[events["joint"] == events["joint"][0]]
    onset, separation = (first_events[first_events["kind"] == kind][0] for kind in ("on", "off"))
    return {"force": 1e-3 * float(separation["force_peak"]), "duration": 1e6 * float(separation["t"] - onset["t"])}


def measure_bar(*, quick: bool = False) -> list[Row]:
    """Return force and duration at three speeds."""
    return read_reference(BAR).rows_at({f"{speed} m/s": bar_impact(speed) for speed in BAR_SPEEDS})


BAR_IMPACTS = Benchmark("bar", BAR, measure_bar)


# ----------------------------------------------------------------------------------------------------------------------
# Trends of measured wear: volume and profile of a bushing, and the deepest wear of a spatial joint.


WEAR = "Trends of wear"
PRESSURES = ("persson", "winkler", "hertz-line", "mean")
WORN_IN_CONTACTS = {"foundation": {"elastic": "winkler", "thickness": 3e-3}, "line contact": {}}  # keys of its contact
WORN_DEPTH = 6e-5  # m
TILTS = {"aligned": 0.0, "tilted by 0.3 deg": np.radians(0.3)}


def bushing_grid(pressure: str) -> dict[str, Any]:
    """Return the grid of a slider-crank whose PTFE bushing runs dry at 30 rpm under a spring."""
    return read_grid("bushing", {"joints.crank-rod.wear.pressure": pressure})


def worn_in_grid(kind: str) -> dict[str, Any]:
    """Return the grid of a bushing worn by WORN_DEPTH whose worn shape acts back; `kind`: key of WORN_IN_CONTACTS."""
    source = bushing_grid("winkler" if kind == "foundation" else "hertz-line")
    joint = source["joints"]["crank-rod"]
    # with its onset rate renewed the line contact rebounds more often and slides less: volumes would compare motions
    joint["contact"] |= WORN_IN_CONTACTS[kind] | {"onset": "first"}
    joint["wear"] |= {"evolve": True, "bins": 180}
    return source | {"life": {"limit": WORN_DEPTH, "joint": "crank-rod"}}


run_wear = functools.partial(run, failure="a worn joint did not run")


@functools.cache
def worn_in_profiles() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the (nodes,) revolutions and (nodes, bins) depths (m) of both kinds of WORN_IN_CONTACTS."""
    histories = {kind: run_wear(worn_in_grid(kind)).history for kind in WORN_IN_CONTACTS}
    return {kind: (history["revolutions"], history["crank_rod/profile_bearing"]) for kind, history in histories.items()}


def deepest_wear_position(trajectory: Trajectory) -> float:
    """Return the axial place of the deepest wear of the bearing: 0 in the middle, 1 in the strip at an edge."""
    depth = trajectory.wear["crank_rod"][0].max(axis=0)
    middle = 0.5 * (len(depth) - 1)
    return float(abs(int(np.argmax(depth)) - middle) / middle)


@functools.cache
def new_profiles() -> dict[str, np.ndarray]:
    """Return the (bins,) depth (m) of the new bushing by pressure law."""
    return {law: run_wear(bushing_grid(law)).wear["crank_rod"][0] for law in PRESSURES}


def measure_wear(*, quick: bool = False) -> list[Row]:
    """Return the rows of both trends; `quick` limits the first trend to two laws."""
    laws = PRESSURES[: 2 if quick else None]
    volume = {law: run_wear(bushing_grid(law)).summary["crank_rod_wear_volume"] for law in laws}
    ratios = {(f"{law} over persson", "ratio of worn volumes"): volume[law] / volume["persson"] for law in laws[1:]}
    rows = read_reference(WEAR, "bushing").rows(ratios)
    if quick:
        return rows
    rates = {kind: depths[-1].mean() / turns[-1] for kind, (turns, depths) in worn_in_profiles().items()}
    ratio = float(rates["line contact"] / rates["foundation"])
    rows += read_reference(WEAR, "bushing").rows(
        {("line contact over foundation, worn in", "ratio of worn volumes"): ratio}
    )
    axial_positions = {
        (name, "place of the deepest wear"): deepest_wear_position(
            run_wear(read_grid("spatial", {"joints.crank-rod.tilt": [tilt, 0.0]}))
        )
        for name, tilt in TILTS.items()
    }
    return rows + read_reference(WEAR, "in space").rows(axial_positions)


def draw_wear(rows: list[Row]) -> Figure:
    """Draw the worn profile of the bushing by pressure law."""
    page = Figure(figsize=(9.0, 3.4), layout="constrained")
    new, worn = new_profiles(), {kind: depths[-1] for kind, (_, depths) in worn_in_profiles().items()}
    drawings = (new, COLOURS, 1e9, "worn in 3 revolutions [nm]"), (worn, COLOURS[1:], 1e6, "worn in a life [um]")
    for panel, (profiles, colours, scale, label) in zip(page.subplots(1, 2), drawings, strict=True):
        for (name, depth), colour in zip(profiles.items(), colours, strict=False):
            panel.plot(np.arange(len(depth)) * 360.0 / len(depth), scale * depth, color=colour, label=name)
        panel.set(xlabel="angle on the bushing [deg]", ylabel=label)
        panel.legend(frameon=False)
        style_axes(panel)
    return page


WEAR_TRENDS = Benchmark("worn", WEAR, measure_wear, draw_wear)
