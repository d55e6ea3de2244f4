"""Remarks where cases leave what their laws are made for, and where figures of a finished case cannot be meant.

Yield and a law's range are figures of their own.  The message of a case tells the rest, and the law's range besides: a
list of remarks, each of which begins with a word.
"""

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from .results import ELASTIC_ONSET
from .wording import joint_name

#: Figure of a joint -> value above which there is a remark.
THRESHOLDS = {"onset_rate_max": ELASTIC_ONSET, "law_limit_fraction": 0.0}
#: What remarks in the message of a case begin with: past its law's range, a contact that never ends and keeps the rate
#: at which it began, and what nobody can have meant.
LAW_LIMIT, ONSET_KEPT = "law-limit: ", "onset-kept: "
TOO_DEEP, WORN_THROUGH, IMBALANCE = "too-deep: ", "worn-through: ", "imbalance: "
UNCHECKED = "unchecked: "  # its error check came to nothing
BETWEEN = " | "  # remarks in a message
DEEP = 0.1  # of the bearing's radius: a deeper contact is no small deformation
#: Energy residual that a tolerance explains, per onset and revolution.  Of 1,300 random cases at tolerances from 1e-12
#: to 1e-3 none came to more than 1.4; what rounding alone makes is below LEAST_RESIDUAL, and more than MOST_RESIDUAL no
#: tolerance excuses.
RESIDUAL, LEAST_RESIDUAL, MOST_RESIDUAL = 10.0, 1e-9, 1e-2


def columns(joints: Iterable[str]) -> list[str]:
    """Return the columns of the summary that decide whether there is a remark."""
    return ["case_id", "message", *(f"{joint}_{figure}" for figure in THRESHOLDS for joint in joints)]


class Remarks:
    """Counts the cases that leave the range of their laws, and keeps the worst of each kind."""

    def __init__(self, joints: Iterable[str]) -> None:
        self.joints = list(joints)
        self.cases = 0
        self.counts = dict.fromkeys((*THRESHOLDS, *_TOLD), 0)
        self.first: dict[str, tuple[str, str]] = {}  # word of _TOLD -> case_id, remark
        self.worst: dict[str, tuple[float, str, Mapping]] = dict.fromkeys(
            THRESHOLDS, (-math.inf, "", {})
        )  # value, joint, row

    def add(self, row: Mapping) -> None:
        """Take in a finished case, a row of the summary with at least `columns`."""
        self.cases += 1
        for word in _TOLD:
            if remark := _remark(row, word):
                self.counts[word] += 1
                self.first.setdefault(word, (row["case_id"], remark))
        for figure, threshold in THRESHOLDS.items():
            value, joint = max((_number(row[f"{joint}_{figure}"]), joint) for joint in self.joints)
            if value > threshold:
                self.counts[figure] += 1
                if value > self.worst[figure][0]:
                    self.worst[figure] = (value, joint_name(joint), row)

    def sentences(self) -> list[str]:
        """Return the remarks on all cases, one sentence or two for each kind."""
        sentence = {"onset_rate_max": self._fast, "law_limit_fraction": self._deep}
        return [
            *(sentence[figure](*self.worst[figure]) for figure in THRESHOLDS if self.counts[figure]),
            *(
                "{} in {}, such as case {}: {}.".format(sentence_of, self._share(word), *self.first[word])
                for word, sentence_of in _TOLD.items()
                if word in self.first
            ),
        ]

    def _fast(self, rate: float, joint: str, row: Mapping) -> str:
        return (
            f"Impacts leave the elastic range in {self._share('onset_rate_max')}: the fastest closes at {rate:.3g} "
            f"m/s, {rate / ELASTIC_ONSET:.2g} times the {ELASTIC_ONSET:g} m/s from about which steel may yield (case "
            f"{row['case_id']}, {joint}); a law that does not yield then overstates forces and understates losses."
        )

    def _deep(self, share: float, joint: str, row: Mapping) -> str:
        worst = _remark(row, LAW_LIMIT) or f"{joint}, {_percent(share)} of the time"
        return (
            f"Contacts go deeper than their elastic law holds in {self._share('law_limit_fraction')}, longest in case "
            f"{row['case_id']}: {worst}"
            ". The notes of clearsweep laws NAME say how its force goes on."
        )

    def _share(self, figure: str) -> str:
        return f"{self.counts[figure]:,} of {self.cases:,} case{'s' * (self.cases != 1)}"


_TOLD = {
    ONSET_KEPT: "A contact never ends, and its law keeps the rate of its first touch: the start of the run decides the "
    "forces,",
    TOO_DEEP: "A contact is deeper than its clearance or a tenth of its bearing's radius",
    WORN_THROUGH: "Wear is deeper than the clearance",
    IMBALANCE: "The energies do not add up as closely as the tolerance promises",
    UNCHECKED: "The error check came to nothing",
}


def message_of(*remarks: str) -> str:
    """Return the message of a finished case from its remarks, '' for none."""
    return BETWEEN.join(remark for remark in remarks if remark)


def _remark(row: Mapping, word: str) -> str:
    """Return the remark in a row's message that begins with `word`, without it; '' where there is none."""
    remarks = str(row["message"] or "").split(BETWEEN)
    return next((remark.removeprefix(word) for remark in remarks if remark.startswith(word)), "")


class Reached(NamedTuple):
    """How far a joint came in a case."""

    joint: str  # 'rod-slider'
    penetration: float  # m, largest
    worn: float  # m, deepest wear in the window, 0 without wear
    clearance: float  # m
    bearing_radius: float | None  # m


def too_deep(joints: Iterable[Reached]) -> str:
    """Return the remark on contacts that are deeper than the clearance or a tenth of the bearing's radius."""
    remarks = []
    for joint in joints:
        radius = DEEP * joint.bearing_radius if joint.bearing_radius else math.inf
        if joint.penetration > min(joint.clearance, radius):
            than = f"a clearance of {_mm(joint.clearance)}" + (
                f" and a bearing radius of {_mm(joint.bearing_radius)}" if joint.bearing_radius else ""
            )
            remarks.append(f"{joint.joint} is penetrated by {_mm(joint.penetration)} at {than}")
    hint = "; no law of contact holds there: look for a stiffness, a mass or a speed in the wrong unit"
    return TOO_DEEP + "; ".join(remarks) + hint if remarks else ""


def worn_through(joints: Iterable[Reached]) -> str:
    """Return the remark on wear that is deeper than the clearance."""
    remarks = [
        f"{joint.joint} is worn {_mm(joint.worn)} deep at a clearance of {_mm(joint.clearance)}"
        for joint in joints
        if joint.worn > joint.clearance
    ]
    hint = "; is the coefficient in mm^2/N? (1 mm^2/N is 1e-6 m^2/N)"
    return WORN_THROUGH + "; ".join(remarks) + hint if remarks else ""


def imbalance(residual: float, tolerance: float, count: float) -> str:
    """Return the remark on an energy residual beyond what the tolerance explains; count : onsets and revolutions."""
    explained = min(max(RESIDUAL * tolerance * count, LEAST_RESIDUAL), MOST_RESIDUAL)
    if residual <= explained:
        return ""
    return (
        f"{IMBALANCE}the energy residual is {residual:.2g} where a tolerance of {tolerance:g} explains at most "
        f"{explained:.2g}; a tighter tolerance may help, or masses, stiffness and damping less far from each other"
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


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
