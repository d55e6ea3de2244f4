"""Curves, maps, kinds of motion, wear and laws: the report shows what the summary and the run contain."""

import base64
import csv
import re

import fake_physics
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from fake_runs import CONFIGS, RPM, Run
from mechanism_cases import PAIR, changed
from test_report import Page

from clearsweep import grid, report, simulation, store
from clearsweep.answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, column_label
from clearsweep.answers.words import common_units
from clearsweep.cli import verbs
from clearsweep.contracts.case import Contact, Joint, Material, Materials
from clearsweep.contracts.results import Trajectory
from clearsweep.language.wording import TIMES, axis_name, quantity_text
from clearsweep.report import sections
from clearsweep.report.blocks.section import Detail, Gallery, Interactive, Points, Sentences, draw_svg, painted
from clearsweep.report.blocks.table import Column, Table
from clearsweep.report.documents.page import case_pictures
from clearsweep.report.laws import CURVE_DEPTHS
from clearsweep.report.motion import (
    cases_along_axis,
    classify_motion,
    harmonic_spectrum,
    points_along_axis,
    short_contacts,
)
from clearsweep.report.one_case.joints import wear_pictures
from clearsweep.report.sections.drivers import tradeoff_sections
from clearsweep.report.sections.laws import elastic_laws_sections, law_choice_sections
from clearsweep.report.sections.maps import answer_maps, curve_sections, map_sections
from clearsweep.report.sections.motion import motion_type_sections
from clearsweep.report.study import prepare, resolve_cases
from clearsweep.sweeping import summary, sweep
from clearsweep.sweeping.facts import value_text
from clearsweep.sweeping.pool.case_runner import SIMULATION

CLEARANCE, SPEED, PEAK = "joints.rod-slider.clearance", "drive.speed", "rod_slider_force_peak"
IDEAL = "rod_slider_force_peak_ideal"


def axes_of(picture):
    """Return the axes that a picture is painted on."""
    return painted(picture)[0].axes


def items(axes, kind="line"):
    return [item for item in axes.items if item.kind == kind]


def pictures(run, builder=curve_sections, **options):
    (result,) = builder(prepare(run, **options))
    return {picture.title: picture for _, picture in result.pictures}


@pytest.mark.parametrize(("typical", "reduced"), [(False, "max"), (True, "median")])
def test_a_curve_for_each_clearance_is_the_worst_case_or_the_median(typical, reduced):
    run = Run()
    axes = axes_of(pictures(run, shows_median=typical)["Force peak over crank speed"])
    by_value = run.summary.groupby([CLEARANCE, SPEED])[PEAK].agg(reduced)
    assert [entry.name for entry in axes.legend_entries] == ["0.05", "0.1", "0.2", "0.5"]
    for line, clearance in zip(items(axes), (5e-5, 1e-4, 2e-4, 5e-4), strict=True):
        assert line.x == pytest.approx([1000, 3000, 5000])
        assert 1e3 * line.y == pytest.approx(by_value[clearance].to_numpy(), rel=1e-12)


def test_the_line_across_is_the_limit_also_where_it_is_a_multiple_of_the_ideal_peak():
    run = Run()
    run.grid["limits"] = {PEAK: {"at_most": 2.0, "times": IDEAL}, "slider_error_max": 1e-4}
    drawn = pictures(run)
    assert next(iter(drawn)) == "Force peak over crank speed"
    axes = axes_of(drawn["Force peak over crank speed"])
    limit_line = items(axes)[-1]
    ideal = run.summary.groupby(SPEED)[IDEAL].min().to_numpy()
    assert axes.legend_entries[-1].name == "limit"
    assert 1e3 * limit_line.y == pytest.approx(2.0 * ideal, rel=1e-12)
    fixed = items(axes_of(drawn["Slider error over crank speed"]))[-1]
    assert fixed.y == pytest.approx([0.1] * 3, rel=1e-12)  # mm


def test_of_a_figure_that_should_be_large_the_smallest_is_drawn():
    run = Run()
    run.grid["limits"] = {PEAK: {"at_least": 1.0}}
    picture = pictures(run)["Force peak over crank speed"]
    least = run.summary.groupby([CLEARANCE, SPEED])[PEAK].min()[5e-5].to_numpy()
    assert 1e3 * items(axes_of(picture))[0].y == pytest.approx(least, rel=1e-12)
    assert picture.caption == "Smallest over stiffness and restitution."


def test_one_axis_has_one_curve_and_few_or_no_numbers_have_none():
    single = Run(sweep={SPEED: [1000 * RPM, 3000 * RPM, 5000 * RPM]})
    axes = axes_of(pictures(single)["Force peak over crank speed"])
    assert 1e3 * items(axes)[0].y == pytest.approx(single.summary.sort_values(SPEED)[PEAK].to_numpy(), rel=1e-12)
    assert axes.legend is None
    assert curve_sections(prepare(Run(sweep={SPEED: [1000 * RPM, 3000 * RPM]}))) == []
    assert curve_sections(prepare(Run(sweep={"joints.rod-slider.contact.law": ["hertz", "flores", "exact"]}))) == []


def test_many_clearances_are_thinned_and_the_caption_says_so():
    run = Run(sweep={CLEARANCE: np.linspace(1e-4, 5e-4, 20).tolist(), SPEED: [100.0, 200.0, 300.0]})
    picture = pictures(run)["Force peak over crank speed"]
    assert picture.caption == "7 of 20 values of clearance. "
    assert len(items(axes_of(picture))) == 7


