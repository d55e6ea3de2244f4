"""Contacts that last: how long the rate of the onset counts, what takes its place, and that the start is forgotten."""

import copy
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml
from law_cases import RECIPES, joint, names
from mechanism_cases import PAIR, changed, slider_crank
from scipy.integrate import quad, solve_ivp

import clearsweep
from clearsweep import grid
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.contract import ENTERED, NEVER, ONSET_FLOOR, StepStart, guard_values, latched, touches
from clearsweep.mechanics.laws.elastic import elastic_energy, elastic_force, power_of
from clearsweep.mechanics.laws.hysteresis import Hysteresis
from clearsweep.mechanics.laws.loss import (
    ENERGY_EXCEEDED,
    RATE_ZERO,
    approach_loss,
    contact_force,
    needs_onset_rate,
    renewed_law,
    with_mass,
)
from clearsweep.mechanics.machines.contract import energy, gaps, impact_masses, pose_at
from clearsweep.mechanics.observe import START, Observed, contact_observables_in
from clearsweep.mechanics.solver import integration
from clearsweep.simulation.analyses.trajectory import simulate
from clearsweep.simulation.running.run import Run, onset_rates
from clearsweep.simulation.setup import scene
from clearsweep.simulation.setup.start import control_of, period, start_of

ROOT = Path(__file__).parent.parent
SITES = {"A": "ground-crank", "B": "crank-rod", "C": "rod-slider"}
CONTACT = "joints.rod-slider.contact"
MASS = 0.1  # kg
KEEPING = [name for name in names("law") if RECIPES["law", name].law.uses_onset]
PEN, RATE = 2e-5, 0.3  # m, m/s


def observed(rate):
    return Observed(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, rate, 0.0)


def lasting(elastic, restitution):
    """Return the compiled form of a law that gives back `restitution`, its contact of MASS lasting."""
    return with_mass(renewed_law(Hysteresis(0.5), elastic, restitution), MASS)


# ---------------------------------------------------------------------------------------------- the law alone


@pytest.mark.parametrize("name", KEEPING)
def test_until_a_contact_lasts_its_law_is_the_published_one(name):
    law, elastic = registry.compile_contact(joint(name))
    impact = renewed_law(law, elastic, 0.25)._replace(doubling_energy=1.0)
    for rate in (-RATE, 0.0, RATE):
        assert contact_force(impact, elastic, PEN, rate, 0.7) == contact_force(law, elastic, PEN, rate, 0.7)


@pytest.mark.parametrize("name", [name for name in KEEPING if name != "pant-wijeyewickrema"])
@pytest.mark.parametrize("asked", [0.02, 0.1, 0.5, 0.9, 0.99])
def test_no_free_impact_comes_near_the_speed_at_which_a_contact_lasts(name, asked):
    chi = registry.compile_contact(joint(name, restitution=asked))[0].factor
    assert math.sqrt(2.0 * approach_loss(chi)) / chi < 1.0  # v / v0 at the deepest point, where 2 is asked for


def test_the_force_does_not_jump_where_the_rule_changes():
    elastic = power_of(6.61e10, 1.5)
    before = lasting(elastic, 0.5)._replace(doubling_energy=elastic_energy(elastic, PEN))
    beyond, at_last = before._replace(doubling_energy=-before.doubling_energy), before._replace(doubling_energy=0.0)
    published = contact_force(before, elastic, PEN, RATE, 0.7)
    assert contact_force(beyond, elastic, PEN, RATE, 0.7) == pytest.approx(published, rel=1e-14)
    for other in (beyond, at_last):
        assert contact_force(other, elastic, PEN, 0.0, 0.7) == contact_force(before, elastic, PEN, 0.0, 0.7)


def test_guards_look_for_the_doubled_speed_then_for_rest():
    elastic = power_of(6.61e10, 1.5)
    (doubling_energy,) = latched(lasting(elastic, 0.5), ENTERED, observed(0.4), 0.0)
    assert doubling_energy == pytest.approx(
        0.5 * MASS * 0.8**2, rel=1e-14
    )  # W where v = sqrt(2 W / m) is twice 0.4 m/s
    falling, rising = observed(-RATE), observed(RATE)
    law = lasting(elastic, 0.5)._replace(doubling_energy=doubling_energy)
    depth = (doubling_energy / (0.4 * 6.61e10)) ** 0.4
    for share, sign in ((0.999, -1.0), (1.001, 1.0)):
        assert sign * guard_values(law, StepStart(law, rising), rising, math.sqrt(share * depth))[ENERGY_EXCEEDED] > 0.0
    assert (
        guard_values(law, StepStart(law, rising), falling, 0.0)[RATE_ZERO] == NEVER
    )  # a deepest point is not looked for
    assert guard_values(law, StepStart(law, falling), rising, 0.0)[RATE_ZERO] == RATE
    pressed = law._replace(doubling_energy=latched(law, ENERGY_EXCEEDED, rising, 0.0)[0])
    assert guard_values(pressed, StepStart(pressed, rising), falling, 0.0) == (NEVER, RATE)
    assert latched(pressed, RATE_ZERO, falling, 0.0) == (0.0,)
    assert guard_values(lasting(elastic, 0.5), StepStart(lasting(elastic, 0.5), falling), rising, 0.0) == (NEVER, NEVER)


