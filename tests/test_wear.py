"""Wear: what the bins hold, in which frame, and how much in all."""

import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import grid, simulation
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.dry import Joint
from clearsweep.mechanics.observe import DEPTH_ROW, FORCE_ROW, KAPPA_ROW, PARTS, SLIP_ROW, STEP_VALUE_ROWS
from clearsweep.mechanics.solver import integration, loop
from clearsweep.mechanics.wear import (
    ACCOUNT_SIZE,
    MAX_BINS,
    Account,
    Bins,
    JointAccount,
    SlidingContact,
    Worn,
    half_arc,
    pressure_integral_over_load,
)
from clearsweep.mechanics.wear.arc import POINTS, WORKSPACE_SIZE, StepRows, workspace_of
from clearsweep.mechanics.wear.bins import update_worn_profile
from clearsweep.mechanics.wear.laws import Archard, HertzLine, Persson, UniformPressure, Winkler
from clearsweep.simulation.figures.window import interpolated_depths
from clearsweep.simulation.running.run import Run
from clearsweep.simulation.setup.start import start_of

BINS = 360
BEARING, JOURNAL = (StepRows.index_of(f"{body}_angle") for body in ("bearing", "journal"))
WEAR = {"law": "archard", "coefficient": 2e-14, "bins": BINS}
STEEL = 207e9 / (2.0 * (1.0 - 0.3**2))  # Pa, E* of steel on steel
LINE_WEAR = WEAR | {"pressure": "hertz-line", "pressure_modulus": STEEL}


LINE = HertzLine(math.sqrt(4.0 * (0.01 * 0.0095 / 0.0005) / (math.pi * 1e11)))


def worn_joint(bearing, journal, pressure=LINE):
    law = Archard(bearing, journal, float(BINS), 0.02, pressure, math.inf)
    return Joint(0.5e-3, 0.01, 0.0095, 1.0, (), (), (), law)


def slide(joint, force, *, turns=0.0, way=0.0, pen=1e-6, at=(0.3, 0.0)):
    """Return the depths of bearing and journal after a step under a steady force of fixed direction.

    The journal turns by `turns` turns under the contact, or slides by `way` (m) with the contact staying where it is.
    """
    polynomials, step_values = np.zeros((StepRows.SIZE, POINTS)), np.zeros((STEP_VALUE_ROWS, PARTS + 1))
    way = way or 2.0 * math.pi * joint.journal_radius * turns
    for row, value in ((FORCE_ROW, force / 0.02), (KAPPA_ROW, 1.0), (SLIP_ROW, way), (DEPTH_ROW, pen)):
        polynomials[row, 0], step_values[row] = value, value
    polynomials[BEARING, 0] = at[0]
    polynomials[JOURNAL, :2] = at[1], -2.0 * math.pi * turns
    return both(joint, polynomials, step_values)


def both(joint, polynomials, step_values):
    """Return the depths of bearing and journal after a step with these courses."""
    depths, workspace = np.zeros(2 * BINS), workspace_of(np.zeros(WORKSPACE_SIZE))
    workspace.step.numbers[: len(polynomials)] = polynomials
    bins = (Bins(depths, 0, BINS), Bins(depths, BINS, BINS))
    account = JointAccount(Account(np.zeros(ACCOUNT_SIZE)), 1.0)
    update_worn_profile(joint, workspace, step_values, 1.0, bins, account)
    return depths[:BINS], depths[BINS:]


def shares(x):
    """Return the share of Hertz's elliptic load that lies before `x` of the arc."""
    x = np.clip(x, -1.0, 1.0)
    return 0.5 + (x * np.sqrt(1.0 - x**2) + np.arcsin(x)) / math.pi


def test_a_wearing_journal_meets_the_contact_at_each_point_once_a_turn():
    coefficient, force, parts = 1e-14, 1000.0, 60  # a step spans at most 0.02 turns
    total = np.zeros(BINS)
    for part in range(parts):
        bearing, journal = slide(
            worn_joint(0.0, coefficient), force, turns=1.0 / parts, at=(0.3, -2.0 * math.pi * part / parts)
        )
        assert np.all(bearing == 0.0)
        total += journal
    expected = coefficient * force / 0.02  # k times the line load, per turn
    assert total == pytest.approx(expected, rel=1e-6, abs=0.0)


