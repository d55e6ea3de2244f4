"""The largest value that meets the limits: found among ordinary cases, the same after every interruption."""

import dataclasses
import json
import math
import re

import numpy as np
import pyarrow.parquet as pq
import pytest
from fake_physics import FAILS, GOOD, Fake, grid, sweep, trajectory
from fake_runs import TEXT as GRID_TEXT
from fake_runs import load as grid_load
from mechanism_cases import slider_crank
from test_sweep import parts, program, same_results, wait_for

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation
from clearsweep.answers.ranking import ranking_of
from clearsweep.answers.verdict import Limit
from clearsweep.language.errors import InputError
from clearsweep.report.axis import axes_of
from clearsweep.report.blocks.table import Quantity, Table
from clearsweep.report.sections import searches as page
from clearsweep.report.sections.searches import seek_sections
from clearsweep.report.study import prepare
from clearsweep.searches.refine import RefineFound
from clearsweep.searches.seeking import border_of_all, loosened_limits, most_cases
from clearsweep.sweeping.estimate import estimate
from clearsweep.sweeping.summary import of_run, run_text

MASS, GRAVITY = "mechanism.slider.mass", "mechanism.gravity"
PEAK = 1  # rod_slider_force_peak is so many times the mass in kg, which tests rely upon


def quiet(source, out, **options):
    return sweep(source, out, executor="serial", show_progress=False, **options)


def searching(limit=0.3137, gravities=(GOOD,), **changes):
    """Return a grid that seeks the largest mass whose force peak stays below a limit."""
    seek = {"largest": MASS, "between": ["0.1 kg", "0.9 kg"], "within": "1 g"} | changes
    return grid(1, gravities, orbits="none") | {
        "sweep": {GRAVITY: list(gravities)},
        "limits": {"rod_slider_force_peak": limit},
        "seek": {key: value for key, value in seek.items() if value is not None},
    }


def answers(out):
    return pq.read_table(out / "seek.parquet").to_pylist()


def test_the_made_up_force_is_the_mass():
    assert next(name for name in trajectory(loaded(grid(1)).case(0)).summary) == "rod_slider_force_peak"
    assert trajectory(loaded(grid(1)).case(0)).summary["rod_slider_force_peak"] == PEAK * 0.1


def loaded(source):
    return grids.load(source, Fake.catalogue())


def test_the_border_is_found_to_the_width_requested_and_enclosed(tmp_path):
    result = quiet(searching(gravities=(GOOD, 1e-3)), tmp_path / "run")
    rows = answers(tmp_path / "run")
    assert [row[GRAVITY] for row in rows] == [GOOD, 1e-3]
    for row in rows:
        assert row["seek_low"] == row[f"seek.{MASS}"] <= 0.3137 < row["seek_high"] <= row["seek_low"] + 1e-3
        assert row["limiting"] == "rod_slider_force_peak"
        assert row["probes"] <= 5 + 8 + 4
    assert result.ran == sum(row["probes"] for row in rows)
    run = clearsweep.open(tmp_path / "run")
    assert len(run.summary) == result.ran
    assert run.summary[MASS].between(0.1, 0.9).all()
    assert run.grid["seek"]["largest"] == MASS
    text = run_text(of_run(result))
    assert "largest slider mass within the limits" in text
    assert "limited by force peak" in text


def test_probes_are_stored_cases_and_run_once(tmp_path):
    quiet(searching(), tmp_path / "run")
    first = answers(tmp_path / "run")
    again = quiet(searching(), tmp_path / "run")
    assert again.ran == 0
    assert answers(tmp_path / "run") == first
    finer = quiet(searching(within="0.1 g"), tmp_path / "run")
    assert 0 < finer.ran < finer.cases
    assert first[0]["seek_low"] <= answers(tmp_path / "run")[0]["seek_low"] <= 0.3137


