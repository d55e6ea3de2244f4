"""Claims about cases in step (`zip`, `cases`), drawn (`sample`) and bounded (`limits`), and messages on mistakes."""

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fake_runs import CONTACT, JOINT, TEXT, ids, load

from clearsweep.grid.sections.axes import Distribution
from clearsweep.language.errors import InputError

CLEARANCE, SPEED, RESTITUTION = f"{JOINT}.clearance", "drive.speed", f"{CONTACT}.restitution"


@pytest.fixture
def at(tmp_path, monkeypatch):
    """Return a function that loads the demo grid with further text from grid.yaml, after writing a table of cases."""
    monkeypatch.chdir(tmp_path)

    def write(more="", table="", overrides=None):
        Path("cases.csv").write_text(table, encoding="utf-8")
        Path("grid.yaml").write_text(TEXT + more, encoding="utf-8")
        return load("grid.yaml", overrides)

    return write


def points(cases, *paths):
    """Return the values of these paths, case by case."""
    return [tuple(cases.point(k)[path] for path in paths) for k in range(len(cases))]


def sample(over, method="sobol", n=16, seed=7, more=""):
    """Return the text of a section `sample`, its distributions on lines of their own from line 22 on."""
    head = f"sample: {{method: {method}, n: {n}, seed: {seed}, over: {{\n"
    return head + "".join(f"  {path}: {form},\n" for path, form in over.items()) + f"}}}}\n{more}"


OVER = {
    CLEARANCE: "{lognormal: {mean: 0.5 mm, cv: 0.2}}",
    RESTITUTION: "{truncated-normal: {mean: 0.9, std: 0.03, low: 0.8, high: 1}}",
    SPEED: "{uniform: [1000 rpm, 5000 rpm]}",
    f"{CONTACT}.stiffness": "{loguniform: [1e10 N/m^1.5, 1e11 N/m^1.5]}",
    f"{JOINT}.friction.coefficient": "{normal: {mean: 0.05, cv: 0.1}}",
}


# --------------------------------------------------------------------------------------------------- in step


def test_axes_in_step_give_case_after_case(at):
    cases = at(f"zip:\n  {CLEARANCE}: [0.1 mm, 0.2 mm, 0.2 mm]\n  {SPEED}: {{linspace: [10 rad/s, 30 rad/s, 3]}}\n")
    assert points(cases, CLEARANCE, SPEED) == [(1e-4, 10.0), (2e-4, 20.0), (2e-4, 30.0)]
    assert cases.written_case(1)["drive"]["speed"] == 20.0
    assert cases.fixed_settings()["swept"] == [SPEED, CLEARANCE]


def test_what_goes_in_step_is_one_factor_of_the_product(at):
    more = f"sweep:\n  {SPEED}: [10 rad/s, 20 rad/s]\nzip:\n  {CLEARANCE}: [0.1 mm, 0.2 mm]\n"
    cases = at(f"{more}  {RESTITUTION}: [0.8, 0.9]\ncases:\n  mechanism.gravity: [0, 9.81]\n")
    assert len(cases) == 8
    assert {point[:2] for point in points(cases, CLEARANCE, RESTITUTION)} == {(1e-4, 0.8), (2e-4, 0.9)}
    assert len(set(ids(cases))) == 8
    again = load(json.loads(json.dumps(cases.resolved())))
    assert ids(again) == ids(cases)
    assert again.resolved() == cases.resolved()


def test_law_names_go_in_step_with_what_they_use(at):
    cases = at(f"zip:\n  {CONTACT}.law: [flores, exact]\n  {RESTITUTION}: [0.8, 0.9]\n")
    contacts = [cases.written_case(k)["joints"]["rod-slider"]["contact"] for k in range(2)]
    assert [(contact["law"], contact["restitution"]) for contact in contacts] == [("flores", 0.8), ("exact", 0.9)]


