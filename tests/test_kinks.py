"""Where the formula of a law changes, a step ends: laws declare all their kinks, and none costs accuracy."""

import itertools
import json
import math
from importlib import resources
from types import SimpleNamespace

import numpy as np
import pytest
from law_cases import RECIPES, joint, names, numbers, written
from mechanism_cases import slider_crank
from numpy.polynomial import chebyshev
from scipy.optimize import brentq
from test_film import oiled

import clearsweep
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.contract import Contact, JointState, Offsets, guard_quantity, load, parts
from clearsweep.mechanics.joints.dry import Gap
from clearsweep.mechanics.laws.contract import StepStart, guard_values, guards, internal_rates, kink_variable, kinks
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.film import AFLOAT, FilmMotion, Reversals, film_force, has_reversal_corners
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.laws.loss import contact_force
from clearsweep.simulation.running.run import integration_of
from clearsweep.verify import extremes, stability

MACHINES = resources.files("clearsweep.verify") / "references" / "machines.json"

# ---------------------------------------------------------------------------------------------- all are declared


def distance_from_polynomials(function, low, high, parts=40, degree=24):
    """Return how far a function is from polynomials on parts of an interval, over its size there."""
    edges, worst, nodes = np.linspace(low, high, parts + 1), 0.0, np.cos(np.pi * (np.arange(25) + 0.5) / 25)
    size = max(abs(function(x)) for x in np.linspace(low, high, 50)) or 1.0
    for a, b in itertools.pairwise(edges):
        series = chebyshev.chebfit(nodes, [function(a + 0.5 * (b - a) * (1.0 + u)) for u in nodes], degree)
        worst = max(worst, np.abs(series[-3:]).max() / size)
    return worst


def is_smooth_between(function, places, low, high):
    """Return whether a function is smooth on an interval between some places."""
    edges, away = [low, *(x for x in places if low < x < high), high], 1e-9 * (high - low)
    pairs = itertools.pairwise(edges)
    return all(distance_from_polynomials(function, a + away, b - away) < 1e-11 for a, b in pairs)


def test_the_check_sees_a_kink_of_the_second_derivative():
    def bent(x):
        return math.sin(3.0 * x) + abs(x - 0.1234) ** 3

    assert is_smooth_between(lambda x: math.sin(3.0 * x), [], -1.0, 1.0)
    assert not is_smooth_between(bent, [], -1.0, 1.0)
    assert is_smooth_between(bent, [0.1234], -1.0, 1.0)


def seen(slip):
    return Contact(normal=1.0, tangential=0.0, slip=slip, rate=0.0, depth=1e-6, elastic=1.0, raw=1.0)


@pytest.mark.parametrize("name", names("friction"))
def test_friction_is_smooth_over_the_sliding_speed_between_its_kinks(name):
    """Karnopp slides to a latched side; the band in which it sticks and its static limit are events of their own."""
    friction = registry.compile_joint(joint(friction=name), "slider").friction
    friction = friction._replace(sliding_sign=1.0) if name == "karnopp" else friction
    scales = [value for value in numbers(RECIPES["friction", name].law).values() if value < 0.1]
    places = kinks(friction) if type(friction) in kinks.members else ()
    for scale in scales:
        for low, high in ((-5.0 * scale, 5.0 * scale), (-0.3 * scale, 0.4 * scale)):
            assert is_smooth_between(lambda slip: friction_force(friction, 1.0, slip), places, low, high)
            for i in range(len(internal_rates(friction, seen(0.0)))):
                assert is_smooth_between(lambda slip, i=i: internal_rates(friction, seen(slip))[i], places, low, high)


def bends_at_guards(friction, slip, bends):
    """Return the bends at which a step with this sliding speed ends that begins at a smaller one of `bends`."""

    def values(bend, start):
        before = StepStart(friction._replace(bend=start), seen(slip))
        return np.array(guard_values(friction._replace(bend=bend), before, seen(slip), 0.0))

    return [
        brentq(lambda bend, a=a, i=i: values(bend, a)[i], a, b, xtol=1e-18)
        for a, b in itertools.pairwise(bends)
        for i in np.flatnonzero((values(a, a) < 0.0) & (values(b, a) > 0.0) & np.isfinite(values(b, a)))
    ]


