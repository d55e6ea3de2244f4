"""Phases of work and their progress: current activity of a process, elapsed time, and time left.

Code opens a phase and records its progress, which takes a microsecond.  `show_progress` prints the open phase on
stderr: a line after FIRST_LINE_DELAY s without one, or on a terminal a line that is redrawn.  `store_progress` stores
it where another process reads it, as worker processes do.
"""

import contextlib
import json
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

from .errors import escape_control_characters
from .wording import duration_text

FIRST_LINE_DELAY = 5.0  # s without a line before the first one is printed
INTERVAL_GROWTH = 1.5  # factor by which the next pause is longer
MAX_INTERVAL = 60.0  # s
REFRESH_INTERVAL = 0.25  # s between two looks at the open phases, and between two drawings on a terminal
MIN_ELAPSED = 1.0  # s of work before its time left is estimated, before a terminal shows it, and between two writes
BAR_WIDTH = 24  # characters of a bar


class Progress(NamedTuple):
    """The progress of some work at one time."""

    what: str  # names of the open phases
    seconds: float  # elapsed
    left: float | None = None  # s until the end, None: unknown
    facts: Mapping[str, Any] = MappingProxyType({})  # further values for programs, such as the number of a block
    share: float | None = None  # finished share of the work
    once: bool = False  # the result of the work is kept for later runs

    @property
    def text(self) -> str:
        """Return the progress as 'writing orbits.h5, 37 %, 8 s spent, about 14 s left'."""
        left = "" if self.left is None else f"about {duration_text(self.left)} left"
        return ", ".join(filter(None, [self.what, f"{duration_text(self.seconds)} spent", left]))


