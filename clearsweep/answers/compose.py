"""Composes the answer of a run: the judged cases, the figures that lead its question, and the sentences on both."""

import functools
import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts import catalogue
from ..contracts.case import value_at
from ..contracts.layout import Column, Layout
from ..contracts.vibration import IDEAL, NO_SEVERITY, SEVERITIES, zone_of
from ..language import wording
from ..language.wording import is_missing
from . import questions
from .figure_sentences import coexisting
from .judge import NOT_RUN, answer_on
from .judged import EXCEEDED, MET, ONE_AT_A_TIME, UNDECIDED, Cases, named_value
from .ranking import SEARCHES, START_UP, ranking_of
from .sentences import sentences
from .verdict import limits_and_figures_of
from .words import FIELD_BY_COLUMN, Words, coverage_text, interval_text, read_lifetime, spread_text

MAX_UNRUN = 100_000  # cases of a grid up to which those that were not run are listed
KEPT = 2  # columns in memory, 8 bytes a case each; to read one again takes 0.4 ms, of a hundred thousand cases 3 ms
MAX_SETTINGS = 50  # designs whose worst case has its values in the answer
#: Question -> figures of a joint or of the mechanism whose effects are listed.
LEADING = {
    "life": ("life_hours",),
    "start-up": ("start_up_time",),
    "film": ("film_thickness_min",),
    "force": ("force_peak", "error_max"),
}
#: Figures whose extremes are in the answer.
EXTREMES = (
    "force_peak",
    "error_max",
    "film_thickness_min",
    "film_loss",
    "life_hours",
    "wear_rate_max",
    "start_up_time",
    "velocity_rms",
)

NOTED_INDENTATION = 0.1  # of an output error: less is not mentioned
UNLIKE_SHARES = 0.1  # difference of the shares of penetration of two joints, beyond which no share is given

Reader = Callable[[str], np.ndarray]


class Source(NamedTuple):
    """What an answer is made of."""

    record: Mapping[str, Any]  # run.json
    layout: Layout
    read: Reader  # returns a column of all stored cases, (n,): numbers, texts as objects, identities as bytes
    base_laws: Mapping[str, str] = {}  # path of a law that `check_laws` varies -> the law of the grid
    complete: bool = True
    search: Sequence[Mapping[str, Any]] = ()  # rows of the table of a search
    counts: Mapping[str, int] | None = None  # of verdicts, where `read` gives a part of the cases: no design is judged
    worn_body: Callable[[str], str] = lambda case_id: ""  # returns which body limits the life of a case, in words


class _Columns:
    """Columns by name, of which few are in memory."""

    def __init__(self, read: Reader, names: set[str]):
        self._read, self.names = functools.lru_cache(KEPT)(read), names

    def __contains__(self, name: str) -> bool:
        return name in self.names

    def __getitem__(self, name: str) -> np.ndarray:
        return self._read(name)


def compose(source: Source) -> dict[str, Any]:
    """Return the answer of a run, with its sentences."""
    record, layout = source.record, source.layout
    names = {column.name for column in layout.columns} | {
        *record["units"],
        "case_id",
        "status",
        *record.get("case_labels", []),
    }
    columns: Any = _Columns(source.read, names | {*(record.get("figures") or {})})
    own = own_cases(record, columns, source.base_laws)
    counts = source.counts
    if not source.complete and counts is None and not any(record.get(section) for section in SEARCHES):
        factors = _grid_factors(record)
        if math.prod(map(len, factors)) > MAX_UNRUN:
            counts = _counts_of_part(record, columns, own) if record.get("limits") else None
        else:
            points = [{path: part[path] for part in parts for path in part} for parts in itertools.product(*factors)]
            columns, own = _with_unrun(points, record, columns, own)
    is_part = counts is not None
    cases = Cases({**record, "limits": {}} if is_part else record, columns, own)
    question = question_of(record, layout, cases.paths)
    figures = [] if is_part else _figures(question, cases, layout)
    answer: dict[str, Any] = {
        "question": question,
        "complete": source.complete,
        **answer_on(cases, figures),
        "search": [dict(row) for row in source.search],
        "sentences": [],
    }
    answer |= {"cases": dict(counts)} if counts and record.get("limits") else {}
    answer |= _details(source, cases, columns, answer)
    is_ok = columns["status"] == "ok"
    words = Words(record, layout, lambda name: columns[name][is_ok])
    if check := _law_check(source, columns, is_ok & ~own, answer, words):
        answer["laws"] = check
    if coverage := coverage_text(record, answer):
        answer["fits"] = coverage
    answer["sentences"] = sentences(answer, words)
    return answer


