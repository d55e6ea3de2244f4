"""The limit to add to a grid without limits, as text of the grid."""

import math

from ..language import wording
from . import films
from .case_ranking import START_UP
from .cases import Cases

NO_LIMITS = "No limits are set, so no case is assessed."
MICROMETRE = 1e-6  # m


def no_limits(cases: Cases) -> str:
    """Return the suggested limit for a grid without limits, with the reason for its value."""
    names = {column.name for column in cases.layout.columns}
    if cases.ranking.question == "start-up":
        return _text("", f"{START_UP}: 1 s")
    if not cases.ranking.candidates:
        return NO_LIMITS
    if cases.ranking.question == "film":
        return _film(cases)
    joint = cases.ranking.candidates[0].joint
    ideal = f"{joint}_force_peak_ideal"
    return _text("", f"{joint}_force_peak: " + (f"{{at_most: 3, times: {ideal}}}" if ideal in names else "5 kN"))


def _text(reason: str, limit: str) -> str:
    """Return the advice with its reason and a limit as text of the grid."""
    return " ".join(filter(None, (NO_LIMITS, reason, f"To assess them, add to the grid: limits: {{{limit}}}")))


def _film(cases: Cases) -> str:
    """Return the advice on a film: a multiple of the roughness if this is known, else the end of the film law."""
    worst = cases.worst()
    joint = worst[2] if worst else cases.ranking.candidates[0].joint
    column, times = f"{joint}_{films.THICKNESS}", f"{films.ROUGHNESSES:g} times the combined roughness of the surfaces"
    rough = films.needed(cases, joint)
    if rough is not None and rough.size:
        return _text(f"A film separates them above {times}.", f"{column}: {{at_least: {_micrometres(rough.max())}}}")
    end = films.end_of_law(cases, joint)
    missing = f"No roughness is given: a film should exceed {times}."
    if end is None:
        return f"{NO_LIMITS} {missing}"
    least = _micrometres(end)
    varies = f"joints.{wording.joint_name(joint)}.clearance" in cases.axes
    reason = f"{missing} The film law ends at {least}{' for the largest clearance' if varies else ''}."
    return _text(reason, f"{column}: {{at_least: {least}}}")


def _micrometres(length: float) -> str:
    """Return a length (m) in micrometres with two digits, rounded up, as text of the grid."""
    size = length / MICROMETRE
    digits = 1 - math.floor(math.log10(size))
    rounded = math.ceil(round(size * 10.0**digits, 6)) / 10.0**digits
    return f"{rounded:.{max(digits, 0)}f} um".replace(".0 um", " um")
