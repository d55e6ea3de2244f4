"""Contacts that yield: the loop of force over penetration, its memory, its energy, and how its ends are located."""

import math

import numpy as np
import pytest
from law_cases import resolved, written
from mechanism_cases import PAIR, changed, slider_crank

import clearsweep
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.contract import every_latched, with_internal_state
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.loss import contact_force
from clearsweep.simulation.analyses.outcome import trajectory_of
from clearsweep.simulation.running.run import integration_of

pytestmark = pytest.mark.heavy

LAW = "lankarani-nikravesh-plastic"
STIFFNESS = 6.61e10
CONTACT = {"law": LAW, "stiffness": STIFFNESS, "restitution": 0.7}
STEEL = {"material": {"young": 207e9, "poisson": 0.3}}


def bounce(speed=1.0, mass=0.2, **contact):
    """Return the scene of one impact of two bodies of this mass."""
    return clearsweep.load_case(
        changed(
            PAIR,
            {
                "joints.pair.contact": CONTACT | contact,
                "mechanism.speed": speed,
                "mechanism.masses": [mass, mass],
                "simulate.impacts": 1,
            },
        )
    )


def returned(**changes):
    return clearsweep.simulate(bounce(**changes)).summary["pair_restitution"]


def crank(**changes):
    """Return the trajectory of a slider-crank whose contact yields."""
    changes = {"joints.rod-slider.contact": CONTACT} | {k.replace("__", "."): v for k, v in changes.items()}
    return clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes)))


def on_the_loop(pen, restitution):
    """Return the force (N) over a history of penetrations (m) from one onset on, as the paper has it."""
    deepest, force = 0.0, []
    for p in pen:
        deepest = max(deepest, p)
        left = (1.0 - restitution**2) * deepest
        largest = STIFFNESS * deepest**1.5
        force.append(largest * (max(p - left, 0.0) / (deepest - left)) ** 1.5 if deepest > 0.0 else 0.0)
    return np.array(force)


# ---------------------------------------------------------------------------------------------- the law alone


def test_the_way_back_begins_at_the_largest_force_and_ends_at_the_indentation():
    joint = resolved(written() | {"contact": CONTACT | {"elastic": "power", "exponent": 1.5, "yield_rate": 0.0}})
    law, elastic = registry.compile_contact(joint)
    back = with_internal_state(law, [2e-5], 0)
    assert contact_force(back, elastic, 2e-5, -1.0, 1.0)[0] == pytest.approx(STIFFNESS * 2e-5**1.5, rel=1e-14)
    assert contact_force(back, elastic, (1.0 - 0.49) * 2e-5, -1.0, 1.0)[0] == pytest.approx(0.0, abs=1e-9)
    raw, stored = contact_force(back, elastic, 0.4 * 2e-5, -1.0, 1.0)
    assert raw < 0.0 == stored
    pen = np.linspace(0.51 * 2e-5, 2e-5, 20001)
    work = np.trapezoid([contact_force(back, elastic, p, -1.0, 1.0)[0] for p in pen], pen)
    assert work == pytest.approx(0.49 * STIFFNESS * 2e-5**2.5 / 2.5, rel=1e-7)


def test_below_the_yield_rate_all_is_elastic():
    joint = resolved(written() | {"contact": CONTACT | {"elastic": "power", "exponent": 1.5, "yield_rate": 0.05}})
    law, elastic = registry.compile_contact(joint)
    for deepest in (0.0, 2e-5):
        force = elastic_force(elastic, 1e-5)
        assert contact_force(with_internal_state(law, [deepest], 0), elastic, 1e-5, -0.01, 0.05) == (force, force)
    assert returned(speed=0.04, yield_rate=0.05) == pytest.approx(1.0, abs=1e-9)
    assert returned(speed=0.06, yield_rate=0.05) == pytest.approx(0.7, abs=1e-9)


# ---------------------------------------------------------------------------------------------- impacts


CHANGES = {
    "mass": {"mass": 2.0},
    "slow": {"speed": 0.01},
    "fast": {"speed": 5.0},
    "linear": {"exponent": 1.0, "stiffness": 1e8},
    "square": {"exponent": 2.0, "stiffness": 1e13},
    "johnson": {"elastic": "johnson", **STEEL},
    "liu": {"elastic": "liu", **STEEL},
}


