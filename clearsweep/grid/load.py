"""Loads grids: reads and checks them, and refuses what cannot be run."""

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from ..contracts.case import Case
from ..contracts.catalogue import Catalogue
from ..contracts.layout import Layout
from ..language.errors import InputError, shown
from . import checks, identified, labels, law_check, save_keys, variations
from .added_cases import rows as added_rows
from .assumed_units import assumed_units, written_units
from .changes import Changed, apply_overrides
from .document import Problems, name_of_run, override, read
from .grid import Grid
from .read_keys import read_keys
from .reader import Reader

MOST_CASES = 200_000_000  # their summaries take about 100 GB


MOST_IDENTITIES = 20_000_000  # identities in memory where cases may repeat or are added: 160 MB and 100 s


def load(
    source: str | PathLike | Mapping | Changed, catalogue: Catalogue, overrides: Mapping[str, Any] | None = None
) -> "Grid":
    """Return the checked grid in `source`: a path, a dict of the same form, or one with overrides.

    `overrides` maps dotted paths to values that replace those in the file; None removes a key.  A swept path that
    is overridden is no longer swept.  An InputError reports every mistake.
    """
    problems = Problems()
    changed = source if isinstance(source, Changed) else Changed(source)
    source = changed.source
    root = read(source, problems)
    if not isinstance(root.value, dict):
        raise InputError(
            f"{root.place}found {shown(root.value)}; expected a grid with the keys mechanism, drive, joints"
        )
    root = apply_overrides(root, changed, problems)
    for path, value in (overrides or {}).items():
        root = override(root, path, value, problems)
    file = fspath(source) if isinstance(source, (str, PathLike)) else None
    name = name_of_run(root, file, problems)
    reader = read_keys(root, catalogue, problems, frozenset({*(overrides or ()), *changed.fixed}))
    checks.check(reader, catalogue)
    problems.check()
    grid = Grid(
        name,
        file,
        reader.axes | variations.first_values(reader),
        reader.limits,
        reader.own_figures,
        reader.shape,
        reader.values,
        frozenset(reader.written),
        reader.names,
        {reader.way[paths[0]]: paths for paths in variations.steps(reader)} | variations.searched(reader),
        _sample(reader),
        reader.outline,
        {path: tuple(entries) for path, entries in reader.fits.items()},
        assumed_units(reader),
        reader.seek,
        reader.refine,
        reader.uncertain,
        added_rows(reader),
        tuple(reader.taken.values()),
        reader.defined,
        reader.optimise,
        reader.identify,
        written_units(reader),
        labels.of_axes(reader),
        law_check.paths(reader),
        reader.materials,
    )
    searched = grid.seek or grid.refine or grid.optimise or grid.identify or grid.checked_laws
    most = MOST_IDENTITIES if searched or grid.may_repeat else MOST_CASES
    if grid.size > most:
        raise InputError(
            f"{file or 'the grid'}: has {grid.size:,} cases; at most {most:,} can be run: take fewer values on "
            "the axes, or draw cases with `sample`"
        )
    for index in {0, grid.size - 1} if reader.mechanism.refusal else ():
        _refuse(reader, grid.case(index))
    problems.check()
    layout = Layout.of(grid.case(0), catalogue)
    save_keys.check_channels(reader, layout)
    identify = identified.check(reader, root, layout)
    problems.check()
    return replace(grid, _layout=layout, identify=identify)


def starter(kind: str = "slider-crank") -> str:
    """Return the text of a commented example grid: 'slider-crank', 'four-bar', 'planar' or 'press'."""
    return (Path(__file__).with_name("starters") / f"{kind}.yaml").read_text(encoding="utf-8")


def _refuse(reader: Reader, case: Case) -> None:
    """Report why the mechanism of a case cannot be assembled."""
    assert reader.mechanism.refusal is not None  # only some mechanisms have this check
    refusal = reader.mechanism.refusal(reader.mechanism, case)
    if refusal:
        path = f"mechanism.{refusal[0]}".rstrip(".")
        reader.problems.add(reader.place(path), path, refusal[1])


def _sample(reader: Reader) -> dict[str, Any]:
    """Return the section `sample` in SI, or {} if there is none."""
    if reader.sample is None:
        return {}
    heading: dict[str, Any] = {"method": reader.sample.method}
    if reader.sample.method != "one-at-a-time":
        heading |= {"n": reader.sample.n, "seed": reader.sample.seed}
    return heading | {"over": {path: reader.distributions[path].written() for path in reader.drawn}}
