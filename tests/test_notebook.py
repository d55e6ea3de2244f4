"""What an interactive session shows of a case and of a run: short, with units, and no flood."""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fake_physics import grid, sweep

import clearsweep
from clearsweep import simulation
from clearsweep.contracts import results
from clearsweep.language import wording
from clearsweep.language.errors import InputError

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


def test_without_xarray_its_lack_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(ImportError, match=r"clearsweep\[xarray\]"):
        made_up().to_xarray()
    sweep(grid(1), tmp_path / "run", executor="serial", show_progress=False)
    with pytest.raises(ImportError, match=r"clearsweep\[xarray\]"):
        clearsweep.open(tmp_path / "run").to_xarray()


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


@pytest.mark.slow
def test_the_page_on_python_runs_from_top_to_bottom(tmp_path, monkeypatch):
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[1] / "docs/python.md").read_text(encoding="utf-8")
    names = {"__name__": "__main__"}
    for block in re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
        exec(compile(block, "docs/python.md", "exec"), names)
    assert names["points"].shape == (400, 2)  # the last two revolutions of 200 speeds
    run, data = names["run"], names["data"]
    for case_id in run.summary["case_id"]:
        orbit, case = run.orbit(case_id), data.sel(case_id=case_id)
        assert np.array_equal(case["t"].to_numpy(), orbit["t"])
        assert np.array_equal(case["slider/x"].to_numpy(), orbit["slider/x"])
        peak = run.summary.set_index("case_id").loc[case_id, "rod_slider_force_peak"]
        assert case["rod_slider_force_peak"].item() == peak
    assert data["slider/x"].attrs["units"] == "m"


def test_shorter_histories_end_with_nan_and_unknown_channels_are_named(tmp_path):
    pytest.importorskip("xarray")
    changed = {"sweep": {"mechanism.gravity": [0.0, 800.0]}, "save": {"orbits": "all"}}  # the second case fails
    sweep(grid(2) | changed, tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    data = run.to_xarray()
    lengths = [len(run.orbit(case_id)) for case_id in run.summary["case_id"]]
    assert np.isfinite(data["t"]).sum("sample").to_numpy().tolist() == lengths
    assert 0 in lengths
    assert "sample" not in run.to_xarray(()).dims
    with pytest.raises(InputError, match=r"no channel 'rod/tilt' is stored; there are t, "):
        run.to_xarray(["rod/tilt"])


def test_a_notebook_shows_the_range_of_every_column_of_a_run(tmp_path):
    sweep(grid(3), tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    rows = [[cell.text for cell in row] for row in ElementTree.fromstring(f"<div>{run._repr_html_()}</div>").iter("tr")]
    assert rows[0] == ["column", "smallest", "median", "largest"]
    shown = {name: values for name, *values in rows[1:]}
    assert shown.keys() == {*run.summary.select_dtypes("number").columns}
    forces = run.summary["rod_slider_force_peak"]
    assert shown["rod_slider_force_peak"][2] == wording.quantity_text(forces.max(), "N")


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: made_up()[3], KeyError, "no channel '3'; there are t, joints/rod_slider/x"),
        (lambda: clearsweep.load_case(PAIR, [1]), InputError, "overrides: found a list; expected dotted paths"),
        (lambda: clearsweep.load_case(PAIR, {3: 1}), InputError, "overrides: found a section; expected dotted paths"),
        (lambda: clearsweep.sweep(PAIR, "x", jobs="two"), InputError, "jobs: found 'two'; expected a whole number"),
        (lambda: clearsweep.open(__file__), clearsweep.DirectoryError, r"contains no run \(it is a file\)"),
    ],
)
def test_a_wrong_argument_is_named(call, error, message):
    with pytest.raises(error, match=message):
        call()
