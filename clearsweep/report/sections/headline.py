"""What the run says: the hardest case, what drives the forces, where the model ends, the best design at each speed."""

from collections import Counter

import numpy as np
from markupsafe import Markup

from ...judging import validity
from ...language import wording
from ..case_table import AT_ONCE, axis_columns
from ..main_effects import MainEffect, main_effects
from ..section import Points, Section, filled
from ..study import PER_HOURS, RATIO, Joint, Study, grouped
from ..table import Column, Table
from .verdict import ratios


def sections(study: Study) -> list[Section]:
    """Return the section of what a designer should know first."""
    return [Section("headline", "What the run says", filled([Points(_points(study)), _best_by_speed(study)]))]


def _points(study: Study) -> list[str]:
    """Return the sentences about the figures, about failed cases, and the warnings of the run."""
    points = sentences(study) + ([] if study.cases.empty else ratios(study))
    failed, finished = len(study.failed), len(study.cases)
    if failed and finished:
        cases = Markup('<a href="#failures">{} of {} cases failed</a>').format(failed, failed + finished)
        points.append(cases + " and are in no figure or table above the list of failures.")
    points += [Markup("<b>Warning:</b> {}").format(warning) for warning in study.run.grid.get("warnings") or []]
    return points


def sentences(study: Study) -> list[str]:
    """Return what a designer should know first, one sentence or two per entry."""
    if study.cases.empty:
        return [f"None of the {wording.count(len(study.failed), 'case')} finished; the reasons are listed below."]
    joint = study.hardest_joint()
    return [
        *_hardest(study, joint),
        *(_drivers(study, joint) if study.levels() else []),
        *_output(study),
        *_wear(study),
        *_restitution(study),
        *limits(study),
        *_repeating(study, joint),
    ]


def _hardest(study: Study, joint: Joint) -> list[str]:
    column, lead = joint.column(study.lead.figure), study.lead
    if not study.has(column):
        return ["No contact force was recorded in any case."]
    worst, mildest = study.cases[column].idxmax(), study.cases[column].idxmin()
    where = study.where(joint, " in joint {}")
    if lead.figure == "force_peak":
        points = [f"Largest force peak: {study.text(worst, column)}{_at(study, worst)}."]
    else:
        points = [_exceeded(study, joint, worst), *_highest(study, joint, worst)]
    if worst != mildest:
        points.append(f"Smallest {lead.short}{where}: {study.text(mildest, column)} at {study.setting(mildest)}.")
    return points


def _at(study: Study, case_id: str) -> str:
    return f" at {study.setting(case_id)}" if study.swept() else ""


def _exceeded(study: Study, joint: Joint, case_id: str) -> str:
    """Return the p99 of the force in a joint, beside the reaction of the ideal one and the peak."""
    ratio = joint.column(RATIO)
    known = study.has(ratio) and not np.isnan(study.cases.at[case_id, ratio])
    names = ("force_p99", "force_peak", "force_peak_ideal")[: 3 if known else 2]
    force, peak, *ideal = study.texts(*((case_id, joint.column(name)) for name in names))
    times = f"{study.text(case_id, ratio)} times" if known else ""
    beside = f", {times} the largest reaction of the ideal joint ({ideal[0]})" if known else ""
    return (
        f"Largest force{study.where(joint, ' in joint {}')}: {force} is exceeded during 1 % of the time (p99)"
        f"{_at(study, case_id)}{beside}; the single largest peak of that case is {peak}."
    )


def _highest(study: Study, hardest: Joint, case_id: str) -> list[str]:
    """Return the largest peak of all cases where it is not in the case and the joint with the largest p99."""
    joint = max(study.joints, key=lambda joint: np.nan_to_num(study.cases.largest(joint.column("force_peak"))))
    highest = study.cases[joint.column("force_peak")].idxmax()
    if (joint, highest) == (hardest, case_id):
        return []
    peak, p99 = study.texts(*((highest, joint.column(name)) for name in ("force_peak", "force_p99")))
    return [
        f"Largest peak{study.where(joint, ' in joint {}')}: {peak}{_at(study, highest)}, where p99 is {p99}: it does "
        "not see impacts that take less than 1 % of the time."
    ]


