"""Wear: what the bins hold, in which frame, and how much in all."""

import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import grid, simulation
from clearsweep.mechanics.joint.dry import Joint
from clearsweep.mechanics.joint.wear.archard import Arc, Archard, spread
from clearsweep.mechanics.joint.wear.contract import ACCOUNT, NARROW, Bins, Rubbing, wear_rate
from clearsweep.mechanics.joint.wear.pressure import HertzLine, Mean

BINS = 360
WEAR = {"law": "archard", "coefficient": 2e-14, "bins": BINS}


LINE = HertzLine(1e11, 0.01 * 0.0095 / 0.0005)


def worn_joint(bearing, journal, pressure=LINE):
    law = Archard(bearing, journal, float(BINS), 0.02, pressure)
    return Joint(0.5e-3, 0.01, 0.0095, 1.0, (), (), (), law)


def turn_journal(joint, force, turns, steps):
    """Return the depths of bearing and journal after the journal turned under a force of fixed direction."""
    depths = np.zeros(2 * BINS)
    bins = Bins(depths, 0, BINS, np.zeros(ACCOUNT))
    way = 2.0 * math.pi * joint.journal_radius * turns / steps
    for step in range(steps):
        angle = -2.0 * math.pi * turns * (step + 0.5) / steps
        wear_rate(joint.wear, joint, Rubbing(force, 1e-6, way, 0.3, angle), bins)
    return depths[:BINS], depths[BINS:]


def test_only_the_journal_wears_and_every_material_point_meets_the_contact_once_a_turn():
    coefficient, force, turns = 1e-14, 1000.0, 3
    bearing, journal = turn_journal(worn_joint(0.0, coefficient), force, turns, 3 * 7200)
    expected = turns * coefficient * force / 0.02  # k times the line load, per turn
    assert np.all(bearing == 0.0)
    assert journal == pytest.approx(expected, rel=1e-6, abs=0.0)


def test_only_the_bearing_wears_with_the_profile_of_the_pressure_at_the_load():
    coefficient, force = 1e-14, 1000.0
    joint = worn_joint(coefficient, 0.0)
    bearing, journal = turn_journal(joint, force, 2, 100)
    way = 2.0 * math.pi * joint.journal_radius * 2
    half_width = math.sqrt(4.0 * (force / 0.02) * joint.wear.pressure.radius / (math.pi * joint.wear.pressure.modulus))
    edges = (np.arange(BINS + 1) * 2.0 * math.pi / BINS - 0.3) * joint.bearing_radius / half_width
    x = np.clip(edges, -1.0, 1.0)
    held = np.diff(0.5 + (x * np.sqrt(1.0 - x**2) + np.arcsin(x)) / math.pi)
    width = 2.0 * math.pi / BINS * joint.bearing_radius
    assert np.all(journal == 0.0)
    assert bearing == pytest.approx(coefficient * way * force / 0.02 * held / width, rel=1e-9, abs=1e-30)
    assert np.argmax(bearing) == int(0.3 / (2.0 * math.pi) * BINS)


@pytest.mark.parametrize("pressure", [LINE, Mean()])
@pytest.mark.parametrize("angle", [0.0, 1e-9, 3.1, 6.28318, -7.0, 100.0])
@pytest.mark.parametrize("half_arc", [0.0, 1e-9, 0.003, 0.3, 1.5])
def test_spreading_loses_nothing_wherever_the_arc_lies(pressure, angle, half_arc):
    depths = np.zeros(BINS)
    spread(pressure, Arc(angle, half_arc, 1.0), depths, 0, BINS)
    assert depths.sum() * 2.0 * math.pi / BINS == pytest.approx(1.0, rel=1e-12)
    assert depths.min() >= 0.0


