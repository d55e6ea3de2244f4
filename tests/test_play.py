"""Play in rotation: gears and couplings against closed solutions, and what grids may say about them."""

import json
import math
import time
from pathlib import Path

import numpy as np
import pytest
from mechanism_cases import changed
from right_grids import grid_of
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import clearsweep
from clearsweep import grid, laws
from clearsweep.grid.keys.joint_keys import laws_of_point_contacts
from clearsweep.language.errors import InputError
from clearsweep.report.blocks.section import painted
from clearsweep.report.one_case.motion import motion_pictures, onset_pictures
from clearsweep.report.study import prepare
from clearsweep.simulation.machine.ideal import size_warnings
from clearsweep.simulation.setup import scene
from clearsweep.verify import check
from clearsweep.verify.stability import acceleration_at_stops, reduced_mass

TRUTH = json.loads(Path(__file__).with_name("one_sided_play.json").read_text())
INPUT, PAIR = TRUTH["input"], TRUTH["gear_pair"]
PERIOD = 2.0 * math.pi / INPUT["W_rad_s"]
SPEED = INPUT["W0_rad_s"]
ORIGIN = [0.0, 0.0]
TURNS = [0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi, 2.0 * math.pi]
PUMP = {"on": "wheel", "table": {"crank_angle": TURNS, "torque": [0.5, 2.0, 0.5, -1.5, 0.5]}}


def wheels(joint, play, ratio=1.0, sense=1.0, **changes):
    """Return two wheels on the ground, the first driven at a speed that would turn the second at SPEED."""
    given = {
        "mechanism.bodies.wheel.initial": {"angle": -sense * INPUT["delta0_rad"], "rate": sense * SPEED},
        "mechanism.joints.mesh": {"between": ["pinion", "wheel"], **joint},
        "drive.speed": ratio * SPEED,
        "joints.mesh": {"drag": INPUT["drag_relative_N_m_s_per_rad"], **play},
        "simulate.revolutions": 40.0 * PERIOD * ratio * SPEED / (2.0 * math.pi),
    }
    return changed(changed(grid_of("two wheels with play"), given), changes)


def coupling(**changes):
    """Return two wheels with a coupling between them."""
    contact = {"law": "kelvin-voigt", "stiffness": INPUT["stiffness_N_m_per_rad"], "damping": 0.0}
    play = {"play": 2.0 * INPUT["half_play_rad"], "contact": contact}
    return wheels({"type": "coupling"}, play, **changes)


def gear(**changes):
    """Return two wheels in mesh, the pair that is equivalent to the coupling."""
    ratio = PAIR["r2_m"] / PAIR["r1_m"]
    stiffness = PAIR["contact_stiffness_along_line_of_action_N_m"]
    contact = {"law": "kelvin-voigt", "stiffness": stiffness, "damping": 0.0}
    joint = {"type": "gear", "ratio": ratio, "radius": PAIR["r1_m"], "pressure_angle": "20 deg"}
    play = {"backlash": PAIR["backlash_circumferential_m"], "contact": contact}
    return wheels(joint, play, ratio, -1.0, **changes)


def shaken(tree, sense, given=INPUT):
    """Return the scene of a grid whose second wheel is loaded, and shaken as if the drive were.

    In a frame that turns with the first wheel the uneven drive is the torque J2 theta1'' on the second.
    """
    with laws.collecting() as records:

        @laws.load("shaking", mean="N*m", amplitude="N*m", rate="rad/s")
        def shaking(t, angle, position, velocity, p):
            return 0.0, 0.0, p.mean + p.amplitude * math.sin(p.rate * t)

    amplitude = given["inertia_kg_m2"] * given["A_rad_s"] * given["W_rad_s"]
    sizes = {"mean": -sense * given["load_torque_N_m"], "amplitude": sense * amplitude, "rate": given["W_rad_s"]}
    tree["loads"] = {"shake": {"on": "wheel", "law": "shaking", **sizes}}
    digest = "play" if sense > 0.0 else "gear"
    return scene.build(grid.load(tree, scene.catalogue().with_laws(records, digest)).case(0))


@pytest.mark.few("gear--1.0")
@pytest.mark.parametrize(("tree", "sense"), [(coupling, 1.0), (gear, -1.0)])
def test_one_sided_impacts_begin_and_end_when_the_closed_solution_says(tree, sense):
    built = shaken(tree(), sense)
    result = clearsweep.simulate(built, TRUTH["state_times_s"])
    events = result.events
    assert events["kind"].tolist() == TRUTH["kinds"]
    assert set(events["joint"].tolist()) == {"mesh_drive"}
    assert np.max(np.abs(events["t"] - TRUTH["times_s"])) < 1e-9 * PERIOD
    arm = abs(built.value.joints[0].arm_distal)  # of the position along the line of action
    assert events["rate"] / arm == pytest.approx(np.array(TRUTH["rates_rad_s"]), rel=1e-7)
    assert result["joints/mesh/x"] / arm == pytest.approx(np.array(TRUTH["delta_rad"]), rel=1e-7)
    assert result.summary["energy_residual"] < 1e-11


