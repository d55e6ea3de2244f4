"""Many cases at once: those whose scenes are of one type are integrated side by side, as many as fit a register."""

import contextlib
import time
from collections import deque
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..contracts.case import Case
from ..contracts.results import Trajectory
from ..mechanics.compiled.family import NO_ENTRY, WIDTH, Entry, flatten, form_number
from ..mechanics.compiled.pinned import Pinned
from ..mechanics.coupling.trial_step import together_of
from ..mechanics.solver import loop, run_control
from .figures import SETUP
from .heat import has_balance
from .outcome import Outcome, outcome_of, periods_of, to_trajectory
from .run import Run, board_of, lane_of, shared, start, wants_events
from .scene import Scene, build
from .start import Start, control_of, start_of
from .trajectory import Horizon, extent_of, simulate, with_limits

MANY = WIDTH  # cases of one type of scene for which it is worth looking up their step side by side
OFTEN = 0.05  # s of processor time after which the cases that have ended meanwhile are reported, all at once

Ended = tuple[int, Trajectory | Exception]


class Prepared(NamedTuple):
    """A case that waits, or is under way."""

    place: int  # among the cases
    extent: Horizon
    start: Start
    control: run_control.Control
    seconds: float  # that making it ready took


def solve_each(cases: Iterable[Case]) -> Iterator[Ended]:
    """Yield the place of each case and its result, or what went wrong; each is that of the case alone.

    What Python does is done for many cases at a time, which takes half as long as between two cases' integrations:
    all are prepared at first, those of each type of scene are integrated, and what has ended is reported now and then.
    """
    kinds: dict[int, deque[Prepared]] = {}
    for place, case in enumerate(cases):
        try:
            scene = build(case)
            if is_plain(scene):
                kinds.setdefault(form_number(scene.value), deque()).append(prepared(place, scene))
                continue
            ended: Trajectory | Exception = simulate(scene)
        except Exception as error:
            ended = error
        yield place, ended
    for waiting in kinds.values():
        yield from _Ensemble(waiting).run()


def is_plain(scene: Scene) -> bool:
    """Return whether a scene comes to what a single integration of known length does."""
    layout, turns = scene.layout, scene.mechanism.turns and not scene.crank_clock.free
    single = not (layout.until or layout.horizon or layout.error_check or has_balance(scene.case) or scene.case.life)
    return turns and single


def prepared(place: int, scene: Scene) -> Prepared:
    """Return a plain scene made ready."""
    begin, extent = time.perf_counter(), extent_of(scene)
    control = control_of(scene, extent.end, keep_events=wants_events(scene, extent.times))
    start = start_of(scene, extent.times, extent.marks)
    return Prepared(place, extent, start, control, scene.build_time + time.perf_counter() - begin)


def compile_together(case: Case) -> None:
    """Compile, or load from the cache, the step of cases like this one side by side."""
    scene = build(case)
    if is_plain(scene):
        together_of(scene.value, flatten(scene.value))


class _Buffers:
    """Arrays for WIDTH cases of one type of scene, and the runs that work on them, used again and again."""

    def __init__(self, scene: Scene):
        board = board_of(scene)
        self.lanes = [lane_of(board, place) for place in range(WIDTH)]
        self.first = scene  # in a lane without a case its parameters are, among them addresses that are read
        for lane in self.lanes:
            lane["parameters"][:] = flatten(scene.value)
        self.arrays = shared(self.lanes[0])
        self.runs: dict[int, Run] = {}  # by lane
        self.former: dict[int, Run | None] = {}  # likewise, the one before
        self.addresses, self.status = np.zeros(WIDTH, dtype=np.int64), np.zeros(WIDTH, dtype=np.int64)  # likewise
        self.known: tuple[int, ...] = ()  # of which lanes and by which code the lot is that is kept
        self.kept: Pinned

    def lot(self, lanes: list[int], together: Entry) -> Pinned:
        """Return the cases in some lanes as what is integrated side by side."""
        key = (*lanes, together.code)
        if key != self.known:
            lot = loop.Lot(self.addresses[lanes], self.status[: len(lanes)], together, *self.arrays)
            self.known, self.kept = key, Pinned(lot)
        elif len(lanes) > 0:
            self.kept.value.addresses[:] = self.addresses[lanes]
        return self.kept

    def run(self, lane: int, case: Prepared) -> Run:
        """Return the run in a lane, at the start of a case: the one that is there where it can be used."""
        run = self.former[lane] = self.runs.pop(lane, None)  # gone if it goes wrong; its numbers stay
        if run and run.form == case.start.form:
            run.begin(case.start)
        else:
            run = Run(case.start, lane=self.lanes[lane])
            self.addresses[lane] = run.kept.address
        self.runs[lane] = run
        return run


