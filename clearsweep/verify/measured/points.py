"""The reference points of the benchmarks, and the rows of the comparison."""

import functools
import json
from collections.abc import Callable, Mapping
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = ("measured", "published", "remembered")
FILE = "measured.json"  # benchmark -> kind, source, note, points: [[point, quantity, unit, value], ...]


class Row(NamedTuple):
    """One reference figure and its computed value."""

    benchmark: str
    kind: str  # measured, published or remembered
    source: str
    point: str  # value of the varied quantity, with its name
    quantity: str
    unit: str
    reference: float
    computed: float | None  # None if the model has no such figure
    difference: float | None  # computed minus reference, in the unit
    variant: str = ""  # law used, if there are several


class Benchmark(NamedTuple):
    """A comparison with one source or a few: a section of the page."""

    key: str  # name of the file of its picture
    name: str
    text: str  # subject, agreements, disagreements and their causes
    measure: Callable[..., list[Row]]  # (quick: bool) -> its rows
    picture: "Callable[[list[Row]], Figure] | None" = None  # for rows of which a table is not enough


class Reference(NamedTuple):
    """The points of one source."""

    benchmark: str
    kind: str
    source: str
    note: str  # remark for readers on these points
    points: tuple[tuple[str, str, str, float], ...]  # point, quantity, unit, value

    def row(self, index: int, computed: float | None, variant: str = "") -> Row:
        """Return the Row of a point."""
        point, quantity, unit, value = self.points[index]
        difference = None if computed is None else computed - value
        return Row(self.benchmark, self.kind, self.source, point, quantity, unit, value, computed, difference, variant)

    def rows(self, computed: Mapping[tuple[str, str], float | None], variant: str = "") -> list[Row]:
        """Return the rows of all points; `computed`: (point, quantity) -> value; missing points are omitted."""
        return [
            self.row(i, computed[point, quantity], variant)
            for i, (point, quantity, _, _) in enumerate(self.points)
            if (point, quantity) in computed
        ]

    def values(self, quantity: str) -> dict[str, float]:
        """Return point -> value of a quantity."""
        return {point: value for point, name, _, value in self.points if name == quantity}


@functools.cache
def _read_references() -> dict[str, Any]:
    """Return the content of FILE."""
    file = resources.files(__package__).joinpath("..", "references", FILE)
    points: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return points


def read_reference(benchmark: str, name: str = "") -> Reference:
    """Return the Reference of a benchmark; `name` selects one of several."""
    entry = _read_references()[f"{benchmark}/{name}" if name else benchmark]
    points = tuple((str(point), quantity, unit, float(value)) for point, quantity, unit, value in entry["points"])
    return Reference(benchmark, entry["kind"], entry["source"], entry["note"], points)
