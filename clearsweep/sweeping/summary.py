"""The last lines of a run and of a dry run: worst cases, failures, answer, files."""

import json
import re
from collections.abc import Iterable, Mapping
from typing import Any

from .. import grid as grids
from ..answers.judged import binomial_interval
from ..answers.questions import dry_share_text, expected_peak_sentence
from ..answers.ranking import START_UP, TYPICAL_VELOCITY
from ..answers.verdict import Limit, column_label, limit_label
from ..answers.words import MIN_DIGITS, common_units, digits_of, varied_text
from ..contracts.layout import Layout
from ..language import wording
from ..language.errors import InputError
from ..searches import SEARCHES, search_of
from ..store import ANSWER_FILE, StoredRun
from .facts import RunFacts, assumed_texts, grid_text, grid_texts, setting_name, setting_text, value_text
from .pool.case_runner import SIMULATION
from .sweep import RunResult

DERIVED = 12  # lines on derived values at the end of a run
RADIAL, DIAMETRAL, SCATTER = ", radial)", ", diametral)", ", range)"  # ends of names of values that share a line
MANY_AXES = 4  # swept paths above which the summary table leaves out columns with one value


def of_run(result: RunResult) -> dict[str, Any]:
    """Return the facts that `run` reports of a RunResult, for JSON: counts, files, worst cases, failures; in SI."""
    run = result.open()
    run_facts = RunFacts(run.grid, run.layout)
    run_facts.read(run)
    limits, leading = run_facts.limits, run_facts.ranking
    words = {key: run.grid.get(key, {}) for key in ("units", "fits", "labels")}
    words["written_units"] = common_units(run.grid)
    words["digits"] = {path: digits_of(run.grid, path, words["written_units"]) for path in run.grid["units"]}
    answer = json.loads((result.directory / ANSWER_FILE).read_bytes())
    return words | {
        "directory": str(result.directory),
        "cases": result.cases,
        "ran": result.ran,
        "reused": result.reused,
        "ok": result.ok,
        "failed": result.failed,
        "missing": result.missing,
        "others": result.others,
        "statuses": dict(run_facts.statuses),
        "joined": result.joined,
        "seconds": round(result.seconds, 3),
        "case_seconds": round(result.case_seconds, 3),
        "derived": result.derived,
        "warnings": [*result.warnings, *run_facts.remarks.sentences()],
        "limits": limits.facts(),
        "limit_labels": _limit_labels(run.layout, limits.verdict.limits, limits.units),
        "limited_figures": {limit.column: column_label(run.layout, limit.column) for limit in limits.verdict.limits},
        "probability": _probability(answer),
        "life": run_facts.lives.facts(),
        "slowest": run_facts.slowest_case.slowest,
        **dict.fromkeys((search.answer_key for search in SEARCHES if search.answer_key), None),
        "question": answer["question"],
        "ranked": {"title": leading.title, "headings": list(leading.headings), "units": limits.units},
        "worst": run_facts.worst.facts(),
        "answer": answer | {"sentences": [plain(text) for text in answer["sentences"]]},
        "expected": run_facts.expected,
        **_search_facts(result, run, run_facts),
        "failures": run_facts.failures,
        "files": {name: str(result.directory / name) for name in (*run.files, ANSWER_FILE)},
    }


def _search_facts(result: RunResult, run: StoredRun, run_facts: RunFacts) -> dict[str, Any]:
    """Return the answer of the search of a run under its key, {} without a search."""
    search = search_of(run.grid)
    if search is None:
        return {}
    facts = run_facts.own.facts(next(iter(run_facts.worst.entries), None))
    if facts is None and result.search_result:
        facts = result.search_result.facts(SIMULATION.catalogue(), run.grid, run_facts.limits.verdict)
    return {search.answer_key: facts}


def require_judgement(grid: grids.Grid) -> None:
    """Raise InputError for a grid that judges nothing, so that `--fail-on-limits` would always pass."""
    if not (grid.limits or (grid.search and grid.search.judges)):
        lack = "the grid has no `limits` and no search; add `limits` or leave the option out"
        raise InputError(f"--fail-on-limits: {lack}")


