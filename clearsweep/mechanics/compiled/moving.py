"""A state on its way: each component with its rate of time as slope, so that what follows from it has its rate too."""

import operator

from numba import types
from numba.extending import lower_builtin, make_attribute_wrapper, models, overload, register_model, type_callable

from .dual import Dual, construct
from .family import OPTIONS


class Moving:
    """A state of coordinates, their rates and time that moves with `accelerations`; it gives Duals by `[i]`.

    values : (2 n + 1 or more,) numbers, Duals where the rate is differentiated too; accelerations : tuple of n numbers.
    """

    __slots__ = ("accelerations", "values")

    def __init__(self, values, accelerations):
        self.values, self.accelerations = values, accelerations

    def __getitem__(self, i):
        return moving_item(self, i)


def moving_item(state, i):
    """Return component `i` of a Moving state."""
    n = len(state.accelerations)
    if i < n:
        return Dual(state.values[i], state.values[n + i])
    if i < 2 * n:
        return Dual(state.values[i], state.accelerations[i - n])
    return Dual(state.values[i], 1.0)  # time


class MovingType(types.Type):
    """The compiler's type of a Moving state."""

    def __init__(self, values, accelerations):
        self.values, self.accelerations = values, accelerations
        super().__init__(f"Moving({values}, {accelerations})")


@register_model(MovingType)
class _MovingModel(models.StructModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, [("values", kind.values), ("accelerations", kind.accelerations)])


make_attribute_wrapper(MovingType, "values", "values")
make_attribute_wrapper(MovingType, "accelerations", "accelerations")


@type_callable(Moving)
def _type_moving(context):
    def typed(values, accelerations):
        return MovingType(values, accelerations)

    return typed


lower_builtin(Moving, types.Any, types.Any)(construct)


@overload(operator.getitem, strict=False, jit_options=dict(OPTIONS, forceinline=True))
def _item(state, i):
    return moving_item if isinstance(state, MovingType) else None
