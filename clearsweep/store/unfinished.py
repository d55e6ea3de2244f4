"""What a long case keeps until its row is committed, so that it goes on where a killed process left it."""

import hashlib
from pathlib import Path

from . import durable
from .directory import SCRATCH


class Unfinished:
    """The log of one case: one file among those that pass, replaced as a whole, named by the identity of the case."""

    def __init__(self, directory: Path, case_id: str):
        """Take the directory of the run and the case."""
        self.scratch = directory / SCRATCH
        self.path = durable.kept(self.scratch, case_id)

    def read(self) -> bytes | None:
        """Return what was kept last; None where nothing was, or it is not what was written."""
        try:
            content = durable.read(self.path)
        except FileNotFoundError:
            return None
        checksum, _, rest = content.partition(b"\n")
        return rest if checksum == _checksum(rest) else None

    def keep(self, content: bytes) -> None:
        """Keep this in the place of what was kept before; a crash leaves one of them, whole."""
        with durable.storing(self.path):
            durable.replace(self.path, _checksum(content) + b"\n" + content, self.scratch)

    def discard(self) -> None:
        """Forget what was kept."""
        durable.discard(self.path)


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