def test_an_uneven_drive_from_a_table_gives_the_same_impacts():
    """Many rows lie next to a separation, behind which the time of a trial step runs back."""
    uneven, rate, end = INPUT["A_rad_s"], INPUT["W_rad_s"], 40.0 * PERIOD
    times = np.linspace(0.0, 1.001 * end, 10001)
    angles = SPEED * times + uneven / rate * np.sin(rate * times)
    tree = coupling()
    tree["drive"] = {"angle": {"table": {"time": times.tolist(), "angle": angles.tolist()}}}
    tree["mechanism"]["bodies"]["wheel"]["initial"]["rate"] = SPEED + uneven - INPUT["delta_rate0_rad_s"]
    tree["loads"] = {"load": {"on": "wheel", "torque": -INPUT["load_torque_N_m"]}}
    tree["simulate"] = {"time": end, "discard": 0.0, "tolerance": 1e-11}
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    assert result.events["kind"].tolist() == TRUTH["kinds"]
    assert np.max(np.abs(result.events["t"] - TRUTH["times_s"])) < 1e-9 * PERIOD
    assert result.summary["energy_residual"] < 1e-11


def test_energy_balances_where_the_acceleration_of_a_drive_jumps_in_the_play():
    """At a row of a speed table the first wheel, of 1e-3 kg m^2, needs another torque."""
    times = np.arange(31) * 1e-3
    speeds = SPEED + 5.0 * (np.arange(31) % 2)
    tree = coupling()
    tree["drive"] = {"speed": {"table": {"time": times.tolist(), "speed": speeds.tolist()}}}
    tree["joints"]["mesh"] |= {"drag": 0.0, "play": 5e-3}
    tree["loads"] = {"load": {"on": "wheel", "torque": -INPUT["load_torque_N_m"]}}
    tree["simulate"] = {"time": 0.03, "discard": 0.0, "tolerance": 1e-11}
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    assert 0.1 < result.summary["mesh_free_share"] < 0.9
    assert result.summary["energy_residual"] < 1e-11


def test_figures_of_play_follow_from_the_closed_solution():
    figures = clearsweep.simulate(shaken(gear(), -1.0), []).summary
    half_play, times = INPUT["half_play_rad"], TRUTH["times_s"]
    low, high = (bound * half_play for bound in TRUTH["delta_range_over_b"])
    onsets = TRUTH["kinds"].count("on")
    turns = 40.0 * PERIOD * 2.0 * SPEED / (2.0 * math.pi)
    free = sum(end - begin for begin, end in zip(times[::2], times[1::2], strict=True)) / (40.0 * PERIOD)
    assert figures["mesh_impacts_per_cycle"] == pytest.approx(onsets / turns, rel=1e-12)
    assert figures["mesh_free_share"] == pytest.approx(free, rel=1e-8)
    assert figures["mesh_lost_motion"] == pytest.approx(high - low, rel=1e-3)  # four digits are known
    assert figures["mesh_transmission_error"] == pytest.approx(high, rel=1e-3)
    torque = INPUT["stiffness_N_m_per_rad"] * (high - half_play)
    assert figures["mesh_torque_peak"] == pytest.approx(torque, rel=1e-3)
    base_radius = PAIR["r2_m"] * math.cos(math.radians(PAIR["pressure_angle_deg"]))
    assert figures["mesh_force_peak"] == pytest.approx(figures["mesh_torque_peak"] / base_radius, rel=1e-12)
    assert figures["mesh_torque_peak_ideal"] == pytest.approx(
        INPUT["load_torque_N_m"] + INPUT["inertia_kg_m2"] * INPUT["A_rad_s"] * INPUT["W_rad_s"], rel=1e-3
    )


def contacts_of(slope, position, sizes, end, start, longest, rows=()):
    """Return (time, 'on' or 'off', side) of the contacts of a coupling, by Runge-Kutta 8 from piece to piece.

    slope : acceleration (rad/s^2) by time, state, and torque (N m) of the shaft; position : angle between the wheels by
    time and state; start : the state there; longest : step (s); rows : times at which a piece ends, too.
    """
    (_, stiffness, half_play), time, state, side, events = sizes, 0.0, start, 0, []
    while time < end:

        def rates(t, y, side=side):
            return [y[1], slope(t, y, stiffness * (position(t, y) - side * half_play) if side else 0.0)]

        borders = []
        for flank in (1, -1) if side == 0 else (side,):

            def border(t, y, flank=flank):
                return flank * position(t, y) - half_play

            border.terminal, border.direction = True, 1 if side == 0 else -1
            borders.append(border)
        stop = min(end, next((row for row in rows if row > time + 1e-12), end))
        accuracy = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-17, "max_step": longest}
        piece = solve_ivp(rates, (time, stop), state, events=borders, **accuracy)
        time, state = piece.t[-1], piece.y[:, -1]
        if piece.status == 1:
            reached = side or (1, -1)[next(k for k, times in enumerate(piece.t_events) if len(times))]
            events.append((time, "off" if side else "on", reached))
            side = 0 if side else reached
    return events


