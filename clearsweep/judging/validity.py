"""Remarks where cases leave what their laws are made for, and where figures of a finished case cannot be meant.

Yield and a law's range are figures of their own.  The message of a case tells the rest, and the law's range besides: a
list of remarks, each of which begins with a word.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.case import column_name
from ..contracts.results import ELASTIC_ONSET, ELASTIC_SHARE
from ..language.wording import joint_name, short_id

#: Figure of a joint -> value above which there is a remark.
THRESHOLDS = {"onset_rate_max": ELASTIC_ONSET, "law_limit_fraction": 0.0}
#: What remarks in the message of a case begin with: past its law's range, a contact that never ends and keeps the rate
#: at which it began, and what nobody can have meant.
LAW_LIMIT, ONSET_KEPT = "law-limit: ", "onset-kept: "
TOO_DEEP, WORN_THROUGH, IMBALANCE = "too-deep: ", "worn-through: ", "imbalance: "
FILM_HELD, FILM_BEYOND, FILM_FLOW = "film-limit: ", "film-beyond: ", "film-flow: "
UNBALANCED = (
    "film-heat: the heat balance of a film did not come to stand; more revolutions, or a larger conductance, help"
)
TAYLOR = 41.3  # above, vortices begin between cylinders of which the inner one turns (Taylor 1923)
UNCHECKED = "unchecked: "  # its error check came to nothing
UNREACHED = "unreached: "  # its life did not come to the limit
BETWEEN = " | "  # remarks in a message
#: Of the bearing's radius.  Beyond DEEP a contact is no small deformation.  Up to BORNE, a strain of about a per cent,
#: a contact may be deeper than its clearance: journals in tight fits are, and need no mistake for it.
DEEP, BORNE = 0.1, 0.01
#: Energy residual that a tolerance explains, per onset and revolution.  Of 1,300 random cases at tolerances from 1e-12
#: to 1e-3 none came to more than 1.4; what rounding alone makes is below LEAST_RESIDUAL, and more than MOST_RESIDUAL no
#: tolerance excuses.
RESIDUAL, LEAST_RESIDUAL, MOST_RESIDUAL = 10.0, 1e-9, 1e-2


class Surfaces(NamedTuple):
    """What of a joint decides whether impacts leave the range that its law is made for."""

    law: str  # name of its contact law, or the column that has it
    elastic_to: float = ELASTIC_ONSET  # m/s
    material: str = "steel"  # to which that applies
    hint: str = ""  # how to have it of another one


def surfaces_of(record: Mapping[str, Any], joints: Iterable[str]) -> dict[str, Surfaces]:
    """Return what there is to know of some joints ('rod_slider') of a run, by its run.json."""
    sections = {column_name(name): (name, section) for name, section in record.get("joints", {}).items()}
    found = {}
    for joint in joints:
        name, section = sections.get(joint, (joint, {}))
        contact, path = section.get("contact", {}), f"joints.{name}.contact.law"
        law = path if path in record.get("units", {}) else contact.get("law", "")
        material = contact.get("material", {})
        bodies = [material] if "young" in material else [body for body in material.values() if isinstance(body, dict)]
        speeds = [ELASTIC_SHARE * math.sqrt(body["young"] / body["density"]) for body in bodies if "density" in body]
        hint = " (of another material: write its density)" if bodies else ""
        found[joint] = Surfaces(law, min(speeds), "its material") if speeds else Surfaces(law, hint=hint)
    return found


def columns(surfaces: Mapping[str, Surfaces]) -> list[str]:
    """Return the columns of the summary that decide whether there is a remark on some joints."""
    laws = dict.fromkeys(each.law for each in surfaces.values() if "." in each.law)
    return ["case_id", "message", *(f"{joint}_{figure}" for figure in THRESHOLDS for joint in surfaces), *laws]


class _Worst(NamedTuple):
    """The case that is furthest beyond a threshold."""

    value: float  # of the figure, SI
    joint: str  # in words
    case_id: str
    message: str


class Remarks:
    """Counts the cases that leave the range of their laws, and keeps the worst of each kind."""

    def __init__(self, surfaces: Mapping[str, Surfaces], yielding: Iterable[str] = ()) -> None:
        """Take the joints ('rod_slider') and the names of laws that yield: fast impacts are what these are made for."""
        self.surfaces, self.joints, self.yielding = surfaces, list(surfaces), sorted(yielding)
        self.cases = 0
        self.counts = dict.fromkeys((*THRESHOLDS, *_TOLD), 0)
        self.first: dict[str, tuple[str, str]] = {}  # word of _TOLD -> case_id, remark
        self.worst = dict.fromkeys(THRESHOLDS, _Worst(-math.inf, "", "", ""))

    def add(self, cases: Mapping[str, Sequence[Any] | np.ndarray]) -> None:
        """Take in finished cases, column of the summary -> its values, with at least `columns`."""
        ids, messages = cases["case_id"], cases["message"]
        self.cases += len(ids)
        for place in (place for place, message in enumerate(messages) if message):
            for word in _TOLD:
                if remark := _remark(messages[place], word):
                    self.counts[word] += 1
                    self.first.setdefault(word, (short_id(ids[place]), remark))
        for figure, threshold in THRESHOLDS.items():
            values = np.nan_to_num(np.array([cases[f"{joint}_{figure}"] for joint in self.joints], float))
            if figure == "onset_rate_max":
                values *= [self._elastic(cases, self.surfaces[joint]) for joint in self.joints]
            largest = values.max(axis=0)
            self.counts[figure] += int(np.count_nonzero(largest > threshold))
            place = int(np.argmax(largest)) if len(largest) else 0
            if np.any(largest > max(threshold, self.worst[figure].value)):
                joint = max(
                    name for name, value in zip(self.joints, values[:, place], strict=True) if value == largest[place]
                )
                self.worst[figure] = _Worst(float(largest[place]), joint_name(joint), ids[place], messages[place])

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

    def _elastic(self, cases: Mapping[str, Any], surfaces: Surfaces) -> Any:
        """Return by what to multiply the impact speeds in a joint so that steel's limit holds; 0: its law yields."""
        weight, law = ELASTIC_ONSET / surfaces.elastic_to, surfaces.law
        if law in cases:
            return np.array([0.0 if name in self.yielding else weight for name in cases[law]])
        return np.full(len(cases["case_id"]), 0.0 if law in self.yielding else weight)

    def _fast(self, scaled: float, joint: str, case_id: str, _message: str) -> str:
        surfaces = self.surfaces[column_name(joint)]
        rate = scaled * surfaces.elastic_to / ELASTIC_ONSET
        limit = f"{surfaces.elastic_to:.3g} m/s from about which {surfaces.material} may yield{surfaces.hint}"
        return (
            f"Impacts leave the elastic range in {self._share('onset_rate_max')}: the fastest closes at {rate:.3g} "
            f"m/s, {scaled / ELASTIC_ONSET:.2g} times the {limit} (case {short_id(case_id)}, {joint}); a law that does "
            "not yield then overstates forces and understates losses."
        )

    def _deep(self, share: float, joint: str, case_id: str, message: str) -> str:
        worst = _remark(message, LAW_LIMIT) or f"{joint}, {_percent(share)} of the time"
        return (
            f"Contacts go deeper than their elastic law holds in {self._share('law_limit_fraction')}, longest in case "
            f"{short_id(case_id)}: {worst}"
            ". The notes of clearsweep list NAME say how its force goes on."
        )

    def _share(self, figure: str) -> str:
        return f"{self.counts[figure]:,} of {self.cases:,} case{'s' * (self.cases != 1)}"


