"""Drawing of error against run time."""

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

STYLE = {  # method -> colour (Okabe and Ito 2008), marker
    "event-driven": ("#0072B2", "o"),
    "explicit only": ("#56B4E9", "v"),
    "implicit only": ("#009E73", "D"),
    "scipy DOP853": ("#E69F00", "s"),
    "scipy LSODA": ("#CC79A7", "x"),
    "scipy Radau": ("#666666", "+"),
    "fixed-step RK4": ("#D55E00", "^"),
}
COLUMNS = 3
FIRST_HALF_LABEL, RESTITUTION_LABEL = "error over the first half [1]", "error of the restitution [1]"


def draw(results: dict[str, Any], path: str | Path) -> Path:
    """Draw error against run time for every problem of `results`, from `measure`; return the path.

    The ending of `path` determines the format: .svg, .png or .pdf.
    """
    entries = results["problems"]
    rows = -(-len(entries) // COLUMNS)
    figure = Figure(figsize=(4.0 * COLUMNS, 3.3 * rows + 0.5), layout="constrained")
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for panel, entry in zip(panels, entries, strict=False):
        _draw_panel(panel, entry)
    for panel in panels[len(entries) :]:
        panel.set_axis_off()
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=len(names), frameon=False)
    path = Path(path)
    figure.savefig(path, dpi=150)
    return path


def _draw_panel(panel: Axes, entry: dict[str, Any]) -> None:
    """Draw one problem on matplotlib axes."""
    column = "error_whole" if entry["measure"] == "restitution" else "error_first_half"
    for method, (colour, marker) in STYLE.items():
        rows = [row for row in entry["rows"] if row["method"] == method and row[column]]
        run_times, errors = [row["ms_per_revolution"] for row in rows], [row[column] for row in rows]
        panel.plot(run_times, errors, color=colour, marker=marker, markersize=4, linewidth=1.2, label=method)
    panel.set(
        xscale="log",
        yscale="log",
        ylabel=RESTITUTION_LABEL if column == "error_whole" else FIRST_HALF_LABEL,
        xlabel="run time [ms]" if column == "error_whole" else "run time [ms a revolution]",
    )
    panel.set_title(f"{entry['name']}: {entry['title']}", fontsize=9)
    panel.yaxis.set_major_locator(LogLocator(base=100.0, numticks=12))
    panel.yaxis.set_minor_locator(NullLocator())
    panel.grid(color="#dde3e8", linewidth=0.6)
    panel.set_axisbelow(True)
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)
