"""Cases of the stability table with spatial joints: a factorial drawn once, by a seed.

There are CASES_PER_FORM cases of each form; in every factor each level occurs equally often in each form, in random
order. Stiffness is chosen as for `machines`; misalignment is a share of the tilt that jams the journal.
"""

import math

import numpy as np

from .extremes import MAX_OSCILLATIONS, ExtremeCase, Section, contact_section, tanh_section

SEED, CASES_PER_FORM = 20261122, 8
RADIUS, LENGTH = 0.01, 0.02  # m, of the bearing
FACTORS = {
    "speed": (30.0, 300.0, 1500.0, 6000.0),  # rpm
    "clearance": (3e-6, 3e-5, 2e-4, 1e-3),  # m
    "axial": (0.3, 1.0, 3.0, 10.0),  # axial clearance over the radial one
    "restitution": (0.05, 0.5, 0.9, 1.0),
    "softness": (0.0, 0.33, 0.67, 1.0),  # position of the stiffness on the logarithmic scale from softest to stiffest
    "friction": (0.0, 0.0, 0.1, 0.5),
    "mass": (0.1, 1.0, 1.0, 30.0),  # factor on all masses and inertias
    "tilt": (0.0, 0.1, 0.3, 0.7),  # share of the tilt that the clearances allow
}
#: The open joint, the freedoms of the other one, and whether there are flanges.
FORMS = {
    "flanges": ("crank-rod", "spherical", True),
    "edges": ("crank-rod", "spherical", False),
    "sleeve": ("crank-rod", "cylindrical", True),
    "slider's pin": ("rod-slider", "spherical", True),
}
Levels = dict[str, float]


def spatial_cases() -> list[ExtremeCase]:
    """Return all cases."""
    generator, cases = np.random.default_rng(SEED), []
    for name, (clearance_joint, freedoms, flange) in FORMS.items():
        columns = {
            key: generator.permutation(np.tile(values, CASES_PER_FORM // len(values)))
            for key, values in FACTORS.items()
        }
        for number in range(CASES_PER_FORM):
            levels = {key: float(column[number]) for key, column in columns.items()}
            grid = _grid(levels, clearance_joint, freedoms)
            grid["joints"][clearance_joint] |= _axial_sections(levels, flange=flange)
            cases.append(ExtremeCase(f"in space/{name} {number} {_levels_text(levels)}", grid))
    return cases


def _levels_text(levels: Levels) -> str:
    """Return the main levels of a case in words."""
    return f"{levels['speed']:g} rpm, {levels['clearance']:.0e} m, e {levels['restitution']:g}, tilt {levels['tilt']:g}"


def _axial_sections(levels: Levels, *, flange: bool) -> Section:
    """Return flanges, or a journal that extends beyond its bearing, and the misalignment of the bearing."""
    axial = levels["axial"] * levels["clearance"]
    jam_tilt = min(levels["clearance"] / (0.5 * LENGTH), axial / RADIUS if flange else math.inf)
    tilt = [0.8 * levels["tilt"] * jam_tilt, 0.6 * levels["tilt"] * jam_tilt]
    if flange:
        return {"flange": True, "axial_clearance": axial, "tilt": tilt}
    return {"flange": False, "journal_length": 1.5 * LENGTH, "tilt": tilt}


def _grid(levels: Levels, clearance_joint: str, freedoms: str) -> Section:
    """Return the grid of a spatial slider-crank; `freedoms` : of its ideal joint."""
    rate, mass = levels["speed"] * math.pi / 30.0, levels["mass"]
    load = 0.65 * mass * (9.81 + 0.05 * rate**2)
    min_stiffness = max(1e5, load / min(5e-4, levels["clearance"] * 10.0) ** 1.5)
    max_stiffness = ((MAX_OSCILLATIONS * rate) ** 2 * 0.14 * mass / (1.5 * load ** (1.0 / 3.0))) ** 1.5
    stiffness = min_stiffness * (min(max(max_stiffness, min_stiffness), 1e14) / min_stiffness) ** levels["softness"]
    (ideal_joint,) = {"crank-rod", "rod-slider"} - {clearance_joint}
    joint = {
        "type": "spatial",
        "clearance": levels["clearance"],
        "bearing_radius": RADIUS,
        "length": LENGTH,
        "contact": contact_section(stiffness, levels["restitution"]) | {"onset": "first"},
        "friction": tanh_section(levels["friction"], 1e-2),
    }
    return {
        "mechanism": {
            "type": "slider-crank",
            "spatial": True,
            "crank": {"length": 0.05, "mass": 0.3 * mass, "inertia": 1e-4 * mass},
            "rod": {"length": 0.12, "mass": 0.21 * mass, "inertia": [2e-5 * mass, 2.5e-4 * mass, 2.5e-4 * mass]},
            "slider": {"mass": 0.14 * mass},
            "gravity": [0.0, -9.81, 0.0],
            "ideal": {ideal_joint: freedoms},
        },
        "drive": {"speed": rate},
        "joints": {clearance_joint: joint},
        "simulate": {"revolutions": 2, "discard": 0},
        "save": {"orbits": "none"},
    }
