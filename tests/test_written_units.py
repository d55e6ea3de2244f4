"""What a grid gives in a unit is shown in that unit: on axes, in tables and CSV files, in closing lines."""

import csv
import dataclasses
import io
import json

import pyarrow.parquet as pq
import pytest
from fake_runs import Run
from right_grids import grid_of

import clearsweep
from clearsweep import grid, simulation
from clearsweep.answers.words import MIN_DIGITS, varied_text
from clearsweep.language import quantity, wording
from clearsweep.report.blocks.table import Column, Table
from clearsweep.report.study import prepare
from clearsweep.sweeping import summary
from clearsweep.sweeping.facts import value_text

SPEED, CLEARANCE = "drive.speed", "joints.rod-slider.clearance"
RESTITUTION = "joints.rod-slider.contact.restitution"
BASE = grid_of("a crank with units")


def loaded(**ways):
    return grid.load(BASE | ways, simulation.catalogue())


@pytest.mark.parametrize(
    ("text", "unit", "factor", "offset"),
    [
        ("60 degC", "K", 1.0, 273.15),
        ("46 mm^2/s", "m^2/s", 1e-6, 0.0),
        ("90 %", "1", 0.01, 0.0),
        ("3 um", "m", 1e-6, 0.0),
    ],
)
def test_a_written_unit_leads_back_to_the_number_that_was_written(text, unit, factor, offset):
    known = quantity.written_unit(text, unit)
    assert known == (text.split(" ", 1)[1], pytest.approx(factor), offset)
    scale = wording.recorded_scale(known._asdict())
    assert scale.exact_number_text(quantity.read(text, unit)) == text.split(" ")[0]


@pytest.mark.parametrize("value", [5.0, "5", "= play", "5 parsecs", "5 kg", None])
def test_numbers_expressions_and_wrong_units_are_in_no_written_unit(value):
    assert quantity.written_unit(value, "m") is None


def test_axes_and_values_note_the_unit_that_they_are_written_in():
    over = {SPEED: ["20 Hz", "30 Hz"], CLEARANCE: {"logspace": [-2, -1, 3, "mm"]}, RESTITUTION: [0.5, 0.9]}
    units = loaded(sweep=over).written_units
    assert {path: known.unit for path, known in units.items()} == {
        "mechanism.crank.length": "mm",
        "mechanism.slider.mass": "g",
        SPEED: "Hz",
        CLEARANCE: "mm",
    }


def test_a_drawn_value_notes_the_unit_of_its_distribution():
    drawn = {"method": "random", "n": 4, "seed": 1, "over": {RESTITUTION: {"uniform": ["50 %", "90 %"]}}}
    assert loaded(sample=drawn).written_units[RESTITUTION].unit == "%"


def test_the_unit_does_not_enter_the_identity_of_a_case():
    written, bare = loaded(sweep={CLEARANCE: ["50 um"]}), loaded(sweep={CLEARANCE: [5e-5]})
    assert written.case_id(0) == bare.case_id(0)
    assert written.fixed_settings() == bare.fixed_settings()


def test_a_grid_read_from_its_record_keeps_fits_and_units():
    first = loaded(sweep={CLEARANCE: {"fits": ["H7/g6", "H7/f7"]}, SPEED: ["20 Hz"]})
    record = first.resolved()
    notes = {
        "fits": {path: [fit._asdict() for fit in fits] for path, fits in first.fits.items()},
        "written_units": {path: known._asdict() for path, known in first.written_units.items()},
    }
    second = dataclasses.replace(grid.load(record, simulation.catalogue()), **grid.as_written(record | notes))
    assert (second.fits, second.written_units) == (first.fits, first.written_units)
    assert CLEARANCE not in first.written_units


def axes_of(**units):
    run = Run(histories=False)
    run.grid["written_units"] = {
        path: {"unit": unit, "factor": factor, "offset": 0.0} for path, (unit, factor) in units.items()
    }
    return {axis.path: axis for axis in prepare(run).axes}


def test_an_axis_is_in_the_unit_of_the_grid():
    axes = axes_of(**{SPEED: ("Hz", quantity.read("1 Hz", "rad/s")), RESTITUTION: ("%", 0.01)})
    assert axes[SPEED].label() == "crank speed [Hz]"
    assert axes[RESTITUTION].text(0.9) == "90\u00a0%"
    assert axes[CLEARANCE].label() == "clearance [mm]"  # it has none of its own: one that suits it


