"""Remarks on a finished case: laws beyond their range, films beyond their limit, implausible figures."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from ..answers.validity import (
    FilmState,
    PenetrationAndWear,
    RubbingJoint,
    ball_stiffness_remark,
    film_remarks,
    friction_heat_remark,
    imbalance_remark,
    law_range_remark,
    onset_remark,
    penetration_remark,
    pv_remark,
    wear_depth_remark,
    wear_rate_remark,
)
from ..contracts.case import Joint, column_name
from ..contracts.layout import FRICTION_POWER
from ..mechanics.joint import registry
from ..mechanics.joint.film import reynolds
from .scene import Scene
from .window import Window


def remarks(scene: Scene, window: Window, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the remarks on a finished case; '' replaces each remark that does not apply."""
    beyond_limit, rubbing_powers, balls, sizes, wearing = [], [], [], [], []
    for layout, joint in zip(scene.layout.joints, scene.case.joints, strict=True):
        name, radius = layout.name, joint.bearing_radius
        if fraction := summary[f"{name}_law_limit_fraction"]:
            beyond_limit.append((joint.name, joint.elastic_name, registry.penetration_limit(joint), fraction))
        if layout.friction and not layout.film:
            conductance = joint.thermal.conductance if joint.thermal else None
            rubbing_powers.append((joint.name, summary[f"{name}_friction_power"], conductance))
        if scene.mechanism.turns and registry.uses_ball_stiffness(joint):
            balls.append(joint.name)
        penetration = summary[f"{name}_penetration_max"] if joint.is_dry else 0.0
        wear_depth = summary[f"{name}_wear_depth_max"] if layout.wear_bins else 0.0
        sizes.append(PenetrationAndWear(joint.name, penetration, wear_depth, joint.clearance, radius))
        if layout.wear_bins:
            rate, pv = summary[f"{name}_wear_rate_max"], summary[f"{name}_pv_mean"]
            wearing.append(RubbingJoint(joint.name, rate, pv, radius or 0.0, joint.film is not None))
    rubbing_powers += _powers_without_clearance(scene, summary)
    has_film = any(joint.film for joint in scene.layout.joints)
    settings = scene.case.simulate
    return (
        law_range_remark(beyond_limit),
        onset_remark(_lasting_contacts(scene, window)),
        *(film_remarks(_film_states(scene, window, summary)) if has_film else ()),
        friction_heat_remark(rubbing_powers),
        ball_stiffness_remark(balls),
        penetration_remark(sizes),
        wear_depth_remark(sizes),
        wear_rate_remark(wearing),
        pv_remark(wearing),
        imbalance_remark(
            summary["energy_residual"], settings.tolerance, 0.5 * window.events + max(settings.revolutions, 1.0)
        ),
    )


def _powers_without_clearance(scene: Scene, summary: Mapping[str, Any]) -> list[tuple[str, float, None]]:
    """Return the name and the friction power (W) of joints without clearance; their conductance (None) is unknown."""
    names = dict.fromkeys([load.values["on"] for load in scene.case.loads if load.friction])
    return [
        (name, summary[f"{column_name(name)}_{FRICTION_POWER}"], None)
        for name in names
        if column_name(name) in scene.layout.rubbing
    ]


def _lasting_contacts(scene: Scene, window: Window) -> Iterator[tuple[str, float]]:
    """Yield joint and onset rate (m/s) of every contact that lasts for the whole window."""
    for index, joint in enumerate(scene.case.joints):
        rate = float(window.onset_rate[index])
        if joint.contact.onset == "first" and not math.isnan(rate) and window.totals.joint[index].onsets == 0.0:
            yield joint.name, rate


def _film_states(scene: Scene, window: Window, summary: Mapping[str, Any]) -> Iterator[FilmState]:
    """Yield the state of every film."""
    for index, joint in enumerate(scene.case.joints):
        if joint.film:
            totals = window.totals.joint[index]
            generated, dissipated = totals.generated_energy, totals.film_energy
            yield FilmState(
                joint.name,
                joint.film.limit,
                summary[f"{joint.column}_film_limit_fraction"],
                summary[f"{joint.column}_eccentricity_max"] / joint.clearance,
                joint.is_dry,
                summary[f"{joint.column}_film_taylor"],
                float(generated / max(dissipated, generated)) if generated > 0.0 else 0.0,
                passive_film(joint),
            )


def passive_film(joint: Joint) -> str:
    """Return a passive film law that is valid at the length / diameter of a joint."""
    if joint.length is None or joint.bearing_radius is None:
        return "reynolds"
    slenderness = 0.5 * joint.length / joint.bearing_radius
    if slenderness < reynolds.SHORTEST:
        return "short"
    return "reynolds" if slenderness <= reynolds.LONGEST else "long"
