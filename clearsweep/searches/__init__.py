"""The searches: each is a class with its section of a grid, its cases and its answer, registered in SEARCHES.

A sweep runs a search in rounds.  Added cases are ordinary cases.  So stored ones are not run again, and the same
results lead to the same cases however often the run was interrupted.
"""

from collections.abc import Mapping
from typing import Any

from ..contracts.search import Search
from .check_laws import CheckLaws, OwnRows, base_laws
from .identify import Identify
from .optimise import SENSES, Optimise
from .refine import Refine
from .seek import Seek

__all__ = ["SEARCHES", "SENSES", "OwnRows", "base_laws", "search_of"]

#: Those that a grid may have, in the order of the page of keys.
SEARCHES: tuple[type[Search], ...] = (Seek, Refine, Optimise, Identify, CheckLaws)


def search_of(record: Mapping[str, Any]) -> type[Search] | None:
    """Return the kind of search of a run, from its run.json, or None without one."""
    return next((search for search in SEARCHES if record.get(search.name)), None)