def test_maps_of_one_figure_share_their_colours_and_hold_the_summary():
    run = Run()
    drawn = pictures(run, map_sections) | {picture.title: picture for picture in answer_maps(prepare(run))}
    forces = [axes_of(picture) for title, picture in drawn.items() if title.startswith("Force peak: ")]
    ends = {items(axes, "cells")[0].style.scale[:2] for axes in forces}
    tables = [run.summary.groupby([first, other])[PEAK].max() for first, other in ((CLEARANCE, SPEED),)]
    assert len(forces) == 6
    ((low, high),) = ends
    assert high == pytest.approx(run.summary[PEAK].max() / 1e3, rel=1e-12)
    assert low <= tables[0].min() / 1e3
    (cells,) = items(axes_of(drawn["Force peak: clearance \u00d7 crank speed"]), "cells")
    assert 1e3 * cells.style.values.ravel() == pytest.approx(tables[0].unstack(0).to_numpy().ravel(), rel=1e-12)


@pytest.mark.parametrize("figure", ["film_thickness_min", "film_loss"])
def test_a_cell_with_an_unsafe_film_is_marked_on_the_map(figure):
    run = Run()
    for name, unit in (("film_thickness_min", "m"), ("film_loss", "W"), ("film_limit_fraction", "1")):
        column = run.layout.columns[-1]._replace(name=f"rod_slider_{name}", unit=unit, figure=name, joint="rod_slider")
        run.layout = run.layout._replace(columns=(*run.layout.columns, column))
        run.summary[column.name] = 1e-9 * run.summary["rod_slider_force_peak"]
        run.summary.attrs["units"][column.name] = unit
    run.summary["rod_slider_film_limit_fraction"] = 0.0
    run.summary.loc[0, "rod_slider_film_limit_fraction"] = 0.1
    name = {"film_thickness_min": "Least film", "film_loss": "Film loss"}[figure]
    (picture,) = (each for each in answer_maps(prepare(run)) if each.title.startswith(f"{name}: "))
    texts = [item.style.text for item in items(axes_of(picture), "text")]
    marked = [text for text in texts if "unsafe" in text]
    assert len(marked) == 1
    assert "Unsafe: a case of the cell is not within its law." in picture.caption
    assert column_label(run.layout, f"rod_slider_{figure}") == name.lower()  # as in the sentences


def test_what_does_not_vary_has_neither_map_nor_cloud():
    run = Run()
    run.summary["rod_slider_impacts_per_rev"], run.summary["rod_slider_onset_rate_max"] = 0.0, 0.0
    assert not any("Impacts" in title for title in pictures(run, map_sections))
    assert "Force peak against onset rate" not in pictures(run, tradeoff_sections)
    assert "Force peak against p99" in pictures(run, tradeoff_sections)


def test_clearances_of_fits_are_in_micrometres_on_the_page_and_in_the_last_lines():
    means = [1.725e-5, 1.7e-4]
    run = Run(sweep={CLEARANCE: means})
    run.grid["fits"] = {
        CLEARANCE: [
            {"name": name, "mean": mean, "low": mean, "high": mean, "diameter": 0.08}
            for name, mean in zip("ab", means, strict=True)
        ]
    }
    run.grid |= {"written_units": {}, "units": {CLEARANCE: "m"}}
    (axis,) = prepare(run).axes
    assert [axis.text(mean).replace("\u00a0", " ") for mean in means] == ["17.25 \u00b5m (a)", "170 \u00b5m (b)"]
    facts = {"units": {CLEARANCE: "m"}, "fits": run.grid["fits"], "written_units": common_units(run.grid)}
    assert [value_text(CLEARANCE, mean, facts) for mean in means] == ["17.25 \u00b5m (a)", "170 \u00b5m (b)"]


def test_values_of_candidates_have_one_unit_in_the_last_lines():
    labelled = {CLEARANCE: {"H9/d9": 6.8e-5, "H11/d11": 1.35e-4}}
    record = {"units": {CLEARANCE: "m"}, "labels": labelled, "written_units": {}}
    facts = record | {"fits": {}, "written_units": common_units(record)}
    texts = [value_text(CLEARANCE, value, facts) for value in labelled[CLEARANCE].values()]
    assert texts == ["H9/d9 (0.068 mm)", "H11/d11 (0.135 mm)"]


def test_a_key_of_one_body_reads_as_words():
    assert axis_name("joints.pin.wear.bearing.coefficient") == "wear coefficient of the bearing"
    assert axis_name("joints.pin.contact.material.journal.young") == "Young's modulus of the journal"
    assert axis_name("joints.pin.wear.coefficient") == "wear coefficient"
    assert quantity_text("D", "1") == "D"
    assert axis_name("joints.hinge.stops.at.0") == "lower stop"
    assert axis_name("mechanism.rod.elastic.section.1") == "height of the section of rod"


def test_the_head_of_a_column_may_differ_on_the_page_and_in_the_file():
    table = Table("best", "Best", "", (Column("rod_slider_load_peak", "N", heading="load peak"),), [(1.0,)])
    assert [head.name for head in table.to_text().heads] == ["load peak"]
    assert table.csv().startswith("rod_slider_load_peak")


def test_figures_of_one_column_of_the_closing_table_have_one_unit():
    column = [{"column": "start_up_time", "value": value} for value in (0.2478, None, 0.0910)]
    assert summary.figure_texts(column, {"start_up_time": "s"}) == ["0.2478 s", "cut off", "0.091 s"]
    mixed = [{"column": "load", "value": 2584.0}, {"column": "share", "value": 0.5}, {"column": "load", "value": 830.4}]
    assert summary.figure_texts(mixed, {"load": "N"}) == ["2.584 kN", "0.5", "0.8304 kN"]
    velocity = [{"column": "foot_velocity_rms", "value": 1.25}]  # in the unit of the sentences
    assert summary.figure_texts(velocity, {"foot_velocity_rms": "m/s"}) == ["1250 mm/s"]


def test_clearances_of_several_joints_have_one_unit():
    sweep = {"joints.rod-slider.clearance": [5e-5, 7e-5], "joints.crank-rod.clearance": [1e-4, 5e-4]}
    given = prepare(Run(sweep=sweep, joints=("rod_slider", "crank_rod")))
    assert {axis.scale.unit for axis in given.axes} == {"mm"}


