"""The closing table of a run: worst cases, failures, files."""

from collections.abc import Mapping
from typing import Any

from ..judging import expected, order, probability
from ..language import wording
from . import identified
from .law_checks import law_lines
from .lives import life_lines
from .pace import pace_lines
from .run_facts import RunFacts
from .searched import optimise_lines, optimised, refine_lines, seek_facts, seek_lines
from .settings import given_text, grid_text, number_of_joints, setting_text, value_text
from .sweep import RunResult

DERIVED = 12  # lines on derived values at the end of a run
RADIAL, DIAMETRAL, SCATTER = ", radial)", ", diametral)", ", range)"  # ends of names of values that share a line
MANY_AXES = 4  # swept paths above which the closing table leaves out columns with one value


def of_run(result: RunResult) -> dict[str, Any]:
    """Return the facts that `run` reports of a RunResult, for JSON: counts, files, worst cases, failures; in SI."""
    run = result.open()
    seen = RunFacts(run.grid, run.layout)
    seen.read(run)
    limits, lead = seen.limits, seen.lead
    return {
        "directory": str(result.directory),
        "cases": result.cases,
        "ran": result.ran,
        "reused": result.reused,
        "ok": result.ok,
        "failed": result.failed,
        "missing": result.missing,
        "others": result.others,
        "statuses": dict(seen.statuses),
        "joined": result.joined,
        "seconds": round(result.seconds, 3),
        "case_seconds": round(result.case_seconds, 3),
        "derived": result.derived,
        "warnings": [*result.warnings, *seen.remarks.sentences()],
        "units": run.grid.get("units", {}),
        "written_units": run.grid.get("written_units", {}),
        "limits": limits.facts(),
        "probability": _probability(result, run.grid, limits.facts()),
        "life": seen.lives.facts(),
        "slowest": seen.pace.slowest,
        "seek": seek_facts(result, run.grid),
        "optimised": optimised(result, limits.units, limits.verdict.limits),
        "identified": result.identified and identified.of_run(result.identified),
        "refined": result.refined and result.refined._asdict(),
        "fits": run.grid.get("fits", {}),
        "labels": run.grid.get("labels", {}),
        "question": lead.question,
        "ranked": {"title": lead.title, "headings": list(lead.headings), "units": limits.units},
        "no_limits": order.no_limits(run.layout) if lead.question in ("film", "force") else "",
        "worst": seen.worst.entries,
        "expected": seen.expected,
        "law_check": seen.laws.facts(next(iter(seen.worst.entries), None)),
        "failures": seen.failures,
        "files": {name: str(result.directory / name) for name in run.files},
    }


def _probability(
    result: RunResult, record: Mapping[str, Any], kept: dict[str, Any] | None
) -> tuple[float, float, float] | None:
    """Return how probable it is that a limit is exceeded, with its interval; None if the cases are no one sample."""
    if not kept or not kept["cases"] or result.failed or not probability.is_one_sample(record):
        return None
    return probability.share(kept["exceeding"], kept["cases"])


def _limit_lines(facts: dict[str, Any]) -> list[str]:
    """Return the lines on limits."""
    kept = facts["limits"]
    if not kept:
        return []
    failed = f"; {cases(facts['failed'])} failed and have no figures" if facts["failed"] else ""
    lines = ["", f"Limits: {kept['exceeding']:,} of {cases(kept['cases'])} exceed at least one{failed}"]
    lines += [f"  {probability.sentence(facts['probability'])}"] if facts["probability"] else []
    for name, each in kept["each"].items():
        doubt = f" ({each['unknown']:,} of them cannot be assessed: null)" if each["unknown"] else ""
        lines.append(f"  {name} {each['limit']}: {each['cases']:,} exceed it{doubt}")
    if kept["unknown"]:
        lines.append(
            f"  {cases(kept['unknown'])} cannot be assessed, as a limited figure is null (infinite, 0/0 or not "
            "computed); they count as exceeding it and have no margin"
        )
    if kept["worst"]:
        setting = setting_text(kept["worst"]["swept"], facts)
        lines.append(
            f"  smallest margin: {kept['worst']['margin_words']}, case {wording.short_id(kept['worst']['case_id'])}"
            + (f", {setting}" if setting else "")
        )
    return lines


def _expected_lines(facts: dict[str, Any]) -> list[str]:
    """Return the line on the largest force peak to expect in many revolutions."""
    known = facts["expected"]
    if not known:
        return []
    many = len(known["swept"]) > MANY_AXES
    setting = f"case {wording.short_id(known['case_id'])}" if many else setting_text(known["swept"], facts)
    where = f" in {wording.joint_name(known['joint'])}" + (f" at {setting}" if setting else "")
    return ["", expected.sentence([grid_text(known[end], "N") for end in ("value", "high", "seen")], where)]