@pytest.mark.parametrize("name", ["dahl", "lugre", "elasto-plastic"])
@pytest.mark.parametrize("slip", [-0.02, 0.0004, 0.02])
def test_the_rate_of_bristles_is_smooth_over_their_bend_between_their_kinks(name, slip):
    friction = registry.compile_joint(joint(friction=name), "slider").friction
    largest = 1.5 * max(friction.coefficient, getattr(friction, "static_coefficient", 0.0)) / friction.bristle_stiffness

    def rate(bend):
        return internal_rates(friction._replace(bend=bend), seen(slip))[0]

    assert is_smooth_between(
        rate, bends_at_guards(friction, slip, np.linspace(-largest, largest, 60)), -largest, largest
    )


@pytest.mark.parametrize("name", names("law"))
def test_the_loss_is_smooth_over_rate_and_penetration_between_its_kinks(name):
    dry = registry.compile_joint(joint(law=name), "slider")
    law, places, over = dry.law, (), ""
    if type(law) in kinks.members:
        places = kinks(law)
        over = kink_variable.body_of(law).__name__
    pen, onset = 1e-5, 0.1

    def by_rate(rate):
        return contact_force(law, dry.elastic, pen, rate, onset)[0]

    def by_root(root):
        return contact_force(law, dry.elastic, root * root, 0.05, onset)[0]

    assert is_smooth_between(by_rate, places if over == "rate_variable" else (), -0.3, 0.4)
    depths = places if over in ("penetration_variable", "depth_variable") else ()
    for deepest in (1e-5, *(2.0 * place for place in depths)):
        roots = [math.sqrt(place) for place in depths]
        assert is_smooth_between(by_root, roots, 0.01 * math.sqrt(deepest), math.sqrt(deepest))


@pytest.mark.parametrize("name", [name for name in names("elastic") if name != "pereira"])
def test_an_elastic_law_is_smooth_over_the_penetration_but_at_its_limit(name):
    made = joint(elastic=name)
    term, limit = registry.compile_contact(made)[1], RECIPES["elastic", name].limit(made)
    end = math.sqrt(limit if limit < math.inf else 1e-4)
    assert is_smooth_between(lambda root: elastic_force(term, root * root), [end], 0.3 * end, 1.3 * end)


@pytest.mark.parametrize("name", names("film"))
def test_a_film_is_smooth_over_rate_and_spin_but_at_declared_signs(name):
    film = registry.compile_joint(oiled(name), "slider").film
    places = [0.0] if type(film) in has_reversal_corners.members else []
    for i in range(2):  # the radial and the tangential force
        for ratio in (0.3, 0.9):
            assert is_smooth_between(
                lambda x, i=i, e=ratio: film_force(film, FilmMotion(e, x, 7.0))[i], places, -3.0, 4.0
            )
            assert is_smooth_between(
                lambda x, i=i, e=ratio: film_force(film, FilmMotion(e, 2.0, x))[i], places, -30.0, 40.0
            )


# ---------------------------------------------------------------------------------------------- none costs accuracy

#: Numbers with which the motion comes to the kinks, where those of `law_cases` are not of that size.
REACHED = {
    "adams-impact": {"depth": 2e-6},
    "bengisu-akay": {"velocity_scale": 0.05},
    "threlfall": {"velocity_scale": 0.05},
    "stribeck": {"shape": 1.0},
}


def has_guards(family, name):
    """Return whether contacts with a law end steps at something that it declares."""
    term = registry.compile_joint(joint(**{family: name}), "slider")
    return type(term.law if family == "law" else term.friction) in guards.members


DECLARING = [(family, name) for family in ("friction", "law") for name in names(family) if has_guards(family, name)]


