"""Results on disk: batches that are committed one by one, merged into one summary and one file of orbits, read again."""

from clearsweep.store.directory import Store, commit, id_text, now
from clearsweep.store.form import Axis, Form, Row
from clearsweep.store.merge import merge
from clearsweep.store.reading import Run, newest

__all__ = ["Axis", "Form", "Row", "Run", "Store", "commit", "id_text", "merge", "newest", "now", "open"]


def open(directory) -> Run:
    """Return the run in `directory`: its summary, orbits, events and wear."""
    return Run(directory)
