"""Sentences on figures with the cases of their extremes, on motions that coexist, and on the results of searches."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..contracts.catalogue import STARTS
from ..contracts.layout import Layout
from ..language import wording
from .judged import Cases, codes_of, combined_codes, median, plain_value
from .words import (
    MAX_LINES,
    Answer,
    Words,
    every_text,
    factor_text,
    from_to,
    in_brackets,
    life_criterion_text,
    margin_text,
)

# Sentences on single figures: forces, errors, lives, starts, films and wear, with the cases of their extremes.

MAX_PLACE = 90  # characters of the values of a case; instead of longer ones its identity is given


def own_figure_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the range of the user-defined figures."""
    for name in words.record.get("figures") or {}:
        if entry := extreme(answer, name):
            yield f"{words.figure(name)}: {_range_text(words, entry)}."


def _range_text(words: Words, entry: Mapping[str, Any]) -> str:
    """Return the smallest and the largest value of a figure in words."""
    texts = words.figures(entry["figure"], [entry["smallest"]["value"], entry["largest"]["value"]])
    return " to ".join(dict.fromkeys(texts))


def extreme(answer: Answer, column: str) -> Mapping[str, Any] | None:
    """Return the entry with the extremes of a column, or None."""
    return next((entry for entry in answer.get("extremes", ()) if entry["figure"] == column), None)


def extremes_of(answer: Answer, figure: str, words: Words) -> list[Mapping[str, Any]]:
    """Return the entries of a figure of all joints."""
    names = {column.name for column in words.layout.columns if column.figure == figure}
    return [entry for entry in answer.get("extremes", ()) if entry["figure"] in names]


def place_text(words: Words, end: Mapping[str, Any], max_length: int = MAX_PLACE) -> str:
    """Return ' at crank speed 2000 rpm (case 1a2b3c4d)' for an end of an extreme; the case alone if it is too long."""
    setting, case = words.setting(end["values"], end["case"]), f"case {wording.short_id(end['case'])}"
    if not setting:
        return ""
    return f" in {case}" if setting == case or len(setting) > max_length else f" at {setting} ({case})"


def force_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the largest normal force and its ratio to the ideal reaction."""
    entries = extremes_of(answer, "force_peak", words)
    if not entries and not answer.get("finished", 1):
        yield "No case finished, so nothing is known of forces and errors."
    never = [other for other in entries if not other["largest"]["value"]]
    if len(never) == len(entries):
        if entries:
            yield "The surfaces never touch: every force peak is 0."
        return
    largest = sorted(entries, key=lambda other: other["largest"]["value"], reverse=True)
    by_unit = {words.units[other["figure"]]: other for other in reversed(largest) if other not in never}
    leads = [by_unit[unit] for unit in sorted(by_unit)]  # torques, which do not compare with forces, have their own
    for entry in leads:
        ratio = entry["largest"].get("ratio")
        yield _largest_sentence(words, entry, f", {factor_text(ratio)} times the ideal" if ratio else "")
    if never:
        names = wording.sentence_list([words.figure(other["figure"]) for other in never])
        yield f"The surfaces never touch: {names} 0."
    elif not leads[0]["smallest"]["value"]:
        yield f"The surfaces do not touch in every case, such as{place_text(words, leads[0]['smallest'])}."


def _largest_sentence(words: Words, entry: Mapping[str, Any], remark: str = "") -> str:
    """Return the sentence on the largest value of a figure, and the case that has it; remark : on the value."""
    (text,) = words.figures(entry["figure"], [entry["largest"]["value"]])
    return f"Largest {words.figure(entry['figure'])}: {text}{remark}{place_text(words, entry['largest'])}."


STEADY_RATIO = 1.1  # of load peak to ideal, up to which the indentation is that of the ideal loads, without impacts
SURE_SHARE = 0.9  # of an indentation, which is an upper estimate: its joints and the error need not peak at once


def error_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the largest error of the output."""
    for entry in [entry for entry in extremes_of(answer, "error_max", words) if entry["largest"]["value"]][:1]:
        yield _largest_sentence(words, entry)


