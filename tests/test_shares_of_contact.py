"""What dry contact bears next to a film, and what friction heats: against time histories of the same motion."""

from types import SimpleNamespace

import numpy as np
import pytest
from mechanism_cases import changed, slider_crank
from spatial_cases import spatial

import clearsweep
from clearsweep import grid, simulation
from clearsweep.answers import validity
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.observe import BINS, FORCE_ROW, KAPPA_ROW, PARTS, add_profile, time_above
from clearsweep.mechanics.solver.totals import ContactTotals
from clearsweep.simulation.analyses.outcome import trajectory_of
from clearsweep.simulation.figures import catalogue
from clearsweep.simulation.figures.sums import DryTime, Ratio
from clearsweep.simulation.running.run import integration_of

pytestmark = pytest.mark.compiled  # as plain Python only what is marked plain

J = "joints.rod-slider"
STEEL = {"young": 207e9, "poisson": 0.3}
FRICTION = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}


def through_a_film(roughness):
    """Return the trajectory of a film of 2 mPa s and 50 um, 5.6 um thin at the least, whose asperities bear."""
    film = {"law": "short", "viscosity": 0.002, "transition": {"law": "greenwood-tripp", "roughness": roughness}}
    contact = {"law": "lankarani-nikravesh", "elastic": "johnson", "restitution": 0.9, "material": STEEL}
    changes = {
        "drive.speed": "3000 rpm",
        "simulate.revolutions": 0.1,
        "simulate.tolerance": 1e-6,
        "save": {"orbits": "all", "samples": 20000},
        f"{J}.clearance": 50e-6,
        f"{J}.film": film,
        f"{J}.contact": contact,
        f"{J}.friction": FRICTION,
    }
    path = clearsweep.simulate(clearsweep.load_case(changed(slider_crank("rod-slider"), changes)))
    assert path.status == "ok", path.message
    return path


def share_of(path, figure):
    return path.summary[f"rod_slider_{figure}"]


# ---------------------------------------------------------------------------------------------- with a film


@pytest.mark.plain
@pytest.mark.parametrize("roughness", [2e-6, 5e-6])
def test_the_dry_share_is_that_of_the_time_histories(roughness):
    path = through_a_film(roughness)
    total, dry = (np.abs(path[f"joints/rod_slider/force_{name}"]) for name in ("normal", "dry"))
    share = np.trapezoid(dry, path.t) / np.trapezoid(total, path.t)
    assert share_of(path, "dry_load_share") == pytest.approx(share, rel=1e-4)
    load = np.trapezoid(total, path.t) / path.t[-1]
    assert share_of(path, "dry_fraction") == pytest.approx(np.mean(dry > 1e-3 * load), abs=2e-3)
    assert share_of(path, "dry_fraction") + share_of(path, "film_fraction") == pytest.approx(1.0, abs=1e-12)


@pytest.mark.plain
def test_a_film_whose_asperities_bear_a_few_millionths_of_the_load_bears_alone():
    """They bear something for a third of the time."""
    path = through_a_film(1.5e-6)
    assert np.mean(path["joints/rod_slider/force_dry"] > 0.0) > 0.3
    assert 0.0 < share_of(path, "dry_load_share") < 1e-5
    assert (share_of(path, "dry_fraction"), share_of(path, "film_fraction")) == (0.0, 1.0)


@pytest.mark.parametrize(("first", "last"), [(0.0, 40.0), (40.0, 0.0), (3.0, 3.0), (1e-9, 2e-9)])
def test_a_course_spends_above_a_force_the_share_of_the_step_that_it_is_there(first, last):
    """Forces below all bins are in the lowest one."""
    step_values, filled = np.zeros((FORCE_ROW + KAPPA_ROW + 1, PARTS + 1)), np.zeros((1, BINS, 2))
    step_values[FORCE_ROW], step_values[KAPPA_ROW] = np.linspace(first, last, PARTS + 1), 3.0
    add_profile(filled, 0, step_values, 0.7, (np.zeros((3, PARTS)), np.zeros(PARTS + 1, int)))
    assert time_above(0.0, filled[0]) == pytest.approx(0.7, rel=1e-12)
    for force in (1.0, 10.0, 30.0):
        low, high = sorted((first, last))
        share = np.clip((high - force) / (high - low), 0.0, 1.0) if high > low else float(force < high)
        assert time_above(force, filled[0]) == pytest.approx(0.7 * share, rel=1e-6, abs=1e-12)