def test_values_in_step_are_compared_row_by_row(at):
    cases = at(f"zip:\n  {CLEARANCE}: [1 mm, 11 mm]\n  {JOINT}.bearing_radius: [10 mm, 20 mm]\n")
    assert len(cases) == 2


def test_a_csv_table_lists_cases_with_units_in_its_head(at):
    cases = at("cases: cases.csv\n", f'\ufeff"{CLEARANCE} [mm]", {SPEED} [rpm]\n0.1, 60 \n\n0.2,120\n')
    assert points(cases, CLEARANCE) == [(1e-4,), (2e-4,)]
    assert cases.point(0)[SPEED] == pytest.approx(2.0 * np.pi, rel=1e-15, abs=0.0)
    same = at(f"zip:\n  {CLEARANCE}: [0.1 mm, 0.2 mm]\n  {SPEED}: [60 rpm, 120 rpm]\n")
    assert ids(same) == ids(cases)


def test_a_parquet_table_lists_cases(at):
    pq.write_table(pa.table({f"{CLEARANCE} [mm]": [0.1, 0.2], SPEED: [10, 20]}), "cases.parquet")
    assert points(at("cases: cases.parquet\n"), CLEARANCE, SPEED) == [(1e-4, 10.0), (2e-4, 20.0)]


def test_the_table_is_looked_for_next_to_the_grid(at, tmp_path, monkeypatch):
    at("cases: cases.csv\n", f"{SPEED}\n10\n")
    monkeypatch.chdir("/")
    assert len(load(tmp_path / "grid.yaml")) == 1


def test_an_override_ends_that_a_value_is_varied(at):
    more = f"zip:\n  {CLEARANCE}: [0.1 mm, 0.2 mm]\n  {SPEED}: [10, 20]\n"
    cases = at(more, overrides={SPEED: 50})
    assert (len(cases), list(cases.axes)) == (2, [CLEARANCE])
    assert len(at(more, overrides={SPEED: 50, CLEARANCE: "0.1 mm"})) == 1
    assert list(at(sample(OVER), overrides={SPEED: 50}).axes) == [path for path in OVER if path != SPEED]


# ---------------------------------------------------------------------------------------------------- drawn


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "random", "saltelli"])
def test_the_same_seed_gives_the_same_cases(at, method):
    cases = at(sample(OVER, method))
    assert len(cases) == 16 * (len(OVER) + 2 if method == "saltelli" else 1)
    assert ids(at(sample(OVER, method))) == ids(cases)
    assert not set(ids(at(sample(OVER, method, seed=8)))) & set(ids(cases))


@pytest.mark.parametrize("method", ["sobol", "random"])
def test_a_larger_sample_keeps_the_cases_of_a_smaller_one(at, method):
    assert ids(at(sample(OVER, method, n=32)))[:16] == ids(at(sample(OVER, method)))


def test_drawn_values_are_kept_in_the_resolved_grid(at):
    cases = at(sample(OVER))
    resolved = json.loads(json.dumps(cases.resolved()))
    assert resolved["sample"]["seed"] == 7
    assert load(resolved).resolved() == cases.resolved()
    resolved["sample"]["drawn"][SPEED][3] = 123.0  # as if another version had drawn it
    assert load(resolved).point(3)[SPEED] == 123.0


@pytest.mark.parametrize(
    "form",
    [
        *("{normal: {mean: 0.5 mm, std: 0}}", "{normal: {mean: 0.5 mm, cv: 0}}", "{lognormal: {mean: 0.5 mm, cv: 0}}"),
        *("{truncated-normal: {mean: 0.5 mm, std: 0, low: 0.1 mm}}", "{uniform: [0.5 mm, 500 um]}"),
        *("{loguniform: [0.5 mm, 500 um]}", "{normal: {mean: 0.5 mm, std: 1e-30 mm}}"),
    ],
)
@pytest.mark.parametrize("method", ["sobol", "saltelli"])
def test_without_variance_the_case_is_the_deterministic_one_bit_for_bit(at, form, method):
    cases, plain = at(sample({CLEARANCE: form}, method)), at()
    assert len(cases) == 1  # sixteen equal draws
    assert cases.case(0) == plain.case(0)
    assert ids(cases) == ids(plain)


