"""Compares the results of the same cases in two directories."""

from typing import Any

import numpy as np

from ..contracts.results import TIMINGS
from .batch import GROUP_ROWS, ResultSchema, datasets, id_text, summary_schema
from .directory import RunDirectory
from .orbits import OrbitFiles
from .summary import summary_groups

Difference = tuple[str, str, Any, Any]  # case_id, name of a column or dataset, value here, value there


def difference(
    form: ResultSchema, first: RunDirectory, mine: np.ndarray, second: RunDirectory, theirs: np.ndarray
) -> Difference | None:
    """Return the first difference of two directories, or None.

    `mine` and `theirs` (ROWS) locate the same cases in the same order.  Timings are ignored.
    """
    names = [np.array([batch.name for batch in run.batches], "S") for run in (first, second)]
    apart = names[0][mine["batch"]] != names[1][theirs["batch"]]  # batches are named by their content
    mine, theirs = mine[apart], theirs[apart]
    return _in_summary(form, first, mine, second, theirs) or _in_orbits(form, first, mine, second, theirs)


def _in_summary(
    form: ResultSchema, first: RunDirectory, mine: np.ndarray, second: RunDirectory, theirs: np.ndarray
) -> Difference | None:
    schema = summary_schema(form)
    groups = (summary_groups(run, schema, rows) for run, rows in ((first, mine), (second, theirs)))
    for number, tables in enumerate(zip(*groups, strict=True)):
        for name in schema.names:
            if name in TIMINGS or tables[0][name].equals(tables[1][name]):
                continue
            pairs = zip(*(table[name].to_pylist() for table in tables), strict=True)
            place, (here, there) = next((k, pair) for k, pair in enumerate(pairs) if pair[0] != pair[1])
            return id_text(int(mine["id"][number * GROUP_ROWS + place])), name, here, there
    return None


def _in_orbits(
    form: ResultSchema, first: RunDirectory, mine: np.ndarray, second: RunDirectory, theirs: np.ndarray
) -> Difference | None:
    with OrbitFiles(first, form) as here, OrbitFiles(second, form) as there:
        for dataset in datasets(form):
            places = [
                orbits.extents(dataset.each, dataset.width, rows) for orbits, rows in ((here, mine), (there, theirs))
            ]
            for k, case_id in enumerate(mine["id"].tolist()):
                values = [
                    orbits.read(int(rows["batch"][k]), dataset, int(begin[k]), int(count[k]))
                    for orbits, rows, (begin, count) in zip((here, there), (mine, theirs), places, strict=True)
                ]
                if values[0] != values[1]:
                    here_size, there_size = (f"{len(value):,} bytes" for value in values)
                    return id_text(case_id), dataset.path, here_size, there_size
    return None
