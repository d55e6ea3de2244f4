"""Exit codes of the command line: an exception of a command becomes a message and a code."""

import sys
import traceback

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
