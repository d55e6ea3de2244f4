"""Stiff, extreme and degenerate cases end as they should; what must not matter to the motion does not."""

import itertools
import math
import re

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.contracts.results import TIMINGS
from clearsweep.mechanics.laws.elastic import Liu, PowerThreeHalves
from clearsweep.verify import extremes, stability

pytestmark = pytest.mark.heavy

TABLE = extremes.extreme_cases()
SOME = stability.select_evenly(TABLE, 25)
FIGURES = ("force_peak", "force_rms", "penetration_max", "impacts_per_rev", "onset_rate_max")


def run(source, **overrides):
    result = clearsweep.simulate(clearsweep.load_case(source, {k.replace("__", "."): v for k, v in overrides.items()}))
    assert result.status == "ok", result.message
    return result.summary


# ---------------------------------------------------------------------------------------------- the table


def test_the_bound_of_a_force_that_is_no_power_is_within_that_of_its_like():
    shallow = Liu(1e9, 1e6)  # K pen sqrt(pen / 2 c) as long as pen is far below c
    power = PowerThreeHalves(1e9 / math.sqrt(2e6))
    impact, load = (stability.penetration_bound(power, *given) for given in ((1e-3, 0.0), (0.0, 50.0)))
    assert stability.penetration_bound(shallow, 1e-3, 0.0) == pytest.approx(impact, rel=1e-6)
    assert stability.penetration_bound(shallow, 0.0, 50.0) == pytest.approx(load, rel=1e-6)
    together = stability.penetration_bound(shallow, 1e-3, 50.0)
    assert max(impact, load) < together < stability.penetration_bound(power, 1e-3, 50.0)


def test_the_table_spans_what_it_should():
    assert len(TABLE) >= 200
    assert len({case.name for case in TABLE}) == len(TABLE)
    joints = [joint for case in TABLE for joint in case.grid["joints"].values()]
    stiffness = [joint["contact"]["stiffness"] for joint in joints if "stiffness" in joint["contact"]]
    restitution = [joint["contact"]["restitution"] for joint in joints if "restitution" in joint["contact"]]
    friction = [joint.get("friction", {}).get("coefficient", 0.0) for joint in joints]
    clearance = [joint["clearance"] for joint in joints]
    rpm = [case.grid["drive"]["speed"] * 30.0 / math.pi for case in TABLE if "drive" in case.grid]
    for values, low, high in (
        (stiffness, 1e5, 1e14),
        (restitution, 0.01, 1.0),
        (friction, 0.0, 1.0),
        (clearance, 1e-7, 5e-3),
        (rpm, 1, 5e4),
    ):
        assert min(values) == pytest.approx(low)
        assert max(values) == pytest.approx(high)
    assert {len(case.grid["joints"]) for case in TABLE} == {1, 2, 3}


@pytest.mark.few(*(case.name for case in stability.select_evenly(SOME, 8)[1:]))  # `verify` runs all
@pytest.mark.parametrize("case", SOME, ids=lambda case: case.name)
def test_a_case_of_the_table_passes(case):
    assert stability.run_case(case)["failure"] == ""


@pytest.mark.slow
def test_nineteen_of_twenty_cases_of_the_table_pass_and_the_others_say_why():
    table = stability.measure()
    assert table["share_passed"] >= 0.95
    for row in table["failures"]:
        assert row["rhs_evaluations"] > 0
        assert len(row["failure"]) > 20


def test_a_penetration_bound_is_reached_by_a_free_impact_and_by_nothing_less():
    """Two bodies meet without a load: the bound is the closed form, and the run has exactly that penetration."""
    for case in TABLE:
        if case.group == "pair":
            assert stability.run_case(case)["share_of_bound"] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_a_free_impact_reaches_the_bound_of_a_given_damper_at_any_speed(speed):
    """chi = D v / K is that of its own speed."""
    grid = extremes.impact_pair_grid(1e9, 0.5, speed=speed)
    contact = {"law": "hunt-crossley", "stiffness": 1e9, "damping": 2e9}
    (joint,) = grid["joints"].values()
    case_scene = clearsweep.load_case(grid | {"joints": {"pair": joint | {"contact": contact}}})
    assert stability.run_scene(case_scene)["share_of_bound"] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.slow
def test_what_is_beyond_the_bound_fails_and_is_compared_with_a_tighter_tolerance():
    row = stability.run_case(next(case for case in TABLE if case.name == "mixed/10 AB"))
    assert row["share_of_bound"] > 1.5
    off, left = map(float, re.findall(r"\d\.\de[+-]\d+", row["failure"]))
    assert 0.0 < off < 1e-3
    assert 0.0 < left < 1e-3


def test_a_contact_that_the_log_lacks_is_seen():
    made, _ = stability.scene_of(next(case for case in TABLE if case.name == "stiffness/C 1e+10"))
    result = clearsweep.simulate(made, times=np.linspace(0.0, 0.02, 4001))
    assert stability.largest_escape(made, result, 0, "rod_slider") < stability.BOUND_TOLERANCE
    lost = clearsweep.Trajectory("ok", "", result.summary, result.channels, result.events[1:])
    assert stability.largest_escape(made, lost, 0, "rod_slider") > stability.BOUND_TOLERANCE


