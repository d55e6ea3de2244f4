"""Friction of a given size in joints without clearance, and preload in joints with it."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import JOINT, changed
from mechanism_cases import slider_crank as slider_crank_grid
from planar_machines import four_bar, slider_crank
from right_grids import grid_of

import clearsweep
from clearsweep.contracts.machine import Braking, Constant, Rubbing
from clearsweep.mechanics.joints.contract import Load
from clearsweep.mechanics.laws.friction import Ambrosio, Stribeck, Tanh, friction_force
from clearsweep.mechanics.machines import planar
from clearsweep.mechanics.machines.contract import accelerate, crank_rate, load_power, pose_at

ANGLES = np.linspace(0.0, 2.0 * math.pi, 2001)
FOUR_BAR = grid_of("friction in a pin without clearance")


STICKS = {"law": "karnopp", "torque": 3, "static_torque": 4, "stribeck_velocity": 1, "band": "0.5 rad/s"}


def grid(**changes):
    """Return the grid of the four-bar with other values at paths, dots written as two underscores."""
    made = changed(FOUR_BAR, **{path.replace("_X_", "-"): value for path, value in changes.items()})
    return {section: content for section, content in made.items() if content != {}}


def test_a_brake_takes_its_torque_times_the_angle_it_turns():
    brake = Braking("blade", "rocker-ground", Ambrosio(3.0, 1e-9, 1e-6))
    free, braked = (planar.ideal(four_bar(drive=Constant(1.0), loads=loads), ANGLES) for loads in ((), (brake,)))
    work = np.trapezoid(braked.torque - free.torque, ANGLES)
    swing = np.ptp(planar.ideal(four_bar(drive=Constant(1.0)), ANGLES).position)
    assert work == pytest.approx(3.0 * 2.0 * swing, rel=1e-4)


def test_a_braked_guide_takes_its_force_times_its_way():
    brake = Braking("seal", "slider-ground", Ambrosio(20.0, 1e-9, 1e-6))
    free, braked = (planar.ideal(slider_crank(drive=Constant(1.0), loads=loads), ANGLES) for loads in ((), (brake,)))
    assert np.trapezoid(braked.torque - free.torque, ANGLES) == pytest.approx(20.0 * 4.0 * 0.05, rel=1e-4)


@pytest.mark.parametrize("law", [Tanh(3.0, 0.5), Ambrosio(3.0, 0.1, 1.0), Stribeck(3.0, 4.0, 2.0, 2.0, 0.1, 0.2)])
def test_the_open_machine_is_the_ideal_one_under_the_same_friction(law):
    class Clearance:
        clearance = 1e-3

    machine = four_bar(drive=Constant(5.0), loads=(Braking("blade", "crank-coupler", law),))
    built = planar.build(machine, {"coupler-rocker": Clearance()}, {})
    ideal = planar.ideal(machine, np.array([0.0]))
    force = ideal.reactions["coupler-rocker"][0]
    pose = pose_at(built.value, built.start)
    motion = accelerate(built.value, pose, (Load(float(force[0]), float(force[1]), 0.0, 0.0, ()),))
    assert motion.torque == pytest.approx(float(ideal.torque[0]), rel=1e-9)
    (power,) = motion.powers
    assert power < 0.0
    assert load_power(built.value, motion) == power
    assert crank_rate(built.value, pose, 5.0) == 5.0


def test_a_coefficient_times_a_constant_reaction_is_the_same_as_a_given_size():
    rate, radius, normal = 2.0, 0.01, 200.0
    given = Braking("brake", "j", Tanh(0.1, 0.001), radius, normal)
    couple = given.radius * friction_force(given.friction, given.normal, given.radius * rate)
    assert couple == pytest.approx(friction_force(Tanh(0.1 * radius * normal, 0.001 / radius), 1.0, rate), rel=1e-14)
    assert Rubbing("brake", "j", given.friction, radius).radius == given.radius


def test_a_blade_of_a_four_bar_is_in_the_ledger_of_energy():
    braked, free = (clearsweep.simulate(clearsweep.load_case(each)).summary for each in (grid(), grid(loads={})))
    assert braked["energy_residual"] < 1e-7
    assert braked["coupler_rocker_force_peak_ideal"] != free["coupler_rocker_force_peak_ideal"]


def test_every_velocity_law_takes_a_torque():
    laws = {
        "tanh": {"velocity_scale": "0.1 rad/s"},
        "coulomb": {"velocity_scale": "0.1 rad/s"},
        "ambrosio": {"v0": "0.01 rad/s", "v1": "0.1 rad/s"},
        "threlfall": {"velocity_scale": "0.1 rad/s"},
        "bengisu-akay": {"static_torque": "4 N*m", "velocity_scale": "0.1 rad/s", "decay": "1 s"},
        "brown-mcphee": {"static_torque": "4 N*m", "stribeck_velocity": "0.1 rad/s", "viscous": "0.1 N*m*s"},
        "stribeck": {"static_torque": "4 N*m", "stribeck_velocity": "1 rad/s", "velocity_scale": "0.1 rad/s"},
    }
    for law, keys in laws.items():
        case = clearsweep.load_case(grid(loads__blade__friction={"law": law, "torque": "3 N*m"} | keys))
        assert case.machine.loads[0].friction[0] == 3.0, law
        result = planar.ideal(case.machine, np.linspace(0.0, 6.0, 7))
        assert np.all(np.isfinite(result.torque)), law


def test_preload_rubs_in_a_joint_with_clearance_whether_it_touches_or_not():
    friction = {"law": "tanh", "coefficient": 0.1, "velocity_scale": "1 mm/s"}
    joint = JOINT | {"clearance": 5e-5, "friction": friction}
    loaded = copy.deepcopy(joint)
    loaded["friction"]["preload"] = "200 N"
    scenes = [clearsweep.load_case(grid(loads={}, joints={"coupler-rocker": each})) for each in (joint, loaded)]
    (brake,) = scenes[1].machine.loads
    assert (brake.joint, brake.radius, brake.normal, brake.friction.coefficient) == ("coupler-rocker", 0.01, 200.0, 0.1)
    result = [clearsweep.simulate(scene).summary for scene in scenes]
    assert result[1]["energy_residual"] < 1e-7
    assert result[1]["crank_torque_peak"] != result[0]["crank_torque_peak"]


def seal(preload, speed):
    """Return the scene of a block of 0.2 kg in a guide with clearance whose walls turn with the crank."""
    given = {"joints.guide.friction.preload": preload}
    if speed:
        start = {"x": 0.02, "y": 0.0103, "vx": 0.5 - 0.0103 * speed, "vy": 0.02 * speed, "rate": speed}
        given |= {"mechanism.bodies.block.initial": start, "drive.speed": speed, "simulate.revolutions": 1.0}
    return changed(grid_of("a block in a turning guide"), given)


@pytest.mark.slow
def test_preload_of_a_guide_with_clearance_stops_its_block():
    path = clearsweep.simulate(clearsweep.load_case(seal(20.0, 0.0)), times=[0.0, 0.02, 0.04])
    slowing = 0.1 * 20.0 / 0.2  # m/s^2
    assert path["block/vx"] == pytest.approx([0.5, 0.5 - 0.02 * slowing, 0.5 - 0.04 * slowing], rel=1e-6)
    assert path["block/y"] == pytest.approx(0.0103, rel=1e-4)
    assert len(path.events) == 0


@pytest.mark.slow
def test_preload_of_a_guide_that_turns_is_in_the_ledger_and_in_its_friction_power():
    path = clearsweep.simulate(clearsweep.load_case(seal(20.0, 30.0)))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-9
    taken = np.trapezoid(np.abs(path["joints/guide/vx"]) * 0.1 * 20.0, path.t) / path.t[-1]
    assert path.summary["guide_friction_power"] > 0.9 * taken


def stopping(**changes):
    """Return the motion of a slider with clearance at its pin, whose guide has Karnopp's friction."""
    friction = {"law": "karnopp", "force": "20 N", "static_force": "30 N", "stribeck_velocity": 1.0, "band": "0.1 mm/s"}
    changes = {
        "loads": {"seal": {"on": "slider-ground", "friction": friction}},
        "drive.speed": "120 rpm",
        "simulate.tolerance": 1e-8,
        "save.orbits": "all",
        "save.samples": 20000,
        "mechanism.gravity": 0.0,
    } | changes
    return clearsweep.simulate(clearsweep.load_case(slider_crank_grid("rod-slider", changes=changes)))


