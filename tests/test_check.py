"""`clearsweep check`: error against run time, stability and cost of a user's own cases."""

import copy
import json
import re
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from ruamel.yaml import YAML

from clearsweep import grid
from clearsweep.contracts.results import Trajectory
from clearsweep.language.errors import InputError
from clearsweep.simulation.analyses.trajectory import simulate
from clearsweep.simulation.setup import scene
from clearsweep.verify import accuracy, check, check_page, reference_run, rivals, stability

CONFIGS = Path(__file__).parents[1] / "configs"
PAIR = {
    "name": "pair",
    "mechanism": {"type": "impact-pair", "masses": [0.2, 0.2], "speed": 1.0},
    "joints": {"pair": {"clearance": 1e-3, "contact": {"law": "exact", "stiffness": 6.61e10, "restitution": 0.9}}},
    "simulate": {"impacts": 4, "tolerance": 1e-8},
    "sweep": {"joints.pair.contact.restitution": [0.5, 0.9]},
}


def checked(source, tmp_path, *selection, **options):
    """Return the check of some cases of a grid."""
    loaded = grid.load(source, scene.catalogue())
    options = {"seconds": 600.0} | options  # of a machine that does other things, too
    return check.measure(loaded, check.Options(selection or ("first",), directory=tmp_path, **options))


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """The check of the second case of PAIR, in its directory."""
    directory = tmp_path_factory.mktemp("check")
    return checked(PAIR, directory, grid.load(PAIR, scene.catalogue()).case_id(1)), directory


def quadruple_precision(name):
    """Return the grid, times (n,) s and positions (m) by channel of the journals in quadruple precision."""
    for problem in accuracy.all_problems():
        if problem.name == name:
            tree = reference_run.base_tree(grid.load(problem.grid, scene.catalogue()).written_case(0))
            solution = rivals.Solution(problem.samples, np.empty((0, 5)), 0, None, 0)
            path = rivals.sampled(reference_run.scene_of(tree), problem.times, solution)
            return problem.grid, problem.times, path.channels
    file = resources.files("clearsweep.verify") / "references" / "machines.json"
    machine = json.loads(file.read_text(encoding="utf-8"))["problems"][name]
    samples = {channel: np.array(values) for channel, values in machine["samples"].items()}
    return machine["grid"], samples["t"], samples


@pytest.mark.slow
@pytest.mark.parametrize("name", ["b_base", "b_grav_fric", "a_base", "ab_base", "fb_c", "sc_load", "sc_torque"])
def test_errors_are_those_against_quadruple_precision(name, tmp_path):
    """They are within a factor of 2 of the truth where they are ten times the reference's own error."""
    source, times, channels = quadruple_precision(name)
    case = checked(source, tmp_path)["cases"][0]
    tree = reference_run.base_tree(grid.load(source, scene.catalogue()).written_case(0))
    case_scene = reference_run.scene_of(tree)
    turned = times / times[-1] * source["simulate"]["revolutions"]
    times = times[turned < case["compared_revolutions"]]
    truth = Trajectory("ok", "", {}, {name: values[: len(times)] for name, values in channels.items()} | {"t": times})

    def moved(method, tolerance):
        settings = {"tolerance": tolerance, "method": method, "step_budget": reference_run.STEP_BUDGET}
        return simulate(case_scene.with_settings(**settings), times=times)

    def distance(path, other):
        return float(np.max(reference_run.distances(tree, path, other)))

    own_error = case["reference"]["error"]
    reference = moved("auto", case["reference"]["tolerance"])
    assert distance(reference, truth) < 2.0 * own_error
    rows = [row for row in case["ladder"] if row["error"] and row["error"] > 10.0 * own_error]
    assert len({row["tolerance"] for row in rows}) >= 5
    for row in rows:
        path = moved(row["method"], row["tolerance"])
        exact = distance(path, truth)
        assert exact <= 2.0 * row["error"], row  # the samples may miss the largest distance
        if exact > 10.0 * own_error:
            assert 0.5 < distance(path, reference) / exact < 2.0, row


def test_a_tighter_tolerance_errs_less_at_about_first_order(pair):
    """The error of a step is proportional to the tolerance."""
    case = pair[0]["cases"][0]
    errors = {row["tolerance"]: row["error"] for row in case["ladder"] if row["method"] == "auto"}
    assert errors[1e-4] > errors[1e-7] > errors[1e-10]
    assert 0.7 < case["order"] < 1.4
    assert case["yours"]["tolerance"] == 1e-8
    assert case["yours"]["error"] == errors[1e-8]
    assert all(row["events_equal"] for row in case["ladder"] if row["tolerance"] < 1e-5)


