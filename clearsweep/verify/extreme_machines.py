"""Extreme cases of other machines, of joints in space, and of films."""

import math

import numpy as np

from .extremes import (
    MAX_OSCILLATIONS,
    ExtremeCase,
    Levels,
    Section,
    balanced_levels,
    contact_section,
    read_levels,
    tanh_section,
)

# ----------------------------------------------------------------------------------------------------------------------
# Cases of the stability table with loads, free cranks, four-bars, guides, elastic rods: a factorial drawn by a seed.
#
# Each family has CASES_PER_MACHINE cases.  In every factor each level occurs equally often, in random order: a balanced
# factorial. Stiffness is between that with a penetration of half a millimetre under load and that with MAX_OSCILLATIONS
# oscillations per revolution, as in the mixed cases of `extremes`.


MACHINE_SEED, CASES_PER_MACHINE = 20261122, 16
LINKS = {"crank": (0.05, 0.3, 1e-4), "rod": (0.12, 0.21, 2.5e-4), "rocker": (0.1, 0.25, 2.2e-4)}  # m, kg, kg m^2


def machine_cases() -> list[ExtremeCase]:
    """Return all cases."""
    families = {
        "loaded": _loaded_grid,
        "free crank": _free_crank_grid,
        "four-bar": _four_bar_grid,
        "guide": _guide_grid,
        "elastic rod": _elastic_rod_grid,
    }
    generator = np.random.default_rng(MACHINE_SEED)
    text = "{speed:g} rpm, {clearance:.0e} m, e {restitution:g}, load {load:g}"
    return [
        ExtremeCase(f"{name}/{number:02d} {text.format(**levels)}", family(levels))
        for name, family in families.items()
        for number, levels in enumerate(
            balanced_levels(generator, read_levels()["factors"]["machines"], CASES_PER_MACHINE)
        )
    ]


def _link(name: str, levels: Levels) -> Section:
    """Return the section of a link of LINKS."""
    length, mass, inertia = LINKS[name]
    return {"length": length, "mass": mass * levels["mass"], "inertia": inertia * levels["mass"]}


def _load(levels: Levels) -> float:
    """Return the load (N) of weight and inertia on a joint, to an order."""
    return 0.65 * levels["mass"] * (9.81 + 0.05 * (levels["speed"] * math.pi / 30.0) ** 2)


def _contact(levels: Levels, load: float, deepest: float = 5e-4) -> Section:
    """Return the contact at the `softness` of its range of stiffness.

    In the range the penetration under the `load` (N) is at most `deepest` (m), and there are at most MAX_OSCILLATIONS.
    """
    rate, min_stiffness = levels["speed"] * math.pi / 30.0, max(1e5, load / deepest**1.5)
    max_stiffness = ((MAX_OSCILLATIONS * rate) ** 2 * SLIDER_MASS * levels["mass"] / (1.5 * load ** (1.0 / 3.0))) ** 1.5
    stiffness = min_stiffness * (min(max(max_stiffness, min_stiffness), 1e14) / min_stiffness) ** levels["softness"]
    return contact_section(stiffness, levels["restitution"])


def _machine_joint(levels: Levels) -> Section:
    """Return the joint with clearance."""
    joint: Section = {"clearance": levels["clearance"], "contact": _contact(levels, _load(levels) + levels["load"])}
    return joint | ({"friction": tanh_section(levels["friction"], 1e-2)} if levels["friction"] else {})


def _pin(levels: Levels) -> Section:
    """Return the joint with clearance of a pin."""
    return _machine_joint(levels) | {"bearing_radius": 0.01}


def _machine_grid(
    levels: Levels, mechanism: Section, joints: Section, loads: Section, drive: Section | None = None
) -> Section:
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
    slider = {"mass": SLIDER_MASS * levels["mass"], **slider}
    return {"type": "slider-crank", **{name: _link(name, levels) for name in ("crank", "rod")}, "slider": slider}


def _press_load(levels: Levels) -> Section:
    """Return a load that presses on the slider."""
    return {"press": {"on": "slider", "force": [-levels["load"], 0.1 * levels["load"]]}}


def _loaded_grid(levels: Levels) -> Section:
    """Return a slider-crank with a load on its slider."""
    return _machine_grid(levels, _slider_crank(levels), {"rod-slider": _pin(levels)}, _press_load(levels))


