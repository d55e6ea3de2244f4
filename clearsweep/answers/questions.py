"""Answers of runs with a question of their own: films, identified machines, other laws, peaks to expect."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from ..language.wording import is_missing
from .judge import answer_on
from .judged import EXCEEDED, Cases
from .ranking import CaseRanking, FinishedCases
from .words import Words

# Oil films: which cases keep them within their law and above the roughness, and which combinations always do.

ROUGHNESSES = 3.0  # combined roughnesses of both surfaces that a film should exceed to separate them
FILM_THICKNESS = "film_thickness_min"
FILM_LOSS = "film_loss"
FILM_LIMIT_FRACTION = "film_limit_fraction"
UNSAFE = "film_unsafe"  # column of the answer on films: 1 for an unsafe film
MAX_LISTED = 4  # safe combinations in the answer


def film_answer(record: Mapping[str, Any], layout: Layout, cases: Cases) -> dict[str, Any] | None:
    """Return the combinations of choices whose films are safe under every condition, the thickest first.

    Return None for a random sample, and if no joint has a film.
    """
    finished = FinishedCases(record, layout, tuple(cases.codes), cases.values)
    joints = film_joints(finished)
    if not joints or record.get("sample"):
        return None
    unsafe = is_unsafe(finished).astype(float)
    table = {path: cases.values(path) for path in cases.codes}
    table |= {name: cases.values(name) for name in ("case_id", "status")} | {UNSAFE: unsafe}
    column = {"name": UNSAFE, "unit": "1", "description": ""}
    of_films = {**record, "limits": {UNSAFE: 0.0}, "figures": {}, "layout": {"columns": [column]}}
    answer = answer_on(Cases(of_films, table), ())
    safe = [design for design in answer["designs"] if design["verdict"] == "meets"]
    thickness = np.nanmin([cases.numbers(f"{joint}_{FILM_THICKNESS}") for joint in joints], axis=0)
    named = [(float(thickness[cases.rows_of(design["values"])].min()), design["values"]) for design in safe]
    named.sort(key=lambda entry: -entry[0])
    texts = [(wording.texts_in_common_unit([size], "m")[0], values) for size, values in named]
    return {
        "count": len(safe),
        "undecided": sum(design["verdict"] == "undecided" for design in answer["designs"]),
        "missing": [design for design in answer["designs"] if design["missing"]][:MAX_LISTED],
        "total": answer["designs_total"],
        "criterion": film_criterion_text(finished, joints[0]),
        "designs": [{"values": values, "text": f"least film {text}"} for text, values in texts[:MAX_LISTED]],
    }


def film_joints(cases: FinishedCases) -> list[str]:
    """Return the joints with a film."""
    return [joint.name for joint in cases.layout.joints if cases.has_values(f"{joint.name}_{FILM_THICKNESS}")]


def required_thickness(cases: FinishedCases, joint: str) -> np.ndarray | None:
    """Return ROUGHNESSES times the combined roughness (m) of a joint's surfaces in each case; None if it is unknown."""
    roughness = cases.number(f"joints.{wording.joint_name(joint)}.film.transition.roughness")
    return None if roughness is None else ROUGHNESSES * roughness


def law_end_thickness(cases: FinishedCases, joint: str) -> float | None:
    """Return the largest film (m) at which the law of a joint's film ends; None if the grid does not state it."""
    paths = (f"joints.{wording.joint_name(joint)}.{key}" for key in ("clearance", "film.limit"))
    clearances, limit_ratios = (cases.number(path) for path in paths)
    if clearances is None or limit_ratios is None:
        return None
    thicknesses = clearances * (1.0 - limit_ratios)
    return float(np.nanmax(thicknesses)) if np.isfinite(thicknesses).any() else None


def is_unsafe(cases: FinishedCases) -> np.ndarray:
    """Return which cases (n,) leave the range of a film law, are too thin for the surfaces' roughness, or unknown."""
    is_unsafe = np.zeros(len(cases), bool)
    for joint in film_joints(cases):
        if cases.has_values(f"{joint}_{FILM_LIMIT_FRACTION}"):
            is_unsafe |= cases.values_of(f"{joint}_{FILM_LIMIT_FRACTION}").astype(float) > 0.0
        thickness = cases.values_of(f"{joint}_{FILM_THICKNESS}").astype(float)
        required = required_thickness(cases, joint)
        is_unsafe |= ~(thickness > 0.0)
        if required is not None:
            is_unsafe |= thickness < required
    return is_unsafe


def film_criterion_text(cases: FinishedCases, joint: str) -> str:
    """Return the criteria of a safe film: within its law, and thicker than the roughness if this is known."""
    roughness = "" if required_thickness(cases, joint) is None else f" and above {ROUGHNESSES:g} roughnesses"
    return f"within its law{roughness}"


def dry_share_text(share: float) -> str:
    """Return a dry load share in words; NaN means that no contact behind the film is modelled."""
    return "not modelled" if np.isnan(share) else wording.percent_text(share)


# Sentences on an identified machine: certainty of its values, and whether the model explains the signals.

