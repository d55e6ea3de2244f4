"""The answer at the top of the page: cards, verdict, limits, reliability; and what failed."""

import itertools
import math
from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from ...answers import validity
from ...answers.figure_sentences import extremes_of
from ...answers.judge import DIFFERS, FALLS, RISES
from ...answers.judged import named_value
from ...answers.questions import MIN_REVOLUTIONS, expected_peak_sentence, largest_expected_peak, required_columns
from ...answers.ranking import TORQUE_UNIT
from ...answers.sentences import at_worst, deciding_figures, effect_text
from ...answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN, limit_label
from ...answers.words import case_margin_text, every_text, factor_text, share_text
from ...language import wording
from ...language.wording import TIMES, is_missing
from ..axis import PEAK, Axis
from ..blocks.section import Cards, Gallery, Picture, Points, Section, Sentences, section
from ..blocks.table import CHUNK_ROWS, CaseRows, Column, Quantity, Table, axis_columns, columns_of, count_cell
from ..draw import INK
from ..draw.comparison import MAP_SIZE, cell_font_size, draw_cells
from ..effects import main_effects_of
from ..plot import Axes, ColourScale
from ..study import (
    Joint,
    Study,
    answer_of_study,
    finished_cases,
    indices_by_value,
    reduce_over_other_axes,
    words_of,
)
from . import setup
from .identified import parameter_cards
from .laws import elastic_laws_sections, elastic_links_sections, law_choice_sections, recommendation_texts
from .maps import answer_maps
from .sample import failures_by_status, finished_and_failed, limit_columns, limit_counts, summed_counts
from .searches import answer_cards

# The cards at the top of the page: verdict, margin, worst case, force, error, life, and what drives them.

MAX_CARDS = 7  # concepts on the first screen
Card = tuple[str, str, str]  # name, value with unit, reference


def summary_sections(study: Study) -> list[Section]:
    """Return the cards of a run: name, value with unit, and reference of each."""
    finished, failed = finished_and_failed(study)
    missing = study.run.grid.get("counts", {}).get("missing", 0)
    note = (f"{failed} failed" if failed else "none failed") + (f", {missing} not run yet" if missing else "")
    finished_card = ("Cases finished", f"{finished} of {finished + failed + missing}", note)
    cards = [] if study.cases.empty else _answer_cards(study)
    if study.run.marks():
        sample_note = "a random sample, and the cases with the smallest and the largest value of each figure"
        cards.append(("Shown on this page", f"{len(study.cases) + len(study.failed)} cases", sample_note))
    return [Section("summary", "", [Cards([finished_card, *cards] if failed or missing else [*cards, finished_card])])]


def _answer_cards(study: Study) -> list[Card]:
    """Return the cards that the answer fills, in the order of their weight."""
    answer = answer_of_study(study)
    if answer["question"] == "identify":
        return parameter_cards(study)
    cards = [*(answer_cards(study) if answer["question"] == "seek" else ()), *_verdict_cards(study, answer)]
    figures = [
        ("life_hours", "Shortest life", "smallest"),
        ("start_up_time", "Start-up time", "largest"),
        ("film_thickness_min", "Thinnest film", "smallest"),
        ("force_peak", "Largest normal force", "largest"),
        ("error_max", f"Largest {study.run.layout.output} error", "largest"),
    ]
    for figure, name, end in figures:
        cards += _extreme_cards(study, answer, (figure, name, end))
    return [*cards[: MAX_CARDS - 1], *_driver_cards(study, answer)]


def _verdict_cards(study: Study, answer: Mapping[str, Any]) -> list[Card]:
    """Return the cards on the verdict and on the margin of the best or the nearest design."""
    designs, words = answer["designs"], words_of(study)
    if not designs:
        return []
    best, every = designs[0], every_text(answer, words).strip()
    if share := best.get("share"):
        undecided = f"{share_text(share['undecided'])} undecided" if share["undecided"] else ""
        notes = f"of {share['draws']} draws", undecided, words.design(best) if best["values"] else ""
        return [("Exceeds a limit", share_text(share["exceeded"]), "; ".join(filter(None, notes)))]
    if answer["designs_total"] == 1:
        cards = [("Verdict", f"{best['verdict']} the limits".replace("undecided the limits", "undecided"), every)]
    else:
        met, open_count = (answer["verdicts"][name] for name in ("meets", "undecided"))
        note = "; ".join(filter(None, (every, f"{open_count} undecided" if open_count else "")))
        cards = [("Designs within the limits", f"{met} of {answer['designs_total']}", note)]
    text = words.margin(best)
    where = "; ".join(filter(None, (words.design(best), at_worst(answer, words, best).removeprefix(" at "))))
    if not text:
        return cards
    if text.startswith("margin "):
        name = "Largest margin" if len(designs) > 1 else "Smallest margin"
        return [*cards, (name, text.removeprefix("margin "), where)]
    value, _, figure = text.partition(" of ") if " times the limit of " in text else (text, "", "")
    return [*cards, ("Nearest design" if len(designs) > 1 else "Worst case", value, f"{figure}; {where}".strip("; "))]


