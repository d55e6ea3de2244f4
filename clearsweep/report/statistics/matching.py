"""Matched cases, which differ in one law only."""

from typing import NamedTuple

import pandas as pd

from ..data.axis import Axis
from ..data.study import Study


class MatchedCases(NamedTuple):
    """Matched cases, which differ in one law only."""

    axis: Axis
    pairs: pd.DataFrame  # columns group, law, case_id

    def table(self, study: Study, column: str) -> pd.DataFrame:
        """Return a figure (SI) by group and law, for groups with a positive figure under at least two laws."""
        values = study.cases[column].reindex(self.pairs["case_id"]).to_numpy()
        known = self.pairs.assign(value=values)[values > 0.0]
        table = known.pivot_table(index="group", columns="law", values="value", aggfunc="median")
        return table[table.count(axis=1) > 1]

    def case_id(self, group: int, law: str) -> str:
        """Return the id of the case of a law in a group."""
        return self.pairs.loc[(self.pairs["group"] == group) & (self.pairs["law"] == law), "case_id"].iloc[0]


def match_cases(study: Study, axis: Axis) -> MatchedCases:
    """Return the cases that share all swept values except those of one axis.

    A value that a law does not use does not separate cases: the case then belongs to every group that shares the
    others.
    """
    other_paths = [other.path for other in study.swept() if other is not axis]
    codes = pd.DataFrame({path: pd.factorize(study.cases[path])[0] for path in other_paths}, index=study.cases.index)
    groups = codes.drop_duplicates().rename_axis(None).reset_index(drop=True).rename_axis("group").reset_index()
    used_paths = [tuple(path for path in other_paths if code[path] >= 0) for code in codes.to_dict("records")]
    groups_with_cases = []
    for shared_paths in dict.fromkeys(used_paths):
        rows = codes[[paths == shared_paths for paths in used_paths]].reset_index()[["case_id", *shared_paths]]
        merge_options = {"on": list(shared_paths)} if shared_paths else {"how": "cross"}
        groups_with_cases.append(groups[["group", *shared_paths]].merge(rows, **merge_options))
    pairs = pd.concat(groups_with_cases, ignore_index=True)[["group", "case_id"]]
    return MatchedCases(axis, pairs.assign(law=study.cases[axis.path].reindex(pairs["case_id"]).to_numpy()))


def axis_key(axis: Axis) -> str:
    """Return an axis as a key of tables: 'laws_rod_slider_contact_law' for 'joints.rod-slider.contact.law'."""
    return axis.path.replace("joints.", "laws_", 1).replace(".", "_").replace("-", "_")
