"""Reads the sections with one entry per name: `figures`, `limits` and `uncertain`; predicts the columns of cases."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from ...answers.verdict import EXCEEDED_COLUMN, KINDS, MARGIN_COLUMN, UNDECIDED_COLUMN
from ...contracts.case import Uncertain, column_name
from ...contracts.catalogue import ROLES, Catalogue, Field
from ...contracts.layout import CONTACTS_OF_KIND, FEATURES_OF_FLANKED, CaseFeatures, JointLayout, Layout
from ...language import expression, np, quantity
from ...language.errors import did_you_mean, mistake_of, quoted
from ...language.quantity import is_bare, written_unit
from ..keys import Number
from ..keys.run_keys import LIFE
from ..written import MistakeError, WrittenValue, placed
from . import (
    QUANTITY_SCHEMA,
    NameSection,
    QuantityKey,
    Reader,
    ValueReader,
    read_quantity,
    report_unknown_keys,
    single_key_schemas,
)
from .axes import DISTRIBUTIONS, Distribution, distribution_of, forms_text, parameter_forms, read_distribution

_TIMES_KEY = "times"
_FIGURE_EXAMPLE = 'headroom: "1 - rod_slider_load_peak / (2 * rod_slider_force_peak_ideal)"'
FIGURES_SECTION = NameSection(
    "figures",
    "name of a new figure -> expression of columns of summary.parquet, or {law: NAME, KEY: ...}: a figure of one's "
    "own, which a file of `laws` declares",
    "figure",
    _FIGURE_EXAMPLE,
    {
        "anyOf": [
            {"type": "string"},
            {
                "type": "object",
                "properties": {"law": {"type": "string"}},
                "additionalProperties": QUANTITY_SCHEMA,
                "required": ["law"],
            },
        ]
    },
)
_BOUNDS_SCHEMA = dict.fromkeys(KINDS, QUANTITY_SCHEMA) | {_TIMES_KEY: {"type": "string"}}
LIMITS_SECTION = NameSection(
    "limits",
    "figure (a column of summary.parquet) -> largest acceptable value, or {at_most or at_least: value, times: another "
    "figure}",
    "limit",
    "rod_slider_force_peak: 5 kN",
    {
        "anyOf": [
            QUANTITY_SCHEMA,
            {"type": "object", "properties": _BOUNDS_SCHEMA, "additionalProperties": False, "minProperties": 1},
        ]
    },
)
_ROLES_TEXT = (
    "varied path -> its part in the answer, in place of the usual one. Choice: the designer decides; condition: must "
    "hold at every value; uncertainty and model: the worst value counts; numerics: the finest value counts"
)
ROLES_SECTION = NameSection("roles", _ROLES_TEXT, "role", "loads.spring.stiffness: choice", {"enum": list(ROLES)})


def read_roles(reader: Reader, root: WrittenValue) -> None:
    """Read the roles that the grid sets; the axes must be known.  A path that could vary may have one, too."""
    could_vary = [path for path, key in reader.keys_in_use.items() if getattr(key, "sweep", False)]
    known_paths = dict.fromkeys((*reader.written_axes, *could_vary))
    for path, written in ROLES_SECTION.entries(reader.problems, root).items():
        if path not in known_paths:
            position = root.value["roles"].key_position(path)
            message = f"cannot vary in this grid{did_you_mean(path, known_paths)}"
            known = f" (varied: {', '.join(reader.written_axes)})" if reader.written_axes else "; nothing varies"
            reader.problems.add(position, f"roles.{path}", message if "mean" in message else message + known)
        elif written.value not in ROLES:
            suggestion = did_you_mean(str(written.value), ROLES) or f" (known: {', '.join(ROLES)})"
            reader.problems.add(written, f"roles.{path}", f"unknown role {quoted(written.value)}{suggestion}")
        else:
            reader.roles[path] = written.value


def read_limits(reader: Reader, root: WrittenValue) -> None:
    """Read both sections into the reader; its columns must be known, but for figures of one's own."""
    own_units = {figure.name: figure.unit for figure in reader.outline.figures}
    figures, units = FIGURES_SECTION.entries(reader.problems, root), reader.figures | own_units
    for name, written in figures.items():
        name_mistake = _name_mistake(reader, name)
        if problem := name_mistake or ("" if name in own_units else _expression_mistake(written.value, units)):
            position = root.value["figures"].key_position(name) if name_mistake else written
            reader.problems.add(position, f"figures.{name}", problem)
        elif name not in own_units:
            units[name] = expression.unit_of(written.value, units)
            reader.user_figures[name] = written.value
    reader.figures |= own_units
    for column, written in LIMITS_SECTION.entries(reader.problems, root).items():
        if column not in units:
            position = root.value["limits"].key_position(column)
            message = reader.unrated_figures.get(column) or _unknown_column_text(column, units)
            reader.problems.add(position, f"limits.{column}", message)
        elif isinstance(written.value, dict):
            _read_bounds(reader, column, written, units)
        else:
            with reader.problems.reporting():
                reader.limits[column] = _read_limit(reader, f"limits.{column}", written, units[column])


