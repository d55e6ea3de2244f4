"""Signals one upon the other: the first one decides the exit code and the way out, later ones change nothing."""

import fcntl
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from fake_physics import GOOD, grid
from test_sweep import parts, program, wait_for

from clearsweep.sweeping.pool import system

BURST = (signal.SIGINT, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)

pytestmark = pytest.mark.usefixtures("hang_up_heeded")


def code_of(work):
    """Return the exit code with which something is stopped."""
    with pytest.raises(system.Stopped) as stopped, system.catching():
        work()
    return stopped.value.exit_code


@pytest.mark.parametrize("first", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_on_the_way_out_change_nothing(first):
    seen = []

    def leave():
        try:
            signal.raise_signal(first)
        finally:
            for signum in BURST:
                signal.raise_signal(signum)
            seen.append("to its end")

    assert (code_of(leave), seen) == (128 + first, ["to its end"])


def test_the_second_signal_stops_at_once_with_the_exit_code_of_the_first():
    seen = []

    def wait():
        with system.patience():
            signal.raise_signal(signal.SIGTERM)
            seen.append(system.requested())
            signal.raise_signal(signal.SIGINT)
            seen.append("not reached")

    assert (code_of(wait), seen) == (143, [signal.SIGTERM])


def test_what_a_signal_breaks_is_no_error_of_its_own():
    def broken():
        try:
            signal.raise_signal(signal.SIGTERM)
        except system.Stopped:
            raise RuntimeError("release unlocked lock") from None

    assert code_of(broken) == 143
    with pytest.raises(RuntimeError, match="of its own"), system.catching():
        raise RuntimeError("of its own")


def test_a_process_that_ends_with_its_run_stays_deaf_until_then():
    code = (
        "import signal; from clearsweep.sweeping.pool import system; system.end_with_run()\n"
        "try:\n"
        "    with system.catching(): signal.raise_signal(signal.SIGTERM)\n"
        "except system.Stopped as stopped:\n"
        "    for signum in system.SIGNALS: signal.raise_signal(signum)\n"
        "    raise SystemExit(stopped.exit_code)\n"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 143


@pytest.mark.few("0.002")
@pytest.mark.parametrize("pause", [0.0, 0.002, 0.05])
def test_a_burst_of_signals_ends_a_run_like_its_first_one(tmp_path, pause):
    process = program(tmp_path / "run", grid(100, (GOOD + 0.05,)), jobs=2, show_progress=False)
    try:
        wait_for(lambda: parts(tmp_path / "run") >= 2, seconds=120.0)
        for signum in BURST:
            process.send_signal(signum)
            time.sleep(pause)
        _, err = process.communicate(timeout=60)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode in {130, 143, 129} if pause == 0.0 else process.returncode == 130, err
    assert "Traceback" not in err


TRACKED = """
import os, signal, time
from multiprocessing import resource_tracker
from clearsweep.sweeping.pool import forks
if __name__ == "__main__":
    pool = forks.Local(1)
    assert pool.submit(abs, -2).result(60) == 2
    os.kill(resource_tracker._resource_tracker._pid, signal.SIGKILL)
    time.sleep(0.2)
    assert pool.submit(abs, -3).result(60) == 3
    pool.close()
    del pool
"""


@pytest.mark.heavy
def test_a_killed_resource_tracker_leaves_no_word_on_stderr(tmp_path):
    (tmp_path / "tracked.py").write_text(TRACKED)
    ended = subprocess.run(
        [sys.executable, "tracked.py"], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120
    )
    assert (ended.returncode, ended.stderr) == (0, "")


HOLDING = """
import fcntl, os, threading, time
from clearsweep.sweeping.pool import forks
lock = open("lock", "w")
fcntl.flock(lock, fcntl.LOCK_EX)
threads = [threading.Thread(target=time.sleep, args=(600,), daemon=True)] if {threads} else []
for thread in threads:
    thread.start()
pool = forks.Local(2)
worker, server = pool.submit(os.getpid).result(60), pool.submit(os.getppid).result(60)
print(worker, server, flush=True)
time.sleep(600)
"""


def is_running(pid):
    """Return whether a process runs."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends a process with its parent")
@pytest.mark.parametrize("threads", [False, True])
def test_workers_are_forks_of_a_process_with_one_thread_and_end_with_the_run(tmp_path, threads):
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-c", HOLDING.format(threads=threads)]
    process = subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        worker, server = map(int, process.stdout.readline().split())
        lines = [Path(f"/proc/{pid}/cmdline").read_bytes() for pid in (process.pid, server, worker)]
        assert (lines[0] == lines[1]) is not threads  # a process with further threads is not forked
        assert lines[1] == lines[2]
        assert len(os.listdir(f"/proc/{server}/task")) == 1
        files = {os.readlink(path) for pid in (server, worker) for path in Path(f"/proc/{pid}/fd").iterdir()}
        assert str(tmp_path / "lock") not in files  # it would stay locked for as long as they last
    finally:
        process.kill()
        process.communicate()
    with (tmp_path / "lock").open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    wait_for(lambda: not is_running(server) and not is_running(worker), seconds=30.0)
