"""Compiled code is kept in a private directory and checked before it is run."""

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import caching

from clearsweep.mechanics.compiled import cache

PROGRAM = """
import sys
from clearsweep.mechanics.compiled import cache
print(cache.prepare())
import numba
cache.guard()
sys.path.insert(0, {place!r})
import kept
print(kept.twice(21.0), kept.twice.stats.cache_hits.total() if hasattr(kept.twice.stats.cache_hits, 'total') else 0)
"""
KEPT = "from numba import njit\n\n@njit(cache=True)\ndef twice(x):\n    return 2.0 * x\n"


@pytest.fixture
def run(tmp_path):
    """Return a function that runs a small compiled program, its code kept below `home`: its output and its messages."""
    (tmp_path / "kept.py").write_text(KEPT)
    environment = {
        key: value for key, value in os.environ.items() if key not in ("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT")
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
    place, hits, told = run()
    assert (hits, told) == (0, "")
    assert place.stat().st_mode & 0o777 == 0o700
    assert run() == (place, 1, "")


@pytest.mark.heavy
@pytest.mark.parametrize("ending", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("harm", ["truncate", "empty", "flip"])
def test_damaged_code_is_compiled_anew_once_with_a_line(run, ending, harm):
    place, _, _ = run()
    files = list(place.rglob(ending))
    assert files
    for file in files:
        content = bytearray(file.read_bytes())
        if harm == "flip":
            content[len(content) // 2] ^= 4
        file.write_bytes(content[: len(content) // 2 if harm == "truncate" else 0] if harm != "flip" else content)
    _, hits, told = run()
    assert hits == 0
    assert told.count("is damaged and is compiled anew") == 1
    assert run() == (place, 1, "")


@pytest.mark.heavy
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
    used, hits, told = run()
    assert used.parent.parent != place.parent.parent
    assert hits == 0
    assert "compiled code is not kept in" in told
    assert not used.exists()  # it went with the process


@pytest.mark.heavy
def test_a_predictable_directory_below_the_temporary_one_is_not_trusted(run, tmp_path):
    planted = tmp_path / "tmp" / f"clearsweep-{os.getuid()}" / cache.stamp()
    planted.mkdir(parents=True)
    used, _, told = run(home=Path("/proc/none"), TMPDIR=str(tmp_path / "tmp"))
    assert used != planted
    assert list(planted.iterdir()) == []
    assert "compiled code is not kept" in told


def test_types_that_are_not_here_are_no_trouble_and_keep_their_code(tmp_path, monkeypatch):
    (tmp_path / "made_up.py").write_text("from typing import NamedTuple\nclass Joint(NamedTuple):\n    gap: float\n")
    monkeypatch.syspath_prepend(tmp_path)
    key = importlib.import_module("made_up").Joint(0.5)

    def kept():
        return caching.IndexDataCacheFile(str(tmp_path), "of_a_function", "stamp")

    kept().save(key, "of the test")
    del sys.modules["made_up"]
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(sys, "path", [place for place in sys.path if place != str(tmp_path)])
        importlib.invalidate_caches()
        assert kept().load("another") is None
        kept().save("another", "of the run")
        assert kept().load("another") == "of the run"
    importlib.invalidate_caches()
    assert kept().load(importlib.import_module("made_up").Joint(0.5)) == "of the test"


def test_two_processes_that_compile_at_once_do_not_take_each_other_s_code(tmp_path, monkeypatch):
    slow, quick = (caching.IndexDataCacheFile(str(tmp_path), "of_a_function", "stamp") for _ in range(2))
    monkeypatch.setattr(quick, "_load_index", lambda: {})  # it looked before the other one had written
    store = slow._save_data

    def overtaken(name, data):
        quick.save("quick", "of the quick one")
        store(name, data)

    monkeypatch.setattr(slow, "_save_data", overtaken)
    slow.save("slow", "of the slow one")
    found = caching.IndexDataCacheFile(str(tmp_path), "of_a_function", "stamp")
    assert found.load("quick") == "of the quick one"
    assert found.load("slow") in (None, "of the slow one")
