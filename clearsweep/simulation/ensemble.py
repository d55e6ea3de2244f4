"""Many cases at once: those whose scenes are of one type are integrated side by side, as many as a register holds."""

import time
from collections import deque
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..contracts.case import Case
from ..contracts.results import Trajectory
from ..mechanics.attempt import together_of
from ..mechanics.compiled.family import NO_ENTRY, WIDTH, flatten, form_number
from ..mechanics.compiled.rows import Board
from ..mechanics.observe.along import Attempt
from ..mechanics.observe.tally import Ledger
from ..mechanics.solver import loop, plan
from .heat import has_balance
from .revolutions import marks_of
from .run import Form, Lane, Run, board_of, control_of, shared, start
from .scene import Scene, build, signature
from .trajectory import end_of, judged, own_sampling, simulate, trajectory_of

AT_ONCE = 64  # scenes built before the first of them is integrated
MANY = WIDTH  # cases of one type of scene for which it is worth looking up their step side by side


class Beside(NamedTuple):
    """A case under way."""

    place: int  # among the cases
    scene: Scene
    run: Run


Ended = tuple[int, Trajectory | Exception]


def solve_each(cases: Iterable[Case]) -> Iterator[Ended]:
    """Yield the place of each case and its result, or what went wrong, as they end; each is that of the case alone."""
    kinds: dict[tuple, deque[tuple[int, Case]]] = {}
    for place, case in enumerate(cases):
        try:
            kinds.setdefault(signature(case), deque()).append((place, case))
        except Exception as error:
            yield place, error
    for waiting in kinds.values():
        yield from _type_by_type(waiting)


def _type_by_type(waiting: deque[tuple[int, Case]]) -> Iterator[Ended]:
    """Yield the same of cases that mostly share their type: values that are zero can make a machine another one."""
    while waiting:
        ensemble = _Ensemble(waiting)
        yield from ensemble.run()
        waiting = ensemble.others


def is_plain(scene: Scene) -> bool:
    """Return whether a scene comes to what a single integration of known length does."""
    layout, turns = scene.layout, scene.mechanism.turns and not scene.turning.free
    single = not (layout.until or layout.horizon or layout.error_check or has_balance(scene.case) or scene.case.life)
    return turns and single


def prepared(scene: Scene, lane: Lane, run: Run | None = None) -> Run:
    """Return the integration, in a lane, of a plain scene; `simulate` makes the same one.

    run : the one that was in this lane before, which is used again where it can.
    """
    settings, save, end = scene.case.simulate, scene.case.save, end_of(scene)
    times, marks = own_sampling(scene), marks_of(scene, settings.revolutions)
    if run and run.form == Form.of(scene, times, marks):
        run.begin(scene, times, marks)
    else:
        run = Run(scene, times, marks=marks, lane=lane)
    run.deadline = time.process_time() + settings.time_budget
    start(run, control_of(scene, end, keep_events=save.orbits != "none"))
    return run


def finished(scene: Scene, run: Run) -> Trajectory:
    """Return what the integration that was `prepared` came to."""
    run.events = np.concatenate(run.logs)
    run.counts += run.work.counts
    return judged(scene, trajectory_of(scene, run, end_of(scene)))


def compile_together(case: Case) -> None:
    """Compile, or load from the cache, the step of cases like this one side by side."""
    scene = build(case)
    if is_plain(scene):
        together_of(scene.value, flatten(scene.value))


def _built(waiting: deque[tuple[int, Case]]) -> Iterator[tuple[int, Case, Scene | Exception]]:
    """Yield cases and their scenes, or what is wrong with them.

    Some are built at once, in half the time of one after each run.
    """

    def made(case: Case) -> Scene | Exception:
        try:
            return build(case)
        except Exception as error:
            return error

    while waiting:
        some = [waiting.popleft() for _ in range(min(AT_ONCE, len(waiting)))]
        yield from [(place, case, made(case)) for place, case in some]


class _Ensemble:
    """Cases of one type of scene: those that wait, and up to WIDTH of them under way."""

    def __init__(self, waiting: deque[tuple[int, Case]]):
        self.waiting, self.lanes = waiting, dict[int, Beside]()  # by lane
        self.others = deque[tuple[int, Case]]()  # whose scenes turned out to be of another type
        self.number: int | None = None  # of the form of the scenes
        self.runs: dict[int, Run] = {}  # the latest of each lane
        self.seen = time.process_time()  # up to where deadlines have been put off by what other cases took
        self.many, self.together = len(waiting) >= MANY, NO_ENTRY
        self.board: Board | None = None
        self.arrays: tuple[Attempt, Ledger] | tuple[()] = ()  # of the board's first lane

    def run(self) -> Iterator[Ended]:
        """Yield what the cases come to."""
        scenes = _built(self.waiting)
        while True:
            for lane in (lane for lane in range(WIDTH) if lane not in self.lanes):
                for place, case, scene in scenes:
                    if self._is_other(scene):
                        self.others.append((place, case))
                        continue
                    ended = self._begin(lane, place, scene)
                    if ended is None:
                        break
                    yield place, ended
            if not self.lanes:
                return
            yield from self._integrate()

    def _is_other(self, scene: Scene | Exception) -> bool:
        """Return whether a scene is of another type than those before."""
        if isinstance(scene, Exception):
            return False
        number: int = form_number(scene.value)
        self.number = number if self.number is None else self.number
        return number != self.number

    def _begin(self, lane: int, place: int, scene: Scene | Exception) -> Trajectory | Exception | None:
        """Put a case into a free lane and return None; return what it came to if that is known at once."""
        if isinstance(scene, Exception):
            return scene
        try:
            if not is_plain(scene):
                return simulate(scene)
            board = self._board(scene)
            self.runs[lane] = run = prepared(scene, board.lane(lane), self.runs.pop(lane, None))
            self.lanes[lane] = Beside(place, scene, run)
        except Exception as error:
            return error
        return None

    def _board(self, scene: Scene) -> Board:
        if self.board is None:
            self.board = board_of(scene)
            first = self.board.lane(0)
            self.arrays = shared(first)
            if self.many:
                self.together = together_of(scene.value, first["parameters"])
        return self.board

    def _integrate(self) -> Iterator[Ended]:
        """Integrate all cases under way up to where one of them or more are to be looked at; yield those that ended."""
        runs = [beside.run for beside in self.lanes.values()]
        addresses, status = np.array([run.kept.address for run in runs]), np.zeros(len(runs), dtype=np.int64)
        began, clock = time.process_time(), time.perf_counter()
        loop.integrate(runs[0].kept, addresses, status, self.together, *self.arrays)
        now, share = time.process_time(), (time.perf_counter() - clock) / len(runs)
        others = now - self.seen - (now - began) / len(runs)  # what went to other cases is left out of account
        self.seen = now
        for (lane, beside), state in zip(list(self.lanes.items()), status, strict=True):
            beside.run.duration += share
            beside.run.deadline += others
            if state == plan.GOING:
                continue
            try:
                if not beside.run.ended(int(state)):
                    continue
                ended: Trajectory | Exception = finished(beside.scene, beside.run)
            except Exception as error:
                ended = error
            del self.lanes[lane]
            yield beside.place, ended
