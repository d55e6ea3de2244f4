"""Friction with internal state in joints without clearance: bristles, and surfaces that stick, by reaction or size."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import changed, slider_crank
from right_grids import grid_of
from scipy.integrate import solve_ivp
from test_given_friction import FOUR_BAR, JOINT, STICKS, grid
from test_heat import DRY

import clearsweep
from clearsweep.contracts.layout import Layout
from clearsweep.contracts.machine import Rubbing
from clearsweep.mechanics.laws.bristles import Dahl, LuGre
from clearsweep.mechanics.laws.friction import (
    Karnopp,
    Tanh,
    friction_force,
    friction_in_pin,
    settled_state,
    static_limit_in_pin,
    without_history,
)
from clearsweep.simulation.running.run import integration_of
from clearsweep.verify.measured.machines import LAW

LENGTH = 1.001  # m, from the crank's pivot to the slider at the start
DAHL = {"law": "dahl", "coefficient": 0.2, "bristle_stiffness": 1e3}


def block(friction, force, *, end=25.0, stiffness=0.0, **simulate):
    """Return the grid of a block of 1 kg on an ideal guide under 1 N, pulled along it by a table over time.

    It is the slider of a machine whose pin has so much clearance that it never touches.
    """
    given = {"drive.speed": 2.0 * math.pi / end, "loads.rub.friction": friction, "loads.spring.stiffness": stiffness}
    made = changed(grid_of("a block on an ideal guide"), given)
    made["loads"]["pull"]["table"] = {"time [s]": [0.0, end], "fx [N]": force}
    return changed(made, {f"simulate.{key}": value for key, value in simulate.items()})


def moved(grid, times):
    """Return place (m) and speed (m/s) of the block at times (s), and the summary of its case."""
    path = clearsweep.simulate(clearsweep.load_case(grid), times=times)
    assert path.status == "ok"
    return path["slider/x"] - LENGTH, path["slider/v"], path.summary


# ---------------------------------------------------------------------------------------------- the friction circle


def driven_shaft(coefficient, load):
    """Return the grid of a shaft that turns on an ideal pin of 20 mm radius under a load (N)."""
    given = {"loads.weight.force": [0.0, -load], "loads.rub.friction.coefficient": coefficient}
    return changed(grid_of("a shaft on an ideal pin"), given)


def loaded_bush(coefficient, load, clearance):
    """Return the grid of a turning shaft that carries a bush, loaded (N) and kept from turning, with clearance."""
    grid, still = driven_shaft(coefficient, load), [0.0, 0.0]
    bodies, joints = grid["mechanism"]["bodies"], grid["mechanism"]["joints"]
    del bodies["free"], joints["rest"]
    bodies["carriage"] = {"mass": 0.0, "inertia": 0.0, "points": {"pin": still}}
    bodies["bush"] = {"mass": 1.0, "inertia": 0.0, "points": {"bore": still}}
    joints["across"] = {"type": "prismatic", "between": ["ground.main", "carriage.pin"], "axis": 0.0}
    joints["along"] = {"type": "prismatic", "between": ["carriage.pin", "bush.bore"], "axis": "90 deg"}
    joints["dry"] = {"type": "revolute", "between": ["shaft.pin", "bush.bore"], "journal": "shaft"}
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 2e4}
    friction = {"law": "tanh", "velocity_scale": 1e-6, "coefficient": coefficient}
    grid["joints"] = {"dry": {"clearance": clearance, "bearing_radius": 0.02, "contact": contact, "friction": friction}}
    damper = {"between": ["ground", "bush"], "anchor": [-100.0, 0.0], "point": "bore", "stiffness": 0.0}
    grid["loads"] = {"weight": {"on": "bush", "force": [0.0, -load]}, "damper": damper | {"damping": 2e3}}
    grid["simulate"] = {"revolutions": 3, "discard": 2}
    return grid


@pytest.mark.parametrize("coefficient", [0.1, 0.5])
def test_an_ideal_pin_is_the_limit_of_a_small_clearance(coefficient):
    """The torque of a pin of radius r under a load W is W r sin(atan mu), by the friction circle."""
    torques = [
        clearsweep.simulate(clearsweep.load_case(grid))["drive/torque"][-1]
        for grid in (driven_shaft(coefficient, 100.0), loaded_bush(coefficient, 100.0, 1e-6))
    ]
    circle = 100.0 * 0.02 * math.sin(math.atan(coefficient))
    assert torques[0] == pytest.approx(circle, rel=1e-12)
    assert torques[1] == pytest.approx(circle, rel=1e-4)


@pytest.mark.parametrize(
    "law",
    [Tanh(0.8, 0.01), Dahl(0.5, 1e3, 1.0, 3e-4), LuGre(0.5, 0.7, 0.1, 2.0, 0.2, 1e3, 0.1, 1.0, 2e-4)],
    ids=lambda law: type(law).__name__,
)
def test_normal_force_and_friction_of_a_pin_add_up_to_its_reaction(law):
    tangential = friction_in_pin(law, 250.0, 0.02)
    normal = math.sqrt(250.0**2 - tangential**2)
    assert tangential == pytest.approx(friction_force(law, normal, 0.02), rel=1e-12)


def test_a_pin_sticks_up_to_the_static_coefficient_times_its_normal_force():
    law = Karnopp(0.3, 0.6, 0.01, 2.0, 0.0, 1e-4)
    limit = static_limit_in_pin(law, 250.0)
    assert limit == pytest.approx(0.6 * math.sqrt(250.0**2 - limit**2), rel=1e-12)


# ---------------------------------------------------------------------------------------------- bristles


@pytest.mark.slow
@pytest.mark.compiled
def test_stick_slip_of_the_lugre_paper_on_a_guide_without_clearance():
    """Against an integration of the paper's own three equations: creep, break-away and the first slip."""

    def paper(t, state):
        x, v, z = state
        fall = 1.0 + 0.5 * math.exp(-((v / LAW["stribeck_velocity"]) ** 2))
        bending = v - LAW["bristle_stiffness"] * abs(v) * z / fall
        friction = LAW["bristle_stiffness"] * z + LAW["bristle_damping"] * bending + LAW["viscous"] * v
        return v, 2.0 * (0.1 * t - x) - friction, bending

    times = np.array([1.0, 3.0, 5.0, 7.3, 7.6, 8.0, 9.0, 10.0, 10.3, 12.0])
    exact = solve_ivp(paper, (0.0, 12.0), [0.0, 0.0, 0.0], "Radau", times, rtol=1e-9, atol=1e-13, max_step=0.05).y
    x, v, summary = moved(block({"law": "lugre"} | LAW, [0.0, 5.0], stiffness=2.0), times)
    np.testing.assert_allclose(x, exact[0], atol=2e-7)
    np.testing.assert_allclose(v, exact[1], atol=1e-6)
    assert summary["energy_residual"] < 1e-9


