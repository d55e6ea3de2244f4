"""Cases on their way from a driver to a worker."""

from typing import NamedTuple

import numpy as np


class Task(NamedTuple):
    """A case for a worker, which generates its values itself to relieve the parent."""

    case_id: str
    grid_index: int


class Tasks:
    """Cases on their way to a worker, as two arrays: a driver would need longer for a `Task` each than for all else."""

    def __init__(self, indices: np.ndarray, ids: np.ndarray):
        """Take the indices and the identities, uint64, of the cases, both (cases,)."""
        self.indices, self.ids = indices, ids

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, position: int) -> Task:
        return Task(f"{int(self.ids[position]):016x}", int(self.indices[position]))

    def part(self, first: int, last: int | None = None) -> "Tasks":
        """Return the cases from one place to another, default the end."""
        return Tasks(self.indices[first:last], self.ids[first:last])

    def without(self, position: int) -> "Tasks":
        """Return all cases but the one at a place."""
        return Tasks(np.delete(self.indices, position), np.delete(self.ids, position))

    def listed(self) -> list[Task]:
        """Return the cases one by one."""
        pairs = zip(self.ids.tolist(), self.indices.tolist(), strict=True)
        return [Task(f"{number:016x}", index) for number, index in pairs]


class Batch(NamedTuple):
    """Cases that are computed and committed together."""

    name: str  # of its files
    cases: Tasks
    attempts: int = 0  # how often it was lost with its worker
