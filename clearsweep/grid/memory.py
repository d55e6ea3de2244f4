"""Checks that the time histories of cases fit into memory and on disk."""

import os

from ..contracts.case import Save
from ..contracts.layout import MOST_REVOLUTIONS, Column, Layout
from ..language.errors import InputError
from .grid import Grid

COPIES = 2.0  # copies of a case's histories in memory: as recorded, and by channel


def history_bytes(layout: Layout, save: Save, revolutions: float) -> float:
    """Return the bytes of history that a case of so many revolutions records, without events."""
    return _bytes(layout, layout.channels, save, revolutions)


def _bytes(layout: Layout, channels: tuple[Column, ...], save: Save, revolutions: float) -> float:
    saved_turns = {"none": 0.0, "last": save.revolutions, "all": revolutions}[save.orbits]
    if not layout.turns and save.orbits != "none":
        saved_turns = 1.0  # samples are per run, not per revolution
    sections = min(revolutions, MOST_REVOLUTIONS) * len(layout.sections) if save.orbits != "none" else 0.0
    return float(8.0 * (saved_turns * save.samples * len(channels) + sections))


def first_case_history(grid: Grid) -> float:
    """Return the most bytes of history that the first case of a grid stores, without events."""
    case = grid.case(0)
    lasting = case.simulate.until or case.life
    revolutions = lasting.max_revolutions if lasting else case.simulate.revolutions
    return _bytes(grid.layout, grid.layout.stored, case.save, revolutions)


def largest_history(grid: Grid) -> float:
    """Return the least bytes of history that the longest case of a grid stores, without events."""
    return _bytes(grid.layout, grid.layout.stored, grid.case(0).save, _longest(grid))


def recorded_history(grid: Grid) -> float:
    """Return the bytes of history that the longest case of a grid has in memory, without events."""
    return history_bytes(grid.layout, grid.case(0).save, _longest(grid))


def _longest(grid: Grid) -> float:
    """Return the most revolutions that a case of a grid runs."""
    lengths = grid.axes.get("simulate.revolutions", (grid.case(0).simulate.revolutions,))
    return float(max(lengths))


def check_memory(size: float) -> None:
    """Raise InputError if the histories of a case, `size` bytes, do not fit into memory."""
    memory = float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    if COPIES * size > memory:
        raise InputError(
            f"save.orbits: the time histories of one case take {size / 1e9:,.4g} GB and twice that while it runs; this "
            f"machine has {memory / 1e9:,.4g} GB: save the last revolutions only (orbits: last), or fewer samples"
        )


def check_disk(size: float, free_bytes: float) -> None:
    """Raise InputError if all histories, `size` bytes in batches and again when merged, exceed `free_bytes` bytes."""
    if COPIES * size > free_bytes:
        raise InputError(
            f"save.orbits: the time histories of all cases take {size / 1e9:,.4g} GB and as much again while they are "
            f"merged; there the disk has {free_bytes / 1e9:,.4g} GB left: save fewer revolutions, samples or "
            "channels (save.channels), or none (orbits: none)"
        )
