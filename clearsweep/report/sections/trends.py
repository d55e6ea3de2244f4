"""Comparison with trends of wear in the literature: pairs of cases that differ in one value only."""

import math
from typing import NamedTuple

import numpy as np

from ...answers.probability import Estimate
from ...language import wording
from ..blocks.picture import capitalise
from ..blocks.section import Points, Section
from ..blocks.table import Column, Table, count_cell
from ..data.axis import Axis
from ..data.study import WEAR_PER_MILLION_STROKES, Joint, Study
from ..one_case import worn
from ..statistics.matching import match_cases
from ..statistics.paired import trend_exponent
from ..statistics.sensitivity import estimate_quantile

UNEVEN_RATIO = 1.5  # deepest over mean depth around a body above which its wear is called uneven
MAX_CASES_READ = 200  # cases whose depths round the circle are read; ids are hashes, so the first ones are random
SHOWN, CONTRADICTED, OPEN, NO_CLAIM = "shown", "contradicted", "not decided", "no claim"
NOTE = (
    "The literature finds deeper wear with larger clearance, higher crank speed and lower stiffness, and uneven wear "
    "around the circumference. This section compares the depth per turn of the crank in pairs of cases that differ in "
    "one value only. The interval of the median change shows or contradicts a trend. It assumes no distribution of the "
    "depths. With a probability of 95 % all claims on a joint are judged rightly together (Holm 1979). If an interval "
    "allows both, or the cases are too few for one, the trend remains open. Volume and pressure give the reason. The "
    "volume is the coefficient times the integral of the force over the sliding distance. The depth is this volume "
    "over the area that the contact passes. So a higher pressure alone does not wear deeper. Wear is "
    f"uneven if its deepest place is at least {UNEVEN_RATIO} times as deep as the mean around the body."
)


class Claim(NamedTuple):
    """A trend of wear depth with a swept value that the literature names."""

    title: str
    path_endings: tuple[str, ...]  # last parts of the paths concerned
    sign: float  # 1: deeper with a larger value, -1: with a smaller one


CLAIMS = (
    Claim("deeper with larger clearance", ("clearance",), 1.0),
    Claim("deeper with higher crank speed", ("drive.speed",), 1.0),
    Claim("deeper with lower stiffness", ("contact.stiffness", "young"), -1.0),
)
#: Figures that give the reason of a trend: column of a joint, name.
REASONS = (("wear_volume", "volume"), ("pressure_mean", "mean pressure"))


