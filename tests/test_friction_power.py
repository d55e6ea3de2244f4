"""Friction power of joints without clearance and of preload: a column, heat, a remark, a sentence of the report."""

import copy

import numpy as np
import pytest
from mechanism_cases import slider_crank
from test_given_friction import JOINT, STICKS, grid
from test_warm_joint import DRY

import clearsweep
from clearsweep.contracts.layout import Layout
from clearsweep.simulation.running.run import integration_of

HISTORIES = {"save__orbits": "all", "save__samples": 40000}
PRELOADED = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 0.01, "preload": 200.0}


def run(**changes):
    path = clearsweep.simulate(clearsweep.load_case(grid(**changes)))
    assert path.status == "ok", path.message
    return path


def mean(path, power):
    """Return the mean over time of a power at the samples."""
    return np.trapezoid(power, path.t) / (path.t[-1] - path.t[0])


@pytest.mark.few("explicit")
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_brake_takes_its_couple_times_the_rate_of_its_joint(method):
    path = run(**HISTORIES, simulate__method=method)
    rate = path["rocker/rate"]
    expected = mean(path, 3.0 * np.tanh(rate / 0.1) * rate)
    assert expected > 10.0
    assert path.summary["rocker_ground_friction_power"] == pytest.approx(expected, rel=2e-6)
    assert path.units["rocker_ground_friction_power"] == "W"


def test_loads_in_one_joint_are_added_and_each_joint_has_its_own():
    blade = {"law": "tanh", "torque": 3.0, "velocity_scale": 0.1}
    loads = {
        "blade": {"on": "rocker-ground", "friction": blade},
        "seal": {"on": "rocker-ground", "friction": blade | {"torque": 1.0}},
        "pin": {"on": "crank-coupler", "friction": {**blade, "torque": 2.0}},
    }
    path = run(**HISTORIES, loads=loads)
    rate, relative = path["rocker/rate"], path["coupler/rate"] - path["crank/rate"]
    assert path.summary["rocker_ground_friction_power"] == pytest.approx(
        mean(path, 4.0 * np.tanh(rate / 0.1) * rate), rel=2e-6
    )
    assert path.summary["crank_coupler_friction_power"] == pytest.approx(
        mean(path, 2.0 * np.tanh(relative / 0.1) * relative), rel=2e-6
    )


@pytest.mark.few("friction0")
@pytest.mark.parametrize(
    "friction", [{"law": "tanh", "coefficient": 0.1, "radius": 0.01, "velocity_scale": 1e-3}, STICKS]
)
def test_the_power_of_a_reaction_and_of_a_joint_that_sticks_is_that_of_the_ledger(friction):
    source = grid(loads={"blade": {"on": "rocker-ground", "friction": friction}}, simulate__revolutions=0.2)
    scene = clearsweep.load_case(source)
    done = integration_of(scene, np.empty(0), scene.crank_clock.value_after(0.2), in_angles=True)
    outside = done.totals.mechanism.work_gravity  # the work of gravity, of which there is none here, and of loads
    assert done.totals.friction.sum() == pytest.approx(-outside, rel=1e-12)
    assert outside < -0.01


def preloaded(friction):
    joint = JOINT | {"clearance": 5e-5, "friction": copy.deepcopy(friction)}
    return run(**HISTORIES, loads={}, joints={"coupler-rocker": joint})


@pytest.mark.slow
def test_a_preload_is_in_the_friction_power_of_its_joint():
    path = preloaded(PRELOADED)
    radius, slip = 0.01, 0.01 * (path["rocker/rate"] - path["coupler/rate"])
    by_preload = mean(path, 0.1 * 200.0 * np.tanh(slip / 0.01) * slip)
    on_contact = 0.1 * path["joints/coupler_rocker/force_normal"]
    # at the surfaces the journal slides by its radius, and its centre moves
    rough = mean(path, on_contact * np.tanh(slip / 0.01) * slip)
    assert by_preload > 0.5 * rough
    assert radius > 0.0
    power = path.summary["coupler_rocker_friction_power"]
    assert power == pytest.approx(by_preload + rough, rel=0.05)
    assert [name for name in path.summary if name.endswith("friction_power")] == ["coupler_rocker_friction_power"]


@pytest.mark.slow
def test_a_preload_heats_its_joint():
    friction = DRY["joints.rod-slider.friction"]
    changes = copy.deepcopy(DRY) | {"joints.rod-slider.friction": friction | {"preload": 300.0}}
    summary = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes))).summary
    cold = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=copy.deepcopy(DRY)))).summary
    assert summary["rod_slider_friction_power"] > cold["rod_slider_friction_power"] + 5.0
    rise = summary["rod_slider_friction_power"] / 2.0
    assert summary["rod_slider_temperature"] == pytest.approx(303.15 + rise, abs=0.1 + 0.02 * rise)


def test_discarded_revolutions_do_not_count():
    whole, later = (run(simulate__revolutions=0.4, simulate__discard=discard) for discard in (0, 0.2))
    first = run(simulate__revolutions=0.2)
    both = [path.summary["rocker_ground_friction_power"] for path in (first, later)]
    assert whole.summary["rocker_ground_friction_power"] == pytest.approx(np.mean(both), rel=1e-6)
    assert both[0] != pytest.approx(both[1], rel=0.1)


def test_friction_that_would_burn_an_ideal_joint_is_flagged():
    blade = {"law": "tanh", "torque": 30.0, "velocity_scale": 0.1}
    path = run(loads__blade__friction=blade)
    assert path.summary["rocker_ground_friction_power"] > 100.0
    assert "friction-heat: rocker-ground: friction power" in path.message
    assert "friction-heat" not in run().message


def test_friction_of_joints_without_clearance_is_limited_and_reported(tmp_path):
    source = grid(limits={"rocker_ground_friction_power": "50 W"}) | {"name": "brake"}
    source["sweep"] = {"loads.blade.friction.torque": [1.0, 3.0]}
    result = clearsweep.sweep(source, out=tmp_path / "run", executor="serial", show_progress=False)
    assert result.status == "ok" if hasattr(result, "status") else True
    stored = clearsweep.open(tmp_path / "run")
    assert list(stored.summary.sort_values("rocker_ground_friction_power")["limits_exceeded"]) == [
        "",
        "rocker_ground_friction_power",
    ]
    layout = stored.layout
    assert Layout.read(layout.written()) == layout


def test_a_scene_without_such_loads_has_no_column():
    names = run(loads={}).summary
    assert not [name for name in names if "friction_power" in name]
