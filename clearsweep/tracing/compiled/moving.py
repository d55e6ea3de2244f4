"""A state with time derivatives as slopes, so that derived quantities also have their rates."""

from ..protocols import Composite
from .dual import Dual


class Moving(Composite):
    """A state of coordinates, their rates and time that moves with `accelerations`; `[i]` returns Duals.

    values : (2 n + 1 or more,) numbers, or Duals for second derivatives; accelerations : tuple of n numbers.
    """

    __slots__ = ("accelerations", "values")

    def __init__(self, values, accelerations):
        self.values, self.accelerations = values, accelerations

    def traced_parts(self):
        """Return the components."""
        return self.values, self.accelerations

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


Moving.traced_item = staticmethod(moving_item)
