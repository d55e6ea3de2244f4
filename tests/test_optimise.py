"""Claims about `optimise`: the best of ordinary cases, the same however often it was interrupted."""

import dataclasses
import itertools

import numpy as np
import pyarrow.parquet as pq
import pytest
from fake_physics import CATALOGUE, FAILS, GOOD, Fake, grid, sweep
from fake_runs import JOINT, TEXT
from fake_runs import load as grid_load

import clearsweep
from clearsweep import grid as grids
from clearsweep.contracts.catalogue import Figure
from clearsweep.language.errors import InputError
from clearsweep.report.sections.searches import folded_optimised_sections, optimised_sections
from clearsweep.report.study import prepare
from clearsweep.searches import optimise as optimising
from clearsweep.searches.seeking import Choice
from clearsweep.sweeping.summary import of_run, run_text

MASS, ROD, GRAVITY = "mechanism.slider.mass", "mechanism.rod.mass", "mechanism.gravity"


def quiet(source, out, **options):
    return sweep(source, out, executor="serial", show_progress=False, **options)


def asked(cases=40, **changes):
    """Return a grid whose force peak (N), which is the mass (kg), is to come near 0.4."""
    section = {"over": {MASS: ["0.1 kg", "0.9 kg"]}, "minimise": "miss", "cases": cases} | changes
    whole = grid(1, (GOOD,), orbits="none")
    whole.pop("sweep")
    return whole | {"figures": {"miss": "abs(rod_slider_force_peak - '0.4 N')"}, "optimise": section}


def best(out):
    return pq.read_table(out / "optimise.parquet").to_pylist()


def test_the_best_case_is_found_among_ordinary_cases(tmp_path):
    result = quiet(asked(), tmp_path / "run")
    assert result.ran == len(clearsweep.open(tmp_path / "run").summary) == 40
    (row,) = best(tmp_path / "run")
    assert row[MASS] == pytest.approx(0.4, abs=0.02)
    summary = clearsweep.open(tmp_path / "run").summary
    assert row["miss"] == summary["miss"].min()
    assert "best of 40 cases" in run_text(of_run(result))
    assert clearsweep.open(tmp_path / "run").optimise["case_id"][0] == row["case_id"]


def test_run_again_it_has_the_same_cases_and_the_same_bytes(tmp_path):
    quiet(asked(), tmp_path / "a")
    again = quiet(asked(), tmp_path / "a")
    assert again.ran == 0
    quiet(asked(16), tmp_path / "b")  # what a run has that was stopped after a round
    more = quiet(asked(), tmp_path / "b")
    assert more.ran == 24
    for name in ("a", "b"):
        assert (tmp_path / name / "optimise.parquet").read_bytes() == (tmp_path / "a/optimise.parquet").read_bytes()


def test_limits_are_constraints(tmp_path):
    result = quiet(asked() | {"limits": {"rod_slider_force_peak": 0.3}}, tmp_path / "run")
    (row,) = best(tmp_path / "run")
    assert 0.27 < row[MASS] <= 0.3
    assert row["limiting"] == "rod_slider_force_peak"
    none = quiet(asked() | {"limits": {"rod_slider_force_peak": 0.05}}, tmp_path / "run")
    assert (result.exit_code, none.exit_code) == (0, 0)
    (row,) = best(tmp_path / "run")
    assert row["margin"] < 0.0
    assert row["limiting"] == "rod_slider_force_peak"
    assert of_run(none)["answer"]["best_met"] is False


def test_of_two_objectives_the_front_is_given(tmp_path):
    source = asked(minimise=["miss", "rod_slider_force_peak"], over={MASS: ["0.1 kg", "0.9 kg"]})
    quiet(source, tmp_path / "run")
    rows = best(tmp_path / "run")
    assert len(rows) > 5
    assert all(row[MASS] <= 0.42 for row in rows)
    peaks = [row["rod_slider_force_peak"] for row in rows]
    assert peaks == sorted(peaks, reverse=True)
    (largest,) = best_of(tmp_path / "large", asked(minimise=None, maximise="rod_slider_force_peak"))
    assert largest[MASS] > 0.85


