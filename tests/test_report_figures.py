"""Curves, maps and kinds of motion: what is drawn is what the summary and the run contain."""

import csv

import fake_physics
import numpy as np
import pandas as pd
import pytest
from fake_runs import RPM, Run
from matplotlib.figure import Figure

from clearsweep import report, store
from clearsweep.report import kinds, spectrum, strobe, study
from clearsweep.report.sections import curves, maps, motion_type, tradeoffs

CLEARANCES, SPEED, PEAK = "joints.rod-slider.clearance", "drive.speed", "rod_slider_force_peak"
IDEAL = "rod_slider_force_peak_ideal"


def painted(picture):
    axes = Figure().subplots()
    picture.paint(axes)
    return axes


def section(run, module=curves, **options):
    (result,) = module.sections(study.prepare(run, **options))
    return {picture.title: picture for _, picture in result.pictures}


@pytest.mark.parametrize(("typical", "reduced"), [(False, "max"), (True, "median")])
def test_a_curve_for_each_clearance_holds_the_worst_case_at_each_speed_or_the_median(typical, reduced):
    run = Run()
    axes = painted(section(run, typical=typical)["Force peak over crank speed"])
    by_value = run.summary.groupby([CLEARANCES, SPEED])[PEAK].agg(reduced)
    assert [line.get_label() for line in axes.lines] == ["0.05", "0.1", "0.2", "0.5"]
    for line, clearance in zip(axes.lines, (5e-5, 1e-4, 2e-4, 5e-4), strict=True):
        assert np.asarray(line.get_xdata()) == pytest.approx([1000, 3000, 5000])
        assert 1e3 * np.asarray(line.get_ydata()) == pytest.approx(by_value[clearance].to_numpy(), rel=1e-12)


def test_the_line_across_is_the_limit_also_where_it_is_a_multiple_of_the_ideal_peak():
    run = Run()
    run.grid["limits"] = {PEAK: {"at_most": 2.0, "times": IDEAL}, "slider_error_max": 1e-4}
    drawn = section(run)
    assert next(iter(drawn)) == "Force peak over crank speed"
    bound = painted(drawn["Force peak over crank speed"]).lines[-1]
    ideal = run.summary.groupby(SPEED)[IDEAL].min().to_numpy()
    assert bound.get_label() == "limit"
    assert 1e3 * np.asarray(bound.get_ydata()) == pytest.approx(2.0 * ideal, rel=1e-12)
    fixed = painted(drawn["Slider error over crank speed"]).lines[-1]
    assert np.asarray(fixed.get_ydata()) == pytest.approx([0.1] * 3, rel=1e-12)  # mm


def test_of_a_figure_that_should_be_large_the_smallest_is_drawn():
    run = Run()
    run.grid["limits"] = {PEAK: {"at_least": 1.0}}
    picture = section(run)["Force peak over crank speed"]
    least = run.summary.groupby([CLEARANCES, SPEED])[PEAK].min()[5e-5].to_numpy()
    assert 1e3 * np.asarray(painted(picture).lines[0].get_ydata()) == pytest.approx(least, rel=1e-12)
    assert picture.caption == "Smallest over stiffness and restitution."


def test_one_axis_has_one_curve_and_few_or_no_numbers_have_none():
    single = Run(sweep={SPEED: [1000 * RPM, 3000 * RPM, 5000 * RPM]})
    axes = painted(section(single)["Force peak over crank speed"])
    assert 1e3 * np.asarray(axes.lines[0].get_ydata()) == pytest.approx(
        single.summary.sort_values(SPEED)[PEAK].to_numpy(), rel=1e-12
    )
    assert axes.get_legend() is None
    assert curves.sections(study.prepare(Run(sweep={SPEED: [1000 * RPM, 3000 * RPM]}))) == []
    assert (
        curves.sections(study.prepare(Run(sweep={"joints.rod-slider.contact.law": ["hertz", "flores", "exact"]}))) == []
    )


def test_many_clearances_are_thinned_and_the_caption_says_so():
    run = Run(sweep={CLEARANCES: np.linspace(1e-4, 5e-4, 20).tolist(), SPEED: [100.0, 200.0, 300.0]})
    picture = section(run)["Force peak over crank speed"]
    assert picture.caption == "7 of 20 values of clearance. "
    assert len(painted(picture).lines) == 7


def test_maps_of_one_figure_share_their_colours_and_hold_the_summary():
    run = Run()
    drawn = section(run, maps) | {picture.title: picture for picture in maps.first(study.prepare(run))}
    forces = [painted(picture) for title, picture in drawn.items() if title.startswith("Force peak: ")]
    ends = {axes.collections[0].get_clim() for axes in forces}
    tables = [run.summary.groupby([first, other])[PEAK].max() for first, other in ((CLEARANCES, SPEED),)]
    assert len(forces) == 6
    ((low, high),) = ends
    assert high == pytest.approx(run.summary[PEAK].max() / 1e3, rel=1e-12)
    assert low <= tables[0].min() / 1e3
    cells = painted(drawn["Force peak: clearance \u00d7 crank speed"]).collections[0].get_array()
    assert 1e3 * np.asarray(cells).ravel() == pytest.approx(tables[0].unstack(0).to_numpy().ravel(), rel=1e-12)


