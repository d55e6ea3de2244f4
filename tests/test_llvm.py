"""What the tracer relies on in LLVM and llvmlite: these fail first when either changes, see docs/numerics.md."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import simulation
from clearsweep.grid import load
from clearsweep.mechanics.coupling import entries
from clearsweep.tracing import cache, objects
from clearsweep.tracing.compiled.family import inlined, kernel
from clearsweep.tracing.memory import View
from clearsweep.tracing.symbols import DOUBLE

TANH = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}
SYMBOLS = {"memcpy", "memset"}  # what an object may ask of the system
NUMBERS = np.array([1.0 + 2.0**-30, 1.0 - 2.0**-30, -1.0, 0.0, 0.0, 0.0])  # a b + c = -2^-60 with a single rounding


@kernel
def product(a, b):
    return a * b


@inlined
def fused(a, b, c):
    return a * b + c


@inlined
def unfused(a, b, c):
    return product(a, b) + c


def both_sums(numbers, out, _):
    here, there = View(numbers.base, DOUBLE, (3,), (1,)), View(out.base, DOUBLE, (2,), (1,))
    there[0], there[1] = fused(here[0], here[1], here[2]), unfused(here[0], here[1], here[2])


def entry_of(body, items="f"):
    """Return the LLVM code of a body that is handed bare pointers."""
    return str(objects.trace_body(lambda *given: objects.run(body, *given), items).module)


def test_a_sum_is_fused_where_it_is_written_and_nowhere_else():
    """Also after functions have been merged into their callers."""
    code, out = objects.load_object(objects.compile_object(entry_of(both_sums))), np.zeros(2)
    objects.function_at(code.address, 1)(NUMBERS.ctypes.data, out.ctypes.data, 0)
    assert out.tolist() == [-(2.0**-60), 0.0]


@pytest.mark.parametrize("level", objects.LEVELS)
def test_an_object_is_made_for_every_level_whatever_the_processor(monkeypatch, level):
    monkeypatch.setattr(objects, "_LEVELS_FOR_PACKAGE", [level])
    assert len(objects.compile_object(entry_of(both_sums))) > 200


def test_all_levels_that_run_here_give_the_same_bits(monkeypatch):
    known, result = list(objects.LEVELS), []
    if objects.level() not in known:
        pytest.skip("a processor of another kind")
    for level in known[known.index(objects.level()) :]:
        monkeypatch.setattr(objects, "_LEVELS_FOR_PACKAGE", [level])
        content, out = objects.compile_object(entry_of(both_sums)), np.zeros(2)
        monkeypatch.setattr(objects, "_LEVELS_FOR_PACKAGE", [])
        code = objects.load_object(content)
        objects.function_at(code.address, 1)(NUMBERS.ctypes.data, out.ctypes.data, 0)
        result.append(out.tobytes())
    assert len(set(result)) == 1


def test_an_object_for_another_kind_of_processor_asks_for_nothing_more_and_links(tmp_path, monkeypatch):
    """A step of a slider-crank with friction; linking needs that processor's linker.  Nobody has run it."""
    case = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.friction": TANH}))
    monkeypatch.setattr(objects, "_LEVELS_FOR_PACKAGE", ["aarch64"])
    made = objects.trace_scene(entries.sweep_entry, case.value, "fifffff")
    content = objects.compile_object(str(made.module))
    assert int.from_bytes(content[0x12:0x14], "little") == 183  # of AArch64, in ELF
    assert undefined(content) <= SYMBOLS
    linker = shutil.which("aarch64-linux-gnu-ld")
    if linker:
        (tmp_path / "step.o").write_bytes(content)
        command = [linker, "-shared", "-o", str(tmp_path / "step.so"), str(tmp_path / "step.o")]
        message = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (message.returncode, message.stderr) == (0, "")


@pytest.mark.heavy
def test_no_page_of_ours_is_writable_and_executable():
    """But for the one that llvmlite asks ctypes for when it is imported."""
    program = (
        "import sys; sys.path.insert(0, 'tests')\n"
        "def pages():\n"
        "    return {line.split()[0] for line in open('/proc/self/maps') if line.split()[1][1:3] == 'wx'}\n"
        "import llvmlite.binding\n"
        "before = pages()\n"
        "import clearsweep\n"
        "from mechanism_cases import slider_crank\n"
        "case = slider_crank('rod-slider', changes={'simulate.revolutions': 0.01})\n"
        "clearsweep.simulate(clearsweep.load_case(case))\n"
        "print(*(pages() - before))\n"
    )
    place = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, cwd=place)
    assert done.stdout.strip() == ""


