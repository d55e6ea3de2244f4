"""Streams that are closed or full and limits of the operating system: a run goes on, or is refused with the remedy."""

import json
import os
import resource
import signal
import subprocess
import sys
import threading
from pathlib import Path

import fake_physics
import pytest
import torture_exits
from fake_physics import FAILS, GOOD, Fake, grid, sweep
from test_sweep import parts, program, same_results, wait_for
from torture_exits import READS_AHEAD, late_threads

import clearsweep
from clearsweep import cli, exit_codes
from clearsweep.language import errors, phases
from clearsweep.language.errors import InputError
from clearsweep.sweeping.pool import driver, executors, forks, system

pytestmark = pytest.mark.heavy

HERE = Path(__file__).parent
#: The command line with made-up mechanics; sweeps by this very process.
MADE_UP = "import fake_physics; from clearsweep.sweeping import sweep; sweep.sweep = fake_physics.sweep; "
MAIN = "from clearsweep import cli; cli.main()"


def shell(script: str, cwd: Path, code: str = MADE_UP + MAIN) -> subprocess.CompletedProcess:
    """Run a shell script in which `$cs` is the command line."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([str(HERE), str(HERE.parent)]),
        "cs": f"{sys.executable} -c '{code}'",
    }
    command = ["bash", "-c", script.replace("clearsweep ", 'eval "$cs" ')]
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False, timeout=60)


@pytest.fixture
def grid_file(tmp_path):
    (tmp_path / "g.json").write_text(json.dumps(grid(2, (GOOD, FAILS))), encoding="utf-8")
    return tmp_path


@pytest.mark.few("closed")
@pytest.mark.parametrize("streams_of_run", ["<&- >&- 2>&-", ">/dev/full 2>&1"], ids=["closed", "full"])
def test_a_run_whose_streams_are_closed_or_full_continues_and_ends_with_its_code(grid_file, streams_of_run):
    ended = shell(
        f"clearsweep run g.json --out x --executor serial {streams_of_run}; echo ${{PIPESTATUS[0]}} >code", grid_file
    )
    assert (grid_file / "code").read_text().strip() == "3"
    assert (grid_file / "x" / "summary.parquet").exists()
    assert "Traceback" not in ended.stderr + (grid_file / "x" / "lock").read_text()


@pytest.mark.few(">/dev/full-No space left", "| :-")
@pytest.mark.parametrize(
    ("stream", "message"), [(">&-", ""), ("2>&-", ""), (">/dev/full", "No space left"), ("| :", "")]
)
def test_what_cannot_be_printed_is_dropped_and_a_full_stdout_is_reported(tmp_path, stream, message):
    ended = shell(f"clearsweep init {stream}; exit ${{PIPESTATUS[0]}}", tmp_path, MAIN)
    assert ended.returncode == 0
    assert (message in ended.stderr) if message else not ended.stderr


def test_the_null_device_takes_the_place_of_a_stream_that_was_left(tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    lasting = exit_codes._ResilientFile(writing, "w")
    assert lasting.write(b"12345") == 5
    assert os.fstat(lasting.fileno()).st_rdev == os.stat(os.devnull).st_rdev
    lasting.close()


def test_a_program_without_stderr_sees_no_progress_in_its_stdout(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stderr", None)
    phases.print_line("something")
    with phases.show_progress(), phases.phase(driver.CaseProgress(3)):
        phases.Display().refresh()
    assert not capsys.readouterr().out


@pytest.mark.usefixtures("hang_up_heeded")
@pytest.mark.slow
def test_a_hang_up_of_the_terminal_ends_a_run_like_a_termination(tmp_path):
    process = program(tmp_path / "run", grid(100, (GOOD + 0.05,)), jobs=2, show_progress=False, session=True)
    wait_for(lambda: parts(tmp_path / "run") >= 1)
    os.killpg(process.pid, signal.SIGHUP)  # a terminal reaches all, the workers, too
    _, err = process.communicate(timeout=20)
    assert process.returncode == 129
    assert int(err.split("stopped: ")[1].split(" of")[0]) > 0
    assert "run the same command again" in err


@pytest.mark.usefixtures("hang_up_heeded")
def test_a_hang_up_stops_a_run_and_has_its_exit_code():
    with pytest.raises(system.Stopped) as stopped, system.catching():
        signal.raise_signal(signal.SIGHUP)
    assert stopped.value.exit_code == 129
    with system.catching(), system.patience():
        signal.raise_signal(signal.SIGHUP)
        assert system.requested() == signal.SIGHUP


def test_a_hang_up_that_is_ignored_stays_so_while_a_run_catches_signals():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with system.catching():
            assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) != signal.SIG_DFL
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.slow
def test_under_nohup_a_hang_up_is_ignored(tmp_path):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # what a program is started with, it inherits
    try:
        process = program(tmp_path / "run", grid(20, (GOOD + 0.02,)), jobs=1, show_progress=False, session=True)
    finally:
        signal.signal(signal.SIGHUP, before)
    wait_for(lambda: parts(tmp_path / "run") >= 1)
    os.killpg(process.pid, signal.SIGHUP)
    out, err = process.communicate(timeout=20)
    assert process.returncode == 0, err
    assert json.loads(out)["ran"] == 20


@pytest.mark.few("-v 500000-ulimit -v 4000000")
@pytest.mark.parametrize(
    ("limit", "text"), [("-n 8", "ulimit -n 256"), ("-n 16", "ulimit -n 256"), ("-v 500000", "ulimit -v 4000000")]
)
def test_too_little_of_a_resource_is_refused_with_the_limit_and_the_remedy(grid_file, limit, text):
    ended = shell(f"ulimit {limit}; clearsweep run g.json --out x", grid_file, MAIN)
    assert ended.returncode == 2
    assert len(ended.stderr.splitlines()) == 1
    assert text in ended.stderr
    assert not (grid_file / "x").exists()


def test_open_files_are_allowed_as_far_as_the_system_lets_us(monkeypatch):
    given = []
    monkeypatch.setattr(resource, "getrlimit", lambda _: (16, 1024))
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: given.append(limits))
    executors.allow_files("local", 8)
    assert given == [(40, 1024)]
    with pytest.raises(errors.InputError, match=r"1,024 .*2,024"):
        executors.allow_files("local", 1000)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    executors.allow_files("local", 10**6)
    assert len(given) == 1


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (MemoryError("Unable to allocate 7.45 GiB"), "7.45 GiB); use fewer workers with --jobs"),
        (OSError(12, "Cannot allocate memory"), "memory: not enough"),
        (OSError(24, "Too many open files"), "ulimit -n"),
        (
            OSError(36, "File name too long", "x" * 300),
            "xxx...: File name too long for the file system (300 characters)",
        ),
    ],
)
def test_limits_that_are_met_on_the_way_are_reported_with_their_remedy(monkeypatch, capsys, error, text):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(cli.verbs, "main", fail)
    assert exit_codes.run(cli.verbs, ["laws"]) == 2
    message = capsys.readouterr().err
    assert text in message
    assert len(message.splitlines()) == 1


@pytest.mark.parametrize("verb", ["run g.json --out", "run g.json --dry-run --out", "init", "report", "report x --out"])
def test_a_name_of_300_characters_is_bad_input(grid_file, monkeypatch, capsys, verb):
    monkeypatch.chdir(grid_file)
    with pytest.raises(SystemExit) as ended:
        cli.main([*verb.split(), "y" * 300])
    message = capsys.readouterr().err
    assert ended.value.code == 2
    assert len(message.splitlines()) == 1
    assert "yyy" in message or "x: contains no run" in message


class Verbose(Fake):
    """Mechanics whose compiler talks for hundreds of lines, or whose cases find no memory."""

    error: Exception = TypeError("\n".join(f"line {number} {'1' * 400}" for number in range(300)))

    @classmethod
    def compile_for(cls, case):
        """Fail."""
        raise cls.error

    @classmethod
    def solve(cls, case):
        """Fail in the same way."""
        raise cls.error


class Greedy(Verbose):
    """Mechanics that find no memory."""

    error = MemoryError("Unable to allocate 7.45 GiB for an array")


@pytest.mark.parametrize(("mechanics", "text"), [(Verbose, "TypeError: line 0"), (Greedy, "with --jobs, save fewer")])
def test_what_went_wrong_in_a_case_is_reported_in_one_line(tmp_path, capsys, mechanics, text):
    result = sweep(grid(1), tmp_path / "run", simulator=mechanics, executor="serial", show_progress=False)
    (message,) = result.open().summary["message"]
    assert text in message
    assert len(message) < 300
    messages = capsys.readouterr().err
    assert len(messages.splitlines()) == 1
    assert len(messages) < 300


def test_workers_that_cannot_be_started_are_reported_with_the_reason(monkeypatch):
    def refuse(*_, **__):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(forks, "ProcessPool", refuse)
    with pytest.raises(errors.InputError, match=r"jobs: 3 worker processes .*Resource temporarily unavailable"):
        forks.Local(3)
    assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == set()


def test_workers_leave_hang_ups_to_their_parent():
    before = {signum: signal.getsignal(signum) for signum in system.SIGNALS}
    try:
        system.in_worker()
        assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)


def test_nothing_is_left_of_threads_that_asked_in_vain(monkeypatch):
    monkeypatch.setattr(executors, "ANSWER_TIMEOUT", 0.05)
    end = threading.Event()
    with pytest.raises(TimeoutError, match="no answer within"):
        executors.with_timeout(end.wait)
    end.set()
    with pytest.raises(ZeroDivisionError):
        executors.with_timeout(lambda: 1 / 0)
    assert executors.with_timeout(lambda: 5) == 5


def test_errors_name_their_own_space_only(monkeypatch):
    monkeypatch.setattr(resource, "getrlimit", lambda _: (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    system.check_space()
    assert system.remedy_text(ZeroDivisionError("bug")) is None


# ---------------------------------------------------------------------------------------------- ends of programs


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


# ----------------------------------------------------------------------------------- settings and disks of others


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    out = tmp_path_factory.mktemp("surroundings") / "run"
    fake_physics.sweep(grid(6), out, executor="serial", show_progress=False)
    return out


def report(run, *options, limit=None, **environment):
    """Return what `report` comes to, its files limited to some bytes."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    return subprocess.run(
        [sys.executable, "-m", "clearsweep", "report", str(run), *map(str, options)],
        env=os.environ | environment,
        preexec_fn=limited if limit else None,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_figures_do_not_depend_on_settings_of_matplotlib_by_others(ran, tmp_path):
    odd = {"MPLBACKEND": "nope", "SOURCE_DATE_EPOCH": "x"}
    for name, variables in (("usual", {}), ("odd", odd)):
        done = report(
            ran, "--out", tmp_path / f"{name}.html", "--figures", tmp_path / name, "--format", "pdf", **variables
        )
        assert done.returncode == 0, done.stderr
    files = sorted(file.name for file in (tmp_path / "usual").iterdir())
    assert len(files) > 1
    for name in files:
        assert (tmp_path / "usual" / name).read_bytes() == (tmp_path / "odd" / name).read_bytes()


