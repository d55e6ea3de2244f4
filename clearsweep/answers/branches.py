"""Motions that coexist: cases that differ in their start alone and end in different motions."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..contracts.catalogue import STARTS
from ..contracts.layout import Layout
from .judged import Cases, codes_of, combined_codes, median, plain_value
from .words import Answer, Sentence, Words

DISTINCT = 0.05  # of the larger median: a smaller difference is none
MAX_POINTS = 1000  # points with several motions that an answer lists
MAX_CASES = 20  # cases of a motion that it lists


def coexisting(cases: Cases, layout: Layout) -> dict[str, Any] | None:
    """Return at which points of a grid its starts lead to different motions; None if it has one start.

    The statistic is the median of the largest forces of each revolution, in every joint.  Two cases have different
    motions if in some joint the 95 % intervals of this median do not overlap, nor does any chain of intervals of other
    cases connect them, and the medians differ by more than DISTINCT.  A case without an interval is undecided.
    """
    starts = [path for path in cases.paths if path in STARTS]
    medians = [column.name for column in layout.columns if column.figure == "force_peak_median"]
    if not starts or not medians or not len(cases):
        return None
    others = [path for path in cases.paths if path not in STARTS]
    points = combined_codes([codes_of(cases.values(path))[1] for path in others], len(cases))
    ends = ("", "_low", "_high")  # of the names of a median and its interval, (n, 3) N
    statistics = {name: np.stack([cases.numbers(f"{name}{end}") for end in ends], -1) for name in medians}
    is_known = np.logical_and.reduce([np.isfinite(statistic).all(axis=1) for statistic in statistics.values()])
    several, undecided = [], 0
    for point in sorted({*points.tolist()}):
        rows = np.flatnonzero(points == point)
        known = rows[is_known[rows]]
        labels = [motions_of(statistic[known]) for statistic in statistics.values()]
        groups = [known[number] for number in _groups(labels)]
        undecided += len(known) < len(rows) and len(groups) < 2
        if len(groups) > 1:
            several.append(_point(cases, others, rows, groups, statistics))
    spans = [[each["values"][path] for each in several] for path in others if len(others) == 1]
    between = [
        sum(min(span) <= value <= max(span) for value in codes_of(cases.values(path))[0])
        for path, span in zip(others, spans, strict=False)
        if span and not isinstance(span[0], str)
    ]
    counts = {"points": len({*points.tolist()}), "coexisting": len(several), "undecided": int(undecided)}
    counts |= {"between": sum(between)}
    return {"along": starts[0], **counts, "motions": several[:MAX_POINTS]}


def motions_of(statistic: np.ndarray) -> np.ndarray:
    """Return the number of the motion of each case from its median and the ends of its interval, (n, 3); see above."""
    order, labels = np.argsort(statistic[:, 1], kind="stable"), np.zeros(len(statistic), int)
    label, highest, largest = 0, np.inf, np.inf
    for row in order.tolist():
        median, low, high = statistic[row].tolist()
        if low > highest and median - largest > DISTINCT * median:
            label, highest, largest = label + 1, high, median
        highest = high if np.isinf(highest) else max(highest, high)
        largest = median if np.isinf(largest) else max(largest, median)
        labels[row] = label
    return labels


def _groups(labels: list[np.ndarray]) -> list[np.ndarray]:
    """Return the positions of the cases of each motion, whose labels are equal in every joint."""
    number = combined_codes(labels, len(labels[0]))
    return [np.flatnonzero(number == each) for each in sorted({*number.tolist()})]


def _point(
    cases: Cases, paths: list[str], rows: np.ndarray, groups: list[np.ndarray], statistics: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    """Return one point with its motions, the one with the smallest force first."""
    means = {name: [median(statistic[group, 0]) for group in groups] for name, statistic in statistics.items()}
    figure = max(means, key=lambda name: max(means[name]) / max(min(means[name]), 1e-300))
    motions = [
        {
            "median": median,
            "low": float(statistics[figure][group, 1].min()),
            "high": float(statistics[figure][group, 2].max()),
            "starts": len(group),
            "share": len(group) / len(rows),
            "cases": [str(cases.values("case_id")[row]) for row in group[:MAX_CASES].tolist()],
        }
        for median, group in sorted(zip(means[figure], groups, strict=True), key=lambda pair: pair[0])
    ]
    values = {path: plain_value(cases.values(path)[rows[0]]) for path in paths}
    return {"values": values, "figure": figure, "motions": motions, "undecided": len(rows) - sum(map(len, groups))}


COUNTS = {2: "Two", 3: "Three", 4: "Four", 5: "Five", 6: "Six"}


def branch_sentences(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say where motions coexist and what their forces are, or that the starts show no difference."""
    branches = answer.get("branches")
    if not branches:
        return
    total, points = branches["points"], branches["motions"]
    starts = "up and down" if branches["along"] == STARTS[0] else "from random starts"
    if points:
        point = max(points, key=lambda each: each["motions"][-1]["median"] / max(each["motions"][0]["median"], 1e-300))
        count = len(point["motions"])
        values = {
            "many": COUNTS.get(count, str(count)),
            "where": _where(branches, words, point),
            "figure": words.figure(point["figure"]),
            "forces": _forces(point, words),
            "starts": _starts(point) if branches["along"] == STARTS[1] else "",
        }
        yield Sentence("{many} motions coexist {where}: {figure} {forces}{starts}.", values)
    elif branches["undecided"] < total:
        decided = total - branches["undecided"]
        values = {"starts": starts, "count": decided, "noun": "point" if decided == 1 else "points"}
        yield Sentence("The motions {starts} show no difference at {count} {noun}.", values)
    if branches["undecided"]:
        values = {"count": branches["undecided"], "total": total}
        template = "Whether motions coexist is undecided at {count} of {total} points; {remedy}."
        yield Sentence(template, values | {"remedy": "run more revolutions, at least 30 after simulate.discard"})


