"""The film law `reynolds` against a second solver of the same equation, published tables, and its own invariants."""

import csv
import itertools
import math
import runpy
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from film_oracle import solution
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.contracts.case import NO_CONTACT, Film, Joint
from clearsweep.mechanics.laws import reynolds
from clearsweep.mechanics.laws.contract import RECIPES
from clearsweep.mechanics.laws.film import FilmMotion, film_force, film_pressure
from clearsweep.mechanics.laws.reynolds import Short
from clearsweep.simulation.advice import advice
from clearsweep.tracing.compiled.dual import Dual

TABLE = runpy.run_path(str(Path(__file__).parent.parent / "docs/tools/film_table.py"))
SLENDER = (0.2, 0.33, 0.5, 0.8, 1.0, 1.4, 2.0)


def law_of(slenderness):
    """Return the law in the units of the second solver: its integrals over half of the pin."""
    squared = slenderness**2
    return reynolds.Reynolds(Short(2.0 / 3.0 * squared, 0.5 * squared), *reynolds.tables_at(slenderness))


def film_result(law, ratio, squeeze, wedge):
    """Return the force for 2 eps' and w eps."""
    return np.array(film_force(law, FilmMotion(ratio, 0.5 * squeeze, wedge / ratio)))


def moving(ratio, turn):
    """Return squeeze and wedge in a direction of motion in which neither is lost without the other."""
    return math.sin(turn), math.cos(turn) / (1.0 - ratio * ratio) ** 0.25


def distance(law, slenderness, ratio, turn, mesh):
    """Return how far the force is from that of the second solver, over its size."""
    motion = moving(ratio, turn)
    truth = solution(slenderness, ratio, *motion, mesh)[:2]
    return float(np.linalg.norm(film_result(law, ratio, *motion) - truth) / np.linalg.norm(truth))


QUADRANTS = [*itertools.product((0.2, 0.7, 2.0), (0.05, 0.6, 0.93), (0.4, 1.57, 2.2, 3.6, 4.712, 5.6))]


@pytest.mark.parametrize(("slenderness", "ratio", "turn"), QUADRANTS)
def test_a_film_of_finite_length_is_reynolds_equation_in_all_directions_of_motion(slenderness, ratio, turn):
    assert distance(law_of(slenderness), slenderness, ratio, turn, (96, 6)) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("slenderness", SLENDER)
def test_a_film_of_finite_length_is_reynolds_equation_up_to_thin_films(slenderness):
    law = law_of(slenderness)
    for ratio, turn in itertools.product((0.3, 0.75, 0.9, 0.97), np.arange(12) * math.pi / 6.0 + 0.1):
        assert distance(law, slenderness, ratio, turn, (192, 8)) < 0.004, (ratio, turn)


@pytest.mark.slow
def test_the_file_is_what_its_solver_makes():
    """At directions and eccentricities between those that it is made of, and at lengths between."""
    for slenderness, ratio in itertools.product((0.25, 0.6, 1.7), (0.2, 0.66, 0.96)):
        law, sines = law_of(slenderness), np.array([-0.97, -0.4, 0.1, 0.8])
        exact = TABLE["logarithms_over_short"](slenderness, ratio, sines)
        for table, rows, tolerance in ((law.power, exact[0], 2e-3), (law.peak, exact[1], 0.1)):
            result = [reynolds.evaluate_expansion(table, ratio, sine)[0] for sine in sines]
            assert result == pytest.approx(rows, rel=0.0, abs=tolerance)


def published(motion, shortest=0.2):
    """Yield length / diameter, eccentricity ratio, So and attitude (deg) of Butenschoen's tables, without misprints."""
    file = resources.files("clearsweep.verify") / "references" / "butenschoen_1976.csv"
    with file.open(encoding="utf-8") as lines:
        for row in csv.DictReader(line for line in lines if not line.startswith("#")):
            slenderness, ratio = float(row["length_over_diameter"]), float(row["eccentricity_ratio"])
            if row["motion"] == motion and slenderness >= shortest:
                yield slenderness, ratio, float(row["sommerfeld_number_So"]), row["attitude_deg"]


def sommerfeld(slenderness, ratio, squeeze_rate, spin):
    """Return So and attitude (deg) by the law: F psi^2 / (L D mu w) of integrals over half of the pin."""
    radial, tangential = 3.0 * np.array(film_force(law_of(slenderness), FilmMotion(ratio, squeeze_rate, spin)))
    return math.hypot(radial, tangential), math.degrees(math.atan2(tangential, -radial))


