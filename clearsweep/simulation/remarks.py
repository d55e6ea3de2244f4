"""Remarks on a finished case: laws beyond their range, films beyond their limit, implausible figures."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from ..contracts.case import Joint, column_name
from ..contracts.layout import FRICTION_POWER
from ..judging.validity import (
    FilmState,
    PenetrationAndWear,
    RubbingJoint,
    ball_stiffness,
    films,
    friction_heat,
    imbalance,
    lasting_onsets,
    outside_law_range,
    pv_high,
    too_deep,
    worn_away,
    worn_through,
)
from ..mechanics.joint import registry
from ..mechanics.joint.film import reynolds
from .scene import Scene
from .window import Window


def remarks(scene: Scene, window: Window, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the remarks on a finished case; '' replaces each remark that does not apply."""
    pairs = list(zip(scene.layout.joints, scene.case.joints, strict=True))
    limit_shares = [(joint, summary[f"{layout.name}_law_limit_fraction"]) for layout, joint in pairs]
    range_remark = outside_law_range(
        [
            (joint.name, joint.elastic_name, registry.penetration_limit(joint), share)
            for joint, share in limit_shares
            if share
        ]
    )
    film_remarks = films(_film_states(scene, window, summary)) if any(layout.film for layout, _ in pairs) else ()
    dry_pairs = [(layout, joint) for layout, joint in pairs if layout.friction and not layout.film]
    conductances = [joint.thermal.conductance if joint.thermal else None for _, joint in dry_pairs]
    dry_powers = [(joint.name, summary[f"{layout.name}_friction_power"]) for layout, joint in dry_pairs]
    ideal_powers = [
        (name, summary[f"{column_name(name)}_{FRICTION_POWER}"], None) for name in _ideal_joints_with_friction(scene)
    ]
    heat_remark = friction_heat(
        [*((*power, conductance) for power, conductance in zip(dry_powers, conductances, strict=True)), *ideal_powers]
    )
    ball_remark = ball_stiffness(
        [joint.name for _, joint in pairs if scene.mechanism.turns and registry.is_ball(joint)]
    )
    return (
        range_remark,
        lasting_onsets(_lasting_contacts(scene, window)),
        *film_remarks,
        heat_remark,
        ball_remark,
        *_implausible_remarks(scene, window, summary),
    )


def _ideal_joints_with_friction(scene: Scene) -> list[str]:
    """Return the names of joints without clearance that have friction."""
    names = dict.fromkeys(load.values["on"] for load in scene.case.loads if load.friction)
    return [name for name in names if column_name(name) in scene.layout.rubbing]


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


def _implausible_remarks(scene: Scene, window: Window, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the remarks on implausible figures of a finished case; '' replaces each remark that does not apply."""
    joints = [
        PenetrationAndWear(
            joint.name,
            summary[f"{layout.name}_penetration_max"] if joint.is_dry else 0.0,
            summary[f"{layout.name}_wear_depth_max"] if layout.wear_bins else 0.0,
            joint.clearance,
            joint.bearing_radius,
        )
        for layout, joint in zip(scene.layout.joints, scene.case.joints, strict=True)
    ]
    count = 0.5 * window.events + max(scene.case.simulate.revolutions, 1.0)
    energy_remark = imbalance(summary["energy_residual"], scene.case.simulate.tolerance, count)
    rubbing_joints = [
        RubbingJoint(
            joint.name,
            summary[f"{layout.name}_wear_rate_max"],
            summary[f"{layout.name}_pv_mean"],
            joint.bearing_radius or 0.0,
            joint.film is not None,
        )
        for layout, joint in zip(scene.layout.joints, scene.case.joints, strict=True)
        if layout.wear_bins
    ]
    return too_deep(joints), worn_through(joints), worn_away(rubbing_joints), pv_high(rubbing_joints), energy_remark
