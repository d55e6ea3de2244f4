"""Answers agree with a second judge, plain loops written from the manual, over random grids and made-up figures."""

import copy
import os

import answer_grids
import answer_oracle as oracle
import pytest
from answer_grids import (
    BASE,
    CLEARANCE,
    FORCE,
    IDEAL,
    IMPACTS,
    LAW,
    MASS,
    ONSET,
    OWN,
    PEAK,
    SPEED,
    SPRING,
    TOLERANCE,
    Setting,
    answered,
    differences,
    settings_of_grids,
)
from hypothesis import example, given, settings

from clearsweep import simulation
from clearsweep.grid.keys import Section
from clearsweep.grid.keys.key_table import table_of_keys

#: Random answers of every day; `CLEARSWEEP_ANSWERS=10000 pytest -m slow tests/test_answer_oracle.py`: of the slow test.
FEW, COUNT = 40, int(os.environ.get("CLEARSWEEP_ANSWERS", "400"))
OK, STALLED = oracle.OK, "stalled"


def setting(outcomes: list, **sections) -> Setting:
    """Return a grid with these sections and the figures of its cases: dicts, or the word of a failure."""
    cases = tuple((OK, row) if isinstance(row, dict) else (row, {}) for row in outcomes)
    return Setting(copy.deepcopy(BASE) | sections, {}, [0], cases)


def table(column: str, values: list) -> list:
    """Return one figure of every case; a word is a failure."""
    return [value if isinstance(value, str) else {column: value} for value in values]