@pytest.mark.parametrize("pen", [1e-9, 5e-6, 0.4e-3])
def test_a_mean_pressure_wears_the_geometric_arc_evenly_and_takes_k_f_s_off_each_body(pen):
    coefficient, force, way = 1e-14, 1000.0, 0.7
    joint = worn_joint(coefficient, 2.0 * coefficient, Mean())
    bins = Bins(np.zeros(2 * BINS), 0, BINS, np.zeros(ACCOUNT))
    wear_rate(joint.wear, joint, Rubbing(force, pen, way, 1.0, 4.0), bins)
    theta = math.acos(0.5e-3 / (0.5e-3 + pen))
    edges, width = np.arange(BINS + 1) * 2.0 * math.pi / BINS, 2.0 * math.pi / BINS
    for k, depths, angle, radius in (
        (coefficient, bins.depths[:BINS], 1.0, joint.bearing_radius),
        (2.0 * coefficient, bins.depths[BINS:], 4.0, joint.journal_radius),
    ):
        covered = np.diff(np.clip(edges, angle - theta, angle + theta)) / width
        pressure = force / 0.02 / (2.0 * radius * theta)
        assert depths == pytest.approx(k * pressure * way * covered, rel=1e-6, abs=1e-22)
        assert np.sum(depths) * width * radius * 0.02 == pytest.approx(k * force * way, rel=1e-12, abs=0.0)
    assert bins.account[NARROW] == (2.0 * theta < 5.0 * width)


def run(**changes):
    case = {"joints.rod-slider.wear": WEAR, "simulate.revolutions": 2, "simulate.discard": 1, **changes}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=case))
    trajectory = clearsweep.simulate(scene)
    assert trajectory.status == "ok"
    return scene, trajectory


@pytest.mark.compiled
@pytest.mark.parametrize("start", ["centred", "seated"])
def test_worn_volume_is_the_coefficient_times_force_times_way(start):
    """The way is integrated from samples: slip = rate along the tangent plus the turning of the rod's pin."""
    changes = {"simulate.start": start, "joints.rod-slider.contact.restitution": 0.3}
    _, trajectory = run(**{**changes, "save.orbits": "last", "save.revolutions": 1, "save.samples": 200000})
    x, y = trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"]
    size = np.maximum(np.hypot(x, y), 1e-12)
    tangential = (-y * trajectory["joints/rod_slider/vx"] + x * trajectory["joints/rod_slider/vy"]) / size
    slip = np.abs(tangential + trajectory["rod/rate"] * 9.5e-3)
    work = np.trapezoid(trajectory["joints/rod_slider/force_normal"] * slip, trajectory.t)
    assert trajectory.summary["rod_slider_wear_volume"] == pytest.approx(2 * 2e-14 * work, rel=2e-3, abs=0.0)


@pytest.mark.compiled
@pytest.mark.parametrize("name", ["ground-crank", "crank-rod", "rod-slider"])
def test_bins_turn_with_their_bodies(name):
    """The mean direction of wear on both bodies is what samples of force, sliding and direction say."""
    changes = {f"joints.{name}.wear": WEAR, "save.orbits": "all", "save.revolutions": 1, "save.samples": 100000}
    trajectory = clearsweep.simulate(clearsweep.load_case(slider_crank(name, changes=changes)))
    joint = name.replace("-", "_")
    x, y = trajectory[f"joints/{joint}/x"], trajectory[f"joints/{joint}/y"]
    crank, rod, still = trajectory["crank_angle"], trajectory["rod/angle"], 0.0 * trajectory.t
    bearing, journal = {"ground-crank": (still, crank), "crank-rod": (crank, rod), "rod-slider": (still, rod)}[name]
    tangential = -y * trajectory[f"joints/{joint}/vx"] + x * trajectory[f"joints/{joint}/vy"]
    spin = 9.5e-3 * np.gradient(journal, trajectory.t) - 1e-2 * np.gradient(bearing, trajectory.t)
    slip = np.abs(tangential / np.maximum(np.hypot(x, y), 1e-12) + spin)
    work = trajectory[f"joints/{joint}/force_normal"] * slip
    for body, depths in zip((bearing, journal), trajectory.wear[joint], strict=True):
        sampled = np.sum(work * np.exp(1j * (np.arctan2(y, x) - body))) / work.sum()
        binned = np.sum(depths * np.exp(1j * (np.arange(BINS) + 0.5) * 2.0 * math.pi / BINS)) / depths.sum()
        assert abs(binned - sampled) < 0.01