def test_the_restitution_at_its_extremes_is_among_the_variants(pair):
    """With every pair of factors that the scene has, and none that it lacks."""
    stable = pair[0]["cases"][0]["stability"]
    tree = reference_run.base_tree(grid.load(PAIR, scene.catalogue()).written_case(1))
    texts = {check.variant_text(variant) for variant in check.variants_of(tree)}
    assert stable["tried"] + len(stable["refused"]) == len(texts) == 50
    assert {"ten times the speed, restitution 0", "tolerance 1e-12", "a tenth of the clearance"} <= texts
    assert not any("friction" in text or "start" in text for text in texts)
    assert stable["passed"] == stable["tried"] - len(stable["failed"])


@pytest.mark.slow
def test_verdicts_are_those_of_the_stability_table():
    """A case of the table fails or passes in both."""
    from clearsweep.verify import extremes

    cases = stability.select_evenly(extremes.extreme_cases(), 6)
    for case in cases:
        tree = reference_run.base_tree(grid.load(case.grid, scene.catalogue()).written_case(0))
        if case.tuning or case.displacement:
            continue
        row = stability.run_case(case)
        assert bool(check.try_variant(tree, (), np.inf)["why"]) == bool(row["failure"]), case.name


@pytest.mark.slow
def test_a_variant_whose_link_leaves_its_model_is_refused_with_the_reason():
    """The rod of this machine folds at ten times its speed, by whatever method."""
    written = grid.load(CONFIGS / "bending_rod.yaml", scene.catalogue()).written_case(0)
    tree = reference_run.base_tree(written)
    fast = next(variant for variant in check.variants_of(tree) if check.variant_text(variant) == "ten times the speed")
    outcome = check.try_variant(tree, fast, np.inf)
    assert outcome["status"] == "refused"
    assert "beyond its second-order model" in outcome["why"]


@pytest.mark.slow
def test_all_variants_of_the_first_case_of_a_configuration_pass():
    """Journals in a tight bearing, overdamped contacts and a full friction are no failures of the integration."""
    loaded = grid.load(CONFIGS / "slider_crank.yaml", scene.catalogue())
    tree = reference_run.base_tree(loaded.written_case(0))
    for variant in check.variants_of(tree):
        assert check.try_variant(tree, variant, np.inf)["why"] == "", check.variant_text(variant)


def test_the_advice_tells_why_an_error_is_unknown_and_counts_failures_by_cause(tmp_path):
    """A step budget that is too small, in every case."""
    source = PAIR | {"simulate": {"impacts": 4, "tolerance": 1e-8, "step_budget": 3}}
    result = checked(source, tmp_path)
    unknown, stability_sentence = result["advice"]
    assert unknown.startswith("The error at your tolerance is unknown: reached the budget of 12 steps")
    assert re.match(
        r"0 of (\d+) variants pass; \1 by step-budget, the first is a tenth of the clearance: reached",
        stability_sentence,
    )
    case = result["cases"][0]
    assert case["yours"]["error"] is None
    text = check_page.result_text(result, lambda path, value: str(value))
    assert "contacts are missing" not in text


def test_values_of_a_case_have_the_units_of_the_grid():
    source = copy.deepcopy(PAIR) | {"define": {"gap": "0.1 mm"}, "sweep": {"define.gap": ["0.1 mm", "0.2 mm"]}}
    source["joints"]["pair"]["clearance"] = "= gap"
    text = check.text_of_values(grid.load(source, scene.catalogue()))
    case = {"case_id": "0" * 16, "chosen_as": ["worst"], "values": {"define.gap": 2e-4}}
    assert check_page.case_title(case, text) == "case 00000000 (worst): gap 0.2 mm"


def advice_for(errors, milliseconds=(1.0, 1.1, 1.5), yours=1e-6):
    """Return the second line of advice for errors at 1e-4, 1e-6 and 1e-8."""
    tolerances = (1e-4, 1e-6, 1e-8)
    rows = [
        {"method": "auto", "tolerance": tolerance, "error": error, "events_equal": True, "milliseconds": time}
        for tolerance, error, time in zip(tolerances, errors, milliseconds, strict=True)
    ]
    own = next(row for row in rows if row["tolerance"] == yours)
    stability = {"tried": 0, "passed": 0, "failed": []}
    case = {"case_id": "0" * 16, "ladder": rows, "yours": own, "compared_revolutions": 0.5, "stability": stability}
    return check.advice([case], complete=True)[1]