def question_of(record: Mapping[str, Any], layout: Layout, paths: Sequence[str]) -> str:
    """Return the leading question of a grid; paths : those that vary."""
    question = ranking_of(layout, limits_and_figures_of(record).limits, record).question
    if question in ("life", *SEARCHES):
        return question
    sample = record.get("sample") or {}
    if sample.get("method", ONE_AT_A_TIME) != ONE_AT_A_TIME and set(paths) <= set(sample["drawn"]):
        return "sample"
    return "refine" if record.get("refine") else question


def own_cases(record: Mapping[str, Any], columns: Any, base_laws: Mapping[str, str]) -> np.ndarray:
    """Return a mask of the grid's own cases; all others were added by a search or by check_laws."""
    count = len(columns["status"])
    if any(record.get(section) for section in SEARCHES):
        return np.zeros(count, bool)
    is_own = np.ones(count, bool)
    for path, law in base_laws.items():
        is_own &= np.array([is_missing(value) or value == law for value in columns[path].tolist()], bool)
    for section in record.values():
        if isinstance(section, Mapping) and isinstance(added := section.get("added"), Mapping) and added:
            points = set(_points(added.values()))
            is_own &= np.array([point not in points for point in _points(columns[path].tolist() for path in added)])
    return is_own


def _grid_factors(record: Mapping[str, Any]) -> list[list[dict[str, Any]]]:
    """Return the axes of a grid, whose product has a point for each of its own cases."""
    sections = [{path: values} for path, values in (record.get("sweep") or {}).items()]
    sections += [record.get("zip") or {}, record.get("cases") or {}, (record.get("sample") or {}).get("drawn") or {}]
    return [
        [dict(zip(part, row, strict=True)) for row in zip(*part.values(), strict=True)] for part in sections if part
    ]


def _counts_of_part(record: Mapping[str, Any], columns: Any, own: np.ndarray) -> dict[str, int]:
    """Return the number of cases of each verdict in a part of a grid too large to list; those not run are undecided."""
    verdicts = Cases(record, columns, own).verdicts
    counts = {name: int((verdicts == name).sum()) for name in (MET, EXCEEDED)}
    undecided = math.prod(map(len, _grid_factors(record))) - sum(counts.values())
    return counts | {"undecided": undecided, "added": int((~own).sum())}


def _with_unrun(
    points: Sequence[Mapping[str, Any]], record: Mapping[str, Any], columns: Any, own: np.ndarray
) -> tuple[Any, np.ndarray]:
    """Return the columns and the mask of own cases with a row for each point of the grid that was not run."""
    paths = list(record["units"])
    stored = _points(columns[path].tolist() for path in paths)
    exact, partial = set(stored), [row for row in stored if None in row]
    keys = [tuple(point.get(path) for path in paths) for point in points]
    unrun = [
        key
        for key in keys
        if key not in exact and not any(all(a in (None, b) for a, b in zip(row, key, strict=True)) for row in partial)
    ]

    def read(name: str) -> np.ndarray:
        values = columns[name]
        if name in paths:
            added: list[Any] = [key[paths.index(name)] for key in unrun]
        else:
            added = [{"case_id": "", "status": NOT_RUN}.get(name)] * len(unrun)
        if values.dtype.kind in "OS":
            return np.concatenate([values, np.array([*added, None], object)[:-1].astype(values.dtype)])
        return np.concatenate([values, np.array([np.nan if value is None else value for value in added], float)])

    return _Columns(read, {*columns.names}), np.append(own, np.ones(len(unrun), bool))


def _points(columns: Iterable[Sequence[Any]]) -> list[tuple]:
    """Return the rows of some columns; None for null."""
    return [tuple(None if is_missing(value) else value for value in row) for row in zip(*columns, strict=True)]


def _figures(question: str, cases: Cases, layout: Layout) -> list[str]:
    """Return the columns whose effects are listed."""
    limited = [limit.column for limit in cases.limits]
    leading: list[str] = []
    for figure in LEADING.get(question, () if limited else LEADING["force"]):
        candidates = [column.name for column in layout.columns if column.figure == figure]
        sign = -1.0 if figure in ("life_hours", "film_thickness_min") else 1.0  # their smallest value is the worst
        known = ((name, sign * cases.numbers(name)) for name in candidates)
        worst = {name: float(np.nanmax(values)) for name, values in known if np.isfinite(values).any()}
        leading += [max(worst, key=worst.__getitem__)] if worst else []
    return list(dict.fromkeys([*leading, *limited, *(cases.record.get("figures") or {})]))


