"""Durable files: only regular files are opened, and writes are atomic.

A file is written under an unpredictable name, synced, renamed, and its directory synced.  A link, a pipe,
a device or a directory in place of a file is refused: it is not followed, waited for or replaced.  Neither is a link in
place of a folder of a run, nor a file of the user in place of a page, a picture or a table.
"""

import contextlib
import hashlib
import os
import re
import secrets
import shutil
import stat
from collections.abc import Iterator
from io import BufferedReader, FileIO
from pathlib import Path

from ..language.errors import ClearsweepError, DirectoryError, StorageError

_KINDS = {
    stat.S_IFLNK: "a link",
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
# Names of files that a killed run leaves.
TEMPORARY = re.compile(r"\.clearsweep-([0-9a-f]{16}\.(?:part|note|work|stop)|stop|run\.work)")
PROGRESS = re.compile(r"\.clearsweep-([0-9a-f]{16})\.work")  # of a batch
LIFE_LOG = re.compile(r"\.clearsweep-([0-9a-f]{16})\.life")  # kept until its case, which resumes from it, is committed
_OWN_MARK = b"clearsweep"  # in the first or last MARKED bytes of a page or picture, after one of _OWN_STARTS
_OWN_STARTS = (b"<!doctype html", b"<?xml", b"<svg", b"<!-- drawn by", b"\x89PNG", b"%PDF", b"GIF8", b"RIFF")
_MARKED = 4096  # bytes
SET_ASIDE = re.compile(r"([0-9a-f]{16}-[0-9a-f]{16}\.(?:h5|parquet))\.damaged")


def check_regular(path: Path) -> None:
    """Raise DirectoryError if this name exists but is not a regular file."""
    with contextlib.suppress(FileNotFoundError):
        kind = stat.S_IFMT(os.lstat(path).st_mode)
        if kind != stat.S_IFREG:
            raise DirectoryError(
                f"{path}: is {_KINDS.get(kind, 'something else')}, not a file; move it away or choose another place"
            )


def make_folder(path: Path) -> None:
    """Create a folder if it is missing; raise DirectoryError if a link or a file has its name."""
    with contextlib.suppress(FileExistsError):
        os.mkdir(path)
    check_folder(path)


def check_folder(path: Path) -> None:
    """Raise DirectoryError if a link or a file has the name of a folder."""
    kind = stat.S_IFMT(os.lstat(path).st_mode)
    if kind != stat.S_IFDIR:
        raise DirectoryError(
            f"{path}: is {_KINDS.get(kind, 'a file')}, not a folder; move it away or choose another place with --out"
        )


def open_regular(path: Path) -> BufferedReader:
    """Return a regular file opened for reading; DirectoryError for anything else, FileNotFoundError if missing."""
    with _reading(path):
        return open(path, "rb", opener=lambda *_: _open_handle(path, os.O_RDONLY))  # so that it has its name


def open_lock(path: Path) -> FileIO:
    """Return a regular file opened for reading and writing; create it if it is missing."""
    return os.fdopen(_open_handle(path, os.O_RDWR | os.O_CREAT), "r+b", buffering=0)


def _open_handle(path: Path, flags: int) -> int:
    check_regular(path)  # before opening, since opening a device may have effects
    handle = os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o666)
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise DirectoryError(f"{path}: is not a file; move it away or choose another place")
    return handle


def read(path: Path) -> bytes:
    """Return the content of a regular file; raise DirectoryError for anything else."""
    with _reading(path), open_regular(path) as file:
        return file.read()


def read_span(file: BufferedReader, offset: int, size: int) -> bytes:
    """Return exactly `size` bytes of a file from `offset` on; raise EOFError if it is shorter.

    One call of the system may return less: over a network, after a signal, and beyond 2 GiB.
    """
    content = os.pread(file.fileno(), size, offset)
    while 0 < len(content) < size:
        part = os.pread(file.fileno(), size - len(content), offset + len(content))
        if not part:
            break
        content += part
    if len(content) < size:
        raise EOFError(f"it ends {size - len(content):,} bytes early")
    return content


def checksum(path: Path) -> str:
    """Return the SHA-256 of a regular file in hexadecimal."""
    with _reading(path), open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextlib.contextmanager
def _reading(path: Path) -> Iterator[None]:
    try:
        yield
    except (ClearsweepError, FileNotFoundError, NotADirectoryError):
        raise
    except OSError as error:
        raise unreadable_error(path, error) from error


def unreadable_error(path: Path, error: OSError) -> DirectoryError:
    """Return the error for a file that the system does not let this user read; it need not be damaged."""
    return DirectoryError(f"{path}: cannot be read ({error.strerror or error}); make it readable or move it away")


def create_file(path: Path) -> int:
    """Return the descriptor of a new file opened for writing; raise FileExistsError if the name exists."""
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)


def scratch_file(folder: Path, name: str) -> Path:
    """Return the path of a temporary file of a run; its name marks it as such."""
    return folder / f".clearsweep-{name}"


def find(folder: Path, names: re.Pattern[str]) -> dict[str, Path]:
    """Return the files in a folder whose names match TEMPORARY, PROGRESS, LIFE_LOG or SET_ASIDE, by their group."""
    matches = ((name, names.fullmatch(name)) for name in _names_in(folder))
    return {match.group(1): folder / name for name, match in matches if match}


def _names_in(folder: Path) -> list[str]:
    return sorted(os.listdir(folder)) if folder.is_dir() else []


def overwrite_temporary(path: Path, content: bytes) -> None:
    """Write a temporary file, creating it if missing; a concurrent reader may see a part of it."""
    with os.fdopen(_open_handle(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), "wb") as file:
        file.write(content)


