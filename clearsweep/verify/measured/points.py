"""The reference points of the benchmarks, the rows of the comparison, and the page `measured.md` with its pictures."""

import functools
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from ruamel.yaml import YAML

from ...contracts.results import Trajectory
from ...grid.cases import put_values
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from ..text import table_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------------------------------------------------
# The reference points of the benchmarks, and the rows of the comparison.


KINDS = ("measured", "published", "remembered")


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
    measure: Callable[..., list[Row]]  # (quick: bool) -> its rows
    picture: "Callable[[list[Row]], Figure] | None" = None  # for rows of which a table is not enough

    @property
    def text(self) -> str:
        """Return subject, agreements, disagreements and their causes, from `references/measured.md`."""
        _, _, section = _read_text("measured.md").partition(f"\n## {self.name}\n")
        return section.partition("\n## ")[0].strip()


class Reference(NamedTuple):
    """The points of one source."""

    benchmark: str
    kind: str
    source: str
    note: str  # remark for readers on these points
    points: tuple[tuple[str, str, str, float], ...]  # point, quantity, unit, value

    @property
    def names(self) -> list[str]:
        """Return the names of the points, each once, in order."""
        return list(dict.fromkeys(point for point, *_ in self.points))

    def rows(self, computed: Mapping[tuple[str, str], float | None], variant: str = "") -> list[Row]:
        """Return the rows of all points; `computed`: (point, quantity) -> value; missing points are omitted."""
        rows = []
        for point, quantity, unit, reference in self.points:
            if (point, quantity) in computed:
                value = computed[point, quantity]
                difference = None if value is None else value - reference
                heads = self.benchmark, self.kind, self.source, point, quantity, unit
                rows.append(Row(*heads, reference, value, difference, variant))
        return rows

    def rows_at(self, computed: Mapping[str, Mapping[str, float | None]], variant: str = "") -> list[Row]:
        """Return the rows of some points; `computed`: point -> quantity -> value."""
        return self.rows(
            {(point, name): computed[point][name] for point in computed for name in computed[point]}, variant
        )

    def values(self, quantity: str) -> dict[str, float]:
        """Return point -> value of a quantity."""
        return {point: value for point, name, _, value in self.points if name == quantity}


