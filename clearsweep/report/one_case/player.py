"""Data of the player of a page, which shows one case in motion."""

from collections.abc import Mapping

import numpy as np

from ... import simulation
from ...contracts.machine import GROUND
from ...language import wording
from ...language.errors import InputError
from ..blocks.section import Interactive, encode_floats
from ..study import Joint, Study, resolve_cases
from .motion import ORBIT_CHANNELS, History, has_straight_walls, history_of, joint_histories

RELATIVE_ROUNDING = (
    1e-12  # of the largest value of a curve: smaller values, such as a torque at a dead centre, are rounding
)
MAX_SAMPLES = 3000  # samples: longer histories are cut to those around the largest force
DRAWN_PENETRATION = 0.25  # of the clearance: drawn height of the deepest penetration
NO_SCRIPTS = "The animation needs scripts. clearsweep show DIR CASE draws the motion without scripts."


def player_data(study: Study, case_id: str, channels: Mapping) -> Interactive | None:
    """Return the data of a case for the player, or None without rotation, picture or complete channels."""
    if not all(f"joints/{joint.name}/{name}" in channels for joint in study.joints for name in ORBIT_CHANNELS):
        return None
    history, sketch = history_of(study, case_id, channels), _load_sketch(study, case_id)
    bodies = _bodies(sketch, channels) if sketch else []
    if history.angle is None or sketch is None or not bodies:
        return None
    samples = _shown_samples(study, channels)
    data = {
        "angle": encode_floats(np.degrees(history.angle[samples])),
        "bodies": [body | {key: encode_floats(body[key][samples]) for key in ("x", "y", "angle")} for body in bodies],
        "ground": [joint.position.tolist() for joint in sketch.joints if joint.grounded and joint.guide is None],
        "joints": _joints(study, case_id, channels, samples, sketch),
        "charts": _charts(study, case_id, history, samples),
    }
    return Interactive("player", f"motion-of-{case_id}", f"Case {case_id} in motion", data, NO_SCRIPTS)


def _shown_samples(study: Study, channels: Mapping) -> slice:
    """Return the slice of displayed samples."""
    force = np.asarray(channels[f"joints/{study.most_loaded_joint().name}/force_normal"], float)
    if len(force) <= MAX_SAMPLES:
        return slice(None)
    start = min(max(int(force.argmax()) - MAX_SAMPLES // 2, 0), len(force) - MAX_SAMPLES)
    return slice(start, start + MAX_SAMPLES)


def _load_sketch(study: Study, case_id: str) -> simulation.Sketch | None:
    """Return the mechanism of a case at its start, or None if it has no picture or is from another version."""
    try:
        return simulation.sketch(resolve_cases(study, [case_id])[0])
    except InputError:
        return None


def _bodies(sketch: simulation.Sketch, channels: Mapping) -> list[dict]:
    """Return the moving bodies over time, or [] if a body has no channels.

    Each has its points relative to the centre of mass at the start, and its position and angle over time.
    """
    bodies = []
    for body in sketch.bodies:
        name = body.name.replace("-", "_")
        if body.name == GROUND:
            continue
        if not {f"{name}/x", f"{name}/y"} <= set(channels):
            return []
        x, y = (np.asarray(channels[f"{name}/{key}"], float) for key in ("x", "y"))
        angle = np.asarray(channels.get(f"{name}/angle", np.full(len(x), body.angle)), float)
        bodies.append(
            {"began": body.angle, "points": (body.points - body.center).tolist(), "x": x, "y": y, "angle": angle}
        )
    return bodies


def _joints(study: Study, case_id: str, channels: Mapping, samples: slice, sketch: simulation.Sketch) -> list[dict]:
    """Return the joints over time: position and force of the journal or block, clearance, and the walls if straight."""
    joints = []
    for joint in study.joints:
        x, y, force = (
            np.asarray(channels[f"joints/{joint.name}/{key}"], float)[samples] for key in ("x", "y", "force_normal")
        )
        clearance = study.value(case_id, f"joints.{joint.title}.clearance")
        if clearance is None:
            continue
        distance, walls = np.hypot(x, y), None
        if has_straight_walls(study, joint):
            half_length, tilt = _block(study, case_id, joint, sketch, channels)
            distance = abs(y) + half_length * abs(np.sin(tilt[samples]))
            walls = {"half_length": half_length, "tilt": encode_floats(tilt[samples])}
        deepest = max(float(distance.max()) - float(clearance), 0.0)
        force_scale = wording.scale("N", force)
        joints.append(
            {
                "name": joint.title,
                "clearance": float(clearance),
                "said": wording.quantity_text(float(clearance), "m"),
                "magnified": float(f"{max(DRAWN_PENETRATION * float(clearance) / deepest, 1.0):.1g}")
                if deepest > 0.0
                else 1.0,
                "x": encode_floats(x),
                "y": encode_floats(y),
                "walls": walls,
                "force": encode_floats(force / force_scale.factor),
                "most": float(force.max() / force_scale.factor),
                "unit": force_scale.unit,
            }
        )
    return joints


def _block(
    study: Study, case_id: str, joint: Joint, sketch: simulation.Sketch, channels: Mapping
) -> tuple[float, np.ndarray]:
    """Return half the length (m) of a guide's block and its tilt (rad) between the walls; zeros for a pin in a slot."""
    sketched_joint = next(sketched for sketched in sketch.joints if sketched.name == joint.title)
    tilt = np.zeros(len(channels[f"joints/{joint.name}/y"]))
    if sketched_joint.guide is None:
        return 0.0, tilt
    start = {body.name: body.angle for body in sketch.bodies}
    for body, sign in ((sketched_joint.sliding_body, 1.0), (sketched_joint.guiding_body, -1.0)):
        channel = f"{body.replace('-', '_')}/angle"
        if channel in channels:
            tilt += sign * (np.asarray(channels[channel], float) - start[body])
    return 0.5 * float(study.value(case_id, f"joints.{joint.title}.length") or 0.0), tilt


def _zero_rounding_errors(values: np.ndarray) -> np.ndarray:
    """Return values; those within the rounding error of the largest are set to 0."""
    clean: np.ndarray = np.where(
        np.abs(values) < RELATIVE_ROUNDING * np.nanmax(np.abs(values), initial=0.0), 0.0, values
    )
    return clean


def _charts(study: Study, case_id: str, history: History, samples: slice) -> list[dict]:
    charts = []
    for curve in joint_histories(study, case_id, history):
        scale = wording.scale(curve.unit, curve.actual[samples])
        lines = [("with clearance", _zero_rounding_errors(curve.actual), "accent", False)]
        if curve.ideal is not None:
            lines.append(("ideal", _zero_rounding_errors(curve.ideal), "mark", True))
        charts.append(
            {
                "name": curve.name,
                "unit": scale.unit,
                "lines": [
                    {
                        "name": name,
                        "values": encode_floats(values[samples] / scale.factor),
                        "colour": colour,
                        "dashed": dashed,
                    }
                    for name, values, colour, dashed in lines
                ],
            }
        )
    return charts
