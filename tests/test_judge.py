"""What the core of answers says of small tables of cases, judged by hand."""

import math

import numpy as np
import pytest
from fake_physics import Fake, grid, sweep, trajectory
from fake_runs import Run
from judged_cases import (
    CLEARANCE,
    FORCE,
    IDEAL,
    IMPACTS,
    OTHER,
    ROLES,
    SPEED,
    UNITS,
    answer_of,
    core_of,
    record_of,
    table_of,
)
from test_seek import quiet

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation, store
from clearsweep.answers.judge import sign_test
from clearsweep.answers.ranking import Candidate, CaseRanking, ranking_of
from clearsweep.answers.verdict import limits_of
from clearsweep.contracts.layout import Column
from clearsweep.language.errors import InputError
from clearsweep.report.sections.answer import summary_sections, verdict_sections
from clearsweep.report.sections.laws import law_check_sections
from clearsweep.report.study import case_ranking_of, prepare, worst_case
from clearsweep.sweeping import summary
from clearsweep.sweeping.summary import of_run

NAMES = {CLEARANCE: 0, SPEED: 1, FORCE: 2}
LAW, TOLERANCE = "joints.pin.contact.law", "simulate.tolerance"


def verdicts(answer):
    """Return clearance -> verdict of every design."""
    return {design["values"].get(CLEARANCE): design["verdict"] for design in answer["designs"]}


def effect(answer, path, figure=FORCE):
    return next(entry for entry in answer["effects"] if (entry["path"], entry["figure"]) == (path, figure))


def effect_of(rows, path=CLEARANCE, limits=None):
    return effect(answer_of(record_of(limits or {FORCE: 1e9}), table_of(NAMES, rows)), path)


def test_a_design_exceeds_if_one_condition_does_and_margins_only_order():
    rows = [(1, 1, 2.0), (1, 2, 12.0), (2, 1, 2.0), (2, 2, 8.0), (3, 1, 1.0), (3, 2, 1.0)]
    answer = answer_of(record_of({FORCE: 10.0}), table_of(NAMES, rows))
    assert answer["cases"] == {"met": 5, "exceeded": 1, "undecided": 0, "added": 0}
    assert [design["values"][CLEARANCE] for design in answer["designs"]] == [3.0, 2.0, 1.0]
    assert verdicts(answer) == {3.0: "meets", 2.0: "meets", 1.0: "exceeds"}
    assert [design["margin"] for design in answer["designs"]] == pytest.approx([0.9, 0.2, -0.2])
    assert [design["worst"][-1] for design in answer["designs"]] == ["5", "3", "1"]  # of equal ones the last


def test_a_value_equal_to_its_bound_meets_it():
    for limits in ({FORCE: 10.0}, {FORCE: {"at_least": 10.0}}):
        assert verdicts(answer_of(record_of(limits), table_of(NAMES, [(1, 1, 10.0)]))) == {None: "meets"}


def test_a_bound_of_zero_exceeded_has_an_excess_and_no_margin():
    rows = [(1, 1, 0.0, 5.0), (1, 2, 0.0, 6.0), (2, 1, 3.0, 5.0), (2, 2, 1.0, 5.0)]
    table = table_of({CLEARANCE: 0, SPEED: 1, IMPACTS: 2, FORCE: 3}, rows)
    met, exceeding = answer_of(record_of({IMPACTS: 0.0, FORCE: 10.0}), table)["designs"]
    assert (met["verdict"], met["margin"], met["excess"], met["limit"]) == ("meets", pytest.approx(0.4), None, FORCE)
    assert (exceeding["verdict"], exceeding["margin"]) == ("exceeds", None)
    assert (exceeding["excess"], exceeding["limit"], exceeding["worst"][-1]) == (3.0, IMPACTS, "2")