def test_bristles_resist_before_they_slide():
    """Dahl's bristles under a force that grows slowly: x = -(mu / sigma0) ln(1 - F / (mu N))."""
    times = np.array([2.0, 5.0, 10.0, 15.0, 20.0])
    x, _, _ = moved(block(DAHL, [0.0, 0.2], stiffness=0.0), times)
    exact = -0.2 / 1e3 * np.log1p(-0.2 * times / 25.0 / 0.2)
    np.testing.assert_allclose(x, exact, atol=2e-6)  # it sways by sqrt(m / (sigma0 N)) times the speed of the force


def test_bristles_take_the_energy_that_their_force_over_the_way_says():
    """A spring draws the block out from rest; the friction is mu N (1 - exp(-sigma0 x / mu)) as long as it goes on."""
    grid = block(DAHL, [1.0, 1.0], end=2.0)
    times = np.linspace(0.0, 0.5, 11)[1:]
    x, v, _ = moved(grid, times)
    friction = 0.2 * (x - 0.2 / 1e3 * -np.expm1(-1e3 * x / 0.2))
    np.testing.assert_allclose(0.5 * v**2, 1.0 * x - friction, rtol=1e-8)


@pytest.mark.slow
def test_an_implicit_run_of_bristles_agrees_with_an_explicit_one():
    times = np.array([1.0, 5.0, 7.6, 8.0])
    runs = [
        moved(block({"law": "elasto-plastic"} | LAW, [0.0, 5.0], stiffness=2.0, method=method), times)
        for method in ("explicit", "implicit")
    ]
    np.testing.assert_allclose(runs[0][0], runs[1][0], atol=1e-7)
    assert runs[0][2]["steps"] != runs[1][2]["steps"]


