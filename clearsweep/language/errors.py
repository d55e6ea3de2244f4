"""The errors clearsweep raises: one root, each also a builtin, each with the exit code of the command line.

How their messages show values and guess what was meant is here, too.
"""

import contextlib
import errno
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from unicodedata import category

LONGEST_LINE = 200  # characters of a message that others wrote


class ClearsweepError(Exception):
    """Root of every error that clearsweep raises on purpose; `exit_code` is what the command line returns."""

    exit_code = 1


class InputError(ClearsweepError, ValueError):
    """A grid, case or argument that cannot be used; `problems` contains one sentence per mistake found."""

    exit_code = 2

    def __init__(self, *problems: str):
        super().__init__("\n".join(problems))
        self.problems = problems


class DirectoryError(ClearsweepError, FileExistsError):
    """A run directory that does not fit: of another grid, locked by another run, or not writable at the start."""

    exit_code = 2


class DamagedError(DirectoryError):
    """A file of a run that is not what was written; the message says what restores it."""


class StorageError(ClearsweepError, OSError):
    """Writing results failed while a run was under way; what was committed before is unharmed."""

    exit_code = 4


class SchedulerLostError(ClearsweepError, ConnectionError):
    """The scheduler of a cluster does not answer any more; what was committed before is unharmed."""

    exit_code = 4


def brief(error: BaseException) -> str:
    """Return what an error says as one short line, its kind first."""
    first = (str(error).strip().splitlines() or [""])[0]
    return f"{type(error).__name__}: {first if len(first) <= LONGEST_LINE else first[:LONGEST_LINE] + '...'}"


def printable(text: str) -> str:
    """Return text without what a terminal would obey or hide: such characters as `\\x1b`, line ends kept."""
    return "".join(
        char if char == "\n" or category(char) not in _UNSEEN else char.encode("unicode_escape").decode()
        for char in text
    )


_UNSEEN = ("Cc", "Cf", "Zl", "Zp")


def nearest(word: str, known: Iterable[str]) -> str:
    """Return `; did you mean 'hertz'?` for the known word most like `word`, or nothing."""
    known = list(known)
    same = [other for other in known if other.lower() == word.lower()]
    near = same or get_close_matches(word, known, 1, 0.7)
    return f"; did you mean '{near[0]}'?" if near else ""


def likely(word: str, known: Iterable[str]) -> list[str]:
    """Return the known words of which `word` is a part, or else those most like it, or [] if none is."""
    known = list(known)
    parts = [other for other in known if word and word.lower() in other.lower()]
    return parts or get_close_matches(word, known, 3, 0.6)


def shown(value: object) -> str:
    """Return a value as a message shows it: short, text in quotes."""
    if isinstance(value, (dict, list)):
        return "a section" if isinstance(value, dict) else "a list"
    words = {True: "true", False: "false", None: "nothing"}
    text = words[value] if value is None or isinstance(value, bool) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


@contextlib.contextmanager
def writing() -> Iterator[None]:
    """Turn the refusal of a place where a file was to be written into an InputError: it is the user's to choose."""
    try:
        yield
    except ClearsweepError:
        raise
    except OSError as error:
        advice = "make room or " if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) else ""
        raise InputError(
            f"{error.filename or 'a file'}: cannot be written ({error.strerror or error}); {advice}choose another place"
        ) from error
