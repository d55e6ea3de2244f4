"""The cases of the stability table: stiff, extreme and degenerate ones, each with a name.

They span stiffness 1e5 to 1e14 N/m^1.5, clearance 1e-7 to 5e-3 m, restitution 0.01 to 1, speed 1 to 50,000 rpm,
friction 0 to 1, masses over four decades, one to three open joints.  Stiffness increases with speed so that the
penetration under load is smaller than the joint.  A contact has at most some 1e5 oscillations per revolution, except in
the group `dear`, whose cases may need more steps than the budget.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import resources
from typing import Any, NamedTuple

import numpy as np
from ruamel.yaml import YAML

from .. import grid
from ..contracts.case import column_name
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from .reference_run import with_values

JOINTS = ("ground-crank", "crank-rod", "rod-slider")
JOINT_BY_LETTER = dict(zip("ABC", JOINTS, strict=True))
OPENINGS = ("A", "B", "C", "AB", "AC", "BC", "ABC")
#: Keys of a case that are no arguments of `slider_crank_grid`, see `case_of`.
CASE_KEYS = (
    *("opening", "stiffness", "restitution", "damping", "friction", "coefficient", "velocity_scale"),
    *("forward", "sideways", "tuning", "tuned", "low", "high", "label"),
)
MIXED_CASE_COUNT, SEED = 48, 20240229  # drawn at random with a fixed seed
SURFACES = ("johnson/fractal", "compatible/kogut-etsion", "compatible/", "power/fractal")  # elastic law/roughness
ROUGH_CASE_COUNT, ROUGH_SEED = 10, 20261122
MAX_OSCILLATIONS = 5e4  # largest number of oscillations in contact per revolution of a mixed case

Section = dict[str, Any]  # of a grid, in SI


Levels = dict[str, Any]  # factor -> level: a number, or a word


class ExtremeCase(NamedTuple):
    """A case of the stability table."""

    name: str  # group/description
    grid: Section
    displacement: tuple = ()  # clearances by which the slider, and lengths of the rod's end, are displaced at the start
    tuning: tuple = ()  # (kind: graze or meet, dotted path, low, high): found by bisection, see `tune_case`

    @property
    def group(self) -> str:
        """Return the name of the group."""
        return self.name.split("/", maxsplit=1)[0]


def contact_section(stiffness: float = 6.61e10, restitution: float = 0.9) -> Section:
    """Return a contact section whose free impact has exactly this `restitution`."""
    return {"law": "exact", "stiffness": stiffness, "restitution": restitution}


def tanh_section(coefficient: float, scale: float = 1e-3) -> Section:
    """Return a friction section."""
    return {"law": "tanh", "coefficient": coefficient, "velocity_scale": scale}


def slider_crank_grid(  # noqa: PLR0913 - parameters that differ between cases, by name
    opening: str,
    *,
    speed: float = 5000.0,
    contact: Section | None = None,
    clearance: float = 5e-4,
    friction: Section | None = None,
    mass_factor: float = 1.0,
    slider_mass: float = 0.14,
    gravity: float = 0.0,
    start: str = "centred",
) -> Section:
    """Return a grid of a slider-crank open at the joints given by the letters of `opening`.

    `speed` : rpm; `mass_factor` : on all masses and inertias; `slider_mass` : kg; `contact` : section of the contact.
    """
    joint: Section = {"clearance": clearance, "bearing_radius": 0.01, "contact": contact or contact_section()}
    if friction:
        joint["friction"] = friction
    levels = {"speed": speed, "mass": mass_factor}
    mechanism = _slider_crank(levels, mass=slider_mass * mass_factor) | {"gravity": gravity}
    joints = {JOINT_BY_LETTER[letter]: dict(joint) for letter in opening}
    simulation = {"revolutions": 2, "discard": 0, "start": start}
    return _machine_grid(levels, mechanism, joints, {}) | {"simulate": simulation, "save": {"orbits": "none"}}


def impact_pair_grid(
    stiffness: float,
    restitution: float,
    masses: tuple[float, float] = (0.2, 0.2),
    speed: float = 1.0,
    clearance: float = 1e-3,
) -> Section:
    """Return a grid of two bodies that bounce ten times."""
    return {
        "mechanism": {"type": "impact-pair", "masses": list(masses), "speed": speed},
        "joints": {"pair": {"clearance": clearance, "contact": contact_section(stiffness, restitution)}},
        "simulate": {"impacts": 10},
        "save": {"orbits": "none"},
    }


def balanced_levels(
    generator: np.random.Generator, factors: Mapping[str, Sequence[Any]], count: int
) -> Iterator[Levels]:
    """Yield `count` combinations of the levels of all factors: each level as often as the others, in random order."""
    columns = {name: generator.permutation(np.tile(values, count // len(values))) for name, values in factors.items()}
    for row in range(count):
        yield {name: column[row].item() for name, column in columns.items()}


def extreme_cases() -> list[ExtremeCase]:
    """Return all cases of the table except those of other machines, of joints in space and of films."""
    return [
        *cases_of("table"),
        *_mixed_cases(),
        *cases_of("pairs"),
        *_rough_cases(),
        *cases_of("dear"),
    ]


def cases_of(part: str) -> list[ExtremeCase]:
    """Return the cases of a part of `references/extremes.yaml`: one for each combination of levels of each group."""
    cases = []
    for entry in read_levels()[part]:
        axes = [
            [{key: value} for key, values in axis.items() for value in values] if isinstance(axis, dict) else axis
            for axis in entry.get("vary", [])
        ]
        for combination in itertools.product(*axes):
            levels = entry.get("with", {}) | {key: value for level in combination for key, value in level.items()}
            cases.append(case_of(entry["group"], entry["text"].format(**levels), dict(levels)))
    return cases


@functools.cache
def read_levels() -> dict[str, Any]:
    """Return the content of `references/extremes.yaml`."""
    file = resources.files(__package__) / "references" / "extremes.yaml"
    content: dict[str, Any] = YAML(typ="safe", pure=True).load(file.read_text(encoding="utf-8"))
    return content


def case_of(group: str, text: str, levels: Section) -> ExtremeCase:
    """Return the case with these levels, from which what it uses is taken.

    `opening` : the open joints; `damping` : of a linear contact; `stiffness`, `restitution` : of any other;
    `friction` : its law, with `coefficient` and `velocity_scale`; `forward`, `sideways` : displacement of the slider at
    the start, in clearances; `tuning` : graze or meet, by the clearance of joint `tuned` between `low` and `high`;
    `label` : words for the text.  All others are arguments of `slider_crank_grid`, or of `impact_pair_grid`.
    """
    if "opening" not in levels:
        return ExtremeCase(f"{group}/{text}", impact_pair_grid(**levels))
    taken = {key: levels.pop(key) for key in CASE_KEYS if key in levels}
    contact = {key: taken[key] for key in ("stiffness", "restitution") if key in taken}
    voigt = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": taken.get("damping")}  # N/m, N s/m
    levels["contact"] = voigt if "damping" in taken else contact_section(**contact)
    if "friction" in taken:
        law = {"tanh": {"velocity_scale": taken.get("velocity_scale", 1e-3)}, "ambrosio": {"v0": 1e-3, "v1": 1e-2}}
        coefficient = taken["coefficient"]
        levels["friction"] = {"law": taken["friction"], "coefficient": coefficient} | law[taken["friction"]]
    tuning: tuple = ()
    if "tuning" in taken:
        path = f"joints.{JOINT_BY_LETTER[taken['tuned']]}.clearance"
        tuning = taken["tuning"], path, taken["low"], taken["high"]
    displacement = (taken["forward"], taken["sideways"]) if "forward" in taken else ()
    return ExtremeCase(
        f"{group}/{taken['opening']} {text}", slider_crank_grid(taken["opening"], **levels), displacement, tuning
    )


def _mixed_cases() -> Iterator[ExtremeCase]:
    """Yield cases in which all quantities differ."""
    generator = np.random.default_rng(SEED)
    for number in range(MIXED_CASE_COUNT):
        opening = OPENINGS[number % len(OPENINGS)]
        speed = 10.0 ** generator.uniform(0.0, math.log10(5e4))
        clearance = 10.0 ** generator.uniform(-7.0, math.log10(5e-3))
        mass_factor = 10.0 ** generator.uniform(-2.0, 2.0)
        restitution = float(generator.choice([0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0]))
        coefficient, gravity = float(generator.choice([0.0, 0.05, 0.3, 1.0])), float(generator.choice([0.0, 9.81]))
        levels = {"speed": speed, "mass": mass_factor, "restitution": restitution, "softness": generator.uniform()}
        friction = tanh_section(coefficient, 1e-2) if coefficient else None
        grid = slider_crank_grid(
            opening,
            speed=speed,
            contact=_contact(levels, _load(levels, gravity)),
            clearance=clearance,
            mass_factor=mass_factor,
            friction=friction,
            gravity=gravity,
        )
        yield ExtremeCase(f"mixed/{number:02d} {opening}", grid)


def _rough_cases() -> Iterator[ExtremeCase]:
    """Yield rough and conformal joints in which all quantities differ."""
    generator = np.random.default_rng(ROUGH_SEED)
    for number in range(ROUGH_CASE_COUNT):
        elastic_law, _, roughness_law = SURFACES[number % len(SURFACES)].partition("/")
        speed, clearance = 10.0 ** generator.uniform(1.8, 4.0), 10.0 ** generator.uniform(-5.3, -3.0)
        texture = {"dimension": generator.uniform(1.1, 1.9), "scale": 10.0 ** generator.uniform(-13.0, -8.0)}
        hardness, young = 10.0 ** generator.uniform(8.0, 10.0), 10.0 ** generator.uniform(9.0, 11.6)
        restitution = float(generator.choice([0.01, 0.1, 0.5, 0.9, 1.0]))
        coefficient = float(generator.choice([0.0, 0.1, 0.5]))
        contact = {"law": "exact", "elastic": elastic_law, "restitution": restitution}
        contact["material"] = {"young": young, "poisson": 0.3}
        friction = tanh_section(coefficient, 1e-2) if coefficient else None
        grid = slider_crank_grid(
            "C", speed=speed, contact=contact, clearance=clearance, friction=friction, gravity=9.81
        )
        grid["joints"][JOINT_BY_LETTER["C"]]["length"] = 0.02
        if roughness_law:
            grid["joints"][JOINT_BY_LETTER["C"]]["roughness"] = {"law": roughness_law, "hardness": hardness, **texture}
        yield ExtremeCase(f"rough/{number:02d} {elastic_law}{' ' * bool(roughness_law)}{roughness_law}", grid)


# ----------------------------------------------------------------------------------------------------------------------
# Tunes a parameter of a case by bisection, until a contact just grazes or two joints touch at the same time.


TUNED_REVOLUTIONS = 0.25  # revolutions within which the onsets are compared
SCAN_VALUES = 64  # values of the parameter between which a change of the count of onsets is searched for
MAX_HALVINGS = 60
GRAZE_RATIO = 1e-4  # of the largest onset rate: a graze closes slower


def tune_case(case: ExtremeCase) -> tuple[dict[str, Any], str]:
    """Return the grid of a case with its tuned parameter, and a note with the value."""
    kind, path, low, high = case.tuning
    search = _find_graze if kind == "graze" else _find_meeting
    value, remark = search(case, path, low, high)
    return with_values(case.grid, {path: value}), f"{path} = {value!r}; {remark}"


def find_onsets(source: dict[str, Any], path: str, value: float) -> np.ndarray:
    """Return the event log's onsets within TUNED_REVOLUTIONS revolutions."""
    shortened = with_values(source, {path: value, "simulate.revolutions": TUNED_REVOLUTIONS})
    events = simulate(scene.build(grid.load(shortened, scene.catalogue()).case(0)), times=[0.0]).events
    onsets: np.ndarray = events[events["kind"] == "on"]
    return onsets


