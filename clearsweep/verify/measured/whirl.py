"""Onset of oil whirl: the largest speed at which a rigid rotor stays at its equilibrium."""

import math
import tempfile
from typing import Any

import numpy as np

from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from ...sweeping.sweep import sweep
from . import bearing
from .points import Benchmark, Row, read_reference

NAME = "Onset of oil whirl"
TEXT = """A housing of mass M hangs on a turning shaft by its film alone; its weight M g is the load. It is a free
body with `initial`, of so large a moment of inertia that it does not turn. It starts next to its place of rest.
`seek` finds the largest speed at which the film carries no more than 1.02 times the weight after 940 revolutions:
below the onset the housing has come to rest, above it whirls. The threshold is that speed times sqrt(clearance / g).

* **Closed form**: stiffness and damping of the short half film and Routh's criterion. The film's law is `short` and
  its viscosity is that with which the housing rests at the tabulated eccentricity at the threshold. Stiffness,
  damping, inertia and the integrator all enter.
* **Nicholas, Barrett & Leader** give 2.1 for a bearing with two axial grooves, length / diameter 1, close to its
  centre. Here the law is `reynolds`, without grooves. The difference is that of the bearings: a plain one whirls
  later. The coefficients in the last section show the same difference.
* The whirl's own speed is taken from the motion at the largest stable speed."""
GRAVITY = 9.81  # m/s^2
RADIUS, CLEARANCE, MASS, SLENDERNESS = 0.02, 4e-5, 10.0, 0.25  # m, m, kg, of the closed form: without effect on it
HOUSING_INERTIA = 1e3  # kg m^2: a housing that does not rotate
INITIAL_OFFSET = 0.02  # of the clearance: initial distance of the housing from its equilibrium
LOAD_FACTOR = 1.02  # times the weight: a film in equilibrium carries the weight only, a whirl more
REVOLUTIONS, EVALUATED_REVOLUTIONS = 1000, 60  # revolutions of a probe, and of its evaluated part
SPEED_TOLERANCE = 0.003  # of the speed


def short_film_viscosity(ratio: float, speed: float) -> float:
    """Return the viscosity (Pa s) with which a short half film carries MASS at an eccentricity ratio."""
    length = 2.0 * RADIUS * SLENDERNESS
    shape = ratio / (1.0 - ratio**2) ** 2 * math.sqrt(math.pi**2 * (1.0 - ratio**2) + 16.0 * ratio**2)
    return MASS * GRAVITY * 4.0 * CLEARANCE**2 / (RADIUS * speed * length**3 * shape)


def film_joint(law: str, viscosity: float, slenderness: float, radius: float, clearance: float) -> dict[str, Any]:
    """Return a joint that has a film and no contact law."""
    film = {"law": law, "viscosity": viscosity}
    return {"clearance": clearance, "bearing_radius": radius, "length": 2.0 * radius * slenderness, "film": film}


def equilibrium(film: dict[str, Any], speed: float, mass: float) -> tuple[float, float]:
    """Return the equilibrium (m) of the housing: that of a massless housing under the same load."""
    trajectory = bearing.run(bearing.grid(film, speed, mass * GRAVITY, mass=1e-4 * mass, revolutions=60))
    return float(trajectory["housing/x"][-1]), float(trajectory["housing/y"][-1])


def grid(film: dict[str, Any], speed: float, mass: float) -> dict[str, Any]:
    """Return the grid of a housing on its film; `speed` (rad/s): at which its equilibrium is computed."""
    x, y = equilibrium(film, speed, mass)
    clearance, origin = film["clearance"], [0.0, 0.0]
    offset = 1.0 - INITIAL_OFFSET * clearance / math.hypot(x, y)
    housing = {
        "mass": mass,
        "inertia": HOUSING_INERTIA,
        "points": {"bore": origin},
        "initial": {"x": offset * x, "y": offset * y},
    }
    return {
        "mechanism": {
            "type": "planar",
            "gravity": GRAVITY,
            "bodies": {
                "ground": {"points": {"main": origin}},
                "shaft": {"mass": 1.0, "inertia": 1e-4, "points": {"pin": origin}},
                "housing": housing,
            },
            "joints": {
                "main": {"type": "revolute", "between": ["ground.main", "shaft.pin"]},
                "film": {"type": "revolute", "between": ["shaft.pin", "housing.bore"], "journal": "shaft"},
            },
            "driven": "main",
            "output": {"body": "shaft"},
        },
        "drive": {"speed": speed},
        "joints": {"film": film},
        "simulate": {"revolutions": REVOLUTIONS, "discard": REVOLUTIONS - EVALUATED_REVOLUTIONS, "tolerance": 1e-7},
        "save": {"orbits": "none"},
        "limits": {"film_load_peak": LOAD_FACTOR * mass * GRAVITY},
    }


def seek_threshold(source: dict[str, Any], between: tuple[float, float]) -> float:
    """Return the largest stable speed (rad/s) by `seek`.  Raise RuntimeError if it is outside the range."""
    seek = {
        "largest": "drive.speed",
        "between": list(between),
        "within": SPEED_TOLERANCE * between[1],
        "meeting": "limits",
        "for": "all",
    }
    with tempfile.TemporaryDirectory() as directory:
        result = sweep(
            source | {"name": "whirl", "seek": seek}, directory + "/run", executor="serial", show_progress=False
        )
    (answer,) = result.found.answers
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


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of the closed form and of Nicholas' two bearings."""
    table = read_reference(NAME, "short film")
    speeds = table.values("threshold speed")
    values = {}
    for point in list(speeds)[2:3] if quick else speeds:
        threshold_speed = speeds[point] * math.sqrt(GRAVITY / CLEARANCE)
        film = film_joint(
            "short", short_film_viscosity(float(point.split()[-1]), threshold_speed), SLENDERNESS, RADIUS, CLEARANCE
        )
        source = grid(film, threshold_speed, MASS)
        onset = seek_threshold(source, (0.94 * threshold_speed, 1.06 * threshold_speed))
        values[point, "threshold speed"] = onset * math.sqrt(CLEARANCE / GRAVITY)
        values[point, "whirl over shaft speed"] = whirl_ratio(source, onset)
    rows = table.rows(values, "short")
    return rows if quick else rows + _plain_bearings()


def _plain_bearings() -> list[Row]:
    """Return the rows of plain bearings like those of Nicholas, Barrett & Leader."""
    table, values = read_reference(NAME, "nicholas"), {}
    for point, *_ in table.points:
        clearance = 1e-6 * float(point.split()[-2])
        reference_speed = math.sqrt(GRAVITY / clearance)
        film = film_joint("reynolds", 0.0524, 1.0, 0.0127, clearance)
        source = grid(film, 2.5 * reference_speed, 66.278 / GRAVITY)
        values[point, "threshold speed"] = (
            seek_threshold(source, (2.0 * reference_speed, 3.2 * reference_speed)) / reference_speed
        )
    return table.rows(values, "reynolds")


BENCHMARK = Benchmark("whirl", NAME, TEXT, measure)
