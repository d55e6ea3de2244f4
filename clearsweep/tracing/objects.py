"""Machine code of traced functions: optimised, stored as plain objects, loaded."""

import contextlib
import ctypes
import functools
import gc
import hashlib
import itertools
import platform
import re
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite.binding as llvm
import numpy as np
from llvmlite import ir

from ..language import phases
from . import (
    cache,
    loops,  # noqa: F401 - the interpreter registers itself
    symbols,
)
from .activation import leaves, map_leaves
from .calls import call, run
from .memory import Pointer, View, view_at
from .symbols import ADDRESS, DOUBLE, INT64, Boolean, Integer, NotTraceableError, Number, Trace

#: Levels of processors for which code is compiled, the best first, and the features of each.
LEVELS = {
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
    "x86-64-v3": ("avx2", "fma", "bmi", "bmi2", "f16c", "lzcnt", "movbe"),
}
#: Other kinds of processors: triple, processor.  Objects for these have only been linked, never run.
OTHER_PROCESSORS = {"aarch64": ("aarch64-unknown-linux-gnu", "generic")}

#: Attributes of every function: none throws and every loop ends, so LLVM drops calls and loops with unused results.
ATTRIBUTES = "mustprogress nounwind"

_LEVELS_FOR_PACKAGE: list[str] = []  # a level for which code is compiled instead of this machine's


def level() -> str:
    """Return the level of processors for which code is compiled."""
    return _LEVELS_FOR_PACKAGE[-1] if _LEVELS_FOR_PACKAGE else _own_level()


@contextlib.contextmanager
def compiling_for_package(name: str) -> Iterator[Path]:
    """In this context, compile code for a level and store it in the package, not in the user's cache; do not run it."""
    _LEVELS_FOR_PACKAGE.append(name)
    try:
        with cache.stored_in_package() as directory:
            yield directory
    finally:
        _LEVELS_FOR_PACKAGE.pop()


@functools.cache
def _own_level() -> str:
    """Return the level of this machine's processor; its own name if it is below all levels or of another kind."""
    if platform.machine().lower() in ("x86_64", "amd64"):
        host_features = llvm.get_host_cpu_features()
        required: tuple[str, ...] = ()
        for name, features in reversed(LEVELS.items()):
            required += features
            if not all(host_features.get(feature) for feature in required):
                break
            best = name
        else:
            return best
        if required != LEVELS["x86-64-v3"]:
            return best
    if platform.machine().lower() == "aarch64" and platform.system() == "Linux":
        return "aarch64"
    return str(llvm.get_host_cpu_name())


def _target_machine() -> Any:
    """Return a new target machine for this machine's level; an engine takes ownership of it."""
    if level() in OTHER_PROCESSORS:
        llvm.initialize_all_targets()
        llvm.initialize_all_asmprinters()
        target, cpu, features = llvm.Target.from_triple(_triple()), OTHER_PROCESSORS[level()][1], ""
    else:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        target, cpu, features = llvm.Target.from_default_triple(), level(), ""
        if level() not in LEVELS:
            features = llvm.get_host_cpu_features().flatten()
    return target.create_target_machine(cpu=cpu, features=features, opt=3, reloc="pic", codemodel="small")


def _triple() -> str:
    return OTHER_PROCESSORS[level()][0] if level() in OTHER_PROCESSORS else str(llvm.get_process_triple())


def trace_scene(function: Callable, scene: Any, items: str) -> Trace:
    """Return the trace of `function(scene pointer, *arrays, integer)`.

    items : a letter per array, 'f' for float64, 'i' for int64.
    """

    def body(numbers: Pointer, *arguments: Any) -> None:
        view, indices = View(numbers.base, DOUBLE, (1 << 30,), (1,)), itertools.count()
        run(function, (map_leaves(scene, lambda _: view[next(indices)]),), *arguments)

    return trace_body(body, items)


def trace_body(body: Callable, items: str, width: int = 1) -> Trace:
    """Return the trace of a body of pointers to numbers and to the items of arrays, and an integer."""
    active_trace = Trace(width)
    active_trace.module.triple = _triple()
    kinds = [ADDRESS] * (1 + len(items)) + [INT64]
    entry = ir.Function(active_trace.module, ir.FunctionType(ir.VoidType(), kinds), "entry")
    for pointer in entry.args[1:-1]:
        pointer.add_attribute("noalias")  # so that loaded values need not be loaded again after every store
    active_trace.builder = ir.IRBuilder(entry.append_basic_block())
    with symbols.current_trace(active_trace):
        arrays = [
            Pointer(pointer, DOUBLE if item == "f" else INT64)
            for pointer, item in zip(entry.args[:-1], f"f{items}", strict=True)
        ]
        body(*arrays, Integer(entry.args[-1]))
        active_trace.builder.ret_void()
    return active_trace