def _drivers(study: Study, joint: Joint) -> list[str]:
    effects = main_effects(study, joint.column(study.lead.figure))
    strong = [effect for effect in effects if effect.clear()]
    weak = [effect.axis.name for effect in effects if not effect.clear()]
    if not strong:
        return [f"None of the swept values moves the {study.lead.name} clearly."]
    text = f"What drives the {study.lead.name}, strongest first: {wording.sentence_list(_causes(strong, study))}."
    if weak:
        text += f" No clear effect on it: {wording.sentence_list(weak)}."
    others = {"force_rms": "force rms"} | ({} if study.lead.figure == "force_peak" else {"force_peak": "largest peak"})
    most = [main_effects(study, joint.column(figure))[0] for figure in others]
    named = zip(others.values(), _causes(most, study), strict=True)
    text += f" The {', the '.join(f'{name} is driven most by {cause}' for name, cause in named)}."
    return [text, *_beside_ideal(study, joint)]


def _beside_ideal(study: Study, joint: Joint) -> list[str]:
    """Return what drives the force once the ideal mechanism's own reaction is taken out; only where that varies."""
    if not study.has(joint.column(RATIO)) or study.cases[joint.column("force_peak_ideal")].nunique() < 2:
        return []
    strongest = main_effects(study, joint.column(RATIO))[0]
    if not strongest.clear():
        return []
    return [
        "Measured against the largest reaction of the ideal joint, which itself depends on the swept values, "
        f"the p99 is driven most by {strongest.axis.name} (ratio: {_span(strongest, wording.Scale(1.0, ''))})."
    ]


def _causes(effects: list[MainEffect], study: Study) -> list[str]:
    """Return what moves forces, and from where to where, all in one unit."""
    known = [median for effect in effects for median in effect.medians]
    scale = wording.scale(study.unit(effects[0].column), known)
    return [f"{effect.axis.name} ({_span(effect, scale)})" for effect in effects]


def _span(effect: MainEffect, scale: wording.Scale) -> str:
    low, high = sorted(effect.extremes())
    axis = effect.axis
    first, last = (f"{scale.text(effect.medians[place])} at {axis.text(axis.values[place])}" for place in (low, high))
    if np.isnan(effect.share):
        return f"{first}, {last}"
    return f"median {first}, {last}, {wording.percent(effect.share)} of the variation"


def _output(study: Study) -> list[str]:
    error, acceleration = study.column("error_max"), study.column("acceleration_peak")
    if not study.has(error):
        return []
    worst, best = study.cases[error].idxmax(), study.cases[error].idxmin()
    most, least = study.texts((worst, error), (best, error))
    sizes = f"up to {most}" if worst == best else f"{least} to {most}"
    sentence = f"The {study.run.layout.output} is off its ideal place by {sizes}"
    if study.has(acceleration):
        sentence += f"; its acceleration reaches {study.text(study.cases[acceleration].idxmax(), acceleration)}"
    return [f"{sentence}."]


def _wear(study: Study) -> list[str]:
    points = []
    for joint in study.joints:
        column = joint.column("wear_depth_max")
        if joint.wears and study.has(column):
            worst = study.cases[column].idxmax()
            # two spans of time, orders apart: 15.7 nm beside 590 mm
            depth, hours = study.text(worst, column), study.text(worst, joint.column(PER_HOURS))
            points.append(
                f"Deepest wear in joint {joint.title}: {depth} in the window, at that rate {hours} in 1000 h"
                f"{_at(study, worst)}."
            )
    return points


def _restitution(study: Study) -> list[str]:
    points = []
    for joint in study.joints:
        column = joint.column("restitution")
        if study.has(column):
            measured, where = study.cases[column], study.where(joint, " in joint {}")
            span = " to ".join(dict.fromkeys((wording.plain(measured.min(), 4), wording.plain(measured.max(), 4))))
            points.append(f"Measured restitution{where} (rebound over approach speed): {span}.")
    return points


def _repeating(study: Study, joint: Joint) -> list[str]:
    """Return how many motions repeat themselves or are known to be chaotic, and so what a single peak is worth."""
    if "period" not in study.cases:
        return []
    periods, count = study.cases["period"], len(study.cases)
    found, points = periods.to_numpy()[periods.notna()], []
    if len(found):
        cases = "All motions" if len(found) == count else f"{len(found)} of {wording.count(count, 'motion')}"
        shares = Counter(int(period) for period in found)
        after = wording.sentence_list([f"{number} after {period}" for period, number in sorted(shares.items())])
        points.append(f"{cases} repeat themselves (revolutions: {after}): a peak there comes back in every period.")
    points += _chaotic(study)
    if len(found) < count:
        rest, beside = wording.count(count, "motion"), _beside_median(study, joint)
        points.append(
            f"{count - len(found)} of {rest} were not seen to repeat themselves within the window: compare these by "
            f"the median of the peaks of revolutions, by rms or p99{beside}."
        )
    return points


