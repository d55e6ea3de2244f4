"""How true the answers are and what they cost: error against run time on problems with known answers.

A problem (`problems`) is a trajectory in quadruple precision or a closed form; the yardsticks (`yardsticks`) are
integrators that others use, on the same compiled laws; `measure` runs all on all.
"""

import sys
from pathlib import Path


def main(json: bool = False, quick: bool = False) -> None:
    """Measure, and print the tables or, for programs, JSON; what is being done goes to stderr.

    `quick` takes fewer tolerances, steps and rounds, and ends within a minute.
    """
    from json import dumps

    from . import table

    results = measure(quick, lambda what: print(f"verify: {what}", file=sys.stderr, flush=True))
    print(dumps(results, indent=2, allow_nan=False) if json else table.text(results), flush=True)


def measure(quick: bool = False, note=None) -> dict:
    """Return all figures as a dict that JSON can hold; see `measuring.measure`."""
    from .measuring import measure as run

    return run(quick, note)


def draw(results: dict, path) -> Path:
    """Draw error against run time, a panel a problem, as SVG or PNG by the ending of `path`; return the path."""
    from . import figure

    return figure.draw(results, path)