def test_a_multiple_of_zero_is_a_bound_of_zero():
    rows = [(1, 1, 0.5, 0.0), (2, 1, 0.0, 0.0)]
    table = table_of({CLEARANCE: 0, SPEED: 1, FORCE: 2, IDEAL: 3}, rows)
    answer = answer_of(record_of({FORCE: {"at_most": 2.0, "times": IDEAL}}), table)
    assert verdicts(answer) == {2.0: "meets", 1.0: "exceeds"}


def test_a_failed_condition_leaves_a_design_undecided_and_is_named():
    rows = [(1, 1, 2.0), (1, 2, None), (2, 1, 20.0), (2, 2, None)]
    answer = answer_of(record_of({FORCE: 10.0}), table_of(NAMES, rows))
    assert verdicts(answer) == {1.0: "undecided", 2.0: "exceeds"}
    undecided = answer["designs"][0]
    assert (undecided["conditions"], undecided["met"], undecided["undecided"]) == (2, 1, 1)
    assert undecided["missing"] == [{"values": {SPEED: pytest.approx(2 * math.pi / 30)}, "why": "time-limit"}]
    assert (undecided["margin"], undecided["worst"]) == (None, f"{1:016x}")


def test_a_condition_that_was_not_run_is_missing():
    rows = [(1, 1, 2.0), (1, 2, 3.0), (2, 1, 1.0)]
    answer = answer_of(record_of({FORCE: 10.0}), table_of(NAMES, rows))
    assert verdicts(answer) == {1.0: "meets", 2.0: "undecided"}
    hole = answer["designs"][1]
    assert [entry["why"] for entry in hole["missing"]] == ["not run"]
    assert (hole["missing_total"], hole["undecided"], hole["worst"]) == (1, 0, None)


def test_a_null_figure_is_named_unless_another_limit_is_exceeded():
    names = NAMES | {IMPACTS: 3}
    rows = [(1, 1, 2.0, None), (2, 1, 20.0, None)]
    answer = answer_of(record_of({FORCE: 10.0, IMPACTS: 1.0}), table_of(names, rows))
    assert verdicts(answer) == {1.0: "undecided", 2.0: "exceeds"}
    assert answer["designs"][0]["missing"] == [{"values": {}, "why": f"{IMPACTS} is null"}]
    assert answer["designs"][1]["margin"] == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("null", "kind", "verdict"),
    [
        ("", "at_most", "undecided"),
        ("nothing", "at_most", "meets"),
        ("nothing", "at_least", "meets"),
        ("endless", "at_most", "exceeds"),
        ("endless", "at_least", "meets"),
    ],
)
def test_a_null_is_judged_by_its_meaning(null, kind, verdict):
    record = record_of({FORCE: {kind: 5.0}}, nulls={FORCE: null})
    table = table_of(NAMES | {IMPACTS: 3}, [(1, 1, None, 1.0)])
    assert verdicts(answer_of(record, table)) == {None: verdict}


def test_a_times_that_is_null_is_named():
    table = table_of(NAMES | {IDEAL: 3}, [(1, 1, 5.0, None)])
    (design,) = answer_of(record_of({FORCE: {"at_most": 2.0, "times": IDEAL}}), table)["designs"]
    assert design["missing"] == [{"values": {}, "why": f"{IDEAL} is null"}]


def test_the_worst_over_the_laws_counts():
    roles = {CLEARANCE: "choice", LAW: "model"}
    rows = [(1, "flores", 2.0), (1, "hertz", 12.0), (2, "flores", 1.0), (2, "hertz", 2.0)]
    table = table_of({CLEARANCE: 0, LAW: 1, FORCE: 2}, rows)
    answer = answer_of(record_of({FORCE: 10.0}, roles, {CLEARANCE: "m", LAW: ""}), table)
    assert verdicts(answer) == {2.0: "meets", 1.0: "exceeds"}
    assert (effect(answer, LAW)["verdict"], effect(answer, LAW)["highest"]) == ("differs", "hertz")


