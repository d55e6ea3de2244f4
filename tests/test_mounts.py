"""Housings that yield, against the equations of another program, and against machines without mounts."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from mechanism_cases import JOINT, changed, slider_crank
from right_grids import grid_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import clearsweep
from clearsweep import report, simulation
from clearsweep.grid import load
from clearsweep.simulation.machine.ideal import mechanism_of

#: The slider-crank of the README with a housing of 4 kg at its crank: Lagrange's equations against those of Newton and
#: Euler for four free bodies, which agree to 7e-12 of the largest motion.
TRUTH = json.loads(Path(__file__).with_name("yielding_housing.json").read_text(encoding="utf-8"))
TIMES = np.array([*TRUTH["times_s"], 0.2])  # s, the last after five revolutions
SPEED = TRUTH["input"]["crank_rate_rad_s"]
CRANK_MOUNT, X, Y = "mechanism.mounts.ground-crank", "joints/ground_crank/mount_x", "joints/ground_crank/mount_y"
HOUSING = {"mass": 4.0, "stiffness": [2e6, 1e6], "damping": [200.0, 150.0]}
MOUNTED = changed(
    slider_crank(),
    {CRANK_MOUNT: HOUSING, "drive.speed": SPEED, "simulate.revolutions": 5, "simulate.tolerance": 1e-12},
)
IMPACTS = {"simulate.revolutions": 0.3, "simulate.tolerance": 1e-11, "drive.speed": SPEED}


def run(grid, times=None):
    """Return the run of a grid dict; it has to succeed."""
    motion = clearsweep.simulate(clearsweep.load_case(grid), times)
    assert motion.status == "ok", motion.message
    return motion


def test_a_housing_moves_as_in_the_equations_of_lagrange_and_of_newton():
    motion = run(MOUNTED, TIMES)
    for channel, axis in ((X, "X"), (Y, "Y")):
        exact, largest = [*TRUTH[f"{axis}_m"], TRUTH[f"{axis}_after_5_revolutions_m"]], TRUTH[f"{axis}_largest_m"]
        assert np.max(np.abs(motion.channels[channel] - exact)) < 1e-9 * largest
    assert motion.summary["energy_residual"] < 1e-12


def test_the_largest_motion_of_a_housing_and_its_effect_on_the_slider_are_found():
    motion = run(MOUNTED, np.linspace(0.0, 0.2, 20001))
    distance = np.hypot(motion.channels[X], motion.channels[Y])
    assert motion.summary["ground_crank_mount_motion_max"] == pytest.approx(distance.max(), rel=1e-5)
    assert motion.summary["ground_crank_mount_motion_max"] > distance.max()
    angle = SPEED * motion.t
    fixed = 0.05 * np.cos(angle) + np.sqrt(0.12**2 - (0.05 * np.sin(angle)) ** 2)
    error = np.max(np.abs(motion.channels["slider/place"] - fixed))
    assert motion.summary["slider_error_mounts"] == pytest.approx(error, rel=1e-3)  # to first order
    assert motion.summary["slider_error_max"] == pytest.approx(error, rel=1e-4)


@pytest.mark.slow
def test_the_frame_of_a_mounted_machine_is_its_housing():
    vibration = {"at": {"frame": {}, "piston": {"body": "slider"}}}
    motion = run(changed(MOUNTED, {"vibration": vibration, "simulate.revolutions": 6}), TIMES)
    for axis, stiffness, damping in zip("xy", HOUSING["stiffness"], HOUSING["damping"], strict=True):
        spring = stiffness * motion.channels[f"joints/ground_crank/mount_{axis}"][:-1]
        damper = damping * np.array(TRUTH[f"{axis.upper()}d"])
        force = -(spring + damper + HOUSING["mass"] * motion.channels[f"frame/a{axis}"][:-1])
        exact = np.array(TRUTH[f"pin_force_on_crank_{axis}"])
        assert np.max(np.abs(force - exact)) < 1e-7 * np.max(np.abs(exact))
    guide = motion.channels["frame/force_x"][:-1]  # springs and dampers alone pass the force along the slide
    assert guide == pytest.approx(
        HOUSING["stiffness"][0] * motion.channels[X][:-1] + HOUSING["damping"][0] * np.array(TRUTH["Xd"]), rel=1e-6
    )
    assert motion.summary["frame_velocity_rms"] > 0.01 > motion.summary["frame_velocity_rms_ideal"]


@pytest.mark.slow
@pytest.mark.parametrize("clearance", [None, "ground-crank", "rod-slider"])
def test_ever_stiffer_springs_make_the_fixed_machine(clearance):
    grid = slider_crank(*filter(None, [clearance]), changes={"mechanism.gravity": 9.81, **IMPACTS})
    mount = {"mass": 0.4, "stiffness": 1e14, "damping": "5 %"}
    stiff = changed(grid, {CRANK_MOUNT: mount, "mechanism.mounts.slider-ground": mount})
    times = np.linspace(0.0, 0.3 * 2.0 * math.pi / SPEED, 101)
    motion = run(stiff, times)
    if clearance:
        rigid = run(grid, times).channels["slider/place"]
    else:
        angle = SPEED * times
        rigid = 0.05 * np.cos(angle) + np.sqrt(0.12**2 - (0.05 * np.sin(angle)) ** 2)
    bound = 1e-4 * JOINT["clearance"] if clearance else 1e-9  # impacts amplify the yield of the springs
    assert np.max(np.abs(motion.channels["slider/place"] - rigid)) < bound
    for joint in ("ground_crank", "slider_ground"):
        assert np.max(np.abs(motion.channels[f"joints/{joint}/mount_y"])) < 1e-10


def guide_on_springs(time, state, gravity):
    """Return the rates of a housing that moves across the guide of the slider-crank: d'Alembert with one coordinate."""
    y, rate = state
    angle, crank, rod, centre, masses = SPEED * time, 0.05, 0.12, 0.06, (0.21, 0.14)
    turned = math.asin((y - crank * math.sin(angle)) / rod)
    c, s = math.cos(turned), math.sin(turned)
    spin = (rate - crank * SPEED * math.cos(angle)) / (rod * c)
    pin = -crank * SPEED**2 * np.array([math.cos(angle), math.sin(angle)])
    inward, across = np.array([-c, -s]), np.array([-s, c])

    def residual(acceleration):
        spin_rate = (acceleration - pin[1] + rod * s * spin**2) / (rod * c)
        middle, end = (pin + arm * (spin_rate * across + spin**2 * inward) for arm in (centre, rod))
        weight = np.array([0.0, gravity])
        power = masses[0] * (middle + weight) @ across * centre + masses[1] * (end + weight) @ across * rod
        power = (power + 2.5e-4 * spin_rate) / (rod * c)
        housing = HOUSING["mass"] * acceleration + HOUSING["stiffness"][1] * y + HOUSING["damping"][1] * rate
        return power + housing

    return [rate, -residual(0.0) / (residual(1.0) - residual(0.0))]


