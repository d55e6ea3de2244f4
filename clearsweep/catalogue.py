"""How a law and the numbers it takes are described; what there is to choose from."""

from math import inf
from typing import NamedTuple


class Field(NamedTuple):
    """One number a user writes."""

    name: str
    unit: str  # SI unit of the value, '1' for none; 'N/m^exponent' depends on the key `exponent` beside it
    text: str = ""  # one line: what it is
    low: float = 0.0
    high: float = inf
    low_open: bool = True  # `low` itself is not allowed
    high_open: bool = True
    default: float | None = None  # None: required, unless `optional`
    optional: bool = False  # may be left out without a default, or with one that follows from other values
    whole: bool = False

    def allowed(self) -> str:
        """Return the range in words: 'above 0 and at most 1'."""
        parts = []
        if self.low > -inf:
            parts.append(f"{'above' if self.low_open else 'at least'} {self.low:.15g}")
        if self.high < inf:
            parts.append(f"{'below' if self.high_open else 'at most'} {self.high:.15g}")
        unit = "" if self.unit == "1" else f" ({self.unit})"
        return ("a whole number " if self.whole else "") + (" and ".join(parts) or "any finite number") + unit

    def holds(self, value: float) -> bool:
        """Return whether `value`, in SI, is allowed."""
        above = value > self.low if self.low_open else value >= self.low
        below = value < self.high if self.high_open else value <= self.high
        return above and below and (not self.whole or value == int(value))


class Range(NamedTuple):
    """What a law asks of a value that is not its own."""

    path: str  # within the joint, such as 'clearance'
    low: float  # allowed, like all between
    high: float
    unit: str  # SI
    reason: str


class Law(NamedTuple):
    """One law of a family, as a user names it."""

    family: str  # 'law' (contact.law), 'elastic', 'friction' (friction.law), 'wear' (wear.law), 'pressure'
    name: str
    summary: str
    formula: str
    source: str
    fields: tuple[Field, ...] = ()
    uses_elastic: bool = True  # family 'law': False where the law brings its own stiffness and takes no `elastic`
    notes: str = ""  # pitfalls
    needs: tuple[str, ...] = ()  # 'length', 'material', 'modulus': what has to be there besides the law's fields
    ranges: tuple[Range, ...] = ()


class Catalogue(NamedTuple):
    """All laws there are."""

    laws: tuple[Law, ...]

    def of(self, family: str) -> tuple[Law, ...]:
        """Return the laws of one family."""
        return tuple(law for law in self.laws if law.family == family)

    def names(self, family: str) -> tuple[str, ...]:
        """Return the names of one family's laws."""
        return tuple(law.name for law in self.of(family))

    def find(self, family: str, name: str) -> Law | None:
        """Return the law called `name`, or None."""
        return next((law for law in self.of(family) if law.name == name), None)