MAX_DEVIATION = 3.0  # standard deviations above which a feature is mentioned
MAX_SPEED_DEVIATION = 0.01  # relative difference of measured and computed speed above which it is mentioned
MAX_NAMED_FEATURES = 4  # most features mentioned


def certainty_text(parameter: Mapping[str, Any]) -> str:
    """Return the remark on an interval: the data hardly determine the value, or the interval ends at the range."""
    remarks = {"not": "the data do not determine it", "weakly": "the data determine it weakly"}
    statements = [remarks[parameter["determined"]]] if parameter["determined"] in remarks else []
    if parameter["ends"] and parameter["determined"] == "well":
        statements.append(
            f"the interval ends at the {' and '.join(parameter['ends'])} end of its range: widen the range"
        )
    return f"; {', '.join(statements)}" if statements else ""


def difference_text(fit: Mapping[str, Any]) -> str:
    """Return the difference between a computed and a measured feature in words."""
    if not fit["measured"]:
        return ""
    percentage = 100.0 * (fit["computed"] / fit["measured"] - 1.0)
    return f" ({percentage:+.3g} %)" if math.isfinite(percentage) else ""


def identification_sentences(identified: Mapping[str, Any], joint_count: int) -> list[str]:
    """Return the sentences on misfit, keys that trade off, priors and treatment of the signals."""
    lines = [_misfit_sentence(identified)]
    for first_key, second_key, correlation in identified["traded"]:
        names = f"{wording.axis_name(first_key, joint_count)} and {wording.axis_name(second_key, joint_count)}"
        lines.append(f"{names} trade off (correlation {correlation:.2f}): the data determine a combination of them.")
    for signal in identified["signals"]:
        noise_text, low_text, high_text = (f"{100.0 * noise_share:.2g}" for noise_share in signal["noise"])
        lines.append(
            f"{signal['channel']} of {signal['file']}: {signal['revolutions']} revolutions of {signal['samples']:.4g} "
            f"samples, compared up to order {signal['orders']:.3g}; crank angle {math.degrees(signal['angle']):.3g} "
            f"deg in advance, noise {noise_text} % of the rms (95 %: {low_text} to {high_text} %)."
        )
        speed, computed_speed = signal["speed"], identified["computed_speed"]
        if speed and abs(speed / computed_speed - 1.0) > MAX_SPEED_DEVIATION:
            lines.append(
                f"{signal['file']}: the measured speed is {speed * 30.0 / math.pi:.5g} rpm, but the cases have "
                f"{computed_speed * 30.0 / math.pi:.5g} rpm; set drive.speed to the measured speed."
            )
    gain = identified["priors"]["gain"]
    noise_range = [100.0 * noise_share for noise_share in identified["priors"]["noise"]]
    lines.append(
        f"Priors: even over each range; gain within {196.0 * gain:.2g} % (95 %); offset and crank angle free; noise "
        f"{noise_range[0]:.2g} to {noise_range[1]:.2g} % of the rms."
    )
    return lines


def _misfit_sentence(identified: Mapping[str, Any]) -> str:
    """Return the sentence on whether the model explains the measurement."""
    if identified["explained"]:
        return "The model explains the measurement within the assumed errors; smaller model errors are not detected."
    deviating = sorted(
        (fit for fit in identified["fits"] if abs(fit["deviations"]) > MAX_DEVIATION),
        key=lambda fit: -abs(fit["deviations"]),
    )
    descriptions = [
        f"{fit['channel']}, {fit['feature']}{difference_text(fit)}" for fit in deviating[:MAX_NAMED_FEATURES]
    ]
    location = f"; largest differences: {wording.sentence_list(descriptions)}" if descriptions else ""
    return (
        f"Misfit: no values of these keys explain the measurement{location}. Errors are "
        f"{math.sqrt(identified['misfit']):.2g} times the assumed ones, so the intervals are widened; "
        "another law or a missing effect may be the reason."
    )


# Effect of the other valid laws on the deciding case of a run (`check_laws`).

MAX_NAMED_LAWS = 4  # laws that a sentence names


class LawResult(NamedTuple):
    """The deciding case under one other law."""

    case_id: str
    path: str  # of the law's name
    law: str
    column: str  # of the figure that ranks the cases
    value: float  # SI, nan for null


def law_results(table: Mapping[str, np.ndarray], grid_laws: Mapping[str, str], ranking: CaseRanking) -> list[LawResult]:
    """Return the results of the finished cases that check laws; grid_laws : path -> law of the grid."""
    worst_values, candidate_numbers = ranking.worst_values(table)
    rows = []
    for index, case_id in enumerate(table["case_id"].astype(str).tolist()):
        path, law = changed_law({path: table[path][index] for path in grid_laws}, grid_laws)
        column = ranking.candidates[int(candidate_numbers[index])].columns[0]
        rows.append(LawResult(case_id, path, law, column, float(worst_values[index])))
    return rows


