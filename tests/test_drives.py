"""Drives that turn back and runs over time: against closed forms, mirrored machines and other forms of one drive."""

import copy
import math

import numpy as np
import pytest
from right_grids import grid_of
from scipy.integrate import solve_ivp

import clearsweep
from clearsweep.contracts import case
from clearsweep.contracts.catalogue import Outline
from clearsweep.language.errors import InputError
from clearsweep.mechanics.machines.drives import make_drive
from clearsweep.simulation.remarks import warnings

MACHINE = grid_of("a crank that a servo turns")
#: The same without a weight that a flywheel of 1 kg m^2 would feel.
LIGHT = {
    "type": "slider-crank",
    "crank": {"length": "50 mm", "mass": "0 kg", "inertia": "0 kg*m^2"},
    "rod": {"length": "120 mm", "mass": "1e-6 kg", "inertia": "1e-9 kg*m^2"},
    "slider": {"mass": "1e-6 kg"},
}
FLYWHEEL = {"inertia": "1 kg*m^2"}


def run(times=None, **sections):
    grid = copy.deepcopy(MACHINE) | sections
    return clearsweep.simulate(clearsweep.load_case(grid), times=times)


def run_light(times, drive, **simulate):
    return run(times, mechanism=LIGHT, drive=drive | FLYWHEEL, simulate={"time": f"{times[-1]} s"} | simulate)


def test_a_clockwise_crank_is_the_mirror_image_of_the_other():
    times = np.linspace(0.0, 4.0 * math.pi / 100.0, 60)
    forth, back = run(times), run(times, drive={"speed": "-100 rad/s"})
    assert back.status == "ok"
    assert back["slider/x"] == pytest.approx(forth["slider/x"], abs=1e-9)
    for channel in ("crank_angle", "crank/torque", "rod/y", "rod/angle"):
        assert back[channel] == pytest.approx(-forth[channel], abs=1e-6 * np.abs(forth[channel]).max())
    for figure in ("rod_slider_force_peak", "rod_slider_force_peak_ideal", "slider_error_max"):
        assert back.summary[figure] == pytest.approx(forth.summary[figure], rel=1e-6)


def test_a_clockwise_speed_table_ends_after_its_revolutions():
    table = {"time [s]": [0, 0.1, 1], "speed [rad/s]": [0, -100, -100]}
    back = run(drive={"speed": {"table": table}})
    forth = run(drive={"speed": {"table": table | {"speed [rad/s]": [0, 100, 100]}}})
    assert back["crank_angle"][[0, -1]] == pytest.approx([0.0, -4.0 * math.pi], abs=1e-9)
    assert back.summary["rod_slider_force_peak_ideal"] == pytest.approx(forth.summary["rod_slider_force_peak_ideal"])


def test_an_angle_table_of_constant_rate_is_a_constant_speed():
    period = 2.0 * math.pi / 100.0
    table = {"time [s]": [0.0, 0.4 * period, period], "angle [rad]": [0.0, 0.8 * math.pi, 2.0 * math.pi]}
    times = np.linspace(0.0, 2.0 * period, 60)
    steady, given = run(times), run(times, drive={"angle": table})
    assert given["slider/x"] == pytest.approx(steady["slider/x"], abs=1e-9)
    in_cycles = run(times, drive={"angle": table}, simulate={"cycles": 2, "period": f"{period!r} s", "discard": 0})
    for figure in ("rod_slider_force_peak", "rod_slider_force_peak_ideal", "rod_slider_impacts_per_rev"):
        assert in_cycles.summary[figure] == pytest.approx(steady.summary[figure], rel=1e-6)


def test_an_angle_table_bends_as_a_natural_cubic_spline():
    table = {"time [s]": [0, 0.1, 0.2, 0.3], "angle [rad]": [0.2, 0.5, 0.1, 0.2]}
    times = np.linspace(0.0, 0.3, 31)
    path = run(times, drive={"angle": {"table": table}}, simulate={"time": "0.3 s"})
    # inner moments of the spline: 4 m1 + m2 = 6 (0.1 - 2 x 0.5 + 0.2) / h^2, m1 + 4 m2 = 6 (0.2 - 2 x 0.1 + 0.5) / h^2
    first, second = np.linalg.solve([[4.0, 1.0], [1.0, 4.0]], [6.0 * -0.7 / 0.01, 6.0 * 0.5 / 0.01])
    moments = np.interp(times, [0.0, 0.1, 0.2, 0.3], [0.0, first, second, 0.0])
    assert path["crank_angle"][::10] == pytest.approx([0.2, 0.5, 0.1, 0.2], abs=1e-12)
    start_rate = 3.0 - 0.1 * first / 6.0
    rate = start_rate + np.concatenate([[0.0], np.cumsum(0.5 * np.diff(times) * (moments[1:] + moments[:-1]))])
    assert path["crank/rate"] == pytest.approx(rate, abs=1e-9)


