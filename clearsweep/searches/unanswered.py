"""What helps if `seek` finds no value: limits that would pass, and other keys that change the margin.

The effects of the keys are finite differences.  Their cases are a separate run in a folder of the run's directory, so
it resumes like any other.
"""

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from typing import Any, NamedTuple

from .. import grid as grids
from ..answers.verdict import KINDS, MARGIN_COLUMN, Limit, limits_and_figures_of, units_of
from ..contracts.catalogue import CHOICE
from ..contracts.search import FurtherRuns
from ..language import phases
from ..language.errors import InputError

STEP = 0.1  # relative step: larger than the scatter of chaotic motion, small enough for a slope
FOLDER = "sensitivity"  # prefix of its name; a hash of the keys follows
DIGITS = 4  # digits of a limit that would pass
_AXIS_SECTIONS = ("sweep", "zip", "cases", "sample", "seek")  # sections of a resolved grid that choose cases
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


def effects(grid: grids.Grid, best: Sequence[Mapping[str, Any]], runs: FurtherRuns) -> list[Effect]:
    """Return the effects of the other choices on the margin, the largest first; [] without a margin or `runs.run`.

    They apply to the case furthest from its limits, at its best value.  best : how near each case comes to its limits
    """
    worst = furthest_from_limits(best)
    if grid.search is None or worst is None or runs.run is None:
        return []
    point = worst["point"] | dict.fromkeys(grid.search.varied_paths, worst["value"])
    fixed = {key: section for key, section in grid.resolved().items() if key not in _AXIS_SECTIONS}
    perturbed = _perturbed(grid, point, fixed, runs.catalogue)
    paths = list(perturbed)
    if not paths:
        return []
    point_values = {path: value for path, value in _numbers(grid, point).items() if path in perturbed}
    points = [point_values, *(point_values | {path: value} for path, values in perturbed.items() for value in values)]
    columns = {path: [value] * len(points) for path, value in point.items()}
    columns |= {path: [row[path] for row in points] for path in paths}
    phases.print_line(
        f"no value meets the limits; {len(points)} more cases show which other keys help (--no-effects leaves them out)"
    )
    name = hashlib.sha256(" ".join(sorted(columns)).encode()).hexdigest()[:8]
    table = runs.run(fixed | {"cases": columns}, runs.directory / f"{FOLDER}-{name}").summary
    values_with_margin = table[[*paths, MARGIN_COLUMN]].dropna().to_numpy(float).tolist()
    margins = {tuple(values): margin for *values, margin in values_with_margin}
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


def most_cases(grid: grids.Grid) -> int:
    """Return the largest number of cases that `effects` runs."""
    return 1 + 2 * len(_numbers(grid, grid.point(0)))


def furthest_from_limits(best: Iterable[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the case furthest from its limits at its best value, or None if no margin is known."""
    finite = [case for case in best if case["margin"] is not None]
    return min(finite, key=lambda case: case["margin"], default=None)


def _numbers(grid: grids.Grid, point: Mapping[str, Any]) -> dict[str, float]:
    """Return path -> value (SI) of the numbers of a case that the designer chooses."""
    tree = grid.case_tree(point)
    return {
        path: value
        for path, value in grids.leaves(tree)
        if isinstance(value, float)
        and ".table." not in path
        and value
        and path not in point
        and not path.endswith(_EXPONENT)
        and grid.role(path) == CHOICE
    }


def _perturbed(
    grid: grids.Grid, point: Mapping[str, Any], fixed: dict[str, Any], catalogue: grids.Catalogue
) -> dict[str, list[float]]:
    """Return path -> values lower and higher by STEP, for keys that accept them."""
    perturbed = {}
    for path, value in _numbers(grid, point).items():
        possible = [
            changed
            for changed in (value * (1.0 - STEP), value * (1.0 + STEP))
            if _is_possible(
                fixed | {"cases": {**{axis: [coordinate] for axis, coordinate in point.items()}, path: [changed]}},
                catalogue,
            )
        ]
        if possible:
            perturbed[path] = possible
    return perturbed


def _is_possible(source: dict[str, Any], catalogue: grids.Catalogue) -> bool:
    try:
        grids.load(source, catalogue)
    except InputError:
        return False
    return True


def unanswered_facts(
    record: Mapping[str, Any], best: Sequence[Mapping[str, Any]], effects: Iterable[Effect], catalogue: grids.Catalogue
) -> dict[str, Any]:
    """Return facts about searches without an answer for run.json, in SI.

    record : run.json; best : how near each case comes to its limits
    """
    limits, columns = limits_and_figures_of(record).limits, units_of(record)
    finite = all(case["margin"] is not None for case in best)
    units = grids.key_units(record, catalogue) if effects else {}
    return {
        "best": [{**case} | {"needed": loosened_limits(limits, columns, [case["margins"]])} for case in best],
        "needed": loosened_limits(limits, columns, [case["margins"] for case in best]) if finite else {},
        "furthest": furthest_from_limits(best),
        "effects": [effect._asdict() | {"unit": units.get(effect.path, "1")} for effect in effects],
    }


def loosened_limits(
    limits: Sequence[Limit], units: Mapping[str, str], margins: Sequence[Mapping[str, float]]
) -> dict[str, str]:
    """Return in words the exceeded limits for cases with these margins, each relaxed so that all cases pass.

    Columns with two limits are left out: a margin does not show which limit is exceeded.
    """
    texts: dict[str, str] = {}
    columns = Counter(limit.column for limit in limits)
    for limit in limits:
        margin = min((margin.get(limit.column, 0.0) for margin in margins), default=0.0)
        if margin < 0.0 and columns[limit.column] > 1:
            return {}
        if margin < 0.0:
            is_upper = limit.kind == KINDS[0]
            size = abs(limit.value) or 1.0  # the margin to a bound of 0 is the excess
            loosened = limit.value + size * (-margin if is_upper else margin)
            value = _rounded(loosened, ROUND_CEILING if is_upper else ROUND_FLOOR)
            texts[limit.column] = replace(limit, value=value).bound_text(units.get(limit.column, "1"))
    return texts


def _rounded(value: float, rounding: str) -> float:
    """Return a number with DIGITS digits, rounded up or down so that the relaxed limit still passes."""
    exact = Decimal(f"{value:.12g}")  # removes rounding errors of a margin
    return float(exact.quantize(Decimal(1).scaleb(exact.adjusted() + 1 - DIGITS), rounding))
