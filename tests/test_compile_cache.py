"""Compiled code is kept in a private directory and checked before it is run."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from mechanism_cases import slider_crank

from clearsweep.tracing import cache

PROGRAM = """
import sys
from clearsweep.tracing import cache
print(cache.prepare_cache())
from clearsweep.tracing import objects
made, object_of = [], objects.compile_object
objects.compile_object = lambda module: made.append(module) or object_of(module)
sys.path.insert(0, {place!r})
import kept
import numpy as np
numbers = np.array([21.0])
code = objects.compiled_code(kept.twice, (0.0,), (float,), "f")
objects.function_at(code.address, 1)(numbers.ctypes.data, numbers.ctypes.data, 0)
print(numbers[0], 0 if made else 1)
"""
KEPT = "def twice(numbers, out, _):\n    View(out.base, out.item, (1,), (1,))[0] = 2.0 * numbers[0][0]\n"
KEPT = f"from clearsweep.tracing.memory import View\n\n\n{KEPT}"


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a small compiled program, its code kept below `home`: its output and its messages."""
    (tmp_path / "kept.py").write_text(KEPT)
    environment = {
        key: value for key, value in os.environ.items() if key not in ("CLEARSWEEP_CACHE_DIR", "CLEARSWEEP_DISABLE_JIT")
    }

    def call(home=tmp_path / "home", **more):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM.format(place=str(tmp_path))],
            env=environment | {"XDG_CACHE_HOME": str(home), **more},
            capture_output=True,
            text=True,
            check=True,
            timeout=120,
        )
        place, answer = done.stdout.splitlines()
        number, hits = answer.split()
        assert float(number) == 42.0
        return Path(place), int(hits), done.stderr

    return call


@pytest.mark.heavy
def test_code_is_kept_in_a_directory_of_the_user_alone(run):
    place, hits, message = run()
    assert (hits, message) == (0, "")
    assert place.stat().st_mode & 0o777 == 0o700
    assert run() == (place, 1, "")


