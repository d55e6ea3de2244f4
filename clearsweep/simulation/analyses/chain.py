"""Chains of cases, each of which starts where the one before it ended."""

import itertools
from collections.abc import Mapping

import numpy as np

from ...contracts.case import Case
from ...language import phases
from ...language.errors import InputError
from ...mechanics.solver import integration
from ...mechanics.wear import Worn
from ..running.run import Run, integration_of, release
from ..setup import scene as setup
from ..setup.places import Carried, contact_units, places_of, units_of
from ..setup.scene import Scene
from ..setup.start import NO_TIMES, marks_of

#: The cases of the chain that this process computed last, and how they ended.
_chain: list[tuple[Case, Carried]] = []


def build(case: Case, worn: Mapping[str, Worn] | None = None) -> Scene:
    """Return the scene of a case, which starts where the case before it in its chain ended, if it has one.

    What was computed last in this process is not computed again; the rest of the chain is run before it.
    `worn` is as in `setup.scene.build`, for a case without others before it.  Raises InputError if the initial state is
    impossible, or if a case before it failed.
    """
    if not case.before:
        return setup.build(case, worn)
    shared = itertools.takewhile(lambda pair: pair[0][0] == pair[1], zip(_chain, case.before, strict=False))
    del _chain[len([*shared]) :]
    for number, earlier in enumerate(case.before[len(_chain) :], start=len(_chain) + 1):
        with phases.phase(f"case {number} of {len(case.before)} before it in its chain"):
            scene = _scene(earlier)
            end = scene.crank_clock.value_after(earlier.simulate.revolutions)
            run = integration_of(scene, NO_TIMES, end, marks=marks_of(scene, earlier.simulate.revolutions))
        if run.status != integration.OK:
            place = f"number {number} of {len(case.before)} before it"
            raise InputError(f"simulate.start: carried needs the end of a case that failed, {place}; see its status")
        _chain.append((earlier, _end_of(scene, run)))
        release(run)
    return _scene(case)


def _scene(case: Case) -> Scene:
    """Return the scene of a case after those that are known."""
    return setup.build(case._replace(before=()), earlier_end=_chain[-1][1] if _chain else None)


def keep_end(scene: Scene, run: Run) -> None:
    """Keep the end of a finished run if it continues the chain, so that the next case need not run it again."""
    if scene.case.simulate.start != "carried" or run.status != integration.OK:
        return
    if scene.earlier_end is None:
        _chain.clear()
    if scene.earlier_end is (_chain[-1][1] if _chain else None):
        _chain.append((scene.case, _end_of(scene, run)))


def _end_of(scene: Scene, run: Run) -> Carried:
    """Return the end of a run in the units that the next case shares."""
    work, joints, rate = run.work, scene.value.joints, scene.value.reference_rate
    state: np.ndarray = work.end if np.any(work.end) else work.y
    places, rates = places_of(scene.built, state[: work.time + 1])
    units, contacts = units_of(joints), contact_units(joints)
    own, latched = state[work.time + 1 :], work.latched.copy()
    latched[: len(contacts)] /= contacts * abs(rate)
    return Carried(
        places / units,
        rates / (units * abs(rate)),
        own[: len(contacts)] / np.sqrt(contacts),
        own[len(contacts) :].copy(),
        latched,
        work.mode.copy(),
    )
