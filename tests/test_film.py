"""Films of oil: each law against closed forms and quadrature of its own pressure, then motions with films."""

import itertools
import json
import math
from importlib import resources

import numpy as np
import pytest
from law_cases import RECIPES, names
from mechanism_cases import changed, slider_crank

import clearsweep
from clearsweep import simulation
from clearsweep.answers import validity
from clearsweep.contracts.case import NO_CONTACT, Film, Joint
from clearsweep.language.errors import InputError
from clearsweep.mechanics.joints import lubricated, registry
from clearsweep.mechanics.laws import reynolds
from clearsweep.mechanics.laws.film import FilmMotion, Ramp, dry_fraction, film_couples, film_force, film_pressure
from clearsweep.simulation.analyses import repeated
from clearsweep.simulation.remarks import passive_film
from clearsweep.tracing.compiled.dual import Dual
from clearsweep.verify import extremes

LAWS, SHEARS = names("film"), names("film-friction")
LONG, SHORT, PINKUS = reynolds.Long(1.0, 6.0), reynolds.Short(1.0, 1.5), reynolds.PinkusSternlicht(1.0)
MOTIONS = [*itertools.product((0.05, 0.3, 0.7, 0.95), (-1.5, -0.1, 0.0, 0.2, 2.0), (-0.7, 0.0, 1.0))]


def film_result(law, ratio, squeeze_rate, spin=1.0):
    return film_force(law, FilmMotion(ratio, squeeze_rate, spin))


def oiled(law="finite", friction="none", length=0.04):
    """Return a joint with a film of 0.4 Pa s and nothing behind it."""
    film = Film(law=law, friction=friction, viscosity=0.4, limit=0.99, density=870.0)
    return Joint(name="rod-slider", clearance=5e-4, contact=NO_CONTACT, bearing_radius=0.02, length=length, film=film)


# ---------------------------------------------------------------------------------------------- laws


@pytest.mark.parametrize("law", [LONG, PINKUS], ids=["long", "pinkus-sternlicht"])
@pytest.mark.parametrize(
    ("ratio", "force"), [(0.2, (-0.245098, 1.886103)), (0.5, (-1.777778, 4.836798)), (0.8, (-8.080808, 9.519978))]
)
def test_a_long_film_that_turns_steadily_bears_what_sommerfeld_found(law, ratio, force):
    assert film_result(law, ratio, 0.0) == pytest.approx(force, abs=5.1e-7, rel=0.0)


@pytest.mark.parametrize(
    ("ratio", "closes", "opens"),
    [
        (0.1, -21.568264, 16.703487),
        (0.3, -29.881934, 13.545986),
        (0.5, -46.694386, 11.347193),
        (0.8, -165.449530, 9.083395),
        (0.95, -1230.0482, 8.247053),
    ],
)
def test_a_long_film_that_is_squeezed_has_the_closed_form(ratio, closes, opens):
    assert film_result(LONG, ratio, 1.0, 0.0) == pytest.approx((closes, 0.0), rel=5e-8, abs=1e-12)
    assert film_result(LONG, ratio, -1.0, 0.0) == pytest.approx((opens, 0.0), rel=5e-8, abs=1e-12)


@pytest.mark.parametrize(
    ("ratio", "squeeze_rate", "approximate", "exact"),
    [
        (0.5, 0.1, (-5.52306, 6.01389), (-5.28136, 5.55313)),
        (0.5, 1.0, (-49.60082, 7.04514), (-46.6979, 6.41713)),
        (0.5, -0.1, (0.2811, 3.65971), (0.5228, 4.12047)),
        (0.8, 0.1, (-19.90655, 12.6295), (-19.4349, 11.91869)),
        (0.3, 0.1, (-3.30421, 3.42457), (-3.10934, 3.15749)),
    ],
)
def test_long_films_that_turn_and_are_squeezed_have_their_checked_values(ratio, squeeze_rate, approximate, exact):
    assert film_result(PINKUS, ratio, squeeze_rate) == pytest.approx(approximate, rel=1e-5, abs=5e-6)
    assert film_result(LONG, ratio, squeeze_rate) == pytest.approx(exact, rel=1e-5, abs=5e-6)