def pieces_of(parameters, end):
    """Return the contacts of a coupling under an uneven drive.

    parameters : inertia, stiffness, half of the play, load, drag, amplitude and rate of the drive.
    """
    *sizes, load, drag, amplitude, rate = parameters
    inertia, stiffness, _ = sizes

    def slope(t, y, spring):
        return (-inertia * amplitude * rate * math.sin(rate * t) - spring + load - drag * y[1]) / inertia

    longest = min(0.05 * 2.0 * math.pi / rate, 0.1 / math.sqrt(stiffness / inertia))
    return contacts_of(slope, lambda t, y: y[0], sizes, end, [0.0, 0.0], longest)


def test_impacts_on_both_flanks_agree_with_a_second_program():
    strong = INPUT | {"A_rad_s": 2.0, "load_torque_N_m": 0.3, "delta0_rad": 0.0, "drag_relative_N_m_s_per_rad": 0.2}
    tree = coupling()
    tree["mechanism"]["bodies"]["wheel"]["initial"]["angle"] = 0.0
    tree["joints"]["mesh"]["drag"] = strong["drag_relative_N_m_s_per_rad"]
    tree["simulate"]["revolutions"] /= 4.0
    result = clearsweep.simulate(shaken(tree, 1.0, strong), [])
    keys = ("inertia_kg_m2", "stiffness_N_m_per_rad", "half_play_rad", "load_torque_N_m")
    keys += ("drag_relative_N_m_s_per_rad", "A_rad_s", "W_rad_s")
    expected = pieces_of([strong[key] for key in keys], 10.0 * PERIOD)
    names = {1: "mesh_drive", -1: "mesh_coast"}
    assert len(expected) > 20
    assert {side for *_, side in expected} == {1, -1}
    assert result.events["joint"].tolist() == [names[side] for *_, side in expected]
    assert result.events["kind"].tolist() == [kind for _, kind, _ in expected]
    assert np.max(np.abs(result.events["t"] - [time for time, *_ in expected])) < 1e-9 * PERIOD


def test_a_drive_that_reverses_takes_the_play_up_on_both_flanks():
    amplitude, rate, load, drag, cycles = 5.0, 300.0, 0.2, 0.63, 5
    end = cycles * 2.0 * math.pi / rate
    tree, _, _ = reversing(amplitude, rate, load, drag, cycles, 5001)
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    sizes = [INPUT[key] for key in ("inertia_kg_m2", "stiffness_N_m_per_rad", "half_play_rad")]
    expected = pieces_of([*sizes, load, drag, amplitude, rate], end)
    assert {side for *_, side in expected} == {1, -1}
    assert result.events["kind"].tolist() == [kind for _, kind, _ in expected]
    assert np.max(np.abs(result.events["t"] - [time for time, *_ in expected])) < 1e-9 * 2.0 * math.pi / rate
    onsets = sum(kind == "on" for _, kind, _ in expected)
    assert result.summary["mesh_impacts_per_cycle"] == pytest.approx(onsets / cycles, rel=1e-12)
    torque = result.summary["mesh_torque_peak"]
    deflection = torque / INPUT["stiffness_N_m_per_rad"]
    assert result.summary["mesh_transmission_error"] == pytest.approx(INPUT["half_play_rad"] + deflection, rel=1e-9)
    play = 2.0 * INPUT["half_play_rad"]
    assert play + deflection < result.summary["mesh_lost_motion"] < play + 2.0 * deflection


def pieces_of_table(spline, sizes, load, drag, end, rate):
    """Return what `pieces_of` does where the angle of the first half is a cubic spline, from row to row of it."""
    inertia, stiffness, _ = sizes

    def slope(t, y, spring):
        return (spring + drag * (spline(t, 1) - y[1]) - load) / inertia

    longest = 0.1 / math.sqrt(stiffness / inertia)
    return contacts_of(slope, lambda t, y: spline(t) - y[0], sizes, end, [0.0, rate], longest, spline.x)


def reversing(amplitude, rate, load, drag, cycles, rows):
    """Return the coupling under a load whose first wheel turns to and fro, and the rows of its drive."""
    times = np.linspace(0.0, 1.001 * cycles * 2.0 * math.pi / rate, rows)
    angles = amplitude / rate * np.sin(rate * times)
    tree = coupling()
    tree["drive"] = {"angle": {"table": {"time": times.tolist(), "angle": angles.tolist()}}}
    tree["mechanism"]["bodies"]["wheel"]["initial"] = {"angle": 0.0, "rate": amplitude}
    tree["loads"] = {"load": {"on": "wheel", "torque": -load}}
    tree["joints"]["mesh"]["drag"] = drag
    tree["simulate"] = {"cycles": cycles, "period": 2.0 * math.pi / rate, "discard": 0, "tolerance": 1e-11}
    return tree, times, angles


