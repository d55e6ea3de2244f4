"""Remarks where cases leave what their laws are made for: yield, a law's range, pulling forces, lasting contact."""

import math
from collections.abc import Iterable, Mapping

from .results import ELASTIC_ONSET
from .wording import joint_name

#: Figure of a joint -> value above which there is a remark.
THRESHOLDS = {"onset_rate_max": ELASTIC_ONSET, "law_limit_fraction": 0.0, "force_clips": 0.0}
LAW_LIMIT = "law-limit: "  # what the message of a case begins with that went past its law's range
ONSET_KEPT = "onset-kept: "  # and what is in it where a contact that never ends keeps the rate at which it began


def columns(joints: Iterable[str]) -> list[str]:
    """Return the columns of the summary that decide whether there is a remark."""
    return ["case_id", "message", *(f"{joint}_{figure}" for figure in THRESHOLDS for joint in joints)]


class Remarks:
    """Counts the cases that leave the range of their laws, and keeps the worst of each kind."""

    def __init__(self, joints: Iterable[str]) -> None:
        self.joints = list(joints)
        self.cases = 0
        self.lasting = 0  # cases whose message is of ONSET_KEPT
        self.counts = dict.fromkeys(THRESHOLDS, 0)
        self.worst: dict[str, tuple[float, str, Mapping]] = dict.fromkeys(
            THRESHOLDS, (-math.inf, "", {})
        )  # value, joint, row

    def add(self, row: Mapping) -> None:
        """Take in a finished case, a row of the summary with at least `columns`."""
        self.cases += 1
        self.lasting += ONSET_KEPT in str(row["message"] or "")
        for figure, threshold in THRESHOLDS.items():
            value, joint = max((_number(row[f"{joint}_{figure}"]), joint) for joint in self.joints)
            if value > threshold:
                self.counts[figure] += 1
                if value > self.worst[figure][0]:
                    self.worst[figure] = (value, joint_name(joint), row)

    def sentences(self) -> list[str]:
        """Return the remarks on all cases, one sentence or two for each kind."""
        sentence = {"onset_rate_max": self._fast, "law_limit_fraction": self._deep, "force_clips": self._clipped}
        found = [sentence[figure](*self.worst[figure]) for figure in THRESHOLDS if self.counts[figure]]
        return [*found, self._kept()] if self.lasting else found

    def _kept(self) -> str:
        return (
            f"A contact never ends in {self._times(self.lasting)}, and with contact.onset: first its law keeps the "
            "rate of the first touch for ever: the start of the run decides the forces. contact.onset: renewed does "
            "not."
        )

    def _fast(self, rate: float, joint: str, row: Mapping) -> str:
        return (
            f"Impacts leave the elastic range in {self._share('onset_rate_max')}: the fastest closes at {rate:.3g} "
            f"m/s, {rate / ELASTIC_ONSET:.2g} times the {ELASTIC_ONSET:g} m/s from about which steel may yield (case "
            f"{row['case_id']}, {joint}); elastic laws then overstate forces and understate losses."
        )

    def _deep(self, share: float, joint: str, row: Mapping) -> str:
        message = str(row["message"] or "")
        known = message.startswith(LAW_LIMIT)
        worst = message.removeprefix(LAW_LIMIT) if known else f"{joint}, {_percent(share)} of the time"
        return (
            f"Contacts go deeper than their elastic law holds in {self._share('law_limit_fraction')}, longest in case "
            f"{row['case_id']}: {worst}"
            ". The notes of clearsweep laws NAME say how its force goes on."
        )

    def _clipped(self, times: float, joint: str, row: Mapping) -> str:
        return (
            f"A contact force that would have pulled was clipped at zero in {self._share('force_clips')}, most often "
            f"in case {row['case_id']}: {times:,.0f} time{'s' * (times != 1)} in {joint}."
        )

    def _share(self, figure: str) -> str:
        return self._times(self.counts[figure])

    def _times(self, count: int) -> str:
        return f"{count:,} of {self.cases:,} case{'s' * (self.cases != 1)}"


def past_limits(spent: Iterable[tuple[str, str, float, float]]) -> str:
    """Return the message of a finished case from (joint, elastic law, its limit in m, share of the time beyond it)."""
    excesses = [
        f"{joint} is deeper than {1e3 * limit:.4g} mm, up to which {law} holds, for {_percent(share)} of the time"
        for joint, law, limit, share in spent
        if share > 0.0
    ]
    return LAW_LIMIT + "; ".join(excesses) if excesses else ""


def kept_onsets(lasting: Iterable[tuple[str, float]]) -> str:
    """Return the message of a finished case from (joint, onset rate in m/s) of contacts that keep it and never end."""
    kept = [
        f"{joint} never loses contact in the window, and its law keeps the {rate:.3g} m/s of the first touch"
        for joint, rate in lasting
    ]
    return f"{ONSET_KEPT}{', '.join(kept)}; contact.onset: renewed forgets how it began" if kept else ""


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


def _number(value: float | None) -> float:
    """Return a figure of the summary, 0 for one that is not there."""
    return float(value) if value is not None and not math.isnan(value) else 0.0
