"""Claims about reading quantities: what parses to what, exactly, and what a mistake is answered."""

import contextlib
import math
import time

import pint
import pytest
import yaml
from fake_runs import CATALOGUE, TEXT
from hypothesis import given
from hypothesis import strategies as st
from right_grids import text_of

from clearsweep import grid, simulation
from clearsweep.contracts.catalogue import LARGEST, Field
from clearsweep.language import quantity, wording
from clearsweep.language.errors import InputError
from clearsweep.sweeping.facts import assumed_sentences

READS = [
    ("0.5 mm", "m", 0.0005),
    ("0.5mm", "m", 0.0005),
    (" 20 um ", "m", 20e-6),
    ("20 µm", "m", 20e-6),
    ("1 in", "m", 0.0254),
    ("2 lb", "kg", 0.90718474),
    ("1 lbf", "N", 4.4482216152605),
    ("1 psi", "Pa", 6894.757293168362),
    ("6.61e10 N/m^1.5", "N/m^1.5", 6.61e10),
    ("1e6 N/mm", "N/m", 1e9),
    ("2e-14 m^2/N", "m^2/N", 2e-14),
    ("5.05e-4 mm^3/(N*m)", "m^2/N", 5.05e-13),
    ("1e-4 kg*m^2", "kg*m^2", 1e-4),
    ("1e-4 kg m^2", "kg*m^2", 1e-4),
    ("1 kg·m²", "kg*m^2", 1.0),
    ("207 GPa", "Pa", 2.07e11),
    ("100 N*s/m", "N*s/m", 100.0),
    ("100 N s m^-1", "N*s/m", 100.0),
    ("9.81 m/s^2", "m/s^2", 9.81),
    ("9.81 m/s**2", "m/s^2", 9.81),
    ("140 g", "kg", 0.14),
    ("0.2 t", "kg", 200.0),
    ("90 %", "1", 0.9),
    ("180 deg", "rad", math.pi),
    ("5 kN", "N", 5000.0),
    ("+1e3", "m", 1000.0),
    ("5 Nm", "N*m", 5.0),
    ("5 kNm", "N*m", 5000.0),
    ("5 Ns/m", "N*s/m", 5.0),
    ("1 Nms", "N*m*s", 1.0),
    ("3 kgm^2", "kg*m^2", 3.0),
    ("3 kgcm²", "kg*m^2", 3e-4),
    ("20 mPas", "Pa*s", 0.02),
    ("100 cP", "Pa*s", 0.1),
    ("46 cSt", "m^2/s", 46e-6),
    ("65e-6 mm^3/Nm", "m^2/N", 65e-15),
    ("1 ft", "m", 0.3048),
    ("4 mil", "m", 101.6e-6),
    ("1 ksi", "Pa", 6894757.293168361),
    ("1 hp", "W", 745.6998715822702),
    ("1 kgf", "N", 9.80665),
    ("2 g0", "m/s^2", 19.6133),
    ("1 ft-lbf", "N*m", 1.3558179483314003),
    ("1 lbf in", "N*m", 0.1129848290276167),
    ("32 degF", "K", 273.15),
    ("212 °F", "K", 373.15),
    ("9 1/degF", "1/K", 16.2),
    ("18e-6 1/degC", "1/K", 18e-6),
    ("\N{MINUS SIGN}5 mm", "m", -0.005),
    (".5", "m", 0.5),
    ("5.", "m", 5.0),
    (5, "m", 5.0),
    (0.25, "1", 0.25),
]


@pytest.mark.parametrize(("text", "unit", "value"), READS)
def test_a_quantity_reads_as_the_nearest_float_in_si(text, unit, value):
    assert quantity.read(text, unit) == value


def test_hz_of_a_shaft_means_turns_per_second():
    assert quantity.read("3 Hz", "rad/s") == pytest.approx(6 * math.pi, rel=1e-15, abs=0.0)
    assert quantity.read("3 Hz", "rad/s") == quantity.read("180 rpm", "rad/s") == quantity.read("3 turn/s", "rad/s")
    assert quantity.read("0.003 kHz", "rad/s") == quantity.read("1080 deg/s", "rad/s")


PRINTED_UNITS = (
    *("m", "m^2", "m^3", "kg", "kg*m^2", "s", "rad", "m/s", "m/s^2", "N", "N*m", "W", "J", "Pa", "1/K", "Pa*s"),
    *("N/m", "N/m^1.5", "N*s/m", "N*s/m^2.5", "m^2/N", "m^2/s", "kg/m^3", "W/m^2", "W/K", "rad/s^2"),
)