@pytest.mark.slow
def test_a_coarse_table_of_angles_moves_events_by_its_spline_alone():
    """Against the sine the events of 250 rows are off by a third of a period; against their own spline by rounding."""
    amplitude, rate, load, drag, cycles = 5.0, 300.0, 0.2, 0.63, 12
    end, period = cycles * 2.0 * math.pi / rate, 2.0 * math.pi / rate
    tree, times, angles = reversing(amplitude, rate, load, drag, cycles, 251)
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    sizes = [INPUT[key] for key in ("inertia_kg_m2", "stiffness_N_m_per_rad", "half_play_rad")]
    expected = pieces_of_table(CubicSpline(times, angles, bc_type="natural"), sizes, load, drag, end, amplitude)
    assert result.events["kind"].tolist() == [kind for _, kind, _ in expected]
    assert np.max(np.abs(result.events["t"] - [time for time, *_ in expected])) < 1e-9 * period
    of_sine = pieces_of([*sizes, load, drag, amplitude, rate], end)
    assert np.max(np.abs(result.events["t"] - [time for time, *_ in of_sine])) > 0.1 * period


@pytest.mark.slow
def test_torques_of_a_planetary_gear_are_those_of_its_radii():
    figures = clearsweep.simulate(clearsweep.load_case(grid_of("a planetary gear")), []).summary
    sun, ring = 0.03, 0.07
    assert figures["inner_torque_peak_ideal"] == pytest.approx(0.5, rel=1e-9)
    assert figures["outer_torque_peak_ideal"] == pytest.approx(0.5 * ring / sun, rel=1e-9)
    assert figures["inner_force_peak_ideal"] * sun * math.cos(math.radians(20.0)) == pytest.approx(0.5, rel=1e-9)
    assert figures["energy_residual"] < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "distance"), [(2.0, 0.09), (-3.0, 0.06)])
def test_energy_balances_where_a_wheel_moves_in_its_bearing(ratio, distance):
    tree = gear()
    del tree["mechanism"]["bodies"]["wheel"]["initial"]
    tree["mechanism"] |= {"gravity": 9.81}
    tree["mechanism"]["joints"]["mesh"]["ratio"] = ratio
    tree["mechanism"]["bodies"]["ground"]["points"]["second"] = [distance, 0.0]
    contact = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
    tree["joints"]["bearing"] = {"clearance": 2e-5, "bearing_radius": 0.01, "contact": contact}
    tree["joints"]["mesh"]["contact"] |= {"damping": 50.0}
    tree["loads"] = {"brake": {"on": "wheel", "torque": -1.0}}
    tree["simulate"] |= {"revolutions": 0.5, "tolerance": 1e-10}
    figures = clearsweep.simulate(clearsweep.load_case(tree), []).summary
    assert figures["energy_residual"] < 1e-8
    assert figures["bearing_impacts_per_rev"] > 0.0
    base_radius = abs(ratio) * 0.03 * math.cos(math.radians(20.0))
    assert figures["mesh_force_peak_ideal"] == pytest.approx(1.0 / base_radius, rel=1e-9)
    weight, tooth = 9.81, figures["mesh_force_peak_ideal"]
    assert abs(figures["bearing_force_peak_ideal"] - tooth) < weight * (1.0 + 1e-9)


def test_a_wheel_with_clearance_needs_a_gear_with_play():
    tree = gear()
    del tree["joints"]["mesh"], tree["mechanism"]["bodies"]["wheel"]["initial"]
    contact = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
    tree["joints"]["bearing"] = {"clearance": 2e-5, "bearing_radius": 0.01, "contact": contact}
    refused(tree, "joints.bearing", "mesh needs its own")


def test_a_geared_machine_must_repeat_after_a_revolution_or_stay_within_it():
    tree = gear()
    del tree["mechanism"]["bodies"]["wheel"]["initial"]
    tree["mechanism"]["bodies"]["wheel"]["points"]["rim"] = [0.05, 0.0]
    tree["mechanism"]["output"] = {"body": "wheel", "point": "rim"}
    tree["loads"] = {"brake": {"on": "wheel", "torque": -1.0}}
    tree["simulate"] |= {"revolutions": 2.0, "tolerance": 1e-8}
    refused(tree, "wheel has something attached off its centre", "1/ratio is whole")
    tree["simulate"]["revolutions"] = 0.9
    figures = clearsweep.simulate(clearsweep.load_case(tree), []).summary
    assert figures["output_error_max"] < 1e-4  # about half the play


