"""Which law is recommended for a joint, and which others hold there: for `list --for`, dry runs, pages and runs."""

from collections.abc import Iterable, Sequence
from os import PathLike
from typing import NamedTuple

import numpy as np

from .. import grid
from ..contracts.case import Case, Joint
from ..language import wording
from ..language.errors import InputError, nearest
from ..mechanics.joint import registry
from .advice import DOUBTFUL, HOLDS, KEYS, OUT, WORDS, Advice, Verdict, advice, of_joint
from .scene import catalogue

FAMILIES = ("elastic", "law")  # of which one law each is recommended
MOST_CASES = 25  # of a grid that are looked at
DEPTH = 1e-6  # m, at which the forces of laws are compared
_JOINTS = "{joints}"  # in a text that several joints may share
_CAVEAT = "The load is the largest reaction without clearance; impacts are harder. clearsweep list NAME explains a law."


class Recommendation(NamedTuple):
    """The law of one family that is recommended for a joint."""

    joint: str
    key: str  # 'contact.elastic' or 'contact.law'
    law: str  # '' if none is valid
    reason: str
    used: str  # the law that the grid has
    word: str  # HOLDS, DOUBTFUL or OUT, of the law that the grid has
    objection: str  # what is to be said of that

    def _name(self) -> str:
        """Return key and law in words."""
        law = self.law or "none (none is valid there)"
        return f"{self.key} {law}{' (in use)' if self.law == self.used else ''}"

    def _used(self) -> str:
        """Return what is to be said of the law in use."""
        said = HOLDS if self.word == HOLDS else f"is {self.word}: {self.objection}"
        return f"In use is {self.used}, which {said}."


def _recommended_text(laws: Sequence[Recommendation]) -> str:
    """Return the laws that are recommended for the joints _JOINTS, with the reasons and what the grid has."""
    head = f"Recommended for {_JOINTS}: {', '.join(each._name() for each in laws)}."
    reasons = [f"{each.law}: {each.reason}." for each in laws if each.law]
    return " ".join([head, *reasons, *(each._used() for each in laws if each.law != each.used)])


def recommended_texts(laws: Iterable[Recommendation]) -> list[str]:
    """Return a line on the laws that are recommended for each joint; joints with the same line share it."""
    by_joint: dict[str, list[Recommendation]] = {}
    for each in laws:
        by_joint.setdefault(each.joint, []).append(each)
    alike: dict[str, list[str]] = {}
    for joint, own in by_joint.items():
        alike.setdefault(_recommended_text(own), []).append(joint)
    return [text.replace(_JOINTS, wording.sentence_list(joints)) for text, joints in alike.items()]


def recommendations(case: Case) -> list[Recommendation]:
    """Return what is recommended for each dry joint of a case."""
    return [each for joint, known in zip(case.joints, advice(case), strict=True) for each in _of(joint, known.verdicts)]


def recommendations_for(joint: Joint, load: float | None) -> list[Recommendation]:
    """Return what is recommended for a joint under a load (N)."""
    return _of(joint, of_joint(joint, load).verdicts)


def elastic_words(joint: Joint, load: float | None) -> dict[str, tuple[str, str]]:
    """Return elastic law -> whether it is valid for a joint under a load (N), and why."""
    return {
        verdict.law: (verdict.word, verdict.reason)
        for verdict in of_joint(joint, load).verdicts
        if verdict.family == "elastic"
    }


def alternatives(case: Case) -> dict[str, list[str]]:
    """Return path of a law's name -> the other laws that hold in its joint."""
    names: dict[str, list[str]] = {}
    for joint, known in zip(case.joints, advice(case), strict=True):
        for verdict in known.verdicts:
            if verdict.family in FAMILIES and verdict.word == HOLDS and verdict.law != _used(joint, verdict.family):
                names.setdefault(f"joints.{joint.name}.{KEYS[verdict.family]}", []).append(verdict.law)
    return names


def advice_text(source: str | PathLike, name: str | None = None) -> str:
    """Return what suits the joints of a grid, law by law, or what is to be said there of the law `name`.

    Of many cases some are looked at, and a law is called by the worst that is to be said of it.  Raises InputError.
    """
    cases = grid.load(source, catalogue())
    places = np.unique(np.linspace(0, len(cases) - 1, MOST_CASES).round().astype(int)).tolist()
    looked = [cases.case(place) for place in places]
    by_case = [advice(case) for case in looked]
    alike: dict[tuple[str, ...], list[str]] = {}  # paragraphs -> the joints they are about
    for number, section in enumerate(looked[0].joints):
        text = _paragraphs(section, [each[number] for each in by_case], name)
        alike.setdefault(text, []).append(section.name)
    lines: list[str] = []
    printed: dict[str, str] = {}  # paragraph on a family of laws -> the joint where it is
    for (first, *families), joints in alike.items():
        lines.append(f"{', '.join(joints)}: {first.replace(_JOINTS, wording.sentence_list(joints))}")
        for paragraph in families:
            there = printed.setdefault(paragraph, joints[0])
            lines.append(paragraph if there == joints[0] else f"{paragraph.splitlines()[0]}: as for {there}")
    return "\n\n".join([*lines, _CAVEAT])


