"""Dispatch of compiled code by type, and calls of this code from the integrator, which is compiled once.

A *family* is a function with one body per type of its first argument.  A scene is a NamedTuple of NamedTuples of
floats: its types select the bodies and so decide what is compiled, its values are the parameters.  The integrator does
not depend on the scene's type: it receives the address of an *entry*, the compiled code of one scene type, and the
address of the scene's parameters.  A further law therefore only compiles its own scenes, in half a second.
"""

import contextlib
import contextvars
import ctypes
import functools
import itertools
import os
from collections.abc import Iterator
from typing import ClassVar, NamedTuple

import numpy as np

from .. import objects
from ..memory import call_at, view_at
from ..protocols import KNOWN, SEPARATE, mark_traceable, register_emitter

# ----------------------------------------------------------------------------------------------------------------------
# Determines whether kernels run as plain Python, slow but debuggable: if CLEARSWEEP_DISABLE_JIT is set and not 0.


_IS_PLAIN = os.environ.get("CLEARSWEEP_DISABLE_JIT", "0") not in ("", "0")


def is_plain() -> bool:
    """Return whether nothing is compiled."""
    return _IS_PLAIN


# ----------------------------------------------------------------------------------------------------------------------


def kernel(function):
    """Return `function`, marked for compilation to machine code; called from Python it runs as Python."""
    return mark_traceable(function, SEPARATE)


def inlined(function):
    """Return `function` like `kernel`, but inlined into its callers: scenes and loads are expensive arguments."""
    return mark_traceable(function)


def known(function):
    """Return `function`, marked to run as Python while a body is traced: it looks only at types and known values."""
    return mark_traceable(function, KNOWN)


def family(stub):
    """Return `stub` as a function with code chosen by the type of its first argument.

    `@stub.member(cls)` registers the code for `cls`, a NamedTuple, or for several; for None, the default for other
    types.  In compiled code the choice takes no time and only the chosen body is compiled; in plain Python, with
    CLEARSWEEP_DISABLE_JIT=1, the same bodies run.
    """
    members = {}

    def body_of(value):
        return members.get(type(value), members.get(None))

    @functools.wraps(stub)
    def dispatch(value, *arguments):
        return body_of(value)(value, *arguments)

    def member(*classes):
        def register_body(body):
            for cls in classes:
                members.setdefault(cls, body)
            return body

        return register_body

    dispatch.member, dispatch.members, dispatch.body_of = member, members, body_of
    return dispatch


def family_with_default(stub):
    """Return `stub` as a `family` whose default for other types is its own body."""
    dispatch = family(stub)
    dispatch.member(None)(stub)
    return dispatch


class Entry(NamedTuple):
    """Addresses of the compiled code of a scene type and of a scene's parameters; 0 for none."""

    code: int
    parameters: int


NO_ENTRY = Entry(0, 0)


def flatten(value):
    """Return the numbers of nested tuples of floats as a (numbers,) float64 array, in the order of compiled code."""
    return np.array(numbers_of(value), dtype=np.float64)


def numbers_of(value):
    """Return the numbers as a list, which must not be changed."""
    return _form_and_numbers(value)[2]


def put_numbers(scene, numbers, parameters):
    """Make entries created with the array `parameters` use another scene of the same type.

    numbers : the numbers of the scene, see `numbers_of`
    """
    parameters[:] = numbers
    if is_plain():
        _SCENES[id(parameters)] = scene


_PLAIN = {}  # targets of Entries without compilation: code -> (function, id of the parameters)
_SCENES = {}  # and the scene of these parameters


_COMPILED = {}  # (function, form number of the scene, width) -> machine code or None
_EMPTY = contextvars.ContextVar("_EMPTY", default=False)


@contextlib.contextmanager
def empty_entries() -> Iterator[None]:
    """In this context entries are empty and nothing is compiled: for values needed only for their types."""
    token = _EMPTY.set(True)
    try:
        yield
    finally:
        _EMPTY.reset(token)


def are_entries_empty() -> bool:
    """Return whether entries are empty here, so that none may be called."""
    return _EMPTY.get()


_LATEST = [(None, 0, [])]  # the last scene with its form number and numbers, since queries repeat
_FORM_NUMBERS: dict[tuple, int] = {}  # kinds of scenes
_FORM_COUNTER = itertools.count()  # makes numbers unique between threads


def form_number(scene):
    """Return a number shared by scenes with the same `kinds`; faster to look up than these."""
    return _form_and_numbers(scene)[1]


def _form_and_numbers(scene):
    """Return a scene, its form number, and its numbers."""
    latest = _LATEST[0]
    if latest[0] is not scene:
        numbers: list[float] = []
        form = _walk(scene, numbers, _walk_cached)
        _LATEST[0] = latest = scene, _FORM_NUMBERS.setdefault(form, next(_FORM_COUNTER)), numbers
    return latest


def kinds(value):
    """Return the types in nested tuples."""
    return _walk(value, [])


