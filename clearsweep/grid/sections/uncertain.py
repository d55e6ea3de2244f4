"""Reads `uncertain`: intervals of wear coefficients, from which a second interval of a life follows."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from ...contracts.case import Uncertain
from ...language import quantity
from ...language.errors import InputError, shown
from ..keys.kinds import Number
from ..keys.run_keys import LIFE
from ..written.document import WrittenValue
from .axes import Reading
from .distributions import LAWS, Distribution, distribution_of, forms_text, parameter_forms, read_distribution
from .reader import Reader
from .section import NameSection, named_forms

UNCERTAIN, FACTOR, PUBLISHED = "uncertain", "factor", "published"
LARGEST_FACTOR = 1e3  # factor
BODIES = ("bearing_coefficient", "journal_coefficient")
_PATH = re.compile(r"joints\.([^.]+)\.wear\.(coefficient|bearing_coefficient|journal_coefficient)")
_TAILS = (0.025, 0.975)  # ends of a 95 % interval
UNCERTAIN_SECTION = NameSection(
    UNCERTAIN,
    "dotted path of a wear coefficient -> {factor: 3}, lognormal with 95 % between a third and three times its value; "
    "or a distribution of `sample`; or `published`, loguniform over the range of the named wear pair; a life gets "
    "a second interval from two further lives at the ends",
    "path",
    "joints.rod-slider.wear.coefficient: {factor: 3}",
    {
        "anyOf": [
            *named_forms(
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
    if LIFE not in reader.shape:
        sentence = "needs `life`, whose interval it widens; write life: {limit, joint}, or remove this key"
        reader.problems.add(section, UNCERTAIN, sentence)
        return
    for path, written in entries.items():
        if problem := _refused(reader, path, [*entries]):
            reader.problems.add(section.key_place(path), f"{UNCERTAIN}.{path}", problem)
        elif (spread := _spread(reader, path, written)) is not None:
            reader.uncertain[path] = spread


def _refused(reader: Reader, path: str, paths: list[str]) -> str:
    """Return why a path cannot be uncertain, or '' if it can."""
    match = _PATH.fullmatch(path)
    if not match:
        return (
            "is not a wear coefficient; `uncertain` accepts only joints.J.wear.coefficient, bearing_coefficient and "
            "journal_coefficient; draw other values with `sample`"
        )
    wear = f"joints.{match[1]}.wear"
    if wear not in reader.shape:
        return f"there is no section '{wear}'; write it, or name a joint that wears"
    if match[2] == "coefficient" and any(f"{wear}.{body}" in paths for body in BODIES):
        return f"conflicts with {wear}.bearing_coefficient or journal_coefficient; write both bodies', or this"
    return ""


def _spread(reader: Reader, path: str, written: WrittenValue) -> dict[str, Any] | None:
    """Return the distribution of a coefficient, in SI, or None if it is invalid."""
    where = f"{UNCERTAIN}.{path}"
    if isinstance(written.value, dict) and [*written.value] == [FACTOR]:
        try:
            factor = quantity.read(written.value[FACTOR].value, "1")
        except InputError as error:
            reader.problems.add(written.value[FACTOR], f"{where}.{FACTOR}", str(error))
            return None
        if 1.0 < factor <= LARGEST_FACTOR:
            return {FACTOR: factor}
        sentence = f"found {factor:.6g}; allowed: above 1 and at most {LARGEST_FACTOR:g}"
        reader.problems.add(written.value[FACTOR], f"{where}.{FACTOR}", sentence)
        return None
    if written.value == PUBLISHED:
        library_value = reader.library_values.get(path)
        if library_value is None:
            sentence = f"needs the range of a wear pair; write `{path.rpartition('.')[0]}.pair`, or a distribution"
            reader.problems.add(written, where, sentence)
            return None
        bounds = [
            WrittenValue(f"{end!r} {library_value.value.unit}", written.origin) for end in library_value.value[2:]
        ]
        written = WrittenValue({"loguniform": WrittenValue(bounds, written.origin)}, written.origin)
    if not isinstance(written.value, dict) or not set(written.value) <= set(LAWS):
        reader.problems.add(
            written,
            where,
            f"found {shown(written.value)}; expected {{factor: 3}}, {PUBLISHED} or one of {forms_text()}",
        )
        return None
    wear = path.rpartition(".")[0]
    node = reader.shape[f"{wear}.{BODIES[0]}"]
    assert isinstance(node, Number)  # a single coefficient
    (field, *_) = node.fields(reader.names)

    def value(item: WrittenValue) -> float | None:
        try:
            return quantity.read(item.value, field.unit)
        except InputError as error:
            reader.problems.add(item, where, str(error))
            return None

    spread = read_distribution(reader.problems, where, written, Reading(value, field.unit, (field,)))
    if spread is None:
        return None
    if _ends(spread)[0] <= 0.0:
        sentence = f"{spread.name}: its 2.5 % quantile is not above 0; write a lognormal or loguniform distribution"
        reader.problems.add(written, where, sentence)
        return None
    return spread.written()


def _ends(spread: Distribution) -> tuple[float, float]:
    """Return the ends of the 95 % interval of a distribution, in SI."""
    import numpy as np

    low, high = spread.values(np.array(_TAILS)).tolist()
    return low, high


def uncertain_leaves(spreads: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of the distributions, as in a case."""
    for path, spread in spreads.items():
        for kind, content in spread.items():
            nested = f"{UNCERTAIN}.{path}.{kind}"
            if isinstance(content, Mapping):
                yield from ((f"{nested}.{key}", value) for key, value in content.items())
            else:
                yield nested, content


def uncertain_of(section: Mapping[str, Any]) -> tuple[Uncertain, ...]:
    """Return the typed form of the section of a case, given as nested sections in SI."""
    uncertain = []
    for joint, nested in section["joints"].items():
        for key, spread in nested["wear"].items():
            keys = BODIES if key == "coefficient" else (key,)
            ((kind, content),) = spread.items()
            if kind == FACTOR:
                uncertain.append(Uncertain(joint, keys, 1.0 / content, content, relative=True))
            else:
                uncertain.append(Uncertain(joint, keys, *_ends(distribution_of(spread)), relative=False))
    return tuple(uncertain)
