"""Starts carried along an axis or drawn at random: coexisting motions against a second program."""

import copy
import itertools
import json
import math
import re

import numpy as np
import pandas as pd
import pytest
from mechanism_cases import changed, untimed
from right_grids import grid_of
from scipy.integrate import solve_ivp

import clearsweep
from clearsweep import grid, simulation, store
from clearsweep.answers.figure_sentences import motions_of
from clearsweep.language.errors import InputError
from clearsweep.simulation import random_places, warnings
from clearsweep.simulation.analyses import repeated
from clearsweep.simulation.analyses.trajectory import simulate
from clearsweep.simulation.setup.places import places_of, units_of
from clearsweep.sweeping.pool import worker
from clearsweep.sweeping.pool.case_runner import Pending, by_chain
from clearsweep.sweeping.pool.driver import Batches
from clearsweep.verify.reference_run import base_tree, scene_of

INERTIA, STIFFNESS, HALF_PLAY, DRAG = 0.02, 2000.0, 5e-4, 0.63  # kg m^2, N m/rad, rad, N m s/rad
LOAD, SHAKE = 0.1, 0.05  # N m: mean and amplitude of the load on the rotor, once a turn
#: Largest torque (N m) in the spline by `second_program`, up and down from 1300 to 2300 rpm.
SPEEDS = (1300.0, 1800.0, 2300.0)  # rpm
UP, DOWN = (0.16129, 0.17723, 0.36978), (0.16129, 0.47987, 0.36978)


def rotor(start="carried", **changes):
    """Return a rotor that a shaft of constant speed drives through a spline with play, under a load with a ripple."""
    angles = np.linspace(0.0, 360.0, 181)
    torques = -LOAD - SHAKE * np.cos(np.radians(angles))
    load = {"crank_angle [deg]": angles.tolist(), "torque [N*m]": torques.tolist()}
    given = {"loads.pump": {"on": "rotor", "table": load}, "simulate.start": start}
    given["sweep"] = {"drive.speed": [f"{speed:g} rpm" for speed in SPEEDS]}
    return changed(grid_of("a rotor behind a spline"), given | changes)


def slider_crank(start="carried", **changes):
    """Return a slider-crank with clearance in one pin."""
    tree = changed(grid_of("a speed that carries on"), {"simulate.start": start})
    return changed(tree, changes)


def loaded(tree):
    """Return the grid of a dict."""
    return grid.load(tree, simulation.catalogue())


def index_of(cases, direction, speed):
    """Return the index of the case of a direction at a speed, rpm."""
    points = map(cases.point, range(len(cases)))
    return next(
        index
        for index, point in enumerate(points)
        if point["simulate.direction"] == direction and math.isclose(point["drive.speed"], speed * math.pi / 30.0)
    )


def second_program(speed, state, revolutions=50):
    """Return the state of the play after some revolutions, and the largest torque of the last ten, by DOP853."""
    rate = speed * math.pi / 30.0
    period = 2.0 * math.pi / rate

    def torque(delta):
        return STIFFNESS * (delta - np.clip(delta, -HALF_PLAY, HALF_PLAY))

    def rates(t, y):
        load = LOAD + SHAKE * math.cos(rate * t)
        return y[1], (load - torque(y[0]) - DRAG * y[1]) / INERTIA

    span = (0.0, revolutions * period)
    run = solve_ivp(rates, span, state, "DOP853", rtol=1e-9, atol=1e-13, max_step=period / 60.0, dense_output=True)
    times = np.linspace((revolutions - 10.0) * period, revolutions * period, 20_001)
    return run.y[:, -1], float(np.max(torque(run.sol(times)[0])))


@pytest.mark.slow
def test_the_recorded_torques_are_those_of_a_second_program():
    state, rate = np.zeros(2), 1.0
    for speeds, torques in ((SPEEDS, UP), (SPEEDS[::-1], DOWN[::-1])):
        for speed, torque in zip(speeds, torques, strict=True):
            state, computed = second_program(speed, state * [1.0, speed / rate])
            assert computed == pytest.approx(torque, rel=1e-4)
            rate = speed