def test_the_energy_of_a_reversing_drive_is_balanced():
    table = {"time [s]": [0, 0.1, 0.3, 0.4], "speed [rpm]": [0, 300, -300, 0]}
    path = run(drive={"speed": {"table": table}, "start_angle": "40 deg"}, simulate={"time": "0.4 s", "discard": 0})
    assert path.status == "ok"
    assert path["crank_angle"][-1] == pytest.approx(math.radians(40.0), abs=1e-12)
    assert path.summary["rod_slider_impacts_per_rev"] > 0
    assert abs(path.summary["energy_residual"]) < 1e-6


def test_the_window_of_a_run_over_time_begins_after_its_discard():
    table = {"time [s]": [0, 0.1, 0.2], "speed [rpm]": [0, 300, 0]}
    drive = {"speed": {"table": table}}
    whole, late = (run(drive=drive, simulate={"time": "0.4 s", "discard": d}) for d in ("0 s", "0.25 s"))
    assert whole["t"][[0, -1]] == pytest.approx([0.0, 0.4])
    assert len(whole["t"]) == 721
    assert late["t"][-1] == pytest.approx(0.4)
    assert late.summary["rod_slider_force_peak_ideal"] == pytest.approx(0.0, abs=1e-9)
    assert whole.summary["rod_slider_force_peak_ideal"] > 1.0


@pytest.mark.slow  # a form of its own
def test_a_servo_moves_an_inertia_as_a_damped_oscillator():
    times = np.linspace(0.0, 1.0, 21)
    servo = {
        "target": {"time [s]": [0, 1], "angle [rad]": [0.5, 0.5]},
        "stiffness": "100 N*m/rad",
        "damping": "4 N*m*s/rad",
    }
    path = run_light(times, {"servo": servo})
    decay, frequency = 2.0, math.sqrt(96.0)
    wave = np.cos(frequency * times) + decay / frequency * np.sin(frequency * times)
    assert path.status == "ok"
    assert path["crank_angle"] == pytest.approx(0.5 - 0.5 * np.exp(-decay * times) * wave, abs=1e-6)


@pytest.mark.slow  # a form of its own
def test_a_servo_at_its_limit_gives_a_constant_torque_both_ways():
    times = np.linspace(0.0, 0.9, 10)
    target = {"time [s]": [0, 1], "angle [rad]": [0.5, 0.5]}
    servo = {"target": target, "stiffness": "100 N*m/rad", "damping": "0 N*m*s/rad", "torque_limit": "1 N*m"}
    for side in (1.0, -1.0):
        aimed = servo | {"target": target | {"angle [rad]": [0.5 * side, 0.5 * side]}}
        assert run_light(times, {"servo": aimed})["crank_angle"] == pytest.approx(0.5 * side * times**2, abs=1e-6)


#: A step of the target by half a radian, for a servo with an integral part.
STEP = {"time [s]": [0, 1], "angle [rad]": [0.5, 0.5]}
REGULATED = {"target": STEP, "stiffness": 100.0, "damping": 8.0, "integral": 400.0}


@pytest.mark.slow  # a form of its own
def test_a_servo_with_an_integral_moves_an_inertia_as_its_three_roots_say():
    times = np.linspace(0.0, 1.0, 21)
    roots = np.roots([1.0, 8.0, 100.0, 400.0])  # the error and its first derivatives begin at 0.5, 0, -100 x 0.5
    shares = np.linalg.solve(np.vander(roots, 3, increasing=True).T, [0.5, 0.0, -50.0])
    error = np.real(np.exp(np.outer(times, roots)) @ shares)
    path = run_light(times, {"servo": REGULATED})
    assert path.status == "ok"
    assert path["crank_angle"] == pytest.approx(0.5 - error, abs=1e-6)
    assert path.summary["slider_error_max"] < 2e-4  # the ideal machine has the same servo


