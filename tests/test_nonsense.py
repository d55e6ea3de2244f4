"""Figures that nobody can have meant are named, and a case that would never end is ended."""

import re

import numpy as np
import pytest
from fake_physics import Fake, grid
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import simulation
from clearsweep.answers.validity import (
    Remarks,
    imbalance_remark,
    join_remarks,
    penetration_remark,
    pv_remark,
    wear_depth_remark,
    wear_rate_remark,
)
from clearsweep.contracts.case import NO_CONTACT, Film, Joint
from clearsweep.grid import check_disk, check_memory, largest_history, load
from clearsweep.simulation import catalogue
from clearsweep.sweeping import sweep

CONTACT = "joints.rod-slider.contact"
WEAR = {"law": "archard", "coefficient": 2e-8}


def run(**changes):
    """Return the trajectory of a slider-crank over a revolution; `changes` has `__` for dots."""
    changes = {path.replace("__", "."): value for path, value in changes.items()}
    return clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes)))


@pytest.mark.compiled
def test_a_case_that_would_not_end_is_ended_by_its_time():
    length = {"simulate__revolutions": 1e9, "simulate__time_budget": 1e-3}
    path = run(**length, simulate__tolerance=1e-6, simulate__method="explicit")
    assert path.status == "time-budget"
    assert re.match(r"reached the budget of 0\.001 s of process time at [\d.]+ s of 1\.2e\+07 s", path.message)
    assert path.summary["steps"] > 0
    assert path.summary["rod_slider_force_peak"] is None


@pytest.mark.compiled
def test_a_step_budget_says_what_was_taken():
    path = run(simulate__revolutions=3, simulate__step_budget=100)
    assert path.status == "step-budget"
    words = re.match(r"reached the budget of (\d+) steps at .* \((\d+) accepted, (\d+) rejected\)", path.message)
    budget, steps, rejected = map(int, words.groups())
    assert steps == path.summary["steps"]
    assert steps + rejected == budget == 300


@pytest.mark.compiled
def test_a_contact_deeper_than_the_bearing_allows_is_named():
    path = run(**{f"{CONTACT}.stiffness": 1e5}, simulate__revolutions=0.5)
    assert path.status == "ok"
    assert path.message.startswith("too-deep: rod-slider is penetrated by ")
    assert path.summary["rod_slider_penetration_max"] > 0.5e-3


@pytest.mark.compiled
def test_wear_deeper_than_the_clearance_is_named():
    wear = {"joints.rod-slider.wear": WEAR | {"coefficient": 1e-6}}
    path = run(**wear, simulate__revolutions=0.5, simulate__tolerance=1e-6)
    assert path.summary["rod_slider_wear_depth_max"] > 0.5e-3
    assert "worn-through: rod-slider is worn " in path.message
    assert "is the coefficient in mm^2/N?" in path.message


def test_wear_and_pressure_times_speed_beyond_any_bush_are_flagged():
    pin, thousand_hours = Joint("pin", 1e-4, NO_CONTACT, bearing_radius=0.01), 1000.0 * 3600.0
    assert wear_rate_remark([(pin, 0.59 / thousand_hours)]).startswith(
        "worn-away: pin wears by 590 mm in 1000 h, and its bearing radius is 10 mm. "
    )
    assert "mean pV of 12 MPa m/s. Dry bushes allow 1 to 3 MPa m/s" in pv_remark([(pin, 12e6)])
    assert wear_rate_remark([(pin, 0.9 * 0.01 / thousand_hours)]) == pv_remark([(pin, 3e6)]) == ""
    assert pv_remark([(pin._replace(film=Film("short", "short", 0.1, 0.99)), 12e6)]) == ""


@pytest.mark.compiled
def test_the_mean_pressure_times_speed_is_that_of_the_histories():
    changes = {"joints.rod-slider.wear": WEAR | {"coefficient": 1e-12}}
    changes |= {"simulate.revolutions": 0.5, "simulate.discard": 0.0, "simulate.tolerance": 1e-6}
    ready = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    path = clearsweep.simulate(ready, times=np.linspace(0.0, ready.crank_clock.value_after(0.5), 40001))
    joint, force = ready.case.joints[0], path["joints/rod_slider/force_normal"]
    x, y, vx, vy = (path[f"joints/rod_slider/{name}"] for name in ("x", "y", "vx", "vy"))
    distance = (x * vy - y * vx) / np.maximum(np.hypot(x, y), 1e-12)
    slip = distance + (joint.bearing_radius - joint.clearance) * path["rod/rate"]  # the slider does not turn
    speed = np.where(force > 0.0, np.abs(slip), 0.0)
    mean = force.mean() / (2.0 * joint.bearing_radius * joint.length) * speed.mean()
    assert path.summary["rod_slider_pv_mean"] == pytest.approx(mean, rel=0.01)


