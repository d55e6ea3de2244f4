"""What a grid makes of its cases' columns: figures of its own, and which cases keep to its limits, by what margin."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from ..contracts.layout import Column
from ..language import expression, wording

if TYPE_CHECKING:
    import numpy as np  # loaded only where cases are judged

EXCEEDED, MARGIN = "limits_exceeded", "margin"  # columns
KINDS = ("at_most", "at_least")


class Limit(NamedTuple):
    """A bound on a column."""

    column: str
    kind: str  # one of KINDS
    value: float  # SI, of the column's unit over that of `times`
    times: str = ""  # another column, whose multiple the bound is; '' for none

    def words(self, unit: str) -> str:
        """Return the bound in words, where the column is in `unit`: 'at most 5 kN', 'at least 2 times NAME'."""
        scale = wording.scale("1" if self.times else unit, self.value)
        bound = scale.given(self.value) + (f" times {self.times}" if self.times else "")
        return f"{self.kind.replace('_', ' ')} {bound}"

    def bound(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return the bound of every case, in the unit of the column; NaN where it is a multiple of what is null."""
        import numpy as np

        given = columns[self.times] if self.times else np.ones(len(columns[self.column]))
        found: np.ndarray = self.value * given
        return found

    def short_by(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return how far (in the column's unit) each case is on the good side of the bound, negative beyond it."""
        off: np.ndarray = self.bound(columns) - columns[self.column]
        return off if self.kind == "at_most" else -off

    def margin(self, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
        """Return 1 - value / limit of every case, of `at_least` value / limit - 1; NaN where the limit is zero."""
        import numpy as np

        with np.errstate(all="ignore"):
            size = np.abs(self.bound(columns))
            found: np.ndarray = np.where(size > 0.0, self.short_by(columns) / size, np.nan)
        return found


class Own(NamedTuple):
    """A figure of a grid's own."""

    name: str
    text: str  # expression of columns
    unit: str  # SI


class Verdict(NamedTuple):
    """All that a grid makes of columns."""

    figures: tuple[Own, ...] = ()
    limits: tuple[Limit, ...] = ()

    @property
    def columns(self) -> tuple[Column, ...]:
        """Return the columns that it adds to a summary."""
        found = [Column(own.name, own.unit, f"own figure: {own.text}") for own in self.figures]
        if self.limits:
            found += [
                Column(EXCEEDED, "", "the columns whose limits the case exceeds, comma separated", "text"),
                Column(MARGIN, "1", "smallest of 1 - value/limit, of at_least value/limit - 1; null: none is known"),
            ]
        return tuple(found)

    def needs(self) -> set[str]:
        """Return the columns that it is made of."""
        own = {figure.name for figure in self.figures}
        used = {name for figure in self.figures for name in expression.names_in(figure.text)}
        used |= {name for limit in self.limits for name in (limit.column, limit.times) if name}
        return used - own

    def of_case(self, summary: Mapping[str, Any], *, failed: bool = False) -> dict[str, Any]:
        """Return what it adds to the summary of one case, None for null there and here."""
        if not (self.figures or self.limits):
            return {}
        if failed:
            return dict.fromkeys(column.name for column in self.columns)
        import numpy as np

        known = {name: summary[name] for name in self.needs()}
        added = self.judge({name: np.array([np.nan if value is None else value]) for name, value in known.items()})
        return {name: None if values[0] != values[0] else values.tolist()[0] for name, values in added.items()}

    def judge(self, columns: "Mapping[str, np.ndarray]") -> "dict[str, np.ndarray]":
        """Return what it adds to the columns (n,) of some finished cases, NaN for null there and here.

        A limit on what is null is not exceeded and has no margin.
        """
        import numpy as np

        known, added = dict(columns), dict[str, np.ndarray]()
        for own in self.figures:
            added[own.name] = known[own.name] = expression.value_of(own.text, known)
        if self.limits:
            with np.errstate(invalid="ignore"):
                beyond = {limit.column: np.zeros(len(known[limit.column]), bool) for limit in self.limits}
                for limit in self.limits:
                    beyond[limit.column] |= limit.short_by(known) < 0.0
            table = np.array(list(beyond.values()))
            names = np.array(list(beyond), object)
            added[EXCEEDED] = np.array([",".join(names[case]) for case in table.T], object)
            margins = np.array([limit.margin(known) for limit in self.limits])
            added[MARGIN] = np.where(np.isnan(margins).all(axis=0), np.nan, np.fmin.reduce(margins, axis=0))
        return added


NO_VERDICT = Verdict()


def limits_of(written: Mapping[str, Any]) -> tuple[Limit, ...]:
    """Return the limits that a resolved grid holds: a column -> a number, or a mapping of KINDS and 'times', in SI."""
    found = []
    for column, bound in written.items():
        bounds = bound if isinstance(bound, Mapping) else {KINDS[0]: bound}
        found += [Limit(column, kind, bounds[kind], bounds.get("times", "")) for kind in KINDS if kind in bounds]
    return tuple(found)


def of_record(record: Mapping[str, Any]) -> Verdict:
    """Return what a grid, as run.json holds it, makes of its cases' columns."""
    units = {column["name"]: column["unit"] for column in record["layout"]["columns"]}
    return Verdict(figures_of(record.get("figures") or {}, units), limits_of(record.get("limits") or {}))


def figures_of(written: Mapping[str, str], units: Mapping[str, str]) -> tuple[Own, ...]:
    """Return a grid's own figures, each of columns and those before it; InputError where one cannot be read."""
    known, found = dict(units), []
    for name, text in written.items():
        known[name] = expression.unit_of(text, known)
        found.append(Own(name, text, known[name]))
    return tuple(found)
