"""Files that are there whole or not at all: temporary name, fsync, rename, fsync of the directory."""

import contextlib
import hashlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from ..errors import StorageError


def write(path: Path, content: bytes, scratch: Path) -> None:
    """Write a file so that after any crash it is there whole or not at all; `scratch` is on the same file system."""
    temporary = scratch / f"{path.name}.{os.getpid()}"
    with storing(path):
        with open(temporary, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        publish(temporary, path)


def publish(temporary: Path, path: Path) -> None:
    """Rename a finished, synced file into place and make the rename last."""
    os.replace(temporary, path)
    handle = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def duplicate(source: Path, path: Path, scratch: Path) -> None:
    """Make a finished file appear at `path`, too, linked where the file system can, else copied; not yet synced."""
    with storing(path):
        temporary = scratch / path.name
        temporary.unlink(missing_ok=True)
        try:
            os.link(source, temporary)
        except OSError:
            shutil.copyfile(source, temporary)
            sync(temporary)
        os.replace(temporary, path)


def sync(path: Path) -> None:
    """Bring what was written to a file, or the names in a directory, onto the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def checksum(path: Path) -> str:
    """Return the SHA-256 of a file in hexadecimal."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Turn an operating system's refusal while writing `path` into a StorageError that says what is safe."""
    try:
        yield
    except StorageError:
        raise
    except (OSError, RuntimeError) as error:  # h5py reports a failed flush as RuntimeError
        number = getattr(error, "errno", None)
        reason = os.strerror(number) if number else str(error)
        raise StorageError(
            f"{path}: writing failed ({reason}); what was committed before is unharmed: "
            "make room and run the same command again"
        ) from error
