"""Machine code of traced functions: optimised, stored as plain objects, loaded."""

import contextlib
import ctypes
import functools
import hashlib
import itertools
import platform
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir

from ...language import phases
from . import cache, interpreter, symbols  # noqa: F401 - the interpreter registers itself
from .calls import call_body, run
from .memory import Bare, View, viewed
from .paths import changed, leaves
from .symbols import ADDRESS, DOUBLE, WHOLE, Trace, Whole

#: Levels of processors for which code is compiled, the best first, and the features of each.
LEVELS = {
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": ("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe"),
}
#: Other kinds of processors: triple, processor.  Objects for these have only been linked, never run.
ELSEWHERE = {"aarch64": ("aarch64-unknown-linux-gnu", "generic")}

_WANTED: list[str] = []  # a level for which code is compiled instead of this machine's


def level() -> str:
    """Return the level of processors for which code is compiled."""
    return _WANTED[-1] if _WANTED else _own_level()


@contextlib.contextmanager
def shipped_for(name: str) -> Iterator[Path]:
    """In this context, compile code for a level and store it in the package, not in the user's cache; do not run it."""
    _WANTED.append(name)
    try:
        with cache.kept_in_package() as position:
            yield position
    finally:
        _WANTED.pop()


@functools.cache
def _own_level() -> str:
    """Return the level of this machine's processor; its own name if it is below all levels or of another kind."""
    if platform.machine().lower() in ("x86_64", "amd64"):
        has = llvm.get_host_cpu_features()
        required: tuple[str, ...] = ()
        for name, features in reversed(LEVELS.items()):
            required += features
            if not all(has.get(feature) for feature in required):
                break
            nearest_name = name
        else:
            return nearest_name
        if required != LEVELS["x86-64-v3"]:
            return nearest_name
    if platform.machine().lower() == "aarch64" and platform.system() == "Linux":
        return "aarch64"
    return str(llvm.get_host_cpu_name())


def _machine() -> Any:
    """Return a new target machine for this machine's level; an engine takes ownership of it."""
    if level() in ELSEWHERE:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        target, cpu, features = llvm.Target.from_triple(_triple()), ELSEWHERE[level()][1], ""
    else:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        target, cpu, features = llvm.Target.from_default_triple(), level(), ""
        if level() not in LEVELS:
            features = llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(cpu=cpu, features=features, opt=3, reloc="pic", codemodel="small")


def _triple() -> str:
    return ELSEWHERE[level()][0] if level() in ELSEWHERE else str(llvm.get_process_triple())


def traced(function: Callable, scene: Any, items: str) -> ir.Module:
    """Return the module of `function(scene pointer, *arrays, integer)`.

    items : a letter per array, 'f' for float64, 'i' for int64.
    """

    def body(numbers: Bare, *remaining: Any) -> None:
        view, places = View(numbers.base, DOUBLE, (1 << 30,), (1,)), itertools.count()
        run(function, (changed(scene, lambda _: view[next(places)]),), *remaining)

    return _module(body, items)


def _module(body: Callable, items: str, width: int = 1) -> ir.Module:
    """Return the module of a body of pointers to numbers and to the items of arrays, and an integer."""
    active_trace = Trace(width)
    active_trace.module.triple = _triple()
    kinds = [ADDRESS] * (1 + len(items)) + [WHOLE]
    entry = ir.Function(active_trace.module, ir.FunctionType(ir.VoidType(), kinds), "entry")
    for pointer in entry.args[1:-1]:
        pointer.add_attribute("noalias")  # so that loaded values need not be loaded again after every store
    active_trace.builder = ir.IRBuilder(entry.append_basic_block())
    with symbols.in_hand(active_trace):
        arrays = [
            Bare(pointer, DOUBLE if item == "f" else WHOLE)
            for pointer, item in zip(entry.args[:-1], f"f{items}", strict=True)
        ]
        body(*arrays, Whole(entry.args[-1]))
        active_trace.builder.ret_void()
    return active_trace.module


def optimised(module: ir.Module) -> Any:
    """Return the module, optimised by LLVM."""
    parsed = llvm.parse_assembly(str(module))
    parsed.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    passes = llvm.create_pass_builder(_machine(), options)
    passes.getModulePassManager().run(parsed, passes)
    return parsed


def object_of(module: ir.Module) -> bytes:
    """Return a module as a plain object."""
    return _machine().emit_object(optimised(module))


_LOADED = itertools.count()  # objects


class Code(NamedTuple):
    """Machine code in memory."""

    address: int
    engine: Any  # owner of the code


def loaded(content: bytes) -> Code:
    """Return the machine code of an object."""
    library = llvm.JITLibraryBuilder().add_object_img(content).add_current_process().export_symbol("entry")
    tracker = library.link(_linker(), f"code {next(_LOADED)}")
    return Code(tracker["entry"], tracker)


