"""Accuracy and cost: error against run time on problems with known answers.

A problem (`problems`) is a trajectory in quadruple precision or a closed form.  The rivals (`rivals`) are integrators
in common use, on the same compiled laws.  `measure` runs all methods on all problems, every case of a table of stiff
and extreme ones (`stability`), and (`comparisons`) a chaotic case over tolerances and lengths, machines with known
motion, and stiff cases by both methods.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..language import phases


def main(*, json: bool = False, quick: bool = False, directory: str | Path | None = None) -> None:
    """Measure, and print the tables or JSON; progress goes to stderr.

    `quick` uses fewer tolerances, steps, rounds and extreme cases, and ends within a minute; `directory` : destination
    of the report, see `write`.
    """
    from json import dumps

    from . import text

    latest_line = ["verify"]

    def report_progress(sentence: str) -> None:
        latest_line[0] = f"verify: {sentence}"
        phases.print_line(latest_line[0])

    with phases.phase(lambda: latest_line[0]):
        results = measure(quick=quick, report_progress=report_progress)
    print(dumps(results, indent=2, allow_nan=False) if json else text.results_text(results), flush=True)
    if directory is not None:
        phases.print_line(f"verify: wrote {write(results, directory)}")


def measure(*, quick: bool = False, report_progress: Callable[[str], None] | None = None) -> dict[str, Any]:
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


def draw(results: dict[str, Any], path: str | Path) -> Path:
    """Draw error against run time, one panel per problem, as SVG or PNG by the ending of `path`; return the path."""
    from . import text

    return text.draw(results, path)