TWO_AXES = {CLEARANCE: [1e-4, 2e-4], "drive.speed": [1000 * RPM, 2000 * RPM, 4000 * RPM]}
TURN = 2.0 * np.pi


def test_a_spectrum_finds_every_oscillation_at_its_order_and_no_other():
    angle = np.linspace(0.0, 2 * TURN, 1441)
    values = 7.0 + 3.0 * np.cos(2 * angle + 0.3) + 0.5 * np.sin(5.5 * angle)
    result = harmonic_spectrum(angle, values)
    assert result.revolutions == 2
    amplitudes = dict(zip(result.order.tolist(), result.amplitude.tolist(), strict=True))
    assert amplitudes.pop(2.0) == pytest.approx(3.0, rel=1e-12)
    assert amplitudes.pop(5.5) == pytest.approx(0.5, rel=1e-12)
    assert max(amplitudes.values()) < 1e-12


def test_a_spectrum_keeps_the_mean_square_and_leaves_out_what_is_no_whole_turn():
    angle = np.linspace(1.0, 1.0 + 2.25 * TURN, 2 * 360 + 90 + 1)
    values = np.random.default_rng(1).normal(size=len(angle))
    result, last = harmonic_spectrum(angle, values), values[-720:]
    square = 0.5 * (result.amplitude[:-1] ** 2).sum() + result.amplitude[-1] ** 2
    assert square == pytest.approx(last.var(), rel=1e-12)
    assert harmonic_spectrum(angle[:300], values[:300]) is None


def test_a_diagram_has_the_stored_points_of_the_cases_after_the_discarded():
    run = Run(sweep=TWO_AXES)
    given = prepare(run)
    neighbour = run.summary.query(f"`{CLEARANCE}` == 2e-4")["case_id"].iloc[0]
    axis = next(axis for axis in given.axes if axis.path == "drive.speed")
    points = points_along_axis(given, given.joints[0], axis, neighbour)
    cases = run.summary.query(f"`{CLEARANCE}` == 2e-4").sort_values("drive.speed")
    stored = pd.concat([run.poincare(case_id)[2:] for case_id in cases["case_id"]])
    assert points.cases == 3
    assert points.x.tolist() == stored["rod_slider/x"].tolist()
    assert points.y.tolist() == stored["rod_slider/y"].tolist()
    assert points.value.tolist() == np.repeat(cases["drive.speed"].to_numpy(), 9).tolist()
    assert set(points.clearance) == {2e-4}


def test_axes_in_step_are_followed_together():
    run = Run(sweep=TWO_AXES)
    given = prepare(run)
    run.grid["zip"] = {path: [] for path in TWO_AXES}
    axis = next(axis for axis in given.axes if axis.path == "drive.speed")
    assert len(cases_along_axis(given, axis, run.summary["case_id"][0])) == 6


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
        yield np.array(counts), {name: np.array(value) for name, value in values.items()}


def test_the_time_of_impacts_is_that_of_contacts_below_ten_degrees():
    run = Struck(sweep={"drive.speed": [1000 * RPM, 2000 * RPM]}, joints=("rod_slider", "crank_rod"))
    first, second = run.summary["case_id"]
    run.contacts = {
        first: [(1.0, 1.01), (1.99, 2.005), (3.0, 3.02), (4.0, 4.5)],
        second: [(2.5, 2.5277), (2.6, 2.6279)],
    }
    given = prepare(run)
    result = short_contacts(given, given.joints[0])
    assert result == pytest.approx([(0.005 + 0.02) / 8, 0.0277 / 8], rel=1e-9)


@pytest.mark.parametrize(
    ("bearing", "onsets", "contact"),
    [(1.0, 0.0, 0), (0.9, 3.0, 1), (0.1, 6.0, 2), (0.1, 3.5, 1), (0.0, 0.0, 3), (np.nan, np.nan, -1)],
)
def test_a_contact_is_named_by_how_long_it_lasts(bearing, onsets, contact):
    run = Run(sweep={"drive.speed": [1000 * RPM, 2000 * RPM]})
    run.summary["rod_slider_contact_fraction"], run.summary["rod_slider_impacts_per_rev"] = bearing, onsets
    given = prepare(run)
    assert classify_motion(given, given.joints[0]).contact.tolist() == [contact] * 2


def test_the_table_of_kinds_is_that_of_the_summary(tmp_path):
    run = Run(sweep=TWO_AXES)
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
    (shown,) = motion_type_sections(prepare(Run(sweep=TWO_AXES)))
    assert [picture.title for _, picture in shown.pictures] == [
        "Contact: clearance \u00d7 crank speed",
        "Period: clearance \u00d7 crank speed",
        "Share of time over crank speed",
        "Cases by period over crank speed",
        "Bifurcation diagram of x over crank speed",
        "Bifurcation diagram of y over crank speed",
        "Poincaré section: positions",
        "Poincaré section: velocities",
        "Spectrum of normal force",
        "Spectrum of slider acceleration",
    ]
    (bare,) = motion_type_sections(prepare(Run(sweep=TWO_AXES, histories=False)))
    assert len(bare.pictures) == 4
    assert [column.name for column in bare.tables[0].columns[3:5]] == ["free flight", "contact"]
    pair = Run(sweep={}, joints=("pair",), mechanism="impact-pair", wear=False)
    assert motion_type_sections(prepare(pair)) == []


@pytest.mark.parametrize(
    ("speeds", "is_log"),
    [
        (np.linspace(50.0, 1000.0, 12), False),
        (np.geomspace(50.0, 1000.0, 12), True),
        (np.geomspace(50.0, 90.0, 12), False),
    ],
)
def test_an_axis_is_logarithmic_where_factors_space_its_values(speeds, is_log):
    run = Run(sweep={SPEED: speeds.tolist()})
    assert axes_of(pictures(run)["Force peak over crank speed"]).xaxis.is_log is is_log
    (shown,) = motion_type_sections(prepare(run))
    diagrams = [picture for _, picture in shown.pictures if picture.title.startswith("Bifurcation diagram")]
    assert [picture.title for picture in diagrams] == [
        f"Bifurcation diagram of {name} over crank speed" for name in "xy"
    ]
    assert [axes_of(picture).xaxis.is_log for picture in diagrams] == [is_log, is_log]
    points = [item for picture in diagrams for item in items(axes_of(picture), "points")]
    assert {item.style.size for item in points} == {0.75}  # points: a pixel


