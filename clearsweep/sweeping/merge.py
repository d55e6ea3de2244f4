"""Joining runs of one grid, such as its shards, into one run."""

import time
from pathlib import Path

import numpy as np

from .. import grid as grids
from .. import store
from ..errors import DirectoryError
from ..grid.variations import WAYS
from . import progress, signals
from .shard import Shard
from .simulator import SIMULATION
from .sweep import RunResult, case_ids, conclude, facts
from .worker import Simulator

NAMED = 3  # cases or shards that a message lists before it stops


def merge(directories, out, *, partial=False, simulator: Simulator = SIMULATION) -> RunResult:
    """Join runs of the same grid into `out`, which then is what one run of the grid would have left.

    Directories of different grids, cases that disagree and, unless `partial`, missing cases are refused before
    anything is written.  Batches are linked where the file system can, else copied; the directories stay as they are.
    """
    begin = time.monotonic()
    out = Path(out)
    places = list({Path(directory).resolve(): Path(directory) for directory in directories}.values())
    records = _same_grid(places)
    grid = grids.load({key: records[0][key] for key in records[0]["keys"]}, simulator.catalogue())
    target = store.Store(out)
    target.check(grid)
    if target.record.exists() and out.resolve() not in {place.resolve() for place in places}:
        places.append(out)
    sources = [store.Store(place) for place in places]
    for source in sources:
        for sentence in source.look().values():
            progress.say(f"{source.directory}: {sentence}")
    rows = [source.rows() for source in sources]
    ids = np.unique(case_ids(grid))
    if not partial:
        _complete(ids, rows, [record.get("shard") for record in records])
    _agree(store.Form.of(grid), sources, rows)
    derived, warnings = facts(grid, simulator)
    with signals.catching(), target.open_for(grid) as held:
        start = min(record["start"] for record in records)
        for sentence in held.recover():
            progress.say(sentence)
        for source in sources:
            held.take(source)
        counts = conclude(
            held,
            grid,
            ids,
            ran=0,
            start=start,
            source=records[0]["source"],
            derived=derived,
            warnings=warnings,
            joined=[str(place) for place in places],
        )
    return RunResult(
        out,
        **counts,
        seconds=time.monotonic() - begin,
        case_seconds=0.0,
        start_up=0.0,
        derived=derived,
        warnings=tuple(warnings),
        joined=len(places),
    )


def _same_grid(places: list[Path]) -> list[dict]:
    """Return the run.json of every directory; DirectoryError where two are not of the same grid and version."""
    records = [store.read_record(place) for place in places]
    for place, record in zip(places, records, strict=True):
        if not isinstance(record, dict) or not {"frame", "keys", "start"} <= record.keys():
            raise DirectoryError(f"{place / 'run.json'}: is not what `clearsweep run` writes; leave this directory out")
    first = _decisive(records[0])
    for place, record in zip(places[1:], records[1:], strict=True):
        other = _decisive(record)
        differing = [path for path in sorted({*first, *other}) if first.get(path) != other.get(path)]
        if differing:
            found = "".join(
                f"\n  {path}: {_short(first.get(path))} there, {_short(other.get(path))} here" for path in differing
            )
            raise DirectoryError(
                f"{place}: holds results of another grid than {places[0]}; "
                f"only shards of one grid can be joined; what differs:{found}"
            )
    return records


def _decisive(record: dict) -> dict:
    """Return dotted path -> value of all that decides which cases a run has and what they give."""
    axes = {f"{way}.{path}": values for way in WAYS for path, values in (record.get(way) or {}).items()}
    return record.get("frame", {}) | axes


def _complete(ids: np.ndarray, rows: list[np.ndarray], shards: list[str | None]) -> None:
    """Raise DirectoryError where a case is in no directory."""
    held = np.concatenate([each["id"] for each in rows])
    missing = np.setdiff1d(ids, held)
    if not len(missing):
        return
    parts = {Shard.read(text).of for text in shards if text}
    where = []
    if len(parts) == 1 and all(shards):  # all of one division: say which shards are to run
        of = parts.pop()
        left = [str(shard) for shard in (Shard(k + 1, of) for k in range(of)) if np.isin(shard.ids(ids), missing).any()]
        where = [f"run what is left of shard {_listed(left)}, or"]
    raise DirectoryError(
        f"{len(missing):,} of {len(ids):,} cases are in none of these directories "
        f"({_listed([store.id_text(value) for value in missing.tolist()])}); "
        + " ".join(
            [*where, "merge with --partial what there is and run the grid with --out there, which computes the rest"]
        )
    )


def _agree(form, sources: list, rows: list[np.ndarray]) -> None:
    """Raise DirectoryError where a case is in two directories and differs in more than its timing."""
    ids = np.concatenate([each["id"] for each in rows])
    place = np.concatenate([np.arange(len(each)) for each in rows])
    number = np.repeat(np.arange(len(rows)), [len(each) for each in rows])
    order = np.argsort(ids, kind="stable")
    twice = np.flatnonzero(ids[order][1:] == ids[order][:-1])
    first, second = order[twice], order[twice + 1]
    for a, b in np.unique(np.column_stack([number[first], number[second]]), axis=0).tolist():
        pair = (number[first] == a) & (number[second] == b)
        found = store.difference(
            form, sources[a], rows[a][place[first[pair]]], sources[b], rows[b][place[second[pair]]]
        )
        if found:
            case_id, name, here, there = found
            raise DirectoryError(
                f"case {case_id}: {name} is {_short(here)} in {sources[a].directory} and "
                f"{_short(there)} in {sources[b].directory}; leave out the one that is wrong "
                "(machines that round differently give different chaotic motion)"
            )


def _listed(texts: list[str]) -> str:
    return ", ".join(texts[:NAMED]) + (", ..." if len(texts) > NAMED else "")


def _short(value) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