def test_a_role_decides_what_a_design_is():
    spring = "loads.spring.stiffness"
    rows = [(1, 1, 2.0), (1, 2, 12.0), (2, 1, 2.0), (2, 2, 12.0)]
    table = table_of({CLEARANCE: 0, spring: 1, FORCE: 2}, rows)
    for role, total, met in (("choice", 4, 2), ("condition", 2, 0)):
        record = record_of({FORCE: 10.0}, {CLEARANCE: "choice", spring: role}, {CLEARANCE: "m", spring: "N/m"})
        answer = answer_of(record, table)
        assert (answer["designs_total"], sum(d["verdict"] == "meets" for d in answer["designs"])) == (total, met)


def test_the_finest_tolerance_decides_and_the_others_tell_convergence():
    record = record_of({FORCE: 170.0}, {TOLERANCE: "numerics", SPEED: "condition"}, {TOLERANCE: "1", SPEED: "rad/s"})
    rows = [(1e-2, 1, 150.0), (1e-9, 1, 200.0), (1e-6, 1, 199.0), (1e-2, 2, 100.0), (1e-6, 2, 100.0)]
    answer = answer_of(record, table_of({TOLERANCE: 0, SPEED: 1, FORCE: 2}, rows))
    assert answer["cases"] == {"met": 1, "exceeded": 1, "undecided": 0, "added": 0}
    assert [design["values"] for design in answer["designs"]] == [{}]
    by_value = {entry["value"]: entry for entry in answer["convergence"]}
    assert by_value[1e-2]["difference"] == pytest.approx(0.25)
    assert (by_value[1e-6]["finest"], by_value[1e-6]["next"]) == (200.0, 199.0)
    assert all(entry["path"] != TOLERANCE for entry in answer["effects"])


def test_a_failed_finest_case_is_undecided():
    record = record_of({FORCE: 170.0}, {TOLERANCE: "numerics"}, {TOLERANCE: "1"})
    answer = answer_of(record, table_of({TOLERANCE: 0, FORCE: 1}, [(1e-2, 150.0), (1e-9, None)]))
    assert verdicts(answer) == {None: "undecided"}


def test_cases_that_a_search_added_make_no_design_and_no_condition():
    rows = [(1, 1, 2.0), (2, 1, 3.0), (3, 7, 50.0)]
    answer = answer_of(record_of({FORCE: 10.0}), table_of(NAMES, rows), own=[True, True, False])
    assert answer["cases"] == {"met": 2, "exceeded": 0, "undecided": 0, "added": 1}
    assert verdicts(answer) == {1.0: "meets", 2.0: "meets"}
    assert answer["roles"] == {CLEARANCE: "choice"}  # the speed varies in added cases alone


def test_a_value_that_a_law_does_not_use_makes_no_difference():
    restitution = "joints.pin.contact.restitution"
    roles = {LAW: "model", restitution: "choice"}
    rows = [("flores", 0.5, 2.0), ("flores", 0.9, 3.0), ("hertz", None, 12.0)]
    record = record_of({FORCE: 10.0}, roles, {LAW: "", restitution: "1"})
    answer = answer_of(record, table_of({LAW: 0, restitution: 1, FORCE: 2}, rows))
    assert answer["designs_total"] == 2
    assert all(design["verdict"] == "exceeds" and not design["missing"] for design in answer["designs"])


def test_draws_have_shares_and_a_one_at_a_time_sample_has_no_designs():
    drawn = {CLEARANCE: [1.0, 2.0, 3.0, 4.0]}
    table = table_of({CLEARANCE: 0, FORCE: 1}, [(1.0, 1.0), (2.0, 2.0), (3.0, 20.0), (4.0, None)])
    roles = {CLEARANCE: "uncertainty"}
    record = record_of({FORCE: 10.0}, roles, {CLEARANCE: "m"}, sample={"method": "sobol", "drawn": drawn})
    (design,) = answer_of(record, table)["designs"]
    share = design["share"]
    assert (share["met"], share["exceeded"], share["undecided"]) == (0.5, 0.25, 0.25)
    assert share["low"] == pytest.approx(0.0676, abs=1e-4)  # Clopper and Pearson, 2 of 4
    assert share["high"] == pytest.approx(0.9324, abs=1e-4)
    record["sample"]["method"] = "one-at-a-time"
    assert answer_of(record, table)["designs"] == []


