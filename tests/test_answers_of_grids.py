"""Grids that designers asked about, run with the mechanics: what `answer.json` has to say of each."""

import json

import pytest
from mechanism_cases import changed
from right_grids import grid_of

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation
from clearsweep.language.errors import InputError

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


def test_friction_power_rises_from_zero(answer_of):
    friction = {"law": "tanh", "coefficient": 0.1, "velocity_scale": "1 mm/s"}
    path, figure = f"{JOINT}.friction.coefficient", "rod_slider_friction_power"
    answer = answer_of(
        grid(
            {SPEED: "600 rpm", f"{JOINT}.friction": friction},
            simulate={"revolutions": 8, "discard": 4},
            limits={figure: "2 W"},
            sweep={path: [0, 0.05, 0.1, 0.2], CLEARANCE: ["0.05 mm", "0.1 mm"]},
        )
    )
    reported = effect(answer, figure, path)
    assert (reported["verdict"], reported["from"], reported["pairs"]) == ("rises", 0.0, 2)
    assert reported["to"] == pytest.approx(0.83, abs=0.01)
    assert answer["effects"][0]["path"] == path


def test_impacts_rise_from_zero(answer_of):
    answer = answer_of(grid(limits={IMPACTS: 1}, sweep={SPEED: SPEEDS, CLEARANCE: THREE}))
    reported = effect(answer, IMPACTS, CLEARANCE)
    assert (reported["verdict"], reported["from"], reported["to"], reported["pairs"]) == ("rises", 0.0, 3.0, 4)


def test_figure_of_ones_own_keeps_its_sign(answer_of):
    answer = answer_of(
        grid(
            figures={"reserve": f"1 - {PEAK} / '200 N'"},
            limits={"reserve": {"at_least": 0}},
            sweep={SPEED: SPEEDS, CLEARANCE: ["0.02 mm", "0.05 mm"]},
        )
    )
    strongest = answer["effects"][0]
    assert (strongest["path"], strongest["verdict"]) == (SPEED, "falls")
    assert strongest["from"] > 0.0 > strongest["to"]
    assert set(verdicts(answer).values()) == {"exceeds"}
    for design in answer["designs"]:
        assert design["margin"] is None
        assert design["excess"] > 0.0


def test_failed_condition_leaves_a_design_undecided(answer_of):
    brake = "loads.brake.friction.torque"
    answer = answer_of(
        grid(
            {"mechanism.crank.inertia": "1e-3 kg*m^2"},
            drive={"motor": {"stall_torque": "2 N*m", "no_load_speed": "900 rpm"}, "initial_speed": "300 rpm"},
            loads={
                "brake": {
                    "on": "ground-crank",
                    "friction": {"law": "tanh", "torque": "1 N*m", "velocity_scale": "0.1 rad/s"},
                }
            },
            simulate={"revolutions": 6, "discard": 2, "time_limit": "2 s"},
            limits={PEAK: "2 kN"},
            sweep={brake: ["0.2 N*m", "1 N*m", "3 N*m"], CLEARANCE: ["0.05 mm", "0.1 mm"]},
        )
    )
    assert answer["roles"][brake] == "condition"
    assert counts(answer) == (4, 0, 2, 0)
    assert verdicts(answer) == {5e-5: "undecided", 1e-4: "undecided"}
    for design in answer["designs"]:
        assert design["missing"] == [{"values": {brake: 3.0}, "why": "time-limit"}]
        assert (design["conditions"], design["met"], design["undecided"]) == (3, 2, 1)


def test_design_without_every_speed_is_undecided(answer_of):
    cases = {CLEARANCE: ["0.02 mm", "0.02 mm", "0.2 mm"], SPEED: ["500 rpm", "2000 rpm", "500 rpm"]}
    answer = answer_of(grid(limits={PEAK: "500 N"}, cases=cases))
    assert verdicts(answer) == {2e-5: "meets", 2e-4: "undecided"}
    (missing,) = answer["designs"][1]["missing"]
    assert missing == {"values": {SPEED: pytest.approx(209.4395102)}, "why": "not run"}
    reported = effect(answer, PEAK, CLEARANCE)
    assert (reported["verdict"], reported["pairs"]) == ("rises", 1)
    assert (reported["from"], reported["to"]) == (pytest.approx(28.87, abs=0.1), pytest.approx(100.1, abs=0.1))


def test_one_at_a_time_sample_has_no_designs(answer_of):
    over = {
        SPEED: {"normal": {"mean": "1400 rpm", "std": "100 rpm"}},
        "mechanism.slider.mass": {"normal": {"mean": "0.14 kg", "std": "0.01 kg"}},
        CLEARANCE: {"normal": {"mean": "0.02 mm", "std": "0.002 mm"}},
    }
    answer = answer_of(
        grid(
            figures={"reserve": f"1 - {PEAK} / '200 N'"},
            limits={"reserve": {"at_least": "10 %"}},
            sample={"method": "one-at-a-time", "over": over},
        )
    )
    assert answer["designs"] == []
    assert sum(counts(answer)[:3]) == 10


def test_finest_tolerance_decides(answer_of):
    answer = answer_of(
        grid(
            {SPEED: "300 rpm", f"{JOINT}.contact.stiffness": "6.61e10 N/m^1.5"},
            simulate={"revolutions": 3, "discard": 1},
            limits={PEAK: "170 N"},
            sweep={"simulate.tolerance": ["1e-2", "1e-4", "1e-6", "1e-9"]},
        )
    )
    assert answer["roles"] == {"simulate.tolerance": "numerics"}
    assert counts(answer) == (0, 1, 0, 0)
    (design,) = answer["designs"]
    assert (design["values"], design["verdict"], design["conditions"]) == ({}, "exceeds", 1)
    assert design["margin"] == pytest.approx(1.0 - 203.08 / 170.0, abs=1e-3)
    assert answer["effects"] == []
    assert all(entry["finest"] == pytest.approx(203.08, abs=0.05) for entry in answer["convergence"])
    assert max(entry["difference"] for entry in answer["convergence"]) == pytest.approx(0.26, abs=0.01)