def _read_limit(reader: Reader, path: str, written: WrittenValue, unit: str) -> float:
    """Return a bound (SI) and note the unit in which it is written; MistakeError if it is invalid."""
    if unit_of_text := written_unit(written.value, unit):
        reader.limit_units[".".join(path.split(".")[:2])] = unit_of_text
    bound: float = placed(written, path, quantity.read, written.value, unit)
    return bound


def _unknown_column_text(name: str, units: dict[str, str]) -> str:
    known = f" (known: {', '.join(units)})"  # a long list, shown only if no name is near
    return f"is not a column of this grid{did_you_mean(name, units) or known}"


def _name_mistake(reader: Reader, name: str) -> str:
    """Return why a user-defined figure cannot have this name, or '' if it can."""
    if name in reader.figures:
        return "is a column already; give the figure another name"
    if name in (
        EXCEEDED_COLUMN,
        UNDECIDED_COLUMN,
        MARGIN_COLUMN,
        "case_id",
        "status",
        "message",
        *expression.FUNCTIONS,
    ):
        return "is a reserved name; rename the figure"
    return "" if name.isidentifier() else "is not a valid name; expected letters, digits and _, and a letter or _ first"


def _expression_mistake(text: Any, units: dict[str, str]) -> str:
    """Return what is wrong with an expression, or '' if nothing is."""
    if not isinstance(text, str):
        return f"found {quoted(text)}; expected an expression of columns, in quotes, such as `{_FIGURE_EXAMPLE}`"
    return mistake_of(expression.unit_of, text, units)


def _read_bounds(reader: Reader, column: str, written: WrittenValue, units: dict[str, str]) -> None:
    """Read a limit written as a section: at_most, at_least, times."""
    path, entries = f"limits.{column}", written.value
    known_keys = (*KINDS, _TIMES_KEY)
    unknown = report_unknown_keys(reader.problems, path, written, known_keys)
    if not unknown and not any(kind in entries for kind in KINDS):
        reader.problems.add(written, path, f"contains no limit; add {' or '.join(KINDS)}, such as {{at_most: 5 kN}}")
        return
    unit, bounds = units[column], dict[str, Any]()
    if _TIMES_KEY in entries:
        other_column = entries[_TIMES_KEY].value
        if not isinstance(other_column, str) or other_column not in units:
            message = f"{quoted(other_column)} {_unknown_column_text(str(other_column), units)}"
            reader.problems.add(entries[_TIMES_KEY], f"{path}.{_TIMES_KEY}", message)
            return
        unit = unit_of_quotient(unit, units[other_column])
        bounds[_TIMES_KEY] = other_column
    for kind in KINDS:
        if kind in entries and unit != "1" and _TIMES_KEY in bounds and is_bare(entries[kind].value):
            message = (
                f"found {entries[kind].value}; it is in {unit}, because {column} is in {units[column]} and "
                f"{bounds[_TIMES_KEY]} in {units[bounds[_TIMES_KEY]]}; write the unit, or compare with a column in "
                f"{units[column]}"
            )
            reader.problems.add(entries[kind], f"{path}.{kind}", message)
        elif kind in entries:
            with reader.problems.reporting():
                bounds[kind] = _read_limit(reader, f"{path}.{kind}", entries[kind], unit)
    if any(kind in bounds for kind in KINDS):
        reader.limits[column] = bounds


def unit_of_quotient(unit: str, divisor: str) -> str:
    """Return the SI unit of a quotient of two quantities, '1' for equal units."""
    if divisor in ("1", unit):
        return unit if divisor == "1" else "1"
    return expression.unit_of("a / b", {"a": unit, "b": divisor})


