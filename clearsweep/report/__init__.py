"""Reports: one offline HTML page of a run, its tables as CSV, and one case simulated again and drawn."""

from pathlib import Path

from ..store import StoredRun


class Run(StoredRun):
    """The results in one directory, as the store reads them, that can write their report."""

    def report(self, out: str | Path | None = None) -> Path:
        """Write the report as one self-contained HTML file, default report.html in the directory; return its path."""
        return write(self, out or self.directory / "report.html")


def open(directory: str | Path) -> Run:
    """Return the run in `directory`: its summary, orbits, events and wear; raise DirectoryError where there is none."""
    return Run(directory)


def write(run: "StoredRun", out: str | Path, *, typical: bool = False) -> Path:
    """Write the report of a run (as the store opens it) as one self-contained HTML file; return its path.

    Maps show the worst case over the axes that they leave out; `typical`: the median.
    """
    from . import page

    return page.write(run, Path(out), typical=typical)


def tables(run: "StoredRun", directory: str | Path) -> list[Path]:
    """Write every table of a run as CSV (SI, units in the header) into a directory; return the paths."""
    from . import page

    return page.write_tables(run, Path(directory))


def compare(first: "StoredRun", second: "StoredRun", out: str | Path, tables: str | Path | None = None) -> Path:
    """Write the comparison of two runs, case by case, as one HTML file, and its tables as CSV; return the file."""
    from . import two_runs

    if tables:
        two_runs.tables(first, second, Path(tables))
    return two_runs.write(first, second, Path(out))


def show(run: "StoredRun", case_id: str, out: str | Path) -> Path:
    """Simulate one case of a run again and draw it, as HTML, SVG or PNG by the ending of `out`; return its path."""
    from . import single

    return single.show(run, case_id, Path(out))


def draw(source: str | Path, out: str | Path) -> Path:
    """Draw the mechanism of a grid at its start, as SVG or PNG by the ending of `out`; return its path."""
    from . import mechanism

    return mechanism.draw(Path(source), Path(out))
