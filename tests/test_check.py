"""`clearsweep check`: error against run time, stability and cost of a user's own cases."""

import json

import numpy as np
import pytest
from ruamel.yaml import YAML

from clearsweep import grid
from clearsweep.language.errors import InputError
from clearsweep.simulation.analyses.trajectory import simulate
from clearsweep.simulation.setup import scene
from clearsweep.verify import check, problems, reference_run, rivals, stability

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
    return check.measure(loaded, check.Options(selection or ("first",), directory=tmp_path, **options))


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """The check of the second case of PAIR, in its directory."""
    directory = tmp_path_factory.mktemp("check")
    return checked(PAIR, directory, grid.load(PAIR, scene.catalogue()).case_id(1)), directory


@pytest.mark.heavy
def test_errors_are_those_against_quadruple_precision(tmp_path):
    """The reference is as good as it says, and errors are at least those at the ten samples that are known."""
    problem = next(problem for problem in problems.all_problems() if problem.name == "b_base")
    case = checked(problem.grid, tmp_path, seconds=300.0)["cases"][0]
    tree = reference_run.base_tree(grid.load(problem.grid, scene.catalogue()).written_case(0))
    times = problem.times[problem.times <= 0.5 * problem.times[-1]]
    solution = rivals.Solution(problem.samples[: len(times)], np.empty((0, 5)), 0, None, 0)
    case_scene = reference_run.scene_of(tree)
    truth = rivals.sampled(case_scene, times, solution)

    def distance(tolerance):
        path = simulate(case_scene.with_settings(tolerance=tolerance, method="explicit"), times=times)
        return float(np.max(reference_run.distances(tree, path, truth)))

    own_error = case["reference"]["error"]
    assert distance(case["reference"]["tolerance"]) < 2.0 * own_error
    rows = [row for row in case["ladder"] if row["method"] == "explicit" and row["error"] > 10.0 * own_error]
    ratios = [row["error"] / distance(row["tolerance"]) for row in rows]
    assert len(rows) >= 5
    assert all(0.9 < ratio < 3.0 for ratio in ratios), ratios  # ten samples miss the largest distance
    assert 0.9 < np.median(ratios) < 2.0


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
    source = json.loads(json.dumps(problems.all_problems()[0].grid))
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
    result = CliRunner().invoke(verbs, ["check", str(path), "--case", "first", "--out", str(out), "--json", "--rivals"])
    assert result.exit_code == 0, result.output
    stored = json.loads((out / "check.json").read_text(encoding="utf-8"))
    case = stored["cases"][0]
    assert {"case_id", "values", "horizon_revolutions", "reference", "yours", "order", "ladder", "stability"} <= {*case}
    assert {"method", "tolerance", "error", "peaks", "events_equal", "milliseconds"} <= {*case["ladder"][0]}
    assert {"scipy DOP853", "scipy LSODA"} <= {row["method"] for row in case["ladder"]}
    assert len(stored["advice"]) == 3
    assert (out / "check.html").read_text(encoding="utf-8").count("<svg") == 2
