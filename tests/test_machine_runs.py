"""Motions of machines that a grid describes, against trajectories in quadruple precision that share nothing with them.

`verify/references/machines.json` says how they were made: absolute coordinates with multipliers, where our equations
have neither.  A four-bar, a loaded slider-crank, a free crank under a torque, a V-twin, each with a clearance joint; a
slider-crank with a film in it, and with a dry joint behind the film.
"""

import copy
import json
import math
import re
from importlib import resources

import numpy as np
import pandas as pd
import pytest
from mechanism_cases import slider_crank
from random_machines import random_machine
from right_grids import grid_of
from scipy.integrate import solve_ivp

import clearsweep
from clearsweep import report
from clearsweep.language.errors import InputError
from clearsweep.mechanics.solver import integration
from clearsweep.report.one_case.joints import pin_forces
from clearsweep.report.study import Joint
from clearsweep.simulation import reactions_unknown
from clearsweep.simulation.analyses import trajectory
from clearsweep.simulation.machine.ideal import ideal_motion, ideal_peaks, largest
from clearsweep.simulation.running.run import Run
from clearsweep.simulation.setup.start import control_of, start_of

HELD = json.loads((resources.files("clearsweep.verify") / "references" / "machines.json").read_text(encoding="utf-8"))
PROBLEMS = HELD["problems"]
STILL = 1e-9  # of a channel's own size: below it is nothing, as in `slider/y`


def run(name, **settings):
    source = copy.deepcopy(PROBLEMS[name]["grid"])
    source["simulate"] |= settings
    times = np.array(PROBLEMS[name]["samples"]["t"])
    return clearsweep.simulate(clearsweep.load_case(source), times=times), times


@pytest.mark.slow  # four compiled forms
@pytest.mark.parametrize("name", PROBLEMS)
def test_a_machine_moves_as_in_quadruple_precision(name):
    path, times = run(name)
    assert path.status == "ok"
    fair = times <= PROBLEMS[name]["fair"]
    for channel, values in PROBLEMS[name]["samples"].items():
        truth = np.array(values)
        size = max(float(np.max(np.abs(truth))), STILL)
        assert np.max(np.abs(path[channel] - truth)[fair]) <= 1e-6 * size, channel
    assert path.summary["energy_residual"] < 1e3 * 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
def test_its_contacts_are_those_of_quadruple_precision(name):
    path, times = run(name)
    truth = PROBLEMS[name]["events"]
    assert [(e["joint"], e["kind"]) for e in path.events] == [(joint, kind) for _, joint, kind, _, _ in truth]
    moments = np.array([row[0] for row in truth])
    assert np.max(np.abs(path.events["t"] - moments), initial=0.0) <= 1e-9 * times[-1]  # a film may bear for ever
    peaks = np.array([row[4] for row in truth])
    assert path.events["force_peak"] == pytest.approx(peaks, rel=1e-6, abs=1e-6)


@pytest.mark.slow
def test_a_free_crank_ends_at_its_revolution_and_is_sampled_at_equal_angles():
    source = copy.deepcopy(PROBLEMS["sc_torque"]["grid"])
    source["simulate"] |= {"tolerance": 1e-8}
    source["save"] = {"orbits": "all", "samples": 36}
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path["crank_angle"] == pytest.approx(2.0 * np.pi * np.arange(37) / 36, rel=1e-12, abs=1e-12)
    last = {channel: values[-1] for channel, values in PROBLEMS["sc_torque"]["samples"].items()}
    end = last["t"] + (2.0 * np.pi - last["crank/angle"]) / last["crank/rate"]  # microseconds later
    assert path.t[-1] == pytest.approx(end, rel=1e-7, abs=0.0)
    assert path.summary["crank_speed_min"] < path["crank/rate"].min() + 1e-6
    assert path.summary["crank_speed_max"] > path["crank/rate"].max() - 1e-6


def too_weak():
    """Return the grid of a crank that does not get through."""
    source = copy.deepcopy(PROBLEMS["sc_torque"]["grid"])
    source["simulate"] |= {"tolerance": 1e-6}
    source["drive"] = {"torque": 0.5, "initial_speed": "100 rpm"}
    source["loads"] = {"press": {"on": "slider", "force": ["400 N", 0]}}
    return source