def _free_crank_grid(levels: Levels) -> Section:
    """Return a slider-crank with a motor, from half its speed, and a flywheel whose energy exceeds the load's work."""
    rate, load_torque = levels["speed"] * math.pi / 30.0, 0.1 * (levels["load"] + 0.7 * 9.81 * levels["mass"])
    motor = {"stall_torque": 2.0 * load_torque + 1.0, "no_load_speed": rate}
    flywheel = 2.0 * load_torque * 2.0 * math.pi / (0.25 * rate**2) + 1e-3 * levels["mass"]
    drive = {"motor": motor, "initial_speed": 0.5 * rate, "inertia": flywheel}
    return _machine_grid(levels, _slider_crank(levels), {"rod-slider": _pin(levels)}, _press_load(levels), drive)


def _four_bar_grid(levels: Levels) -> Section:
    """Return a four-bar with a brake on its rocker."""
    links = {"crank": _link("crank", levels), "coupler": _link("rod", levels), "rocker": _link("rocker", levels)}
    mechanism = {"type": "four-bar", "ground": {"length": 0.13}, **links}
    loads = {"brake": {"on": "rocker", "torque": -0.1 * levels["load"]}}
    return _machine_grid(levels, mechanism, {"coupler-rocker": _pin(levels)}, loads)


def _guide_grid(levels: Levels) -> Section:
    """Return a slider-crank with clearance in its guide."""
    joint = _machine_joint(levels) | {"length": 0.06, "height": 0.03}
    mechanism = _slider_crank(levels, inertia=5e-5 * levels["mass"])
    return _machine_grid(levels, mechanism, {"slider-ground": joint}, _press_load(levels))


def _elastic_rod_grid(levels: Levels) -> Section:
    """Return a slider-crank with an elastic rod: from as soft as rubber to ten times as stiff as steel."""
    mechanism = _slider_crank(levels)
    softness = levels["softness"] * (1.0 if levels["restitution"] < 0.8 else 0.5)
    damping = 0.1 if levels["restitution"] < 0.1 else 0.01
    mechanism["rod"]["elastic"] = {"axial_stiffness": 4e9 * 1e-4**softness, "segments": 4, "damping": damping}
    return _machine_grid(levels, mechanism, {"rod-slider": _pin(levels)}, _press_load(levels))


# ----------------------------------------------------------------------------------------------------------------------
# Cases of the stability table with spatial joints: a factorial drawn once, by a seed.
#
# There are CASES_PER_FORM cases of each form; in every factor each level occurs equally often in each form, in random
# order. Stiffness is chosen as for machines; misalignment is a share of the tilt that jams the journal.


SPATIAL_SEED, CASES_PER_FORM = 20261122, 8
SPATIAL_RADIUS, SPATIAL_LENGTH = 0.01, 0.02  # m, of the bearing
#: The open joint, the freedoms of the other one, and whether there are flanges.
FORMS = {
    "flanges": ("crank-rod", "spherical", True),
    "edges": ("crank-rod", "spherical", False),
    "sleeve": ("crank-rod", "cylindrical", True),
    "slider's pin": ("rod-slider", "spherical", True),
}


def spatial_cases() -> list[ExtremeCase]:
    """Return all cases."""
    generator, cases = np.random.default_rng(SPATIAL_SEED), []
    for name, (clearance_joint, freedoms, flange) in FORMS.items():
        for number, levels in enumerate(
            balanced_levels(generator, read_levels()["factors"]["spatial"], CASES_PER_FORM)
        ):
            grid = _spatial_grid(levels, clearance_joint, freedoms)
            grid["joints"][clearance_joint] |= _axial_sections(levels, flange=flange)
            text = "{speed:g} rpm, {clearance:.0e} m, e {restitution:g}, tilt {tilt:g}"
            cases.append(ExtremeCase(f"in space/{name} {number} {text.format(**levels)}", grid))
    return cases


