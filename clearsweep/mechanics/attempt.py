"""A step as one piece of compiled code: its stages, its end, its error; of one case, or of several side by side.

Both are made of the same functions, on numbers or on numbers side by side, and round alike: which of them took a step
cannot be told from what came out.
"""

from typing import NamedTuple

import llvmlite.binding as llvm
import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .carried import carried
from .compiled.dual import as_type_of
from .compiled.family import NO_ENTRY, Entry, entry, inlined, shaped
from .compiled.lanes import LanesType, WholesType
from .compiled.rows import RowsType, new_rows, put_back, taken
from .joint.places import room_of_all
from .observe.along import ERROR, LENGTH, RISE, RUN, SUMS, follow_along, step_width, sum_along
from .observe.observables import CONTACT_WIDTH, CONTACTS, columns
from .rates import rates, size_of
from .solver.dop853 import END, ROWS, WEIGHTS, error_norm, stage_state

#: The arrays of a case in the table of addresses, in this order.
PARAMETERS, STATE, MODE, LATCHED, SCALE, RATES, OBSERVED, STOP, STEP, ARRAYS = range(10)


#: Which rows of the arrays that a step fills are wanted after it.
HANDED_OUT = {RATES: ((5, END + 1),), OBSERVED: ((3, 4), (5, END + 1)), STOP: ((0, 1),), STEP: ((0, 1),)}


class Arrays(NamedTuple):
    """What a step is made from and what it makes; see `event.Work`."""

    y: tuple
    mode: tuple
    latched: tuple
    scale: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple


@inlined
def _stage(scene, arrays, row):
    """Fill a row of rates and observables; `end` gets the state there."""
    stage_state(row, arrays.step[LENGTH], arrays.y, arrays.k, arrays.end)
    rates(scene, arrays.end, arrays.mode, arrays.latched, arrays.k, arrays.o, row)


@inlined
def _keep_last_stage(arrays):
    for i in range(arrays.end.size):
        arrays.step[SUMS + i] = arrays.end[i]


@inlined
def _stages_in_turn(scene, arrays):
    for row in range(1, END):
        _stage(scene, arrays, row)
    _keep_last_stage(arrays)  # lies at the end of the step, too
    _stage(scene, arrays, END)


@inlined
def _stages_written_out(scene, arrays):
    """Do the same, a tenth faster for a single case, whose stages are short against the way through a loop."""
    _stage(scene, arrays, 1)
    _stage(scene, arrays, 2)
    _stage(scene, arrays, 3)
    _stage(scene, arrays, 4)
    _stage(scene, arrays, 5)
    _stage(scene, arrays, 6)
    _stage(scene, arrays, 7)
    _stage(scene, arrays, 8)
    _stage(scene, arrays, 9)
    _stage(scene, arrays, 10)
    _stage(scene, arrays, 11)
    _keep_last_stage(arrays)
    _stage(scene, arrays, END)


@inlined
def _sum_up(scene, arrays):
    """Put into `step` what a step comes to whose rows 0 to END are filled, see `observe.along`."""
    k, o, end, step = arrays.k, arrays.o, arrays.end, arrays.step
    contacts, n, _ = size_of(scene)
    rise = run = as_type_of(0.0, step[LENGTH])
    for i in range(n):
        inverse = 1.0 / arrays.scale[i]
        steeper, farther = (k[END, i] - k[END - 1, i]) * inverse, (end[i] - step[SUMS + i]) * inverse
        rise, run = rise + steeper * steeper, run + farther * farther
    step[RISE], step[RUN] = rise, run
    step[ERROR] = error_norm(step[LENGTH], k, arrays.scale)
    sum_along(o, contacts, step, WEIGHTS)
    follow_along(o, contacts, step)


def attempt_entry(scene, y, mode, latched, scale, k, o, end, step, _):
    """Take a step of one case with arrays from bare pointers."""
    here = scene[0]
    contacts, n, latching = size_of(here)
    arrays = Arrays(
        shaped(y, (n,)),
        shaped(mode, (contacts,)),
        shaped(latched, (latching,)),
        shaped(scale, (n,)),
        shaped(k, (ROWS, n)),
        shaped(o, (ROWS, columns(contacts))),
        shaped(end, (n,)),
        shaped(step, (step_width(contacts, n),)),
    )
    _stages_written_out(here, arrays)
    _sum_up(here, arrays)


# ---------------------------------------------------------------------------------------------- side by side


def _lanes_form(kind, width):
    """Return the type of a scene whose numbers stand side by side."""
    if isinstance(kind, types.BaseTuple):
        items = [_lanes_form(item, width) for item in kind.types]
        if isinstance(kind, types.BaseNamedTuple):
            return types.NamedTuple(items, kind.instance_class)
        return types.BaseTuple.from_types(items)
    return LanesType(width)


def _numbers_in(kind):
    return sum(map(_numbers_in, kind.types)) if isinstance(kind, types.BaseTuple) else 1