@pytest.mark.parametrize(("body", "radius"), [(0, 0.01), (1, 0.0095)])
def test_the_profile_is_that_of_the_pressure_on_an_arc_of_the_bodys_own_radius(body, radius):
    coefficient, force, way = 1e-14, 1000.0, 0.1
    joint = worn_joint(coefficient, coefficient)
    depths = slide(joint, force, way=way, at=(0.3, 0.3))[body]
    half_width = math.sqrt(4.0 * (force / 0.02) * 0.19 / (math.pi * 1e11))
    edges = (np.arange(BINS + 1) * 2.0 * math.pi / BINS - 0.3) * radius / half_width
    width = 2.0 * math.pi / BINS * radius
    contents = np.diff(shares(edges))
    assert depths == pytest.approx(coefficient * way * force / 0.02 * contents / width, rel=1e-9, abs=1e-24)
    assert np.argmax(depths) == int(0.3 / (2.0 * math.pi) * BINS)


@pytest.mark.parametrize("pressure", [LINE, UniformPressure(), Winkler(), Persson(1e11)])
@pytest.mark.parametrize("angle", [0.0, 1e-9, 3.1, 6.28318, -7.0, 100.0])
@pytest.mark.parametrize(("force", "pen"), [(1e-12, 1e-18), (10.0, 1e-8), (1e5, 1e-5), (1e9, 0.4)])
def test_a_step_loses_nothing_wherever_the_arc_lies(pressure, angle, force, pen):
    joint = worn_joint(1e-14, 1e-14, pressure)
    arc = half_arc(
        pressure, joint, joint.bearing_radius, SlidingContact(force / 0.02, pen, 0.0, 0.0, 0.0, 0.0, 0.5e-3, 0.0)
    )
    pressed = force / 0.02 * pressure_integral_over_load(pressure, arc)
    for depths, radius in zip(slide(joint, force, turns=0.01, pen=pen, at=(angle, angle)), (0.01, 0.0095), strict=True):
        way = 2.0 * math.pi * 0.0095 * 0.01
        assert depths.sum() * 2.0 * math.pi / BINS == pytest.approx(1e-14 * pressed * way / radius, rel=1e-12)
        assert depths.min() >= 0.0


@pytest.mark.parametrize("pen", [1e-9, 5e-6, 0.4e-3])
def test_a_mean_pressure_bears_the_load_over_the_geometric_arc_and_wears_it_evenly(pen):
    coefficient, force, way = 1e-14, 1000.0, 0.7
    joint = worn_joint(coefficient, 2.0 * coefficient, UniformPressure())
    bearing, journal = slide(joint, force, way=way, pen=pen, at=(1.0, 4.0))
    theta = math.acos(0.5e-3 / (0.5e-3 + pen))
    edges, width = np.arange(BINS + 1) * 2.0 * math.pi / BINS, 2.0 * math.pi / BINS
    for k, depths, angle, radius in (
        (coefficient, bearing, 1.0, joint.bearing_radius),
        (2.0 * coefficient, journal, 4.0, joint.journal_radius),
    ):
        covered = np.diff(np.clip(edges, angle - theta, angle + theta)) / width
        pressure = force / 0.02 / (2.0 * radius * math.sin(theta))  # its parts along the load come to the load
        assert depths == pytest.approx(k * pressure * way * covered, rel=1e-6, abs=1e-22)
        volume = k * force * way * theta / math.sin(theta)
        assert np.sum(depths) * width * radius * 0.02 == pytest.approx(volume, rel=1e-12, abs=0.0)


