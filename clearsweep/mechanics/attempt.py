"""A step of the explicit method as one piece of compiled code: its stages and its end.

The right-hand side is in it once, so that the same code evaluates it alone, too.

The same functions, on numbers in lanes, make it for one case and for as many as lie side by side.  Every operation and
its rounding is fixed by them, see `compiled.lanes`: by which of the two a step was taken cannot be told from its bits.
"""

import numba
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .carried import carried
from .compiled.family import NO_ENTRY, WIDTH, Entry, entry, form_number, inlined
from .compiled.lanes import LanesType, WholesType
from .compiled.rows import RowsType, place_in, rows_at
from .joint.places import observed_columns, room_of_all
from .observe.along import LENGTH, WHOLE, Attempt, keep_last_stage, step_width
from .rates import RATES_ARRAYS, rates
from .solver.dop853 import END, stage_state


@inlined
def _take(scene, tried, only):
    """Fill rows 1 to END of rates and observables, `end` getting the state of each.

    `only` : the row that is filled for the state that `end` has, or WHOLE.
    """
    first, last = (1, END) if only == WHOLE else (only, only)
    for row in range(first, last + 1):
        if only == WHOLE:
            if row == END:
                keep_last_stage(tried, tried.end)
            stage_state(row, tried.step[LENGTH], tried.y, tried.k, tried.end)
        rates(scene, tried.end, tried.mode, tried.latched, tried.k, tried.o, row)


def _in_lanes(kind, width):
    """Return the type of a scene whose numbers stand in lanes."""
    if isinstance(kind, types.BaseTuple):
        items = [_in_lanes(item, width) for item in kind.types]
        if isinstance(kind, types.BaseNamedTuple):
            return types.NamedTuple(items, kind.instance_class)
        return types.BaseTuple.from_types(items)
    return LanesType(width)


@intrinsic(prefer_literal=True)
def _scene_at(typing_context, scene, width):
    """Emit the scene whose numbers stand in lanes from a pointer on."""
    form, kind = _in_lanes(scene.dtype, width.literal_value), LanesType(width.literal_value)

    def emit(context, builder, signature, values):
        read = iter(range(1 << 20))

        def made(part):
            if isinstance(part, types.BaseTuple):
                return context.make_tuple(builder, part, [made(item) for item in part.types])
            return builder.load(place_in(builder, values[0], kind, ir.IntType(64)(next(read))))

        return made(form)

    return form(scene, width), emit


@intrinsic(prefer_literal=True)
def _attempt_at(typing_context, scene, pointers, width):
    """Emit the Attempt whose arrays are rows from pointers on."""
    numbers, wholes = LanesType(width.literal_value), WholesType(width.literal_value)
    joints = scene.dtype.types[scene.dtype.fields.index("joints")]
    size = room_of_all(joints)
    count = len(scene.dtype.types[scene.dtype.fields.index("coordinates")])
    n = 2 * count + 1 + size.contact + size.internal
    columns = {
        "mode": size.contact,
        "latched": size.contact + size.latched,
        "o": observed_columns(joints),
        "step": step_width(size.contact, n),
    }
    forms = [RowsType(wholes if name == "mode" else numbers) for name in Attempt._fields]
    result = types.NamedTuple(forms, Attempt)

    def emit(context, builder, signature, values):
        rows = []
        for place, (form, name) in enumerate(zip(forms, Attempt._fields, strict=True)):
            pointer, wide = builder.extract_value(values[1], place), ir.IntType(64)(columns.get(name, n))
            rows.append(rows_at(context, builder, form, pointer, wide))
        return context.make_tuple(builder, result, rows)

    return result(scene, pointers, width), emit


def _entry_for(width):
    """Return the function that takes a step of `width` cases side by side."""

    def attempt_entry(scene, y, mode, latched, weight, k, o, end, step, row):
        """Take a step, or fill a `row`, with parameters and arrays from bare pointers."""
        tried = _attempt_at(scene, (y, mode, latched, weight, k, o, end, step), width)
        _take(_scene_at(scene, width), tried, row)

    return attempt_entry


_one, _all = _entry_for(1), _entry_for(WIDTH)

_carried: dict[int, bool] = {}  # by the number of the form of scenes, as it takes long to find out


def _entry_of(function, scene, parameters):
    """Return the Entry of a function of `_entry_for`; NO_ENTRY of a scene that is not `carried`, or not compiled."""
    if numba.config.DISABLE_JIT:
        return NO_ENTRY
    form = form_number(scene)
    if form not in _carried:
        _carried[form] = carried(scene)
    return entry(function, scene, RATES_ARRAYS, parameters) if _carried[form] else NO_ENTRY


def attempt_of(scene, parameters) -> Entry:
    """Return the Entry that evaluates and takes steps of `scene`, whose parameters are in a lane."""
    return _entry_of(_one, scene, parameters)


def together_of(scene, parameters) -> Entry:
    """Return the Entry that takes a step of WIDTH scenes of the type of `scene`, `parameters` being the first's."""
    return _entry_of(_all, scene, parameters)
