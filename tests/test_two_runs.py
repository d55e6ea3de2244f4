"""Two runs are compared by the values that either varies, and what differs is given in numbers."""

import csv

import numpy as np
import pytest
from fake_runs import RPM, Run

from clearsweep.language.errors import InputError
from clearsweep.report.blocks.section import painted
from clearsweep.report.documents import two_runs
from clearsweep.report.study import prepare

CLEARANCE = "joints.rod-slider.clearance"
SHORT = {CLEARANCE: [1e-4, 2e-4], "drive.speed": [1000 * RPM, 3000 * RPM]}


def harder(run, factor=2.0):
    """Return a run whose force peak is larger by a factor."""
    run.summary["rod_slider_force_peak"] *= factor
    run.directory = "harder"
    return run


def made(**options):
    run = Run(**options)
    run.directory = "plain"
    return run


def tables_of(first, second, tmp_path):
    two_runs.comparison_page(first, second).write_tables(tmp_path)
    return {path.stem: list(csv.DictReader(path.read_text().splitlines())) for path in tmp_path.glob("*.csv")}


def test_every_case_meets_its_counterpart_and_the_factor_between_them_is_reported(tmp_path):
    result = tables_of(made(sweep=SHORT), harder(made(sweep=SHORT)), tmp_path)
    figures = {row["column"]: row for row in result["compared_figures"]}
    assert float(figures["rod_slider_force_peak"]["B over A, median"]) == pytest.approx(2.0)
    assert list(figures) == ["rod_slider_force_peak"]  # the others are the same
    assert float(figures["rod_slider_force_peak"]["cases that differ"]) == 1.0
    assert len(result["compared_cases"]) == 4
    assert all(float(row["B over A"]) == pytest.approx(2.0) for row in result["compared_cases"])


def test_a_value_that_one_run_sweeps_and_the_other_has_fixed_is_matched():
    several, single = made(sweep=SHORT), made(sweep={CLEARANCE: [1e-4, 5e-4]})
    speed = prepare(single).base["drive"]["speed"]
    several.summary.loc[several.summary["drive.speed"] == 1000 * RPM, "drive.speed"] = speed
    pairs = two_runs.pair_cases(prepare(several), prepare(single))
    assert len(pairs.case_ids) == 1
    assert pairs.unpaired == (3, 1)


def test_runs_without_a_case_in_common_are_refused():
    with pytest.raises(InputError, match="no finished case of one has the same values"):
        two_runs.pair_cases(prepare(made(sweep={CLEARANCE: [1e-4]})), prepare(made(sweep={CLEARANCE: [2e-4]})))


def test_the_page_says_what_differs_in_the_setup():
    heavier = harder(made(sweep=SHORT))
    heavier.grid["mechanism"]["slider"]["mass"] = 0.28
    plain = made(sweep=SHORT)
    for run, bound in ((plain, 4e3), (heavier, 5e3)):
        run.grid |= {"limits": {"rod_slider_force_peak": bound}}
        run.grid["keys"] = ["mechanism", "limits"]
    text = two_runs.comparison_page(plain, heavier).text()
    mass = "mechanism.slider.mass from 0.14\u00a0kg to 0.28\u00a0kg"
    limit = "limits.rod_slider_force_peak from 4\u00a0kN to 5\u00a0kN"
    changed = text.index(f"Changed from A to B: {mass}; {limit}.")
    verdict = text.index("A: None of 2 designs")
    largest = text.index("Largest change of a figure with a unit: the force peak of B is 2.00 times that of A")
    assert changed < verdict < largest < text.index("4 cases finished in both runs")
    assert "4 cases finished in both runs" in text
    assert "The force peak of B is 2.00 times that of A in the median case" in text
    assert "Equal in every case: force rms, force p99" in text


def test_what_is_drawn_is_each_case_of_b_over_that_of_a():
    first, second = made(sweep=SHORT), harder(made(sweep=SHORT))
    (name, picture), *_ = two_runs.comparison_page(first, second).sections[0].pictures
    assert (name, picture.title) == ("", "Force peak of B over A")
    (points,) = (item for item in painted(picture)[0].axes.items if item.kind == "points")
    drawn = 1e3 * np.stack([points.x, points.y], -1)
    forces = first.summary["rod_slider_force_peak"].to_numpy()
    assert drawn[np.argsort(drawn[:, 0])] == pytest.approx(np.sort(forces)[:, np.newaxis] * [1.0, 2.0], rel=1e-12)
