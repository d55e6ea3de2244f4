"""Approach speeds up to which contacts stay elastic, as sentences, cards and pictures."""

import numpy as np

from ...answers.validity import YIELD_SPEED
from ...language import wording
from ...language.errors import InputError
from ..data.study import Joint, Study, joint_of, resolve_cases

MAX_SPEED_RATIO = 3.0  # times the fastest onset: a higher line would compress all onsets at the bottom of a picture
_NO_STRENGTH = ", because it needs a yield strength or a hardness"


def yield_speed_sentence(study: Study, joint: Joint) -> str:
    """Return the sentence on the approach speeds (m/s) of first yield of a joint in all cases."""
    column = joint.column(YIELD_SPEED)
    if not study.has(column):
        reason = " for this kind of joint or law" if _has_strength(study, joint) else _NO_STRENGTH
        return f"The speed at which the contact first yields is not computed{reason}."
    extremes = (study.cases[column].min(), study.cases[column].max())
    scale = wording.scale("m/s", extremes)
    range_text = " to ".join(dict.fromkeys(scale.number_text(extreme, 2) for extreme in extremes))
    return f"The contact first yields at {scale.with_unit(range_text)}."


def _has_strength(study: Study, joint: Joint) -> bool:
    """Return whether the strength of a joint's weaker body is known in any case; False without a finished case."""
    layout = next(joint_layout for joint_layout in study.run.layout.joints if joint_layout.name == joint.name)
    if layout.strength:
        return True
    try:
        cases = resolve_cases(study, study.cases.index[:1])
    except InputError:  # a law that this version does not know
        return False
    return any(joint_of(case, joint).strength is not None for case in cases)


def yield_speeds(study: Study, case_id: str, fastest: float) -> list[tuple[str, float]]:
    """Return joint and approach speed (m/s) of first yield in a case; speeds far above the `fastest` are left out."""
    speeds = []
    for joint in study.joints:
        column = joint.column(YIELD_SPEED)
        speed = float(study.cases.at[case_id, column]) if study.has(column) else np.nan
        if speed <= MAX_SPEED_RATIO * fastest:
            speeds.append((joint.title, speed))
    return speeds
