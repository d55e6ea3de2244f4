"""Grids that designers asked about, run with the mechanics: what `answer.json` has to say of each."""

import json

import pytest
from mechanism_cases import changed
from right_grids import grid_of

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation

CLEARANCE, SPEED, JOINT = "joints.rod-slider.clearance", "drive.speed", "joints.rod-slider"
PEAK, IMPACTS = "rod_slider_force_peak", "rod_slider_impacts_per_rev"
CRANK = grid_of("a crank of answers")
SPEEDS = ["500 rpm", "1000 rpm", "1500 rpm", "2000 rpm"]
THREE = ["0.02 mm", "0.2 mm", "0.5 mm"]


def grid(changes=None, **sections):
    """Return the crank with changed values, path -> value, and with these sections."""
    return changed(CRANK, changes) | sections


@pytest.fixture
def answer_of(tmp_path, monkeypatch):
    """Return a function that runs a grid and gives its answer, read from the directory."""
    monkeypatch.chdir(tmp_path)
    count = iter(range(100))

    def run(source):
        directory = tmp_path / f"run{next(count)}"
        clearsweep.sweep(source, directory, executor="serial", show_progress=False)
        run.directory = directory
        return json.loads((directory / "answer.json").read_text(encoding="utf-8"))

    return run


def verdicts(answer, path=CLEARANCE):
    """Return value of a path -> verdict of its design."""
    return {design["values"][path]: design["verdict"] for design in answer["designs"]}


def effect(answer, figure, path):
    """Return the effect of a path on a figure."""
    return next(entry for entry in answer["effects"] if (entry["figure"], entry["path"]) == (figure, path))


def counts(answer):
    """Return how many judged cases meet, exceed, are undecided, and how many were added."""
    return tuple(answer["cases"][word] for word in ("met", "exceeded", "undecided", "added"))


@pytest.mark.parametrize("limits", [{IMPACTS: 0}, {IMPACTS: 0, PEAK: "20 kN"}])
def test_limit_of_zero_is_a_limit(answer_of, limits):
    answer = answer_of(grid(limits=limits, sweep={SPEED: SPEEDS, CLEARANCE: THREE}))
    assert counts(answer) == (4, 8, 0, 0)
    assert verdicts(answer) == {2e-5: "meets", 2e-4: "exceeds", 5e-4: "exceeds"}
    for design in answer["designs"][1:]:
        assert design["margin"] is None
        assert design["limit"] == IMPACTS
    assert {design["values"][CLEARANCE]: design["excess"] for design in answer["designs"]} == {
        2e-5: None,
        2e-4: 1.0,
        5e-4: 3.75,
    }


def test_check_of_laws_does_not_overrule_a_limit_of_zero(answer_of):
    answer = answer_of(grid({CLEARANCE: "0.3 mm"}, limits={IMPACTS: 0, PEAK: "20 kN"}, check_laws=True))
    assert counts(answer) == (0, 1, 0, 8)
    assert [(design["verdict"], design["excess"]) for design in answer["designs"]] == [("exceeds", 2.25)]


def test_refined_cases_make_no_design(answer_of):
    sweep = {CLEARANCE: ["0.02 mm", "0.1 mm", "0.2 mm"], SPEED: ["500 rpm", "1500 rpm"]}
    answer = answer_of(grid(limits={IMPACTS: 0, PEAK: "20 kN"}, sweep=sweep, refine={"along": "limits", "cases": 8}))
    assert answer["question"] == "refine"
    assert counts(answer) == (4, 2, 0, 8)
    assert verdicts(answer) == {2e-5: "meets", 1e-4: "meets", 2e-4: "exceeds"}
    assert answer["designs_total"] == 3


@pytest.mark.few("limits0")
@pytest.mark.parametrize("limits", [{IMPACTS: 0}, {IMPACTS: 0, PEAK: "20 kN"}])
def test_search_without_answer_says_all_cases_exceed(answer_of, limits):
    seek = {"largest": CLEARANCE, "between": ["0.3 mm", "0.5 mm"], "within": "0.05 mm", "meeting": "limits"}
    answer = answer_of(grid(limits=limits, sweep={SPEED: ["500 rpm", "1500 rpm"]}, seek=seek))
    assert answer["question"] == "seek"
    assert counts(answer) == (0, 0, 0, 10)
    assert answer["designs"] == []
    assert [row[f"seek.{CLEARANCE}"] for row in answer["search"]] == [None, None]
    assert not any("cannot be assessed" in sentence for sentence in answer["sentences"])