def test_an_arc_that_travels_and_grows_within_a_step_leaves_the_exact_means():
    """Against ten thousand arcs that rest still, of a force that rises as in an impact."""
    joint, count = worn_joint(1e-14, 1e-14), 10000
    polynomials, step_values = np.zeros((StepRows.SIZE, POINTS)), np.ones((STEP_VALUE_ROWS, PARTS + 1))
    polynomials[FORCE_ROW, :3] = 2.5e5, 3e5, -5e4  # N/m
    polynomials[KAPPA_ROW, 0], polynomials[SLIP_ROW, 0] = 1.0, 1e-3
    polynomials[BEARING, :3] = 0.3, 0.06, -0.02
    depths, _ = both(joint, polynomials, step_values)
    x = (np.arange(count) + 0.5) / count
    load = 2.5e5 + 3e5 * x - 5e4 * x**2
    half = np.sqrt(4.0 * load * 0.19 / (math.pi * 1e11)) / 0.01
    edges = np.arange(60) * 2.0 * math.pi / BINS
    before = [
        np.sum(1e-14 * load * 1e-3 / 0.01 / count * shares((edge - 0.3 - 0.06 * x + 0.02 * x**2) / half))
        for edge in edges
    ]
    naive = np.diff(before) / (2.0 * math.pi / BINS)
    assert depths[:59] == pytest.approx(naive, rel=0.0, abs=1e-6 * naive.max())


@pytest.mark.parametrize("pressure", [LINE, UniformPressure(), Winkler(), Persson(1e11)])
@pytest.mark.parametrize(("travel", "turn"), [(0.06, -0.02), (0.02, -0.05), (-1.3, 0.4), (0.0, 0.0)])
@pytest.mark.parametrize("sliding", [(1e-3, 0.0), (1e-3, -2.5e-3)])
def test_the_bins_of_an_arc_that_travels_sum_to_the_volume_of_the_step(pressure, travel, turn, sliding):
    """Edges are passed by both ends, once or twice; the second sliding turns after 0.4 of the step.

    The volume is that of 2 x 200 points of Gauss, none of them a point of the step.
    """
    joint, load, depth = worn_joint(1e-14, 3e-14, pressure), (2.5e5, 3e5, -5e4), (1e-6, 2e-6, -1e-6)
    polynomials, step_values = np.zeros((StepRows.SIZE, POINTS)), np.ones((STEP_VALUE_ROWS, PARTS + 1))
    polynomials[FORCE_ROW, :3], polynomials[DEPTH_ROW, :3], polynomials[KAPPA_ROW, 0] = load, depth, 1.0
    polynomials[SLIP_ROW, :2] = sliding
    step_values[SLIP_ROW] = np.polyval(sliding[::-1], np.arange(PARTS + 1) / PARTS)
    for row, at in ((BEARING, 0.3), (JOURNAL, 5.9)):
        polynomials[row, :3] = at, travel, turn
    nodes, weights = np.polynomial.legendre.leggauss(200)
    kink = -sliding[0] / sliding[1] if sliding[1] else 0.5
    x = np.concatenate([kink * (nodes + 1.0) / 2.0, kink + (1.0 - kink) * (nodes + 1.0) / 2.0])
    weights = np.concatenate([kink * weights, (1.0 - kink) * weights]) / 2.0
    force, deep, slip = (np.polyval(values[::-1], x) for values in (load, depth, sliding))
    pressed = []
    for f, d in zip(force, deep, strict=True):
        half = half_arc(pressure, joint, joint.bearing_radius, SlidingContact(f, d, 0.0, 0.0, 0.0, 0.0, 0.5e-3, 0.0))
        pressed.append(f * pressure_integral_over_load(pressure, half))
    rubbed = np.sum(weights * pressed * np.abs(slip))
    for depths, radius, coefficient in zip(
        both(joint, polynomials, step_values), (0.01, 0.0095), (1e-14, 3e-14), strict=True
    ):
        assert depths.sum() * radius * 2.0 * math.pi / BINS == pytest.approx(coefficient * rubbed, rel=1e-12, abs=0.0)
        assert depths.min() >= 0.0


