"""Sentences on the figures of a run: forces, drivers, output, wear, valid ranges of laws, periodicity."""

from collections import Counter

import numpy as np

from ...contracts.layout import FRICTION_POWER
from ...judging import expected, validity
from ...language import wording
from ..blocks.case_table import CHUNK_ROWS, axis_columns
from ..blocks.section import Points, Section, without_empty
from ..blocks.table import Column, Table
from ..data.leading import PEAK
from ..data.study import Joint, Study, indices_by_value
from ..samples import counts
from .verdict import ratios

TRANSIENT = (
    "The motion is a start-up, so figures are those of this run from rest or its initial speed, not of a steady state."
)


def sections(study: Study) -> list[Section]:
    """Return the section of forces and output in words."""
    if study.cases.empty:
        return []
    points = [*sentences(study), *ratios(study)]
    return [Section("headline", "Forces and output in words", without_empty([Points(points), _best_by_speed(study)]))]


def sentences(study: Study) -> list[str]:
    """Return the largest and the smallest figures of the finished cases, one sentence or two per entry."""
    return [*_hardest(study), *_output(study), *_restitution(study), *_friction(study)]


def _hardest(study: Study) -> list[str]:
    """Return sentences on the largest force peak of all joints, with p99 and ideal reaction, and on the smallest."""
    known = [joint for joint in study.joints if study.has(joint.column(PEAK.figure))]
    if not known:
        return ["No contact force was recorded in any case."]
    joint = max(known, key=lambda joint: study.cases.largest(joint.column(PEAK.figure)))
    column = joint.column(PEAK.figure)
    worst, mildest = study.cases[column].idxmax(), study.cases[column].idxmin()
    where, suffix = (
        study.joint_text(joint, " in joint {}"),
        {"force_p99": "p99", "force_peak_ideal": "without clearance"},
    )
    columns = {joint.column(name): word for name, word in suffix.items() if study.has(joint.column(name))}
    peak, *others = study.texts((worst, column), *((worst, name) for name in columns))
    others_text = wording.sentence_list([f"{word} {text}" for word, text in zip(columns.values(), others, strict=True)])
    points = [f"Largest force peak{where}: {peak}{_at(study, worst)}{f' ({others_text})' if others_text else ''}."]
    if "force_p99" in {name.removeprefix(f"{joint.name}_") for name in columns}:
        points.append("p99 is exceeded during 1 % of the time, so it ignores shorter impacts.")
    if worst != mildest:
        points.append(f"Smallest force peak{where}: {study.text(mildest, column)} at {study.setting(mildest)}.")
    return points


def _at(study: Study, case_id: str) -> str:
    return f" at {study.setting(case_id)}" if study.swept() else ""


def _friction(study: Study) -> list[str]:
    """Return the friction power of the joints without clearance that have friction."""
    opened, points = {joint.name for joint in study.joints}, []
    for column in study.run.layout.columns:
        if column.figure == FRICTION_POWER and column.joint not in opened and study.has(column.name):
            powers = study.cases[column.name]
            ends = wording.in_common_unit(dict.fromkeys((float(powers.min()), float(powers.max()))), "W")
            points.append(
                f"Friction in joint {column.joint}, which has no clearance, dissipates {' to '.join(ends)} on average."
            )
    return points


def _output(study: Study) -> list[str]:
    error, acceleration = study.column("error_max"), study.column("acceleration_peak")
    if not study.has(error):
        return []
    worst, best = study.cases[error].idxmax(), study.cases[error].idxmin()
    most, least = study.texts((worst, error), (best, error))
    sizes = f"up to {most}" if worst == best else f"{least} to {most}"
    sentence = f"The {study.run.layout.output} deviates from its ideal position by {sizes}"
    if study.has(acceleration):
        sentence += f"; its acceleration reaches {study.text(study.cases[acceleration].idxmax(), acceleration)}"
    return [f"{sentence}."]


def _restitution(study: Study) -> list[str]:
    points = []
    for joint in study.joints:
        column = joint.column("restitution")
        if study.has(column):
            measured, where = study.cases[column], study.joint_text(joint, " in joint {}")
            span = " to ".join(dict.fromkeys((wording.plain(measured.min(), 4), wording.plain(measured.max(), 4))))
            points.append(f"Measured restitution{where} (rebound over approach speed): {span}.")
    return points


def repeating(study: Study) -> list[str]:
    """Return sentences on the number of periodic and chaotic motions, and on the significance of a single peak."""
    if "period" not in study.cases:
        return []
    if study.is_start_up:
        return [TRANSIENT]
    periods, count = study.cases["period"], len(study.cases)
    repeated, points = periods.to_numpy()[periods.notna()], []
    if len(repeated):
        cases = "Every motion" if len(repeated) == count else f"{len(repeated)} of {wording.count(count, 'motion')}"
        shares = Counter(int(period) for period in repeated)
        shares_of = [f"{number} every {_turns(period)}" for period, number in sorted(shares.items())]
        verb = "is" if len(repeated) in (1, count) else "are"
        points.append(
            f"{cases} {verb} periodic: {wording.sentence_list(shares_of)}. Their peaks recur in every period."
        )
    points += _chaotic(study)
    if len(repeated) < count:
        rest, suffix = wording.count(count, "motion"), _over_median(study, study.hardest_joint())
        points.append(
            f"{count - len(repeated)} of {rest} did not become periodic within the run, so the largest peak is "
            f"partly random{suffix}. Compare the median peak, rms or p99, the force exceeded during 1 % of the time."
        )
        points += _expected(study)
    return points


