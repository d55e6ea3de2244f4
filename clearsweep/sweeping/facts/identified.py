"""Result of `identify` in run.json and in the last lines of a run."""

from pathlib import Path
from typing import Any

from ...answers.questions import difference_text, identification_sentences
from ...searches.identifying import IdentificationResult
from ...searches.observed import GAIN, NOISE
from .settings import grid_text, number_of_joints


def of_run(identified: IdentificationResult) -> dict[str, Any]:
    """Return the result as a JSON-ready dictionary in SI units, without the sample."""
    facts = {name: value for name, value in identified._asdict().items() if name != "sample"}
    for name in ("parameters", "fits", "signals"):
        facts[name] = [fact._asdict() for fact in facts[name]]
    facts["parameters"] = [fact | {"ends": list(fact["ends"])} for fact in facts["parameters"]]
    facts["traded"] = [list(pair) for pair in identified.traded]
    facts["signals"] = [
        fact | {"file": Path(fact["file"]).name, "noise": list(fact["noise"])} for fact in facts["signals"]
    ]
    return facts | {"priors": {"gain": GAIN, "noise": list(NOISE)}}


def fit_lines(facts: dict[str, Any]) -> list[str]:
    """Return the lines that compare the best cases with the measured signals, feature by feature."""
    identified = facts["identified"]
    if not identified:
        return []
    lines = ["", "The best cases compared with the measured signals"]
    for fit in identified["fits"]:
        measured, computed = (grid_text(fit[name], fit["unit"]) for name in ("measured", "computed"))
        discrepancy = difference_text(fit)
        lines.append(f"  {fit['channel']}, {fit['feature']}: {measured} measured, {computed} computed{discrepancy}")
    joints = number_of_joints(parameter["path"] for parameter in identified["parameters"])
    lines += ["", f"Identified by {identified['finished']:,} finished cases of {identified['looked_at']:,}"]
    return [*lines, *(f"  {sentence}" for sentence in identification_sentences(identified, joints))]