def _chaotic(study: Study) -> list[str]:
    """Return how many motions were found to be chaotic; only where `simulate.horizon` looked."""
    if not study.has("lyapunov_exponent"):
        return []
    chaotic = int(((study.cases["lyapunov_exponent"] > 0.0) & study.cases["period"].isna()).sum())
    count = wording.count(len(study.cases), "motion")
    return [f"{chaotic} of {count} are chaotic: the smallest disturbance grows."] if chaotic else []


def _beside_median(study: Study, joint: Joint) -> str:
    """Return by how much the largest peak of a case that does not repeat itself exceeds the median of revolutions."""
    median = joint.column("force_peak_median")
    if not study.has(median):
        return ""
    irregular = study.cases["period"].isna().to_numpy()
    peaks, medians = (study.cases[name].to_numpy()[irregular] for name in (joint.column("force_peak"), median))
    ratio = peaks / np.where(medians > 0.0, medians, np.nan)
    ratio = ratio[np.isfinite(ratio)]
    span = " to ".join(dict.fromkeys((wording.plain(ratio.min(), 2), wording.plain(ratio.max(), 2))))
    return f" (the largest peak is {span} times that median)" if len(ratio) else ""


def limits(study: Study) -> list[str]:
    """Return where the cases leave what their laws are made for, as the run's closing words say it."""
    joints = [joint.name for joint in study.joints]
    remarks = validity.Remarks(joints)
    cases = {"case_id": study.cases.index}
    cases |= {name: study.cases[name] for name in validity.columns(joints, study.cases.columns) if name != "case_id"}
    for start in range(0, len(study.cases), AT_ONCE):
        remarks.add({name: values[start : start + AT_ONCE].to_numpy() for name, values in cases.items()})
    return remarks.sentences()


def _best_by_speed(study: Study) -> Table:
    """Return the least and the most loaded design at each crank speed; empty unless speed and another axis vary."""
    speed = next((axis for axis in study.levels() if axis.path == "drive.speed"), None)
    others = [axis for axis in study.swept() if axis is not speed]
    if speed is None or not others or study.cases.empty:
        return Table("by_speed", "", "", (), [])
    joint = study.hardest_joint()
    p99 = joint.column("force_p99")
    error = study.column("error_max")
    of_output = [(error, f"{study.run.layout.output} error")] if error else []
    peak, ratio = (joint.column(name) for name in ("force_peak", RATIO))
    figures = ((p99, "force p99"), (peak, "force peak"), (ratio, "p99 / ideal"), *of_output)
    forces, ends = study.cases[p99].to_numpy(), []
    known = np.where(np.isfinite(forces), study.places(speed), -1)
    for value, cases in zip(speed.values, grouped(known, len(speed.values)), strict=True):
        if len(cases):
            ends += [(value, "least", cases[forces[cases].argmin()]), (value, "most", cases[forces[cases].argmax()])]
    places = [place for *_, place in ends]
    shown = [study.cases.index[places], *(study.cases[axis.path].iloc[places] for axis in others)]
    for column, _ in figures:
        shown.append(study.cases[column].iloc[places] if column in study.cases else np.full(len(places), np.nan))
    found = zip(ends, zip(*shown, strict=True), strict=True)
    rows = [(value, load, *values, case_id) for (value, load, _), (case_id, *values) in found]
    columns = (
        *axis_columns(study, [speed]),
        Column("load"),
        *axis_columns(study, others),
        *(Column(heading, study.unit(column)) for column, heading in figures),
        Column("case_id"),
    )
    title = "Least and most loaded design at each crank speed"
    note = (
        f"Ranked by the 99th percentile of the contact force{study.where(joint, ' in joint {}')}, which is blind to "
        "impacts under 1 % of the time: the force peak beside it is not."
    )
    return Table("by_speed", title, note, columns, rows)
