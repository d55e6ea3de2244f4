"""Figures of one's own: functions of the time histories of a case that give columns of the summary."""

import json
import math
import os

import numpy as np
import pytest
from click.testing import CliRunner
from fake_runs import forget_laws
from pyarrow.parquet import read_table
from test_own_laws import CRANK, FLORES, PAIR, with_joint

from clearsweep import grid as grids
from clearsweep import laws
from clearsweep.cli import verbs
from clearsweep.grid.written import law_execution
from clearsweep.simulation import catalogue, simulate
from clearsweep.simulation.setup import scene

LAWS = """import numpy as np
from clearsweep import laws

@laws.figure("power-mean", "m", channel=laws.key("1", default=0.0), power=laws.key("1", above=0.0, default=2.0))
def power_mean(t, channels, p):
    x = channels["joints/rod_slider/x" if p.channel == 0.0 else "joints/rod_slider/y"]
    return np.mean(np.abs(x) ** p.power) ** (1.0 / p.power)

@laws.figure("angle-integral", "rad*s", doc="integral of the crank angle over time, times a {factor}", factor="1")
def angle_integral(t, channels, p):
    return p.factor * np.trapezoid(channels["crank_angle"], t)

@laws.figure("samples")
def samples(t, channels, p):
    return len(t)

@laws.figure("broken", kind="1")
def broken(t, channels, p):
    if p.kind == 1.0:
        return float("nan")
    if p.kind == 2.0:
        return "text"
    if p.kind == 3.0:
        channels["slider/a"][0] = 0.0
    if p.kind == 4.0:
        return t
    if p.kind == 5.0:
        return True
    raise ValueError("of no kind")
"""
SPEED = 1000.0 * 2.0 * math.pi / 60.0  # rad/s
MACHINE = with_joint(CRANK, contact=FLORES)
MACHINE |= {"simulate": {"revolutions": 0.5, "discard": 0.25, "tolerance": "1e-6"}}
ANGLE = {"law": "angle-integral", "factor": 2}


@pytest.fixture(autouse=True)
def trusted(place):
    """A folder with a trusted law file."""
    write_laws(LAWS)


def write_laws(text):
    law_execution.Path("my_figures.py").write_text(text, encoding="utf-8")
    grids.trust(law_execution.Path("my_figures.py"))


def load(figures, machine=MACHINE, **sections):
    with open("grid.json", "w", encoding="utf-8") as file:
        json.dump(machine | {"name": "own", "laws": "my_figures.py", "figures": figures} | sections, file)
    return grids.load("grid.json", catalogue())


def run(figures, machine=MACHINE, **sections):
    return simulate(scene.build(load(figures, machine, **sections).case(0)))


@pytest.mark.parametrize(
    ("save", "stored"),
    [
        ({"orbits": "none"}, 0),
        ({"orbits": "last", "revolutions": 0.1, "samples": 100}, 11),
        ({"orbits": "last", "revolutions": 0.4, "samples": 100}, 41),
        ({"orbits": "all", "samples": 100}, 51),
    ],
)
def test_a_figure_gets_the_window_whatever_is_saved(save, stored):
    trajectory = run({"area": ANGLE, "count": "samples"}, save={"samples": 100} | save)
    start, end = 0.25 * 2.0 * math.pi, 0.5 * 2.0 * math.pi  # rad: the crank turns steadily
    assert trajectory.summary["area"] == pytest.approx((end**2 - start**2) / SPEED, rel=1e-12)
    assert trajectory.summary["count"] == 26.0
    assert len(trajectory.channels.get("t", ())) == stored
    assert trajectory.units["area"] == "rad*s"


def test_a_figure_without_a_crank_gets_the_whole_run():
    machine = with_joint(PAIR, contact=FLORES)
    trajectory = run({"count": "samples"}, machine, save={"orbits": "none", "samples": 30})
    assert trajectory.summary["count"] == 31.0


