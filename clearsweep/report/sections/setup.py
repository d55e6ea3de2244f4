"""Setup of the run: swept, fixed and derived values, and the origin of the results."""

import re

from ... import grid
from ...language import wording
from ..blocks.section import Block, Columns, Facts, Note, Section, without_empty
from ..data.axis import Axis
from ..data.dotted_paths import leaves
from ..data.study import CASE_SECTIONS, Study

LISTED = 12  # values of an axis that are listed one by one, at most
ELSEWHERE = (  # in the record of a run, and shown elsewhere or not for people
    "name",
    "sweep",
    "zip",
    "cases",
    "limits",
    "layout",
    "units",
    "fits",
    "written_units",
    "keys",
    "frame",
    "derived",
    "warnings",
)
NOT_FOR_PEOPLE = ("machine.node", "merged.mark")  # the name of a machine is nobody's else; run.json has both
CHECKSUM_SHOWN = 12  # characters of a checksum; run.json has all
SUMS = (("steps", "accepted steps, all cases"), ("rhs_evaluations", "evaluations, all cases"))
RESIDUAL = (
    "The energy residual is the largest imbalance of work, energy and losses, divided by the largest kinetic energy. "
    "It shows how accurately the equations are solved, not how well they describe a machine."
)


def sections(study: Study) -> list[Section]:
    """Return the section, with the values in one column and their origin in the other."""
    swept = [(axis.path, _listed(axis)) for axis in study.axes]
    values: list[Block] = [
        Facts("Swept", "Swept values", swept),
        Facts("The same in every case" if study.axes else "The case", "Fixed values", _fixed(study)),
        Facts("Derived from these", "Derived values", _derived(study)),
    ]
    origin: list[Block] = [Facts("Provenance", "Provenance", _provenance(study)), Note(RESIDUAL)]
    return [Section("setup", "Values and origin", [Columns((without_empty(values), origin))])]


def _listed(axis: Axis) -> str:
    if axis.is_scattered or len(axis.values) > LISTED:
        return axis.span()
    return ", ".join(axis.text(value) for value in axis.values)


def _fixed(study: Study) -> list[tuple[str, str]]:
    """Return the values that every case shares: dotted path, value with unit."""
    swept = {axis.path for axis in study.axes}
    fits = {path: f" ({known[0].name})" for path, known in grid.recorded_fits(study.run.grid).items()}
    return [
        (path, _text(study, path, value) + fits.get(path, ""))
        for path, value in leaves(study.base)
        if path not in swept
    ]


def _text(study: Study, path: str, value: object) -> str:
    """Return a fixed value, or each of a list, with its unit."""
    if isinstance(value, list) and len(value) > LISTED:
        unit, ends = study.unit(path), (min(value), max(value))
        return f"{len(value)} values, {' to '.join(wording.scale(unit, ends).given(end, 4) for end in ends)}"
    if isinstance(value, list):
        return ", ".join(_text(study, f"{path}.{place}", item) for place, item in enumerate(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    written = wording.written_scale(study.run.grid.get("written_units", {}).get(path), study.unit(path))
    return (written or wording.scale(study.unit(path), value, speed=path == "drive.speed")).given(value)


def _derived(study: Study) -> list[tuple[str, str]]:
    """Return derived values, such as a stiffness from a material: dotted path, range with unit."""
    facts = []
    for path, span in (study.run.grid.get("derived") or {}).items():
        scale = wording.scale(span["unit"], (span["min"], span["max"]))
        ends = dict.fromkeys(scale.given(span[end], 4) for end in ("min", "max"))
        facts.append((path, " to ".join(ends)))
    return facts


def _shortened(value: object) -> str:
    """Return a value as text; of a checksum, only enough digits to distinguish two."""
    text = str(value)
    return f"{text[:CHECKSUM_SHOWN]}..." if re.fullmatch("[0-9a-f]{40,}", text) else text


def _provenance(study: Study) -> list[tuple[str, str]]:
    """Return the origin of the figures: versions, machine, times, counts, energy residual."""
    record = {key: value for key, value in study.run.grid.items() if key not in (*CASE_SECTIONS, *ELSEWHERE) and value}
    if "sample" in record:
        record["sample"] = {key: value for key, value in record["sample"].items() if key != "drawn"}
    facts = [
        (path.replace("_", " "), _shortened(value)) for path, value in leaves(record) if path not in NOT_FOR_PEOPLE
    ]
    if study.has("energy_residual"):
        residual = study.cases["energy_residual"]
        facts.append(("energy residual, largest", wording.plain(residual.max(), 2)))
        facts.append(("energy residual, median", wording.plain(residual.median(), 2)))
    facts += [(name, wording.plain(study.cases[column].sum(), 4)) for column, name in SUMS if study.has(column)]
    if study.has("run_time"):
        facts.append(("integration time, all cases", wording.text(study.cases["run_time"].sum(), "s")))
    return facts
