"""Reliability of peaks in words: periodicity, chaos, ranges of laws; and a table of forces by crank speed."""

from collections import Counter

import numpy as np

from ...answers import expected, validity
from ...language import wording
from ..blocks.case_table import CHUNK_ROWS, axis_columns
from ..blocks.section import Section, without_empty
from ..blocks.table import Column, Table
from ..data.leading import PEAK
from ..data.study import Joint, Study, indices_by_value
from ..samples import counts

START_UP_NOTE = (
    "The motion is a start-up, so figures are those of this run from rest or its initial speed, not of a steady state."
)


def sections(study: Study) -> list[Section]:
    """Return the section with the least and the most loaded design at each crank speed."""
    return [Section("headline", "Forces by crank speed", without_empty([_extremes_by_speed_table(study)]))]


def _setting_text(study: Study, case_id: str) -> str:
    return f" at {study.setting(case_id)}" if study.swept() else ""


def periodicity_sentences(study: Study) -> list[str]:
    """Return sentences on the number of periodic and chaotic motions, and on the significance of a single peak."""
    if "period" not in study.cases:
        return []
    if study.is_start_up:
        return [START_UP_NOTE]
    periods, count = study.cases["period"], len(study.cases)
    known_periods, points = periods.to_numpy()[periods.notna()], []
    if len(known_periods):
        cases = (
            ("Every motion" if count > 1 else "The motion")
            if len(known_periods) == count
            else f"{len(known_periods)} of {wording.count_text(count, 'motion')}"
        )
        count_by_period = Counter(int(period) for period in known_periods)
        count_texts = [
            f"{number} every {_revolutions_text(period)}" for period, number in sorted(count_by_period.items())
        ]
        verb = "is" if len(known_periods) in (1, count) else "are"
        points.append(
            f"{cases} {verb} periodic: {wording.sentence_list(count_texts)}. Their peaks recur in every period."
        )
    points += _chaos_sentences(study)
    if len(known_periods) < count:
        motions, suffix = wording.count_text(count, "motion"), _ratio_to_median_text(study, study.most_loaded_joint())
        subject = f"{count - len(known_periods)} of {motions}" if count > 1 else "The motion"
        points.append(
            f"{subject} did not become periodic within the run, so the largest peak is "
            f"partly random{suffix}. Compare the median peak, rms or p99, the force exceeded during 1 % of the time."
        )
        points += _expected_peak_sentences(study)
    return points


def _revolutions_text(period: int) -> str:
    return "revolution" if period == 1 else f"{period} revolutions"


def _expected_peak_sentences(study: Study) -> list[str]:
    """Return a sentence on the largest force peak to expect in many revolutions, or why none is predicted."""
    joints = [joint.name for joint in study.joints]
    names = [name for name in expected.required_columns(joints) if name in study.cases]
    columns = {name: study.cases[name].to_numpy() for name in names} | {"case_id": study.cases.index.to_numpy()}
    largest = expected.largest_expected_peak(columns, joints)
    if largest is None:
        return [
            "Without a period, the largest peak in 10⁶ revolutions is predicted only from "
            f"{expected.MIN_REVOLUTIONS} or more independent revolutions in the window."
        ]
    joint = next(joint for joint in study.joints if joint.name == largest.joint)
    force_texts = wording.texts_in_common_unit((largest.value, largest.high, largest.seen), "N")
    location_text = study.joint_text(joint, " in joint {}") + _setting_text(study, largest.case_id)
    return [expected.expected_peak_sentence(force_texts, location_text)]


def _chaos_sentences(study: Study) -> list[str]:
    """Return a sentence on the number of chaotic motions, or [] unless `simulate.horizon` tests for chaos."""
    if not study.has("lyapunov_exponent"):
        return []
    chaotic = int(((study.cases["lyapunov_exponent"] > 0.0) & study.cases["period"].isna()).sum())
    count = wording.count_text(len(study.cases), "motion")
    return [f"{chaotic} of {count} are chaotic: any small disturbance grows."] if chaotic else []