def test_a_film_does_not_fly():
    run = Run(sweep=TWO_AXES)
    run.summary["rod_slider_film_thickness_min"] = 1e-5
    (shown,) = motion_type_sections(prepare(run))
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


STIFFNESS = "joints.rod-slider.contact.stiffness"
SWEEP = {CLEARANCE: [5e-5, 1e-4, 2e-4], STIFFNESS: [1e9, 1e10], "drive.speed": [1000 * RPM, 3000 * RPM]}


def wear_blocks(run, kind):
    return [block for part in sections.wear.wear_sections(prepare(run)) for block in part.blocks if type(block) is kind]


def test_depths_round_both_bodies_are_drawn_where_they_are_and_on_one_scale():
    run = Run(sweep=SWEEP)
    (deepest,) = wear_blocks(run, Detail)
    assert deepest.case_id == run.summary.set_index("case_id")["rod_slider_wear_depth_max"].idxmax()
    stored = run.wear(deepest.case_id)["rod_slider"]
    bearing, journal, distance = deepest.pictures
    assert (bearing.title, journal.title) == ("Bearing in the slider", "Journal on the rod")
    axes = [axes_of(picture) for picture in (bearing, journal)]
    for ax, depth in zip(axes, stored, strict=True):
        pairs = depth.reshape(180, 2)  # bins of two degrees, the deeper of two
        (area,) = items(ax, "area")
        assert np.degrees(np.arctan2(area.y, area.x)) % 360.0 == pytest.approx(np.arange(1.0, 360.0, 2.0))
        assert np.hypot(area.x, area.y) == pytest.approx(pairs.max(axis=1) * 1e9)
        mean = items(ax)[-1]
        (mark,) = items(ax, "points")
        assert np.hypot(mean.x, mean.y) == pytest.approx(depth.mean() * 1e9)
        assert np.hypot(mark.x, mark.y) == pytest.approx(depth.max() * 1e9)
        assert np.degrees(np.arctan2(mark.y, mark.x)) % 360.0 == pytest.approx(depth.argmax() + 0.5)
    assert axes[0].yaxis.limits() == axes[1].yaxis.limits()
    for line, depth in zip(items(axes_of(distance)), stored, strict=True):
        assert line.y == pytest.approx(depth.reshape(180, 2).max(axis=1) * 1e9)
    assert "deepest 3.00 nm at 0°" in bearing.caption.replace("\u00a0", " ")


def test_a_body_that_does_not_wear_has_no_circle_of_its_own():
    depth = np.linspace(0.0, 1e-6, 90)
    prepared = prepare(Run(sweep={}))
    joint, case_id = prepared.joints[0], prepared.cases.index[0]
    pictures = wear_pictures(prepared, joint, case_id, (depth, np.zeros(90)))
    assert [picture.title for picture in pictures] == ["Bearing in the slider", "Depth along the surface"]
    assert wear_pictures(prepared, joint, case_id, (np.zeros(90), np.zeros(90))) == []


def test_any_case_but_the_drawn_one_can_be_chosen_the_deepest_first():
    run = Run(sweep=SWEEP)
    (choice,) = wear_blocks(run, Interactive)
    prepared = prepare(run)
    order = prepared.cases.index[prepared.cases.ordered("rod_slider_wear_depth_max")][1:]
    assert [case["name"].split(":")[0] for case in choice.data["cases"]] == [prepared.setting(each) for each in order]
    depths = run.wear(order[0])["rod_slider"]
    most = max(depth.max() for depth in depths)
    for place, depth in enumerate(depths):
        case = choice.data["cases"][0]
        shares = np.frombuffer(base64.b64decode(case["depths"][place]), np.uint8) / 255.0
        assert shares == pytest.approx(depth.reshape(120, 3).max(axis=1) / most, abs=0.501 / 255.0, rel=0.0)
        assert case["mean"][place] == pytest.approx(depth.mean() / most)
    assert wear_blocks(Run(sweep={}), Interactive) == []  # of one case there is nothing to choose


def test_pressure_and_wear_are_mapped_over_the_axes_that_move_them():
    run = Run(sweep=SWEEP)
    frame = run.summary
    frame["rod_slider_pressure_peak"] = 1e6 * frame[CLEARANCE] / 5e-5 * frame[STIFFNESS] / 1e9
    frame["rod_slider_pv_peak"] = 2e6  # the same everywhere: nothing to map
    (gallery,) = wear_blocks(run, Gallery)
    titles = {picture.title: picture for picture in gallery.pictures}
    pressure = f"Pressure peak: clearance {TIMES} stiffness"
    assert list(titles) == [f"Wear depth per 1000 h: clearance {TIMES} crank speed", pressure]
    (cells,) = items(axes_of(titles[pressure]), "cells")
    assert cells.style.values == pytest.approx(np.outer([1.0, 10.0], [1.0, 2.0, 4.0]))
    (line,) = wear_blocks(Run(sweep={CLEARANCE: SWEEP[CLEARANCE]}), Gallery)
    assert [picture.title for picture in line.pictures] == ["Wear depth per 1000 h over clearance"]


def answers(run):
    """Return (what is said, rows of the table) of the trends of a run."""
    (part,) = sections.drivers.trend_sections(prepare(run))
    text = next(block for block in part.blocks if isinstance(block, Points)).texts
    table = next(block for block in part.blocks if isinstance(block, Table))
    return text, {row[0]: row for row in table.rows}


