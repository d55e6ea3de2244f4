"""What an interactive session shows of a case and of a run: short, with units, and no flood."""

import sys
from xml.etree import ElementTree

import numpy as np
import pytest
from fake_physics import grid, sweep

import clearsweep
from clearsweep import simulation
from clearsweep.contracts import results

PAIR = {
    "mechanism": {"type": "impact-pair", "masses": ["0.2 kg", "0.2 kg"], "speed": "1 m/s"},
    "joints": {"pair": {"clearance": "1 mm", "contact": {"law": "exact", "stiffness": "1e8", "restitution": 0.9}}},
}


def made_up() -> results.Trajectory:
    turn = np.linspace(0.0, 6.0, 5000)
    channels = {
        "t": turn,
        "joints/rod_slider/x": np.cos(turn),
        "joints/rod_slider/y": np.sin(turn),
        "joints/rod_slider/force_normal": turn**2,
    }
    summary = {"rod_slider_force_peak": 20e3, "steps": 7, "nothing": None}
    return results.Trajectory("ok", "", summary, channels, units={"rod_slider_force_peak": "N"})


def test_a_trajectory_prints_as_one_short_line():
    assert repr(made_up()) == "<Trajectory ok: 5,000 samples of 4 channels from 0 to 6 s, 0 events, 3 figures>"
    failed = results.Trajectory("stalled", "the crank stops", {})
    assert str(failed) == "<Trajectory stalled: the crank stops>"


def test_a_notebook_shows_orbit_force_and_figures_with_their_units():
    page = made_up()._repr_html_()
    tree = ElementTree.fromstring(f"<div>{page}</div>")  # well-formed
    points = [line.get("points").split() for line in tree.iter("polyline")]
    assert len(points) == 2
    orbit = np.array([[float(number) for number in point.split(",")] for point in points[0]])
    assert np.ptp(np.hypot(*(orbit - 100.0).T)) < 2.0  # px: a circle stays one
    assert "rod-slider: normal force over time, up to 36.0\u00a0N" in page
    assert "20.000\u00a0kN" in page
    assert len(page) < 100_000
    assert "<svg" not in results.Trajectory("crashed", "a < b", {})._repr_html_()


def test_every_channel_and_figure_of_a_simulated_case_has_its_unit():
    scene = simulation.load_case(PAIR)
    assert scene.layout.units["pair_force_peak"] == scene.layout.units["joints/pair/force_normal"] == "N"
    assert scene.layout.units.keys() >= {column.name for column in (*scene.layout.columns, *scene.layout.channels)}


def test_without_xarray_its_lack_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"clearsweep\[xarray\]"):
        made_up().to_xarray()


def test_histories_go_to_xarray_with_their_units():
    pytest.importorskip("xarray")
    result = made_up().to_xarray()
    assert result["joints/rod_slider/force_normal"].sizes == {"t": 5000}
    assert result.attrs["steps"] == 7


def test_an_opened_run_writes_its_report(tmp_path, monkeypatch):
    sweep(grid(2), tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    written = []
    monkeypatch.setattr("clearsweep.report.write", lambda run, out: written.append((run, out)) or out)
    assert run.report() == tmp_path / "run" / "report.html"
    assert run.report("x.html") == "x.html"
    assert written[0][0] is run
