"""The progress of a worker in its batch: a temporary file that the parent and `status` read."""

import contextlib
import os
from pathlib import Path

from ..language import phases
from ..language.wording import short_id
from . import durable
from .directory import SCRATCH


class Working:
    """The file in which a worker keeps its progress; `name` is that of its batch or of its preparation."""

    def __init__(self, directory: Path, name: str):
        """Prepare for a batch or preparation called `name` of the run in a directory."""
        self.path = durable.scratch_file(directory / SCRATCH, f"{name}.work")

    def replace_progress(self, content: bytes | None) -> None:
        """Replace the stored progress, which need not survive a crash; for None, remove the file."""
        with contextlib.suppress(OSError):  # a full disk, of which the batch itself reports
            if content is None:
                durable.discard(self.path)
            else:
                durable.overwrite_temporary(self.path, content)

    def read(self) -> phases.Progress | None:
        """Return the present progress, or None."""
        try:
            return phases.stored_progress(durable.read(self.path))
        except OSError:
            return None


def read_workers(directory: Path) -> list[phases.Progress]:
    """Return the progress of every worker of a run."""
    scratch = directory / SCRATCH
    names = sorted(os.listdir(scratch)) if scratch.is_dir() else []
    batches = (durable.batch_of_progress(name) for name in names)
    workers = (Working(directory, name).read() for name in batches if name)
    return [progress for progress in workers if progress]


def case_text(progress: phases.Progress) -> str:
    """Return the progress of a case as 'case 2 of 4 (3a0ed69e): block 7, 31 um of 50 um, 2 min spent, ...'."""
    facts = progress.facts
    if "case_id" not in facts:
        return progress.text
    return f"case {facts['case']:,} of {facts['cases']:,} ({short_id(facts['case_id'])}): {progress.text}"
