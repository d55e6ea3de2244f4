"""What a run says, in figures and sentences: the hardest case, what drives the forces, where the model ends."""

from typing import NamedTuple

import numpy as np

from .. import validity, wording
from ..results import ELASTIC_ONSET
from .study import RATIO, Axis, Joint, Study, position

ELASTIC_TEXT = wording.scale("m/s", ELASTIC_ONSET).given(ELASTIC_ONSET)
CLEAR_FACTOR = 1.05  # largest over smallest median below which an axis is said to have no clear effect
CLEAR_CONTRAST = 4.0  # F ratio below which it is
PASSES = 20  # of the fit of main effects; one is exact where every combination finished


class Effect(NamedTuple):
    """The main effect of one axis on one figure, other axes spread over all their values."""

    axis: Axis
    column: str
    medians: np.ndarray  # (values,) SI; NaN where no case finished
    low: np.ndarray  # (values,) 10th percentile
    high: np.ndarray  # (values,) 90th percentile
    share: float  # of the variance of the figure's logarithm, less what chance gives, 0 to 1; NaN: undefined
    contrast: float  # variance between the values over that which no axis explains (F ratio); NaN: undefined

    def extremes(self) -> tuple[int, int]:
        """Return the places of the smallest and the largest median."""
        return int(np.nanargmin(self.medians)), int(np.nanargmax(self.medians))

    def clear(self) -> bool:
        """Tell whether the axis moves the figure by more than the scatter; by its medians where there is no scatter."""
        enough = bool(self.factor() >= CLEAR_FACTOR)
        return enough if np.isnan(self.contrast) else enough and self.contrast >= CLEAR_CONTRAST

    def factor(self) -> float:
        """Return the largest over the smallest median; NaN where that is zero or undefined."""
        if not np.isfinite(self.medians).any():
            return np.nan
        smallest, largest = (self.medians[place] for place in self.extremes())
        return largest / smallest if smallest > 0.0 else np.nan


def percent(share: float) -> str:
    """Return a share in whole per cent."""
    if np.isnan(share):
        return wording.DASH
    return f"{100.0 * share:.0f}\u00a0%" if share >= 0.01 else "under 1\u00a0%"


def effects(study: Study, column: str) -> list[Effect]:
    """Return the main effects of all swept axes on a figure over the finished cases, the strongest first."""
    axes, values = study.levels(), study.cases[column].to_numpy(float)
    places = [position(axis, study.cases[axis.path]) for axis in axes]
    shares = explained(values, places)
    found = []
    for axis, place, share in zip(axes, places, shares, strict=True):
        groups = [values[(place == k) & np.isfinite(values)] for k in range(len(axis.values))]
        quantiles = np.array([np.percentile(group, (50, 10, 90)) if len(group) else [np.nan] * 3 for group in groups])
        found.append(Effect(axis, column, *quantiles.T, *share))
    return sorted(found, key=lambda one: (-np.nan_to_num(one.share), -np.nan_to_num(one.factor())))


def explained(values: np.ndarray, places: list[np.ndarray]) -> list[tuple[float, float]]:
    """Return per axis its share of the variance of log(values), chance taken off, and its F ratio.

    `places` : per axis the place of each case on it, (cases,).  The scatter is what a sum of all main effects leaves
    (analysis of variance without interactions); where it leaves no freedom both are NaN.
    """
    known = np.isfinite(values) & (values > 0.0)
    logs = np.log(values[known])
    groups = [np.unique(place[known], return_inverse=True)[1] for place in places]
    freedoms = [int(group.max(initial=0)) for group in groups]
    spare, rest = len(logs) - 1 - sum(freedoms), logs - logs.mean() if len(logs) else logs
    total = float((rest**2).sum())
    if spare <= 0 or total <= 1e-20 * len(logs):  # all values the same, but for rounding
        return [(np.nan, np.nan)] * len(places)
    between = [float((_means(group, rest)[group] ** 2).sum()) for group in groups]
    for _ in range(PASSES):
        for group in groups:
            rest = rest - _means(group, rest)[group]
    scatter = max(float((rest**2).sum()) / spare, 1e-12 * total)
    return [
        (max(0.0, (part - freedom * scatter) / total), part / freedom / scatter if freedom else np.nan)
        for part, freedom in zip(between, freedoms, strict=True)
    ]


