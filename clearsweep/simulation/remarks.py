"""What is to be remarked on a finished case: laws past their range, films past their limit, figures nobody meant."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from ..judging.validity import Lubricated, Reached, films, imbalance, kept_onsets, past_limits, too_deep, worn_through
from ..mechanics.joint import registry
from ..mechanics.observe.tally import ONSETS
from .scene import Scene
from .window import Window


def remarks(scene: Scene, window: Window, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the remarks on a finished case, '' for each that there is no reason for."""
    parts = list(zip(scene.layout.joints, scene.case.joints, strict=True))
    shares = [(joint, summary[f"{part.name}_law_limit_fraction"]) for part, joint in parts]
    limits = past_limits(
        [(joint.name, joint.elastic_name, registry.penetration_limit(joint), share) for joint, share in shares if share]
    )
    oiled = films(_lubricated(scene, summary)) if any(part.film for part, _ in parts) else ()
    return limits, kept_onsets(_lasting(scene, window)), *oiled, *_nonsense(scene, window, summary)


def _lasting(scene: Scene, window: Window) -> Iterator[tuple[str, float]]:
    """Yield joint and onset rate (m/s) of every contact that lasts throughout the window and keeps that rate."""
    for j, joint in enumerate(scene.case.joints):
        rate = float(window.onset[j])
        if joint.contact.onset == "first" and not math.isnan(rate) and window.tally.joint[j, ONSETS] == 0.0:
            yield joint.name, rate


def _lubricated(scene: Scene, summary: Mapping[str, Any]) -> Iterator[Lubricated]:
    """Yield what became of every film."""
    for joint in scene.case.joints:
        if joint.film:
            yield Lubricated(
                joint.name,
                joint.film.limit,
                summary[f"{joint.column}_film_limit_fraction"],
                summary[f"{joint.column}_eccentricity_max"] / joint.clearance,
                joint.is_dry,
                summary[f"{joint.column}_film_taylor"],
            )


def _nonsense(scene: Scene, window: Window, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return remarks on figures of a finished case that cannot be meant, '' for each that can."""
    joints = [
        Reached(
            joint.name,
            summary[f"{part.name}_penetration_max"] if joint.is_dry else 0.0,
            summary[f"{part.name}_wear_depth_max"] if part.wear_bins else 0.0,
            joint.clearance,
            joint.bearing_radius,
        )
        for part, joint in zip(scene.layout.joints, scene.case.joints, strict=True)
    ]
    count = 0.5 * window.events + max(scene.case.simulate.revolutions, 1.0)
    balance = imbalance(summary["energy_residual"], scene.case.simulate.tolerance, count)
    return too_deep(joints), worn_through(joints), balance
