"""Benchmarks of turning journals and of machines."""

import math
import tempfile
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from ...contracts.results import Trajectory
from ...mechanics.joints.registry import compile_friction
from ...mechanics.laws.friction import friction_force
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from ...sweeping.sweep import sweep
from ..text import style_axes
from . import films
from .points import COLOURS, REFERENCE_STYLE, Benchmark, Row, read_grid, read_reference, run

CRANK_PIN = "Crank-pin rig"
LOADS = (4.0, 8.0)  # kN
MEAN_HEIGHTS = "reynolds, mean heights"
FILM_LAWS = ("reynolds", "finite", MEAN_HEIGHTS)
VISCOSITY = 6.8e-3  # Pa s
TEST_BEARING = {"bearing_radius": 23.9e-3, "length": 17.2e-3, "clearance": 23.9e-6}  # m
SUPPORT_BEARING = {"bearing_radius": 27e-3, "length": 25e-3, "clearance": 27e-6}
ASPERITIES = {
    "law": "greenwood-tripp",
    "roughness": 0.309e-6,
    "density": 0.05,
    "sharpness": 0.00712,
    "modulus": 53.3e9,
    "width": 2e-6,
}
MEAN_HEIGHT = 0.6e-6  # m, mean height of the asperities of both surfaces together
DRY_CONTACT = {"law": "hertz", "stiffness": 1e10, "exponent": 1.5}  # beyond the clearance, not reached in any run
FRICTION = {"law": "tanh", "coefficient": 0.02, "velocity_scale": 1e-3}
PIN_MASS, PIN_REVOLUTIONS = 0.02, 40  # kg, light enough to avoid whirl; revolutions until equilibrium


def loaded_equilibrium(bearing_size: dict[str, float], load: float, rate: float, law: str) -> tuple[float, float]:
    """Return torque (N m) and least film (um) of one bearing that carries `load` (N) at `rate` (rad/s)."""
    asperities = ASPERITIES | ({"mean_height": MEAN_HEIGHT} if law == MEAN_HEIGHTS else {})
    film: dict[str, Any] = {"law": law.partition(",")[0], "viscosity": VISCOSITY}
    if bearing_size is TEST_BEARING:  # the source has asperities for this bearing only
        film["transition"] = asperities
    joint: dict[str, Any] = {**bearing_size, "film": film, "contact": DRY_CONTACT, "friction": FRICTION}
    trajectory = films.run_bearing(films.bearing_grid(joint, rate, load, mass=PIN_MASS, revolutions=PIN_REVOLUTIONS))
    return films.torque(trajectory), 1e6 * (bearing_size["clearance"] - films.eccentricity(trajectory))


def rig_figures(load: float, rpm: float, law: str) -> dict[str, float]:
    """Return the torque of the shaft and the least film of the test bearing under a load (N)."""
    rate = rpm * math.pi / 30.0
    torque, film_thickness = loaded_equilibrium(TEST_BEARING, load, rate, law)
    support_torque, _ = loaded_equilibrium(SUPPORT_BEARING, 0.5 * load, rate, law)
    return {"shaft torque": torque + 2.0 * support_torque, "least film": film_thickness}


def measure_crank_pin(*, quick: bool = False) -> list[Row]:
    """Return the rows of both loads; `quick`: three points of one law."""
    table = read_reference(CRANK_PIN)
    points = table.names[:2] + table.names[-2:-1] if quick else table.names
    rows = []
    for law in FILM_LAWS[: 1 if quick else None]:
        rows += table.rows_at({point: rig_figures(*_load_and_speed(point), law) for point in points}, law)
    return rows


def _load_and_speed(point: str) -> tuple[float, float]:
    """Return load (N) and speed (rpm) of a point such as '8 kN, 3000 rpm'."""
    words = point.split()
    return 1e3 * float(words[0]), float(words[2])


def draw_crank_pin(rows: list[Row]) -> Figure:
    """Draw the torque over speed."""
    page = Figure(figsize=(9.0, 3.6), layout="constrained")
    for panel, load in zip(page.subplots(1, 2), LOADS, strict=True):
        for law, colour in zip(FILM_LAWS, COLOURS, strict=False):
            selected = [row for row in rows if (row.variant, row.quantity) == (law, "shaft torque")]
            selected = [row for row in selected if _load_and_speed(row.point)[0] == 1e3 * load]
            order = np.argsort([_load_and_speed(row.point)[1] for row in selected])
            speeds = [_load_and_speed(selected[i].point)[1] for i in order]
            panel.plot(speeds, [selected[i].computed for i in order], color=colour, marker=".", label=law)
        panel.plot(speeds, [selected[i].reference for i in order], **REFERENCE_STYLE, label="Sander et al., digitised")
        panel.set(xscale="log", xlabel="speed [rpm]", ylabel="shaft torque [N m]", title=f"{load:g} kN")
        style_axes(panel)
    panel.legend(frameon=False)
    return page