def best_of(out, source):
    source["optimise"] = {key: value for key, value in source["optimise"].items() if value is not None}
    quiet(source, out)
    return best(out)


def test_the_case_that_is_written_is_looked_at_first(tmp_path):
    source = asked()
    result = quiet(source, tmp_path / "run")
    own = grids.load(source, Fake.catalogue())
    assert result.search_result.start.point[MASS] == own.search.start[MASS]
    assert own.point(0)[MASS] == own.search.start[MASS]


def modelled(points):
    """Return a smooth objective whose least value is at (0.3, 0.6, 0.6), and the margin of a limit that forbids it."""
    x, y, z = points.T
    return 1.0 + 3.0 * (x - 0.3) ** 2 + (x + y - 0.9) ** 2 + (y - z) ** 2, np.column_stack([x - 0.5])


def test_a_model_of_known_cases_leads_to_the_best_within_a_limit():
    chance = np.random.default_rng(3)
    known = chance.random((16, 3))
    for _ in range(8):
        objective, margins = modelled(known)
        order = np.lexsort([objective, margins[:, 0] < 0.0])
        more = optimising.better_points(known[order], objective[order], margins[order], 8, chance)
        assert more.shape == (8, 3)
        known = np.vstack([known, more.clip(0.0, 1.0)])
    objective, margins = modelled(known)
    least = objective[margins[:, 0] >= 0.0].min()
    assert 1.12 <= least < 1.1205  # at x = 0.5, y = z = 0.4; 80 cases at random come to 1.16


def test_a_model_needs_cases_that_differ_in_every_key():
    chance = np.random.default_rng(3)
    known, none = chance.random((20, 2)), np.empty((20, 0))
    assert optimising.better_points(known[:5], known[:5, 0], none[:5], 4, chance).shape == (0, 2)
    known[:, 1] = 0.5
    assert optimising.better_points(known, known[:, 0], none, 4, chance).shape == (0, 2)


class Turns(Fake):
    """Mechanics whose quantile of force peaks has an interval of 0.05 N to either side."""

    @staticmethod
    def catalogue():
        ends = [Figure(f"force_peak_p95{end}", "N", "made up", of="joint") for end in ("", "_low", "_high")]
        return CATALOGUE._replace(figures=(*CATALOGUE.figures, *ends))

    @staticmethod
    def solve(case, log=None):
        motion, mass = Fake.solve(case, log), case.mechanism.values["slider.mass"]
        ends = {"": mass, "_low": mass - 0.05, "_high": mass + 0.05}
        figures = motion.summary | {f"rod_slider_force_peak_p95{end}": value for end, value in ends.items()}
        return dataclasses.replace(motion, summary=figures)


def test_an_objective_with_an_interval_is_given_with_it(tmp_path):
    out = tmp_path / "run"
    source = asked(minimise="rod_slider_force_peak_p95") | {"limits": {"rod_slider_force_peak_p95": {"at_least": 0.2}}}
    result = quiet(source, out, simulator=Turns)
    best, peaks = result.search_result.best[0], clearsweep.open(out).summary["rod_slider_force_peak_p95"]
    (peak,) = best.values.values()
    assert best.intervals == {"rod_slider_force_peak_p95": (peak - 0.05, peak + 0.05)}
    assert result.search_result.alike == ((peaks > peak) & (peaks <= peak + 0.1)).sum() > 1
    (section,) = optimised_sections(prepare(clearsweep.open(out)))
    said = f"{result.search_result.alike} other cases within the limits cannot be distinguished from it"
    assert said in " ".join(section.blocks[0].texts)