def scene(tolerance, *, soft=False, **laws):
    """Return the scene of a slider-crank whose surfaces slide back and forth and knock; of rubber, if `soft`."""
    changes = {f"joints.rod-slider.{key}": value for key, value in written(**laws).items()}
    changes |= {"drive.speed": "600 rpm", "simulate.revolutions": 0.5, "simulate.tolerance": tolerance}
    if soft:
        changes["joints.rod-slider.contact"]["material"] = {"young": 3e5, "poisson": 0.3}
    changes |= {"simulate.discard": 0, "simulate.method": "explicit", "save.orbits": "none"}
    return clearsweep.load_case(slider_crank("rod-slider", changes=changes))


def ends(tolerance, **laws):
    """Return where the motion ends, the coordinates over their size, and how many guards and limits were passed."""
    made = scene(tolerance, **laws)
    run = integration_of(made, np.empty(0), 0.05)
    many = len(made.value.coordinates)
    return run.work.end[:many] / 0.1, run.work.counts.passages, run.work.counts.steps


MOST = 300.0  # errors over the tolerance, which impacts amplify


def check_accuracy(**laws):
    """Check that errors follow the tolerance, and that steps grow in number as those of a method of high order.

    The truth is the median of several runs, as a single one may be inaccurate by chance.
    """
    runs = [ends(tolerance, **laws) for tolerance in (1e-13, 1.3e-13, 1.7e-13, 2.2e-13, 3e-13)]
    assert all(passed > 0 for _, passed, _ in runs)
    exact = np.median([end for end, _, _ in runs], axis=0)
    matches = {tolerance: ends(tolerance, **laws) for tolerance in (1e-6, 1e-9, 1e-12)}
    errors = {tolerance: np.abs(end - exact).max() for tolerance, (end, _, _) in matches.items()}
    assert all(error < MOST * tolerance for tolerance, error in errors.items()), errors
    steps = [count for _, _, count in matches.values()]
    assert max(steps) < 8.0 * min(steps), steps  # 10^(6/8) = 5.6


@pytest.mark.few("friction-ambrosio", "friction-lugre", "law-adams-impact")
@pytest.mark.compiled
@pytest.mark.parametrize(("family", "name"), DECLARING)
def test_no_kink_of_a_law_costs_accuracy(family, name):
    check_accuracy(**{family: name}, **REACHED.get(name, {}))


@pytest.mark.compiled
def test_the_end_of_an_elastic_law_costs_no_accuracy():
    """Persson's pads, soft enough that the journal passes the depth beyond which their law goes on straight."""
    check_accuracy(elastic="persson", soft=True)


@pytest.mark.slow
@pytest.mark.compiled
def test_a_film_that_turns_within_the_reach_of_its_dry_joint_costs_no_accuracy():
    """A trajectory in quadruple precision; where the journal turns in thin oil, the squeeze is stiff.

    Each tolerance has neighbours: one run alone may be accurate by luck.
    """
    problem = json.loads(MACHINES.read_text(encoding="utf-8"))["problems"]["sc_film_dry"]
    truth = {name: np.array(problem["samples"][f"joints/rod_slider/{name}"]) for name in "xy"}

    def error(tolerance):
        grid = problem["grid"] | {"simulate": problem["grid"]["simulate"] | {"tolerance": tolerance}}
        path = clearsweep.simulate(clearsweep.load_case(grid), times=np.array(problem["samples"]["t"]))
        return max(np.abs(path[f"joints/rod_slider/{name}"] - values).max() for name, values in truth.items())

    for tolerance in (1e-8, 1e-9, 1e-10, 1e-12):
        errors = {factor: error(factor * tolerance) for factor in (2.0, 1.6, 1.3, 1.0, 0.8, 0.7, 0.5)}
        assert np.median(list(errors.values())) < max(5e-4 * tolerance, 5e-13)  # m; the clearance is 0.5 mm
        for factor, largest in errors.items():
            assert largest < max(1e-3 * factor * tolerance, 1.5e-12)  # impacts amplify rounding


