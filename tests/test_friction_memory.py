"""Friction that remembers: bristles that bend, from the law alone to its place in the state of a mechanism."""

import math

import numpy as np
import pytest
from law_cases import RECIPES, compiled_friction, in_millimetres, joint, names, resolved, written
from mechanism_cases import slider_crank
from scipy.integrate import solve_ivp

import clearsweep
from clearsweep.mechanics.coupling.rates import rates
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.contract import Contact, every_internal_state, with_internal_state
from clearsweep.mechanics.laws.contract import FREE, PRESSED, internal_rates, internal_state
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.machines.contract import gaps, pose_at
from clearsweep.simulation.running.run import integration_of

pytestmark = pytest.mark.heavy

LUGRE = {
    "law": "lugre",
    "coefficient": 0.1,
    "static_coefficient": 0.15,
    "stribeck_velocity": 1e-3,
    "bristle_stiffness": 1e5,
    "bristle_damping": 316.0,
}
ELASTO_PLASTIC = LUGRE | {"law": "elasto-plastic", "elastic_share": 0.6}
DAHL = {"law": "dahl", "coefficient": 0.1, "bristle_stiffness": 1e5}
REMEMBERING = [name for name in names("friction") if internal_state(registry.compile_friction(joint(friction=name)))]


def term(bend=0.0, **friction):
    """Return a friction law with its bristles bent by `bend` (m)."""
    fields = RECIPES["friction", friction["law"]].law.fields
    defaults = {field.name: field.default for field in fields if field.default is not None}
    return with_internal_state(
        registry.compile_friction(resolved(written() | {"friction": defaults | friction})), [bend], 0
    )


def crank(friction, *joints, **changes):
    """Return the scene of a slider-crank with this friction in the first of `joints`."""
    joints = joints or ("rod-slider",)
    written = {f"joints.{joints[0]}.friction": friction}
    written |= {f"joints.{name}.contact.onset": "first" for name in joints}  # the friction alone has a memory
    return clearsweep.load_case(
        slider_crank(*joints, changes=written | {k.replace("__", "."): v for k, v in changes.items()})
    )


def bend_rate(law, slip):
    """Return the rate (m/s) of the bend of a law's bristles at a sliding speed."""
    (rate,) = internal_rates(law, Contact(100.0, 0.0, slip, 0.0, 0.0, 100.0, 100.0))
    return rate


def sliding_distance(law, slip, distance):
    """Return the bend (m) of bristles straight at first, after sliding at an even speed: an independent integration."""
    done = solve_ivp(
        lambda t, z: [bend_rate(with_internal_state(law, z, 0), slip)],
        (0.0, distance / abs(slip)),
        [0.0],
        "Radau",
        rtol=1e-10,
        atol=1e-18,
    )
    return done.y[0, -1]


# ---------------------------------------------------------------------------------------------- the laws alone


def test_lugre_settles_at_stribeck_s_curve():
    bend = sliding_distance(term(**LUGRE), 1e-3, 1e-4)
    assert bend == pytest.approx(1.1839397e-6, rel=1e-7, abs=0.0)
    assert friction_force(term(bend, **LUGRE), 100.0, 1e-3) == pytest.approx(-11.839397, rel=1e-6)
    assert sliding_distance(term(**LUGRE), -5.0, 1e-4) == pytest.approx(-1e-6, rel=1e-7, abs=0.0)


def test_lugre_s_viscous_part_is_added():
    written = LUGRE | {"viscous": 0.04}
    assert friction_force(term(1e-6, **written), 100.0, 5.0) == pytest.approx(-100.0 * (0.1 + 0.2), rel=1e-6)


def test_dahl_is_elastic_at_first_and_ends_at_the_kinetic_coefficient():
    law = term(**DAHL)
    bend = sliding_distance(law, 0.01, 1e-9)
    assert friction_force(term(bend, **DAHL), 100.0, 0.01) == pytest.approx(-100.0 * 1e5 * 1e-9, rel=1e-3)
    bend = sliding_distance(law, 0.01, 1e-4)
    assert friction_force(term(bend, **DAHL), 100.0, 0.01) == pytest.approx(-10.0, rel=1e-9)


@pytest.mark.parametrize(
    ("shape", "bent"), [(1.0, lambda x: 1.0 - math.exp(-x)), (2.0, lambda x: x / (1.0 + x))], ids=["1", "2"]
)
def test_dahl_approaches_sliding_as_its_closed_form(shape, bent):
    law = term(**DAHL, shape=shape)
    for reach in (0.1, 1.0, 4.0):  # sliding over mu / sigma0
        assert sliding_distance(law, 2.0, reach * 1e-6) == pytest.approx(1e-6 * bent(reach), rel=1e-8, abs=0.0)
        assert sliding_distance(law, -2.0, reach * 1e-6) == pytest.approx(-1e-6 * bent(reach), rel=1e-8, abs=0.0)