@pytest.mark.slow
def test_a_page_that_does_not_fit_is_named_and_nothing_is_left_of_it(ran, tmp_path):
    done = report(ran, "--out", tmp_path / "page.html", limit=40_000)
    assert done.returncode == 2
    assert f"{tmp_path / 'page.html'}: cannot be written (File too large); make room or choose" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("source", ["grid.yaml", {"mechanism": {}}, None, 1.0])
def test_simulate_says_what_it_takes(source):
    with pytest.raises(InputError, match=r"expected the result of load_case, as in clearsweep\.simulate"):
        clearsweep.simulate(source)


@pytest.mark.parametrize("limit", [9_000])
def test_a_disk_that_fills_in_the_middle_costs_what_was_not_committed(tmp_path, limit):
    source = grid(40, wear=True)
    fake_physics.sweep(source, tmp_path / "undisturbed", executor="serial", show_progress=False)
    out = tmp_path / "run"
    resource_limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))\n"
    script = resource_limit + (
        "import sys, json; sys.path[:0] = json.loads(sys.argv[3])\n"
        "from fake_physics import sweep; from clearsweep.language.errors import ClearsweepError\n"
        'try: sweep(json.loads(sys.argv[1]), sys.argv[2], executor="serial", show_progress=False)\n'
        "except ClearsweepError as error: print(error, file=sys.stderr); sys.exit(error.exit_code)\n"
    )
    arguments = [json.dumps(source), str(out), json.dumps(sys.path)]
    done = subprocess.run([sys.executable, "-c", script, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode in (2, 4), done.stderr
    assert "Traceback" not in done.stderr
    assert str(out) in done.stderr
    program(out, source, show_progress=False).communicate(timeout=100)
    assert same_results(tmp_path / "undisturbed", out)
    assert parts(out) == len(list((out / "shards").iterdir()))