def bisect(predicate: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """Return neighbours between `low`, where `predicate` is true, and `high`, where it is not."""
    for _ in range(MAX_HALVINGS):
        midpoint = 0.5 * (low + high)
        if midpoint in (low, high):
            break
        low, high = (midpoint, high) if predicate(midpoint) else (low, midpoint)
    return low, high


def _find_graze(case: ExtremeCase, path: str, low: float, high: float) -> tuple[float, str]:
    """Return the value at which an onset is about to vanish, closing ever slower."""
    values = np.geomspace(low, high, SCAN_VALUES)
    counts = [len(find_onsets(case.grid, path, value)) for value in values]
    for i in np.flatnonzero(np.diff(counts)):
        smaller_count = counts[i] if counts[i] < counts[i + 1] else counts[i + 1]
        bounds = (values[i], values[i + 1]) if counts[i] > smaller_count else (values[i + 1], values[i])

        def has_more(value: float, fewer: int = smaller_count) -> bool:
            return len(find_onsets(case.grid, path, value)) > fewer

        value, _ = bisect(has_more, *bounds)
        rates = find_onsets(case.grid, path, value)["rate"]
        if rates.min() < GRAZE_RATIO * rates.max():  # else an onset crossed the horizon
            return float(value), f"onset at {rates.min():.1e} m/s after {rates.max():.1e} m/s"
    raise LookupError(f"{case.name}: no graze between {low:g} and {high:g}")


def _find_meeting(case: ExtremeCase, path: str, low: float, high: float) -> tuple[float, str]:
    """Return the clearance at which the first onset of its joint falls upon one of the other joint."""
    joint = column_name(path.split(".")[1])

    def onsets_before(value: float) -> int:  # onsets of the other joint before the first one of this
        log = find_onsets(case.grid, path, value)
        own_rows = np.flatnonzero(log["joint"] == joint)
        return int(own_rows[0]) if own_rows.size else len(log)

    values = np.geomspace(low, high, SCAN_VALUES)
    counts = [onsets_before(value) for value in values]
    for i in np.flatnonzero(np.diff(counts)):
        if counts[i + 1] < counts[i]:
            continue

        def has_at_most(value: float, count: int = counts[i]) -> bool:
            return onsets_before(value) <= count

        value, _ = bisect(has_at_most, values[i], values[i + 1])
        log = find_onsets(case.grid, path, value)
        own_times, other_times = (log["t"][log["joint"] == joint], log["t"][log["joint"] != joint])
        if own_times.size and other_times.size > counts[i]:
            return float(value), f"onsets {abs(own_times[0] - other_times[counts[i]]):.1e} s apart"
    raise LookupError(f"{case.name}: no onsets of two joints meet between {low:g} and {high:g} m")


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
    text = "{}/{:02d} {speed:g} rpm, {clearance:.0e} m, e {restitution:g}, load {load:g}"
    return _drawn_cases("machines", (MACHINE_SEED, CASES_PER_MACHINE), families, text)


def _drawn_cases(
    factors: str, seed_and_count: tuple[int, int], families: Mapping[str, Callable[[Levels], Section]], text: str
) -> list[ExtremeCase]:
    """Return as many cases of each family, with the levels of `factors` drawn by a seed.

    text : their names, with family, number and levels in place of braces
    """
    seed, count = seed_and_count
    generator, levels_of_factors = np.random.default_rng(seed), read_levels()["factors"][factors]
    return [
        ExtremeCase(text.format(name, number, **levels), family(levels))
        for name, family in families.items()
        for number, levels in enumerate(balanced_levels(generator, levels_of_factors, count))
    ]


def _link(name: str, levels: Levels) -> Section:
    """Return the section of a link of LINKS."""
    length, mass, inertia = LINKS[name]
    return {"length": length, "mass": mass * levels["mass"], "inertia": inertia * levels["mass"]}


def _load(levels: Levels, gravity: float = 9.81) -> float:
    """Return the load (N) of weight and inertia on a joint, to an order."""
    return float(0.65 * levels["mass"] * (gravity + 0.05 * (levels["speed"] * math.pi / 30.0) ** 2))


def _contact(levels: Levels, load: float, deepest: float = 5e-4) -> Section:
    """Return the contact at the `softness` of its range of stiffness.

    In the range the penetration under the `load` (N) is at most `deepest` (m), and there are at most MAX_OSCILLATIONS:
    small ones have the frequency sqrt(1.5 K^(2/3) F^(1/3) / m).
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
        "mechanism": {"gravity": 9.81} | mechanism,
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
    families = {name: functools.partial(_spatial_grid, form=form) for name, form in FORMS.items()}
    text = "in space/{} {} {speed:g} rpm, {clearance:.0e} m, e {restitution:g}, tilt {tilt:g}"
    return _drawn_cases("spatial", (SPATIAL_SEED, CASES_PER_FORM), families, text)


def _axial_sections(levels: Levels, *, flange: bool) -> Section:
    """Return flanges, or a journal that extends beyond its bearing, and the misalignment of the bearing."""
    axial = levels["axial"] * levels["clearance"]
    jam_tilt = min(levels["clearance"] / (0.5 * SPATIAL_LENGTH), axial / SPATIAL_RADIUS if flange else math.inf)
    tilt = [0.8 * levels["tilt"] * jam_tilt, 0.6 * levels["tilt"] * jam_tilt]
    if flange:
        return {"flange": True, "axial_clearance": axial, "tilt": tilt}
    return {"flange": False, "journal_length": 1.5 * SPATIAL_LENGTH, "tilt": tilt}


def _spatial_grid(levels: Levels, form: tuple[str, str, bool]) -> Section:
    """Return the grid of a spatial slider-crank of one of FORMS."""
    clearance_joint, freedoms, flange = form
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
    mechanism = _slider_crank(levels)
    mechanism["rod"]["inertia"] = [2e-5 * levels["mass"], mechanism["rod"]["inertia"], mechanism["rod"]["inertia"]]
    mechanism |= {"spatial": True, "gravity": [0.0, -9.81, 0.0], "ideal": {ideal_joint: freedoms}}
    joints = {clearance_joint: joint | _axial_sections(levels, flange=flange)}
    return _machine_grid(levels, mechanism, joints, {}) | {"save": {"orbits": "none"}}


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


def film_cases() -> list[ExtremeCase]:
    """Return all cases."""
    families = {name: functools.partial(_film_grid, dry=name == "mixed film") for name in ("film", "mixed film")}
    text = "{}/{:02d} {law} in {joints}, {speed:g} rpm, {clearance:.0e} m, load {scarcity:g}"
    return _drawn_cases("films", (FILM_SEED, FILMS_PER_FAMILY), families, text)


def _film_grid(levels: Levels, *, dry: bool) -> Section:
    """Return the grid of a slider-crank with films, and with dry contact behind them if `dry`.

    The film at half its clearance carries the load over the scarcity at the crank's speed.
    """
    rate, clearance, load = levels["speed"] * math.pi / 30.0, levels["clearance"], _load(levels)
    # N per Pa s, for length / diameter 1, to an order
    capacity = 2.6 * FILM_LENGTH * FILM_RADIUS**3 / clearance**2 * rate
    film: Section = {"law": levels["law"], "viscosity": load / (levels["scarcity"] * capacity)}
    joint: Section = {"clearance": clearance, "bearing_radius": FILM_RADIUS, "length": FILM_LENGTH, "film": film}
    if dry:
        film["transition"] = {"width": levels["width"]}
        joint |= {"contact": _contact(levels, load)}
        joint |= {"friction": tanh_section(levels["friction"], 1e-2)} if levels["friction"] else {}
    joints = dict.fromkeys(levels["joints"].split(" and "), joint)
    return _machine_grid(levels, _slider_crank(levels), joints, {}) | {"save": {"orbits": "none"}}