def expected_columns(reader: Reader, catalogue: Catalogue) -> dict[str, str]:
    """Return the figures of merit that the cases will have, each with its unit."""
    life, joints = column_name(reader.values.get(f"{LIFE}.joint", "")), []
    for site in sorted(reader.mechanism.joints, key=lambda site: "stops" in site.kind):
        path = f"joints.{site.name}"
        if path not in reader.keys_in_use and not site.stopped:
            continue
        ratings = [rating for rating in ("dynamic", "static") if reader.is_given(f"{path}.capacity.{rating}")]
        joint = JointLayout(
            column_name(site.name),
            int(f"{path}.wear" in reader.keys_in_use),
            f"{path}.film" in reader.keys_in_use,
            *CONTACTS_OF_KIND[site.kind],
            friction=f"{path}.friction" in reader.keys_in_use,
            strength=site.kind in ("revolute", "line") and _has_strength(reader, path),
            thermal=f"{path}.thermal" in reader.keys_in_use,
            is_rolling=site.kind == "rolling",
            flanked=site.kind if site.kind in FEATURES_OF_FLANKED else "",
            **dict.fromkeys(ratings, True),
        )
        joints.append(joint)
        reader.unrated_figures |= {
            figure.column(joint.name): f"needs the rating of the bearing; write {path}.capacity.{rating}"
            for figure in catalogue.figures
            for rating in {"dynamic", "static"} - {*ratings}
            if joint.is_rolling and rating in figure.needs
        }
    features = CaseFeatures(
        reader.mechanism.name,
        reader.outline._replace(figures=()),
        tuple(joints),
        "simulate.horizon" in reader.values,
        "simulate.error_check" in reader.values,
        str(reader.values.get("simulate.until.figure", "")),
        life,
        bool(reader.uncertain),
    )
    return {column.name: column.unit for column in Layout.with_features(features, catalogue).columns}


def _has_strength(reader: Reader, joint: str) -> bool:
    """Return whether a joint with contact has a yield strength or a hardness."""
    known_paths = [path for path in (*reader.written, *reader.written_axes) if path.startswith(f"{joint}.")]
    return f"{joint}.contact" in reader.keys_in_use and any(
        path.endswith(".yield_strength") or path in (f"{joint}.wear.hardness", f"{joint}.roughness.hardness")
        for path in known_paths
    )


UNCERTAIN, FACTOR, PUBLISHED = "uncertain", "factor", "published"
LARGEST_FACTOR = 1e3  # factor
BODY_COEFFICIENTS = ("bearing_coefficient", "journal_coefficient")
_COEFFICIENT_PATH = re.compile(r"joints\.([^.]+)\.wear\.(coefficient|bearing_coefficient|journal_coefficient)")
_INTERVAL_PROBABILITIES = (0.025, 0.975)  # ends of a 95 % interval
_FACTOR_KEY = QuantityKey(
    FACTOR,
    "95 % of the values are between the coefficient divided and multiplied by it",
    bounds=Field(FACTOR, "1", low=1.0, high=LARGEST_FACTOR, high_open=False),
)
UNCERTAIN_SECTION = NameSection(
    UNCERTAIN,
    "dotted path of a wear coefficient -> its distribution; {factor: 3}: lognormal, with 95 % between a third and "
    "three times the value; `published`: loguniform over the range of the named wear pair; or a distribution of "
    "`sample`. Two further lives, at the ends of the distribution, give a second interval of the life",
    "path",
    "joints.rod-slider.wear.coefficient: {factor: 3}",
    {
        "anyOf": [
            *single_key_schemas(
                {
                    FACTOR: {"type": "number", "exclusiveMinimum": 1, "maximum": LARGEST_FACTOR},
                    **{name: {"description": form} for name, form in parameter_forms().items()},
                }
            ),
            {"const": PUBLISHED},
        ]
    },
)


def read_uncertain(reader: Reader, root: WrittenValue) -> None:
    """Read the section into the reader: path -> distribution, in SI."""
    entries = UNCERTAIN_SECTION.entries(reader.problems, root)
    if not entries:
        return
    section = root.value[UNCERTAIN]
    if LIFE not in reader.keys_in_use:
        message = "needs `life`, whose interval it widens; write life: {limit, joint}, or remove this key"
        reader.problems.add(section, UNCERTAIN, message)
        return
    for path, written in entries.items():
        if problem := _path_mistake(reader, path, [*entries]):
            reader.problems.add(section.key_position(path), f"{UNCERTAIN}.{path}", problem)
        else:
            with reader.problems.reporting():
                reader.uncertain[path] = _coefficient_distribution(reader, path, written)


