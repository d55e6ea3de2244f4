"""A machine of a thousandth of the size moves alike, unless a law, a bound or a figure has a length of its own.

With lengths and times s times as long and masses s^3 times as large, speeds and pressures stay and forces grow by s^2.
A power of two as s changes no digit of most numbers.
"""

from pathlib import Path

import pytest
from mechanism_cases import changed
from right_grids import READER

import clearsweep
from clearsweep.contracts.results import TIMINGS
from clearsweep.language import quantity

CONFIGS = Path(__file__).parent.parent / "configs"
SIZE = 2.0**-10
EXPONENTS = {"[length]": 1, "[time]": 1, "[mass]": 3}
WORK = {"steps", "steps_rejected", "rhs_evaluations", "energy_residual"}  # these may move with the last digit
BLOCK = {
    "clearance": "0.05 mm",
    "length": "50 mm",
    "height": "40 mm",
    "contact": {"law": "flores", "stiffness": "5e9 N/m^1.5", "restitution": 0.5},
    "friction": {"law": "coulomb", "coefficient": 0.1, "velocity_scale": "1 mm/s"},
}
CHANGES = {
    "bending_rod": {},
    "gear_rattle": {},
    "lubricated": {},
    "rolling": {"vibration": {"band": ["10 Hz", "1 kHz"]}},
    "slider_crank": {"joints": {"slider-ground": BLOCK}, "mechanism.slider.inertia": "1e-4 kg*m^2"},
    "spatial_four_bar": {},
    "two_joints": {},
    "wiper": {},
    "worn_slider_crank": {},
}


def factor(unit, size):
    """Return by what a number of this unit grows where the machine grows by `size`."""
    dimension = () if unit == "1" else quantity.value_and_dimension(f"1 {unit}")[1]
    return size ** float(sum(EXPONENTS.get(name, 0) * exponent for name, exponent in dimension))


def scaled(written, size):
    """Return a part of a grid with all its quantities multiplied; other numbers and texts stay."""
    if isinstance(written, dict):
        return {key: scaled(value, size) for key, value in written.items()}
    if isinstance(written, list):
        return [scaled(value, size) for value in written]
    if not quantity.has_unit(written):
        return written
    value, dimension = quantity.value_and_dimension(written)
    unit = quantity.unit_of(dimension)
    return f"{value * factor(unit, size)!r} {unit}"


@pytest.mark.few("rolling", "slider_crank")
@pytest.mark.parametrize("name", CHANGES)
def test_figures_of_a_small_machine_are_those_of_the_large_one_in_its_units(name):
    grid = changed(READER.load((CONFIGS / f"{name}.yaml").read_text(encoding="utf-8")), CHANGES[name])
    grid = {key: grid[key] for key in grid.keys() - {"sweep", "seek", "limits"}}
    large, small = (clearsweep.load_case(scaled(grid, size)) for size in (1.0, SIZE))
    known, similar = clearsweep.simulate(large).summary, clearsweep.simulate(small).summary
    columns = [column for column in large.layout.columns if isinstance(known.get(column.name), (int, float))]
    largest = {unit: max(abs(known[c.name]) for c in columns if c.unit == unit) for unit in {c.unit for c in columns}}
    assert len(columns) > 30
    for column in columns:
        if column.name not in TIMINGS:
            value, allowed = similar[column.name] / factor(column.unit, SIZE), 0.1 if column.name in WORK else 1e-6
            wanted = pytest.approx(known[column.name], rel=allowed, abs=1e-11 * largest[column.unit])
            assert value == wanted, column.name