def test_a_bearing_that_turns_bears_what_butenschoen_tabulated():
    """His film begins where it is thickest; ours where a pressure above 0 can, a little before it in a long bearing."""
    rows = list(published("wedge"))
    assert len(rows) == 84
    for slenderness, ratio, load, attitude in rows:
        result, angle = sommerfeld(slenderness, ratio, 0.0, 1.0)
        # the table's So has four digits, and its grid is coarse for thin films
        assert result == pytest.approx(load, rel=0.022 if ratio <= 0.9 else 0.04, abs=6e-5), (slenderness, ratio)
        assert angle - float(attitude) == pytest.approx(0.0, abs=0.5 + 5.0 * slenderness**2 * (1.0 - ratio))


@pytest.mark.parametrize(("slenderness", "ratio"), [(1.0, 0.2), (1.0, 0.6), (0.5, 0.3)])
def test_the_published_film_begins_where_it_is_thickest(slenderness, ratio):
    """Without pressure at theta = 0 the second solver has the published attitude, with it that of the law."""
    attitudes = {(b, eps): (load, float(angle)) for b, eps, load, angle in published("wedge")}
    load, attitude = attitudes[slenderness, ratio]
    for groove, size, angle in ((True, load, attitude), (False, *sommerfeld(slenderness, ratio, 0.0, 1.0))):
        radial, tangential, _ = 3.0 * solution(slenderness, ratio, 0.0, ratio, (96, 6), groove)
        assert math.hypot(radial, tangential) == pytest.approx(size, rel=0.003)
        assert math.degrees(math.atan2(tangential, -radial)) == pytest.approx(angle, abs=0.15)


def test_a_bearing_that_is_squeezed_bears_what_butenschoen_tabulated():
    """The eccentricity has the sign of its rate."""
    rows = list(published("squeeze"))
    assert len(rows) > 160
    for slenderness, ratio, load, _ in rows:
        if abs(ratio) <= 0.97 and ratio != 0.0:
            result, _ = sommerfeld(slenderness, abs(ratio), math.copysign(1.0, ratio), 0.0)
            assert result == pytest.approx(load, rel=0.02, abs=6e-5), (slenderness, ratio)


def test_the_fits_of_finite_are_as_near_to_the_tables_as_they_say():
    """Each alone: a steady wedge and a pure squeeze, over what the law is trusted for."""
    for slenderness, ratio, load, _ in published("wedge", 0.125):
        result = math.hypot(*film_force(reynolds.make_butenschoen(1.0, slenderness), FilmMotion(ratio, 0.0, 1.0)))
        assert ratio > 0.95 or result == pytest.approx(load, rel=0.07, abs=6e-5), (slenderness, ratio)
    for slenderness, ratio, load, _ in published("squeeze", 0.125):
        motion = FilmMotion(abs(ratio), math.copysign(1.0, ratio), 0.0)
        result = math.hypot(*film_force(reynolds.make_butenschoen(1.0, slenderness), motion))
        assert abs(ratio) > 0.95 or result == pytest.approx(load, rel=0.07, abs=6e-5), (slenderness, ratio)


#: Length / diameter, eccentricity ratio -> Sommerfeld number S = 1 / (2 pi So) and attitude (deg): Raimondi & Boyd
#: 1958, Trans. ASLE 1:159, full bearing.
RAIMONDI = {
    (1.0, 0.2): (0.631, 74.02),
    (1.0, 0.6): (0.121, 50.58),
    (1.0, 0.8): (0.0446, 36.24),
    (1.0, 0.9): (0.0188, 26.45),
    (0.5, 0.6): (0.319, 48.14),
    (0.5, 0.8): (0.0923, 33.31),
    (0.25, 0.6): (1.07, 46.72),
}


@pytest.mark.parametrize("place", RAIMONDI)
def test_a_bearing_that_turns_bears_what_raimondi_and_boyd_tabulated(place):
    load, attitude = sommerfeld(*place, 0.0, 1.0)
    number, angle = RAIMONDI[place]
    assert 0.5 / (math.pi * load) == pytest.approx(number, rel=0.012)
    assert attitude - angle == pytest.approx(0.0, abs=0.5 + 5.0 * place[0] ** 2 * (1.0 - place[1]))


@settings(max_examples=300)
@given(st.floats(0.2, 2.0), st.floats(0.0, 0.999), st.floats(-math.pi, math.pi))
@example(1.0, 0.95, -1.0)
@example(2.0, 0.999, -math.pi / 2.0)
def test_a_film_never_feeds_energy_in(slenderness, ratio, turn):
    squeeze, wedge = math.sin(turn), math.cos(turn)
    motion = FilmMotion(ratio, 0.5 * squeeze, wedge / ratio if ratio > 1e-6 else 0.0)
    radial, tangential = film_force(law_of(slenderness), motion)
    squeeze, wedge = 2.0 * motion.squeeze_rate, motion.spin * ratio
    assert wedge * tangential - squeeze * radial >= 0.0


