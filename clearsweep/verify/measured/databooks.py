"""Spread of film models: tables of bearings with two grooves compared with a plain bearing."""

import math

from matplotlib.figure import Figure

from .coefficients import film_coefficients, whirl_threshold
from .drawing import LINE_STYLES, REFERENCE_STYLE, style_axes
from .film_at_rest import equilibrium_of
from .points import Benchmark, Row, read_reference

NAME = "Spread of film models"
TEXT = """Two databooks of bearings with two axial grooves, of 20 and 10 deg, and a plain bearing by `reynolds`
and `finite` under the same load number S. This is no test: grooves and the film's boundary differ. The differences
say what the choice of groove and cavity costs.

* Eccentricity: at most 0.033 of the clearance. Attitude: up to 15 deg for length / diameter 1, where the grooves cut
  more of the film; 3 deg and less beyond an eccentricity ratio of 0.7 at length / diameter 0.5.
* A designer who does not know the grooves of his bearing has its least film within 0.033 of the clearance, but the
  direction in which it rests only within 15 deg.
* **Stiffness K and damping B** are slopes of the film's force where the journal rests. x is along the load, y is 90 deg
  on with the shaft, W the load, c the clearance and w the shaft's speed. The books have B_xy = B_yx.
* A plain bearing (`reynolds`) has the tabulated K_xy within 12 %, B_xx within 17 %. Its K_xx is 0.45 to 1.1 times the
  tabulated one, and its B_yy 0.8 to 3.4 times. The grooves lie at either side of the load: they take away damping
  across it, most of all in long, lightly loaded bearings.
* **Threshold speed**: from where a rigid rotor whirls, over sqrt(g / c), by Routh's criterion from either set of
  coefficients. A plain bearing has up to 27 % more. Grooved ones of length / diameter 1 and light load have 2.0 to 2.1,
  the plain one 2.5. So grooves explain the difference in the section on oil whirl.
* `finite` adds a wedge and a squeeze that were fitted each alone. Its B_xy is up to 2 too small, and its B_yy in loaded
  bearings up to twice too large. Choose `reynolds` where whirl matters."""
LAWS = ("reynolds", "finite")
BOOKS = ("lund-thomsen", "someya")


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of both databooks; `quick`: every sixth point."""
    rows = []
    for book in BOOKS:
        table = read_reference(NAME, book)
        points = list(dict.fromkeys(point for point, *_ in table.points))[:: 6 if quick else 1]
        for law in LAWS:
            values = {
                (point, name): value
                for point in points
                for name, value in bearing_figures(law, *parse_point(point)).items()
            }
            rows += table.rows(values, law)
    return rows


def parse_point(point: str) -> tuple[float, float]:
    """Return length / diameter and So of a point, such as 'L/D 0.5, S 1.656'; So = 1 / (2 pi S)."""
    words = point.replace(",", "").split()
    return float(words[1]), 0.5 / (math.pi * float(words[3]))


def bearing_figures(law: str, slenderness: float, sommerfeld: float) -> dict[str, float | None]:
    """Return the equilibrium of a journal, stiffness and damping of its film there, and its whirl threshold."""
    equilibrium = equilibrium_of(law, slenderness, sommerfeld)
    film = film_coefficients(
        law, slenderness, sommerfeld, equilibrium["eccentricity ratio"], math.radians(equilibrium["attitude"])
    )
    threshold_speed = whirl_threshold(film)
    return {**equilibrium, **film, "threshold speed": threshold_speed if math.isfinite(threshold_speed) else None}


def picture(rows: list[Row]) -> Figure:
    """Draw stiffness and damping of the longer bearings of the second book over the load number S."""
    page = Figure(figsize=(9.0, 4.6), layout="constrained")
    source, coefficient_names = rows[-1].source, ("Kxx", "Kxy", "Kyx", "Kyy", "Bxx", "Bxy", "Byy")
    panels = page.subplots(2, 4, sharex=True).ravel()
    for panel, coefficient_name in zip(panels, coefficient_names, strict=False):
        selected = [row for row in rows if row.source == source and row.quantity.endswith(coefficient_name)]
        longer_bearings = [row for row in selected if row.point.startswith("L/D 1,")]
        for law in LAWS:
            points = [(_load_number(row), row.computed) for row in longer_bearings if row.variant == law]
            panel.plot(*zip(*points, strict=True), **LINE_STYLES[law], label=law)
        table = dict.fromkeys((_load_number(row), row.reference) for row in longer_bearings)
        panel.plot(*zip(*table, strict=True), **REFERENCE_STYLE, label="Someya 1989")
        signed_scales = {"Kyx": "symlog", "Bxy": "linear"}  # figures that may change sign
        panel.set(
            xscale="log",
            title=f"{coefficient_name} [{longer_bearings[0].unit}]",
            yscale=signed_scales.get(coefficient_name, "log"),
        )
        style_axes(panel)
    for panel in panels[4:7]:
        panel.set_xlabel("S [1]")
    handles, labels = panels[0].get_legend_handles_labels()
    panels[-1].legend(handles, labels, frameon=False, loc="center")
    panels[-1].set_axis_off()
    return page


def _load_number(row: Row) -> float:
    return float(row.point.split()[-1])


BENCHMARK = Benchmark("databooks", NAME, TEXT, measure, picture)
