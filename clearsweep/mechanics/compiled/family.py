"""How the type of a value chooses the code, and how the integrator, compiled once, calls the code so chosen.

A *family* is a function with one body per type of its first argument.  A scene is a NamedTuple of NamedTuples of
floats: its types select the bodies and so decide what is compiled, its values are the parameters.  The integrator does
not depend on the scene's type: it is handed the address of an *entry*, the compiled code of one scene type, and the
address of the scene's parameters.  A further law therefore compiles its own scene alone, in half a second.
"""

import contextlib
import contextvars
import functools
import itertools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..trace import objects
from ..trace.memory import call_at, viewed
from ..trace.primitives import ON_ITS_OWN, primitive, traceable
from .plain import is_plain


def kernel(function):
    """Return `function`, marked to become a function of machine code; from Python it runs as Python."""
    return traceable(function, ON_ITS_OWN)


def inlined(function):
    """Return `function` like `kernel`, but as a part of its callers: scenes and loads are costly to hand over."""
    return traceable(function)


def family(stub):
    """Return `stub` as a function whose code is chosen by the type of its first argument.

    `@stub.member(cls)` enters the code for `cls`, a NamedTuple; for None, that for all types not entered.  A field that
    is a plain tuple may narrow it: `member(cls, field=(A, None))` is for values whose field has an `A` and anything;
    the first one entered that fits is taken.  In compiled code the choice costs nothing and only the chosen body is
    compiled; with NUMBA_DISABLE_JIT=1 the same bodies run as plain Python.
    """
    members = {}
    fields, bodies = {}, {}  # the fields that narrow a class; bodies by class and types in these: looked up at once

    @functools.wraps(stub)
    def dispatch(first, *rest):
        form = type(first)
        if form not in fields:
            narrowed = [field for narrowed, _ in members.get(form, members.get(None, ())) for field in narrowed]
            fields[form] = tuple(dict.fromkeys(narrowed))
        if fields[form]:
            form = (form, *[tuple(map(type, getattr(first, field))) for field in fields[form]])
        if form not in bodies:
            bodies[form] = _body_of(members, first)
        return bodies[form](first, *rest)

    def member(cls, **narrowed):
        def enter(body):
            members.setdefault(cls, []).append((narrowed, body))
            fields.clear()
            bodies.clear()
            return body

        return enter

    dispatch.member, dispatch.members, dispatch.body_for = member, members, functools.partial(_body_for, members)
    dispatch.body_of = functools.partial(_body_of, members)
    return dispatch


def _chosen(members, cls, classes):
    """Return the body for a class, or None; `classes(field)` : the classes of the items of a field."""
    for narrowed, body in members.get(cls, members.get(None, ())):
        if all(_fits(wanted, tuple(classes(field))) for field, wanted in narrowed.items()):
            return body
    return None


def _body_of(members, value):
    """Return the body for a value, or None."""
    return _chosen(members, type(value), lambda field: map(type, getattr(value, field)))


def _body_for(members, cls):
    """Return the body for a class that no field narrows, as a function of Python."""
    ((_, body),) = members.get(cls, members.get(None))
    return body


def _fits(wanted, classes):
    return all(cls in (None, there) for cls, there in zip(wanted, classes, strict=True))


def map_joints(function, following):
    """Return a function that calls `function` for every joint of a tuple, or for every part of a joint.

    It takes (items, partners, place, shared), two tuples in step and two values of any kind, and returns the tuple of
    `function(item, partner, place, shared)`.  `place` is the one given for the first item, and `following(place, item)`
    after each.  The items may differ in type, so that each gets code of its own; both functions are kernels.
    """

    def mapped(items, partners, place, shared):
        results = []
        for item, partner in zip(items, partners, strict=True):
            results.append(function(item, partner, place, shared))
            place = following(place, item)
        return tuple(results)

    mapped.each = function, following
    return mapped


class Entry(NamedTuple):
    """Where the compiled code of a scene type and the parameters of a scene are; 0 where there is none."""

    code: int
    parameters: int


NO_ENTRY = Entry(0, 0)


def flatten(value):
    """Return the numbers of nested tuples of floats as a (numbers,) float64 array, in the order compiled code reads."""
    return np.array(numbers_of(value), dtype=np.float64)


