"""Setup of the run: swept, fixed and derived values, and the origin of the results."""

import re

from ... import grid
from ...language import wording
from ..blocks.section import Block, Columns, Facts, Note, Section, without_empty
from ..data.axis import Axis
from ..data.dotted_paths import leaves
from ..data.study import CASE_SECTIONS, Study

MAX_LISTED_VALUES = 12  # values of an axis that are listed one by one, at most
OMITTED_KEYS = (  # in the record of a run, and shown elsewhere or not for people
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
OMITTED_PATHS = ("machine.node", "merged.mark")  # the name of a machine is nobody's else; run.json has both
CHECKSUM_DIGITS = 12  # characters of a checksum; run.json has all
SUMMED_COLUMNS = (("steps", "accepted steps, all cases"), ("rhs_evaluations", "evaluations, all cases"))
RESIDUAL_NOTE = (
    "The energy residual is the largest imbalance of work, energy and losses, divided by the largest kinetic energy. "
    "It shows how accurately the equations are solved, not how well they describe a machine."
)


def sections(study: Study) -> list[Section]:
    """Return the section, with the values in one column and their origin in the other."""
    axis_texts = [(axis.path, _axis_text(axis)) for axis in study.axes]
    values: list[Block] = [
        Facts("Swept", "Swept values", axis_texts),
        Facts("The same in every case" if study.axes else "The case", "Fixed values", _fixed_values(study)),
        Facts("Derived from these", "Derived values", _derived_values(study)),
    ]
    origin: list[Block] = [Facts("Provenance", "Provenance", _provenance(study)), Note(RESIDUAL_NOTE)]
    return [Section("setup", "Values and origin", [Columns((without_empty(values), origin))])]


def _axis_text(axis: Axis) -> str:
    if axis.is_scattered or len(axis.values) > MAX_LISTED_VALUES:
        return axis.range_text()
    return ", ".join(axis.text(value) for value in axis.values)


def _fixed_values(study: Study) -> list[tuple[str, str]]:
    """Return the values that every case shares: dotted path, value with unit."""
    swept = {axis.path for axis in study.axes}
    fits = {path: f" ({entries[0].name})" for path, entries in grid.recorded_fits(study.run.grid).items()}
    return [
        (path, _value_text(study, path, value) + fits.get(path, ""))
        for path, value in leaves(study.base)
        if path not in swept
    ]


def _value_text(study: Study, path: str, value: object) -> str:
    """Return a fixed value, or each of a list, with its unit."""
    if isinstance(value, list) and len(value) > MAX_LISTED_VALUES:
        unit, extremes = study.unit(path), (min(value), max(value))
        return (
            f"{len(value)} values, "
            f"{' to '.join(wording.scale(unit, extremes).exact_text(extreme, 4) for extreme in extremes)}"
        )
    if isinstance(value, list):
        return ", ".join(_value_text(study, f"{path}.{index}", item) for index, item in enumerate(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    written_scale = wording.written_scale(study.run.grid.get("written_units", {}).get(path), study.unit(path))
    return (written_scale or wording.scale(study.unit(path), value, speed=path == "drive.speed")).exact_text(value)


def _derived_values(study: Study) -> list[tuple[str, str]]:
    """Return derived values, such as a stiffness from a material: dotted path, range with unit."""
    facts = []
    for path, extremes in (study.run.grid.get("derived") or {}).items():
        scale = wording.scale(extremes["unit"], (extremes["min"], extremes["max"]))
        texts = dict.fromkeys(scale.exact_text(extremes[key], 4) for key in ("min", "max"))
        facts.append((path, " to ".join(texts)))
    return facts


def _shortened(value: object) -> str:
    """Return a value as text; of a checksum, only enough digits to distinguish two."""
    text = str(value)
    return f"{text[:CHECKSUM_DIGITS]}..." if re.fullmatch("[0-9a-f]{40,}", text) else text


def _provenance(study: Study) -> list[tuple[str, str]]:
    """Return the origin of the figures: versions, machine, times, counts, energy residual."""
    record = {
        key: value for key, value in study.run.grid.items() if key not in (*CASE_SECTIONS, *OMITTED_KEYS) and value
    }
    if "sample" in record:
        record["sample"] = {key: value for key, value in record["sample"].items() if key != "drawn"}
    facts = [(path.replace("_", " "), _shortened(value)) for path, value in leaves(record) if path not in OMITTED_PATHS]
    if study.has("energy_residual"):
        residual = study.cases["energy_residual"]
        facts.append(("energy residual, largest", wording.number_text(residual.max(), 2)))
        facts.append(("energy residual, median", wording.number_text(residual.median(), 2)))
    facts += [
        (name, wording.number_text(study.cases[column].sum(), 4))
        for column, name in SUMMED_COLUMNS
        if study.has(column)
    ]
    if study.has("run_time"):
        facts.append(("integration time, all cases", wording.quantity_text(study.cases["run_time"].sum(), "s")))
    return facts
