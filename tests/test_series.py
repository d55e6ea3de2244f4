"""`clearsweep wear SERIES.csv`: Archard's equation along a measured series, and the published table against it."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from test_cli import ROOT

from clearsweep import series
from clearsweep.cli import verbs
from clearsweep.language import quantity
from clearsweep.language.errors import InputError

PUBLISHED = ROOT / "configs/operating_series.csv"
COEFFICIENT = 2e-14  # m^2/N


def printed_wear(*arguments):
    return CliRunner().invoke(verbs, ["wear", *map(str, arguments)], catch_exceptions=False).stdout


def test_the_published_table_gives_the_depths_of_its_pressures_and_speeds():
    worn = series.compute_wear(series.read_series(PUBLISHED), COEFFICIENT)
    ends = [round(1e6 * worn.depths[rule][-1], 3) for rule in ("trapezoidal", "left", "right")]
    assert ends == [0.281, 0.258, 0.304]
    assert worn.implied_coefficients[[0, -1]] == pytest.approx([2.245e-14, 1.133e-14], rel=1e-3)


@pytest.mark.parametrize(
    "sentence",
    [
        "the table grows by 0.200 um, but its pressures and speeds with 2e-14 m^2/N give 0.281 um",
        "the right one, up to 1 s.",
        "its steps need 2.24e-14 to 1.13e-14 m^2/N",
        "the table's radial clearance shrinks by 10 um (diametral 20 um) while 0.2 um are worn; wear enlarges",
        "force over pressure falls from 100 to 84.38 mm^2 while the force grows from 120 to 270 N",
        "2e-14 m^2/N is 2e-08 mm^2/N; 2e-08 m^2/N, as such a number is often printed, would wear 0.281 m",
    ],
)
def test_contradictions_of_the_published_table_are_said_in_words(sentence):
    assert sentence in " ".join(printed_wear(PUBLISHED, "--coefficient", "2e-14 m^2/N").split())


def written(path, columns, heads):
    rows = "\n".join(",".join(repr(float(value)) for value in row) for row in zip(*columns, strict=True))
    path.write_text(",".join(heads) + "\n" + rows + "\n", encoding="utf-8")
    return path


def test_a_table_that_follows_its_equations_is_reported_so(tmp_path):
    time = np.linspace(0.0, 5.0, 11)
    pressure, speed = 1.0 + 0.1 * time, 0.5 - 0.05 * time  # MPa, m/s
    rate = COEFFICIENT * 1e12 * pressure * speed  # um/s
    depth = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * 0.5)])
    heads = ("time [s]", "pressure [MPa]", "sliding_speed [m/s]", "depth [um]", "clearance [um]")
    path = written(tmp_path / "own.csv", (time, pressure, speed, depth, 50.0 + depth), heads)
    worn = series.compute_wear(series.read_series(path), COEFFICIENT)
    assert worn.remarks == ()
    assert worn.implied_coefficients == pytest.approx(COEFFICIENT, rel=1e-9)
    assert "The table agrees with its own pressures and speeds." in printed_wear(path, "--coefficient", "2e-14 m^2/N")


def test_the_trapezoidal_rule_is_exact_for_what_is_straight_and_sums_bound_it(tmp_path):
    time = np.linspace(0.0, 2.0, 5)
    path = written(tmp_path / "straight.csv", (time, 100.0 * time, -np.ones(5)), ("t [s]", "force [N]", "speed [m/s]"))
    depth = series.compute_wear(series.read_series(path), 1e-12, area=1e-4).depths
    assert depth["trapezoidal"][-1] == pytest.approx(1e-12 * 100.0 * 2.0 / 1e-4, rel=1e-14)  # integral of F |v| / A
    assert depth["left"][-1] < depth["trapezoidal"][-1] < depth["right"][-1]


def test_a_bare_coefficient_next_to_a_hardness_is_dimensionless():
    assert series.read_coefficient("4e-5", "2 GPa") == (pytest.approx(2e-14, rel=1e-15), 4e-5)
    assert series.read_coefficient("2e-14 m^2/N", "2 GPa")[0] == pytest.approx(2e-14, rel=1e-15)
    assert series.read_coefficient("2e-8 mm^2/N", None) == (2e-14, None)


def test_json_has_the_same_in_si():
    facts = json.loads(printed_wear(PUBLISHED, "--coefficient", "4e-5", "--hardness", "2 GPa", "--json"))
    assert facts["depth"]["trapezoidal"] == pytest.approx(2.81e-7, rel=1e-3)
    assert facts["coefficient"] == pytest.approx(2e-14, rel=1e-15)
    assert (facts["table_depth"], len(facts["contradictions"])) == (pytest.approx(2e-7, rel=1e-12), 4)


@pytest.mark.parametrize(
    ("depth", "agrees"),
    [
        ("0.040", True),
        ("0.0404", True),
        ("0.04", False),  # too coarse: half a last digit is an eighth of what is worn
        ("0.0406", False),
        ("1", False),
        ("0", False),
        ("1e300", False),
        ("0e300", False),
    ],
)
def test_a_depth_agrees_within_half_a_last_digit_and_a_twentieth_of_itself(tmp_path, depth, agrees):
    path = tmp_path / "series.csv"  # 0.04045 um: k p v t
    head = "time [s],pressure [MPa],speed [m/s],depth [um]\n"
    path.write_text(head + f"0,1,2.0225,0\n1,1,2.0225,{depth}\n", encoding="utf-8")
    if "e300" in depth and float(depth):
        with pytest.raises(InputError, match="found a depth of"):
            series.read_series(path)
        return
    text = printed_wear(path, "--coefficient", "2e-14 m^2/N")
    assert ("The table agrees" in text) is agrees
    assert ("rounded too coarsely" in text or "contradicts" in text) is not agrees


def test_a_long_series_reads_as_its_cells_do_one_by_one(tmp_path):
    rows = [f"{0.001 * k:.3f},{1 + 0.37 * (k % 11):.4g},{0.7e-3 * k:.3e},{0.1 * k:.2f}" for k in range(5000)]
    head = "time [ms],pressure [MPa],speed [mm/s],depth [um]"
    (tmp_path / "series.csv").write_text("\n".join([head, *rows]), encoding="utf-8")
    read = series.read_series(tmp_path / "series.csv")
    for place, (name, unit) in enumerate([("time", "ms"), ("pressure", "MPa"), ("speed", "mm/s"), ("depth", "um")]):
        exact = [quantity.read(f"{row.split(',')[place]} {unit}", series.COLUMNS[name][0]) for row in rows]
        assert read.columns[name] == pytest.approx(exact, rel=4e-16, abs=0.0)
    text = series.wear_text(series.compute_wear(read, 1e-14))
    assert "4,800 more rows; --json has all" in text
    assert len(text.splitlines()) < 250
