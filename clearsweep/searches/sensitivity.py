"""If `seek` finds no value: which other keys of the grid change the margin, from finite differences.

The cases are a separate run in a folder of the run's directory, so it resumes like any other.
"""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from .. import grid as grids
from .. import store
from ..answers.verdict import MARGIN_COLUMN
from ..language.errors import InputError
from ..sweeping.pool.worker import Simulator
from .seeking import Answer

STEP = 0.1  # relative step: larger than the scatter of chaotic motion, small enough for a slope
FOLDER = "sensitivity"  # prefix of its name; a hash of the keys follows
_AXIS_SECTIONS = ("sweep", "zip", "cases", "sample", "seek")  # sections of a resolved grid that choose cases
_METHOD_PREFIXES = ("simulate.", "save.", "uncertain.")  # keys that are not properties of the machine
_EXPONENT = ".exponent"  # the units of other keys depend on this key


class Effect(NamedTuple):
    """Effect of a key on the margin if no tried value meets the limits."""

    path: str
    value: float  # SI, value in the grid
    margin: float  # margin at this value
    lower: float | None  # margin with the value lower by STEP, or None if the case failed or is impossible
    upper: float | None

    @property
    def size(self) -> float:
        """Return the largest change of the margin."""
        return max(abs(margin - self.margin) for margin in (self.lower, self.upper, self.margin) if margin is not None)


def effects(
    grid: grids.Grid, answers: list[Answer], directory: Path, simulator: Simulator, run: Callable[[dict, Path], Any]
) -> list[Effect]:
    """Return the effects of other keys on the margin, the largest first, or [] if every search has an answer.

    They apply to the case furthest from its limits, at its best value.  `run` runs a grid in a directory.
    """
    worst = furthest_from_limits(answers)
    if grid.seek is None or worst is None:
        return []
    point = worst["point"] | dict.fromkeys(grid.seek.paths, worst["value"])
    fixed = {key: section for key, section in grid.resolved().items() if key not in _AXIS_SECTIONS}
    perturbed = _perturbed(grid, point, fixed, simulator)
    paths = list(perturbed)
    if not paths:
        return []
    point_values = {path: value for path, value in _numbers(grid, point).items() if path in perturbed}
    points = [point_values, *(point_values | {path: value} for path, values in perturbed.items() for value in values)]
    columns = {path: [value] * len(points) for path, value in point.items()}
    columns |= {path: [row[path] for row in points] for path in paths}
    name = hashlib.sha256(" ".join(sorted(columns)).encode()).hexdigest()[:8]
    out = directory / f"{FOLDER}-{name}"
    run(fixed | {"cases": columns}, out)
    margins = _margins(store.open(out), paths)
    start = margins.get(tuple(point_values.values()))
    if start is None:
        return []
    effects = []
    for path in paths:
        neighbours = [
            margins.get(tuple((point_values | {path: point_values[path] * factor}).values()))
            for factor in (1.0 - STEP, 1.0 + STEP)
        ]
        effects.append(Effect(path, point_values[path], start, *neighbours))
    return sorted(effects, key=lambda effect: (-effect.size, effect.path))


def furthest_from_limits(answers: Iterable[Answer]) -> dict[str, Any] | None:
    """Return the case furthest from its limits at its best value, or None if every search has an answer."""
    finite = [case for answer in answers for case in answer.best if case["margin"] is not None]
    return min(finite, key=lambda case: case["margin"], default=None)


def _numbers(grid: grids.Grid, point: Mapping[str, Any]) -> dict[str, float]:
    """Return path -> value (SI) of the numbers of a case that could be changed."""
    tree = grid.case_tree(point)
    return {
        path: value
        for path, value in grids.leaves(tree)
        if isinstance(value, float)
        and value
        and path not in point
        and not path.startswith(_METHOD_PREFIXES)
        and not path.endswith(_EXPONENT)
    }


def _perturbed(
    grid: grids.Grid, point: Mapping[str, Any], fixed: dict[str, Any], simulator: Simulator
) -> dict[str, list[float]]:
    """Return path -> values lower and higher by STEP, for keys that accept them."""
    perturbed = {}
    for path, value in _numbers(grid, point).items():
        possible = [
            changed
            for changed in (value * (1.0 - STEP), value * (1.0 + STEP))
            if _is_possible(
                fixed | {"cases": {**{axis: [coordinate] for axis, coordinate in point.items()}, path: [changed]}},
                simulator,
            )
        ]
        if possible:
            perturbed[path] = possible
    return perturbed


def _is_possible(source: dict[str, Any], simulator: Simulator) -> bool:
    try:
        grids.load(source, simulator.catalogue())
    except InputError:
        return False
    return True


def _margins(run: store.StoredRun, paths: list[str]) -> dict[tuple[float, ...], float]:
    """Return values of some keys -> margin of the case with them."""
    table = run.summary
    values_with_margin = table[[*paths, MARGIN_COLUMN]].dropna().to_numpy(float).tolist()
    return {tuple(values): margin for *values, margin in values_with_margin}
