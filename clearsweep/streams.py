"""Standard streams that may be closed, full or abandoned by their reader: a run continues without them."""

import errno
import os
import sys
from io import BufferedWriter, FileIO, TextIOWrapper
from typing import Any

STANDARD_DESCRIPTORS = (0, 1, 2)  # of stdin, stdout, stderr
READER_GONE_ERRORS = (errno.EPIPE, errno.EIO)  # the reader, such as `head`, or the terminal has closed the stream


def survive_closed_streams() -> None:
    """Make stdout and stderr accept all writes, which are lost if a stream is closed; replace closed streams.

    A file opened later would else get the number of a closed stream and be written to as if it were the terminal.
    """
    for descriptor in STANDARD_DESCRIPTORS:
        try:
            os.fstat(descriptor)
        except OSError:
            null_descriptor = os.open(os.devnull, os.O_RDWR)  # it gets the lowest free number, this one
            os.set_inheritable(null_descriptor, True)  # noqa: FBT003 - it has no name
    for descriptor, name in enumerate(("stdout", "stderr"), 1):
        stream = getattr(sys, name)
        if stream is getattr(sys, f"__{name}__"):  # otherwise the calling program has replaced it
            setattr(sys, name, _resilient_stream(descriptor, stream))


def _resilient_stream(descriptor: int, stream: TextIOWrapper | None) -> TextIOWrapper:
    """Return a stream that replaces `stream`, which is None if it was closed."""
    return TextIOWrapper(
        BufferedWriter(_ResilientFile(descriptor, "w", closefd=False)),
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
            null_descriptor = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null_descriptor, self.fileno())
            os.close(null_descriptor)
            if self.fileno() == 1 and error.errno not in READER_GONE_ERRORS:
                print(f"stdout: cannot be written ({error.strerror}); what is printed there is lost", file=sys.stderr)
            return len(content)