@pytest.mark.parametrize(
    ("ratio", "squeeze_rate", "spin", "force"),
    [
        (0.5, 0.0, 1.0, (-0.4444444, 0.6045998)),
        (0.5, 1.0, 0.0, (-9.1157311, 0.0)),
        (0.5, -1.0, 0.0, (0.5578655, 0.0)),
        (0.5, 0.3, 1.0, (-2.7591642, 0.9079342)),
        (0.5, -0.3, 1.0, (0.1429147, 0.3012653)),
        (0.8, 1.0, 1.0, (-91.775019, 5.464720)),
    ],
)
def test_a_short_film_has_its_checked_values(ratio, squeeze_rate, spin, force):
    assert film_result(SHORT, ratio, squeeze_rate, spin) == pytest.approx(force, rel=1e-7, abs=6e-8)


@pytest.mark.parametrize(
    ("form", "pressure_at", "share", "lead"),
    [(LONG, reynolds._long_pressure, 1.0, 1.0), (SHORT, reynolds._short_pressure, 1.0 / 3.0, 0.0)],
    ids=["long", "short"],
)
def test_a_film_in_closed_form_is_the_integral_of_its_pressure(form, pressure_at, share, lead):
    """Over the half circle, with Gauss's rule; along the pin, a short film's pressure is a parabola."""
    x, weight = np.polynomial.legendre.leggauss(300)
    for ratio, squeeze_rate, spin in MOTIONS:
        if squeeze_rate == spin == 0.0:
            continue
        squeeze = squeeze_rate * (2.0 + ratio * ratio) if lead else 2.0 * squeeze_rate
        angle = math.atan2(squeeze, spin * ratio) + 0.5 * math.pi * (x + 1.0)
        motion = FilmMotion(ratio, squeeze_rate, spin)
        pressure = np.array([pressure_at(form, motion, math.cos(a), math.sin(a)) for a in angle])
        result = [share * 0.5 * math.pi * float((weight * pressure * f(angle)).sum()) for f in (np.cos, np.sin)]
        assert film_result(form, ratio, squeeze_rate, spin) == pytest.approx(result, rel=1e-9, abs=1e-10)
        fine = math.atan2(squeeze, spin * ratio) + np.linspace(0.0, math.pi, 2001)
        assert film_pressure(form, motion) == pytest.approx(
            pressure_at(form, motion, np.cos(fine), np.sin(fine)).max(), rel=1e-4
        )


def test_the_long_films_antisymmetry_holds_with_the_full_films_force():
    """p(-theta; w, -eps') = -p(theta; w, eps'): what a half film bears while it opens follows from the full film."""
    for law, (ratio, squeeze_rate, spin) in itertools.product((LONG, PINKUS), MOTIONS):
        if squeeze_rate > 0.0 and spin > 0.0:
            (closes, distance), (opens, back) = (
                film_result(law, ratio, sign * squeeze_rate, spin) for sign in (1.0, -1.0)
            )
            whole = 12.0 * math.pi * ratio * spin / ((2.0 + ratio**2) * math.sqrt(1.0 - ratio**2))
            full = 12.0 * math.pi * squeeze_rate / (1.0 - ratio**2) ** 1.5
            assert opens - closes == pytest.approx(full, rel=1e-10)
            assert distance + back == pytest.approx(whole, rel=1e-10)


#: Length / diameter, eccentricity ratio -> So and attitude (deg) of the wedge, So of the squeeze: finite differences of
#: Reynolds' equation in two dimensions, 180 by 24 points.
REYNOLDS = {
    (0.25, 0.6): (0.1475, 46.86, 1.8450),
    (0.5, 0.3): (0.1302, 69.23, 1.6900),
    (0.5, 0.6): (0.4972, 48.26, 6.0650),
    (0.5, 0.8): (1.7329, 32.99, 26.686),
    (1.0, 0.3): (0.4113, 71.44, 5.0484),
    (1.0, 0.6): (1.3102, 51.98, 14.775),
    (1.0, 0.8): (3.5565, 36.79, 50.392),
}