def test_what_does_not_vary_has_neither_map_nor_cloud():
    run = Run()
    run.summary["rod_slider_impacts_per_rev"], run.summary["rod_slider_onset_rate_max"] = 0.0, 0.0
    assert not any("Impacts" in title for title in section(run, maps))
    assert "How hard the journal arrives" not in section(run, tradeoffs)
    assert "Force peak against p99" in section(run, tradeoffs)


def test_clearances_of_several_joints_have_one_unit():
    sweep = {"joints.rod-slider.clearance": [5e-5, 7e-5], "joints.crank-rod.clearance": [1e-4, 5e-4]}
    given = study.prepare(Run(sweep=sweep, joints=("rod_slider", "crank_rod")))
    assert {axis.scale.unit for axis in given.axes} == {"mm"}


CLEARANCE = "joints.rod-slider.clearance"
PAIR = {CLEARANCE: [1e-4, 2e-4], "drive.speed": [1000 * RPM, 2000 * RPM, 4000 * RPM]}
TURN = 2.0 * np.pi


def test_a_spectrum_finds_every_oscillation_at_its_order_and_no_other():
    angle = np.linspace(0.0, 2 * TURN, 1441)
    values = 7.0 + 3.0 * np.cos(2 * angle + 0.3) + 0.5 * np.sin(5.5 * angle)
    result = spectrum.of_history(angle, values)
    assert result.turns == 2
    amplitudes = dict(zip(result.order.tolist(), result.amplitude.tolist(), strict=True))
    assert amplitudes.pop(2.0) == pytest.approx(3.0, rel=1e-12)
    assert amplitudes.pop(5.5) == pytest.approx(0.5, rel=1e-12)
    assert max(amplitudes.values()) < 1e-12


def test_a_spectrum_keeps_the_mean_square_and_leaves_out_what_is_no_whole_turn():
    angle = np.linspace(1.0, 1.0 + 2.25 * TURN, 2 * 360 + 90 + 1)
    values = np.random.default_rng(1).normal(size=len(angle))
    result, last = spectrum.of_history(angle, values), values[-720:]
    square = 0.5 * (result.amplitude[:-1] ** 2).sum() + result.amplitude[-1] ** 2
    assert square == pytest.approx(last.var(), rel=1e-12)
    assert spectrum.of_history(angle[:300], values[:300]) is None


def test_a_diagram_has_the_stored_points_of_the_cases_along_its_axis_after_what_is_discarded():
    run = Run(sweep=PAIR)
    given = study.prepare(run)
    beside = run.summary.query(f"`{CLEARANCE}` == 2e-4")["case_id"].iloc[0]
    axis = next(axis for axis in given.axes if axis.path == "drive.speed")
    points = strobe.along_axis(given, given.joints[0], axis, beside)
    cases = run.summary.query(f"`{CLEARANCE}` == 2e-4").sort_values("drive.speed")
    stored = pd.concat([run.poincare(case_id)[2:] for case_id in cases["case_id"]])
    assert points.cases == 3
    assert points.x.tolist() == stored["rod_slider/x"].tolist()
    assert points.y.tolist() == stored["rod_slider/y"].tolist()
    assert points.value.tolist() == np.repeat(cases["drive.speed"].to_numpy(), 9).tolist()
    assert set(points.clearance) == {2e-4}


def test_axes_in_step_are_followed_together():
    run = Run(sweep=PAIR)
    given = study.prepare(run)
    run.grid["zip"] = {path: [] for path in PAIR}
    axis = next(axis for axis in given.axes if axis.path == "drive.speed")
    assert len(strobe.line(given, axis, run.summary["case_id"][0])) == 6


class Struck(Run):
    """A run whose journals touch when its test says: case_id -> (on, off) in turns of the crank."""

    def event_blocks(self):
        """Yield the events of all cases at once, a contact of another joint among them."""
        counts, values = [], {"t": [], "joint": [], "kind": []}
        for case_id, speed in zip(self.summary["case_id"], self.summary["drive.speed"], strict=True):
            own = sorted((turn, 0, kind) for pair in self.contacts[case_id] for kind, turn in enumerate(pair))
            events = [*own, (9.99, 1, 0), (9.995, 1, 1)]
            counts.append(len(events))
            for name, each in zip(("t", "joint", "kind"), zip(*events, strict=True), strict=True):
                values[name] += [TURN / speed * turn for turn in each] if name == "t" else each
        yield np.array(counts), {name: np.array(each) for name, each in values.items()}