THREE_EACH = {CLEARANCE: [5e-5, 1e-4, 2e-4], STIFFNESS: [1e9, 1e10, 1e11], "drive.speed": [1e2, 2e2, 4e2]}


def with_depths(depth):
    """Return a run whose depths are those of a formula of clearance, stiffness and speed."""
    run = Run(sweep=THREE_EACH)
    frame = run.summary
    frame["rod_slider_wear_depth_max"] = depth(frame[CLEARANCE], frame[STIFFNESS], frame["drive.speed"])
    return run


def test_trends_that_exist_are_shown_with_their_size_and_others_contradicted():
    text, rows = answers(with_depths(lambda c, k, v: 1e-9 * c**0.5 * v**2 * k**-0.3))
    assert text[0] == (
        "Shown: deeper with larger clearance, deeper with higher crank speed, deeper with lower stiffness, uneven "
        "round the bearing and uneven round the journal."
    )
    assert rows["deeper with larger clearance"][4:7] == pytest.approx((2**0.5,) * 3)
    assert rows["deeper with higher crank speed"][4:7] == pytest.approx((4.0,) * 3)
    assert rows["deeper with lower stiffness"][4:7] == pytest.approx((2**-0.3,) * 3)
    text, _ = answers(with_depths(lambda c, k, v: 1e-9 * c**-0.5 * v * k**0.3))
    assert text[1] == "Contradicted: deeper with larger clearance and deeper with lower stiffness."


def test_a_trend_that_chance_may_have_made_is_not_decided():
    chance = np.random.default_rng(2)
    text, rows = answers(with_depths(lambda c, k, v: 1e-9 * v * chance.lognormal(0.0, 0.2, len(c))))
    assert text[1] == "Not decided: deeper with larger clearance and deeper with lower stiffness."
    assert rows["deeper with larger clearance"][5] < 1.0 < rows["deeper with larger clearance"][6]


@pytest.mark.slow
def test_three_claims_are_rarely_wrong_together_where_nothing_acts(monkeypatch):
    """Of 120 runs without a trend 6 may judge any of three claims; without a correction 17 would."""
    chance, wrong = np.random.default_rng(8), 0
    run = Run(sweep=THREE_EACH)
    prepared = prepare(run)
    (joint,) = (joint for joint in prepared.joints if joint.wears)
    concerned = [
        (claim, axis)
        for claim in sections.drivers.CLAIMS
        for axis in prepared.levels()
        if sections.drivers.concerns(claim, axis, joint)
    ]
    assert len(concerned) == 3
    pairs = {axis.path: sections.drivers.match_cases(prepared, axis) for _, axis in concerned}  # the same in every run
    monkeypatch.setattr(sections.drivers, "match_cases", lambda _, axis: pairs[axis.path])
    for _ in range(120):
        trial = prepare(with_depths(lambda c, k, v: 1e-9 * chance.lognormal(0.0, 0.2, len(c))))
        verdicts = {answer.verdict for answer in sections.drivers.judged(trial, joint, concerned)}
        wrong += verdicts != {"not decided"}
    assert wrong <= 12


def test_volume_and_pressure_are_given_as_the_reason_of_a_trend():
    run = with_depths(lambda c, k, v: 1e-9 * c**0.1)
    frame = run.summary
    frame["rod_slider_wear_volume"] = 1e-9 * frame[CLEARANCE] ** 0.05
    frame["rod_slider_pressure_mean"] = 1e6 * frame[CLEARANCE] ** 0.5
    text, rows = answers(run)
    assert rows["volume with clearance"][2] == rows["mean pressure with clearance"][2] == "no claim"
    assert rows["volume with clearance"][4:7] == pytest.approx((2**0.05,) * 3)
    assert rows["mean pressure with clearance"][4:7] == pytest.approx((2**0.5,) * 3)
    assert text[-1].startswith("Reason, as factors of a doubling: volume with clearance 1.04, mean pressure with")


def test_of_what_is_not_swept_nothing_is_said_and_of_one_case_nothing_decided():
    text, rows = answers(Run(sweep={}))
    assert list(rows) == ["uneven round the bearing", "uneven round the journal"]
    assert text == ["Not decided: uneven round the bearing and uneven round the journal."]
    assert sections.drivers.trend_sections(prepare(Run(wear=False))) == []


def test_an_even_wear_is_distinguished_from_an_uneven_one(monkeypatch):
    run = Run(sweep=SWEEP)
    even = {"rod_slider": (np.full(360, 1e-9), 1e-9 * (1.2 + np.sin(np.radians(np.arange(360)))))}
    monkeypatch.setattr(run, "wear", lambda case_id: even)
    _, rows = answers(run)
    assert rows["uneven round the bearing"][2:4] == ("contradicted", "deepest over mean depth")
    assert rows["uneven round the bearing"][4:7] == pytest.approx((1.0, 1.0, 1.0))
    assert rows["uneven round the journal"][4] == pytest.approx(2.2 / 1.2)
    assert rows["uneven round the journal"][2] == "shown"


def test_a_case_that_is_shown_by_itself_shows_its_wear():
    run = Run(sweep=SWEEP)
    case_id = run.summary["case_id"].iloc[0]
    path = {name: values.to_numpy() for name, values in run.orbit(case_id).items()}
    result = Trajectory("ok", "", {}, path, wear=run.wear(case_id))
    titles = [picture.title for picture in case_pictures(prepare(run), case_id, result)]
    assert titles[-3:] == ["Bearing in the slider", "Journal on the rod", "Depth along the surface"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["worn_slider_crank", "wear_trends", "ptfe_bushing", "press_life"])
def test_a_ready_study_of_wear_is_looked_over_by_a_dry_run(name):
    result = CliRunner().invoke(verbs, ["run", str(CONFIGS / f"{name}.yaml"), "--dry-run"])
    assert result.exit_code == 0, result.output
    assert "to run" in result.output