def _means(group: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.bincount(group, values) / np.bincount(group)


def headline(study: Study) -> list[str]:
    """Return what a designer should know first, one sentence or two per entry."""
    if study.cases.empty:
        return [f"None of the {wording.count(len(study.failed), 'case')} finished; the reasons are listed below."]
    joint = study.hardest_joint()
    return [
        *_hardest(study, joint),
        *(_drivers(study, joint) if study.levels() else []),
        *_slider(study),
        *_wear(study),
        *_restitution(study),
        *limits(study),
        *_chaos(study, joint),
    ]


def _hardest(study: Study, joint: Joint) -> list[str]:
    column, lead = joint.column(study.lead.figure), study.lead
    if not study.has(column):
        return ["No contact force was recorded in any case."]
    worst, mildest = study.cases[column].idxmax(), study.cases[column].idxmin()
    at = f" at {study.setting(worst)}" if study.swept() else ""
    where = f" in joint {joint.title}" if len(study.joints) > 1 else ""
    if lead.figure == "force_peak":
        hardest = f"Largest force peak: {study.text(worst, column)}{at}."
    else:
        peak = study.text(worst, joint.column("force_peak"))
        hardest = (
            f"Largest force{where}: {study.text(worst, column)} is exceeded during 1 % of the time (p99){at}"
            f"{_over_ideal(study, joint, worst)}; the single largest peak of that case is {peak}."
        )
    if worst == mildest:
        return [hardest]
    return [hardest, f"Smallest {lead.short}{where}: {study.text(mildest, column)} at {study.setting(mildest)}."]


def _over_ideal(study: Study, joint: Joint, case_id: str) -> str:
    if not study.has(joint.column(RATIO)) or np.isnan(study.cases.at[case_id, joint.column(RATIO)]):
        return ""
    ideal = study.text(case_id, joint.column("force_peak_ideal"))
    return f", {study.text(case_id, joint.column(RATIO))} times the largest reaction of the ideal joint ({ideal})"


def _drivers(study: Study, joint: Joint) -> list[str]:
    strong, weak = [], []
    for one in effects(study, joint.column(study.lead.figure)):
        (strong if one.clear() else weak).append(one)
    if not strong:
        return [f"None of the swept values moves the {study.lead.name} clearly."]
    said = [f"{one.axis.name} ({_span(one, study)})" for one in strong]
    found = [f"What drives the {study.lead.name}, strongest first: {wording.sentence_list(said)}."]
    if weak:
        found.append(f"No clear effect on it: {wording.sentence_list([one.axis.name for one in weak])}.")
    rms = effects(study, joint.column("force_rms"))[0]
    found.append(f"The force rms is driven most by {rms.axis.name} ({_span(rms, study)}).")
    return [" ".join(found), *_beside_ideal(study, joint)]


def _beside_ideal(study: Study, joint: Joint) -> list[str]:
    """Return what drives the force once the ideal mechanism's own reaction is taken out; only where that varies."""
    if not study.has(joint.column(RATIO)) or study.cases[joint.column("force_peak_ideal")].nunique() < 2:
        return []
    strongest = effects(study, joint.column(RATIO))[0]
    if not strongest.clear():
        return []
    said = (
        "Measured against the largest reaction of the ideal joint, which itself depends on the swept values, "
        f"the p99 is driven most by {strongest.axis.name} (ratio: {_span(strongest, study)})."
    )
    return [said]


def _span(one: Effect, study: Study) -> str:
    smallest, largest = one.extremes()
    unit = study.units.get(one.column, "1")
    low, high = sorted((smallest, largest))
    median = "" if np.isnan(one.share) else "median "
    change = (
        f"{median}{wording.text(one.medians[low], unit)} at {one.axis.text(one.axis.values[low])}, "
        f"{wording.text(one.medians[high], unit)} at {one.axis.text(one.axis.values[high])}"
    )
    return change if np.isnan(one.share) else f"{change}, {percent(one.share)} of the variation"


def _slider(study: Study) -> list[str]:
    if not study.has("slider_error_max"):
        return []
    worst, best = study.cases["slider_error_max"].idxmax(), study.cases["slider_error_max"].idxmin()
    sizes = (
        f"up to {study.text(worst, 'slider_error_max')}"
        if worst == best
        else f"{study.text(best, 'slider_error_max')} to {study.text(worst, 'slider_error_max')}"
    )
    hardest = study.cases["slider_acceleration_peak"].max()
    said = f"The slider is off its ideal place by {sizes}; its acceleration reaches {wording.text(hardest, 'm/s^2')}."
    return [said]


def _wear(study: Study) -> list[str]:
    said = []
    for joint in study.joints:
        column = joint.column("wear_depth_max")
        if joint.wears and study.has(column):
            worst = study.cases[column].idxmax()
            at = f" at {study.setting(worst)}" if study.swept() else ""
            said.append(
                f"Deepest wear in joint {joint.title}: {study.text(worst, column)} in the window, growing by "
                f"{study.text(worst, joint.column('wear_rate_max'))}{at}."
            )
    return said


def _restitution(study: Study) -> list[str]:
    if not study.has("pair_restitution"):
        return []
    got = study.cases["pair_restitution"]
    figures = " to ".join(dict.fromkeys((wording.plain(got.min(), 4), wording.plain(got.max(), 4))))
    return [f"Measured restitution (rebound over approach speed): {figures}."]


def _chaos(study: Study, joint: Joint) -> list[str]:
    if study.mechanism == "impact-pair":
        return []
    ratio = study.cases[joint.column("force_peak")] / study.cases[joint.column("force_p99")]
    ratio = ratio[np.isfinite(ratio)]
    span = " to ".join(dict.fromkeys((wording.plain(ratio.min(), 2), wording.plain(ratio.max(), 2))))
    figures = f" (here the peak is {span} times the p99)" if len(ratio) > 1 else ""
    said = (
        "Motion with clearance is chaotic wherever contact is lost: a single peak changes with the smallest "
        "disturbance. Compare designs by p99 and rms, which are taken over the whole window, not by single "
        f"peaks{figures}."
    )
    return [said]


def limits(study: Study) -> list[str]:
    """Return where the cases leave what their laws are made for, as the run's closing words tell it."""
    told = validity.Remarks(joint.name for joint in study.joints)
    for row in study.cases.reset_index()[validity.columns(told.joints)].to_dict("records"):
        told.add(row)
    return told.sentences()