@pytest.mark.parametrize("shape", [1.0, 1.5, 2.0])
def test_bristles_bent_too_far_come_back(shape):
    for bend in (1.5e-6, 1e-3):
        assert bend_rate(term(bend, **DAHL, shape=shape), 1.0) < 0.0
        assert bend_rate(term(-bend, **DAHL, shape=shape), -1.0) > 0.0
        assert bend_rate(term(bend, **DAHL, shape=shape), 0.0) == 0.0


@pytest.mark.parametrize("damped", [LUGRE, ELASTO_PLASTIC], ids=["lugre", "elasto-plastic"])
def test_damped_bristles_never_drive_unless_their_damping_lasts(damped):
    def least_loss(**written):
        worst = math.inf
        for slip in np.geomspace(1e-7, 10.0, 161):
            for bend in np.linspace(-1.5e-6, 1.5e-6, 61):
                law = term(bend, **written)
                stored = 1e5 * bend * bend_rate(law, slip)  # rate at which bristles store energy, per load
                worst = min(worst, (-friction_force(law, 1.0, slip) * slip - stored) / slip)
        return worst

    assert least_loss(**damped) >= -1e-12
    assert least_loss(**damped, damping_velocity=0.1) < -1e-3


def test_elasto_plastic_bristles_only_bend_up_to_their_share_of_the_friction():
    law = term(**ELASTO_PLASTIC)
    for distance in (1e-9, 1e-7, 0.59e-6):  # mu / sigma0 is 1 um, the share 0.6
        assert sliding_distance(law, 1e-4, distance) == pytest.approx(distance, rel=1e-9, abs=0.0)
        assert sliding_distance(law, -0.5, distance) == pytest.approx(-distance, rel=1e-9, abs=0.0)
        bent = term(distance, **ELASTO_PLASTIC | {"bristle_damping": 0.0})
        assert friction_force(bent, 100.0, 0.0) == pytest.approx(-100.0 * 1e5 * distance, rel=1e-12)
    assert sliding_distance(law, 1e-4, 1.2e-6) < 1.15e-6
    for bend in (0.7e-6, 1.4e-6):  # back, the bristles unbend alone, however far they are bent
        assert bend_rate(term(bend, **ELASTO_PLASTIC), -2.0) == -2.0
        assert bend_rate(term(-bend, **ELASTO_PLASTIC), 2.0) == 2.0


def test_elasto_plastic_bristles_break_away_and_settle_at_stribeck_s_curve():
    law = term(**ELASTO_PLASTIC)
    for slip, coefficient in ((1e-7, 0.15), (1e-3, 0.11839397), (-5.0, 0.1)):
        bend = sliding_distance(law, slip, 1e-4)
        assert bend == pytest.approx(math.copysign(1e-5 * coefficient, slip), rel=1e-6, abs=0.0)
        settled = -friction_force(term(bend, **ELASTO_PLASTIC), 100.0, slip)
        assert settled == pytest.approx(math.copysign(100.0 * coefficient, slip), rel=1e-5)


def test_elasto_plastic_bristles_give_way_by_the_published_sine():
    flat = ELASTO_PLASTIC | {"static_coefficient": 0.1}
    for x in (0.65, 0.8, 0.97):
        rise = 0.5 * (1.0 + math.sin(math.pi * (x - 0.8) / 0.4))
        assert bend_rate(term(1e-6 * x, **flat), 3.0) == pytest.approx(3.0 * (1.0 - rise * x), rel=1e-12)
    for edge in (0.6e-6, 1e-6):
        below, above = (bend_rate(term(edge * (1.0 + off), **flat), 1.0) for off in (-1e-9, 1e-9))
        assert below == pytest.approx(above, abs=1e-8)


@pytest.mark.parametrize(("low", "high"), [(0.1, 0.59), (-0.3, 0.55)])
def test_a_load_swinging_below_the_share_moves_lugre_s_surfaces_alone(low, high):
    """Slow enough for the bend to follow the load: z = T / (N sigma0), and the slip is what bends it so."""

    def drift(**written):
        flat = written | {"static_coefficient": 0.1, "bristle_damping": 0.0}
        bends = np.linspace(1e-6 * low, 1e-6 * high, 4001)
        there = np.trapezoid([1.0 / bend_rate(term(bend, **flat), 1.0) for bend in bends], bends)
        back = np.trapezoid([-1.0 / bend_rate(term(bend, **flat), -1.0) for bend in bends], bends)
        return there - back

    expected = -1e-6 * math.log((1.0 - high**2) / (1.0 - low**2))
    assert drift(**LUGRE) == pytest.approx(expected, rel=1e-6, abs=0.0)
    assert abs(drift(**ELASTO_PLASTIC)) < 1e-9 * expected


