"""The report's verdict: worst ratios, limits and margins of a made-up run, worst and median maps, kinds of motion."""

import numpy as np
import pytest
from report_fake import Run

from clearsweep import report, verdict
from clearsweep.report import study
from clearsweep.report.sections import headline, maps
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
    worst = cases["rod_slider_force_peak_ratio"].idxmax()
    assert f"At most {prepared.text(worst, 'rod_slider_force_peak_ratio')} times the largest reaction" in told
    assert f"Smallest margin: \u2212{-100 * cases[verdict.MARGIN].min():.3g} %" in told


def test_the_table_of_limits_is_that_of_the_summary(run):
    prepared = study.prepare(run)
    (table,) = section.sections(prepared)[0].tables
    cases = prepared.cases
    found = {row[0].split()[0]: (row[1].value, row[2].value, row[3].value) for row in table.rows}
    margins = {PEAK: 1.0 - cases[PEAK] / cases[IDEAL] / 6.0, "slider_error_max": 1.0 - cases["slider_error_max"] / 3e-4}
    for name, margin in margins.items():
        assert found[name][:2] == (int((margin < 0.0).sum()), len(cases))
        assert found[name][2] == pytest.approx(margin.min(), rel=1e-12)


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
        return " ".join(headline.sentences(study.prepare(made)))

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
