"""Shards: a grid cut into parts that run apart, with nothing between them but the grid."""

import re
from typing import NamedTuple

import numpy as np

from ..errors import InputError


class Shard(NamedTuple):
    """One of `of` parts of a grid's cases, counted from 1."""

    index: int
    of: int

    @classmethod
    def read(cls, text: str) -> "Shard":
        """Return the shard that a text such as '2/8' names."""
        found = re.fullmatch(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", str(text))
        shard = cls(*map(int, found.groups())) if found else cls(0, 0)
        if not 1 <= shard.index <= shard.of:
            raise InputError(f"shard: found {text!r}; expected I/N with I from 1 to N, such as 2/8")
        return shard

    def __str__(self):
        return f"{self.index}/{self.of}"

    def ids(self, ids: np.ndarray) -> np.ndarray:
        """Return the identities of the cases in this shard.

        It is every N-th of the sorted identities.  These are hashes, so that every axis is spread over all shards and
        none of them gets the slow cases alone.
        """
        return np.unique(ids)[self.index - 1 :: self.of]