def test_a_shaken_mass_comes_back_on_elasto_plastic_bristles_alone():
    """m x'' = P(t) + T with N = 100 N: P swings between 2 N and 5 N, the friction could hold 10 N."""

    def crept(**written):
        def slope(t, y):
            law = term(y[2], **written)
            pushed = 3.5 - 1.5 * math.cos(2.0 * math.pi * 50.0 * t)
            return [y[1], (pushed + friction_force(law, 100.0, y[1])) / 1.0, bend_rate(law, y[1])]

        cycles = [2.0 / 50.0, 3.0 / 50.0]
        at_rest = [2e-7, 0.0, 2e-7]
        done = solve_ivp(slope, (0.0, cycles[-1]), at_rest, "LSODA", cycles, rtol=1e-7, atol=[1e-14, 1e-12, 1e-14])
        return done.y[0, 1] - done.y[0, 0]

    swing = 1e-6 * math.log((1.0 - 0.2**2) / (1.0 - 0.5**2))  # that of a slow load
    assert 0.5 * swing < crept(**LUGRE | {"static_coefficient": 0.1}) < swing
    assert abs(crept(**ELASTO_PLASTIC)) < 1e-3 * swing


@pytest.mark.parametrize("name", REMEMBERING)
def test_bent_bristles_give_the_same_force_compiled_and_in_any_unit(name):
    term = registry.compile_friction(joint(friction=name))
    ((size, kept),) = internal_state(term)
    assert not kept
    slips = np.linspace(-0.01, 0.01, 21)
    for bend in (-0.7 * size, 0.4 * size):
        law = with_internal_state(term, [bend], 0)
        plain = np.array([friction_force(law, 100.0, slip) for slip in slips])
        np.testing.assert_allclose(compiled_friction(law, 100.0, slips), plain, rtol=1e-13, atol=1e-300)
        scaled = with_internal_state(registry.compile_friction(in_millimetres(written(friction=name))), [1e3 * bend], 0)
        in_mm = [friction_force(scaled, 100.0, 1e3 * slip) for slip in slips]
        np.testing.assert_allclose(in_mm, plain, rtol=1e-11)


# ---------------------------------------------------------------------------------------------- in a mechanism


def test_a_scene_without_memory_has_no_state_for_it():
    tanh = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-3}
    plain, bristles = crank(tanh), crank(DAHL)
    assert every_internal_state(plain.value.joints) == []
    assert plain.start.size == 2 * 2 + 1 + 1
    assert every_internal_state(bristles.value.joints) == [(0, (1e-6, False), 0.0)]
    assert bristles.start.size == plain.start.size + 1


@pytest.mark.parametrize("friction", [LUGRE, pytest.param(DAHL, marks=pytest.mark.slow)], ids=["lugre", "dahl"])
def test_the_first_contact_is_that_of_scipy_in_time(friction):
    """The right-hand side in time, with the penetration of the coordinates, from the located onset on."""
    made = crank(friction, simulate__revolutions=0.03, simulate__tolerance=1e-11)
    n, value = len(made.value.coordinates), made.value
    onset = clearsweep.simulate(made, times=[0.0]).events[0]
    end = onset["t"] + 4e-5
    ours = clearsweep.simulate(made, times=[onset["t"], end])
    channels = ("rod/angle", "slider/x", "rod/rate", "slider/v")
    start = np.array([*(ours[name][0] for name in channels), 0.0])
    k, o = np.zeros((made.start.size, 16)), np.zeros((40, 16))
    state, rate = np.array([PRESSED]), np.array([onset["rate"]])

    def slope(t, y):
        gap = np.hypot(*places(y, t)) - 0.5e-3
        full = np.array([*y[: 2 * n], t, math.sqrt(max(gap, 1e-16)), y[2 * n]])
        rates(value, full, state, rate, k, o, 0)
        return np.delete(k[:, 0], [2 * n, 2 * n + 1]) / k[2 * n, 0]

    def places(y, t):
        gap = gaps(value.mechanism, pose_at(value.mechanism, np.array([*y[: 2 * n], t])))[0]
        return gap.x, gap.y

    scale = np.array([1.0, 1.0, 1e3, 1e3, 1e-3])
    done = solve_ivp(slope, (onset["t"], end), start, "Radau", rtol=1e-9, atol=1e-13 * scale)
    assert [ours[name][1] for name in channels] == pytest.approx(done.y[: 2 * n, -1], rel=1e-8, abs=1e-9)
    assert ours["joints/rod_slider/force_tangential"][1] != 0.0