def _forces(point: Mapping[str, Any], words: Words) -> str:
    """Return '1.1 or 2.6 kN', after the name of the figure."""
    texts = words.figures(point["figure"], [motion["median"] for motion in point["motions"]])
    numbers, units = zip(*(text.split(maxsplit=1) for text in texts), strict=True)
    shown = numbers if len(set(units)) == 1 else texts
    return " or ".join([*shown[:-1], texts[-1]])


def _starts(point: Mapping[str, Any]) -> str:
    """Return how many random starts lead to each motion."""
    counts = [str(motion["starts"]) for motion in point["motions"]]
    total = sum(motion["starts"] for motion in point["motions"]) + point["undecided"]
    return f", after {' and '.join(counts)} of {total} starts"


def _where(branches: Mapping[str, Any], words: Words, point: Mapping[str, Any]) -> str:
    """Return 'from 640 to 820 rpm' if the only axis has them in between, else how many points, and one of them."""
    points, total = branches["motions"], branches["points"]
    paths = list(point["values"])
    if len(paths) == 1 and len(points) > 1 and not isinstance(point["values"][paths[0]], str):
        ends = sorted(each["values"][paths[0]] for each in points)
        first, last = (words.value(paths[0], value) for value in (ends[0], ends[-1]))
        unit = last.partition(" ")[2]
        is_whole = branches["coexisting"] == branches["between"]
        gaps = "" if is_whole else f" at {branches['coexisting']} of {branches['between']} values"
        return f"from {first.removesuffix(f' {unit}')} to {last}{gaps}"
    if total == 1:
        return f"at {words.setting(point['values'])}" if paths else "there"
    such = f", such as {words.setting(point['values'])}" if len(points) > 1 else f", {words.setting(point['values'])}"
    return f"at {branches['coexisting']} of {total} points{such}"