@pytest.mark.parametrize("system", wording.SYSTEMS)
@given(number=st.floats(min_value=1e-18, max_value=1e12), sign=st.sampled_from((1.0, -1.0)))
def test_what_is_printed_can_be_read(system, number, sign):
    with wording.unit_system(system):
        for unit in PRINTED_UNITS:
            text = wording.scale(unit, number).exact_text(sign * number, 12)
            assert quantity.read(text, unit) == pytest.approx(sign * number, rel=1e-10, abs=0.0), text
        speed = wording.scale("rad/s", number, speed=True).exact_text(sign * number, 12)
        assert quantity.read(speed, "rad/s") == pytest.approx(sign * number, rel=1e-10, abs=0.0)
        temperature = wording.temperature_scale().exact_text(number, 12)
        assert quantity.read(temperature, "K") == pytest.approx(number, rel=1e-10, abs=1e-8 * (number + 273.15))


@pytest.mark.parametrize("written", [number for number, *_ in READS if isinstance(number, str)])
def test_a_written_unit_can_be_read_as_it_is_printed(written):
    unit = next(unit for text, unit, _ in READS if text == written)
    if read_unit := quantity.written_unit(written, unit):
        shown = wording.recorded_scale(read_unit._asdict()).exact_text(quantity.read(written, unit), 15)
        assert quantity.read(shown, unit) == pytest.approx(quantity.read(written, unit), rel=1e-14, abs=1e-14)


@given(st.decimals(min_value="0.001", max_value="100000", places=6))
def test_the_spelling_of_the_unit_does_not_change_a_bit(number):
    mm = quantity.read(f"{number} mm", "m")
    assert mm == quantity.read(f"{number * 1000} um", "m") == quantity.read(f"{number / 1000}", "m")


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_bare_number_comes_back_as_it_is_whether_number_or_text(number):
    assert (
        quantity.read(number, "m") == number == quantity.read(repr(number), "m") == quantity.read(f"{number!r} m", "m")
    )


@pytest.mark.parametrize("written", ["90 1/min", "90 U/min", "90/min", "90 min^-1", "90 rpm"])
def test_a_shaft_that_turns_so_often_a_minute_is_read_as_its_rating_plate_has_it(written):
    assert quantity.read(written, "rad/s") == pytest.approx(3.0 * math.pi, rel=1e-15, abs=0.0)
    assert quantity.read("90 1/min", "1/s") == 1.5


def test_a_quantity_is_repeated_as_it_was_written():
    assert quantity.written_text("20 mm", "m") == "20 mm"
    assert (
        quantity.written_text("500", "rad/s"),
        quantity.written_text(0.1, "m"),
        quantity.written_text("3", "1"),
    ) == (
        "500 rad/s",
        "0.1 m",
        "3",
    )


@pytest.mark.parametrize("zero", [-0.0, "-0.0", "-0 mm", "-1e-999 m", 0])
def test_zero_has_no_sign(zero):
    assert math.copysign(1.0, quantity.read(zero, "m")) == 1.0


@pytest.mark.parametrize(("value", "words"), [(10**400, "not a finite number"), ("1" * 1000, "begin with a number")])
def test_a_monstrous_number_is_refused_in_a_line(value, words):
    with pytest.raises(InputError, match=words) as caught:
        quantity.read(value, "m")
    assert len(str(caught.value)) < 200
    assert "\n" not in str(caught.value)


@given(st.text(max_size=30))
def test_any_text_gives_a_finite_number_or_an_input_error(text):
    with contextlib.suppress(InputError):
        assert math.isfinite(quantity.read(text, "m"))


@given(st.text(alphabet="mksNPa*/^()1. -²%°", max_size=12))
def test_any_unit_gives_a_finite_number_or_an_input_error(text):
    with contextlib.suppress(InputError):
        assert math.isfinite(quantity.read(f"1 {text}", "m"))


def test_a_monstrous_exponent_costs_no_time():
    began = time.process_time()
    assert quantity.read("1e-999999999 mm", "m") == 0.0
    with pytest.raises(InputError, match="not a finite number"):
        quantity.read("1e999999999 mm", "m")
    assert time.process_time() - began < 1.0


@pytest.mark.parametrize(
    "text",
    [
        "1 mm^(10**10)",
        "1 mm^2^2^2^2^2^9",
        "1 m^9^9^9",
        "1 ((mm^99)^99)^99",
        "1 (mm^99 s)²",
        "1 mm^99²",
        "1 mm**9**9**9",
        "1 mm ^ 99 ^ 99",
    ],
)
def test_powers_of_powers_are_refused_at_once(text):
    began = time.process_time()
    with pytest.raises(InputError, match=r"power of a power|cannot be read as a unit"):
        quantity.read(text, "m")
    assert time.process_time() - began < 1.0