@pytest.mark.parametrize("travel", [(-0.001, 0.017), (0.0005, 0.012)])
@pytest.mark.parametrize("angle", [0.3, 0.304])
def test_an_edge_that_an_even_arc_passes_divides_its_wear_in_time(angle, travel):
    """Against 400,000 moments; both ends accelerate within the step."""
    joint, count = worn_joint(1e-14, 1e-14, UniformPressure()), 400000
    polynomials, step_values = np.zeros((StepRows.SIZE, POINTS)), np.ones((STEP_VALUE_ROWS, PARTS + 1))
    polynomials[FORCE_ROW, 0], polynomials[DEPTH_ROW, 0] = 2.5e5, 1e-5
    polynomials[KAPPA_ROW, 0], polynomials[SLIP_ROW, 0] = 1.0, 1e-3
    polynomials[BEARING, :3] = angle, *travel
    depths, _ = both(joint, polynomials, step_values)
    x, half = (np.arange(count) + 0.5) / count, math.acos(0.5e-3 / (0.5e-3 + 1e-5))
    middle, width = angle + travel[0] * x + travel[1] * x**2, 2.0 * math.pi / BINS
    before = [np.mean(np.clip(0.5 + 0.5 * (k * width - middle) / half, 0.0, 1.0)) for k in range(BINS + 1)]
    naive = np.diff(before) / width * 1e-14 * 2.5e5 * 1e-3 / 0.01 * half / math.sin(half)
    assert depths == pytest.approx(naive, rel=0.0, abs=1e-9 * naive.max())


def test_finer_bins_keep_the_means_of_those_that_wear_is_summed_up_in():
    means = np.maximum(0.0, np.sin(np.arange(MAX_BINS) * 0.05)) ** 2
    depths = interpolated_depths(means, 5 * MAX_BINS)
    assert depths.min() >= 0.0
    assert depths.reshape(MAX_BINS, 5).mean(axis=1) == pytest.approx(means, rel=1e-9, abs=1e-12)


def run(**changes):
    case = {"joints.rod-slider.wear": WEAR, "simulate.revolutions": 2, "simulate.discard": 1, **changes}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=case))
    trajectory = clearsweep.simulate(scene)
    assert trajectory.status == "ok"
    return scene, trajectory


@pytest.mark.compiled
@pytest.mark.parametrize("wrong", ["power", "force", "histogram", "wear"])
def test_a_sum_that_is_not_finite_fails_the_case(monkeypatch, wrong):
    integrate = loop.integrate

    def with_one_wrong_sum(pinned):
        integrate(pinned)
        totals = pinned.value.totals
        if wrong == "power":
            totals.mechanism.residual = math.inf  # as the loop notes a power that is nan
        elif wrong == "force":
            totals.joint[0].force_square = math.nan
        elif wrong == "histogram":
            totals.histogram[0, 0, 1] = math.nan
        else:
            totals.wear[3] = math.nan
        if not loop.has_finite_sums(totals):  # as the loop ends
            pinned.value.stepper.status = integration.SUMS_NOT_FINITE

    scene, _ = run()
    monkeypatch.setattr(loop, "integrate", with_one_wrong_sum)
    trajectory = clearsweep.simulate(scene)
    assert trajectory.status == "not-finite"
    assert "a sum of its powers, forces or wear is not" in trajectory.message
    assert trajectory.summary["rod_slider_wear_volume"] is None


@pytest.mark.compiled
def test_a_history_that_is_not_finite_fails_the_case_with_its_channel(monkeypatch):
    integrate = loop.integrate

    def with_one_wrong_sample(pinned):
        integrate(pinned)
        pinned.value.record.samples[40, 5] = math.nan

    scene, _ = run(save={"orbits": "last", "revolutions": 1, "samples": 72})
    monkeypatch.setattr(loop, "integrate", with_one_wrong_sample)
    trajectory = clearsweep.simulate(scene)
    assert trajectory.status == "not-finite"
    assert f"but its history {scene.layout.channels[5].name} is not;" in trajectory.message
    assert not trajectory.history