def test_a_guide_on_springs_moves_by_the_principle_of_d_alembert():
    grid = changed(slider_crank(), {"mechanism.mounts.slider-ground": HOUSING, "mechanism.gravity": 50.0, **IMPACTS})
    times = np.linspace(0.0, 0.3 * 2.0 * math.pi / SPEED, 31)
    motion = run(grid, times)
    exact = solve_ivp(
        guide_on_springs, times[[0, -1]], [0.0, 0.0], "DOP853", times, args=(50.0,), rtol=1e-12, atol=1e-16
    )
    across = motion.channels["joints/slider_ground/mount_y"]
    assert np.max(np.abs(across - exact.y[0])) < 1e-9 * np.max(np.abs(across))
    assert np.max(np.abs(motion.channels["joints/slider_ground/mount_x"])) < 1e-15
    assert motion.summary["energy_residual"] < 1e-12


LENGTHS = {"ground": 0.2, "crank": 0.05, "coupler": 0.18, "rocker": 0.12}
FOUR_BAR = {
    "type": "four-bar",
    **{name: {"length": length, "mass": 0.2, "inertia": 2e-4} for name, length in LENGTHS.items()},
    "ground": {"length": LENGTHS["ground"]},
}


@pytest.mark.slow
def test_a_four_bar_on_two_housings_keeps_its_energy():
    mounts = {name: {"mass": 1.0, "stiffness": [1e6, 2e6]} for name in ("ground-crank", "rocker-ground")}
    grid = MOUNTED | {"mechanism": FOUR_BAR | {"mounts": mounts, "gravity": 9.81}}
    motion = run(grid, np.linspace(0.0, 0.2, 101))
    assert motion.summary["energy_residual"] < 1e-11
    assert np.max(np.abs(motion.channels["joints/rocker_ground/mount_x"])) > 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["ground-crank", "slider-ground"])