def test_a_force_grows_with_the_velocities_and_is_mirrored_with_them():
    law = law_of(0.7)
    for ratio, turn in itertools.product((1e-9, 0.4, 0.95), (-1.2, -0.3, 0.0, 0.7, 1.4)):
        squeeze, wedge = moving(ratio, turn)
        radial, tangential = film_result(law, ratio, squeeze, wedge)
        assert film_result(law, ratio, 40.0 * squeeze, 40.0 * wedge) == pytest.approx(
            (40.0 * radial, 40.0 * tangential)
        )
        assert film_result(law, ratio, squeeze, -wedge) == pytest.approx((radial, -tangential))
    assert film_force(law, FilmMotion(0.5, 0.0, 0.0)) == (0.0, 0.0)
    assert film_force(law, FilmMotion(0.0, 0.0, 0.0)) == (0.0, 0.0)


def test_a_force_is_the_gradient_of_half_the_power():
    law, step = law_of(1.1), 1e-5

    def power(squeeze, wedge):
        radial, tangential = film_result(law, 0.83, squeeze, wedge)
        return wedge * tangential - squeeze * radial

    for turn in np.linspace(-3.0, 3.0, 9):
        squeeze, wedge = moving(0.83, turn)
        by_squeeze = (power(squeeze + step, wedge) - power(squeeze - step, wedge)) / (2.0 * step)
        by_wedge = (power(squeeze, wedge + step) - power(squeeze, wedge - step)) / (2.0 * step)
        assert film_result(law, 0.83, squeeze, wedge) == pytest.approx((-0.5 * by_squeeze, 0.5 * by_wedge), rel=1e-6)


def test_a_journal_near_the_centre_has_the_force_of_one_that_is_squeezed_there():
    """Whatever the direction of its velocity from there: at the centre none is another."""
    law = law_of(0.9)
    sizes = [
        np.linalg.norm(film_result(law, 1e-12, math.sin(turn), math.cos(turn)))
        for turn in np.linspace(-math.pi, math.pi, 13)
    ]
    assert sizes == pytest.approx([sizes[0]] * 13, rel=2e-4)


def test_the_largest_pressure_is_that_of_the_second_way():
    """Where a film closes or turns; while it opens, where the pressure is far below these, within a tenth."""
    for slenderness, ratio in itertools.product((0.3, 1.0, 2.0), (0.2, 0.6, 0.9)):
        film, law = TABLE["Film"](slenderness, ratio, (128, 16)), law_of(slenderness)
        for turn, tolerance in ((0.0, 0.02), (0.5, 0.02), (1.5, 0.02), (-0.3, 0.03), (-1.5, 0.1)):
            squeeze, wedge = moving(ratio, turn)
            result = film_pressure(law, FilmMotion(ratio, 0.5 * squeeze, wedge / ratio))
            assert result == pytest.approx(film.solve(squeeze, wedge).max_pressure, rel=tolerance)


@pytest.mark.plain
def test_a_film_of_finite_length_has_exact_derivatives():
    law, step = law_of(0.6), 1e-6
    point = np.array([0.8, -3.0, 40.0])
    for way in range(3):
        seeds = [Dual(value, float(i == way)) for i, value in enumerate(point)]
        up, down = (
            film_force(law, FilmMotion(*(point + sign * step * point[way] * np.eye(3)[way]))) for sign in (1, -1)
        )
        for dual, high, low in zip(film_force(law, FilmMotion(*seeds)), up, down, strict=True):
            assert dual.slope == pytest.approx((high - low) / (2.0 * step * point[way]), rel=1e-6, abs=1e-6)


def test_a_law_has_the_sizes_of_its_joint():
    """F = 3 (L D mu / psi^2) times the integrals over half of the pin, p = 6 mu (R / c)^2 times the pressure."""
    film = Film(law="reynolds", friction="none", viscosity=0.4, limit=0.99)
    joint = Joint(name="rod-slider", clearance=5e-4, contact=NO_CONTACT, bearing_radius=0.02, length=0.04, film=film)
    made, plain, motion = RECIPES["film", "reynolds"].make(joint), law_of(1.0), FilmMotion(0.6, 3.0, 200.0)
    size = 3.0 * 0.04 * 0.04 * 0.4 / (5e-4 / 0.02) ** 2
    assert film_force(made, motion) == pytest.approx([size * x for x in film_force(plain, motion)], rel=1e-12)
    assert film_pressure(made, motion) == pytest.approx(6.0 * 0.4 * 1600.0 * film_pressure(plain, motion), rel=1e-12)


