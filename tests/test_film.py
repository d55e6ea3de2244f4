"""Films of oil: each law against closed forms and quadrature of its own pressure, then motions with films."""

import itertools
import json
import math
from importlib import resources

import numpy as np
import pytest
from film_oracle import solution
from law_cases import RECIPES, names
from mechanism_cases import changed, slider_crank
from right_grids import grid_of

import clearsweep
from clearsweep import simulation
from clearsweep.answers import validity
from clearsweep.contracts.case import NO_CONTACT, Film, Joint
from clearsweep.language.errors import InputError
from clearsweep.mechanics.joints import lubricated, registry
from clearsweep.mechanics.joints.dry import Gap
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
        highest = fine[pressure_at(form, motion, np.cos(fine), np.sin(fine)).argmax()]
        fine = highest + (fine[1] - fine[0]) * np.linspace(-1.0, 1.0, 2001)
        assert film_pressure(form, motion) == pytest.approx(
            pressure_at(form, motion, np.cos(fine), np.sin(fine)).max(), rel=1e-9
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
    source = a_crank({"joints.rod-slider.film": film, "simulate.revolutions": 8, "simulate.discard": 1})
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
    path = clearsweep.simulate(clearsweep.load_case(grid_of("two bodies that come to rest in oil")))
    assert path.status == "at-rest"
    assert "reduce it" in path.message


# ---------------------------------------------------------------------------------------------- the balance of a film


BALANCED = [name for name in SHEARS if name != "none"]
PASSIVE = ("reynolds", "short", "long")  # at any motion
CLEARANCE, RADIUS, LENGTH, VISCOSITY = 5e-4, 0.02, 0.04, 0.4


def film_of(law, friction, journal=None):
    """Return the compiled joint with a film and nothing behind it."""
    film = Film(law=law, friction=friction, viscosity=VISCOSITY, limit=0.99)
    joint = Joint("rod-slider", CLEARANCE, NO_CONTACT, RADIUS, LENGTH, journal, film=film)
    return registry.compile_joint(joint, "slider")


def gap_of(ratio, squeeze_rate, spin, bearing=-40.0, around=0.0, angle=0.7):
    """Return the Gap of a ratio, its rate, and the effective spin.

    closing : 1/s; spin : rad/s; bearing : rad/s, its own spin; around : rad/s, that of the line of centres.
    """
    x, y = ratio * CLEARANCE * math.cos(angle), ratio * CLEARANCE * math.sin(angle)
    grows = CLEARANCE * squeeze_rate
    vx, vy = grows * math.cos(angle) - around * y, grows * math.sin(angle) + around * x
    return Gap(x, y, vx, vy, bearing, spin - bearing + 2.0 * around)


GAPS = [
    gap_of(*motion, bearing, around)
    for motion, bearing, around in itertools.product(
        itertools.product((0.05, 0.4, 0.8, 0.97), (-900.0, -60.0, 0.0, 40.0, 700.0), (-300.0, 0.0, 120.0)),
        (-40.0, 0.0),
        (-30.0, 90.0),
    )
]
GAP = GAPS[77]


def spun(gap, rate):
    """Return the Gap with a rotation of everything at `rate` (rad/s) added, its velocities and spins with it."""
    return Gap(
        gap.x, gap.y, gap.vx - rate * gap.y, gap.vy + rate * gap.x, gap.spin_proximal + rate, gap.spin_distal + rate
    )


# ---------------------------------------------------------------------------------------------- moments


@pytest.mark.parametrize(("name", "friction"), [*itertools.product(LAWS, BALANCED)])
def test_the_couples_of_a_film_and_the_moment_of_its_force_add_up_to_nothing(name, friction):
    for journal in (None, "rod"):
        term = film_of(name, friction, journal)
        for gap in GAPS:
            film = lubricated.film_load(term, gap)
            moment = math.hypot(gap.x, gap.y) * film.tangential
            size = abs(film.journal_couple) + abs(film.bearing_couple) + abs(moment)
            assert film.journal_couple + film.bearing_couple == pytest.approx(-moment, rel=0.0, abs=1e-14 * size)
            load = lubricated.film_only_load(term, film, 0.0)  # about the proximal centre, all that acts on both bodies
            whole = load.moment_proximal + load.moment_distal + gap.x * load.fy - gap.y * load.fx
            size += math.hypot(gap.x, gap.y) * abs(film.radial)
            assert whole == pytest.approx(0.0, abs=1e-13 * size)


@pytest.mark.parametrize("name", LAWS)
def test_by_law_and_butenschoen_are_the_same_couple_and_none_is_no_couple(name):
    for gap in GAPS[::7]:
        assert lubricated.film_load(film_of(name, "by-law"), gap) == lubricated.film_load(
            film_of(name, "butenschoen"), gap
        )
        film = lubricated.film_load(film_of(name, "none"), gap)
        assert (film.journal_couple, film.bearing_couple) == (0.0, 0.0)


def test_sommerfelds_couple_beside_his_full_film_is_the_published_one():
    """4 pi mu R^3 L w (1 + 2 eps^2) / (c (2 + eps^2) sqrt(1 - eps^2)) on the journal of a bearing at rest."""
    angle_rate, size = 80.0, math.pi * VISCOSITY * RADIUS**3 * LENGTH / CLEARANCE
    shear = RECIPES["film-friction", "sommerfeld"].make(
        Joint("a", CLEARANCE, NO_CONTACT, RADIUS, LENGTH, film=Film("long", "sommerfeld", VISCOSITY, 0.99))
    )
    for ratio in (0.0, 0.3, 0.9):
        under = (2.0 + ratio**2) * math.sqrt(1.0 - ratio**2)
        moment = 12.0 * size * angle_rate * ratio**2 / under  # e F_t of the full film
        motion = FilmMotion(ratio, 0.0, angle_rate)
        journal, bearing = film_couples(shear, motion, angle_rate, moment)
        assert journal == pytest.approx(-4.0 * size * angle_rate * (1.0 + 2.0 * ratio**2) / under, rel=1e-12)
        assert bearing == pytest.approx(4.0 * size * angle_rate * (1.0 - ratio**2) / under, rel=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_a_rotation_of_everything_changes_no_force_no_shear_and_no_loss(name):
    for journal, friction in itertools.product((None, "rod"), SHEARS):
        term = film_of(name, friction, journal)
        still, turned = (lubricated.film_load(term, gap) for gap in (GAP, spun(GAP, 314.0)))
        for field in (
            "radial",
            "tangential",
            "journal_couple",
            "bearing_couple",
            *(["lost_power"] if friction != "none" else []),
        ):
            assert getattr(turned, field) == pytest.approx(getattr(still, field), rel=1e-10)


@pytest.mark.parametrize("name", LAWS)
def test_what_a_film_takes_is_what_its_forces_do_to_both_bodies(name):
    for journal, friction in itertools.product((None, "rod"), SHEARS):
        term = film_of(name, friction, journal)
        film = lubricated.film_load(term, GAP)
        load = lubricated.film_only_load(term, film, 0.0)
        power = load.fx * GAP.vx + load.fy * GAP.vy
        power += load.moment_proximal * GAP.spin_proximal + load.moment_distal * GAP.spin_distal
        assert film.lost_power == pytest.approx(-power, rel=1e-12)


# ---------------------------------------------------------------------------------------------- power


@pytest.mark.parametrize(("name", "friction"), [*itertools.product(PASSIVE, BALANCED)])
def test_a_film_takes_energy_at_any_motion(name, friction):
    term = film_of(name, friction)
    for gap in GAPS:
        film = lubricated.film_load(term, gap)
        assert film.pressure_power >= 0.0
        assert film.lost_power >= film.pressure_power


@pytest.mark.parametrize(("name", "friction"), [*itertools.product(LAWS, BALANCED)])
def test_a_film_that_only_turns_or_only_is_squeezed_takes_energy(name, friction):
    term = film_of(name, friction)
    for ratio, squeeze_rate in itertools.product((0.05, 0.4, 0.8, 0.97), (-300.0, 0.0, 300.0)):
        film = lubricated.film_load(term, gap_of(ratio, squeeze_rate, 0.0 if squeeze_rate else 200.0))
        assert film.pressure_power > 0.0
        assert film.lost_power >= film.pressure_power


def test_an_opening_finite_film_feeds_energy_in_and_that_of_reynolds_does_not():
    """What its notes say of it, and why there is the law `reynolds`."""
    gap = gap_of(0.9, -150.0, 300.0)
    assert lubricated.film_load(film_of("finite", "butenschoen"), gap).pressure_power < 0.0
    assert lubricated.film_load(film_of("reynolds", "butenschoen"), gap).pressure_power > 0.0


def arc(start):
    """Return angles and weights of Gauss's rule over the half circle from `start`."""
    x, weights = np.polynomial.legendre.leggauss(200)
    return start + 0.5 * math.pi * (x + 1.0), 0.5 * math.pi * weights


def flow_of_short(ratio, squeeze, wedge):
    """Return h^3 / (12 mu) (dp/dz)^2 over the film under pressure, p = 3 mu (L^2 / 4 - z^2) f / (c^2 H^3)."""
    angles, weights = arc(math.atan2(squeeze, wedge))
    source = wedge * np.sin(angles) - squeeze * np.cos(angles)
    around = float(weights @ (source**2 / (1.0 + ratio * np.cos(angles)) ** 3))
    return 3.0 * VISCOSITY / CLEARANCE * LENGTH**3 / 12.0 * RADIUS * around


def flow_of_long(ratio, squeeze, wedge):
    """Return h^3 / (12 mu R^2) (dp/dtheta)^2 over the arc at whose ends the pressure is 0."""
    angles, weights = arc(math.atan2(0.5 * squeeze * (2.0 + ratio**2), wedge))
    cubed = (1.0 + ratio * np.cos(angles)) ** 3
    drawn = wedge * np.cos(angles) + squeeze * np.sin(angles)
    flow = drawn - (weights @ (drawn / cubed)) / (weights @ (1.0 / cubed))
    slopes = 6.0 * VISCOSITY * RADIUS**2 / CLEARANCE**2 * flow / cubed
    return CLEARANCE**3 / (12.0 * VISCOSITY * RADIUS) * LENGTH * float(weights @ (cubed * slopes**2))


def flow_of_reynolds(ratio, squeeze, wedge):
    """Return the same in two dimensions: a(p, p) of the second solver."""
    done = solution(0.5 * LENGTH / RADIUS, ratio, squeeze, wedge, (96, 6))[2]
    return 1.5 * CLEARANCE * 2.0 * LENGTH * RADIUS * VISCOSITY * (RADIUS / CLEARANCE) ** 2 * done


FLOWS = {"short": (flow_of_short, 1e-9), "long": (flow_of_long, 1e-9), "reynolds": (flow_of_reynolds, 2e-3)}


@pytest.mark.few("reynolds")
@pytest.mark.parametrize("name", FLOWS)
def test_the_loss_of_a_film_is_the_quadrature_of_its_flow_and_its_shear(name):
    flow_of, tolerance = FLOWS[name]
    for ratio, squeeze_rate, spin in itertools.product((0.1, 0.6, 0.9), (-90.0, 0.0, 50.0), (-120.0, 250.0)):
        gap = gap_of(ratio, squeeze_rate, spin, bearing=15.0, around=40.0)
        film = lubricated.film_load(film_of(name, "butenschoen"), gap)
        flow = flow_of(ratio, 2.0 * squeeze_rate, spin * ratio)
        angles = 2.0 * math.pi * np.arange(400) / 400.0
        speed = RADIUS * (gap.spin_distal - gap.spin_proximal)
        thickness = CLEARANCE * (1.0 + ratio * np.cos(angles))
        shear = float((VISCOSITY * speed**2 / thickness).sum()) * 2.0 * math.pi / 400.0 * RADIUS * LENGTH
        assert film.pressure_power == pytest.approx(flow, rel=tolerance)
        assert film.lost_power == pytest.approx(flow + shear, rel=tolerance)