@pytest.mark.parametrize(
    ("errors", "words"),
    [
        ((1e-1, 1e-2, 1e-4), "Use 1e-08: it keeps the journal within 0.0001 of its clearance."),
        ((1e-1, 1e-2, 5e-3), "No tolerance keeps the journal within 0.001 of its clearance"),
        ((1e-2, 1e-4, 1e-7), "Keep yours, or use 1e-08: within 1e-07 of the clearance for 36 % more time."),
        ((1e-2, 1e-4, 1e-5), "Keep yours: no tolerance keeps the journal within 1e-06"),
        ((1e-4, 1e-7, 1e-9), "A looser tolerance would err by more than 1e-06 of the clearance; keep yours."),
        ((5e-7, 1e-7, 1e-9), "A looser tolerance saves no time worth having (0.0001: 9 %); keep yours."),
    ],
)
def test_the_advice_follows_from_errors_and_times(errors, words):
    """A tighter tolerance is named with its cost, a looser one where it saves time."""
    assert advice_for(errors).startswith(words)


def test_a_check_that_was_stopped_continues(tmp_path, monkeypatch):
    """What was measured is not measured again, and what is missing is said."""
    first = checked(PAIR, tmp_path, seconds=-1.0)
    assert not first["complete"]
    assert "run the same command again" in first["advice"][-1]
    assert first["cases"][0]["yours"]["error"] is None
    second = checked(PAIR, tmp_path)
    assert second["complete"]
    monkeypatch.setattr(reference_run, "simulate", None)
    monkeypatch.setattr(check, "simulate", None)
    assert json.dumps(checked(PAIR, tmp_path)) == json.dumps(second)


def test_another_grid_does_not_use_measured_pieces(tmp_path):
    """The pieces belong to the cases that were checked."""
    checked(PAIR, tmp_path)
    changed = json.loads(json.dumps(PAIR))
    changed["mechanism"]["speed"] = 2.0
    assert not checked(changed, tmp_path, seconds=-1.0)["complete"]


def test_the_worst_case_has_the_largest_ratio_and_an_unknown_one_is_refused(tmp_path):
    """Without a run of the grid its cases are run at a loose tolerance."""
    loaded = grid.load(PAIR, scene.catalogue())
    chosen = check.select_cases(loaded, ["worst", "first"], None, lambda sentence: None)
    peaks = [simulate(scene.build(loaded.case(index))).summary["pair_force_peak"] for index in range(2)]
    worst = int(np.argmax(peaks))
    assert "worst" in chosen[worst]
    assert "first" in chosen[0]
    with pytest.raises(InputError, match="no case of the grid match"):
        check.select_cases(loaded, ["zz"], None, lambda sentence: None)


def test_parts_are_what_the_scene_has(tmp_path):
    """Friction and wear are left out in turn; a scene without them has none."""
    source = json.loads(json.dumps(accuracy.all_problems()[0].grid))
    source["save"] = {"orbits": "none"}
    bare = check.costs_of_parts(grid.load(source, scene.catalogue()).written_case(0))
    assert [part["part"] for part in bare] == ["histogram", "rates"]
    assert bare[1]["milliseconds"] > 0.0


@pytest.mark.heavy
def test_the_command_prints_advice_and_writes_a_page(tmp_path):
    """JSON has the form of the contract; the page has both pictures."""
    from click.testing import CliRunner

    from clearsweep.cli import verbs

    path = tmp_path / "pair.yaml"
    with path.open("w", encoding="utf-8") as stream:
        YAML(typ="safe").dump(PAIR, stream)
    out = tmp_path / "out"
    result = CliRunner().invoke(
        verbs, ["check", str(path), "--case", "first", "--out", str(out), "--json", "--rivals", "--seconds", "600"]
    )
    assert result.exit_code == 0, result.output
    stored = json.loads((out / "check.json").read_text(encoding="utf-8"))
    case = stored["cases"][0]
    assert {"case_id", "values", "horizon_revolutions", "reference", "yours", "order", "ladder", "stability"} <= {*case}
    assert {"method", "tolerance", "error", "peaks", "events_equal", "milliseconds"} <= {*case["ladder"][0]}
    assert {"scipy DOP853", "scipy LSODA"} <= {row["method"] for row in case["ladder"]}
    assert len(stored["advice"]) == 3
    assert (out / "check.html").read_text(encoding="utf-8").count("<svg") == 2
