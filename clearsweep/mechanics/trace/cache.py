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

#: All compiled code and its sources are below this directory.
SOURCES = Path(__file__).parents[1]
SHIPPED = SOURCES / "objects"  # machine code in the package, below a directory with the stamp of its sources
CHECKSUM = hashlib.sha256().digest_size  # bytes at the end of every file


def hash_of_sources() -> str:
    """Return a hash of all sources of `mechanics` and of the compiler's version.

    The compiler itself only notices edits in the file of a cached function.
    """
    digest = hashlib.sha256(f"{version('llvmlite')}".encode())
    for source in sorted(SOURCES.rglob("*.py")):
        digest.update(f"{source.relative_to(SOURCES).as_posix()} {source.stat().st_size}\n".encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def prepare_cache() -> Path:
    """Make the compiler use a private, stamped directory, and return it.

    It is in NUMBA_CACHE_DIR if that is set, else in the user's cache.  If that cannot be written, or is not
    private, the code is kept only for this process and its workers, with a message on stderr.
    """
    source_stamp = hash_of_sources()
    configured = os.environ.get("NUMBA_CACHE_DIR")
    if configured and Path(configured).name == source_stamp and not privacy_problem(Path(configured)):
        return Path(configured)  # inherited from the process that prepared it
    parent = Path(configured or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "clearsweep")
    directory = parent / source_stamp
    try:
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        is_writable = os.access(directory, os.W_OK | os.X_OK)
        reason = privacy_problem(directory) or ("" if is_writable else "it cannot be written")
    except OSError as error:
        reason = f"it cannot be made ({error.strerror})"
    if reason:
        print(f"compiled code is not kept in {parent}: {reason}", file=sys.stderr)
        directory = _temporary_directory() / source_stamp
        directory.mkdir(mode=0o700)
    os.environ["NUMBA_CACHE_DIR"] = str(directory)
    return directory


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


def _without_checksum(content: bytes, path: str) -> bytes:
    """Return the content of a file without its checksum; ValueError if they disagree."""
    body, checksum = content[:-CHECKSUM], content[-CHECKSUM:]
    if hashlib.sha256(body).digest() != checksum:
        raise ValueError(f"{path}: its checksum differs")
    return body


_reported_directories: set[str] = set()  # directories with a reported damage


def _report_damage(path: str) -> dict:
    """Report damage once for each directory; return an empty index."""
    directory = str(Path(path).parents[1])
    if directory not in _reported_directories:
        _reported_directories.add(directory)
        print(f"compiled code kept in {directory} is damaged and is compiled anew", file=sys.stderr)
    return {}


# ---------------------------------------------------------------------------------------------- plain objects


def load(name: str) -> bytes | None:
    """Return the valid content stored under a name or shipped with the package, or None."""
    directory = Path(os.environ["NUMBA_CACHE_DIR"])
    for path in (directory / "traced" / name, SHIPPED / directory.name / name):
        try:
            return _without_checksum(path.read_bytes(), str(path))
        except FileNotFoundError:
            continue
        except (OSError, ValueError):
            _report_damage(str(path))
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
    directory = _PACKAGE_DIRECTORY[-1] if _PACKAGE_DIRECTORY else Path(os.environ["NUMBA_CACHE_DIR"]) / "traced"
    partial = directory / f"{name}.{secrets.token_hex(8)}"
    try:
        directory.mkdir(mode=0o755 if _PACKAGE_DIRECTORY else 0o700, parents=True, exist_ok=True)
        partial.write_bytes(content + hashlib.sha256(content).digest())
        partial.replace(directory / name)
    except OSError:
        with contextlib.suppress(OSError):
            partial.unlink()