@pytest.mark.parametrize("slenderness", [0.25, 0.5, 1.0])
def test_a_finite_film_is_within_the_stated_error_of_reynolds_equation(slenderness):
    law = reynolds.make_butenschoen(1.0, slenderness)
    for (b, ratio), (angle_rate, attitude, squeeze) in REYNOLDS.items():
        if b == slenderness:
            radial, tangential = film_result(law, ratio, 0.0)
            assert math.hypot(radial, tangential) == pytest.approx(angle_rate, rel=0.034)
            assert math.degrees(math.atan2(tangential, -radial)) == pytest.approx(attitude, abs=4.0)
            assert -film_result(law, ratio, 1.0, 0.0)[0] == pytest.approx(squeeze, rel=0.034)


@pytest.mark.parametrize("name", LAWS)
def test_a_film_is_continuous_where_it_turns_from_closing_to_opening(name):
    law = RECIPES["film", name].make(oiled(name))
    for ratio in (1e-6, 0.1, 0.5, 0.9, 0.99):
        before, here, after = (film_result(law, ratio, squeeze_rate, 100.0) for squeeze_rate in (-1e-9, 0.0, 1e-9))
        for force in (before, after):
            assert force == pytest.approx(here, rel=0.0, abs=1e-7 * math.hypot(*here) + 1e-8)


@pytest.mark.parametrize("name", LAWS)
def test_a_film_that_closes_pushes_back_and_a_concentric_one_at_rest_does_nothing(name):
    law = RECIPES["film", name].make(oiled(name))
    assert all(film_result(law, ratio, 10.0, 0.0)[0] < 0.0 for ratio in (0.0, 1e-6, 0.5, 0.99))
    assert film_result(law, 0.0, 0.0, 300.0) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert film_result(law, 0.5, 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.plain
@pytest.mark.parametrize("name", LAWS)
def test_a_film_has_exact_derivatives(name):
    law = RECIPES["film", name].make(oiled(name))
    step = 1e-6
    for way in range(3):
        point = np.array([0.6, -3.0, 40.0])
        seeds = [Dual(value, float(i == way)) for i, value in enumerate(point)]
        up, down = (film_result(law, *(point + sign * step * point[way] * np.eye(3)[way])) for sign in (1.0, -1.0))
        for dual, high, low in zip(film_result(law, *seeds), up, down, strict=True):
            assert dual.slope == pytest.approx((high - low) / (2.0 * step * point[way]), rel=1e-6, abs=1e-4)


# ---------------------------------------------------------------------------------------------- joints


def test_shear_has_petroffs_couple_where_the_journal_is_concentric():
    petroff = 2.0 * math.pi * 0.4 * 0.02**3 * 0.04 / 5e-4 * 100.0
    for name in SHEARS:
        shear = RECIPES["film-friction", name].make(oiled(friction=name))
        journal, bearing = film_couples(shear, FilmMotion(0.0, 0.0, 0.0), 100.0, 0.0)
        assert journal == -bearing == pytest.approx(0.0 if name == "none" else -petroff)


def test_butenschoens_shear_is_the_published_coefficient_of_a_bearing_at_rest():
    ratio, spin, b, psi = 0.6, 80.0, 1.0, 5e-4 / 0.02
    joint = oiled(friction="butenschoen")
    law, shear = registry.compile_film(joint)
    size, sine, _ = reynolds.wedge_number(law, ratio)
    journal, _ = film_couples(
        shear, FilmMotion(ratio, 0.0, spin), spin, ratio * 5e-4 * film_result(law, ratio, 0.0, spin)[1]
    )
    coefficient = psi * (math.pi / (math.sqrt(1.0 - ratio**2) * size) + 0.5 * ratio * sine)
    assert -journal == pytest.approx(coefficient * size * law.force * spin * 0.02, rel=1e-12)
    assert law.slenderness == b


def test_the_force_is_continuous_over_the_transition_and_its_shares_add_up():
    ramp = Ramp(1e-6, 2e-6)
    shares = [dry_fraction(ramp, depth) for depth in (-1.0, 1e-6, 2e-6, 3e-6, 1.0)]
    assert shares == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0], abs=1e-12)


