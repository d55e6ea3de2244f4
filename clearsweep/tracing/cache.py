"""The cache of compiled code: a private directory of objects, and of records of what each was traced from.

An object is named by a hash of the LLVM code that a trace emitted, so whatever leads to the same code shares it.  A
record belongs to a kind of code: a function, the types of its arguments and a level of processors.  It contains the
name of the object, and the hash of every source on which the trace depended.  While these are as they were, the object
is loaded without a trace.  If one of them has changed, the function is traced anew, and compiled only if its code
differs.

Cached code is executed, so a directory that another user could have written to is not used.  As one changed bit may
change a number, everything carries a checksum.
"""

import atexit
import contextlib
import functools
import hashlib
import json
import os
import re
import secrets
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path

PLACE = "CLEARSWEEP_CACHE_DIR"  # environment variable: where compiled code is kept
PACKAGE = Path(__file__).parents[1]
COMPILER = PACKAGE / "tracing"
SOURCES = (PACKAGE / "mechanics", COMPILER)  # of all code that the package compiles
SHIPPED = PACKAGE / "mechanics" / "objects"  # machine code, below a directory with the stamp of its compiler
CHECKSUM = hashlib.sha256().digest_size  # bytes at the end of every file
texts: dict[str, str] = {}  # name of a source that is not on disk, such as a law file -> its hash
_IMPORT = re.compile(r"^[ \t]*from[ \t]+(\.*)([\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)", re.MULTILINE)


def compiler_stamp() -> str:
    """Return a hash of what makes objects of LLVM code: the version of llvmlite, and how it is used."""
    import llvmlite  # which a grid that is only read never needs

    digest = hashlib.sha256(f"{llvmlite.__version__}\n".encode() + (COMPILER / "objects.py").read_bytes())
    return digest.hexdigest()[:16]


@functools.cache
def source_hashes() -> dict[str, str]:
    """Return the hashes of all sources by their paths, as they are when this process begins."""
    return {str(path): _hash_of(path) for folder in SOURCES for path in sorted(folder.rglob("*.py"))}


def _hash_of(path: Path) -> str:
    """Return the hash of a source, or '' if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    except OSError:
        return ""


def dependencies(traced: Iterable[str], *, on_all: bool = False) -> dict[str, str]:
    """Return the hashes of the sources on which the trace of functions in these files depends, by their paths.

    They are those of the tracer, of these files, and of what they import of the package, from which their constants
    and classes are.  A file elsewhere may depend on any of the package.  on_all : whether the trace depends on all.
    """
    hashes, waiting = source_hashes(), list(traced)
    if on_all:
        return hashes | {path: _hash_now(path) for path in waiting if path not in hashes and _is_other_source(path)}
    result = {path: hash_of_source for path, hash_of_source in hashes.items() if Path(path).is_relative_to(COMPILER)}
    while waiting:
        path = waiting.pop()
        if path in hashes:
            if path not in result or Path(path).is_relative_to(COMPILER):
                waiting += [x for x in _imported(path) if x in hashes and x not in result]
            result[path] = hashes[path]
        elif _is_other_source(path):
            result |= hashes | {path: _hash_now(path)}
    return result


def _is_other_source(path: str) -> bool:
    """Return whether a name is that of a source outside of the package, and not '<string>' or the like."""
    return path in texts or os.path.isabs(path)


def _imported(path: str) -> list[str]:
    """Return the paths of the modules of the package that a module may import."""
    text, places = Path(path).read_text(encoding="utf-8"), []
    for dots, module, names in _IMPORT.findall(text):
        base = Path(path).parents[len(dots) - 1] if dots else PACKAGE.parent
        base = base.joinpath(*module.split(".")) if module else base
        places += [base, *(base / name for name in re.findall(r"\w+", names))]
    return [str(path) for place in places for path in (place.with_suffix(".py"), place / "__init__.py")]


def prepare_cache() -> Path:
    """Make this process and its children keep code in a private, stamped directory, and return it.

    It is in CLEARSWEEP_CACHE_DIR if that is set, else in the user's cache.  If that cannot be written, or is not
    private, the code is kept only for this process and its workers, with a message on stderr.
    """
    source_hashes()
    stamp = compiler_stamp()
    configured = os.environ.get(PLACE)
    try:
        parent = Path(configured) if configured else _user_cache()
        is_inherited = parent.name == stamp  # from the process that prepared it
        directory = parent if is_inherited else parent / stamp
        place, reason = (directory if is_inherited else parent), _preparation_problem(directory)
    except RuntimeError as error:  # pathlib's, without HOME and without an entry in passwd
        place, reason = "~/.cache", f"{error}; set HOME or XDG_CACHE_HOME"
    if reason:
        print(f"compiled code is not kept in {place}: {reason}", file=sys.stderr)
        directory = _temporary_directory() / stamp
        directory.mkdir(mode=0o700)
    os.environ[PLACE] = str(directory)
    return directory


def _user_cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "clearsweep"


def _preparation_problem(directory: Path) -> str:
    """Create a directory if it is missing; return why code cannot be kept there, or ''.

    Something may remove it at any moment, such as a cleaner of caches.
    """
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        return privacy_problem(directory) or ("" if os.access(directory, os.W_OK | os.X_OK) else "it cannot be written")
    except OSError as error:
        return f"it cannot be made ({error.strerror})"


def privacy_problem(directory: Path) -> str:
    """Return why another user could have written to a directory or replaced it, or '' if nobody could."""
    if not hasattr(os, "geteuid"):
        return ""
    for path in (directory, directory.parent):
        if path.is_symlink():
            return f"{path} is a link"
    real = directory.resolve()
    for path in (real, *real.parents):
        status = path.stat()
        is_own = status.st_uid == os.geteuid()
        if not is_own and (path == real or status.st_uid != 0):
            return f"{path} belongs to another user"
        is_writable_by_others = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        if is_writable_by_others and (path == real or not status.st_mode & stat.S_ISVTX):
            return f"{path} can be written by other users"
    return ""


def _temporary_directory() -> Path:
    """Return a new private directory that is removed with this process."""
    directory, owner = Path(tempfile.mkdtemp(prefix="clearsweep-")), os.getpid()
    atexit.register(lambda: shutil.rmtree(directory, ignore_errors=True) if os.getpid() == owner else None)
    return directory


def _checksum(name: str, stamp: str, body: bytes) -> bytes:
    """Return the checksum of an object; it covers name and stamp, since an exchanged object would be foreign code."""
    return hashlib.sha256(f"{stamp}/{name}\n".encode() + body).digest()


_reported_directories: set[str] = set()  # directories with a reported damage


def _report_damage(path: Path) -> None:
    """Report damage once for each directory."""
    directory = str(path.parents[1])
    if directory not in _reported_directories:
        _reported_directories.add(directory)
        print(f"compiled code kept in {directory} is damaged and is compiled anew", file=sys.stderr)


def load(name: str) -> bytes | None:
    """Return the valid content stored under a name or shipped with the package, or None."""
    return next(_contents(name), None)


def _contents(name: str) -> Iterator[bytes]:
    """Yield what is stored under a name, in the user's cache and in the package, as far as it is not damaged."""
    directory = Path(os.environ[PLACE])
    for path in (directory / "traced" / name, SHIPPED / directory.name / name):
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            continue
        except OSError:
            content = b""
        body, checksum = content[:-CHECKSUM], content[-CHECKSUM:]
        if checksum == _checksum(name, directory.name, body):
            yield body
        else:
            _report_damage(path)