def test_spring_is_a_choice_and_force_a_condition(answer_of):
    stiffness = "loads.back.stiffness"
    back = {"between": ["ground", "slider"], "anchor": ["0 m", "0 m"], "stiffness": "2 N/mm", "free_length": "0 mm"}
    source = grid(
        {SPEED: "600 rpm"},
        loads={"back": back},
        simulate={"revolutions": 4, "discard": 2},
        limits={PEAK: "150 N"},
        sweep={stiffness: ["0.2 N/mm", "0.8 N/mm", "4 N/mm"], CLEARANCE: ["0.05 mm", "0.1 mm"]},
    )
    answer = answer_of(source)
    assert answer["roles"] == {stiffness: "choice", CLEARANCE: "choice"}
    assert [design["verdict"] for design in answer["designs"]] == ["meets"] * 4 + ["exceeds"] * 2
    (soft,) = [design for design in answer["designs"] if design["values"] == {stiffness: 800.0, CLEARANCE: 1e-4}]
    assert soft["margin"] == pytest.approx(0.26, abs=0.005)
    answer = answer_of(source | {"roles": {stiffness: "condition"}})
    assert verdicts(answer) == {5e-5: "exceeds", 1e-4: "exceeds"}


def test_worst_of_the_laws_counts(answer_of):
    law = f"{JOINT}.contact.law"
    answer = answer_of(
        grid(
            {
                SPEED: "1500 rpm",
                "mechanism.rod.center": "60 mm",
                f"{JOINT}.contact.stiffness": "6.61e10 N/m^1.5",
                f"{JOINT}.contact.restitution": 0.8,
            },
            simulate={"revolutions": 12, "discard": 4},
            limits={PEAK: "1 kN"},
            sweep={law: ["flores", "lankarani-nikravesh", "hertz"], CLEARANCE: ["0.05 mm", "0.1 mm", "0.2 mm"]},
        )
    )
    assert answer["roles"][law] == "model"
    assert verdicts(answer) == {5e-5: "exceeds", 1e-4: "exceeds", 2e-4: "exceeds"}
    least = next(design for design in answer["designs"] if design["values"] == {CLEARANCE: 5e-5})
    assert (least["met"], least["exceeded"], least["conditions"]) == (2, 1, 3)


@pytest.mark.slow
def test_thickness_of_the_film_holds_under_every_law(answer_of):
    source = grid({SPEED: "3000 rpm"}, simulate={"revolutions": 4, "discard": 2})
    source["joints"]["rod-slider"] = {
        "clearance": "0.2 mm",
        "bearing_radius": "10 mm",
        "length": "10 mm",
        "film": {"viscosity": "0.4 Pa*s"},
    }
    laws = {f"{JOINT}.film.law": ["short", "reynolds", "finite"], CLEARANCE: ["0.1 mm", "0.2 mm"]}
    answer = answer_of(source | {"limits": {"rod_slider_film_thickness_min": {"at_least": "5 um"}}, "sweep": laws})
    assert answer["roles"][f"{JOINT}.film.law"] == "model"
    assert verdicts(answer) == {1e-4: "meets", 2e-4: "meets"}
    assert {design["conditions"] for design in answer["designs"]} == {3}


def test_role_of_a_path_that_could_vary_is_accepted(answer_of):
    source = grid(limits={PEAK: "20 kN"}, sweep={SPEED: SPEEDS[:2]}, roles={CLEARANCE: "condition", SPEED: "choice"})
    assert answer_of(source)["roles"] == {SPEED: "choice"}
    with pytest.raises(InputError, match=r"roles\.drive\.sped: cannot vary in this grid; did you mean 'drive\.speed'"):
        clearsweep.sweep(source | {"roles": {"drive.sped": "choice"}}, show_progress=False)


def test_start_cannot_be_swept():
    with pytest.raises(InputError, match=r"simulate\.start.*cannot be swept"):
        clearsweep.sweep(grid(sweep={"simulate.start": ["centred", "seated"]}), show_progress=False)


def test_clearance_up_to_which_a_crank_meets(answer_of):
    answer = answer_of(
        grid(
            {SPEED: "600 rpm"},
            simulate={"revolutions": 8, "discard": 4},
            limits={PEAK: "250 N"},
            sweep={SPEED: ["600 rpm", "1200 rpm"], CLEARANCE: ["0.05 mm", "0.2 mm"]},
        )
    )
    assert verdicts(answer) == {5e-5: "meets", 2e-4: "exceeds"}
    assert answer["complete"] is True


def test_variants_with_conditions_of_their_own_are_judged_as_they_stand():
    def role_of_speed(clearances, speeds, **sections):
        zipped = {CLEARANCE: [f"{each} um" for each in clearances], SPEED: [f"{each} rpm" for each in speeds]}
        return grids.load(grid(zip=zipped, **sections), simulation.catalogue()).roles[SPEED]

    assert role_of_speed([10, 20, 30], [600, 900, 900]) == "choice"
    assert role_of_speed([10, 20, 30], [600, 900, 900], roles={SPEED: "condition"}) == "condition"
    assert role_of_speed([10, 10, 20, 20], [600, 900, 600, 900]) == "condition"  # each design runs at both speeds
    assert role_of_speed([10, 10, 20], [600, 900, 600]) == "condition"  # one was not run: undecided