ZERO_LIMIT = setting(
    [{IMPACTS: impacts, PEAK: 100.0} for impacts in (0.0, 0.0, 0.25, 1.0, 2.0, 3.75)],
    limits={IMPACTS: 0, PEAK: "20 kN"},
    sweep={CLEARANCE: ["0.02 mm", "0.2 mm", "0.5 mm"], SPEED: ["500 rpm", "1000 rpm"]},
)
FAILED_CONDITION = setting(
    table(PEAK, [90.0, 40.0, STALLED, 95.0, 45.0, STALLED]),
    limits={PEAK: "2 kN"},
    sweep={CLEARANCE: ["0.05 mm", "0.1 mm"], FORCE: ["-10 N", "0 N", "10 N"]},
)
NOT_RUN = setting(
    table(PEAK, [28.9, 442.0, 100.1]),
    limits={PEAK: "500 N"},
    cases={CLEARANCE: ["0.02 mm", "0.02 mm", "0.2 mm"], SPEED: ["500 rpm", "2000 rpm", "500 rpm"]},
)
UNLIKE_CONDITIONS = setting(  # the medians fall where each speed rises
    table(PEAK, [10.0, 100.0, 20.0, 30.0]),
    limits={PEAK: "500 N"},
    cases={
        CLEARANCE: ["0.05 mm", "0.05 mm", "0.2 mm", "0.2 mm"],
        SPEED: ["500 rpm", "6000 rpm", "500 rpm", "1000 rpm"],
    },
)
ZERO_FIGURES = setting(
    table(PEAK, [0.0, 0.21, 0.42, 0.83]),
    limits={PEAK: "2 N"},
    sweep={answer_grids.FRICTION: [0, 0.05, 0.1, 0.2]},
)
SIGNED_FIGURES = setting(
    table(PEAK, [-30.0, -10.0, 40.0, 60.0]),
    limits={PEAK: "100 N"},
    sweep={SPEED: ["500 rpm", "1000 rpm"], CLEARANCE: ["0.02 mm", "0.05 mm"]},
)
FINEST = setting(
    table(PEAK, [150.0, 160.0, 165.0, 203.0]),
    limits={PEAK: "170 N"},
    sweep={TOLERANCE: ["1e-2", "1e-4", "1e-6", "1e-9"]},
)
FAILED_FINEST = FINEST._replace(given=(*FINEST.given[:3], ("step-budget", {})))
SPRING_CHOICE = setting(
    table(PEAK, [100.0, 160.0, 90.0, 110.0]),
    limits={PEAK: "150 N"},
    sweep={SPRING: ["1 kN/m", "2 kN/m"], CLEARANCE: ["0.05 mm", "0.1 mm"]},
)
LAWS = setting(
    table(PEAK, [0.9, 0.8, 1.2, 0.95, 0.9, 0.99]),
    limits={PEAK: "1 N"},
    sweep={CLEARANCE: ["0.05 mm", "0.1 mm"], LAW: ["flores", "lankarani-nikravesh", "hertz"]},
)
UNUSED_RESTITUTION = setting(  # hertz has none, so its cases are one and have null on this axis
    table(PEAK, [0.9, 0.8, 1.2]),
    limits={PEAK: "1 N"},
    sweep={answer_grids.RESTITUTION: [0.2, 0.8], LAW: ["flores", "hertz"]},
)
DEFINED_SPEED = setting(
    table(PEAK, [1.0, 3.0, 0.5, 1.5]),
    limits={PEAK: "2 N"},
    define={"pace": "500 rpm"},
    drive={"speed": "= pace"},
    sweep={"define.pace": ["500 rpm", "1000 rpm"], CLEARANCE: ["0.05 mm", "0.1 mm"]},
)
CLOSE_LENGTHS = setting(
    table(PEAK, [1.0, 3.0, 2.0]),
    limits={PEAK: "2 N"},
    sweep={answer_grids.LENGTH: ["119.98 mm", "120 mm", "120.02 mm"]},
)
JOINT = BASE["joints"]["rod-slider"]
FITS_OF_TWO_JOINTS = setting(
    table(PEAK, [1.0, 3.0, 3.0, 4.0]),
    limits={PEAK: "2 N"},
    joints={"rod-slider": JOINT, "crank-rod": JOINT},
    sweep={CLEARANCE: {"fits": ["H7/g6", "H7/f7"]}, "joints.crank-rod.clearance": {"fits": ["H7/g6", "H7/f7"]}},
)
OWN_ROLE = setting(
    table(PEAK, [1.0, 3.0, 1.5]), limits={PEAK: "2 N"}, sweep={FORCE: ["-10 N", "0 N", "10 N"]}, roles={FORCE: "choice"}
)
TIMES_NULL = setting(
    [{PEAK: 5.0, IDEAL: None}, {PEAK: 5.0, IDEAL: 1.0}, {PEAK: None, IDEAL: 1.0}],
    limits={PEAK: {"at_most": 5, "times": IDEAL}, IMPACTS: 10},
    sweep={CLEARANCE: ["0.02 mm", "0.05 mm", "0.1 mm"]},
)
EXCEEDED_BESIDE_NULL = setting(
    [{PEAK: None, IMPACTS: 3.0}, {PEAK: 1.0, IMPACTS: 1.0}],
    limits={PEAK: "2 N", IMPACTS: 2},
    sweep={CLEARANCE: ["0.02 mm", "0.05 mm"]},
)
NEGATIVE_BOUND = setting(
    [{PEAK: 1.0}, {PEAK: 4.0}, {PEAK: 9.0}],
    figures={OWN: f"1 - {PEAK} / '2 N'"},
    limits={OWN: {"at_least": -1}},
    sweep={CLEARANCE: ["0.02 mm", "0.05 mm", "0.1 mm"]},
)


TIED_CONDITION = setting(
    [{PEAK: 1.0}, {PEAK: 4.0}],
    zip={CLEARANCE: ["0.02 mm", "0.05 mm"], SPEED: ["500 rpm", "2000 rpm"]},
    roles={CLEARANCE: "choice"},
)


@pytest.mark.slow
@settings(max_examples=COUNT)
@given(settings_of_grids())
def test_core_agrees_with_the_second_judge_in_many_grids(grid):
    assert differences(answered(grid)) == []


@settings(max_examples=FEW)
@given(settings_of_grids())
@example(ZERO_LIMIT)
@example(FAILED_CONDITION)
@example(NOT_RUN)
@example(UNLIKE_CONDITIONS)
@example(ZERO_FIGURES)
@example(SIGNED_FIGURES)
@example(FINEST)
@example(FAILED_FINEST)
@example(SPRING_CHOICE)
@example(LAWS)
@example(DEFINED_SPEED)
@example(CLOSE_LENGTHS)
@example(FITS_OF_TWO_JOINTS)
@example(OWN_ROLE)
@example(TIMES_NULL)
@example(EXCEEDED_BESIDE_NULL)
@example(NEGATIVE_BOUND)
@example(TIED_CONDITION)
def test_core_agrees_with_the_second_judge(grid):
    assert differences(answered(grid)) == []


@pytest.mark.slow
@settings(max_examples=15)
@given(settings_of_grids())
def test_answers_of_many_runs_are_those_of_their_cases(grid):
    assert_answer_of_a_run_is_that_of_its_cases(grid)