@functools.cache
def _linker() -> Any:
    """Return LLVM's JITLink, which allocates code and constants in one piece.

    The older loader, MCJIT, aborts in a large process whose free addresses are more than 2 GB apart.
    """
    return llvm.create_lljit_compiler(_machine(), use_jit_link=True)


def compiled(function: Callable, scene: Any, kinds: tuple, items: str) -> Code | None:
    """Return the machine code of `function` for scenes of these kinds, compiled or from the cache; see `traced`."""
    return code_of(function, f"{_text(kinds)} {items}", lambda: traced(function, scene, items))


def compiled_at(function: Callable, cache_key: str) -> Code | None:
    """Return the machine code of `function(address)`; cache_key : everything the code depends on except its sources."""

    def body(numbers: Bare, _: Any) -> None:
        run(function, Whole(symbols.trace().builder.ptrtoint(numbers.base, WHOLE)))

    return code_of(function, cache_key, lambda: _module(body, ""))


def code_of(function: Callable, cache_key: str, module: Callable[[], ir.Module]) -> Code | None:
    """Return the machine code of a module of a function, or of its stored object, or None if it is not available."""
    cache_key = f"{function.__module__}.{function.__qualname__} {cache_key} {level()}"
    name = f"{function.__name__}-{hashlib.sha256(cache_key.encode()).hexdigest()[:32]}.o"
    content = None if _WANTED else cache.kept(name)
    if content is None:
        with phases.phase(phases.Phase("compiling (kept for later runs)", once=True)):
            content = object_of(module())
        cache.keep(name, content)
    return loaded(content) if content and not _WANTED else None


@functools.cache
def function_at(address: int, arrays: int) -> Any:
    """Return the machine code at an address as a Python function of the scene's address and `arrays` further ones."""
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * (1 + arrays), ctypes.c_int64)(address)


def machine_code(function: Callable) -> Callable:
    """Return a function of numbers, nested tuples and arrays as machine code, compiled at its first call.

    Numbers are float64 and arguments of the code; integers, which may be loop bounds, are part of the code.  Arrays are
    float64 or int64.  The function returns numbers or nested tuples of them.
    """
    merged: dict[Any, Any] = {}

    @functools.wraps(function)
    def called(*operands: Any) -> Any:
        arrays = [x for x in leaves(operands) if isinstance(x, np.ndarray)]
        numbers = np.array([float(x) for x in leaves(operands) if isinstance(x, float)] or [0.0])
        key = _form(operands)
        if key not in merged:
            merged[key] = _of_numbers(function, operands)
        code, result, count = merged[key]
        results = np.empty(max(count, 1))
        kept_arrays = [np.ascontiguousarray(array) for array in arrays]
        function_at(code.address, len(kept_arrays) + 1)(
            numbers.ctypes.data, *(array.ctypes.data for array in kept_arrays), results.ctypes.data, 0
        )
        for array, right_operand in zip(arrays, kept_arrays, strict=True):
            if right_operand is not array:
                array[...] = right_operand
        values = iter(results.tolist())
        return changed(result, lambda x: next(values) if x is _PLACE else x)

    return called


_PLACE = object()  # placeholder of a number in a result


def _form(operands: Any) -> Any:
    """Return the part of the arguments on which machine code depends."""
    if isinstance(operands, tuple):
        return (type(operands), *map(_form, operands))
    if isinstance(operands, np.ndarray):
        return operands.dtype.kind, operands.shape
    return float if isinstance(operands, float) else operands


def _of_numbers(function: Callable, operands: tuple) -> tuple[Code, Any, int]:
    """Return machine code for arguments of the form of `operands`, its result without numbers, and their count."""
    cache_key: list[Any] = []
    kinds = "".join(x.dtype.kind for x in leaves(operands) if isinstance(x, np.ndarray))

    def body(numbers: Any, *remaining: Any) -> None:
        *bare, out, _ = remaining
        arrays, places = iter(bare), itertools.count()
        view = View(numbers.base, DOUBLE, (1 << 30,), (1,))

        def single_lane(x: Any) -> Any:
            if isinstance(x, np.ndarray):
                return viewed(next(arrays), x.shape)
            return view[next(places)] if isinstance(x, float) else x

        value = call_body(function, changed(operands, single_lane), {})
        into, position = View(out.base, DOUBLE, (1 << 30,), (1,)), itertools.count()
        for x in leaves(value):
            if isinstance(x, float) or symbols.is_symbol(x):
                into[next(position)] = x
        cache_key.append(changed(value, lambda x: _PLACE if isinstance(x, float) or symbols.is_symbol(x) else x))
        cache_key.append(next(position))

    content = object_of(_module(body, f"{kinds}f"))
    return loaded(content), *cache_key


def _text(kinds: Any) -> str:
    """Return nested tuples of types as a text that is the same in every process."""
    if isinstance(kinds, tuple):
        return f"({' '.join(map(_text, kinds))})"
    return f"{kinds.__module__}.{kinds.__qualname__}"
