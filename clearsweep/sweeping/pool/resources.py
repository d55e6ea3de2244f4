"""Limits of the operating system: too low ones are refused at once, with the limit and the remedy."""

import errno
import gc
import os
import resource

from ...language.errors import InputError

MIN_ADDRESS_SPACE = 1_000_000_000  # bytes of address space for loading the modules of a run and compiling a scene
ADVISED_ADDRESS_SPACE = 4_000_000  # kB, as for `ulimit -v`; the advised limit
ADVISED_FILES = 256  # least advised number of open files
THREAD_VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)  # environment variables with the number of threads of libraries, which read them when they are loaded


_USUAL_THRESHOLDS = gc.get_threshold()
_OBJECTS_OF_IMPORTS = 500_000  # that stay: the garbage collector would look through them again and again


def make_start_cheap() -> None:
    """Prepare this process, which ends with its command, for loading libraries.

    They use one thread, unless the user set their number: a process with several cannot be forked, see `forks`.
    """
    gc.set_threshold(_OBJECTS_OF_IMPORTS, *_USUAL_THRESHOLDS[1:])
    for name in THREAD_VARIABLES:
        os.environ.setdefault(name, "1")


def collect_as_usual() -> None:
    """Collect garbage as Python does by default, but for the objects that there are now."""
    gc.freeze()
    gc.set_threshold(*_USUAL_THRESHOLDS)


def check_space() -> None:
    """Raise InputError if the address space is too small to load the modules of every verb."""
    space, _ = resource.getrlimit(resource.RLIMIT_AS)
    if space != resource.RLIM_INFINITY and space < MIN_ADDRESS_SPACE:
        raise InputError(
            f"memory: this process may use {space / 1e6:,.0f} MB of address space (ulimit -v), less than the "
            f"{MIN_ADDRESS_SPACE / 1e6:,.0f} MB that clearsweep needs; raise it, for example with `ulimit -v "
            f"{ADVISED_ADDRESS_SPACE}`"
        )


def allow_files(count: int) -> None:
    """Allow this process `count` open files; raise InputError if that is not permitted."""
    soft_limit, hard_limit = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft_limit == resource.RLIM_INFINITY or count <= soft_limit:
        return
    if hard_limit != resource.RLIM_INFINITY and count > hard_limit:
        raise InputError(
            f"open files: this process may have {hard_limit:,} (ulimit -n), fewer than the {count:,} that its workers "
            f"need; raise the limit, such as `ulimit -n {max(ADVISED_FILES, count)}`, or use fewer workers with --jobs"
        )
    resource.setrlimit(resource.RLIMIT_NOFILE, (count, hard_limit))


def remedy_text(error: BaseException) -> str | None:
    """Return a sentence for an error caused by a system limit, or None for any other error."""
    number = getattr(error, "errno", None)
    if isinstance(error, MemoryError) or number == errno.ENOMEM:
        return (
            f"memory: not enough ({str(error) or 'an allocation failed'}); use fewer workers with "
            "--jobs, save fewer histories with `save`, or raise the limit (ulimit -v)"
        )
    if number in (errno.EMFILE, errno.ENFILE):
        return (
            f"open files: this process has reached its limit (ulimit -n); raise it, for example with `ulimit -n "
            f"{ADVISED_FILES}`, or use fewer workers with --jobs"
        )
    if number == errno.ENAMETOOLONG:
        return path_too_long_text(str(getattr(error, "filename", "")))
    return None


def path_too_long_text(name: str) -> str:
    """Return the message for a path that is too long for the file system."""
    return f"{name[:60]}...: File name too long for the file system ({len(name)} characters); choose a shorter one"
