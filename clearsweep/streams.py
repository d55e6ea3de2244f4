"""Standard streams that may be closed, full or abandoned by their reader: a run continues without them."""

import errno
import os
import sys
from io import BufferedWriter, FileIO, TextIOWrapper
from typing import Any

STANDARD = (0, 1, 2)
READER_GONE = (errno.EPIPE, errno.EIO)  # the reader, as `head`, has what it wanted; the terminal is gone


def survive_closed_streams() -> None:
    """Make stdout and stderr accept all writes, which are lost if a stream is closed; replace closed streams.

    A file opened later would else get the number of a closed stream and be written to as if it were the terminal.
    """
    for number in STANDARD:
        try:
            os.fstat(number)
        except OSError:
            null = os.open(os.devnull, os.O_RDWR)  # it gets the lowest free number, this one
            os.set_inheritable(null, True)  # noqa: FBT003 - it has no name
    for number, name in enumerate(("stdout", "stderr"), 1):
        stream = getattr(sys, name)
        if stream is getattr(sys, f"__{name}__"):  # else somebody who calls us put another in its place
            setattr(sys, name, _resilient(number, stream))


def _resilient(number: int, stream: TextIOWrapper | None) -> TextIOWrapper:
    """Return a stream that replaces `stream`, which is None if it was closed."""
    return TextIOWrapper(
        BufferedWriter(_ResilientFile(number, "w", closefd=False)),
        stream.encoding if stream else "utf-8",
        "replace",  # a terminal that lacks a sign gets a question mark, not a traceback
        line_buffering=stream is not None and (stream.line_buffering or stream.write_through),
    )


class _ResilientFile(FileIO):
    """A file that is exchanged for the null device when it cannot be written."""

    def write(self, content: Any, /) -> int:
        """Write bytes as far as possible and return the number of bytes handled."""
        try:
            return super().write(content)
        except OSError as error:
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, self.fileno())
            os.close(null)
            if self.fileno() == 1 and error.errno not in READER_GONE:
                print(f"stdout: cannot be written ({error.strerror}); what is printed there is lost", file=sys.stderr)
            return len(content)