def optimise(code: str) -> Any:
    """Return the module of LLVM code, optimised by LLVM."""
    parsed = llvm.parse_assembly(re.sub(r"^define .*", rf"\g<0> {ATTRIBUTES}", code, flags=re.MULTILINE))
    parsed.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=2)
    passes = llvm.create_pass_builder(_target_machine(), options)
    passes.getModulePassManager().run(parsed, passes)
    return parsed


def compile_object(code: str) -> bytes:
    """Return LLVM code as a plain object."""
    return _target_machine().emit_object(optimise(code))


_LOADED = itertools.count()  # objects


class Code(NamedTuple):
    """Machine code in memory."""

    address: int
    engine: Any  # owner of the code


def load_object(content: bytes) -> Code:
    """Return the machine code of an object."""
    library = llvm.JITLibraryBuilder().add_object_img(content).add_current_process().export_symbol("entry")
    tracker = library.link(_linker(), f"code {next(_LOADED)}")
    return Code(tracker["entry"], tracker)


@functools.cache
def _linker() -> Any:
    """Return LLVM's JITLink, which allocates code and constants in one piece.

    The older loader, MCJIT, aborts in a large process whose free addresses are more than 2 GB apart.
    """
    return llvm.create_lljit_compiler(_target_machine(), use_jit_link=True)


def compiled_code(function: Callable, scene: Any, kinds: tuple, items: str) -> Code | None:
    """Return the machine code of `function` for scenes of these kinds, compiled or cached; see `trace_scene`."""
    return load_or_compile(function, f"{_kinds_text(kinds)} {items}", lambda: trace_scene(function, scene, items))


def compiled_code_at(function: Callable, cache_key: str) -> Code | None:
    """Return the machine code of `function(address)`; cache_key : everything the code depends on except its sources."""

    def body(numbers: Pointer, _: Any) -> None:
        run(function, Integer(symbols.trace().builder.ptrtoint(numbers.base, INT64)))

    return load_or_compile(function, cache_key, lambda: trace_body(body, ""))


def compiled_routine(function: Callable, items: str) -> Code | None:
    """Return the machine code of `function(*arrays, integer)`; its first argument is unused; see `trace_scene`."""

    def body(_: Pointer, *arguments: Any) -> None:
        run(function, *arguments)

    return load_or_compile(function, items, lambda: trace_body(body, items))


_COMPILING = threading.RLock()  # tracing and LLVM serve one thread at a time


def load_or_compile(function: Callable, description: str, trace_function: Callable[[], Trace]) -> Code | None:
    """Return the machine code of a trace of a function, compiled or stored, or None if it is for another machine."""
    description = f"{function.__module__}.{function.__qualname__} {description} {level()}"
    record = f"{function.__name__}-{_hash(description)}.json"
    with _COMPILING:
        recorded = None if _LEVELS_FOR_PACKAGE else cache.recorded_object(record)
        content = cache.load(recorded) if recorded else None
        if content is None:
            with phases.phase(phases.Phase("compiling (kept for later runs)", once=True)), _without_collection():
                content = _compile_unless_stored(function, record, trace_function())
        return load_object(content) if content and not _LEVELS_FOR_PACKAGE else None


@contextlib.contextmanager
def _without_collection() -> Iterator[None]:
    """In this context, keep garbage: nearly all objects of a trace are in use, and searching them takes 10 % of it."""
    is_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if is_enabled:
            gc.enable()


def _compile_unless_stored(function: Callable, record: str, trace: Trace) -> bytes:
    """Return the object of a trace, and record from which sources it is."""
    code = str(trace.module)
    name = f"{function.__name__}-{_hash(f'{level()} {code}')}.o"
    content = None if _LEVELS_FOR_PACKAGE else cache.load(name)
    if content is None:
        content = compile_object(code)
        cache.store(name, content)
    cache.record(record, name, trace.sources, on_all=trace.chooses)
    return content


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@functools.cache
def function_at(address: int, arrays: int) -> Any:
    """Return the machine code at an address as a Python function of the scene's address and `arrays` further ones."""
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * (1 + arrays), ctypes.c_int64)(address)