def test_a_step_without_dry_force_enters_nothing():
    step_values, filled = np.zeros((FORCE_ROW + KAPPA_ROW + 1, PARTS + 1)), np.zeros((1, BINS, 2))
    step_values[KAPPA_ROW] = 1.0
    add_profile(filled, 0, step_values, 0.7, (np.zeros((3, PARTS)), np.zeros(PARTS + 1, int)))
    assert not filled.any()


def blocks(loads, dry):
    """Return what blocks of 1 s sum up: load (N), dry force (N) for half of the time, in each."""
    taken, sums = [], []
    joint, filled = ContactTotals.zeros(1), np.zeros((1, BINS, 2))
    for load, force in [(0.0, 0.0), *zip(loads, dry, strict=True)]:
        step_values = np.zeros((FORCE_ROW + KAPPA_ROW + 1, PARTS + 1))
        step_values[FORCE_ROW], step_values[KAPPA_ROW] = force, 1.0
        add_profile(filled, 0, step_values, 0.5, (np.zeros((3, PARTS)), np.zeros(PARTS + 1, int)))
        joint[0].load_time += load
        joint[0].dry_force_time += 0.5 * force
        totals = SimpleNamespace(joint=joint, dry=filled)
        taken.append(DryTime(above=True).take(totals, 0))
        sums.append(Ratio("dry_force_time", "load_time").take(totals, 0))
    return np.arange(len(loads) + 1.0), taken, sums


def test_shares_of_blocks_are_those_of_their_mean_load():
    """0.9 N is below a thousandth of 1000 N, the mean; 2 N in three blocks of four is above it for half a second."""
    times, taken, sums = blocks([500.0, 1500.0, 1000.0, 1000.0], [2.0, 2.0, 0.9, 2.0])
    share, width = DryTime(above=True).over_blocks(times, taken, 1)
    assert share == pytest.approx(0.375, rel=1e-12)
    assert DryTime(above=False).over_blocks(times, taken, 1) == (pytest.approx(0.625, rel=1e-12), width)
    assert width > 0.1
    ratio, around = Ratio("dry_force_time", "load_time").over_blocks(times, sums, 1)
    assert ratio == pytest.approx(3.45 / 4000.0, rel=1e-12)
    assert 0.0 < around < 2.0 * ratio
    _, _, even = blocks([500.0, 1500.0, 1000.0], [1.0, 3.0, 2.0])  # the same share in every block
    share = Ratio("dry_force_time", "load_time").over_blocks(np.arange(4.0), even, 1)
    assert share == pytest.approx((1e-3, 0.0), abs=1e-15)


# ---------------------------------------------------------------------------------------------- friction


@pytest.mark.plain
@pytest.mark.parametrize("joint", ["crank-rod", "rod-slider"])
def test_the_power_of_friction_is_that_of_the_time_histories(joint):
    """Minus tangential force times the sliding of the surfaces: that of the centres across and that of the spins."""
    changes = {
        "simulate.revolutions": 0.05,
        "simulate.start": "seated",
        "save": {"orbits": "all", "samples": 40000},
        f"joints.{joint}.friction": FRICTION,
    }
    path = clearsweep.simulate(clearsweep.load_case(slider_crank(joint, changes=changes)))
    column, bearing = joint.replace("-", "_"), {"crank-rod": 2.0 * np.pi * 5000.0 / 60.0, "rod-slider": 0.0}[joint]
    x, y, vx, vy = (path[f"joints/{column}/{name}"] for name in ("x", "y", "vx", "vy"))
    across = (vy * x - vx * y) / np.hypot(x, y)
    slip = across + (0.01 - 5e-4) * path["rod/rate"] - 0.01 * bearing
    power = -path[f"joints/{column}/force_tangential"] * slip
    mean = np.trapezoid(power, path.t) / path.t[-1]
    assert mean > 1.0
    assert path.summary[f"{column}_friction_power"] == pytest.approx(mean, rel=1e-3)