# ---------------------------------------------------------------------------------------------- grids


def oiled_grid(length="40 mm", **film):
    """Return the grid of a slider-crank with a film in a bearing of 40 mm diameter."""
    joint = {"film": {"viscosity": "0.4 Pa*s", **film}, "bearing_radius": "20 mm", "length": length}
    return slider_crank("rod-slider", changes={f"joints.rod-slider.{key}": value for key, value in joint.items()})


def test_a_film_without_a_law_is_one_of_reynolds():
    scene = clearsweep.load_case(oiled_grid())
    assert scene.case.joints[0].film.law == "reynolds"
    assert type(scene.value.joints[0].film) is reynolds.Reynolds
    for length in ("8 mm", "80 mm"):  # 0.2 and 2 diameters
        clearsweep.load_case(oiled_grid(length))


@pytest.mark.parametrize("length", ["120 mm", "4 mm", "60 mm"])
def test_the_law_of_a_short_bearing_is_allowed_at_every_length(length):
    clearsweep.load_case(oiled_grid(length, law="short"))


def test_advice_reports_for_which_bearings_a_law_of_a_film_holds():
    words = {}
    for length in ("40 mm", "60 mm", "120 mm"):
        (film_result,) = advice(clearsweep.load_case(oiled_grid(length, law="long")).case)
        words[length] = {item.law: item.rating for item in film_result.assessments if item.family == "film"}
    assert [words[length]["reynolds"] for length in words] == ["suitable", "suitable", "not here"]
    assert [words[length]["finite"] for length in words] == ["suitable", "not here", "not here"]


@pytest.mark.slow
def test_a_case_says_where_its_law_fed_energy_in():
    messages = {}
    for law in ("finite", "reynolds"):
        source = oiled_grid(law=law, viscosity=0.1) | {"simulate": {"revolutions": 2, "discard": 0, "tolerance": 1e-6}}
        source["joints"]["rod-slider"] |= {"clearance": "0.5 mm"}
        source["joints"]["rod-slider"].pop("contact", None)
        messages[law] = clearsweep.simulate(clearsweep.load_case(source)).message
    assert "film-fed: the film of rod-slider returns" in messages["finite"]
    assert "choose film.law: reynolds" in messages["finite"]
    assert "film-fed" not in messages["reynolds"]


# ---------------------------------------------------------------------------------------------- a squeezed film


#: (length / diameter, eccentricity ratio, Sommerfeld number of pure squeeze), from the tables of Butenschön 1976.
SQUEEZED = [(1.0, 0.99, 6057.9), (0.5, 0.99, 5486.9), (0.25, 0.99, 4335.3), (0.25, -0.9, 0.0376), (0.25, -0.5, 0.0688)]


@pytest.mark.parametrize(("slenderness", "ratio", "number"), SQUEEZED)
def test_a_squeezed_film_has_the_number_of_the_table(slenderness, ratio, number):
    """A ratio below 0 is a journal that leaves: the film is squeezed on the other side."""
    force = film_result(law_of(slenderness), abs(ratio), math.copysign(1.0, ratio), 0.0)
    assert 6.0 * float(np.hypot(*force)) == pytest.approx(number, rel=8e-3)
    assert reynolds.squeeze_number(reynolds.make_butenschoen(1.0, slenderness), ratio) == pytest.approx(
        number, rel=0.025
    )


@pytest.mark.slow
def test_the_table_and_the_fit_lie_below_the_converged_force_at_the_last_ratio():
    """Two meshes of the second solver agree within 1e-4; So of the table is 107.787, 0.5 % below them."""
    coarse, fine = (3.0 * 0.99 * np.hypot(*solution(1.0, 0.99, 0.0, 1.0, (cells, 8))[:2]) for cells in (384, 768))
    assert coarse == pytest.approx(fine, rel=1e-4)
    assert 107.787 / fine == pytest.approx(0.995, abs=1e-3)
    fit, _, _ = reynolds.wedge_number(reynolds.make_butenschoen(1.0, 1.0), 0.99)
    assert fit / fine == pytest.approx(0.9765, abs=1e-3)
    assert 3.0 * np.hypot(*film_result(law_of(1.0), 0.99, 0.0, 0.99)) == pytest.approx(fine, rel=1e-3)
