"""Forces of pins in the fixed frame accelerate the slider as Newton's law says."""

import numpy as np
import pandas as pd
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import report
from clearsweep.language.errors import InputError
from clearsweep.report.data.study import Joint
from clearsweep.report.one_case.pin_forces import pin_forces

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
    assert list(forces) == ["time [s]", "crank_angle [deg]", "rod_slider/fx [N]", "rod_slider/fy [N]"]
    path = clearsweep.simulate(clearsweep.load_case(GRID), times=forces["time [s]"].to_numpy())
    pushed = -forces["rod_slider/fx [N]"]  # on the slider, which has the bearing
    assert pushed.abs().max() > 5.0
    np.testing.assert_allclose(pushed, 0.14 * path["slider/a"], rtol=1e-4, atol=1e-4 * pushed.abs().max())


def test_a_journal_to_the_right_is_pushed_to_the_left_and_rubbed_upwards():
    channels = {"t": [0.0, 1.0], "joints/pin/x": [1e-4, 0.0], "joints/pin/y": [0.0, 0.0]}
    channels |= {"joints/pin/force_normal": [5.0, 0.0], "joints/pin/force_tangential": [2.0, 0.0]}
    forces = pin_forces(channels, (Joint("pin", "pin", wears=False),))
    assert forces.to_numpy().tolist() == [[0.0, -5.0, 2.0], [1.0, 0.0, 0.0]]


def test_a_case_without_pins_in_the_plane_is_refused():
    with pytest.raises(InputError, match="if it has a clearance"):
        pin_forces({"t": [0.0]}, ())