@settings(max_examples=5)
@given(settings_of_grids())
@example(ZERO_LIMIT)
@example(FAILED_CONDITION)
@example(UNUSED_RESTITUTION)
def test_answer_of_a_run_is_that_of_its_cases(grid):
    assert_answer_of_a_run_is_that_of_its_cases(grid)


def assert_answer_of_a_run_is_that_of_its_cases(grid):
    run = answer_grids.run_and_judged(grid)
    assert differences(run) == []
    core = answered(grid).answer
    assert run.answer["cases"] == core["cases"]
    assert by_values(run.answer["designs"]) == by_values(core["designs"])


DRAWN_CHOICE = setting(
    table(PEAK, [1.0, 3.0, 1.5, 2.5]),
    limits={PEAK: "2 N"},
    sample={
        "method": "random",
        "n": 4,
        "over": {MASS: {"uniform": ["0.1 kg", "0.3 kg"]}, SPEED: {"uniform": ["500 rpm", "2000 rpm"]}},
    },
    roles={MASS: "choice"},
)
COARSE_ALONE = setting(
    table(PEAK, [None, -1.0, -1.0, 5.0]),
    limits={PEAK: "2 N"},
    cases={
        answer_grids.REVOLUTIONS: [3, 3, 6, 3],
        SPRING: ["0 N/m", "1 kN/m", "0 N/m", "2 kN/m"],
    },
)


def test_share_counts_the_draws_that_were_not_run():
    assert differences(answered(DRAWN_CHOICE)) == []


def test_convergence_compares_no_case_with_itself():
    assert differences(answered(COARSE_ALONE)) == []


def by_values(designs: list[dict]) -> dict[str, tuple]:
    """Return values -> verdict and counts of designs; ties make their order and worst case that of the rows."""
    keys = ("verdict", "margin", "excess", "conditions", "met", "exceeded", "undecided", "missing_total")
    return {repr(design["values"]): tuple(design[key] for key in keys) for design in designs}


NEXT = {"meets": "exceeds", "exceeds": "undecided", "undecided": "meets", "rises": "falls", "falls": "rises"}


def changed_answers(answer: dict):
    """Yield copies of an answer, each with one thing changed."""
    for word in answer["cases"]:
        yield answer | {"cases": answer["cases"] | {word: answer["cases"][word] + 1}}
    for place, design in enumerate(answer["designs"]):
        changes = {key: design[key] + 1 for key in ("conditions", "met", "exceeded", "missing_total")}
        changes |= {
            "verdict": NEXT[design["verdict"]],
            "worst": "another",
            "limit": "another",
            "values": {"another": 1},
        }
        changes["margin"] = 0.123 if design["margin"] is None else None
        yield from (with_entry(answer, "designs", place, design | {key: changes[key]}) for key in changes)
    for place, effect in enumerate(answer["effects"]):
        changes = {"verdict": NEXT.get(effect["verdict"], "rises"), "pairs": effect["pairs"] + 1}
        yield from (with_entry(answer, "effects", place, effect | {key: changes[key]}) for key in changes)
    yield answer | {"roles": dict.fromkeys(answer["roles"], "another")}
    yield answer | {"complete": not answer["complete"]}
    yield answer | {"question": "another"}


def with_entry(answer: dict, section: str, place: int, entry: dict) -> dict:
    """Return an answer with one entry of a list replaced."""
    return answer | {section: [*answer[section][:place], entry, *answer[section][place + 1 :]]}


@pytest.mark.parametrize(
    "grid", [ZERO_LIMIT, FAILED_CONDITION, NOT_RUN, FINEST, LAWS, TIMES_NULL, EXCEEDED_BESIDE_NULL]
)
def test_second_judge_notices_every_change(grid):
    run = answered(grid)
    unnoticed = [answer for answer in changed_answers(run.answer) if not differences(run._replace(answer=answer))]
    assert unnoticed == []


