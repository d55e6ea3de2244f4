"""Cases that a driver sends to a worker."""

from typing import NamedTuple

import numpy as np


class Task(NamedTuple):
    """A case for a worker, which generates its values itself to relieve the parent."""

    case_id: str
    grid_index: int


class Tasks:
    """Cases for a worker, as two arrays: creating a `Task` for each would take a driver most of its time."""

    def __init__(self, indices: np.ndarray, ids: np.ndarray):
        """Take the indices and the identities, uint64, of the cases, both (cases,)."""
        self.indices, self.ids = indices, ids

    def __len__(self) -> int:
        return len(self.indices)

    def __getitem__(self, position: int) -> Task:
        return Task(f"{int(self.ids[position]):016x}", int(self.indices[position]))

    def part(self, first: int, last: int | None = None) -> "Tasks":
        """Return the cases from position `first` up to but not including `last`; default: to the end."""
        return Tasks(self.indices[first:last], self.ids[first:last])

    def without(self, position: int) -> "Tasks":
        """Return all cases except the one at a position."""
        return Tasks(np.delete(self.indices, position), np.delete(self.ids, position))

    def listed(self) -> list[Task]:
        """Return the cases as a list of tasks."""
        pairs = zip(self.ids.tolist(), self.indices.tolist(), strict=True)
        return [Task(f"{number:016x}", index) for number, index in pairs]


class Batch(NamedTuple):
    """Cases that are computed and committed together."""

    name: str  # of its files
    cases: Tasks
    attempts: int = 0  # how often it was lost with its worker