# ---------------------------------------------------------------------------------------------- grids


FILM = {"law": "finite", "viscosity": "0.4 Pa*s"}


def film_grid(**changes):
    changes = {"joints.rod-slider.film": FILM, "joints.rod-slider.bearing_radius": 0.02} | changes
    return slider_crank("rod-slider", changes={path.replace("__", "."): value for path, value in changes.items()})


def test_a_film_needs_no_dry_contact_and_has_columns_and_a_channel_of_its_own():
    scene = clearsweep.load_case(film_grid(**{"joints.rod-slider.contact": None}))
    assert type(scene.value.joints[0]) is lubricated.Film
    assert "joints/rod_slider/force_dry" in [channel.name for channel in scene.layout.channels]
    columns = {column.name for column in scene.layout.columns}
    assert {f"rod_slider_{name}" for name in ("film_thickness_min", "film_loss", "force_peak_dry")} <= columns
    assert simulation.warnings(scene.case) == []  # which looked for the loss of a law that is not there
    dry = clearsweep.load_case(slider_crank("rod-slider"))
    assert not any("film" in column.name or "dry" in column.name for column in dry.layout.columns)


# ---------------------------------------------------------------------------------------------- oil, asperities


OIL = {"at_40C": "46 mm^2/s", "at_100C": "6.8 mm^2/s", "density": "870 kg/m^3"}


def test_a_viscosity_at_a_temperature_is_walthers():
    """Between its two points an ISO VG 46 oil has about 20 mm^2/s at 60 degC, as charts of ASTM D341 show it."""
    film = {"law": "short", "viscosity": OIL, "temperature": "60 degC"}
    read = clearsweep.load_case(film_grid(**{"joints.rod-slider.film": film})).case.joints[0].film
    assert read.temperature == pytest.approx(333.15, rel=1e-12)
    assert read.viscosity / 870.0 == pytest.approx(20.6e-6, rel=5e-3)
    for temperature, kinematic in ((313.15, 46e-6), (373.15, 6.8e-6)):
        assert read.oil.viscosity(temperature) == pytest.approx(870.0 * kinematic, rel=1e-12)


def test_the_remarks_on_films_name_joint_and_figures():
    contents, beyond, flow, fed = validity.film_remarks(
        [validity.FilmState("rod-slider", 0.99, 0.25, 1.05, False, 62.0, 0.02)]
    )
    assert "rod-slider exceeds the eccentricity ratio 0.99" in contents
    assert "for 25 % of the time" in contents
    assert "reaches 1.05 clearances" in beyond
    assert "Taylor number of 62" in flow
    assert "the film of rod-slider returns 2 % of the energy that it takes" in fed
    assert fed.endswith("choose film.law: reynolds")
    assert validity.film_remarks([validity.FilmState("rod-slider", 0.99, 0.0, 0.9, False, 5.0, 1e-5)]) == (
        "",
        "",
        "",
        "",
    )
    assert validity.film_remarks([validity.FilmState("rod-slider", 0.99, 0.0, 1.1, True, 5.0)])[1] == ""
    reynolds = validity.FilmState("rod-slider", 0.99, 0.0, 0.9, False, 5.0, 0.02, "short")
    assert validity.film_remarks([reynolds])[3].endswith("choose film.law: short")


@pytest.mark.parametrize(("length", "law"), [(6e-3, "short"), (9e-3, "reynolds"), (79e-3, "reynolds"), (81e-3, "long")])
def test_the_film_that_a_remark_recommends_is_allowed_at_the_length_of_the_bearing(length, law):
    def read(name):
        film = {"law": name, "viscosity": "0.4 Pa*s"}
        changes = {"joints.rod-slider.film": film, "joints.rod-slider.length": length}
        return clearsweep.load_case(film_grid(**changes)).case.joints[0]

    assert passive_film(read("short")) == law
    assert read(law).film.law == law
    if law != "reynolds":
        with pytest.raises(InputError, match="film 'reynolds' allows"):
            read("reynolds")


