"""Links that bend, against the exact bar and the second-order floating frame of another program, and in machines."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from mechanism_cases import changed, slider_crank
from right_grids import grid_of

import clearsweep
from clearsweep.report.one_case.motion import saved_channels
from clearsweep.report.sections import all_sections
from clearsweep.report.sections.cases import player_data
from clearsweep.report.study import prepare
from clearsweep.simulation.running.deformation import Rainflow, damage, turning_points

#: The exact inextensible bar (tangent angles against a chain of rigid bars, 1e-5), and a second-order floating frame
#: whose equations were checked against Lagrange's: the machine of Simeon 1996 over one revolution.
TRUTH = json.loads(Path(__file__).with_name("bending_rod.json").read_text(encoding="utf-8"))
SPEED, CRANK, LENGTH, HEIGHT, YOUNG = 150.0, 0.15, 0.3, 0.008, 200e9
TIMES = 2.0 * math.pi / SPEED * np.arange(1, 11) / 10
SIMEON = grid_of("a bending rod")
STEEL = {"section": [0.02, 0.012], "young": 210e9, "bending": 2, "damping": 0.01}


def simeon(**changes):
    """Return Simeon's machine; changes : of `elastic`, None removes a key."""
    return changed(SIMEON, {f"mechanism.rod.elastic.{name}": value for name, value in changes.items()})


def slider_error(motion):
    """Return the slider's place minus that with a rigid rod (m)."""
    angle = SPEED * motion.t
    ideal = CRANK * np.cos(angle) + np.sqrt(LENGTH**2 - (CRANK * np.sin(angle)) ** 2)
    return motion.channels["slider/place"] - ideal


def relative(values, reference):
    """Return the largest difference over the largest value."""
    return np.max(np.abs(values - np.array(reference))) / np.max(np.abs(reference))


@pytest.mark.few("2-simeon_damped")
@pytest.mark.parametrize("case", ["simeon", "simeon_damped"])
@pytest.mark.parametrize("modes", [1, 2, 3, 4])
def test_a_bending_rod_moves_as_the_second_order_floating_frame(case, modes):
    truth = TRUTH[case]
    motion = clearsweep.simulate(clearsweep.load_case(simeon(bending=modes, damping=truth["damping"])), TIMES)
    frame, deflection = truth["modes"][str(modes)], motion.channels["rod/deflection"]
    assert relative(deflection, frame["deflection_m"]) < 1e-6
    assert relative(slider_error(motion), frame["slider_error_m"]) < 1e-6
    exact = np.max(np.abs(deflection - np.array(truth["deflection_m"]))) / truth["largest_deflection_m"]
    assert exact < (5e-3 if modes < 3 else 1e-3)
    assert motion.summary["energy_residual"] < 1e-9


def test_an_ever_stiffer_rod_is_rigid():
    motion = clearsweep.simulate(clearsweep.load_case(simeon(young=1e6 * YOUNG, damping=0.01)), TIMES)
    assert np.max(np.abs(slider_error(motion))) < 1e-6 * CRANK
    assert np.max(np.abs(motion.channels["rod/deflection"])) < 1e-6 * LENGTH


@pytest.mark.slow
def test_a_rod_that_stretches_too_deflects_as_the_bar_with_axial_stiffness():
    truth = TRUTH["simeon"]["with_axial_stiffness"]
    motion = clearsweep.simulate(clearsweep.load_case(simeon(bending=4, segments=8)), TIMES)
    difference = np.abs(motion.channels["rod/deflection"] - np.array(truth["deflection_m"]))
    assert np.max(difference) < 2e-3 * truth["largest_deflection_m"]  # 1.5e-3 apart without stretch
    assert motion.summary["energy_residual"] < 1e-9


def crank_with_clearance(elastic=None, **changes):
    """Return the slider-crank with clearance at the slider's pin over a short run."""
    given = {"simulate.revolutions": 0.5, "simulate.tolerance": 1e-10} | changes
    given |= {"mechanism.rod.elastic": elastic} if elastic else {}
    return clearsweep.load_case(slider_crank("rod-slider", changes=given))


def test_impacts_of_a_bending_rod_are_located_and_its_energy_is_kept():
    bending, rigid = (clearsweep.simulate(crank_with_clearance(elastic)) for elastic in (STEEL, None))
    assert bending.summary["energy_residual"] < 1e-9
    assert len(bending.events) > 2
    first = bending.events["t"][0], rigid.events["t"][0]
    assert first[0] == pytest.approx(first[1], rel=0.05)
    assert first[0] != first[1]


@pytest.mark.slow
def test_a_slider_with_clearance_in_its_guide_hangs_on_a_bending_rod():
    """The slider is moved by the deflection of the rod's end, which is no unit vector in its mass matrix."""
    guide = {"clearance": 5e-5, "length": 0.03, "height": 0.02, "contact": {"law": "hertz", "stiffness": 1e9}}
    changes = {"mechanism.slider.inertia": 1e-4, "mechanism.rod.elastic": STEEL, "joints": {"slider-ground": guide}}
    case = slider_crank("rod-slider", changes=changes | {"simulate.revolutions": 0.2, "simulate.tolerance": 1e-10})
    summary = clearsweep.simulate(clearsweep.load_case(case)).summary
    assert summary["slider_ground_force_peak"] > 0.0
    assert summary["energy_residual"] < 1e-9


