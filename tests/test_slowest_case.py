"""What a run reports of the case that took longest for the time that its machine takes."""

import math

import numpy as np
import pytest

from clearsweep.contracts.layout import Column, Layout
from clearsweep.sweeping.facts import SlowestCase


def layout_with(*columns, life=""):
    return Layout("slider-crank", True, "slider", (), tuple(Column(name, "s", "") for name in columns), (), life=life)


def told_of(record, layout, block):
    pace = SlowestCase(record, layout)
    assert set(pace.columns) <= set(block)
    pace.add({name: np.array(values) for name, values in block.items()}, lambda place: {"case_id": f"case{place}"})
    return pace.slowest


def test_the_slowest_case_is_the_one_with_the_least_motion_for_its_time():
    record = {"drive": {}, "simulate": {"revolutions": 10.0}, "units": {"drive.speed": "rpm"}}
    block = {"run_time": [0.1, 0.05, 0.3], "drive.speed": [100.0 * math.pi, -400.0 * math.pi, 50.0 * math.pi]}
    slowest = told_of(record, layout_with("run_time"), block)
    assert slowest["case_id"] == "case1"
    assert slowest["factor"] == pytest.approx(10.0 * 2.0 / 400.0 / 0.05, rel=1e-12)


def test_a_run_with_until_counts_the_revolutions_that_were_run():
    record = {"drive": {"speed": 2.0 * math.pi}, "simulate": {"revolutions": 10.0}, "units": {}}
    slowest = told_of(
        record, layout_with("run_time", "revolutions_run"), {"run_time": [2.0], "revolutions_run": [40.0]}
    )
    assert slowest["factor"] == pytest.approx(20.0, rel=1e-12)


@pytest.mark.parametrize("life", ["", "rod-slider"])
def test_nothing_is_reported_of_lives_and_of_cranks_without_a_speed(life):
    record = {"drive": {"speed": 10.0} if life else {"torque": 3.0}, "simulate": {"revolutions": 10.0}, "units": {}}
    assert told_of(record, layout_with("run_time", life=life), {"run_time": [1.0]}) is None