@pytest.mark.compiled
@pytest.mark.parametrize("start", ["centred", "seated"])
def test_worn_volume_is_the_coefficient_times_pressure_times_way(start):
    """The way is integrated from samples: slip = rate along the tangent plus the turning of the rod's pin.

    An even pressure over half the arc theta sums up to theta / sin(theta) of its load.
    """
    changes = {"simulate.start": start, "joints.rod-slider.contact.restitution": 0.3}
    _, trajectory = run(**{**changes, "save.orbits": "last", "save.revolutions": 1, "save.samples": 200000})
    x, y = trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"]
    size = np.maximum(np.hypot(x, y), 1e-12)
    tangential = (-y * trajectory["joints/rod_slider/vx"] + x * trajectory["joints/rod_slider/vy"]) / size
    slip = np.abs(tangential + trajectory["rod/rate"] * 9.5e-3)
    theta = np.arccos(np.minimum(0.5e-3 / size, 1.0))
    pressed = trajectory["joints/rod_slider/force_normal"] / np.sinc(theta / math.pi)
    work = np.trapezoid(pressed * slip, trajectory.t)
    assert trajectory.summary["rod_slider_wear_volume"] == pytest.approx(2 * 2e-14 * work, rel=2e-3, abs=0.0)


@pytest.mark.few("crank-rod")
@pytest.mark.compiled
@pytest.mark.parametrize("name", ["ground-crank", "crank-rod", "rod-slider"])
def test_bins_turn_with_their_bodies(name):
    """The mean direction of wear on both bodies is what samples of force, sliding and direction say."""
    changes = {f"joints.{name}.wear": LINE_WEAR, "save.orbits": "all", "save.revolutions": 1, "save.samples": 100000}
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


@pytest.mark.slow
@pytest.mark.compiled
def test_every_bin_has_the_mean_of_a_hundred_thousand_standing_arcs():
    """At a tolerance of 1e-8, to 1e-6 of the deepest bin, against samples of a motion at 1e-12."""
    changes = {"joints.rod-slider.wear": LINE_WEAR, "simulate.revolutions": 0.5, "simulate.tolerance": 1e-12}
    changes |= {"save.orbits": "all", "save.samples": 2, "save.revolutions": 0.5}
    changes["joints.rod-slider.contact.onset"] = "first"  # no clip between an onset and its end
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    moments = [*clearsweep.simulate(scene).events["t"], 0.006]
    u = (np.arange(10000) + 0.5) / 10000
    spans = [(a, b - a) for a, b in zip(moments[::2], moments[1::2], strict=False)]
    times = np.concatenate([a + length * u * u * (3.0 - 2.0 * u) for a, length in spans])
    weights = np.concatenate([length * 6.0 * u * (1.0 - u) / u.size for _, length in spans])
    path = clearsweep.simulate(scene, times=times)
    x, y, vx, vy = (path[f"joints/rod_slider/{name}"] for name in ("x", "y", "vx", "vy"))
    load = np.maximum(path["joints/rod_slider/force_normal"], 0.0) / 0.02
    slip = np.abs((x * vy - y * vx) / np.hypot(x, y) + path["rod/rate"] * 9.5e-3)
    changes["simulate.tolerance"] = 1e-8
    worn = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes))).wear["rod_slider"]
    for depths, radius, turned in zip(worn, (0.01, 0.0095), (0.0, path["rod/angle"]), strict=True):
        angle, amount = np.arctan2(y, x) - turned, weights * 2e-14 * load * slip / radius
        half, width = np.sqrt(4.0 * load * 0.19 / (math.pi * STEEL)) / radius, 2.0 * math.pi / BINS
        first, before, naive = np.floor((angle - half) / width), 0.0, np.zeros(BINS)
        for k in range(int(2.0 * half.max() / width) + 2):
            after = shares(((first + k + 1) * width - angle) / half)
            np.add.at(naive, ((first + k) % BINS).astype(int), amount * (after - before) / width)
            before = after
        assert depths == pytest.approx(naive, rel=0.0, abs=1e-6 * naive.max())


