"""Numbers in arrays that have names: the same bodies with arrays of numpy and as machine code."""

import numpy as np
import pytest

from clearsweep.tracing.compiled.family import kernel
from clearsweep.tracing.memory import Fields
from clearsweep.tracing.objects import machine_code
from clearsweep.tracing.symbols import NotTraceableError


class Tank(Fields):
    """The state of a tank."""

    level: float  # m
    inflow: float  # m/s


class FillCounts(Fields):
    """Counts."""

    fillings: int
    overflows: int


@kernel
def fill(tank, height):
    """Let a tank rise by its inflow; return whether it overflows."""
    tank.level += tank.inflow
    if tank.level > height:
        tank.level = height
        return True
    return False


def fillings(tanks, counted, height):
    """Fill both tanks three times; return the level of the first."""
    state, counts = Tank(tanks), FillCounts(counted)
    for _ in range(3):
        counts.fillings += 1
        for j in range(2):
            if fill(state[j], height):
                counts.overflows = counts.overflows + 1
    return state[0].level


@pytest.mark.parametrize("how", [machine_code(fillings), fillings])
def test_a_body_changes_named_numbers_and_rows_of_them(how):
    tanks, counted = Tank.zeros(2), FillCounts.zeros()
    tanks.column("inflow")[:] = 0.25, 0.5
    assert how(tanks.numbers, counted.numbers, 1.0) == 0.75
    assert tanks.column("level").tolist() == [0.75, 1.0]
    assert tanks[1].level == 1.0
    assert (counted.fillings, counted.overflows) == (3, 1)


def test_memory_follows_from_the_declaration():
    assert Tank.SIZE == 2
    assert FillCounts.zeros().numbers.dtype == np.int64
    assert Tank.zeros(3).numbers.shape == (3, 2)
    assert Tank.index_of("inflow") == 1


def test_a_further_record_adds_its_own_numbers():
    class Heated(Tank):
        heat: float  # J

    assert Heated.SIZE == 3
    assert [Heated.index_of(name) for name in ("level", "inflow", "heat")] == [0, 1, 2]


def test_rows_have_no_number_of_their_own():
    with pytest.raises(AttributeError, match="several rows"):
        _ = Tank.zeros(2).level


def test_numbers_of_two_kinds_are_refused():
    with pytest.raises(ValueError, match="too many values"):
        type("Mixed", (Fields,), {"__annotations__": {"a": float, "b": int}})


def test_an_attribute_that_is_no_number_is_not_assigned():
    def misspelt(tanks):
        Tank(tanks).levle = 2.0

    with pytest.raises(AttributeError, match="levle"):
        misspelt(np.zeros(2))
    with pytest.raises(NotTraceableError, match="assigns an attribute that is no number in memory"):
        machine_code(misspelt)(np.zeros(2))
