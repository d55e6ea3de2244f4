"""Shards: parts of a grid that run independently on separate machines."""

import re
from typing import NamedTuple

import numpy as np

from ...language.errors import InputError


class Shard(NamedTuple):
    """One of `of` parts of a grid's cases, counted from 1."""

    number: int
    of: int

    @classmethod
    def read(cls, text: str) -> "Shard":
        """Return the shard for a text such as '2/8'; raise InputError for any other text."""
        match = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", str(text))
        shard = cls(*map(int, match.groups())) if match else cls(0, 0)
        if not 1 <= shard.number <= shard.of:
            raise InputError(f"shard: found {text!r}; expected I/N with I from 1 to N, such as 2/8")
        return shard

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    def ids(self, ids: np.ndarray) -> np.ndarray:
        """Return the identities of this shard's cases, uint64, from those of all cases.

        They are every N-th of the sorted identities.  These are hashes, so every axis is spread over all shards and
        no shard gets all slow cases.
        """
        return distinct(ids)[self.number - 1 :: self.of].copy()  # a copy, not a view


def distinct(ids: np.ndarray) -> np.ndarray:
    """Return the distinct identities, ascending; np.unique needs five times the memory for a million."""
    ordered = np.sort(ids)
    is_repeated = ordered[1:] == ordered[:-1]
    return ordered[np.concatenate([[True], ~is_repeated])] if is_repeated.any() else ordered
