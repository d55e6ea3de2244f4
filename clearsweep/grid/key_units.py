"""The SI unit of every number of a grid, from the key table."""

from collections.abc import Mapping

from ..contracts.catalogue import Catalogue
from ..language import quantity
from .key_table import shape
from .keys import Number, Word
from .outlining import outline_of
from .resolve import leaves

VARIATIONS = ("sweep", "zip", "cases")  # sections of a resolved grid with dotted path -> values


def key_units(resolved: Mapping, catalogue: Catalogue) -> dict[str, str]:
    """Return dotted path -> SI unit of every number in use in the result of `Grid.resolved`.

    Numbers of a law that is missing from the catalogue have no unit.
    """
    mechanism = catalogue.outlined(resolved["mechanism"]["type"], outline_of(resolved, _varied(resolved)))
    keys = shape(mechanism, catalogue) if mechanism else {}
    axes = _varied(resolved)
    values = dict(leaves(resolved))
    names = {
        path: frozenset(axes.get(path) or [values.get(path, node.default)])
        for path, node in keys.items()
        if isinstance(node, Word)
    }
    units_by_path = {}
    for path, node in keys.items():
        if isinstance(node, Number):
            sibling = f"{path.rpartition('.')[0]}.exponent"
            exponent = None if sibling in axes else values.get(sibling, _default(keys.get(sibling), names))
            units_by_path[path] = unit(node, names, exponent)
    return {path: name for path, name in units_by_path.items() if name}


def _varied(resolved: Mapping) -> dict:
    """Return path -> values of the varied keys of a resolved grid."""
    return {path: values for variation in VARIATIONS for path, values in (resolved.get(variation) or {}).items()}


def unit(node: Number, names: Mapping[str, frozenset[str]], exponent: float | None) -> str:
    """Return the SI unit of a number with the law names in use, 'A or B' where they differ, or '' if none is in use.

    `exponent` is the value of the key `exponent` next to it, or None if there is none or it varies.
    """
    written = [field.unit for field in node.fields(names)]
    exact = written if exponent is None else [quantity.exponent_of(name, exponent) for name in written]
    return " or ".join(dict.fromkeys(exact))


def _default(node: object, names: Mapping[str, frozenset[str]]) -> float | None:
    """Return the default of a missing key, or None if it has no numeric default."""
    fields = node.fields(names) if isinstance(node, Number) else ()
    return fields[0].default if fields else None
