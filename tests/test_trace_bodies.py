"""Statements and expressions of bodies do on symbols what Python does, one by one and in lanes that differ."""

import math
from pathlib import Path

import numpy as np
import pytest
from traced_states import aligned, observed, rates_of, states

from clearsweep import simulation
from clearsweep.grid import load
from clearsweep.mechanics.coupling import entries
from clearsweep.mechanics.observe import END, ERROR, ERROR_RATE, STAGES
from clearsweep.tracing import calls, objects
from clearsweep.tracing.compiled.choosing import cond, lane_range, rolled_range, table_item, where
from clearsweep.tracing.compiled.dual import Dual, slope
from clearsweep.tracing.compiled.family import form_number, inlined, kernel
from clearsweep.tracing.memory import Fields, View
from clearsweep.tracing.objects import machine_code
from clearsweep.tracing.symbols import DOUBLE, WIDTH, NotTraceableError

TABLE = np.array([[float(i * i), float(-i)] for i in range(8)])


@kernel
def returns_early(x, y):
    if x > 1.0:
        if y > x:
            return x * y
        x = x - 1.0
    elif y < 0.0:
        return -y
    z = x + y
    if z == 0.0:
        return 7.0
    return z


@kernel
def newton(x, y):
    """Root of x by Newton's method, each lane for as long as it needs."""
    a, root = abs(x) + 0.1, 1.0 + abs(y)
    for _ in range(40):
        better = 0.5 * (root + a / root)
        if abs(better - root) < 1e-14 * root:
            break
        root = better
    return root


@kernel
def leaves_from_within(x, y):
    total = 0.0
    for i in rolled_range(9):
        if x > 1.5 and i > 4:
            return total + 100.0
        if y < -1.0:
            continue
        total += x * (i + 1.0)
        if total > 12.0:
            break
    return total + y