def recorded_object(name: str) -> str | None:
    """Return the name of the object of a kind of code, or None if its sources are not those that were traced."""
    for content in _contents(name):
        record = json.loads(content)
        if all(_hash_now(path) == expected for path, expected in record["sources"].items()):
            return str(record["object"])
    return None


def _hash_now(path: str) -> str:
    """Return the hash of a source as it is in this process; path : relative to the package, or absolute."""
    full_path = str(PACKAGE / path)
    hashes = source_hashes()
    return texts.get(path) or hashes.get(full_path) or _hash_of(Path(full_path))


def record(name: str, object_name: str, traced: Iterable[str], *, on_all: bool = False) -> None:
    """Record the object of a kind of code with its `dependencies`, unless one of these changed since the start."""
    sources = dependencies(traced, on_all=on_all)
    if all(texts.get(path) or _hash_of(Path(path)) == expected for path, expected in sources.items()):
        relative = {path.removeprefix(f"{PACKAGE}{os.sep}"): hash_of_source for path, hash_of_source in sources.items()}
        store(name, json.dumps({"object": object_name, "sources": relative}, sort_keys=True).encode())


_PACKAGE_DIRECTORY: list[Path] = []  # directory used instead of the user's cache


@contextlib.contextmanager
def stored_in_package() -> Iterator[Path]:
    """In this context, store code in the package."""
    directory = SHIPPED / Path(os.environ[PLACE]).name
    _PACKAGE_DIRECTORY.append(directory)
    try:
        yield directory
    finally:
        _PACKAGE_DIRECTORY.pop()


def empty_package() -> None:
    """Remove all code from the package."""
    shutil.rmtree(SHIPPED, ignore_errors=True)


def store(name: str, content: bytes) -> None:
    """Store content under a name; on failure, store nothing."""
    prepared = Path(os.environ[PLACE])
    directory = _PACKAGE_DIRECTORY[-1] if _PACKAGE_DIRECTORY else prepared / "traced"
    partial = directory / f"{name}.{secrets.token_hex(8)}"
    try:
        directory.mkdir(mode=0o755 if _PACKAGE_DIRECTORY else 0o700, parents=True, exist_ok=True)
        partial.write_bytes(content + _checksum(name, prepared.name, content))
        partial.replace(directory / name)
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()