def test_a_csv_has_an_axis_in_the_unit_of_the_grid_and_others_in_si():
    axes = axes_of(**{CLEARANCE: ("um", 1e-6)})
    columns = (Column("clearance", "m", axes[CLEARANCE]), Column("crank speed", "rad/s", axes[SPEED]))
    table = Table("key", "title", "", columns, [(2e-4, 100.0), (None, 50.0)])
    head, first, second = csv.reader(io.StringIO(table.csv()))
    assert head == ["clearance [µm]", "crank speed [rad/s]"]
    assert (first, second) == (["200.0", "100.0"], ["", "50.0"])


def test_closing_lines_give_a_value_in_the_unit_of_the_grid():
    written = {"joints.J.thermal.ambient": {"unit": "degC", "factor": 1.0, "offset": 273.15}}
    assert varied_text("joints.J.thermal.ambient", 333.15, "K", written, MIN_DIGITS) == "60 degC"
    assert varied_text("joints.J.clearance", 5e-4, "m", written, MIN_DIGITS) == "0.5 mm"


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (0.0508, "m", "2.00 in"),
        (50e-6, "m", "1.97 mil"),
        (2e-7, "m", "7.87 µin"),
        (5e3, "N", "1124 lbf"),
        (10.0, "N*m", "7.38 lbf ft"),
        (0.5, "N*m", "4.43 lbf in"),
        (207e9, "Pa", "30 023 ksi"),
        (1e6, "Pa", "145 psi"),
        (1.0, "kg", "2.20 lb"),
        (1e-4, "kg*m^2", "0.342 lb in²"),
        (1e6, "N/m", "5710 lbf/in"),
        (3e-15, "m^2/N", f"2.07 {wording.TIMES} 10⁻¹¹ in²/lbf"),
        (1e6, "W/m^2", "28 551 psi ft/min"),
        (9.81, "m/s^2", "32.2 ft/s²"),
        (0.9, "1", "0.900"),
    ],
)
def test_imperial_units_are_those_of_handbooks(value, unit, said):
    with wording.unit_system("imperial"):
        text = wording.quantity_text(value, unit).replace(wording.BLANK, " ").replace("\u202f", " ")
        scale = wording.scale(unit, value)
    assert text == said
    assert scale.from_si(value) * scale.factor == pytest.approx(value)


def test_imperial_factors_are_those_of_the_unit_library():
    for unit, steps in wording._IMPERIAL_SCALES.items():
        for _, factor, name in steps:
            known = {"µin": "1e-6 in", "mil": "1e-3 in", "mil³": "1e-9 in^3", "ksi": "1e3 psi", "°": "1 deg"}
            written = known.get(name, f"1 {name}").replace("²", "^2").replace("³", "^3").replace(wording.BLANK, "*")
            if "lbf*ft" in written or "ft" in written or "µs" in name:
                continue  # feet are no unit of grids; the cases above have them
            assert quantity.read(written, unit) == pytest.approx(factor, rel=1e-12), (unit, name)


def test_a_system_of_units_ends_with_its_block_and_overrides_the_units_of_the_grid():
    noted = {"unit": "degC", "factor": 1.0, "offset": 273.15}
    assert wording.written_scale(noted, "K").text(333.15) == "60.0\u00a0°C"
    with wording.unit_system("imperial"):
        assert wording.written_scale(noted, "K").text(333.15) == "140\u00a0°F"
        assert wording.written_scale({"unit": "um", "factor": 1e-6, "offset": 0.0}, "m") is None
        rpm = {"unit": "rpm", "factor": 0.1047, "offset": 0.0}
        assert wording.written_scale(rpm, "rad/s").unit == "rpm"
        assert varied_text(CLEARANCE, 1e-4, "m", {}, MIN_DIGITS) == "3.937 mil"
    assert varied_text(CLEARANCE, 1e-4, "m", {}, MIN_DIGITS) == "0.1 mm"
    assert wording.quantity_text(0.0508, "m") == "50.8\u00a0mm"


def test_a_report_in_imperial_units_has_no_metric_ones_but_its_tables_are_in_si():
    run = Run(histories=False)
    run.grid["written_units"] = {CLEARANCE: {"unit": "um", "factor": 1e-6, "offset": 0.0}}
    with wording.unit_system("imperial"):
        axes = {axis.path: axis for axis in prepare(run).axes}
        assert axes[CLEARANCE].scale.unit == "mil"
        table = Table("k", "t", "", (Column("clearance", "m", axis=axes[CLEARANCE]),), [(1e-4,)])
        assert table.to_text().heads[0].unit == "mil"
        assert next(csv.reader(io.StringIO(table.csv()))) == ["clearance [m]"]


