"""Compiled code is kept in a private directory and checked before it is run."""

import copy
import hashlib
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import llvmlite
import pytest
from mechanism_cases import JOINT, slider_crank

import clearsweep
from clearsweep.mechanics.coupling import entries, rates
from clearsweep.tracing import cache, objects

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


# ---------------------------------------------------------------------------------------------- keys


ROOT = Path(__file__).parents[1]
EDITED = """
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
        program = EDITED.format(tests=str(ROOT / "tests"), laws=laws, cache=kept)
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
    assert others == {"mechanics/__init__.py", "mechanics/laws/contract.py", "mechanics/observe.py"}


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


# ---------------------------------------------------------------------------------------------- idle loops


ROD = {"mass": 0.21, "inertia": 2.5e-4, "center": [0.06, 0], "points": {"big": [0, 0], "small": [0.12, 0]}}
PISTON = {"mass": 0.14, "inertia": 1e-4, "points": {"pin": [0, 0]}}
CRANK = {"mass": 0.3, "inertia": 1e-4, "center": [0.025, 0], "points": {"pivot": [0, 0], "pin": [0.05, 0]}}
LOADS = {
    "nothing": {},
    "gas": {"table": "configs/engine_gas.csv"},
    "a spring": {"anchor": ["300 mm", 0], "stiffness": "2 kN/m"},
    "a constant force": {"force": [3.0, 1.0]},
}
ENTRIES = {  # of a run: function and kinds of its arrays
    "sweep": (entries.sweep_entry, "fifffff"),
    "rates": (entries.rates_entry, "fifff"),
    "observables": (entries.observe_entry, "fiff"),
    "time histories": (rates.sample_entry, "fifff"),
}


def engine(cylinders, load="nothing"):
    """Return the grid of a radial engine with clearance in its first small end, and a load on every piston."""
    bodies = {"ground": {"points": {"main": [0, 0]}}, "crank": CRANK}
    joints = {"main": {"type": "revolute", "between": ["ground.main", "crank.pivot"]}}
    start, loads = {}, {}
    for i in range(cylinders):
        angle = 2.0 * math.pi * i / cylinders
        bodies[f"rod{i}"], bodies[f"piston{i}"] = copy.deepcopy((ROD, PISTON))
        joints[f"big{i}"] = {"type": "revolute", "between": ["crank.pin", f"rod{i}.big"]}
        joints[f"small{i}"] = {"type": "revolute", "between": [f"rod{i}.small", f"piston{i}.pin"]}
        joints[f"bore{i}"] = {"type": "prismatic", "between": ["ground.main", f"piston{i}.pin"], "axis": angle}
        start[f"rod{i}"] = angle + math.asin(0.05 / 0.12 * math.sin(angle))
        ends = {"between": ["ground", f"piston{i}"]} if load == "a spring" else {"on": f"piston{i}"}
        loads |= {f"load{i}": ends | LOADS[load]} if LOADS[load] else {}
    output = {"body": "piston0", "point": "pin", "along": 0.0}
    return {
        "mechanism": {
            "type": "planar", "bodies": bodies, "joints": joints, "driven": "main", "start": start, "output": output
        },
        "drive": {"speed": "2000 rpm"},
        "loads": loads,
        "joints": {"small0": copy.deepcopy(JOINT)},
    }  # fmt: skip


def code_of(source, entry):
    """Return the LLVM code of an entry of a grid's scene, as it was traced."""
    function, items = ENTRIES[entry]
    return str(objects.trace_scene(function, clearsweep.load_case(source).value, items).module)


def instructions_of(code):
    """Return the kinds of the instructions of optimised code."""
    functions = objects.optimise(code).functions
    return [str(each.opcode) for function in functions for block in function.blocks for each in block.instructions]


@pytest.mark.few("nothing")
@pytest.mark.parametrize("load", ["nothing", "gas", "a spring", "a constant force"])
def test_a_sweep_of_an_engine_contains_its_open_cylinder_alone(load):
    single, three = (instructions_of(code_of(engine(cylinders, load), "sweep")) for cylinders in (1, 3))
    assert Counter(three) == Counter(single)


@pytest.mark.slow
def test_code_grows_with_the_bodies_of_a_machine_and_no_faster():
    """From 8 to 26 bodies, as traced and as optimised."""
    written, compiled = [], []
    for cylinders in (3, 12):
        codes = [code_of(engine(cylinders), entry) for entry in ENTRIES]
        written.append(sum(code.count("\n") for code in codes))
        compiled.append(sum(len(instructions_of(code)) for code in codes))
    for small, large in (written, compiled):
        assert math.log(large / small) / math.log(26 / 8) <= 1.15