def rough_and_oily():
    """Return a joint whose rough surfaces rub through the film `finite`."""
    film = {"law": "finite", "viscosity": 0.002, "transition": {"law": "greenwood-tripp", "roughness": 2e-5}}
    contact = {"law": "hertz", "elastic": "johnson", "material": {"young": 207e9, "poisson": 0.3}}
    written_joint = {"contact": contact, "film": film, "length": 0.02, "friction": written(friction="tanh")["friction"]}
    changes = {f"joints.rod-slider.{key}": value for key, value in written_joint.items()}
    (oily,) = clearsweep.load_case(slider_crank("rod-slider", changes=changes)).value.joints
    return oily


def contact_at(oily, gap):
    """Return the contact of a joint with a film while its surfaces are apart, and its observables for guards."""
    state = JointState(np.zeros(1), np.array([AFLOAT]), np.zeros(1), 0)
    (contact,) = load(oily, gap, Offsets(0, 0, 0, 0), state).contacts
    return contact, SimpleNamespace(depth=contact.depth, rate=contact.rate, guard_quantity=guard_quantity(contact))


def test_the_spin_of_a_film_is_a_kink_whatever_its_asperities_rub():
    """At a spin of 0 the film has no tangential force, but friction of asperities has one."""
    oily = rough_and_oily()
    eccentricity = oily.clearance - 1e-5

    def contact_with(spin):
        return contact_at(oily, Gap(eccentricity, 0.0, 1e-3, 0.5 * eccentricity * (10.0 - spin), 10.0, 0.0))

    (reversals,) = [part.law for part in parts(oily) if isinstance(part.law, Reversals)]
    square = (eccentricity / oily.clearance) ** 2
    for spin in (-2.0, 2.0):
        _, start = contact_with(spin)
        rubs, at_rest = contact_with(0.0)
        assert abs(rubs.tangential) > 1.0
        assert guard_values(reversals, StepStart(reversals, start), at_rest, 0.0)[
            2 if spin < 0.0 else 3
        ] == pytest.approx(0.0, abs=1e-12)
        assert guard_values(reversals, StepStart(reversals, start), start, 0.0)[
            2 if spin < 0.0 else 3
        ] == pytest.approx(-abs(spin) * square)


@pytest.mark.parametrize("distance", [1e-6, 1e-3, 0.3])
def test_the_guard_of_a_spin_is_smooth_close_to_the_centre(distance):
    """The spin itself grows like the reciprocal of the eccentricity, so no polynomial over a step describes it."""
    oily = rough_and_oily()
    scale = 0.2 * oily.clearance

    def value(x):
        gap = Gap(scale * x, scale * distance, scale * 5.0, scale * (3.0 + 4.0 * x), 10.0, 0.0)
        return contact_at(oily, gap)[1].guard_quantity

    assert value(-1.0) * value(1.0) < 0.0  # its zero is on the path
    assert distance_from_polynomials(value, -1.0, 1.0, parts=1) < 1e-13


@pytest.mark.slow
@pytest.mark.compiled
def test_a_journal_that_starts_at_the_centre_of_a_film_leaves_it_in_few_steps():
    """In thin oil it moves by 1e-15 m in the first picosecond; it once stayed there for two million steps."""
    (thin,) = [case for case in extremes.film_cases() if case.name.startswith("mixed film/06 finite")]
    row = stability.run_case(thin)
    assert (row["status"], row["failure"]) == ("ok", "")
    assert row["steps"] < 20_000


if __name__ == "__main__":
    for family, name in DECLARING:
        given = {family: name} | REACHED.get(name, {})
        exact, passed, _ = ends(1e-13, **given)
        rows = [ends(tolerance, **given) for tolerance in (1e-6, 1e-9, 1e-12)]
        print(name, passed, *[f"{np.abs(end - exact).max():.1e}/{steps}" for end, _, steps in rows], flush=True)
