"""Variants of a case at the extremes of its factors, and what the parts of its scene cost."""

import itertools
import math
import time
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..language.errors import InputError
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from . import stability
from .case_tree import Tree, base_tree, leaves, plain, scene_of, with_values, without
from .reference_run import processor_time

STABILITY_REVOLUTIONS = 2.0
ONSET_TOLERANCES = 100.0  # tolerances, in revolutions, by which the first onset may differ between the methods
BEYOND_ONSET = 1.1  # times the first onset: length of the runs that are compared
LEAST_ONSET_DIFFERENCE = 1e-9  # revolutions
PART_ROUNDS = 6  # the first warms up, the least counts
UNOBSERVED = 0.999  # share of a run that is discarded, so that nothing is accumulated
OPTIONAL_SECTIONS = ("friction", "wear", "film", "roughness", "thermal")  # of a joint


class Level(NamedTuple):
    """One change of a case: its factor, the level in words, and the new values by path."""

    factor: str
    text: str
    change: Mapping[str, Any]


def levels_of(tree: Tree) -> dict[str, list[Level]]:
    """Return the changes of a case by factor; a factor that the scene lacks is left out."""
    values = dict(leaves(tree))
    in_contact = {path: value for path, value in values.items() if path.startswith("joints.") and ".contact." in path}
    stiffness = {path: value for path, value in in_contact.items() if path.endswith((".stiffness", ".young"))}
    damping = {path: value for path, value in in_contact.items() if path.endswith((".damping", ".damping_factor"))}
    clearances = {f"joints.{name}.clearance": joint["clearance"] for name, joint in tree["joints"].items()}
    speeds = {
        path: values[path] for path in ("drive.speed", "drive.initial_speed", "mechanism.speed") if path in values
    }
    restitutions = [path for path in in_contact if path.endswith(".restitution")]
    friction = [
        path for path in values if path.startswith("joints.") and ".friction." in path and path.endswith("coefficient")
    ]
    start = tree["simulate"].get("start", "centred")
    factors = {
        "clearance": _scaled("clearance", clearances),
        "stiffness": _scaled("stiffness", stiffness),
        "speed": _scaled("speed", {path: value for path, value in speeds.items() if value}),
        "restitution": _set("restitution", restitutions, (0.0, 1.0)),
        "damping": _scaled("damping", damping),
        "friction": _set("friction", friction, (0.0, 1.0)),
        "tolerance": _set("tolerance", ["simulate.tolerance"], (1e-4, 1e-12)),
        "start": [
            Level("start", f"start {word}", {"simulate.start": word})
            for word in ("centred", "seated")
            if word != start and "start" in tree["simulate"]
        ],
    }
    return {name: levels for name, levels in factors.items() if levels}


def _scaled(factor: str, values: Mapping[str, Any]) -> list[Level]:
    """Return the values at a tenth and at ten times."""
    if not values:
        return []
    return [
        Level(factor, f"{text} the {factor}", {path: scale * value for path, value in values.items()})
        for scale, text in ((0.1, "a tenth of"), (10.0, "ten times"))
    ]


def _set(factor: str, paths: Sequence[str], values: Sequence[float]) -> list[Level]:
    """Return these values at all paths."""
    return [Level(factor, f"{factor} {value:g}", dict.fromkeys(paths, value)) for value in values] if paths else []


def variants_of(tree: Tree) -> list[tuple[Level, ...]]:
    """Return the variants of a case: every level alone, and every pair of levels of two factors."""
    factors = levels_of(tree)
    singles: list[tuple[Level, ...]] = [(level,) for levels in factors.values() for level in levels]
    return singles + [
        pair
        for first, second in itertools.combinations(factors.values(), 2)
        for pair in itertools.product(first, second)
    ]


def variant_text(variant: Sequence[Level]) -> str:
    """Return a variant in words: 'restitution 0, ten times the speed'."""
    return ", ".join(level.text for level in variant)