@contextlib.contextmanager
def atomic_file(path: Path, scratch: Path | None = None) -> Iterator[Path]:
    """Yield the name under which to create and sync a file; at the end it replaces `path`.

    The name is in `scratch`, the folder of a run for temporary files, or else next to `path`.  The exchange is on the
    disk only after a `sync` of the directory.
    """
    temporary = scratch_file(scratch or path.parent, f"{secrets.token_hex(8)}.part")
    try:
        with _folder_of(path, scratch) as folder:
            check_regular(path)
            yield temporary
            os.replace(temporary, path.name, dst_dir_fd=folder)
    except OSError as error:
        if error.errno:  # system errors of a refused write name no file, or the temporary one
            error.filename = os.fspath(path)
        raise
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def _folder_of(path: Path, scratch: Path | None) -> Iterator[int]:
    """Yield the descriptor of the folder of a file, with which a name in it stays in it.

    A run may be worked at where the user's link leads, but its own folders, `scratch` among them, are no links: someone
    may have put one there while the run works.
    """
    own = [folder for folder in (scratch, path.parent) if folder != scratch.parent] if scratch else []
    for folder in own:
        check_folder(folder)
    handle = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC | (os.O_NOFOLLOW if own[1:] else 0))
    try:
        yield handle
    finally:
        os.close(handle)


def replace(path: Path, content: bytes, scratch: Path | None = None) -> None:
    """Write a file of a run atomically: after a crash `path` has the old or the new content."""
    with atomic_file(path, scratch) as temporary, os.fdopen(create_file(temporary), "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    sync(path.parent)


def replace_output(path: Path, content: bytes, start: bytes = b"") -> None:
    """Write a file where the user wants it, atomically; DirectoryError if `check_output` refuses."""
    check_output(path, start)
    replace(path, content)


def check_output(path: Path, start: bytes = b"") -> None:
    """Raise DirectoryError if `path` is something else than a file that clearsweep wrote, or an empty one.

    Pages and pictures have a mark; tables have none, but begin with `start`, the names of their columns.
    """
    check_regular(path)
    with contextlib.suppress(FileNotFoundError), open_regular(path) as file:
        head = file.read(_MARKED)
        file.seek(max(0, os.fstat(file.fileno()).st_size - _MARKED))
        is_marked = head.startswith(_OWN_STARTS) and _OWN_MARK in head + file.read(_MARKED)
        if head and not is_marked and not (start and head.startswith(start)):
            reason = "exists with other columns" if start else "exists, and clearsweep did not write it"
            raise DirectoryError(f"{path}: {reason}; move it away, or choose another name")


def link_or_copy(source: Path, path: Path, scratch: Path) -> None:
    """Link a finished file to `path`, or copy it if the file system cannot link; not yet synced."""
    with atomic_file(path, scratch) as temporary:
        try:
            os.link(source, temporary, follow_symlinks=False)
        except OSError:
            with open_regular(source) as original, os.fdopen(create_file(temporary), "wb") as file:
                shutil.copyfileobj(original, file)
            sync(temporary)


def discard(path: Path) -> None:
    """Remove a regular file; leave anything else."""
    with contextlib.suppress(FileNotFoundError):
        if stat.S_ISREG(os.lstat(path).st_mode):
            os.unlink(path)


def set_aside(path: Path) -> None:
    """Rename a damaged file, so that it is no longer used."""
    aside = path.with_name(f"{path.name}.damaged")
    check_regular(aside)
    os.replace(path, aside)


def remove_temporaries(folder: Path, *, remove_folder: bool = False) -> None:
    """Remove the temporary files of runs in a folder; `remove_folder`: also the folder, if it is then empty."""
    with contextlib.suppress(OSError):
        for path in find(folder, TEMPORARY).values():
            discard(path)
        if remove_folder:
            os.rmdir(folder)


def check_writable(folder: Path) -> None:
    """Raise OSError if no file can be written in a folder for temporary files."""
    probe = scratch_file(folder, f"{secrets.token_hex(8)}.part")
    with os.fdopen(create_file(probe), "wb") as file:
        file.write(b"x")
    discard(probe)


def find_foreign_names(folder: Path) -> list[str]:
    """Return the names in a folder for temporary files that are not from runs."""
    return [name for name in _names_in(folder) if not TEMPORARY.fullmatch(name) and not LIFE_LOG.fullmatch(name)]


def sync(path: Path) -> None:
    """Flush a file, or the names in a directory, to disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Convert an OSError while writing `path` into a StorageError that says which results are safe."""
    try:
        yield
    except ClearsweepError:
        raise
    except (OSError, RuntimeError) as error:  # h5py reports a failed flush as RuntimeError
        raise refused_write_error(path, error) from error


def damaged_error(path: Path, reason: str = "") -> StorageError:
    """Return the message for a batch file that was changed after the commit."""
    return StorageError(
        f"{path}: was damaged or removed while this run worked here{f' ({reason})' if reason else ''}; run the same "
        "command again, which runs its cases again"
    )


def refused_write_error(path: Path, error: OSError | RuntimeError) -> StorageError:
    """Return the message for a refused write to `path`."""
    number = getattr(error, "errno", None)
    if isinstance(error, FileNotFoundError) or (isinstance(error, OSError) and not number):  # while reading
        return StorageError(
            f"{path}: cannot be merged ({error}): a file of a batch was damaged or removed meanwhile; run the "
            "same command again, which runs its cases again"
        )
    reason = os.strerror(number) if number else str(error)
    return StorageError(
        f"{path}: writing failed ({reason}); finished cases are safe: make room and run the same command again"
    )
