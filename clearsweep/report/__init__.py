"""Reports: one offline HTML page of a run, its tables and figures, and one case simulated again and drawn."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from .. import store
from ..store import BlockedRun, StoredRun

if TYPE_CHECKING:
    from .page import Page  # loads what draws


class _Reporting(StoredRun):
    """The results in one directory that can write their report."""

    def figures(self, directory: str | Path, form: str = "svg", width: str = "auto") -> list[Path]:
        """Write every figure of the report as `clearsweep.report.figures` does; return the paths."""
        return figures(self, directory, form, width)

    def report(self, out: str | Path | None = None) -> Path:
        """Write the report as one self-contained HTML file, default report.html in the directory; return its path."""
        return write(self, out or self.directory / "report.html")


class Run(_Reporting):
    """The results in one directory, as the store reads them, that can write their report."""


class RunOfBlocks(_Reporting, BlockedRun):
    """The same of a run that is cut into blocks: its summary is lazy, and its report shows a sample."""


def open(directory: str | Path, *, partial: bool = False) -> Run | RunOfBlocks:
    """Return the run in `directory`: its summary, orbits, events and wear; raise DirectoryError where there is none.

    A run that is not finished is refused, unless `partial`: then it has the cases that are finished so far.  They are
    put together in a temporary directory, which goes with the object; `directory` stays as it is.
    """
    directory = Path(directory)
    if store.is_cut(directory):
        return RunOfBlocks(directory, partial=partial)
    if not partial or not store.is_unfinished(directory):
        return Run(directory)
    from .partial import gathered

    return gathered(directory, Run)


def of(run: "StoredRun", *, typical: bool = False, measured: str | Path | None = None) -> "Page":
    """Return the page of a run (as the store opens it), to write it, its tables, its figures.

    Maps show the worst case over the axes that they leave out; `typical`: the median.  measured : a CSV file
    whose signals are laid over those of the nearest case.
    """
    _load_drawing()
    from . import page, study

    return page.of(study.prepare(run, typical=typical), measured)


def compared(first: "StoredRun", second: "StoredRun") -> "Page":
    """Return the page that compares two runs case by case."""
    _load_drawing()
    from . import two_runs

    return two_runs.compared(first, second)


def write(run: "StoredRun", out: str | Path, *, typical: bool = False) -> Path:
    """Write the report of a run as one self-contained HTML file; return its path.  `typical` as for `of`."""
    return of(run, typical=typical).write(Path(out))


def tables(run: "StoredRun", directory: str | Path) -> list[Path]:
    """Write every table of a run into a directory, as CSV (SI, units in the header) and Markdown; return the paths."""
    return of(run).write_tables(Path(directory))


def figures(run: "StoredRun", directory: str | Path, form: str = "svg", width: str = "auto") -> list[Path]:
    """Write every figure of a run's page into a directory, under its name, and a list of them; return the paths.

    form : svg, pdf or png; width : 85 or 170 (mm), auto: as much of them as it needs.
    """
    _load_drawing()
    from . import paper

    return of(run).write_figures(paper.Wanted(Path(directory), form, width))


def show(run: "StoredRun", case_id: str, out: str | Path) -> Path:
    """Simulate one case of a run again and draw it, as HTML, SVG or PNG by the ending of `out`; return its path."""
    _load_drawing()
    from . import single

    return single.show(run, case_id, Path(out))


def draw_grid(source: str | Path, out: str | Path) -> Path:
    """Draw the mechanism of a grid at its start, as SVG or PNG by the ending of `out`; return its path."""
    _load_drawing()
    from . import mechanism

    return mechanism.draw(Path(source), Path(out))


def _load_drawing() -> None:
    """Load matplotlib, also where MPLBACKEND names no backend: figures are drawn into files, which needs none."""
    given = os.environ.get("MPLBACKEND")
    try:
        import matplotlib
    except ValueError:
        if given is None:
            raise
        for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
            del sys.modules[name]  # loaded in part
        del os.environ["MPLBACKEND"]
        try:
            import matplotlib  # noqa: F401
        finally:
            os.environ["MPLBACKEND"] = given
