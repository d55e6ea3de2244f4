"""Runs the text of a trusted law file, once in each process, and returns the laws that it records.

The text that was hashed is the text that runs; nothing is read again.  While it runs, an audit hook refuses what a law
file has no reason to do: start a process or a thread, open a connection, write a file, read a neighbouring file that
its text does not name.  This gives mistakes a clear end.  It is no sandbox: what is trusted can do whatever its user
can.
"""

import _thread
import contextlib
import hashlib
import linecache
import os
import posix
import signal
import sys
import threading
import traceback
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from importlib.machinery import PathFinder
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

from ...contracts.case import LawFile
from ...contracts.catalogue import Catalogue
from ...language.errors import InputError, error_line
from ...laws import Law, collecting
from ...tracing import cache
from . import Problems, WrittenValue, law_files

ONLY_LAWS = "a law file may only declare laws"
TIME_LIMITS = {signal.SIGPROF: 20.0, signal.SIGALRM: 60.0}  # s of processor time, and of the clock
PATIENCE = 2.0  # s, after which the process ends if a text catches that its time is over
_REFUSED = {  # what happens -> beginnings of the names of its audit events
    "starts a process": ("subprocess.", "pty.spawn", "os.fork", "os.exec", "os.posix_spawn", "os.spawn", "os.system"),
    "starts a thread": ("_thread.start",),
    "opens a connection": ("socket.connect", "socket.send", "socket.getaddrinfo", "socket.gethost"),
    "changes a file or the directory": (
        "os.remove",
        "os.rename",
        "os.rmdir",
        "os.truncate",
        "shutil.",
        "os.link",
        "os.symlink",
        "os.ch",
    ),
    "sends a signal": ("os.kill", "signal."),
    "watches the process": ("sys.addaudithook", "sys.settrace", "sys.setprofile"),
}
_UNAUDITED = (  # functions without an event, at least in some versions of Python
    *((module, name, "ends the process") for module in (os, posix) for name in ("_exit", "abort")),
    (_thread, "start_new_thread", "starts a thread"),
    *((threading, name, "starts a thread") for name in ("_start_new_thread", "_start_joinable_thread")),
)
_WATCHED = ("builtins", "clearsweep", "cmath", "json", "math", "numpy", "os", "posix", "sys")  # may not be changed
RECORDS: dict[str, tuple[Law, ...]] = {}  # key of a file -> its laws, in this process
_LOCK = threading.RLock()


class _Running:
    """The text that runs."""

    file: LawFile | None = None
    thread = 0
    refused = ""  # what the hook refused
    has_hook = False


class _OutOfTimeError(BaseException):
    """A text that does not end."""


def run(file: LawFile, folder: Path | None = None) -> tuple[Law, ...]:
    """Return the laws of a file with their functions; raise InputError if it is not trusted, or fails.

    folder : that of the grid that names the file, for --trust-laws
    """
    if not law_files.is_allowed(file, folder):
        raise InputError(law_files.refusal_text(file))
    with _LOCK:
        if file.key not in RECORDS:
            _check_named(file)
            for module, line in law_files.imports(file).items():
                if place := _neighbouring(module, file):
                    reason = f"imports {module}, a neighbouring file ({place}); {law_files.NO_NEIGHBOURS}"
                    raise InputError(f"{file.name}:{line}: {reason}")
            records = _executed(file)
            _check_named(file)
            RECORDS[file.key] = records
        return RECORDS[file.key]


def run_all(files: Iterable[LawFile]) -> list[Law]:
    """Return the laws of all files, with their functions.  Raises InputError."""
    return [law for file in files for law in run(file)]


def has_run(file: LawFile) -> bool:
    """Return whether this process has run a file."""
    return file.key in RECORDS


def digest_of(files: Iterable[LawFile]) -> str:
    """Return the hash of all on which the laws of these files depend."""
    return hashlib.sha256("".join(law_files.digest_of_law(file, "") for file in files).encode()).hexdigest()[:16]


def enter_law_files(
    root: WrittenValue, catalogue: Catalogue, problems: Problems
) -> tuple[WrittenValue, Catalogue, tuple[LawFile, ...]]:
    """Return the document without its key `laws`, the catalogue with the laws of its files, and these files.

    The files run, but for those that a run has recorded with their laws: these run where a case needs them.  Raises
    InputError.
    """
    root, places = law_files.read_law_files(root, problems)
    problems.check()
    for file, written in places.items():
        try:
            if not file.laws:
                run(file, Path(written.origin).parent if written.line else Path())
        except InputError as error:
            problems.add(written, law_files.LAWS, str(error))
    problems.check()
    if not places or all(file.laws for file in places):
        laws = [law for file in places for law in file.laws]
        digest = digest_of(places) if places else catalogue.own_laws
        return root, catalogue._replace(laws=(*catalogue.laws, *laws), own_laws=digest), tuple(places)
    extended = catalogue.with_laws(run_all(places), digest_of(places))
    files = []
    for file in places:
        names = {law.name for law in run(file)}
        laws = [law for law in extended.laws if law.origin and law.name in names]
        files.append(replace(file, laws=tuple(laws), is_allowed=True))
    return root, extended, tuple(files)