def test_a_joint_with_clearance_in_a_housing_keeps_the_energy(joint):
    guide = {"clearance": 0.2e-3, "length": 0.03, "height": 0.02, "contact": JOINT["contact"]}
    grid = changed(slider_crank(), {"mechanism.slider.inertia": 1e-4, "mechanism.gravity": 9.81, **IMPACTS})
    grid |= {"joints": {joint: JOINT if joint == "ground-crank" else guide}}
    motion = run(changed(grid, {f"mechanism.mounts.{joint}": HOUSING}), np.linspace(0.0, 0.01, 11))
    assert motion.summary["energy_residual"] < 1e-9
    assert len(motion.events) > 2
    assert np.max(np.abs(motion.channels[f"joints/{joint.replace('-', '_')}/mount_y"])) > 1e-6


def journal_in_its_housing(time, state, onset):
    """Return the rates of crank pivot and housing: virtual work in x, y of the pivot, Newton for the housing.

    onset : m/s, at which the contact of Lankarani and Nikravesh began, or 0 while the journal is free
    """
    (x, y), place, (vx, vy), velocity = state.reshape(4, 2)
    crank, rod, centre, (of_crank, of_rod, of_slider) = 0.05, 0.12, 0.06, (0.30, 0.21, 0.14)
    outward = np.array([math.cos(SPEED * time), math.sin(SPEED * time)])
    turned = math.asin(-(y + crank * outward[1]) / rod)
    rod_axis, across = np.array([math.cos(turned), math.sin(turned)]), np.array([-math.sin(turned), math.cos(turned)])
    spin = -(vy + crank * SPEED * outward[0]) / (rod * rod_axis[0])
    relative, rate = np.array([x, y]) - place, np.array([vx, vy]) - velocity
    distance, push = math.hypot(*relative), np.zeros(2)
    if onset:
        normal, depth = relative / distance, max(distance - JOINT["clearance"], 0.0)
        loss = 0.75 * (1.0 - JOINT["contact"]["restitution"] ** 2) * (rate @ normal) / onset
        push = JOINT["contact"]["stiffness"] * depth**1.5 * (1.0 + loss) * normal

    def residual(acceleration):
        pin = acceleration - crank * SPEED**2 * outward
        spin_rate = spin**2 * rod_axis[1] / rod_axis[0] - pin[1] / (rod * rod_axis[0])
        middle, end = (pin + arm * (spin_rate * across - spin**2 * rod_axis) for arm in (centre, rod))
        weight = np.array([0.0, 9.81])
        force = of_crank * (acceleration - 0.025 * SPEED**2 * outward + weight) + of_rod * (middle + weight) + push
        couple = of_rod * centre * (middle + weight) @ across + of_slider * rod * end[0] * across[0]
        force[1] -= (couple + 2.5e-4 * spin_rate) / (rod * rod_axis[0])
        force[0] += of_slider * end[0]
        return force

    still = residual(np.zeros(2))
    columns = [residual(unit) - still for unit in np.eye(2)]
    springs = np.array(HOUSING["stiffness"]) * place + np.array(HOUSING["damping"]) * velocity
    accelerations = np.linalg.solve(np.transpose(columns), -still), (push - springs) / HOUSING["mass"]
    return np.concatenate([state[4:], *accelerations])


