"""All cases that a directory holds as one run to read, also those that the grid last run has not."""

import contextlib
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .. import grid as grids
from .. import store
from ..grid.refined import REFINE
from ..grid.sought import SEEK
from ..grid.variations import WAYS
from .crew import Crew, Options
from .simulator import SIMULATION
from .sweep import conclude, facts
from .worker import Simulator


@contextlib.contextmanager
def everything(directory: str | Path, simulator: Simulator = SIMULATION) -> Iterator[store.StoredRun]:
    """Yield the run that would have left every case that is committed in `directory`.

    It is put together in a passing directory, which takes as much room as those cases; `directory` stays as it is.
    Raises DirectoryError where there is no run.
    """
    record = store.read_record(Path(directory))
    source = store.RunDirectory(directory)
    source.look()
    with tempfile.TemporaryDirectory(prefix="clearsweep-") as passing:
        unvaried = {key: record[key] for key in record["keys"] if key not in (*WAYS, SEEK, REFINE)}
        grid = grids.load(unvaried | _ways(record, source), simulator.catalogue())
        target = store.RunDirectory(Path(passing) / "run")
        with target.open_for(grid), Crew(target, Options(), simulator) as crew:
            target.take(source)
            derived, warnings = facts(grid, simulator)
            known = {"source": record["source"], "derived": derived, "warnings": warnings}
            conclude(crew, grid, target.rows()["id"], start=record["start"], **known)
        yield store.open(target.path)


def _ways(record: dict[str, Any], source: store.RunDirectory) -> dict[str, Any]:
    """Return the part of a grid that has all cases of a directory: their values, axis by axis or case by case."""
    paths = list(record["units"])  # in the order of the columns
    if not paths:
        return {}
    columns: dict[str, list[Any]] = {path: [] for path in paths}
    for batch in source.batches:
        with store.open_table(batch.summary) as table:
            rows = table.read(paths, use_threads=False)
        for path in paths:
            columns[path] += rows.column(path).to_pylist()
    first = {path: record.get("sweep", {}).get(path, []) for path in paths}
    axes = {path: list(dict.fromkeys(_present([*first[path], *columns[path]]))) for path in paths}
    if (
        "sweep" in record
        and not {*WAYS[1:], SEEK, REFINE} & record.keys()
        and math.prod(map(len, axes.values())) < 1_000_000
    ):
        return {"sweep": axes}
    different = dict.fromkeys(zip(*columns.values(), strict=True))
    return {"cases": dict(zip(columns, map(list, zip(*different, strict=True)), strict=True))}


def _present(values: list[Any]) -> list[Any]:
    """Return values that are used, numbers in order of size."""
    used = [value for value in values if value is not None]
    return used if any(isinstance(value, str) for value in used) else sorted(used)