@pytest.mark.slow
def test_a_joint_that_has_just_left_its_bearing_is_not_met_again_at_once():
    """Eleven thousand events without a loss, from hard impacts to all but grazing ones."""
    (dear,) = (case for case in TABLE if case.name == "dear/ABC undamped 1e14, 1 rpm")
    result = clearsweep.simulate(clearsweep.load_case(dear.grid, {"simulate.revolutions": 0.2}), times=[0.0])
    assert result.status == "ok"
    for joint in ("ground_crank", "crank_rod", "rod_slider"):
        events = result.events[result.events["joint"] == joint]
        assert len(events) > 3000
        assert np.all(np.diff(events["t"]) > 0.0)
        assert np.all(events["rate"][events["kind"] == "on"] > 0.0)


@pytest.mark.slow
def test_tuned_cases_are_what_they_say():
    graze = next(case for case in TABLE if case.name == "graze/C 5000 rpm 0.9")
    made, note = stability.scene_of(graze)
    rates = clearsweep.simulate(made, times=[0.0]).events
    rates = rates["rate"][rates["kind"] == "on"]
    assert rates.min() < 1e-4 * rates.max(), note
    simultaneous = next(case for case in TABLE if case.name == "simultaneous/BC 5000 rpm")
    made, note = stability.scene_of(simultaneous)
    log = clearsweep.simulate(made, times=[0.0]).events
    first = [log["t"][(log["joint"] == name) & (log["kind"] == "on")][0] for name in ("crank_rod", "rod_slider")]
    assert first[0] == pytest.approx(first[1], rel=1e-9, abs=0.0), note


# ---------------------------------------------------------------------------------------------- what must not matter


def untimed(summary):
    return {name: value for name, value in summary.items() if name not in TIMINGS}


@pytest.mark.few("rod-slider+crank-rod+ground-crank")
@pytest.mark.parametrize("names", list(itertools.permutations(extremes.JOINTS)), ids="+".join)
def test_the_order_of_joints_in_the_file_does_not_matter(names):
    changes = {"simulate.revolutions": 0.5, "mechanism.gravity": 9.81, "joints.rod-slider.clearance": 2e-4}
    first = run(slider_crank(*extremes.JOINTS, changes=changes))
    other = run(slider_crank(*names, changes=changes))
    assert untimed(first) == untimed(other)


@pytest.mark.parametrize("opening", ["C", "BC"])
def test_a_tighter_tolerance_converges(opening):
    names = [extremes.JOINT_BY_LETTER[letter] for letter in opening]
    peak = [
        run(slider_crank(*names), simulate__revolutions=0.2, simulate__tolerance=tolerance)["rod_slider_force_peak"]
        for tolerance in (1e-5, 1e-7, 1e-9, 1e-13)
    ]
    errors = [abs(value / peak[-1] - 1.0) for value in peak[:-1]]
    assert errors[2] <= errors[1] <= errors[0]
    assert errors[2] < 1e-6


def test_bodies_of_a_pair_may_be_swapped():
    first, other = (run(extremes.impact_pair_grid(1e9, 0.5, masses=masses)) for masses in ((0.1, 3.0), (3.0, 0.1)))
    assert untimed(first) == untimed(other)


@pytest.mark.few("rod-slider")
@pytest.mark.parametrize("name", extremes.JOINTS)
def test_either_body_may_carry_the_journal_where_nothing_rubs(name):
    """Without friction only the normal counts, which both surfaces share: from concentric pins the motion is one."""
    proximal, distal = name.split("-")
    joint = name.replace("-", "_")
    first, other = (
        run(slider_crank(name), simulate__revolutions=0.3, **{f"joints__{name}__journal": body})
        for body in (proximal, distal)
    )
    for figure in FIGURES:
        assert first[f"{joint}_{figure}"] == pytest.approx(other[f"{joint}_{figure}"], rel=1e-7, abs=0.0)


def mirrored(sign):
    """Return the state of a slider seated across its bearing's side `sign`, weightless at standstill of the rod."""
    case = extremes.ExtremeCase("mirror/C", extremes.slider_crank_grid("C", speed=1000.0), (0.3, 0.4 * sign))
    made, _ = stability.scene_of(case)
    return made


def test_a_mirrored_start_at_the_reversed_crank_gives_the_mirrored_motion():
    """Weightless, y and the crank's sense reversed: rod angle and every y change sign, x and the forces do not."""
    import dataclasses

    up, down = mirrored(1.0), mirrored(-1.0)
    drive = down.value.mechanism.drive._replace(speed=-up.value.mechanism.drive.speed)
    start = down.start.copy()
    start[2] = -start[2]  # the rod's rate
    down = dataclasses.replace(
        down, start=start, value=down.value._replace(mechanism=down.value.mechanism._replace(drive=drive))
    )
    times = np.linspace(0.0, 0.02, 201)
    first, other = (clearsweep.simulate(made, times=times) for made in (up, down))
    assert first.status == other.status == "ok"
    assert first["rod/angle"] == pytest.approx(-other["rod/angle"], abs=1e-9)
    assert first["slider/x"] == pytest.approx(other["slider/x"], abs=1e-10)
    assert first["joints/rod_slider/y"] == pytest.approx(-other["joints/rod_slider/y"], abs=1e-9)
    assert len(first.events) == len(other.events) > 0