def _extreme_cards(study: Study, answer: Mapping[str, Any], figure: tuple[str, str, str]) -> list[Card]:
    """Return the card on the worst value of a figure over all joints; [] if no case has it."""
    (name, title, end), words = figure, words_of(study)
    entries = extremes_of(answer, name, words)
    if not entries:
        return []
    sign = -1.0 if end == "smallest" else 1.0
    alike = study.run.layout.comparable(entry["figure"] for entry in entries)
    worst = max((entry for entry in entries if entry["figure"] in alike), key=lambda entry: sign * entry[end]["value"])
    value = worst[end]["value"]
    hours = f"{wording.number_text(value)}{wording.BLANK}h"
    text = hours if name == "life_hours" else words.figures(worst["figure"], [value])[0]
    if name == "force_peak" and not value:
        text = "the surfaces never touch"
    if words.units[worst["figure"]] == TORQUE_UNIT:
        title = title.replace("normal force", "torque")
    ratio = worst[end].get("ratio")
    notes = [words.setting(worst[end]["values"], worst[end]["case"])]
    notes += [f"{factor_text(ratio)} times the ideal"] if ratio else []
    notes += [worst[end]["body"]] if worst[end].get("body") else []
    joint = next((column.joint for column in study.run.layout.columns if column.name == worst["figure"]), "")
    notes += [f"joint {wording.joint_name(joint)}"] if joint and len(study.joints) > 1 else []
    return [(title, text, "; ".join(filter(None, notes)))]


def _driver_cards(study: Study, answer: Mapping[str, Any]) -> list[Card]:
    """Return the card on what drives the leading figure; [] without a clear effect."""
    words = words_of(study)
    for figure in deciding_figures(answer)[:1]:
        for effect in answer["effects"]:
            if effect["figure"] == figure and effect["verdict"] in (RISES, FALLS, DIFFERS):
                name = f"{words.figure(figure).capitalize()} depends on"
                axis_names = [words.axis_name(path) for path in (effect["path"], *effect.get("with", ()))]
                return [(name, wording.sentence_list(axis_names), effect_text(answer, words, effect, subject=True))]
    return []


# The answer to the question of the grid, and maps and a table of the limits.

MAX_MAPS = 3  # pairs of axes at most
NOTE = "Each cell shows its smallest margin in per cent. It passes if all of its cases meet all limits."
#: Of passing cells, those whose design fails elsewhere, and failing ones: distinguished by any eye, and in grey.
CELL_COLOURS = ("#9fd0e8", "#dcecf5", "#f2b28c")
FAILS_ELSEWHERE, FAILING_CODE = 1.0, 2.0  # codes of cells; 0: passes
VERDICT_COLOURS = ColourScale(-0.5, FAILING_CODE + 0.5, CELL_COLOURS, is_stepped=True)
PASS_DOT_COLOUR, FAIL_DOT_COLOUR = "#1f5f86", "#a34a12"


class Dots(NamedTuple):
    """Cases between the cells of a map: (cases,) each."""

    x: np.ndarray  # positions on the first axis
    y: np.ndarray  # and on the second
    failing: np.ndarray  # bool


def verdict_sections(study: Study) -> list[Section]:
    """Return the section."""
    if study.cases.empty:
        count = wording.count_text(len(study.failed), "case")
        lines = [f"None of the {count} finished; the reasons are listed below.", *answer_of_study(study)["sentences"]]
        return [Section("verdict", "Answer", [Points(list(dict.fromkeys(lines)))])]
    gallery = Gallery("", [*_margin_maps(study)[:1], *answer_maps(study)])
    return section("verdict", "Answer", Points(answer_of_study(study)["sentences"]), gallery)


def folded_verdict_sections(study: Study) -> list[Section]:
    """Return a section with the table of limits and the maps of further pairs of axes."""
    if study.cases.empty:
        return []
    return section("limits-kept", "Limits", limit_table(study), Gallery("", _margin_maps(study)[1:]))