@pytest.mark.compiled
def test_the_pressure_that_a_grid_names_acts():
    """The tenth harmonic of the bearing's wear: a contact of half arc theta leaves sin(10 theta) / (10 theta) of it."""
    changes = {"save.orbits": "last", "save.revolutions": 1, "save.samples": 100000}
    worn = {
        pressure: run(**changes, **{"joints.rod-slider.wear": WEAR | {"pressure": pressure}})[1]
        for pressure in ("hertz-line", "mean")
    }
    mean = worn["mean"]
    x, y = mean["joints/rod_slider/x"], mean["joints/rod_slider/y"]
    size = np.maximum(np.hypot(x, y), 1e-12)
    slip = (x * mean["joints/rod_slider/vy"] - y * mean["joints/rod_slider/vx"]) / size + mean["rod/rate"] * 9.5e-3
    work = mean["joints/rod_slider/force_normal"] * np.abs(slip)
    theta = np.arccos(np.minimum(0.5e-3 / size, 1.0))
    tenth = np.exp(10j * np.arctan2(y, x)) * np.sinc(10.0 * theta / math.pi)
    sampled = np.sum(work * tenth) / work.sum()
    places = (np.arange(BINS) + 0.5) * 2.0 * math.pi / BINS
    binned = {name: np.sum(each.wear["rod_slider"][0] * np.exp(10j * places)) for name, each in worn.items()}
    binned = {name: value / worn[name].wear["rod_slider"][0].sum() for name, value in binned.items()}
    assert abs(binned["mean"] - sampled) < 0.01
    assert abs(binned["hertz-line"] - sampled) > 0.05
    line = worn["hertz-line"].summary
    assert mean.summary["rod_slider_wear_volume"] == pytest.approx(line["rod_slider_wear_volume"], rel=1e-9, abs=0.0)
    assert mean.summary["rod_slider_force_peak"] == line["rod_slider_force_peak"]


def case_of(pressure=None, **changes):
    wear = WEAR | ({"pressure": pressure} if pressure else {})
    source = slider_crank("rod-slider", changes={"joints.rod-slider.wear": wear} | changes)
    return grid.load(source, simulation.catalogue())


def test_a_pressure_left_out_is_that_of_a_line_contact_and_the_same_case():
    assert case_of().case_id(0) == case_of("hertz-line").case_id(0) != case_of("mean").case_id(0)


def test_only_a_pressure_that_needs_a_modulus_asks_for_it():
    spring = {"joints.rod-slider.contact": {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 100.0}}
    assert len(case_of("mean", **spring)) == 1
    with pytest.raises(clearsweep.InputError, match="the pressure of wear needs Young's modulus"):
        case_of("hertz-line", **spring)


@pytest.mark.compiled
def test_figures_of_wear_are_those_of_the_bins():
    scene, trajectory = run()
    bearing, journal = trajectory.wear["rod_slider"]
    assert bearing.shape == journal.shape == (BINS,)
    assert bearing.min() >= 0.0 <= journal.min()
    deepest = max(bearing.max(), journal.max())
    assert trajectory.summary["rod_slider_wear_depth_max"] == deepest > 0.0
    assert trajectory.summary["rod_slider_wear_rate_max"] == pytest.approx(deepest / 0.012, rel=1e-12, abs=0.0)
    assert scene.value.joints[0].wear.pressure.modulus == pytest.approx(0.75 * 6.61e10 / math.sqrt(0.19), rel=1e-12)


@pytest.mark.compiled
def test_wear_does_not_change_the_motion():
    with_wear = run()[1]
    without = clearsweep.simulate(
        clearsweep.load_case(slider_crank("rod-slider", changes={"simulate.revolutions": 2, "simulate.discard": 1}))
    )
    assert with_wear.summary["rod_slider_force_peak"] == without.summary["rod_slider_force_peak"]
    assert with_wear.summary["steps"] == without.summary["steps"]


@pytest.mark.compiled
def test_a_body_with_coefficient_zero_keeps_its_shape():
    wear = {"law": "archard", "bearing_coefficient": 1e-14, "journal_coefficient": 0.0}
    try:
        _, trajectory = run(**{"joints.rod-slider.wear": wear})
    except clearsweep.InputError as error:
        pytest.fail(str(error))
    bearing, journal = trajectory.wear["rod_slider"]
    assert bearing.max() > 0.0
    assert np.all(journal == 0.0)
