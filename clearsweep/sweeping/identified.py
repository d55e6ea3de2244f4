"""Result of `identify` in run.json and in the last lines of a run."""

from pathlib import Path
from typing import Any

from .identifying import IdentificationResult
from .observed import GAIN, NOISE


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
