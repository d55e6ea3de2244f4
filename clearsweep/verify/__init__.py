"""How true the answers are and what they cost: error against run time on problems with known answers.

A problem (`problems`) is a trajectory in quadruple precision or a closed form; the rivals (`rivals`) are
integrators that others use, on the same compiled laws; `measure` runs all on all, a chaotic case over tolerances and
lengths (`convergence`), every case of a table of stiff and extreme ones (`stability`), and cases that show what the
implicit method saves (`stiff`).
"""

import sys
from pathlib import Path


def main(json: bool = False, quick: bool = False, directory=None) -> None:
    """Measure, and print the tables or, for programs, JSON; what is being done goes to stderr.

    `quick` takes fewer tolerances, steps, rounds and extreme cases, and ends within a minute; `directory` : where the
    report is written, see `write`.
    """
    from json import dumps

    from . import text

    results = measure(quick, lambda what: print(f"verify: {what}", file=sys.stderr, flush=True))
    print(dumps(results, indent=2, allow_nan=False) if json else text.text(results), flush=True)
    if directory is not None:
        print(f"verify: wrote {write(results, directory)}", file=sys.stderr, flush=True)


def measure(quick: bool = False, note=None) -> dict:
    """Return all figures as a dict that JSON can hold; see `measure` of each of the modules named above."""
    from . import accuracy, convergence, stability, stiff

    more = {"convergence": convergence, "stability": stability, "stiffness": stiff}
    return accuracy.measure(quick, note) | {name: module.measure(quick, note) for name, module in more.items()}


def write(results: dict, directory) -> Path:
    """Write `accuracy.md` and its figure, `accuracy/error.svg`, below `directory`; return the path of the former."""
    from . import figure, text

    directory = Path(directory)
    (directory / "accuracy").mkdir(parents=True, exist_ok=True)
    figure.draw(results, directory / "accuracy" / "error.svg")
    page = directory / "accuracy.md"
    page.write_text(text.markdown(results), encoding="utf-8")
    return page


def draw(results: dict, path) -> Path:
    """Draw error against run time, a panel a problem, as SVG or PNG by the ending of `path`; return the path."""
    from . import figure

    return figure.draw(results, path)
