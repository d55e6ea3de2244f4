"""The report's verdict: worst ratios, limits and margins of a made-up run, worst and median maps, kinds of motion."""

import numpy as np
import pytest
from report_fake import Run
from test_refine import Arc, off_border, refined
from test_seek import MASS, quiet, searching

import clearsweep
from clearsweep import report
from clearsweep.judging import verdict
from clearsweep.report import study
from clearsweep.report.picture import svg
from clearsweep.report.sections import maps, trust
from clearsweep.report.sections import seek as answers
from clearsweep.report.sections import verdict as section

PEAK, IDEAL = "rod_slider_force_peak", "rod_slider_force_peak_ideal"
LIMITS = {PEAK: {"at_most": 6.0, "times": IDEAL}, "slider_error_max": 3e-4}


@pytest.fixture
def run():
    """Return a run with limits, its columns worked out anew."""
    made = Run(failures=3)
    made.grid["limits"] = LIMITS
    rows = made.summary["status"] == "ok"
    ratio = made.summary[PEAK] / made.summary[IDEAL]
    made.summary["rod_slider_load_peak"] = made.summary[PEAK]
    made.summary["rod_slider_force_peak_ratio"] = ratio
    made.summary["period"] = np.where(np.arange(len(rows)) % 2, np.nan, 1.0)
    error = made.summary["slider_error_max"]
    names = [(PEAK, ratio > 6.0), ("slider_error_max", error > 3e-4)]
    exceeded = [",".join(name for name, beyond in names if beyond[row]) for row in made.summary.index]
    made.summary[verdict.EXCEEDED] = np.where(rows, exceeded, None)
    made.summary[verdict.MARGIN] = np.minimum(1.0 - ratio / 6.0, 1.0 - error / 3e-4)
    return made


def test_the_verdict_counts_cases_and_names_the_worst(run):
    prepared = study.prepare(run)
    cases = prepared.cases
    beyond = int((cases[verdict.EXCEEDED] != "").sum())
    told = " ".join(section.sections(prepared)[0].blocks[0].texts).replace("\u00a0", " ")
    assert 0 < beyond < len(cases)
    assert f"{beyond} of {len(cases)} cases exceed at least one limit." in told
    assert f"Smallest margin: {1.0 - cases[verdict.MARGIN].min():.1f} times the limit" in told


def test_the_table_of_limits_is_that_of_the_summary(run):
    prepared = study.prepare(run)
    (table,) = section.sections(prepared)[0].tables
    cases = prepared.cases
    result = {row[0]: tuple(cell.value for cell in row[2:6]) for row in table.rows}
    assert [row[1] for row in table.rows] == [
        "force peak at most 6 times the ideal peak",
        "slider error at most 0.3\u00a0mm",
    ]
    margins = {PEAK: 1.0 - cases[PEAK] / cases[IDEAL] / 6.0, "slider_error_max": 1.0 - cases["slider_error_max"] / 3e-4}
    for name, margin in margins.items():
        assert result[name][:3] == (int((margin < 0.0).sum()), 0, len(cases))
        assert result[name][3] == pytest.approx(margin.min(), rel=1e-12)


def test_a_map_shows_the_worst_of_a_cell_or_on_request_the_median(run):
    for typical, reduced, word in ((False, np.max, "Largest over"), (True, np.median, "Median over")):
        prepared = study.prepare(run, typical=typical)
        across, up = prepared.axes[0], prepared.axes[3]
        values = prepared.cases[PEAK].to_numpy(float)
        table = study.over_other_axes(prepared, values, (across, up), reduced)
        at = (prepared.cases[across.path] == across.values[1]) & (prepared.cases[up.path] == up.values[2])
        assert table[2, 1] == reduced(values[at])
        assert maps.sections(prepared)[0].blocks[0].pictures[0].caption.startswith(word)


def test_only_motions_that_are_found_to_be_chaotic_are_called_so(run):
    def told(made):
        return " ".join(trust.points(study.prepare(made)))

    finished = run.summary["status"] == "ok"
    repeating = int(run.summary["period"][finished].notna().sum())
    assert f"{repeating} of {int(finished.sum())} motions repeat themselves" in told(run)
    assert "chaotic" not in told(run)
    run.summary["lyapunov_exponent"] = 3.0
    assert f"{int(finished.sum()) - repeating} of {int(finished.sum())} motions are chaotic" in told(run)


def test_the_page_holds_the_verdict_and_its_map(run, tmp_path):
    page = report.write(run, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Within the limits" in page
    assert page.index('id="verdict"') < page.index('id="headline"')


def told(result, place=0):
    """Return what the first block of a section says, with plain spaces."""
    return " ".join(result[place].blocks[0].texts).replace("\u00a0", " ")


@pytest.mark.parametrize(("whom", "limit"), [("each", 0.3137), ("all", 0.3137), ("each", 0.05), ("each", 1.0)])
def test_what_was_sought_stands_in_the_verdict_and_in_a_section_of_its_own(tmp_path, whom, limit):
    source = searching(limit, gravities=(0.0, 1e-3))
    source["seek"]["for"] = whom
    quiet(source, tmp_path / "run")
    run = clearsweep.open(tmp_path / "run")
    prepared = study.prepare(run)
    (part,) = answers.sections(prepared)
    table = part.tables[0]
    frame = run.seek
    assert [row[-5] for row in table.rows] == pytest.approx(frame[f"seek.{MASS}"].tolist(), rel=1e-12, nan_ok=True)
    assert len(table.rows) == (2 if whom == "each" else 1)
    first = told(section.sections(prepared)).replace("\u2009", "")
    assert told([part]).startswith(first.partition(". ")[0])
    if limit == 0.05:
        assert "Largest safe slider mass: none of the range that was looked at in 2 of 2 searches, limited by" in first
    else:
        value = frame[f"seek.{MASS}"].min()
        assert f"Largest safe slider mass: {value:.4g} kg" in first
        assert ("the border is between" in first) == (limit < 0.9)
        assert ("in all 2 searches" in first) == (whom == "each")
    pictures = [picture for block in part.blocks for picture in getattr(block, "pictures", [])]
    assert len(pictures) == (whom == "each" and limit > 0.05)
    assert MASS in {axis.path for axis in prepared.axes}
    report.write(run, tmp_path / "page.html")


def test_the_map_shows_cases_between_its_cells(tmp_path):
    quiet(refined(), tmp_path / "run", simulator=Arc)
    run = clearsweep.open(tmp_path / "run")
    prepared = study.prepare(run)
    added, own = off_border(run.summary)
    assert f"of {len(run.summary)} cases exceed at least one limit" in told(section.sections(prepared))
    assert "no share of designs" in told(section.sections(prepared))
    (picture,) = section.sections(prepared)[0].blocks[-1].pictures
    assert f"{len(added)} dots: cases between" in picture.caption
    assert len(svg(picture, "map")) > 1000
    across, up = prepared.axes
    dots = section._between(prepared, (prepared.cases[verdict.EXCEEDED] != "").to_numpy(float), across, up)
    assert len(own) == 20
    mass, speed = 0.1 + 0.2 * dots.x, 100.0 + 200.0 * dots.y  # both axes have equal steps
    assert np.array_equal(np.hypot(mass, speed / 1000.0) > 0.6137, dots.failing)
