"""Identified parameters: intervals, distributions, and the fit of the best cases."""

import itertools
from typing import Any

import pandas as pd

from ...answers import identification
from ...language import wording
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Block, Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Quantity, Table
from ..data.axis import Axis
from ..data.study import Study
from ..draw import posterior

MAX_PAIRS = 6  # of keys that are drawn


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing was identified, or the run did not end."""
    identified: dict[str, Any] = study.run.grid.get("identified") or {}
    sample = study.run.identify if identified else None
    if sample is None or sample.empty:
        return []
    axes = {axis.path: axis for axis in study.axes}
    joint_count = _joint_count(identified)
    blocks: list[Block] = [
        Sentences(
            [*(f"{_estimate_text(axes[parameter['path']], parameter)}." for parameter in identified["parameters"])]
        ),
        Sentences(identification.sentences(identified, joint_count)),
        Gallery(
            "Dashed lines are the ends of the 95 % interval, the solid line is the median.",
            _pictures(identified, sample, axes),
        ),
        _parameter_table(identified, axes),
    ]
    return [Section("identify", "The identified machine", without_empty(blocks))]


def folded_sections(study: Study) -> list[Section]:
    """Return pairs of keys and the fit of each feature, or [] if nothing was identified."""
    if not sections(study):
        return []
    identified, sample = study.run.grid["identified"], study.run.identify
    pairs = Gallery(
        "Darker cells are more probable.", _pair_pictures(identified, sample, {axis.path: axis for axis in study.axes})
    )
    return [
        Section(
            "identify-more", "Identified pairs and measured features", without_empty([pairs, _fit_table(identified)])
        )
    ]


def parameter_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return a card for each key that was identified."""
    axes = {axis.path: axis for axis in study.axes}
    identified = study.run.grid.get("identified") or {}
    return [
        (
            capitalise(axes[parameter["path"]].name),
            axes[parameter["path"]].scale.text(parameter["value"]),
            _interval_text(axes[parameter["path"]], parameter),
        )
        for parameter in identified.get("parameters", ())
    ]


def _joint_count(identified: dict[str, Any]) -> int:
    return len(
        {
            parameter["path"].split(".")[1]
            for parameter in identified["parameters"]
            if parameter["path"].startswith("joints.")
        }
    )


def _interval_text(axis: Axis, parameter: dict[str, Any]) -> str:
    """Return the interval of a key."""
    return f"95 %: {axis.scale.number_text(parameter['low'])} to {axis.scale.text(parameter['high'])}"


def _estimate_text(axis: Axis, parameter: dict[str, Any]) -> str:
    """Return a value, its interval, and its certainty."""
    text = (
        f"{axis.name} {axis.scale.text(parameter['value'])} "
        f"({_interval_text(axis, parameter)}){identification.certainty_text(parameter)}"
    )
    return text[0].upper() + text[1:]


def _pictures(identified: dict[str, Any], sample: pd.DataFrame, axes: dict[str, Axis]) -> list[Picture]:
    """Return the distribution of each key."""
    weights = sample["weight"].to_numpy()

    def density_picture(parameter: dict[str, Any]) -> Picture:
        axis, quantiles = axes[parameter["path"]], (parameter["low"], parameter["value"], parameter["high"])

        def paint(ax: Any) -> None:
            posterior.draw_density(ax, sample[axis.path].to_numpy(), weights, quantiles, axis)

        return Picture(f"Probability of {axis.name}", "", f"{_estimate_text(axis, parameter)}.", paint)

    return [density_picture(parameter) for parameter in identified["parameters"]]


def _pair_pictures(identified: dict[str, Any], sample: pd.DataFrame, axes: dict[str, Axis]) -> list[Picture]:
    """Return the distributions of pairs of keys."""
    weights = sample["weight"].to_numpy()

    def pair_picture(x_axis: Axis, y_axis: Axis) -> Picture:
        def paint(ax: Any) -> None:
            pair = (sample[x_axis.path].to_numpy(), sample[y_axis.path].to_numpy())
            posterior.draw_joint_density(ax, pair, weights, (x_axis, y_axis))

        title = f"{x_axis.name} and {y_axis.name}"
        return Picture(title, "", f"Probability of pairs of {title}.", paint)

    pairs = itertools.combinations([axes[parameter["path"]] for parameter in identified["parameters"]], 2)
    return [pair_picture(*pair) for pair in itertools.islice(pairs, MAX_PAIRS)]


def _parameter_table(identified: dict[str, Any], axes: dict[str, Axis]) -> Table:
    """Return a row for each key."""
    rows = []
    for parameter in identified["parameters"]:
        axis = axes[parameter["path"]]
        cells = [Quantity(parameter[name], axis.scale.text(parameter[name])) for name in ("value", "low", "high")]
        rows.append((axis.name, *cells, parameter["determined"]))
    columns = (Column("key"), Column("median"), Column("from"), Column("to"), Column("determined"))
    return Table("identify", "Keys with their 95 % intervals", "", columns, rows)


def _fit_table(identified: dict[str, Any]) -> Table:
    """Return a row for each feature."""
    rows = []
    for fit in identified["fits"]:
        cells = [
            Quantity(fit[name], wording.quantity_text(fit[name], fit["unit"])) for name in ("measured", "computed")
        ]
        rows.append((fit["channel"], fit["feature"], *cells, fit["deviations"]))
    columns = (Column("signal"), Column("feature"), Column("measured"), Column("computed"), Column("deviations"))
    note = (
        "Computed values are medians of the best cases. Deviations are measured minus computed values, in standard "
        "deviations."
    )
    return Table("identify-fit", "Features measured and computed", note, columns, rows)