def living():
    """Return a run whose joint grows evenly by 50 um, the faster the larger its clearance."""
    run = Run(sweep=SWEEP)
    frame = run.summary
    turns = 1e6 * 5e-5 / frame[CLEARANCE]
    run.layout = run.layout._replace(life="rod_slider")
    run.grid["life"] = {"limit": 5e-5, "of": "clearance_growth", "joint": "rod-slider"}
    for name, values in {"revolutions": turns, "hours": turns / 6e4, "low": 0.9 * turns, "high": 1.2 * turns}.items():
        frame[f"rod_slider_life_{name}"] = values
        frame.attrs["units"][f"rod_slider_life_{name}"] = "h" if name == "hours" else "1"

    def history(case_id):
        case = frame.set_index("case_id").loc[case_id]
        at = np.linspace(0.0, 1.0, 5)
        return {
            "revolutions": at * case["rod_slider_life_revolutions"],
            "rod_slider/wear_depth_max": 4e-5 * at,
            "rod_slider/clearance": case[CLEARANCE] + 5e-5 * at,
            "rod_slider/force_peak": 1e3 * (1.0 + at),
        }

    run.history = history
    return run


def test_lives_are_reported_mapped_and_drawn_with_their_intervals():
    (part,) = sections.wear.life_sections(prepare(living()))
    (gallery,) = part.blocks
    mapped, depth, growth, force = gallery.pictures
    assert "Life" in mapped.title
    shortest, bar, median = items(axes_of(growth))[:3]
    assert shortest.y == pytest.approx([0.0, 12.5, 25.0, 37.5, 50.0])
    assert shortest.x == pytest.approx(np.linspace(0.0, 0.25, 5))  # millions
    assert bar.x == pytest.approx([0.225, 0.3])
    assert median.x[-1] > 0.25
    assert items(axes_of(depth))[0].y[-1] == pytest.approx(40.0)
    assert items(axes_of(force))[0].y == pytest.approx([1.0, 1.25, 1.5, 1.75, 2.0])


def test_a_run_without_a_life_has_no_section_on_it():
    assert sections.wear.life_sections(prepare(Run(sweep=SWEEP))) == []


JOINT = "joints.rod-slider"
LAW, ELASTIC, RESTITUTION = f"{JOINT}.contact.law", f"{JOINT}.contact.elastic", f"{JOINT}.contact.restitution"
SPEEDS = {"drive.speed": [1000 * RPM, 2000 * RPM, 3000 * RPM]}
STEEL = {"law": "exact", "material": {"young": 207e9, "poisson": 0.3}, "thickness": 5e-3, "restitution": 0.7}


def of_laws(more=SPEEDS):
    """Return a run over two laws whose force peaks differ by 3, at the highest speed by 6, and by nothing else."""
    run = Run(sweep={LAW: ["lankarani-nikravesh", "exact"], **more}, histories=False, wear=False)
    run.summary[PEAK] = 100.0 * run.summary["drive.speed"]
    factor = np.where(run.summary["drive.speed"] == max(SPEEDS["drive.speed"]), 6.0, 3.0)
    run.summary[PEAK] *= np.where(run.summary[LAW] == "exact", factor, 1.0)
    return run


def of_elastic(names, contact=STEEL):
    """Return a run over elastic laws of a steel joint; over none the law is `power`."""
    run = Run(sweep={ELASTIC: names} if names else {}, histories=False, wear=False)
    run.grid["joints"]["rod-slider"]["contact"] = dict(contact)
    return run


def of_choice(run):
    """Return the sections about the choice of a law."""
    given = prepare(run)
    return [*law_choice_sections(given), *elastic_laws_sections(given)]


def blocks(run, kind):
    """Return the blocks of one kind in the first section about the choice of a law."""
    return [block for block in of_choice(run)[0].blocks if isinstance(block, kind)]


def tables(run):
    return [table for section in of_choice(run) for table in section.tables]


def table(run, key):
    return next(table for table in tables(run) if table.key.endswith(key))


def text(run, tmp_path):
    return Page(report.write(run, tmp_path / "page.html").read_text(encoding="utf-8")).text


@pytest.mark.heavy
def test_spread_is_taken_between_cases_that_differ_in_the_law_alone():
    spread = table(of_laws(), "contact_law_spread")
    figure, joint, count, median, largest, low, weakest, high, strongest, at = spread.rows[0]
    assert (figure, joint, count.value) == ("force peak", "rod-slider", 3)
    assert (median, largest) == (pytest.approx(3.0), pytest.approx(6.0))
    assert (weakest, strongest, at) == ("lankarani-nikravesh", "exact", "crank speed 3000\u00a0rpm")
    assert high.value / low.value == pytest.approx(6.0)


@pytest.mark.heavy
def test_a_law_is_measured_against_the_others_at_equal_values():
    rows = {row[0]: row for row in table(of_laws(), "contact_law_rod_slider").rows}
    assert rows["exact"][5] == pytest.approx(3.0 / 2.0)  # median of 2 values: their mean
    assert rows["lankarani-nikravesh"][5] == pytest.approx(1.0 / 2.0)


@pytest.mark.heavy
def test_a_failed_case_leaves_its_comparison_out():
    run = of_laws()
    fastest = run.summary["drive.speed"] == max(SPEEDS["drive.speed"])
    run.summary.loc[fastest & (run.summary[LAW] == "exact"), ["status", PEAK]] = ["step-budget", None]
    row = table(run, "contact_law_spread").rows[0]
    assert row[2].value == 2
    assert row[4] == pytest.approx(3.0)


@pytest.mark.heavy
def test_a_law_without_a_swept_value_stands_beside_all_of_its_values():
    run = Run(sweep={LAW: ["hertz", "exact"], RESTITUTION: [0.5, 0.9], **SPEEDS})
    idle = (run.summary[LAW] == "hertz") & (run.summary[RESTITUTION] == 0.9)
    run.summary = run.summary[~idle].reset_index(drop=True)
    run.summary.loc[run.summary[LAW] == "hertz", RESTITUTION] = None
    row = table(run, "contact_law_spread").rows[0]
    assert row[2].value == 6
    given = {row[0]: row[1:3] for row in table(run, "restitution").rows if row[0] == "hertz"}
    assert np.isnan(given["hertz"][0])
    assert given["hertz"][1] == 1.0


