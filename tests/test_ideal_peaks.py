"""The largest reactions without clearance: at the ends of a run, at jumps, between samples."""

import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.simulation.machine.ideal import ideal_motion, ideal_peaks, largest

PLACES = np.linspace(0.0, 6.0, 721)
ROOT = math.sqrt(2.0)


def falls_at_root(x):
    return np.where(x <= ROOT, x, 0.2 * x)


def rises_at_root(x):
    return np.where(x <= ROOT, x, 4.0 - x)


def bump_beside_a_jump(x):
    """Rise within 1e-4 of a jump, as friction does near rest: 1 + 0.3 at the largest."""
    away = (x - ROOT) / 1e-4
    return np.where(x < ROOT, 0.5, 1.0 + 0.3 * away * np.exp(1.0 - np.abs(away)))


@pytest.mark.parametrize(
    ("function", "peak"),
    [
        (np.cos, 1.0),
        (np.exp, math.exp(6.0)),
        (lambda x: np.exp(-x), 1.0),
        (lambda x: 5.0 - (x - 1.2345678) ** 2, 5.0),
        (lambda x: 5.0 - np.abs(x - 1.2345678), 5.0),
        (falls_at_root, 1.2),
        (rises_at_root, 4.0 - ROOT),
        (bump_beside_a_jump, 1.3),
        (lambda x: bump_beside_a_jump(x) + 0.01 * x, 1.3 + 0.01 * (ROOT + 1e-4)),  # no maximum of the samples there
        (lambda x: np.full_like(x, 7.0), 7.0),
        (lambda x: 0.0 * x, 0.0),
    ],
)
def test_the_largest_value_is_found_at_ends_kinks_and_jumps(function, peak):
    peak = max(peak, ROOT) if function is falls_at_root else peak
    (result,) = largest(lambda x: np.array([function(x)]), PLACES)
    assert result == pytest.approx(peak, rel=1e-9, abs=1e-300)


def test_of_several_functions_each_has_its_own_and_one_that_is_undefined_has_none():
    result = largest(lambda x: np.array([np.cos(x - 1.0), np.where(x > 1.0, x, np.nan), falls_at_root(x)]), PLACES)
    assert result[[0, 2]] == pytest.approx([1.0, ROOT], rel=1e-9)
    assert math.isnan(result[1])


# ---------------------------------------------------------------------------------------------- machines

LIGHT = {
    "mechanism.crank": {"length": 0.05, "mass": 2.0, "inertia": 1e-3, "center": 0.03},
    "mechanism.rod": {"length": 0.12, "mass": 1e-9, "inertia": 1e-12, "center": 0.06},
    "mechanism.slider.mass": 1e-9,
}
ABOUT = 1e-3 + 2.0 * 0.03**2  # kg m^2, of the crank about its pivot


GAS = {"crank_angle [deg]": [0, 90, 360], "fx": [0, -900, 0]}


def peaks_of(changes):
    return ideal_peaks(clearsweep.load_case(slider_crank("rod-slider", changes=changes)).case)


@pytest.mark.parametrize("discard", [0, 0.5])
def test_a_crank_that_slows_down_has_its_largest_reaction_where_the_window_begins(discard):
    """M r sqrt(speed^4 + (torque / inertia)^2), the square of the speed falling evenly over the angle."""
    drive = {"torque": -3.0, "initial_speed": 200.0}
    result = peaks_of(LIGHT | {"drive": drive, "simulate.revolutions": 2, "simulate.discard": discard})
    slowing = 3.0 / ABOUT
    square = 200.0**2 - 2.0 * slowing * 2.0 * math.pi * discard
    assert result["ground-crank"] == pytest.approx(2.0 * 0.03 * math.hypot(square, slowing), rel=1e-6)


@pytest.mark.parametrize(("speeds", "turns"), [([200.0, 150.0], 0.0), ([150.0, 200.0], 1.25)])
def test_a_crank_whose_speed_is_a_table_has_its_largest_reaction_at_one_end(speeds, turns):
    """At the beginning or, faster by then, at the end of the window."""
    table = {"time": [0.0, 0.1], "speed": speeds}
    changes = {"drive": {"speed": {"table": table}}, "simulate.revolutions": 1.25, "simulate.discard": 0}
    alpha = (speeds[1] - speeds[0]) / 0.1
    square = speeds[0] ** 2 + 2.0 * alpha * 2.0 * math.pi * turns
    assert peaks_of(LIGHT | changes)["ground-crank"] == pytest.approx(0.06 * math.hypot(square, alpha), rel=1e-6)


def closely(case, count):
    """Return the largest reactions of a case at many angles of a turn, then three times about the largest of each."""
    turn = np.linspace(0.0, 2.0 * math.pi, count)
    result = {}
    for joint, force in ideal_motion(case, turn).reactions.items():
        about, size = turn, np.hypot(*force.T)
        for _ in range(3):
            width = 2.0 * (about[1] - about[0])
            about = about[np.argmax(size)] + np.linspace(-width, width, 2001)
            size = np.hypot(*ideal_motion(case, about).reactions[joint].T)
        result[joint] = size.max()
    return result


@pytest.mark.few("ambrosio")
@pytest.mark.parametrize("law", ["tanh", "ambrosio"])
def test_friction_that_reverses_leaves_the_largest_reaction_where_it_jumps(law):
    """The slider turns round where its inertia is largest, under 5 kN across."""
    smooth = {"tanh": {"velocity_scale": 1e-5}, "ambrosio": {"v0": 1e-6, "v1": 1e-5}}[law]
    rub = {"on": "slider-ground", "friction": {"law": law, "coefficient": 0.1, **smooth}}
    loads = {"rub": rub, "press": {"on": "slider", "force": [0.0, -5e3]}}
    case = clearsweep.load_case(slider_crank("rod-slider", changes={"loads": loads})).case
    result, known = ideal_peaks(case), closely(case, 8001)
    for joint, value in known.items():
        assert result[joint] == pytest.approx(value, rel=1e-6), joint


@pytest.mark.parametrize("loads", [{}, {"gas": {"on": "slider", "table": GAS}}], ids=["free", "gas"])
def test_peaks_of_smooth_machines_are_those_of_many_more_angles(loads):
    case = clearsweep.load_case(slider_crank("rod-slider", changes={"loads": loads} if loads else {})).case
    known = closely(case, 2001)
    for joint, value in ideal_peaks(case).items():
        assert value == pytest.approx(known[joint], rel=1e-8)


def test_a_force_between_two_samples_is_looked_at_where_its_table_has_a_row():
    """A spike of 0.02 degrees, a fortieth of the distance of samples."""
    knots = [0.0, 77.10, 77.11, 77.12, 360.0]
    spike = {"on": "slider", "table": {"crank_angle [deg]": knots, "fx": [0, 0, -1e6, 0, 0]}}
    along_the_rod = 1e6 / math.sqrt(1.0 - (0.05 * math.sin(math.radians(77.11)) / 0.12) ** 2)
    result = peaks_of({"loads": {"spike": spike}, "drive.speed": "300 rpm"})
    assert result["rod-slider"] == pytest.approx(along_the_rod, rel=1e-3)