def test_labels_and_fits_are_text_in_an_answer():
    record = record_of({FORCE: 10.0}, labels={CLEARANCE: {"tight": 1.0}}, fits={CLEARANCE: []})
    answer = answer_of(record, table_of(NAMES, [(1.0, 1, 2.0), (2.0, 1, 3.0)]))
    assert [design["values"][CLEARANCE] for design in answer["designs"]] == ["tight", 2.0]


def test_without_limits_nothing_is_judged():
    answer = answer_of(record_of(), table_of(NAMES, [(1, 1, 2.0), (2, 1, 3.0)]), figures=[FORCE])
    assert (answer["cases"], answer["designs"], answer["question"]) == (None, [], "force")
    assert effect(answer, CLEARANCE)["verdict"] == "rises"


def test_effects_compare_cases_that_differ_in_one_value_only():
    uneven = [(1, 1, 28.9), (1, 4, 440.0), (2, 1, 100.1)]  # the medians over all cases fall
    assert effect_of(uneven) | {"medians": 0} == {
        "figure": FORCE,
        "path": CLEARANCE,
        "verdict": "rises",
        "from": 28.9,
        "to": 100.1,
        "pairs": 1,
        "share": None,
        "method": "pairs",
        "medians": 0,
    }


@pytest.mark.parametrize(
    ("values", "verdict"),
    [
        ([0.0, 0.2, 0.8], "rises"),
        ([0.0, 0.0, 0.0], "none"),
        ([-1.0, -2.0, -3.0], "falls"),
        ([3.0, 0.0, -3.0], "falls"),
        ([100.0, 100.4, 100.9], "none"),
        ([1.0, 9.0, 5.0], "mixed"),
        ([1.0, 10.0, 9.5], "rises"),
        ([5.0, 1.0, 5.0], "mixed"),
        ([1.0, 2.0, None], "not-decided"),
    ],
)
def test_the_verdict_on_one_block(values, verdict):
    assert effect_of([(k, 1, value) for k, value in enumerate(values)])["verdict"] == verdict


def test_blocks_that_disagree_are_decided_by_a_sign_test():
    def verdict(rising, falling):
        rows = [(0, j, 1.0) for j in range(rising + falling)]
        rows += [(1, j, 2.0 if j < rising else 0.5) for j in range(rising + falling)]
        return effect_of(rows)["verdict"]

    assert verdict(5, 1) == "mixed"  # 2 * 7 / 64 = 0.22
    assert verdict(9, 1) == "rises"  # 2 * 11 / 1024 = 0.021
    assert verdict(1, 9) == "falls"
    assert verdict(3, 0) == "rises"
    assert sign_test(9, 1) == pytest.approx(22 / 1024)


@pytest.mark.parametrize(
    ("lines", "trend"),
    [
        ([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]], ("rises", 1)),
        ([[3.0, 2.0, 1.0], [3.0, 4.0, 1.0]], ("falls", 1)),
        ([[1.0, 2.0, 3.0], [2.0, 1.0, 3.0], [2.0, 1.0, 3.0]], None),  # most of them turn back
        ([[1.0, 2.0, 1.0]] * 3 + [[1.0, 1.0, 1.0]] * 3, None),  # equal at both ends
        ([[1.0, 2.0, 3.0], [3.0, 1.0, 2.0]], None),  # one rises, one falls
    ],
)
def test_a_trend_that_few_blocks_leave_on_the_way_is_said_with_their_number(lines, trend):
    rows = [(k, j, value) for j, line in enumerate(lines) for k, value in enumerate(line)]
    entry = effect_of(rows)
    assert entry["verdict"] == "mixed"
    assert (entry["trend"], entry["reversed"]) == trend if trend else "trend" not in entry


