"""Simulates many cases one after another, and computes their figures in bulk."""

import time
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from ..contracts.case import Case
from ..contracts.results import Trajectory
from .figures.catalogue import SETUP
from .heat import has_balance
from .outcome import Outcome, outcome_of, periods_of, to_trajectory
from .run import initial_run, integrate, keeps_events, release
from .scene import Scene, build
from .trajectory import horizon_of, simulate, with_deadline, with_limits

REPORT_INTERVAL = 0.05  # s of processor time after which finished cases are reported together

IndexedResult = tuple[int, Trajectory | Exception]


class PendingResult(NamedTuple):
    """A case that is integrated but not reported yet."""

    case_index: int
    build_time: float  # s, time to build the scene
    outcome: Outcome


def solve_each(cases: Iterable[Case]) -> Iterator[IndexedResult]:
    """Yield the index of each case and its result or error, equal to those of a separate run of the case.

    Figures of plain cases are computed for many cases at a time, which halves the time.
    """
    pending: list[PendingResult] = []
    last_report = time.process_time()
    for index, case in enumerate(cases):
        try:
            begin = time.perf_counter()
            scene = build(case)
            if is_plain(scene):
                pending.append(_integrate_plain(index, scene, begin))
                if time.process_time() - last_report > REPORT_INTERVAL:
                    yield from _results(pending)
                    pending, last_report = [], time.process_time()
                continue
            result: Trajectory | Exception = simulate(scene)
        except Exception as error:
            result = error
        yield index, result
    yield from _results(pending)


def is_plain(scene: Scene) -> bool:
    """Return whether a single integration of known length gives the result of a scene."""
    layout, has_crank = scene.layout, scene.mechanism.turns and not scene.crank_clock.free
    is_single = not (layout.until or layout.horizon or layout.error_check or has_balance(scene.case) or scene.case.life)
    return has_crank and is_single


def _integrate_plain(index: int, scene: Scene, begin: float) -> PendingResult:
    """Return a plain scene with its integration; building it began at `begin` (s)."""
    scene = with_deadline(scene)
    horizon = horizon_of(scene)
    run = initial_run(scene, horizon.times, in_angles=False, marks=horizon.marks)
    build_time = time.perf_counter() - begin
    integrate(scene, run, horizon.end, keep_events=keeps_events(scene, horizon.times))
    outcome = outcome_of(scene, run, horizon.end)
    release(run)
    return PendingResult(index, build_time, outcome)


def _results(pending: list[PendingResult]) -> Iterator[IndexedResult]:
    """Yield the results of cases."""
    try:
        periods = iter(periods_of([pending_case.outcome for pending_case in pending]))
    except Exception:  # one of them has failed: each is reported by itself
        periods = None
    for pending_case in pending:
        begin = time.perf_counter()
        try:
            period = next(periods) if periods else periods_of([pending_case.outcome])[0]
            result: Trajectory | Exception = to_trajectory(pending_case.outcome, period)
            assert isinstance(result, Trajectory)
            result.summary[SETUP.name] = pending_case.build_time + time.perf_counter() - begin
            result = with_limits(pending_case.outcome.scene, result)
        except Exception as error:
            result = error
        yield pending_case.case_index, result
