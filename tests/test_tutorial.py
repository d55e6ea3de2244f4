"""The tutorial: its grids are those that are ready, and its steps lead to the decision that it takes."""

import math
import os
import re
import runpy
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fake_physics import sweep
from ruamel.yaml import YAML
from scipy.special import beta
from test_own_laws import CRANK, FLORES, PAIR, catalogue_of, figures_of, joint_of, with_joint

import clearsweep
from clearsweep import grid, simulation
from clearsweep.cli import verbs
from clearsweep.contracts import results
from clearsweep.contracts.case import OwnFigure
from clearsweep.contracts.layout import Layout
from clearsweep.grid.library import fits as iso286
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.contract import compile_law, internal_rates
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.machines.planar.drives import motor_torque
from clearsweep.mechanics.wear import SlidingContact, wear_rate
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


# The laws on the page of laws of one's own: each is read from the page and compared with its closed form.


PAGE = Path(__file__).parents[1] / "docs/howto/own-laws.md"
AZAD = {"law": "azad-featherstone", "k": "1e9 N/m^1.5", "d": "2 kN*s/m^1.5"}
PALMGREN = {"law": "exact", "restitution": 0.7, "elastic": "palmgren", "roller": "20 mm"}
MAKKAR = {"law": "makkar", "g1": 0.05, "g2": "1 s/mm", "g3": "0.1 s/mm", "g4": 0.1, "g5": "0.5 s/mm", "g6": "0.01 s/m"}
CONSTANTINOU = {"law": "constantinou", "f_max": 0.12, "f_min": 0.05, "a": "20 s/m", "y": "5 um"}
USUI = {"law": "usui", "a": "1e-15 m^2/N", "b": "2000 K", "temperature": "400 K"}
KLOSS = {"motor": {"law": "kloss", "breakdown": "5 N*m", "slip": 0.1, "synchronous": "1000 rpm"}}
FREE = KLOSS | {"initial_speed": "500 rpm", "inertia": "1e-3 kg*m^2"}


