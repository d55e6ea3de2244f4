"""Table of the variables that drive a random sample: rank correlations, chance of exceeding limits in either half."""

import itertools

import numpy as np

from ...answers import sampled
from ...answers.probability import Estimate
from ...language import wording
from ..blocks.table import Column, Quantity, Table
from ..data.study import Study
from ..statistics import sensitivity
from ..statistics.sensitivity import Sample
from .sample_tables import (
    any_limit_exceeded,
    estimate_cells,
    estimate_columns,
    figure_columns,
    limited_figures,
    point_cells,
    variable_names,
)


def rank_table(study: Study, samples: list[Sample]) -> Table:
    """Return rank correlations of each figure with each drawn variable, the strongest first; empty for few cases."""
    names = variable_names(study)
    drawn = {path: np.asarray(values, float) for path, values in study.run.grid["sample"]["drawn"].items()}
    has_limits = bool(study.run.grid.get("limits"))
    columns = [
        *figure_columns(study),
        Column("variable"),
        *estimate_columns("rank correlation"),
        *estimate_columns("others fixed"),
    ]
    if has_limits:
        columns += [*estimate_columns("limits exceeded, lower half"), *estimate_columns("upper half")]
    rows = []
    for figure, sample in itertools.product(limited_figures(study), samples):
        for path, simple, partial in figure_correlations(study, sample, figure.column):
            head = (figure.name, figure.unit, *point_cells(study, sample), names[path])
            halves = _halves(study, sample, drawn[path]) if has_limits else []
            rows.append((*head, *estimate_cells(simple, "1"), *estimate_cells(partial, "1"), *halves))
    note = (
        "Spearman's rank correlation is 1 if the figure always rises with the variable, and "
        f'{wording.MINUS}1 if it always falls. Under "others fixed" is the partial rank correlation (PRCC), after '
        "regression on the other variables. Brackets contain the 95 % interval."
    )
    if has_limits:
        note += (
            " The last two columns are the probabilities that a limit is exceeded with the variable below and above "
            "its median."
        )
    return Table("rank_drivers", "What drives the spread", note, tuple(columns), rows)


def figure_correlations(study: Study, sample: Sample, column: str) -> list[tuple[str, Estimate, Estimate]]:
    """Return variable, rank correlation with a figure, and partial rank correlation, the strongest first.

    Return [] if there are too few cases or the figure is constant.
    """
    table = study.run.grid["sample"]["drawn"]
    drawn = {path: np.asarray(table[path], float) for path in variable_names(study)}
    return sampled.variable_correlations(drawn, sample.figures[column])


def _halves(study: Study, sample: Sample, values: np.ndarray) -> list[Quantity]:
    """Return the cells with the chance that a limit is exceeded below and above the median of a variable."""
    is_finished, exceeds = sample.is_finished(), any_limit_exceeded(study, sample)
    values = values[is_finished]
    median = np.median(values)
    cells = []
    for is_in_half in (values <= median, values > median):
        probability = (
            sensitivity.exceedance_probability(exceeds[is_in_half])
            if is_in_half.any()
            else Estimate(np.nan, np.nan, np.nan)
        )
        cells += estimate_cells(probability, "1")
    return cells
