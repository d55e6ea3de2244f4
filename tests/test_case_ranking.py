"""Which question a run answers first: the same on the page and on the command line."""

import numpy as np
import pytest
from fake_physics import grid
from fake_runs import Run
from test_seek import quiet

from clearsweep.answers.ranking import Candidate, CaseRanking, ranking_of
from clearsweep.answers.verdict import limits_of
from clearsweep.contracts.layout import Column
from clearsweep.report.sections.answer import summary_sections, verdict_sections
from clearsweep.report.study import case_ranking_of, prepare, worst_case
from clearsweep.sweeping import summary

PEAK = "rod_slider_force_peak"
FILM = {"film_thickness_min": "m", "dry_load_share": "1", "film_loss": "W"}


def layout(*names, life=""):
    made = Run().layout
    columns = tuple(Column(f"rod_slider_{name}", "1", "") for name in ("force_peak", *names))
    return made._replace(columns=columns, life=life)


SOUGHT = {"largest": "mechanism.slider.mass"}
LIMITS = limits_of({PEAK: 1.0})


@pytest.mark.parametrize(
    ("given", "limits", "asked", "leads"),
    [
        (layout("life_hours", *FILM, life="rod_slider"), LIMITS, {"seek": SOUGHT}, "life"),
        (layout(*FILM), LIMITS, {"seek": SOUGHT}, "seek"),
        (layout(*FILM), LIMITS, {"optimise": {"minimise": [PEAK]}}, "optimise"),
        (layout(*FILM), LIMITS, {"identify": {"over": {}, "cases": 400}}, "identify"),
        (layout(*FILM), LIMITS, {}, "limits"),
        (layout(*FILM), (), {}, "film"),
        (layout(), (), {}, "force"),
    ],
)
def test_the_first_question_that_a_grid_asks_leads(given, limits, asked, leads):
    assert ranking_of(given, limits, asked).question == leads


def test_a_film_study_leads_with_its_films_and_its_thinnest_case():
    lead = ranking_of(layout(*FILM), ())
    assert lead.headings == ("least film", "dry load share", "loss")
    columns = {name: np.array([3.0, 1.0, np.nan]) for name in lead.columns}
    values, _ = lead.worst_values(columns)
    assert int(np.argmax(lead.severity(values, columns))) == 1
    assert lead.severity(values, columns)[2] == -np.inf


def test_the_best_case_within_the_limits_leads_an_optimisation():
    lead = ranking_of(layout(), LIMITS, {"optimise": {"minimise": [PEAK]}})
    columns = {PEAK: np.array([1.0, 2.0, 3.0]), "margin": np.array([-0.5, 0.5, 0.1])}
    columns |= {"limits_exceeded": np.array([PEAK, "", ""], object), "limits_undecided": np.array([""] * 3, object)}
    values, _ = lead.worst_values(columns)
    assert int(np.argmax(lead.severity(values, columns))) == 1
    lead = ranking_of(layout(), (), {"optimise": {"maximise": [PEAK]}})
    values, _ = lead.worst_values(columns)
    assert int(np.argmax(lead.severity(values, columns))) == 2


def test_a_case_beyond_a_limit_of_zero_is_the_worst_by_its_excess():
    lead = ranking_of(layout(), limits_of({PEAK: 0.0}))
    columns = {PEAK: np.array([2.25, 3.75, 1.0, 0.0]), "margin": np.array([np.nan, np.nan, -0.5, np.nan])}
    exceeded = np.array([PEAK, PEAK, PEAK, ""], object)
    columns |= {"limits_exceeded": exceeded, "limits_undecided": np.array(["", "", "", PEAK])}
    values, _ = lead.worst_values(columns)
    assert np.argsort(lead.severity(values, columns)).tolist() == [3, 2, 0, 1]


def test_of_several_joints_the_worse_one_ranks_a_case_and_null_never_does():
    candidates = tuple(Candidate(name, (name,)) for name in ("a", "b"))
    lead = CaseRanking("force", "", ("peak",), False, candidates)
    values, which = lead.worst_values({"a": np.array([1.0, np.nan, np.nan]), "b": np.array([2.0, -3.0, np.nan])})
    assert values.tolist()[:2] == [2.0, -3.0]
    assert which.tolist()[:2] == [1, 1]
    assert np.isnan(values[2])


@pytest.mark.parametrize("limits", [None, {PEAK: "0.1015 N"}])
def test_page_and_closing_lines_name_the_same_worst_case(tmp_path, limits):
    result = quiet(grid(3) | ({"limits": limits} if limits else {}), tmp_path / "run")
    facts = summary.of_run(result)
    prepared = prepare(result.open())
    case_id, _ = worst_case(prepared)
    assert facts["worst"][0]["case_id"] == case_id
    assert facts["question"] == case_ranking_of(prepared).question == ("limits" if limits else "force")
    shown = summary_sections(prepared)[0].blocks[0].cards
    assert len(shown) <= 8
    said = summary.plain(" ".join(verdict_sections(prepared)[0].blocks[0].texts))
    text = summary.run_text(facts)
    for sentence in facts["answer"]["sentences"]:
        assert sentence in text
        assert sentence in said
    if limits:
        margins = [entry["figures"][0]["value"] for entry in facts["worst"]]
        assert margins == sorted(margins)
