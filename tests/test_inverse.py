"""The page on inverse questions has the figures that were measured, and these are good enough."""

import json
import re
import runpy
from pathlib import Path

import inverse_page
import numpy as np
import optima
import pytest
import rigs
from inverse_page import rows
from ruamel.yaml import YAML

import clearsweep


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


# The tutorial on a measured rig: its grid is the one that is ready, and its steps find the clearance.


ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs/rig.md").read_text(encoding="utf-8")
TRUE = {"week_00": 60e-6, "week_20": 95e-6}


def test_the_grid_is_the_one_that_is_shown():
    (end,) = re.findall(r"<!-- end of configs/rig.yaml -->\n```yaml\n(.*?)```", TEXT, re.DOTALL)
    assert (ROOT / "configs/rig.yaml").read_text(encoding="utf-8").endswith(end)


@pytest.mark.slow
def test_the_clearance_is_found_from_the_acceleration(tmp_path):
    whole = YAML(typ="safe").load((ROOT / "configs/rig.yaml").read_text(encoding="utf-8"))
    whole["identify"] |= {"from": {str(ROOT / "configs/rig.csv"): {"slider/a": "acceleration"}}, "cases": 160}
    result = clearsweep.sweep(whole, tmp_path / "rig", show_progress=False)
    computed = {parameter.path: parameter for parameter in result.search_result.parameters}[rigs.CLEARANCE]
    assert computed.low < rigs.TRUE[rigs.CLEARANCE] < computed.high
    (read,) = result.search_result.signals
    assert read.angle == pytest.approx(0.698, abs=0.05)  # 40 deg
    (said,) = (
        parameter
        for parameter in json.loads((tmp_path / "rig" / "answer.json").read_text(encoding="utf-8"))["identified"]
        if parameter["path"] == rigs.CLEARANCE
    )
    assert (said["low"], said["high"]) == (computed.low, computed.high)


@pytest.mark.slow
def test_a_growing_clearance_is_followed_from_file_to_file(tmp_path, monkeypatch):
    (tmp_path / "configs").mkdir()
    (tmp_path / "measured").mkdir()
    (tmp_path / "configs/rig.yaml").write_text((ROOT / "configs/rig.yaml").read_text(encoding="utf-8"))
    for name, clearance in TRUE.items():
        rig = rigs.TRUE | {rigs.CLEARANCE: clearance}
        rigs.measure(tmp_path / f"measured/{name}.csv", rig, 1, revolutions=10, samples=720)
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    (tmp_path / "series.py").write_text(code)
    history = runpy.run_path("series.py")["history"]
    assert history["week_00"].high < history["week_20"].low
    for name, clearance in TRUE.items():
        assert history[name].low < clearance < history[name].high
        assert history[name].high - history[name].low < 0.5 * clearance
