"""Figures of merit, mechanisms and layouts are described once; all that shows them follows from the description."""

import copy
import json
import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from mechanism_cases import slider_crank
from right_grids import grid_of

import clearsweep
from clearsweep import grid, report, simulation
from clearsweep.contracts.catalogue import Entry, Figure
from clearsweep.contracts.layout import Layout
from clearsweep.grid import load
from clearsweep.grid.pages.schema import whole_schema
from clearsweep.language.errors import DirectoryError
from clearsweep.simulation.figures import catalogue
from clearsweep.simulation.figures.sums import Mean
from clearsweep.simulation.running.vibration import WINDOW, window_transform
from clearsweep.simulation.setup import scene

ROOT = Path(__file__).parent.parent
columns_markdown = runpy.run_path(str(ROOT / "docs/tools/columns.py"))["columns_markdown"]
TEXT = "mean square of the normal force over the window's time"
FURTHER = Figure(
    "force_mean_square",
    "N^2",
    TEXT,
    of="joint",
    sums=Mean("force_square"),
    tables=(Entry("forces", "force mean square"), Entry("sample", "force mean square")),
)
COLUMN = "rod_slider_force_mean_square"


@pytest.fixture
def further(monkeypatch):
    """Add a figure made up from a sum that exists: one block, after the other figures of joints."""
    figures = (*catalogue.JOINT, FURTHER, *catalogue.FIGURES[len(catalogue.JOINT) :])
    for module in (catalogue, scene):
        monkeypatch.setattr(module, "FIGURES", figures)


def dead_weight_on_a_block(weight, **changes):
    """Return the summary of a slider-crank whose slider, a block in a guide with clearance, carries a weight (N)."""
    guide = {"clearance": 2e-5, "length": 0.04, "height": 0.03, "contact": {"law": "exact", "stiffness": 3e9}}
    guide["contact"]["restitution"] = 0.5
    case = slider_crank(changes={"joints.slider-ground": guide, "mechanism.slider.inertia": 1e-4} | changes)
    case["mechanism"]["gravity"] = 9.81
    case["loads"] = {"dead": {"on": "slider", "force": [0.0, -weight]}}
    case["drive"] = {"speed": "600 rpm"}
    case["simulate"] = {"revolutions": 3, "discard": 1, "tolerance": 1e-8}
    path = clearsweep.simulate(clearsweep.load_case(case))
    assert path.status == "ok"
    return {name.removeprefix("slider_ground_"): value for name, value in path.summary.items()}