@pytest.mark.plain
def test_friction_at_walls_and_flanges_of_a_joint_in_space_is_all_that_is_rubbed():
    """Against what the energy ledger, from the powers of all points, says of the only joint that rubs."""
    changes = {"simulate.revolutions": 0.1, "simulate.tolerance": 1e-7, "drive.speed": 200.0}
    source = changed(spatial(friction=FRICTION, tilt=[2e-3, 2e-3], axial_clearance=4e-5), changes)
    scene = clearsweep.load_case(source)
    end = scene.crank_clock.value_after(0.1)
    with np.errstate(all="ignore"):  # as compiled code does
        run = integration_of(scene, np.empty(0), end)
    rubbed = run.work.totals.mechanism.energy_friction
    summary = trajectory_of(scene, run, end).summary
    assert summary["crank_rod_axial_force_peak"] > 0.0
    assert rubbed > 0.0
    assert summary["crank_rod_friction_power"] * end == pytest.approx(rubbed, rel=1e-9)


@pytest.mark.parametrize(
    ("contact", "length", "elastic", "flagged"),
    [
        ({"law": "hertz", "material": STEEL}, 0.02, "compatible", False),
        ({"law": "hertz", "material": STEEL}, None, "power", True),
        ({"law": "hertz", "material": STEEL, "elastic": "power"}, 0.02, "power", True),
        ({"law": "hertz", "material": STEEL, "exponent": 1.5}, 0.02, "power", True),
        ({"law": "hertz", "material": STEEL, "stiffness": 1e10}, 0.02, "power", False),
        ({"law": "hertz", "stiffness": 1e10}, 0.02, "power", False),
        ({"law": "kogut-etsion", "material": STEEL, "hardness": 2e9}, 0.02, "power", False),
    ],
)
def test_the_default_elastic_law_is_that_of_a_journal_where_it_can_be(contact, length, elastic, flagged):
    """A law that is made for a ball keeps it, and a ball's stiffness from the material is remarked on."""
    source = slider_crank("rod-slider", changes={f"{J}.contact": contact, f"{J}.length": length})
    (joint,) = clearsweep.load_case(source).case.joints
    assert joint.contact.elastic == elastic
    assert registry.uses_ball_stiffness(joint) == flagged
    remark = validity.ball_stiffness_remark([joint.name] if flagged else [])
    assert ("rod-slider has the stiffness of a ball in a socket" in remark) == flagged


def test_a_swept_stiffness_or_law_that_needs_a_ball_keeps_the_power():
    for path, values in (
        (f"{J}.contact.stiffness", [1e9, 1e10]),
        (f"{J}.contact.law", ["hertz", "kogut-etsion"]),
    ):
        contact = {"law": "hertz", "material": STEEL, "hardness": 2e9}
        source = slider_crank("rod-slider", changes={f"{J}.contact": contact})
        if path.endswith("stiffness"):
            del source["joints"]["rod-slider"]["contact"]["hardness"]
        cases = grid.load(source | {"sweep": {path: values}}, simulation.catalogue())
        assert [cases.case(k).joints[0].contact.elastic for k in range(2)] == ["power", "power"]


def test_a_joint_without_friction_has_no_power_of_it():
    columns = {column.name for column in clearsweep.load_case(slider_crank("crank-rod")).layout.columns}
    assert "crank_rod_friction_power" not in columns
    rubbing = clearsweep.load_case(slider_crank("crank-rod", changes={"joints.crank-rod.friction": FRICTION}))
    columns = {column.name: column.unit for column in rubbing.layout.columns}
    assert columns["crank_rod_friction_power"] == "W"


def test_friction_that_would_heat_a_dry_joint_by_more_than_100_k_is_flagged():
    assert validity.friction_heat_remark([("rod-slider", 99.9, None)]) == ""
    remark = validity.friction_heat_remark([("crank-rod", 5.0, None), ("rod-slider", 124.2, None)])
    assert remark == "friction-heat: rod-slider: friction power 124 W would heat a dry joint by some 124 K at 1 W/K"
    result = validity.Remarks(["rod_slider"])
    result.add(
        {
            "case_id": ["a"],
            "message": [remark],
            "rod_slider_onset_rate_max": [0.0],
            "rod_slider_yield_speed": [float("nan")],
            "rod_slider_law_limit_fraction": [0.0],
        }
    )
    (sentence,) = result.sentences()
    assert "1 of 1 case" in sentence
    assert "124 K" in sentence


def test_every_new_figure_is_shown_in_the_report():
    shown = {figure.name: figure.tables for figure in catalogue.FIGURES}
    assert shown["friction_power"]
    assert shown["dry_load_share"]
