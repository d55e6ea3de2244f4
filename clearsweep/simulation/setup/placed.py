"""Starts with the journals at given places and rates: carried from the end of another case, or drawn at random."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Case
from ...language.errors import InputError
from ...mechanics.joints.contract import contact_modes
from ...mechanics.joints.mesh import Mesh
from ...mechanics.machines.contract import Built, gaps, pose_at

BRANCHES = ("carried", "random")  # starts that are placed here

ITERATIONS = 20  # of Newton's method, which needs four
PLACED = 1e-13  # of the machine's size: largest distance of a journal from where it should be
DIFFERENCE = 1e-5  # of the machine's size: displacement for a derivative


class Carried(NamedTuple):
    """The end of a case, in units that another case shares: clearances, and clearances times crank speed."""

    places: np.ndarray  # (k,) of the open joints: x and y of a journal, or the position of flanks along their normal
    rates: np.ndarray  # (k,) of these places
    roots: np.ndarray  # (contacts,) of penetration, over roots of the clearance
    internal: np.ndarray  # (i,) internal state of laws, in its own units
    latched: np.ndarray  # (contacts + l,) rates of onset, in the units of `rates`, then those of laws, in their own
    mode: np.ndarray  # (contacts,)


def random_places(seed: int, draw: int, flanked: Sequence[bool]) -> tuple[np.ndarray, np.ndarray]:
    """Return random places (k,) of the open joints in clearances, and rates (k,) in clearances times crank speed.

    A journal is anywhere in its clearance circle with equal probability, flanks anywhere in their play; rates have the
    same distribution.  The numbers depend on seed and draw alone.  `flanked` says which joints are gears or couplings.
    """
    generator = np.random.default_rng([int(seed), int(draw)])
    places, rates = list[float](), list[float]()
    for has_flanks in flanked:
        values_of = _in_play if has_flanks else _in_circle
        places += values_of(generator)
        rates += values_of(generator)
    return np.array(places), np.array(rates)


def _random_places(case: Case) -> tuple[np.ndarray, np.ndarray]:
    settings, flanked = case.simulate, [bool(joint.flanked) for joint in case.joints]
    return random_places(settings.seed, settings.draw, flanked)


def _in_play(generator: "np.random.Generator") -> list[float]:
    return [float(generator.uniform(-1.0, 1.0))]


def _in_circle(generator: "np.random.Generator") -> list[float]:
    radius, angle = math.sqrt(generator.uniform()), generator.uniform(0.0, 2.0 * math.pi)
    return [radius * math.cos(angle), radius * math.sin(angle)]


def with_places(case: Case, built: Built, joints: tuple, earlier_end: Carried | None) -> Built:
    """Return a mechanism that starts where another case ended, or at random; the first of a chain starts centred.

    Raises InputError if more moves freely than the joints with clearance.
    """
    units = units_of(joints)
    if len(units) != len(built.lengths):
        raise InputError(
            f"simulate.start: {case.simulate.start} places {len(units)} coordinates of joints with clearance, and this "
            f"machine has {len(built.lengths)}; make the other moving parts rigid, or use centred"
        )
    if earlier_end is None and case.simulate.start == "carried":
        return built
    places, rates = _random_places(case) if earlier_end is None else (earlier_end.places, earlier_end.rates)
    return built._replace(start=placed(built, units * places, units * abs(built.rate) * rates))


def latched_of(earlier_end: Carried, joints: tuple, built: Built) -> list[float]:
    """Return the numbers that change only at events, as Work has them: those of contacts in m/s."""
    contacts, latched = contact_units(joints), earlier_end.latched.copy()
    latched[: len(contacts)] *= contacts * abs(built.rate)
    return latched.tolist()  # type: ignore[no-any-return]


def units_of(joints: tuple) -> np.ndarray:
    """Return the clearance (m) of each place of the open joints, (k,)."""
    return np.array([joint.clearance for joint in joints for _ in range(1 if isinstance(joint, Mesh) else 2)])


def places_of(built: Built, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k,) m of the open joints at a state, and their rates (k,) m/s."""
    relative = gaps(built.value, pose_at(built.value, y))
    places = [place for gap in relative for place in ((gap.x,) if hasattr(gap, "wider") else (gap.x, gap.y))]
    rates = [rate for gap in relative for rate in ((gap.v,) if hasattr(gap, "wider") else (gap.vx, gap.vy))]
    return np.array(places, float), np.array(rates, float)


def contact_units(joints: tuple) -> np.ndarray:
    """Return the clearance (m) of the joint of each contact, (contacts,)."""
    return np.array([joint.clearance for joint in joints for _ in contact_modes(joint)])


def placed(built: Built, places: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the initial state (2n + 1,) with the open joints at `places` (m) and with `rates` (m/s).

    The state of `built` is the first guess of Newton's method.  Raises InputError if the machine has no such state.
    """
    y, count = built.start.copy(), len(built.lengths)
    for _ in range(ITERATIONS):
        missing = places - places_of(built, y)[0]
        if np.max(np.abs(missing)) <= PLACED * built.size:
            break
        steps = DIFFERENCE * built.size / built.lengths
        y[:count] += _solution(_slopes(built, y, steps, 0), missing, built.lengths)
    else:
        raise InputError("simulate.start: the bodies cannot have these places in their joints; use centred")
    y[count : 2 * count] += _solution(
        _slopes(built, y, built.rate * built.size / built.lengths, 1), rates - places_of(built, y)[1], built.lengths
    )
    return y


def _slopes(built: Built, y: np.ndarray, steps: np.ndarray, order: int) -> np.ndarray:
    """Return the derivatives of places (`order` 0) or rates (1) by the coordinates or their rates, (k, n)."""
    columns = []
    for index, step in enumerate(steps):
        forward, backward = y.copy(), y.copy()
        forward[index + order * len(steps)] += step
        backward[index + order * len(steps)] -= step
        columns.append((places_of(built, forward)[order] - places_of(built, backward)[order]) / (2.0 * step))
    return np.stack(columns, -1)


def _solution(slopes: np.ndarray, missing: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the least change of the coordinates, measured by `lengths` (m per unit), that adds what is missing."""
    solution: Any = np.linalg.lstsq(slopes / lengths, missing, rcond=None)[0]
    return solution / lengths  # type: ignore[no-any-return]
