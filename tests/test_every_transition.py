"""What every transition from film to dry contact must do, whichever recipes there are; kernels run as Python."""

import math

import numpy as np
import pytest
from law_cases import RECIPES, names, numbers
from mechanism_cases import JOINT

from clearsweep.contracts.case import Contact, Film, Joint, Material, Materials
from clearsweep.mechanics.joints import dry, lubricated, registry
from clearsweep.mechanics.joints.contract import JointState, contact_modes, every_latched, first_offsets, load
from clearsweep.mechanics.laws.film import asperity_load, dry_fraction, transition_depths

CLEARANCE, RADIUS, ONSET = 50e-6, 0.01, 0.05  # m, m, m/s
BEGIN, WIDTH = 0.5e-6, 2e-6  # m
STEEL = Materials(*2 * (Material(207e9, 0.3),))


def case_of(name, viscosity=0.02, restitution=0.7):
    """Return a joint of a case with a film, a dry contact behind it and this transition between them."""
    fields = [field for field in RECIPES["transition", name].law.fields if not field.optional]
    values = numbers(RECIPES["transition", name].law._replace(fields=fields)) | {"roughness": 0.4e-6}
    film = Film("short", "butenschoen", viscosity, 0.99, transition=name, begin=BEGIN, width=WIDTH, asperities=values)
    contact = Contact("exact", "power", {"stiffness": 6.61e10, "exponent": 1.5, "restitution": restitution}, STEEL)
    return Joint("rod-slider", CLEARANCE, contact, RADIUS, JOINT["length"], film=film)


def load_at(term, gap, depth):
    """Return the Load of a lubricated joint at a depth (m) of its Gap; it is in contact where that is above 0."""
    (modes,) = contact_modes(term)
    mode = modes.pressed if depth > 0.0 else modes.apart
    latched = np.array([ONSET, *(began for _, began in every_latched((term,)))])
    present = JointState(np.array([math.sqrt(max(depth, 0.0))]), np.array([mode]), latched, 0)
    return load(term, gap, first_offsets((term,), 0), present)


def gap_at(depth, angle, moving):
    """Return the Gap with the journal at a depth (m) and an angle (rad); moving : rates of both, and two spins."""
    rate, angle_rate, bearing, journal = moving
    e, n, t = CLEARANCE + depth, (math.cos(angle), math.sin(angle)), (-math.sin(angle), math.cos(angle))
    velocity = (rate * n[i] + e * angle_rate * t[i] for i in range(2))
    return dry.Gap(e * n[0], e * n[1], *velocity, bearing, journal)


def power_of(term, depth, angle, moving):
    """Return the power (W) of the forces and couples of the joint on its bodies."""
    gap = gap_at(depth, angle, moving)
    acting = load_at(term, gap, depth)
    translating = acting.fx * gap.vx + acting.fy * gap.vy
    return translating + acting.moment_proximal * gap.spin_proximal + acting.moment_distal * gap.spin_distal


DEPTHS = np.linspace(-4e-6, 5e-6, 901)


@pytest.mark.parametrize("name", names("transition"))
def test_the_dry_share_grows_from_zero_to_one_between_its_bounds(name):
    term = RECIPES["transition", name].make(case_of(name))
    low, high = transition_depths(term)
    shares = np.array([dry_fraction(term, depth) for depth in DEPTHS])
    assert np.all(shares[low > DEPTHS] == 0.0)
    assert np.all(shares[high < DEPTHS] == 1.0)
    assert np.all(np.diff(shares) >= 0.0)
    between = shares[(low + 1e-9 < DEPTHS) & (high - 1e-9 > DEPTHS)]
    assert 0.0 < between[0] < 0.05
    assert 0.95 < between[-1] < 1.0
    assert np.all(np.diff(between) > 0.0)
    assert np.diff(shares).max() < 0.05  # no jump: 1e-8 m are 0.005 of the width
    assert (low, high) == pytest.approx((BEGIN, BEGIN + WIDTH), rel=1e-12, abs=0.0)


@pytest.mark.parametrize("name", names("transition"))
def test_asperities_push_the_surfaces_apart_and_harder_the_closer_they_are(name):
    term = RECIPES["transition", name].make(case_of(name))
    loads = np.array([asperity_load(term, depth) for depth in DEPTHS])
    assert np.all(np.diff(loads) >= 0.0)
    assert loads[0] == 0.0
    assert np.diff(loads).max() <= 0.03 * max(loads[-1], 1e-30)


