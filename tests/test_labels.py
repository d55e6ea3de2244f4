"""Values of an axis may have labels: shown in all output, stored with the numbers, without effect on identities."""

import csv
import dataclasses
import io
import json

import pyarrow.parquet as pq
from fake_runs import Run
from test_written_units import BASE, CLEARANCE, RESTITUTION, loaded

import clearsweep
from clearsweep import grid, simulation
from clearsweep.report.blocks.table import Column, Table
from clearsweep.report.study import prepare
from clearsweep.sweeping import summary
from clearsweep.sweeping.facts import value_text

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