def test_both_branches_of_a_rotor_are_found(tmp_path):
    result = clearsweep.sweep(rotor(), tmp_path / "run", jobs=1, show_progress=False)
    table = result.open().summary.sort_values("drive.speed")
    for direction, torques in (("up", UP), ("down", DOWN)):
        computed = table[table["simulate.direction"] == direction]["spline_force_peak"]
        assert computed.to_numpy() == pytest.approx(torques, rel=3e-4)
    assert "Carried along drive.speed: up and down\n" in store.status_text(store.status(tmp_path / "run"))
    answer = json.loads((tmp_path / "run/answer.json").read_text())
    branches = answer["branches"]
    assert (branches["points"], branches["coexisting"], branches["undecided"]) == (3, 1, 0)
    assert [motion["median"] for motion in branches["motions"][0]["motions"]] == pytest.approx((UP[1], DOWN[1]), 3e-4)
    assert "Two motions coexist" in answer["sentences"][0]
    assert "0.177 or 0.480\xa0N\xa0m" in answer["sentences"][0]
    assert not [effect for effect in answer["effects"] if effect["path"] == "simulate.direction"]


def test_random_starts_find_both_motions(tmp_path):
    tree = rotor({"random": 6, "seed": 1}, **{"sweep/drive.speed": ["1800 rpm"]})
    result = clearsweep.sweep(tree, tmp_path / "run", jobs=1, show_progress=False)
    torques = np.sort(result.open().summary["spline_force_peak"].to_numpy())
    assert len(torques) == 6
    distances = np.abs(torques[:, None] / [UP[1], DOWN[1]] - 1.0)
    assert distances.min(axis=1).max() < 3e-4
    assert {*distances.argmin(axis=1).tolist()} == {0, 1}
    answer = json.loads((tmp_path / "run/answer.json").read_text())
    (point,) = answer["branches"]["motions"]
    counts = np.array([motion["starts"] for motion in point["motions"]])
    assert (counts <= np.bincount(distances.argmin(axis=1))).all()
    assert counts.sum() + point["undecided"] == 6  # a start whose run-in is too long is undecided


def test_a_chain_goes_on_like_one_longer_run():
    cases = loaded(slider_crank())
    upward, downward = (cases.case(index_of(cases, direction, 600.0)) for direction in ("up", "down"))
    assert (len(upward.before), len(downward.before)) == (1, 2)  # it turns at 600 rpm, which is run once more
    whole = simulate(repeated.build(upward).with_settings(revolutions=6.0))
    last = simulation.solve(downward)
    for name, share in (("x", 1e-6), ("y", 1e-6), ("force_normal", 1e-4)):
        histories = (each[f"joints/rod_slider/{name}"] for each in (whole, last))
        first, second = (history[-len(last.t) :] for history in histories)
        assert np.abs(first - second)[:720].max() <= share * np.abs(first).max()


def test_a_case_is_the_same_whether_its_chain_was_run_before_or_not():
    cases = loaded(slider_crank())
    case = cases.case(index_of(cases, "down", 500.0))
    for earlier in range(len(case.before)):
        simulation.solve(case.before[earlier]._replace(before=case.before[:earlier]))
    after_its_chain = simulation.solve(case)
    repeated._chain.clear()
    alone = simulation.solve(case)
    assert untimed(alone) == untimed(after_its_chain)


def test_a_start_is_carried_in_turns_and_clearances():
    tree = slider_crank(**{"sweep/drive.speed": None, "sweep/joints.rod-slider.clearance": ["50 um", "60 um"]})
    cases = loaded(tree)
    case = next(case for case in map(cases.case, range(len(cases))) if len(case.before) == 1)
    later = repeated.build(case)
    earlier = simulate(repeated.build(case.before[0]), times=[0.3]).channels
    places, _ = places_of(later.built, later.start[: 2 * len(later.built.lengths) + 1])
    ends = [earlier[f"joints/rod_slider/{key}"][-1] for key in ("x", "y")]
    assert np.abs(places / 60e-6) == pytest.approx(np.abs(np.array(ends)) / 50e-6, rel=1e-6)


def test_an_identity_has_the_values_before_it_and_not_those_after():
    short, long, lower = (
        loaded(slider_crank(**{"sweep/drive.speed": [f"{speed} rpm" for speed in speeds]}))
        for speeds in ((500, 600), (500, 600, 700), (450, 500, 600))
    )

    def case_id(cases, direction, speed):
        return cases.case_id(index_of(cases, direction, speed))

    assert case_id(short, "up", 600.0) == case_id(long, "up", 600.0)
    assert case_id(short, "down", 600.0) != case_id(long, "down", 600.0)
    assert case_id(short, "up", 500.0) != case_id(lower, "up", 500.0)
    for cases in (short, long, lower):
        numbers = [f"{number:016x}" for number in cases.identities()]
        assert numbers == [cases.case_id(index) for index in range(len(cases))]
        assert len(set(numbers)) == len(cases)
        again = loaded(cases.resolved())
        assert [*again.identities()] == [*cases.identities()]