def vibration_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the largest velocity of each place with its zone, and that without clearance."""
    for entry in extremes_of(answer, "velocity_rms", words):
        end = entry["largest"]
        texts = words.figures(entry["figure"], [end[name] for name in ("value", "ideal") if name in end])
        zones = [in_brackets(f"zone {end[name]}") if name in end else "" for name in ("zone", "ideal_zone")]
        place = entry["figure"].removesuffix("_velocity_rms").replace("_", " ")
        ideal = f"; without clearance {texts[1]}{zones[1]}" if texts[1:] else ""
        yield f"Velocity of {place}: {texts[0]}{zones[0]}{place_text(words, end)}{ideal}."


def indentation_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Split the largest error into clearance, bending, housings and indentation; say which limit no clearance meets."""
    is_steady = all(
        entry["largest"].get("ratio", math.inf) <= STEADY_RATIO for entry in extremes_of(answer, "force_peak", words)
    )
    for entry in extremes_of(answer, "error_max", words)[:1]:
        error, indentation = entry["largest"]["value"], entry["largest"].get("indentation", 0.0)
        bending, mounts = (entry["largest"].get(part, 0.0) for part in ("bending", "mounts"))
        if not indentation and not bending and not mounts:
            continue
        numbers = [error, error - indentation - bending - mounts, bending, mounts, indentation]
        total, clearance, bent, yielded, depth = words.figures(entry["figure"], numbers)
        parts = [
            *([f"{clearance} or more is clearance"] if words.layout.joints else []),
            *([f"{bent} or less is bending"] if bending else []),
            *([f"{yielded} or less is the yield of housings"] if mounts else []),
            *([f"{depth} or less is indentation at the stiffness given"] if indentation else []),
        ]
        yield f"Of {words.figure(entry['figure'])} {total}, {', '.join(parts)}."
        for limit in words.limits if is_steady else ():
            if limit.column == entry["figure"] and limit.kind == "at_most" and limit.value < SURE_SHARE * indentation:
                yield f"No clearance can meet {words.limit(limit)} there."


def touch(answer: Answer, words: Words) -> Iterator[str]:
    """Say that the surfaces of a joint never touch, where limits lead."""
    for entry in extremes_of(answer, "force_peak", words):
        if not entry["largest"]["value"]:
            joint = next(column.joint for column in words.layout.columns if column.name == entry["figure"])
            yield f"The surfaces of {wording.joint_name(joint)} never touch in any case."


def life_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the shortest and the longest life with their intervals."""
    criterion = life_criterion_text(words.record.get("life") or {})
    until = f" {criterion}" if criterion else ""
    for entry in extremes_of(answer, "life_hours", words)[:1]:
        shortest, longest = entry["smallest"], entry["largest"]
        hours, longest_hours = (f"{wording.number_text(end['value'])}{wording.BLANK}h" for end in (shortest, longest))
        interval, longest_interval = (in_brackets(end.get("interval", "")) for end in (shortest, longest))
        body = f" ({shortest['body']})" if shortest.get("body") else ""
        yield f"Shortest life of {wording.joint_name(words.layout.life)}{body}: {hours}{place_text(words, shortest)}."
        yield f"It lasts{until}{interval}."
        if shortest.get("spread"):
            yield f"{shortest['spread']}."
        if longest["case"] != shortest["case"] and not answer.get("unlimited"):
            yield f"Longest: {longest_hours}{longest_interval}{place_text(words, longest)}."
    if unlimited := answer.get("unlimited"):
        count = wording.count_text(unlimited, "case")
        yield f"{count} {'has' if unlimited == 1 else 'have'} no wear, so the life there is unlimited."
    if unreached := answer.get("unreached"):
        count = wording.count_text(unreached, "case")
        yield f"{count} did not reach the limit, so the life there is longer than the run."


def start_up_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Say how fast the motor reaches its speed, and which cases do not."""
    entry = extreme(answer, "start_up_time")
    unreached, total = answer.get("unreached", 0), answer.get("finished", 0)
    if entry is None:
        yield "No case reaches 95 % of the motor's no-load speed within its run; run more revolutions."
        return
    time = _range_text(words, entry)
    where = place_text(words, entry["largest"]) if " to " in time else ""
    cases = f"{total - unreached} of {total} cases reach" if total > 1 else "The motor reaches"
    yield f"{cases} 95 % of the no-load speed after {time}{f', the slowest{where}' if where else ''}."
    if unreached:
        yield f"{wording.count_text(unreached, 'start')} ended before: run more revolutions there."


