"""The mechanism of a case without clearance: its motion and its largest reactions."""

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...contracts.case import Case
from ...contracts.catalogue import Mechanism
from ...contracts.machine import Machine
from ...contracts.outline import Outline
from ...mechanics.machines import MECHANISMS, planar
from ...mechanics.machines.contract import IdealMotion
from ...tracing.compiled.family import Identity
from .largest import largest

SAMPLES_PER_TURN = 720  # initial samples of a turn


def mechanism_of(case: Case) -> Mechanism:
    """Return the mechanism of a case, with the user-defined parts of its grid."""
    mechanism: Mechanism = MECHANISMS[case.mechanism.type]
    return _mechanism_with_outline(mechanism.with_outline, case.outline) if mechanism.with_outline else mechanism


@functools.lru_cache(maxsize=256)  # the cases of a sweep share it
def _mechanism_with_outline(with_outline: Callable[[Outline], Mechanism], outline: Outline) -> Mechanism:
    return with_outline(outline)


def machine_of(mechanism: Mechanism, case: Case) -> Machine | None:
    """Return the planar machine of a case, or None if its mechanism has none; cases that differ elsewhere share it."""
    if not mechanism.machine:
        return None
    sections = Identity(case.mechanism), Identity(case.loads), Identity(case.outline)
    return _machine(mechanism.machine, sections, repr(case.drive), planar.AlwaysEqual(case))


@functools.lru_cache(maxsize=256)
def _machine(
    machine_from: Callable[[Case], Machine], sections: tuple[Identity, ...], drive: str, case: planar.AlwaysEqual
) -> Machine:
    """Return the machine of a case, which depends on these `sections` and its `drive` only."""
    machine: Machine = machine_from(case.value)
    return machine


def ideal_motion(case: Case, angles: np.ndarray) -> IdealMotion | None:
    """Return the ideal mechanism of a case at drive angles (rad), or None if it has none."""
    machine = machine_of(mechanism_of(case), case)
    return planar.ideal(machine, angles) if machine else None


def ideal_peaks(case: Case, machine: Machine | None = None) -> Mapping[str, float]:
    """Return the largest reaction (N) of each joint without clearance; empty if the mechanism has no ideal motion.

    machine : the machine of the case, if it is already built
    """
    machine = machine or machine_of(mechanism_of(case), case)
    if machine is None:
        return {}
    tables = [load.table for load in case.loads if load.table]
    turn_range = _turn_range(case, tables)
    knots = _knots(case, tables, turn_range)
    return _peaks(planar.machine_key(machine), turn_range, knots, planar.AlwaysEqual(machine))


@functools.lru_cache(maxsize=256)  # the cases of a sweep share few mechanisms and speeds
def _peaks(
    key: bytes, turn_range: tuple[float, float], knots: tuple[float, ...], machine: planar.AlwaysEqual
) -> Mapping[str, float]:
    """Return the result of `peaks` for a machine with this key."""
    start = machine.value.drive.start_angle
    return peaks(lambda angles: planar.ideal_reactions(machine.value, start + angles), turn_range, knots)


def _turn_range(case: Case, tables: list[Mapping[str, Any]]) -> tuple[float, float]:
    """Return the revolutions over which the ideal mechanism is evaluated: one period, or else the window.

    tables : load tables of the case
    """
    is_free = case.outline.free or (case.drive is not None and case.drive.table is not None)
    is_periodic = not is_free and not any("time" in table for table in tables)
    if not is_periodic:
        return case.simulate.discard, case.simulate.revolutions
    spans = [table["crank_angle"][-1] - table["crank_angle"][0] for table in tables]
    return 0.0, float(max([1, *[round(span / (2.0 * math.pi)) for span in spans]]))


def _knots(case: Case, tables: list[Mapping[str, Any]], turn_range: tuple[float, float]) -> tuple[float, ...]:
    """Return the crank angles (rad from the start) of rows in load tables."""
    assert case.drive is not None  # a machine has an ideal motion
    begin, end = 2.0 * math.pi * turn_range[0], 2.0 * math.pi * turn_range[1]
    knots: list[float] = []
    for table in tables:
        if "crank_angle" in table:
            row_angles = np.array(table["crank_angle"]) - case.drive.start_angle
            span = row_angles[-1] - row_angles[0]
            turns = np.arange(math.floor((begin - row_angles[-1]) / span), math.ceil((end - row_angles[0]) / span) + 1)
            row_angles = np.add.outer(span * turns, row_angles).ravel()
        elif case.outline.free or case.drive.table is not None:
            continue
        else:
            row_angles = case.drive.speed * np.array(table["time"])
        knots += row_angles[(row_angles > begin) & (row_angles < end)].tolist()
    return tuple(knots)


def peaks(
    reactions: Callable[[np.ndarray], Mapping[str, np.ndarray]],
    turn_range: tuple[float, float],
    knots: tuple[float, ...] = (),
) -> Mapping[str, float]:
    """Return the largest reaction (N) of each joint over a range of revolutions, both ends included.

    reactions : (n,) rad from the start -> force (n, 2) N of each joint; knots : (k,) rad, further angles to evaluate.
    """
    names: list[str] = []

    def magnitudes(angles: np.ndarray) -> np.ndarray:
        forces = reactions(angles)
        names[:] = forces
        return np.array([np.hypot(force[:, 0], force[:, 1]) for force in forces.values()])

    start_angle, end_angle = (2.0 * math.pi * turns for turns in turn_range)
    equidistant = np.linspace(
        start_angle, end_angle, max(round(SAMPLES_PER_TURN * (turn_range[1] - turn_range[0])), 2) + 1
    )
    largest_values = largest(magnitudes, np.union1d(equidistant, knots))
    return dict(zip(names, largest_values.tolist(), strict=True))
