"""Claims about what `make scale` measures, and about what does not grow with the square of the cases."""

import math
import time

import numpy as np
import pandas as pd
import pytest
import scale
import scale_cases
import speed_page
from fake_runs import OfFrame

from clearsweep import grid, simulation
from clearsweep.contracts.results import Trajectory
from clearsweep.language import wording
from clearsweep.report.axis import Rows
from clearsweep.report.blocks.table import CaseRows
from clearsweep.report.draw import comparison
from clearsweep.report.study import Axis, Study, index_on_axis, reduce_over_other_axes
from clearsweep.sweeping.pool.case_runner import distinct, is_common


@pytest.fixture
def chance():
    return np.random.default_rng(11)


class CountsItems(np.ndarray):
    """Counts the indices by which its items are read."""

    count = 0

    def __getitem__(self, index):
        CountsItems.count += np.size(index)
        return np.asarray(self)[index]


def axis(values):
    return Axis("drive.speed", "speed", wording.Scale(1.0, ""), tuple(values), 4)


class MadeUp(OfFrame):
    """A run of which only the summary is there."""

    def __init__(self, figures):
        self.summary = pd.DataFrame(figures)
        self.summary.insert(0, "case_id", [f"{k:06d}" for k in range(len(self.summary))])


def table_of(figures):
    """Return figures as the rows of a run."""
    run = MadeUp(figures)
    return Rows(run, run.summary["case_id"], np.ones(len(run.summary), bool), set())


@pytest.mark.parametrize("count", [*scale_cases.COUNTS, 100])
def test_a_grid_has_as_many_cases_as_it_is_measured_for(count):
    axes = scale_cases.axes_of(count, dict.fromkeys("abc", (1.0, 2.0)))
    assert math.prod(map(len, axes.values())) == count
    assert all(np.mean(values) == pytest.approx(1.5, rel=1e-12, abs=0.0) for values in axes.values())


def test_stand_ins_take_the_processor_as_long_as_asked():
    cases = grid.load(scale_cases.made_up(1, 0.01), scale_cases.StandIn.catalogue())
    began = time.process_time()
    result = scale_cases.StandIn.solve(cases.case(0))
    assert 0.01 <= result.summary["run_time"] <= time.process_time() - began


def test_real_cases_are_timed_by_the_processor(monkeypatch):
    def solve(spent):
        began = time.process_time()
        while time.process_time() - began < spent:
            pass
        time.sleep(0.05)  # no processor time
        return Trajectory("ok", "", {"run_time": 0.0})

    monkeypatch.setattr(simulation, "solve", solve)
    began = time.process_time()
    assert 0.01 <= scale_cases.timed(0.01).summary["run_time"] <= time.process_time() - began < 0.05


@pytest.mark.slow
def test_a_case_takes_few_bytes_of_the_parent(tmp_path):
    few, many = (scale.measured("run", "made-up", tmp_path / str(count), count)["memory"] for count in (1_000, 100_000))
    assert many - few < 200 * 99_000  # B; 163 measured, most of them columns that the answer needs


def test_each_command_leaves_the_others_their_parts_of_the_page(tmp_path):
    page = tmp_path / "speed.md"
    page.write_text("of no part\n")
    for part, text in (("many cases", "old"), ("other programs", "# Speed"), ("many cases", "new\n\nlines")):
        speed_page.write(part, f"{text}\n", page)
    first, second = (speed_page.mark(part) for part in ("other programs", "many cases"))
    assert page.read_text() == f"{first}# Speed\n\n{second}new\n\nlines\n"
    assert page.read_text().count("make scale") == 1


def test_the_page_that_is_kept_has_parts_that_commands_write():
    parts = speed_page.parts(speed_page.PAGE.read_text(encoding="utf-8"))
    assert parts
    assert set(parts) <= set(speed_page.PARTS)


def test_identities_are_found_as_numpy_finds_them(chance):
    for many in (0, 1, 200):
        values, those = (chance.integers(0, 100, many, dtype="u8") for _ in range(2))
        np.testing.assert_array_equal(distinct(values), np.unique(values))
        np.testing.assert_array_equal(is_common(values, distinct(those)), np.isin(values, those))


def test_values_are_found_on_their_axis(chance):
    for values in ([2.0], [0.3, 0.1, 0.2], list(chance.uniform(1.0, 2.0, 40))):
        given = np.concatenate(
            [values, np.multiply(values, 1.0 + 1e-12), np.multiply(values, 1.001), [np.nan, -1.0, 9.0]]
        )
        expected = [
            next((k for k, value in enumerate(values) if abs(value - each) <= 1e-9 * value), -1) for each in given
        ]
        np.testing.assert_array_equal(index_on_axis(axis(values), given), expected)


def test_a_map_of_many_cells_takes_no_pass_over_all_cases_for_each(chance):
    across, up = axis(np.arange(1.0, 201.0)), axis(np.arange(1.0, 101.0))._replace(path="other")
    cases = table_of({each.path: chance.choice(each.values, 100_000) for each in (across, up)})
    values = chance.normal(size=len(cases))
    values[::7] = np.nan
    values = values.view(CountsItems)
    table = reduce_over_other_axes(Study(None, (), (), "", cases, cases, {}, {}), values, (across, up), np.median)
    assert CountsItems.count == np.isfinite(values).sum()  # each value once, where masks of cells read all of them
    for row, column in ((0, 0), (3, 77), (99, 199)):
        here = (cases["other"] == up.values[row]) & (cases["drive.speed"] == across.values[column]) & ~np.isnan(values)
        assert table[row, column] == np.median(values[here])


def test_rows_of_a_table_are_the_same_one_by_one_and_at_once(chance):
    cases = table_of({"force": chance.normal(size=9000)})
    listed = CaseRows(cases, ["force"], "force")
    assert list(listed) == [*zip(cases.index[np.argsort(-cases["force"])], sorted(cases["force"])[::-1], strict=True)]
    assert listed[:50] == list(listed)[:50]
    assert (listed[0], listed[-1]) == tuple(list(listed)[k] for k in (0, -1))


def test_a_cloud_leaves_out_points_that_others_cover_and_no_others():
    x, y = (each.ravel().astype(float) for each in np.meshgrid(np.arange(50), np.arange(60)))
    x[5] = np.nan
    seen = comparison.visible_points(np.repeat(x, 3), np.repeat(y, 3))
    np.testing.assert_array_equal(seen, 3 * np.delete(np.arange(3000), 5) + 2)
