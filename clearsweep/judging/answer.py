"""Sentences that answer the question of a grid, the same on the page and in the closing lines of a run."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from . import designs, sampled
from .order import Lead
from .validity import THOUSAND_HOURS

START_UP, FASTEST = "start_up_time", "crank_speed_max"  # columns
RUN_LENGTH = "revolutions_run"  # column
NOT_MODELLED = "not modelled"
MANY_AXES = 4  # varied values of a case above which a sentence has its identity instead


class Cases(NamedTuple):
    """The finished cases of a run, as numbers and in words."""

    record: Mapping[str, Any]  # run.json
    layout: Layout
    lead: Lead
    axes: tuple[str, ...]  # varied paths
    case_ids: Sequence[str]
    column: Callable[[str], np.ndarray]  # values (n,) of a column or a path; SI, NaN for null
    texts: Callable[[str, Sequence[float]], list[str]]  # column and values -> words, in one unit
    setting: Callable[[int, Sequence[str]], str]  # index of a case, paths -> their values in words

    def at(self, index: int) -> str:
        """Return ' at crank speed 60 rpm', or the identity where many values vary; '' without variation."""
        if len(self.axes) > MANY_AXES:
            return f" in case {wording.short_id(self.case_ids[index])}"
        setting = self.setting(index, self.axes)
        return f" at {setting}" if setting else ""

    def named(self, index: int) -> str:
        """Return ' (case 1a7fc708)', or '' where `at` has the identity already."""
        return "" if len(self.axes) > MANY_AXES else f" (case {wording.short_id(self.case_ids[index])})"

    def text(self, column: str, index: int) -> str:
        """Return a figure of a case in words."""
        return self.texts(column, [float(self.column(column)[index])])[0]

    def has(self, column: str) -> bool:
        """Return whether any case has a figure."""
        if not any(known.name == column for known in self.layout.columns):
            return False
        return bool(np.isfinite(self.column(column)).any())

    def extremes(self, column: str) -> tuple[int, int]:
        """Return the cases with the smallest and the largest value of a figure that some case has."""
        values = self.column(column)
        return int(np.nanargmin(values)), int(np.nanargmax(values))


def sentences(cases: Cases) -> list[str]:
    """Return the answer: start-up, force or film, designs within the limits, figures of the grid."""
    if not len(cases.case_ids):
        return []
    by_question = {"film": (films,), "force": (largest_force, position_error), "limits": (limited,)}
    specific = [line for answer in by_question.get(cases.lead.question, ()) for line in answer(cases)]
    return [*start_up(cases), *specific, *own_figures(cases), *lengths(cases)]


def extremes(cases: Cases) -> list[str]:
    """Return the part of the answer that needs only the cases with the extremes of each column."""
    if not len(cases.case_ids):
        return []
    force = (*largest_force(cases)[:1], *position_error(cases)) if cases.lead.question == "force" else ()
    return [*force, *own_figures(cases)]


def lengths(cases: Cases) -> list[str]:
    """Return how long the cases ran under `until`, and how many did not reach its accuracy."""
    if not cases.has(RUN_LENGTH):
        return []
    fewest, most = (f"{cases.column(RUN_LENGTH)[index]:.0f}" for index in cases.extremes(RUN_LENGTH))
    text = f"A case ran {fewest}{f' to {most}' if most != fewest else ''} revolutions."
    count, unsettled = len(cases.case_ids), int(np.sum(cases.column("settled") == 0))
    reached = "" if unsettled else "Each reached its accuracy or a periodic motion."
    if unsettled:
        reached = f"{unsettled} of {wording.count(count, 'case')} reached neither the accuracy nor a periodic motion."
    return [f"{text} {reached}"]


def start_up(cases: Cases) -> list[str]:
    """Return when a motor reaches its speed, where it does not, and by how much it exceeds the no-load speed."""
    motor = (cases.record.get("drive") or {}).get("motor") or {}
    no_load = motor.get("no_load_speed")
    if not isinstance(no_load, float) or "drive.motor.no_load_speed" in cases.axes or not cases.has(FASTEST):
        return []
    times, speeds = cases.column(START_UP), cases.column(FASTEST)
    (target,) = cases.texts(FASTEST, [0.95 * no_load])
    lines = []
    if np.isfinite(times).any():
        first, last = cases.extremes(START_UP)
        ends = cases.texts(START_UP, [float(times[first]), float(times[last])])
        text = f"Start-up to {target}, 95 % of the motor's no-load speed, takes {ends[0]}"
        slowest = "slowest, of those that reach it," if np.isnan(times).any() else "slowest"
        span = f" to {ends[1]}. Fastest{cases.at(first)}; {slowest}{cases.at(last)}"
        lines.append(f"{text}{span if first != last else cases.at(first)}.")
    if count := int(np.isnan(times).sum()):
        highest = int(np.argmax(np.where(np.isnan(times), speeds, -np.inf)))
        lines.append(
            f"{count} of {wording.count(len(times), 'case')} did not reach {target} within the run: at most "
            f"{cases.text(FASTEST, highest)}{cases.at(highest)}."
        )
    fastest = int(np.nanargmax(speeds))
    if speeds[fastest] > no_load:
        over = wording.percent(float(speeds[fastest]) / no_load - 1.0)
        lines.append(
            f"The crank exceeds the no-load speed by up to {over}: {cases.text(FASTEST, fastest)}{cases.at(fastest)}."
        )
    return lines


def start_up_card(cases: Cases) -> tuple[str, str] | None:
    """Return the start-up times as 'fastest to slowest', and how many cases did not reach the speed; None: no motor."""
    if not start_up(cases):
        return None
    times = cases.column(START_UP)
    missing, known = int(np.isnan(times).sum()), times[np.isfinite(times)]
    remark = f"not reached in {missing} of {wording.count(len(times), 'case')}" if missing else "to 95 % of the speed"
    ends = dict.fromkeys(cases.texts(START_UP, [float(known.min()), float(known.max())])) if known.size else ["none"]
    return " to ".join(ends), remark


def largest_force(cases: Cases) -> list[str]:
    """Return the largest normal force, with the load over the largest reaction without clearance."""
    worst = _worst(cases)
    if worst is None:
        return []
    index, (peak, *_), joint = worst
    text = (
        f"Largest normal force{_where(cases, joint)}: {cases.text(peak, index)}{cases.at(index)}{cases.named(index)}."
    )
    ratio, load = f"{joint}_force_peak_ratio", f"{joint}_load_peak"
    if cases.has(ratio) and np.isfinite(cases.column(ratio)[index]):
        rubs = cases.has(load) and cases.column(load)[index] > cases.column(peak)[index]
        subject = "With friction, the load" if rubs else "It"
        text += f" {subject} is {cases.text(ratio, index)} times the largest reaction without clearance."
    return [text, *_restitutions(cases)]


def _restitutions(cases: Cases) -> list[str]:
    """Return how far the measured restitution of each joint is from the requested one, where that varies."""
    lines = []
    for joint in cases.layout.joints:
        figure, path = f"{joint.name}_restitution", f"joints.{wording.joint_name(joint.name)}.contact.restitution"
        if path not in cases.axes or not cases.has(figure):
            continue
        measured, wanted = cases.column(figure).astype(float), cases.column(path).astype(float)
        worst = int(np.nanargmax(np.abs(measured - wanted)))
        lines.append(
            f"Measured restitution{_where(cases, joint.name)} differs from the requested one by at most "
            f"{wording.plain(abs(float(measured[worst] - wanted[worst])), 2)}: "
            f"{wording.plain(float(measured[worst]))}{cases.at(worst)}."
        )
    return lines


def position_error(cases: Cases) -> list[str]:
    """Return the largest error of the output's position."""
    error = next((column.name for column in cases.layout.columns if column.figure == "error_max"), "")
    if not error or not cases.has(error):
        return []
    worst = cases.extremes(error)[1]
    return [f"Largest {cases.layout.output} error: {cases.text(error, worst)}{cases.at(worst)}."]


