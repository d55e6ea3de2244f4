"""Comparing what two directories hold of the same cases."""

import numpy as np

from ..results import TIMINGS
from .assemble import GROUP_ROWS, Shards, summary_group
from .batch import Form, datasets, summary_schema
from .directory import Store, id_text


def difference(form: Form, one: Store, mine: np.ndarray, other: Store, theirs: np.ndarray):
    """Return (case_id, name, value here, value there) of the first thing in which two directories differ, or None.

    `mine` and `theirs` (ROWS) say where each holds the same cases in the same order.  Timings are not looked at.
    """
    parts = [np.array([part.path.name for part in store.parts], "S") for store in (one, other)]
    apart = parts[0][mine["part"]] != parts[1][theirs["part"]]  # parts are named by their content
    mine, theirs = mine[apart], theirs[apart]
    return _in_summary(form, one, mine, other, theirs) or _in_orbits(form, one, mine, other, theirs)


def _in_summary(form: Form, one: Store, mine: np.ndarray, other: Store, theirs: np.ndarray):
    schema = summary_schema(form)
    for start in range(0, len(mine), GROUP_ROWS):
        group = slice(start, start + GROUP_ROWS)
        tables = [summary_group(store, schema, rows[group]) for store, rows in ((one, mine), (other, theirs))]
        for name in schema.names:
            if name in TIMINGS or tables[0][name].equals(tables[1][name]):
                continue
            pairs = zip(*(table[name].to_pylist() for table in tables), strict=True)
            place, (here, there) = next((k, pair) for k, pair in enumerate(pairs) if pair[0] != pair[1])
            return id_text(int(mine["id"][start + place])), name, here, there
    return None


def _in_orbits(form: Form, one: Store, mine: np.ndarray, other: Store, theirs: np.ndarray):
    with Shards(one, form) as here, Shards(other, form) as there:
        for dataset in datasets(form):
            places = [
                shards.extents(dataset.each, dataset.width, rows) for shards, rows in ((here, mine), (there, theirs))
            ]
            for k, case_id in enumerate(mine["id"].tolist()):
                values = [
                    shards.read(int(rows["part"][k]), dataset, int(first[k]), int(count[k]))
                    for shards, rows, (first, count) in zip((here, there), (mine, theirs), places, strict=True)
                ]
                if values[0] != values[1]:
                    return id_text(case_id), dataset.path, *(f"{len(each):,} bytes" for each in values)
    return None