@pytest.mark.parametrize("elastic", ["power", "johnson", "liu", "winkler", "persson"])
@pytest.mark.parametrize("asked", [0.1, 0.5, 0.9])
def test_a_lasting_contact_gives_back_what_was_requested(elastic, asked):
    term = registry.compile_contact(joint("exact", elastic))[1]
    law = lasting(term, asked)

    def rates(t, y):
        return [y[1], -contact_force(law, term, max(y[0], 0.0), y[1], 1.0)[0] / MASS]

    def parts(t, y):
        return y[0] if t > 0.0 else 1.0

    parts.terminal, parts.direction = True, -1
    start, stop = [1e-12, 0.1], {"rtol": 1e-10, "atol": 1e-16}
    end = solve_ivp(rates, (0.0, 1.0), start, events=parts, max_step=1e-5, **stop).y[1, -1]
    assert -end / 0.1 == pytest.approx(asked, rel=2e-5)


@pytest.mark.parametrize("name", names("elastic"))
def test_elastic_energy_is_the_integral_of_the_force(name):
    term = registry.compile_contact(joint("exact", name))[1]
    for pen in (1e-7, 1e-5, 2e-4):
        truth = quad(lambda x, p=pen: 2.0 * p * x * elastic_force(term, p * x * x), 0.0, 1.0, epsrel=1e-11)[0]
        assert elastic_energy(term, pen) == pytest.approx(truth, rel=2e-6)


# ---------------------------------------------------------------------------------------------- the mass


def mass_by_energy(mechanism, y, n, j):
    """Return the mass along gap `j` from kinetic energies and rates of the gap alone, both of which are polynomials."""

    def moving(rates):
        state = np.array(y)
        state[n : 2 * n] = rates
        return pose_at(mechanism, state)

    def kinetic(*coordinates):
        return energy(mechanism, moving(sum(np.eye(n)[i] for i in coordinates) if coordinates else np.zeros(n)))[0]

    matrix = np.array(
        [[kinetic(i, k) - kinetic(i) - kinetic(k) + kinetic() for k in range(n)] for i in range(n)]
    )  # of T = q' M q' / 2 + b q' + c
    still = gaps(mechanism, moving(np.zeros(n)))[j]
    normal = np.array([still.x, still.y]) / math.hypot(still.x, still.y)
    rates = [gaps(mechanism, moving(row))[j] for row in np.eye(n)]
    distance = np.array([[gap.vx - still.vx, gap.vy - still.vy] for gap in rates]) @ normal
    return 1.0 / (distance @ np.linalg.solve(matrix, distance))


HOUSING = {"mechanism.mounts": {"ground-crank": {"mass": 0.7, "stiffness": [1e6, 2e6]}}}


@pytest.mark.parametrize(
    ("opening", "housing"),
    [*((opening, {}) for opening in ("A", "B", "C", "AB", "AC", "BC", "ABC")), ("A", HOUSING), ("BC", HOUSING)],
)
def test_masses_of_impacts_are_those_of_the_whole_mass_matrix(opening, housing):
    changes = {"mechanism.rod.center": 0.05, "mechanism.crank.center": 0.02} | housing
    value = clearsweep.load_case(slider_crank(*map(SITES.get, opening), changes=changes)).value
    n = len(value.coordinates)
    y = np.random.default_rng(1).normal(scale=0.3, size=2 * n + 1)
    pose = pose_at(value.mechanism, y)
    masses = impact_masses(value.mechanism, pose, gaps(value.mechanism, pose))
    expected = [mass_by_energy(value.mechanism, y, n, j) for j in range(len(masses))]
    assert masses == pytest.approx(expected, rel=1e-9)