@pytest.mark.slow
def test_the_journal_of_a_housing_meets_it_as_in_a_second_program():
    """The first three contacts; the second program locates onsets and separations by events of scipy."""
    changes = {"mechanism.slider.inertia": 1e-4, "mechanism.gravity": 9.81, **IMPACTS, "simulate.tolerance": 1e-12}
    times = np.linspace(0.0, 5e-3, 201)
    grid = changed(slider_crank("ground-crank", changes=changes), {CRANK_MOUNT: HOUSING})
    motion = run(grid, times)

    def gap(time, state, onset):
        return math.hypot(*(state[:2] - state[2:4])) - JOINT["clearance"]

    gap.terminal, time, state, onset, events, paths = True, 0.0, np.zeros(8), 0.0, [], [np.zeros((8, 1))]
    while time < times[-1]:
        gap.direction = -1.0 if onset else 1.0
        later = times[times > time]
        part = solve_ivp(
            journal_in_its_housing,
            (time, times[-1]),
            state,
            "DOP853",
            later,
            events=gap,
            args=(onset,),
            rtol=1e-12,
            atol=1e-15,
            max_step=5e-6,
        )
        paths.append(part.y)
        if not part.t_events[0].size:
            break
        time, state = part.t_events[0][0], part.y_events[0][0]
        normal = (state[:2] - state[2:4]) / JOINT["clearance"]
        onset = 0.0 if onset else (state[4:6] - state[6:]) @ normal
        events.append((time, onset))
    exact = np.concatenate(paths, axis=1)
    assert motion.events["kind"][:6].tolist() == ["on", "off"] * 3
    assert len(events) == 6
    begins = [t for t, _ in events]
    assert motion.events["t"][:6] == pytest.approx(begins, abs=1e-10)
    relative = exact[:2] - exact[2:4]
    for k, axis in enumerate("xy"):
        assert np.max(np.abs(motion.channels[f"joints/ground_crank/{axis}"] - relative[k])) < 1e-6 * JOINT["clearance"]
        mount = motion.channels[f"joints/ground_crank/mount_{axis}"]
        assert np.max(np.abs(mount - exact[2 + k])) < 1e-6 * np.max(np.abs(exact[2:4]))


def test_a_damping_in_per_cent_follows_a_swept_stiffness():
    axes = {f"{CRANK_MOUNT}.stiffness.0": [1e6, 4e6], f"{CRANK_MOUNT}.damping.0": ["1 %", "2 %"]}
    swept = load(changed(MOUNTED, {f"{CRANK_MOUNT}.damping": "3 %"}) | {"sweep": axes}, simulation.catalogue())
    cases = map(swept.case, range(len(swept)))
    dampings = [mechanism_of(case).machine(case).mounts[0].damping[0] for case in cases]
    assert sorted(dampings) == pytest.approx([40.0, 80.0, 80.0, 160.0])
    load(swept.written_case(0), simulation.catalogue())  # with the default of the other key


@pytest.mark.slow
def test_the_answer_splits_an_error_into_clearance_housings_and_indentation(tmp_path):
    mount = {"mass": 4.0, "stiffness": 1e7, "damping": "5 %"}
    settings = {"simulate": {"revolutions": 6, "discard": 4}, "name": "split", CRANK_MOUNT: mount}
    grid = changed(slider_crank("rod-slider"), settings | {"joints.rod-slider.clearance": 50e-6, "drive.speed": SPEED})
    clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")
    answer = json.loads((tmp_path / "run" / "answer.json").read_text())
    largest = next(entry["largest"] for entry in answer["extremes"] if entry["figure"] == "slider_error_max")
    row = clearsweep.open(tmp_path / "run").summary.iloc[0]
    assert largest["mounts"] == row["slider_error_mounts"]
    clearance = largest["value"] - largest["mounts"] - largest.get("indentation", 0.0)
    assert clearance == pytest.approx(50e-6, rel=0.1)
    assert any("is the yield of housings" in sentence for sentence in answer["sentences"])


