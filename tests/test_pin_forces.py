"""Forces of pins in the fixed frame accelerate the slider as Newton's law says."""

import math

import numpy as np
import pandas as pd
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import report
from clearsweep.language.errors import InputError
from clearsweep.report.one_case.joints import pin_forces
from clearsweep.report.study import Joint
from clearsweep.simulation import reactions_unknown
from clearsweep.simulation.analyses import trajectory

GRID = slider_crank(
    "rod-slider",
    changes={
        "drive.speed": "1000 rpm",
        "joints.rod-slider.clearance": "0.1 mm",
        "joints.rod-slider.contact": {"law": "flores", "stiffness": "1e9 N/m^1.5", "restitution": 0.7},
        "joints.rod-slider.friction": {"law": "ambrosio", "coefficient": 0.1, "v0": "1 mm/s", "v1": "10 mm/s"},
        "simulate.revolutions": 0.5,
        "simulate.tolerance": 1e-8,
    },
)


@pytest.mark.heavy
def test_the_force_of_the_pin_accelerates_the_slider(tmp_path):
    run = clearsweep.sweep(GRID, tmp_path / "run", executor="serial", show_progress=False).open()
    case_id = str(run.summary.case_id.iloc[0])
    file = report.show(run, case_id, tmp_path / "forces.csv")
    forces = pd.read_csv(file)
    joints = ("rod_slider", "ground_crank", "crank_rod", "slider_ground")
    named = [f"{joint}/{axis} [N]" for joint in joints for axis in ("fx", "fy")]
    rest = ["slider_ground/couple [N*m]", "drive/torque [N*m]"]
    assert list(forces) == ["time [s]", "crank_angle [deg]", *named, *rest]
    path = clearsweep.simulate(clearsweep.load_case(GRID), times=forces["time [s]"].to_numpy())
    pushed = -forces["rod_slider/fx [N]"]  # on the slider, which has the bearing
    assert pushed.abs().max() > 5.0
    near = {"rtol": 1e-4, "atol": 1e-4 * pushed.abs().max()}
    np.testing.assert_allclose(pushed, 0.14 * path["slider/a"], **near)
    np.testing.assert_allclose(forces["slider_ground/fy [N]"], forces["rod_slider/fy [N]"], **near)  # it moves along x
    torque = forces["drive/torque [N*m]"]  # the engine gets it from virtual work, without any force in a joint
    np.testing.assert_allclose(torque, path["crank/torque"], rtol=1e-4, atol=1e-4 * torque.abs().max())


RUB = {
    "on": "ground-crank",
    "friction": {"law": "tanh", "coefficient": 0.1, "velocity_scale": 0.01, "radius": 0.01},
}
LOADED = {
    "mechanism": {
        "type": "four-bar",
        "ground": {"length": 0.13},
        "crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4},
        "coupler": {"length": 0.12, "mass": 0.21, "inertia": 2.5e-4},
        "rocker": {"length": 0.1, "mass": 0.25, "inertia": 2.2e-4},
        "gravity": 9.81,
    },
    "drive": {"speed": "300 rpm"},
    "loads": {
        "brake": {"on": "rocker", "torque": -1.0},
        "spring": {
            "between": ["ground", "rocker"],
            "anchor": [0.2, 0.1],
            "stiffness": 500.0,
            "free_length": 0.1,
            "damping": 5.0,
        },
    },
    "joints": {
        "coupler-rocker": {
            "clearance": 5e-5,
            "bearing_radius": 0.01,
            "contact": {"law": "flores", "stiffness": 1e9, "restitution": 0.7},
            "friction": {"law": "ambrosio", "coefficient": 0.1, "v0": 1e-3, "v1": 1e-2},
        }
    },
    "simulate": {"revolutions": 0.5, "discard": 0, "tolerance": 1e-8},
}


@pytest.mark.slow
@pytest.mark.heavy
def test_forces_in_ideal_joints_bear_gravity_a_spring_and_friction():
    times = np.linspace(0.01, 0.09, 60)
    plain = trajectory.pin_reactions(clearsweep.load_case(LOADED), times)
    assert set(plain.forces) == {"ground_crank", "crank_coupler", "rocker_ground"}
    torque = plain.trajectory["crank/torque"][::2]
    assert np.abs(torque).max() > 0.5
    np.testing.assert_allclose(plain.torque, torque, rtol=1e-4, atol=1e-4 * np.abs(torque).max())
    rubbed = trajectory.pin_reactions(clearsweep.load_case(LOADED | {"loads": LOADED["loads"] | {"rub": RUB}}), times)
    size = np.hypot(*rubbed.forces["ground_crank"].T)
    assert 1e-3 * size.max() > 1e-3  # N m
    # a pin that turns one way at 0.31 m/s, far above the velocity scale; its couple moves no body
    circle = 0.01 * math.sin(math.atan(0.1))  # m
    np.testing.assert_allclose(rubbed.torque - plain.torque, circle * size, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize(
    ("change", "reason"),
    [({"film": {"law": "short", "viscosity": 0.1}, "length": 0.02}, "not a dry pin"), ({}, "")],
)
def test_it_is_said_why_forces_in_ideal_joints_are_not_known(change, reason):
    joint = LOADED["joints"]["coupler-rocker"]
    joint = {key: value for key, value in joint.items() if not change or key != "friction"} | change
    case = clearsweep.load_case(LOADED | {"joints": {"coupler-rocker": joint}}).case
    assert reason in reactions_unknown(case)
    assert bool(reason) == bool(reactions_unknown(case))


def test_a_journal_to_the_right_is_pushed_to_the_left_and_rubbed_upwards():
    channels = {"t": [0.0, 1.0], "joints/pin/x": [1e-4, 0.0], "joints/pin/y": [0.0, 0.0]}
    channels |= {"joints/pin/force_normal": [5.0, 0.0], "joints/pin/force_tangential": [2.0, 0.0]}
    forces = pin_forces(channels, (Joint("pin", "pin", layout=None),))
    assert np.transpose([*forces.values()]).tolist() == [[0.0, -5.0, 2.0], [1.0, 0.0, 0.0]]


def test_a_case_without_pins_in_the_plane_is_refused():
    with pytest.raises(InputError, match="no planar pin joint of this case has clearance"):
        pin_forces({"t": [0.0]}, ())