def normal_forces_of_rigid_rod(angles):
    """Return normal forces (N) in a uniform rigid rod, at the crank, at the slider and their mean, and its tilt (rad).

    They follow from Newton's law of rod and slider at crank angles.
    """
    mass, slider, rate = 0.151104, 0.075552, SPEED
    sine, cosine = np.sin(angles), np.cos(angles)
    tilt = -np.arcsin(CRANK / LENGTH * sine)  # of the rod
    spin = -CRANK / LENGTH * cosine * rate / np.cos(tilt)
    turn = (CRANK / LENGTH * sine * rate**2 + np.sin(tilt) * spin**2) / np.cos(tilt)
    axis, across = np.array([np.cos(tilt), np.sin(tilt)]), np.array([-np.sin(tilt), np.cos(tilt)])
    pin = -CRANK * rate**2 * np.array([cosine, sine])
    places = [pin + share * LENGTH * (turn * across - spin**2 * axis) for share in (0.0, 0.5, 1.0)]
    push = slider * places[2][0]  # along x, on the slider
    moment = mass * LENGTH**2 / 12.0 * turn + 0.5 * LENGTH * mass * np.sum(across * places[1], axis=0)  # about the pin
    lift = (moment + LENGTH * (-push) * np.sin(tilt)) / (LENGTH * np.cos(tilt))  # along y, of the slider on the rod
    at_slider = -push * np.cos(tilt) + lift * np.sin(tilt)
    near, middle, far = (np.sum(axis * place, axis=0) for place in places)
    return at_slider - mass * middle, at_slider, at_slider - mass * (near / 2.0 + (far - near) / 3.0), tilt


def test_the_normal_force_of_a_stiff_link_is_that_of_newtons_law():
    area = 64e-6
    stiff = simeon(section=None, area=area, second_moment=1e-4, edge=1e-9)
    stress = clearsweep.simulate(clearsweep.load_case(stiff)).summary["rod_stress_max"]
    at_crank, at_slider, _, _ = normal_forces_of_rigid_rod(np.linspace(0.0, 2.0 * math.pi, 7201))
    assert stress * area == pytest.approx(max(np.max(np.abs(at_crank)), np.max(np.abs(at_slider))), rel=1e-4)


@pytest.mark.slow
def test_a_rod_that_only_stretches_moves_the_slider_by_its_extension():
    stiffness = 1e7
    elastic = {"axial_stiffness": stiffness, "segments": 8, "damping": 0.9}
    changes = {"mechanism.rod.elastic": elastic, "simulate.revolutions": 3, "simulate.discard": 1}
    summary = clearsweep.simulate(clearsweep.load_case(changed(SIMEON, changes))).summary
    _, _, mean, tilt = normal_forces_of_rigid_rod(np.linspace(0.0, 2.0 * math.pi, 721))
    assert summary["slider_error_max"] == pytest.approx(np.max(np.abs(mean / stiffness / np.cos(tilt))), rel=0.02)
    assert summary["energy_residual"] < 1e-9


def test_deflection_frequency_and_error_of_a_run_are_those_of_the_bar():
    truth, damped = TRUTH["simeon_damped"], simeon(damping=0.01)
    summary = clearsweep.simulate(clearsweep.load_case(damped)).summary
    assert summary["rod_deflection_max"] == pytest.approx(truth["modes"]["2"]["largest_deflection_m"], rel=1e-6)
    assert summary["rod_frequency"] == pytest.approx(truth["first_rate_rad_s"] / (2.0 * math.pi), rel=1e-9)
    assert summary["slider_error_bending"] == pytest.approx(summary["slider_error_max"], rel=1e-3)


@pytest.mark.slow
def test_the_stress_at_the_edges_is_that_of_the_exact_bar():
    wide = simeon(section=None, area=1e3, second_moment=0.008**4 / 12.0, edge=0.004, bending=4, damping=0.01)
    summary = clearsweep.simulate(clearsweep.load_case(wide)).summary  # so wide that the normal force adds nothing
    assert summary["rod_stress_max"] == pytest.approx(TRUTH["simeon_damped"]["largest_stress_Pa"], rel=1e-2)


def test_the_stress_in_the_middle_is_that_of_the_exact_bar():
    truth = TRUTH["simeon_damped"]
    motion = clearsweep.simulate(clearsweep.load_case(simeon(damping=0.01)), TIMES)
    error = np.max(np.abs(motion.channels["rod/stress"] - np.array(truth["stress_Pa"]))) / truth["largest_stress_Pa"]
    assert error < 0.05  # of two modes
    assert np.all(motion.channels["rod/stress"] * motion.channels["rod/deflection"] < 0.0)


