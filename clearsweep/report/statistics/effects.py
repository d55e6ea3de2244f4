"""Effects of swept values on figures: medians, pairs of otherwise equal cases, ranges of laws."""

import itertools
import math
from typing import NamedTuple

import numpy as np
import pandas as pd

from ...answers import judge
from ...answers.judge import known_blocks, verdict_on
from ...answers.statistics import CONFIDENCE, Estimate, variance_shares
from ...answers.validity import YIELD_SPEED
from ...language import wording
from ...language.errors import InputError
from ..axis import Axis
from ..study import Joint, Study, comparable_values, indices_by_value, joint_of, resolve_cases

# Main effects of swept values on a figure: medians over the values, share of the variation.


class MainEffect(NamedTuple):
    """The main effect of one axis on one figure, over blocks of cases that differ on this axis alone."""

    axis: Axis
    column: str
    medians: np.ndarray  # (values,) SI; NaN without a finished case
    low: np.ndarray  # (values,) 10th percentile
    high: np.ndarray  # (values,) 90th percentile
    share: float  # of the figure's variance, corrected for chance, 0 to 1; NaN: undefined
    verdict: str  # of answers.blocks

    def extreme_indices(self) -> tuple[int, int]:
        """Return the indices of the smallest and the largest median."""
        return int(np.nanargmin(self.medians)), int(np.nanargmax(self.medians))

    def factor(self) -> float:
        """Return the ratio of largest to smallest median; NaN unless both are positive."""
        low, high = float(np.nanmin(self.medians)), float(np.nanmax(self.medians))
        return high / low if low > 0.0 else np.nan


def main_effects_of(study: Study, column: str) -> list[MainEffect]:
    """Return the main effects of all swept axes on a figure over the finished cases, the strongest first."""
    return study.cases.cached(("effects", column), lambda: _main_effects(study, column))


def _main_effects(study: Study, column: str) -> list[MainEffect]:
    levels, values = study.levels(), comparable_values(study, column)
    codes = {axis.path: study.indices_on(axis) for axis in study.swept()}
    shares = variance_shares(values, [codes[axis.path] for axis in levels])
    effects = []
    for axis, share in zip(levels, shares, strict=True):
        of_axis = judge.Axis((axis.path,), list(axis.values), codes[axis.path])
        matched = known_blocks(codes, of_axis, values)
        if not matched:
            continue
        rows = np.concatenate(matched)
        groups = [values[rows[group]] for group in indices_by_value(codes[axis.path][rows], len(axis.values))]
        quantiles = [np.percentile(group, (50, 10, 90)) if len(group) else [np.nan] * 3 for group in groups]
        medians, low, high = np.array(quantiles).T
        verdict = verdict_on(of_axis, matched, values)
        effects.append(MainEffect(axis, column, medians, low, high, share, verdict))
    return sorted(effects, key=lambda effect: (-np.nan_to_num(effect.share), -float(np.nanmax(effect.medians))))


# Matched cases, which differ in one law only.


class MatchedCases(NamedTuple):
    """Matched cases, which differ in one law only."""

    axis: Axis
    pairs: pd.DataFrame  # columns group, law, case_id

    def table(self, study: Study, column: str) -> pd.DataFrame:
        """Return a figure (SI) by group and law, for groups with a positive figure under at least two laws."""
        values = study.cases[column].reindex(self.pairs["case_id"]).to_numpy()
        known = self.pairs.assign(value=values)[values > 0.0]
        table = known.groupby(["group", "law"])["value"].median().unstack()
        return table[table.count(axis=1) > 1]

    def case_id(self, group: int, law: str) -> str:
        """Return the id of the case of a law in a group."""
        return self.pairs.loc[(self.pairs["group"] == group) & (self.pairs["law"] == law), "case_id"].iloc[0]


def match_cases(study: Study, axis: Axis) -> MatchedCases:
    """Return the cases that share all swept values except those of one axis.

    A value that a law does not use does not separate cases: the case then belongs to every group that shares the
    others.
    """
    return study.cases.cached(("matches", axis.path), lambda: _match_cases(study, axis))


def _match_cases(study: Study, axis: Axis) -> MatchedCases:
    other_paths = [other.path for other in study.swept() if other is not axis]
    codes = pd.DataFrame({path: pd.factorize(study.cases[path])[0] for path in other_paths}, index=study.cases.index)
    groups = codes.drop_duplicates().rename_axis(None).reset_index(drop=True).rename_axis("group").reset_index()
    used_paths = [tuple(path for path in other_paths if code[path] >= 0) for code in codes.to_dict("records")]
    groups_with_cases = []
    for shared_paths in dict.fromkeys(used_paths):
        rows = codes[[paths == shared_paths for paths in used_paths]].reset_index()[["case_id", *shared_paths]]
        merge_options = {"on": list(shared_paths)} if shared_paths else {"how": "cross"}
        groups_with_cases.append(groups[["group", *shared_paths]].merge(rows, **merge_options))
    pairs = pd.concat(groups_with_cases, ignore_index=True)[["group", "case_id"]]
    return MatchedCases(axis, pairs.assign(law=study.cases[axis.path].reindex(pairs["case_id"]).to_numpy()))