@pytest.mark.slow
def test_a_crank_stalls_where_it_stalls_however_often_the_run_pauses():
    scene = clearsweep.load_case(too_weak())
    control, ends = control_of(scene, scene.crank_clock.value_after(1.0), keep_events=False), []
    for pause_steps in (control.pause_steps, 10):
        run = Run(start_of(scene, np.empty(0)))
        status, _ = run.advance(control._replace(pause_steps=pause_steps))
        ends.append((status, *run.work.end))
    assert ends[0][0] == integration.STALLED
    assert ends[1] == ends[0]


def test_a_motor_whose_torque_is_negative_says_that_it_turns_backwards():
    source = too_weak() | {"drive": {"torque": "-1 N*m"}}
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "stalled"
    assert "the torque of the drive is negative and turns the crank backwards" in path.message


@pytest.mark.slow
def test_a_crank_that_gets_stuck_ends_stalled_and_a_slow_one_at_its_limit():
    source = too_weak()
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "stalled"
    assert "the crank stops" in path.message
    del source["loads"]
    source["simulate"]["time_limit"] = "1 ms"
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "time-limit"
    assert "increase simulate.time_limit" in path.message


def pendulum():
    """A crank on an ideal pin that swings, and a body in a ring."""
    return grid_of("a crank that swings")


def test_a_machine_at_rest_is_measured_over_time_but_never_turns():
    source = pendulum()
    source["mechanism"]["gravity"], source["drive"]["initial_speed"] = 0.0, 0.0
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "time-limit"
    assert "the crank does not turn" in path.message
    assert "simulate: {time: 5 s}" in path.message
    slow = source | {"drive": {"torque": 1.0, "initial_speed": 0.0}, "simulate": {"revolutions": 1, "time_limit": 1e-4}}
    assert "increase simulate.time_limit" in clearsweep.simulate(clearsweep.load_case(slow)).message
    path = clearsweep.simulate(clearsweep.load_case(source | {"simulate": {"time": 1.0}}))
    assert path.status == "ok"
    assert path.summary["energy_residual"] == path.summary["output_error_max"] == path.summary["rest_force_peak"] == 0.0


def test_a_free_crank_that_turns_back_keeps_its_history():
    """A pendulum on an ideal pin rises until it turns back; the run ends a hundredth of a turn later."""
    source = pendulum()

    def swing(_, state):
        return [state[1], -2.0 * 9.81 * 0.5 * np.cos(state[0]) / (0.1 + 2.0 * 0.25)]

    scene, times = clearsweep.load_case(source), np.linspace(0.0, 0.6, 61)
    path = clearsweep.simulate(scene, times=times)
    assert path.status == "stalled"
    exact = solve_ivp(swing, (0.0, 0.6), [0.0, 3.0], "DOP853", times, rtol=1e-11, atol=1e-13).y[0]
    assert len(path.t) > 10
    assert np.max(path["crank_angle"]) - path["crank_angle"][-1] > 0.03  # rad: it is on its way back
    assert path["crank_angle"] == pytest.approx(exact[: len(path.t)], abs=1e-8)
    by_angle = clearsweep.simulate(scene)
    assert by_angle["crank_angle"] == pytest.approx(2.0 * np.pi / 720 * np.arange(len(by_angle.t)), abs=1e-9)


@pytest.mark.slow
def test_times_beyond_the_end_of_a_free_crank_are_reported():
    scene = clearsweep.load_case(PROBLEMS["sc_torque"]["grid"] | {"simulate": {"revolutions": 0.1, "discard": 0}})
    with pytest.raises(InputError, match="times: found"):
        clearsweep.simulate(scene, times=[0.0, 1.0])


# Forces of pins in the fixed frame accelerate the slider as Newton's law says.


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
LOADED = grid_of("a slider-crank under loads")


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


# ---------------------------------------------------------------------------------------------- peaks of ideal machines


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


# ---------------------------------------------------------------------------------------------- random machines


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("seed", range(12))
def test_a_random_machine_ends_well_or_says_why(seed):
    try:
        path = clearsweep.simulate(clearsweep.load_case(random_machine(seed)))
    except clearsweep.InputError as error:
        refusal = str(error)
    else:
        refusal = ""
    if refusal:
        assert re.search("closed|singular|turn on|without mass|was fitted|requires|cannot be seated", refusal), refusal
        return
    assert (path.status == "ok") or path.message
    numbers = {key: value for key, value in path.summary.items() if isinstance(value, int | float)}
    assert {key: value for key, value in numbers.items() if not math.isfinite(value)} == {}
