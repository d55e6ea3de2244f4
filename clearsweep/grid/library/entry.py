"""One entry of a library: its values, each with a range."""

from collections.abc import Mapping
from typing import NamedTuple


class Value(NamedTuple):
    """A typical value and its range, in SI."""

    unit: str
    typical: float
    low: float
    high: float


class Entry(NamedTuple):
    """A material, an oil or a wear pair."""

    name: str
    summary: str
    values: Mapping[str, Value]  # by key
    source: str
    checked: str  # which values were compared with a published text, and which text
