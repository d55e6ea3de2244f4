"""The tutorial on a measured rig: its grid is the one that is ready, and its steps find the clearance."""

import json
import re
import runpy
from pathlib import Path

import pytest
import rigs
from ruamel.yaml import YAML

import clearsweep

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
