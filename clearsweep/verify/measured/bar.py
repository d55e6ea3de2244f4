"""A mass that strikes the end of an elastic bar axially: waves in the bar, Hertz's law in the contact."""

import math

from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from .points import Benchmark, Row, read_reference

NAME = "Axial impact on an elastic bar"
TEXT = """A mass of 0.14 kg strikes the end of a steel bar of 0.21 kg and 3.9e8 N/m, whose other end is fixed. The
reference is the continuous bar: Saint-Venant's waves, reflected at the fixed end, with Hertz's law in the contact as
Sears had it. In the grid the bar is an `elastic` link of six segments, and the mass a free body with `initial` in a
joint with clearance. Nothing is fitted. A chain of six springs spreads the wave front over a segment, so it errs most
where the contact is shortest."""
SEGMENTS = 6
STIFFNESS, BAR_MASS, HAMMER_MASS, CONTACT_STIFFNESS = 3.9e8, 0.21, 0.14, 6.61e10  # N/m, kg, kg, N/m^1.5
CLEARANCE = 1e-4  # m
CRANK_SPEED = 1e-3  # rad/s, of the bar: a crank must rotate
SPEEDS = (0.2, 1.0, 4.4)  # m/s


def grid(speed: float) -> dict:
    """Return the grid of a mass that strikes a bar; the bar is a nearly fixed crank."""
    return {
        "mechanism": {
            "type": "planar",
            "bodies": {
                "ground": {"points": {"wall": [0.0, 0.0]}},
                "bar": {
                    "mass": BAR_MASS,
                    "inertia": BAR_MASS * 0.12**2 / 12.0,
                    "center": [0.06, 0.0],
                    "points": {"fixed": [0.0, 0.0], "end": [0.12, 0.0]},
                    "elastic": {"between": ["fixed", "end"], "axial_stiffness": STIFFNESS, "segments": SEGMENTS},
                },
                "hammer": {
                    "mass": HAMMER_MASS,
                    "inertia": 1e-4,
                    "points": {"face": [0.0, 0.0]},
                    "initial": {"x": 0.12, "vx": -speed},
                },
            },
            "joints": {
                "wall": {"type": "revolute", "between": ["ground.wall", "bar.fixed"]},
                "face": {"type": "revolute", "between": ["bar.end", "hammer.face"]},
            },
            "driven": "wall",
            "output": {"body": "bar"},
        },
        "drive": {"speed": CRANK_SPEED},
        "joints": {
            "face": {
                "clearance": CLEARANCE,
                "bearing_radius": 0.01,
                "contact": {"law": "hertz", "stiffness": CONTACT_STIFFNESS, "exponent": 1.5},
            }
        },
        "simulate": {
            "revolutions": CRANK_SPEED * (CLEARANCE / speed + 2e-4) / (2.0 * math.pi),
            "discard": 0,
            "tolerance": 1e-10,
        },
        "save": {"orbits": "none"},
    }


def impact(speed: float) -> dict[str, float]:
    """Return force (kN) and duration (us) of the first impact at a speed (m/s)."""
    events = simulate(load_case(grid(speed)), times=[0.0]).events
    first_events = events[events["joint"] == events["joint"][0]]
    onset, separation = (first_events[first_events["kind"] == kind][0] for kind in ("on", "off"))
    return {"force": 1e-3 * float(separation["force_peak"]), "duration": 1e6 * float(separation["t"] - onset["t"])}


def measure(*, quick: bool = False) -> list[Row]:
    """Return force and duration at three speeds."""
    return read_reference(NAME).rows(
        {(f"{speed} m/s", name): value for speed in SPEEDS for name, value in impact(speed).items()}
    )


BENCHMARK = Benchmark("bar", NAME, TEXT, measure)
