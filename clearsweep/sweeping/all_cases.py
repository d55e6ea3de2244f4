"""All cases in a directory as one run to read, including those of earlier grids."""

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path

from .. import grid as grids
from .. import store
from ..language import phases
from .pool.case_runner import CaseRunner, Options
from .pool.simulator import SIMULATION
from .pool.worker import Simulator
from .sweep import conclude, facts


@contextlib.contextmanager
def complete_run(directory: str | Path, simulator: Simulator = SIMULATION) -> Iterator[store.StoredRun]:
    """Yield a run that contains every committed case in `directory`.

    The run is assembled in a temporary directory, which needs as much space as the cases; `directory` is not changed.
    Raises DirectoryError if there is no run.
    """
    record = store.read_record(Path(directory))
    store.check_format(Path(directory), record)
    if "blocks" in record:  # all of its blocks belong to the last grid
        yield store.open(directory)
        return
    source = store.RunDirectory(directory)
    with phases.phase("reading the directory"):
        source.expect(store.ResultSchema.of_record(record))
        source.load_batches(contents=True)
    with tempfile.TemporaryDirectory(prefix="clearsweep-") as folder:
        grid = grids.load(store.keys_of_all(record, source), simulator.catalogue())
        store.check_version(Path(directory), record, grid)
        target = store.RunDirectory(Path(folder) / "run")
        with target.open_for(grid), CaseRunner(target, Options(), simulator) as case_runner:
            target.link_batches(source)
            derived, warnings = facts(grid, simulator)
            outcome_facts = {"source": record.get("source"), "derived": derived, "warnings": warnings}
            conclude(case_runner, grid, target.rows()["id"], start=record.get("start"), **outcome_facts)
        yield store.open(target.path)
