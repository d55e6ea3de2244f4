"""How a command ends: an exception becomes a message and an exit code; standard streams may be closed, full or gone."""

import errno
import os
import sys
import traceback
from io import BufferedWriter, FileIO, TextIOWrapper
from typing import Any

import click

from .language.errors import ClearsweepError, escape_control_characters
from .sweeping.pool import system

INTERNAL, BAD_INPUT, LIMITS, INTERRUPTED = 1, 2, 5, 130


def run(command: click.Command, arguments: list[str] | None) -> int:
    """Run a command and return its exit code; print a message about its failure on stderr."""
    try:
        return int(command.main(arguments, prog_name="clearsweep", standalone_mode=False) or 0)
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()
        return 0
    except click.ClickException as error:
        error.show()
        return BAD_INPUT
    except click.Abort as error:
        return _report_interruption(error.__cause__)
    except KeyboardInterrupt as error:
        return _report_interruption(error)
    except ClearsweepError as error:
        print(escape_control_characters(str(error)), file=sys.stderr)
        return error.exit_code
    except Exception as error:
        if sentence := system.remedy_text(error):
            print(escape_control_characters(sentence), file=sys.stderr)
            return BAD_INPUT
        traceback.print_exc()
        print("internal error: this is a bug in clearsweep; please report it with the lines above", file=sys.stderr)
        return INTERNAL


def _report_interruption(error: BaseException | None) -> int:
    """Print why the command was interrupted and return the exit code of that signal."""
    print(str(error or "") or "stopped", file=sys.stderr)
    return int(getattr(error, "exit_code", INTERRUPTED))


# ---------------------------------------------------------------------------------------------- streams


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