def run_text(facts: dict[str, Any]) -> str:
    """Return the facts of a run as text lines."""
    left = f", {facts['missing']:,} left" if facts["missing"] else ""
    done = f"{cases(facts['ran'])} ran in {wording.duration(facts['seconds'])} ({facts['reused']:,} reused)"
    if facts["joined"]:
        done = (
            f"{cases(facts['reused'])} of {facts['joined']} directories merged in {wording.duration(facts['seconds'])}"
        )
    lines = [f"{done}: {facts['ok']:,} ok, {facts['failed']:,} failed{left}", *pace_lines(facts["slowest"])]
    if facts["others"]:
        lines.append(
            f"{cases(facts['others'])} with other values on the axes stay stored and are not in summary.parquet; "
            f"a grid with these values reuses them; `clearsweep report {facts['directory']} --all` shows all"
        )
    lines += derived_lines(facts["derived"], DERIVED)
    lines += ["", *(f"Note: {sentence}" for sentence in facts["warnings"])] if facts["warnings"] else []
    if facts["failures"]:
        lines += [
            "",
            "Failed cases: "
            + ", ".join(f"{count:,} {status}" for status, count in facts["statuses"].items() if status != "ok"),
        ]
        lines += [
            f"  {wording.short_id(entry['case_id'])}  {setting_text(entry['swept'], facts)}: {entry['status']}: "
            f"{entry['message']}"
            for entry in facts["failures"]
        ]
        lines += ["  --retry-failed runs them again"]
    if facts["worst"]:
        lines += ["", facts["ranked"]["title"] + _shared(facts), *_aligned(_worst_rows(facts))]
    lines += _expected_lines(facts)
    lines += life_lines(facts["life"], lambda point: setting_text(point, facts))
    lines += seek_lines(facts)
    lines += optimise_lines(facts)
    lines += identified.identify_lines(facts)
    lines += _limit_lines(facts)
    lines += refine_lines(facts)
    lines += law_lines(facts["law_check"], facts["ranked"]["units"])
    lines += ["", facts["no_limits"]] if facts["no_limits"] and facts["ok"] else []
    lines += [
        "",
        f"Results in {facts['directory']}: {', '.join(facts['files'])}",
        f"Next: clearsweep report {facts['directory']}",
    ]
    return plain("\n".join(lines))


def derived_lines(derived: dict[str, dict[str, Any]], most: int | None = None) -> list[str]:
    """Return a line for each derived value with its range, or for both clearances of a fit; at most `most` lines."""
    lines = []
    for name, value in derived.items():
        across, scatter = name.replace(RADIAL, DIAMETRAL), name.removesuffix(")") + SCATTER
        if name.endswith(DIAMETRAL) and name.replace(DIAMETRAL, RADIAL) in derived:
            continue
        if name.endswith(SCATTER) and name.replace(SCATTER, ")") in derived:
            continue
        if name.endswith(RADIAL) and across in derived:
            both = f"{_range(value)} radial, {_range(derived[across])} diametral"
            lines.append(f"derived: {name.removesuffix(RADIAL)}) = {both}")
        else:
            spread = f" ({_range(derived[scatter])})" if scatter in derived else ""
            lines.append(f"derived: {name} = {_range(value)}{spread}")
    if most is not None and len(lines) > most:
        lines[most - 1 :] = [f"derived: {len(lines) - most + 1} more values, which run --dry-run lists"]
    return lines


def _range(value: dict[str, Any]) -> str:
    """Return a derived value, or its range, in words."""
    low, high = (grid_text(value[end], value["unit"]) for end in ("min", "max"))
    return low + (f" to {high}" if high != low else "")


def estimate_text(facts: dict[str, Any]) -> str:
    """Return the facts of a dry run as text lines."""
    lines = [
        f"{cases(facts['cases'])}, {facts['cases'] - facts['pending']:,} of them stored already, "
        f"{facts['pending']:,} to run",
        *derived_lines(facts["derived"]),
        *_assumed_lines(facts["assumed"]),
        *_defined_lines(facts["defined"]),
        *_case_lines(facts["case"]),
        *facts["recommended"],
    ]
    if facts["seconds"] is None:
        lines.append("time: unknown; the first case gave no estimate")
    elif facts["pending"]:
        spread = facts["give_or_take"] > 0.1 * facts["seconds"]
        beginning = (
            f", {facts['extrapolated']:,} of them extrapolated from its beginning" if facts["extrapolated"] else ""
        )
        lines.append(
            f"time: about {wording.duration(facts['seconds'])}"
            + (f", give or take {wording.duration(facts['give_or_take'])}" if spread else "")
            + f" ({cases(facts['timed'])} timed{beginning}, {grid_text(facts['case_seconds'], 's')} each, the longest "
            f"{grid_text(facts['longest'], 's')})"
        )
    if facts["pending"]:
        lines.append(f"storage: about {wording.size(facts['bytes'])}")
    lines += [f"Note: {sentence}" for sentence in facts["warnings"]]
    return plain("\n".join(lines))