def limits_failure(facts: Mapping[str, Any]) -> str:
    """Return why the limits of a run are not known to be met, or ''; facts : of `of_run`."""
    answer, reasons = facts["answer"], []
    counts = answer["cases"] or {}
    if counts.get("exceeded"):
        exceeding = [design for design in answer["designs"] if design["verdict"] == "exceeds"]
        worst = f" (worst: {wording.short_id(exceeding[-1]['worst'])})" if exceeding else ""
        verb = "exceeds" if counts["exceeded"] == 1 else "exceed"
        reasons.append(f"{wording.count_text(counts['exceeded'], 'case')} {verb} a limit{worst}")
    if counts.get("undecided"):
        undecided = wording.count_text(counts["undecided"], "case")
        reasons.append(f"{undecided} undecided: failed, not run, or without figure")
    missing = [search.missing_answer(answer) for search in SEARCHES if search.name == answer["question"]]
    return "; ".join([*reasons, *filter(None, missing)])


def _probability(answer: Mapping[str, Any]) -> tuple[float, float, float] | None:
    """Return the probability of exceeding a limit, with its interval; None if the cases are not one random sample."""
    share = answer["designs"][0].get("share") if answer["question"] == "sample" and answer["designs"] else None
    if share is None or share["low"] is None:
        return None
    draws = answer["designs"][0]["conditions"]
    return binomial_interval(round(share["exceeded"] * draws), draws)


def _limit_labels(layout: Layout, limits: Iterable[Limit], units: Mapping[str, str]) -> dict[str, str]:
    """Return the limits on each column in words; units : column -> SI unit."""
    texts: dict[str, list[str]] = {}
    for limit in limits:
        texts.setdefault(limit.column, []).append(limit_label(layout, limit, units.get(limit.column, "1")))
    return {column: " and ".join(limit_texts) for column, limit_texts in texts.items()}


def expected_lines(facts: dict[str, Any]) -> list[str]:
    """Return the line on the largest force peak to expect in many revolutions."""
    peak = facts["expected"]
    if not peak:
        return []
    has_many_axes = len(peak["swept"]) > MANY_AXES
    setting = f"case {wording.short_id(peak['case_id'])}" if has_many_axes else setting_text(peak["swept"], facts)
    where = f" in {wording.joint_name(peak['joint'])}" + (f" at {setting}" if setting else "")
    return ["", expected_peak_sentence([grid_text(peak[key], "N") for key in ("value", "high", "seen")], where)]


def run_text(facts: dict[str, Any]) -> str:
    """Return the facts of a run as text lines."""
    remaining = f", {facts['missing']:,} left" if facts["missing"] else ""
    first_line = f"{cases(facts['ran'])} ran in {wording.duration_text(facts['seconds'])} ({facts['reused']:,} reused)"
    if facts["joined"]:
        duration = wording.duration_text(facts["seconds"])
        first_line = f"{cases(facts['reused'])} of {facts['joined']} directories merged in {duration}"
    lines = [f"{first_line}: {facts['ok']:,} ok, {facts['failed']:,} failed{remaining}"]
    if facts["others"]:
        lines.append(
            f"{cases(facts['others'])} with other values on the axes stay stored and are not in summary.parquet; "
            f"a grid with these values reuses them; `clearsweep report {facts['directory']} --all` shows all"
        )
    lines += derived_lines(facts["derived"], DERIVED)
    if facts["failures"]:
        counts = (f"{count:,} {status}" for status, count in facts["statuses"].items() if status != "ok")
        lines += ["", f"Failed cases: {', '.join(counts)}"]
        for entry in facts["failures"]:
            case = f"{wording.short_id(entry['case_id'])}  {setting_text(entry['swept'], facts)}"
            lines.append(f"  {case}: {entry['status']}: {entry['message']}")
        lines += ["  --retry-failed runs them again"]
    if facts["worst"]:
        lines += ["", *_worst_lines(facts)]
    lines += expected_lines(facts)
    searches = (search for search in SEARCHES if facts.get(search.answer_key))
    lines += [line for search in searches for line in search.lines(facts[search.answer_key])]
    lines += ["", *(f"Note: {sentence}" for sentence in facts["warnings"])] if facts["warnings"] else []
    sentences = facts["answer"]["sentences"]
    lines += ["", "Answer", *(f"  {sentence}" for sentence in sentences)] if sentences else []
    directory = facts["directory"]
    lines += ["", f"Results in {directory}: {', '.join(facts['files'])}", f"Next: clearsweep report {directory}"]
    return plain("\n".join(lines))


