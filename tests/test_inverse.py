"""The page on inverse questions has the figures that were measured, and these are good enough."""

import inverse_page
import numpy as np
import optima
import rigs
from inverse_page import rows


def test_the_page_is_made_of_what_was_measured():
    assert inverse_page.PAGE.read_text(encoding="utf-8") == inverse_page.page()


def test_identify_finds_the_clearance_of_made_up_rigs():
    own = [row for row in rows("rigs") if not row["law"]]
    other = [row for row in rows("rigs") if row["law"]]
    assert len(own) == len(other) == 20
    assert sum(row["inside"] for row in own) >= 18
    assert sorted(row["half_width"] for row in own)[10] <= 0.15
    assert all(row["inside"] or not row["explained"] for row in other)
    for row in [*own, *other]:
        low, _, high, _ = row["found"][rigs.CLEARANCE]
        assert row["inside"] == (low <= row["true"][rigs.CLEARANCE] <= high)
    again = rows("rigs_again")
    assert sum(row["inside"] for row in again) >= 0.9 * len(again)
    assert np.median([row["half_width"] for row in again]) <= 0.15
    assert max(row["processor_seconds_beside_the_cases"] for row in rows("rigs_times")) <= 30.0


def test_optimise_comes_near_the_best_of_a_brute_force():
    for name, problem in optima.PROBLEMS.items():
        every, runs = optima.compared(rows("optima"), name)
        middle, _, seconds = optima.shares(every, runs, len(problem["minimise"]))
        assert every["cases"] >= 20_000
        assert {row["cases"] for row in runs} == {300}
        assert len(runs) == 10
        assert middle <= 2.0 if len(problem["minimise"]) == 1 else middle >= 97.0
        assert seconds <= 3.0


def test_no_kill_changes_an_answer():
    for of in ("optimise", "identify"):
        mine = [row for row in rows("kills") if row["of"] == of]
        assert sum(sum(row["kills"].values()) for row in mine) >= 100
        assert all(row["wrong"] == [] for row in mine)