def _turns(period: int) -> str:
    return "revolution" if period == 1 else f"{period} revolutions"


def _expected(study: Study) -> list[str]:
    """Return a sentence on the largest force peak to expect in many revolutions, or why none is predicted."""
    joints = [joint.name for joint in study.joints]
    names = [name for name in expected.columns(joints) if name in study.cases]
    block = {name: study.cases[name].to_numpy() for name in names} | {"case_id": study.cases.index.to_numpy()}
    largest = expected.worst(block, joints)
    if largest is None:
        return [
            "Without a period, the largest peak in 10⁶ revolutions is predicted only from "
            f"{expected.MIN_REVOLUTIONS} or more independent revolutions in the window."
        ]
    joint = next(joint for joint in study.joints if joint.name == largest.joint)
    ends = wording.in_common_unit((largest.value, largest.high, largest.seen), "N")
    where = study.joint_text(joint, " in joint {}") + _at(study, largest.case_id)
    return [expected.sentence(ends, where)]


def _chaotic(study: Study) -> list[str]:
    """Return a sentence on the number of chaotic motions, or [] unless `simulate.horizon` tests for chaos."""
    if not study.has("lyapunov_exponent"):
        return []
    chaotic = int(((study.cases["lyapunov_exponent"] > 0.0) & study.cases["period"].isna()).sum())
    count = wording.count(len(study.cases), "motion")
    return [f"{chaotic} of {count} are chaotic: any small disturbance grows."] if chaotic else []


def _over_median(study: Study, joint: Joint) -> str:
    """Return how much the largest peak of non-periodic cases exceeds the median peak per revolution."""
    median = joint.column("force_peak_median")
    if not study.has(median):
        return ""
    irregular = study.cases["period"].isna().to_numpy()
    peaks, medians = (study.cases[name].to_numpy()[irregular] for name in (joint.column("force_peak"), median))
    ratio = peaks / np.where(medians > 0.0, medians, np.nan)
    ratio = ratio[np.isfinite(ratio)]
    span = " to ".join(dict.fromkeys((wording.plain(ratio.min(), 2), wording.plain(ratio.max(), 2))))
    return f": {span} times the median peak per revolution" if len(ratio) else ""


def limits(study: Study) -> list[str]:
    """Return remarks on cases outside the range of their laws, in the words of the last lines of the run."""
    joints = [joint.name for joint in study.joints]
    remarks = validity.Remarks(joints)
    cases = {"case_id": study.cases.index}
    cases |= {name: study.cases[name] for name in validity.columns(joints, study.cases.columns) if name != "case_id"}
    for start in range(0, len(study.cases), CHUNK_ROWS):
        remarks.add({name: values[start : start + CHUNK_ROWS].to_numpy() for name, values in cases.items()})
    if counted := counts.remarks(study):
        remarks.replace_counts(counted)
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
    peak, ratio = (joint.column(name) for name in (PEAK.figure, "force_peak_ratio"))
    figures = ((peak, "force peak"), (p99, "force p99"), (ratio, "load / ideal"), *of_output)
    forces, ends = study.cases[peak].to_numpy(), []
    known = np.where(np.isfinite(forces), study.indices_on(speed), -1)
    for value, cases in zip(speed.values, indices_by_value(known, len(speed.values)), strict=True):
        if len(cases):
            least, most = cases[forces[cases].argmin()], cases[forces[cases].argmax()]
            ends += [(value, "least", least), (value, "most", most)] if least != most else [(value, "only", most)]
    places = [place for *_, place in ends]
    shown = [study.cases.index[places], *(study.cases[axis.path].iloc[places] for axis in others)]
    for column, _ in figures:
        shown.append(study.cases[column].iloc[places] if column in study.cases else np.full(len(places), np.nan))
    best = zip(ends, zip(*shown, strict=True), strict=True)
    rows = [(value, load, *values, case_id) for (value, load, _), (case_id, *values) in best]
    columns = (
        *axis_columns(study, [speed]),
        Column("load"),
        *axis_columns(study, others),
        *(Column(heading, study.unit(column)) for column, heading in figures),
        Column("case_id"),
    )
    title = "Least and most loaded design at each crank speed"
    where = study.joint_text(joint, " in joint {}")
    note = f"Ranked by the largest normal force{where}. p99 is exceeded during 1 % of the time."
    return Table("by_speed", title, note, columns, rows)