def test_a_chain_is_one_task():
    cases = loaded(slider_crank({"carried": "drive.speed"}, **{"sweep/mechanism.slider.mass": [0.14, 0.2, 0.3]}))
    indices = np.arange(len(cases))
    pending, chains = by_chain(cases, Pending(indices, np.fromiter(cases.identities(), "u8", len(cases))))
    batches = Batches(pending.indices, pending.ids, 2, 1.0)
    batches.chains = chains
    for _ in range(3):
        batch = batches.next()
        points = [cases.point(index) for index in batch.cases.indices.tolist()]
        assert len(points) == 4
        assert len({point["mechanism.slider.mass"] for point in points}) == 1
        assert [len(cases.before(point)) for point in points] == [0, 1, 2, 3]
    assert batches.next() is None


def test_a_resumed_chain_ends_as_an_undisturbed_one(tmp_path):
    whole, resumed = (tmp_path / name for name in ("whole", "resumed"))
    tree = slider_crank(**{"save/orbits": "none"})
    table = clearsweep.sweep(tree, whole, jobs=1, show_progress=False).open().summary
    clearsweep.sweep(tree, resumed, jobs=1, show_progress=False)
    parts = sorted((resumed / "parts").iterdir())
    for part in parts[len(parts) // 2 :]:
        part.unlink()
    repeated._chain.clear()
    again = clearsweep.sweep(tree, resumed, jobs=1, show_progress=False).open().summary
    columns = [column for column in table.columns if column not in ("run_time", "setup_time")]
    assert table[columns].equals(again[columns])


def test_a_case_of_a_chain_is_checked_from_a_centred_start():
    tree = base_tree(loaded(slider_crank()).written_case(1))
    assert {"start", "carried_axis", "direction"}.isdisjoint(tree["simulate"])
    assert scene_of(tree).case.simulate.start == "centred"


def test_a_killed_chain_loses_only_its_latest_cases(tmp_path, monkeypatch):
    monkeypatch.setattr(worker, "CHAIN_SECONDS", 0.0)
    tree = slider_crank(**{"save/orbits": "none"})
    options = {"jobs": 1, "executor": "serial", "show_progress": False}
    whole = clearsweep.sweep(tree, tmp_path, **options).open().summary
    cases = {part: pd.read_parquet(part)["case_id"].tolist() for part in (tmp_path / "parts").iterdir()}
    single = {part: ids[0] for part, ids in cases.items() if len(ids) == 1}
    assert sorted(single.values()) == sorted(whole["case_id"])  # each was there before the end of its chain
    for part in cases:
        if part not in single or single[part] == whole["case_id"].iloc[-1]:
            part.unlink()
    repeated._chain.clear()
    again = clearsweep.sweep(tree, tmp_path, **options)
    assert again.ran == 1
    columns = [column for column in whole.columns if column not in ("run_time", "setup_time")]
    assert whole[columns].equals(again.open().summary[columns])


def test_random_places_fill_the_play_evenly():
    draws = [np.concatenate(random_places(1, draw, [False, True])) for draw in range(1, 2001)]
    x, y, flank, vx, vy, rate = np.array(draws).T
    for a, b in ((x, y), (vx, vy)):
        assert np.hypot(a, b).max() <= 1.0
        assert np.mean(a**2 + b**2) == pytest.approx(0.5, abs=0.03)  # of a disc
        assert np.abs([a.mean(), b.mean()]).max() < 0.05
    for each in (flank, rate):
        assert np.abs(each).max() <= 1.0
        assert np.mean(each**2) == pytest.approx(1.0 / 3.0, abs=0.03)
    assert np.array_equal(draws[6], np.concatenate(random_places(1, 7, [False, True])))
    assert not np.array_equal(draws[6], np.concatenate(random_places(2, 7, [False, True])))


def test_bodies_start_where_the_places_of_a_draw_say():
    cases = loaded(slider_crank({"random": 3, "seed": 5}))
    case = cases.case(len(cases) - 1)
    scene = repeated.build(case)
    computed = places_of(scene.built, scene.start[: 2 * len(scene.built.lengths) + 1])
    unit = units_of(scene.value.joints)
    for values, drawn, scale in zip(
        computed, random_places(5, 3, [False]), (1.0, scene.value.reference_rate), strict=True
    ):
        assert values == pytest.approx(drawn * unit * scale, rel=1e-6, abs=1e-9 * unit[0] * scale)


@pytest.mark.parametrize(
    ("medians", "half_widths", "motions"),
    [
        ((1.0, 1.02, 1.5), (0.1, 0.1, 0.1), [0, 0, 1]),
        ((1.0, 1.5, 2.0), (0.3, 0.3, 0.3), [0, 0, 0]),  # intervals that overlap one another
        ((1.0, 1.04), (0.0, 0.0), [0, 0]),  # apart, but close
        ((3.0, 1.0, 2.0), (0.0, 0.0, 0.0), [2, 0, 1]),
        ((0.0, 1.0), (0.0, 0.2), [0, 1]),
    ],
)
def test_motions_are_told_apart_by_their_scatter(medians, half_widths, motions):
    medians, half_widths = np.array(medians), np.array(half_widths)
    statistic = np.stack([medians, medians - half_widths, medians + half_widths], -1)
    for order in itertools.permutations(range(len(medians))):
        computed = motions_of(statistic[list(order)])
        assert computed.tolist() == [motions[index] for index in order]


def test_starts_of_one_chaotic_motion_are_not_told_apart():
    """32 samples of 40 peaks of the logistic map, which has one attractor, differ by their scatter alone."""
    from clearsweep.simulation.figures.window import quantiles

    statistic = []
    for start in np.random.default_rng(1).uniform(0.1, 0.9, 32):
        peaks = [start]
        for _ in range(200):
            peaks.append(3.8 * peaks[-1] * (1.0 - peaks[-1]))
        median = quantiles(np.array(peaks[-40:]), (0.5,))[0]
        statistic.append([median.value, median.low, median.high])
    assert set(motions_of(np.array(statistic)).tolist()) == {0}


def test_a_chain_is_not_divided_into_shards(tmp_path):
    with pytest.raises(InputError, match="not divided into shards"):
        clearsweep.sweep(slider_crank(), tmp_path / "run", shard="1/2", show_progress=False)


def test_one_direction_may_be_run_alone():
    cases = loaded(slider_crank(**{"simulate/direction": "down"}))
    assert len(cases) == 2
    assert len(cases.case(0).before) == 1  # 500 rpm comes after 600 rpm


# ---------------------------------------------------------------------------------------------- starts of ideal loops


GROUND, CRANK, COUPLER, ROCKER = 0.13, 0.05, 0.12, 0.1  # m
FOUR_BAR = grid_of("a four-bar that may start in two ways")


def notes(start):
    """Return the notes on the start of a four-bar with these angles."""
    source = copy.deepcopy(FOUR_BAR)
    source["mechanism"]["start"] = start
    return [note for note in warnings(clearsweep.load_case(source).case) if note.startswith("mechanism.start")]


def test_a_note_names_both_assemblies():
    (note,) = notes({})
    base = GROUND - CRANK  # the third side of the triangle with coupler and rocker at crank angle 0
    expected = math.degrees(math.acos((COUPLER**2 + base**2 - ROCKER**2) / (2.0 * COUPLER * base)))
    angles = sorted(float(angle) for angle in re.findall(r"coupler: (-?[\d.]+) deg", note))
    assert angles == pytest.approx([-expected, expected], rel=1e-3)


def test_angles_that_the_grid_leaves_open_are_derived():
    source = copy.deepcopy(FOUR_BAR)
    base = GROUND - CRANK
    expected = math.acos((COUPLER**2 + base**2 - ROCKER**2) / (2.0 * COUPLER * base))
    starts = []
    for start in ({}, {"rocker": "100 deg"}):
        source["mechanism"]["start"] = start
        angles = simulation.derived(clearsweep.load_case(source).case)
        starts.append({path: value for path, (value, _) in angles.items() if path.startswith("mechanism.start")})
    open_start, given_start = starts
    assert open_start.keys() == {"mechanism.start.coupler", "mechanism.start.rocker"}
    assert abs(open_start["mechanism.start.coupler"]) == pytest.approx(expected)
    assert given_start == {}


@pytest.mark.parametrize("start", [{"coupler": "50 deg"}, {"coupler": "-50 deg"}, {"rocker": "100 deg"}])
def test_no_note_where_start_decides(start):
    assert notes(start) == []
