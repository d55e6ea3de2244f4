"""Curves and maps: what they draw is what the summary holds, the worst of what they leave out, in one scale."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from report_fake import RPM, Run

from clearsweep.report import study
from clearsweep.report.sections import curves, maps, tradeoffs

CLEARANCE, SPEED, PEAK = "joints.rod-slider.clearance", "drive.speed", "rod_slider_force_peak"
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
    by_value = run.summary.groupby([CLEARANCE, SPEED])[PEAK].agg(reduced)
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
    least = run.summary.groupby([CLEARANCE, SPEED])[PEAK].min()[5e-5].to_numpy()
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
    run = Run(sweep={CLEARANCE: np.linspace(1e-4, 5e-4, 20).tolist(), SPEED: [100.0, 200.0, 300.0]})
    picture = section(run)["Force peak over crank speed"]
    assert picture.caption == "7 of 20 values of clearance. "
    assert len(painted(picture).lines) == 7


def test_maps_of_one_figure_share_their_colours_and_hold_the_summary():
    run = Run()
    drawn = section(run, maps) | {picture.title: picture for picture in maps.first(study.prepare(run))}
    forces = [painted(picture) for title, picture in drawn.items() if title.startswith("Force peak: ")]
    ends = {axes.collections[0].get_clim() for axes in forces}
    tables = [run.summary.groupby([first, other])[PEAK].max() for first, other in ((CLEARANCE, SPEED),)]
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