class _Ensemble:
    """Cases of one type of scene: those that wait, up to WIDTH of them under way, and what others have come to."""

    def __init__(self, waiting: deque[Prepared]):
        self.waiting, self.lanes = waiting, dict[int, Prepared]()  # by lane
        self.free = list(range(WIDTH))  # lanes
        self.buffers: _Buffers | None = None
        self.ended: list[tuple[Prepared, Outcome | Exception]] = []  # not reported yet
        self.seen = self.reported_at = time.process_time()  # s, the latest, and when the latest cases were reported
        self.shared = self.others = 0.0  # s, shares so far: of a case in integrating, and of others in all time
        self.durations, self.deadlines = dict[int, float](), dict[int, float]()  # by lane: s, less those shares
        self.many, self.together = len(waiting) >= MANY, NO_ENTRY

    def run(self) -> Iterator[Ended]:
        """Yield what the cases come to."""
        while self.waiting or self.lanes:
            while self.waiting and self.free:
                self._begin(self.free[-1], self.waiting.popleft())
            if self.lanes:
                self._integrate()
            if self.seen - self.reported_at > OFTEN:
                yield from self._tell()
        yield from self._tell()

    def _begin(self, lane: int, case: Prepared) -> None:
        """Put a case into a free lane."""
        try:
            run = self._run(lane, case)
        except Exception as error:
            self.ended.append((case, error))
            return
        start(run, case.control)
        self.free.pop()
        self.lanes[lane], self.durations[lane] = case, self.shared
        self.deadlines[lane] = self.seen + case.start.scene.case.simulate.time_budget - self.others

    def _run(self, lane: int, case: Prepared) -> Run:
        """Return the run in a lane, at the start of a case."""
        if self.buffers is None:
            self.buffers = _Buffers(case.start.scene)
            if self.many:
                with contextlib.suppress(Exception):  # what is wrong with it is no case's fault: each goes by itself
                    self.together = together_of(case.start.scene.value, self.buffers.lanes[0]["parameters"])
        return self.buffers.run(lane, case)

    def _integrate(self) -> None:
        """Integrate all cases under way up to where one of them or more are to be looked at; take those that ended."""
        assert self.buffers is not None  # the first case under way made it
        buffers, lanes = self.buffers, sorted(self.lanes)
        count, model = len(lanes), buffers.runs[lanes[0]].kept
        status = buffers.status[:count]
        started = time.perf_counter()
        loop.integrate(model, buffers.lot(lanes, self.together))
        self.shared += (time.perf_counter() - started) / count
        before, self.seen = self.seen, time.process_time()
        self.others += (self.seen - before) * (1.0 - 1.0 / count)
        for lane, state in zip(lanes, status.tolist(), strict=True):
            if state != run_control.GOING:
                self._look(lane, state)

    def _look(self, lane: int, state: int) -> None:
        """Let the case in a lane go on or, where it has ended, take what it came to."""
        assert self.buffers is not None  # as above
        case, run = self.lanes[lane], self.buffers.runs[lane]
        run.deadline = self.deadlines[lane] + self.others
        try:
            if not run.ended(state):
                return
            run.duration = self.shared - self.durations[lane]
            run.conclude(run.log())
            ended: Outcome | Exception = outcome_of(case.start.scene, run, case.extent.end)
        except Exception as error:
            ended = error
        del self.lanes[lane]
        self.free.append(lane)
        self.ended.append((case, ended))

    def _tell(self) -> Iterator[Ended]:
        """Yield what has ended meanwhile."""
        ended, self.ended = self.ended, []
        outcomes = [came for _, came in ended if isinstance(came, Outcome)]
        try:
            periods = iter(periods_of(outcomes))
        except Exception:  # of one of them, which is reported by itself
            periods = None
        result: Trajectory | Exception
        for case, came in ended:
            begin = time.perf_counter()
            try:
                if isinstance(came, Outcome):
                    period = next(periods) if periods else periods_of([came])[0]
                    result = to_trajectory(came, period)
                    result.summary[SETUP.name] = case.seconds + time.perf_counter() - begin
                    result = with_limits(came.scene, result)
                else:
                    result = came
            except Exception as error:
                result = error
            yield case.place, result
        self.reported_at = time.process_time()