def test_the_time_of_impacts_is_that_of_contacts_shorter_than_ten_degrees_within_the_window():
    run = Struck(sweep={"drive.speed": [1000 * RPM, 2000 * RPM]}, joints=("rod_slider", "crank_rod"))
    first, second = run.summary["case_id"]
    run.contacts = {
        first: [(1.0, 1.01), (1.99, 2.005), (3.0, 3.02), (4.0, 4.5)],
        second: [(2.5, 2.5277), (2.6, 2.6279)],
    }
    given = study.prepare(run)
    result = kinds.short_contacts(given, given.joints[0])
    assert result == pytest.approx([(0.005 + 0.02) / 8, 0.0277 / 8], rel=1e-9)


@pytest.mark.parametrize(
    ("bearing", "onsets", "contact"),
    [(1.0, 0.0, 0), (0.9, 3.0, 1), (0.1, 6.0, 2), (0.1, 3.5, 1), (0.0, 0.0, 3), (np.nan, np.nan, -1)],
)
def test_a_contact_is_named_by_how_long_it_lasts(bearing, onsets, contact):
    run = Run(sweep={"drive.speed": [1000 * RPM, 2000 * RPM]})
    run.summary["rod_slider_contact_fraction"], run.summary["rod_slider_impacts_per_rev"] = bearing, onsets
    given = study.prepare(run)
    assert kinds.of_joint(given, given.joints[0]).contact.tolist() == [contact] * 2


def test_the_table_of_kinds_is_that_of_the_summary(tmp_path):
    run = Run(sweep=PAIR)
    run.summary["period"] = [1.0, 2.0, 3.0, np.nan, 1.0, np.nan]
    report.tables(run, tmp_path)
    rows = list(csv.DictReader((tmp_path / "kinds_of_motion.csv").read_text().splitlines()))
    assert [row["axis"] for row in rows] == ["clearance"] * 2 + ["crank speed"] * 3
    for row in rows:
        path = CLEARANCE if row["axis"] == "clearance" else "drive.speed"
        alike = run.summary[run.summary[path] == float(row["value"])]
        bearing, period = alike["rod_slider_contact_fraction"], alike["period"]
        assert float(row["free flight"]) == pytest.approx(1.0 - bearing.mean(), rel=1e-12)
        parts = [float(row[name]) for name in ("free flight", "impacts", "lasting contact")]
        assert sum(parts) == pytest.approx(1.0, rel=1e-12)
        expected = [(period == 1).mean(), (period == 2).mean(), (period == 3).mean(), period.isna().mean()]
        result = [float(row[name]) for name in ("period 1", "period 2", "period n", "irregular")]
        assert result == pytest.approx(expected)


def test_the_section_shows_what_there_is_and_is_left_out_where_nothing_turns():
    (shown,) = motion_type.sections(study.prepare(Run(sweep=PAIR)))
    assert [picture.title for _, picture in shown.pictures] == [
        "Contact: clearance \u00d7 crank speed",
        "Period: clearance \u00d7 crank speed",
        "Share of time over crank speed",
        "Cases by period over crank speed",
        "Bifurcation diagram over crank speed",
        "Poincaré section: places",
        "Poincaré section: rates",
        "Spectrum of normal force",
        "Spectrum of slider acceleration",
    ]
    (bare,) = motion_type.sections(study.prepare(Run(sweep=PAIR, histories=False)))
    assert len(bare.pictures) == 4
    assert [column.name for column in bare.tables[0].columns[3:5]] == ["free flight", "contact"]
    pair = Run(sweep={}, joints=("pair",), mechanism="impact-pair", wear=False)
    assert motion_type.sections(study.prepare(pair)) == []


def test_a_film_does_not_fly():
    run = Run(sweep=PAIR)
    run.summary["rod_slider_film_thickness_min"] = 1e-5
    (shown,) = motion_type.sections(study.prepare(run))
    assert [picture.title for _, picture in shown.pictures][:2] == [
        "Period: clearance \u00d7 crank speed",
        "Cases by period over crank speed",
    ]
    assert [column.name for column in shown.tables[0].columns[3:]] == ["period 1", "period 2", "period n", "irregular"]
    assert "impact" not in shown.blocks[0].note


def test_events_are_read_in_blocks_as_they_are_read_case_by_case(tmp_path, monkeypatch):
    grid = fake_physics.grid(masses=3, gravities=(fake_physics.GOOD, fake_physics.FAILS))
    fake_physics.sweep(grid, tmp_path / "run", executor="serial", show_progress=False)
    run = store.open(tmp_path / "run")
    monkeypatch.setattr("clearsweep.store.read.GROUP_ROWS", 4)
    blocks = list(run.event_blocks())
    assert [len(counts) for counts, _ in blocks] == [4, 2]
    first = pd.concat([run.events(case_id) for case_id in run.summary["case_id"]])
    assert sum(counts.sum() for counts, _ in blocks) == len(first) > 0
    for name, words in (("t", None), ("joint", run.layout.contacts), ("kind", ("on", "off"))):
        values = np.concatenate([events[name] for _, events in blocks])
        assert [*(values if words is None else (words[code] for code in values))] == first[name].tolist()
