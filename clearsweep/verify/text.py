"""The results of `verify` as text, as `accuracy.md`, and as the figure of error against run time."""

import math
import string
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from .comparisons import TITLES

# ----------------------------------------------------------------------------------------------------------------------
# The measurements as fixed-width text.


EXPLANATION = (
    "error: largest deviation at the samples of angle / 0.05 rad, place / 0.05 m, angular rate / crank rate, speed /",
    "    (crank rate x crank length), over the first half of the run and all of it.  Motion with clearance is chaotic:",
    "    an error grows a thousandfold and more in a revolution, whatever the method.",
    "events: contact onsets and separations found; = means that number and order are exact.",
    "force peaks: largest relative error in the first half; '-' where contacts are missing or peaks are not compared.",
    "rhs: evaluations of the equations of motion, those for events included.",
    "time: least of {repetitions} interleaved rounds (one for runs of 0.2 s and more), compilation excluded; ours: the",
    "    whole call of clearsweep.simulate with every figure of the summary.",
)
METHODS = (
    "event-driven    clearsweep.simulate: adaptive order 8, every onset and separation located",
    "explicit only   the same with simulate.method: explicit; implicit only: implicit (Radau IIA of order 9)",
    "scipy DOP853    solve_ivp on the same compiled right-hand side, every onset and separation located, restarted",
    "scipy LSODA     the same with method LSODA; scipy Radau: Radau, its Jacobian by differences",
    "fixed-step RK4  classical Runge-Kutta 4, compiled, on the same right-hand side, events not located",
)


def results_text(results: dict) -> str:
    """Return the tables of all problems, their explanation, and the main figures."""
    machine = results["machine"]
    lines = [
        f"clearsweep {results['version']}, error against run time ({results['command']}, {results['date']})",
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; Python {machine['python']}, "
        f"numpy {machine['numpy']}, scipy {machine['scipy']}, llvmlite {machine['llvmlite']}",
        "",
        *METHODS,
    ]
    for entry in results["problems"]:
        lines += ["", *_problem_lines(entry)]
    lines += [
        "",
        *(line.format(repetitions=results["rounds"]) for line in EXPLANATION),
        "",
        *_headline_lines(results["headline"]),
    ]
    lines += ["", *machine_lines(results["machines"])] if results["machines"]["rows"] else []
    lines += ["", *convergence_lines(results["convergence"]), "", *stability_lines(results["stability"])]
    lines += ["", *stiffness_lines(results["stiffness"])]
    return "\n".join(lines)


def results_markdown(results: dict) -> str:
    """Return the report as Markdown, with a link to the figure `accuracy/error.svg`."""
    table = results["stability"]
    rows = [
        f"| {row['name']} | {row['status']} | {row['rhs_evaluations']:,} | {_error_text(row['energy_residual'])} | "
        f"{_error_text(row['share_of_bound'])} | {row['failure'] or 'passed'} |"
        for row in table["rows"]
    ]
    return "\n".join(
        [
            "# Accuracy and stability",
            "",
            f"Written by `{results['command']} --write` on {results['date']}; the machine is below.",
            "",
            "![Error against run time](accuracy/error.svg)",
            "",
            "```text",
            results_text(results),
            "```",
            "",
            "## Every case of the stability table",
            "",
            "| case | status | right-hand sides | energy residual | penetration over bound | |",
            "| --- | --- | ---: | ---: | ---: | --- |",
            *rows,
            "",
        ]
    )


class _Cells(string.Formatter):
    """Formats cells of a table; a missing number is '-'."""

    def format_field(self, value: Any, format_spec: str) -> str:
        return "-" if value is None else str(super().format_field(value, format_spec))


def table_lines(columns: str, rows: Sequence[Mapping]) -> list[str]:
    """Return rows as lines of a table, its first column to the left; columns : "head {field:format} | ..."."""
    heads, fields = zip(*(column.split(" {", 1) for column in columns.split(" | ")), strict=True)
    cells = [heads, *([_Cells().vformat(f"{{{field}", (), row) for field in fields] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])] for row in cells)
    return [f"  {'  '.join(line)}".rstrip() for line in lines]


