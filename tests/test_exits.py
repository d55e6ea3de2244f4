"""Exit codes: what a library's threads do while the interpreter ends decides nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import torture_exits
from fake_physics import GOOD, grid, sweep
from torture_exits import READS_AHEAD, late_threads

pytestmark = pytest.mark.heavy

HERE = Path(__file__).parent
#: All that reads Parquet files and batches: a sweep of a table, its results in every form, a merge, a second sweep.
READS_ALL = """
import sys
from pathlib import Path
import pyarrow as pa, pyarrow.parquet as pq
from fake_physics import GOOD, grid, merge, sweep
from clearsweep import store
from clearsweep.sweeping.merge import complete_run
place = Path(sys.argv[1])
pq.write_table(pa.table({"mechanism.slider.mass": [1.0, 2.0, 3.0]}), place / "cases.parquet")
source = grid(1, (GOOD,), wear=True)
source = {key: value for key, value in source.items() if key != "sweep"} | {"cases": str(place / "cases.parquet")}
for name in ("one", "one", "two"):
    sweep(source, place / name, executor="serial", show_progress=False)
merge([place / "one", place / "two"], place / "both")
run = store.open(place / "both")
assert len(run.summary) == len(run.column("status")) == len(run.column("mechanism.slider.mass")) == 3
store.status(place / "both", every_file=True)
"""
#: The command line, with such a verb.
VERB_READS_AHEAD = f"""
from clearsweep import __main__, cli
def verb():
    exec({READS_AHEAD!r})
    raise SystemExit(3)
cli.main = verb
__main__.main()
"""


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """Return the environment in which threads that have woken others end late."""
    environment = late_threads(tmp_path_factory.mktemp("late"))
    paths = [environment["PYTHONPATH"], str(HERE)]
    return environment | {"PYTHONPATH": os.pathsep.join(paths), "OPENBLAS_NUM_THREADS": "1"}


@pytest.fixture
def table(tmp_path):
    """Return a Parquet file."""
    sweep(grid(1, (GOOD,)), tmp_path / "run", executor="serial", show_progress=False)
    return tmp_path / "run" / "summary.parquet"


def ended(program, argument, environment) -> subprocess.CompletedProcess:
    """Run a program of Python to its end."""
    command = [sys.executable, "-c", program, str(argument)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=100)


@pytest.mark.slow
def test_a_thread_that_still_holds_a_python_buffer_aborts_the_interpreter(late, table):
    outcome = ended(READS_AHEAD, table, late)
    assert outcome.returncode == -6, "the threads were not delayed, so the next tests show nothing"
    assert "terminate called" in outcome.stderr


def test_no_thread_holds_what_is_python_s_when_a_program_that_used_everything_ends(late, tmp_path):
    outcome = ended(READS_ALL, tmp_path, late)
    assert (outcome.returncode, outcome.stderr) == (0, "")


def test_the_command_line_ends_with_its_code_whatever_a_library_does_at_the_end(late, table):
    assert ended(VERB_READS_AHEAD, table, late).returncode == 3


def test_bad_exits_are_counted_for_every_verb(monkeypatch, tmp_path):
    verbs = {name: lambda mark: [sys.executable, "-c", f"import sys; sys.exit({mark[-1]} == 1)"] for name in ("a", "b")}
    monkeypatch.setattr(torture_exits, "prepared", lambda folder: (folder / "fresh").mkdir() or verbs)
    result = torture_exits.exits(4, 3, tmp_path)
    assert result == {"a": ([0, 1], [0, 1, 0]), "b": ([0, 1], [0, 1, 0])}


def test_a_fixture_that_hangs_is_ended_and_all_stacks_are_printed(request, tmp_path):
    limit, way = (request.config.getini(name) for name in ("timeout", "timeout_method"))
    assert 0 < float(limit) <= 600
    file = tmp_path / "test_hangs.py"
    file.write_text(
        "import threading, pytest\n"
        "@pytest.fixture\ndef closing():\n    yield\n    threading.Event().wait()\n"
        "def test_hangs(closing): pass\n"
    )
    command = [sys.executable, "-m", "pytest", "-c", "/dev/null", "-p", "no:cacheprovider", "--timeout", "1"]
    outcome = subprocess.run(
        [*command, "--timeout-method", way, file], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60
    )
    assert outcome.returncode != 0
    assert "in closing" in outcome.stdout + outcome.stderr