def limit_table(study: Study) -> Table:
    """Return, for each limit, the number of cases that exceed it, and the case with the smallest margin."""
    columns = columns_of("column* | limit | cases that exceed it | undecided | of | smallest margin")
    columns += [*axis_columns(study, study.swept()), Column("case_id")]
    rows = []
    counts = limit_counts(study)
    for limit, (failing, unknown) in zip(study.limits, counts.by_limit, strict=True):
        values_by_column = limit_columns(study, limit)
        margins, fails = limit.margin(values_by_column), limit.is_exceeded(values_by_column)
        row = _worst_row(margins, fails, limit.excess(values_by_column))
        case_id = study.cases.index[row]
        values = (study.cases.at(case_id, axis.path) for axis in study.swept())
        worst = float(margins[row])
        margin = Quantity(worst, case_margin_text(worst, [limit], limit.column if fails[row] else ""))
        of_cases = (count_cell(failing), count_cell(unknown), count_cell(counts.cases))
        label = limit_label(study.run.layout, limit, study.unit(limit.column))
        rows.append((limit.column, label, *of_cases, margin, *values, case_id))
    note = (
        "The margin is the distance within the limit over its size. A limit is undecided where its figure is null; a "
        "bound of 0 has no margin."
    )
    return Table("limits_kept", "Limits", note, columns, rows)


def _worst_row(margins: np.ndarray, fails: np.ndarray, excesses: np.ndarray) -> int:
    """Return the worst case of a limit: exceeded without a margin by the largest excess, else the smallest margin."""
    is_bare = fails & ~(margins < 0.0)
    if is_bare.any():
        return int(np.argmax(np.where(is_bare, np.nan_to_num(excesses, nan=np.inf), -np.inf)))
    return int(np.nanargmin(margins)) if np.isfinite(margins).any() else 0


def _margin_maps(study: Study) -> list[Picture]:
    """Return the maps of the smallest margin over the pairs of axes with the largest effect."""
    if MARGIN_COLUMN not in study.cases or not study.has(MARGIN_COLUMN):
        return []
    ranked = [effect.axis for effect in main_effects_of(study, MARGIN_COLUMN)]
    if len(ranked) < 2:
        return []
    pairs = list(itertools.combinations(ranked, 2))[:MAX_MAPS]
    return [_margin_map(study, *sorted(pair, key=study.axes.index)) for pair in pairs]


def _margin_map(study: Study, x_axis: Axis, y_axis: Axis) -> Picture:
    margins = study.cases[MARGIN_COLUMN]
    exceeded = ((study.cases[EXCEEDED_COLUMN] != "") | (study.cases[UNDECIDED_COLUMN] != "")).astype(float)
    smallest = -reduce_over_other_axes(study, -margins, (x_axis, y_axis), np.max)
    failing = reduce_over_other_axes(study, exceeded, (x_axis, y_axis), np.max)
    added_cases = added_points(study, exceeded, x_axis, y_axis)
    passing_cells, cells = int((failing == 0.0).sum()), int(np.isfinite(failing).sum())
    others = [axis.name for axis in study.swept() if axis not in (x_axis, y_axis)]
    reservations, remark = _reservations(study, (x_axis, y_axis))
    caption = f"{NOTE} Worst over {wording.sentence_list(others)}." if others else f"{NOTE} Each cell is one case."
    caption += remark
    if len(added_cases.x):
        dots_text = wording.count_text(len(added_cases.x), "dot")
        case_phrase = "is a case" if len(added_cases.x) == 1 else "are cases"
        caption += f" The {dots_text} between cells {case_phrase} that refine added; crosses exceed a limit."

    def paint(ax: Axes) -> None:
        texts = np.empty(failing.shape, object)
        for place, is_failing in np.ndenumerate(failing):
            margin = smallest[place]
            margin_text = wording.number_text(float(100.0 * margin), 2) if np.isfinite(margin) else ""
            passing_text = "(ok)" if reservations[place] == FAILS_ELSEWHERE else "ok"
            verdict_text = wording.DASH if np.isnan(is_failing) else "no" if is_failing else passing_text
            texts[place] = f"{verdict_text}\n{margin_text}".strip()
        codes = np.where(failing == 0.0, reservations, FAILING_CODE * failing)
        draw_cells(ax, codes, (x_axis, y_axis), VERDICT_COLOURS, texts, cell_font_size(failing.shape[1], 5))
        # Draw the line between neighbours of which one passes and the other fails
        rows, columns = np.nonzero(np.abs(np.diff(failing, axis=1)) == 1.0)
        ax.vlines(columns + 0.5, rows - 0.5, rows + 0.5, color=INK, linewidth=1.8)
        rows, columns = np.nonzero(np.abs(np.diff(failing, axis=0)) == 1.0)
        ax.hlines(rows + 0.5, columns - 0.5, columns + 0.5, color=INK, linewidth=1.8)
        for is_failing, colour, marker, size in ((False, PASS_DOT_COLOUR, "o", 3.7), (True, FAIL_DOT_COLOUR, "X", 3.0)):
            chosen = added_cases.failing == is_failing
            ax.scatter(added_cases.x[chosen], added_cases.y[chosen], size=size, color=colour, marker=marker)

    return Picture(
        f"Within the limits: {x_axis.name} {wording.TIMES} {y_axis.name}",
        caption,
        f"Map of the smallest margin over {x_axis.name} and {y_axis.name}: {passing_cells} of {cells} cells meet all "
        f"limits. {caption}",
        paint,
        MAP_SIZE,
    )


