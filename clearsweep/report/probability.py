"""The part of a report on a sample: how the figures spread, how likely limits are exceeded, what drives the spread."""

from typing import NamedTuple

import numpy as np

from .. import wording
from ..errors import InputError
from . import draw, sensitivity
from .figures import Canvas, Picture
from .findings import percent
from .sensitivity import Estimate, Setting
from .study import Study
from .table import Column, Quantity, Table

HISTOGRAMS = 12  # drawn at most
JOINT = (
    ("force_p99", "force p99"),
    ("force_rms", "force rms"),
    ("force_peak", "force peak"),
    ("impacts_per_rev", "impacts per rev."),
    ("wear_depth_max", "wear depth"),
    ("wear_volume", "wear volume"),
)
WHOLE = (
    ("slider_error_max", "slider error"),
    ("slider_acceleration_peak", "slider acc. peak"),
    ("crank_torque_peak", "crank torque peak"),
    ("pair_restitution", "restitution"),
)


class Figure(NamedTuple):
    """One figure of merit whose spread is told."""

    column: str
    name: str
    unit: str
    limit: float | None


class Part(NamedTuple):
    """What a report says about a sample."""

    tables: list[Table]
    pictures: list[Picture]
    sentences: list[str]


def part(study: Study, canvas: Canvas) -> Part:
    """Return tables, histograms and sentences about the sample of a run; none of them where it has none."""
    samples = [one for one in sensitivity.settings(study.run) if len(one.failed) < len(set(one.case_ids))]
    if not samples:
        return Part([], [], [])
    found, sentences = _tables(study, samples)
    pictures = [
        _histogram(canvas, study, one, figure)
        for figure in _figures(study)
        for one in samples
        if study.run.grid["sample"]["method"] in INDEPENDENT and np.isfinite(one.figures[figure.column]).any()
    ][:HISTOGRAMS]
    return Part(found, pictures, sentences)


def tables(study: Study) -> list[Table]:
    """Return the tables about the sample of a run, [] where it has none."""
    samples = [one for one in sensitivity.settings(study.run) if len(one.failed) < len(set(one.case_ids))]
    return _tables(study, samples)[0] if samples else []


#: Methods whose points stand for the distributions.
INDEPENDENT = ("sobol", "latin-hypercube", "random")


def _tables(study: Study, samples: list[Setting]) -> tuple[list[Table], list[str]]:
    method = study.run.grid["sample"]["method"]
    if method in INDEPENDENT:
        return [table for table in (_spreads(study, samples), _limits(study, samples)) if table.rows], []
    try:
        table, sentences = (_indices if method == "saltelli" else _effects)(study, samples)
        return [table], sentences
    except InputError as refusal:
        return [], [f"No sensitivity. {refusal}"]


def _figures(study: Study) -> list[Figure]:
    """Return the figures whose spread is told: those that matter, and those that have a limit."""
    limits, several = study.run.grid.get("limits") or {}, len(study.joints) > 1
    named = {
        joint.column(figure): f"{name} ({joint.title})" if several else name
        for joint in study.joints
        for figure, name in JOINT
    } | dict(WHOLE)
    named |= {column: column.replace("_", " ") for column in limits if column not in named}
    return [
        Figure(column, name, study.units.get(column, "1"), limits.get(column))
        for column, name in named.items()
        if study.has(column)
    ]


def _spreads(study: Study, samples: list[Setting]) -> Table:
    """Return mean, variation and quantiles of every figure."""
    columns = (
        Column("figure"),
        Column("figure unit", file_only=True),
        *_others(study),
        Column("cases"),
        *_heads("mean"),
        *_heads("cv"),
        *_heads("5 % quantile"),
        *_heads("median"),
        *_heads("95 % quantile"),
    )
    rows = []
    for figure in _figures(study):
        for one in samples:
            values = one.figures[figure.column]
            if not np.isfinite(values).any():
                continue
            told = sensitivity.spread(values)
            quantiles = [cell for each in told.quantiles for cell in _cells(each, figure.unit)]
            rows.append(
                (
                    figure.name,
                    figure.unit,
                    *_point(study, one),
                    _count(told.count),
                    *_cells(told.mean, figure.unit),
                    *_cells(told.cv, "1"),
                    *quantiles,
                )
            )
    note = (
        "In brackets the 95 % confidence interval: of mean and cv (standard deviation over mean) from the "
        f"bootstrap, of quantiles from order statistics; {wording.DASH}: too few cases to give that end. "
        f"{_left_out(samples)}"
    )
    return Table("distribution", "Spread of the figures", note.strip(), columns, rows)


