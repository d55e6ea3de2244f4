"""Error against run time of a run that sweeps `simulate.tolerance`, from the finest of otherwise equal cases."""

from typing import Any

import numpy as np
import pandas as pd

from ..blocks.picture import Picture
from ..blocks.section import Gallery, Section, Sentences
from ..blocks.table import Column, Table
from ..data.study import Study
from ..draw.style import set_log_scale

PATH = "simulate.tolerance"
FIGURES = ("force_peak", "force_p99", "force_rms")
COLOURS = ("#D55E00", "#0072B2", "#009E73")  # Okabe and Ito 2008
LEAST_DRAWN = 1e-16  # a difference of 0 is drawn there
NOTE = (
    "Each point is the median over the cases of one tolerance. Beyond the horizon of chaotic motion two tolerances are "
    "two samples of the same motion, and their difference does not fall any further."
)


def sections(study: Study) -> list[Section]:
    """Return the section, or [] unless tolerances are swept and cases at several of them have finished."""
    if study.cases.empty or not study.joints or PATH not in {axis.path for axis in study.swept()}:
        return []
    joint = study.most_loaded_joint()
    columns = [joint.column(name) for name in FIGURES if study.has(joint.column(name))]
    others = [axis.path for axis in study.swept() if axis.path != PATH]
    cases = pd.DataFrame({name: study.cases[name] for name in (PATH, "run_time", *others, *columns)})
    medians = differences(cases, others, columns)
    if len(medians) < 2 or not columns:
        return []
    heads = [Column("tolerance"), Column("run time", "s"), *(Column(f"difference of {name}") for name in columns)]
    rows = [tuple(row) for row in medians.itertuples()]
    table = Table("tolerances", "Difference from the finest tolerance", "Medians; relative.", tuple(heads), rows)
    finest = f"The reference is the finest tolerance, {cases[PATH].min():g}, of otherwise equal cases."
    return [
        Section(
            "tolerances", "Error against run time", [Sentences([finest]), Gallery(NOTE, [_picture(medians)]), table]
        )
    ]


def differences(cases: pd.DataFrame, other_paths: list[str], columns: list[str]) -> pd.DataFrame:
    """Return medians by tolerance: run time (s) and relative differences from the finest of otherwise equal cases.

    cases : finished cases with a column `run_time`; other_paths : the swept paths besides the tolerance.  The finest
    tolerance has no row.
    """
    key = [cases[path].astype(str) for path in other_paths] or [pd.Series("", index=cases.index)]
    finest = cases.groupby(key)[PATH].transform("min")
    by_case = cases[[PATH, "run_time"]].copy()
    for column in columns:
        reference = cases[column].where(cases[PATH] == finest).groupby(key).transform("max")
        by_case[column] = (cases[column] / reference - 1.0).abs()
    return by_case[cases[PATH] > finest].groupby(PATH).median().sort_index(ascending=False)


def _picture(medians: pd.DataFrame) -> Picture:
    """Return the picture of the differences over the run time, a curve per figure."""

    def paint(ax: Any) -> None:
        for column, colour in zip(medians.columns[1:], COLOURS, strict=False):
            errors = np.maximum(medians[column].to_numpy(), LEAST_DRAWN)
            ax.plot(medians["run_time"].to_numpy(), errors, color=colour, marker="o", markersize=4, label=column)
        ax.set(xlabel="run time of a case [s]", ylabel="relative difference")
        set_log_scale(ax, "x")
        set_log_scale(ax, "y")
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.03), frameon=False)

    return Picture(
        "Error against run time", "", "Difference from the finest tolerance over run time.", paint, (5.4, 3.1)
    )
