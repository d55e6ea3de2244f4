"""Reports: one offline HTML page of a run, its tables and figures, and one case simulated again and drawn."""

from pathlib import Path
from typing import TYPE_CHECKING

from ..store import StoredRun

if TYPE_CHECKING:
    from .page import Page  # loads what draws


class Run(StoredRun):
    """The results in one directory, as the store reads them, that can write their report."""

    def figures(self, directory: str | Path, form: str = "svg", width: str = "auto") -> list[Path]:
        """Write every figure of the report as `clearsweep.report.figures` does; return the paths."""
        return figures(self, directory, form, width)

    def report(self, out: str | Path | None = None) -> Path:
        """Write the report as one self-contained HTML file, default report.html in the directory; return its path."""
        return write(self, out or self.directory / "report.html")


def open(directory: str | Path) -> Run:
    """Return the run in `directory`: its summary, orbits, events and wear; raise DirectoryError where there is none."""
    return Run(directory)


def of(run: "StoredRun", *, typical: bool = False) -> "Page":
    """Return the page of a run (as the store opens it), to write it, its tables, its figures.

    Maps show the worst case over the axes that they leave out; `typical`: the median.
    """
    from . import page, study

    return page.of(study.prepare(run, typical=typical))


def compared(first: "StoredRun", second: "StoredRun") -> "Page":
    """Return the page that compares two runs case by case."""
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
    from . import paper

    return of(run).write_figures(paper.Wanted(Path(directory), form, width))


def show(run: "StoredRun", case_id: str, out: str | Path) -> Path:
    """Simulate one case of a run again and draw it, as HTML, SVG or PNG by the ending of `out`; return its path."""
    from . import single

    return single.show(run, case_id, Path(out))


def draw(source: str | Path, out: str | Path) -> Path:
    """Draw the mechanism of a grid at its start, as SVG or PNG by the ending of `out`; return its path."""
    from . import mechanism

    return mechanism.draw(Path(source), Path(out))