MACHINES = (
    "machine {title} | tolerance {tolerance:.0e} | error {error:.1e} | events {events}/{events_expected} | "
    "their times {event_error:.1e} | rhs {rhs_evaluations} | time [ms] {ms:.3g}"
)
STIFFNESS = (
    "case {name} | tolerance {explicit[tolerance]:.0e} | rhs {explicit[rhs_evaluations]} | "
    "error {explicit[error]:.1e} | automatic {auto[tolerance]:.0e} | rhs {auto[rhs_evaluations]} | "
    "error {auto[error]:.1e} | rhs ratio {evaluations_ratio:.3g} | time {run_time_ratio:.3g}"
)
CHOICES = (
    "case {name} | tolerance {tolerance:.0e} | explicit {rhs_evaluations[explicit]} | "
    "time [s] {processor_time[explicit]:.2g} | implicit {rhs_evaluations[implicit]} | "
    "time [s] {processor_time[implicit]:.2g} | auto {rhs_evaluations[auto]} | time [s] {processor_time[auto]:.2g} | "
    "ratio {over_better:.2f}"
)
PROBLEM = (
    "method {method} | setting {setting} | error, 1st half {error_first_half:.1e} | error, all {error_whole:.1e} | "
    "events {found} | force peaks {peak_error_first_half:.1e} | rhs {rhs_evaluations} | steps {steps} | "
    "time [ms/rev] {ms_per_revolution:.3g}"
)


def machine_lines(table: dict) -> list[str]:
    """Return the lines that give error against run time on machines with known trajectories."""
    return [
        "machines with loads, free cranks, loops: largest error of a body's channel over its largest value, up to",
        "    where a comparison with the trajectory in quadruple precision is fair; time of the integration",
        *table_lines(MACHINES, [row | {"title": TITLES[row["name"]]} for row in table["rows"]]),
    ]


COLUMNS = {  # heading, and what a unit of the column is in SI
    "rod_slider_force_rms": ("force rms [N]", 1.0),
    "rod_slider_force_p99": ("force p99 [N]", 1.0),
    "rod_slider_impacts_per_rev": ("impacts per rev", 1.0),
    "rod_slider_wear_rate_max": ("wear rate [nm/s]", 1e-9),
}


def convergence_lines(table: dict) -> list[str]:
    """Return the lines that give how statistics settle with tolerance and length of the run."""
    heads = (f"{COLUMNS[figure][0]} {{{figure}}}" for figure in table["figures"])
    rows = [
        row | {figure: _interval_text(row[figure], COLUMNS[figure][1]) for figure in table["figures"]}
        for row in sorted(table["rows"], key=lambda row: row["revolutions"])
    ]
    return [
        f"convergence of statistics: {table['problem']} with wear, after {table['discard']} discarded revolutions; "
        "95 % intervals from blocks of revolutions",
        *table_lines(" | ".join(("revolutions {revolutions}", "tolerance {tolerance:.0e}", *heads)), rows),
        "  Pointwise errors are above, for the first revolution only; later, runs at two tolerances are two samples",
        f"  of one motion.  {100.0 * table['within']:.0f} % of all pairs of tolerances agree within their intervals "
        f"(95 % expected), in {table['seconds']:.0f} s.",
    ]


def _interval_text(estimate: dict, unit: float) -> str:
    """Return a value with its interval, rounded to two figures of the latter."""
    value, width = estimate["value"] / unit, estimate["half_width"] / unit
    decimals = max(0, 1 - math.floor(math.log10(width))) if width > 0.0 else 3
    return f"{value:.{decimals}f} +- {width:.{decimals}f}"


def stability_lines(table: dict) -> list[str]:
    """Return the lines on the stiff and extreme cases, with all failures."""
    lines = [
        f"stability: {table['passed']} of {table['cases']} stiff, extreme and degenerate cases pass "
        f"({100.0 * table['share_passed']:.1f} %), in {table['seconds']:.0f} s: two revolutions ended ok with default",
        "    tolerance and budgets, all finite, energy balanced to 1000 tolerances a revolution, no contact missed,",
        "    penetration within its bound.  Largest share of the energy bound "
        f"{table['largest_share_of_energy_bound']:.2g}, of the penetration bound "
        f"{table['largest_share_of_penetration_bound']:.2g}.",
    ]
    for row in table["failures"]:
        lines += [f"  {row['name']}: {row['rhs_evaluations']:,} rhs", f"    {row['failure']}"]
    return lines