def test_search_for_no_impacts(answer_of):
    seek = {"largest": CLEARANCE, "between": ["0.02 mm", "0.5 mm"], "within": "0.02 mm", "meeting": "limits"}
    answer = answer_of(grid(limits={IMPACTS: 0}, sweep={SPEED: ["500 rpm", "1500 rpm"]}, seek=seek))
    assert [row[f"seek.{CLEARANCE}"] for row in answer["search"]] == pytest.approx([5e-5, 8e-5], rel=1e-3)


def test_share_of_a_sample_counts_the_limit_of_zero(answer_of):
    over = {
        CLEARANCE: {"uniform": ["0.02 mm", "0.5 mm"]},
        SPEED: {"uniform": ["500 rpm", "2000 rpm"]},
    }
    sample = {"method": "sobol", "n": 64, "over": over}
    answer = answer_of(grid(limits={IMPACTS: 0, PEAK: "20 kN"}, sample=sample))
    (design,) = answer["designs"]
    assert answer["question"] == "sample"
    assert set(answer["roles"].values()) == {"uncertainty"}
    assert (design["values"], design["verdict"], design["conditions"]) == ({}, "exceeds", 64)
    assert (design["met"], design["exceeded"]) == (12, 52)
    share = design["share"]
    assert (share["met"], share["exceeded"], share["undecided"]) == (12 / 64, 52 / 64, 0.0)
    assert 0.05 < share["low"] < share["met"] < share["high"] < 0.35


def test_best_case_has_no_impacts(answer_of):
    over = {CLEARANCE: ["0.01 mm", "0.3 mm"], "mechanism.slider.mass": ["0.1 kg", "0.3 kg"]}
    answer = answer_of(
        grid(
            {CLEARANCE: "0.02 mm"},
            limits={IMPACTS: 0},
            optimise={"over": over, "minimise": PEAK, "cases": 24},
        )
    )
    assert (answer["question"], answer["designs"]) == ("optimise", [])
    assert counts(answer)[3] >= 24
    (best,) = answer["search"]
    assert best["margin"] is None  # nothing but a limit of zero, which the case meets
    summary = clearsweep.open(answer_of.directory).summary.set_index("case_id")
    assert summary.loc[best["case_id"], IMPACTS] == 0.0
    assert best[PEAK] == summary.loc[summary[IMPACTS] == 0.0, PEAK].min()


def test_impacts_rise_from_zero(answer_of):
    answer = answer_of(grid(limits={IMPACTS: 1}, sweep={SPEED: SPEEDS, CLEARANCE: THREE}))
    reported = effect(answer, IMPACTS, CLEARANCE)
    assert (reported["verdict"], reported["from"], reported["to"], reported["pairs"]) == ("rises", 0.0, 3.0, 4)


def test_role_of_a_path_that_could_vary_is_accepted(answer_of):
    source = grid(limits={PEAK: "20 kN"}, sweep={SPEED: SPEEDS[:2]}, roles={CLEARANCE: "condition", SPEED: "choice"})
    assert answer_of(source)["roles"] == {SPEED: "choice"}


def test_variants_with_conditions_of_their_own_are_judged_as_they_stand():
    def role_of_speed(clearances, speeds, **sections):
        zipped = {CLEARANCE: [f"{each} um" for each in clearances], SPEED: [f"{each} rpm" for each in speeds]}
        return grids.load(grid(zip=zipped, **sections), simulation.catalogue()).roles[SPEED]

    assert role_of_speed([10, 20, 30], [600, 900, 900]) == "choice"
    assert role_of_speed([10, 20, 30], [600, 900, 900], roles={SPEED: "condition"}) == "condition"
    assert role_of_speed([10, 10, 20, 20], [600, 900, 600, 900]) == "condition"  # each design runs at both speeds
    assert role_of_speed([10, 10, 20], [600, 900, 600]) == "condition"  # one was not run: undecided