def _details(source: Source, cases: Cases, columns: Any, answer: Mapping[str, Any]) -> dict[str, Any]:
    """Return further parts of the answer: ends of axes, extremes of figures, and what its question asks for."""
    record = source.record
    details: dict[str, Any] = {"ends": {}, "order": {}, "finished": int(cases.is_finished.sum())}
    for path, (levels, _) in cases.codes.items():
        if not any(isinstance(level, str) for level in levels) and levels:
            named = [named_value(record, path, level) for level in levels]
            details["ends"][path] = [named[0], named[-1]]
            if isinstance(named[0], str):
                details["order"][path] = named
    own_figures: list[Any] = [
        Column(name, "", "") for name, text in (record.get("figures") or {}).items() if isinstance(text, str)
    ]
    details["extremes"] = [
        entry
        for column in [*source.layout.columns, *own_figures]
        if column.figure in EXTREMES or not column.figure
        if (entry := _extremes(source, cases, column))
    ]
    worst = [design["worst"] for design in answer["designs"][:MAX_SETTINGS] if design["worst"]]
    details["settings"] = _settings(cases, worst)
    counted = f"{source.layout.life}_life_hours" if answer["question"] == "life" else START_UP
    if counted in columns and answer["question"] in ("life", "start-up"):
        details["unreached"] = int(np.isnan(cases.numbers(counted)[cases.is_finished]).sum())
        details["unlimited"] = int(np.isinf(cases.numbers(counted)).sum())
    if answer["question"] == "film" and (film := questions.film_answer(record, source.layout, cases)):
        details["film"] = film
    if answer["cases"] and answer["cases"]["added"]:
        all_cases = Cases(record, columns)
        details["all_cases"] = {name: int((all_cases.verdicts == name).sum()) for name in (MET, EXCEEDED, UNDECIDED)}
    if answer["question"] == "seek":
        details["nearest"] = _nearest(record, columns, answer["search"])
    if branches := coexisting(cases, source.layout):
        details["branches"] = branches
    if answer["question"] == "sample":
        details["irregular"] = _irregular(cases)
    details["tried"] = len(columns["status"])
    if answer["question"] == "optimise" and cases.limits and answer["search"]:
        all_cases = Cases(record, columns)
        of_case = dict(zip(all_cases.values("case_id").astype(str).tolist(), all_cases.verdicts.tolist(), strict=True))
        details["best_met"] = of_case.get(answer["search"][0]["case_id"]) == MET
    if not cases.limits and answer["question"] in LEADING:
        details["suggestion"] = _suggested_limit(source, cases, answer["question"], details["extremes"])
    if answer["question"] == "identify":
        details["identified"] = identified_parameters(record)
        details["explained"] = bool((record.get("identified") or {}).get("explained", True))
    return details


def _irregular(cases: Cases) -> int:
    """Return how many finished motions are not periodic, where a limit on peaks depends on the length of a run."""
    columns = {column["name"] for column in cases.record["layout"]["columns"]}
    limits_peaks = any(limit.column.endswith(("_peak", "_max", "_ratio")) for limit in cases.limits)
    if "period" not in columns or not limits_peaks:
        return 0
    return int(np.isnan(cases.numbers("period")[cases.is_finished]).sum())


def _suggested_limit(source: Source, cases: Cases, question: str, extremes: Sequence[Mapping[str, Any]]) -> str:
    """Return a limit to add to a grid without limits, as text of the grid; '' without a figure to limit."""
    figures = {column.name: column for column in source.layout.columns}
    leading = LEADING[question][0]
    known = [entry for entry in extremes if entry["figure"] in figures and figures[entry["figure"]].figure == leading]
    if question == "life" or not known:
        return ""
    if question == "start-up":
        return f"{START_UP}: 1 s"
    if question == "film":
        column = min(known, key=lambda entry: float(entry["smallest"]["value"]))["figure"]
        joint = figures[column].joint
        finished = questions.FinishedCases(source.record, source.layout, tuple(cases.codes), cases.values)
        required = questions.required_thickness(finished, joint)
        least = questions.law_end_thickness(finished, joint) if required is None else float(required.max())
        return f"{column}: {{at_least: {math.ceil(1e8 * least) / 100:g} um}}" if least else ""
    column = max(known, key=lambda entry: float(entry["largest"]["value"]))["figure"]
    ideal = f"{column}_ideal"
    has_ideal = ideal in figures and bool((cases.numbers(ideal) > 0.0).any())
    example = "5 kN" if figures[column].unit == "N" else "5 N*m"
    return f"{column}: " + (f"{{at_most: 3, times: {ideal}}}" if has_ideal else example)


