"""The worst cases of a run for the leading question of its grid, for the summary table."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...answers.ranking import CaseRanking
from ...answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, Limit
from ...answers.words import case_margin_text

WORST_CASES = 5


class WorstCases:
    """Keeps the worst finished cases, updated block by block."""

    def __init__(self, ranking: CaseRanking, joints: list[str], limits: tuple[Limit, ...]):
        """Prepare with the ranking, the joints whose force peaks each entry contains, and the limits of the grid."""
        self.ranking, self.joints, self.limits = ranking, joints, limits
        self.columns = [*dict.fromkeys((*ranking.columns, *(f"{joint}_force_peak" for joint in joints)))]
        self.entries: list[dict[str, Any]] = []  # the worst first

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        if not self.ranking.candidates:
            return
        values, candidate_numbers = self.ranking.worst_values(block)
        severity = self.ranking.severity(values, block)
        least_severity = np.partition(severity, -WORST_CASES)[-WORST_CASES] if len(severity) > WORST_CASES else -np.inf
        worst = np.flatnonzero(severity >= least_severity)
        worst = worst[np.lexsort((block["case_id"][worst], severity[worst]))[-WORST_CASES:]]
        entries = [
            describe(index)
            | self._figures(block, index, int(candidate_numbers[index]))
            | {"severity": float(severity[index])}
            for index in worst.tolist()
        ]
        self.entries = sorted([*self.entries, *entries], key=self._severity, reverse=True)[:WORST_CASES]

    def _severity(self, entry: dict[str, Any]) -> tuple[float, str]:
        return entry["severity"], entry["case_id"]

    def _figures(self, block: Mapping[str, np.ndarray], index: int, number: int) -> dict[str, Any]:
        """Return the figures that rank a case, and the largest force peak with its joint; None for null."""
        candidate = self.ranking.candidates[number]
        peaks = [(float(np.nan_to_num(float(block[f"{joint}_force_peak"][index]))), joint) for joint in self.joints]
        peak, joint = max(peaks)
        figures = []
        for name in candidate.columns:
            value = float(block[name][index])
            figures.append({"column": name, "value": None if np.isnan(value) else value})
            if name == MARGIN_COLUMN:
                figures[-1]["words"] = case_margin_text(value, self.limits, block[EXCEEDED_COLUMN][index] or "")
        return {"joint": candidate.joint or joint, "force_peak": peak, "figures": figures}