def _path_mistake(reader: Reader, path: str, paths: list[str]) -> str:
    """Return why a path cannot be uncertain, or '' if it can."""
    match = _COEFFICIENT_PATH.fullmatch(path)
    if not match:
        return (
            "is not a wear coefficient; `uncertain` accepts only joints.J.wear.coefficient, bearing_coefficient and "
            "journal_coefficient; draw other values with `sample`"
        )
    wear = f"joints.{match[1]}.wear"
    if wear not in reader.keys_in_use:
        return f"there is no section '{wear}'; write it, or name a joint that wears"
    if match[2] == "coefficient" and any(f"{wear}.{body}" in paths for body in BODY_COEFFICIENTS):
        return f"conflicts with {wear}.bearing_coefficient or journal_coefficient; write both bodies', or this"
    return ""


def _coefficient_distribution(reader: Reader, path: str, written: WrittenValue) -> dict[str, Any]:
    """Return the distribution of a coefficient, in SI; MistakeError if it is invalid."""
    key_path = f"{UNCERTAIN}.{path}"
    if isinstance(written.value, dict) and [*written.value] == [FACTOR]:
        return {FACTOR: _FACTOR_KEY.read(reader.problems, f"{key_path}.{FACTOR}", written.value[FACTOR], "1")}
    if written.value == PUBLISHED:
        library_value = reader.library_numbers.get(path)
        if library_value is None:
            message = f"needs the range of a wear pair; write `{path.rpartition('.')[0]}.pair`, or a distribution"
            raise MistakeError(written, key_path, message)
        bounds = [
            WrittenValue(f"{endpoint!r} {library_value.value.unit}", written.origin)
            for endpoint in library_value.value[2:]
        ]
        written = WrittenValue({"loguniform": WrittenValue(bounds, written.origin)}, written.origin)
    if not isinstance(written.value, dict) or not set(written.value) <= set(DISTRIBUTIONS):
        message = f"found {quoted(written.value)}; expected {{factor: 3}}, {PUBLISHED} or one of {forms_text()}"
        raise MistakeError(written, key_path, message)
    wear = path.rpartition(".")[0]
    key = reader.keys_in_use[f"{wear}.{BODY_COEFFICIENTS[0]}"]
    assert isinstance(key, Number)  # a single coefficient
    (field, *_) = key.fields(reader.names)

    reading = ValueReader(lambda item: read_quantity(reader.problems, key_path, item, field.unit), field.unit, (field,))
    distribution = read_distribution(reader.problems, key_path, written, reading)
    if _interval(distribution)[0] <= 0.0:
        message = "its 2.5 % quantile is not above 0; write a lognormal or loguniform distribution"
        raise MistakeError(written, key_path, f"{distribution.name}: {message}")
    return distribution.resolved()


def _interval(distribution: Distribution) -> tuple[float, float]:
    """Return the ends of the 95 % interval of a distribution, in SI."""
    low, high = distribution.values(np.array(_INTERVAL_PROBABILITIES)).tolist()
    return low, high


def uncertain_leaves(distributions: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of the distributions, as in a case."""
    for path, distribution in distributions.items():
        for kind, content in distribution.items():
            nested = f"{UNCERTAIN}.{path}.{kind}"
            if isinstance(content, Mapping):
                yield from ((f"{nested}.{key}", value) for key, value in content.items())
            else:
                yield nested, content


def uncertain_of(section: Mapping[str, Any]) -> tuple[Uncertain, ...]:
    """Return the typed form of the section of a case, given as nested sections in SI."""
    uncertain = []
    for joint, nested in section["joints"].items():
        for key, distribution in nested["wear"].items():
            keys = BODY_COEFFICIENTS if key == "coefficient" else (key,)
            ((kind, content),) = distribution.items()
            if kind == FACTOR:
                uncertain.append(Uncertain(joint, keys, 1.0 / content, content, relative=True))
            else:
                uncertain.append(Uncertain(joint, keys, *_interval(distribution_of(distribution)), relative=False))
    return tuple(uncertain)