def case_of(pressure=None, **changes):
    wear = WEAR | ({"pressure": pressure} if pressure else {})
    source = slider_crank("rod-slider", changes={"joints.rod-slider.wear": wear} | changes)
    return grid.load(source, simulation.catalogue())


MATERIAL = {"joints.rod-slider.contact.material": {"young": 207e9, "poisson": 0.3}}
MODULUS = {"joints.rod-slider.wear": WEAR | {"pressure_modulus": STEEL}}


def test_a_pressure_left_out_is_even_or_hertzian_where_a_modulus_is_given():
    assert case_of().case_id(0) == case_of("mean").case_id(0)
    assert case_of(**MATERIAL).case_id(0) == case_of("hertz-line", **MATERIAL).case_id(0)
    assert case_of(**MATERIAL).case(0).joints[0].wear.pressure == "hertz-line"
    assert case_of(**MODULUS).case(0).joints[0].wear.pressure == "hertz-line"
    assert case_of("mean", **MATERIAL).case(0).joints[0].wear.pressure == "mean"


def test_an_even_pressure_needs_no_modulus():
    assert len(case_of("mean")) == 1


def test_the_modulus_of_a_line_contact_does_not_follow_the_stiffness():
    for stiffness in (1e9, 1e11):
        changes = {**MATERIAL, "joints.rod-slider.contact.stiffness": stiffness}
        (joint,) = case_of(**changes).case(0).joints
        assert registry.compile_wear(joint).pressure.width_factor == pytest.approx(
            math.sqrt(4.0 * 0.19 / (math.pi * STEEL)), rel=1e-12
        )


@pytest.mark.compiled
def test_figures_of_wear_are_those_of_the_bins():
    _, trajectory = run()
    bearing, journal = trajectory.wear["rod_slider"]
    assert bearing.shape == journal.shape == (BINS,)
    assert bearing.min() >= 0.0 <= journal.min()
    deepest = max(bearing.max(), journal.max())
    assert trajectory.summary["rod_slider_wear_depth_max"] == deepest > 0.0
    assert trajectory.summary["rod_slider_wear_rate_max"] == pytest.approx(deepest / 0.012, rel=1e-12, abs=0.0)


@pytest.mark.compiled
def test_the_bins_of_a_run_sum_to_the_volume_on_both_bodies():
    """Both lose the same volume, whose bins are passed at different moments; the energy law's is the work of friction.

    That work is summed from the stages of each step and the wear from a course through them: they differ by the error
    of the steps, 7e-9 at a tolerance of 1e-6, 7e-11 at one of 1e-9 and 4e-12 at one of 1e-12.
    """
    friction = {"law": "coulomb", "coefficient": 0.1, "velocity_scale": 1e-3}
    changes = {"joints.rod-slider.wear": LINE_WEAR | {"law": "energy"}, "joints.rod-slider.friction": friction}
    _, trajectory = run(**changes)
    bearing, journal = (depths.sum() * 0.02 * 2.0 * math.pi / BINS for depths in trajectory.wear["rod_slider"])
    volume = trajectory.summary["rod_slider_wear_volume"]
    assert bearing * 0.01 == pytest.approx(journal * 9.5e-3, rel=1e-12, abs=0.0)
    assert bearing * 0.01 + journal * 9.5e-3 == pytest.approx(volume, rel=1e-12, abs=0.0)
    work = trajectory.summary["rod_slider_friction_power"] * 0.012
    assert volume == pytest.approx(2.0 * 2e-14 * work, rel=5e-10, abs=0.0)


