"""Predicts which figures of merit the cases of a grid will have, before any case is created."""

from ..contracts.case import column_name
from ..contracts.catalogue import Catalogue, Mechanism
from ..contracts.layout import columns_of, rubbing_joints
from . import life_keys
from .keys import Section
from .reader import Reader


def figures(reader: Reader, mechanism: Mechanism, catalogue: Catalogue) -> dict[str, str]:
    """Return the figures of merit that the cases will have, each with its unit."""
    sections = [path.split(".") for path, node in reader.shape.items() if isinstance(node, Section)]
    inside = [path[1:] for path in sections if path[0] == "joints" and len(path) > 1]
    parts = {
        column_name(joint): {part for joint_name, *parts_of in inside if joint_name == joint for part in parts_of[:1]}
        for joint, *_ in inside
    }
    for joint in mechanism.joints:
        if column_name(joint.name) in parts and mechanism.spatial:
            parts[column_name(joint.name)] |= {"spatial", "axial"} if joint.kind == "spatial" else {"spatial"}
    until, life = str(reader.values.get("simulate.until.figure", "")), reader.values.get(f"{life_keys.LIFE}.joint")
    requested = {name for name in ("horizon", "error_check") if f"simulate.{name}" in reader.values}
    requested |= {
        name
        for name, is_requested in (("until", until), ("life", life), ("uncertain", reader.uncertain))
        if is_requested
    }
    for joint in mechanism.joints:
        if column_name(joint.name) in parts and joint.kind in ("revolute", "line") and _strength(reader, joint.name):
            parts[column_name(joint.name)].add("strength")
    if life and column_name(life) in parts:
        parts[column_name(life)].add("limited")
    columns = columns_of(catalogue, mechanism, parts, requested, until, rubbing_joints(reader.outline))
    return {column.name: column.unit for column in columns}


def _strength(reader: Reader, joint: str) -> bool:
    """Return whether a joint with contact has a yield strength or a hardness."""
    prefix = f"joints.{joint}."
    known_paths = [path for path in (*reader.written, *reader.swept) if path.startswith(prefix)]
    return f"{prefix}contact" in reader.shape and any(
        path.endswith(".yield_strength") or path in (f"{prefix}wear.hardness", f"{prefix}roughness.hardness")
        for path in known_paths
    )
