"""The program `clearsweep`; `python -m clearsweep` is the same."""

import atexit
import contextlib
import os
import signal
import sys

from . import cli, exit_codes
from .sweeping.pool import system


def main() -> None:
    """Run the command line and end the process with its exit code, even if interpreter shutdown fails."""
    codes: list[int] = []
    # The function registered first is called last.  After it the interpreter would shut down, where a thread of any
    # library can still abort the process.
    atexit.register(_leave, codes)
    system.end_with_run()
    os.environ.pop("SOURCE_DATE_EPOCH", None)  # no result has a date, and scipy cannot be imported if it is no number
    system.make_start_cheap()
    try:
        cli.main()
    except SystemExit as outcome:
        codes.append(int(outcome.code or 0))
    except KeyboardInterrupt:  # between the last word and here
        codes.append(exit_codes.INTERRUPTED)
    for signum in system.SIGNALS:
        signal.signal(signum, signal.SIG_IGN)
    sys.exit(codes[0])


def _leave(codes: list[int]) -> None:
    """End the process at once if its exit code is decided; a forked child, with an empty list, ends as usual."""
    if codes:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError, AttributeError):  # closed, full or None
                stream.flush()
        os._exit(codes[0])


if __name__ == "__main__":
    main()