def test_the_moments_are_those_requested(at):
    cases = at(sample(OVER, n=4096))
    drawn = {path: np.array(values) for path, values in cases.axes.items()}
    for path, mean, std in ((CLEARANCE, 5e-4, 1e-4), (f"{JOINT}.friction.coefficient", 0.05, 0.005)):
        assert drawn[path].mean() == pytest.approx(mean, rel=1e-3)
        assert drawn[path].std() == pytest.approx(std, rel=1e-2)
    assert np.median(drawn[f"{CONTACT}.stiffness"]) == pytest.approx(10**10.5, rel=1e-3)
    assert np.median(drawn[SPEED]) == pytest.approx(np.pi * 100.0, rel=1e-3)
    assert 0.8 <= drawn[RESTITUTION].min() < 0.81
    assert 0.99 < drawn[RESTITUTION].max() <= 1.0


def test_one_at_a_time_begins_with_the_middle(at):
    text = sample({SPEED: "{uniform: [10 rad/s, 20 rad/s]}", "mechanism.gravity": "{normal: {mean: 0, std: 1}}"})
    cases = at(text.replace("method: sobol, n: 16, seed: 7", "method: one-at-a-time"))
    low, high = 1.6448536269514722, 1e-9 * np.sqrt(2.0 * np.pi)
    expected = [(15, 0), (10.5, 0), (19.5, 0), (15 + 1e-8, 0), (15, -low), (15, low), (15, high)]
    assert np.allclose(points(cases, SPEED, "mechanism.gravity"), expected, rtol=1e-14, atol=1e-15)


def test_limits_are_read_in_si(at):
    assert at("limits: {rod_slider_force_peak: 5 kN, slider_error_max: 1 mm}\n").limits == {
        "rod_slider_force_peak": 5000.0,
        "slider_error_max": 0.001,
    }


# ------------------------------------------------------------------------------------------------- mistakes


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_a_table_that_is_not_utf_8_says_how_to_save_it(at, encoding):
    at(f"sweep: {{{CLEARANCE}: [0.1 mm]}}\n")
    Path("table.csv").write_text(f"{CLEARANCE} [µm]\n100\n", encoding=encoding)
    with pytest.raises(InputError, match=r"table\.csv cannot be read: not UTF-8 text .*; save the file as UTF-8"):
        at("cases: table.csv\n")


def test_a_parquet_row_is_named(at):
    pq.write_table(pa.table({f"{SPEED} [rpm]": [60.0, None]}), "cases.parquet")
    with pytest.raises(InputError, match=r"^cases.parquet:2:1: drive.speed: found nothing"):
        at("cases: cases.parquet\n")


DRAWN = {
    "loguniform": (
        {"low": 1e-3, "high": 2.0},
        ["0x1.4948bdd17eecfp-10", "0x1.6e5b7d16657e1p-5", "0x1.979ac61d4e09dp+0"],
    ),
    "lognormal": (
        {"mean": 0.1, "std": 0.02},
        ["0x1.14be8ebf717e2p-4", "0x1.91a556151761cp-4", "0x1.23758e576f3bep-3"],
    ),
}


@pytest.mark.skipif(sys.platform != "linux", reason="the last bits are those of glibc's exp and pow")
@pytest.mark.parametrize("law", DRAWN)
def test_drawn_values_do_not_depend_on_the_processor(law):
    numbers, expected = DRAWN[law]  # numpy's exp and power with AVX-512 differ in the last bit of some values
    points = np.linspace(0.03, 0.97, 7)[[0, 3, 6]]
    assert [value.hex() for value in Distribution(law, numbers).values(points)] == expected
