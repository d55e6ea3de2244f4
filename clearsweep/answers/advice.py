"""The limit to add to a grid without limits, as text of the grid."""

import math

from ..language import wording
from . import films
from .case_ranking import START_UP
from .cases import FinishedCases

NO_LIMITS = "No limits are set, so no case is assessed."
MICROMETRE = 1e-6  # m


def suggest_limit(cases: FinishedCases) -> str:
    """Return the suggested limit for a grid without limits, with the reason for its value."""
    names = {column.name for column in cases.layout.columns}
    if cases.ranking.question == "start-up":
        return _advice_text("", f"{START_UP}: 1 s")
    if not cases.ranking.candidates:
        return NO_LIMITS
    if cases.ranking.question == "film":
        return _film_advice(cases)
    joint = cases.ranking.candidates[0].joint
    ideal_peak = f"{joint}_force_peak_ideal"
    is_known = ideal_peak in names and cases.has_values(ideal_peak)
    return _advice_text("", f"{joint}_force_peak: " + (f"{{at_most: 3, times: {ideal_peak}}}" if is_known else "5 kN"))


def _advice_text(reason: str, limit: str) -> str:
    """Return the advice with its reason and a limit as text of the grid."""
    return " ".join(filter(None, (NO_LIMITS, reason, f"To assess them, add to the grid: limits: {{{limit}}}")))


def _film_advice(cases: FinishedCases) -> str:
    """Return the advice on a film: a multiple of the roughness if this is known, else the end of the film law."""
    worst_case = cases.worst_case()
    joint = worst_case.joint if worst_case else cases.ranking.candidates[0].joint
    column, multiple_text = (
        f"{joint}_{films.THICKNESS}",
        f"{films.ROUGHNESSES:g} times the combined roughness of the surfaces",
    )
    required_thickness = films.required_thickness(cases, joint)
    if required_thickness is not None and required_thickness.size:
        return _advice_text(
            f"A film separates them above {multiple_text}.",
            f"{column}: {{at_least: {_micrometres_text(required_thickness.max())}}}",
        )
    law_end = films.law_end_thickness(cases, joint)
    no_roughness_text = f"No roughness is given: a film should exceed {multiple_text}."
    if law_end is None:
        return f"{NO_LIMITS} {no_roughness_text}"
    law_end_text = _micrometres_text(law_end)
    is_clearance_varied = f"joints.{wording.joint_name(joint)}.clearance" in cases.varied_paths
    reason = (
        f"{no_roughness_text} The film law ends at "
        f"{law_end_text}{' for the largest clearance' if is_clearance_varied else ''}."
    )
    return _advice_text(reason, f"{column}: {{at_least: {law_end_text}}}")


def _micrometres_text(length: float) -> str:
    """Return a length (m) in micrometres with two digits, rounded up, as text of the grid."""
    micrometres = length / MICROMETRE
    digits = 1 - math.floor(math.log10(micrometres))
    rounded = math.ceil(round(micrometres * 10.0**digits, 6)) / 10.0**digits
    return f"{rounded:.{max(digits, 0)}f} um".replace(".0 um", " um")
