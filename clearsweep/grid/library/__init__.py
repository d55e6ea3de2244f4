"""Materials, oils and wear pairs by name: typical values, each with its range and its source."""

from collections.abc import Mapping

from ...language.errors import InputError, nearest, shown
from .entry import Entry, Value
from .listing import listed
from .materials import MATERIALS
from .oils import OILS
from .pairs import PAIRS

#: Names of whole libraries for `clearsweep list NAME`.
LIBRARIES: Mapping[str, Mapping[str, Entry]] = {"materials": MATERIALS, "oils": OILS, "pairs": PAIRS}

__all__ = ["LIBRARIES", "MATERIALS", "OILS", "PAIRS", "Entry", "Value", "text"]


def text(name: str) -> str | None:
    """Return the library or the entry called `name` as text, or None if there is neither."""
    if name in LIBRARIES:
        return "\n\n".join(listed(entry) for entry in LIBRARIES[name].values())
    entries = [library[name] for library in LIBRARIES.values() if name in library]
    return "\n\n".join(map(listed, entries)) or None


def names() -> tuple[str, ...]:
    """Return every name that `text` accepts."""
    return (*LIBRARIES, *(name for library in LIBRARIES.values() for name in library))


def entry(library: Mapping[str, Entry], name: str) -> Entry:
    """Return an entry by its name in any letter case.  Raises InputError with the nearest name."""
    folded = {" ".join(name.split()).casefold(): name for name in library}
    known = folded.get(" ".join(name.split()).casefold())
    if known is None:
        kind = next(kind for kind, each in LIBRARIES.items() if each is library)
        hint = nearest(name, library)
        raise InputError(f"unknown name {shown(name)}{hint} (`clearsweep list {kind}` prints all {len(library)})")
    return library[known]
