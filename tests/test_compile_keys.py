"""A compiled object is kept for as long as its sources are the same, or for as long as the same code comes of them."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import llvmlite
import pytest

from clearsweep.tracing import cache

ROOT = Path(__file__).parents[1]
PROGRAM = """
import sys; sys.path.insert(0, {tests!r})
from pathlib import Path
import clearsweep
from mechanism_cases import slider_crank
objects = set(Path({cache!r}).rglob('*.o'))
for law in {laws}:
    friction = {{'law': law, 'coefficient': 0.1, 'velocity_scale': 1e-2}}
    changes = {{'joints.rod-slider.friction': friction, 'simulate.revolutions': 0.1, 'simulate.discard': 0}}
    run = clearsweep.simulate(clearsweep.load_case(slider_crank('rod-slider', changes=changes)))
    print(run.status, repr(run.summary['rod_slider_force_peak']), run.summary['steps'])
    before, objects = objects, set(Path({cache!r}).rglob('*.o'))
    print(*sorted(path.name for path in objects - before))
"""
SLIDING, LOOP = "mechanics/laws/friction.py", "mechanics/solver/loop.py"


class Copy:
    """A copy of the package with a cache of its own, and the objects of the loop that the package has."""

    def __init__(self, place):
        self.place, self.package = place, place / "clearsweep"
        shutil.copytree(ROOT / "clearsweep", self.package, ignore=shutil.ignore_patterns("__pycache__"))

    def edit(self, file, old, new):
        path = self.package / file
        text = path.read_text()
        assert text.count(old) == 1
        path.write_text(text.replace(old, new))

    def run(self, *laws):
        """Return for each law of friction what its run prints, and the names of the objects compiled for it."""
        kept = str(self.place / "cache")
        program = PROGRAM.format(tests=str(ROOT / "tests"), laws=laws, cache=kept)
        environment = os.environ | {"PYTHONPATH": str(self.place), cache.PLACE: kept}
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, env=environment, cwd=self.place, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        lines = done.stdout.splitlines()
        return list(zip(lines[::2], [line.split() for line in lines[1::2]], strict=True))


@pytest.mark.slow
@pytest.mark.compiled
def test_an_edit_of_a_law_compiles_its_scenes_alone(tmp_path):
    copy = Copy(tmp_path)
    (smooth, compiled), (other, also) = copy.run("tanh", "threlfall")
    assert compiled
    assert also

    copy.edit(LOOP, '"""Integrate one case; ', '"""Integrate a single case; ')
    copy.edit(SLIDING, "class Tanh(NamedTuple):", "# A comment.\nclass Tanh(NamedTuple):")
    assert copy.run("tanh", "threlfall") == [(smooth, []), (other, [])]

    copy.edit(SLIDING, "normal * math.tanh(slip", "0.5 * normal * math.tanh(slip")
    (edited, compiled), unedited = copy.run("tanh", "threlfall")
    assert compiled
    assert not [name for name in compiled if name.startswith("integrate_at")]
    assert edited != smooth
    assert unedited == (other, [])


def test_the_loop_depends_on_the_contract_of_laws_and_on_none_of_them():
    solver = str(cache.PACKAGE / LOOP)
    names = {Path(path).relative_to(cache.PACKAGE).as_posix() for path in cache.dependencies([solver])}
    assert {LOOP, "mechanics/solver/step.py", "mechanics/observe.py", "tracing/objects.py"} <= names
    others = {name for name in names if not name.startswith(("mechanics/solver/", "tracing/"))}
    assert others == {"mechanics/laws/contract.py", "mechanics/observe.py"}


def test_a_file_outside_the_package_may_depend_on_all_of_it(tmp_path):
    path = tmp_path / "law.py"
    path.write_text("K = 1.0\n")
    dependencies = cache.dependencies([str(path)])
    assert dependencies.keys() == cache.source_hashes().keys() | {str(path)}


@pytest.fixture
def recorded(tmp_path, monkeypatch):
    """Return a source whose object is recorded."""
    monkeypatch.setenv(cache.PLACE, str(tmp_path))
    path = tmp_path / "law.py"
    path.write_text("K = 1.0\n")
    cache.record("law.json", "law.o", [str(path)])
    assert cache.recorded_object("law.json") == "law.o"
    return path


def test_an_object_is_not_taken_for_other_sources(recorded):
    recorded.write_text("K = 2.0\n")
    assert cache.recorded_object("law.json") is None
    recorded.unlink()
    assert cache.recorded_object("law.json") is None


@pytest.mark.parametrize("file", [SLIDING, "tracing/symbols.py"])
def test_a_record_covers_every_source_of_the_package(recorded, monkeypatch, file):
    hashes = cache.source_hashes() | {str(cache.PACKAGE / file): "another"}
    monkeypatch.setattr(cache, "source_hashes", lambda: hashes)
    assert cache.recorded_object("law.json") is None


def test_no_record_is_made_of_sources_that_changed_since_the_start(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.PLACE, str(tmp_path))
    hashes = cache.source_hashes() | {str(cache.PACKAGE / SLIDING): "as it was"}
    monkeypatch.setattr(cache, "source_hashes", lambda: hashes)
    cache.record("scene.json", "scene.o", hashes)
    assert cache.recorded_object("scene.json") is None
    assert list(tmp_path.iterdir()) == []


def test_a_record_that_was_changed_is_damaged(recorded, tmp_path, capsys):
    (path,) = tmp_path.rglob("law.json")
    path.write_bytes(path.read_bytes().replace(b"law.o", b"own.o"))
    assert cache.recorded_object("law.json") is None
    assert re.search("compiled code kept in .* is damaged", capsys.readouterr().err)


def test_compiled_code_is_kept_under_a_stamp_of_its_compiler(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.PLACE, str(tmp_path))
    place = cache.prepare_cache()
    assert place == tmp_path / cache.compiler_stamp()
    assert os.environ[cache.PLACE] == str(place)
    assert cache.prepare_cache() == place  # a child process does not stamp again
    monkeypatch.setattr(llvmlite, "__version__", "0.0")
    assert cache.compiler_stamp() != place.name


def test_a_trace_that_chose_a_body_by_type_depends_on_every_source(tmp_path):
    path = tmp_path / "law.py"
    path.write_text("K = 1.0\n")
    dependencies = cache.dependencies([str(path), "<machine>"], on_all=True)
    assert dependencies.keys() == cache.source_hashes().keys() | {str(path)}