def derived_lines(derived: dict[str, dict[str, Any]], max_lines: int | None = None) -> list[str]:
    """Return at most `max_lines` lines: one for each derived value with its range, or for both clearances of a fit.

    Joints with the same value share a line.
    """
    joints_by_value: dict[tuple[str, str], list[str]] = {}
    for name, value in derived.items():
        diametral, scatter = name.replace(RADIAL, DIAMETRAL), name.removesuffix(")") + SCATTER
        if name.endswith(DIAMETRAL) and name.replace(DIAMETRAL, RADIAL) in derived:
            continue
        if name.endswith(SCATTER) and name.replace(SCATTER, ")") in derived:
            continue
        text = f"{_range(value)} ({_range(derived[scatter])})" if scatter in derived else _range(value)
        if name.endswith(RADIAL) and diametral in derived:
            text = f"{_range(value)} radial, {_range(derived[diametral])} diametral"
        of_joint = re.fullmatch(r"joints\.([^.]+)\.(.+)", name.replace(RADIAL, ")"))
        joint, key = of_joint.groups() if of_joint else ("", name)
        joints_by_value.setdefault((key, text), []).append(joint)
    lines = []
    for (key, text), joints in joints_by_value.items():
        place = f"joints.{joints[0]}.{key}" if joints[0] else key
        lines.append(f"derived: {f'{key} of {wording.sentence_list(joints)}' if joints[1:] else place} = {text}")
    if max_lines is not None and len(lines) > max_lines:
        lines[max_lines - 1 :] = [f"derived: {len(lines) - max_lines + 1} more values, which run --dry-run lists"]
    return lines


def _range(value: dict[str, Any]) -> str:
    """Return a derived value, or its range, in words."""
    ends = [value["min"], value["max"]]
    low, high = grid_texts(ends, value["unit"]) if 0.0 in ends else (grid_text(end, value["unit"]) for end in ends)
    return low + (f" to {high}" if high != low else "")


def estimate_text(facts: dict[str, Any]) -> str:
    """Return the facts of a dry run as text lines."""
    lines = [
        f"{cases(facts['cases'])} to run; a run reuses those that its directory has",
        *derived_lines(facts["derived"]),
        *(f"no unit given, SI assumed: {path} = {text}" for path, text in assumed_texts(facts["assumed"]).items()),
        *(
            f"define: {name}{' = ' * bool(each['expression'])}{each['expression']} = "
            f"{grid_text(each['value'], each['unit'])}"
            for name, each in facts["defined"].items()
        ),
        *case_lines(facts["case"]),
        *facts["recommended"],
    ]
    if facts["seconds"] is None:
        lines.append("time: unknown; the first case gave no estimate")
    else:
        spread, timed = "", f"{cases(facts['timed'])} timed"
        if facts["give_or_take"] > 0.1 * facts["seconds"]:
            spread = f", give or take {wording.duration_text(facts['give_or_take'])}"
        if facts["extrapolated"]:
            timed += f", {facts['extrapolated']:,} of them extrapolated from its beginning"
        each, longest = (grid_text(facts[name], "s") for name in ("case_seconds", "longest"))
        duration = wording.duration_text(facts["seconds"])
        lines.append(f"time: about {duration}{spread} ({timed}, {each} each, the longest {longest})")
    lines.append(f"storage: about {wording.bytes_text(facts['bytes'])}")
    lines += [f"Note: {sentence}" for sentence in facts["warnings"]]
    return plain("\n".join(lines))


