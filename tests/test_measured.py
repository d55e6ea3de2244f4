"""clearsweep against measurements and published solutions: the claims of results/measured.md, and its form."""

import json
import math
from collections.abc import Iterable
from importlib import resources

import numpy as np
import pytest
from click.testing import CliRunner

from clearsweep import cli, grid, simulation
from clearsweep.verify import measured
from clearsweep.verify.measured import contact, films, machines, points
from clearsweep.verify.measured.points import KINDS, Row

pytestmark = pytest.mark.heavy

KEYS = {"benchmark", "kind", "source", "point", "quantity", "unit", "reference", "computed", "difference"}
slow = pytest.mark.slow


def largest(rows: Iterable[Row], quantity: str, variant: str = "") -> float:
    """Return the largest difference of a quantity; there has to be one."""
    result = [abs(row.difference) for row in rows if (row.quantity, row.variant) == (quantity, variant)]
    assert result
    return max(result)


@pytest.mark.parametrize("name", ["oblique", "bar", "bushing", "spatial", "squeezer", "stick_slip", "rig", "whirl"])
def test_the_grid_of_a_benchmark_is_a_file_that_anybody_can_run(name):
    file = resources.files("clearsweep.verify") / "references" / "grids" / f"{name}.yaml"
    assert len(grid.load(str(file), simulation.catalogue())) == 1


def test_every_benchmark_says_what_it_compares_and_why_it_differs():
    assert all(len(benchmark.text) > 100 for benchmark in measured.BENCHMARKS)
    assert len({benchmark.text for benchmark in measured.BENCHMARKS}) == len(measured.BENCHMARKS)


def test_a_hertz_impact_is_as_deep_hard_and_long_as_the_closed_form():
    rows = contact.measure_hertz()
    assert len(rows) == 12
    assert all(row.computed == pytest.approx(row.reference, rel=5e-5) for row in rows)


def test_an_impact_on_a_chain_of_six_springs_is_that_on_the_continuous_bar():
    rows = contact.measure_bar()
    assert len(rows) == 6
    for row in rows:
        assert row.computed == pytest.approx(row.reference, rel=0.01), row


@pytest.mark.slow
def test_a_housing_settles_where_the_table_of_its_film_says():
    rows = films.measure_at_rest(quick=True)
    assert largest(rows, "eccentricity ratio", "reynolds") < 0.003
    assert largest(rows, "attitude", "reynolds") < 4.6
    assert largest(rows, "eccentricity ratio", "finite") < 0.01


@slow
def test_every_film_settles_where_both_tables_say_and_drags_as_tabulated():
    rows = films.measure_at_rest()
    published = [row for row in rows if row.kind == "published"]
    assert len({row.point for row in published}) >= 24
    assert largest(published, "eccentricity ratio", "reynolds") < 0.003
    assert largest(published, "attitude", "reynolds") < 4.6
    drag = [row for row in rows if row.quantity == "friction variable"]
    assert all(row.computed == pytest.approx(row.reference, rel=0.012) for row in drag)


def at(rows, quantity, variant, low, high):
    """Return the rows of a quantity and a law whose incidence lies between two angles (deg)."""
    result = [row for row in rows if (row.quantity, row.variant) == (quantity, variant)]
    return [row for row in result if low <= float(row.point.split()[1]) <= high]


@pytest.mark.slow
def test_a_ball_that_sticks_springs_back_with_bristles_and_stops_without():
    rows = contact.measure_oblique(quick=True)
    for row in at(rows, "tangential restitution", "tanh", 0.0, 30.0):
        assert row.computed == pytest.approx(5.0 / 7.0, abs=1e-3)
    bristles = at(rows, "tangential restitution", "dahl", 10.0, 25.0)
    assert [row.computed for row in bristles] == pytest.approx([row.reference for row in bristles], abs=0.04)


@slow
@pytest.mark.parametrize("law", contact.FRICTION_LAWS)
def test_every_friction_law_gives_the_measured_rebound_of_a_ball_that_slides(law, impacts):
    restitution = at(impacts, "tangential restitution", law, 30.0, 90.0)
    assert len(restitution) == 6
    assert [row.computed for row in restitution] == pytest.approx([row.reference for row in restitution], abs=0.025)
    spin = at(impacts, "rebound spin", law, 45.0, 90.0)
    assert [row.computed for row in spin] == pytest.approx([row.reference for row in spin], rel=0.06)