def test_forces_of_a_guide_are_those_across_it():
    """A block that rests evenly on two corners carries the reaction of the ideal guide, each corner half of it."""
    block = dead_weight_on_a_block(200.0)
    assert block["force_peak"] == pytest.approx(218.27, rel=1e-4)
    assert block["force_peak_ratio"] == pytest.approx(1.0, rel=1e-3)
    assert block["force_rms"] == pytest.approx(202.6, rel=1e-3)
    assert block["corner_force_peak"] == pytest.approx(109.13, rel=1e-4)
    assert block["corner_force_rms"] == pytest.approx(101.3, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("weight", [0.0, 20.0])
def test_no_mean_or_quantile_of_a_guide_exceeds_its_peak(weight):
    friction = {"law": "tanh", "coefficient": 0.2, "velocity_scale": 0.01}
    block = dead_weight_on_a_block(weight, **{"joints.slider-ground.friction": friction})
    assert max(block["force_rms"], block["force_p99"]) <= block["force_peak"] <= block["load_peak"]
    assert block["corner_force_rms"] <= block["corner_force_peak"]
    assert block["force_peak_median"] <= block["force_peak"]


def pin_beside_a_guide(**guide_keys):
    """Return the grid of a slider-crank whose crank pin wears and whose slider is a block in a guide with clearance."""
    contact = {"law": "hunt-crossley", "stiffness": 6.61e10, "exponent": 1.5, "restitution": 0.8}
    friction = {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-5, "v1": 1e-4}
    pin = {"clearance": 1e-4, "bearing_radius": 0.01, "length": 0.02, "contact": contact, "friction": friction}
    pin["wear"] = {"law": "archard", "coefficient": "1e-16 m^2/N", "hardness": 1e9, "bins": 180}
    guide = {"clearance": 1e-4, "length": 0.06, "height": 0.03, "contact": contact | {"stiffness": 1e9}} | guide_keys
    case = slider_crank(changes={"mechanism.slider.inertia": 1e-4, "drive.speed": 60.0})
    case["joints"] = {"slider-ground": guide | {"friction": friction}, "crank-rod": pin}
    return case | {"simulate": {"revolutions": 1, "discard": 0}}


@pytest.mark.slow
def test_a_pin_wears_beside_a_guide():
    """Archard's volume of two bodies is twice the coefficient times friction energy over friction, over small arcs."""
    case = clearsweep.load_case(pin_beside_a_guide())
    summary = clearsweep.simulate(case).summary
    energy = summary["crank_rod_friction_power"] * 2.0 * math.pi / case.value.reference_rate
    assert summary["crank_rod_wear_volume"] == pytest.approx(2e-16 * energy / 0.05, rel=0.01)


def test_layouts_that_are_kept_follow_the_figures_there_are(further):
    case = grid.load(slider_crank("rod-slider"), simulation.catalogue()).case(0)
    assert COLUMN in {column.name for column in simulation.build(case).layout.columns}


def test_layouts_are_kept_by_all_that_decides_them():
    case = grid.load(slider_crank("rod-slider"), simulation.catalogue()).case(0)
    assert simulation.build(case).layout is simulation.build(case).layout
    for changes in ({"horizon": True}, {"error_check": True}):
        changed = case._replace(simulate=case.simulate._replace(**changes))
        assert simulation.build(changed).layout == Layout.of(changed, simulation.catalogue())
    assert COLUMN not in {column.name for column in simulation.build(case).layout.columns}


def source(**changes):
    """Return a grid of one case of two revolutions; `changes` has `__` for dots."""
    asked = {key.replace("__", "."): value for key, value in changes.items()}
    return slider_crank("rod-slider", changes={"simulate.revolutions": 2, "simulate.tolerance": 1e-6} | asked)


def test_a_further_figure_is_a_column_a_row_of_the_report_and_has_an_error_check(further, tmp_path):
    clearsweep.sweep(source(simulate__error_check=True), out=tmp_path / "run", jobs=1, executor="serial")
    run = clearsweep.open(tmp_path / "run")
    (row,) = run.summary.to_dict("records")
    assert row[COLUMN] == pytest.approx(row["rod_slider_force_rms"] ** 2, rel=1e-12)
    assert run.summary.attrs["units"][COLUMN] == run.summary.attrs["units"][f"{COLUMN}_difference"] == "N^2"
    assert run.summary.attrs["descriptions"][COLUMN] == TEXT
    files = {file.name: file for file in report.tables(run, tmp_path / "tables")}
    assert "force mean square [N^2]" in files["peaks_rod_slider.csv"].read_text(encoding="utf-8").splitlines()[0]


def test_a_further_figure_can_be_judged_and_limited(further):
    until = {"figure": COLUMN, "relative_ci": 0.2, "max_revolutions": 4}
    loaded = grid.load(source(simulate__until=until, limits={COLUMN: "4 kN^2"}), simulation.catalogue())
    assert loaded.limits == {COLUMN: 4e6}
    unit = {column.name: column.unit for column in loaded.layout.columns}
    assert unit["figure_ci"] == unit[COLUMN] == "N^2"


def test_a_further_figure_is_a_word_of_the_schema_and_a_row_of_the_table_of_columns(further):
    known = simulation.catalogue()
    figure = whole_schema(known)["properties"]["simulate"]["properties"]["until"]["properties"]["figure"]
    words = {word for kind in figure["anyOf"] for word in kind.get("enum", ())}
    assert {COLUMN, "ground_crank_force_mean_square"} <= words
    assert f"| `J_force_mean_square` * | N^2 | {TEXT} |  |" in columns_markdown(known).splitlines()


def test_the_table_of_columns_is_made_of_the_figures():
    text = (ROOT / "docs/columns.md").read_text(encoding="utf-8")
    assert text.partition("<!-- columns -->\n")[2].startswith(columns_markdown(simulation.catalogue()))


def test_figures_have_names_of_their_own_and_need_what_there_is():
    names = [figure.name for figure in catalogue.FIGURES]
    assert len(set(names)) == len(names)
    needs = {need for figure in catalogue.FIGURES for need in figure.needs}
    of_case = {"turns", "rests", "free", "horizon", "error_check", "until", "life", "uncertain", "vibration", "bends"}
    of_case |= {"mounted", "fatigue"}
    of_place = {"zones", "across", "moves"}
    of_joint = {"wear", "arc", "film", "friction", "guide", "spatial", "axial", "strength", "limited", "thermal"}
    of_joint |= {"rolling", "dynamic", "static", "flanked"}
    assert needs <= of_case | of_joint | of_place
    assert {figure.of for figure in catalogue.FIGURES} == {"joint", "output", "case", "place", "order", "link", "mount"}


def test_every_figure_of_a_case_is_computed():
    path = clearsweep.simulate(clearsweep.load_case(source()))
    missing = {name for name, value in path.summary.items() if value is None}
    assert path.status == "ok"
    short = {"period", "periodic_from"} | {
        f"rod_slider_force_peak_{name}" for name in ("median_low", "median_high", "p95_high")
    }
    short |= {f"rod_slider_force_peak_million{end}" for end in ("", "_high")}
    assert missing <= {"rod_slider_onset_rate"} | short  # none in free flight; two revolutions are too few for these


def test_a_layout_is_read_from_run_json_as_it_was():
    layout = grid.load(source(simulate__horizon=True), simulation.catalogue()).layout
    assert Layout.read(json.loads(json.dumps(layout.written()))) == layout
    assert isinstance(hash(layout), int)


@pytest.mark.parametrize("form", [grid.SCHEMA_VERSION - 1, None])
def test_a_directory_of_another_form_is_refused_in_a_sentence(tmp_path, form):
    record = {"layout": ["slider-crank", [["rod_slider", 0]]], "frame": {"schema": form}, "versions": {}}
    (tmp_path / "run.json").write_text(json.dumps(record), encoding="utf-8")
    with pytest.raises(DirectoryError, match=f"has format {form} of .*reads format {grid.SCHEMA_VERSION}"):
        clearsweep.open(tmp_path)


# ---------------------------------------------------------------------------------------------- passing lines


PARTS = "cage", "element", "inner", "outer"
GRID = grid_of("a ball bearing whose lines pass")
RATE = 2.0 * math.pi * 25.0


def blackman_harris(count):
    """Return the window at `count` times from the first to before the last, of mean 1."""
    angle = 2.0 * math.pi * np.arange(count) / count
    return sum((-1) ** k * term * np.cos(k * angle) for k, term in enumerate(WINDOW)) / WINDOW[0]


@pytest.mark.parametrize("line", [6.0, 6.37, 40.5, 101.93])
def test_a_sine_between_lines_has_its_amplitude(line):
    """Its whole spectrum also has a sine 1000 times as large, six lines away."""
    times = np.arange(4096) / 4096
    signal = 0.7 * np.cos(2.0 * math.pi * line * times + 0.4) + 700.0 * np.sin(2.0 * math.pi * (line + 6.0) * times)
    spectrum = 2.0 * np.fft.rfft(signal)[:400] / len(times)
    result = abs(spectrum @ window_transform(line - np.arange(400)))
    assert result == pytest.approx(0.7, abs=700.0 * 10 ** (-92 / 20) + 1e-3)
    alone = 2.0 * np.fft.rfft(0.7 * np.cos(2.0 * math.pi * line * times + 0.4))[:400] / len(times)
    assert abs(alone @ window_transform(line - np.arange(400))) == pytest.approx(0.7, rel=2e-4)


@pytest.mark.slow  # compiles a rolling bearing with vibration
def test_passing_lines_are_those_of_sampled_histories():
    """Of the histories less their mean turn, as spectra leave out the orders of the crank."""
    scene = clearsweep.load_case(GRID)
    count = 12 * 4096
    times = 2.0 * math.pi / RATE * (3.0 + 12.0 * np.arange(count + 1) / count)
    motion = clearsweep.simulate(scene, times=times)
    channels, figures = motion.channels, motion.summary
    masses = {"crank": 0.3, "rod": 0.21, "slider": 0.14}
    momenta = [sum(m * channels[f"{body}/v{axis}"] for body, m in masses.items()) for axis in "xy"]
    forces = [-np.gradient(momentum, times) for momentum in momenta]
    velocities = {
        "slider": [channels["slider/vx"]],
        "middle": [channels["rod/vx"], channels["rod/vy"]],
        "frame": forces,
    }
    window, known = blackman_harris(count), 0
    for part in PARTS:
        frequency = figures[f"crank_rod_{part}_frequency"]
        wave = window * np.exp(-2j * math.pi * frequency * times[:-1])
        order = frequency / 25.0
        for place, signals in velocities.items():
            turns = [signal[:-1].reshape(12, -1) for signal in signals]
            sums = [abs(2.0 * np.mean((turn - turn.mean(axis=0)).ravel() * wave)) for turn in turns]
            value = max(sums) / (40.0 * 2.0 * math.pi * frequency if place == "frame" else 1.0)
            result = figures[f"{place}_crank_rod_{part}_velocity"]
            if abs(order - round(order)) * 12.0 < len(WINDOW):
                assert result is None
                continue
            known += 1
            assert result == pytest.approx(value, rel=5e-3 if place == "frame" else 1e-4), (place, part)
    assert known >= 6


def test_columns_are_those_of_places_that_move_and_bearings():
    columns = load(GRID, simulation.catalogue()).layout.units
    expected = {f"{at}_crank_rod_{part}_velocity" for at in ("frame", "slider", "middle") for part in PARTS}
    assert expected == {name for name in columns if name.endswith("_velocity") and "crank_rod" in name}
    still = copy.deepcopy(GRID)
    still["vibration"]["at"] = {"frame": {}}
    assert not any(name.endswith("_velocity") for name in load(still, simulation.catalogue()).layout.units)
    plain = copy.deepcopy(GRID)
    plain["joints"]["crank-rod"] = {
        "clearance": 1e-4,
        "bearing_radius": 0.01,
        "contact": {"law": "hertz", "stiffness": 6.61e10},
    }
    assert not any(name.endswith("_velocity") for name in load(plain, simulation.catalogue()).layout.units)