def _assumed_lines(assumed_units: dict[str, dict[str, Any]]) -> list[str]:
    """Return a line for each quantity written without a unit."""
    lines = []
    for path, each in assumed_units.items():
        values = " to ".join(f"{value:.6g}" for value in each["values"])
        known = " to ".join(grid_text(value, each["unit"], speed=path.endswith("speed")) for value in each["values"])
        same = known == f"{values} {each['unit']}"
        lines.append(f"no unit given, SI assumed: {path} = {values} {each['unit']}{'' if same else f' = {known}'}")
    return lines


def _defined_lines(defined: dict[str, dict[str, Any]]) -> list[str]:
    """Return a line for each user-defined quantity."""
    lines = []
    for name, each in defined.items():
        own = f" = {each['expression']}" if each["expression"] else ""
        lines.append(f"define: {name}{own} = {grid_text(each['value'], each['unit'])}")
    return lines


def _case_lines(case: dict[str, Any]) -> list[str]:
    """Return the values of a case: a line for each section, then a line for each column of a table."""
    sections: dict[str, list[str]] = {}
    rows: dict[str, list[float]] = {}
    for path, value in case["values"].items():
        section, _, key = path.rpartition(".")
        if ".table." in path:
            rows.setdefault(section, []).append(value)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        text = given_text(path, value, case["units"].get(path, "1"), case["written_units"]) if number else str(value)
        sections.setdefault(section, []).append(f"{key} {text}")
    lines = [f"  {section}: {', '.join(texts)}" for section, texts in sections.items() if section not in rows]
    lines += [f"  {path}: {len(row)} values in SI, {min(row):.4g} to {max(row):.4g}" for path, row in rows.items()]
    return [f"the first case ({wording.short_id(case['case_id'])}), with every default:", *lines]


def cases(count: int) -> str:
    """Return '1 case' or '1,200 cases'."""
    return f"{count:,} case" + "s" * (count != 1)


def plain(text: str) -> str:
    """Return a text with ordinary spaces, at which a terminal can break lines."""
    return text.replace("\u00a0", " ").replace("\u2009", " ")


def _listed_paths(facts: dict[str, Any]) -> list[str]:
    """Return the swept paths with a column in the closing table; of many, those whose values differ there."""
    rows = [entry["swept"] for entry in facts["worst"]]
    return [path for path in rows[0] if len(rows[0]) <= MANY_AXES or len({row[path] for row in rows}) > 1]


def _shared(facts: dict[str, Any]) -> str:
    """Return the swept values that all cases of the closing table share and that have no column there."""
    listed = _listed_paths(facts)
    same = {path: value for path, value in facts["worst"][0]["swept"].items() if path not in listed}
    setting = setting_text(same, facts)
    return f", all with {setting}" if setting else ""


def _worst_rows(facts: dict[str, Any]) -> list[list[str]]:
    paths = _listed_paths(facts)
    of_joint = facts["question"] in ("life", "film", "force")
    head = ["case_id", *(wording.axis_name(path, number_of_joints(paths)) for path in paths)]
    rows = [[*head, *(["joint"] if of_joint else []), *facts["ranked"]["headings"]]]
    for entry in facts["worst"]:
        rows.append(
            [
                wording.short_id(entry["case_id"]),
                *(value_text(path, entry["swept"][path], facts) for path in paths),
                *([wording.joint_name(entry["joint"])] if of_joint else []),
                *(_figure(figure, facts["ranked"]["units"]) for figure in entry["figures"]),
            ]
        )
    return rows


def _figure(figure: dict[str, Any], units: Mapping[str, str]) -> str:
    """Return a figure with its unit, shares in per cent, lives in hours."""
    name, value = figure["column"], figure["value"]
    if value is None or "words" in figure:
        return str(figure.get("words", "-"))
    if name.endswith("_life_hours"):
        return f"{value:.4g} h"
    if name.endswith("_dry_load_share"):
        return f"{100.0 * value:.3g} %"
    return grid_text(value, units.get(name, "1"))


def _aligned(rows: list[list[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