def loss_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the range of the loss of each film."""
    for entry in extremes_of(answer, "film_loss", words)[:1]:
        yield f"{words.figure(entry['figure'])}: {_range_text(words, entry)}."


def wear_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the deepest wear in 1000 hours, and when it would reach the clearance."""
    for entry in extremes_of(answer, "wear_rate_max", words)[:1]:
        rate = entry["largest"]["value"]
        if not rate:
            continue
        (text,) = wording.texts_in_common_unit([3.6e6 * rate], "m")
        hours = entry["largest"].get("clearance_hours")
        until = f", valid up to {wording.number_text(hours, 2)} h, when it has doubled the clearance" if hours else ""
        where = place_text(words, entry["largest"], MAX_PLACE // 2 if hours else MAX_PLACE)
        yield f"Deepest wear: {text} per 1000 h{where}{until}."


# Sentences on searches: what `refine` added, and the answers of `seek`, `optimise` and `identify`.


def added_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Say how many cases a search added, and how many exceed a limit with them."""
    counts = answer["cases"]
    if counts and not counts["added"] and answer["question"] == "refine":
        yield "No cases were added: no two neighbours differ in meeting the limits."
    if counts and counts["added"] and (totals := answer.get("all_cases")):
        undecided = f", {totals['undecided']} are undecided" if totals["undecided"] else ""
        yield (
            f"The search added {counts['added']} cases; of all {sum(totals.values())}, {totals['exceeded']} exceed a "
            f"limit{undecided} and {totals['met']} meet them."
        )


def found_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the sentences that a search of another kind has left in run.json."""
    yield from (words.record.get("found") or {}).get("sentences", ())


LIMITED_BY = ", limited by "


def seek_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the answers of `seek`, or what comes nearest where there is none."""
    section = words.record.get("seek") or {}
    direction = "largest" if "largest" in section else "smallest"
    searched = section.get(direction)
    paths = [searched] if isinstance(searched, str) else list(searched or ())
    if not paths or not answer["search"]:
        yield "The search was interrupted; run the same command again to continue."
        return
    names = wording.sentence_list([words.axis_name(path) for path in paths])
    others = {path: role for path, role in answer["roles"].items() if path not in paths}
    others |= {path: "condition" for path, role in others.items() if role == "choice"}  # the worst of them decides
    every = every_text({**answer, "roles": others}, words) if section.get("for") == "all" else ""
    items, borders = [], []
    for row in answer["search"]:
        point = {path: value for path, value in row.items() if path in words.path_units and value is not None}
        text, border, cause = _sought(words, row, paths[0])
        setting = words.setting(point) if row.get(f"seek.{paths[0]}") is not None or not every else ""
        is_alone = len(answer["search"]) == 1  # its border is a line of its own
        tail = f" (from there to {border} not known to be safe)" if border and not is_alone else ""
        decides_there = is_alone and setting and cause.startswith(LIMITED_BY)
        first = f"{setting}: " if setting else ""
        items.append(f"{text}{cause} at {setting}" if decides_there else f"{first}{text}{tail}{cause}")
        borders += [border] if border and is_alone else []
    lead = f"The {direction} {names} within the limits{every}"
    if len(items) == 1:
        yield f"{lead}: {items[0]}."
        for border in borders:
            yield f"From there to {border} it is not known to be safe."
    else:
        yield f"{lead}:"
        most = 3 if answer.get("nearest") else 4  # two lines or more follow
        shown = len(items) if len(items) <= most else most - 1
        for item in items[:shown]:
            yield f"{item}."
        if len(items) > shown:
            yield f"{len(items) - shown} more are in seek.parquet."
    for nearest in answer.get("nearest", ())[:1]:
        where = words.setting(nearest["values"], nearest["case"])
        tried, failed, margin = wording.count_text(nearest["tried"], "value"), nearest["failed"], words.margin(nearest)
        failures = f" and {failed} failed" if failed else ""
        yield f"None of {tried} tried meets the limits{failures}; nearest: {margin} at {where}."
    help_ = words.record.get("nearest") or {}
    for effect in help_.get("effects", ())[:1]:
        less, now, more = (
            "a failed case" if effect[side] is None else margin_text(effect[side], words.limits)
            for side in ("lower", "margin", "upper")
        )
        if len({less, now, more}) > 1:
            key = words.axis_name(effect["path"])
            yield f"Of the other keys {key} matters most: 10 % less gives {less}, 10 % more {more}."
    if needed := help_.get("needed"):
        limits = [f"{words.figure(column)} {bound}" for column, bound in needed.items()]
        yield f"The limits that would be met: {wording.sentence_list(limits)}."


def _sought(words: Words, row: Mapping[str, Any], path: str) -> tuple[str, str, str]:
    """Return an answer of `seek` in words, the nearest value that is not known to be safe or '', and what limits it."""
    value, limiting = row.get(f"seek.{path}"), row.get("limiting")
    if value is None:
        figures = {column.name for column in words.layout.columns} | {*(words.record.get("figures") or {})}
        if limiting and figures.isdisjoint(limiting.split(",")):
            return f"not known, as cases failed ({limiting})", "", ""
        return "none in the range" if "seek_fit" not in row else "none of those tried", "", ""
    text = f"{row['seek_fit']} ({words.value(path, value)})" if row.get("seek_fit") else words.value(path, value)
    other = row["seek_high"] if "largest" in (words.record.get("seek") or {}) else row["seek_low"]
    by = wording.sentence_list([words.figure(name) for name in (limiting or "").split(",") if name])
    border = words.value(path, other) if row["seek_low"] != row["seek_high"] else ""
    return text, border, f"{LIMITED_BY}{by}" if by else ", the end of the range"


def optimise_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the best cases of `optimise`."""
    rows = answer["search"]
    section = words.record.get("optimise") or {}
    objectives = [
        name
        for sense in ("minimise", "maximise")
        for name in ([section[sense]] if isinstance(section.get(sense), str) else section.get(sense) or ())
    ]
    count, tried = len(rows), wording.count_text(answer["tried"], "case")
    shown = MAX_LINES - 1 if count == MAX_LINES - 1 else MAX_LINES - 2
    lead = f"The front has {count} of {tried}{', such as' if count > shown else ''}: "
    lead = f"The best of {tried}: " if count == 1 else lead
    lead = lead if answer.get("best_met", True) else "No case meets the limits; nearest: "
    for row in rows[:shown]:
        limiting, margin = (row.get("limiting") or "").split(","), row.get("margin")
        limits = [limit for limit in words.limits if limit.column in limiting]
        setting = words.setting({path: row[path] for path in words.path_units if row.get(path) is not None})
        known = [(name, row[name]) for name in objectives if row.get(name) is not None]
        figures = [f"{words.figure(name)} {words.figures(name, [value])[0]}" for name, value in known]
        margin_words = "" if margin is None else f", {margin_text(margin, limits)}"
        yield f"{lead}{setting}: {wording.sentence_list(figures)}{margin_words}."
        lead = ""
    if count > shown:
        yield f"{count - shown} more are in optimise.parquet."


def identify_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Give the identified values with their intervals."""
    for parameter in answer.get("identified", ())[: MAX_LINES - 1]:
        path = parameter["path"]
        value, low, high = (words.value(path, parameter[key]) for key in ("value", "low", "high"))
        interval = from_to(low, high).removeprefix("from ")
        yield f"{words.axis_name(path)} {value} (95 %: {interval}){parameter['note']}."
    if not answer.get("explained", True):
        yield "Misfit: no values of these keys explain the measurement, so the intervals are widened."


# ---------------------------------------------------------------------------------------------- motions that coexist


DISTINCT = 0.05  # of the larger median: a smaller difference is none
MAX_POINTS = 1000  # points with several motions that an answer lists
MAX_CASES = 20  # cases of a motion that it lists


def coexisting(cases: Cases, layout: Layout) -> dict[str, Any] | None:
    """Return at which points of a grid its starts lead to different motions; None if it has one start.

    The statistic is the median of the largest forces of each revolution, in every joint.  Two cases have different
    motions if in some joint the 95 % intervals of this median do not overlap, nor does any chain of intervals of other
    cases connect them, and the medians differ by more than DISTINCT.  A case without an interval is undecided.
    """
    starts = [path for path in cases.paths if path in STARTS]
    medians = [column.name for column in layout.columns if column.figure == "force_peak_median"]
    if not starts or not medians or not len(cases):
        return None
    others = [path for path in cases.paths if path not in STARTS]
    points = combined_codes([codes_of(cases.values(path))[1] for path in others], len(cases))
    ends = ("", "_low", "_high")  # of the names of a median and its interval, (n, 3) N
    statistics = {name: np.stack([cases.numbers(f"{name}{end}") for end in ends], -1) for name in medians}
    is_known = np.logical_and.reduce([np.isfinite(statistic).all(axis=1) for statistic in statistics.values()])
    several, undecided = [], 0
    for point in sorted({*points.tolist()}):
        rows = np.flatnonzero(points == point)
        known = rows[is_known[rows]]
        labels = [motions_of(statistic[known]) for statistic in statistics.values()]
        groups = [known[number] for number in _groups(labels)]
        undecided += len(known) < len(rows) and len(groups) < 2
        if len(groups) > 1:
            several.append(_point(cases, others, rows, groups, statistics))
    spans = [[each["values"][path] for each in several] for path in others if len(others) == 1]
    between = [
        sum(min(span) <= value <= max(span) for value in codes_of(cases.values(path))[0])
        for path, span in zip(others, spans, strict=False)
        if span and not isinstance(span[0], str)
    ]
    counts = {"points": len({*points.tolist()}), "coexisting": len(several), "undecided": int(undecided)}
    counts |= {"between": sum(between)}
    return {"along": starts[0], **counts, "motions": several[:MAX_POINTS]}


def motions_of(statistic: np.ndarray) -> np.ndarray:
    """Return the number of the motion of each case from its median and the ends of its interval, (n, 3); see above."""
    order, labels = np.argsort(statistic[:, 1], kind="stable"), np.zeros(len(statistic), int)
    label, highest, largest = 0, np.inf, np.inf
    for row in order.tolist():
        median, low, high = statistic[row].tolist()
        if low > highest and median - largest > DISTINCT * median:
            label, highest, largest = label + 1, high, median
        highest = high if np.isinf(highest) else max(highest, high)
        largest = median if np.isinf(largest) else max(largest, median)
        labels[row] = label
    return labels


def _groups(labels: list[np.ndarray]) -> list[np.ndarray]:
    """Return the positions of the cases of each motion, whose labels are equal in every joint."""
    number = combined_codes(labels, len(labels[0]))
    return [np.flatnonzero(number == each) for each in sorted({*number.tolist()})]


def _point(
    cases: Cases, paths: list[str], rows: np.ndarray, groups: list[np.ndarray], statistics: Mapping[str, np.ndarray]
) -> dict[str, Any]:
    """Return one point with its motions, the one with the smallest force first."""
    means = {name: [median(statistic[group, 0]) for group in groups] for name, statistic in statistics.items()}
    figure = max(means, key=lambda name: max(means[name]) / max(min(means[name]), 1e-300))
    motions = [
        {
            "median": median,
            "low": float(statistics[figure][group, 1].min()),
            "high": float(statistics[figure][group, 2].max()),
            "starts": len(group),
            "share": len(group) / len(rows),
            "cases": [cases.case_id(row) for row in group[:MAX_CASES].tolist()],
        }
        for median, group in sorted(zip(means[figure], groups, strict=True), key=lambda pair: pair[0])
    ]
    values = {path: plain_value(cases.values(path)[rows[0]]) for path in paths}
    return {"values": values, "figure": figure, "motions": motions, "undecided": len(rows) - sum(map(len, groups))}


COUNTS = {2: "Two", 3: "Three", 4: "Four", 5: "Five", 6: "Six"}


def branch_sentences(answer: Answer, words: Words) -> Iterator[str]:
    """Say where motions coexist and what their forces are, or that the starts show no difference."""
    branches = answer.get("branches")
    if not branches:
        return
    total, points = branches["points"], branches["motions"]
    starts = "up and down" if branches["along"] == STARTS[0] else "from random starts"
    if points:
        point = max(points, key=lambda each: each["motions"][-1]["median"] / max(each["motions"][0]["median"], 1e-300))
        count, is_random = len(point["motions"]), branches["along"] == STARTS[1]
        counts = [str(motion["starts"]) for motion in point["motions"]]
        total_starts = sum(map(int, counts)) + point["undecided"]
        many, where, figure = COUNTS.get(count, count), _where(branches, words, point), words.figure(point["figure"])
        after = f", after {' and '.join(counts)} of {total_starts} starts" if is_random else ""
        yield f"{many} motions coexist {where}: {figure} {_forces(point, words)}{after}."
    elif branches["undecided"] < total:
        decided = wording.count_text(total - branches["undecided"], "point")
        yield f"The motions {starts} show no difference at {decided}."
    if branches["undecided"]:
        yield (
            f"Whether motions coexist is undecided at {branches['undecided']} of {total} points; run more revolutions, "
            "at least 30 after simulate.discard."
        )


def _forces(point: Mapping[str, Any], words: Words) -> str:
    """Return '1.1 or 2.6 kN', after the name of the figure."""
    texts = words.figures(point["figure"], [motion["median"] for motion in point["motions"]])
    numbers, units = zip(*(text.split(maxsplit=1) for text in texts), strict=True)
    shown = numbers if len(set(units)) == 1 else texts
    return " or ".join([*shown[:-1], texts[-1]])


def _where(branches: Mapping[str, Any], words: Words, point: Mapping[str, Any]) -> str:
    """Return 'from 640 to 820 rpm' if the only axis has them in between, else how many points, and one of them."""
    points, total = branches["motions"], branches["points"]
    paths = list(point["values"])
    if len(paths) == 1 and len(points) > 1 and not isinstance(point["values"][paths[0]], str):
        ends = sorted(each["values"][paths[0]] for each in points)
        first, last = (words.value(paths[0], value) for value in (ends[0], ends[-1]))
        unit = last.partition(" ")[2]
        is_whole = branches["coexisting"] == branches["between"]
        gaps = "" if is_whole else f" at {branches['coexisting']} of {branches['between']} values"
        return f"from {first.removesuffix(f' {unit}')} to {last}{gaps}"
    if total == 1:
        return f"at {words.setting(point['values'])}" if paths else "there"
    such = f", such as {words.setting(point['values'])}" if len(points) > 1 else f", {words.setting(point['values'])}"
    return f"at {branches['coexisting']} of {total} points{such}"