def test_a_figure_has_keys_with_defaults_and_is_used_twice():
    figures = {"rms": "power-mean", "mean": {"law": "power-mean", "channel": 1, "power": 1}}
    trajectory = run(figures, save={"orbits": "all", "samples": 100})
    x, y = (trajectory.channels[f"joints/rod_slider/{name}"][25:] for name in "xy")
    assert trajectory.summary["rms"] == pytest.approx(math.sqrt(sum(value * value for value in x) / 26), rel=1e-12)
    assert trajectory.summary["mean"] == pytest.approx(sum(map(abs, y)) / 26, rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (1, "my_figures.py:17: laws.figure 'broken' gives nan; expected a finite number"),
        (2, "my_figures.py:17: laws.figure 'broken' gives 'text'; expected a number"),
        (3, "my_figures.py:24: ValueError: assignment destination is read-only: channels"),
        (4, "my_figures.py:17: laws.figure 'broken' gives "),
        (5, "my_figures.py:17: laws.figure 'broken' gives true; expected a number"),
        (6, 'my_figures.py:29: ValueError: of no kind: raise ValueError("of no kind")'),
    ],
)
def test_a_figure_that_fails_is_missing_and_a_remark_says_why(kind, message):
    trajectory = run(
        {"bad": {"law": "broken", "kind": kind}, "good": "samples"}, save={"orbits": "none", "samples": 100}
    )
    assert trajectory.status == "ok"
    assert trajectory.summary["bad"] is None
    assert trajectory.summary["good"] == 26.0
    assert f"own-figure: figures.bad: {message}" in trajectory.message


def test_a_decorated_figure_is_recorded_with_its_unit_and_has_no_function_of_c():
    with laws.collecting() as records:
        laws.figure("largest", "N", level="N")(lambda t, channels, p: channels["force"].max() / p.level)
    assert (records[0].kind, records[0].unit, records[0].keys[0].unit) == ("figure", "N", "N")


def test_identities_depend_on_the_figures_that_a_grid_names():
    before, other = (load(figures).case_id(0) for figures in ({"a": ANGLE}, {"a": ANGLE | {"factor": 3}}))
    assert before != other
    assert load({"a": ANGLE}, save={"samples": 100}).case_id(0) != before
    write_laws(LAWS.replace("of no kind", "of another kind"))
    assert load({"a": ANGLE}).case_id(0) == before
    write_laws(LAWS.replace("p.factor *", "2.0 * p.factor *"))
    assert load({"a": ANGLE}).case_id(0) != before
    expression = {"a": "2 * rod_slider_force_peak"}
    assert load(expression).case_id(0) == load(expression, save={"samples": 100}).case_id(0)


def test_a_key_may_be_an_expression_of_a_defined_quantity():
    figures = {"a": {"law": "angle-integral", "factor": "= 3 * twice"}}
    assert load(figures, define={"twice": 2}).case(0).figures[0].values == {"factor": 6.0}


def test_limits_and_expressions_use_figures():
    load({"area": ANGLE, "half": "area / 2"}, limits={"half": 0.01}, save={"orbits": "none"})
    summary = simulate(scene.load_case("grid.json")).summary
    assert summary["half"] == pytest.approx(0.5 * (math.pi**2 - (0.5 * math.pi) ** 2) / SPEED, rel=1e-12)
    assert summary["limits_exceeded"] == "half"


@pytest.mark.slow
def test_figures_of_runs_of_open_length_get_their_window():
    until = {"figure": "rod_slider_force_rms", "relative_ci": 0.9, "max_revolutions": 5}
    settings = {"revolutions": 2, "discard": 1, "tolerance": "1e-6", "until": until, "error_check": True}
    trajectory = run({"count": "samples"}, save={"orbits": "none", "samples": 50}, simulate=settings)
    window = trajectory.summary["revolutions_run"] - trajectory.summary["window_from"]
    assert trajectory.summary["count"] == 50.0 * window + 1.0
    assert "count_difference" not in trajectory.summary


@pytest.mark.slow
def test_a_run_sweeps_keys_and_judges_figures_and_a_report_runs_nothing(monkeypatch):
    figures = {"area": ANGLE, "count": "samples", "ratio": "area / count"}
    sections = {"sweep": {"figures.area.factor": [1, 2]}, "limits": {"area": 0.1}, "save": {"orbits": "none"}}
    load(figures, **sections)
    result = CliRunner().invoke(verbs, ["run", "grid.json"])
    assert result.exit_code == 0, result.output
    os.remove("my_figures.py")
    forget_laws(monkeypatch)
    monkeypatch.setattr(law_execution, "_executed", lambda file: pytest.fail("the law file ran"))
    assert CliRunner().invoke(verbs, ["report", "results/own"]).exit_code == 0
    assert "area" in law_execution.Path("results/own/report.html").read_text(encoding="utf-8")
    cases = read_table("results/own/summary.parquet").sort_by("figures.area.factor").to_pydict()
    expected = np.array([1.0, 2.0]) * 0.5 * (math.pi**2 - (0.5 * math.pi) ** 2) / SPEED
    np.testing.assert_allclose(cases["area"], expected, rtol=1e-12)
    np.testing.assert_allclose(cases["ratio"], expected / 181.0, rtol=1e-12)
    assert cases["limits_exceeded"] == ["" if area <= 0.1 else "area" for area in expected]
