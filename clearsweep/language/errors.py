"""The errors clearsweep raises: one root, each also a builtin, each with the exit code of the command line.

Also formats values in messages and suggests the intended word.
"""

import contextlib
import errno
from collections.abc import Callable, Iterable, Iterator
from difflib import get_close_matches
from typing import Any
from unicodedata import category

MAX_BITS = 4096  # of a quoted whole number
MAX_LINE = 200  # longest quoted message of another library


class ClearsweepError(Exception):
    """Root of every error that clearsweep raises on purpose; the command line returns its `exit_code`."""

    exit_code = 1


class InputError(ClearsweepError, ValueError):
    """A grid, case or argument that cannot be used; `problems` contains one sentence per mistake found."""

    exit_code = 2

    def __init__(self, *problems: str):
        super().__init__("\n".join(problems))
        self.problems = problems


class DirectoryError(ClearsweepError, FileExistsError):
    """A run directory that cannot be used: of another grid, locked by another run, or not writable."""

    exit_code = 2


class DamagedError(DirectoryError):
    """A file of a run that differs from what was written; the message says how to restore it."""


class StorageError(ClearsweepError, OSError):
    """Writing results failed during a run; results committed before are unharmed."""

    exit_code = 4


class SchedulerLostError(ClearsweepError, ConnectionError):
    """The scheduler of a cluster no longer answers; results committed before are unharmed."""

    exit_code = 4


def mistake_of(read: Callable[..., Any], *arguments: Any) -> str:
    """Return the message of the InputError that a call raises, or ''."""
    try:
        read(*arguments)
    except InputError as error:
        return str(error)
    return ""


def error_line(error: BaseException) -> str:
    """Return an error as one line of at most MAX_LINE characters after its type."""
    first_line = (str(error).strip().splitlines() or [""])[0]
    text = first_line if len(first_line) <= MAX_LINE else first_line[:MAX_LINE] + "..."
    return f"{type(error).__name__}: {text}"


def escape_control_characters(text: str) -> str:
    """Return text with control characters such as `\\x1b` escaped; line ends are kept."""
    return "".join(
        char if char == "\n" or category(char) not in _INVISIBLE_CATEGORIES else char.encode("unicode_escape").decode()
        for char in text
    )


_INVISIBLE_CATEGORIES = ("Cc", "Cf", "Zl", "Zp")


def did_you_mean(word: str, names: Iterable[str]) -> str:
    """Return `; did you mean 'hertz'?` for the known word nearest to `word`, or ''."""
    matches = nearest_words(word, names)
    return f"; did you mean '{matches[0]}'?" if matches else ""


#: Names of other programs for a word of ours, which an error suggests.
OTHER_NAMES = {
    **dict.fromkeys(("pin", "hinge", "journal", "bearing", "rotational"), "revolute"),
    **dict.fromkeys(("guide", "slider", "translational", "sliding"), "prismatic"),
    **dict.fromkeys(("slotted", "pin-in-slot"), "slot"),
    **dict.fromkeys(("rpm", "omega", "angular_velocity"), "speed"),
}


def nearest_words(word: str, names: Iterable[str]) -> list[str]:
    """Return a list with the known word nearest to `word`, or [] if none is near."""
    names = list(names)
    equal_ignoring_case = [name for name in names if name.lower() == word.lower()]
    same_words = [name for name in names if _sorted_words(name) == _sorted_words(word)]
    matches = equal_ignoring_case or same_words or [name for name in names if name == OTHER_NAMES.get(word.lower())]
    if not matches and "_" in word:  # 'force_peak' of a joint; 'rod_slider_period', which the machine has
        has_joint = word.count("_") > 1
        matches = [name for name in names if name.endswith(f"_{word}") or (has_joint and word.endswith(f"_{name}"))]
    return (matches or get_close_matches(word, names, 1, 0.7))[:1]


def _sorted_words(name: str) -> list[str]:
    """Return the words of a name in a fixed order: 'peak_load' has those of 'load_peak'."""
    return sorted(name.lower().replace("-", "_").split("_"))


def similar_words(word: str, names: Iterable[str]) -> list[str]:
    """Return the known words that contain `word`, or else the most similar ones; [] if there are none."""
    names = list(names)
    containing = [name for name in names if word and word.lower() in name.lower()]
    return containing or get_close_matches(word, names, 3, 0.6)


def quoted(value: object) -> str:
    """Return a value as a message cites it: at most 60 characters, text in quotes."""
    if isinstance(value, (dict, list)):
        return "a section" if isinstance(value, dict) else "a list"
    constant_texts = {True: "true", False: "false", None: "nothing"}
    if isinstance(value, int) and value.bit_length() > MAX_BITS:
        return "a whole number of thousands of digits"  # Python refuses to print it
    text = constant_texts[value] if value is None or isinstance(value, bool) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


@contextlib.contextmanager
def convert_write_errors() -> Iterator[None]:
    """Convert an OSError for a path that the user chose into an InputError."""
    try:
        yield
    except ClearsweepError:
        raise
    except OSError as error:
        advice = "make room or " if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG) else ""
        raise InputError(
            f"{error.filename or 'a file'}: cannot be written ({error.strerror or error}); {advice}choose another place"
        ) from error
