"""What tortures clearsweep finds what it looks for; a few mutated grids are read every day."""

import contextlib
import random
import time
from pathlib import Path
from unittest import mock

import pytest
import reliability
import torture_attempts
import torture_flips
import torture_grids
from torture_attempts import Result, TrialStep
from torture_grids import Ended, drawn

from clearsweep import grid, simulation
from clearsweep.language.errors import DirectoryError, InputError
from clearsweep.sweeping.pool.case_runner import SIMULATION

pytestmark = pytest.mark.heavy


@pytest.mark.few("10")
@pytest.mark.parametrize("count", [10, 100])
def test_mutated_grids_are_read_or_refused(tmp_path, count):
    contents, read, catalogue = drawn(count, seed=2), 0, simulation.catalogue()
    assert contents == drawn(count, seed=2)
    for content in contents:
        (tmp_path / "grid.yaml").write_bytes(content)
        with contextlib.suppress(InputError):
            result = grid.load(tmp_path / "grid.yaml", catalogue)
            result.case_id(len(result) - 1)
            read += 1
    assert 0.1 * count < read < 0.9 * count


class Bad:
    """Mechanics of which a grid goes wrong in the way that is named."""

    def __init__(self, way):
        """Take the way."""
        self.way = way

    def __getattr__(self, name):
        return getattr(SIMULATION, name)

    def catalogue(self):
        """Go wrong."""
        if self.way == "hangs":
            time.sleep(60.0)
        if self.way == "writes":
            Path("../stranger").write_text("")
        if self.way == "breaks":
            raise ZeroDivisionError("bug")
        return SIMULATION.catalogue()


@pytest.mark.parametrize(
    ("way", "fault"),
    [
        ("hangs", "did not end in time"),
        ("writes", "wrote outside its directory"),
        ("breaks", "traceback"),
        ("refuses", ""),
    ],
)
@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_a_grid_that_goes_wrong_is_at_fault(tmp_path, monkeypatch, way, fault):
    monkeypatch.setattr(torture_grids, "SECONDS", 1.0 if way == "hangs" else 20.0)
    assert torture_grids.run(b"name: x\n", tmp_path / "grid", Bad(way)).fault == fault


def test_an_exit_code_that_no_grid_may_have_is_a_fault():
    assert [Ended(code, 0.1, "").fault for code in (0, 2, 3)] == ["", "", ""]
    assert Ended(4, 0.1, "").fault == "exit code 4"


def test_a_file_that_is_read_as_something_else_is_not_named_but_silent(tmp_path, monkeypatch):
    (tmp_path / "file").write_bytes(b"abc")
    torture_flips.flip(tmp_path / "file", random.Random(1))
    changed = (tmp_path / "file").read_bytes()
    assert sum((first ^ other).bit_count() for first, other in zip(b"abc", changed, strict=True)) == 1

    monkeypatch.setattr(torture_flips, "command", lambda *_: (0, "fine"))
    outcomes = []
    for read in ("other", "written", DirectoryError("file: damaged"), DirectoryError("nothing"), KeyError("bug")):
        reader = mock.Mock(side_effect=[read])
        monkeypatch.setattr(torture_flips, "content", reader)
        outcomes.append(torture_flips.outcome(tmp_path, tmp_path / "file", "written"))
    assert outcomes == ["silent", "without meaning", "named", "unnamed", "traceback"]


@pytest.mark.parametrize(
    ("code", "text", "fault"),
    [
        (2, "no such thing", ""),
        (0, "no such thing", "exit code 0"),
        (2, "nothing", "did not say 'no such thing'"),
        (2, "no such thing\n  Traceback (most", "said 'Traceback'"),
        (2, "no such thing \x1b[31m", "said '\\x1b'"),
        (None, "", "did not end in time"),
    ],
)
def test_an_attempt_that_ends_otherwise_than_it_has_to_falls_short(code, text, fault):
    assert Result(TrialStep("name", "true", (2,), "no such thing"), code, 0.1, text).fault == fault


def test_names_of_attempts_differ_and_the_page_keeps_what_is_not_measured(monkeypatch, tmp_path):
    names = [attempt.name for attempt in torture_attempts.ATTEMPTS]
    assert len(set(names)) == len(names) > 40
    monkeypatch.setattr(reliability, "PAGE", tmp_path / "page.md")
    reliability.PAGE.write_text(f"Prose\n\n{reliability.MARK}\n### One\n\nold\n\n### Other\n\nkept\n\ntable\n")
    written = reliability.page("command", {"One": ("text", "table")})
    assert written.startswith(f"Prose\n\n{reliability.MARK}\n### One\n\ntext\n\ntable\n\n`command`, ")
    assert written.endswith(".\n\n### Other\n\nkept\n\ntable\n")
