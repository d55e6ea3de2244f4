"""A sample of a run in blocks, used like a run: random rows and the extremes of every column, in little memory."""

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from .batch import GROUP_ROWS
from .columns import values_of
from .datasets import EVENT, read_values
from .read import EVENT_COLUMNS, OFFSETS_BY_ITEM
from .read_blocks import BlockedRun, OneBlock, to_frame

if TYPE_CHECKING:
    import pandas as pd


class SampledRun(BlockedRun):
    """A sample of a run in blocks; its rows are sorted by case_id.  Counts of all cases are in `marks`."""

    def __init__(self, run: BlockedRun):
        """Take the run."""
        self.whole = run
        self.directory, self.files_directory, self.grid, self.layout = (
            run.directory,
            run.files_directory,
            run.grid,
            run.layout,
        )
        self.block_runs, self._marks = run.block_runs, run.marks()
        all_rows = pa.concat_tables([table for _, table in self.sampled_parts()])
        self._table_of_sample = all_rows.take(pc.sort_indices(all_rows, [("case_id", "ascending")])).combine_chunks()

    def __len__(self) -> int:
        return len(self._table_of_sample)

    @cached_property
    def frame(self) -> "pd.DataFrame":
        """Return the rows of the sample as a DataFrame."""
        return to_frame(self._table_of_sample)

    @property
    def summary(self) -> "pd.DataFrame":
        """Return the rows of the sample as a DataFrame."""
        return self.frame

    def column(self, name: str) -> "pd.Series":
        """Return one column of the sample."""
        import pandas as pd

        return pd.Series(values_of(self._table_of_sample[name].combine_chunks()), name=name)

    def blocks(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield columns of the sample, name -> values, for a few thousand rows at a time."""
        for first in range(0, len(self), GROUP_ROWS):
            rows = self._table_of_sample.slice(first, GROUP_ROWS)
            yield {name: values_of(rows[name].combine_chunks()) for name in columns}

    def event_blocks(self) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Yield the results of `StoredRun.event_blocks` for the whole sample at once."""
        ids: list[str] = []
        events: list[dict[str, np.ndarray]] = []
        for part, table in self.sampled_parts():
            sampled = table["case_id"].to_pylist()
            ids += sampled
            events += _events(part, [int(case_id, 16) for case_id in sampled])
        order = sorted(range(len(ids)), key=ids.__getitem__)
        counts = np.array([len(events[number]["t"]) for number in order], int)
        yield (
            counts,
            {
                name: np.concatenate([np.empty(0), *(events[number][name] for number in order)])
                for name in EVENT_COLUMNS
            },
        )


def _events(part: OneBlock, identities: list[int]) -> list[dict[str, np.ndarray]]:
    """Return the events of some cases of a block, by identity; consecutive rows are read at once."""
    row_indices = np.searchsorted(part.numbers, np.array(identities, "u8"))
    events: list[dict[str, np.ndarray]] = [{name: np.empty(0) for name in EVENT_COLUMNS} for _ in identities]
    with part.orbits() as file:
        if not part.histories or not len(row_indices):
            return events
        offsets = file[OFFSETS_BY_ITEM[EVENT]][:]
        runs = np.split(np.arange(len(row_indices)), np.flatnonzero(np.diff(row_indices) != 1) + 1)
        for run in runs:
            start, stop = int(offsets[row_indices[run[0]]]), int(offsets[row_indices[run[-1]] + 1])
            values = {name: read_values(file, f"events/{name}", slice(start, stop)) for name in EVENT_COLUMNS}
            for row in run.tolist():
                span = slice(int(offsets[row_indices[row]]) - start, int(offsets[row_indices[row] + 1]) - start)
                events[row] = {name: values[name][span] for name in EVENT_COLUMNS}
    return events