def try_variant(tree: Tree, variant: Sequence[Level], deadline: float) -> dict[str, Any]:
    """Return status and cause of failure of a variant; the cause is empty if it passes."""
    changes = {path: value for level in variant for path, value in level.change.items()}
    if "revolutions" in tree["simulate"]:
        changes["simulate.revolutions"] = STABILITY_REVOLUTIONS
    changed = with_values(tree, changes)
    try:
        case_scene = scene_of(changed)
    except InputError as error:
        return {"status": "refused", "why": str(error)}
    seconds = max(deadline - time.monotonic(), 1.0)
    case_scene = case_scene.with_settings(time_budget=seconds)
    row = stability.run_scene(case_scene)
    why = row["failure"] or _onset_difference(case_scene, row["first_onset"])
    return {"status": row["status"], "why": why, "energy_residual": row["energy_residual"]}


def _onset_difference(case_scene: scene.Scene, first_onset: float | None) -> str:
    """Return how the first onset differs between the explicit and the implicit method; '' if it is equal.

    first_onset : s, None if there is none.
    """
    if first_onset is None:
        return ""
    period, onsets = 2.0 * math.pi / case_scene.value.reference_rate, []
    settings: dict[str, Any] = {}
    if case_scene.mechanism.turns:
        settings["revolutions"] = min(BEYOND_ONSET * first_onset / period + 0.01, STABILITY_REVOLUTIONS)
    for method in ("explicit", "implicit"):
        path = simulate(case_scene.with_settings(method=method, **settings), times=np.zeros(1))
        events = path.events[path.events["kind"] == "on"]
        if not len(events):
            return f"first onset: none by the {method} method, at {first_onset:.9g} s by auto"
        onsets.append((str(events["joint"][0]), float(events["t"][0])))
    (joint, moment), (other_joint, other_moment) = onsets
    allowed = max(ONSET_TOLERANCES * case_scene.case.simulate.tolerance, LEAST_ONSET_DIFFERENCE)
    if joint == other_joint and abs(moment - other_moment) <= allowed * period:
        return ""
    return (
        f"first onset: {joint} at {moment:.9g} s by the explicit method, {other_joint} at {other_moment:.9g} s by the "
        "implicit one"
    )


def costs_of_parts(written: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what each part of a scene costs (ms a revolution), found by leaving it out.

    A scene without a law moves otherwise, so for laws the costs of a step are compared, times the steps of the whole
    scene; a joint also brings steps of its own.  `rates` is what remains without any part: equations of motion, steps
    and events.
    """
    base = bare = base_tree(written)
    scenes = {"": scene_of(base)}
    for name, joint in base["joints"].items():
        removable = [f"joints.{name}.{section}" for section in OPTIONAL_SECTIONS if section in joint]
        for path in [*([f"joints.{name}"] if len(base["joints"]) > 1 else []), *removable]:
            try:
                scenes[path] = scene_of(without(base, path))
                barer = without(bare, path) if path in removable else bare
                scene_of(barer)
            except InputError:
                continue  # the rest of the scene needs this part
            bare = barer
    if plain(written).get("save", {}).get("orbits", "none") != "none":
        length = {"revolutions": 1.0} if "revolutions" in base["simulate"] else {}
        scenes["orbits"] = scene_of(dict(base, save=plain(written)["save"] | length))
    barest = scene_of(bare)
    unobserved = barest.with_settings(discard=UNOBSERVED * barest.case.simulate.revolutions)
    runs = {**scenes, "bare": barest, "unobserved": unobserved}
    costs = dict.fromkeys(runs, math.inf)
    counts = {}
    for _ in range(PART_ROUNDS):
        for path, case_scene in runs.items():
            seconds, trajectory = processor_time(case_scene)
            counts[path] = trajectory.summary["steps"]
            costs[path] = min(costs[path], seconds / max(counts[path], 1))
    rows = []
    for path in runs:
        if path in ("", "bare", "unobserved"):
            continue
        cost = costs[path] - costs[""] if path == "orbits" else costs[""] - costs[path]
        milliseconds = 1e3 * cost * counts[""]
        if path.count(".") == 1:  # a joint
            milliseconds = 1e3 * (costs[""] * counts[""] - costs[path] * counts[path])
        rows.append({"part": path, "milliseconds": milliseconds})
    rows.append({"part": "histogram", "milliseconds": 1e3 * (costs["bare"] - costs["unobserved"]) * counts[""]})
    rows.append({"part": "rates", "milliseconds": 1e3 * costs["unobserved"] * counts[""]})
    return rows