CRANK_PIN_RIG = Benchmark("crank_pin", CRANK_PIN, measure_crank_pin, draw_crank_pin)


# ----------------------------------------------------------------------------------------------------------------------
# Onset of oil whirl: the largest speed at which a rigid rotor stays at its equilibrium.


WHIRL = "Onset of oil whirl"
GRAVITY = 9.81  # m/s^2
RADIUS, CLEARANCE, MASS, SLENDERNESS = 0.02, 4e-5, 10.0, 0.25  # m, m, kg, of the closed form: without effect on it
INITIAL_OFFSET = 0.02  # of the clearance: initial distance of the housing from its equilibrium
LOAD_FACTOR = 1.02  # times the weight: a film in equilibrium carries the weight only, a whirl more
SPEED_TOLERANCE = 0.003  # of the speed


def short_film_viscosity(ratio: float, speed: float) -> float:
    """Return the viscosity (Pa s) with which a short half film carries MASS at an eccentricity ratio."""
    length = 2.0 * RADIUS * SLENDERNESS
    shape = ratio / (1.0 - ratio**2) ** 2 * math.sqrt(math.pi**2 * (1.0 - ratio**2) + 16.0 * ratio**2)
    return MASS * GRAVITY * 4.0 * CLEARANCE**2 / (RADIUS * speed * length**3 * shape)


def whirl_grid(film: dict[str, Any], speed: float, mass: float) -> dict[str, Any]:
    """Return the grid of a housing on its film, next to its equilibrium at `speed` (rad/s): that of a massless housing
    under the same load.
    """
    settled = films.run_bearing(films.bearing_grid(film, speed, mass * GRAVITY, mass=1e-4 * mass, revolutions=60))
    x, y = float(settled["housing/x"][-1]), float(settled["housing/y"][-1])
    offset = 1.0 - INITIAL_OFFSET * film["clearance"] / math.hypot(x, y)
    housing = {"mass": mass, "initial": {"x": offset * x, "y": offset * y}}
    values = {f"mechanism.bodies.housing.{key}": value for key, value in housing.items()}
    values |= {"drive.speed": speed, "joints.film": film, "limits.film_load_peak": LOAD_FACTOR * mass * GRAVITY}
    return read_grid("whirl", values)


def seek_threshold(source: dict[str, Any], between: tuple[float, float]) -> float:
    """Return the largest stable speed (rad/s) by `seek`.  Raise RuntimeError if it is outside the range."""
    seek = {
        "largest": "drive.speed",
        "between": list(between),
        "within": SPEED_TOLERANCE * between[1],
        "meeting": "limits",
        "for": "all",
    }
    whirl = source | {"name": "whirl", "seek": seek}
    with tempfile.TemporaryDirectory() as directory:
        result = sweep(whirl, directory + "/run", executor="serial", show_progress=False)
    (answer,) = result.search_result.answers
    if answer.low is None or answer.high is None or answer.low == answer.high:
        raise RuntimeError(f"no onset of whirl between {between[0]:g} and {between[1]:g} rad/s")
    return float(0.5 * (answer.low + answer.high))


def whirl_ratio(source: dict[str, Any], speed: float) -> float:
    """Return the speed of the whirl over that of the shaft, from a run close to the threshold."""
    source_at_speed = source | {"drive": {"speed": speed}, "save": {"orbits": "last", "revolutions": 40, "samples": 36}}
    trajectory = simulate(load_case({key: value for key, value in source_at_speed.items() if key != "limits"}))
    position = trajectory["joints/film/x"] + 1j * trajectory["joints/film/y"]
    phase = np.unwrap(np.angle(position - position.mean()))
    return float((phase[-1] - phase[0]) / (trajectory["crank_angle"][-1] - trajectory["crank_angle"][0]))


