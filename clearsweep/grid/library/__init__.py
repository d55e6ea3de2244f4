"""Materials, oils, wear pairs and rolling bearings by name: values with their ranges and sources."""

import textwrap
from collections.abc import Mapping

from ...language.errors import InputError, did_you_mean, quoted
from .entries import BEARINGS, MATERIALS, OILS, PAIRS, Entry, Value

#: Names of whole libraries for `clearsweep list NAME`.
LIBRARIES: Mapping[str, Mapping[str, Entry]] = {
    "materials": MATERIALS,
    "oils": OILS,
    "pairs": PAIRS,
    "bearings": BEARINGS,
}

__all__ = ["BEARINGS", "LIBRARIES", "MATERIALS", "OILS", "PAIRS", "Entry", "Value", "library_text"]


def library_text(name: str) -> str | None:
    """Return the library or the entry called `name` as text, or None if there is neither."""
    if name in LIBRARIES:
        return "\n\n".join(entry_text(entry) for entry in LIBRARIES[name].values())
    entries = [library[name] for library in LIBRARIES.values() if name in library]
    return "\n\n".join(map(entry_text, entries)) or None


def library_names() -> tuple[str, ...]:
    """Return every name that `library_text` accepts."""
    return (*LIBRARIES, *(name for library in LIBRARIES.values() for name in library))


def find_entry(library: Mapping[str, Entry], name: str) -> Entry:
    """Return an entry by its name in any letter case.  Raises InputError with the nearest name."""
    names_by_folded_name = {" ".join(name.split()).casefold(): name for name in library}
    entry_name = names_by_folded_name.get(" ".join(name.split()).casefold())
    if entry_name is None:
        kind = next(kind for kind, entries in LIBRARIES.items() if entries is library)
        hint = did_you_mean(name, library)
        raise InputError(f"unknown name {quoted(name)}{hint} (`clearsweep list {kind}` prints all {len(library)})")
    return library[entry_name]


_WIDTH = 100  # characters in a line
_SCALES = {  # SI -> unit for display
    "Pa": (1e9, "GPa"),
    "1/K": (1e-6, "1e-6/K"),
    "m^2/s": (1e-6, "mm^2/s"),
    "m": (1e-3, "mm"),
    "N": (1e3, "kN"),
}


def entry_text(entry: Entry) -> str:
    """Return an entry as text: values with ranges, source, and which values were checked."""
    lines = [_wrapped("", f"{entry.name}: {entry.summary}")]
    width = max(map(len, entry.values))
    lines += [f"  {key:{width}}  {value_text(value)}" for key, value in entry.values.items()]
    if not entry.hard_body_wears:
        lines.append("  of the softer body; the harder one does not wear")
    checked = entry.checked or "no: written from memory of the source; next to the name write `unchecked: true`"
    lines += [_wrapped("  ", f"source: {entry.source}"), _wrapped("  ", f"checked: {checked}")]
    return "\n".join(lines)


def value_text(value: Value) -> str:
    """Return a value with its range: '210 GPa (205 to 213)'; an exact one alone."""
    scale, unit = _SCALES.get(value.unit, (1.0, value.unit))
    if value.unit == "Pa" and value.high < 1e9:
        scale, unit = 1e6, "MPa"
    typical, low, high = (f"{number / scale:.4g}" for number in value[1:])
    spread = f" ({low} to {high})" if value.low < value.high else ""
    return f"{typical}{'' if unit == '1' else f' {unit}'}{spread}"


def _wrapped(indent: str, content: str) -> str:
    return textwrap.fill(content, _WIDTH, initial_indent=indent, subsequent_indent="  ", break_on_hyphens=False)