def test_eccentric_wheels_shift_the_output_along_the_line_of_action():
    """On the loaded flank r1 angle1 + r2 angle2 + e1 sin(angle1 + phase1 + pressure angle) - e2 sin(..) is constant."""
    tree, brake, stiffness, pressure_angle = gear(), 2.0, 1e9, math.radians(20.0)
    sizes = {"first_eccentricity": 2e-5, "first_phase": 0.4, "second_eccentricity": 3e-5, "second_phase": -1.1}
    tree["mechanism"]["joints"]["mesh"] |= sizes
    tree["joints"]["mesh"]["contact"] = {"law": "hunt-crossley", "stiffness": stiffness, "restitution": 0.1}
    del tree["mechanism"]["bodies"]["wheel"]["initial"]
    tree["drive"], tree["loads"] = {"speed": 4.0}, {"brake": {"on": "wheel", "torque": brake}}
    tree["simulate"] |= {"revolutions": 1.5, "tolerance": 1e-9}
    times = np.linspace(1.0, 3.0 * math.pi / 4.0, 40)
    result = clearsweep.simulate(clearsweep.load_case(tree), times)
    first, second = 4.0 * times, result["wheel/angle"]
    centres = 2e-5 * np.sin(first + 0.4 + pressure_angle) - 3e-5 * np.sin(second - 1.1 + pressure_angle)
    arm = PAIR["r1_m"] * math.cos(pressure_angle)
    pressed = 0.5 * PAIR["backlash_circumferential_m"] * math.cos(pressure_angle) + brake / (2.0 * arm * stiffness)
    assert 2.0 * arm * second == pytest.approx(pressed - arm * first - centres, abs=1e-10)
    assert result.summary["energy_residual"] < 1e-9


def rubbing_gear(ratio, distance):
    """Return two wheels with 20 teeth on the first one, friction of their teeth, and a load on the second."""
    tree = gear()
    tree["mechanism"]["joints"]["mesh"] |= {"teeth": 20, "ratio": ratio, "approach": 0.4}
    tree["mechanism"]["bodies"]["ground"]["points"]["second"] = [distance, 0.0]
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 2e4}
    friction = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-4}
    tree["joints"]["mesh"] |= {"contact": contact, "friction": friction, "drag": 0.0}
    del tree["mechanism"]["bodies"]["wheel"]["initial"]
    tree["drive"] = {"speed": 20.0}
    tree["loads"] = {"brake": {"on": "wheel", "torque": math.copysign(5.0, ratio)}}
    tree["simulate"] = {"revolutions": 1.3, "discard": 0.3, "tolerance": 1e-8}
    return tree


@pytest.mark.slow  # a form of its own
@pytest.mark.parametrize(("ratio", "distance"), [(2.0, 0.09), (-3.0, 0.06)])
def test_friction_of_teeth_acts_where_they_touch_and_turns_at_the_pitch_point(ratio, distance):
    """Both torques follow from the levers of normal force and friction: base radius, and the way to the contact."""
    arm, pitch = PAIR["r1_m"] * math.cos(math.radians(20.0)), 2.0 * math.pi / 20
    spin, lever = 20.0 * (1.0 + 1.0 / ratio), math.tan(math.radians(20.0))  # the levers here are over `arm`

    def forces(place):
        friction = 0.1 * np.tanh(arm * place * spin / 1e-4)  # per normal force, against the slip
        normal = 5.0 / (arm * (abs(ratio) + math.copysign(1.0, ratio) * friction * (lever * ratio - place)))
        return normal, friction * normal, arm * normal * (1.0 + friction * (lever + place))

    times = np.linspace(0.4, 1.3, 400) * 2.0 * math.pi / 20.0
    result = clearsweep.simulate(clearsweep.load_case(rubbing_gear(ratio, distance)), times)
    place = ((20.0 * times / pitch + 0.4) % 1.0 - 0.4) * pitch
    settled = (np.abs(place) > 0.15 * pitch) & (place > -0.3 * pitch)  # long after the last jump of the force
    normal, _, torque = forces(place)
    assert result["joints/mesh/force_normal"][settled] == pytest.approx(normal[settled], rel=1e-5)
    assert result["drive/torque"][settled] == pytest.approx(torque[settled], rel=1e-5)
    places = ((np.arange(20000) + 0.5) / 20000 - 0.4) * pitch
    power = np.mean(forces(places)[1] * arm * places * spin)
    assert result.summary["mesh_friction_power"] == pytest.approx(power, rel=2e-4)
    assert result.summary["energy_residual"] < 1e-9