def test_a_slider_in_flight_stops_by_its_seal_and_stays():
    path = stopping()
    assert path.status == "ok"
    speed, pace = path["slider/v"], path["slider/a"]
    apart = path["joints/rod_slider/force_normal"] == 0.0
    sliding = apart & (np.abs(speed) > 2e-4)
    fall = 20.0 + 10.0 * np.exp(-(speed[sliding] ** 2))  # Stribeck's fall from 30 to 20 N over 1 m/s
    np.testing.assert_allclose(pace[sliding], -np.sign(speed[sliding]) * fall / 0.14, rtol=1e-6)
    stuck = apart & (np.abs(speed) < 0.9e-4)
    assert np.count_nonzero(stuck) > 100
    rate = 2.0 * math.pi * 2.0
    np.testing.assert_allclose(pace[stuck], -rate * speed[stuck], atol=1e-9)
    assert path.summary["energy_residual"] < 1e-7


def test_a_stuck_slider_lets_go_where_more_than_the_static_force_pushes_it():
    path = stopping()
    pushed = np.abs(path["joints/rod_slider/force_normal"])
    still = np.abs(path["slider/v"]) < 0.5e-4
    assert np.max(pushed[still]) < 31.0
    assert np.max(pushed) > 31.0
    assert np.ptp(path["slider/x"]) > 0.09


@pytest.mark.slow
def test_a_joint_that_moves_as_the_crank_says_cannot_stick():
    brake = {"on": "ground-crank", "friction": STICKS}
    path = clearsweep.simulate(clearsweep.load_case(grid(loads__blade=brake, simulate__revolutions=0.1)))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-7


@pytest.mark.slow
def test_two_joints_that_stick_hold_each_other():
    friction = {"law": "karnopp", "torque": 50, "static_torque": 60, "stribeck_velocity": 1, "band": "0.1 rad/s"}
    loads = {name: {"on": on, "friction": friction} for name, on in (("a", "rocker-ground"), ("b", "crank-coupler"))}
    path = clearsweep.simulate(clearsweep.load_case(grid(loads=loads, simulate__revolutions=0.1)))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-6
