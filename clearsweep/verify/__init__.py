"""Accuracy and cost: error against run time on problems with known answers.

A problem (`problems`) is a trajectory in quadruple precision or a closed form.  The rivals (`rivals`) are integrators
in common use, on the same compiled laws.  `measure` runs all methods on all problems, every case of a table of stiff
and extreme ones (`stability`), and (`comparisons`) a chaotic case over tolerances and lengths, machines with known
motion, and stiff cases by both methods.
"""

import contextlib
from collections.abc import Callable, Iterator
from json import dumps
from pathlib import Path
from typing import Any

from ..language import phases

Report = Callable[[str], None]  # takes the name of a step as soon as it begins


def main(*, json: bool = False, quick: bool = False, directory: str | Path | None = None) -> None:
    """Measure, and print the tables or JSON; progress goes to stderr.

    `quick` uses fewer tolerances, steps, rounds and extreme cases, and ends within a minute; `directory` : destination
    of the report, see `write`.
    """
    from . import text

    with announced_steps("verify", phases.print_line) as report_progress:
        results = measure(quick=quick, report_progress=report_progress)
    publish(results, results if json else text.results_text(results), directory, write)


@contextlib.contextmanager
def announced_steps(command: str, report: Report = lambda line: None) -> Iterator[Report]:
    """Open a phase with the name of the latest step; yield the function that takes a step, whose line is reported."""
    latest_line = [command]

    def report_progress(step: str) -> None:
        latest_line[0] = f"{command}: {step}"
        report(latest_line[0])

    with phases.phase(lambda: latest_line[0]):
        yield report_progress


def publish(results: Any, shown: Any, directory: str | Path | None, write: Callable[[Any, Any], Path]) -> None:
    """Print text as it is and other values as JSON; `write` the results into a directory, if there is one."""
    print(shown if isinstance(shown, str) else dumps(shown, indent=2, allow_nan=False), flush=True)
    if directory is not None:
        phases.print_line(f"verify: wrote {write(results, directory)}")


def measure(*, quick: bool = False, report_progress: Report = lambda step: None) -> dict[str, Any]:
    """Return all figures as a dict for JSON; see `measure` of each of the modules named above."""
    from . import accuracy, comparisons, stability

    parts = {
        "machines": comparisons.measure_machines,
        "convergence": comparisons.measure_convergence,
        "stability": stability.measure,
        "stiffness": comparisons.measure_stiff,
    }
    results = accuracy.measure(quick=quick, report_progress=report_progress)
    return results | {name: part(quick=quick, report_progress=report_progress) for name, part in parts.items()}


def write(results: dict[str, Any], directory: str | Path) -> Path:
    """Write `accuracy.md` and its figure, `accuracy/error.svg`, into `directory`; return the path of the former."""
    from . import text

    directory = Path(directory)
    (directory / "accuracy").mkdir(parents=True, exist_ok=True)
    text.draw(results, directory / "accuracy" / "error.svg")
    page = directory / "accuracy.md"
    page.write_text(text.results_markdown(results), encoding="utf-8")
    return page