@pytest.mark.slow  # a form of its own
def test_friction_of_teeth_balances_energy_where_their_centres_move():
    tree = rubbing_gear(2.0, 0.09)
    tree["mechanism"]["joints"]["mesh"]["first_eccentricity"] = 1e-5
    contact = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
    tree["joints"]["bearing"] = {"clearance": 2e-5, "bearing_radius": 0.01, "contact": contact}
    tree["loads"] = {"pump": PUMP}
    tree["simulate"] = {"revolutions": 1.0, "discard": 0, "tolerance": 1e-9}
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    assert {"mesh_drive", "mesh_coast"} < set(result.events["joint"].tolist())
    assert result.summary["mesh_friction_power"] > 0.0
    assert result.summary["energy_residual"] < 1e-9


def wearing_gear(ratio, distance):
    """Return two wheels without friction whose teeth wear, the second wheel's twice as fast."""
    tree = rubbing_gear(ratio, distance)
    del tree["joints"]["mesh"]["friction"]
    wear = {"law": "archard", "coefficient": 1e-13, "journal_coefficient": 2e-13, "bins": 80}
    tree["joints"]["mesh"] |= {"length": 0.02, "wear": wear}
    tree["simulate"] |= {"revolutions": 1.25, "discard": 0.25}
    return tree


def depths_by_archard(ratio):
    """Return places on the path of contact (m), and the depths (m) that a turn of the first wheel wears of both."""
    arm, lever = PAIR["r1_m"] * math.cos(math.radians(20.0)), PAIR["r1_m"] * math.sin(math.radians(20.0))
    pitch = 2.0 * math.pi * arm / 20
    places = ((np.arange(40) + 0.5) / 40 - 0.4) * pitch
    per_radius = 1e-13 * 5.0 / (arm * abs(ratio)) / 0.02 * abs(1.0 + 1.0 / ratio) * np.abs(places)
    return places, per_radius / np.abs(lever + places), 2.0 * per_radius / np.abs(lever * ratio - places)


@pytest.mark.slow  # a form of its own
@pytest.mark.parametrize(("ratio", "distance", "side"), [(2.0, 0.09, 1), (2.0, 0.09, -1), (-3.0, 0.06, 1)])
def test_wear_of_teeth_is_archards_along_the_path_of_contact(ratio, distance, side):
    """A pair that passes a place wears it by k w |v| / (spin x radius of curvature), v the sliding speed there."""
    tree = wearing_gear(ratio, distance)
    tree["loads"]["brake"]["torque"] *= side
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    loaded, free = (slice(0, 40), slice(40, 80))[::side]
    places, *expected = depths_by_archard(ratio)
    inner = np.abs(places) > 0.05 * (places[-1] - places[0])  # elsewhere |v| bends within a bin
    for depth, closed in zip(result.wear["mesh"], expected, strict=True):
        assert depth[loaded][inner] == pytest.approx(closed[inner], rel=1e-6)
        assert not depth[free].any()
    arm = PAIR["r1_m"] * math.cos(math.radians(20.0))
    slid = 2.0 * math.pi * abs(1.0 + 1.0 / ratio) * 0.5 * (0.4**2 + 0.6**2) * 2.0 * math.pi * arm / 20  # m a turn
    volume = 3e-13 * 5.0 / (arm * abs(ratio)) * slid
    assert result.summary["mesh_wear_volume"] == pytest.approx(volume, rel=1e-6)
    assert "mesh_pressure_peak" not in result.summary


@pytest.mark.slow  # a form of its own
@pytest.mark.parametrize("of", ["wear_depth_max", "clearance_growth"])
def test_a_life_ends_where_the_teeth_are_worn_to_its_limit(tmp_path, of):
    tree = wearing_gear(2.0, 0.09) | {"life": {"limit": "20 um", "joint": "mesh", "of": of}, "name": "teeth"}
    summary = clearsweep.sweep(tree, tmp_path / "run", jobs=1, show_progress=False).open().summary
    _, first, second = depths_by_archard(2.0)
    per_turn = np.max(first + second) if of == "clearance_growth" else max(first.max(), second.max())
    assert summary["mesh_life_revolutions"].iloc[0] == pytest.approx(20e-6 / per_turn, rel=1e-6)


def refused(tree, *words):
    """Assert that a grid is refused with a message that has these words."""
    with pytest.raises(InputError) as error:
        clearsweep.load_case(tree)
    for word in words:
        assert word in str(error.value)


def flap(**changes):
    """Return a flap on a torsion spring, whose free angle lies beyond the lower of two stops."""
    contact = {"law": "kelvin-voigt", "stiffness": 2e4, "damping": 0.0}
    tree = coupling(**changes)
    bodies, joints = tree["mechanism"]["bodies"], tree["mechanism"]["joints"]
    bodies["wheel"] |= {"inertia": 2e-3, "initial": {"angle": 0.3, "rate": 0.0}}
    del joints["mesh"]
    tree["mechanism"]["output"] = {"body": "pinion"}
    tree["loads"] = {"spring": {"between": ["ground", "wheel"], "torsional_stiffness": 5.0, "free_angle": -0.2}}
    tree["joints"] = {"bearing": {"stops": {"at": [-0.05, 0.5], "contact": contact}}}
    tree["simulate"] |= {"revolutions": 1.0, "tolerance": 1e-10}
    return tree


