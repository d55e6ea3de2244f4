"""Teeth along their path of contact: varying stiffness, change of pairs, and lost motion of drives that reverse."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from test_play import INPUT, PAIR, PUMP, changed, coupling, gear, refused, rubbing_gear

import clearsweep

ARM = PAIR["r1_m"] * math.cos(math.radians(20.0))  # m, base radius of the first wheel
HALF_PLAY = 0.5 * PAIR["backlash_circumferential_m"] * math.cos(math.radians(20.0))  # m, along the line of action
ROWS = {"pitch": [0.0, 0.2, 0.5, 0.8, 1.0], "factor": [0.8, 1.2, 1.1, 0.9, 0.8]}
FACTOR = CubicSpline(ROWS["pitch"], ROWS["factor"], bc_type="periodic")


def varying_gear(ratio=2.0, distance=0.09, rows=ROWS):
    """Return two wheels whose 20 teeth of the first have a stiffness that varies over the pitch, without friction."""
    tree = rubbing_gear(ratio, distance)
    del tree["joints"]["mesh"]["friction"]
    tree["joints"]["mesh"]["mesh_stiffness"] = rows
    return tree


@pytest.mark.few("2.0-0.09")
@pytest.mark.parametrize(("ratio", "distance"), [(2.0, 0.09), (-3.0, 0.06)])
def test_teeth_under_a_constant_load_give_by_force_over_stiffness(ratio, distance):
    """The work of the varying stiffness, W' / 2 = -F^2 / (2 k)', is done by the drive: its torque has it."""
    tree, speed, pitch = varying_gear(ratio, distance), 0.2, 2.0 * math.pi / 20
    tree["drive"], tree["simulate"] = {"speed": speed}, {"revolutions": 0.15, "discard": 0.05, "tolerance": 1e-9}
    times = np.linspace(0.05, 0.15, 200) * 2.0 * math.pi / speed
    result = clearsweep.simulate(clearsweep.load_case(tree), times)
    force, shares = 5.0 / (ARM * abs(ratio)), (speed * times / pitch + 0.4) % 1.0
    given_way = result["joints/mesh/x"] - HALF_PLAY
    assert given_way == pytest.approx(force / (1e8 * FACTOR(shares)), rel=5e-4)  # of which 3e-4 is the damping
    energy_slope = 0.5 * force**2 / 1e8 * FACTOR(shares, 1) / FACTOR(shares) ** 2 / pitch
    assert result["drive/torque"] - ARM * force == pytest.approx(energy_slope, abs=2e-3 * np.max(energy_slope))
    largest = HALF_PLAY + force / (1e8 * np.min(FACTOR(np.linspace(0.0, 1.0, 2001))))
    error = result.summary["mesh_transmission_error"] * ARM * abs(ratio)
    assert error == pytest.approx(largest, rel=1e-5)
    assert result.summary["energy_residual"] < 1e-10


@pytest.mark.slow  # a form of its own
@pytest.mark.parametrize(("share", "growth"), [(2.0, 0.1 / 4.0), (1.5, 0.0)])
def test_teeth_shake_the_wheel_at_twice_its_natural_frequency(share, growth):
    """Mathieu: at twice the frequency w a stiffness k (1 + e cos) lets deviations grow by exp(e w t / 4)."""
    stiffness, shares = PAIR["contact_stiffness_along_line_of_action_N_m"], np.linspace(0.0, 1.0, 41)
    rate = 2.0 * ARM * math.sqrt(stiffness / INPUT["inertia_kg_m2"])
    factors = 1.0 + 0.1 * np.cos(2.0 * np.pi * shares)
    factors[-1] = factors[0]
    period = 2.0 * math.pi / (share * rate)

    def state_after_a_pitch(place, speed):
        tree = varying_gear(rows={"pitch": shares.tolist(), "factor": factors.tolist()})
        tree["joints"]["mesh"]["contact"] = {"law": "hertz", "stiffness": stiffness}
        start = HALF_PLAY + 2.0 / (2.0 * ARM * stiffness) * (1.0 + place)
        start_rate = 2.0 / (2.0 * ARM * stiffness) * rate * speed
        initial = {"angle": start / (2.0 * ARM), "rate": (start_rate / ARM - share * rate / 20.0) / 2.0}
        tree["mechanism"]["bodies"]["wheel"]["initial"] = initial
        tree["drive"], tree["loads"]["brake"]["torque"] = {"speed": share * rate / 20.0}, 2.0
        tree["simulate"] = {"revolutions": 1.01 / 20.0, "discard": 0, "tolerance": 1e-11}
        result = clearsweep.simulate(clearsweep.load_case(tree), [period])
        assert not len(result.events)
        return np.array([result["joints/mesh/x"][0], result["joints/mesh/vx"][0] / rate])

    reference = state_after_a_pitch(0.0, 0.0)
    columns = [state_after_a_pitch(*deviation) - reference for deviation in ((0.1, 0.0), (0.0, 0.1))]
    matrix = np.array(columns) / (0.1 * 2.0 / (2.0 * ARM * stiffness))
    assert np.linalg.det(matrix) == pytest.approx(1.0, rel=1e-7)  # nothing is lost
    largest = np.max(np.abs(np.linalg.eigvals(matrix)))
    assert math.log(largest) / (period * rate) == pytest.approx(growth, rel=1e-3, abs=1e-6)


@pytest.mark.slow  # a form of its own
def test_energy_balances_where_wheels_with_a_varying_stiffness_move():
    tree = varying_gear()
    tree["mechanism"]["joints"]["mesh"]["first_eccentricity"] = 1e-5
    contact = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
    tree["joints"]["bearing"] = {"clearance": 2e-5, "bearing_radius": 0.01, "contact": contact}
    tree["loads"] = {"pump": PUMP}
    tree["joints"]["mesh"]["contact"] = {"law": "hertz", "stiffness": 1e7}
    tree["simulate"] = {"revolutions": 1.0, "discard": 0, "tolerance": 1e-9}
    result = clearsweep.simulate(clearsweep.load_case(tree), [])
    assert {"mesh_drive", "mesh_coast"} < set(result.events["joint"].tolist())
    assert result.summary["energy_residual"] < 1e-9


def test_a_stiffness_whose_cubic_falls_below_zero_is_refused():
    rows = {"pitch": [0.0, 0.1, 0.9, 1.0], "factor": [1.0, 0.05, 0.05, 1.0]}
    refused(varying_gear(rows=rows), "joints.mesh.mesh_stiffness", "the cubic", "stay above 0", "add rows")


def test_a_varying_stiffness_needs_teeth_and_an_elastic_law():
    tree = varying_gear()
    refused(changed(tree, {"mechanism.joints.mesh.teeth": None}), "joints.mesh.mesh_stiffness", "joints.mesh.teeth")
    plastic = {"law": "lankarani-nikravesh-plastic", "stiffness": 1e8, "restitution": 0.5, "yield_rate": 0.1}
    refused(changed(tree, {"joints.mesh.contact": plastic}), "joints.mesh.mesh_stiffness", "not used by law")
    tree = coupling()
    tree["joints"]["mesh"]["mesh_stiffness"] = ROWS
    refused(tree, "joints.mesh.mesh_stiffness")


@pytest.mark.slow  # a form of its own
def test_energy_balances_where_a_row_of_the_drive_ends_a_pair_of_teeth():
    """At an angle of 0 the coast flank changes its pair where a step has to end anyway."""
    tree, times = varying_gear(), np.arange(0.0, 0.42, 0.05)
    angles = [0.35 * math.sin(0.5 * math.pi * k) for k in range(len(times))]
    tree["drive"] = {"angle": {"table": {"time": times.tolist(), "angle": angles}}}
    tree["mechanism"]["joints"]["mesh"]["approach"] = 0.5
    friction = {"law": "tanh", "torque": 2.0, "velocity_scale": 0.01}
    tree["loads"] = {"brake": {"on": "bearing", "friction": friction}}
    contact = {"law": "hunt-crossley", "stiffness": 5e7, "restitution": 0.6}
    tree["joints"]["mesh"] |= {"backlash": 3e-5, "contact": contact}
    tree["simulate"] = {"cycles": 2, "period": 0.2, "discard": 1, "tolerance": 1e-7}
    assert clearsweep.simulate(clearsweep.load_case(tree), []).summary["energy_residual"] < 1e-7


@pytest.mark.slow  # forms of their own
def test_steps_end_where_the_next_pair_of_teeth_takes_over():
    """A jump of the force that no event locates costs twice the steps, 2,225; each of 26 pairs needs some 40."""
    result = clearsweep.simulate(clearsweep.load_case(rubbing_gear(2.0, 0.09)), [])
    assert result.summary["steps"] < 1200


@pytest.mark.slow  # forms of their own
@pytest.mark.parametrize("tree", [coupling, gear])
@pytest.mark.parametrize(("brake", "drag", "load"), [(0.5, 0, 0), (0.5, 0.05, 0), (0.5, 0, 0.2), (0.5, 0, 1)])
def test_lost_motion_is_the_play_and_what_both_torques_turn(tree, brake, drag, load):
    """Slowly to and fro against dry friction T and a load: play + 2 T / k; a larger load keeps the teeth together."""
    grid = tree()
    turn_slowly(grid, brake, 20.0)
    grid["joints"]["mesh"]["drag"] = drag
    grid["loads"] |= {"weight": {"on": "wheel", "torque": load}} if load else {}
    figures = clearsweep.simulate(clearsweep.load_case(grid), []).summary
    turned = 2.0 * brake / INPUT["stiffness_N_m_per_rad"]
    expected = turned if load > brake else 2.0 * INPUT["half_play_rad"] + turned
    assert figures["mesh_lost_motion"] == pytest.approx(expected, rel=5e-3 if load > brake else 1e-6)


@pytest.mark.slow  # forms of their own
@pytest.mark.parametrize("tree", [coupling, gear])
def test_lost_motion_without_torque_is_the_play(tree):
    """What is left is what a wheel that meets a flank at a speed s turns beyond it, s sqrt(J / k)."""
    lost = []
    for period in (40.0, 400.0):
        grid = tree()
        turn_slowly(grid, 1e-4, period)
        lost.append(clearsweep.simulate(clearsweep.load_case(grid), []).summary["mesh_lost_motion"])
    play = 2.0 * INPUT["half_play_rad"]
    assert 0.0 < lost[1] - play < 0.2 * (lost[0] - play) < 2e-4 * play


def turn_slowly(grid, brake, period):
    """Let the first wheel turn to and fro by 0.02 rad, against a brake (N m) on the second."""
    times = np.linspace(0.0, 2.001 * period, 401)
    angles = 0.02 * np.sin(2.0 * math.pi * times / period)
    grid["drive"] = {"angle": {"table": {"time": times.tolist(), "angle": angles.tolist()}}}
    del grid["mechanism"]["bodies"]["wheel"]["initial"]
    friction = {"law": "tanh", "torque": brake, "velocity_scale": 1e-6}
    grid["loads"] = {"brake": {"on": "bearing", "friction": friction}}
    stiffness = grid["joints"]["mesh"]["contact"]["stiffness"]
    contact = {"law": "hunt-crossley", "stiffness": stiffness, "restitution": 0.1}
    grid["joints"]["mesh"] |= {"contact": contact, "drag": 0.0}
    grid["simulate"] = {"cycles": 2, "period": period, "discard": 1, "tolerance": 1e-7}