def four_bar(on, friction, **changes):
    """Return the grid of the four-bar with friction on one joint."""
    grid = copy.deepcopy(FOUR_BAR)
    grid["loads"] = {"blade": {"on": on, "friction": friction}}
    for path, value in changes.items():
        section, key = path.split("__")
        grid[section][key] = value
    return grid


BRUSH = {"static_coefficient": 0.2, "stribeck_velocity": 0.5, "bristle_stiffness": 2e4, "bristle_damping": 1.0}


def test_bristles_of_a_pin_that_turns_on_settle_to_stribecks_curve():
    """The crank's pin turns at a constant speed, so its bristles stay bent and the couple is that without them."""
    torques = []
    for law in ({"law": "lugre"} | BRUSH, {"law": "stribeck", "velocity_scale": 1e-4} | dict(list(BRUSH.items())[:2])):
        grid = four_bar("ground-crank", law | {"coefficient": 0.1, "radius": 0.01})
        scene = clearsweep.load_case(grid)
        assert len(scene.start) == len(scene.built.start) + 1 + ("bristle_stiffness" in law)
        path = clearsweep.simulate(scene, times=np.linspace(0.005, 0.03, 6))
        assert path.summary["energy_residual"] < 1e-7
        torques.append(path["crank/torque"])
    np.testing.assert_allclose(*torques, rtol=1e-6)


@pytest.mark.few("friction0")
@pytest.mark.parametrize(
    "friction",
    [
        {"law": "lugre", "coefficient": 0.1, "radius": 0.01} | BRUSH,
        {
            "law": "lugre",
            "torque": "1 N*m",
            "static_torque": "1.5 N*m",
            "stribeck_velocity": "5 rad/s",
            "bristle_stiffness": "1e4 N*m",
            "bristle_damping": "10 N*m*s",
        },
        {"law": "dahl", "torque": "1 N*m", "bristle_stiffness": "1e3 N*m"},
        {"law": "elasto-plastic", "coefficient": 0.1, "radius": 0.01} | BRUSH,
    ],
)
def test_bristles_of_a_rocker_are_in_the_ledger_of_energy(friction):
    summary = clearsweep.simulate(clearsweep.load_case(four_bar("rocker-ground", friction))).summary
    assert summary["energy_residual"] < 1e-7
    assert summary["rocker_ground_friction_power"] > 0.0


@pytest.mark.slow
def test_a_preload_may_have_bristles():
    grid = copy.deepcopy(FOUR_BAR) | {"loads": {}}
    del grid["loads"]
    friction = {"law": "lugre", "coefficient": 0.1, "preload": "200 N"} | BRUSH
    grid["joints"]["coupler-rocker"]["friction"] = friction
    scene = clearsweep.load_case(grid)
    assert len(scene.start) == len(scene.built.start) + 1 + 2  # those of the contact, then those of the preload
    path = clearsweep.simulate(scene)
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-7