@pytest.mark.heavy
@pytest.mark.few("flip")
@pytest.mark.parametrize("harm", ["truncate", "empty", "flip"])
def test_damaged_code_is_compiled_anew_once_with_a_line(run, harm):
    place, _, _ = run()
    files = list(place.rglob("*.o"))
    assert files
    for file in files:
        content = bytearray(file.read_bytes())
        if harm == "flip":
            content[len(content) // 2] ^= 4
        file.write_bytes(content[: len(content) // 2 if harm == "truncate" else 0] if harm != "flip" else content)
    _, hits, message = run()
    assert hits == 0
    assert message.count("is damaged and is compiled anew") == 1
    assert run() == (place, 1, "")


@pytest.mark.heavy
@pytest.mark.few("shared", "of another")
@pytest.mark.parametrize("trouble", ["shared", "linked", "of another", "read-only", "shared parent"])
def test_code_is_not_taken_from_where_somebody_else_could_have_put_it(run, tmp_path, monkeypatch, trouble):
    place, _, _ = run()
    if trouble == "shared":
        place.chmod(0o777)
    elif trouble == "linked":
        place.rename(tmp_path / "elsewhere")
        place.symlink_to(tmp_path / "elsewhere")
    elif trouble == "shared parent":
        place.parent.chmod(0o777)
    elif os.geteuid() != 0:
        pytest.skip("only root can give a directory away")
    elif trouble == "of another":
        os.chown(place, 12345, -1)
    else:  # root may write anywhere but below what is no directory
        shutil.rmtree(place.parent)
        place.parent.write_text("in the way")
    used, hits, message = run()
    assert used.parent.parent != place.parent.parent
    assert hits == 0
    assert "compiled code is not kept in" in message
    assert not used.exists()  # it went with the process


@pytest.mark.heavy
def test_a_predictable_directory_below_the_temporary_one_is_not_trusted(run, tmp_path):
    planted = tmp_path / "tmp" / f"clearsweep-{os.getuid()}" / cache.compiler_stamp()
    planted.mkdir(parents=True)
    used, _, message = run(home=Path("/proc/none"), TMPDIR=str(tmp_path / "tmp"))
    assert used != planted
    assert list(planted.iterdir()) == []
    assert "compiled code is not kept" in message


def test_two_processes_that_compile_at_once_do_not_harm_each_other(monkeypatch, tmp_path):
    monkeypatch.setenv("CLEARSWEEP_CACHE_DIR", str(tmp_path))
    replace = Path.replace

    def overtaken(self, target):
        monkeypatch.setattr(Path, "replace", replace)
        cache.store("code", b"of the quick one")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", overtaken)
    cache.store("code", b"of the slow one")
    assert cache.load("code") == b"of the slow one"
    assert [path.name for path in (tmp_path / "traced").iterdir()] == ["code"]


@pytest.mark.heavy
def test_a_checksum_of_the_content_alone_is_not_enough(run):
    place, _, _ = run()
    (file,) = place.rglob("*.o")
    body = file.read_bytes()[: -cache.CHECKSUM]
    file.write_bytes(body + hashlib.sha256(body).digest())
    _, hits, message = run()
    assert hits == 0
    assert message.count("is damaged and is compiled anew") == 1


def test_an_object_is_not_loaded_under_another_name_or_stamp(monkeypatch, tmp_path, capsys):
    for stamp in ("this", "other"):
        (tmp_path / stamp).mkdir()
        monkeypatch.setenv("CLEARSWEEP_CACHE_DIR", str(tmp_path / stamp))
        cache.store("one", b"code of one")
        cache.store("two", b"code of two")
    first, two = (tmp_path / "other" / "traced" / name for name in ("one", "two"))
    shutil.copy(first, two)
    shutil.copy(tmp_path / "this" / "traced" / "one", first)
    assert cache.load("one") is None
    assert cache.load("two") is None
    assert "is damaged" in capsys.readouterr().err


@pytest.mark.heavy
def test_a_prepared_directory_that_has_vanished_is_made_again(run, tmp_path):
    gone = tmp_path / "gone" / cache.compiler_stamp()
    place, _, message = run(CLEARSWEEP_CACHE_DIR=str(gone))
    assert (place, message) == (gone, "")
    assert gone.stat().st_mode & 0o777 == 0o700


def test_a_directory_that_vanishes_while_it_is_checked_is_a_reason_and_no_error(monkeypatch, tmp_path):
    def vanish(path):
        raise FileNotFoundError(2, "No such file or directory", str(path))

    monkeypatch.setattr(cache, "privacy_problem", vanish)
    assert cache._preparation_problem(tmp_path).startswith("it cannot be made (No such file")


def test_without_home_and_without_an_entry_in_passwd_code_is_kept_for_this_process(monkeypatch, tmp_path, capsys):
    def unknown():
        raise RuntimeError("Could not determine home directory.")

    for name in ("CLEARSWEEP_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", unknown)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    place = cache.prepare_cache()
    monkeypatch.delenv("CLEARSWEEP_CACHE_DIR")
    assert place.is_relative_to(tmp_path)
    assert "compiled code is not kept in ~/.cache: Could not determine home" in capsys.readouterr().err


THREADS = """
import json, sys
from concurrent.futures import ThreadPoolExecutor
import clearsweep

scenes = [clearsweep.load_case(grid) for grid in json.load(sys.stdin)]
with ThreadPoolExecutor(len(scenes)) as pool:
    together = list(pool.map(clearsweep.simulate, scenes))
alone = [clearsweep.simulate(scene) for scene in scenes]
times = ("run_time", "setup_time")
for one, other in zip(together, alone):
    assert one.status == "ok" and {**one.summary, **dict.fromkeys(times)} == {**other.summary, **dict.fromkeys(times)}
"""


@pytest.mark.slow
@pytest.mark.compiled
def test_threads_that_need_code_at_once_compile_it_one_by_one(tmp_path):
    """Equal scenes among them: code that one thread runs is not replaced by that of another."""
    frictions = {
        "coulomb": {"coefficient": 0.1, "velocity_scale": 0.01},
        "dahl": {"coefficient": 0.1, "bristle_stiffness": 1e5},
    }
    grids = [
        slider_crank(
            "rod-slider",
            changes={
                "joints.rod-slider.friction": {"law": law, **values},
                "simulate.revolutions": 1,
                "simulate.discard": 0,
            },
        )
        for law, values in frictions.items()
        for _ in range(3)
    ]
    environment = os.environ | {"CLEARSWEEP_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", THREADS]
    subprocess.run(command, input=json.dumps(grids), env=environment, text=True, check=True, capture_output=True)
