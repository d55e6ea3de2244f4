"""Reads grid files: checks them, converts to SI and enumerates cases.  Imports neither llvmlite nor numpy."""

import json
import os
import re
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ..contracts.case import Case, Save
from ..contracts.catalogue import Catalogue, Field, Law
from ..contracts.layout import MAX_REVOLUTIONS, Column, Layout
from ..language.errors import InputError, quoted
from ..language.wording import bytes_text
from .cases import KeyValue, LawAssignment
from .grid import SCHEMA_VERSION, CaseLabels, Grid, identity
from .keys.library_names import BEARING, COUNT, pair_warnings
from .keys.outline import key_units
from .library.fits import Fit
from .pages import key_names, key_text, markdown
from .pages.schema import schema
from .reading import check_channels, read_keys
from .reading.joint_checks import check_values
from .reading.values import as_written, assumed_units, written_units
from .sections import ADDED, Reader, added_rows
from .sections.fits import recorded_fits
from .sections.variations import labels_of_axes, recorded_labels, zipped_paths
from .written import (
    SET_OPTION,
    SWEEP_OPTION,
    OverriddenGrid,
    Problems,
    WrittenValue,
    apply_overrides,
    leaves,
    override,
    read_document,
    read_options,
)
from .written.definitions import NO_DEFINITIONS, Definitions, definitions_of_resolved, extended
from .written.law_execution import enter_law_files, guarded, has_run, reported, run_all
from .written.law_files import allowing, list_text, revoke, trust

_NAME_PATTERN = re.compile(r"\w[\w .+-]{0,99}")
SCHEMA_FILE = "clearsweep.schema.json"  # next to a grid that `init` writes
MAX_CASES = 200_000_000  # their summaries take about 100 GB
MAX_IDENTITIES = 20_000_000  # identities in memory where cases may repeat or are added: 160 MB and 100 s


def load(
    source: str | PathLike | Mapping | OverriddenGrid, catalogue: Catalogue, overrides: Mapping[str, Any] | None = None
) -> "Grid":
    """Return the checked grid in `source`: a path, a dict of the same form, or one with overrides.

    `overrides` maps dotted paths to values that replace those in the file; None removes a key.  A swept path that
    is overridden is no longer swept.  An InputError reports every mistake.
    """
    problems = Problems()
    overridden = source if isinstance(source, OverriddenGrid) else OverriddenGrid(source)
    source = overridden.source
    root = read_document(source, problems)
    if not isinstance(root.value, dict):
        raise InputError(
            f"{root.position_text}found {quoted(root.value)}; expected a grid with the keys mechanism, drive, joints"
        )
    if overrides is not None and not (
        isinstance(overrides, Mapping) and all(isinstance(path, str) for path in overrides)
    ):
        raise InputError(
            f"overrides: found {quoted(overrides)}; expected dotted paths and values, {{'drive.speed': '80 Hz'}}"
        )
    root = apply_overrides(extended(root, problems), overridden, problems)
    for path, value in (overrides or {}).items():
        root = override(root, path, value, problems)
    root, catalogue, law_files = enter_law_files(root, catalogue, problems)
    file = fspath(source) if isinstance(source, (str, PathLike)) else None
    name = _name_of_run(root, file, problems)
    reader = read_keys(root, catalogue, problems, frozenset({*(overrides or ()), *overridden.fixed}))
    check_values(reader, catalogue)
    problems.check()
    search = reader.search
    zipped = {reader.varied_by[paths[0]]: paths for paths in zipped_paths(reader)}
    if search and search.varied_paths and not search.in_step:
        zipped[search.name] = search.varied_paths
    drawn = {path: reader.distributions[path] for path in reader.drawn_paths}
    grid = Grid(
        name,
        file,
        reader.axes | (search.first() if search else {}),
        reader.limits,
        reader.user_figures,
        reader.keys_in_use,
        reader.values,
        frozenset(reader.written),
        reader.names,
        zipped,
        reader.sample.resolved() | {"over": drawn} if reader.sample else {},
        reader.outline,
        {path: tuple(entries) for path, entries in reader.fits.items()},
        assumed_units(reader),
        search,
        reader.uncertain,
        added_rows(reader),
        tuple(reader.library_numbers.values()),
        reader.defined,
        written_units(reader),
        labels_of_axes(reader),
        reader.varied_names,
        reader.roles,
        reader.case_labels,
        law_files,
        (*reader.warnings, *pair_warnings(reader.library_numbers.values())),
    )
    _check_cases(grid, reader, catalogue)
    layout = Layout.of(grid.case_at(_point_of_layout(grid)), catalogue)
    check_channels(reader, layout)
    search = search.check(reader, root, layout) if search else None
    problems.check()
    return replace(grid, _layout=layout, search=search)


def _check_cases(grid: Grid, reader: Reader, catalogue: Catalogue) -> None:
    """Check the number of cases, and that the first and the last one are machines that start; others say it later."""
    max_cases = MAX_IDENTITIES if grid.search or grid.may_repeat else MAX_CASES
    if grid.size > max_cases:
        raise InputError(
            f"{grid.source or 'the grid'}: has {grid.size:,} cases; at most {max_cases:,} can be run: take fewer "
            "values on the axes, or draw cases with `sample`"
        )
    ends = sorted({0, grid.size - 1})
    for index in ends:
        if reader.mechanism.refusal and (refusal := reader.mechanism.refusal(reader.mechanism, grid.case(index))):
            reader.report(f"mechanism.{refusal[0]}".rstrip("."), refusal[1])
    reader.problems.check()
    if all(map(has_run, grid.law_files)):
        start_problems = [catalogue.start_problem(grid.case(index)) for index in ends]
        if start_problems[0] and all(start_problems):
            reader.report(*start_problems[0])
    reader.problems.check()