def _paragraphs(joint: Joint, looked: Sequence[Advice], name: str | None) -> tuple[str, ...]:
    """Return what is to be said of a joint in some cases, then of each family of laws; `joint` is that of the first."""
    settings = dict.fromkeys((looked[0].setting, looked[-1].setting))
    worst = [_worst(verdicts) for verdicts in _by_law(looked).values()]
    if name is not None:
        chosen = [each for each in worst if each.law == name]
        if not chosen:
            known = dict.fromkeys(each.law for each in worst)
            raise InputError(f"list: no entry '{name}' there{nearest(name, known)}")
        return " ... ".join(settings), *("\n".join(_rows([each])) for each in chosen)
    recommended = _of(joint, worst)
    lines = [" ... ".join(settings), *(["", _recommended_text(recommended)] if recommended else [])]
    if factor := _factor(joint, [each.law for each in worst if each.family == "elastic" and each.word == HOLDS]):
        lines.append(factor)
    families = sorted({each.family for each in worst}, key=[*KEYS].index)
    rows = ("\n".join(_rows([each for each in worst if each.family == family])) for family in families)
    return "\n".join(lines), *rows


def _rows(verdicts: list[Verdict]) -> list[str]:
    """Return the laws of a family: those that hold row by row, of many others the names alone."""
    alone = len(verdicts) == 1
    shown = [verdict for verdict in verdicts if alone or verdict.word == HOLDS]
    wide = max((len(each.law) for each in shown), default=0)
    lines = [KEYS[verdicts[0].family], *(f"  {each.law:{wide}}  {each.word:8}  {each.reason}" for each in shown)]
    for word in () if alone else (DOUBTFUL, OUT):
        if names := [verdict.law for verdict in verdicts if verdict.word == word]:
            lines.append(f"  {word}: {', '.join(names)} (clearsweep list NAME --for GRID gives the reason)")
    return lines


def _factor(joint: Joint, names: list[str]) -> str:
    """Return by which factor the forces of elastic laws that hold differ; '' of fewer than two."""
    candidates = registry.elastic_candidates(joint)
    forces = {law: registry.elastic_forces(candidates[law][0], [DEPTH])[0] for law in names}
    if len(forces) < 2:
        return ""
    softest, stiffest = min(forces, key=forces.__getitem__), max(forces, key=forces.__getitem__)
    at = wording.text(DEPTH, "m", 1)
    return (
        f"The {len(forces)} valid elastic laws differ by a factor of "
        f"{wording.plain(forces[stiffest] / forces[softest])} in force at {at}, from {softest} to {stiffest}."
    )


def _of(joint: Joint, verdicts: Iterable[Verdict]) -> list[Recommendation]:
    """Return what is recommended for a joint, by what is to be said of each law."""
    listed = list(verdicts)
    recommended = []
    for family in FAMILIES:
        own = {each.law: each for each in listed if each.family == family}
        if not own or all(each.reason == _NO_RESTITUTION for each in own.values() if each.word == HOLDS):
            continue
        used = _used(joint, family)
        mine = own.get(used, Verdict(family, used, HOLDS, ""))
        holding = [each for each in own.values() if each.word == HOLDS]
        best = min(holding, key=_rank, default=None)
        law, reason = (best.law, best.merit.reason if best.merit else best.reason) if best else ("", "")
        recommended.append(Recommendation(joint.name, KEYS[family], law, reason, used, mine.word, mine.reason))
    return recommended


_NO_RESTITUTION = "the joint has no restitution"


def _rank(verdict: Verdict) -> int:
    return verdict.merit.rank if verdict.merit else len(WORDS) + 10


def _used(joint: Joint, family: str) -> str:
    return joint.contact.law if family == "law" else joint.contact.elastic or ""


def _by_law(advices: Iterable[Advice]) -> dict[tuple[str, str], list[Verdict]]:
    """Return what is to be said of each law in some cases."""
    verdicts: dict[tuple[str, str], list[Verdict]] = {}
    for verdict in (verdict for offered in advices for verdict in offered.verdicts):
        verdicts.setdefault((verdict.family, verdict.law), []).append(verdict)
    return verdicts


def _worst(verdicts: list[Verdict]) -> Verdict:
    """Return the worst of what is to be said of a law, and in how many cases it is."""
    worst = max(verdicts, key=lambda verdict: WORDS.index(verdict.word))
    count = sum(verdict.word == worst.word for verdict in verdicts)
    share = f" ({count} of {len(verdicts)} cases)" if count < len(verdicts) else ""
    return worst._replace(reason=f"{worst.reason}{share}")
