"""Beyond the range an elastic law is meant for, a run says for how long."""

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import laws

CONTACT = {"law": "hertz", "elastic": "johnson", "material": {"young": 1e6, "poisson": 0.3}}


def test_time_beyond_the_range_of_the_law_is_the_share_of_samples_beyond_it():
    changes = {"joints.rod-slider.contact": CONTACT, "drive.speed": "300 rpm", "simulate.tolerance": 1e-7}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    limit = laws.penetration_limit(scene.case["joints"]["rod-slider"])
    trajectory = clearsweep.simulate(scene, times=np.linspace(0.0, 0.2, 20001))
    assert trajectory.status == "ok"
    depth = np.hypot(trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"]) - 0.5e-3
    assert 0.0 < np.mean(depth > limit) < 1.0
    assert trajectory.summary["rod_slider_law_limit_fraction"] == pytest.approx(np.mean(depth > limit), abs=2e-3)


def test_a_law_without_a_limit_is_never_beyond_it():
    trajectory = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider")))
    assert trajectory.summary["rod_slider_law_limit_fraction"] == 0.0


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_step_that_overflows_is_rejected():
    from clearsweep.kernels.method import error_norm

    rates = np.zeros((16, 4))
    rates[5, 2] = 1e200
    assert error_norm(1.0, rates, np.ones(4)) == np.inf
    rates[5, 2] = np.nan
    assert not error_norm(1.0, rates, np.ones(4)) < 1.0