def test_the_smallest_value_is_sought_from_the_other_end(tmp_path):
    source = searching(largest=None, smallest=MASS) | {"limits": {"rod_slider_force_peak": {"at_least": 0.3137}}}
    quiet(source, tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert row["seek_low"] < 0.3137 <= row["seek_high"] == row[f"seek.{MASS}"] <= row["seek_low"] + 1e-3


def test_for_all_the_worst_case_decides(tmp_path):
    gravities = (GOOD, FAILS)
    quiet(searching(gravities=gravities) | {"seek": searching(**{"for": "all"})["seek"]}, tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert (row[f"seek.{MASS}"], row["limiting"], row[GRAVITY]) == (None, "step-budget", FAILS)
    quiet(searching(gravities=(GOOD, 1e-3)) | {"seek": searching(**{"for": "all"})["seek"]}, tmp_path / "other")
    (row,) = answers(tmp_path / "other")
    assert row["seek_low"] <= 0.3137 < row["seek_high"]


@pytest.mark.parametrize(("limit", "value", "limiting"), [(1.0, 0.9, None), (0.05, None, "rod_slider_force_peak")])
def test_a_border_outside_the_range_is_reported(tmp_path, limit, value, limiting):
    quiet(searching(limit), tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert (row[f"seek.{MASS}"], row["seek_low"], row["seek_high"], row["limiting"]) == (value, value, value, limiting)


@pytest.mark.parametrize("text", ["rod_slider_force_peak / (0 * steps)", "0 * rod_slider_force_peak / (0 * steps)"])
def test_where_the_figure_is_infinite_or_undefined_no_value_is_safe(tmp_path, text):
    more = {"figures": {"ratio": text}, "limits": {"ratio": "5 N", "rod_slider_force_peak": 0.7}}
    result = quiet(searching() | more, tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert (row[f"seek.{MASS}"], row["limiting"]) == (None, "ratio")
    facts = of_run(result)
    assert facts["limits"]["unknown"] + facts["limits"]["exceeding"] == result.cases


def test_what_was_sought_goes_when_the_grid_seeks_nothing_any_more(tmp_path):
    quiet(searching(), tmp_path / "run")
    plain = quiet(grid(3, orbits="none"), tmp_path / "run")
    assert plain.others > 10
    assert not (tmp_path / "run" / "seek.parquet").exists()


class Noisy(Fake):
    """Made-up mechanics whose force, within 5 g of the border, is above or below the limit as chance has it."""

    @staticmethod
    def solve(case):
        """Return a made-up trajectory."""
        result = trajectory(case)
        mass = case.mechanism.values["slider.mass"]
        if abs(mass - 0.3137) < 0.005:
            result.summary["rod_slider_force_peak"] = np.random.default_rng(int(1e9 * mass)).choice([0.1, 0.9])
        return result


def test_where_limits_are_met_by_chance_the_answer_stays_on_the_safe_side(tmp_path):
    quiet(searching(), tmp_path / "run", simulator=Noisy)
    (row,) = answers(tmp_path / "run")
    assert row["seek_low"] == row[f"seek.{MASS}"] < row["seek_high"]
    assert row["seek_low"] > 0.3137 - 0.02
    assert row["seek_high"] < 0.3137 + 0.02
    summary = clearsweep.open(tmp_path / "run").summary
    safe = summary[summary[MASS].between(row["seek_low"] - 2.1e-3, row["seek_low"] + 1e-9)]
    assert (safe["limits_exceeded"] == "").all()
    assert len(safe) >= 3  # itself and two neighbours


@pytest.mark.few("6")
@pytest.mark.parametrize("after", [1, 6, 9])
def test_killed_at_any_round_it_continues_to_the_same_answers(tmp_path, after):
    source = searching(gravities=(GOOD + 0.02,))
    quiet(source, tmp_path / "whole")
    out = tmp_path / "run"
    process = program(out, source, jobs=1, show_progress=False)
    wait_for(lambda: parts(out) >= after or process.poll() is not None)
    process.kill()
    process.communicate()
    assert parts(out) >= after
    assert not (out / "seek.parquet").exists()
    again = quiet(source, out)
    assert 0 < again.ran < again.cases
    assert (out / "seek.parquet").read_bytes() == (tmp_path / "whole" / "seek.parquet").read_bytes()
    assert same_results(out, tmp_path / "whole")


def test_shards_of_a_search_are_refused(tmp_path):
    with pytest.raises(InputError, match="depend on one another"):
        quiet(searching(), tmp_path / "run", shard="1/2")


PLAY = "joints.rod-slider.clearance"


def test_a_defined_quantity_is_sought(tmp_path):
    source = searching(largest="define.heavy") | {"define": {"heavy": "0.2 kg"}}
    source["mechanism"] = source["mechanism"] | {"slider": {"mass": "= heavy"}}
    quiet(source, tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert row["seek.define.heavy"] <= 0.3137 < row["seek_high"]
    assert clearsweep.open(tmp_path / "run").grid["mechanism"]["slider"]["mass"] == "= heavy"


def test_paths_in_step_have_one_value(tmp_path):
    rod = "mechanism.rod.mass"
    result = quiet(searching(largest=[MASS, rod]), tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert row[f"seek.{MASS}"] == row[f"seek.{rod}"] <= 0.3137 < row["seek_high"]
    summary = clearsweep.open(tmp_path / "run").summary
    assert (summary[MASS] == summary[rod]).all()
    assert len(summary) == result.ran == row["probes"]
    again = quiet(searching(largest=[MASS, rod]), tmp_path / "run")
    assert again.ran == 0
    assert "within the limits" in run_text(of_run(again))


def test_none_in_the_range_says_how_near_each_case_comes_and_what_would_pass(tmp_path):
    result = quiet(searching(limit=0.05, gravities=(GOOD, 1e-3)), tmp_path / "run")
    assert [row["limiting"] for row in answers(tmp_path / "run")] == ["rod_slider_force_peak"] * 2
    facts = of_run(result)
    for answer in facts["seek"]["answers"]:
        (best,) = answer["best"]
        assert best["value"] == 0.1
        assert best["margin"] == pytest.approx(-1.0)
        assert best["needed"] == {"rod_slider_force_peak": "at most 0.1\u00a0N"}
    (nearest,) = facts["answer"]["nearest"]
    assert (nearest["margin"], nearest["values"][MASS], nearest["failed"]) == (pytest.approx(-1.0), 0.1, 0)
    assert [row[f"seek.{MASS}"] for row in facts["answer"]["search"]] == [None, None]


def test_none_in_the_range_says_which_other_keys_move_the_margin(tmp_path):
    source = searching(limit=0.05, largest="mechanism.rod.mass")  # the peak is the mass of the slider
    result = quiet(source, tmp_path / "run")
    first = result.search_result.effects[0]
    assert (first.path, first.value) == (MASS, 0.14)
    assert first.margin == pytest.approx(-1.8)
    assert first.lower == pytest.approx(-1.52)
    assert first.upper == pytest.approx(-2.08)
    assert all(effect.size == 0.0 for effect in result.search_result.effects[1:])
    assert not any(
        effect.path.endswith(".exponent") for effect in result.search_result.effects
    )  # of which units depend
    again = quiet(source, tmp_path / "run")
    assert again.ran == 0
    assert again.search_result.effects == result.search_result.effects


def test_cases_beyond_the_search_are_announced_estimated_and_optional(tmp_path, capsys):
    source = searching(limit=0.05, largest="mechanism.rod.mass")
    slow = searching(limit=0.05, gravities=(0.1,), largest="mechanism.rod.mass")  # s a case
    forecasts = [estimate(slow, jobs=1, no_effects=no, simulator=Fake) for no in (False, True)]
    (line,) = [text for text in forecasts[0].warnings if "--no-effects" in text]
    most = int(re.search(r"up to (\d+) cases", line)[1])
    assert forecasts[0].seconds > forecasts[1].seconds + 0.05 * most
    assert not [text for text in forecasts[1].warnings if "--no-effects" in text]
    without = quiet(source, tmp_path / "without", no_effects=True)
    assert without.search_result.effects == ()
    assert not [*(tmp_path / "without").glob("sensitivity-*")]
    capsys.readouterr()
    with_effects = sweep(source, tmp_path / "with", executor="serial").search_result
    (folder,) = (tmp_path / "with").glob("sensitivity-*")
    count = len(clearsweep.open(folder).summary)
    assert f"{count} more cases show which other keys help" in capsys.readouterr().err
    assert count <= most
    said = json.loads((tmp_path / "with" / "answer.json").read_bytes())["sentences"]
    assert any(sentence.startswith("The limits that would be met: ") for sentence in said)
    assert {loaded(source).role(effect.path) for effect in with_effects.effects} == {"choice"}


def test_a_search_over_lives_says_what_it_seeks():
    joint = "joints.rod-slider"
    changes = {f"{joint}.wear": {"law": "archard", "coefficient": "2e-14 m^2/N"}, f"{joint}.length": "20 mm"}
    source = slider_crank("rod-slider", changes=changes) | {
        "life": {"limit": "20 um", "of": "wear_depth_max", "joint": "rod-slider"},
        "uncertain": {f"{joint}.wear.coefficient": {"factor": 3}},
        "limits": {"rod_slider_life_hours": {"at_least": "30 h"}},
        "seek": {"largest": f"{joint}.clearance", "between": ["20 um", "100 um"], "within": "20 um"},
    }
    seeking = grids.load(source, simulation.catalogue())
    assert ranking_of(seeking.layout, seeking.verdict.limits, seeking.resolved()).question == "seek"
    assert most_cases(seeking) > 20  # of the numbers of the machine; the factor above is none


def test_where_all_cases_count_they_are_compared_at_one_value(tmp_path):
    limits = {"limits": {"rod_slider_force_peak": 0.05, "weight": {"at_least": 10.0}}}
    figures = {"figures": {"weight": "rod_slider_force_peak * 3.00004 + '0 N'"}}
    source = searching(gravities=(GOOD, 1e-3), **{"for": "all"}) | limits | figures
    facts = of_run(quiet(source, tmp_path / "run"))
    best = [each for answer in facts["seek"]["answers"] for each in answer["best"]]
    assert [each["point"] for each in best] == [{GRAVITY: GOOD}, {GRAVITY: 1e-3}]
    assert len({each["value"] for each in best}) == 1
    loosened = {"rod_slider_force_peak": 0.1, "weight": {"at_least": 0.3}}
    assert facts["seek"]["needed"] == {"rod_slider_force_peak": "at most 0.1\u00a0N", "weight": "at least 0.3\u00a0N"}
    quiet(source | {"limits": loosened}, tmp_path / "run")
    (row,) = answers(tmp_path / "run")
    assert row[f"seek.{MASS}"] == 0.1


def test_the_report_says_how_near_the_cases_come_and_which_keys_would_help(tmp_path):
    quiet(searching(limit=0.05, largest="mechanism.rod.mass"), tmp_path / "run")
    (section,) = seek_sections(prepare(clearsweep.open(tmp_path / "run")))
    nearest, keys = [block for block in section.blocks if isinstance(block, Table)][1:]
    (row,) = nearest.rows
    assert [each.text if isinstance(each, Quantity) else each for each in row] == [
        0.1,
        "2.8 times the limit",
        "force peak",
        "rod_slider_force_peak at most 0.14\u00a0N",
    ]
    assert [(row[0], row[2].text, row[3].text) for row in keys.rows] == [
        (MASS, "2.5 times the limit", "3.1 times the limit")
    ]
    quiet(searching(limit=1.0, largest="mechanism.rod.mass"), tmp_path / "run")
    (section,) = seek_sections(prepare(clearsweep.open(tmp_path / "run")))
    assert len([block for block in section.blocks if isinstance(block, Table)]) == 1


@pytest.mark.parametrize(
    ("limit", "margin", "words"),
    [
        (Limit("x", "at_most", 0.0), -2.5, "at most 2.5"),
        (Limit("x", "at_most", 5.0), -0.123456, "at most 5.618"),
        (Limit("x", "at_least", 5.0), -0.123456, "at least 4.382"),
        (Limit("x", "at_most", -5.0), -0.5, "at most -2.5"),
        (Limit("x", "at_most", 2.0, "y"), -1.0, "at most 4 times y"),
    ],
)
def test_a_limit_that_would_pass_is_rounded_so_that_it_does(limit, margin, words):
    assert loosened_limits([limit], {}, [{"x": margin}]) == {"x": words.replace("-", "\u2212")}
    assert (
        loosened_limits([limit, dataclasses.replace(limit, kind="at_least")], {}, [{"x": margin}]) == {}
    )  # which of both is not known


FITTED = (
    GRID_TEXT
    + """\
limits: {rod_slider_force_peak: 5 kN}
seek: {largest: joints.rod-slider.clearance, among: {fits: [H8/e8, H7/g6, H7/f7]}}
"""
)


def test_fits_are_tried_completely_at_their_largest_clearances(at):
    grid = at(FITTED)
    assert [fit.name for fit in grid.search.fits] == ["H7/g6", "H7/f7", "H8/e8"]
    assert grid.axes[PLAY] == tuple(fit.high for fit in grid.search.fits)
    assert grid.fits == {}  # they name means
    assert PLAY not in grid.written_units  # they are shown in units that suit them
    for among, scattered in (({"fits": []}, False), (None, True)):  # only fits are all tried at all other values
        record = grid.resolved() | {"seek": {"among": among}}
        assert axes_of(record, {PLAY: grid.axes[PLAY]}, {}, 1)[-1].is_scattered == scattered
    assert grid.labels[PLAY] == {fit.name: fit.high for fit in grid.search.fits}
    assert grid.axes[PLAY][1] == pytest.approx(31e-6)  # of 20 mm: the contract's 10 to 31 um
    again = grid_load(grid.resolved())
    assert again.search == grid.search
    assert [again.case_id(k) for k in range(3)] == [grid.case_id(k) for k in range(3)]


@pytest.mark.parametrize(
    ("good", "border"),
    [((1, 1, 0), (1, 2)), ((1, 1, 1), (2, None)), ((0, 0, 0), (None, 0)), ((1, 0, 1), (0, 1)), ((0, 1, 0), (1, 2))],
)
def test_the_border_among_fits(good, border):
    assert border_of_all(dict(enumerate(map(bool, good))), 2) == border


def test_fits_that_pass_beyond_the_border_are_reported_on_the_page():
    answers = page._Answers(None, (), True, [{"seek_beyond": "H8/e8"}, {"seek_beyond": None}, {}])
    assert page.not_monotone_sentences(answers) == [
        "The margin is not monotone: beyond the border, H8/e8 also meet the limits."
    ]


# ---------------------------------------------------------------------------------------------- refined borders


SLIDER, SPEED = "mechanism.slider.mass", "drive.speed"
MASSES, SPEEDS = [0.1, 0.3, 0.5, 0.7, 0.9], [100.0, 300.0, 500.0, 700.0]


class Arc(Fake):
    """Made-up mechanics whose force is the distance from the origin, of mass over 1 kg and speed over 1000 rad/s."""

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory."""
        result = trajectory(case)
        result.summary["rod_slider_force_peak"] = distance(case.mechanism.values["slider.mass"], case.drive.speed)
        return result


RADIUS = 0.6137  # N, of the border


def distance(mass, speed):
    return np.hypot(mass, speed / 1000.0)


def refining_grid(cases=60, **changes):
    """Return a grid whose border is a quarter of a circle."""
    source = grid(1, orbits="none") | {
        "sweep": {SLIDER: MASSES, SPEED: SPEEDS},
        "limits": {"rod_slider_force_peak": RADIUS},
        "refine": {"along": "limits", "cases": cases},
    }
    return {key: value for key, value in (source | changes).items() if value is not None}


def run_refined(source, out, simulator=Arc, **options):
    return sweep(source, out, simulator=simulator, executor="serial", show_progress=False, **options)


def off_border(summary):
    """Return how far cases are from the border, in steps of the grid, those between the grid's own first."""
    grid_distances = summary[SLIDER].isin(MASSES) & summary[SPEED].isin(SPEEDS)
    far = (distance(summary[SLIDER], summary[SPEED]) - RADIUS).abs() / 0.2
    return far[~grid_distances].to_numpy(), far[grid_distances].to_numpy()


def test_cases_are_added_along_the_border_and_nowhere_else(tmp_path):
    result = run_refined(refining_grid(), tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    added_distances, grid_distances = off_border(summary)
    assert (len(grid_distances), result.cases) == (20, len(summary))
    assert 55 <= len(added_distances) == result.search_result.added <= 60
    assert added_distances.max() < 1.0  # a box that is crossed has no corner further away than its diagonal
    assert np.median(added_distances) < 0.25  # of a step of the grid
    assert np.median(grid_distances) > 1.0
    angles = np.linspace(np.arctan2(0.1, 0.6), np.arctan2(0.6, 0.11), 50)
    around = RADIUS * np.array([np.cos(angles), np.sin(angles)])
    nearest = [np.min(np.hypot(summary[SLIDER] - x, summary[SPEED] / 1000.0 - y)) for x, y in around.T]
    assert max(nearest) < 0.07  # a third of a step of the grid; without them it is over half of one


def test_what_is_known_of_the_border_does_not_depend_on_interruptions(tmp_path):
    run_refined(refining_grid(), tmp_path / "whole")
    run_refined(refining_grid(cases=24), tmp_path / "run")
    more = run_refined(refining_grid(), tmp_path / "run")
    assert 60 - 24 <= more.ran < 60
    assert same_results(tmp_path / "run", tmp_path / "whole")
    lost = sorted((tmp_path / "run" / "parts").iterdir())[:2]
    for path in lost:
        path.unlink()
    assert 0 < run_refined(refining_grid(), tmp_path / "run").ran < 40
    assert same_results(tmp_path / "run", tmp_path / "whole")
    assert run_refined(refining_grid(), tmp_path / "run").ran == 0


def test_a_border_across_one_axis_is_enclosed_to_a_thousandth_of_a_step(tmp_path):
    source = refining_grid(cases=500, sweep={SLIDER: [0.1, 0.2, 0.4, 0.8], SPEED: [1e-3]})
    result = run_refined(source, tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    good = summary[summary["limits_exceeded"] == ""][SLIDER].max()
    bad = summary[summary["limits_exceeded"] != ""][SLIDER].min()
    assert good <= RADIUS < bad
    assert bad / good == pytest.approx(2.0 ** (1.0 / 1024), rel=1e-9)  # halved by ratios, as the axis is
    assert result.search_result == RefineFound(500, 10, 1, whole=True)
    assert of_run(result)["answer"]["cases"]["added"] == 10


def test_steps_that_are_equal_are_halved_by_differences(tmp_path):
    run_refined(refining_grid(cases=1, sweep={SLIDER: [0.1, 0.5, 0.9], SPEED: [1e-3]}), tmp_path / "run")
    assert sorted(clearsweep.open(tmp_path / "run").summary[SLIDER]) == [0.1, 0.5, 0.7, 0.9]


@pytest.mark.parametrize("limit", [10.0, 0.01])
def test_where_all_cases_agree_none_is_added(tmp_path, limit):
    result = run_refined(refining_grid(limits={"rod_slider_force_peak": limit}), tmp_path / "run")
    assert (result.cases, result.search_result.added) == (20, 0)
    assert of_run(result)["answer"]["cases"]["added"] == 0


def test_each_law_has_its_own_border(tmp_path):
    path = "joints.rod-slider.bearing_radius"
    run_refined(refining_grid(zip={path: [0.01, 0.02], "joints.rod-slider.length": [0.02, 0.03]}), tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    assert sorted(summary[path].unique()) == [0.01, 0.02]  # what goes in step stays as it is
    added_distances = summary[~(summary[SLIDER].isin(MASSES) & summary[SPEED].isin(SPEEDS))]
    assert abs((added_distances[path] == 0.01).mean() - 0.5) < 0.2


def test_a_refined_run_is_written_to_run_json_so_that_it_loads_again(tmp_path):
    run_refined(refining_grid(), tmp_path / "run")
    run = clearsweep.open(tmp_path / "run")
    record = {key: run.grid[key] for key in run.grid["keys"]}
    again = grids.load(record, Fake.catalogue())
    assert sorted(map(again.case_id, range(len(again)))) == run.summary["case_id"].tolist()
    assert sorted(f"{number:016x}" for number in again.identities()) == run.summary["case_id"].tolist()
    assert run_refined(record, tmp_path / "run").ran == 0


def test_shards_of_what_is_refined_are_refused_with_a_way_out(tmp_path):
    with pytest.raises(InputError, match="run the shards without `refine` and merge them"):
        run_refined(refining_grid(), tmp_path / "run", shard="1/2")


def test_a_case_that_fails_is_beyond_the_border(tmp_path):
    class Failing(Arc):
        @staticmethod
        def solve(case, log=None):
            result = Arc.solve(case)
            if result.summary["rod_slider_force_peak"] > RADIUS:
                return type(result)("step-budget", "made to fail", {})
            return result

    run_refined(refining_grid(limits={"rod_slider_force_peak": 10.0}), tmp_path / "run", simulator=Failing)
    added_distances, _ = off_border(clearsweep.open(tmp_path / "run").summary)
    assert len(added_distances) >= 55
    assert added_distances.max() < 1.0


def test_the_made_up_border_is_where_it_is_said_to_be():
    case = grids.load(refining_grid(), Fake.catalogue()).case(0)
    assert Arc.solve(case).summary["rod_slider_force_peak"] == math.hypot(0.1, 0.1)
    assert case.mechanism.values["gravity"] == GOOD