def _reservations(study: Study, pair: tuple[Axis, Axis]) -> tuple[np.ndarray, str]:
    """Return which cells meet the limits although their design does not meet them everywhere, and the remark on it."""
    answer, cases = answer_of_study(study), finished_cases(study)
    conditions = [path for path, role in answer["roles"].items() if role in ("condition", "model", "uncertainty")]
    codes = np.zeros(len(cases))
    if any(axis.path in conditions for axis in pair):
        for design in answer["designs"]:
            if design["verdict"] != "meets" and design["values"]:
                is_of_design = np.ones(len(cases), bool)
                for path, value in design["values"].items():
                    levels = cases.values_of(path).tolist()
                    named = [None if is_missing(level) else named_value(cases.record, path, level) for level in levels]
                    is_of_design &= np.array([name in (None, value) for name in named])
                codes[is_of_design] = FAILS_ELSEWHERE
    names = wording.sentence_list([words_of(study).axis_name(path) for path in conditions])
    remark = f" (ok): met here, but not at every {names}." if codes.any() else ""
    return reduce_over_other_axes(study, codes, pair, np.max), remark


def added_points(study: Study, exceeded: np.ndarray, x_axis: Axis, y_axis: Axis) -> Dots:
    """Return the finished cases between the values of two axes, added by `refine`."""
    is_between = (study.indices_on(x_axis) < 0) | (study.indices_on(y_axis) < 0)
    if not is_between.any():
        return Dots(np.zeros(0), np.zeros(0), np.zeros(0, bool))
    x, y = (_fractional_index(axis, study.cases[axis.path][is_between]) for axis in (x_axis, y_axis))
    return Dots(x, y, exceeded[is_between] > 0.0)


def _fractional_index(axis: Axis, values: np.ndarray) -> np.ndarray:
    """Return the fractional index of values on an axis: 0.5 is halfway between the first two."""
    if not axis.is_numeric:
        return np.array([axis.values.index(value) for value in values], float)
    order = np.argsort(axis.values)
    return np.interp(values.astype(float), np.array(axis.values)[order], order.astype(float))


# Reliability of peaks in words: periodicity, chaos, ranges of laws; and a table of forces by crank speed.

STEADY_PEAKS = 1.01  # largest peak over that of a typical revolution up to which it is no matter of chance
START_UP_NOTE = (
    "The motion is a start-up, so figures are those of this run from rest or its initial speed, not of a steady state."
)