def _check_named(file: LawFile) -> None:
    """Raise InputError if a library or table that a text names is not what was trusted."""
    for path, digest in file.named:
        if law_files.hash_of(path) != digest:
            raise InputError(f"{file.name}: {path} is not what was trusted; see `clearsweep trust`")


def _neighbouring(module: str, file: LawFile) -> str:
    """Return the place of a module that is not installed but a neighbour of a law file, or ''."""
    folder, place = os.path.dirname(file.path), getattr(sys.modules.get(module), "__file__", None)
    if file.package or module in (*sys.builtin_module_names, *sys.stdlib_module_names):
        return ""
    if place is None:
        located = PathFinder.find_spec(module)
        places = [located.origin, *(located.submodule_search_locations or ())] if located else []
        place = next((x for x in [*places, os.path.join(folder, f"{module}.py")] if x and os.path.exists(x)), None)
    return str(place) if place and law_files.is_neighbour(place, folder) else ""


def _executed(file: LawFile) -> tuple[Law, ...]:
    """Return the laws that the text of a file records while it runs."""
    is_new = cache.texts.get(file.name, file.key) == file.key
    name = file.name if is_new else f"{file.name} ({file.key[:8]})"
    lines = file.source.splitlines(keepends=True)
    linecache.cache[name] = len(file.source), None, lines, name  # without a time: nothing is read again
    cache.texts[name] = file.key
    module = ModuleType(f"{file.package + '.' if file.package else ''}laws_{file.key}")
    module.__dict__.update(__file__=file.path, __package__=file.package)
    sys.modules[module.__name__] = module
    try:
        with collecting() as records, guarded([file], has_limits=not file.is_allowed):
            exec(compile(file.source, name, "exec", dont_inherit=True), module.__dict__)
    except InputError:
        del sys.modules[module.__name__]
        raise
    if not records:
        raise InputError(f"{file.name}: declares no law; write one below a decorator such as `@laws.contact(...)`")
    return tuple(records)


@contextlib.contextmanager
def guarded(files: Sequence[LawFile], *, has_limits: bool = True) -> Iterator[None]:
    """In this context, Python runs texts or functions of files.  Raises InputError if these fail, or do anything else.

    What they print goes to stderr, and they have a time limit: but not in workers, which run what has ended before.
    """
    if not files:
        yield
        return
    with reported(files):
        with _watched(files[0], has_limits=has_limits):
            yield
        if _Running.refused:
            raise InputError(_Running.refused)


@contextlib.contextmanager
def reported(files: Sequence[LawFile]) -> Iterator[None]:
    """In this context, failures of functions of files are InputErrors with their places; `guarded` also watches."""
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise InputError(_failure_text(error, files[0])) from None


def _failure_text(error: BaseException, file: LawFile) -> str:
    """Return where a text failed and why."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in cache.texts]
    if isinstance(error, InputError) and (str(error).startswith(file.name) or not frames):
        return str(error)
    reason = str(error) if isinstance(error, (InputError, _OutOfTimeError)) else error_line(error)
    if not frames:
        return f"{file.name}: {reason}"
    name, line = frames[-1].filename, frames[-1].lineno or 1
    return f"{name}:{line}: {reason}: {linecache.getline(name, line).strip()[:80]}"


@contextlib.contextmanager
def _watched(file: LawFile, *, has_limits: bool) -> Iterator[None]:
    """In this context, the audit hook watches, and what changes in other modules is restored and refused."""
    if not _Running.has_hook:
        sys.addaudithook(_audit)
        _Running.has_hook = True
    before, path, bytecode = _attributes(), list(sys.path), sys.dont_write_bytecode
    try:
        with _time_limits() if has_limits else contextlib.nullcontext(), _prints_to_stderr(), _replaced():
            _Running.file, _Running.thread, _Running.refused = file, threading.get_ident(), ""
            sys.dont_write_bytecode = True  # of packages, which would be written files
            yield
    finally:
        _Running.file = None
        sys.path[:], sys.dont_write_bytecode = path, bytecode
        if changed := _restored(before):
            raise InputError(f"{file.name}: changes {changed}; {ONLY_LAWS}")


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    """Refuse what a text has no reason to do while it runs; see `sys.addaudithook`."""
    file = _Running.file
    if file is None or threading.get_ident() != _Running.thread:
        return
    _Running.file = None  # what follows may cause events, too
    try:
        reason = next((text for text, starts in _REFUSED.items() if event.startswith(starts)), "")
        if event == "import" and "." not in arguments[0] and (place := _neighbouring(arguments[0], file)):
            reason = f"imports {arguments[0]}, a neighbouring file ({place}); {law_files.NO_NEIGHBOURS}"
        elif event == "open" and isinstance(arguments[0], (str, bytes, os.PathLike)):
            reason = _reason_against_opening(os.fsdecode(arguments[0]), arguments[1], arguments[2], file)
        elif event == "ctypes.dlopen" and isinstance(arguments[0], str) and "/" in arguments[0]:
            reason = _reason_against_opening(arguments[0], "r", 0, file)
    finally:
        _Running.file = file
    if reason:
        _refuse(reason, file)


def _refuse(reason: str, file: LawFile) -> None:
    """Raise InputError with the line of the text that leads here; it counts even if the text catches it."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename not in cache.texts:
        frame = frame.f_back
    place = f"{frame.f_code.co_filename}:{frame.f_lineno}" if frame else file.name
    _Running.refused = _Running.refused or f"{place}: {reason}; {ONLY_LAWS}"
    raise InputError(_Running.refused)