def test_the_mass_of_an_impact_pair_is_the_reduced_one():
    value = clearsweep.load_case(changed(PAIR, {"mechanism.masses": [0.2, 0.3]})).value
    pose = pose_at(value.mechanism, np.array([1e-3, 1.0, 0.0]))
    assert impact_masses(value.mechanism, pose, gaps(value.mechanism, pose)) == (pytest.approx(0.12, rel=1e-15),)


# ---------------------------------------------------------------------------------------------- motions


def crank(onset="renewed", start="centred", **settings):
    """Return the scene of a slider-crank that comes to permanent contact."""
    changes = {
        f"{CONTACT}.onset": onset,
        f"{CONTACT}.stiffness": 1e10,
        f"{CONTACT}.restitution": 0.5,
        "joints.rod-slider.clearance": 5e-5,
        "simulate.start": start,
        "simulate.revolutions": 12,
        "simulate.discard": 8,
    } | {f"simulate.{key}": value for key, value in settings.items()}
    return clearsweep.load_case(slider_crank("rod-slider", changes=changes))


def bounce(onset, law="exact", asked=0.5, **contact):
    contact = {"law": law, "stiffness": 6.61e10, "restitution": asked, "onset": onset} | contact
    return clearsweep.simulate(clearsweep.load_case(changed(PAIR, {"joints.pair.contact": contact}))).summary


