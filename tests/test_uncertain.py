"""Wear coefficients that are hardly known give a life a second interval, from two further lives."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import slider_crank
from scipy.stats import lognorm
from test_life import KilledError, Memory

import clearsweep
from clearsweep import grid, simulation
from clearsweep.grid.grid import identity
from clearsweep.language import phases
from clearsweep.simulation.analyses.life import (
    HIGH,
    LOW,
    BlockRecord,
    LifeRun,
    failures,
    figures,
    further_lives,
    with_bounding_coefficients,
)

LIFE = {"limit": "20 um", "joint": "rod-slider", "max_revolutions": 12, "tolerance": 0.2}
COEFFICIENT = "joints.rod-slider.wear.coefficient"
WORN = {
    "joints.rod-slider.wear": {"law": "archard", "coefficient": 2e-14, "bins": 72},
    "simulate.tolerance": 1e-6,
    "simulate.revolutions": 3,
    "simulate.discard": 1,
    "save.orbits": "none",
    "life": LIFE,
}
FACTOR = {COEFFICIENT: {"factor": 3}}


def loaded(text=None, **changes):
    changes = copy.deepcopy(WORN) | changes | ({"uncertain": text} if text else {})
    return grid.load(slider_crank("rod-slider", changes=changes), simulation.catalogue())


def test_a_factor_is_a_third_to_three_times_the_value_of_each_case():
    made = loaded(FACTOR, **{"sweep": {COEFFICIENT: [1e-15, 4e-15]}})
    for index, value in enumerate((1e-15, 4e-15)):
        for end, times in ((LOW, 1.0 / 3.0), (HIGH, 3.0)):
            wear = with_bounding_coefficients(made.case(index), end).joints[0].wear
            assert wear.values["bearing_coefficient"] == pytest.approx(times * value, rel=1e-12)
            assert wear.values["journal_coefficient"] == pytest.approx(times * value, rel=1e-12)


def test_a_distribution_is_taken_at_its_ends_of_95_percent():
    bearing = "joints.rod-slider.wear.bearing_coefficient"
    (each,) = loaded({bearing: {"lognormal": {"mean": 2e-14, "cv": 0.5}}}).case(0).uncertain
    spread = math.sqrt(math.log(1.25))
    known = lognorm(spread, scale=2e-14 / math.sqrt(1.25)).ppf([0.025, 0.975])
    assert (each.low, each.high) == pytest.approx(tuple(known), rel=1e-9)
    assert each.keys == ("bearing_coefficient",)
    (even,) = loaded({COEFFICIENT: {"uniform": ["1e-15 m^2/N", "2e-15 m^2/N"]}}).case(0).uncertain
    assert (even.low, even.high) == pytest.approx((1.025e-15, 1.975e-15), rel=1e-9)


def test_it_is_part_of_what_a_case_is_and_of_what_a_run_holds():
    made, plain = loaded(FACTOR), loaded()
    assert made.case_id(0) != plain.case_id(0)
    assert [f"{number:016x}" for number in made.identities()] == [made.case_id(0)]
    assert made.case_id(0) == identity(made.written_case(0))
    again = grid.load(made.resolved(), simulation.catalogue())
    assert again.case_id(0) == made.case_id(0)
    assert again.case(0).uncertain == made.case(0).uncertain
    assert made.fixed_settings() != plain.fixed_settings()
    assert plain.case(0).uncertain == ()
    names = {column.name for column in made.layout.columns} - {column.name for column in plain.layout.columns}
    assert names == {"rod_slider_life_low_uncertain", "rod_slider_life_high_uncertain"}


class Block:
    """Blocks of a made-up motion whose wear rate falls as it wears: dh/dn = k rate / (1 + h / scale)."""

    def __init__(self, rate, scale):
        self.rate, self.scale, self.runs = rate, scale, 0

    def __call__(self, aged, state):
        self.runs += 1
        (part,) = aged.worn_joints
        wear = aged.scene.case.joints[part.joint_index].wear.values
        rate = np.zeros(aged.size)
        for body, where in (("bearing", part.bearing), ("journal", part.journal)):
            rate[where.start] = wear[f"{body}_coefficient"] * self.rate / (1.0 + state[where.start] / self.scale)
        rate[-1] = 0.02
        nothing = np.zeros(aged.size)
        return BlockRecord(rate, nothing, np.ones(1), np.zeros((24, 1)), np.zeros(8, np.int64), np.zeros(2), 2.0)

    def length(self, coefficient, limit):
        """Return the revolutions to a limit (m): n = (h + h^2 / (2 scale)) / (k rate)."""
        return (limit + 0.5 * limit * limit / self.scale) / (coefficient * self.rate)


def life_run(case, log=None):
    return LifeRun(simulation.build(case), log)


def evolving(log=None, scale=2e-5):
    """Return a case that evolves, its own block found, and what runs the blocks of its further lives."""
    wear = WORN["joints.rod-slider.wear"] | {"evolve": True, "pressure": "winkler"}
    made = loaded(FACTOR, **{"joints.rod-slider.wear": wear, "life": LIFE | {"tolerance": 0.02, "blocks": 1000}})
    block, aged = Block(1e6, scale), life_run(made.case(0), log)
    if not aged.records:
        aged.keep(block(aged, aged.start), aged.start)
    return aged, block


def test_lives_that_evolve_are_lived_again_at_both_ends():
    wear = WORN["joints.rod-slider.wear"] | {"evolve": True, "pressure": "winkler"}
    made = loaded(FACTOR, **{"joints.rod-slider.wear": wear, "life": LIFE | {"tolerance": 0.02, "blocks": 1000}})
    block, aged = Block(1e6, 2e-5), life_run(made.case(0))
    aged.records.append(block(aged, aged.start))
    result = figures("rod_slider", further_lives(aged, block))
    assert block.runs > 10
    assert result["rod_slider_life_low_uncertain"] == pytest.approx(block.length(6e-14, 2e-5), rel=0.01)
    assert result["rod_slider_life_high_uncertain"] == pytest.approx(block.length(2e-14 / 3.0, 2e-5), rel=0.01)


def test_further_lives_are_phases_of_their_own_whose_time_is_foretold():
    seen = []

    class Listener:
        def changed(self):
            result = phases.progress()
            if result and result.what not in seen:
                seen.append(result.what)

    aged, block = evolving()
    assert aged.progress.limits.further_lives == 2
    assert life_run(loaded(FACTOR).case(0)).progress.limits.further_lives == 0  # one block gives all
    listener = Listener()
    phases.listeners.append(listener)
    try:
        further_lives(aged, block)
    finally:
        phases.listeners.remove(listener)
    for end in (LOW, HIGH):
        of_end = [words for words in seen if words.startswith(f"life with the wear coefficients at their {end} ends, ")]
        assert any("block 2, " in words for words in of_end)
    assert [aged.bounding(aged.scene.case, "").progress.limits.further_lives for _ in range(2)][1] < 1


def test_a_further_life_whose_block_fails_is_reported_and_the_other_one_stays():
    aged, block = evolving()

    def run(other, state):
        if other.life_index == 1 and block.runs > 3:
            other.failure = "step-budget"
            return None
        return block(other, state)

    result = further_lives(aged, run)
    columns = figures("rod_slider", result)
    assert columns["rod_slider_life_high_uncertain"] is None
    assert columns["rod_slider_life_low_uncertain"] > 0.0
    (remark,) = failures(result)
    assert remark == (
        "life-failed: the life with the wear coefficients at their low ends is not known: its block 4 has the status "
        "step-budget"
    )
    assert failures(further_lives(*evolving())) == ()


@pytest.mark.parametrize("most", [3, 40])
def test_further_lives_that_are_killed_end_alike_and_run_no_block_twice(most):
    aged, block = evolving()
    whole = figures("rod_slider", further_lives(aged, block))
    log = Memory(most)
    killed, first = evolving(log)
    with pytest.raises(KilledError):
        further_lives(killed, first)
    again, rest = evolving(Memory(content=log.content))
    assert len(again.records) == 1
    assert figures("rod_slider", further_lives(again, rest)) == whole
    assert first.runs + rest.runs == block.runs


def test_lives_that_do_not_evolve_follow_from_the_one_block():
    made = loaded(FACTOR)
    block, aged = Block(1e6, math.inf), life_run(made.case(0))
    aged.records.append(block(aged, aged.start))
    result = figures("rod_slider", further_lives(aged, block))
    assert block.runs == 1
    for end, coefficient in (("low", 6e-14), ("high", 2e-14 / 3.0)):
        again = life_run(with_bounding_coefficients(made.case(0), HIGH if end == "low" else LOW))
        message = block(again, again.start)
        assert message.rate[again.worn_joints[0].bearing.start] == pytest.approx(coefficient * 1e6, rel=1e-12)
        length = result[f"rod_slider_life_{end}_uncertain"]
        assert length == pytest.approx(block.length(coefficient, 2e-5), rel=1e-9)


def test_an_uncertain_bearing_leaves_the_journal_to_decide():
    bearing = "joints.rod-slider.wear.bearing_coefficient"
    block, made = Block(1e6, math.inf), loaded({bearing: {"factor": 10}})
    aged = life_run(made.case(0))
    aged.records.append(block(aged, aged.start))
    result = figures("rod_slider", further_lives(aged, block))
    assert result["rod_slider_life_low_uncertain"] == pytest.approx(block.length(2e-13, 2e-5), rel=1e-9)
    assert result["rod_slider_life_high_uncertain"] == pytest.approx(block.length(2e-14, 2e-5), rel=1e-9)


@pytest.mark.heavy
def test_a_case_has_both_lives_beside_its_own():
    path = clearsweep.simulate(
        clearsweep.load_case(slider_crank("rod-slider", changes=copy.deepcopy(WORN) | {"uncertain": FACTOR}))
    )
    assert path.status == "ok"
    life = path.summary["rod_slider_life_revolutions"]
    assert path.summary["rod_slider_life_low_uncertain"] == pytest.approx(life / 3.0, rel=1e-9)
    assert path.summary["rod_slider_life_high_uncertain"] == pytest.approx(3.0 * life, rel=1e-9)
