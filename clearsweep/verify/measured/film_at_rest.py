"""A film in equilibrium with its load: a run settles at the tabulated eccentricity, attitude and friction."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.figure import Figure

from . import bearing
from .drawing import LINE_STYLES, REFERENCE_STYLE, style_axes
from .points import Benchmark, Reference, Row, read_reference

NAME = "Films at rest in their load"
TEXT = """A housing that shifts but does not turn carries a constant load on a shaft that turns. The run starts with
the shaft in the middle and ends after 30 revolutions. The load is that of the table, so eccentricity and attitude
are results.

* `reynolds` solves the same equation as the tables. Its attitude is larger for a light load on a long bearing: the
  tables begin the film where it is thickest, here it begins wherever its pressure can be above zero.
* `finite` is a fit of the same tables, `short` leaves out the flow round the bearing. Both are shown with their
  error.
* The points reach an eccentricity ratio of 0.98, and so does the spread. At 0.99 and length / diameter 1, a second
  solver on two meshes gives So 108.3. The table gives 107.8, `reynolds` 108.4, and `finite` 105.8.
* There the error of the fit, 2.3 %, is larger than the spread, and `finite` ends at `film.limit`: the surfaces touch.
* Five squeezed films of the tables are tested. The laws are within 0.7 % (`reynolds`) and 2.1 % (`finite`) of them.
* The table of Raimondi & Boyd adds the friction of the shaft, (R / c) f = torque / (load c)."""
RADIUS, CLEARANCE, VISCOSITY, SPEED = 0.02, 2e-5, 0.01, 100.0  # m, m, Pa s, rad/s: without effect on the figures
MASS = 0.01  # kg: light enough to prevent whirl
REVOLUTIONS = 30
_LONG_BEARING_LAWS, _SHORT_BEARING_LAWS = ("reynolds", "finite"), ("reynolds", "finite", "short")
LAWS = {
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
    film = {"law": law, "viscosity": VISCOSITY}
    joint = {"clearance": CLEARANCE, "bearing_radius": RADIUS, "length": 2.0 * RADIUS * slenderness, "film": film}
    return bearing.grid(joint, SPEED, load_of(slenderness, sommerfeld), mass=MASS, revolutions=REVOLUTIONS)


def equilibrium_of(law: str, slenderness: float, sommerfeld: float) -> dict[str, float]:
    """Return the equilibrium of a bearing of this length / diameter under its load."""
    load = load_of(slenderness, sommerfeld)
    trajectory = bearing.run(grid_of(law, slenderness, sommerfeld))
    return {
        "eccentricity ratio": bearing.eccentricity(trajectory) / CLEARANCE,
        "attitude": math.degrees(bearing.attitude(trajectory)),
        "friction variable": bearing.torque(trajectory) / (load * CLEARANCE),
    }


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of both tables."""
    rows = _rows(read_reference(NAME, "butenschoen"), lambda number: number, LAWS, stride=8 if quick else 1)
    if quick:
        return rows
    laws = dict.fromkeys(LAWS, ("reynolds",))
    return rows + _rows(read_reference(NAME, "raimondi-boyd"), lambda s: 0.5 / (math.pi * s), laws)


def _rows(
    table: Reference, to_sommerfeld: Callable[[float], float], laws: Mapping[str, tuple[str, ...]], stride: int = 1
) -> list[Row]:
    """Return the rows of a table; `to_sommerfeld` converts its load number to So."""
    rows: list[Row] = []
    for point in list(dict.fromkeys(point for point, *_ in table.points))[::stride]:
        slenderness, _, number = (number_text.rpartition(" ")[2] for number_text in point.split(", "))
        for law in laws[slenderness]:
            computed = equilibrium_of(law, float(slenderness), to_sommerfeld(float(number)))
            rows += table.rows({(point, name): value for name, value in computed.items()}, law)
    return rows


def picture(rows: list[Row]) -> Figure:
    """Draw attitude over eccentricity ratio."""
    page = Figure(figsize=(9.0, 3.4), layout="constrained")
    panels = page.subplots(1, 3, sharey=True)
    for panel, slenderness in zip(panels, DRAWN_SLENDERNESSES, strict=True):
        selected = [row for row in rows if row.point.startswith(f"L/D {slenderness},") and row.kind == "published"]
        for law in LAWS[slenderness]:
            ratio, angle = (
                [
                    table_row.computed
                    for table_row in selected
                    if table_row.variant == law and table_row.quantity == name
                ]
                for name in ("eccentricity ratio", "attitude")
            )
            panel.plot(ratio, angle, **LINE_STYLES[law], label=law)
        table = [table_row for table_row in selected if table_row.variant == "reynolds"]
        values = [
            [table_row.reference for table_row in table if table_row.quantity == name]
            for name in ("eccentricity ratio", "attitude")
        ]
        panel.plot(*values, **REFERENCE_STYLE, label="Butenschoen 1976")
        panel.set(title=f"length / diameter {slenderness}", xlabel="eccentricity ratio [1]")
        style_axes(panel)
    panels[0].set_ylabel("attitude [deg]")
    panels[-1].legend(frameon=False)
    return page


BENCHMARK = Benchmark("film_at_rest", NAME, TEXT, measure, picture)