def _ratio_to_median_text(study: Study, joint: Joint) -> str:
    """Return how much the largest peak of non-periodic cases exceeds the median peak per revolution."""
    median_column = joint.column("force_peak_median")
    if not study.has(median_column):
        return ""
    is_aperiodic = study.cases["period"].isna().to_numpy()
    peaks, medians = (
        study.cases[name].to_numpy()[is_aperiodic] for name in (joint.column("force_peak"), median_column)
    )
    ratio = peaks / np.where(medians > 0.0, medians, np.nan)
    ratio = ratio[np.isfinite(ratio)]
    if not len(ratio):
        return ""
    range_text = " to ".join(dict.fromkeys((wording.number_text(ratio.min(), 2), wording.number_text(ratio.max(), 2))))
    return f": {range_text} times the median peak per revolution"


def law_range_remarks(study: Study) -> list[str]:
    """Return remarks on cases outside the range of their laws, in the words of the last lines of the run."""
    joints = [joint.name for joint in study.joints]
    remarks = validity.Remarks(joints)
    cases = {"case_id": study.cases.index}
    cases |= {
        name: study.cases[name] for name in validity.required_columns(joints, study.cases.columns) if name != "case_id"
    }
    for start in range(0, len(study.cases), CHUNK_ROWS):
        remarks.add({name: values[start : start + CHUNK_ROWS].to_numpy() for name, values in cases.items()})
    if counted := counts.remark_counts(study):
        remarks.replace_counts(counted)
    return remarks.sentences()


def _extremes_by_speed_table(study: Study) -> Table:
    """Return the least and the most loaded design at each crank speed; empty unless speed and another axis vary."""
    speed = next((axis for axis in study.levels() if axis.path == "drive.speed"), None)
    others = [axis for axis in study.swept() if axis is not speed]
    if speed is None or not others or study.cases.empty:
        return Table("by_speed", "", "", (), [])
    joint = study.most_loaded_joint()
    p99 = joint.column("force_p99")
    error = study.column("error_max")
    output_figures = [(error, f"{study.run.layout.output} error")] if error else []
    peak, ratio = (joint.column(name) for name in (PEAK.figure, "force_peak_ratio"))
    figures = ((peak, "force peak"), (p99, "force p99"), (ratio, "load / ideal"), *output_figures)
    forces, extremes = study.cases[peak].to_numpy(), []
    speed_indices = np.where(np.isfinite(forces), study.indices_on(speed), -1)
    for value, cases in zip(speed.values, indices_by_value(speed_indices, len(speed.values)), strict=True):
        if len(cases):
            least_loaded, most_loaded = cases[forces[cases].argmin()], cases[forces[cases].argmax()]
            extremes += (
                [(value, "least", least_loaded), (value, "most", most_loaded)]
                if least_loaded != most_loaded
                else [(value, "only", most_loaded)]
            )
    case_indices = [case_index for *_, case_index in extremes]
    cell_columns = [study.cases.index[case_indices], *(study.cases[axis.path].iloc[case_indices] for axis in others)]
    for column, _ in figures:
        cell_columns.append(
            study.cases[column].iloc[case_indices] if column in study.cases else np.full(len(case_indices), np.nan)
        )
    extreme_cells = zip(extremes, zip(*cell_columns, strict=True), strict=True)
    rows = [(value, load, *values, case_id) for (value, load, _), (case_id, *values) in extreme_cells]
    columns = (
        *axis_columns(study, [speed]),
        Column("load"),
        *axis_columns(study, others),
        *(Column(heading, study.unit(column)) for column, heading in figures),
        Column("case_id"),
    )
    title = "Least and most loaded design at each crank speed"
    joint_text = study.joint_text(joint, " in joint {}")
    note = f"Ranked by the largest normal force{joint_text}. p99 is exceeded during 1 % of the time."
    return Table("by_speed", title, note, columns, rows)
