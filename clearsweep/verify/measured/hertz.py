"""Elastic impacts of balls: depth, force and duration by Hertz."""

import math

from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from .points import Benchmark, Row, read_reference

NAME = "Hertz impacts"
TEXT = """The first two benchmarks of Chung & Ooi: two equal balls that meet, and a ball on a rigid wall. `impact-
pair` with the law `hertz` and the stiffness of the materials is the whole model."""
CLEARANCE = 1e-3  # m: far from the contact, without effect
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
CASES = {
    "glass on glass": _ball_pair(48e9, 0.2, 2800.0),
    "limestone on limestone": _ball_pair(20e9, 0.25, 2500.0),
    "aluminium on a wall": _ball_on_wall(70e9, 0.3, 2699.0),
    "magnesium on a wall": _ball_on_wall(40e9, 0.35, 1800.0),
}


def impact(stiffness: float, masses: list[float], speed: float) -> dict[str, float]:
    """Return depth (um), force (kN) and duration (us) of the first impact."""
    contact = {"law": "hertz", "stiffness": stiffness, "exponent": 1.5}
    source = {
        "mechanism": {"type": "impact-pair", "masses": masses, "speed": speed},
        "joints": {"pair": {"clearance": CLEARANCE, "contact": contact}},
        "simulate": {"impacts": 1, "tolerance": 1e-11},
    }
    trajectory = simulate(load_case(source))
    onset_time, separation_time = trajectory.events["t"][:2]
    return {
        "depth": 1e6 * trajectory.summary["pair_penetration_max"],
        "force": 1e-3 * trajectory.summary["pair_force_peak"],
        "duration": 1e6 * float(separation_time - onset_time),
    }


def measure(*, quick: bool = False) -> list[Row]:
    """Return depth, force and duration of four impacts."""
    values = {(point, name): value for point, case in CASES.items() for name, value in impact(*case).items()}
    return read_reference(NAME).rows(values)


BENCHMARK = Benchmark("hertz", NAME, TEXT, measure)
