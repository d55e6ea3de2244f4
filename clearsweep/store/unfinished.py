"""State of a long case until its row is committed, from which it resumes after its process was killed."""

import hashlib
from pathlib import Path

from . import durable
from .directory import SCRATCH


class Unfinished:
    """The log of a case: a temporary file, replaced as a whole, named by the identity of the case."""

    def __init__(self, directory: Path, case_id: str):
        """Prepare for a case of the run in a directory."""
        self.scratch = directory / SCRATCH
        self.path = durable.life_log(self.scratch, case_id)

    def read(self) -> bytes | None:
        """Return the last content, or None if there is none, or if it is damaged."""
        try:
            content = durable.read(self.path)
        except FileNotFoundError:
            return None
        checksum, _, payload = content.partition(b"\n")
        return payload if checksum == _checksum(payload) else None

    def keep(self, content: bytes) -> None:
        """Replace the content atomically."""
        with durable.storing(self.path):
            durable.replace(self.path, _checksum(content) + b"\n" + content, self.scratch)

    def discard(self) -> None:
        """Remove the content."""
        durable.discard(self.path)


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