@pytest.mark.parametrize(
    ("penetration", "clearance", "radius", "text"),
    [
        (0.4e-3, 0.5e-3, 0.01, False),
        (0.6e-3, 0.5e-3, 0.01, True),
        (0.3e-3, 0.5e-3, 0.002, True),  # more than a tenth of the radius
        (0.4e-3, 0.5e-3, None, False),
        (0.6e-3, 0.5e-3, None, True),
        (9e-6, 3e-6, 0.01, False),  # a tight fit under load
        (1.1e-4, 3e-6, 0.01, True),  # the same fit, its bearing strained by a per cent
    ],
)
def test_a_penetration_is_too_deep_where_no_bearing_bears_it(penetration, clearance, radius, text):
    joint = Joint("pair", clearance, NO_CONTACT, bearing_radius=radius)
    assert bool(penetration_remark([(joint, penetration)])) == text


def test_a_residual_is_remarked_upon_where_the_tolerance_does_not_explain_it():
    assert imbalance_remark(9e-8, 1e-9, 1000.0) == ""
    assert "is 1.1e-07, but a tolerance of 1e-09 explains at most 1e-07" in imbalance_remark(1.1e-7, 1e-9, 1000.0)
    assert imbalance_remark(9e-10, 1e-13, 1.0) == ""  # rounding
    assert "explains at most 0.001" in imbalance_remark(1.02e-3, 1e-3, 1.0)  # the tolerance itself
    assert "explains at most 0.001" in imbalance_remark(1.3e-3, 1e-5, 1e6)  # no run is so long


def test_a_run_counts_the_cases_whose_figures_cannot_be_meant_and_names_one():
    messages, nothing = Remarks(["pair"]), {"pair_onset_rate_max": [0.0] * 2, "pair_law_limit_fraction": [0.0] * 2}
    joint = Joint("pair", 0.5e-3, NO_CONTACT, bearing_radius=0.01)
    depths = penetration_remark([(joint, 0.6e-3)]), wear_depth_remark([(joint, 0.7e-3)])
    message = join_remarks("", *depths, imbalance_remark(0.024, 1e-8, 10.0))
    messages.add({"case_id": ["a", "b"], "message": ["", message], **nothing})
    deep, worn, unbalanced = messages.sentences()
    assert "implausibly large in 1 of 2 cases, such as case b: pair is penetrated by 0.6 mm" in deep
    assert "in 1 of 2 cases, such as case b: pair is worn 0.7 mm deep" in worn
    assert "in 1 of 2 cases, such as case b: the energy residual is 0.024" in unbalanced


@pytest.mark.parametrize(("wear", "text"), [({}, True), ({"coefficient": 2e-14}, False), ({"hardness": 1e5}, False)])
def test_a_wear_coefficient_that_no_hardness_checks_is_warned_of(wear, text):
    case = load(slider_crank("rod-slider", changes={"joints.rod-slider.wear": WEAR | wear}), catalogue()).case(0)
    assert any("is it in mm^2/N?" in sentence for sentence in simulation.warnings(case)) == text


def test_histories_that_do_not_fit_are_refused_before_the_run_with_their_size(tmp_path):
    source = grid(1, orbits="all", simulate={"revolutions": 1e9})
    layout = load(source, Fake.catalogue()).layout
    size = 8.0 * (1e9 * 20 * len(layout.channels) + 2**17 * len(layout.sections))  # sections of the last revolutions
    assert largest_history(load(source, Fake.catalogue())) == size
    with pytest.raises(
        clearsweep.InputError, match=re.escape(f"need {size / 1e12:.3g} TB, and twice that during the run")
    ):
        sweep.run_sweep(source, tmp_path / "out", sweep.Options(show_progress=False), Fake)
    assert not (tmp_path / "out").exists()
    check_memory(1e6)
    with pytest.raises(
        clearsweep.InputError, match=r"need 12\.4 MB, and twice that during merging, but only 1 MB of disk"
    ):
        check_disk(1.2437e7, 1e6)