def test_paths_of_zip_that_fix_one_another_are_one_axis():
    mass = "mechanism.rod.mass"
    record = record_of({FORCE: 1e9}, {CLEARANCE: "choice", mass: "choice"}, {CLEARANCE: "m", mass: "kg"})
    table = table_of({CLEARANCE: 0, mass: 1, FORCE: 2}, [(1, 5, 1.0), (2, 4, 3.0)])
    assert effect(answer_of(record, table), CLEARANCE)["verdict"] == "not-decided"
    record["zip"] = {CLEARANCE: [1, 2], mass: [5, 4]}
    (only,) = answer_of(record, table)["effects"]
    assert (only["verdict"], only["with"], only["pairs"]) == ("rises", [mass], 1)


def test_drawn_variables_are_ranked():
    drawn = {CLEARANCE: [float(k) for k in range(40)], SPEED: [float((7 * k) % 40) for k in range(40)]}
    rows = [(c, s, c - 20.0) for c, s in zip(drawn[CLEARANCE], drawn[SPEED], strict=True)]
    sample = {"method": "sobol", "drawn": drawn}
    record = record_of({FORCE: 1.0}, dict.fromkeys(ROLES, "uncertainty"), UNITS, sample=sample)
    answer = core_of(record, table_of(NAMES, rows))
    assert answer["question"] == "sample"
    assert (effect(answer, CLEARANCE)["verdict"], effect(answer, CLEARANCE)["method"]) == ("rises", "ranks")
    assert effect(answer, CLEARANCE)["share"] == pytest.approx(1.0)
    assert effect(answer, SPEED)["verdict"] == "not-decided"


def test_at_most_a_thousand_designs_and_twenty_holes_are_listed():
    rows = [(k, 0, 1.0) for k in range(1100)] + [(0, j, 1.0) for j in range(1, 41)]
    answer = answer_of(record_of({FORCE: 10.0, OTHER: 1.0}), table_of(NAMES | {OTHER: 2}, rows))
    assert (len(answer["designs"]), answer["designs_total"]) == (1000, 1100)
    assert (len(answer["designs"][5]["missing"]), answer["designs"][5]["missing_total"]) == (20, 40)


# Which question a run answers first: the same on the page and on the command line.


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
        (layout("life_hours", *FILM, life="rod_slider"), LIMITS, {"seek": SOUGHT}, "seek"),
        (layout("life_hours", *FILM, life="rod_slider"), LIMITS, {}, "life"),
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


# ---------------------------------------------------------------------------------------------- the check of laws


RIVAL, MASS = "joints.rod-slider.contact.law", "mechanism.slider.mass"
LARGEST = "rod_slider_force_peak"
HARDER = {"lankarani-nikravesh": 1.0, "hertz": 1.5}


