"""Cases of the stability table with loads, free cranks, four-bars, guides, elastic rods: a factorial drawn by a seed.

Each family has CASES_PER_FAMILY cases.  In every factor each level occurs equally often, in random order: a balanced
factorial. Stiffness is between that with a penetration of half a millimetre under load and that with MAX_OSCILLATIONS
oscillations per revolution, as in the mixed cases of `extremes`.
"""

import math

import numpy as np

from .extremes import MAX_OSCILLATIONS, ExtremeCase, Levels, Section, balanced_levels, contact_section, tanh_section

SEED, CASES_PER_FAMILY = 20261122, 16
LINKS = {"crank": (0.05, 0.3, 1e-4), "rod": (0.12, 0.21, 2.5e-4), "rocker": (0.1, 0.25, 2.2e-4)}  # m, kg, kg m^2
FACTORS = {
    "speed": (30.0, 300.0, 1500.0, 6000.0),  # rpm; of a free crank near its steady speed
    "clearance": (1e-6, 3e-5, 3e-4, 2e-3),  # m
    "restitution": (0.05, 0.5, 0.9, 1.0),
    "softness": (0.0, 0.33, 0.67, 1.0),  # position of the stiffness on the logarithmic scale from softest to stiffest
    "load": (0.0, 1.0, 30.0, 1000.0),  # N on the slider, or N m / 10 on the rocker
    "friction": (0.0, 0.0, 0.1, 0.5),
    "mass": (0.1, 1.0, 1.0, 30.0),  # factor on all masses and inertias
}


def machine_cases() -> list[ExtremeCase]:
    """Return all cases."""
    families = {
        "loaded": _loaded_grid,
        "free crank": _free_crank_grid,
        "four-bar": _four_bar_grid,
        "guide": _guide_grid,
        "elastic rod": _elastic_rod_grid,
    }
    generator = np.random.default_rng(SEED)
    return [
        ExtremeCase(f"{name}/{number:02d} {_levels_text(levels)}", family(levels))
        for name, family in families.items()
        for number, levels in enumerate(balanced_levels(generator, FACTORS, CASES_PER_FAMILY))
    ]


def _levels_text(levels: Levels) -> str:
    """Return the main levels of a case in words."""
    return f"{levels['speed']:g} rpm, {levels['clearance']:.0e} m, e {levels['restitution']:g}, load {levels['load']:g}"


def _link(name: str, levels: Levels) -> Section:
    """Return the section of a link of LINKS."""
    length, mass, inertia = LINKS[name]
    return {"length": length, "mass": mass * levels["mass"], "inertia": inertia * levels["mass"]}


def _joint(levels: Levels) -> Section:
    """Return the joint with clearance."""
    rate = levels["speed"] * math.pi / 30.0
    load = 0.65 * levels["mass"] * (9.81 + 0.05 * rate**2) + levels["load"]
    min_stiffness = max(1e5, load / 5e-4**1.5)
    max_stiffness = ((MAX_OSCILLATIONS * rate) ** 2 * 0.14 * levels["mass"] / (1.5 * load ** (1.0 / 3.0))) ** 1.5
    stiffness = min_stiffness * (min(max(max_stiffness, min_stiffness), 1e14) / min_stiffness) ** levels["softness"]
    joint: Section = {"clearance": levels["clearance"], "contact": contact_section(stiffness, levels["restitution"])}
    return joint | ({"friction": tanh_section(levels["friction"], 1e-2)} if levels["friction"] else {})


def _grid(levels: Levels, mechanism: Section, joints: Section, loads: Section, drive: Section | None = None) -> Section:
    """Return a grid of these sections; the default drive has constant speed."""
    return {
        "mechanism": mechanism | {"gravity": 9.81},
        "drive": drive or {"speed": levels["speed"] * math.pi / 30.0},
        **({"loads": loads} if loads else {}),
        "joints": joints,
        "simulate": {"revolutions": 2, "discard": 0},
        "save": {"orbits": "all", "samples": 2000},
    }


def _slider_crank(levels: Levels, **slider: float) -> Section:
    """Return the mechanism of a slider-crank; `slider` : further keys of its slider."""
    slider = {"mass": 0.14 * levels["mass"], **slider}
    return {"type": "slider-crank", **{name: _link(name, levels) for name in ("crank", "rod")}, "slider": slider}


def _press_load(levels: Levels) -> Section:
    """Return a load that presses on the slider."""
    return {"press": {"on": "slider", "force": [-levels["load"], 0.1 * levels["load"]]}}


def _loaded_grid(levels: Levels) -> Section:
    """Return a slider-crank with a load on its slider."""
    return _grid(
        levels, _slider_crank(levels), {"rod-slider": _joint(levels) | {"bearing_radius": 0.01}}, _press_load(levels)
    )


def _free_crank_grid(levels: Levels) -> Section:
    """Return a slider-crank with a motor, from half its speed, and a flywheel whose energy exceeds the load's work."""
    rate, load_torque = levels["speed"] * math.pi / 30.0, 0.1 * (levels["load"] + 0.7 * 9.81 * levels["mass"])
    motor = {"stall_torque": 2.0 * load_torque + 1.0, "no_load_speed": rate}
    flywheel = 2.0 * load_torque * 2.0 * math.pi / (0.25 * rate**2) + 1e-3 * levels["mass"]
    drive = {"motor": motor, "initial_speed": 0.5 * rate, "inertia": flywheel}
    joints = {"rod-slider": _joint(levels) | {"bearing_radius": 0.01}}
    return _grid(levels, _slider_crank(levels), joints, _press_load(levels), drive)


def _four_bar_grid(levels: Levels) -> Section:
    """Return a four-bar with a brake on its rocker."""
    links = {"crank": _link("crank", levels), "coupler": _link("rod", levels), "rocker": _link("rocker", levels)}
    mechanism = {"type": "four-bar", "ground": {"length": 0.13}, **links}
    loads = {"brake": {"on": "rocker", "torque": -0.1 * levels["load"]}}
    return _grid(levels, mechanism, {"coupler-rocker": _joint(levels) | {"bearing_radius": 0.01}}, loads)


def _guide_grid(levels: Levels) -> Section:
    """Return a slider-crank with clearance in its guide."""
    joint = _joint(levels) | {"length": 0.06, "height": 0.03}
    mechanism = _slider_crank(levels, inertia=5e-5 * levels["mass"])
    return _grid(levels, mechanism, {"slider-ground": joint}, _press_load(levels))


def _elastic_rod_grid(levels: Levels) -> Section:
    """Return a slider-crank with an elastic rod: from as soft as rubber to ten times as stiff as steel."""
    mechanism = _slider_crank(levels)
    softness = levels["softness"] * (1.0 if levels["restitution"] < 0.8 else 0.5)
    damping = 0.1 if levels["restitution"] < 0.1 else 0.01
    mechanism["rod"]["elastic"] = {"axial_stiffness": 4e9 * 1e-4**softness, "segments": 4, "damping": damping}
    return _grid(levels, mechanism, {"rod-slider": _joint(levels) | {"bearing_radius": 0.01}}, _press_load(levels))