@pytest.mark.slow
def test_a_flap_meets_its_stop_when_the_spring_has_turned_it_there():
    result = clearsweep.simulate(clearsweep.load_case(flap()), [])
    rate = math.sqrt(5.0 / 2e-3)
    time = math.acos(0.15 / 0.5) / rate
    first, second = result.events[:2]
    assert (first["joint"], first["kind"], second["kind"]) == ("bearing_lower", "on", "off")
    assert first["t"] == pytest.approx(time, rel=1e-9)
    assert first["rate"] == pytest.approx(0.5 * rate * math.sin(rate * time), rel=1e-9)
    assert second["rate"] == pytest.approx(-first["rate"], rel=1e-8)
    assert result.summary["energy_residual"] < 1e-12
    assert result.units["bearing_penetration_max"] == "rad"


@pytest.mark.slow
def test_the_pictures_of_a_flap_have_torques_and_rates_of_angles(tmp_path):
    run = clearsweep.sweep(flap(), tmp_path / "run", jobs=1, show_progress=False).open()
    study = prepare(run)
    case_id = study.cases.index[0]
    channels = run.orbit(case_id)
    pictures = motion_pictures(study, case_id, channels) + onset_pictures(study, case_id, run.events(case_id), channels)
    labels = {picture.title: painted(picture)[0].axes.yaxis.label for picture in pictures}
    assert labels["Torque"] == "torque [N\xa0m]"
    assert labels["Contact onsets"] == "closing rate at onset [rad/s]"
    assert "{bearing_force_peak: 5 N*m}" in json.loads((tmp_path / "run/answer.json").read_text())["sentences"][-1]


@pytest.mark.slow
def test_the_loop_of_a_drive_that_reverses_is_as_high_as_its_lost_motion(tmp_path):
    tree, times = coupling(), np.linspace(0.0, 0.2, 201)
    tree["drive"] = {"angle": {"table": {"time": times.tolist(), "angle": (0.3 * np.sin(62.8 * times)).tolist()}}}
    tree["mechanism"]["bodies"]["wheel"]["initial"] = {"angle": 0.0, "rate": 0.3 * 62.8}
    tree["simulate"], tree["save"]["samples"] = {"time": 0.2, "discard": 0, "tolerance": 1e-8}, 2000
    run = clearsweep.sweep(tree | {"name": "loop"}, tmp_path / "run", jobs=1, show_progress=False).open()
    study = prepare(run)
    case_id = study.cases.index[0]
    loop = next(p for p in motion_pictures(study, case_id, run.orbit(case_id)) if p.title.startswith("Output against"))
    assert painted(loop)[0].axes.yaxis.label.startswith("shift of wheel [")
    shift = loop.paint.keywords["rate"][0]
    lost_motion = run.summary["mesh_lost_motion"].iloc[0]
    assert 0.95 * lost_motion < np.ptp(shift) <= lost_motion * (1.0 + 1e-9)


def test_a_resolved_grid_of_a_flap_reads_back():
    resolved = grid.load(flap(), scene.catalogue()).written_case(0)
    assert resolved["mechanism"]["bodies"]["wheel"]["initial"]["x"] == 0.0
    assert clearsweep.load_case(resolved).start == pytest.approx(clearsweep.load_case(flap()).start)


def test_the_mass_of_a_bound_is_that_of_the_wheel_on_the_line_of_action():
    for tree, expected in ((coupling(), INPUT["inertia_kg_m2"]), (flap(), 2e-3)):
        case_scene = clearsweep.load_case(tree)
        (layout,) = case_scene.layout.joints
        assert reduced_mass(case_scene, layout) == pytest.approx(expected, rel=1e-9)


def test_the_way_between_stops_is_no_clearance():
    assert not size_warnings(clearsweep.load_case(flap()).case)
    (text,) = size_warnings(clearsweep.load_case(changed(gear(), {"joints.mesh.backlash": 60e-3})).case)
    assert "joints.mesh.backlash is 60 mm" in text


@pytest.mark.slow
def test_the_first_onset_of_a_run_shorter_than_a_turn_is_found_by_every_method():
    tree = flap()
    tree |= {"drive": {"speed": 6.0}, "simulate": {"time": 0.1, "discard": 0.0, "tolerance": 1e-8}}
    result = check.try_variant(tree, (), time.monotonic() + 60.0)
    assert (result["status"], result["why"]) == ("ok", "")


@pytest.mark.slow
def test_the_torque_of_a_stop_is_not_compared_with_the_force_of_its_pin():
    summary = clearsweep.simulate(clearsweep.load_case(changed(flap(), {"mechanism.gravity": 9.81})), []).summary
    assert summary["bearing_force_peak"] > 0.0
    assert summary["bearing_force_peak_ideal"] is None
    assert summary["bearing_force_peak_ratio"] is None