class Phase:
    """A section of work.

    name : '' for a phase that only carries facts.
    covers_nested : its estimate of the time includes all nested phases, whose own estimates do not count.
    once : its result is stored for later runs, such as compiled code.
    since : s of the monotonic clock, start of the work if an earlier phase did part of it.
    """

    def __init__(
        self,
        name: str | Callable[[], str],
        *,
        covers_nested: bool = False,
        once: bool = False,
        since: float | None = None,
    ):
        self._name, self.covers_nested, self.once = name, covers_nested, once
        self.opened = time.monotonic()
        self.begin = self.opened if since is None else since
        self.share: float | None = None
        self.facts: dict[str, Any] = {}
        self._remaining_time: tuple[float, float] | None = None  # s left, and when this was recorded
        self.compile_time = 0.0  # s of nested phases of the kind `once`, which do not count for the pace

    def note(self, *, share: float | None = None, remaining_time: float | None = None, **facts: Any) -> None:
        """Record the finished share of the work or the time (s) left, and facts for programs."""
        self.share = self.share if share is None else share
        self._remaining_time = self._remaining_time if remaining_time is None else (remaining_time, time.monotonic())
        if facts:
            self.facts = self.facts | facts
        _notify_listeners()

    def what(self) -> str:
        """Return the present name of the phase, with the finished share of the work."""
        if not isinstance(self._name, str):
            return self._name()
        return self._name if self.share is None else f"{self._name}, {100.0 * self.share:.0f} %"

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left, or None if unknown."""
        if self._remaining_time is not None:
            remaining_time, noted = self._remaining_time
            return max(remaining_time - (now - noted), 0.0) or None
        elapsed = now - self.begin - self.compile_time
        return elapsed * (1.0 / self.share - 1.0) if self.share and elapsed >= MIN_ELAPSED else None

    def line_suffix(self) -> str:
        """Return further words for a line about this phase."""
        return ""


class _Listener(Protocol):
    def changed(self) -> None:
        """React to a change of the open phases."""


_open_phases: list[Phase] = []  # the outermost first
listeners: list[_Listener] = []
_compile_seconds = [0.0]  # s of finished phases of the kind `once`


def _notify_listeners() -> None:
    """Tell all listeners that the open phases changed."""
    for listener in listeners:
        listener.changed()


@contextlib.contextmanager
def phase(name: str | Phase | Callable[[], str], *, covers_nested: bool = False) -> Iterator[Phase]:
    """Open a phase for as long as this context lasts; see Phase."""
    new_phase = start(name if isinstance(name, Phase) else Phase(name, covers_nested=covers_nested))
    try:
        yield new_phase
    finally:
        end(new_phase)


def start(new_phase: Phase) -> Phase:
    """Open a phase and return it."""
    _open_phases.append(new_phase)
    _notify_listeners()
    return new_phase


def end(ended_phase: Phase) -> None:
    """Close a phase."""
    _open_phases[:] = [open_phase for open_phase in _open_phases if open_phase is not ended_phase]
    if ended_phase.once and not any(open_phase.once for open_phase in _open_phases):
        elapsed = time.monotonic() - ended_phase.opened
        _compile_seconds[0] += elapsed
        for open_phase in _open_phases:
            open_phase.compile_time += elapsed
    _notify_listeners()


def compile_seconds() -> float:
    """Return the time (s) that this process has spent on work that later runs do not repeat."""
    return _compile_seconds[0]


def progress(first_index: int = 0) -> Progress | None:
    """Return the progress of the open phases from index `first_index` on, or None if none is open.

    The time left is that of the outermost phase that `covers_nested`, or else of the innermost with an estimate.
    """
    phases, now = list(_open_phases)[first_index:], time.monotonic()
    if not phases:
        return None
    covering = next((open_phase for open_phase in phases if open_phase.covers_nested), None)
    with_estimate = [open_phase for open_phase in reversed(phases) if open_phase.remaining_time(now) is not None]
    timed_phase = covering or (with_estimate[0] if with_estimate else phases[-1])
    facts: dict[str, Any] = {}
    for open_phase in phases:
        facts |= open_phase.facts
    name = ": ".join(filter(None, [open_phase.what() for open_phase in phases]))
    is_once = phases[-1].once
    return Progress(name, now - timed_phase.begin, timed_phase.remaining_time(now), facts, phases[-1].share, is_once)


def innermost_phase() -> Phase | None:
    """Return the innermost open phase."""
    return next(reversed(list(_open_phases)), None)


# ---------------------------------------------------------------------------------------------- on stderr


class Display:
    """Prints the progress of the open phases on stderr."""

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.is_terminal = sys.stderr is not None and sys.stderr.isatty()
        self.bar: Any = None  # progress bar on a terminal
        self.last_printed, self.interval = time.monotonic(), FIRST_LINE_DELAY
        self.printed_phase: Phase | None = None  # phase printed last
        self.stopped = threading.Event()
        self.thread: threading.Thread | None = None

    def start(self) -> None:
        """Refresh the display now and then, in a thread."""
        self.stopped.clear()
        self.thread = threading.Thread(target=self._watch, name="clearsweep progress", daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """End the thread."""
        self.stopped.set()
        if self.thread is not None:
            self.thread.join()

    def _watch(self) -> None:
        while not self.stopped.wait(REFRESH_INTERVAL):
            with contextlib.suppress(Exception):  # stderr may be closed; an error in one line must not end the others
                self.refresh()

    def refresh(self) -> None:
        """Print a line if one is due."""
        open_phase, current_progress, now = next(iter(list(_open_phases)), None), progress(), time.monotonic()
        if current_progress is None or open_phase is None or sys.stderr is None:
            self.close()
            return
        if self.is_terminal:
            if now - open_phase.begin >= MIN_ELAPSED:
                self._draw(current_progress, open_phase.line_suffix())
            return
        if open_phase is not self.printed_phase:
            self.printed_phase, self.interval = open_phase, FIRST_LINE_DELAY
        if now - self.last_printed >= self.interval:
            self.interval = min(INTERVAL_GROWTH * self.interval, MAX_INTERVAL)
            self.print_line(current_progress.text + open_phase.line_suffix())

    def print_line(self, sentence: str) -> None:
        """Print a line."""
        with self.lock:
            self._clear()
            self.last_printed = time.monotonic()
            if sys.stderr is not None:  # None would mean stdout
                print(escape_control_characters(sentence), file=sys.stderr, flush=True)

    def close(self) -> None:
        """Remove the redrawn line from the terminal."""
        with self.lock:
            self._clear()

    def _draw(self, current_progress: Progress, suffix: str) -> None:
        with self.lock:
            if self.bar is None:
                from tqdm import tqdm

                self.bar = tqdm(total=1.0, file=sys.stderr, leave=False, dynamic_ncols=True, bar_format="{desc}")
            self.bar.n = current_progress.share or 0.0
            self.bar.bar_format = "{desc}" if current_progress.share is None else f"|{{bar:{BAR_WIDTH}}}| {{desc}}"
            self.bar.set_description_str(escape_control_characters(current_progress.text + suffix).replace("\n", " "))

    def _clear(self) -> None:
        if self.bar is not None:
            self.bar.close()
            self.bar = None


_active_displays: list[Display] = []  # the one in use


@contextlib.contextmanager
def show_progress(enabled: bool = True) -> Iterator[None]:  # noqa: FBT001, FBT002 - read as `show_progress(enabled)`
    """Print the progress of the work in this context on stderr, unless it is printed already."""
    if not enabled or _active_displays or sys.stderr is None:
        yield
        return
    display = Display()
    _active_displays.append(display)
    display.start()
    try:
        yield
    finally:
        display.stop()
        _active_displays.remove(display)
        with contextlib.suppress(Exception):
            display.close()


@contextlib.contextmanager
def without_thread() -> Iterator[None]:
    """Show no progress in this context, which needs a thread: a process with several threads must not be forked."""
    for display in _active_displays:
        display.stop()
    try:
        yield
    finally:
        for display in _active_displays:
            display.start()


def forget() -> None:
    """Forget the work of the process of which this one is a fork."""
    for known in (_open_phases, listeners, _active_displays):
        known.clear()


def print_line(sentence: str) -> None:
    """Print a line on stderr, whether progress is shown or not."""
    (_active_displays[0] if _active_displays else Display()).print_line(sentence)


# ---------------------------------------------------------------------------------------------- for another process


class ProgressWriter:
    """Keeps the progress of the open phases where another process reads it.

    A phase that ends within MIN_ELAPSED s leaves nothing, unless later runs do not repeat its work.
    """

    def __init__(self, replace_content: Callable[[bytes | None], None]):
        """Prepare to replace the stored content by `replace_content`; None removes it."""
        self.replace_content = replace_content
        self.next_write = 0.0
        self.is_stored = False
        self.first_phase = len(_open_phases)
        self.once = False  # whether the last written phase is of the kind `once`

    def changed(self) -> None:
        """Write the progress if it is due."""
        open_phase, now = next(iter(list(_open_phases)[self.first_phase :]), None), time.monotonic()
        innermost = innermost_phase()
        is_once = innermost is not None and innermost.once
        is_early = open_phase is not None and now - open_phase.begin < MIN_ELAPSED and not is_once
        if open_phase is None or is_early:  # the compiler reports only its begin and its end
            self.discard()
        elif (now >= self.next_write or is_once != self.once) and (current_progress := progress(self.first_phase)):
            self.next_write, self.is_stored, self.once = now + MIN_ELAPSED, True, current_progress.once
            self.replace_content(
                json.dumps(
                    current_progress._asdict() | {"facts": dict(current_progress.facts), "time": time.time()}
                ).encode()
            )

    def discard(self) -> None:
        """Remove the stored progress."""
        if self.is_stored:
            self.is_stored = False
            self.replace_content(None)


@contextlib.contextmanager
def store_progress(replace_content: Callable[[bytes | None], None]) -> Iterator[None]:
    """Write the progress of the work in this context by `replace_content`; `stored_progress` reads it."""
    listener = ProgressWriter(replace_content)
    listeners.append(listener)
    try:
        yield
    finally:
        listeners.remove(listener)
        listener.discard()


def stored_progress(content: bytes) -> Progress | None:
    """Return the present progress from stored content, or None if the content is incomplete."""
    try:
        fields = json.loads(content)
        age = max(time.time() - fields.pop("time"), 0.0)
        stored = Progress(**fields)
        time_left = stored.left if stored.left is None else max(stored.left - age, 0.0) or None
        return stored._replace(seconds=stored.seconds + age, left=time_left)
    except (ValueError, KeyError, TypeError, AttributeError):
        return None


class EstimateListener:
    """Keeps the latest estimate of the total time (s) of the work, or None."""

    def __init__(self) -> None:
        self.begin, self.first_phase = time.monotonic(), len(_open_phases)
        self.total_time: float | None = None

    def changed(self) -> None:
        """Store the latest estimate."""
        if any(open_phase.once for open_phase in _open_phases):
            return  # the estimate of this phase only
        if (latest := progress(self.first_phase)) and latest.left is not None:
            self.total_time = time.monotonic() - self.begin + latest.left


@contextlib.contextmanager
def track_estimate() -> Iterator[EstimateListener]:
    """Yield an EstimateListener, which keeps the latest estimate of the time of the work in this context."""
    listener = EstimateListener()
    listeners.append(listener)
    try:
        yield listener
    finally:
        listeners.remove(listener)
