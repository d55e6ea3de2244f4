"""Comparison with measurements and published solutions, point by point.

Each `Benchmark` measures its rows, which become a table, and a picture if the table is not enough.
"""

from functools import partial
from pathlib import Path

from ...language import phases
from .. import Report, announced_steps, publish
from . import contact, films, machines, points
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
    with announced_steps("verify", phases.print_line) as report_progress:
        rows = measure(quick=quick, report_progress=report_progress)
    shown = [row._asdict() for row in rows] if json else points.rows_text(rows)
    publish(rows, shown, directory, partial(points.write_page, benchmarks=BENCHMARKS))


def measure(*, quick: bool = False, report_progress: Report = lambda step: None) -> list[Row]:
    """Return the rows of all benchmarks."""
    rows: list[Row] = []
    for benchmark in BENCHMARKS:
        report_progress(benchmark.name)
        rows += benchmark.measure(quick=quick)
    return rows
