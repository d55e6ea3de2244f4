"""The check of a grid in words: the text of the command line, and the page with its pictures."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..language import wording
from ..report.blocks.section import Block, Gallery, Picture, Points, Section, capitalise
from ..report.blocks.table import Table, columns_of
from ..report.documents.page import Page
from ..report.plot import Axes, ColourScale
from .reference_run import CLEARANCES, HALF

COLOURS = {  # method -> colour (Okabe and Ito 2008), marker
    "auto": ("#0072B2", "o"),
    "explicit": ("#56B4E9", "o"),
    "implicit": ("#009E73", "o"),
    "scipy DOP853": ("#E69F00", "s"),
    "scipy LSODA": ("#CC79A7", "s"),
}
LEAST_DRAWN_ERROR = 1e-14  # clearances: an error of 0 is drawn there
PASSED, FAILED, NOT_TRIED = 1.0, 0.0, np.nan
CELL_COLOURS = ("#D55E00", "#009E73")  # of failed and passed
MAX_LISTED = 20  # failed variants in the text


ValueText = Callable[[str, Any], str]  # path, varied value -> text with its unit


def result_text(result: Mapping[str, Any], text_of: ValueText) -> str:
    """Return the check as text: tables of each case, then the advice."""
    blocks = [_case_lines(case, text_of) for case in result["cases"]]
    return "\n".join([line for lines in blocks for line in (*lines, "")] + list(result["advice"]))


def case_title(case: Mapping[str, Any], text_of: ValueText) -> str:
    """Return the name of a case: its id, why it was chosen, its varied values."""
    values = [f"{wording.axis_name(path)} {text_of(path, value)}" for path, value in case["values"].items()]
    name = f"case {wording.short_id(case['case_id'])} ({', '.join(case['chosen_as'])})"
    return f"{name}: {', '.join(values)}" if values else name


def _case_lines(case: Mapping[str, Any], text_of: ValueText) -> list[str]:
    methods = list(dict.fromkeys(row["method"] for row in case["ladder"]))
    lines = [case_title(case, text_of), f"  {reference_sentence(case)}"]
    if methods:
        lines.append("  tolerance" + "".join(f"{method:>24}" for method in methods))
        lines.append("           " + "".join(f"{'error':>12}{'ms/rev':>12}" for _ in methods))
    rows = {(row["method"], row["tolerance"]): row for row in case["ladder"]}
    for tolerance in sorted({row["tolerance"] for row in case["ladder"]}, reverse=True):
        cells = (_cell_text(rows.get((method, tolerance))) for method in methods)
        lines.append(f"  {tolerance:<9.3g}" + "".join(cells))
    lines += [f"  rivals: none; {case['rivals']}"] if case["rivals"] else []
    if any(row["status"] == "ok" and not row["events_equal"] for row in case["ladder"]):
        lines.append("  ! contacts are missing, or in another order")
    stability = case["stability"]
    lines.append(f"  variants: {stability['passed']} of {stability['tried']} pass, {len(stability['refused'])} refused")
    failed = stability["failed"]
    lines += [f"    {entry['text']}: {entry['why']}" for entry in failed[:MAX_LISTED]]
    lines += [f"    and {len(failed) - MAX_LISTED} more"] if len(failed) > MAX_LISTED else []
    if case["parts"]:
        parts = ", ".join(f"{part['part']} {max(part['milliseconds'], 0.0):.2g}" for part in case["parts"])
        lines.append(f"  cost, ms a revolution: {parts}")
    return lines


def reference_sentence(case: Mapping[str, Any]) -> str:
    """Return how far the errors of a case can be trusted."""
    reference, horizon = case["reference"], case["horizon_revolutions"]
    if reference is None:
        return "The time ran out before the reference was known."
    if reference["tolerance"] is None:
        return f"No reference: {reference['why']}."
    length = case["compared_revolutions"]
    period = "half a revolution" if length == HALF else f"{length:.2g} revolutions"
    order = "" if case["order"] is None else f", error ~ tolerance^{case['order']:.2f}"
    prediction = (
        "" if horizon is None else f"; predictable for {horizon:.2g} revolutions, beyond that by statistics only"
    )
    unit = case.get("measured_in", CLEARANCES)
    return (
        f"errors in {unit} over {period}; reference at {reference['tolerance']:g}, good to "
        f"{reference['error']:.1g}{order}{prediction}"
    )


def _cell_text(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return f"{'':>24}"
    if row["error"] is None:
        return f"{row['status']:>24}"
    error = f"{row['error']:.1e}{'' if row['events_equal'] else '!'}"
    return f"{error:>12}{row['milliseconds']:>12.3g}"


# ---------------------------------------------------------------------------------------------- page


Levels = Mapping[str, Sequence[str]]  # factor -> its levels in words


def write_page(result: Mapping[str, Any], levels: Sequence[Levels], text_of: ValueText, out: Path) -> Path:
    """Write the check as a page; levels : the factors of each case."""
    sections = [Section("advice", "What to do", [Points(list(result["advice"]))])]
    for case, factors in zip(result["cases"], levels, strict=True):
        pictures = [_error_picture(case)] if any(row["error"] is not None for row in case["ladder"]) else []
        if case["stability"]["tried"]:
            pictures.append(_stability_picture(case, factors))
        blocks: list[Block] = [Points([reference_sentence(case)]), Gallery("", pictures), *_tables(case)]
        sections.append(Section(f"case-{case['case_id']}", capitalise(case_title(case, text_of)), blocks))
    page = Page(
        name=result["grid"],
        subtitle="error against run time, stability and cost",
        axes_verb="Checked",
        axes=[wording.count_text(len(result["cases"]), "case")],
        sections=sections,
    )
    return page.write(out)


def _tables(case: Mapping[str, Any]) -> list[Block]:
    """Return the tables of a case: the ladder, the failed variants, the cost of the parts."""
    tables: list[Block] = []
    key = wording.short_id(case["case_id"])
    if case["ladder"]:
        rows = [
            (*(row[name] for name in ("method", "tolerance", "error", "peaks")), _seconds(row["milliseconds"]))
            for row in case["ladder"]
        ]
        note = "Error in clearances; relative error of the first three force peaks; processor time a revolution."
        columns = columns_of("method | tolerance | error | first peaks | time [s]")
        tables.append(Table(f"ladder_{key}", "Error against run time", note, columns, rows))
    failed = case["stability"]["failed"]
    if failed:
        rows = [(entry["text"], entry["status"], entry["why"]) for entry in failed]
        heads = columns_of("variant | status | why")
        tables.append(Table(f"variants_{key}", "Variants that fail", "", heads, rows))
    if case["parts"]:
        rows = [(part["part"], _seconds(part["milliseconds"])) for part in case["parts"]]
        note = "Found by leaving the part out; `rates` is what remains without any of them."
        tables.append(Table(f"parts_{key}", "Cost of the parts", note, columns_of("part | time [s]"), rows))
    return tables


def _seconds(milliseconds: float | None) -> float | None:
    return None if milliseconds is None else 1e-3 * milliseconds


def _error_picture(case: Mapping[str, Any]) -> Picture:
    """Return the picture of error against run time, a curve per method, the grid's tolerance marked."""

    def paint(ax: Axes) -> None:
        for method, (colour, marker) in COLOURS.items():
            rows = [row for row in case["ladder"] if row["method"] == method and row["error"] is not None]
            if rows:
                errors = [max(row["error"], LEAST_DRAWN_ERROR) for row in rows]
                times = [row["milliseconds"] for row in rows]
                ax.plot(times, errors, color=colour, marker=marker, markersize=4, linewidth=1.2, label=method)
        yours = case["yours"]
        if yours["error"] is not None:
            point = [yours["milliseconds"]], [max(yours["error"], LEAST_DRAWN_ERROR)]
            ax.plot(*point, marker="o", linestyle="", color="#111111", markersize=7, label="yours")
        ax.set_labels("processor time [ms a revolution]", "error [clearances]")
        ax.set_log("x", "y")
        ax.set_grid("#dde3e8", linewidth=0.6)
        ax.set_legend("right")

    return Picture("Error against run time", "", "Error of the journal against run time by method.", paint, (5.4, 3.4))