# Values of an axis may have labels: shown in all output, stored with the numbers, without effect on identities.


LABELLED = {"tight": "20 um", "loose": "0.1 mm"}


def test_labels_leave_values_and_identities_as_a_list_has_them():
    named, listed = loaded(sweep={CLEARANCE: LABELLED}), loaded(sweep={CLEARANCE: [*LABELLED.values()]})
    assert named.axes == listed.axes
    assert [named.case_id(k) for k in range(2)] == [listed.case_id(k) for k in range(2)]
    assert named.fixed_settings() == listed.fixed_settings()
    assert named.labels == {CLEARANCE: {"tight": 2e-5, "loose": 1e-4}}
    assert named.written_units[CLEARANCE].unit == "um"


def test_axes_in_step_fits_and_own_quantities_have_labels_too():
    step = {CLEARANCE: LABELLED, RESTITUTION: [0.5, 0.9]}
    assert loaded(zip=step).labels[CLEARANCE] == {"tight": 2e-5, "loose": 1e-4}
    fits = loaded(sweep={CLEARANCE: {"tight": {"fit": "H7/g6"}, "loose": {"fit": "H8/e8"}}})
    assert [*fits.labels[CLEARANCE]] == ["tight", "loose"]
    assert [fit.name for fit in fits.fits[CLEARANCE]] == ["H7/g6", "H8/e8"]
    scene = json.loads(json.dumps(BASE))
    scene["joints"]["rod-slider"]["clearance"] = "= play"
    own = grid.load(scene | {"define": {"play": "50 um"}, "sweep": {"define.play": LABELLED}}, simulation.catalogue())
    assert own.labels == {"define.play": {"tight": 2e-5, "loose": 1e-4}}


def test_a_grid_read_from_its_record_keeps_labels():
    first = loaded(sweep={CLEARANCE: LABELLED})
    record = json.loads(json.dumps(first.resolved() | {"labels": first.labels}))
    second = dataclasses.replace(grid.load(first.resolved(), simulation.catalogue()), **grid.as_written(record))
    assert second.labels == first.labels


def test_the_schema_takes_labels_but_no_reserved_word():
    schemas = grid.schema(simulation.catalogue())["$defs"]["axis"]["anyOf"]
    (labels,) = (schema for schema in schemas if "propertyNames" in schema)
    assert {"linspace", "fits", "normal"} <= {*labels["propertyNames"]["not"]["enum"]}


def axis_of(labels):
    run = Run(histories=False)
    run.grid["labels"] = {CLEARANCE: labels}
    return next(axis for axis in prepare(run).axes if axis.path == CLEARANCE)


def test_a_label_is_before_the_number_and_alone_at_the_edge_of_a_figure():
    values = axis_of({}).values
    axis = axis_of({"tight": values[0]})
    assert axis.text(values[0]).startswith("tight (")
    assert axis.short_text(values[0]) == "tight"
    assert "tight" not in axis.text(values[1])
    assert axis.values_text().startswith("tight (")


def test_a_csv_file_has_a_column_of_labels():
    values = axis_of({}).values
    axis = axis_of({"tight": values[0]})
    table = Table("key", "title", "", (Column("clearance", "m", axis),), [(values[0],), (values[1],)])
    head, first, second = csv.reader(io.StringIO(table.csv()))
    assert head == ["clearance [m]", "clearance label"]
    assert (first[1], second[1]) == ("tight", "")
    assert float(first[0]) == values[0]


def test_a_run_stores_labels_and_its_closing_lines_show_them(tmp_path):
    short = {"simulate": {"revolutions": 1, "discard": 0, "tolerance": 1e-4}, "save": {"orbits": "none"}}
    result = clearsweep.sweep(BASE | short | {"sweep": {CLEARANCE: LABELLED}}, tmp_path / "run", executor="serial")
    run = clearsweep.open(tmp_path / "run")
    assert run.grid["labels"] == {CLEARANCE: {"tight": 2e-5, "loose": 1e-4}}
    field = pq.read_schema(tmp_path / "run" / "summary.parquet").field(CLEARANCE)
    assert json.loads(field.metadata[b"labels"]) == {"tight": 2e-5, "loose": 1e-4}
    assert sorted(run.summary[CLEARANCE]) == [2e-5, 1e-4]
    facts = summary.of_run(result)
    assert value_text(CLEARANCE, 2e-5, facts) == "tight (20 um)"
    assert "loose (100 um)" in summary.run_text(facts)
