"""The mechanism of a case without clearance: its motion and its largest reactions."""

import functools
import math
import pickle
from collections.abc import Callable, Mapping

import numpy as np

from ..contracts.case import Case
from ..contracts.catalogue import Mechanism
from ..contracts.outline import Outline
from ..mechanics.mechanism import MECHANISMS, planar
from ..mechanics.mechanism.contract import STEPS, IdealMotion, largest_reactions, peak_of


def mechanism_of(case: Case) -> Mechanism:
    """Return the mechanism of a case, with all that its grid names."""
    mechanism: Mechanism = MECHANISMS[case.mechanism.type]
    return _outlined(mechanism.outlined, case.outline) if mechanism.outlined else mechanism


@functools.lru_cache(maxsize=256)  # the cases of a sweep share it
def _outlined(outlined: Callable[[Outline], Mechanism], outline: Outline) -> Mechanism:
    return outlined(outline)


def ideal_motion(case: Case, angles: np.ndarray) -> IdealMotion | None:
    """Return a case's mechanism without clearance at angles (rad) of its drive; None where it has no ideal."""
    mechanism = mechanism_of(case)
    if mechanism.machine and not mechanism.build:
        return planar.ideal(mechanism.machine(case), angles)
    if mechanism.ideal is None or case.drive is None:
        return None
    motion: IdealMotion = mechanism.ideal(case.mechanism.values, case.drive.speed, angles)
    return motion


def ideal_peaks(case: Case) -> Mapping[str, float]:
    """Return the largest reaction (N) of each joint of a case without clearance; none where it has no ideal."""
    mechanism = mechanism_of(case)
    if mechanism.build or not mechanism.machine:
        return largest_reactions(mechanism, case.mechanism.values, case.drive.speed) if case.drive else {}
    machine = mechanism.machine(case)
    first, last = _stretch(case)
    count = max(round(STEPS * (last - first)), 2)
    angles = machine.drive.start_angle + 2.0 * math.pi * (first + (last - first) * np.arange(count) / count)
    return _peaks(pickle.dumps(machine), angles.tobytes(), planar.Alike(machine))


def _stretch(case: Case) -> tuple[float, float]:
    """Return the revolutions within which a case without clearance is looked at: all that repeats, else the window."""
    tables = [load.table for load in case.loads if load.table]
    passing = case.outline.free or (case.drive is not None and case.drive.table is not None)
    repeats = not passing and not any("time" in table for table in tables)
    if not repeats:
        return case.simulate.discard, case.simulate.revolutions
    spans = [table["crank_angle"][-1] - table["crank_angle"][0] for table in tables]
    return 0.0, float(max([1, *(round(span / (2.0 * math.pi)) for span in spans)]))


@functools.lru_cache(maxsize=256)  # the cases of a sweep share few mechanisms and speeds
def _peaks(key: bytes, angles: bytes, machine: planar.Alike) -> Mapping[str, float]:
    motion = planar.ideal(machine.value, np.frombuffer(angles))
    return {name: peak_of(forces) for name, forces in motion.reactions.items()}