class Identity:
    """A value as part of a cache's key: equal to nothing but itself.  The cache keeps the value alive."""

    __slots__ = ("value",)

    def __init__(self, value):
        self.value = value

    def __eq__(self, other):
        return self.value is other.value

    def __hash__(self):
        return id(self.value)


def _walk_cached(part, numbers):
    """Return the result of `_walk` for a part of a scene, cached because the cases of a sweep share their mechanism."""
    form, part_numbers = _walk_part(Identity(part))
    numbers += part_numbers
    return form


@functools.lru_cache(maxsize=256)
def _walk_part(part):
    numbers: list[float] = []
    return _walk(part.value, numbers), numbers


def _walk(value, numbers, walk=None):
    """Return the types in nested tuples, and append the numbers in them to a list.

    walk : the function for the nested tuples, by default this one.
    """
    form = (type(value), *map(type, value))
    if form not in _TUPLES:
        _TUPLES[form] = tuple(position for position, part in enumerate(value) if isinstance(part, tuple))
    tuples = _TUPLES[form]
    if not tuples:  # as of most
        numbers += value
        return form
    result, start = [form], 0
    for position in tuples:
        numbers += value[start:position]
        result.append((walk or _walk)(value[position], numbers))
        start = position + 1
    numbers += value[start:]
    return tuple(result)


_TUPLES: dict[tuple, tuple[int, ...]] = {}  # types of a tuple and its items -> positions of nested tuples


def entry(function, scene, arrays, parameters):
    """Return the Entry through which `invoke` calls `function(scene pointer, *arrays, integer)`.

    arrays : kinds of the items of the arrays, 'f' for float64, 'i' for int64; parameters : the array that
    `flatten(scene)` returned, which the caller keeps while the Entry is in use.
    """
    if _EMPTY.get():
        return NO_ENTRY
    if is_plain():
        code = hash((function, id(parameters)))
        _PLAIN[code], _SCENES[id(parameters)] = (function, id(parameters)), scene
        return Entry(code, 0)
    key = function, form_number(scene)
    if key not in _COMPILED:
        compiled_now = objects.compiled_code(function, scene, kinds(scene), arrays)
        _COMPILED.setdefault(key, compiled_now)  # never replaced: another thread may be running it
    compiled_entry = _COMPILED[key]
    return Entry(compiled_entry.address, parameters.ctypes.data) if compiled_entry else NO_ENTRY


def entries_of(function, arrays):
    """Return a function of a scene and its parameters that gives the Entry of `function`; arrays : as for `entry`."""
    return lambda scene, parameters: entry(function, scene, arrays, parameters)


def invoke(code, parameters, arrays, integer):
    """Call the code behind an Entry with a tuple of arrays and an integer."""
    if code in _PLAIN:
        function, parameters_id = _PLAIN[code]
        function((_SCENES[parameters_id],), *arrays, integer)
    else:
        objects.function_at(int(code), len(arrays))(int(parameters), *(array.ctypes.data for array in arrays), integer)


def invoke_each(code, parameters, arrays, integer):
    """Call the code behind an Entry as `invoke` does, for each row of the arrays; only for calls from Python."""
    if code in _PLAIN:
        for rows in zip(*arrays, strict=True):
            invoke(code, parameters, rows, integer)
        return
    function = objects.function_at(int(code), len(arrays))
    address_strides = [(a.ctypes.data, a.strides[0]) for a in arrays]
    for row in range(len(arrays[0])):
        function(int(parameters), *[address + row * stride for address, stride in address_strides], integer)


@register_emitter(invoke)
def _emit_call(code, parameters, arrays, integer):
    call_at(code, parameters, tuple(arrays), integer)


class Routine:
    """Compiled code of arrays alone, without a scene: the same for all cases, and part of the package."""

    ALL: ClassVar[list["Routine"]] = []  # of the modules that are imported

    def __init__(self, function, items):
        """Declare `function(*arrays, integer)`; items : a letter per array, 'f' for float64, 'i' for int64."""
        self.function, self.items = function, items
        self._code = []  # the first is used; never removed: another thread may be running it
        self.ALL.append(self)

    def compile(self):
        """Return the machine code, or None while code is compiled for another machine."""
        if not self._code:
            code = objects.compiled_routine(self.function, self.items)
            if code is None:
                return None
            self._code.append(code)
        return self._code[0]

    def __call__(self, arrays, integer):
        """Run it with contiguous arrays of numpy or ctypes."""
        if is_plain():
            self.function(*arrays, integer)
            return
        addresses = [x.ctypes.data if isinstance(x, np.ndarray) else ctypes.addressof(x) for x in arrays]
        objects.function_at(self.compile().address, len(arrays))(0, *addresses, integer)


def shaped(array, shape):
    """Return an argument of an entry as an array of `shape`: compiled code receives bare pointers."""
    return array


register_emitter(shaped)(view_at)
