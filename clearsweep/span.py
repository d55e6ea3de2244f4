"""Runs that are watched on their way: how fast a disturbance grows, and whether the run is long enough.

A watched run pauses between two steps and goes on as if it had not: its motion and figures are, to the last bit, those
of a plain run of the same length.
"""

import itertools
import math
from collections import deque

import numpy as np

from .blocks import Blocks
from .kernels import integrate as loop
from .kernels.joint import FREE
from .outcome import channels

#: Turns before the end of a revolution at which a run pauses: more than a step spans, so that it can still end there.
LEAD = 0.025
PARTS = 20  # of a revolution: a disturbance is brought back so often
SIZE, OVER, MOST = 1e-6, 1e3, 1e-3  # clearances: what it is brought back to; so many tolerances if that is more
FAINTEST = 1e-9  # of that: where a motion forgets a disturbance altogether, no logarithm of zero
SATURATED = 0.1  # clearances: a disturbance that grows no more
SETTLED = 4  # revolutions
HORIZON = 0.01  # clearances: where prediction ends
LONGEST_PERIOD, REPEATS = 16, 3  # revolutions; times that a period has to be repeated
RETURN = 1e-3  # clearances, and clearances times crank rate: how closely a periodic motion returns


def drive(control, run, discard: float, turn: float, watchers) -> tuple[int, np.ndarray]:
    """Return the status and the events of an integration that its `watchers` look at on the way.

    discard : revolutions after which they begin, each of which takes `turn` (s).  A watcher has a number of `parts` of
    a revolution and is called with `work` at the end of each; if it returns True, the run ends with this revolution.
    """
    work, logs, parts = run.work, [], max(watcher.parts for watcher in watchers)
    for k in itertools.count():
        pause = mark(k / parts, discard, turn)
        if pause >= control.end:
            break
        status, log = run.go(control._replace(pause=pause))
        logs.append(log)
        if status != loop.PAUSED:
            return status, np.concatenate(logs)
        end = (discard + k // parts) * turn
        enough = [watcher.see(work) for watcher in watchers if k % (parts // watcher.parts) == 0]
        if any(enough) and work.y[work.time] < end:
            control = control._replace(end=end)
    status, log = run.go(control)
    return status, np.concatenate([*logs, log])


def mark(turns: float, discard: float, turn: float) -> float:
    """Return the time (s) to pause at, so many turns after the first `discard` ones: LEAD before, save at the start."""
    return (discard + turns - LEAD if turns else discard) * turn


def moment_of(work) -> dict:
    """Return copies of all arrays of `work` (event.Work) that the motion goes on from."""
    return {name: array.copy() for name, array in _arrays(work).items() if name not in ("counts", "slopes")}


def go_to(moment: dict, work) -> None:
    """Let `work` go on from what `moment_of` returned of another run of the same scene."""
    arrays = _arrays(work)
    for name, array in moment.items():
        arrays[name][...] = array


def _arrays(work) -> dict[str, np.ndarray]:
    """Return the arrays of `work` (event.Work) by name, those of the implicit method among them."""
    fields = work._asdict() | work.implicit._asdict()
    return {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}


def marks(settings: dict, turn: float) -> np.ndarray:
    """Return the times (s) to pause at once a revolution, always at the same crank angle, within the longest run."""
    count = math.ceil(longest(settings) - settings["discard"] - 1e-9)
    return np.array([mark(k, settings["discard"], turn) for k in range(1, count + 1)])


class Twin:
    """A second run, a little off the first and brought back whenever it has grown: Benettin et al. 1980.

    The distance is that of the coordinates in clearances and of their rates in clearances times crank rate, at equal
    times.  To bring the twin back is to take the same share of all that tells the two states apart; where one of them
    is in contact and the other not yet, it waits.  Brought back, it begins with the step length of the first run, so
    that their steps and the errors of these hardly differ until one of them meets an event without the other.
    """

    parts = PARTS

    def __init__(self, control, run, scale: np.ndarray, tolerance: float):
        """Make a twin in `run`, unused so far; scale : (coordinates and rates,) what counts as 1."""
        self.control = control._replace(keep_events=False, end=math.inf)
        self.run, self.work, self.scale, self.tolerance = run, run.work, scale, tolerance
        self.size = max(SIZE, min(OVER * tolerance, MOST))
        self.times, self.growths = [], []  # s; logarithm of the growth since the start, up to then
        self.status = loop.OK

    def see(self, base) -> bool:
        """Follow `base` to where it is now."""
        moment = float(base.y[base.time])
        if not self.times:
            self.times, self.growths = [moment], [0.0]
            self._bring(base, self.scale / math.sqrt(self.scale.size), 0.0)
        elif self.status == loop.OK and moment > self.work.y[base.time]:
            control = self.control._replace(window=moment, pause=moment)
            status, _ = self.run.go(control)
            if status != loop.PAUSED:
                self.status = status
                return False
            self._measure(base)
        return False

    def _measure(self, base) -> None:
        """Note how far the twin has departed from `base`, and bring it back."""
        work, n = self.work, self.scale.size
        alike = bool(np.all(work.state == base.state))
        off = float(np.linalg.norm((work.y[:n] - base.y[:n]) / self.scale))
        if not alike and off < SATURATED:
            return
        self.times.append(float(base.y[base.time]))
        self.growths.append(self.growths[-1] + math.log(max(off, FAINTEST * self.size) / self.size))
        if alike and off > 0.0:
            self._bring(base, (work.y - base.y) / off, (work.onset - base.onset) / off)
        else:
            self._bring(base, self.scale / math.sqrt(n), 0.0)

    def _bring(self, base, direction: np.ndarray, onset: np.ndarray | float) -> None:
        """Put the twin beside `base`: in this direction of the state (or its first components) and the onset rates."""
        work = self.work
        go_to(moment_of(base), work)
        work.y[: len(direction)] += self.size * direction
        work.onset[:] += self.size * onset
        roots = work.y[work.time + 1 : work.time + 1 + work.state.size]
        roots[:] = np.where(work.state == FREE, 0.0, np.maximum(roots, loop.SEED * work.sigma))

    def figures(self, turn: float) -> dict:
        """Return the exponent and the horizon; None where they were not found, or where a disturbance does not grow.

        Of more than SETTLED revolutions the first does not count: in it the disturbance turns to where it grows most.
        """
        exponent = horizon = None
        if self.status == loop.OK and len(self.times) > 1:
            turns = (np.array(self.times) - self.times[0]) / turn
            first = int(np.searchsorted(turns, 1.0)) if turns[-1] > SETTLED else 0
            exponent = (self.growths[-1] - self.growths[first]) / (self.times[-1] - self.times[first])
        if exponent is not None and exponent > 0.0:
            horizon = max(math.log(HORIZON / self.tolerance), 0.0) / (exponent * turn)
        return {"lyapunov_exponent": exponent, "horizon_revolutions": horizon}


class Until:
    """Ends a run when its figure has settled or its motion repeats itself."""

    parts = 1

    def __init__(self, scene, samples: np.ndarray):
        """Prepare for a run of `scene` that puts its time histories at the `marks` into `samples`."""
        settings, save = scene.case["simulate"], scene.case["save"]
        self.figure, self.relative = settings["until"]["figure"], settings["until"]["relative_ci"]
        self.blocks = Blocks(scene.layout, (self.figure,))
        self.discard, self.least = settings["discard"], settings["revolutions"]
        self.samples, self.places, self.units = samples, *_journals(scene)
        # moments of the run, oldest first, from which what is saved can be run again
        self.starts = deque(maxlen=math.ceil(save["revolutions"]) + 1 if save["orbits"] == "last" else 1)
        self.revolutions, self.period, self.interval, self.settled = 0.0, None, None, False

    def see(self, work) -> bool:
        """Return whether the run may end with this revolution."""
        turns = self.blocks.turns
        self.revolutions = self.discard + turns
        self.starts.append(moment_of(work))
        if self.blocks.note(work) or self.interval is None:
            self.interval = self.blocks.interval(self.figure)
        self.period = period_of(self.samples[:turns, self.places] / self.units)
        self.settled = self.period is not None or self.interval.within(self.relative)
        return turns > 0 and self.settled and self.revolutions >= self.least

    def figures(self) -> dict:
        """Return what the run came to, as columns of the summary."""
        width = self.interval.half_width if self.interval and math.isfinite(self.interval.half_width) else None
        return {
            "revolutions_run": self.revolutions,
            "period": self.period,
            "figure_ci": width,
            "settled": int(self.settled),
        }


def _journals(scene) -> tuple[list, np.ndarray]:
    """Return the channels that tell where the journals are and how fast, and what counts as 1 in each."""
    names = [channel.name for channel in channels(scene.layout)]
    places, units = [], []
    for part, joint in zip(scene.layout.joints, scene.value.joints, strict=True):
        places += [names.index(f"joints/{part.name}/{name}") for name in ("x", "y", "vx", "vy")]
        units += [joint.clearance] * 2 + [joint.clearance * scene.value.pace] * 2
    return places, np.array(units)


def longest(settings: dict) -> float:
    """Return the most revolutions that an `until` allows: `discard` and whole ones, as intervals are made of those."""
    discard = settings["discard"]
    return discard + math.floor(settings["until"]["max_revolutions"] - discard + 1e-9)


def period_of(returns: np.ndarray) -> int | None:
    """Return after how many rows of (revolutions, columns) the last ones repeat themselves; None: they do not."""
    for period in range(1, min(LONGEST_PERIOD, len(returns) // (REPEATS + 1)) + 1):
        last = returns[len(returns) - REPEATS * period :]
        before = returns[len(returns) - (REPEATS + 1) * period : -period]
        if np.all(np.abs(last - before) <= RETURN):
            return period
    return None