def test_a_power_of_a_bracket_is_read():
    assert quantity.read("2 kg/(mm/s)^2", "kg*s^2/m^2") == 2e6
    assert quantity.read("2 (mm)^2*s²", "m^2*s^2") == 2e-6


def test_the_exponent_in_a_unit_is_written_as_a_user_would():
    assert quantity.replace_exponent("N/m^exponent", 1.5) == "N/m^1.5"
    assert quantity.replace_exponent("N/m^exponent", 1.0) == "N/m"
    assert quantity.replace_exponent("N/m", 1.5) == "N/m"


SYMBOLS = "m mm um in kg g t s ms min rad deg rpm N kN lbf Pa MPa psi bar J W hp K cP"
NAMES = st.sampled_from(SYMBOLS.split(" "))
POWERS = st.sampled_from(["", "^2", "**3", "²", "^-1", "^(3)"])
UNITS = pint.UnitRegistry()
PRODUCTS = st.lists(st.tuples(st.sampled_from(["*", "/", " ", "·"]), NAMES, POWERS), max_size=4)


@given(NAMES, POWERS, PRODUCTS, st.booleans())
def test_products_of_units_have_the_size_that_a_second_reader_gives(name, power, others, inverse):
    text = name + power + "".join("".join(other) for other in others)
    text = f"1/({text})" if inverse else text
    expected = UNITS.Quantity(1.0, text.replace("·", "*")).to_base_units()
    size, _ = quantity.value_and_dimension(f"1 {text}")
    assert size == pytest.approx(expected.magnitude, rel=1e-12)


@pytest.mark.parametrize("written", ["*", "mm*", "/)/^(1/2)/", "^0", "mm Pa°", "rev//mm ^0", "()", "m(s)", "(m", "1 /"])
def test_what_cannot_be_a_unit_is_refused_as_one(written):
    with pytest.raises(InputError):
        quantity.read(f"1 {written}", "m")


# Numbers without a unit in a grid file: refused next to others with one, else said; sizes that no machine has.


BARE = text_of("a grid without units")


@pytest.mark.parametrize(
    "change",
    [
        ("center: 60 mm", "center: 0"),  # 0 is the same in every unit
        ("revolutions: 10", "revolutions: 12"),
        ("stiffness: 6.61e10 N/m^1.5", "stiffness: 6.61e10"),  # no length, mass or speed
        ("restitution: 0.9", "restitution: 0.7"),
    ],
)
def test_zero_counts_and_pure_numbers_need_no_unit(at, change):
    assert len(at(TEXT.replace(*change))) == 1


def test_dicts_and_overrides_may_mix(at):
    assert at(TEXT, {"drive.speed": 100}).case(0).drive.speed == 100.0
    mixed = yaml.safe_load(TEXT) | {"drive": {"speed": 100.0}}
    assert grid.load(mixed, CATALOGUE).case(0).drive.speed == 100.0
    source = grid.OverriddenGrid("grid.yaml", {"drive.speed": "100"}, {"mechanism.slider.mass": "0.1, 0.2"})
    assert grid.load(source, CATALOGUE).case(0).drive.speed == 100.0


def test_a_bare_grid_says_what_was_read(at):
    (sentence,) = assumed_sentences(at(BARE))
    assert sentence.startswith("no unit given, SI assumed: crank speed 1500 rad/s = 14,324 rpm, crank length 50 m, ")
    assert "clearance 0.1 m = 100 mm" in sentence
    assert not assumed_sentences(at(TEXT))
    assert not assumed_sentences(grid.load(yaml.safe_load(BARE), CATALOGUE))  # numbers of a program are in SI


def test_sizes_that_no_machine_has_are_remarked_on(at):
    sentence = next(text for text in simulation.warnings(at(BARE).case(0)) if "sizes that no machine has" in text)
    for text in (
        "mechanism.crank has 0.006 kg per metre of its length, 50 m",
        "mechanism.rod is 120 m long",
        "the end of crank moves at 7.5e+04 m/s",
        "a pin of 20 m diameter",
        "joints.rod-slider.clearance is 100 mm",
    ):
        assert text in sentence
    assert not any("no machine" in text for text in simulation.warnings(at(TEXT).case(0)))


# Values that no machine has are refused in a sentence with their place, before anything is computed with them.


@pytest.mark.parametrize("value", [0.0, 1.0 / LARGEST, LARGEST, 1.0])
def test_the_bounds_themselves_are_allowed(value):
    assert Field("x", "m", low_open=False).contains(value)
    assert not Field("x", "m", -math.inf).contains(-2.0 * LARGEST)
    assert "of a size from 1e-60 to 1e+60" in Field("x", "m").allowed(2.0 * LARGEST)
    assert "of a size" not in Field("x", "m").allowed(-1.0)
