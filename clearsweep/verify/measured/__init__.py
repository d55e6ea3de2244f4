"""Comparison with measurements and published solutions, point by point.

Each `Benchmark` measures its rows, which become a table, and a picture if the table is not enough.
"""

import json as json_format
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...language import phases
from . import contact, films, machines
from .points import Row

BENCHMARKS = (
    contact.OBLIQUE_IMPACTS,
    machines.CRANK_PIN_RIG,
    films.FILMS_AT_REST,
    machines.OIL_WHIRL,
    machines.LUGRE_STICK_SLIP,
    machines.ANDREWS_SQUEEZER,
    contact.HERTZ_IMPACTS,
    contact.BAR_IMPACTS,
    contact.WEAR_TRENDS,
    films.DATABOOKS,
)


def main(*, json: bool = False, quick: bool = False, directory: str | Path | None = None) -> None:
    """Compute all benchmarks and print a table or JSON; `directory`: destination of `measured.md` and its pictures.

    `quick` uses a few points of each benchmark.
    """
    from . import points

    latest_line = ["verify"]

    def report_progress(sentence: str) -> None:
        latest_line[0] = f"verify: {sentence}"
        phases.print_line(latest_line[0])

    with phases.phase(lambda: latest_line[0]):
        rows = measure(quick=quick, report_progress=report_progress)
    print(
        json_format.dumps(rows_as_dicts(rows), indent=2, allow_nan=False) if json else points.rows_text(rows),
        flush=True,
    )
    if directory is not None:
        phases.print_line(f"verify: wrote {points.write_page(rows, directory, BENCHMARKS)}")


def measure(*, quick: bool = False, report_progress: Callable[[str], None] | None = None) -> list[Row]:
    """Return the rows of all benchmarks."""
    rows: list[Row] = []
    for benchmark in BENCHMARKS:
        if report_progress:
            report_progress(benchmark.name)
        rows += benchmark.measure(quick=quick)
    return rows


def rows_as_dicts(rows: list[Row]) -> list[dict[str, Any]]:
    """Return rows for JSON."""
    return [row._asdict() for row in rows]