@pytest.fixture(scope="module")
def catalogue(tmp_path_factory):
    blocks = re.findall(r"```py\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    file = tmp_path_factory.mktemp("page") / "my_laws.py"
    file.write_text("\n\n".join(blocks))
    return catalogue_of(lambda: runpy.run_path(str(file)))


def test_the_page_has_the_law_of_its_beginning_a_curve_six_of_papers_and_a_figure(catalogue):
    assert len([law for law in catalogue.laws if law.origin]) == 9


@pytest.mark.parametrize(("power", "mean"), [(2.0, 0.5), (3.0, 4.0 / (3.0 * math.pi)), (4.0, 0.375)])
def test_the_equivalent_load_of_a_sine_is_its_mean_power(catalogue, power, mean):
    t = np.linspace(0.0, 1.0, 1000, endpoint=False)
    normal, tangential = 800.0 * np.sin(2.0 * math.pi * t), 600.0 * np.sin(2.0 * math.pi * t)
    channels = {"joints/rod_slider/force_normal": normal, "joints/rod_slider/force_tangential": tangential}
    figure = OwnFigure("load", "equivalent-load", {"power": power}, catalogue.own_laws)
    load = compile_law("figure", "equivalent-load", figure)(t, channels)
    assert load == pytest.approx(1000.0 * mean ** (1.0 / power), rel=1e-5)


def test_a_torque_curve_is_linear_between_its_points(catalogue):
    motor = {"motor": {"law": "torque-curve", "scale": 2.0}}
    case = grid.load(
        with_joint(CRANK, contact=FLORES) | {"drive": motor | {"initial_speed": "10 rpm"}}, catalogue
    ).case(0)
    law, speeds = compile_law("motor", "torque-curve", case.drive), (0.0, 20.0, 50.0, 75.0, 115.0, 143.5, 157.0)
    expected = np.interp(speeds, (0.0, 50.0, 100.0, 130.0, 157.0), (6.0, 4.8, 5.6, 4.0, 0.0))
    assert [motor_torque(law, speed, 0.0) for speed in speeds] == pytest.approx(expected, abs=1e-12)


def test_azad_and_featherstone_lose_what_the_work_of_their_damper_over_hertz_is(catalogue):
    result = registry.derived_values(joint_of(with_joint(PAIR, contact=AZAD), catalogue))
    speed, depth = 0.1, (1.25 * 0.1**2 / 1e9) ** 0.4
    expected = 0.8 * beta(0.6, 1.5) * 2e3 * depth**1.5 / speed
    assert expected < 0.02
    assert 1.0 - result["contact.restitution at 0.1 m/s and 1 kg"][0] == pytest.approx(expected, rel=expected)


def test_palmgren_gives_the_approach_of_a_roller(catalogue):
    elastic = compile_law("elastic", "palmgren", joint_of(with_joint(CRANK, contact=PALMGREN), catalogue))
    approach = 3.84e-5 * 5000.0**0.9 / 20.0**0.8  # mm
    assert elastic_force(elastic, 1e-3 * approach) == pytest.approx(5000.0, rel=1e-12)


def test_makkar_has_its_slope_at_rest_and_its_limit_at_speed(catalogue):
    joint = joint_of(with_joint(CRANK, contact=FLORES, friction=MAKKAR), catalogue)
    friction = registry.compile_friction(joint)
    slope = 0.05 * (1000.0 - 100.0) + 0.1 * 500.0 + 0.01
    assert friction_force(friction, 10.0, 1e-9) == pytest.approx(-10.0 * slope * 1e-9, rel=1e-6)
    assert friction_force(friction, 10.0, 3.0) == pytest.approx(-10.0 * (0.1 + 0.01 * 3.0), rel=1e-12)


def test_constantinou_slid_from_rest_carries_the_hyperbolic_tangent_of_its_friction(catalogue):
    joint = joint_of(with_joint(CRANK, contact=FLORES, friction=CONSTANTINOU), catalogue)
    friction, slip, steps = registry.compile_friction(joint), 0.1, 400

    class Sliding:
        normal = 10.0

    Sliding.slip = slip

    def rate(state):
        return internal_rates(friction._replace(state_0=state), Sliding)[0]

    state, step = 0.0, 5e-6 / slip / steps  # up to the distance of yield, by the midpoint rule
    for _ in range(steps):
        state += step * rate(state + 0.5 * step * rate(state))
    assert state == pytest.approx(math.tanh(1.0), rel=1e-5)
    coefficient = 0.12 - 0.07 * math.exp(-2.0)
    assert friction_force(friction._replace(state_0=state), 10.0, slip) == pytest.approx(-10.0 * coefficient * state)


def test_usui_wears_by_the_law_of_arrhenius_and_like_archard_without_it(catalogue):
    sliding = SlidingContact(1e4, 1e-6, 0.3, 0.0, 0.0, 1e4, 1e-4, 0.2)
    for b, share in ((2000.0, math.exp(-5.0)), (0.0, 1.0)):
        joint = joint_of(with_joint(CRANK, contact=FLORES, wear=USUI | {"b": f"{b} K"}), catalogue)
        expected = 1e-15 * 1e4 * 0.3 * share
        assert wear_rate(registry.compile_wear(joint), sliding) == pytest.approx((expected, expected), rel=1e-12)


def test_kloss_gives_its_breakdown_torque_and_none_at_the_synchronous_speed(catalogue):
    case = grid.load(with_joint(CRANK, contact=FLORES) | {"drive": FREE}, catalogue).case(0)
    motor, synchronous = compile_law("motor", "kloss", case.drive), 1000.0 * math.pi / 30.0
    torques = [motor_torque(motor, x * synchronous, 0.0) for x in (0.9, 1.0, 0.5, 0.95)]
    assert torques[:2] == pytest.approx([5.0, 0.0], abs=1e-12)
    assert max(torques) == torques[0]


@pytest.mark.slow
def test_the_laws_of_the_page_move_a_machine(catalogue):
    first = with_joint(CRANK, contact=AZAD, friction=CONSTANTINOU, wear=USUI)
    second = with_joint(CRANK, contact=PALMGREN, friction=MAKKAR) | {"drive": FREE}
    for source in (first, second):
        figures = figures_of(source, catalogue)
        assert abs(figures["energy_residual"]) < 1e-5
        assert np.isfinite(figures["rod_slider_force_peak"])
    assert figures_of(first, catalogue)["rod_slider_wear_depth_max"] > 0.0


# The template of a workflow runs what there is here, and keeps what that writes.


@pytest.fixture(scope="module")
def steps():
    """Return the steps of the template."""
    workflow = YAML(typ="safe").load((ROOT / "docs/workflow.yaml").read_text(encoding="utf-8"))
    (job,) = workflow["jobs"].values()
    return job["steps"]


def step_of(steps, action):
    """Return the settings of the step that uses an action."""
    (step,) = (step for step in steps if step.get("uses", "").startswith(f"actions/{action}@"))
    return step["with"]


def test_the_report_that_make_run_writes_is_kept(steps):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    (reported,) = re.findall(r"^\t\$\(BIN\)/clearsweep report (\S+)$", makefile, re.MULTILINE)
    assert any(re.search(r"\bmake run\b", step.get("run", "")) for step in steps)
    assert step_of(steps, "upload-artifact")["path"] == f"{reported}/report.html"


def test_the_key_of_the_cache_follows_from_all_that_compiled_code_depends_on(steps):
    settings = step_of(steps, "cache")
    assert settings["path"] == "~/.cache/clearsweep"
    patterns = re.findall(r"'([^']+)'", settings["key"])
    covered = {path for pattern in patterns for path in ROOT.glob(pattern)}
    assert covered >= {*(ROOT / "clearsweep/mechanics").rglob("*.py"), ROOT / "constraints.txt"}
    assert re.search(r"^llvmlite==", (ROOT / "constraints.txt").read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.slow
def test_every_command_runs_in_a_fresh_clone(steps, tmp_path):
    """With an empty home and a bare environment, as on a runner; only the actions of the service are left out."""
    clone, home = tmp_path / "clone", tmp_path / "home"
    home.mkdir()
    subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    kept = {name: os.environ[name] for name in os.environ if name.upper().startswith(("PATH", "LANG", "PIP_", "HTTP"))}
    for step in steps:
        if "run" in step:
            command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
            environment = kept | {"HOME": str(home), "CI": "true"}
            done = subprocess.run(command, cwd=clone, env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{step['run']}\n{done.stdout}\n{done.stderr}"
    assert (clone / step_of(steps, "upload-artifact")["path"]).is_file()
