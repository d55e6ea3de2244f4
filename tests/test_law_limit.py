"""Beyond the range an elastic law is meant for, a run says for how long."""

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.judging.validity import THRESHOLDS, Remarks, columns, past_limits, surfaces_of
from clearsweep.mechanics.joint import registry
from clearsweep.simulation import scene

pytestmark = pytest.mark.heavy

CONTACT = {"law": "hertz", "elastic": "johnson", "material": {"young": 1e6, "poisson": 0.3}}


def test_time_beyond_the_range_of_the_law_is_the_share_of_samples_beyond_it():
    changes = {"joints.rod-slider.contact": CONTACT, "drive.speed": "300 rpm", "simulate.tolerance": 1e-7}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    limit = registry.penetration_limit(scene.case.joints[0])
    trajectory = clearsweep.simulate(scene, times=np.linspace(0.0, 0.2, 20001))
    assert trajectory.status == "ok"
    depth = np.hypot(trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"]) - 0.5e-3
    assert 0.0 < np.mean(depth > limit) < 1.0
    assert trajectory.summary["rod_slider_law_limit_fraction"] == pytest.approx(np.mean(depth > limit), abs=2e-3)
    assert trajectory.message.startswith("law-limit: rod-slider is deeper than 0.1991 mm, up to which johnson holds")


def test_a_law_without_a_limit_is_never_beyond_it():
    trajectory = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider")))
    assert trajectory.summary["rod_slider_law_limit_fraction"] == 0.0
    assert trajectory.message == ""


def one(row):
    """Columns of one case."""
    return {column: [value] for column, value in row.items()}


def test_a_run_tells_how_many_cases_leave_what_their_laws_are_made_for_and_the_worst():
    told = Remarks(surfaces_of({}, ["crank_rod", "rod_slider"]))
    zero = dict.fromkeys((f"{joint}_{figure}" for joint in told.joints for figure in THRESHOLDS), 0.0)
    told.add(one({"case_id": "a", "message": "", **zero, "rod_slider_onset_rate_max": 0.05}))
    told.add(one({"case_id": "b", "message": "", **zero, "crank_rod_onset_rate_max": 0.06}))
    told.add(one({"case_id": "c", "message": "", **zero, "rod_slider_onset_rate_max": 0.5}))
    message = past_limits([("crank-rod", "liu", np.inf, 0.0), ("rod-slider", "johnson", 2e-4, 0.125)])
    told.add(one({"case_id": "d", "message": message, **zero, "rod_slider_law_limit_fraction": 0.125}))
    told.add(one({"case_id": "e", "message": None, **zero, "rod_slider_law_limit_fraction": None}))
    fast, deep = told.sentences()
    assert "in 2 of 5 cases: the fastest closes at 0.5 m/s, 10 times the 0.05 m/s" in fast
    assert "(case c, rod-slider)" in fast
    assert "a law that does not yield then overstates forces" in fast  # which law it is the row does not say
    assert "in 1 of 5 cases, longest in case d: rod-slider is deeper than 0.2 mm, up to which johnson holds" in deep
    assert "for 12 % of the time." in deep
    together = Remarks(told.surfaces)
    rates = {**{column: [0.0] * 3 for column in zero}, "crank_rod_onset_rate_max": [0.06, np.nan, 0.5]}
    together.add({"case_id": list("abc"), "message": ["", message, None], **rates})
    assert "in 2 of 3 cases: the fastest closes at 0.5 m/s" in together.sentences()[0]
    assert "(case c, crank-rod)" in together.sentences()[0]


def test_laws_that_yield_are_not_blamed_and_a_material_has_a_limit_of_its_own():
    soft = {"young": 0.5e9, "density": 2200.0}  # 1e-5 sqrt(E / rho) = 4.8 mm/s
    record = {
        "joints": {
            "rod-slider": {"contact": {"law": "exact", "material": soft}},
            "crank-rod": {"contact": {"law": "exact", "material": {"bearing": soft, "journal": {"young": 207e9}}}},
        },
        "units": {"joints.crank-rod.contact.law": ""},
    }
    surfaces = surfaces_of(record, ["crank_rod", "rod_slider"])
    assert surfaces["rod_slider"].elastic_to == pytest.approx(4.767e-3, rel=1e-3, abs=0.0)
    told = Remarks(surfaces, {"yields"})
    rows = {"case_id": list("abc"), "message": ["", "", ""]}
    rows |= {f"{joint}_law_limit_fraction": [0.0] * 3 for joint in surfaces}
    rows |= {"crank_rod_onset_rate_max": [0.6, 0.2, 0.0], "rod_slider_onset_rate_max": [0.004, 0.004, 0.006]}
    told.add(rows | {"joints.crank-rod.contact.law": ["yields", "exact", "exact"]})
    (fast,) = told.sentences()
    assert "in 2 of 3 cases: the fastest closes at 0.2 m/s, 42 times the 0.00477 m/s" in fast
    assert "its material may yield (case b, crank-rod)" in fast
    assert columns(surfaces)[-1] == "joints.crank-rod.contact.law"
    assert surfaces_of({}, ["pair"])["pair"].elastic_to == 0.05


def test_a_run_within_what_its_laws_are_made_for_has_nothing_to_tell():
    told = Remarks(surfaces_of({}, ["pair"]))
    told.add(one({"case_id": "a", "message": "", **{f"pair_{figure}": 0.0 for figure in THRESHOLDS}}))
    assert told.sentences() == []
    assert past_limits([("pair", "johnson", 1e-4, 0.0)]) == ""


@pytest.mark.parametrize(("law", "pulls"), [("tsuji", True), ("exact", False)])
def test_a_law_that_pulls_is_named_before_the_run(law, pulls):
    contact = {"law": law, "stiffness": 1e9, "restitution": 0.7, **({"mass": 0.1} if pulls else {})}
    case = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact})).case
    assert any("tsuji pulls before the surfaces part" in sentence for sentence in scene.warnings(case)) == pulls


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_step_that_overflows_is_rejected():
    from clearsweep.mechanics.solver.dop853 import error_norm

    rates = np.zeros((16, 4))
    rates[5, 2] = 1e200
    assert error_norm(1.0, rates, np.ones(4)) == np.inf
    rates[5, 2] = np.nan
    assert not error_norm(1.0, rates, np.ones(4)) < 1.0