def machine_code(function: Callable) -> Callable:
    """Return a function of numbers, nested tuples and arrays as machine code, compiled at its first call.

    Numbers are float64 and arguments of the code; integers, which may be loop bounds, are part of the code.  Arrays are
    float64 or int64, and share no memory.  The function returns numbers or nested tuples of them.  Raises TypeError for
    other arguments and `NotTraceableError`, with file, line and statement, for what cannot be compiled.
    """
    compiled_forms: dict[Any, Any] = {}

    @functools.wraps(function)
    def call_machine_code(*operands: Any) -> Any:
        arrays = [x for x in leaves(operands) if isinstance(x, np.ndarray)]
        _check_arrays(function, arrays)
        numbers = np.array([float(x) for x in leaves(operands) if isinstance(x, float)] or [0.0])
        key = _argument_key(operands)
        if key not in compiled_forms:
            compiled_forms[key] = _compile_for_numbers(function, operands)
        code, result, count = compiled_forms[key]
        results = np.empty(max(count, 1))
        contiguous = [np.ascontiguousarray(array) for array in arrays]
        function_at(code.address, len(contiguous) + 1)(
            numbers.ctypes.data, *(array.ctypes.data for array in contiguous), results.ctypes.data, 0
        )
        for array, copy in zip(arrays, contiguous, strict=True):
            if copy is not array:
                array[...] = copy
        values = zip(results.tolist(), results.view(np.int64).tolist(), strict=True)

        def python_value(x: Any) -> Any:
            if x not in (Number, Integer, Boolean):
                return x
            number, bits = next(values)
            return number if x is Number else bits if x is Integer else bool(number)

        return map_leaves(result, python_value)

    return call_machine_code


def _check_arrays(function: Callable, arrays: list[np.ndarray]) -> None:
    for array in arrays:
        if array.dtype not in (np.float64, np.int64) or not array.flags.writeable:
            raise TypeError(f"{function.__name__}: an array is {array.dtype} or read-only; expected float64 or int64")
    if any(np.may_share_memory(a, b) for a, b in itertools.combinations(arrays, 2)):
        raise TypeError(f"{function.__name__}: two arrays share memory")


def _argument_key(operands: Any) -> Any:
    """Return the part of the arguments on which machine code depends."""
    if isinstance(operands, tuple):
        return (type(operands), *map(_argument_key, operands))
    if isinstance(operands, np.ndarray):
        return operands.dtype.kind, operands.shape
    return float if isinstance(operands, float) else (type(operands), operands)


def _compile_for_numbers(function: Callable, operands: tuple) -> tuple[Code, Any, int]:
    """Return machine code for arguments of the form of `operands`, its result without numbers, and their count."""
    outcome: list[Any] = []
    kinds = "".join(x.dtype.kind for x in leaves(operands) if isinstance(x, np.ndarray))

    def body(numbers: Any, *arguments: Any) -> None:
        *pointers, out, _ = arguments
        arrays, indices = iter(pointers), itertools.count()
        view = View(numbers.base, DOUBLE, (1 << 30,), (1,))

        def parameter(x: Any) -> Any:
            if isinstance(x, np.ndarray):
                return view_at(next(arrays), x.shape)
            return view[next(indices)] if isinstance(x, float) else x

        symbols.trace().are_indices_checked = True
        value = call(function, *map_leaves(operands, parameter))
        out_view, out_indices = View(out.base, DOUBLE, (1 << 30,), (1,)), itertools.count()
        for x in leaves(value):
            if not (symbols.is_symbol(x) or isinstance(x, (bool, int, float, str, type(None)))):
                raise NotTraceableError(f"{function.__name__} returns a {type(x).__name__}")
            if symbols.is_symbol(x):
                out_view[next(out_indices)] = symbols.number_of(x) if isinstance(x, Integer) else x
        outcome.append(map_leaves(value, lambda x: type(x) if symbols.is_symbol(x) else x))
        outcome.append(next(out_indices))

    with _COMPILING:
        content = compile_object(str(trace_body(body, f"{kinds}f").module))
        return load_object(content), *outcome


def _kinds_text(kinds: Any) -> str:
    """Return nested tuples of types as a text that is the same in every process."""
    if isinstance(kinds, tuple):
        return f"({' '.join(map(_kinds_text, kinds))})"
    return f"{kinds.__module__}.{kinds.__qualname__}"