@slow
def test_bristles_alone_let_the_contact_point_of_a_ball_spring_back(impacts):
    for law in contact.FRICTION_LAWS:
        (back,) = at(impacts, "rebound angle of the contact point", law, 20.0, 21.0)
        springs = law in ("dahl", "lugre", "elasto-plastic")
        assert back.difference < 2.5 if springs else back.computed == pytest.approx(0.0, abs=0.1)


@pytest.mark.slow
def test_the_squeezer_ends_where_the_reference_of_its_fourteen_numbers_is():
    rows = machines.measure_squeezer(quick=True)
    assert len(rows) == 14
    assert largest(rows, "angle at 0.03 s", "all pins ideal") < 1e-8
    assert largest(rows, "rate at 0.03 s", "all pins ideal") < 5e-6


@pytest.mark.slow
def test_a_block_drawn_along_a_guide_sticks_and_slips_as_in_the_paper():
    """A guide takes laws with internal state: each corner that touches bends bristles of its own."""
    rows = machines.measure_stick_slip(quick=True)
    assert len(rows) == 14
    assert largest(rows, "place", "lugre") < 1e-6
    assert largest(rows, "bend of the bristles", "lugre") < 5e-12  # of 12 um
    assert largest(rows, "begins", "lugre") < 2e-4
    assert largest(rows, "peak speed", "lugre") < 1e-5


@pytest.mark.slow
def test_a_rig_has_the_torque_of_its_source_while_the_film_bears_alone():
    rows = machines.measure_crank_pin(quick=True)
    result = {row.point: row for row in rows if row.quantity == "shaft torque"}
    assert result["8 kN, 1000 rpm"].computed == pytest.approx(result["8 kN, 1000 rpm"].reference, rel=0.08)
    assert (
        result["4 kN, 250 rpm"].computed < 0.7 * result["4 kN, 250 rpm"].reference
    )  # mixed friction: as the page says


@slow
def test_every_point_of_the_rig_is_between_both_counts_of_the_film():
    rows = [row for row in machines.measure_crank_pin() if row.quantity == "shaft torque"]
    by = {(row.point, row.variant): row.computed for row in rows}
    points = {row.point: row.reference for row in rows}
    assert len(points) == 15
    for point, torque in points.items():
        low, high = by[point, "reynolds"], by[point, machines.MEAN_HEIGHTS]
        assert low <= torque <= high or torque == pytest.approx(low, rel=0.13), point


@slow
def test_oil_whirl_begins_where_the_closed_form_says():
    rows = machines.measure_whirl()
    closed = [row for row in rows if row.variant == "short"]
    assert len(closed) == 16
    assert [row.computed for row in closed] == pytest.approx([row.reference for row in closed], rel=0.02)
    assert all(2.1 < row.computed < 2.76 for row in rows if row.variant == "reynolds")


@slow
def test_grooves_move_a_journal_by_some_hundredths_of_the_clearance():
    rows = films.measure_books()
    assert 0.01 < largest(rows, "eccentricity ratio", "reynolds") < 0.035
    assert largest(rows, "attitude", "reynolds") < 15.0


@slow
def test_grooves_cost_a_film_damping_across_its_load_and_a_rotor_its_threshold():
    rows = films.measure_books()
    assert len(rows) == 452  # of 35 bearings the place, of 20 the coefficients, of 16 of them a threshold, by two laws
    ratios = {}
    for row in rows:
        if row.variant == "reynolds":
            ratios.setdefault(row.quantity, []).append(row.computed / row.reference)
    for quantity, low, high in (  # what the page says
        ("stiffness Kxx", 0.45, 1.1),
        ("stiffness Kxy", 0.88, 1.12),
        ("damping Bxx", 0.83, 1.17),
        ("damping Byy", 0.75, 3.4),
        ("threshold speed", 0.99, 1.28),
    ):
        assert low < min(ratios[quantity]) < max(ratios[quantity]) < high, quantity
    light = {row.computed for row in rows if row.quantity == "threshold speed" and row.point == "L/D 1, S 2.95"}
    assert min(light) == pytest.approx(2.54, abs=0.03)  # as the whirling rotor of whirl.py runs