class Answer(NamedTuple):
    """Result of a run for one claim about one joint."""

    title: str
    joint: Joint
    measure: str  # the estimate in words
    estimate: Estimate
    pair_count: int  # number of pairs or cases
    counted_noun: str
    verdict: str


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing wears, nothing turns or no case finished."""
    if study.cases.empty or not study.is_driven:
        return []
    answers = [answer for joint in study.joints if joint.wears for answer in _answers(study, joint)]
    if not answers:
        return []
    return [Section("wear-trends", "Trends of wear", [Points(_points(study, answers)), _table(study, answers)])]


def _answers(study: Study, joint: Joint) -> list[Answer]:
    if not study.has(joint.column(WEAR_PER_MILLION_STROKES)):
        return []
    concerned = [(claim, axis) for claim in CLAIMS for axis in study.levels() if _concerns(claim, axis, joint)]
    reasons = [answer for claim, axis in concerned for answer in _reasons(study, joint, claim, axis)]
    return _judged(study, joint, concerned) + _unevenness(study, joint) + reasons


def _concerns(claim: Claim, axis: Axis, joint: Joint) -> bool:
    """Return whether a claim is about this axis, in this joint or in the drive."""
    in_scope = axis.path.startswith(f"joints.{joint.title}.") or axis.path == "drive.speed"
    is_positive = axis.is_numeric and min(axis.values) > 0.0
    return in_scope and is_positive and axis.path.endswith(claim.path_endings)


def _judged(study: Study, joint: Joint, concerned: list[tuple[Claim, Axis]]) -> list[Answer]:
    """Return the answers to claims, each at the level that Holm's procedure gives it.

    All claims share the probability of error; those that are decided leave it to the others (Holm 1979, Scand. J.
    Stat. 6:65).
    """
    answers: dict[int, Answer] = {}
    while len(answers) < len(concerned):
        remaining = [index for index in range(len(concerned)) if index not in answers]
        tried = {index: _answer_for_axis(study, joint, *concerned[index], len(remaining)) for index in remaining}
        decided = {index: answer for index, answer in tried.items() if answer.verdict != OPEN}
        answers |= decided or tried
    return [answers[index] for index in range(len(concerned))]


def _answer_for_axis(study: Study, joint: Joint, claim: Claim, axis: Axis, claims: int) -> Answer:
    """Return the answer to a claim, one of `claims`, from pairs of cases that differ only in the value of one axis."""
    table = match_cases(study, axis).table(study, joint.column(WEAR_PER_MILLION_STROKES))
    estimate, pairs = trend_exponent(table.columns.to_numpy(float), table.to_numpy(float), claims)
    bounds = sorted((claim.sign * estimate.low, claim.sign * estimate.high))
    measure = f"factor of the depth for twice the {axis.name}"
    return Answer(claim.title, joint, measure, _doubled(estimate), pairs, "pairs", _verdict(*bounds, border=0.0))


def _doubled(exponent: Estimate) -> Estimate:
    """Return the factor of a figure for twice the value, from its exponent."""
    return Estimate(*(2.0**value for value in exponent))


def _reasons(study: Study, joint: Joint, claim: Claim, axis: Axis) -> list[Answer]:
    """Return how volume and pressure change with the value of a claim, which decide nothing."""
    matches, answers = match_cases(study, axis), []
    depth, per_strokes = (
        matches.table(study, joint.column(figure)) for figure in ("wear_depth_max", WEAR_PER_MILLION_STROKES)
    )
    for figure, name in REASONS:
        if not study.has(joint.column(figure)):
            continue
        table = matches.table(study, joint.column(figure))
        values = table * per_strokes / depth if figure == "wear_volume" else table  # of as many turns
        estimate, pairs = trend_exponent(table.columns.to_numpy(float), values.to_numpy(float))
        measure = f"factor for twice the {axis.name}"
        answers.append(Answer(f"{name} with {axis.name}", joint, measure, _doubled(estimate), pairs, "pairs", NO_CLAIM))
    return answers


def _unevenness(study: Study, joint: Joint) -> list[Answer]:
    """Return the unevenness of the wear of each body."""
    case_ids = study.cases.index[study.cases[joint.column("wear_depth_max")].to_numpy() > 0.0][:MAX_CASES_READ]
    depths = [[worn.deepest_along_axis(depth) for depth in study.run.wear(case_id)[joint.name]] for case_id in case_ids]
    answers = []
    for index, body in enumerate(("bearing", "journal")):
        ratios = np.sort([depth[index].max() / depth[index].mean() for depth in depths if depth[index].max() > 0.0])
        if len(ratios):
            median = estimate_quantile(ratios, 0.5) if len(ratios) > 1 else Estimate(ratios[0], math.nan, math.nan)
            answer = _verdict(median.low, median.high, border=UNEVEN_RATIO)
            title = f"uneven round the {body}"
            answers.append(Answer(title, joint, "deepest over mean depth", median, len(ratios), "cases", answer))
    return answers


def _verdict(low: float, high: float, *, border: float) -> str:
    """Return the verdict on an interval: entirely above a border, below it, or neither."""
    return SHOWN if low > border else CONTRADICTED if high < border else OPEN


def _points(study: Study, answers: list[Answer]) -> list[str]:
    """Return one sentence for each answer."""
    sentences = []
    for verdict_word in (SHOWN, CONTRADICTED, OPEN):
        titles = [
            answer.title + study.joint_text(answer.joint, " ({})")
            for answer in answers
            if answer.verdict == verdict_word
        ]
        sentences += [f"{capitalise(verdict_word)}: {wording.sentence_list(titles)}."] if titles else []
    factors = [
        f"{answer.title}{study.joint_text(answer.joint, ' ({})')} {wording.number_text(answer.estimate.value)}"
        for answer in answers
        if answer.verdict == NO_CLAIM and math.isfinite(answer.estimate.value)
    ]
    return sentences + ([f"Reason, as factors of a doubling: {wording.sentence_list(factors)}."] if factors else [])


def _table(study: Study, answers: list[Answer]) -> Table:
    columns = ("wear is", "joint", "answer", "measured", "median", "interval from", "to", "number", "of")
    rows = [
        (
            answer.title,
            answer.joint.title,
            answer.verdict,
            answer.measure,
            *answer.estimate,
            count_cell(answer.pair_count),
            answer.counted_noun,
        )
        for answer in answers
    ]
    return Table("wear_trends", "Trends of wear in this run", NOTE, tuple(map(Column, columns)), rows)
