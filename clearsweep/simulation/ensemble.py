"""Many cases one after the other: what Python does around their integration is done for many at a time."""

import time
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ..contracts.case import Case
from ..contracts.results import Trajectory
from .figures import SETUP
from .heat import has_balance
from .outcome import Outcome, outcome_of, periods_of, to_trajectory
from .run import integrate, run_at, use_no_more, wants_events
from .scene import Scene, build
from .trajectory import extent_of, simulate, timed, with_limits

OFTEN = 0.05  # s of processor time after which the cases that have ended meanwhile are reported, all at once

Ended = tuple[int, Trajectory | Exception]


class Integrated(NamedTuple):
    """A case that was integrated and is not reported yet."""

    place: int  # among the cases
    seconds: float  # that making it ready took
    outcome: Outcome


def solve_each(cases: Iterable[Case]) -> Iterator[Ended]:
    """Yield the place of each case and its result, or what went wrong; each is that of the case alone.

    The figures of plain cases are made for many at a time, which takes half as long as after each.
    """
    waiting: list[Integrated] = []
    reported = time.process_time()
    for place, case in enumerate(cases):
        try:
            begin = time.perf_counter()
            scene = build(case)
            if is_plain(scene):
                waiting.append(_integrated(place, scene, begin))
                if time.process_time() - reported > OFTEN:
                    yield from _results(waiting)
                    waiting, reported = [], time.process_time()
                continue
            ended: Trajectory | Exception = simulate(scene)
        except Exception as error:
            ended = error
        yield place, ended
    yield from _results(waiting)


def is_plain(scene: Scene) -> bool:
    """Return whether a scene comes to what a single integration of known length does."""
    layout, turns = scene.layout, scene.mechanism.turns and not scene.crank_clock.free
    single = not (layout.until or layout.horizon or layout.error_check or has_balance(scene.case) or scene.case.life)
    return turns and single


def _integrated(place: int, scene: Scene, begin: float) -> Integrated:
    """Return a plain scene, which is made ready since `begin`, integrated."""
    scene = timed(scene)
    extent = extent_of(scene)
    run = run_at(scene, extent.times, turned=False, marks=extent.marks)
    seconds = time.perf_counter() - begin
    integrate(scene, run, extent.end, keep_events=wants_events(scene, extent.times))
    outcome = outcome_of(scene, run, extent.end)
    use_no_more(run)
    return Integrated(place, seconds, outcome)


def _results(waiting: list[Integrated]) -> Iterator[Ended]:
    """Yield what cases came to."""
    try:
        periods = iter(periods_of([case.outcome for case in waiting]))
    except Exception:  # of one of them, which is reported by itself
        periods = None
    for case in waiting:
        begin = time.perf_counter()
        try:
            period = next(periods) if periods else periods_of([case.outcome])[0]
            result: Trajectory | Exception = to_trajectory(case.outcome, period)
            assert isinstance(result, Trajectory)
            result.summary[SETUP.name] = case.seconds + time.perf_counter() - begin
            result = with_limits(case.outcome.scene, result)
        except Exception as error:
            result = error
        yield case.place, result