def _sizes(scene):
    """Return how many contacts, components of the state, latched numbers and observables a scene's type has."""
    size = room_of_all(scene.types[scene.fields.index("joints")])
    count = len(scene.types[scene.fields.index("coordinates")])
    n = 2 * count + 1 + size.contact + size.internal
    return size.contact, n, size.contact + size.latched, CONTACTS + CONTACT_WIDTH * size.contact


def _addresses(builder, table, width, which):
    return [builder.load(builder.gep(table, [ir.IntType(64)(lane * ARRAYS + which)])) for lane in range(width)]


@intrinsic(prefer_literal=True)
def _scene_of(typing_context, scene, table, width):
    """Emit the scene whose numbers are those of each lane."""
    form, kind = _lanes_form(scene.dtype, width.literal_value), LanesType(width.literal_value)

    def emit(context, builder, signature, values):
        numbers = iter(taken(builder, kind, _addresses(builder, values[1], kind.width, PARAMETERS), _numbers_in(form)))

        def made(part):
            if isinstance(part, types.BaseTuple):
                return context.make_tuple(builder, part, [made(item) for item in part.types])
            return next(numbers)

        return made(form)

    return form(scene, table, width), emit


@intrinsic(prefer_literal=True)
def _arrays_of(typing_context, scene, table, width):
    """Emit the Arrays of the cases, on the stack, filled as far as a step needs."""
    kind, wholes = LanesType(width.literal_value), WholesType(width.literal_value)
    contacts, n, latching, seen = _sizes(scene.dtype)
    wide = step_width(contacts, n)
    forms = {
        STATE: (RowsType(kind, n), n, 1),
        MODE: (RowsType(wholes, contacts), contacts, 1),
        LATCHED: (RowsType(kind, latching), latching, 1),
        SCALE: (RowsType(kind, n), n, 1),
        RATES: (RowsType(kind, n), n, END + 1),
        OBSERVED: (RowsType(kind, seen), seen, END + 1),
        STOP: (RowsType(kind, n), 0, 1),
        STEP: (RowsType(kind, wide), 1, 1),
    }
    result = types.NamedTuple([form for form, _, _ in forms.values()], Arrays)

    def emit(context, builder, signature, values):
        made = []
        for which, (form, given, count) in forms.items():
            rows = new_rows(builder, form, count * form.columns)
            addresses = _addresses(builder, values[1], kind.width, which)
            for place, value in enumerate(taken(builder, form.several, addresses, given)[:given]):
                builder.store(value, builder.gep(rows, [ir.IntType(64)(place)]))
            made.append(rows)
        return context.make_tuple(builder, result, made)

    return result(scene, table, width), emit


@intrinsic(prefer_literal=True)
def _hand_out(typing_context, table, arrays):
    """Emit what puts the results into the arrays of each case."""

    def emit(context, builder, signature, values):
        kind = arrays.types[0].several
        for which, parts in HANDED_OUT.items():
            form, rows = arrays.types[which - STATE], builder.extract_value(values[1], which - STATE)
            for first, last in parts:
                places = range(first * form.columns, last * form.columns)
                found = [builder.load(builder.gep(rows, [ir.IntType(64)(place)])) for place in places]
                put_back(builder, kind, _addresses(builder, values[0], kind.width, which), places[0], found)
        return context.get_dummy_value()

    return types.void(table, arrays), emit


def _entry_for(width):
    """Return the function that takes a step of `width` cases side by side."""

    def lanes_entry(scene, table, _):
        """Take a step of cases whose arrays, and the parameters before them, are where a table (lanes, ARRAYS) says."""
        arrays = _arrays_of(scene, table, width)
        here = _scene_of(scene, table, width)
        _stages_in_turn(here, arrays)
        _sum_up(here, arrays)
        _hand_out(table, arrays)

    return lanes_entry


#: How many cases go side by side where the processor's registers hold eight numbers, and elsewhere.
WIDTH = 8 if llvm.get_host_cpu_features().get("avx512f") else 4
_lanes_entry = _entry_for(WIDTH)


def attempt_of(scene, parameters) -> Entry:
    """Return the Entry that takes a step of `scene`."""
    return entry(attempt_entry, scene, (types.float64, types.int64, *(types.float64,) * 6), parameters)


def lanes_of(scene, parameters) -> Entry:
    """Return the Entry that takes a step of WIDTH scenes of the type of `scene`; NO_ENTRY where they cannot."""
    if numba.config.DISABLE_JIT or not carried(scene):
        return NO_ENTRY
    return entry(_lanes_entry, scene, (types.int64,), parameters)


def addresses_of(parameters, work):
    """Return the addresses (ARRAYS,) of the parameters of a scene and of the arrays of its Work that a step needs."""
    arrays = (work.y, work.mode, work.latched, work.scale, work.k, work.o, work.end, work.step)
    return [array.ctypes.data for array in (parameters, *arrays)]