@pytest.mark.slow
def test_a_stiffness_is_sought_and_reported_without_any_clearance(tmp_path):
    stiffness = f"{CRANK_MOUNT}.stiffness.0"
    seek = {"smallest": stiffness, "between": [1e6, 1e8], "within": 5e6, "meeting": "limits", "for": "each"}
    settings = {"simulate": {"revolutions": 12, "discard": 8}, "limits": {"ground_crank_mount_motion_max": 0.15e-3}}
    grid = changed(MOUNTED, {f"{CRANK_MOUNT}.damping": "20 %", f"{CRANK_MOUNT}.stiffness": 4e6, "name": "seek"})
    clearsweep.sweep(grid | settings | {"seek": seek}, out=tmp_path / "run", executor="serial")
    answer = json.loads((tmp_path / "run" / "answer.json").read_text())
    assert any("The smallest stiffness along x of the mount of ground-crank" in text for text in answer["sentences"])
    page = report.write(clearsweep.open(tmp_path / "run"), tmp_path / "page.html").read_text(encoding="utf-8")
    assert "motion of the housing" in page


# A bearing housing that shifts on springs but does not turn, by two guides and a carriage without mass.


STIFFNESS, MASS, CLEARANCE, CONTACT = 2e5, 0.5, 50e-6, 1e10  # N/m, kg, m, N/m^1.5


def housing(shift, *, damping=0.0, force=0.0):
    """Return the grid of a journal at rest in a housing whose springs pull it to `shift` (m) along y."""
    given = {"loads.push": {"on": "housing", "force": [0.0, force]}} if force else {}
    for name, x, y in (("along", -1.0, 0.0), ("across", 0.0, -1.0)):
        given |= {f"loads.{name}.anchor": [x, y + shift], f"loads.{name}.damping": damping}
    return changed(grid_of("a housing on springs"), given)


def test_a_housing_on_springs_sways_at_the_frequency_of_its_mass():
    times = np.linspace(0.0, 0.02, 41)
    path = clearsweep.simulate(clearsweep.load_case(housing(20e-6)), times=times)
    exact = 20e-6 * (1.0 - np.cos(math.sqrt(STIFFNESS / MASS) * times))
    np.testing.assert_allclose(path["housing/y"], exact, atol=1e-9)
    np.testing.assert_allclose(path["housing/angle"], 0.0, atol=1e-15)
    assert len(path.events) == 0


def test_a_housing_shifted_beyond_the_clearance_rests_on_the_journal():
    shift = 120e-6
    path = clearsweep.simulate(clearsweep.load_case(housing(shift, damping=400.0)))
    place = brentq(lambda y: STIFFNESS * (shift - y) - CONTACT * (y - CLEARANCE) ** 1.5, CLEARANCE, shift)
    assert path.status == "ok"
    assert path["housing/y"][-1] == pytest.approx(place, rel=1e-5)
    assert path["joints/bearing/force_normal"][-1] == pytest.approx(STIFFNESS * (shift - place), rel=1e-4)
    assert path.summary["energy_residual"] < 1e-6


def test_a_load_shifts_its_housing_by_the_force_over_the_stiffness():
    path = clearsweep.simulate(clearsweep.load_case(housing(0.0, damping=400.0, force=5.0)))
    assert path["housing/y"][-1] == pytest.approx(5.0 / STIFFNESS, rel=1e-5)


def test_the_how_to_shows_a_housing_that_rests_on_the_journal(tmp_path):
    text = (Path(__file__).parents[1] / "docs/howto/mechanisms.md").read_text(encoding="utf-8")
    (grid,) = re.findall(r"```yaml\n(name: shifting-housing\n.*?)```", text, re.DOTALL)
    (tmp_path / "grid.yaml").write_text(grid, encoding="utf-8")
    for shift in (20e-6, 80e-6, 120e-6):
        case = clearsweep.load_case(tmp_path / "grid.yaml", overrides={"define.shift": f"{shift * 1e6} um"})
        force = clearsweep.simulate(case).summary["bearing_force_peak"]
        place = brentq(lambda y, s=shift: STIFFNESS * (s - y) - CONTACT * max(y - CLEARANCE, 0.0) ** 1.5, 0.0, shift)
        assert force == pytest.approx(CONTACT * max(place - CLEARANCE, 0.0) ** 1.5, rel=1e-3, abs=1e-9)
