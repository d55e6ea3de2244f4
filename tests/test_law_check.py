"""`check_laws`: the deciding case of a run again under the other valid laws, apart from the cases of the grid."""

import pytest
from fake_physics import Fake, grid, sweep, trajectory

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation, store
from clearsweep.language.errors import InputError
from clearsweep.report.sections.laws import law_check_sections
from clearsweep.report.study import prepare
from clearsweep.sweeping.summary import of_run

LAW, MASS = "joints.rod-slider.contact.law", "mechanism.slider.mass"
PEAK = "rod_slider_force_peak"
HARDER = {"lankarani-nikravesh": 1.0, "hertz": 1.5}


class ByLaw(Fake):
    """Made-up mechanics whose force is the slider's mass times a factor of the law."""

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory."""
        result = trajectory(case)
        joint = case.joints[0]
        result.summary[PEAK] = 100.0 * case.mechanism.values["slider.mass"] * HARDER[joint.contact.law]
        return result

    @staticmethod
    def alternatives(case):
        """Return the law that the grid does not have."""
        return {LAW: [law for law in HARDER if law != case.joints[0].contact.law]}


def checked(limit=40.0, **changes):
    source = grid(1, orbits="none") | {
        "sweep": {MASS: [0.1, 0.2, 0.3]},
        "limits": {PEAK: limit},
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
    (extra,) = summary[summary[LAW] != used_law()].to_dict("records")
    assert extra[MASS] == 0.3  # the worst
    assert extra[PEAK] == pytest.approx(45.0)


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
    assert all(LAW not in entry["swept"] for entry in facts["worst"])
    assert facts["answer"]["cases"] == {"met": 3, "exceeded": 0, "undecided": 0, "added": 1}
    assert "hertz" in facts["answer"]["laws"]
    assert "does not meet the limits" in facts["answer"]["laws"]
    page = prepare(store.open(tmp_path / "run"))
    assert len(page.cases) == 3
    (shown,) = law_check_sections(page)
    assert shown.blocks


def test_a_verdict_that_all_laws_share_stands(tmp_path):
    limited = checked() | {"limits": {PEAK: "1 kN"}}
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
    laws = {*clearsweep.open(tmp_path / "run").summary[LAW]}
    assert laws == {used_law()}  # hertz uses no restitution