@pytest.mark.few("lugre")
@pytest.mark.compiled
@pytest.mark.parametrize(
    "friction",
    [LUGRE, DAHL, ELASTO_PLASTIC],
    ids=["lugre", "dahl", "elasto-plastic"],
)
def test_explicit_and_implicit_method_agree_and_energies_balance(friction):
    def run(method, tolerance):
        made = crank(friction, simulate__method=method, simulate__tolerance=tolerance, simulate__revolutions=0.15)
        return clearsweep.simulate(made).summary

    explicit, implicit = run("explicit", 1e-9), run("implicit", 1e-8)
    for figure in ("rod_slider_force_peak", "rod_slider_force_rms", "slider_acceleration_rms", "crank_torque_peak"):
        assert implicit[figure] == pytest.approx(explicit[figure], rel=1e-5)
    assert explicit["energy_residual"] < 1e-10
    assert implicit["energy_residual"] < 1e-9


@pytest.mark.compiled
def test_stiff_bristles_do_not_limit_the_steps_of_either_method():
    """With plain sweeps the explicit method takes 8.0 million evaluations."""

    def run(method):
        stiff = LUGRE | {"bristle_stiffness": 3e6, "bristle_damping": 0.0}
        return clearsweep.simulate(crank(stiff, simulate__method=method, simulate__tolerance=1e-6)).summary

    auto, explicit, implicit = run("auto"), run("explicit"), run("implicit")
    assert auto["rhs_evaluations"] <= explicit["rhs_evaluations"] < 160_000
    assert implicit["rhs_evaluations"] < 120_000
    assert auto["rod_slider_force_peak"] == pytest.approx(implicit["rod_slider_force_peak"], rel=1e-8)


@pytest.mark.compiled
def test_bristles_begin_straight_with_every_contact():
    made = crank(DAHL, simulate__revolutions=0.5)
    onsets = clearsweep.simulate(made, times=[0.0]).events
    onsets = onsets["t"][onsets["kind"] == "on"]
    later = 1e-8  # s: the surfaces slide by less than a tenth of mu / sigma0
    seen = clearsweep.simulate(made, times=onsets + later)
    share = np.abs(seen["joints/rod_slider/force_tangential"] / seen["joints/rod_slider/force_normal"])
    assert len(onsets) > 5
    assert np.all(share < 0.1 * 0.1)
    assert np.all(share > 0.0)


@pytest.mark.few
@pytest.mark.compiled
def test_only_the_separating_joint_forgets():
    made = crank(
        LUGRE,
        "crank-rod",
        "rod-slider",
        simulate__revolutions=0.3,
        simulate__method="explicit",
        **{"joints__rod-slider__friction": DAHL},
    )
    done = integration_of(made, np.empty(0), 0.3 * 2.0 * math.pi / made.value.reference_rate)
    assert list(done.work.reset_by) == [0, 1]
    for part, contact in enumerate(done.work.mode):
        assert (done.work.y[-2 + part] == 0.0) == (contact == FREE)
    alone = crank(LUGRE, "crank-rod", "rod-slider", simulate__revolutions=0.3, simulate__method="explicit")
    assert every_internal_state(alone.value.joints) == [(0, (1e-6, False), 0.0)]
    for scene in (made, alone):
        trajectory = clearsweep.simulate(scene)
        assert trajectory.status == "ok"
        assert trajectory.summary["energy_residual"] < 1e-10  # tolerance 1e-9


@pytest.mark.few("1e-09")
@pytest.mark.compiled
@pytest.mark.parametrize("tolerance", [1e-9, 1e-11])
def test_a_step_over_a_kink_is_repeated_until_it_ends_there(tolerance):
    """Two joints touch, one of them as its surfaces come to rest: the interpolant over the kink is inaccurate."""
    made = crank(
        ELASTO_PLASTIC,
        "crank-rod",
        "rod-slider",
        simulate__revolutions=0.3,
        simulate__method="explicit",
        simulate__tolerance=tolerance,
    )
    trajectory = clearsweep.simulate(made)
    assert trajectory.status == "ok"
    assert trajectory.summary["energy_residual"] < 0.05 * tolerance
