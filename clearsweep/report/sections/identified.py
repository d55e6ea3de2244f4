"""Identified parameters: intervals, distributions, and the fit of the best cases."""

import itertools
from typing import Any

import pandas as pd

from ...judging import identification
from ...language import wording
from ..blocks.picture import Picture
from ..blocks.section import Block, Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.axis import Axis
from ..data.study import Study
from ..draw import posterior

PAIRS = 6  # of keys that are drawn


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing was identified, or the run did not end."""
    identified: dict[str, Any] = study.run.grid.get("identified") or {}
    sample = study.run.identify if identified else None
    if sample is None or sample.empty:
        return []
    axes = {axis.path: axis for axis in study.axes}
    joints = _joints(identified)
    blocks: list[Block] = [
        Sentences([*(f"{_estimate_text(axes[each['path']], each)}." for each in identified["parameters"])]),
        Sentences(identification.sentences(identified, joints)),
        Gallery(
            "Dashed lines are the ends of the 95 % interval, the solid line is the median.",
            _pictures(identified, sample, axes),
        ),
        _parameters(identified, axes),
    ]
    return [Section("identify", "The identified machine", without_empty(blocks))]


def more(study: Study) -> list[Section]:
    """Return pairs of keys and the fit of each feature, or [] if nothing was identified."""
    if not sections(study):
        return []
    identified, sample = study.run.grid["identified"], study.run.identify
    pairs = Gallery(
        "Darker cells are more probable.", _pairs(identified, sample, {axis.path: axis for axis in study.axes})
    )
    return [
        Section("identify-more", "Identified pairs and measured features", without_empty([pairs, _fits(identified)]))
    ]


def cards(study: Study) -> list[tuple[str, str, str]]:
    """Return a card for each key that was identified."""
    axes = {axis.path: axis for axis in study.axes}
    identified = study.run.grid.get("identified") or {}
    return [
        (axes[each["path"]].name, axes[each["path"]].scale.text(each["value"]), _interval(axes[each["path"]], each))
        for each in identified.get("parameters", ())
    ]


def _joints(identified: dict[str, Any]) -> int:
    return len({each["path"].split(".")[1] for each in identified["parameters"] if each["path"].startswith("joints.")})


def _interval(axis: Axis, each: dict[str, Any]) -> str:
    """Return the interval of a key."""
    return f"95 %: {axis.scale.number(each['low'])} to {axis.scale.text(each['high'])}"


def _estimate_text(axis: Axis, each: dict[str, Any]) -> str:
    """Return a value, its interval, and its certainty."""
    text = f"{axis.name} {axis.scale.text(each['value'])} ({_interval(axis, each)}){identification.certainty(each)}"
    return text[0].upper() + text[1:]


def _pictures(identified: dict[str, Any], sample: pd.DataFrame, axes: dict[str, Axis]) -> list[Picture]:
    """Return the distribution of each key."""
    weights = sample["weight"].to_numpy()

    def single(each: dict[str, Any]) -> Picture:
        axis, ends = axes[each["path"]], (each["low"], each["value"], each["high"])

        def paint(ax: Any) -> None:
            posterior.draw_density(ax, sample[axis.path].to_numpy(), weights, ends, axis)

        return Picture(f"Probability of {axis.name}", "", f"{_estimate_text(axis, each)}.", paint)

    return [single(each) for each in identified["parameters"]]


def _pairs(identified: dict[str, Any], sample: pd.DataFrame, axes: dict[str, Axis]) -> list[Picture]:
    """Return the distributions of pairs of keys."""
    weights = sample["weight"].to_numpy()

    def both(first: Axis, second: Axis) -> Picture:
        def paint(ax: Any) -> None:
            pair = (sample[first.path].to_numpy(), sample[second.path].to_numpy())
            posterior.draw_joint_density(ax, pair, weights, (first, second))

        title = f"{first.name} and {second.name}"
        return Picture(title, "", f"Probability of pairs of {title}.", paint)

    pairs = itertools.combinations([axes[each["path"]] for each in identified["parameters"]], 2)
    return [both(*pair) for pair in itertools.islice(pairs, PAIRS)]


def _parameters(identified: dict[str, Any], axes: dict[str, Axis]) -> Table:
    """Return a row for each key."""
    rows = []
    for each in identified["parameters"]:
        axis = axes[each["path"]]
        cells = [Quantity(each[name], axis.scale.text(each[name])) for name in ("value", "low", "high")]
        rows.append((axis.name, *cells, each["determined"]))
    columns = (Column("key"), Column("median"), Column("from"), Column("to"), Column("determined"))
    return Table("identify", "Keys with their 95 % intervals", "", columns, rows)


def _fits(identified: dict[str, Any]) -> Table:
    """Return a row for each feature."""
    rows = []
    for each in identified["fits"]:
        cells = [Quantity(each[name], wording.text(each[name], each["unit"])) for name in ("measured", "computed")]
        rows.append((each["channel"], each["feature"], *cells, each["deviations"]))
    columns = (Column("signal"), Column("feature"), Column("measured"), Column("computed"), Column("deviations"))
    note = (
        "Computed values are medians of the best cases. Deviations are measured minus computed values, in standard "
        "deviations."
    )
    return Table("identify-fit", "Features measured and computed", note, columns, rows)