@pytest.mark.heavy
def test_laws_that_never_meet_at_equal_values_are_not_compared():
    run = of_laws()
    run.grid["zip"] = run.grid.pop("sweep")
    run.summary = run.summary[(run.summary[LAW] == "exact") == (run.summary["drive.speed"] > 200.0)]
    run.summary = run.summary.reset_index(drop=True)
    assert "No two finished cases differ only in the contact law" in blocks(run, Sentences)[0].texts[0]
    assert not any(first.key.endswith("spread") for first in tables(run))


@pytest.mark.heavy
def test_restitution_requested_is_listed_next_to_what_each_law_gives_back(tmp_path):
    run = of_laws({RESTITUTION: [0.5, 0.9], **SPEEDS})
    rows = {row[:2]: row[2] for row in table(run, "restitution").rows}
    assert rows["lankarani-nikravesh", 0.5] == pytest.approx(0.7252, abs=5e-5)
    assert rows["lankarani-nikravesh", 0.9] == pytest.approx(0.9132, abs=5e-5)
    assert rows["exact", 0.5] == pytest.approx(0.5, abs=1e-9)
    assert (
        "With a specified restitution of 0.5, a free impact has a restitution of 0.500 (exact) to 0.725 (lankarani-"
        in text(run, tmp_path)
    )


@pytest.mark.heavy
def test_an_impact_pair_measures_what_its_laws_give_back():
    path = "joints.pair.contact.law"
    names = ["lankarani-nikravesh", "exact"]
    run = Run(sweep={path: names}, joints=("pair",), mechanism="impact-pair", wear=False)
    pair = changed(PAIR, {"joints.pair.contact.restitution": 0.9, "sweep": {path: names}})
    run.grid |= grid.load(pair, simulation.catalogue()).resolved()
    run.summary["pair_restitution"] = np.where(run.summary[path] == "exact", 0.9, 0.91)
    rows = {row[0]: row for row in table(run, "restitution").rows}
    assert (rows["exact"][-1], rows["lankarani-nikravesh"][-1]) == (0.9, 0.91)


@pytest.mark.heavy
def test_the_choice_of_the_elastic_law_moves_the_force_fourteenfold(tmp_path):
    run = of_elastic(["winkler", "power", "johnson"])
    message = text(run, tmp_path)
    assert (
        "The choice among 2 valid elastic laws changes the force in rod-slider up to 1.15 times at a penetration of "
        "1 µm: "
        "815 N (johnson) to 939 N (winkler). With the doubtful one, the factor is 14.2. "
        "Among the valid laws, the factor is 2.12 at 0.1 µm"
    ) in message
    assert "elastic law winkler, power, johnson" in message
    rows = {row[0]: row for row in table(run, "elastic_force_rod_slider").rows}
    assert rows["johnson"][2:7] == pytest.approx((63.068, 814.618, 5158.36, 11700.0, 27138.3), rel=1e-4)
    assert rows["johnson"][8] == pytest.approx(0.1991e-3, rel=1e-3)
    assert np.isnan(rows["power"][8])


@pytest.mark.heavy
def test_a_material_shows_what_other_elastic_laws_would_give(tmp_path):
    run = of_elastic([], {**STEEL, "elastic": "johnson"})
    del run.grid["joints"]["rod-slider"]["contact"]["thickness"]
    rows = {row[0]: row for row in table(run, "elastic_force_rod_slider").rows}
    assert rows["johnson"][1] == "yes"
    assert not any(row[1] for law, row in rows.items() if law != "johnson")
    assert "winkler" not in rows  # nothing says how thick its layer would be
    assert "What another elastic law would give in joint rod-slider" in text(run, tmp_path)
    assert of_choice(Run()) == []  # no material, no law swept


ROUGH = {"law": "fractal", "dimension": 1.5, "scale": 1e-11, "hardness": 5.5e9}


def of_rough(laws):
    """Return a run over roughness laws of a steel joint, of which over none the law is `fractal`."""
    path = f"{JOINT}.roughness.law"
    run = of_elastic([], {**STEEL, "elastic": "johnson"})
    del run.grid["joints"]["rod-slider"]["contact"]["thickness"]
    swept = Run(sweep={path: laws} if laws else {}, histories=False, wear=False)
    swept.grid["joints"] = run.grid["joints"]
    swept.grid["joints"]["rod-slider"]["roughness"] = dict(ROUGH)
    return swept


@pytest.mark.heavy
def test_rough_surfaces_stand_beside_smooth_ones(tmp_path):
    run = of_rough(["smooth", "fractal", "kogut-etsion"])
    rows = {row[0]: row for row in table(run, "elastic_force_rod_slider").rows}
    assert rows["smooth"][3] == pytest.approx(814.618, rel=1e-4)
    assert rows["kogut-etsion"][3] < rows["fractal"][3] < rows["smooth"][3]
    assert "Effect of the choice of roughness law" in text(run, tmp_path)


@pytest.mark.heavy
def test_a_rough_joint_shows_other_elastic_laws_and_surfaces():
    rows = {row[0]: row for row in table(of_rough([]), "elastic_force_rod_slider").rows}
    assert rows["johnson with fractal roughness"][1] == "yes"
    assert rows["johnson with fractal roughness"][3] < rows["johnson"][3]
    assert {"johnson with kogut-etsion roughness", "compatible with fractal roughness"} <= set(rows)