@pytest.mark.few("moving1-ramp", "moving1-greenwood-tripp")
@pytest.mark.parametrize("name", names("transition"))
@pytest.mark.parametrize("moving", [(0.03, 2.0, 40.0, -60.0), (-0.02, -30.0, 0.0, 300.0), (0.0, 5.0, 0.0, 100.0)])
def test_the_force_passes_continuously_from_the_film_to_the_dry_contact(name, moving):
    """Half the distance between two depths halves the largest jump of the force."""
    term = registry.compile_joint(case_of(name), "slider")
    jumps = []
    for count in (1200, 2400):
        result = [load_at(term, gap_at(d, 0.7, moving), d) for d in np.linspace(-4e-6, 5e-6, count)]
        forces = np.array([(first.fx, first.fy, first.moment_proximal, first.moment_distal) for first in result])
        jumps.append(np.abs(np.diff(forces, axis=0)).max(axis=0))
    assert np.all(jumps[1] <= 0.6 * jumps[0] + 1e-12)
    film = lubricated.Film(**{key: value for key, value in term._asdict().items() if key in lubricated.Film._fields})
    hard = dry.Joint(**{key: value for key, value in term._asdict().items() if key in dry.Joint._fields})
    low, high = transition_depths(term.transition)
    for depth, alone in ((-4e-6, film), (high + 1e-6, hard)):
        gap = gap_at(depth, 0.7, moving)
        expected = load_at(alone, gap, depth)
        assert load_at(term, gap, depth)[:4] == pytest.approx(expected[:4], rel=1e-12, abs=1e-15)
    middle = 0.5 * (low + high)
    gap, share = gap_at(middle, 0.7, moving), dry_fraction(term.transition, middle)
    borne = asperity_load(term.transition, middle)
    mixed = np.array(load_at(film, gap, -1.0)[:4]) * (1.0 - share)
    mixed += np.array(load_at(hard, gap, middle)[:4]) * share
    mixed[:2] -= (1.0 - share) * borne * np.array([math.cos(0.7), math.sin(0.7)])
    assert load_at(term, gap, middle)[:4] == pytest.approx(mixed, rel=1e-12)


def work_around(term, spins):
    """Return the work (J) of the joint on its bodies while the journal is pressed in and drawn out once, and its size.

    Simpson's rule over half a sine of the time: 3 um deep at its middle, 4 um away from contact at its ends.
    """
    duration, count = 2e-3, 8001
    t = np.linspace(0.0, duration, count)
    swing = math.pi / duration
    depth, rate = -4e-6 + 7e-6 * np.sin(swing * t), 7e-6 * swing * np.cos(swing * t)
    powers = np.array([power_of(term, d, 0.7, (v, 0.0, *spins)) for d, v in zip(depth, rate, strict=True)])
    weights = np.full(count, 2.0)
    weights[1::2], weights[0], weights[-1] = 4.0, 1.0, 1.0
    weights *= duration / (3.0 * (count - 1))
    return weights @ powers, weights @ np.abs(powers)


@pytest.mark.parametrize("name", names("transition"))
def test_a_transition_alone_takes_and_gives_no_energy(name):
    """With hardly any oil and lossless contact what is left is elastic, and comes back."""
    work, size = work_around(
        registry.compile_joint(case_of(name, viscosity=1e-18, restitution=1.0), "slider"), (0.0, 0.0)
    )
    assert size > 1e-4
    assert abs(work) < 1e-9 * size


@pytest.mark.few("spins1-ramp", "spins1-greenwood-tripp")
@pytest.mark.parametrize("name", names("transition"))
@pytest.mark.parametrize("spins", [(0.0, 0.0), (100.0, -30.0), (0.0, 300.0)])
def test_a_joint_in_transition_takes_energy_from_its_bodies(name, spins):
    """Pressed in and drawn out once, at rest and while both bodies turn."""
    work, size = work_around(registry.compile_joint(case_of(name), "slider"), spins)
    assert work < -1e-3 * size


@pytest.mark.parametrize("name", names("transition"))
def test_the_loss_of_a_joint_in_transition_is_never_negative(name):
    term, rng = registry.compile_joint(case_of(name), "slider"), np.random.default_rng(5)
    for _ in range(300):
        depth, rate = rng.uniform(-4e-6, 5e-6), rng.uniform(-0.04, 0.04)
        moving = (rate, rng.normal(0.0, 50.0), *rng.normal(0.0, 100.0, 2))
        contact = load_at(term, gap_at(depth, 0.7, moving), depth).contacts[0]
        taken = -power_of(term, depth, 0.7, moving) - contact.elastic * rate
        assert taken >= -1e-9 * abs(contact.elastic * rate)
