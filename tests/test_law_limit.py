"""Beyond the range an elastic law is meant for, a run says for how long."""

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import simulation
from clearsweep.answers.validity import (
    LIMIT_SHARE,
    ONSET_RATE,
    YIELD_SPEED,
    Remarks,
    law_range_remark,
    required_columns,
)
from clearsweep.mechanics.joints import registry

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
    assert trajectory.message.startswith("law-limit: rod-slider exceeds 0.1991 mm, the limit of johnson,")


def test_a_law_without_a_limit_is_never_beyond_it():
    trajectory = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider")))
    assert trajectory.summary["rod_slider_law_limit_fraction"] == 0.0
    assert trajectory.message == ""


def columns_of_case(row):
    """Columns of one case."""
    return {column: [value] for column, value in row.items()}


def test_a_run_tells_how_many_cases_leave_the_range_of_their_laws():
    messages = Remarks(["crank_rod", "rod_slider"])
    zero = dict.fromkeys(
        (f"{joint}_{figure}" for joint in messages.joints for figure in (ONSET_RATE, LIMIT_SHARE)), 0.0
    )
    zero |= {"crank_rod_yield_speed": 0.1, "rod_slider_yield_speed": 0.5}
    messages.add(columns_of_case({"case_id": "a", "message": "", **zero, "rod_slider_onset_rate_max": 0.5}))
    messages.add(columns_of_case({"case_id": "b", "message": "", **zero, "crank_rod_onset_rate_max": 0.4}))
    messages.add(columns_of_case({"case_id": "c", "message": "", **zero, "rod_slider_onset_rate_max": 5.0}))
    message = law_range_remark([("crank-rod", "liu", np.inf, 0.0), ("rod-slider", "johnson", 2e-4, 0.125)])
    messages.add(columns_of_case({"case_id": "d", "message": message, **zero, "rod_slider_law_limit_fraction": 0.125}))
    messages.add(columns_of_case({"case_id": "e", "message": None, **zero, "rod_slider_law_limit_fraction": None}))
    fast, deep = messages.sentences()
    assert "in 2 of 5 cases: the fastest approaches at 5 m/s, 10 times the 0.5 m/s at which its contact first" in fast
    assert "(case c, rod-slider)" in fast
    assert "Beyond yield an elastic law overstates forces" in fast  # which law it is the row does not say
    assert "in 1 of 5 cases, longest in case d: rod-slider exceeds 0.2 mm, the limit of johnson," in deep
    assert "for 12 % of the time." in deep
    together = Remarks(messages.joints)
    rates = {column: [value] * 3 for column, value in zero.items()}
    rates["crank_rod_onset_rate_max"] = [0.11, np.nan, 0.5]
    together.add({"case_id": list("abc"), "message": ["", message, None], **rates})
    assert "in 2 of 3 cases: the fastest approaches at 0.5 m/s" in together.sentences()[0]
    assert "(case c, crank-rod)" in together.sentences()[0]


def test_contacts_of_unknown_strength_are_not_blamed():
    message = Remarks(["crank_rod", "rod_slider"])
    rows = {"case_id": list("abc"), "message": ["", "", ""]}
    rows |= {f"{joint}_law_limit_fraction": [0.0] * 3 for joint in message.joints}
    rows |= {"crank_rod_onset_rate_max": [0.6, 0.2, 0.0], "rod_slider_onset_rate_max": [9.0, 9.0, 9.0]}
    rows |= {"crank_rod_yield_speed": [None, 0.1, 0.1]}  # of a law that yields; nothing is known of rod-slider
    message.add(rows)
    (fast,) = message.sentences()
    assert "in 1 of 3 cases: the fastest approaches at 0.2 m/s, 2 times the 0.1 m/s" in fast
    assert "(case b, crank-rod)" in fast
    assert required_columns(message.joints, rows)[-1] == f"crank_rod_{YIELD_SPEED}"


def test_a_run_within_what_its_laws_are_made_for_has_nothing_to_tell():
    message = Remarks(["pair"])
    message.add(
        columns_of_case({"case_id": "a", "message": "", "pair_onset_rate_max": 0.0, "pair_law_limit_fraction": 0.0})
    )
    assert message.sentences() == []
    assert law_range_remark([("pair", "johnson", 1e-4, 0.0)]) == ""


@pytest.mark.parametrize(("law", "pulls"), [("tsuji", True), ("exact", False)])
def test_a_law_that_pulls_is_named_before_the_run(law, pulls):
    contact = {"law": law, "stiffness": 1e9, "restitution": 0.7, **({"mass": 0.1} if pulls else {})}
    case = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact})).case
    assert any("tsuji pulls before the surfaces part" in sentence for sentence in simulation.warnings(case)) == pulls


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_step_that_overflows_is_rejected():
    from clearsweep.mechanics.solver.collocation import error_norm

    coefficients = np.zeros((4, 8))
    coefficients[2, 7] = 1e200
    assert error_norm(coefficients, np.ones(4)) == np.inf
    coefficients[2, 7] = np.nan
    assert not error_norm(coefficients, np.ones(4)) < 1.0