@pytest.mark.heavy
@pytest.mark.few("lubricated", "worn_slider_crank")
@pytest.mark.parametrize("name", ["lubricated", "worn_slider_crank", "spatial_slider_crank", "ptfe_bushing"])
def test_an_object_asks_the_system_to_move_memory_alone(name):
    """Read from the symbols of all objects: shipped, of scenes with wear, film and memory, and in the cache."""
    grid = Path(__file__).parents[1] / "configs" / f"{name}.yaml"
    simulation.compile_for(load(str(grid), simulation.catalogue()).case(0))
    compiled = Path(os.environ["CLEARSWEEP_CACHE_DIR"])
    in_cache = list(compiled.rglob("*.o"))
    assert len(in_cache) >= 4
    result = set()
    for file in (*in_cache, *(cache.SHIPPED / compiled.name).rglob("*.o")):
        result |= undefined(file.read_bytes())
    assert result
    assert result <= SYMBOLS


def undefined(content):
    """Return the names of symbols that an object (ELF, 64 bit) does not define."""
    header = int.from_bytes(content[0x28:0x30], "little")
    size, count = (int.from_bytes(content[at : at + 2], "little") for at in (0x3A, 0x3C))

    def number(at, width=8):
        return int.from_bytes(content[at : at + width], "little")

    sections = [header + size * i for i in range(count)]
    names = set()
    for section in sections:
        if number(section + 4, 4) != 2:  # a table of symbols
            continue
        begin, long, strings = number(section + 0x18), number(section + 0x20), sections[number(section + 0x28, 4)]
        text = number(strings + 0x18)
        for symbol in range(begin + 24, begin + long, 24):
            if number(symbol + 6, 2) == 0:
                first = text + number(symbol, 4)
                names.add(content[first : content.index(b"\0", first)].decode())
    return names - {"", "_GLOBAL_OFFSET_TABLE_"}


def test_an_engine_takes_an_object_that_was_made_elsewhere():
    content = objects.compile_object(entry_of(both_sums))
    assert content[:4] == b"\x7fELF" or sys.platform != "linux"
    first, second = objects.load_object(content), objects.load_object(content)
    assert first.address != second.address
    assert isinstance(llvm.llvm_version_info, tuple)
    assert ctypes.sizeof(ctypes.c_void_p) == 8


def test_whole_numbers_divide_as_those_of_python():
    def divided(numbers, out, integer):
        there = View(out.base, DOUBLE, (2,), (1,))
        there[0], there[1] = integer // 3 * 1.0, integer % 3 * 1.0

    code, out = objects.load_object(objects.compile_object(entry_of(divided))), np.zeros(2)
    for number in (-7, -6, -1, 0, 5, 7):
        objects.function_at(code.address, 1)(out.ctypes.data, out.ctypes.data, number)
        assert out.tolist() == [number // 3, number % 3]


FAR_APART = """
import ctypes
import mmap
import os

from clearsweep import load_case, simulate
from clearsweep.tracing import objects

FAR, HOLE = 1 << 32, 1 << 15  # bytes; the hole takes constants but no code
system, kept = ctypes.CDLL(None), []

def take(size):
    kept.append(mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x4000))  # Linux's MAP_NORESERVE
    return ctypes.addressof(ctypes.c_char.from_buffer(kept[-1]))

def loaded(content, load=objects.load_object):
    begin = take(FAR)
    for size in (1 << 20, 1 << 16, mmap.PAGESIZE):
        while take(size) > begin:  # holes above are taken first
            pass
    system.munmap(ctypes.c_void_p(begin + FAR - HOLE), ctypes.c_size_t(HOLE))
    return load(content)

objects.load_object = loaded
print(simulate(load_case("../configs/one_case.yaml")).status, flush=True)
os._exit(0)
"""


@pytest.mark.heavy
@pytest.mark.compiled
@pytest.mark.skipif(sys.platform != "linux", reason="flags of Linux")
def test_code_is_loaded_where_memory_near_earlier_code_is_taken():
    result = subprocess.run(
        [sys.executable, "-c", FAR_APART], cwd=Path(__file__).parent, capture_output=True, text=True, check=False
    )
    assert (result.returncode, result.stdout) == (0, "ok\n"), result.stderr