def case_lines(case: dict[str, Any]) -> list[str]:
    """Return the values of a case: a line for each section, then a line for each column of a table."""
    sections: dict[tuple[str, bool], list[str]] = {}  # section and whether it is a list
    columns: dict[str, list[float]] = {}
    for path, value in case["values"].items():
        section, _, key = path.rpartition(".")
        if ".table." in path:
            columns.setdefault(section, []).append(value)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        unit = case["units"].get(path, "1")
        text = varied_text(path, value, unit, case["written_units"], MIN_DIGITS) if number else str(value)
        sections.setdefault((section, key.isdigit()), []).append(text if key.isdigit() else f"{key} {text}")
    lines = [
        f"  {section}: {('[{}]' if is_list else '{}').format(', '.join(texts))}"
        for (section, is_list), texts in sections.items()
        if section not in columns
    ]
    lines += [f"  {path}: {len(row)} values in SI, {min(row):.4g} to {max(row):.4g}" for path, row in columns.items()]
    return [f"the first case ({wording.short_id(case['case_id'])}), with every default:", *lines]


def cases(count: int) -> str:
    """Return '1 case' or '1,200 cases'."""
    return f"{count:,} case" + "s" * (count != 1)


def plain(text: str) -> str:
    """Return a text with ordinary spaces, at which a terminal can break lines."""
    return text.replace("\u00a0", " ").replace("\u202f", " ")


def _worst_lines(facts: dict[str, Any]) -> list[str]:
    """Return the summary table under its title, which names the swept values that all of its cases share.

    If there are many swept paths, only those whose values differ have a column.
    """
    entries, ranked = facts["worst"], facts["ranked"]
    first, settings = entries[0]["swept"], [entry["swept"] for entry in entries]
    paths = [path for path in first if len(first) <= MANY_AXES or len({row[path] for row in settings}) > 1]
    shared = setting_text({path: value for path, value in first.items() if path not in paths}, facts)
    varied = wording.of_joints(
        (setting_name(path, paths, facts), tuple(value_text(path, row[path], facts) for row in settings))
        for path in paths
    )
    columns = [["case_id", *(wording.short_id(entry["case_id"]) for entry in entries)]]
    columns += [[f"{name}{joints}", *values] for name, joints, values in varied]
    if facts["question"] in ("life", "film", "force"):
        columns.append(["joint", *(wording.joint_name(entry["joint"]) for entry in entries)])
    figures = zip(*(entry["figures"] for entry in entries), strict=True)
    columns += [
        [heading, *figure_texts([*column], ranked["units"])]
        for heading, column in zip(ranked["headings"], figures, strict=True)
    ]
    widths = [max(map(len, column)) for column in columns]
    title = ranked["title"] + (f", all with {shared}" if shared else "")
    return [
        title,
        *(
            "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in zip(*columns, strict=True)
        ),
    ]


def figure_texts(column: list[dict[str, Any]], units: Mapping[str, str]) -> list[str]:
    """Return the figures of a column of the table, in words; those of one quantity have the unit of the largest."""
    texts = [_figure(figure) for figure in column]
    numbers: dict[str, list[int]] = {}
    for index, (figure, text) in enumerate(zip(column, texts, strict=True)):
        if text is None:
            numbers.setdefault(units.get(figure["column"], "1"), []).append(index)
    for unit, indices in numbers.items():
        name, values = column[indices[0]]["column"], [column[index]["value"] for index in indices]
        typical = TYPICAL_VELOCITY if name.endswith("velocity_rms") else None  # as in the sentences
        for index, text in zip(indices, grid_texts(values, unit, speed="speed" in name, typical=typical), strict=True):
            texts[index] = text
    return [str(text) for text in texts]


def _figure(figure: dict[str, Any]) -> str | None:
    """Return a figure in words, shares in per cent, lives in hours; None for a number with a unit of its column."""
    name, value = figure["column"], figure["value"]
    if value is None and name.endswith("_dry_load_share"):
        return dry_share_text(float("nan"))
    if value is None and name == START_UP:
        return "cut off"
    if value is None or "words" in figure:
        return str(figure.get("words", "-"))
    if name.endswith("_life_hours"):
        return f"{value:.4g} h"
    if name.endswith("_dry_load_share"):
        return dry_share_text(value)
    return None
