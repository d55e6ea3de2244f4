"""Elastic impacts of balls: depth, force and duration by Hertz."""

import math

from ...simulation.scene import load_case
from ...simulation.trajectory import simulate
from .points import Row, reference

NAME = "Hertz impacts"
TEXT = """The first two benchmarks of Chung & Ooi: two equal balls that meet, and a ball on a rigid wall. `impact-
pair` with the law `hertz` and the stiffness of the materials is the whole model."""
CLEARANCE = 1e-3  # m: far from the contact, without effect
HEAVY = 1e12  # times the ball's mass: a wall


def _sphere(radius: float, density: float) -> float:
    return 4.0 / 3.0 * math.pi * radius**3 * density


def _stiffness(radius: float, modulus: float) -> float:
    """Return Hertz's (4/3) E* sqrt(R), N/m^1.5."""
    return 4.0 / 3.0 * modulus * math.sqrt(radius)


def _balls(young: float, poisson: float, density: float) -> tuple[float, list[float], float]:
    """Return stiffness, both masses and speed of two balls of 20 mm that collide at 10 m/s each."""
    mass = _sphere(0.01, density)
    return _stiffness(0.005, 0.5 * young / (1.0 - poisson**2)), [mass, mass], 20.0


def _on_wall(young: float, poisson: float, density: float) -> tuple[float, list[float], float]:
    """Return stiffness, masses and speed of a ball of 200 mm on a wall of a thousand times its Young's modulus."""
    mass, plane = _sphere(0.1, density), young / (1.0 - poisson**2)
    return _stiffness(0.1, plane / (1.0 + 1e-3)), [mass, HEAVY * mass], 0.2


#: point -> stiffness (N/m^1.5), both masses (kg), speed of approach (m/s); Young's modulus, Poisson's ratio, density.
CASES = {
    "glass on glass": _balls(48e9, 0.2, 2800.0),
    "limestone on limestone": _balls(20e9, 0.25, 2500.0),
    "aluminium on a wall": _on_wall(70e9, 0.3, 2699.0),
    "magnesium on a wall": _on_wall(40e9, 0.35, 1800.0),
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
    begins, ends = trajectory.events["t"][:2]
    return {
        "depth": 1e6 * trajectory.summary["pair_penetration_max"],
        "force": 1e-3 * trajectory.summary["pair_force_peak"],
        "duration": 1e6 * float(ends - begins),
    }


def measure(*, quick: bool = False) -> list[Row]:
    """Return depth, force and duration of four impacts."""
    values = {(point, name): value for point, case in CASES.items() for name, value in impact(*case).items()}
    return reference(NAME).rows(values)