@kernel
def counts(x, y):
    steps, z = 0, abs(x)
    while z > 0.1:
        z = z * 0.7 if y > 0.0 else z * 0.5
        steps += 1
    return steps + 1.0 * (steps % 3) + 10.0 * (steps // 3)


@kernel
def written_out(x, y):
    best, place = -math.inf, -1
    for i in range(4):
        value = x * i - y * i * i
        if value > best:
            best, place = value, i
    return best + 100.0 * place


@kernel
def tables_and_choices(x, y):
    row = int(min(max(abs(x) * 2.0, 0.0), 7.0))
    result = table_item(TABLE, row, 0) if y > 0.0 else table_item(TABLE, 7 - row, 1)
    return where(x < 0.0, result, -result) + (1.0 if 0.0 < x <= 1.0 or not y > -1.0 else 0.0)


@inlined
def _small(x, y):
    return x * x + y


@inlined
def _large(x, y):
    return math.sqrt(x) + y


_by_size = cond(_small, _large)


@kernel
def chooses(x, y):
    first, second = _pair(x, y)
    return _by_size(x < 1.0, (x, y)) + first * second


@kernel
def _pair(x, y):
    return (x, y) if x < y else (y, 1.0)


@kernel
def differentiated(x, y):
    z = Dual(x, 1.0)
    z = z * z if y > 0.0 else z + 3.0
    return slope(abs(z) ** 3 / (2.0 + z * z))


BODIES = (
    returns_early,
    newton,
    leaves_from_within,
    counts,
    written_out,
    tables_and_choices,
    chooses,
    differentiated,
)
DRAWN = np.random.default_rng(3)
CORNERS = np.array([0.0, 1.0, -1.0, 1.5, 2.0, -2.0, 0.5, 3.0])
INPUTS = [
    np.concatenate([CORNERS, DRAWN.uniform(-3.0, 3.0, 56)]),
    np.concatenate([-CORNERS, DRAWN.uniform(-3.0, 3.0, 56)]),
]


def machine(body, width):
    """Return a function of arrays of WIDTH numbers each: what machine code for so many at a time makes of them."""

    def entry(given, out, _):
        x, y = (View(given.base, DOUBLE, (2,), (WIDTH,), width)[i] for i in range(2))
        View(out.base, DOUBLE, (1,), (WIDTH,), width)[0] = calls.call(body, x, y)

    code = objects.load_object(objects.compile_object(str(objects.trace_body(entry, "f", width).module)))

    def run(x, y):
        given, out = aligned(np.array([x, y])), aligned(np.zeros(WIDTH))
        for lane in range(0, WIDTH, width):
            objects.function_at(code.address, 1)(given.ctypes.data + 8 * lane, out.ctypes.data + 8 * lane, 0)
        return out.copy()

    return run


@pytest.mark.parametrize("body", BODIES, ids=lambda body: body.__name__)
def test_a_body_does_on_symbols_what_it_does_in_python(body):
    first, eight = machine(body, 1), machine(body, WIDTH)
    for x, y in zip(*(values.reshape(-1, WIDTH) for values in INPUTS), strict=True):
        expected = [body(*pair) for pair in zip(x.tolist(), y.tolist(), strict=True)]
        assert first(x, y) == pytest.approx(expected, rel=1e-13, abs=1e-13)
        assert np.array_equal(first(x, y), eight(x, y))


@pytest.mark.parametrize("body", BODIES, ids=lambda body: body.__name__)
def test_a_lane_does_not_depend_on_its_neighbours(body):
    eight = machine(body, WIDTH)
    x, y = (values[:WIDTH].copy() for values in INPUTS)
    before = eight(x, y)
    x[1:], y[1:] = -2.5, 2.5
    assert eight(x, y)[0] == before[0]


@kernel
def floor_above_its_lowest_bit(x, y):
    return math.floor(x) // 2 + y


def test_floors_of_numbers_beyond_integers_are_the_same_in_lanes_as_in_turn():
    """As integers their lowest bits count, which numbers of this size do not have."""
    x = np.array([math.nan, math.inf, -math.inf, 2.0**63, -(2.0**63), 2.0**63 - 1024.0, -1e300, -0.5])
    first, eight = machine(floor_above_its_lowest_bit, 1), machine(floor_above_its_lowest_bit, WIDTH)
    halves = np.array([0.0, 2.0**62, -(2.0**62), 2.0**62, -(2.0**62), 2.0**62 - 512.0, -(2.0**62), -1.0])
    assert np.array_equal(eight(x, np.zeros(WIDTH)), halves)
    assert np.array_equal(first(x, np.zeros(WIDTH)), halves)


def test_what_cannot_be_traced_is_refused_with_file_line_and_statement():
    @kernel
    def odd(x, y):
        return math.gamma(x) + y

    with pytest.raises(
        NotTraceableError, match=r"test_trace_bodies\.py:\d+: odd cannot be traced: it calls math\.gamma"
    ):
        machine(odd, 1)


@kernel
def shifted_sums(buffer, x):
    """Put into the second row what the first row and a table give, times `x` where it is positive."""
    for i in lane_range(WIDTH):
        here = buffer[i] + TABLE[i, 1]
        here = here * x if here > 0.0 else here - buffer[i + 1]
        buffer[WIDTH + i] = helped(buffer, i, here)


@kernel
def helped(buffer, i, here):
    return here + buffer[i + 2]


def test_turns_that_are_run_at_once_do_what_they_do_one_by_one():
    def entry(given, _):
        buffer = View(given.base, DOUBLE, (2 * WIDTH,), (1,))
        calls.call(shifted_sums, buffer, buffer[0])

    code = objects.load_object(objects.compile_object(str(objects.trace_body(entry, "", 1).module)))
    for seed in range(5):
        buffer = aligned(np.random.default_rng(seed).uniform(-9.0, 9.0, 2 * WIDTH))
        buffer[WIDTH:] = 0.5  # so that what turns read of the second row is as it was before the first
        plain = buffer.copy()
        expected = [_turn(plain, i) for i in range(WIDTH)]
        objects.function_at(code.address, 0)(buffer.ctypes.data, 0)
        assert buffer[WIDTH:] == pytest.approx(expected, rel=1e-14)
        assert np.array_equal(buffer[:WIDTH], plain[:WIDTH])


def _turn(buffer, i):
    here = buffer[i] + TABLE[i, 1]
    return (here * buffer[0] if here > 0.0 else here - buffer[i + 1]) + buffer[i + 2]


def test_turns_at_once_are_as_many_as_there_are_lanes():
    @kernel
    def three(x, y):
        for i in lane_range(3):
            x = x + i
        return x + y

    with pytest.raises(NotTraceableError, match="other than 8 iterations at once"):
        machine(three, 1)


@kernel
def root_of_what_is_left(x, y):
    if x > 1.0:
        return y
    return math.sqrt(y - x)


def test_what_follows_a_return_runs_only_if_a_lane_is_left():
    """The root is behind a second branch: the first one skips what returns."""

    def entry(given, out, _):
        x, y = (View(given.base, DOUBLE, (2,), (WIDTH,), WIDTH)[i] for i in range(2))
        View(out.base, DOUBLE, (1,), (WIDTH,), WIDTH)[0] = calls.call(root_of_what_is_left, x, y)

    before_root, _, _ = str(objects.trace_body(entry, "f", WIDTH).module).partition("@sqrt")
    assert before_root.count("br i1") == 2


# ---------------------------------------------------------------------------------------------- numbers with names


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


# ---------------------------------------------------------------------------------------------- stages and examples


CONFIGS = sorted(path.name for path in (Path(__file__).parents[1] / "configs").glob("*.yaml"))
MOST = 3  # kinds of scenes of a grid that are looked at


def scenes(name):
    """Yield the scenes of a grid of `configs`, one of each kind."""
    grid, seen = load(Path(__file__).parents[1] / "configs" / name, simulation.catalogue()), set()
    for i in range(min(len(grid), 64)):
        scene = simulation.build(grid.case(i))
        if form_number(scene.value) not in seen and len(seen) < MOST:
            seen.add(form_number(scene.value))
            yield scene


@pytest.mark.few("slider_crank.yaml", "two_joints.yaml", "lubricated.yaml", "worn_slider_crank.yaml", "four_bar.yaml")
@pytest.mark.parametrize("name", CONFIGS)
def test_all_stages_observed_at_once_have_the_bits_of_each_in_every_example(name):
    for scene in scenes(name):
        for seed in (7, 8):
            state = states(scene, seed)
            each, together = rates_of(scene, state).o, observed(scene, state).o
            each[[ERROR, ERROR_RATE], :END] = 0.0  # looked up at the end alone
            np.testing.assert_array_equal(each, together)


@pytest.mark.few("slider_crank.yaml", "lubricated.yaml", "worn_slider_crank.yaml", "spatial_four_bar.yaml")
@pytest.mark.parametrize("name", CONFIGS)
def test_machine_code_does_what_the_body_does(name):
    """To rounding: where nothing fuses, sums of products differ in their last digits, and what cancels by more."""
    for scene in scenes(name):
        state = states(scene)
        result = rates_of(scene, state)
        for row in range(STAGES):
            y = np.ascontiguousarray(state.nodes[: len(state.k), row])
            entries.rates_entry((scene.value,), y, state.mode, state.latched, state.k, state.o, row)
            for ours, theirs in ((result.k, state.k), (result.o, state.o)):
                size = np.maximum(np.abs(theirs[:, row]), 1e-6 * np.abs(theirs[:, row]).max())
                np.testing.assert_array_less(np.abs(ours[:, row] - theirs[:, row]), 1e-9 * size + 1e-300)