def test_the_table_of_stability_has_thirty_films_each_level_as_often():
    table = extremes.film_cases()
    assert len(table) == 30
    assert table == extremes.film_cases()
    clearances = [next(iter(case.grid["joints"].values()))["clearance"] for case in table]
    assert [clearances.count(value) for value in extremes.read_levels()["factors"]["films"]["clearance"]] == [6] * 5
    assert sum("contact" in next(iter(case.grid["joints"].values())) for case in table) == 15
    for case in table:
        clearsweep.load_case(case.grid)


# ---------------------------------------------------------------------------------------------- motions


def a_crank(changes=None):
    """Return the grid of the reference trajectory with a film alone, at a looser tolerance."""
    file = resources.files("clearsweep.verify") / "references" / "machines.json"
    grid = json.loads(file.read_text(encoding="utf-8"))["problems"]["sc_film"]["grid"]
    return changed(grid, {"simulate.tolerance": 1e-8, **(changes or {})})


@pytest.mark.slow
def test_a_stiff_film_takes_few_steps_by_every_method_and_its_energies_balance():
    stiff = {"joints.rod-slider.clearance": "0.2 mm", "drive.speed": "1000 rpm"}
    steps = {}
    for method in ("auto", "explicit", "implicit"):
        path = clearsweep.simulate(clearsweep.load_case(a_crank(stiff | {"simulate.method": method})))
        assert path.status == "ok"
        assert path.summary["energy_residual"] < 1e-6
        assert path.summary["rod_slider_film_fraction"] == 1.0
        steps[method] = path.summary["steps"]
    assert steps["auto"] <= steps["explicit"] < 400  # with plain sweeps 41,850
    assert steps["implicit"] < 400


@pytest.mark.slow
def test_a_heat_balance_settles_where_the_loss_is_led_away():
    film = {"law": "finite", "friction": "none", "viscosity": OIL, "thermal": {"conductance": 20.0, "ambient": 300.0}}
    source = a_crank({"joints.rod-slider.film": film, "simulate.revolutions": 4, "simulate.discard": 1})
    summary = clearsweep.simulate(clearsweep.load_case(source)).summary
    warm = 300.0 + summary["rod_slider_film_loss"] / 20.0
    tolerance = max(repeated.ABSOLUTE_TOLERANCE, repeated.RELATIVE_TOLERANCE * (warm - 300.0))
    assert summary["rod_slider_film_temperature"] == pytest.approx(warm, abs=tolerance, rel=0.0)
    assert 0.0 < summary["rod_slider_film_temperature_ci"] < 0.1
    assert summary["rod_slider_film_temperature"] > 301.0


@pytest.mark.slow
def test_the_least_film_grows_with_viscosity_and_falls_with_clearance_and_speed():
    def least(viscosity=0.4, clearance="0.5 mm", speed="3000 rpm"):
        changes = {"film.viscosity": viscosity, "clearance": clearance}
        changes = {f"joints.rod-slider.{key}": value for key, value in changes.items()} | {"drive.speed": speed}
        source = a_crank({**changes, "simulate.revolutions": 3, "simulate.discard": 1})
        return clearsweep.simulate(clearsweep.load_case(source)).summary["rod_slider_film_thickness_min"]

    assert least(viscosity=0.1) < least() < least(viscosity=0.8)
    assert least() < least(clearance="0.3 mm")
    assert least(speed="5000 rpm") < least() < least(speed="1000 rpm")


@pytest.mark.slow
def test_bodies_that_come_to_rest_in_oil_say_so():
    source = {
        "mechanism": {"type": "impact-pair", "masses": ["0.2 kg", "0.2 kg"], "speed": "1 m/s"},
        "joints": {
            "pair": {
                **{"clearance": "0.5 mm", "bearing_radius": "10 mm", "length": "20 mm"},
                "film": {"law": "short", "viscosity": "0.1 Pa*s"},
                "contact": {"law": "hertz", "stiffness": "1e9 N/m^1.5"},
            }
        },
        "simulate": {"impacts": 3, "tolerance": 1e-5},
    }
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "at-rest"
    assert "reduce it" in path.message