def wound_up(times, side, limit, tracking_time):
    """Return the angles (rad) of 1 kg m^2 under the REGULATED servo, solved from one reach of the limit to the next."""
    stiffness, damping, gain = (REGULATED[key] for key in ("stiffness", "damping", "integral"))
    time, state, at_limit, angles = 0.0, [0.0, 0.0, 0.0], side, np.empty(0)

    def demand(_, y):
        return stiffness * (0.5 * side - y[0]) - damping * y[1] + y[2]

    while time < times[-1]:

        def rates(t, y, at_limit=at_limit):
            torque = at_limit * limit if at_limit else demand(t, y)
            return [y[1], torque, gain * (0.5 * side - y[0]) + (torque - demand(t, y)) / tracking_time]

        borders = []
        for sign in (at_limit,) if at_limit else (1.0, -1.0):

            def border(t, y, sign=sign):
                return sign * demand(t, y) - limit

            border.terminal, border.direction = True, -1 if at_limit else 1
            borders.append(border)
        accuracy = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "max_step": 0.02}
        piece = solve_ivp(rates, (time, times[-1]), state, events=borders, dense_output=True, **accuracy)
        angles = np.append(angles, piece.sol(times[(times >= time) & (times <= piece.t[-1])])[0])
        time, state = piece.t[-1], piece.y[:, -1]
        at_limit = 0.0 if at_limit else math.copysign(1.0, demand(time, state))
    return angles


@pytest.mark.slow  # a form of its own
@pytest.mark.parametrize(("given", "tracking_time"), [({}, math.sqrt(8.0 / 400.0)), ({"tracking_time": 1e3}, 1e3)])
def test_a_servo_at_its_limit_winds_up_as_a_second_program_says(given, tracking_time):
    times = np.linspace(0.0, 2.0, 41)
    for side in (1.0, -1.0):
        target = STEP | {"angle [rad]": [0.5 * side, 0.5 * side]}
        path = run_light(times, {"servo": REGULATED | given | {"target": target, "torque_limit": 6.0}})
        assert path["crank_angle"] == pytest.approx(wound_up(times, side, 6.0, tracking_time), abs=1e-6)


def test_the_integral_gives_way_in_the_time_that_the_rule_says():
    servo = {key: REGULATED[key] for key in ("stiffness", "damping", "integral")}
    table = {"time": [0.0, 1.0], "angle": [0.5, 0.5]}

    def tracking_time(**values):
        drive = case.Drive(table=table, values=servo | values)
        return make_drive(drive, Outline(drive="servo")).servo.tracking_time

    assert tracking_time() == pytest.approx(math.sqrt(8.0 / 400.0), rel=1e-15)
    assert tracking_time(damping=0.0) == pytest.approx(100.0 / 400.0, rel=1e-15)
    assert tracking_time(tracking_time=0.3) == 0.3


def test_a_target_beyond_the_limit_of_its_servo_is_told():
    """A flywheel of 1 kg m^2 follows sin(2 pi t) / 2: up to 2 pi^2 = 19.74 N m."""
    times = np.linspace(0.0, 1.0, 201)
    target = {"time [s]": times.tolist(), "angle [rad]": (0.5 * np.sin(2.0 * math.pi * times)).tolist()}
    for limit, words in ((19.0, ["up to 19.7", "limit is 19 N*m"]), (20.0, [])):
        drive = {"servo": REGULATED | {"target": target, "torque_limit": limit}, **FLYWHEEL}
        sections = {"mechanism": LIGHT, "drive": drive, "simulate": {"time": "1 s", "discard": 0}}
        sentences = [text for text in warnings(clearsweep.load_case(MACHINE | sections).case) if "servo" in text]
        assert len(sentences) == bool(words)
        assert all(word in sentences[0] for word in words)


@pytest.mark.slow  # a form of its own
def test_a_motor_table_of_two_rows_is_the_straight_characteristic():
    times = np.linspace(0.0, 2.0, 21)
    table = {"speed [rad/s]": [0, 10], "torque [N*m]": [5, 0]}
    path = run_light(times, {"motor": {"table": table}})
    assert path["crank/rate"] == pytest.approx(10.0 * (1.0 - np.exp(-0.5 * times)), abs=1e-5)


@pytest.mark.slow  # a form of its own
def test_the_torque_of_a_motor_table_is_constant_outside_its_rows():
    times = np.linspace(0.0, 1.0, 11)
    table = {"speed [rad/s]": [5, 10], "torque [N*m]": [3, 1]}
    path = run_light(times, {"motor": {"table": table}})
    assert path["crank/rate"] == pytest.approx(3.0 * times, abs=1e-6)


@pytest.mark.slow  # a form of its own
def test_a_crank_that_swings_as_a_pendulum_is_no_failed_case():
    heavy = MACHINE["mechanism"] | {"gravity": "9.81 m/s^2"}
    drive = {"torque": "0 N*m", "start_angle": "-60 deg", "inertia": "0.01 kg*m^2"}
    path = run(mechanism=heavy, drive=drive, simulate={"time": "2 s"})
    assert path.status == "ok"
    assert path.summary["crank_speed_min"] < 0.0 < path.summary["crank_speed_max"]
    assert abs(path.summary["energy_residual"]) < 1e-6