def _limits(study: Study, samples: list[Setting]) -> Table:
    """Return the probability that each limit is exceeded."""
    columns = (
        Column("figure"),
        Column("figure unit", file_only=True),
        *_others(study),
        Column("limit"),
        Column("cases"),
        *_heads("probability of exceeding it"),
    )
    rows = []
    for figure in _figures(study):
        for one in samples if figure.limit is not None else ():
            values = one.figures[figure.column]
            known = int(np.isfinite(values).sum())
            if known:
                limit = Quantity(figure.limit, wording.text(figure.limit, figure.unit))
                rows.append(
                    (
                        figure.name,
                        figure.unit,
                        *_point(study, one),
                        limit,
                        _count(known),
                        *_cells(sensitivity.exceedance(values, figure.limit), "1"),
                    )
                )
    note = f"In brackets the exact 95 % confidence interval (Clopper and Pearson). {_left_out(samples)}"
    return Table("limits", "How likely limits are exceeded", note.strip(), columns, rows)


def _indices(study: Study, samples: list[Setting]) -> tuple[Table, list[str]]:
    """Return the Sobol indices of every variable on every figure, and what is to be said of chaos."""
    paths, names = _variables(study)
    columns = (
        Column("figure"),
        *_others(study),
        Column("variable"),
        *_heads("first-order index"),
        *_heads("total index"),
        Column("share of chance"),
        Column("chance was", file_only=True),
        Column("verdict"),
    )
    rows, flagged, measured = [], {}, False
    for figure in _figures(study):
        for one in samples:
            found = sensitivity.sobol_indices(one, figure.column, paths)
            chance = sensitivity.chance(one, figure.column, found)
            measured |= chance.measured
            verdict = "" if not chance.chaotic else "chaotic" if chance.measured else "may be chaotic"
            if verdict:
                flagged[figure.name] = verdict
            bound = "" if chance.measured or not chance.share >= 0.01 else "at most about "
            rows += [
                (
                    figure.name,
                    *_point(study, one),
                    names[index.path],
                    *_cells(index.first, "1"),
                    *_cells(index.total, "1"),
                    Quantity(chance.share, bound + percent(chance.share) if index is found[0] else ""),
                    "measured" if chance.measured else "bounded",
                    Quantity(verdict, verdict if index is found[0] else ""),
                )
                for index in found
            ]
    note = (
        "First-order: the share of the figure's variance that the variable explains by itself; total: with all its "
        "interactions. In brackets the bootstrap interval. Share of chance: what of the variance is chaos, not the "
        "variables; from a half on the figure is chaotic, its spread under a tiny disturbance as large as its "
        "effect."
    )
    sentences = [
        _advice([name for name in flagged if flagged[name] == verdict], verdict)
        for verdict in dict.fromkeys(flagged.values())
    ]
    if not measured:
        sentences.append(
            "Chaos was not measured in this run, only bounded: its share of the variance is at most the "
            "smallest total index of a variable that moves anything. simulate: {error_check: true} "
            "measures it."
        )
    return Table("sensitivity", "Sobol indices", note, columns, rows), sentences


