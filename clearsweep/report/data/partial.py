"""Opens an unfinished run: its finished cases are assembled as if it had ended with them."""

import dataclasses
import shutil
import tempfile
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from ... import grid as grids
from ... import simulation, store
from ...contracts.catalogue import Catalogue
from ...language import phases
from ...language.errors import DirectoryError

Run = TypeVar("Run", bound=store.StoredRun)


def open_partial(
    directory: Path, open_run: Callable[[Path, Path], Run], catalogue: Callable[[], Catalogue] = simulation.catalogue
) -> Run:
    """Return the result of `open_run` for a directory and a place where its finished cases are assembled.

    Raise DirectoryError without a finished case.
    """
    folder = Path(tempfile.mkdtemp(prefix="clearsweep-"))
    try:
        with phases.phase("assembling the finished cases"):
            _assemble(directory, folder / "run", catalogue())
        run = open_run(directory, folder / "run")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(run, shutil.rmtree, folder, ignore_errors=True)
    return run


def _assemble(directory: Path, target: Path, catalogue: Catalogue) -> None:
    """Write the run of the cases finished so far in a directory to `target`."""
    record, source = store.read_record(directory), store.RunDirectory(directory)
    source.expect(store.ResultSchema.of_record(record))
    source.load_batches(contents=True)
    if not source.batches:
        raise DirectoryError(f"{directory}: no case of its run is finished yet; `status` prints its progress")
    grid = grids.load(store.keys_so_far(record, source), catalogue)
    store.check_version(directory, record, grid)
    grid = dataclasses.replace(grid, **grids.as_written(record))
    store.gather(source, grid, np.unique(np.fromiter(grid.identities(), "u8", len(grid))), target)