def reliability_sections(study: Study) -> list[Section]:
    """Return the section with the least and the most loaded design at each crank speed.

    Return [] unless speed and another axis vary.
    """
    speed = next((axis for axis in study.levels() if axis.path == "drive.speed"), None)
    others = [axis for axis in study.swept() if axis is not speed]
    if speed is None or not others or study.cases.empty or not study.joints:
        return []
    joint = study.most_loaded_joint()
    error = study.column("error_max")
    output_figures = [(error, f"{study.run.layout.output} error")] if error else []
    peak, p99, ratio = (joint.column(name) for name in (PEAK.figure, "force_p99", "force_peak_ratio"))
    figures = ((peak, "force peak"), (p99, "force p99"), (ratio, "load / ideal"), *output_figures)
    forces, extremes = study.cases[peak], []
    speed_indices = np.where(np.isfinite(forces), study.indices_on(speed), -1)
    for value, cases in zip(speed.values, indices_by_value(speed_indices, len(speed.values)), strict=True):
        if len(cases):
            least_loaded, most_loaded = cases[forces[cases].argmin()], cases[forces[cases].argmax()]
            is_only = least_loaded == most_loaded
            extremes += [] if is_only else [(value, "least", least_loaded)]
            extremes.append((value, "only" if is_only else "most", most_loaded))
    case_indices = [case_index for *_, case_index in extremes]
    cell_columns = [study.cases.index[case_indices], *(study.cases[axis.path][case_indices] for axis in others)]
    unknown = np.full(len(case_indices), np.nan)
    cell_columns += [study.cases[name][case_indices] if name in study.cases else unknown for name, _ in figures]
    extreme_cells = zip(extremes, zip(*cell_columns, strict=True), strict=True)
    rows = [(value, load, *values, case_id) for (value, load, _), (case_id, *values) in extreme_cells]
    columns = [*axis_columns(study, [speed]), Column("load"), *axis_columns(study, others)]
    columns += [*(Column(heading, study.unit(column)) for column, heading in figures), Column("case_id")]
    title = "Least and most loaded design at each crank speed"
    joint_text = study.joint_text(joint, " in joint {}")
    note = f"Ranked by the largest normal force{joint_text}. p99 is exceeded during 1 % of the time."
    return section("headline", "Forces by crank speed", Table("by_speed", title, note, columns, rows))


def periodicity_sentences(study: Study) -> list[str]:
    """Return sentences on the number of periodic and chaotic motions, and on the significance of a single peak."""
    if "period" not in study.cases:
        return []
    if study.is_start_up:
        return [START_UP_NOTE]
    periods, count = study.cases["period"], len(study.cases)
    known_periods, points = periods[~np.isnan(periods)], []
    if len(known_periods):
        cases = f"{len(known_periods)} of {wording.count_text(count, 'motion')}"
        if len(known_periods) == count:
            cases = "Every motion" if count > 1 else "The motion"
        verb, its = ("repeats", "its") if len(known_periods) in (1, count) else ("repeat", "their")
        count_by_period = Counter(int(period) for period in known_periods)
        repeats = {n: f"every {'revolution' if n == 1 else f'{n} revolutions'}" for n in sorted(count_by_period)}
        counts = wording.sentence_list([f"{count_by_period[n]} {text}" for n, text in repeats.items()])
        points.append(
            f"{cases} {verb}{f': {counts}' if len(repeats) > 1 else f' {repeats.popitem()[1]}'}, so {its} peaks recur."
        )
    points += _chaos_sentences(study)
    if len(known_periods) < count:
        unknown = f"{count - len(known_periods)} of {wording.count_text(count, 'motion')}"
        subject = unknown if count > 1 else "The motion"
        ratio = _ratio_to_median(study, study.most_loaded_joint())
        if ratio <= STEADY_PEAKS:
            within = share_text(STEADY_PEAKS - 1.0)
            return [*points, f"{subject} did not repeat exactly; peaks are within {within} of a typical one."]
        up_to = (
            f", up to {wording.number_text(ratio, 2)} times that of a typical revolution" if ratio < math.inf else ""
        )
        points.append(
            f"{subject} did not repeat within the run. The largest peak is partly chance{up_to}. Compare designs by "
            "the median peak, the rms or the p99."
        )
        points += _expected_peak_sentences(study)
    return points


def _expected_peak_sentences(study: Study) -> list[str]:
    """Return a sentence on the largest force peak to expect in many revolutions, or why none is predicted."""
    joints = [joint.name for joint in study.joints]
    names = [name for name in required_columns(joints) if name in study.cases]
    columns = {name: study.cases[name] for name in names} | {"case_id": study.cases.index}
    largest = largest_expected_peak(columns, joints)
    if largest is None:
        return [
            "Without a period, the largest peak in 10⁶ revolutions is predicted only from "
            f"{MIN_REVOLUTIONS} or more independent revolutions in the window."
        ]
    joint = study.joint(largest.joint)
    force_texts = wording.texts_in_common_unit((largest.value, largest.high, largest.seen), "N")
    setting = f" at {study.setting(largest.case_id)}" if study.swept() else ""
    return [expected_peak_sentence(force_texts, study.joint_text(joint, " in joint {}") + setting)]


