"""Results on disk: batches are committed one by one, then merged into one summary and one file of orbits."""

from pathlib import Path

import pyarrow

from . import blocks
from .batch import Axis, ResultSchema, Row, release_memory
from .blocks import Block, Division, discard_from, finish_block, read_mark, sha256_of, sum_counts
from .dataset import BlockedRun, SampledRun, unmark_damaged
from .datasets import id_text
from .directory import ANSWER_FILE, BLOCKS, FINAL_FILES, SCRATCH, OtherGridError, RunDirectory, commit
from .merged import Worst, keep_histories_once, merge
from .parts import Part
from .read import StoredRun, newest_run, verify
from .record import (
    check_format,
    difference_lines,
    differing,
    grid_changes,
    grid_record,
    json_round_trip,
    read_record,
    utc_now,
)
from .results import (
    answer_of,
    check_version,
    commit_answer,
    difference,
    gather,
    is_unfinished,
    keys_of_all,
    keys_so_far,
    read_histories,
    read_results,
    write_search_table,
)
from .state import Unfinished, Working, case_text, clean, clean_text, status, status_text


def open(directory: str | Path) -> StoredRun:
    """Return the run in `directory`: its summary, orbits, events and wear; raise DirectoryError if there is none."""
    return BlockedRun(directory) if is_cut(directory) else StoredRun(directory)


def block_size() -> int:
    """Return the number of consecutive cases in a block."""
    return blocks.BLOCK


def is_cut(directory: str | Path) -> bool:
    """Return whether the run in a directory is divided into blocks; raise DirectoryError if there is none."""
    return "blocks" in read_record(Path(directory))


def use_one_thread() -> None:
    """Keep the readers and writers of this process to one thread."""
    pyarrow.set_cpu_count(1)
    pyarrow.set_io_thread_count(1)