@pytest.mark.parametrize("asked", [0.1, 0.5, 0.9])
def test_a_free_impact_gives_back_what_the_law_does(asked):
    assert bounce("renewed", asked=asked)["pair_restitution"] == pytest.approx(asked, abs=1e-9, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", KEEPING)
@pytest.mark.parametrize("contact", [{"exponent": 1.0, "stiffness": 1e8}, {}, {"exponent": 2.0, "stiffness": 1e13}])
def test_free_impacts_of_all_laws_are_as_published(name, contact):
    for asked in (0.1, 0.3, 0.5, 0.7, 0.9, 0.95):
        result = bounce("renewed", name, asked, **contact)["pair_restitution"]
        assert result == pytest.approx(RECIPES["law", name].free_restitution(asked), rel=1e-6)


def test_the_start_is_forgotten_unless_the_first_touch_counts():
    def figures(onset):
        result = [simulate(crank(onset, start)).summary for start in ("centred", "seated")]
        return np.array([[each[f"rod_slider_{name}"] for name in ("force_rms", "force_p99")] for each in result])

    centred, seated = figures("renewed")
    assert seated == pytest.approx(centred, rel=1e-3)
    centred, seated = figures("first")
    assert seated[1] > 1.5 * centred[1]


def steps(run, control):
    """Yield the law's phase before and after every step of a run, which is behind that step."""
    status, work = integration.PAUSED, run.work
    while status == integration.PAUSED:
        before = work.latched[-1]
        status, _ = run.advance(control._replace(pause=np.nextafter(work.y[work.time], math.inf)))
        yield before, work.latched[-1]


def test_a_contact_turns_lasting_where_its_rate_is_zero():
    made = crank(revolutions=0.5, discard=0)
    run = Run(start_of(made, np.empty(0)))
    turned = 0
    for before, after in steps(run, control_of(made, 0.5 * period(made), keep_events=False)):
        if before != 0.0 and after == 0.0 and touches(int(run.work.mode[0])):
            turned += 1
            assert abs(contact_observables_in(run.work.o, START, 0).rate) < 1e-9
    assert turned >= 1


def test_the_error_follows_the_tolerance():
    def end(tolerance):
        run = Run(start_of(made := crank(tolerance=tolerance, revolutions=0.4, discard=0), np.empty(0)))
        run.advance(control_of(made, 0.4 * period(made), keep_events=False))
        return run.work.end[:2]

    truth = end(1e-13)
    errors = [np.abs(end(tolerance) - truth).max() for tolerance in (1e-3, 1e-5, 1e-7, 1e-9)]
    assert all(later < max(0.1 * earlier, 1e-14) for earlier, later in pairwise(errors)), errors


@pytest.mark.slow
def test_the_implicit_method_agrees_with_the_explicit_one():
    def end(method, tolerance):
        run = Run(start_of(made := crank(method=method, tolerance=tolerance, revolutions=0.4, discard=0), np.empty(0)))
        control = control_of(made, 0.4 * period(made), keep_events=False)
        if method == "implicit":
            run.work.method.current = run.work.method.next = 1
        run.advance(control)
        return run.work.end[:2]

    truth = end("explicit", 1e-13)
    errors = [np.abs(end("implicit", tolerance) - truth).max() for tolerance in (1e-5, 1e-7, 1e-9)]
    assert all(later < 0.2 * earlier for earlier, later in pairwise(errors)), errors


# ---------------------------------------------------------------------------------------------- what a user sees


def test_the_rate_in_force_is_reported():
    first = simulate(crank("first", "seated"))
    assert first.summary["rod_slider_onset_rate"] == ONSET_FLOOR
    assert "onset-kept: rod-slider stays in contact" in first.message
    assert "contact.onset: renewed" in first.message
    now = simulate(crank("renewed", "seated"))
    assert now.summary["rod_slider_onset_rate"] is None
    assert now.message == ""


def test_in_an_impact_it_is_that_of_the_impact():
    made = crank(revolutions=1, discard=0)
    run = Run(start_of(made, np.empty(0)))
    run.advance(control_of(made, 1.0, keep_events=True)._replace(event_budget=1))
    assert needs_onset_rate(made.value.joints[0].law._replace(doubling_energy=1.0))
    assert onset_rates(run)[0] == run.work.latched[0] > 0.1


def identity(**contact):
    case = slider_crank("rod-slider", changes={f"{CONTACT}.{key}": value for key, value in contact.items()})
    return grid.load(case, scene.catalogue()).case_id(0)


def test_the_choice_is_part_of_the_case_where_the_law_knows_the_onset():
    assert identity() == identity(onset="renewed") != identity(onset="first")
    plain = {"law": "hertz", "restitution": None}
    assert identity(**plain) == identity(onset="first", **plain) == identity(onset="renewed", **plain)


def test_both_rules_can_be_swept():
    swept = slider_crank("rod-slider") | {
        "sweep": {f"{CONTACT}.law": ["hertz", "flores"], f"{CONTACT}.onset": ["first", "renewed"]}
    }
    result = [contact.law + (contact.onset or "") for contact in map(contact_of, cases_of(swept))]
    assert result == ["hertz", "floresfirst", "floresrenewed"]


def cases_of(source):
    loaded = grid.load(source, scene.catalogue())
    return [loaded.case(k) for k in range(len(loaded))]


def contact_of(case):
    return case.joints[0].contact


def test_first_compiles_nothing_of_what_forgets():
    assert "Renewed" in str(scene.signature(crank("renewed").case))
    assert "Renewed" not in str(scene.signature(crank("first").case))


# ------------------------------------------------------------------------------------------ the machine of the README

#: Its machine at higher speeds and wider clearances, where every second motion is irregular.
FAST = {
    "joints.rod-slider.clearance": ["0.1 mm", "0.2 mm", "0.5 mm"],
    "drive.speed": {"linspace": ["1000 rpm", "5000 rpm", 4]},
}
COEXISTING = {20}  # two motions side by side: of period 2 without a loss of contact, and without period
SLOW = {4, 13, 21, 22}  # agree after 100 to 300 revolutions


@pytest.mark.slow
def test_centred_and_seated_starts_agree_on_the_fast_machine_of_the_readme():
    source = yaml.safe_load((ROOT / "configs/slider_crank_restitution.yaml").read_text(encoding="utf-8"))
    source["sweep"] |= FAST
    limits_met = {"figure": "rod_slider_force_p99", "relative_ci": 1e-6, "max_revolutions": 40}
    result = {}
    for start in ("centred", "seated"):
        settings = {"revolutions": 40, "discard": 20, "tolerance": 1e-8, "start": start, "until": limits_met}
        cases = cases_of(copy.deepcopy(source) | {"simulate": settings, "save": {"orbits": "none"}})
        result[start] = [simulate(scene.build(case)).summary for case in cases]
    apart = {number for number, both in enumerate(zip(*result.values(), strict=True)) if not agree(*both)}
    assert apart <= COEXISTING | SLOW


def agree(first, other):
    """Return whether two motions are the same: periodic ones by figures, others by their intervals."""
    ratio = {name: other[f"rod_slider_{name}"] / first[f"rod_slider_{name}"] for name in ("force_p99", "force_peak")}
    if first["period"] is not None and first["period"] == other["period"]:
        rms = other["rod_slider_force_rms"] / first["rod_slider_force_rms"]
        return abs(rms - 1.0) < 0.02 and abs(ratio["force_p99"] - 1.0) < 0.02 and abs(ratio["force_peak"] - 1.0) < 0.1
    apart = abs(first["rod_slider_force_p99"] - other["rod_slider_force_p99"])
    return apart <= (first["figure_ci"] or 0.0) + (other["figure_ci"] or 0.0)