@pytest.mark.parametrize(
    ("grid", "verdicts"),
    [
        (ZERO_LIMIT, ["meets", "exceeds", "exceeds"]),
        (FAILED_CONDITION, ["undecided", "undecided"]),
        (NOT_RUN, ["meets", "undecided"]),
        (FINEST, ["exceeds"]),
        (FAILED_FINEST, ["undecided"]),
        (SPRING_CHOICE, ["meets", "meets", "meets", "exceeds"]),
        (LAWS, ["meets", "exceeds"]),
        (DEFINED_SPEED, ["meets", "exceeds"]),
        (FITS_OF_TWO_JOINTS, ["meets", "exceeds", "exceeds", "exceeds"]),
        (OWN_ROLE, ["meets", "meets", "exceeds"]),
        (TIMES_NULL, ["meets", "undecided", "undecided"]),
        (EXCEEDED_BESIDE_NULL, ["meets", "exceeds"]),
        (NEGATIVE_BOUND, ["meets", "meets", "exceeds"]),
    ],
)
def test_verdicts_by_hand(grid, verdicts):
    assert [design["verdict"] for design in answered(grid).answer["designs"]] == verdicts


@pytest.mark.parametrize(
    ("grid", "path", "verdict", "ends"),
    [
        (UNLIKE_CONDITIONS, CLEARANCE, "rises", (10.0, 20.0)),
        (ZERO_FIGURES, answer_grids.FRICTION, "rises", (0.0, 0.83)),
        (SIGNED_FIGURES, SPEED, "rises", (-20.0, 50.0)),
        (NOT_RUN, CLEARANCE, "rises", (28.9, 100.1)),
    ],
)
def test_effects_by_hand(grid, path, verdict, ends):
    effect = next(entry for entry in answered(grid).answer["effects"] if entry["path"] == path)
    assert (effect["verdict"], effect["from"], effect["to"]) == (verdict, *map(pytest.approx, ends))


def test_every_key_has_its_role_of_the_manual():
    catalogue = simulation.catalogue()
    wrong = {
        path: key.role
        for mechanism in catalogue.mechanisms
        for path, key in table_of_keys(mechanism, catalogue).items()
        if not isinstance(key, Section) and key.sweep and key.role != oracle.role_of_key(path)
    }
    assert wrong == {}


SEARCHED = {
    "refine": {"sweep": {CLEARANCE: ["0.02 mm", "0.1 mm"], MASS: ["0.1 kg", "0.2 kg"]}, "refine": {"along": "limits"}},
    "seek each": {"sweep": {MASS: ["0.1 kg", "0.2 kg"]}, "seek": {"largest": CLEARANCE}},
    "seek all": {"sweep": {MASS: ["0.1 kg", "0.2 kg"]}, "seek": {"largest": CLEARANCE, "for": "all"}},
    "optimise": {"optimise": {"over": {CLEARANCE: ["0.01 mm", "0.2 mm"]}, "minimise": PEAK, "cases": 16}},
    "check of laws": {"sweep": {CLEARANCE: ["0.02 mm", "0.1 mm", "0.2 mm"]}, "check_laws": True},
    "refined sample": {
        "sample": {"method": "random", "n": 6, "over": {MASS: {"uniform": ["0.1 kg", "0.3 kg"]}}},
        "check_laws": True,
    },
}


@pytest.mark.few("limits0-refine", "limits0-seek all", "limits1-optimise", "limits1-check of laws")
@pytest.mark.parametrize("name", SEARCHED)
@pytest.mark.parametrize("limits", [{IMPACTS: 0}, {PEAK: "1.3 N", ONSET: {"at_least": "-0.5 m/s"}}])
def test_searched_cases_make_no_design(tmp_path, name, limits):
    sections = copy.deepcopy(SEARCHED[name])
    if "seek" in sections:
        sections["seek"] |= {"between": ["0.01 mm", "0.2 mm"], "within": "0.01 mm", "meeting": "limits"}
    if "refine" in sections:
        sections["refine"] |= {"cases": 6}
    run = answer_grids.search_and_judged(copy.deepcopy(BASE) | sections | {"limits": limits}, tmp_path / "run")
    assert differences(run) == []
    assert run.added > 0


@pytest.mark.few("grid0-options0", "grid1-options2", "grid2-options1", "grid3-options0")
@pytest.mark.parametrize("options", [{"shard": "1/2"}, {"shard": "2/2"}, {"max_failures": 1}])
@pytest.mark.parametrize("grid", [ZERO_LIMIT, FAILED_CONDITION, SPRING_CHOICE, LAWS])
def test_case_of_the_grid_that_was_not_run_is_undecided(grid, options):
    run = answer_grids.run_and_judged(grid, **options)
    assert differences(run) == []
    assert run.answer["complete"] is all(row.status != oracle.NOT_RUN for row in run.rows)