@pytest.mark.few("mass", "slow", "fast", "linear", "johnson")
@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_restitution_does_not_depend_on_mass_speed_or_elastic_law(changes):
    contact = dict(changes)
    if "elastic" not in contact:
        assert returned(**contact) == pytest.approx(0.7, abs=1e-9)
        return
    case = changed(
        PAIR,
        {
            "joints.pair": {
                "clearance": 1e-4,
                "bearing_radius": 0.01,
                "length": 0.02,
                "contact": {"law": LAW, "restitution": 0.7, **contact},
            },
            "simulate.impacts": 1,
        },
    )
    assert clearsweep.simulate(clearsweep.load_case(case)).summary["pair_restitution"] == pytest.approx(0.7, abs=1e-9)


def test_the_first_half_is_that_of_hertz_and_the_loss_is_the_loop_s():
    made = bounce()
    run = integration_of(made, np.empty(0), math.inf)
    lost, stored = run.totals.mechanism.energy_lost, run.totals.mechanism.energy_stored
    assert lost == pytest.approx((1.0 - 0.49) * 0.5 * 0.1 * 1.0**2, rel=1e-9)
    assert stored == pytest.approx(0.0, abs=1e-9 * lost)
    summary = clearsweep.simulate(made).summary
    deepest = (2.5 * 0.1 / (2.0 * STIFFNESS)) ** 0.4
    assert summary["pair_penetration_max"] == pytest.approx(deepest, rel=1e-10, abs=0.0)
    assert summary["pair_force_peak"] == pytest.approx(STIFFNESS * deepest**1.5, rel=1e-10)
    assert summary["pair_force_clips"] == 1.0


# ---------------------------------------------------------------------------------------------- in a mechanism


@pytest.mark.few
@pytest.mark.compiled
def test_a_mechanism_follows_the_loop_through_every_reloading():
    run = crank(save__orbits="all", save__revolutions=1, save__samples=200_000)
    depth = np.hypot(run["joints/rod_slider/x"], run["joints/rod_slider/y"]) - 0.5e-3
    onsets, reloadings = run.events["t"][run.events["kind"] == "on"], 0
    for begin, end in zip(onsets, [*onsets[1:], math.inf], strict=True):
        within = (run.t > begin) & (run.t < end) & (depth > 0.0)
        pen, force = depth[within], run["joints/rod_slider/force_normal"][within]
        np.testing.assert_allclose(force, on_the_loop(pen, 0.7), rtol=0.0, atol=1e-5 * force.max())
        deepens = np.diff(np.maximum.accumulate(pen)) > 0.0
        reloadings += np.count_nonzero(deepens[1:] & ~deepens[:-1])
    assert len(onsets) > 2
    assert reloadings > 2


@pytest.mark.compiled
def test_energies_balance_and_a_tighter_tolerance_converges():
    exact = crank(simulate__revolutions=0.3, simulate__tolerance=1e-12).summary
    shares = []
    for tolerance in (1e-6, 1e-8, 1e-9, 1e-10):
        summary = crank(simulate__revolutions=0.3, simulate__tolerance=tolerance).summary
        assert summary["energy_residual"] < 0.5 * tolerance
        shares.append(abs(summary["rod_slider_force_rms"] / exact["rod_slider_force_rms"] - 1.0) / tolerance)
    assert np.median(shares) < 10.0  # at one tolerance alone luck decides


@pytest.mark.compiled
def test_the_implicit_method_finds_the_same_motion():
    explicit, implicit = (
        crank(simulate__revolutions=0.2, simulate__method=method, simulate__tolerance=1e-8).summary
        for method in ("explicit", "implicit")
    )
    for figure in ("rod_slider_force_peak", "rod_slider_force_rms", "slider_acceleration_rms"):
        assert implicit[figure] == pytest.approx(explicit[figure], rel=1e-6)


@pytest.mark.slow
def test_a_contact_that_yields_and_remembering_friction_keep_to_their_places():
    lugre = {
        "law": "lugre",
        "coefficient": 0.1,
        "static_coefficient": 0.15,
        "stribeck_velocity": 1e-3,
        "bristle_stiffness": 1e5,
        "bristle_damping": 316.0,
    }
    changes = {
        "joints.crank-rod.friction": lugre,
        "joints.rod-slider.contact": CONTACT,
        "joints.rod-slider.friction": lugre,
        "simulate.revolutions": 0.2,
    }
    scene = clearsweep.load_case(slider_crank("crank-rod", "rod-slider", changes=changes))
    run = integration_of(scene, np.empty(0), 0.2 * 2.0 * math.pi / scene.value.reference_rate)
    assert list(run.work.reset_by) == [0, 1]  # of the bristles, which are integrated
    assert [type(law).__name__ for law, _ in every_latched(scene.value.joints)] == ["Renewed", "Plastic"]
    assert run.work.latched.size == 2 + 2
    assert trajectory_of(scene, run, 1.0).summary["energy_residual"] < 1e-9