def changed_law(laws: Mapping[str, Any], grid_laws: Mapping[str, str]) -> tuple[str, str]:
    """Return path and name of the law of a case that is not the grid's."""
    return next((path, law) for path, law in laws.items() if not is_missing(law) and law != grid_laws[path])


def law_check_sentence(
    record: Mapping[str, Any], columns: Any, checks: tuple[Mapping[str, str], np.ndarray], words: Words, figure: str
) -> str:
    """Return whether the other laws change the verdict on the deciding case or, without limits, its figure.

    checks : path -> law of the grid, and a mask (n,) of the cases that check laws; figure : the leading column
    """
    grid_laws, is_checked = checks
    rows = np.flatnonzero(is_checked)
    changed = [changed_law({path: columns[path][row] for path in grid_laws}, grid_laws) for row in rows.tolist()]
    several = len({path.split(".")[1] for path, _ in changed}) > 1
    names = [f"{law} ({path.split('.')[1]})" if several else law for path, law in changed]
    count = f"{len(rows)} other valid law{'s' * (len(rows) != 1)}"
    if not words.limits:
        values = columns[figure][rows].astype(float)
        if not np.isfinite(values).any():
            return ""
        low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
        texts = words.figures(figure, [float(values[low]), float(values[high])])
        spread = f"{texts[0]} ({names[low]})" + (f" to {texts[1]} ({names[high]})" if low != high else "")
        return f"The worst case under {count}: {words.figure(figure)} {spread}."
    cases = Cases(record, columns)
    verdicts = cases.verdicts[rows].tolist()
    unchecked = np.flatnonzero(~is_checked).tolist()
    base = next(row for row in unchecked if _is_same(record, columns, (rows[0], row), grid_laws))
    was_exceeded = cases.verdicts[base] == EXCEEDED
    changing = [name for name, verdict in zip(names, verdicts, strict=True) if (verdict == EXCEEDED) != was_exceeded]
    if not changing:
        return f"{count[0].upper()}{count[1:]} do{'es' * (len(rows) == 1)} not change the verdict on the worst case."
    more = [f"{len(changing) - MAX_NAMED_LAWS} more"] if len(changing) > MAX_NAMED_LAWS else []
    outcome = "meets the limits" if was_exceeded else "does not meet the limits"
    return (
        f"The verdict changes: the worst case {outcome} with {wording.sentence_list(changing[:MAX_NAMED_LAWS] + more)}."
    )


def _is_same(record: Mapping[str, Any], columns: Any, rows: tuple[int, int], grid_laws: Mapping[str, str]) -> bool:
    """Return whether two cases agree at all varied paths but the checked laws."""
    row, other = rows
    paths = [path for path in record["units"] if path not in grid_laws]
    return all(
        columns[path][row] == columns[path][other]
        or (is_missing(columns[path][row]) and is_missing(columns[path][other]))
        for path in paths
    )


# Sentence on the largest force peak to expect in many revolutions.

#: Figures of a joint: the largest peak to expect, its upper bound, and that of the window.
EXPECTED_PEAK_FIGURES = ("force_peak_million", "force_peak_million_high", "force_peak")
MIN_REVOLUTIONS = 100  # independent revolutions


class ExpectedPeak(NamedTuple):
    """The largest force peak to expect in a joint in 10^6 revolutions, N; its fields are keys of `run --json`."""

    case_id: str
    joint: str  # as in columns
    value: float
    high: float  # exceeded with a probability of 2.5 %
    seen: float  # largest peak of the window


def required_columns(joints: list[str]) -> list[str]:
    """Return the columns of the summary that the prediction needs."""
    return [f"{joint}_{figure}" for joint in joints for figure in EXPECTED_PEAK_FIGURES] + ["period"]


def largest_expected_peak(table: Mapping[str, np.ndarray], joints: list[str]) -> ExpectedPeak | None:
    """Return the largest peak to expect among finished non-periodic motions, or None if there is none."""
    largest_peak: ExpectedPeak | None = None
    is_irregular = np.isnan(np.asarray(table["period"], float)) if "period" in table else np.zeros(0, bool)
    for joint in joints:
        columns = [f"{joint}_{figure}" for figure in EXPECTED_PEAK_FIGURES]
        if columns[0] not in table or not is_irregular.any():
            continue
        values = np.where(is_irregular, np.asarray(table[columns[0]], float), np.nan)
        if np.isnan(values).all():
            continue
        index = int(np.nanargmax(values))
        figures = (float(table[name][index]) for name in columns)
        candidate = ExpectedPeak(str(table["case_id"][index]), joint, *figures)
        largest_peak = candidate if largest_peak is None or candidate.value > largest_peak.value else largest_peak
    return largest_peak


def expected_peak_sentence(peak_texts: list[str], location: str) -> str:
    """Return a sentence with the expected peak.

    figures : value, upper end, and largest peak of the window, as texts
    location : ' in joint ... at ...'
    """
    value_text, bound_text, window_text = peak_texts
    return (
        f"The largest force peak in 10⁶ revolutions is estimated at {value_text}, at most {bound_text} (97.5 "
        f"%){location}. The largest peak in the window is {window_text}."
    )