def identified_parameters(record: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the identified parameters with a remark on how well the data determine each."""
    parameters = (record.get("identified") or {}).get("parameters") or []
    return [
        {
            "path": parameter["path"],
            "value": parameter["median"] if "median" in parameter else parameter["value"],
            "low": parameter["low"],
            "high": parameter["high"],
            "note": questions.certainty_text(parameter),
        }
        for parameter in parameters
    ]


def _extremes(source: Source, cases: Cases, column: Any) -> dict[str, Any] | None:
    """Return the smallest and the largest finite value of a figure with their cases; None if no case has one."""
    values = np.where(np.isinf(cases.numbers(column.name)), np.nan, cases.numbers(column.name))
    if not np.isfinite(values).any():
        return None
    ends = {"smallest": int(np.nanargmin(values)), "largest": int(np.nanargmax(values))}
    entry: dict[str, Any] = {"figure": column.name}
    for name, row in ends.items():
        entry[name] = {"value": float(values[row]), "case": cases.case_id(row), "values": _values_of(cases, row)}
        entry[name] |= _more(source, cases, column, row, name)
    return entry


def _more(source: Source, cases: Cases, column: Any, row: int, end: str) -> dict[str, Any]:
    """Return what belongs to one end of the extremes of a figure: ratio, intervals, hours."""
    names = {known.name for known in source.layout.columns}
    if column.figure == "force_peak" and (ratio := f"{column.joint}_force_peak_ratio") in names:
        value = float(cases.numbers(ratio)[row])
        return {"ratio": value} if np.isfinite(value) and value else {}
    if column.figure == "wear_rate_max" and end == "largest":
        clearance = _length(source, cases, f"joints.{wording.joint_name(column.joint)}.clearance", row)
        depth = 3.6e6 * float(cases.numbers(column.name)[row])
        return {"clearance_hours": 1000.0 * clearance / depth} if clearance and depth > clearance else {}
    if column.figure == "velocity_rms" and end == "largest":
        # Velocity of a place without clearance, if known, and the zones of both
        section = source.record.get("vibration") or {}
        bounds = tuple(section.get("zones") or SEVERITIES.get(section.get("severity", NO_SEVERITY), ()))
        ideal = float(cases.numbers(f"{column.name}{IDEAL}")[row])
        values: dict[str, Any] = {"ideal": ideal} if math.isfinite(ideal) else {}
        if bounds:
            values["zone"] = zone_of(float(cases.numbers(column.name)[row]), bounds)
            values |= {"ideal_zone": zone_of(ideal, bounds)} if "ideal" in values else {}
        return values
    if column.figure == "error_max" and end == "largest":
        error = unexplained = float(cases.numbers(column.name)[row])
        parts: dict[str, Any] = {}
        for part in ("bending", "mounts"):
            if (name := column.name.replace("error_max", f"error_{part}")) in names:
                share = min(float(np.nan_to_num(cases.numbers(name)[row])), unexplained)
                unexplained -= share
                parts |= {part: share} if share >= NOTED_INDENTATION * error > 0.0 else {}
        return _indentation_of(source, cases, unexplained, row) | parts
    if column.figure == "life_hours":
        fields = {name: f"{column.joint}_{name}" for name in FIELD_BY_COLUMN}
        life = read_lifetime(
            {name: float(cases.numbers(field)[row]) for name, field in fields.items() if field in names}
        )
        body = source.worn_body(cases.case_id(row))
        return {"interval": interval_text(life), "spread": spread_text(life), "body": body}
    return {}


def _indentation_of(source: Source, cases: Cases, error: float, row: int) -> dict[str, float]:
    """Return how much of an output error is indentation of the contacts, at most, or {} if little or unknown.

    The error is linear in the eccentricities of the joints, clearance plus penetration: where the penetration has the
    same share in all of them, it has that share of the error.  Joints that differ by UNLIKE_SHARES leave it unknown.
    """
    shares: list[float] = []
    for column in source.layout.columns:
        if column.figure == "penetration_max":
            clearance = _length(source, cases, f"joints.{wording.joint_name(column.joint)}.clearance", row)
            depth = float(cases.numbers(column.name)[row])
            if clearance is None or not np.isfinite(depth):
                return {}
            if any(joint.is_rolling and joint.name == column.joint for joint in source.layout.joints):
                clearance = max(0.5 * clearance, 0.0)
            shares.append(max(depth, 0.0) / max(clearance + depth, np.finfo(float).tiny))
    is_known = bool(shares) and max(shares) - min(shares) <= UNLIKE_SHARES
    return {"indentation": max(shares) * error} if is_known and max(shares) >= NOTED_INDENTATION else {}


def _length(source: Source, cases: Cases, path: str, row: int) -> float | None:
    """Return a length (m) of a case that varies or is fixed; None if it is not a number."""
    if path in cases.codes:
        return float(cases.numbers(path)[row])
    value = value_at(source.record, path)
    return value if isinstance(value, float) else None


def _values_of(cases: Cases, row: int) -> dict[str, Any]:
    """Return the varied values of a case in the form of the answer."""
    return cases.values_at([*cases.codes], tuple(int(codes[row]) for _, codes in cases.codes.values()))


def _settings(cases: Cases, case_ids: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return the conditions of some cases, by case."""
    wanted, conditions_by_case = set(case_ids), {}
    conditions = cases.paths_of(catalogue.CONDITION, catalogue.MODEL, catalogue.UNCERTAINTY)
    for row, case_id in enumerate(cases.values("case_id").astype(str).tolist() if wanted else ()):
        if case_id in wanted:
            values = _values_of(cases, row)
            conditions_by_case[case_id] = {path: values[path] for path in conditions if path in values}
    return conditions_by_case


def _nearest(record: Mapping[str, Any], columns: Any, rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return what comes nearest to the limits where `seek` has no answer, at most one entry."""
    section = record["seek"]
    searched = section.get("largest") or section.get("smallest")
    paths = [searched] if isinstance(searched, str) else list(searched)
    entries = [_nearest_of(record, columns, paths, row) for row in rows if row.get(f"seek.{paths[0]}") is None]
    known = [entry for entry in entries if entry["case"]]
    if not known:
        return []
    best = max(
        known, key=lambda entry: (entry["margin"] is not None, entry["margin"] or 0.0, -(entry["excess"] or 0.0))
    )
    return [best | {name: sum(entry[name] for entry in entries) for name in ("tried", "failed")}]


def _nearest_of(
    record: Mapping[str, Any], columns: Any, paths: Sequence[str], row: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the value tried by one search that comes nearest to the limits; its `case` is None if none is known."""
    is_tried = np.ones(len(columns["case_id"]), bool)
    for path in record["units"]:
        if path not in paths and row.get(path) is not None:
            is_tried &= np.array([value == row[path] for value in columns[path].tolist()], bool)
    of_path = {path: catalogue.CHOICE if path in paths else catalogue.CONDITION for path in record["units"]}
    tried = answer_on(Cases({**record, "roles": of_path}, columns, is_tried), ())
    failed = int((is_tried & (columns["status"] != "ok")).sum())
    entry: dict[str, Any] = {"case": None, "tried": int(is_tried.sum()), "failed": failed}
    best = next((design for design in tried["designs"] if design["verdict"] == "exceeds"), None)
    if best is None:
        return entry
    values = dict(best["values"])
    index = columns["case_id"].astype(str).tolist().index(best["worst"])
    for path in record["units"]:
        values.setdefault(path, named_value(record, path, columns[path][index]))
    return (
        entry | {name: best[name] for name in ("margin", "excess", "limit")} | {"case": best["worst"], "values": values}
    )


def _law_check(source: Source, columns: Any, checked: np.ndarray, answer: Mapping[str, Any], words: Words) -> str:
    """Return the sentence on the deciding case under other laws, or ''."""
    if not source.base_laws or not checked.any():
        return ""
    figure = _figures(answer["question"], Cases(source.record, columns, ~checked), source.layout)
    return (
        questions.law_check_sentence(source.record, columns, (source.base_laws, checked), words, figure[0])
        if figure
        else ""
    )