def numbers_of(value):
    """Return the same as a list, which is not to be changed."""
    return _read(value)[2]


def put_numbers(scene, numbers, parameters):
    """Let the entries that were made with the array `parameters` be those of another scene of the same type.

    numbers : those of the scene, see `numbers_of`.
    """
    parameters[:] = numbers
    if is_plain():
        _SCENES[id(parameters)] = scene


_PLAIN = {}  # what is behind an Entry where nothing is compiled: code -> (function, id of the parameters)
_SCENES = {}  # and the scene of these parameters


_COMPILED = {}  # (function, number of the form of the scene, width) -> its machine code, or None if there is none
_EMPTY = contextvars.ContextVar("_EMPTY", default=False)


@contextlib.contextmanager
def empty_entries() -> Iterator[None]:
    """Within, entries lead nowhere and nothing is compiled for them: for values that are looked at for their types."""
    token = _EMPTY.set(True)
    try:
        yield
    finally:
        _EMPTY.reset(token)


_LATEST = [(None, 0, [])]  # the scene that was asked about last, its number and its numbers: it is asked about often
_NUMBERED: dict[tuple, int] = {}  # kinds of scenes
_NUMBERS = itertools.count()  # no number twice, whichever threads ask at a time


def form_number(scene):
    """Return a number that scenes have together whose `kinds` are the same; it is looked up faster than these."""
    return _read(scene)[1]


def _read(scene):
    """Return a scene, the number of its kinds, and its numbers."""
    latest = _LATEST[0]
    if latest[0] is not scene:
        numbers: list[float] = []
        form = _walk(scene, numbers)
        _LATEST[0] = latest = scene, _NUMBERED.setdefault(form, next(_NUMBERS)), numbers
    return latest


def kinds(value):
    """Return the types in nested tuples."""
    return _walk(value, [])


def _walk(value, numbers):
    """Return the same, and add the numbers in them to a list, in their order."""
    form = (type(value), *map(type, value))
    if form not in _TUPLES:
        _TUPLES[form] = tuple(place for place, part in enumerate(value) if isinstance(part, tuple))
    tuples = _TUPLES[form]
    if not tuples:  # as of most
        numbers += value
        return form
    inside, first = [form], 0
    for place in tuples:
        numbers += value[first:place]
        inside.append(_walk(value[place], numbers))
        first = place + 1
    numbers += value[first:]
    return tuple(inside)


_TUPLES: dict[tuple, tuple[int, ...]] = {}  # types of a tuple and of what is in it -> where tuples are in it


def entry(function, scene, arrays, parameters):
    """Return the Entry through which `invoke` calls `function(scene pointer, *arrays, integer)`.

    arrays : kinds of the items of the arrays, 'f' for float64, 'i' for int64; parameters : the array that
    `flatten(scene)` gave, which the caller keeps as long as the Entry is in use.
    """
    if _EMPTY.get():
        return NO_ENTRY
    if is_plain():
        code = hash((function, id(parameters)))
        _PLAIN[code], _SCENES[id(parameters)] = (function, id(parameters)), scene
        return Entry(code, 0)
    key = function, form_number(scene)
    if key not in _COMPILED:
        _COMPILED[key] = objects.compiled(function, scene, kinds(scene), arrays)
    made = _COMPILED[key]
    return Entry(made.address, parameters.ctypes.data) if made else NO_ENTRY


def invoke(code, parameters, arrays, integer):
    """Call the code behind an Entry with a tuple of arrays and an integer."""
    if code in _PLAIN:
        function, known_by = _PLAIN[code]
        function((_SCENES[known_by],), *arrays, integer)
    else:
        objects.function_at(int(code), len(arrays))(int(parameters), *(array.ctypes.data for array in arrays), integer)


@primitive(invoke)
def _emit_call(code, parameters, arrays, integer):
    call_at(code, parameters, arrays.made() if hasattr(arrays, "made") else arrays, integer)


def pointer_to(value):
    """Return what gives `value` by `[0]`: a pointer in compiled code, good until the calling function returns."""
    return (value,)


def shaped(array, shape):
    """Return what an entry was passed as an array of `shape`: compiled code gets bare pointers."""
    return array


primitive(shaped)(viewed)
