"""A value that compiled code finds at an address, so that it can deal with several of one form in turn."""

import functools

import numpy as np
from numba import config, njit, types
from numba.core.registry import cpu_target
from numba.extending import NativeValue, intrinsic, models, overload, register_model, typeof_impl, unbox

from .family import OPTIONS

ROOM = 16384  # bytes that a value may take
_PLAIN = {}  # what is found at an address where nothing is compiled


class Kept:
    """A value and its address; it lives as long as this, and so does all that it refers to."""

    __slots__ = ("address", "numbers", "value")

    def __init__(self, value):
        room = np.empty(ROOM, dtype=np.uint8)
        self.value, self.numbers, self.address = value, room.view(np.float64), room.ctypes.data
        if config.DISABLE_JIT:
            _PLAIN[self.address] = value
        else:
            _put(value, room)

    def put(self, **numbers):
        """Put other numbers (float) into fields of the value; its address and all else stay."""
        if config.DISABLE_JIT:
            _PLAIN[self.address] = self.value = self.value._replace(**numbers)
            return
        fields, places = list(self.value), _places()
        for name, number in numbers.items():
            field, place = places[name]
            fields[field] = self.numbers[place] = number
        self.value = self.value._make(fields)


def found(model, address):
    """Return what gives, by `[0]`, the value at an address, which is of the form of the Kept `model`."""
    return (_PLAIN[address],)


class OneForm:
    """A compiled function whose arguments are of the same types in every call, such as one that is given a Kept.

    The compiler's own call finds out the types of all arguments each time, which takes longer than all else in it.
    """

    def __init__(self, function):
        self.function, self.body = function, None
        self.py_func, self.compile = function.py_func, function.compile

    def __call__(self, *arguments):
        if self.body:
            self.body(*arguments)
            return
        self.function(*arguments)
        (compiled,) = self.function.overloads.values()
        self.body = compiled.entry_point


def of_one_form(function):
    """Return a compiled function that returns nothing as a OneForm; where nothing is compiled, the function itself."""
    return function if config.DISABLE_JIT else OneForm(function)


class KeptType(types.Type):
    """The compiler's type of a Kept, of which it wants to know the type of the value alone."""

    def __init__(self, value):
        self.value = value
        super().__init__(f"Kept({value})")


register_model(KeptType)(models.OpaqueModel)


@intrinsic
def _store(typing_context, value, room):
    """Emit what puts a value into the memory of an array of bytes."""

    def emit(context, builder, signature, values):
        kind = signature.args[0]
        data = context.get_data_type(kind)
        size = context.get_abi_sizeof(data)
        assert size <= ROOM, size
        array = context.make_array(signature.args[1])(context, builder, values[1])
        context.pack_value(builder, kind, values[0], builder.bitcast(array.data, data.as_pointer()))
        return context.get_dummy_value()

    return types.void(value, room), emit


@njit(cache=True)
def _put(value, room):
    _store(value, room)


@typeof_impl.register(Kept)
def _typeof_kept(value, context):
    return _kind(len(_put.overloads))


@functools.cache  # what it is made of takes long to compare
def _kind(forms):
    """Return the type of what is kept; it is of one form, as nothing at an address says of which."""
    (signature,) = _put.nopython_signatures
    return KeptType(signature.args[0])


@functools.cache
def _places():
    """Return which fields of a Kept's value are numbers, and where in its room, in numbers of eight bytes, they are."""
    kind, context = _kind(len(_put.overloads)).value, cpu_target.target_context
    data = context.get_data_type(kind)
    fields = [(place, name) for place, name in enumerate(kind.fields) if kind.types[place] == types.float64]
    return {name: (place, data.get_element_offset(context.target_data, place) // 8) for place, name in fields}


@unbox(KeptType)
def _unbox_kept(kind, value, context):
    return NativeValue(context.context.get_constant_null(kind))


@intrinsic
def _at(typing_context, model, address):
    """Emit the pointer to a value."""
    pointer = types.CPointer(model.value)

    def emit(context, builder, signature, values):
        return builder.inttoptr(values[1], context.get_value_type(pointer))

    return pointer(model, types.int64), emit


@overload(found, strict=False, jit_options=dict(OPTIONS))
def _found(model, address):
    def compiled(model, address):
        return _at(model, address)

    return compiled