def test_the_load_on_a_stop_is_what_the_spring_presses_with():
    built = clearsweep.load_case(flap())
    towards = acceleration_at_stops(built, built.case.joints[0], built.value.joints[0])
    assert towards == pytest.approx(5.0 * (0.2 - 0.05) / 2e-3, rel=1e-9)  # at the lower stop, away from the upper one


def flap_with_clearance():
    """Return a flap whose hinge also has clearance; only couples act, so its pin stays in the middle."""
    tree = flap()
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 0.0}
    tree["joints"]["bearing"] |= {"clearance": 1e-5, "bearing_radius": 0.01, "contact": contact}
    tree["mechanism"]["bodies"]["wheel"]["initial"] |= {"x": 0.09, "y": 0.0}
    return tree


@pytest.mark.slow
def test_a_hinge_with_clearance_meets_its_stop_at_the_same_time():
    result = clearsweep.simulate(clearsweep.load_case(flap_with_clearance()), [])
    assert result.events["joint"].tolist() == ["bearing_stops_lower"] * 2
    assert result.events["t"][0] == pytest.approx(math.acos(0.15 / 0.5) * math.sqrt(2e-3 / 5.0), rel=1e-9)
    impact_rate = math.sqrt(5.0 / 2e-3 * (0.5**2 - 0.15**2))
    assert result.events["rate"][0] == pytest.approx(impact_rate, rel=1e-8)
    assert result.summary["bearing_force_peak"] == 0.0
    assert result.summary["bearing_stops_force_peak"] > 0.99 * impact_rate * math.sqrt(2e4 * 2e-3)
    assert result.summary["energy_residual"] < 1e-9


@pytest.mark.slow
def test_a_block_between_walls_meets_its_stop():
    tree = flap()
    block = {"mass": 2.0, "inertia": 1e-3, "points": {"pin": ORIGIN}}
    tree["mechanism"]["bodies"]["wheel"] = block | {"initial": {"x": 0.1, "y": 0.0, "vx": 0.4}}
    rail = {"type": "prismatic", "between": ["ground.first", "wheel.pin"], "axis": 0.0}
    tree["mechanism"]["joints"]["rail"] = rail
    del tree["mechanism"]["joints"]["bearing"], tree["loads"]
    stops = {"at": [0.05, 0.11], "contact": {"law": "kelvin-voigt", "stiffness": 1e6, "damping": 0.0}}
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 0.0}
    size = {"clearance": 1e-5, "length": 0.04, "height": 0.02}
    tree["joints"] = {"rail": {**size, "contact": contact, "stops": stops}}
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    assert result.events["joint"].tolist() == ["rail_stops_upper"] * 2
    begin, end = result.events["t"]
    assert begin == pytest.approx(0.01 / 0.4, rel=1e-9)
    assert end - begin == pytest.approx(math.pi * math.sqrt(2.0 / 1e6), rel=1e-9)
    assert result.summary["rail_stops_force_peak"] == pytest.approx(0.4 * math.sqrt(2.0 * 1e6), rel=1e-6)


@pytest.mark.slow
def test_a_guide_meets_its_stop_where_its_slider_is():
    result = clearsweep.simulate(clearsweep.load_case(grid_of("a slider that meets its stop")))
    begin = result.events[0]
    assert (begin["joint"], begin["kind"]) == ("rail_lower", "on")
    assert np.interp(begin["t"], result.t, result["slider/x"]) == pytest.approx(0.1, abs=1e-5)
    assert result.summary["energy_residual"] < 1e-9


def flank_laws():
    """Return the names of the contact laws that gears and couplings may have."""
    laws_of_points = (law for law in laws_of_point_contacts(scene.catalogue()) if law.family == "law")
    return [law.name for law in laws_of_points if "material" not in law.needs]


@pytest.mark.slow
@pytest.mark.parametrize("name", flank_laws())
def test_every_law_of_the_normal_force_balances_energy_on_flanks(name):
    law = scene.catalogue().find("law", name)
    sizes = {"restitution": 0.7, "mass": 1e-3, "damping": 0.3, "depth": 1e-4, "stiffness": 2e4}
    needed = [field.name for field in law.fields if field.default is None and not field.optional]
    contact = {"law": name} | {key: sizes[key] for key in (*needed, *law.one_of[:1])}
    if law.uses_elastic:
        contact |= {"stiffness": 2e6, "exponent": 1.5} if "hertz" in law.needs else {"stiffness": 2e4}
    tree = coupling()
    del tree["mechanism"]["bodies"]["wheel"]["initial"]
    tree["joints"]["mesh"]["contact"] = contact
    tree["loads"] = {"pump": PUMP}
    tree["simulate"] = {"revolutions": 0.5, "discard": 0, "tolerance": 1e-7}
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    assert len(result.events)
    assert result.summary["energy_residual"] < 1e-8