def _axial_sections(levels: Levels, *, flange: bool) -> Section:
    """Return flanges, or a journal that extends beyond its bearing, and the misalignment of the bearing."""
    axial = levels["axial"] * levels["clearance"]
    jam_tilt = min(levels["clearance"] / (0.5 * SPATIAL_LENGTH), axial / SPATIAL_RADIUS if flange else math.inf)
    tilt = [0.8 * levels["tilt"] * jam_tilt, 0.6 * levels["tilt"] * jam_tilt]
    if flange:
        return {"flange": True, "axial_clearance": axial, "tilt": tilt}
    return {"flange": False, "journal_length": 1.5 * SPATIAL_LENGTH, "tilt": tilt}


def _spatial_grid(levels: Levels, clearance_joint: str, freedoms: str) -> Section:
    """Return the grid of a spatial slider-crank; `freedoms` : of its ideal joint."""
    rate, mass = levels["speed"] * math.pi / 30.0, levels["mass"]
    contact = _contact(levels, _load(levels), min(5e-4, levels["clearance"] * 10.0))
    (ideal_joint,) = {"crank-rod", "rod-slider"} - {clearance_joint}
    joint = {
        "type": "spatial",
        "clearance": levels["clearance"],
        "bearing_radius": SPATIAL_RADIUS,
        "length": SPATIAL_LENGTH,
        "contact": contact | {"onset": "first"},
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


# ----------------------------------------------------------------------------------------------------------------------
# Cases of the stability table with films: a factorial drawn once, by a seed, before the first run.
#
# There are two families of FILMS_PER_FAMILY cases: a film alone, which must carry the load, and a film with a dry
# joint behind it. In some of the latter the film is so thin that the dry joint carries most of the load.  In every
# factor each level occurs equally often.  The viscosity follows from the ratio of the load to the load capacity of the
# film at half its clearance in pure rotation.


FILM_SEED, FILMS_PER_FAMILY = 20261123, 15
FILM_RADIUS, FILM_LENGTH = 0.02, 0.04  # m
SLIDER_MASS = 0.14  # kg
FILM_LAWS = ("finite", "short", "long", "pinkus-sternlicht", "reynolds")
OPENINGS = (("rod-slider",), ("crank-rod",), ("crank-rod", "rod-slider"))


def film_cases() -> list[ExtremeCase]:
    """Return all cases."""
    generator = np.random.default_rng(FILM_SEED)
    return [
        ExtremeCase(
            f"{family}/{number:02d} {_film_levels_text(levels)}", _film_grid(levels, dry=family == "mixed film")
        )
        for family in ("film", "mixed film")
        for number, levels in enumerate(balanced_levels(generator, read_levels()["factors"]["films"], FILMS_PER_FAMILY))
    ]


def _film_levels_text(levels: Levels) -> str:
    """Return the main levels of a case in words."""
    law, joints = FILM_LAWS[int(levels["law"])], " and ".join(OPENINGS[int(levels["opening"])])
    return f"{law} in {joints}, {levels['speed']:g} rpm, {levels['clearance']:.0e} m, load {levels['scarcity']:g}"


def _film_grid(levels: Levels, *, dry: bool) -> Section:
    """Return the grid of a slider-crank with films, and with dry contact behind them if `dry`."""
    joint = _film_joint(levels, _load(levels), dry=dry)
    return {
        "mechanism": _slider_crank(levels) | {"gravity": 9.81},
        "drive": {"speed": levels["speed"] * math.pi / 30.0},
        "joints": dict.fromkeys(OPENINGS[int(levels["opening"])], joint),
        "simulate": {"revolutions": 2, "discard": 0},
        "save": {"orbits": "none"},
    }


def _film_joint(levels: Levels, load: float, *, dry: bool) -> Section:
    """Return a joint whose film at half its clearance carries `load` (N) over the scarcity at the crank's speed."""
    rate, clearance = levels["speed"] * math.pi / 30.0, levels["clearance"]
    # N per Pa s, for length / diameter 1, to an order
    capacity = 2.6 * FILM_LENGTH * FILM_RADIUS**3 / clearance**2 * rate
    film: Section = {"law": FILM_LAWS[int(levels["law"])], "viscosity": load / (levels["scarcity"] * capacity)}
    joint: Section = {"clearance": clearance, "bearing_radius": FILM_RADIUS, "length": FILM_LENGTH, "film": film}
    if not dry:
        return joint
    film["transition"] = {"width": levels["width"]}
    joint["contact"] = _contact(levels, load)
    return joint | ({"friction": tanh_section(levels["friction"], 1e-2)} if levels["friction"] else {})