def axis_key(axis: Axis) -> str:
    """Return an axis as a key of tables: 'laws_rod_slider_contact_law' for 'joints.rod-slider.contact.law'."""
    return axis.path.replace("joints.", "laws_", 1).replace(".", "_").replace("-", "_")


# Trend of a figure with one swept value, from pairs of otherwise equal cases, without assumed distributions.

MAX_EXACT_PAIRS = (
    3000  # comparisons up to which the distribution of orders is exact; above, it is approximated as normal
)


def trend_exponent(x: np.ndarray, table: np.ndarray, claims: int = 1) -> tuple[Estimate, int]:
    """Return the exponent of `x` in the trend of a figure, its interval, and the number of pairs of cases.

    The exponent is the median slope of log figure over log x of all pairs of a row; the interval contains the
    slopes that the orders within the rows do not reject (Sen 1968, J. Am. Stat. Assoc. 63:1379; several rows as
    blocks: Hirsch, Slack & Smith 1982, Water Resour. Res. 18:107). The method assumes that without a trend every
    order of a row is equally likely, and that rows are independent.

    Parameters
    ----------
    x : (values,) above 0, distinct
    table : (rows, values) the positive figure; in a row everything except x is equal; NaN if unknown
    claims : number of claims that share the probability of error of one interval (Bonferroni)

    Returns
    -------
    exponent : Estimate, NaN without a pair; its ends NaN with too few pairs for an interval

    """
    log_values, log_x = np.log(table), np.log(np.asarray(x, float))
    slope_arrays = [
        (log_values[:, k] - log_values[:, j]) / (log_x[k] - log_x[j])
        for j, k in itertools.combinations(range(len(log_x)), 2)
    ]
    slopes = np.sort(np.concatenate(slope_arrays)) if slope_arrays else np.empty(0)
    slopes = slopes[np.isfinite(slopes)]
    if not len(slopes):
        return Estimate(math.nan, math.nan, math.nan), 0
    sizes = np.isfinite(log_values).sum(axis=1)
    beyond = slopes_beyond(sizes[sizes > 1], 0.5 * (1.0 - CONFIDENCE) / claims)
    interval = (float(slopes[beyond]), float(slopes[-1 - beyond])) if beyond >= 0 else (math.nan, math.nan)
    return Estimate(float(np.median(slopes)), *interval), len(slopes)


def slopes_beyond(sizes: np.ndarray, tail: float) -> int:
    """Return the number of ordered slopes beyond each end of the interval, -1 without ends.

    The number of descending pairs of n values without a trend is distributed like the inversions of a permutation.

    tail : probability beyond either end
    """
    if (sizes * (sizes - 1) // 2).sum() > MAX_EXACT_PAIRS:
        from scipy.special import ndtri  # loads in a fraction of the time of scipy.stats

        pairs = 0.5 * (sizes * (sizes - 1.0)).sum()
        deviation = math.sqrt((sizes * (sizes - 1.0) * (2.0 * sizes + 5.0)).sum() / 72.0)
        return int(0.5 * pairs + ndtri(tail) * deviation - 0.5)
    probabilities = np.ones(1)
    for size in sizes:
        for count in range(2, size + 1):  # the last of `count` values has any rank with equal probability
            probabilities = np.convolve(probabilities, np.full(count, 1.0 / count))
    return int(np.searchsorted(np.cumsum(probabilities), tail, side="right")) - 1


# Approach speeds up to which contacts stay elastic, as sentences, cards and pictures.

MAX_SPEED_RATIO = 3.0  # times the fastest onset: a higher line would compress all onsets at the bottom of a picture
_NO_STRENGTH = ", because it needs a yield strength or a hardness"


def yield_speed_sentence(study: Study, joint: Joint) -> str:
    """Return the sentence on the approach speeds (m/s) of first yield of a joint in all cases."""
    column = joint.column(YIELD_SPEED)
    if not study.has(column):
        reason = " for this kind of joint or law" if _has_strength(study, joint) else _NO_STRENGTH
        return f"The speed at which the contact first yields is not computed{reason}."
    extremes = (study.cases[column].min(), study.cases[column].max())
    scale = wording.scale("m/s", extremes)
    range_text = " to ".join(dict.fromkeys(scale.number_text(extreme, 2) for extreme in extremes))
    return f"The contact first yields at {scale.with_unit(range_text)}."


def _has_strength(study: Study, joint: Joint) -> bool:
    """Return whether the strength of a joint's weaker body is known in any case; False without a finished case."""
    if joint.layout.strength:
        return True
    try:
        cases = resolve_cases(study, study.cases.index[:1])
    except InputError:  # a law that this version does not know
        return False
    return any(joint_of(case, joint).strength is not None for case in cases)


def yield_speeds(study: Study, case_id: str, fastest: float) -> list[tuple[str, float]]:
    """Return joint and approach speed (m/s) of first yield in a case; speeds far above the `fastest` are left out."""
    speeds = []
    for joint in study.joints:
        column = joint.column(YIELD_SPEED)
        speed = float(study.cases.at[case_id, column]) if study.has(column) else np.nan
        if speed <= MAX_SPEED_RATIO * fastest:
            speeds.append((joint.title, speed))
    return speeds
