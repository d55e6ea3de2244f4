"""Result of `identify` in run.json and in the last lines of a run."""

from pathlib import Path
from typing import Any

from ..answers import identification
from ..language import wording
from .identifying import IdentificationResult
from .observed import GAIN, NOISE
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


def identify_lines(facts: dict[str, Any]) -> list[str]:
    """Return the last lines on the identified values."""
    identified = facts["identified"]
    if not identified:
        return []
    joints = number_of_joints(fit["path"] for fit in identified["parameters"])
    lines = ["", "The best cases compared with the measured signals"]
    for fit in identified["fits"]:
        measured, computed = (grid_text(fit[name], fit["unit"]) for name in ("measured", "computed"))
        discrepancy = identification.difference_text(fit)
        lines.append(f"  {fit['channel']}, {fit['feature']}: {measured} measured, {computed} computed{discrepancy}")
    cases = f"{identified['finished']:,} finished cases of {identified['looked_at']:,}"
    lines += ["", f"Identified by {cases} (a sample of the posterior in identify.parquet)"]
    lines += [f"  {sentence}" for sentence in identification.sentences(identified, joints)]
    for fit in identified["parameters"]:
        unit = facts["units"].get(fit["path"], "1")
        scale = wording.scale(unit, fit["value"], speed=fit["path"].endswith("speed"))
        scale = scale if scale.unit.isascii() or scale.unit.startswith("µ") else wording.Scale(1.0, unit)
        value, low, high = (f"{fit[key] / scale.factor:.3g}" for key in ("value", "low", "high"))
        unit_text = f" {scale.unit.replace('µ', 'u')}".rstrip()
        name = wording.axis_name(fit["path"], joints)
        lines.append(
            f"  {name} {value}{unit_text} (95 %: {low} to {high}{unit_text}){identification.certainty_text(fit)}"
        )
    return lines
