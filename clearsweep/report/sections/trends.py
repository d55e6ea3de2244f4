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
SHOWN, CONTRADICTED, OPEN = "shown", "contradicted", "not decided"
NOTE = (
    "The literature finds deeper wear with larger clearance, higher crank speed and lower stiffness, and uneven wear "
    "around the circumference. This section compares the depth per turn of the crank in pairs of cases that differ in "
    "one value only. The 95 % interval of the median change shows or contradicts a trend. It assumes no distribution "
    "of the depths. If the interval allows both, or the cases are too few for one, the trend remains open. Wear is "
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
    pairs = [(claim, axis) for claim in CLAIMS for axis in study.levels() if _concerns(claim, axis, joint)]
    return [_answer_for_axis(study, joint, *pair) for pair in pairs] + _unevenness(study, joint)


def _concerns(claim: Claim, axis: Axis, joint: Joint) -> bool:
    """Return whether a claim is about this axis, in this joint or in the drive."""
    in_scope = axis.path.startswith(f"joints.{joint.title}.") or axis.path == "drive.speed"
    is_positive = axis.is_numeric and min(axis.values) > 0.0
    return in_scope and is_positive and axis.path.endswith(claim.path_endings)


def _answer_for_axis(study: Study, joint: Joint, claim: Claim, axis: Axis) -> Answer:
    """Return the answer to a claim from pairs of cases that differ only in the value of one axis."""
    table = match_cases(study, axis).table(study, joint.column(WEAR_PER_MILLION_STROKES))
    estimate, pairs = trend_exponent(table.columns.to_numpy(float), table.to_numpy(float))
    bounds = sorted((claim.sign * estimate.low, claim.sign * estimate.high))
    factor = Estimate(*(2.0**value for value in estimate))
    measure = f"factor of the depth for twice the {axis.name}"
    return Answer(claim.title, joint, measure, factor, pairs, "pairs", _verdict(*bounds, border=0.0))


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
    return sentences


def _table(study: Study, answers: list[Answer]) -> Table:
    columns = ("wear is", "joint", "answer", "measured", "median", "95 % from", "to", "number", "of")
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