def films(cases: Cases) -> list[str]:
    """Return the thinnest film with its dry share, whether its law covers it, and the range of the loss."""
    worst = _worst(cases)
    if worst is None:
        return []
    index, (thinnest, *_), joint = worst
    share, loss = f"{joint}_dry_load_share", f"{joint}_film_loss"
    parts = [f"loss {cases.text(loss, index)}"] if cases.has(loss) else []
    parts += [f"dry load share {share_words(float(cases.column(share)[index]))}"]
    head = f"Thinnest film{_where(cases, joint)}: {cases.text(thinnest, index)}{cases.at(index)}{cases.named(index)}."
    lines = [f"{head} There: {', '.join(parts)}."]
    outside = cases.column(f"{joint}_film_limit_fraction")
    if outside[index] > 0.0:
        lines[0] += f" The film is {beyond_law(float(outside[index]))}."
        within = np.where(outside > 0.0, np.nan, cases.column(thinnest))
        if np.isfinite(within).any():
            least = int(np.nanargmin(within))
            lines.append(f"Thinnest film within the range of its law: {cases.text(thinnest, least)}{cases.at(least)}.")
    if cases.has(loss) and len(cases.case_ids) > 1:
        low, high = cases.extremes(loss)
        lines.append(
            f"Largest loss{_where(cases, joint)}: {cases.text(loss, high)}{cases.at(high)}. Smallest: "
            f"{cases.text(loss, low)}{cases.at(low)}."
        )
    return lines