@contextlib.contextmanager
def _replaced() -> Iterator[None]:
    """In this context, functions without an event are refused."""
    located = [
        (module, name, reason, vars(module)[name]) for module, name, reason in _UNAUDITED if name in vars(module)
    ]
    for module, name, reason, original in located:

        def refused(*arguments: Any, reason: str = reason, original: Any = original, **keywords: Any) -> Any:
            if _Running.file and threading.get_ident() == _Running.thread:
                _refuse(reason, _Running.file)
            return original(*arguments, **keywords)

        setattr(module, name, refused)
    try:
        yield
    finally:
        for module, name, _, original in located:
            setattr(module, name, original)


def _reason_against_opening(path: str, mode: str | None, flags: int, file: LawFile) -> str:
    """Return why a text may not open a file, or ''."""
    is_written = flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC) or set("wax+").intersection(mode or "")
    if is_written and path != os.devnull:
        return f"writes {path}"
    is_covered = os.path.realpath(path) in (file.path, *(named for named, _ in file.named))
    if not is_covered and not file.package and law_files.is_neighbour(path, os.path.dirname(file.path)):
        return f"opens {path}, which trust does not cover (write the name of a table or library as one text)"
    return ""


@contextlib.contextmanager
def _time_limits() -> Iterator[None]:
    """In this context, what does not end is stopped; only the main thread can do that."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    end, expired = os._exit, list[bool]()

    def stop(signum: int, _frame: FrameType | None) -> None:
        if expired:  # the text catches every error
            print("a law file does not end, and catches what would end it", file=sys.__stderr__, flush=True)
            end(2)
        expired.append(True)
        raise _OutOfTimeError(f"does not end within {TIME_LIMITS[signal.Signals(signum)]:g} s")

    timers = {signal.SIGPROF: signal.ITIMER_PROF, signal.SIGALRM: signal.ITIMER_REAL}
    old_handlers = {signum: signal.signal(signum, stop) for signum in timers}
    old_handlers[signal.SIGINT] = signal.getsignal(signal.SIGINT)
    old_times = {signum: signal.setitimer(timers[signum], TIME_LIMITS[signum], PATIENCE) for signum in timers}
    try:
        yield
    finally:
        for signum, times in old_times.items():
            signal.setitimer(timers[signum], *times)
        for signum, handler in old_handlers.items():
            signal.signal(signum, handler)


@contextlib.contextmanager
def _prints_to_stderr() -> Iterator[None]:
    """In this context, what goes to stdout goes to stderr, by Python or by the system."""
    for stream in filter(None, (sys.stdout, sys.__stdout__)):
        stream.flush()
    copy = os.dup(1)
    os.dup2(2, 1)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        if sys.__stdout__:
            sys.__stdout__.flush()
        os.dup2(copy, 1)
        os.close(copy)


def _attributes() -> dict[ModuleType, dict[str, Any]]:
    """Return the functions, classes and modules in the modules that a text may not change."""
    modules = [module for name, module in list(sys.modules.items()) if name.partition(".")[0] in _WATCHED]
    return {
        module: {name: x for name, x in vars(module).items() if callable(x) or isinstance(x, ModuleType)}
        for module in modules
        if isinstance(module, ModuleType)
    }


def _restored(before: dict[ModuleType, dict[str, Any]]) -> str:
    """Restore what has changed of `_attributes`; return its name, or ''."""
    changed = ""
    for module, attributes in before.items():
        for name, value in attributes.items():
            if vars(module).get(name) is not value:
                setattr(module, name, value)
                changed = f"{module.__name__}.{name}"
    return changed