@pytest.mark.parametrize(
    ("ratio", "threshold"), [(0.1, 2.741), (0.3, 2.606), (0.5, 2.542), (0.7, 3.628), (0.8, math.inf)]
)
def test_a_short_film_has_the_threshold_of_its_closed_form(ratio, threshold):
    """Stiffness and damping of Ocvirk's film in closed form, with Routh's criterion: see the section on oil whirl."""
    slenderness, slow_share = 0.25, 1.0 - ratio**2
    root = math.sqrt(math.pi**2 * slow_share + 16.0 * ratio**2)
    sommerfeld = 0.5 * slenderness**2 * ratio * root / slow_share**2
    attitude = math.atan2(math.pi * math.sqrt(slow_share), 4.0 * ratio)
    film = films.film_coefficients("short", slenderness, sommerfeld, ratio, attitude)
    assert film["damping Bxy"] == pytest.approx(film["damping Byx"], rel=1e-5)
    assert films.whirl_threshold(film) == pytest.approx(threshold, abs=2e-3)


@slow
def test_ten_micrometres_in_a_pin_move_the_squeezer_by_less_than_0_1_rad():
    opened = [row for row in machines.measure_squeezer() if row.variant == "one pin open"]
    assert 1e-3 < largest(opened, "angle at 0.03 s", "one pin open") < 0.1


@slow
def test_pressure_laws_agree_on_volume_and_joints_in_space_wear_at_edges():
    rows = contact.measure_wear()
    ratios = {row.point: row.computed for row in rows if row.quantity == "ratio of worn volumes"}
    # arcs of up to 30 degrees: the pressure all round is up to 0.7 % more than its resultant
    assert ratios.pop("line contact over foundation, worn in") == pytest.approx(0.993, abs=0.02)
    assert list(ratios.values()) == pytest.approx([1.0, 1.0, 1.0], abs=0.05)
    assert largest(rows, "place of the deepest wear") == 0.0
    profiles = contact.new_profiles()
    apart = [np.sqrt(np.mean((depth - profiles["persson"]) ** 2)) for depth in profiles.values()]
    assert max(apart) < 0.1 * profiles["persson"].mean()  # the page says that they hardly differ
    springs, line = (depths for _, depths in contact.worn_in_profiles().values())
    for node, rms, most in ((1, 0.05, 0.11), (-1, 0.07, 0.27)):  # new and worn in
        difference = springs[node] / springs[node].mean() - line[node] / line[node].mean()
        measured = np.sqrt(np.mean(difference**2)), np.abs(difference).max()
        assert measured == pytest.approx((rms, most), abs=0.03)


@pytest.fixture(scope="module")
def impacts():
    return contact.measure_oblique()


@pytest.fixture
def few(monkeypatch):
    """Leave only what takes no time."""
    monkeypatch.setattr(measured, "BENCHMARKS", (contact.HERTZ_IMPACTS,))


def test_of_differences_that_are_normal_the_spread_contains_19_of_20_further_ones():
    chance, inside = np.random.default_rng(7), []
    (row,) = contact.measure_hertz()[:1]
    for _ in range(300):
        drawn = chance.normal(0.0, 2.0, 6)
        limit = points.expected_difference([row._replace(difference=float(value)) for value in drawn])
        inside.append(np.mean(np.abs(chance.normal(0.0, 2.0, 100)) <= limit))
    assert 0.94 < np.mean(inside) < 0.99
    assert points.expected_difference([row]) is None


@pytest.mark.usefixtures("few")
def test_the_command_prints_rows_of_the_contract_as_json():
    message = CliRunner().invoke(cli.verbs, ["verify", "--measured", "--json"])
    assert message.exit_code == 0, message.output
    rows = json.loads(message.stdout)
    assert len(rows) == 12
    for row in rows:
        assert set(row) >= KEYS
        assert row["kind"] in KINDS
        assert row["difference"] == pytest.approx(row["computed"] - row["reference"])


def test_the_page_has_every_point_its_source_and_its_spread(tmp_path):
    rows = contact.measure_hertz()
    words = points.write_page(rows, tmp_path, (contact.HERTZ_IMPACTS,)).read_text(encoding="utf-8")
    assert words.count("| Hertz impacts |") == 12
    assert rows[0].source in words
    assert "| depth |  | published | 4 |" in words
    assert "Hertz impacts, depth" in points.rows_text(rows)
