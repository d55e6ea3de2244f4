"""The libraries as `clearsweep list` prints them."""

import textwrap

from .entry import Entry, Value

_WIDTH = 100  # characters in a line
_SCALES = {"Pa": (1e9, "GPa"), "1/K": (1e-6, "1e-6/K"), "m^2/s": (1e-6, "mm^2/s")}  # SI -> unit for display


def listed(entry: Entry) -> str:
    """Return an entry as text: values with ranges, source, and which values were checked."""
    lines = [_wrapped("", f"{entry.name}: {entry.summary}")]
    width = max(map(len, entry.values))
    lines += [f"  {key:{width}}  {shown(value)}" for key, value in entry.values.items()]
    lines += [_wrapped("  ", f"source: {entry.source}"), _wrapped("  ", f"checked: {entry.checked}")]
    return "\n".join(lines)


def shown(value: Value) -> str:
    """Return a value with its range: '210 GPa (205 to 213)'."""
    scale, unit = _SCALES.get(value.unit, (1.0, value.unit))
    if value.unit == "Pa" and value.high < 1e9:
        scale, unit = 1e6, "MPa"
    typical, low, high = (f"{number / scale:.4g}" for number in value[1:])
    return f"{typical}{'' if unit == '1' else f' {unit}'} ({low} to {high})"


def _wrapped(indent: str, content: str) -> str:
    return textwrap.fill(content, _WIDTH, initial_indent=indent, subsequent_indent="  ", break_on_hyphens=False)
