"""The figures of merit, events and wear that an integration came to."""

import math

import numpy as np

from ..mechanics.observe import tally as tallies
from ..mechanics.solver import loop
from ..results import EVENT_DTYPE
from .run import Run, period
from .scene import Scene


def events_of(scene: Scene, run: Run) -> np.ndarray:
    """Return the event log as a structured array."""
    events = np.empty(len(run.events), EVENT_DTYPE)
    names = np.array([part.name for part in scene.layout.joints])
    events["t"], events["rate"], events["force_peak"] = run.events[:, 0], run.events[:, 3], run.events[:, 4]
    events["joint"] = names[run.events[:, 1].astype(int)]
    events["kind"] = np.where(run.events[:, 2] == loop.ONSET, "on", "off")
    return events


def wear_of(scene: Scene, run: Run) -> dict:
    """Return the wear depths of bearing and journal, m, by joint."""
    depths = run.tally.wear.reshape(len(scene.layout.joints), 2, -1)
    return {
        part.name: (depths[place, 0, : part.wear_bins].copy(), depths[place, 1, : part.wear_bins].copy())
        for place, part in enumerate(scene.layout.joints)
        if part.wear_bins
    }


def figures_of(scene: Scene, run: Run, end: float) -> dict:
    """Return the figures of merit of an integration that went through."""
    turning = scene.mechanism.turns
    whole, settings = run.tally.whole, scene.case.simulate
    duration = end - settings.discard * period(scene) if turning else run.work.y[run.work.time]
    turns = settings.revolutions - settings.discard if turning else 1.0
    figures = {"energy_residual": float(whole[tallies.RESIDUAL] / whole[tallies.KINETIC_MAX])}
    for place, (part, joint) in enumerate(zip(scene.layout.joints, scene.value.joints, strict=True)):
        row = run.tally.joint[place]
        depth = float(max(row[tallies.DEPTH_MAX], -joint.clearance))
        p99 = tallies.force_exceeded(run.tally.time[place], run.tally.ramp[place], 0.01 * duration)
        found = {
            "force_peak": row[tallies.FORCE_MAX],
            "force_rms": math.sqrt(row[tallies.FORCE_SQUARE] / duration),
            "force_p99": p99,
            "impacts_per_rev": row[tallies.ONSETS] / turns,
            "contact_fraction": row[tallies.CONTACT_TIME] / duration,
            "onset_rate_max": row[tallies.ONSET_MAX],
            "penetration_max": max(depth, 0.0),
            "eccentricity_max": joint.clearance + depth,
            "force_clips": row[tallies.CLIPS],
            "law_limit_fraction": row[tallies.BEYOND_TIME] / duration,
        }
        if part.wear_bins:
            found |= _wear_figures(scene, run, place, duration)
        figures |= {f"{part.name}_{name}": float(value) for name, value in found.items()}
    if not turning:
        joint = run.tally.joint[0]
        counted = joint[tallies.REBOUNDS]
        figures["pair_restitution"] = float(joint[tallies.RESTITUTION] / counted) if counted else None
        return figures
    largest = scene.mechanism.largest_reactions(scene.case.mechanism.values, scene.value.pace)
    for joint in scene.case.joints:
        figures[f"{joint.column}_force_peak_ideal"] = largest[joint.name]
    figures["slider_acceleration_peak"] = float(whole[tallies.ACCELERATION_MAX])
    figures["slider_acceleration_rms"] = math.sqrt(whole[tallies.ACCELERATION_SQUARE] / duration)
    figures["slider_error_max"] = float(whole[tallies.ERROR_MAX])
    figures["crank_torque_peak"] = float(whole[tallies.TORQUE_MAX])
    return figures


def _wear_figures(scene: Scene, run: Run, place: int, duration: float) -> dict:
    """Return the figures of one joint's wear."""
    part, joint = scene.layout.joints[place], scene.value.joints[place]
    bearing, journal = wear_of(scene, run)[part.name]
    deepest = max(bearing.max(), journal.max())
    cell = 2.0 * math.pi / part.wear_bins * joint.wear.length
    arcs, narrow = run.tally.account[place]
    return {
        "wear_depth_max": deepest,
        "wear_rate_max": deepest / duration,
        "wear_volume": cell * (joint.bearing_radius * bearing.sum() + joint.journal_radius * journal.sum()),
        "wear_narrow_arcs": narrow / arcs if arcs else 0.0,
    }
