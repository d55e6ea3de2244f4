"""Sizes and speeds of a case that no machine has, which usually come from a wrong unit."""

import math
from collections.abc import Iterator

from ...contracts.case import Case
from ...contracts.machine import GROUND, Machine
from .ideal import machine_of, mechanism_of
from .links import max_drive_speed

LEAST_LINE_MASS = 0.01  # kg/m of a link; a steel wire of 1.3 mm diameter
LARGEST_LENGTH = 100.0  # m, of a link
LARGEST_PIN_DIAMETER = 1.0  # m
LARGEST_CLEARANCE = 0.02  # m, radial
LARGEST_PIN_SPEED = 500.0  # m/s, of the crank pin; a ring of steel bursts: density times speed squared is 2 GPa


def warnings(case: Case) -> list[str]:
    """Return a warning that lists the implausible sizes and speeds of a case, or []."""
    machine = machine_of(mechanism_of(case), case)
    section = "mechanism.bodies" if case.outline.bodies else "mechanism"
    sentences = [*(_machine_warnings(machine, section) if machine else ())]
    for joint in case.joints:
        diameter = 2.0 * (joint.bearing_radius or 0.0)
        if diameter > LARGEST_PIN_DIAMETER:
            sentences.append(f"joints.{joint.name}.bearing_radius is that of a pin of {diameter:.3g} m diameter")
        if joint.clearance > LARGEST_CLEARANCE:
            sentences.append(f"joints.{joint.name}.clearance is {1e3 * joint.clearance:.3g} mm")
    listed = ", ".join(sentences)
    return [f"sizes that no machine has; check their units (SI where none is written): {listed}"] if listed else []


def _machine_warnings(machine: Machine, section: str) -> Iterator[str]:
    """Yield what is implausible in the links and the drive of a machine."""
    lengths = {
        name: max(math.dist(first, second) for first in body.points.values() for second in body.points.values())
        for name, body in machine.bodies.items()
        if name != GROUND and body.points
    }
    for name, length in lengths.items():
        line_mass = machine.bodies[name].mass / length if length else math.inf
        if length > LARGEST_LENGTH:
            yield f"{section}.{name} is {length:.4g} m long"
        if 0.0 < line_mass < LEAST_LINE_MASS:
            yield f"{section}.{name} has {line_mass:.2g} kg per metre of its length, {length:.3g} m"
    driven = next(joint.distal.body for joint in machine.joints if joint.name == machine.driven)
    speed = max_drive_speed(machine)
    if lengths.get(driven, 0.0) * speed > LARGEST_PIN_SPEED:
        end_speed = f"{lengths[driven] * speed:,.4g} m/s"
        yield f"drive turns at {speed * 30.0 / math.pi:,.5g} rpm, so that the end of {driven} moves at {end_speed}"
