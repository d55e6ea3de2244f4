"""Every couple with every law of a film: moments that balance, and a loss that is the flow's and the shear's."""

import itertools
import math

import numpy as np
import pytest
from film_oracle import solution
from law_cases import RECIPES, names

from clearsweep.contracts.case import NO_CONTACT, Film, Joint
from clearsweep.mechanics.joints import lubricated, registry
from clearsweep.mechanics.joints.dry import Gap
from clearsweep.mechanics.laws.film import FilmMotion, film_couples

LAWS, SHEARS = names("film"), names("film-friction")
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


MOTIONS = [
    gap_of(*motion, bearing, around)
    for motion, bearing, around in itertools.product(
        itertools.product((0.05, 0.4, 0.8, 0.97), (-900.0, -60.0, 0.0, 40.0, 700.0), (-300.0, 0.0, 120.0)),
        (-40.0, 0.0),
        (-30.0, 90.0),
    )
]
GAP = MOTIONS[77]


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
        for gap in MOTIONS:
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
    for gap in MOTIONS[::7]:
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
    for gap in MOTIONS:
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
