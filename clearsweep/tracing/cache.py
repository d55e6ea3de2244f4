"""The cache of compiled code: a private directory stamped with everything that the code depends on.

Cached code is executed, so a directory that another user could have written to is not used.  As one changed bit
may change a number, everything carries a checksum.
"""

import atexit
import contextlib
import hashlib
import os
import secrets
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
SOURCES = (PACKAGE / "mechanics", PACKAGE / "tracing")  # of all compiled code
SHIPPED = PACKAGE / "mechanics" / "objects"  # machine code, below a directory with the stamp of its sources
CHECKSUM = hashlib.sha256().digest_size  # bytes at the end of every file


def hash_of_sources() -> str:
    """Return a hash of all sources of `mechanics` and `tracing`, and of the compiler's version.

    The compiler itself only notices edits in the file of a cached function.
    """
    digest = hashlib.sha256(f"{version('llvmlite')}".encode())
    for folder in SOURCES:
        for source in sorted(folder.rglob("*.py")):
            name = source.relative_to(folder.parent).as_posix()
            digest.update(f"{name} {source.stat().st_size}\n".encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def prepare_cache() -> Path:
    """Make the compiler use a private, stamped directory, and return it.

    It is in NUMBA_CACHE_DIR if that is set, else in the user's cache.  If that cannot be written, or is not
    private, the code is kept only for this process and its workers, with a message on stderr.
    """
    source_stamp = hash_of_sources()
    configured = os.environ.get("NUMBA_CACHE_DIR")
    try:
        parent = Path(configured) if configured else _user_cache()
        is_inherited = parent.name == source_stamp  # from the process that prepared it
        directory = parent if is_inherited else parent / source_stamp
        place, reason = (directory if is_inherited else parent), _preparation_problem(directory)
    except RuntimeError as error:  # pathlib's, without HOME and without an entry in passwd
        place, reason = "~/.cache", f"{error}; set HOME or XDG_CACHE_HOME"
    if reason:
        print(f"compiled code is not kept in {place}: {reason}", file=sys.stderr)
        directory = _temporary_directory() / source_stamp
        directory.mkdir(mode=0o700)
    os.environ["NUMBA_CACHE_DIR"] = str(directory)
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
    directory = Path(os.environ["NUMBA_CACHE_DIR"])
    for path in (directory / "traced" / name, SHIPPED / directory.name / name):
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            continue
        except OSError:
            content = b""
        body, checksum = content[:-CHECKSUM], content[-CHECKSUM:]
        if checksum == _checksum(name, directory.name, body):
            return body
        _report_damage(path)
    return None


_PACKAGE_DIRECTORY: list[Path] = []  # directory used instead of the user's cache


@contextlib.contextmanager
def stored_in_package() -> Iterator[Path]:
    """In this context, store code in the package and remove code of other sources from it."""
    directory = SHIPPED / Path(os.environ["NUMBA_CACHE_DIR"]).name
    for shipped in SHIPPED.glob("*"):
        if shipped != directory:
            shutil.rmtree(shipped)
    _PACKAGE_DIRECTORY.append(directory)
    try:
        yield directory
    finally:
        _PACKAGE_DIRECTORY.pop()


def store(name: str, content: bytes) -> None:
    """Store content under a name; on failure, store nothing."""
    prepared = Path(os.environ["NUMBA_CACHE_DIR"])
    directory = _PACKAGE_DIRECTORY[-1] if _PACKAGE_DIRECTORY else prepared / "traced"
    partial = directory / f"{name}.{secrets.token_hex(8)}"
    try:
        directory.mkdir(mode=0o755 if _PACKAGE_DIRECTORY else 0o700, parents=True, exist_ok=True)
        partial.write_bytes(content + _checksum(name, prepared.name, content))
        partial.replace(directory / name)
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()