def measure_whirl(*, quick: bool = False) -> list[Row]:
    """Return the rows of the closed form and of Nicholas' two bearings."""
    table = read_reference(WHIRL, "short film")
    speeds = table.values("threshold speed")
    values = {}
    for point in list(speeds)[2:3] if quick else speeds:
        threshold_speed = speeds[point] * math.sqrt(GRAVITY / CLEARANCE)
        viscosity = short_film_viscosity(float(point.split()[-1]), threshold_speed)
        film = films.film_joint("short", viscosity, SLENDERNESS, RADIUS, CLEARANCE)
        source = whirl_grid(film, threshold_speed, MASS)
        onset = seek_threshold(source, (0.94 * threshold_speed, 1.06 * threshold_speed))
        values[point, "threshold speed"] = onset * math.sqrt(CLEARANCE / GRAVITY)
        values[point, "whirl over shaft speed"] = whirl_ratio(source, onset)
    rows = table.rows(values, "short")
    return rows if quick else rows + _plain_bearings()


def _plain_bearings() -> list[Row]:
    """Return the rows of plain bearings like those of Nicholas, Barrett & Leader."""
    table, values = read_reference(WHIRL, "nicholas"), {}
    for point, *_ in table.points:
        clearance = 1e-6 * float(point.split()[-2])
        reference_speed = math.sqrt(GRAVITY / clearance)
        film = films.film_joint("reynolds", 0.0524, 1.0, 0.0127, clearance)
        source = whirl_grid(film, 2.5 * reference_speed, 66.278 / GRAVITY)
        onset = seek_threshold(source, (2.0 * reference_speed, 3.2 * reference_speed))
        values[point, "threshold speed"] = onset / reference_speed
    return table.rows(values, "reynolds")


OIL_WHIRL = Benchmark("whirl", WHIRL, measure_whirl)


# ----------------------------------------------------------------------------------------------------------------------
# Andrews' squeezer: seven bodies, three loops that share a pin, a free crank and a spring.


SQUEEZER = "Andrews' squeezer"
SQUEEZER_TIME = 0.03  # s
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


def squeezer_grid(clearance: float = 0.0) -> dict[str, Any]:
    """Return the machine, with a clearance (m) in the pin between crank and link unless that is 0."""
    source = read_grid("squeezer")
    if clearance:  # it takes the place of the joint of the body at rest
        del source["mechanism"]["bodies"]["weight"], source["mechanism"]["joints"]["rest"]
        source["joints"] = {"p1": source["joints"]["rest"] | {"clearance": clearance}}
    return source


def end_state(clearance: float = 0.0) -> dict[tuple[str, str], float]:
    """Return angles and rates at the end, by the names of the source."""
    trajectory = run(squeezer_grid(clearance), "the squeezer did not run", np.array([SQUEEZER_TIME]))
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


ANDREWS_SQUEEZER = Benchmark("squeezer", SQUEEZER, measure_squeezer)


# ----------------------------------------------------------------------------------------------------------------------
# Stick-slip of a block on a guide, pulled by a spring, with friction laws with internal state.


STICK_SLIP = "Stick-slip of the LuGre paper"
END_TIME, TIME_STEP = 25.0, 1e-3  # s
SLIP_SPEED = 1e-3  # m/s: sliding speed from which it slips
LAW = {key: value for key, value in read_grid("stick_slip")["joints"]["guide"]["friction"].items() if key != "law"}
BRISTLES = {"lugre": LAW, "elasto-plastic": LAW}
LAWS = BRISTLES | {"karnopp": {key: LAW[key] for key in list(LAW)[:5]} | {"band": 1e-5}}


def stick_slip_grid(friction: dict[str, Any]) -> dict[str, Any]:
    """Return the grid of a block that a spring pulls along a guide."""
    return read_grid("stick_slip", {"joints.guide.friction": friction})


def run_stick_slip(law: str) -> Trajectory:
    """Return the run with a law of LAWS.  Raises RuntimeError."""
    times = np.linspace(0.0, END_TIME, round(END_TIME / TIME_STEP) + 1)
    return run(stick_slip_grid({"law": law, **LAWS[law]}), "a block did not slip", times)


def bristle_deflection(law: str, trajectory: Trajectory) -> float:
    """Return the deflection (m) of the bristles at the friction force at the end of a run."""
    (joint,) = load_case(stick_slip_grid({"law": law, **LAWS[law]})).case.joints
    term = compile_friction(joint)
    normal, tangential, slip = (
        float(trajectory[f"joints/guide/{name}"][-1]) for name in ("force_normal", "force_tangential", "vx")
    )
    limit = LAW["static_coefficient"] / LAW["bristle_stiffness"]

    def force_difference(z: float) -> float:
        return float(friction_force(term._replace(bend=z), normal, slip) - tangential)

    return float(brentq(force_difference, -limit, limit, xtol=1e-16))


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


LUGRE_STICK_SLIP = Benchmark("stick_slip", STICK_SLIP, measure_stick_slip, draw_stick_slip)