def _chaos_sentences(study: Study) -> list[str]:
    """Return a sentence on the number of chaotic motions, or [] unless `simulate.horizon` tests for chaos."""
    if not study.has("lyapunov_exponent"):
        return []
    chaotic = int(((study.cases["lyapunov_exponent"] > 0.0) & np.isnan(study.cases["period"])).sum())
    count = wording.count_text(len(study.cases), "motion")
    return [f"{chaotic} of {count} are chaotic: any small disturbance grows."] if chaotic else []


def _ratio_to_median(study: Study, joint: Joint) -> float:
    """Return the largest peak of any non-periodic case over its median peak per revolution; inf if unknown."""
    median_column = joint.column("force_peak_median")
    if not study.has(median_column):
        return math.inf
    is_aperiodic = np.isnan(study.cases["period"])
    peaks, medians = (study.cases[name][is_aperiodic] for name in (joint.column("force_peak"), median_column))
    ratio = peaks / np.where(medians > 0.0, medians, np.nan)
    ratio = ratio[np.isfinite(ratio)]
    return float(ratio.max()) if len(ratio) else math.inf


def law_range_remarks(study: Study) -> list[str]:
    """Return remarks on cases outside the range of their laws, in the words of the last lines of the run."""
    joints = [joint.name for joint in study.joints]
    remarks = validity.Remarks(joints)
    names = {*validity.required_columns(joints, study.cases.columns)} - {"case_id"}
    cases = {"case_id": study.cases.index} | {name: study.cases[name] for name in names}
    for start in range(0, len(study.cases), CHUNK_ROWS):
        remarks.add({name: values[start : start + CHUNK_ROWS] for name, values in cases.items()})
    if study.run.marks() and (counted := summed_counts(study, "remarks")):
        remarks.replace_counts(counted)
    return remarks.sentences()


# Reliability of the figures: failures, ranges of laws, periodicity, convergence, budget of unknowns.

NO_BUDGET = Markup(
    "This page has no error budget, because the run does not vary each unknown separately. "
    "<code>configs/error_budget.yaml</code> shows such a run."
)


def trust_sections(study: Study) -> list[Section]:
    """Return the section."""
    return section("trust", "Reliability of the results", Points(reliability_points(study)))


def reliability_points(study: Study) -> list[str]:
    """Return failures and warnings of the run, then a sentence each on laws, convergence and unknowns."""
    finished, failed = finished_and_failed(study)
    points: list[str] = []
    if failed and finished:
        cases = Markup('<a href="#failures">{} of {} cases failed</a>').format(failed, failed + finished)
        points.append(cases + ". All results except the list of failures exclude them.")
    points += [Markup("<b>Warning:</b> {}").format(text) for text in study.run.grid.get("warnings") or []]
    if study.cases.empty:
        return points
    periodicity = " ".join(periodicity_sentences(study))
    points += [*law_range_remarks(study), *filter(None, [periodicity]), *recommendation_texts(study)]
    for each in (*law_choice_sections(study), *elastic_laws_sections(study)):
        points += [_with_link(each, sentence) for sentence in each.sentences[:1]]
    points += [_with_link(each, " ".join(each.sentences[:2])) for each in elastic_links_sections(study)]
    budget = [_with_link(each, " ".join(each.sentences[1:2])) for each in setup.budget_sections(study)]
    return [*points, *(budget or [NO_BUDGET])]


def _with_link(section: Section, sentence: str) -> str:
    """Return a sentence of a folded section with a link to it."""
    return Markup('{} <a href="#{}">{}</a>').format(sentence, section.key, "More.")


# The cases that did not finish, with their reasons.


def failure_sections(study: Study) -> list[Section]:
    """Return the section, or [] if every case finished."""
    if study.failed.empty:
        return []
    ordered = sorted(failures_by_status(study).items(), key=lambda pair: (-pair[1], pair[0]))
    reasons = Markup(", ").join(Markup("{} {} <b>{}</b>").format(number, TIMES, status) for status, number in ordered)
    reasons_sentence = Markup("{}. <code>clearsweep run --retry-failed</code> runs them again.").format(reasons)
    labels = study.label_columns
    columns = [Column("case_id"), *map(Column, labels), *axis_columns(study, study.swept())]
    columns += columns_of("status | reason")
    shown_columns = [*labels, *(axis.path for axis in study.swept()), "status", "message"]
    table = Table("failed", "Failed cases", "", columns, CaseRows(study.failed, shown_columns))
    return [Section("failures", "Failed cases", [Sentences([reasons_sentence]), table])]