@pytest.mark.compiled
def test_wear_does_not_change_the_motion():
    with_wear = run()[1]
    without = clearsweep.simulate(
        clearsweep.simulation.load_case(
            slider_crank("rod-slider", changes={"simulate.revolutions": 2, "simulate.discard": 1})
        )
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


@pytest.mark.compiled
def test_a_run_begins_with_the_way_that_its_joints_have_slid_before():
    case = case_of().case(0)
    scene = simulation.build(case, {"rod-slider": Worn(np.zeros(BINS), np.zeros(BINS), 7.0)})
    assert Run(start_of(scene, np.empty(0))).totals.account[0, Account.index_of("sliding_distance")] == 7.0
    assert (
        Run(start_of(simulation.build(case), np.empty(0))).totals.account[0, Account.index_of("sliding_distance")]
        == 0.0
    )


def test_only_shapes_that_act_are_part_of_a_case():
    assert case_of(**{"joints.rod-slider.wear.evolve": False}).case_id(0) == case_of().case_id(0)
    assert case_of(**{"joints.rod-slider.wear.evolve": True}).case_id(0) != case_of().case_id(0)


@pytest.mark.parametrize("angle", [0.3, -7.0, 3000.3])
@pytest.mark.parametrize("way", [0.0, 0.02, 0.5])
def test_an_even_arc_that_opens_at_an_onset_and_travels_leaves_the_exact_means(angle, way):
    """Against ten thousand arcs that rest still; narrow arcs and far angles must not lose digits."""
    joint, count = worn_joint(1e-14, 1e-14, UniformPressure()), 10000
    polynomials, step_values = np.zeros((StepRows.SIZE, POINTS)), np.ones((STEP_VALUE_ROWS, PARTS + 1))
    polynomials[FORCE_ROW, 3], polynomials[DEPTH_ROW, 2] = 3e5, 1e-5  # N/m, m: as of a ball that touches
    polynomials[KAPPA_ROW, 0], polynomials[SLIP_ROW, 0] = 1.0, 1e-3
    polynomials[BEARING, :3] = angle, way, -0.2 * way
    bearing, _ = both(joint, polynomials, step_values)
    x = (np.arange(count) + 0.5) / count
    half, middle = np.arccos(0.5e-3 / (0.5e-3 + 1e-5 * x**2)), angle + way * x - 0.2 * way * x**2
    worn = 1e-14 * 3e5 * x**3 * half / np.sin(half) * 1e-3 / 0.01 / count
    width = 2.0 * math.pi / BINS
    first = math.floor((middle - half).min() / width)
    edges = (first + np.arange(math.ceil((middle + half).max() / width) - first + 1)) * width
    before = [np.sum(worn * np.clip(0.5 + 0.5 * (edge - middle) / half, 0.0, 1.0)) for edge in edges]
    naive = np.zeros(BINS)
    naive[(first + np.arange(len(edges) - 1)) % BINS] = np.diff(before) / width
    assert bearing == pytest.approx(naive, rel=0.0, abs=2e-5 * naive.max())
    assert bearing.sum() * width == pytest.approx(worn.sum(), rel=1e-7, abs=0.0)


@pytest.mark.parametrize("bins", [60, 120])
def test_the_time_with_narrow_arcs_is_that_of_fine_samples_of_the_depth(bins):
    """Of impacts without loss at a coarse tolerance: each is a few steps, and its arc grows from nothing."""
    changes = {
        "joints.rod-slider.contact": {"law": "hertz", "stiffness": 6.61e10},
        "joints.rod-slider.wear": {"law": "archard", "coefficient": 1e-16, "bins": bins},
        "simulate": {"revolutions": 1.0, "discard": 0, "tolerance": 1e-5},
        "save": {"orbits": "all", "samples": 200_000},
    }
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    result, clearance = clearsweep.simulate(case), case.value.joints[0].clearance
    distance = np.hypot(result["joints/rod_slider/x"], result["joints/rod_slider/y"])
    widths = 2.0 * np.arccos(clearance / distance[result["joints/rod_slider/force_normal"] > 0.0].clip(clearance))
    share = float(np.mean(widths < 5.0 * 2.0 * math.pi / bins))
    assert 0.01 < share < 0.9
    assert result.summary["rod_slider_wear_narrow_arcs"] == pytest.approx(share, abs=2e-3)
