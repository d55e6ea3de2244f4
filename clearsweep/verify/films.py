"""Cases of the stability table with films: a factorial drawn once, by a seed, before the first run.

There are two families of CASES_PER_FAMILY cases: a film alone, which must carry the load, and a film with a dry joint
behind it. In some of the latter the film is so thin that the dry joint carries most of the load.  In every factor each
level occurs equally often, as in `machines`.  The viscosity follows from the ratio of the load to the load capacity of
the film at half its clearance in pure rotation.
"""

import math

import numpy as np

from .extremes import MAX_OSCILLATIONS, ExtremeCase, Levels, Section, balanced_levels, contact_section, tanh_section

SEED, CASES_PER_FAMILY = 20261123, 15
RADIUS, LENGTH = 0.02, 0.04  # m
CRANK_LENGTH, ROD_LENGTH, SLIDER_MASS = 0.05, 0.12, 0.14  # m, m, kg
FACTORS = {
    "speed": (60.0, 300.0, 1500.0, 3000.0, 6000.0),  # rpm
    "clearance": (1e-5, 3e-5, 1e-4, 2e-4, 5e-4),  # m
    "scarcity": (0.03, 0.1, 0.3, 1.0, 10.0),  # load over the film's load capacity at half the clearance
    "law": (0, 1, 2, 3, 4),  # of LAWS
    "mass": (0.1, 1.0, 1.0, 1.0, 10.0),  # factor on all masses and inertias
    "softness": (0.2, 0.4, 0.6, 0.8, 1.0),  # position of the stiffness in its range, as in `machines`
    "restitution": (0.05, 0.3, 0.5, 0.9, 1.0),
    "friction": (0.0, 0.0, 0.05, 0.1, 0.3),
    "width": (5e-7, 1e-6, 2e-6, 2e-6, 5e-6),  # m, of the transition
    "opening": (0, 0, 0, 1, 2),  # of OPENINGS
}
LAWS = ("finite", "short", "long", "pinkus-sternlicht", "reynolds")
OPENINGS = (("rod-slider",), ("crank-rod",), ("crank-rod", "rod-slider"))


def film_cases() -> list[ExtremeCase]:
    """Return all cases."""
    generator = np.random.default_rng(SEED)
    return [
        ExtremeCase(f"{family}/{number:02d} {_levels_text(levels)}", _grid(levels, dry=family == "mixed film"))
        for family in ("film", "mixed film")
        for number, levels in enumerate(balanced_levels(generator, FACTORS, CASES_PER_FAMILY))
    ]


def _levels_text(levels: Levels) -> str:
    """Return the main levels of a case in words."""
    law, joints = LAWS[int(levels["law"])], " and ".join(OPENINGS[int(levels["opening"])])
    return f"{law} in {joints}, {levels['speed']:g} rpm, {levels['clearance']:.0e} m, load {levels['scarcity']:g}"


def _grid(levels: Levels, *, dry: bool) -> Section:
    """Return the grid of a slider-crank with films, and with dry contact behind them if `dry`."""
    mass, rate = levels["mass"], levels["speed"] * math.pi / 30.0
    load = 0.65 * mass * (9.81 + 0.05 * rate**2)
    joint = _joint(levels, load, dry=dry)
    return {
        "mechanism": {
            "type": "slider-crank",
            "crank": {"length": CRANK_LENGTH, "mass": 0.3 * mass, "inertia": 1e-4 * mass},
            "rod": {"length": ROD_LENGTH, "mass": 0.21 * mass, "inertia": 2.5e-4 * mass},
            "slider": {"mass": SLIDER_MASS * mass},
            "gravity": 9.81,
        },
        "drive": {"speed": rate},
        "joints": dict.fromkeys(OPENINGS[int(levels["opening"])], joint),
        "simulate": {"revolutions": 2, "discard": 0},
        "save": {"orbits": "none"},
    }


def _joint(levels: Levels, load: float, *, dry: bool) -> Section:
    """Return a joint whose film at half its clearance carries `load` (N) over the scarcity at the crank's speed."""
    rate, clearance = levels["speed"] * math.pi / 30.0, levels["clearance"]
    capacity = 2.6 * LENGTH * RADIUS**3 / clearance**2 * rate  # N per Pa s, for length / diameter 1, to an order
    film: Section = {"law": LAWS[int(levels["law"])], "viscosity": load / (levels["scarcity"] * capacity)}
    joint: Section = {"clearance": clearance, "bearing_radius": RADIUS, "length": LENGTH, "film": film}
    if not dry:
        return joint
    film["transition"] = {"width": levels["width"]}
    min_stiffness = max(1e5, load / 5e-4**1.5)
    max_stiffness = ((MAX_OSCILLATIONS * rate) ** 2 * SLIDER_MASS * levels["mass"] / (1.5 * load ** (1.0 / 3.0))) ** 1.5
    stiffness = min_stiffness * (min(max(max_stiffness, min_stiffness), 1e14) / min_stiffness) ** levels["softness"]
    joint["contact"] = contact_section(stiffness, levels["restitution"])
    return joint | ({"friction": tanh_section(levels["friction"], 1e-2)} if levels["friction"] else {})