def test_failed_cases_are_infeasible(tmp_path):
    source = asked(over={MASS: ["0.1 kg", "0.9 kg"], GRAVITY: {"among": [GOOD, FAILS]}}, cases=32)
    result = quiet(source, tmp_path / "run")
    assert result.failed > 0
    (row,) = best(tmp_path / "run")
    assert row[GRAVITY] == GOOD


def test_a_null_objective_is_an_error(tmp_path):
    source = asked() | {"figures": {"miss": "rod_slider_force_peak / (rod_slider_force_peak - rod_slider_force_peak)"}}
    with pytest.raises(InputError, match="miss is null in case"):
        quiet(source, tmp_path / "run")


def test_every_value_of_a_choice_has_its_part():
    for choice in (Choice("among", ("a", "b", "c")), Choice("whole", (2, 5))):
        every = choice.values if choice.kind == "among" else range(2, 6)
        assert [choice.value_at(choice.fraction_of(value)) for value in every] == list(every)
    assert Choice("range", (1.0, 100.0)).fraction_of(10.0) == pytest.approx(0.5)


def test_a_front_over_ranges_and_choices_has_no_wide_gaps(tmp_path):
    over = {MASS: ["0.1 kg", "0.9 kg"], ROD: ["0.1 kg", "0.9 kg"], GRAVITY: {"among": [GOOD, 0.001]}}
    quiet(asked(96, minimise=["miss", "rod_slider_force_peak"], over=over), tmp_path / "run")
    masses = sorted(row[MASS] for row in best(tmp_path / "run"))
    assert len(masses) > 40
    assert masses[0] < 0.11
    assert max(after - before for before, after in itertools.pairwise([*masses, 0.4])) < 0.04


OPTIMISED = (
    TEXT
    + f"""\
optimise:
  over: {{{JOINT}.clearance: [20 um, 300 um], {JOINT}.contact.law: {{among: [hunt-crossley, flores]}}}}
  minimise: rod_slider_force_peak
  cases: 20
"""
)


def test_laws_fits_and_whole_numbers_are_chosen(at):
    own = at(OPTIMISED)
    assert {own.point(k)[f"{JOINT}.contact.law"] for k in range(len(own))} == {"hunt-crossley", "flores"}
    assert [*grid_load(own.resolved()).identities()] == [*own.identities()]
    fits = at(OPTIMISED.replace("[20 um, 300 um]", "{among: {fits: [H7/g6, H7/f7]}}"))
    assert len({fits.point(k)[f"{JOINT}.clearance"] for k in range(len(fits))}) == 2
    assert Choice("whole", (2, 5)).value_at(0.99) == 5
    assert Choice("range", (1.0, 100.0)).value_at(0.5) == pytest.approx(10.0)


def test_the_report_has_the_best_cases(tmp_path):
    out = tmp_path / "run"
    quiet(asked(minimise=["miss", "rod_slider_force_peak"]), out)
    made = optimised_sections(prepare(clearsweep.open(out)))
    assert [section.key for section in made] == ["optimise"]
    assert made[0].pictures == []
    titles = [picture.title for _, picture in folded_optimised_sections(prepare(clearsweep.open(out)))[0].pictures]
    assert titles == ["The front of both objectives", "All cases as lines across the axes of variables and objectives"]


def test_the_report_has_the_best_case_next_to_the_one_that_is_written(tmp_path):
    out = tmp_path / "run"
    quiet(asked(minimise="rod_slider_force_peak"), out)
    (section,) = optimised_sections(prepare(clearsweep.open(out)))
    text = " ".join(section.blocks[0].texts)
    assert "Compared with the case of the grid: rod_slider_force_peak" in text
    (table,) = [block for block in section.blocks if hasattr(block, "rows")]
    assert [row[-1] for row in table.rows] == ["as written", "best"]


def test_shards_cannot_optimise(tmp_path):
    with pytest.raises(InputError, match="optimise"):
        quiet(asked(), tmp_path / "run", shard="1/2")