def stiffness_lines(table: dict) -> list[str]:
    """Return the lines that compare the automatic choice of the method with the explicit one."""
    worst = max(table["choices"], key=lambda row: row["over_better"])
    return [
        "stiffness: the explicit method in stiff motion, against the automatic choice at the loosest tolerance,",
        "    by tens, at which its error is no larger (one revolution; each column of a Jacobian counts as one rhs)",
        *table_lines(STIFFNESS, table["rows"]),
        "",
        "  all methods at equal tolerance: rhs and processor time; the automatic choice over the better of both",
        *table_lines(CHOICES, table["choices"]),
        f"  largest ratio {worst['over_better']:.2f}, {worst['name']} at {worst['tolerance']:.0e}",
        "",
        "  where the motion is not stiff, automatic over explicit, at the default tolerance:",
        *table_lines("case {name} | rhs ratio {evaluations_ratio:.3f}", table["others"]),
    ]


def _problem_lines(entry: dict) -> list[str]:
    """Return the lines of one problem."""
    if entry["measure"] == "restitution":
        description = "error of the ratio of rebound to approach speed, closed form; time of the run"
    else:
        revolutions_text = f"{entry['revolutions']:g} revolution" + ("" if entry["revolutions"] == 1 else "s")
        description = f"{revolutions_text}, {entry['events_expected']} contact events"
    rows = [
        row
        | {
            "setting": f"tolerance {row['tolerance']:.0e}" if "tolerance" in row else f"step {row['step']:.0e} s",
            "found": f"{'=' if row['events_exact'] else ''}{row['events']}",
        }
        for row in entry["rows"]
    ]
    return [f"{entry['name']}: {entry['title']} ({description})", *table_lines(PROBLEM, rows)]


def _error_text(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}"


def _headline_lines(figures: dict) -> list[str]:
    """Return the lines that give the flagship figures."""
    lines = [
        f"{figures['problem']} at tolerance {figures['tolerance']:g}: {figures['ms_per_revolution']:.3g} ms a "
        f"revolution, {figures['integration_ms_per_revolution']:.3g} of it integrating, error "
        f"{figures['error_first_half']:.1e} over the first half;",
        f"  scipy DOP853 at the same tolerance {figures['scipy_ms_per_revolution']:.4g} ms, error "
        f"{figures['scipy_error_first_half']:.1e}: {figures['ratio_at_equal_tolerance']:.0f} times slower;",
    ]
    if figures["ratio_at_equal_error"]:
        lines.append(
            f"  scipy DOP853 at the same error {figures['scipy_ms_per_revolution_at_equal_error']:.4g} ms: "
            f"{figures['ratio_at_equal_error']:.0f} times slower (between its tolerances, on a log-log line)."
        )
    else:
        lines.append("  scipy DOP853 does not reach that error at any of its tolerances.")
    ratios = figures["scipy_over_first_measured"].items()
    first_ratios = ", ".join(f"{ratio:.2f} at {tolerance}" for tolerance, ratio in ratios)
    lines.append(f"  scipy's time over that of its first measurement, on another machine: {first_ratios}.")
    return lines


# ----------------------------------------------------------------------------------------------------------------------
# Drawing of error against run time.


STYLE = {  # method -> colour (Okabe and Ito 2008), marker
    "event-driven": ("#0072B2", "o"),
    "explicit only": ("#56B4E9", "v"),
    "implicit only": ("#009E73", "D"),
    "scipy DOP853": ("#E69F00", "s"),
    "scipy LSODA": ("#CC79A7", "x"),
    "scipy Radau": ("#666666", "+"),
    "fixed-step RK4": ("#D55E00", "^"),
}
PANELS_IN_A_ROW = 3
FIRST_HALF_LABEL, RESTITUTION_LABEL = "error over the first half [1]", "error of the restitution [1]"


def draw(results: dict[str, Any], path: str | Path) -> Path:
    """Draw error against run time for every problem of `results`, from `measure`; return the path.

    The ending of `path` determines the format: .svg, .png or .pdf.
    """
    entries = results["problems"]
    rows = -(-len(entries) // PANELS_IN_A_ROW)
    figure = Figure(figsize=(4.0 * PANELS_IN_A_ROW, 3.3 * rows + 0.5), layout="constrained")
    panels = figure.subplots(rows, PANELS_IN_A_ROW, squeeze=False).ravel()
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
    style_axes(panel)


def style_axes(panel: Axes) -> None:
    """Give axes a light grid and no box."""
    panel.grid(color="#dde3e8", linewidth=0.6)
    panel.set_axisbelow(True)
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)