def beyond_law(share: float) -> str:
    """Return the remark on a film that is thinner than its law covers for a share of the time."""
    return f"thinner than its law covers for {_percent(share)} of the time"


def share_words(share: float) -> str:
    """Return a dry load share in words; NaN: no contact behind the film is modelled."""
    return NOT_MODELLED if np.isnan(share) else _percent(share)


def _percent(share: float) -> str:
    return f"{wording.short(100.0 * share, 3)}{wording.BLANK}%"


def limited(cases: Cases) -> list[str]:
    """Return the designs that keep to the limits under every operating condition, and a remark on fits."""
    if sampled.is_one_sample(cases.record):
        return []
    grouped = designs.of_cases(cases.axes, cases.column, len(cases.case_ids))
    lines = designs.sentences(grouped, lambda index: cases.setting(index, grouped.varied)) if grouped else []
    return [*lines, *(_fit_remark(cases) if lines else [])]


def _fit_remark(cases: Cases) -> list[str]:
    """Return that fits are computed at their mean clearance."""
    if not any(path in cases.axes for path in cases.record.get("fits") or {}):
        return []
    return ["A fit is computed at its mean clearance, not at the largest of its range."]


def own_figures(cases: Cases) -> list[str]:
    """Return the range of each figure that the grid defines, with the cases at its ends."""
    lines = []
    for name in cases.record.get("figures") or {}:
        values = cases.column(name)
        if np.isfinite(values).any():
            low, high = (int(pick(values)) for pick in (np.nanargmin, np.nanargmax))
            text = f"{name}: smallest {cases.text(name, low)}{cases.at(low)}"
            text += f". Largest: {cases.text(name, high)}{cases.at(high)}"
            lines.append(f"{text}." if values[low] != values[high] else f"{name}: {cases.text(name, low)}.")
    return lines


def wear(cases: Cases) -> list[str]:
    """Return for each joint the fastest wear of a body, and the growth of the clearance where surfaces evolve."""
    lines = []
    for joint in cases.layout.joints:
        rate = f"{joint.name}_wear_rate_max"
        if not joint.wear_bins or not cases.has(rate):
            continue
        worst = cases.extremes(rate)[1]
        (depth,) = cases.texts(f"{joint.name}_wear_depth_max", [THOUSAND_HOURS * float(cases.column(rate)[worst])])
        text = f"Deepest wear of one body{_where(cases, joint.name)}: {depth} per 1000 h{cases.at(worst)}"
        growth, hours = (f"{joint.name}_{figure}" for figure in ("clearance_growth", "life_hours"))
        if cases.has(growth) and cases.has(hours):
            grown = 1000.0 * float(cases.column(growth)[worst]) / float(cases.column(hours)[worst])
            if np.isfinite(grown):
                (per_hours,) = cases.texts(f"{joint.name}_wear_depth_max", [grown])
                text += f". Both bodies together widen the clearance by {per_hours} per 1000 h of its life"
        lines.append(f"{text}.")
    return lines


def _worst(cases: Cases) -> tuple[int, tuple[str, ...], str] | None:
    """Return index, columns and joint of the worst case; None if all figures are null."""
    columns = {name: cases.column(name) for name in cases.lead.columns}
    values, which = cases.lead.worst(columns)
    if np.isnan(values).all():
        return None
    badness = cases.lead.ranking(values)
    index = int(np.flatnonzero(badness == badness.max())[-1])
    candidate = cases.lead.candidates[int(which[index])]
    return index, candidate.columns, candidate.joint


def _where(cases: Cases, joint: str) -> str:
    return f" in joint {wording.joint_name(joint)}" if len(cases.layout.joints) > 1 else ""
