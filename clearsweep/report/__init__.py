"""Reports: one offline HTML page of a run, its tables and figures, and one case simulated again and drawn."""

import functools
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import store
from ..store import BlockedRun, StoredRun

if TYPE_CHECKING:
    from .documents.page import Page  # loads the drawing libraries


class _ReportedRun(StoredRun):
    """The results in one directory, with their report."""

    @functools.cached_property
    def answer(self) -> dict[str, Any]:
        """The answer to the question of the grid, as answer.json has it, from the stored cases."""
        return store.answer_of(self)

    def figures(self, directory: str | Path, form: str = "svg", width: str = "auto") -> list[Path]:
        """Write every figure of the report as `clearsweep.report.figures` does; return the paths."""
        return figures(self, directory, form, width)

    def report(self, out: str | Path | None = None) -> Path:
        """Write the report as one self-contained HTML file, default report.html in the directory; return its path."""
        return write(self, out or self.directory / "report.html")


class Run(_ReportedRun):
    """The results in one directory, as the store reads them, with their report."""


class RunOfBlocks(_ReportedRun, BlockedRun):
    """The results of a run in blocks, with their report: the summary is lazy, and the report shows a sample."""


def open(directory: str | Path, *, partial: bool = False) -> Run | RunOfBlocks:
    """Return the run in `directory`: its summary, orbits, events and wear; raise DirectoryError if there is none.

    An unfinished run raises an error unless `partial` is set; then the run contains the cases finished so far.  They
    are assembled in a temporary directory, which is deleted with the object; `directory` is not changed.
    """
    directory = Path(directory)
    if store.is_cut(directory):
        return RunOfBlocks(directory, partial=partial)
    if not partial or not store.is_unfinished(directory):
        return Run(directory)
    from .study import open_partial

    return open_partial(directory, Run)


def page_of(run: "StoredRun", *, typical: bool = False, measured: str | Path | None = None) -> "Page":
    """Return the page of a run (as the store opens it), from which its files, tables and figures are written.

    Maps show the worst case over the omitted axes; with `typical`, the median.  measured : a CSV file whose signals are
    compared with those of the nearest case.
    """
    from .documents import page
    from .study import prepare

    return page.page_of(prepare(run, shows_median=typical), measured)


def live_page(directory: Path, out: Path, system: str) -> AbstractContextManager[None]:
    """Return a context in which a process rewrites the page `out` of the run in `directory`, a few times a minute.

    system : unit system of the quantities on the page
    """
    from .documents import page

    return page.live_page(directory, out, system)


def compared(first: "StoredRun", second: "StoredRun") -> "Page":
    """Return the page that compares two runs case by case."""
    from .documents import two_runs

    return two_runs.comparison_page(first, second)


def write(run: "StoredRun", out: str | Path, *, typical: bool = False) -> Path:
    """Write the report of a run as one self-contained HTML file; return its path.  `typical` as for `page_of`."""
    return page_of(run, typical=typical).write(Path(out))


def tables(run: "StoredRun", directory: str | Path) -> list[Path]:
    """Write every table of a run into a directory, as CSV (SI, units in the header) and Markdown; return the paths."""
    return page_of(run).write_tables(Path(directory))


def figures(run: "StoredRun", directory: str | Path, form: str = "svg", width: str = "auto") -> list[Path]:
    """Write every figure of a run's page into a directory, one file per figure, and a list of them; return the paths.

    form : svg, pdf or png; width : 85 or 170 (mm), or auto: the smaller one that fits.
    """
    from .documents import paper

    return page_of(run).write_figures(paper.FigureOptions(Path(directory), form, width))


def show(run: "StoredRun", case_id: str, out: str | Path) -> Path:
    """Simulate one case of a run again and draw it, as HTML, SVG or PNG by the ending of `out`; return its path.

    As GIF or WebP it shows the mechanism in motion.  As CSV it has the forces in the joints over time, in the fixed
    frame.
    """
    from .documents import page

    return page.show(run, case_id, Path(out))


def draw_grid(source: str | Path, out: str | Path) -> Path:
    """Draw the mechanism of a grid at its start, as SVG or PNG by the ending of `out`; return its path."""
    from .documents import page

    return page.draw_grid(Path(source), Path(out))