_TOLD = {
    ONSET_KEPT: "A contact never ends, and its law keeps the rate of its first touch: the start of the run decides the "
    "forces,",
    TOO_DEEP: "A contact is deeper than its clearance and a hundredth of its bearing's radius, or than a tenth of it",
    WORN_THROUGH: "Wear is deeper than the clearance",
    FILM_HELD: "A film is thinner than its formula holds for",
    FILM_BEYOND: "A film is squeezed out where there is no dry contact to stop the journal",
    FILM_FLOW: "The flow in a film is no longer laminar",
    UNBALANCED.split(": ", maxsplit=1)[0] + ": ": "A film's temperature is not known",
    IMBALANCE: "The energies do not add up as closely as the tolerance promises",
    UNCHECKED: "The error check came to nothing",
    UNREACHED: "A life does not come to its limit",
}


def message_of(*remarks: str) -> str:
    """Return the message of a finished case from its remarks, '' for none."""
    return BETWEEN.join(remark for remark in remarks if remark)


def _remark(message: str | None, word: str) -> str:
    """Return the remark in a case's message that begins with `word`, without it; '' where there is none."""
    remarks = str(message or "").split(BETWEEN)
    return next((remark.removeprefix(word) for remark in remarks if remark.startswith(word)), "")


class Reached(NamedTuple):
    """How far a joint came in a case."""

    joint: str  # 'rod-slider'
    penetration: float  # m, largest
    worn: float  # m, deepest wear in the window, 0 without wear
    clearance: float  # m
    bearing_radius: float | None  # m


def too_deep(joints: Iterable[Reached]) -> str:
    """Return the remark on contacts that are deeper than the clearance and BORNE, or than DEEP."""
    remarks = []
    for joint in joints:
        radius = joint.bearing_radius
        borne = min(max(joint.clearance, BORNE * radius), DEEP * radius) if radius else joint.clearance
        if joint.penetration > borne:
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


class Lubricated(NamedTuple):
    """What became of the film of a joint in a case."""

    joint: str  # 'rod-slider'
    limit: float  # eccentricity ratio up to which its formula holds
    held: float  # share of the window's time beyond
    ratio: float  # largest eccentricity over clearance
    dry: bool  # there is a dry contact behind it
    taylor: float  # largest Taylor number


def films(joints: Iterable[Lubricated]) -> tuple[str, ...]:
    """Return the remarks on films: past their limit, squeezed out with nothing behind them, not laminar."""
    joints = list(joints)
    held = [
        f"{joint.joint} is beyond the eccentricity ratio {joint.limit:g}, from which on it is evaluated there, for "
        f"{_percent(joint.held)} of the time, and reaches {joint.ratio:.4g}"
        for joint in joints
        if joint.held > 0.0
    ]
    beyond = [
        f"{joint.joint} reaches {joint.ratio:.4g} clearances" for joint in joints if joint.ratio > 1.0 and not joint.dry
    ]
    flow = [
        f"{joint.joint} has a Taylor number of {joint.taylor:.3g}, vortices begin at {TAYLOR:g}; laminar laws "
        "understate its losses"
        for joint in joints
        if joint.taylor > TAYLOR
    ]
    hint = "; write the joint's contact, more viscosity, or less clearance"
    return (
        FILM_HELD + "; ".join(held) if held else "",
        FILM_BEYOND + "; ".join(beyond) + hint if beyond else "",
        FILM_FLOW + "; ".join(flow) if flow else "",
    )


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