@pytest.mark.heavy
def test_the_other_elastic_laws_are_those_that_a_grid_with_this_joint_may_name():
    steel = Material(207e9, 0.3)
    contact = Contact("exact", "power", {"exponent": 1.5, "restitution": 0.7}, Materials(steel, steel))
    joint = Joint("rod-slider", clearance=2e-6, contact=contact, bearing_radius=0.01)
    without_length = {"power", "lankarani-nikravesh-cylindrical", "bai-zhao-literal"}
    assert set(simulation.elastic_choices(joint)) == without_length
    allowed = set(simulation.elastic_choices(joint._replace(length=0.02)))
    assert "johnson" in allowed
    assert "pereira" not in allowed  # fitted to clearances from 5 µm on
    spring = Contact("kelvin-voigt", None, {"stiffness": 1e9, "damping": 1.0})
    assert simulation.elastic_choices(joint._replace(contact=spring)) == {}


@pytest.mark.heavy
def test_laws_of_another_version_leave_the_rest_of_the_page(tmp_path):
    run = of_laws()
    run.grid["sweep"][LAW] = ["lankarani-nikravesh", "forgotten"]
    run.summary[LAW] = run.summary[LAW].replace("exact", "forgotten")
    message = text(run, tmp_path)
    assert "Spread between the contact laws" in message
    assert "Some laws of this run are of another version" in message
    assert "Specified and computed restitution" not in message


@pytest.mark.heavy
def test_tables_of_laws_are_written_with_their_units(tmp_path):
    report.tables(of_elastic(["power", "johnson"]), tmp_path)
    rows = list(csv.reader((tmp_path / "elastic_force_rod_slider.csv").read_text(encoding="utf-8").splitlines()))
    assert rows[0][:4] == ["elastic law", "used here", "at 0.1\u00a0µm [N]", "at 1\u00a0µm [N]"]
    forces = {row[0]: float(row[3]) for row in rows[1:]}  # N, at 1 µm
    assert forces == pytest.approx({"johnson": 814.618, "power": 66.102}, rel=1e-4)
    assert list(forces) == ["johnson", "power"]  # valid laws before doubtful ones
    heads = next(
        csv.reader(
            (tmp_path / "laws_rod_slider_contact_elastic_rod_slider.csv").read_text(encoding="utf-8").splitlines()
        )
    )
    assert "force peak [N]" in heads


@pytest.mark.heavy
def test_a_case_is_resolved_again_with_the_keys_that_it_uses():
    cases = grid.load("configs/law_comparison.yaml", simulation.catalogue())
    run = Run(sweep={path: list(values) for path, values in cases.axes.items()}, wear=False)
    run.grid |= cases.resolved()
    given = prepare(run)
    for case_id in given.cases.index[::10]:
        (case,) = resolve_cases(given, [case_id])
        uses = case.joints[0].contact.elastic
        assert uses == given.value(case_id, ELASTIC)
        assert ("thickness" in case.joints[0].contact.values) == (uses == "winkler")


@pytest.mark.heavy
def test_ranges_of_what_is_derived_hold_one_unit_each():
    cases = grid.load("configs/law_comparison.yaml", simulation.catalogue())
    derived, _ = sweep.facts(cases, SIMULATION)
    stiff = {name: first for name, first in derived.items() if "contact.stiffness" in name}
    assert {first["unit"] for first in stiff.values()} == {"N/m^1.5", "N/m^1.16257", "N/m^1.02531"}
    assert all(first["min"] == first["max"] for first in stiff.values())


@pytest.mark.heavy
def test_alt_text_names_the_softest_and_the_stiffest_law():
    run = of_elastic(["winkler", "power", "johnson"])
    (gallery,) = blocks(run, Gallery)
    rows = table(run, "elastic_force_rod_slider").rows
    forces = {row[0]: row[3] for row in rows}  # N, at a penetration of 1 µm
    softest, stiffest = min(forces, key=forces.get), max(forces, key=forces.get)
    assert rows[-1][0] != stiffest  # laws that are not valid come last, whatever their force
    alt = gallery.pictures[-1].alt.replace("\u00a0", " ")
    assert alt == f"At 1 µm {softest} is the softest law and {stiffest} the stiffest."


@pytest.mark.heavy
def test_every_law_that_is_drawn_is_named():
    names = ["power", "johnson", "radzimovsky", "esdu-78035", "dubowsky-freudenstein", "liu", "winkler", "persson"]
    (gallery,) = blocks(of_elastic(names), Gallery)
    drawing = draw_svg(gallery.pictures[-1], "f1")
    assert all(f">{name}<" in drawing for name in names)
    assert len(set(re.findall(r"#[0-9a-f]{6}", drawing.lower()))) >= 8
    assert len(CURVE_DEPTHS) > 20


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("limit", "message"),
    [
        (70000.0, "decides whether 1 of 3 designs meet the limits. For example, they are met with "),
        (1e9, "does not change the verdict on 3 designs: each meets the limits with every law"),
        (1.0, "does not change the verdict on 3 designs: each exceeds a limit with every law"),
        (20000.0, "lankarani-nikravesh and exceeded with exact"),
    ],
)
def test_whether_the_choice_moves_the_verdict_is_said_first(limit, message):
    run = of_laws()
    peak = run.summary[PEAK]
    run.grid["limits"] = {PEAK: limit}
    run.summary[EXCEEDED_COLUMN] = np.where(peak > limit, PEAK, "")
    run.summary[MARGIN_COLUMN] = 1.0 - peak / limit
    (part,) = [part for part in of_choice(run) if part.key.endswith("contact_law")]
    first = part.blocks[0].texts[0].replace("\u00a0", " ")
    assert message in first
    table = next(table for table in part.tables if table.key.endswith("_verdict"))
    for law, designs, beyond, smallest, _ in table.rows:
        mine = peak[run.summary[LAW] == law]
        assert (designs.value, beyond.value) == (3, int((mine > limit).sum()))
        assert smallest == pytest.approx(1.0 - mine.max() / limit, rel=1e-12)


@pytest.mark.heavy
def test_without_limits_nothing_is_said_of_a_verdict():
    assert not any(table.key.endswith("_verdict") for part in of_choice(of_laws()) for table in part.tables)
