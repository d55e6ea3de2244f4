"""Shared fixtures of the tests.

Compiling costs most: `make test` tests each compiled form at most once in compiled form, everything else about it as
plain Python (marker `plain`, `make test-plain`).  Compiled code is kept between runs, so no test moves
CLEARSWEEP_CACHE_DIR unless it tests the cache.
"""

import gc
import os
import signal
from collections import Counter
from pathlib import Path

import pytest
from fake_runs import forget_laws, load
from hypothesis import HealthCheck, settings

from clearsweep.language.errors import InputError
from clearsweep.tracing.compiled.family import is_plain

# How long an example takes depends on the machine and on what else it does. CI repeats its examples; others are new.
settings.register_profile(
    "untimed", deadline=None, derandomize="CI" in os.environ, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("untimed")

# With Python's own thresholds a quarter of the time goes into looking for circles among modules, trees and tables.
gc.set_threshold(50_000, 20, 100)

SLOW_LIMIT = 3600.0  # s, of a test marked slow, and of all in plain Python; `timeout` in pyproject.toml: of the others


@pytest.hookimpl(tryfirst=True)  # before `-m` chooses
def pytest_collection_modifyitems(config, items):
    """Leave out tests marked plain unless kernels run as plain Python, and give these and slow tests more time.

    Of a test marked `few`, all other cases are slow where they are compiled.  Files with many heavy tests come first,
    so that what runs last in several processes is short.
    """
    missing = set()  # cases that `few` names
    for item in items:
        few = item.get_closest_marker("few")
        if few and not is_plain() and (not few.args or item.callspec.id not in few.args):
            item.add_marker("slow")
        missing |= {f"{item.path.name}::{item.originalname}[{name}]" for name in few.args} if few else set()
    missing -= {f"{item.path.name}::{item.name}" for item in items}
    if missing and not any("::" in argument for argument in config.args):
        raise pytest.UsageError(f"the marker few names cases that are not there: {', '.join(sorted(missing))}")
    if not is_plain():
        config.hook.pytest_deselected(items=[item for item in items if item.get_closest_marker("plain")])
        items[:] = [item for item in items if not item.get_closest_marker("plain")]
    for item in items:
        if (is_plain() or item.get_closest_marker("slow")) and not item.get_closest_marker("timeout"):
            item.add_marker(pytest.mark.timeout(SLOW_LIMIT))
    heavy = Counter(item.path for item in items if item.get_closest_marker("heavy"))
    items.sort(key=lambda item: -heavy[item.path])


def pytest_collection_finish():
    """Leave what all tests share, which stays, out of every search for circles."""
    gc.freeze()


def pytest_sessionfinish():
    """Let libraries release what they hold, or they speak of leaks."""
    gc.unfreeze()


@pytest.fixture(scope="session", autouse=True)
def powered():
    """Let this process not wait until the disk has what is written: no test takes the power away."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda handle: None)
        yield


@pytest.fixture
def at(tmp_path, monkeypatch):
    """Return a function that writes a text as grid.yaml and loads it from there."""
    monkeypatch.chdir(tmp_path)

    def write(text, overrides=None):
        Path("grid.yaml").write_text(text, encoding="utf-8")
        return load("grid.yaml", overrides)

    return write


@pytest.fixture
def problems_in(at):
    """Return a function that gives the problems of a text."""

    def problems(text, overrides=None):
        with pytest.raises(InputError) as caught:
            at(text, overrides)
        return caught.value.problems

    return problems


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a working directory for law files, of a user who trusts none in a process that ran none."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    forget_laws(monkeypatch)
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


@pytest.fixture
def hang_up_heeded():
    """Let this process heed SIGHUP, though the tests may run under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def too_short(monkeypatch):
    """Let a slot be shorter than its stroke, which presses the pin on its ends."""
    monkeypatch.setattr("clearsweep.simulation.setup.places.SLOT_ROUNDING", 10.0)