def _effects(study: Study, samples: list[Setting]) -> tuple[Table, list[str]]:
    """Return the effect of every variable alone on every figure, and what is to be said of chaos."""
    paths, names = _variables(study)
    columns = (
        Column("figure"),
        Column("figure unit", file_only=True),
        *_others(study),
        Column("variable"),
        Column("at its 5 % quantile"),
        Column("in the middle"),
        Column("at its 95 % quantile"),
        Column("scatter"),
        Column("verdict"),
    )
    rows, flagged = [], {}
    for figure in _figures(study):
        for one in samples:
            for effect in sensitivity.effects(one, figure.column, paths):
                numbers = (effect.low, effect.middle, effect.high, effect.scatter)
                blurred = effect.blurred()
                verdict = "" if np.isnan(blurred) else f"blurred: scatter is {percent(blurred)} of the effect"
                if effect.chaotic:
                    verdict = "chaotic: scatter as large as the effect"
                    flagged[figure.name] = verdict
                rows.append(
                    (
                        figure.name,
                        figure.unit,
                        *_point(study, one),
                        names[effect.path],
                        *(Quantity(value, wording.text(value, figure.unit)) for value in numbers),
                        verdict,
                    )
                )
    note = (
        "One variable at a time, the others at their medians. Scatter: how far the figure moves under disturbances "
        "of one part in a thousand million of the variables' ranges, or a tenth of the tolerance where the run "
        "tried that too."
    )
    return Table("one_at_a_time", "One-at-a-time effects", note, columns, rows), (
        [_advice(list(flagged), "chaotic")] if flagged else []
    )


def _advice(figures: list[str], verdict: str) -> str:
    """Return what to do about figures that are chaotic or may be."""
    what = "is" if len(figures) == 1 else "are"
    said = f"{what} chaotic here" if verdict == "chaotic" else f"{what} not known to be free of chaos here"
    whom = "it" if len(figures) == 1 else "them"
    told = f"{wording.sentence_list(figures)} {said}: what a variable seems to do to {whom} may be chance."
    return f"{told[0].upper()}{told[1:]} Take p99 or rms in place of peaks, or a longer run."


def _histogram(canvas: Canvas, study: Study, one: Setting, figure: Figure) -> Picture:
    """Return the histogram of one figure, with its quantiles and its limit."""
    values = one.figures[figure.column]
    values = values[np.isfinite(values)]
    scale = wording.scale(figure.unit, values)
    marks = tuple(np.quantile(values, sensitivity.QUANTILES))
    at = "; ".join(
        f"{axis.name} {axis.text(one.point[axis.path])}"
        for axis in study.axes
        if one.point.get(axis.path) is not None and len(axis.values) > 1
    )
    alt = f"Histogram of {figure.name}, {len(values)} cases. " + ", ".join(
        f"{share:.0%} quantile {scale.text(mark)}" for share, mark in zip(sensitivity.QUANTILES, marks, strict=True)
    )
    title = f"{figure.name[0].upper()}{figure.name[1:]}"
    return canvas.picture(
        lambda ax: draw.histogram(ax, values, figure.name, scale, marks, figure.limit), title, at, alt, size=(3.3, 2.8)
    )


def _variables(study: Study) -> tuple[list[str], dict[str, str]]:
    """Return the drawn paths, and each in words."""
    paths = list(study.run.grid["sample"]["drawn"])
    return paths, {path: wording.axis_name(path, len(study.joints)) for path in paths}


def _others(study: Study) -> list[Column]:
    """Return the columns of the axes that were not drawn."""
    return [Column(axis.name, study.units.get(axis.path, "1"), axis) for axis in _undrawn(study)]


def _point(study: Study, one: Setting) -> list:
    return [one.point[axis.path] for axis in _undrawn(study)]


def _undrawn(study: Study) -> list:
    drawn = study.run.grid["sample"]["drawn"]
    return [axis for axis in study.swept() if axis.path not in drawn]


def _heads(name: str) -> list[Column]:
    return [Column(name), Column(f"{name}, low", file_only=True), Column(f"{name}, high", file_only=True)]


def _cells(estimate: Estimate, unit: str) -> list[Quantity]:
    """Return an estimate with its interval: one cell on the page, three in the file."""
    scale = wording.scale(unit, [end for end in estimate if np.isfinite(end)])
    low, high = scale.number(estimate.low), scale.number(estimate.high)
    return [
        Quantity(estimate.value, f"{scale.text(estimate.value)} ({low} to {high})"),
        Quantity(estimate.low, low),
        Quantity(estimate.high, high),
    ]


def _count(number: int) -> Quantity:
    return Quantity(number, str(number))


def _left_out(samples: list[Setting]) -> str:
    failed = sum(len(one.failed) for one in samples)
    return f"{wording.count(failed, 'failed case')} left out: the figures may be biased." if failed else ""