def read_grid(name: str, values: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return a grid of `references/grids` as a dict, with some `values` (SI) at dotted paths."""
    return put_values(read_yaml(f"grids/{name}.yaml"), values or {})


def read_yaml(file: str) -> dict[str, Any]:
    """Return the content of a YAML file of `references`."""
    content: dict[str, Any] = YAML(typ="safe", pure=True).load(_read_text(file))
    return content


def run(source: dict[str, Any], failure: str, times: np.ndarray | None = None) -> Trajectory:
    """Return the run of a grid, sampled at `times` (s).  Raise RuntimeError with the text `failure` if it fails."""
    trajectory = simulate(load_case(source), times=times)
    if trajectory.status != "ok":
        raise RuntimeError(f"{failure}: {trajectory.message}")
    return trajectory


def _read_text(file: str) -> str:
    """Return the text of a file of `references`."""
    return resources.files(__package__).joinpath("..", "references", file).read_text(encoding="utf-8")


@functools.cache
def _read_references() -> dict[str, Any]:
    """Return benchmark -> kind, source, note, points: [[point, quantity, unit, value], ...]."""
    references: dict[str, Any] = json.loads(_read_text("measured.json"))
    return references


def read_reference(benchmark: str, name: str = "") -> Reference:
    """Return the Reference of a benchmark; `name` selects one of several."""
    entry = _read_references()[f"{benchmark}/{name}" if name else benchmark]
    points = tuple((str(point), quantity, unit, float(value)) for point, quantity, unit, value in entry["points"])
    return Reference(benchmark, entry["kind"], entry["source"], entry["note"], points)


# ----------------------------------------------------------------------------------------------------------------------
# The rows as fixed-width text and as the page `measured.md` with its pictures.


PICTURE_FOLDER = "measured"  # folder of the pictures, next to the page


def rows_text(rows: list[Row]) -> str:
    """Return the differences of each quantity of each benchmark from its reference."""
    spreads = []
    for group in group_rows(rows):
        name = ", ".join(filter(None, (group[0].benchmark, group[0].quantity, group[0].variant)))
        rms, largest = difference_spread(group)
        spreads.append(group[0]._asdict() | {"name": name, "points": len(group), "rms": rms, "largest": largest})
    columns = "benchmark and quantity {name} | kind {kind} | points {points} | rms {rms:.3g} | largest {largest:.3g}"
    lines = table_lines(f"{columns} | unit {{unit}}", spreads)
    count = len({row[:5] for row in rows})
    lines.append(f"{count} points; rms and largest: of the difference, computed minus reference")
    return "\n".join(lines)


def group_rows(rows: list[Row]) -> list[list[Row]]:
    """Return the rows that have a computed value, by source, quantity and variant."""
    by_key: dict[tuple, list[Row]] = {}
    for row in rows:
        if row.computed is not None:
            by_key.setdefault((row.benchmark, row.source, row.quantity, row.variant), []).append(row)
    return list(by_key.values())


def difference_spread(rows: list[Row]) -> tuple[float, float]:
    """Return the root mean square and the largest magnitude of the differences of rows."""
    differences = [abs(row.difference) for row in rows if row.difference is not None]
    return math.sqrt(sum(difference * difference for difference in differences) / len(differences)), max(differences)


def expected_difference(rows: list[Row]) -> float | None:
    """Return the magnitude below which 95 % of further differences are expected; None for a single point.

    It is the largest one, or the prediction interval of normal differences about zero if that is wider.
    """
    from scipy.stats import t

    (rms, largest), count = difference_spread(rows), len(rows)
    return max(largest, float(t.ppf(0.975, count)) * rms * math.sqrt(1.0 + 1.0 / count)) if count > 1 else None


def write_page(rows: list[Row], directory: str | Path, benchmarks: Sequence[Benchmark]) -> Path:
    """Write `measured.md` and its pictures below `directory`, a section for each benchmark; return its path."""
    directory = Path(directory)
    (directory / PICTURE_FOLDER).mkdir(parents=True, exist_ok=True)
    lines = list(_introduction(rows))
    for number, benchmark in enumerate(benchmarks, 1):
        selected = [row for row in rows if row.benchmark == benchmark.name]
        if not selected:
            continue
        lines += ["", f"## {number}. {benchmark.name}", "", benchmark.text]
        if benchmark.picture:
            file = f"{PICTURE_FOLDER}/{benchmark.key}.svg"
            benchmark.picture(selected).savefig(directory / file, metadata={"Date": None})
            lines += ["", f"![{benchmark.name}]({file})"]
        sources = dict.fromkeys((row.kind, row.source, row.benchmark) for row in selected)
        lines += ["", *(f"* {kind}: {source}." for kind, source, _ in sources), "", *_spreads(selected)]
    lines += ["", "## Every point", "", *_all_points(rows)]
    page = directory / "measured.md"
    page.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return page


def _introduction(rows: list[Row]) -> Iterator[str]:
    """Yield the introduction."""
    point_counts = {kind: len({row[:5] for row in rows if row.kind == kind}) for kind in KINDS}
    yield "# Comparison with measurements and published solutions"
    yield ""
    yield (
        f"Written by `clearsweep verify --measured --write`: {sum(point_counts.values())} points, of which "
        f"{point_counts['measured']} are measured, {point_counts['published']} published and "
        f"{point_counts['remembered']} remembered."
    )
    yield ""
    yield "* **measured**: an experiment; **published**: a table or a computation by others that we read;"
    yield "  **remembered**: a published table that we typed from memory."
    yield "* The spread is the root mean square and the largest size of the difference, computed minus reference."
    yield "* The last column is the size of the difference within which we expect 95 % of further points of the"
    yield "  same source: the largest difference, or the prediction interval from the rms, if that is wider."
    yield "  It applies between the points of this page, not beyond them."
    yield "* We fitted no parameter to the points, unless the section names one."
    yield "* We had no measured force of a mechanism with clearance. The page tests the ingredients of such a force:"
    yield "  contact, friction, film, linkage. [How far to trust a peak](../docs/trust.md) says what determines it."


def _spreads(rows: list[Row]) -> Iterator[str]:
    """Yield a table of the spread of rows."""
    yield "| quantity | by | kind | points | rms difference | largest | 95 % of further points within | unit |"
    yield "| --- | --- | --- | ---: | ---: | ---: | ---: | --- |"
    for group in group_rows(rows):
        rms, largest = difference_spread(group)
        first_row = group[0]
        numbers = (len(group), f"{rms:.3g}", f"{largest:.3g}", _number(expected_difference(group), 3))
        cells = (first_row.quantity, first_row.variant, first_row.kind, *numbers, first_row.unit)
        yield f"| {' | '.join(map(str, cells))} |"


def _all_points(rows: list[Row]) -> Iterator[str]:
    """Yield the table of all points."""
    yield "| benchmark | point | quantity | by | reference | computed | difference | unit |"
    yield "| --- | --- | --- | --- | ---: | ---: | ---: | --- |"
    for row in rows:
        numbers = (f"{row.reference:.6g}", _number(row.computed), _number(row.difference, 3))
        cells = (row.benchmark, row.point, row.quantity, row.variant, *numbers, row.unit)
        yield f"| {' | '.join(cells)} |"


def _number(value: float | None, digits: int = 6) -> str:
    return "-" if value is None else f"{value:.{digits}g}"


# ----------------------------------------------------------------------------------------------------------------------
# Colours and line styles of the pictures of results/measured.md.


COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#666666")  # Okabe and Ito 2008
REFERENCE_STYLE: dict[str, Any] = {
    "color": "black",
    "marker": "o",
    "markerfacecolor": "none",
    "linestyle": "",
    "zorder": 3,
}
LINE_STYLES: dict[str, dict[str, Any]] = {
    "reynolds": {"color": COLOURS[0]},
    "finite": {"color": COLOURS[1], "linestyle": "--"},
    "short": {"color": COLOURS[2], "linestyle": ":"},
}
