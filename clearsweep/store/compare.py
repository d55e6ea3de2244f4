"""Compares the results of the same cases in two directories."""

from typing import Any

import numpy as np

from ..contracts.results import TIMINGS
from .batch import GROUP_ROWS, ResultSchema, id_text, summary_schema
from .datasets import datasets
from .directory import RunDirectory
from .orbits import OrbitFiles
from .summary import summary_groups

Difference = tuple[str, str, Any, Any]  # case_id, name of a column or dataset, value here, value there


def difference(
    result_schema: ResultSchema,
    first: RunDirectory,
    first_rows: np.ndarray,
    second: RunDirectory,
    second_rows: np.ndarray,
) -> Difference | None:
    """Return the first difference of two directories, or None.

    `first_rows` and `second_rows` (ROWS) locate the same cases in the same order.  Timings are ignored.
    """
    names = [np.array([batch.name for batch in run.batches], "S") for run in (first, second)]
    is_different = names[0][first_rows["batch"]] != names[1][second_rows["batch"]]  # batches are named by their content
    first_rows, second_rows = first_rows[is_different], second_rows[is_different]
    return _summary_difference(result_schema, first, first_rows, second, second_rows) or _orbits_difference(
        result_schema, first, first_rows, second, second_rows
    )


def _summary_difference(
    result_schema: ResultSchema,
    first: RunDirectory,
    first_rows: np.ndarray,
    second: RunDirectory,
    second_rows: np.ndarray,
) -> Difference | None:
    schema = summary_schema(result_schema)
    groups = (summary_groups(run, schema, rows) for run, rows in ((first, first_rows), (second, second_rows)))
    for number, tables in enumerate(zip(*groups, strict=True)):
        for name in schema.names:
            if name in TIMINGS or tables[0][name].equals(tables[1][name]):
                continue
            pairs = zip(*(table[name].to_pylist() for table in tables), strict=True)
            offset, (first_value, second_value) = next((k, pair) for k, pair in enumerate(pairs) if pair[0] != pair[1])
            return id_text(int(first_rows["id"][number * GROUP_ROWS + offset])), name, first_value, second_value
    return None


def _orbits_difference(
    result_schema: ResultSchema,
    first: RunDirectory,
    first_rows: np.ndarray,
    second: RunDirectory,
    second_rows: np.ndarray,
) -> Difference | None:
    with OrbitFiles(first, result_schema) as first_orbits, OrbitFiles(second, result_schema) as second_orbits:
        for dataset in datasets(result_schema):
            extents = [
                orbits.extents(dataset.item, dataset.width, rows)
                for orbits, rows in ((first_orbits, first_rows), (second_orbits, second_rows))
            ]
            for k, case_id in enumerate(first_rows["id"].tolist()):
                values = [
                    orbits.read(int(rows["batch"][k]), dataset, int(starts[k]), int(count[k]))
                    for orbits, rows, (starts, count) in zip(
                        (first_orbits, second_orbits), (first_rows, second_rows), extents, strict=True
                    )
                ]
                if values[0] != values[1]:
                    first_size, second_size = (f"{len(value):,} bytes" for value in values)
                    return id_text(case_id), dataset.path, first_size, second_size
    return None
