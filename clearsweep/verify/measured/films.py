"""Benchmarks of films at rest in their load: tables of bearings, with stiffness, damping and whirl threshold."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...contracts.results import Trajectory
from ...mechanics.joints import registry
from ...mechanics.joints.dry import Gap
from ...mechanics.joints.lubricated import film_load
from ...simulation.setup.scene import load_case
from ..text import style_axes
from .points import (
    LINE_STYLES,
    REFERENCE_STYLE,
    Benchmark,
    Reference,
    Row,
    read_grid,
    read_reference,
    run,
)

# ----------------------------------------------------------------------------------------------------------------------
# A bearing whose housing translates without rotation, around a shaft at constant speed: a film test rig.


def bearing_grid(
    joint: dict[str, Any], speed: float, load: float, *, mass: float, revolutions: float
) -> dict[str, Any]:
    """Return the grid of a rig: joint, shaft speed (rad/s), downward load (N) and mass (kg) of the housing."""
    length = {"simulate.revolutions": revolutions, "simulate.discard": revolutions - 1.0}
    forces = {"mechanism.bodies.housing.mass": mass, "loads.weight.force": [0.0, -load]}
    return read_grid("rig", {"joints.film": joint, "drive.speed": speed, **forces, **length})


def film_joint(law: str, viscosity: float, slenderness: float, radius: float, clearance: float) -> dict[str, Any]:
    """Return a joint of this length / diameter that has a film and no contact law."""
    film = {"law": law, "viscosity": viscosity}
    return {"clearance": clearance, "bearing_radius": radius, "length": 2.0 * radius * slenderness, "film": film}


run_bearing = partial(run, failure="a rig did not run")


def attitude(trajectory: Trajectory) -> float:
    """Return the angle (rad) from the upward load on the journal to its eccentricity, at the end of a run."""
    x, y = trajectory["joints/film/x"][-1], trajectory["joints/film/y"][-1]
    return float(np.arctan2(-x, y))


def eccentricity(trajectory: Trajectory) -> float:
    """Return the eccentricity (m) of the journal at the end of a run."""
    return float(np.hypot(trajectory["joints/film/x"][-1], trajectory["joints/film/y"][-1]))


def torque(trajectory: Trajectory) -> float:
    """Return the torque (N m) on the shaft at the end of a run."""
    return float(trajectory["drive/torque"][-1])


# ----------------------------------------------------------------------------------------------------------------------
# A film in equilibrium with its load: a run settles at the tabulated eccentricity, attitude and friction.


AT_REST = "Films at rest in their load"
RADIUS, CLEARANCE, VISCOSITY, SPEED = 0.02, 2e-5, 0.01, 100.0  # m, m, Pa s, rad/s: without effect on the figures
MASS = 0.01  # kg: light enough to prevent whirl
REVOLUTIONS = 30
_LONG_BEARING_LAWS, _SHORT_BEARING_LAWS = ("reynolds", "finite"), ("reynolds", "finite", "short")
TABLED_LAWS = {
    "1": _LONG_BEARING_LAWS,
    "0.5": _LONG_BEARING_LAWS,
    "0.4": _LONG_BEARING_LAWS,
    "0.333333": _LONG_BEARING_LAWS,
    "0.25": _SHORT_BEARING_LAWS,
    "0.2": _SHORT_BEARING_LAWS,
}
DRAWN_SLENDERNESSES = ("1", "0.5", "0.25")  # length / diameter


def load_of(slenderness: float, sommerfeld: float) -> float:
    """Return the load (N) of a bearing of this length / diameter: F = So L D mu w / psi^2."""
    return sommerfeld * slenderness * (2.0 * RADIUS) ** 2 * VISCOSITY * SPEED * (RADIUS / CLEARANCE) ** 2


def grid_of(law: str, slenderness: float, sommerfeld: float) -> dict[str, Any]:
    """Return the grid of a bearing of this length / diameter under its load."""
    joint = film_joint(law, VISCOSITY, slenderness, RADIUS, CLEARANCE)
    return bearing_grid(joint, SPEED, load_of(slenderness, sommerfeld), mass=MASS, revolutions=REVOLUTIONS)


def equilibrium_of(law: str, slenderness: float, sommerfeld: float) -> dict[str, float]:
    """Return the equilibrium of a bearing of this length / diameter under its load."""
    load = load_of(slenderness, sommerfeld)
    trajectory = run_bearing(grid_of(law, slenderness, sommerfeld))
    return {
        "eccentricity ratio": eccentricity(trajectory) / CLEARANCE,
        "attitude": math.degrees(attitude(trajectory)),
        "friction variable": torque(trajectory) / (load * CLEARANCE),
    }


def measure_at_rest(*, quick: bool = False) -> list[Row]:
    """Return the rows of both tables."""
    rows = _rows_at_rest(
        read_reference(AT_REST, "butenschoen"), lambda number: number, TABLED_LAWS, stride=8 if quick else 1
    )
    if quick:
        return rows
    laws = dict.fromkeys(TABLED_LAWS, ("reynolds",))
    return rows + _rows_at_rest(read_reference(AT_REST, "raimondi-boyd"), lambda s: 0.5 / (math.pi * s), laws)


def _rows_at_rest(
    table: Reference, to_sommerfeld: Callable[[float], float], laws: Mapping[str, tuple[str, ...]], stride: int = 1
) -> list[Row]:
    """Return the rows of a table; `to_sommerfeld` converts its load number to So."""
    rows: list[Row] = []
    for point in table.names[::stride]:
        slenderness, _, number = (number_text.rpartition(" ")[2] for number_text in point.split(", "))
        for law in laws[slenderness]:
            computed = equilibrium_of(law, float(slenderness), to_sommerfeld(float(number)))
            rows += table.rows_at({point: computed}, law)
    return rows


def draw_at_rest(rows: list[Row]) -> Figure:
    """Draw attitude over eccentricity ratio."""
    page = Figure(figsize=(9.0, 3.4), layout="constrained")
    panels = page.subplots(1, 3, sharey=True)
    for panel, slenderness in zip(panels, DRAWN_SLENDERNESSES, strict=True):
        selected = [row for row in rows if row.point.startswith(f"L/D {slenderness},") and row.kind == "published"]
        names = ("eccentricity ratio", "attitude")
        for law in TABLED_LAWS[slenderness]:
            rows_of_law = [row for row in selected if row.variant == law]
            points = ([row.computed for row in rows_of_law if row.quantity == name] for name in names)
            panel.plot(*points, **LINE_STYLES[law], label=law)
        table = [row for row in selected if row.variant == "reynolds"]
        values = ([row.reference for row in table if row.quantity == name] for name in names)
        panel.plot(*values, **REFERENCE_STYLE, label="Butenschoen 1976")
        panel.set(title=f"length / diameter {slenderness}", xlabel="eccentricity ratio [1]")
        style_axes(panel)
    panels[0].set_ylabel("attitude [deg]")
    panels[-1].legend(frameon=False)
    return page


FILMS_AT_REST = Benchmark("film_at_rest", AT_REST, measure_at_rest, draw_at_rest)


# ----------------------------------------------------------------------------------------------------------------------
# Stiffness and damping of a film in equilibrium with its load: the slope of its force there.


STEP = 1e-5  # of the clearance, and of clearance times speed; the error of central differences is quadratic in it
AXES = ("x", "y")


def film_coefficients(
    law: str, slenderness: float, sommerfeld: float, ratio: float, attitude: float
) -> dict[str, float]:
    """Return stiffness K (W / c) and damping B (W / (c w)) of a film with a journal in equilibrium.

    ratio, attitude : eccentricity ratio and angle (rad) from the load to the eccentricity, in the sense of rotation.

    x is along the load, y rotated from it by 90 degrees with the shaft: K_xy = -dF_x / dy c / W, B_xy = -dF_x / dy' c w
    / W (Lund & Thomsen 1978).  For a law with different damping in closing and opening motion, the mean of both is
    used.
    """
    load = load_of(slenderness, sommerfeld)
    scene = load_case(grid_of(law, slenderness, sommerfeld))
    (joint,) = scene.case.joints
    term = registry.compile_joint(joint, str(joint.journal))
    clearance, speed = CLEARANCE, SPEED
    scales = clearance * np.array([1.0, 1.0, speed, speed])
    equilibrium = np.array([ratio * math.cos(attitude), ratio * math.sin(attitude), 0.0, 0.0])

    def force(motion: np.ndarray) -> np.ndarray:
        """Return the (2,) force on the journal over the load, for its (4,) position and velocity over `scales`."""
        x, y, vx, vy = (float(number) for number in motion * scales)
        film = film_load(term, Gap(x, y, vx, vy, spin_proximal=0.0, spin_distal=speed))
        radial_direction, tangential_direction = np.array([film.nx, film.ny]), np.array([-film.ny, film.nx])
        return np.asarray((film.radial * radial_direction + film.tangential * tangential_direction) / load)

    slopes = [
        (force(equilibrium - STEP * direction) - force(equilibrium + STEP * direction)) / (2.0 * STEP)
        for direction in np.eye(4)
    ]
    result = {}
    for name, columns in (("stiffness K", slopes[:2]), ("damping B", slopes[2:])):
        for column_axis, column in zip(AXES, columns, strict=True):
            for row_axis, slope in zip(AXES, column, strict=True):
                result[f"{name}{row_axis}{column_axis}"] = float(slope)
    return result


def whirl_threshold(values: dict[str, float]) -> float:
    """Return the whirl threshold of a rigid rotor of this weight, speed w over sqrt(g / c); inf if it never whirls.

    values : result of `film_coefficients`.  Routh's criterion: at the threshold M s^2 c / W is the `stiffness`, s the
    whirl speed, and `ratio_squared` is (s / w)^2 (Lund & Thomsen 1978).
    """
    names = [first + second for first in AXES for second in AXES]
    k, b = ({name: values[f"{kind}{name}"] for name in names} for kind in ("stiffness K", "damping B"))
    crossed = k["xx"] * b["yy"] + k["yy"] * b["xx"] - k["xy"] * b["yx"] - k["yx"] * b["xy"]
    stiffness = crossed / (b["xx"] + b["yy"])
    determinant = (k["xx"] - stiffness) * (k["yy"] - stiffness) - k["xy"] * k["yx"]
    ratio_squared = determinant / (b["xx"] * b["yy"] - b["xy"] * b["yx"])
    return math.sqrt(stiffness / ratio_squared) if ratio_squared > 0.0 and stiffness > 0.0 else math.inf


# ----------------------------------------------------------------------------------------------------------------------
# Spread of film models: tables of bearings with two grooves compared with a plain bearing.


BOOKS_NAME = "Spread of film models"
BOOK_LAWS = ("reynolds", "finite")
BOOKS = ("lund-thomsen", "someya")


def measure_books(*, quick: bool = False) -> list[Row]:
    """Return the rows of both databooks; `quick`: every sixth point."""
    rows = []
    for book in BOOKS:
        table = read_reference(BOOKS_NAME, book)
        bearings = {point: parse_point(point) for point in table.names[:: 6 if quick else 1]}
        for law in BOOK_LAWS:
            figures = {point: bearing_figures(law, *bearing) for point, bearing in bearings.items()}
            rows += table.rows_at(figures, law)
    return rows


def parse_point(point: str) -> tuple[float, float]:
    """Return length / diameter and So of a point, such as 'L/D 0.5, S 1.656'; So = 1 / (2 pi S)."""
    words = point.replace(",", "").split()
    return float(words[1]), 0.5 / (math.pi * float(words[3]))


def bearing_figures(law: str, slenderness: float, sommerfeld: float) -> dict[str, float | None]:
    """Return the equilibrium of a journal, stiffness and damping of its film there, and its whirl threshold."""
    equilibrium = equilibrium_of(law, slenderness, sommerfeld)
    ratio, attitude = equilibrium["eccentricity ratio"], math.radians(equilibrium["attitude"])
    film = film_coefficients(law, slenderness, sommerfeld, ratio, attitude)
    threshold_speed = whirl_threshold(film)
    return {**equilibrium, **film, "threshold speed": threshold_speed if math.isfinite(threshold_speed) else None}


def draw_books(rows: list[Row]) -> Figure:
    """Draw stiffness and damping of the longer bearings of the second book over the load number S."""
    page = Figure(figsize=(9.0, 4.6), layout="constrained")
    source, coefficient_names = rows[-1].source, ("Kxx", "Kxy", "Kyx", "Kyy", "Bxx", "Bxy", "Byy")
    panels = page.subplots(2, 4, sharex=True).ravel()
    for panel, coefficient_name in zip(panels, coefficient_names, strict=False):
        selected = [row for row in rows if row.source == source and row.quantity.endswith(coefficient_name)]
        longer_bearings = [row for row in selected if row.point.startswith("L/D 1,")]
        for law in BOOK_LAWS:
            points = [(_load_number(row), row.computed) for row in longer_bearings if row.variant == law]
            panel.plot(*zip(*points, strict=True), **LINE_STYLES[law], label=law)
        table = dict.fromkeys((_load_number(row), row.reference) for row in longer_bearings)
        panel.plot(*zip(*table, strict=True), **REFERENCE_STYLE, label="Someya 1989")
        scale = {"Kyx": "symlog", "Bxy": "linear"}.get(coefficient_name, "log")  # figures that may change sign
        panel.set(xscale="log", title=f"{coefficient_name} [{longer_bearings[0].unit}]", yscale=scale)
        style_axes(panel)
    for panel in panels[4:7]:
        panel.set_xlabel("S [1]")
    handles, labels = panels[0].get_legend_handles_labels()
    panels[-1].legend(handles, labels, frameon=False, loc="center")
    panels[-1].set_axis_off()
    return page


def _load_number(row: Row) -> float:
    return float(row.point.split()[-1])


DATABOOKS = Benchmark("databooks", BOOKS_NAME, measure_books, draw_books)
