"""Small tables of cases, and the answers to them."""

from clearsweep.answers.compose import question_of
from clearsweep.answers.judge import answer_on
from clearsweep.answers.judged import Cases
from clearsweep.contracts.layout import Layout

CLEARANCE, SPEED = "joints.pin.clearance", "drive.speed"
FORCE, IMPACTS, IDEAL, OTHER = "pin_force_peak", "pin_impacts_per_rev", "pin_force_peak_ideal", "reserve"
RPM = 0.10471975511965977  # rad/s
UNITS = {CLEARANCE: "m", SPEED: "rad/s"}
ROLES = {CLEARANCE: "choice", SPEED: "condition"}


def record_of(limits=None, roles=ROLES, units=UNITS, nulls=None, **more):
    """Return the part of a run.json that an answer needs; nulls : column -> meaning of null."""
    figures = {FORCE: "force_peak", IMPACTS: "impacts_per_rev", IDEAL: "force_peak_ideal", OTHER: "reserve"}
    columns = [
        {"name": name, "unit": "N" if "force" in name else "1", "description": "", "kind": "float", "figure": figure}
        | {"joint": "pin", "null": (nulls or {}).get(name, "")}
        for name, figure in figures.items()
    ]
    layout = {"mechanism": "planar", "turns": True, "output": "", "joints": [{"name": "pin", "wear_bins": 0}]}
    layout |= {"columns": columns, "channels": []}
    written = {CLEARANCE: ("mm", 1e-3), SPEED: ("rpm", RPM)}
    written_units = {path: {"unit": unit, "factor": factor, "offset": 0.0} for path, (unit, factor) in written.items()}
    more = {"written_units": written_units, **more}
    return {"limits": limits or {}, "roles": dict(roles), "units": dict(units), "layout": layout, **more}


def table_of(names, rows):
    """Return columns from rows; names : column -> place in a row; a case without any figure failed.

    Speeds are written in rpm.
    """
    table = {name: [row[place] for row in rows] for name, place in names.items()}
    figures = [name for name in names if "." not in name]
    failed = [all(table[name][k] is None for name in figures) for k in range(len(rows))]
    if SPEED in table:
        table[SPEED] = [None if speed is None else RPM * speed for speed in table[SPEED]]
    table["case_id"] = [f"{k:016x}" for k in range(len(rows))]
    table["status"] = ["time-limit" if is_failed else "ok" for is_failed in failed]
    return table


def core_of(record, table, own=None, figures=None):
    """Return the answer to a table of cases without sentences; figures : by default limited and user-defined ones."""
    cases = Cases(record, table, own)
    limited = dict.fromkeys([*(limit.column for limit in cases.limits), *(record.get("figures") or {})])
    question = question_of(record, Layout.read(record["layout"]), cases.paths)
    parts = answer_on(cases, [*limited] if figures is None else figures)
    return {"question": question, "complete": True, **parts, "search": [], "sentences": []}


def answer_of(record, table, **more):
    """Return the answer to a table of cases, with the ends of its axes and the conditions of its worst cases."""
    answer = core_of(record, table, **more)
    places = {case_id: k for k, case_id in enumerate(table["case_id"])}
    conditions = [path for path, role in answer["roles"].items() if role in ("condition", "model", "uncertainty")]
    answer["settings"] = {
        design["worst"]: {path: table[path][places[design["worst"]]] for path in conditions}
        for design in answer["designs"]
        if design["worst"]
    }
    answer["ends"] = {
        path: [min(values), max(values)]
        for path in answer["roles"]
        if (values := [value for value in table[path] if value is not None]) and not isinstance(values[0], str)
    }
    return answer
