"""The arrays of an integration: their shapes, their memory, the names of their numbers."""

import itertools
import math
from typing import Any

import numpy as np

from ...mechanics import observe
from ...mechanics.coupling.rates import observed_width
from ...mechanics.joints.contract import every_contact
from ...mechanics.observe import ROW_COUNT, STAGES
from ...mechanics.solver import integration
from ...mechanics.solver.accumulate import totals as total_columns
from ...mechanics.solver.accumulate.step_sums import ContactStep, Step
from ...mechanics.solver.bernstein import COEFFICIENTS, ROWS
from ...tracing.fields import Fields
from ...tracing.symbols import WIDTH
from .initial import initial_shapes
from .scene import Scene

BLOCK_BYTES = 16384  # bytes: need of a short motion without histograms

Arrays = dict[str, np.ndarray]  # name of a field of Work, Totals or RevolutionMarks -> array


def arrays_of(scene: Scene) -> Arrays:
    """Return the arrays that a step of `scene` uses, as zeros, and `initial_values`, all initial ones in one array."""
    contacts, n = len(every_contact(scene.value.joints)), scene.start.size
    initial_array_shapes: dict[str, tuple[int, ...]] = {
        **initial_shapes(scene.value, scene.start),
        "stepper": (integration.Stepper.SIZE,),
        **dict.fromkeys(("step_peak", "peak_since_mark"), (contacts,)),
        "mechanism": (total_columns.MechanismTotals.SIZE,),
        "joint": (contacts, total_columns.ContactTotals.SIZE),
    }
    step_array_shapes = {
        "k": (n, ROW_COUNT),
        "o": (observed_width(scene.value), ROW_COUNT),
        "nodes": (n + 1, STAGES),
        "f": (n, STAGES),
        "polynomials": (ROWS, COEFFICIENTS),
        "step": (Step.SIZE,),
        "contact_steps": (contacts, ContactStep.SIZE),
        "profiles": (1 + contacts, observe.PARTS + 1),
        "part_times": (contacts, total_columns.PART_TIME_ROWS, observe.PARTS),
        "end": (n,),
        "z": (n,),
    }
    numbers, arrays = np.zeros(sum(map(math.prod, initial_array_shapes.values()))), dict[str, np.ndarray]()
    ends = itertools.accumulate(map(math.prod, initial_array_shapes.values()))
    for (name, shape), end in zip(initial_array_shapes.items(), ends, strict=True):
        arrays[name] = numbers[end - math.prod(shape) : end].reshape(shape)
    arrays |= {name: _aligned(shape) for name, shape in step_array_shapes.items()}
    integer_array_shapes = {
        "mode": (contacts,),
        "has_friction": (contacts,),
        "bins": (contacts, total_columns.BIN_COLUMNS),
    }
    return (
        arrays
        | {name: np.zeros(shape, np.int64) for name, shape in integer_array_shapes.items()}
        | {"initial_values": numbers}
    )


def _aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Return zeros that are aligned for vector registers."""
    numbers = np.zeros(math.prod(shape) + WIDTH)
    begin = -numbers.ctypes.data // 8 % WIDTH
    return numbers[begin : begin + math.prod(shape)].reshape(shape)


def fields_from(record_type: type, arrays: Arrays) -> dict[str, Any]:
    """Return the arrays that are fields of a NamedTuple, with names for their numbers if the type defines them."""
    types = record_type.__annotations__
    return {
        name: types[name](arrays[name]) if issubclass(types[name], Fields) else arrays[name]
        for name in types
        if name in arrays
    }


class Memory:
    """Arrays that start as zeros, cut from a few large blocks so that they are cleared quickly."""

    def __init__(self) -> None:
        self.blocks: list[np.ndarray] = []
        self.bytes_used = 0  # bytes used of the latest block

    def zeros(self, shape: int | tuple[int, ...], dtype: Any = float) -> np.ndarray:
        """Return an array of zeros."""
        byte_count = math.prod(shape if isinstance(shape, tuple) else (shape,)) * np.dtype(dtype).itemsize
        if not self.blocks or self.bytes_used + byte_count > BLOCK_BYTES:
            self.blocks.append(np.zeros(max(byte_count, BLOCK_BYTES), np.uint8))
            self.bytes_used = 0
        begin, self.bytes_used = self.bytes_used, self.bytes_used + -(-byte_count // 8) * 8
        array: np.ndarray = self.blocks[-1][begin : begin + byte_count].view(dtype).reshape(shape)
        return array

    def clear(self) -> None:
        """Set all arrays to zero."""
        for block in self.blocks:
            block.fill(0)