def test_the_page_of_a_sweep_without_clearance_shows_links_that_bend(tmp_path):
    swept = changed(simeon(damping=0.01), {"save.orbits": "all"})
    swept |= {"sweep": {"drive.speed": [100.0, SPEED]}, "limits": {"rod_stress_max": 1.2e8}}
    study = prepare(clearsweep.open(clearsweep.sweep(swept, tmp_path / "run").directory))
    sections = {section.key: section for section in all_sections(study)}
    assert {"bending-links", "main-effects"} <= sections.keys()
    sentences = " ".join(sections["bending-links"].sentences)
    assert "The drive turns at 0.12 of the first bending rate of rod." in sentences
    worst = study.cases.worst_case("rod_stress_max")
    player = player_data(study, worst, saved_channels(study.run, worst))
    (bend,) = [body["bend"] for body in player.data["bodies"] if "bend" in body]
    assert bend["name"] == "rod"
    assert bend["magnified"] == pytest.approx(0.06 * LENGTH / 1.75e-3, rel=0.1)
    assert {"deflection of rod", "stress of rod"} <= {chart["name"] for chart in player.data["charts"]}


def test_a_rod_that_folds_up_ends_its_case_at_once():
    folded = clearsweep.simulate(clearsweep.load_case(simeon(damping=0.01), {"drive.speed": 10.0 * SPEED}))
    assert folded.status == "bent-too-far"
    assert "more than a quarter of its length" in folded.message
    assert folded.summary["steps"] < 10_000


# Rainflow counting and damage, against the example of ASTM E1049 and closed forms.


#: ASTM E1049-85, figure 6: the history, and its half cycles by range.
HISTORY = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]
COUNTS = {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def counts_of(*pieces):
    """Return range -> count of a history in pieces."""
    rainflow, counts = Rainflow(), {}
    for cycles in [*[rainflow.add(np.array(piece)) for piece in pieces], rainflow.left()]:
        for size, count in cycles.tolist():
            counts[size] = counts.get(size, 0.0) + count
    return counts


def test_rainflow_counts_the_published_example():
    assert counts_of(HISTORY) == COUNTS


@pytest.mark.parametrize("cut", range(1, 2 * len(HISTORY)))
def test_pieces_and_points_between_turning_points_change_no_count(cut):
    middles = [0.5 * (first + second) for first, second in itertools.pairwise(HISTORY)]
    history = [value for pair in zip(HISTORY, [*middles, HISTORY[-1]], strict=True) for value in pair]
    assert counts_of(history[:cut], history[cut:]) == COUNTS
    assert counts_of(*[[value] for value in history]) == COUNTS


def test_constant_histories_have_no_cycles():
    assert counts_of([2.0, 2.0], [2.0]) == {}
    assert counts_of([]) == {}
    assert turning_points(np.array([1.0, 1.0, 2.0, 2.0, 1.0])).tolist() == [1.0, 2.0, 1.0]


def test_a_harmonic_stress_uses_up_its_life_in_the_given_cycles():
    rainflow, amplitude = Rainflow(), 150e6
    closed = rainflow.add(amplitude * np.cos(np.pi * np.arange(2001) / 10))  # 100 cycles
    cycles = np.concatenate([closed, rainflow.left()])
    assert cycles[:, 1].sum() == 100.0
    assert damage(cycles, 150e6, 5.0, 2e6) == pytest.approx(100 / 2e6, rel=1e-12)
    assert damage(cycles, 300e6, 5.0, 2e6) == pytest.approx(100 / 2e6 / 2**5, rel=1e-12)
    assert damage(np.zeros((0, 2)), 300e6, 5.0, 2e6) == 0.0


def test_damage_is_the_sum_over_amplitudes():
    cycles = np.array([[200e6, 3.0], [100e6, 0.5]])  # ranges
    assert damage(cycles, 100e6, 3.0, 1e6) == pytest.approx((3.0 + 0.5 / 8.0) / 1e6, rel=1e-14)


@pytest.mark.slow
def test_the_damage_of_a_rod_is_that_of_its_stress_at_the_middle():
    life = {"strength": 200e6, "exponent": 4.0, "cycles": 1e6}
    wide = {"section": None, "area": 1.0, "second_moment": 0.008 * HEIGHT**3 / 12.0, "edge": 0.5 * HEIGHT}
    grid = simeon(bending=1, damping=0.01, stress_life=life, **wide)  # its normal stress is nothing
    motion = clearsweep.simulate(clearsweep.load_case(grid), np.linspace(0.0, 2.0 * math.pi / SPEED, 20001))
    stress = YOUNG * 0.5 * HEIGHT * (math.pi / LENGTH) ** 2 * motion.channels["rod/deflection"]
    rainflow = Rainflow()
    cycles = np.concatenate([rainflow.add(stress), rainflow.left()])
    assert motion.summary["rod_damage"] == pytest.approx(damage(cycles, 200e6, 4.0, 1e6), rel=1e-3)
    assert motion.summary["rod_stress_max"] == pytest.approx(np.max(np.abs(stress)), rel=1e-3)
