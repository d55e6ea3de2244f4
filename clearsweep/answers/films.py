"""Oil films: which cases keep them within their law and above the roughness, and which combinations always do."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from .cases import FinishedCases
from .judge import judge
from .judged import Cases

ROUGHNESSES = 3.0  # combined roughnesses of both surfaces that a film should exceed to separate them
THICKNESS, DRY_SHARE, LOSS, LIMIT_FRACTION = "film_thickness_min", "dry_load_share", "film_loss", "film_limit_fraction"
UNSAFE = "film_unsafe"  # column of the answer on films: 1 for an unsafe film
MAX_LISTED = 4  # safe combinations in the answer


def film_answer(record: Mapping[str, Any], layout: Layout, columns: Any, cases: Cases) -> dict[str, Any] | None:
    """Return the combinations of choices whose films are safe under every condition, the thickest first.

    Return None for a random sample, and if no joint has a film.
    """
    finished = FinishedCases(record, layout, tuple(cases.codes), cases.values)
    joints = film_joints(finished)
    if not joints or record.get("sample"):
        return None
    unsafe = is_unsafe(finished).astype(float)
    table = {path: cases.values(path) for path in cases.codes}
    table |= {name: cases.values(name) for name in ("case_id", "status")} | {UNSAFE: unsafe}
    column = {"name": UNSAFE, "unit": "1", "description": ""}
    of_films = {**record, "limits": {UNSAFE: 0.0}, "figures": {}, "layout": {"columns": [column]}}
    answer = judge(of_films, table, figures=())
    safe = [design for design in answer["designs"] if design["verdict"] == "meets"]
    thickness = np.nanmin([cases.numbers(f"{joint}_{THICKNESS}") for joint in joints], axis=0)
    named = [(float(thickness[cases.rows_of(design["values"])].min()), design["values"]) for design in safe]
    named.sort(key=lambda entry: -entry[0])
    texts = [(wording.texts_in_common_unit([size], "m")[0], values) for size, values in named]
    return {
        "count": len(safe),
        "undecided": sum(design["verdict"] == "undecided" for design in answer["designs"]),
        "missing": [design for design in answer["designs"] if design["missing"]][:MAX_LISTED],
        "total": answer["designs_total"],
        "criterion": criterion_text(finished, joints[0]),
        "designs": [{"values": values, "text": f"least film {text}"} for text, values in texts[:MAX_LISTED]],
    }


def film_joints(cases: FinishedCases) -> list[str]:
    """Return the joints with a film."""
    return [joint.name for joint in cases.layout.joints if cases.has_values(f"{joint.name}_{THICKNESS}")]


def required_thickness(cases: FinishedCases, joint: str) -> np.ndarray | None:
    """Return ROUGHNESSES times the combined roughness (m) of a joint's surfaces in each case; None if it is unknown."""
    roughness = cases.number(f"joints.{wording.joint_name(joint)}.film.transition.roughness")
    return None if roughness is None else ROUGHNESSES * roughness


def law_end_thickness(cases: FinishedCases, joint: str) -> float | None:
    """Return the largest film (m) at which the law of a joint's film ends; None if the grid does not state it."""
    paths = (f"joints.{wording.joint_name(joint)}.{key}" for key in ("clearance", "film.limit"))
    clearances, limit_ratios = (cases.number(path) for path in paths)
    if clearances is None or limit_ratios is None:
        return None
    thicknesses = clearances * (1.0 - limit_ratios)
    return float(np.nanmax(thicknesses)) if np.isfinite(thicknesses).any() else None


def is_outside_law(cases: FinishedCases) -> np.ndarray:
    """Return which cases (n,) leave the range of their film law."""
    is_outside = np.zeros(len(cases), bool)
    for joint in film_joints(cases):
        if cases.has_values(f"{joint}_{LIMIT_FRACTION}"):
            is_outside |= cases.values_of(f"{joint}_{LIMIT_FRACTION}").astype(float) > 0.0
    return is_outside


def is_unsafe(cases: FinishedCases) -> np.ndarray:
    """Return which cases (n,) leave the range of a film law, are too thin for the surfaces' roughness, or unknown."""
    is_unsafe = is_outside_law(cases)
    for joint in film_joints(cases):
        thickness, required = cases.values_of(f"{joint}_{THICKNESS}").astype(float), required_thickness(cases, joint)
        is_unsafe |= ~(thickness > 0.0)
        if required is not None:
            is_unsafe |= thickness < required
    return is_unsafe


def criterion_text(cases: FinishedCases, joint: str) -> str:
    """Return the criteria of a safe film: within its law, and thicker than the roughness if this is known."""
    roughness = "" if required_thickness(cases, joint) is None else f" and above {ROUGHNESSES:g} roughnesses"
    return f"within its law{roughness}"


def dry_share_text(share: float) -> str:
    """Return a dry load share in words; NaN means that no contact behind the film is modelled."""
    return "not modelled" if np.isnan(share) else wording.percent_text(share)