#: No link of this linkage turns fully except its coupler.
DOUBLE_ROCKER = {
    "type": "four-bar",
    "ground": {"length": "130 mm"},
    "crank": {"length": "100 mm", "mass": "1 kg", "inertia": "1e-3 kg*m^2"},
    "coupler": {"length": "60 mm", "mass": "0.5 kg", "inertia": "2e-4 kg*m^2"},
    "rocker": {"length": "110 mm", "mass": "1 kg", "inertia": "1e-3 kg*m^2"},
}
PARALLELOGRAM = DOUBLE_ROCKER | {
    "ground": {"length": "400 mm"},
    "coupler": {"length": "400 mm", "mass": "2 kg", "inertia": "2e-2 kg*m^2"},
    "rocker": {"length": "100 mm", "mass": "1 kg", "inertia": "1e-3 kg*m^2"},
}
OPEN = {"coupler-rocker": MACHINE["joints"]["rod-slider"]}


def swung(low, high):
    """Return the sections of a double rocker that swings between two crank angles (deg)."""
    table = {"time [s]": [0, 0.5, 1], "angle [deg]": [low, high, low]}
    return {"mechanism": DOUBLE_ROCKER, "joints": OPEN, "drive": {"angle": table}, "simulate": {"time": "1 s"}}


@pytest.mark.slow  # a form of its own
def test_a_double_rocker_runs_between_the_angles_that_it_reaches():
    path = run(**swung(50, 90))
    crank, rocker = path["crank_angle"], path["rocker/angle"]
    pin_x, pin_y = 0.13 + 0.11 * np.cos(rocker) - 0.1 * np.cos(crank), 0.11 * np.sin(rocker) - 0.1 * np.sin(crank)
    assert np.hypot(pin_x, pin_y) == pytest.approx(0.06, abs=3e-4)  # the clearance is 0.1 mm
    assert 0.0 < path.summary["rocker_error_max"] < 5e-3
    assert path.summary["coupler_rocker_force_peak_ideal"] > 1.0


def test_a_double_rocker_is_refused_where_it_stops():
    reach = math.acos((0.13**2 + 0.1**2 - 0.17**2) / (2.0 * 0.13 * 0.1))  # coupler and rocker in one line
    with pytest.raises(InputError, match=f"crank angle {math.degrees(reach):.2g}") as raised:
        clearsweep.load_case(copy.deepcopy(MACHINE) | swung(50, math.degrees(reach) + 0.2))
    assert "do not let the crank turn on" in str(raised.value)
    clearsweep.load_case(copy.deepcopy(MACHINE) | swung(50, math.degrees(reach) - 0.2))


@pytest.mark.slow  # a form of its own
@pytest.mark.parametrize("speed", ["120 rpm", "-120 rpm"])
def test_a_parallelogram_away_from_its_change_point_is_compared(speed):
    drive = {"speed": speed, "start_angle": "60 deg"}
    path = run(mechanism=PARALLELOGRAM, joints=OPEN, drive=drive, simulate={"revolutions": 0.1, "discard": 0})
    assert path.status == "ok"
    assert path.summary["coupler_rocker_force_peak_ideal"] > 1.0
    assert path["rocker/angle"] == pytest.approx(path["crank_angle"], abs=5e-3)


@pytest.mark.slow  # a form of its own
def test_a_parallelogram_may_start_at_its_change_point_with_an_open_pin():
    path = run(mechanism=PARALLELOGRAM, joints=OPEN, simulate={"revolutions": 0.1, "discard": 0})
    assert path.status == "ok"
    assert path["rocker/angle"] == pytest.approx(path["crank_angle"], abs=5e-2)


@pytest.mark.slow  # a form of its own
def test_gravity_of_two_components_is_that_of_a_turned_machine():
    """A massive crank on a vertical plane, whose weight points along x: a pendulum turned by a right angle."""
    times = np.linspace(0.0, 0.5, 11)
    drive = {"torque": "0 N*m", "inertia": "1e-3 kg*m^2"}
    heavy = LIGHT | {"crank": {"length": "50 mm", "mass": "1 kg", "inertia": "1e-4 kg*m^2"}}

    def angle(gravity, start):
        sections = {"mechanism": heavy | {"gravity": gravity}, "drive": drive | {"start_angle": start}}
        return run(times, simulate={"time": "0.5 s"}, **sections)["crank_angle"]

    down, sideways = angle("9.81 m/s^2", "-60 deg"), angle(["9.81 m/s^2", "0 m/s^2"], "30 deg")
    assert np.ptp(down) > 0.5
    assert sideways == pytest.approx(down + 0.5 * math.pi, abs=1e-4)
    assert angle(["0 m/s^2", "-9.81 m/s^2"], "-60 deg") == pytest.approx(down, abs=1e-12)