def _stability_picture(case: Mapping[str, Any], factors: Levels) -> Picture:
    """Return the map of the variants: a cell for each pair of levels, singles on the diagonal."""
    levels = list(itertools.chain.from_iterable(factors.values()))
    failed = {entry["text"] for entry in case["stability"]["failed"]}
    refused = {entry["text"] for entry in case["stability"]["refused"]}
    cells = np.full((len(levels), len(levels)), NOT_TRIED)
    groups = [name for name, levels in factors.items() for _ in levels]
    for (i, first), (j, second) in itertools.product(enumerate(levels), repeat=2):
        if i != j and groups[i] == groups[j]:
            continue
        names = {first} if i == j else {f"{first}, {second}", f"{second}, {first}"}
        if not names & refused:
            cells[i, j] = FAILED if names & failed else PASSED

    def paint(ax: Axes) -> None:
        edges = np.arange(len(levels) + 1) - 0.5
        ax.face_colour = "#e8ebee"
        colours = ColourScale(FAILED, PASSED, CELL_COLOURS, is_stepped=True)
        ax.cells(edges, edges, cells, colours, edge_colour="#ffffff", linewidth=1.0)
        positions = list(range(len(levels)))
        ax.xaxis.set_ticks(positions, [str(number + 1) for number in positions])
        ax.yaxis.set_ticks(positions, [f"{text} ({number + 1})" for number, text in enumerate(levels)])
        ax.set_xlim(-0.6, len(levels) - 0.4)
        ax.set_ylim(len(levels) - 0.4, -0.6)
        ax.set_tick_length(0.0)

    caption = "Green passes, red fails, grey was refused or is no variant; the diagonal has single changes."
    return Picture("Variants", caption, "Map of the variants that pass and fail.", paint, (6.4, 4.6))
