"""The tutorial: its grids are those that are ready, and its steps lead to the decision that it takes."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fake_physics import sweep

import clearsweep
from clearsweep import grid, simulation
from clearsweep.cli import verbs
from clearsweep.contracts import results
from clearsweep.contracts.layout import Layout
from clearsweep.grid.library import fits as iso286
from clearsweep.report.sections.motion import peak_revolution_sections
from clearsweep.report.study import prepare
from clearsweep.sweeping.summary import of_run, run_text

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
CLEARANCE = "joints.rod-slider.clearance"
SAFE = 71.4e-6  # m, the largest clearance that is safe where the force is made up


def shown(mark):
    return re.search(rf"<!-- {re.escape(mark)} -->\n```\w+\n(.*?)```", TEXT, re.DOTALL).group(1)


class Quick:
    """The laws and mechanisms that there are, with a made-up load: twice the ideal one at 120 rpm and SAFE."""

    catalogue = staticmethod(simulation.catalogue)
    derived = staticmethod(simulation.derived)
    warnings = staticmethod(simulation.warnings)

    @staticmethod
    def load():
        """Do nothing."""

    @staticmethod
    def signature(case):
        """Return one kind for all."""
        return ""

    @staticmethod
    def compile_for(case):
        """Do nothing."""

    compile_loop = compile_for

    @classmethod
    def solve(cls, case, log=None):
        """Return a made-up trajectory."""
        ratio = 1.0 + case.joints[0].clearance / SAFE * case.drive.speed / (4.0 * np.pi)
        layout = Layout.of(case, simulation.catalogue())
        summary = {column.name: 1.0 for column in layout.columns}
        summary |= dict.fromkeys(("rod_slider_load_peak", "rod_slider_force_peak"), 4e4 * ratio)
        summary |= {"rod_slider_force_peak_ideal": 4e4, "rod_slider_force_peak_ratio": ratio, "period": None}
        summary["rod_slider_wear_rate_max"] = 50e-6 / 3.6e6  # in 1000 h
        channels = {column.name: np.linspace(0.0, 1.0, 5) for column in layout.channels}
        worn = {"rod_slider": (np.zeros(360), np.zeros(360))}
        return results.Trajectory("ok", "", summary, channels, wear=worn)

    @classmethod
    def peak(cls, case, joint, revolutions, *window):
        """Return a made-up revolution."""
        return results.Peak(1.0, cls.solve(case))


def read(name):
    """Return a grid of the tutorial."""
    return grid.load(ROOT / "configs" / f"{name}.yaml", simulation.catalogue())


def test_the_grids_are_those_that_are_shown():
    assert shown("grid: configs/press_joint.yaml") == (ROOT / "configs/press_joint.yaml").read_text(encoding="utf-8")
    end = shown("end of configs/press_joint_largest.yaml")
    largest = (ROOT / "configs/press_joint_largest.yaml").read_text(encoding="utf-8")
    assert largest.endswith(end)
    first, second, third = (read(f"press_joint{more}").resolved() for more in ("", "_largest", "_life"))
    same = ("mechanism", "drive", "loads", "limits")
    assert {key: first[key] for key in same} == {key: second[key] for key in same} == {key: third[key] for key in same}
    life = (ROOT / "configs/press_joint_life.yaml").read_text(encoding="utf-8")
    assert shown("line of configs/press_joint_life.yaml") in life
    assert third["joints"]["rod-slider"]["clearance"] == iso286.find_fit("H7/f7", 80).high


def test_the_fits_have_the_clearances_that_are_reported():
    for name, low, high in re.findall(r"\((H\d+/\w+), radial\) = ([\d.]+ \w+) to ([\d.]+ \w+)", TEXT):
        fit = iso286.find_fit(name, 80)
        assert [fit.low, fit.high] == [clearsweep.language.quantity.read(text, "m") for text in (low, high)]


def test_the_steps_lead_to_a_decision_with_made_up_forces(tmp_path):
    out = tmp_path / "press"
    result = sweep(read("press_joint"), out, simulator=Quick, executor="serial", show_progress=False)
    run = clearsweep.open(out)
    message = run_text(of_run(result))
    assert "(H7/f7) = 15 µm to 45 µm radial" in message
    over = run.summary[CLEARANCE] * run.summary["drive.speed"] / (4.0 * np.pi) > SAFE
    assert of_run(result)["answer"]["cases"]["exceeded"] == int(over.sum())
    assert run.worst == run.summary.nlargest(3, "rod_slider_force_peak_ratio")["case_id"].tolist()
    assert run.summary["hours_to_50_um_wear"].tolist() == pytest.approx([1000.0] * 30, rel=1e-12)
    (part,) = peak_revolution_sections(prepare(run))
    assert [block.case_id for block in part.blocks[1:]] == run.worst
    largest = read("press_joint_largest")
    sweep(largest, tmp_path / "largest", simulator=Quick, executor="serial", show_progress=False)
    answer = clearsweep.open(tmp_path / "largest").seek.iloc[0]
    assert SAFE - 2e-6 < answer["seek_low"] <= SAFE < answer["seek_high"]
    fits = [iso286.find_fit(name, 80) for name in ("H7/g6", "H7/f7", "H8/e8", "H9/d9", "H11/c11")]
    assert [fit.name for fit in fits if fit.high <= answer["seek_low"]][-1] == "H7/f7"


def test_the_best_design_has_the_least_clearance_where_that_decides_the_force(tmp_path):
    grid_file = (ROOT / "configs/press_joint_best.yaml").read_text(encoding="utf-8")
    assert grid_file.endswith(shown("end of configs/press_joint_best.yaml"))
    best = read("press_joint_best")
    result = sweep(best, tmp_path / "best", simulator=Quick, executor="serial", show_progress=False)
    assert result.ran == best.search.cases
    points = [each.point for each in result.search_result.best]
    assert min(point[CLEARANCE] for point in points) < 20e-6
    assert result.search_result.start.point == {"define.width": 0.08, CLEARANCE: 45e-6}
    assert best.case(0).joints[0].length == 0.08


@pytest.mark.slow
def test_the_commands_lead_to_the_decision(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "configs", tmp_path / "configs")
    monkeypatch.chdir(tmp_path)
    for block in re.findall(r"```console\n(.*?)```", TEXT, re.DOTALL):
        for line in block.replace("\\\n", " ").splitlines():
            words = [word.strip('"') for word in re.findall(r'"[^"]*"|\S+', line.removeprefix("$ clearsweep "))]
            done = CliRunner().invoke(verbs, words)
            assert done.exit_code == 0, done.output
    summary = clearsweep.open("results/press-joint").summary
    worst = summary.groupby(CLEARANCE)["rod_slider_force_peak_ratio"].max().tolist()
    assert worst[0] < 1.1
    assert worst[1] < 1.2
    assert worst[2] < 1.9
    assert worst[4] > 3.0
    answer = clearsweep.open("results/press-joint-largest").seek.iloc[0]
    assert 60e-6 < answer["seek_low"] < 76e-6
    laws = clearsweep.open("results/press-joint-laws").summary
    assert (laws["limits_exceeded"] == "").all()
    assert laws["margin"].min() == pytest.approx(0.32, abs=0.05, rel=0.0)
    lives = clearsweep.open("results/press-joint-life").summary.sort_values("drive.speed")["rod_slider_life_hours"]
    assert lives.tolist() == pytest.approx([2644, 869, 417], rel=0.05, abs=0.0)
    hours = laws.groupby("drive.speed")["hours_to_50_um_wear"].mean()
    assert hours.iloc[0] == pytest.approx(11_800, rel=0.05, abs=0.0)
    assert hours.iloc[-1] == pytest.approx(1_700, rel=0.05, abs=0.0)
