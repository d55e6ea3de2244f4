"""What is wrong gets the messages that `wrong_grids.txt` shows below it, all of them and no other.

A section of the page begins with `==`, the name and the text of a right grid.  Each paragraph below it changes this
text (lines `-` become the lines `+`; `&` is between two places), or values of its dict (`path: value`; `~ path` removes
one), may write lines of a file (`| cases.csv: line`), and ends with a line `>` per message.  What is changed as a dict
has no lines, so its messages have no place.  A line `$` is a command that is run where the grid is and refuses it;
without one the grid is read.  `python tests/test_wrong_grids.py` writes the messages anew: read what they have become.
"""

import contextlib
import io
import os
import re
import shlex
import signal
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import pytest
from right_grids import PAGE, READER

from clearsweep import exit_codes, grid, simulation
from clearsweep.cli import verbs
from clearsweep.grid.written import law_execution
from clearsweep.language.errors import InputError

DIGEST = re.compile(r" \([0-9a-f]{8}\)")  # of a law file, which depends on its folder


class Wrong(NamedTuple):
    """The text of a right grid, the lines that change it, and the messages that follow."""

    text: str
    changes: list[str]
    messages: list[str]

    def lines(self, mark):
        """Return what is written behind a mark, line by line."""
        return [line[2:] for line in self.changes if line.startswith(f"{mark} ")]

    def source(self):
        """Return the grid: a dict, or the name of a file that is written into this folder next to its tables."""
        for line in self.lines("|"):
            name, _, content = line.partition(":")
            with open(name, "a", encoding="utf-8") as file:
                file.write(f"{content.removeprefix(' ')}\n")
        values = [line for line in self.changes if line[0] not in "-+&|~$"]
        if values or self.lines("~"):
            return self.changed_dict(READER.load("\n".join(values)) or {}, self.lines("~"))
        Path("grid.yaml").write_text(self.changed_text(), encoding="utf-8")
        return "grid.yaml"

    def changed_dict(self, values, removed):
        """Return the grid as a dict with these values at dotted paths and without the removed ones."""
        source = READER.load(self.text)
        for path in [*values, *removed]:
            *parents, last = path.split(".")
            section = source
            for key in parents:
                section = section.setdefault(key, {})
            if path in values:
                section[last] = values[path]
            else:
                del section[last]
        return source

    def changed_text(self):
        """Return the text with the lines `+` in the place of the lines `-`, or at its end if there are none."""
        text, old, new = self.text, "", ""
        for line in [*self.changes, "&"]:
            if line[0] == "-":
                old += f"{line[1:]}\n"
            elif line[0] == "+":
                new += f"{line[1:]}\n"
            elif line == "&":
                assert not old or text.count(old) == 1, f"{old} is not once in the text"
                text, old, new = text.replace(old, new) if old else text + new, "", ""
        return text

    def answer(self):
        """Return the messages about this grid, or of the command, which writes nothing else; law files are trusted."""
        source, commands = self.source(), self.lines("$")
        files, settings = sorted(os.listdir()), settings_of_python()
        with contextlib.redirect_stderr(io.StringIO()) as errors, contextlib.redirect_stdout(io.StringIO()) as printed:
            if commands:
                assert exit_codes.run(verbs, shlex.split(commands[0])) == exit_codes.BAD_INPUT
                messages = [line for line in errors.getvalue().splitlines() if line]
            else:
                with grid.allowing("own-folder"), pytest.raises(InputError) as refusal:
                    grid.load(source, simulation.catalogue())
                messages = list(refusal.value.problems)
        assert not printed.getvalue()
        assert (files, settings) == (sorted(os.listdir()), settings_of_python())
        return [DIGEST.sub("", message.replace(f"{os.getcwd()}/", "")) for message in messages]


def settings_of_python():
    """Return what a law file might change of this process."""
    return len, os._exit, os.getcwd(), list(sys.path), signal.getsignal(signal.SIGALRM)


def read_page():
    """Return what is wrong on the page."""
    wrong, text = [], ""
    for paragraph in PAGE.read_text(encoding="utf-8").strip().split("\n\n"):
        lines = paragraph.splitlines()
        if lines[0].startswith("== "):
            text = "".join(f"{line}\n" for line in lines[1:])
        else:
            messages = [line[2:] for line in lines if line.startswith("> ")]
            wrong.append(Wrong(text, lines[: len(lines) - len(messages)], messages))
    return wrong


@pytest.mark.parametrize("wrong", read_page(), ids=lambda wrong: wrong.messages[0][:70])
def test_a_wrong_grid_gets_the_messages_of_the_page(wrong, tmp_path, monkeypatch, recwarn):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(law_execution, "RECORDS", {})
    assert wrong.answer() == wrong.messages
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]


def write_page():
    """Write the page with the messages of today."""
    paragraphs, wrong = PAGE.read_text(encoding="utf-8").strip().split("\n\n"), iter(read_page())
    for k, paragraph in enumerate(paragraphs):
        if not paragraph.startswith("== "):
            case = next(wrong)
            with tempfile.TemporaryDirectory() as folder:
                os.chdir(folder)
                paragraphs[k] = "\n".join([*case.changes, *(f"> {message}" for message in case.answer())])
    PAGE.write_text("\n\n".join(paragraphs) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write_page()