def test_a_machine_without_history_has_bristles_bent_as_after_long_sliding():
    lugre = LuGre(0.1, 0.2, 0.5, 2.0, 0.3, 1e4, 100.0, 0.2)
    for slip in (-2.0, -0.1, 0.3):
        curve = 0.1 + 0.1 * math.exp(-((slip / 0.5) ** 2)) + 0.3 * abs(slip)
        assert friction_force(without_history(lugre), 50.0, slip) == pytest.approx(-50.0 * math.copysign(curve, slip))
    assert friction_force(without_history(lugre), 50.0, 0.0) == 0.0
    assert settled_state(Dahl(0.2, 1e3, 1.0), -1.0) == (-2e-4,)
    assert without_history(Tanh(0.1, 1e-3)) == Tanh(0.1, 1e-3)


@pytest.mark.slow
def test_a_free_crank_has_an_ideal_machine_with_bristles():
    grid = four_bar("rocker-ground", {"law": "lugre", "coefficient": 0.1, "radius": 0.01} | BRUSH)
    grid["drive"] = {"motor": {"stall_torque": 20, "no_load_speed": "600 rpm"}, "initial_speed": "300 rpm"}
    summary = clearsweep.simulate(clearsweep.load_case(grid)).summary
    assert summary["energy_residual"] < 1e-7
    assert summary["coupler_rocker_force_peak_ideal"] > 0.0


def test_laws_of_loads_are_replaced_by_place():
    grid = four_bar("rocker-ground", {"law": "dahl", "coefficient": 0.1, "radius": 0.01, "bristle_stiffness": 1e4})
    grid["loads"]["push"] = {"on": "rocker", "torque": 1.0}
    mechanism = clearsweep.load_case(grid).built.value
    other = clearsweep.mechanics.machines.contract.with_friction_laws(mechanism, (Dahl(0.5, 1.0, 1.0, 0.25),))
    (rubbed,) = (load for load in other.loads if isinstance(load, Rubbing))
    assert rubbed.friction == Dahl(0.5, 1.0, 1.0, 0.25)
    assert [type(load) for load in other.loads] == [type(load) for load in mechanism.loads]


# ---------------------------------------------------------------------------------------------- sticking

KARNOPP = {"law": "karnopp", "coefficient": 0.2, "static_coefficient": 0.2, "stribeck_velocity": 1.0, "band": 1e-6}


@pytest.mark.parametrize("tolerance", [1e-8, 1e-12])
@pytest.mark.parametrize(("pull", "weight"), [([0.0, 0.32], [1.0, 1.0]), ([0.2, 0.2], [2.0, 0.4])])
def test_a_block_stays_until_its_static_friction_is_reached_and_then_slides(pull, weight, tolerance):
    """A pull a t, or a weight whose friction falls by a t: it slides from t0 on, with x = a (t - t0)^3 / 6."""
    grid = block(KARNOPP, pull, end=20.0, tolerance=tolerance)
    grid["loads"]["weight"] = {
        "on": "slider",
        "table": {"time [s]": [0.0, 20.0], "fy [N]": [-weight[0], -weight[1]]},
    }
    times = np.array([5.0, 10.0, 13.0, 15.0, 20.0])
    x, _, summary = moved(grid, times)
    exact = 0.016 * np.maximum(times - 12.5, 0.0) ** 3 / 6.0
    np.testing.assert_allclose(x, exact, atol=1e-5)  # of creep within the band, and what it adds to t0
    assert summary["energy_residual"] < 1e-9


@pytest.mark.slow
def test_loads_that_stick_together_are_found_one_after_the_other():
    friction = KARNOPP | {"radius": 0.02, "band": "1 mm/s"}
    grid = four_bar("rocker-ground", friction)
    grid["loads"]["other"] = {"on": "crank-coupler", "friction": friction}
    lugre = {"law": "lugre", "coefficient": 0.1, "radius": 0.01} | BRUSH
    grid["loads"]["third"] = {"on": "rocker-ground", "friction": lugre}
    path = clearsweep.simulate(clearsweep.load_case(grid))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-6


# Friction power of joints without clearance and of preload: a column, heat, a remark, a sentence of the report.


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