def _name_of_run(root: WrittenValue, file: str | None, problems: Problems) -> str:
    """Return the grid's name, by default that of its file; the result directory has this name."""
    written = root.value.get("name")
    if written is None:
        return Path(file).stem if file else "case"
    if isinstance(written.value, str) and _NAME_PATTERN.fullmatch(written.value):
        return written.value
    message = (
        f"found {quoted(written.value)}; expected letters, digits, and . + - _ after the first, at most 100, "
        "because results go to results/<name>"
    )
    problems.add(written, "name", message)
    return "case"


def _point_of_layout(grid: Grid) -> dict[str, KeyValue]:
    """Return the point whose case has the time histories of all: that with the most elements in each bearing."""
    point = grid.point(0)
    for path, varied in grid.varied_names.items():
        counts = f"{path.removesuffix(BEARING)}{COUNT}"
        point[path] = max(grid.axes[path], key=lambda name: varied.numbers[name].get(counts, 0))
    return point


def starter(kind: str = "slider-crank") -> str:
    """Return the text of a commented example grid: 'slider-crank', 'four-bar', 'planar' or 'press'."""
    text = (Path(__file__).with_name("starters") / f"{kind}.yaml").read_text(encoding="utf-8")
    return f"# yaml-language-server: $schema={SCHEMA_FILE}\n{text}"


def write_starter(file: Path, kind: str, catalogue: Catalogue) -> None:
    """Write a commented example grid to a new file, and next to it the schema that its first line names to editors.

    A schema that is there stays.  Raises InputError if the grid exists or a file cannot be written.
    """
    schema_file = file.with_name(SCHEMA_FILE)
    try:
        with open(file, "x", encoding="utf-8") as target:
            target.write(starter(kind))
        if not schema_file.exists():
            schema_file.write_text(json.dumps(schema(catalogue), indent=0), encoding="utf-8")
    except FileExistsError:
        raise InputError(f"{file}: already exists and was not changed; choose a new file name") from None
    except OSError as error:
        raise InputError(f"{file}: cannot be written ({error.strerror}); choose a writable directory") from None


HISTORY_COPIES = 2.0  # copies of a case's histories in memory: as recorded, and by channel


def history_bytes(layout: Layout, save: Save, revolutions: float, channels: tuple[Column, ...] | None = None) -> float:
    """Return the bytes of history that a case of so many revolutions records, without events.

    channels : those that count, by default all
    """
    saved_revolutions = {"none": 0.0, "last": save.revolutions, "all": revolutions}[save.orbits]
    if not layout.turns and save.orbits != "none":
        saved_revolutions = 1.0  # samples are per run, not per revolution
    section_points = min(revolutions, MAX_REVOLUTIONS) * len(layout.sections) if save.orbits != "none" else 0.0
    return float(
        8.0
        * (saved_revolutions * save.samples * len(layout.channels if channels is None else channels) + section_points)
    )


def first_case_history(grid: Grid) -> float:
    """Return the largest number of bytes of history that the first case of a grid stores, without events."""
    case = grid.case(0)
    adaptive_section = case.simulate.until or case.life
    revolutions = adaptive_section.max_revolutions if adaptive_section else case.simulate.revolutions
    return history_bytes(grid.layout, case.save, revolutions, grid.layout.stored)


def largest_history(grid: Grid) -> float:
    """Return the smallest number of bytes of history that the longest case of a grid stores, without events."""
    return history_bytes(grid.layout, grid.case(0).save, _largest_revolutions(grid), grid.layout.stored)


def recorded_history(grid: Grid) -> float:
    """Return the bytes of history that the longest case of a grid has in memory, without events."""
    return history_bytes(grid.layout, grid.case(0).save, _largest_revolutions(grid))


def _largest_revolutions(grid: Grid) -> float:
    """Return the largest number of revolutions that a case of a grid runs."""
    swept = grid.axes.get("simulate.revolutions") or grid.axes.get("simulate.cycles")
    return float(max(swept or (grid.case(0).simulate.revolutions,)))


def check_memory(size: float) -> None:
    """Raise InputError if the histories of a case, `size` bytes, do not fit into memory."""
    memory = float(os.sysconf("SC_PAGE_SIZE")) * os.sysconf("SC_PHYS_PAGES")
    if HISTORY_COPIES * size > memory:
        raise InputError(
            f"save.orbits: the time histories of one case need {bytes_text(size)}, and twice that during the run, "
            f"but this machine has {bytes_text(memory)} of memory; save only the last revolutions (orbits: last), "
            "or fewer samples"
        )


def check_disk(size: float, free_bytes: float) -> None:
    """Raise InputError if all histories, `size` bytes in batches and again when merged, exceed `free_bytes` bytes."""
    if HISTORY_COPIES * size > free_bytes:
        raise InputError(
            f"save.orbits: the time histories of all cases need {bytes_text(size)}, and twice that during merging, "
            f"but only {bytes_text(free_bytes)} of disk space is free; save fewer revolutions, samples or "
            "channels (save.channels), or write orbits: none"
        )