class ByLaw(Fake):
    """Made-up mechanics whose force is the slider's mass times a factor of the law."""

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory."""
        result = trajectory(case)
        joint = case.joints[0]
        result.summary[LARGEST] = 100.0 * case.mechanism.values["slider.mass"] * HARDER[joint.contact.law]
        return result

    @staticmethod
    def alternatives(case):
        """Return the law that the grid does not have."""
        return {RIVAL: [law for law in HARDER if law != case.joints[0].contact.law]}


def checked(limit=40.0, **changes):
    source = grid(1, orbits="none") | {
        "sweep": {MASS: [0.1, 0.2, 0.3]},
        "limits": {LARGEST: limit},
        "check_laws": True,
    }
    return {key: value for key, value in (source | changes).items() if value is not None}


def ran(directory, source=None, **options):
    quiet = {"simulator": ByLaw, "executor": "serial", "show_progress": False}
    return sweep(source or checked(), directory, **(quiet | options))


def used_law():
    return grids.load(checked(), ByLaw.catalogue()).case(0).joints[0].contact.law


def test_the_worst_case_runs_again_under_each_other_law(tmp_path):
    result = ran(tmp_path / "run")
    summary = clearsweep.open(tmp_path / "run").summary
    assert (result.cases, len(summary)) == (4, 4)
    (extra,) = summary[summary[RIVAL] != used_law()].to_dict("records")
    assert extra[MASS] == 0.3  # the worst
    assert extra[LARGEST] == pytest.approx(45.0)


def test_the_cases_of_the_grid_are_those_of_a_grid_without_the_check(tmp_path):
    ran(tmp_path / "run")
    plain = grids.load(checked(check_laws=None), ByLaw.catalogue())
    names = {plain.case_id(k) for k in range(len(plain))}
    assert names < {*clearsweep.open(tmp_path / "run").summary["case_id"]}


def test_a_second_run_reuses_all_and_says_the_same(tmp_path):
    first = of_run(ran(tmp_path / "run"))
    again = of_run(ran(tmp_path / "run"))
    assert again["ran"] == 0
    assert again["law_check"] == first["law_check"]


def test_checks_enter_neither_the_closing_table_nor_the_page_but_move_the_verdict(tmp_path):
    facts = of_run(ran(tmp_path / "run"))
    assert len(facts["worst"]) == 3
    assert facts["limits"]["cases"] == 3
    assert facts["limits"]["exceeding"] == 0
    assert all(RIVAL not in entry["swept"] for entry in facts["worst"])
    assert facts["answer"]["cases"] == {"met": 3, "exceeded": 0, "undecided": 0, "added": 1}
    assert "hertz" in facts["answer"]["laws"]
    assert "does not meet the limits" in facts["answer"]["laws"]
    page = prepare(store.open(tmp_path / "run"))
    assert len(page.cases) == 3
    (shown,) = law_check_sections(page)
    assert shown.blocks


def test_a_verdict_that_all_laws_share_stands(tmp_path):
    limited = checked() | {"limits": {LARGEST: "1 kN"}}
    facts = of_run(ran(tmp_path / "run", limited))
    assert "not change the verdict" in facts["answer"]["laws"]


def test_without_limits_the_figure_is_compared(tmp_path):
    unlimited = {key: value for key, value in checked().items() if key != "limits"}
    assert "hertz" in of_run(ran(tmp_path / "run", unlimited))["answer"]["laws"]


@pytest.mark.parametrize("other", [{"refine": {"cases": 3}}, {"check_laws": "yes"}])
def test_what_adds_cases_itself_and_what_is_no_flag_are_refused(other):
    with pytest.raises(InputError, match="check_laws"):
        grids.load(checked(**other), ByLaw.catalogue())


def test_a_grid_of_its_own_record_has_the_same_cases(tmp_path):
    ran(tmp_path / "run")
    record = clearsweep.open(tmp_path / "run").grid
    again = grids.load({key: record[key] for key in record["keys"]}, ByLaw.catalogue())
    assert {again.case_id(k) for k in range(len(again))} == {*clearsweep.open(tmp_path / "run").summary["case_id"]}


def test_alternatives_are_valid_laws_and_not_the_one_in_use():
    case = simulation.load_case("configs/ptfe_bushing.yaml", {"sweep": None}).case
    names = simulation.alternatives(case)
    assert "exact" in names["joints.crank-rod.contact.law"]
    assert "flores" not in names["joints.crank-rod.contact.law"]
    assert "tsuji" not in names["joints.crank-rod.contact.law"]  # it needs a mass that the joint has not
    assert not {"power", case.joints[0].contact.elastic} & {*names["joints.crank-rod.contact.elastic"]}


def test_a_value_that_a_law_does_not_use_keeps_it_from_being_tried(tmp_path):
    source = checked()
    swept = source["sweep"] | {"joints.rod-slider.contact.restitution": [0.8, 0.9]}
    ran(tmp_path / "run", source | {"sweep": swept})
    laws = {*clearsweep.open(tmp_path / "run").summary[RIVAL]}
    assert laws == {used_law()}  # hertz uses no restitution
