"""Laws of one's own: what a decorator records, how a grid names them, what they give, and what is refused."""

import ctypes
import linecache
import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from fake_physics import BODIES

from clearsweep import grid, laws, simulation
from clearsweep.language.errors import InputError
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.contract import every_guard
from clearsweep.mechanics.laws import contract
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.laws.loss import hysteresis_rebound
from clearsweep.mechanics.laws.sampled import SPEEDS
from clearsweep.mechanics.machines.described import refusal
from clearsweep.simulation import simulate
from clearsweep.simulation.machine.ideal import ideal_motion
from clearsweep.simulation.setup import scene

COPIES = Path(__file__).with_name("copied_laws.py")
STIFFNESS = "1e9 N/m^1.5"
PAIR = {
    "mechanism": {"type": "impact-pair", "masses": ["1 kg", "2 kg"], "speed": "0.2 m/s"},
    "joints": {"pair": {"clearance": "1 mm"}},
    "simulate": {"impacts": 3, "tolerance": "1e-8"},
}
CRANK = {
    "mechanism": BODIES,
    "drive": {"speed": "1000 rpm"},
    "joints": {"rod-slider": {"clearance": "0.1 mm", "bearing_radius": "10 mm", "length": "20 mm"}},
    "simulate": {"revolutions": 0.3, "discard": 0, "tolerance": "1e-6"},
}
FLORES = {"law": "flores", "restitution": 0.7, "stiffness": STIFFNESS, "onset": "first"}
TANH = {"law": "tanh", "coefficient": 0.1, "velocity_scale": "1 mm/s"}
BRISTLES = ("coefficient", "static_coefficient", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
LUGRE = dict(zip(BRISTLES, (0.1, 0.15, "10 mm/s", "1e5 1/m", "100 s/m"), strict=True))
LUGRE |= {"law": "lugre", "damping_velocity": "5 mm/s"}
MY_LUGRE = dict(zip(("mu", "mus", "vs", "s0", "s1"), (LUGRE[key] for key in BRISTLES), strict=True))
MY_LUGRE |= {"law": "my-lugre", "vd": "5 mm/s"}
TIMES = ("time", "compiling")


def catalogue_of(*decorators):
    """Return the catalogue with the laws that functions record; each call has laws of its own."""
    with laws.collecting() as records:
        for decorate in decorators:
            decorate()
    catalogue_of.count = getattr(catalogue_of, "count", 0) + 1
    return scene.catalogue().with_laws(records, f"test{catalogue_of.count}")


def copies():
    return catalogue_of(lambda: runpy.run_path(str(COPIES)))


def with_joint(machine, **sections):
    (name, joint), *_ = machine["joints"].items()
    return machine | {"joints": {name: joint | sections}}


def figures_of(source, catalogue):
    """Return the figures of the only case of a grid, without times."""
    summary = simulate(scene.build(grid.load(source, catalogue).case(0))).summary
    return {name: value for name, value in summary.items() if not any(word in name for word in TIMES)}


def joint_of(source, catalogue):
    return grid.load(source, catalogue).case(0).joints[0]


def hunt_crossley(penetration, rate, onset_rate, p):
    return p.stiffness * penetration**p.exponent + p.damper * penetration**p.exponent * rate


def test_a_decorator_returns_the_function_and_records_it_only_while_collecting():
    with laws.collecting() as records:
        assert laws.contact("my-law", damper="N*s/m^2.5")(hunt_crossley) is hunt_crossley
    assert laws.contact("later", damper="N*s/m^2.5")(hunt_crossley) is hunt_crossley
    (law,) = records
    assert (law.kind, law.name, law.function) == ("contact", "my-law", hunt_crossley)
    assert [(field.name, field.unit) for field in law.keys] == [("damper", "N*s/m^2.5")]
    assert law.file == __file__
    assert "my-law" in linecache.getline(__file__, law.line)


def test_a_function_of_c_has_an_address_and_no_body():
    with laws.collecting() as records:
        laws.elastic("sine")(ctypes.CDLL(None).sin)
    assert records[0].body is None
    assert laws.address_of(records[0].function) > 0


# ---------------------------------------------------------------------------------------------- what they give


def assert_same_bits(machine, original, copy):
    """Assert that two choices of laws give all figures alike, where the copy has a figure."""
    catalogue = copies()
    expected, result = (figures_of(with_joint(machine, **sections), catalogue) for sections in (original, copy))
    assert expected["steps"] > 5
    assert {name: result[name] for name in expected} == expected


def test_copies_of_flores_and_lugre_give_the_bits_of_the_package():
    copy = {"contact": {"law": "my-flores", "e": 0.7, "stiffness": STIFFNESS}, "friction": MY_LUGRE}
    assert_same_bits(CRANK, {"contact": FLORES, "friction": LUGRE}, copy)


@pytest.mark.slow
def test_copies_of_tanh_and_archard_give_the_bits_of_the_package():
    original = {"contact": FLORES, "friction": TANH, "wear": {"law": "archard", "coefficient": "2e-15 m^2/N"}}
    copy = {
        "contact": FLORES,
        "friction": {"law": "my-tanh", "mu": 0.1, "v": "1 mm/s"},
        "wear": {"law": "my-archard", "k": "2e-15 m^2/N"},
    }
    assert_same_bits(CRANK, original, copy)


@pytest.mark.slow
def test_a_copy_of_the_short_bearing_gives_the_bits_of_the_package():
    catalogue = copies()
    films = ({"law": name, "viscosity": "0.05 Pa*s"} for name in ("short", "my-short"))
    expected, result = (figures_of(with_joint(CRANK, length="8 mm", film=film), catalogue) for film in films)
    unknown = "rod_slider_film_pressure_max", "rhs_evaluations"  # a force of one's own has no pressure
    assert result.pop(unknown[0]) is None
    assert {name: value for name, value in expected.items() if name not in unknown} == {
        name: value for name, value in result.items() if name not in unknown
    }


SPRING = ctypes.CFUNCTYPE(ctypes.c_double, *[ctypes.c_double] * 3, ctypes.POINTER(ctypes.c_double))


@SPRING
def spring_of_c(penetration, rate, onset_rate, parameters):
    return parameters[0] * penetration + parameters[1] * rate


def test_a_function_of_c_in_the_loop_gives_the_motion_of_the_same_formula():
    keys = {"k": "N/m", "c": "N*s/m"}
    catalogue = catalogue_of(
        lambda: laws.contact("c", stiffness="N/m", c="N*s/m")(spring_of_c),
        lambda: laws.contact("python", **keys)(lambda penetration, rate, onset_rate, p: p.k * penetration + p.c * rate),
    )
    numbers = {"c": "1e3 N*s/m"}
    by_address = figures_of(with_joint(PAIR, contact={"law": "c", "stiffness": "1e8 N/m"} | numbers), catalogue)
    traced = figures_of(with_joint(PAIR, contact={"law": "python", "k": "1e8 N/m"} | numbers), catalogue)
    assert by_address["pair_force_peak"] == pytest.approx(traced["pair_force_peak"], rel=1e-12)
    assert by_address["steps"] == traced["steps"]


@pytest.mark.slow
def test_a_function_of_numba_is_read_and_one_with_an_address_is_called():
    numba = pytest.importorskip("numba")

    @numba.njit
    def helper(e):
        return 1.6 * (1.0 - e) / e

    @numba.njit
    def traced(penetration, rate, onset_rate, p):
        force = p.elastic_force(penetration)
        return force + force * (helper(p.e) / onset_rate) * rate

    number = numba.types.float64

    @numba.cfunc(number(number, number, number, numba.types.CPointer(number)))
    def called(penetration, rate, onset_rate, p):
        force = p[1] * penetration * math.sqrt(penetration)
        return force + force * ((1.6 * (1.0 - p[0]) / p[0]) / onset_rate) * rate

    catalogue = catalogue_of(
        lambda: laws.contact("traced", e="1")(traced), lambda: laws.contact("called", e="1")(called)
    )
    expected = figures_of(with_joint(CRANK, contact=FLORES), catalogue)
    for name, bound in (("traced", 0.0), ("called", 1e-9)):
        result = figures_of(with_joint(CRANK, contact={"law": name, "e": 0.7, "stiffness": STIFFNESS}), catalogue)
        assert result["rod_slider_force_peak"] == pytest.approx(expected["rod_slider_force_peak"], rel=bound, abs=0.0)


def test_kinks_of_a_law_end_steps_where_it_declares_them():
    def law(penetration, rate, onset_rate, p):
        return p.k * penetration + (p.k * (penetration - p.d) if penetration > p.d else 0.0)

    keys = {"k": "N/m", "d": "m"}
    catalogue = catalogue_of(
        lambda: laws.contact("declared", kinks=["d"], **keys)(law), lambda: laws.contact("silent", **keys)(law)
    )
    numbers = {"k": "1e8 N/m", "d": "5 um"}
    declared, silent = (with_joint(PAIR, contact={"law": name} | numbers) for name in ("declared", "silent"))
    assert list(registry.own_law_remarks(grid.load(declared, catalogue).case(0))) == []
    (remark,) = registry.own_law_remarks(grid.load(silent, catalogue).case(0))
    assert "has a kink at penetration 5e-06 m" in remark
    residuals = [abs(figures_of(source, catalogue)["energy_residual"]) for source in (declared, silent)]
    assert residuals[0] <= residuals[1]


def test_kinks_of_an_elastic_law_end_steps_too():
    def law(penetration, p):
        return p.k * penetration + (p.k * (penetration - p.d) if penetration > p.d else 0.0)

    catalogue = catalogue_of(lambda: laws.elastic("kinked", k="N/m", d="m", kinks=["d"])(law))
    contact = {"law": "hertz", "elastic": "kinked", "k": "1e8 N/m", "d": "5 um"}
    built = scene.build(grid.load(with_joint(PAIR, contact=contact), catalogue).case(0))
    smooth = scene.build(
        grid.load(with_joint(PAIR, contact={"law": "hertz", "stiffness": STIFFNESS}), catalogue).case(0)
    )
    assert len(every_guard(built.value.joints)) == len(every_guard(smooth.value.joints)) + 2
    summary = simulate(built).summary
    assert abs(summary["energy_residual"]) < 1e-9
    energy = 0.5 * (2.0 / 3.0) * 0.2**2  # J, of 1 kg and 2 kg at 0.2 m/s
    depth = 2.5e-6 + math.sqrt(energy / 1e8 - 0.25 * 5e-6**2)  # m: k x^2 / 2 + k (x - d)^2 / 2 = energy
    assert summary["pair_penetration_max"] == pytest.approx(depth, rel=1e-6)


def test_the_restitution_of_a_law_is_that_of_its_closed_form():
    def viscous(penetration, rate, onset_rate, p):
        return p.k * penetration + p.c * rate

    catalogue = catalogue_of(
        lambda: laws.contact("factor", chi="1")(
            lambda penetration, rate, onset_rate, p: p.elastic_force(penetration) * (1.0 + p.chi * rate / onset_rate)
        ),
        lambda: laws.contact("viscous", k="N/m", c="N*s/m")(viscous),
    )
    contact = {"law": "factor", "chi": 0.8, "stiffness": STIFFNESS}
    result = registry.derived_values(joint_of(with_joint(PAIR, contact=contact), catalogue))
    for speed in SPEEDS:
        assert result[f"contact.restitution at {speed:g} m/s"][0] == pytest.approx(hysteresis_rebound(0.8), rel=1e-8)
    contact = {"law": "viscous", "k": "1e8 N/m", "c": "1e3 N*s/m"}
    result = registry.derived_values(joint_of(with_joint(PAIR, contact=contact), catalogue))
    zeta = 1e3 / (2.0 * math.sqrt(1e8))  # of 1 kg
    w = math.sqrt(1.0 - zeta * zeta)
    expected = math.exp(-zeta / w * math.atan2(2.0 * zeta * w, 2.0 * zeta * zeta - 1.0))
    assert result["contact.restitution at 0.1 m/s and 1 kg"][0] == pytest.approx(expected, rel=1e-7)


def drivers():
    """Return the catalogue with a load and motors of one's own."""

    def kloss(speed, t, p):
        slip = 1.0 - speed / p.synchronous
        return 2.0 * p.breakdown * slip * p.slip / (slip * slip + p.slip * p.slip)

    return catalogue_of(
        lambda: laws.load("mine", f="N", k="N/m")(
            lambda t, angle, position, velocity, p: (p.f - p.k * (position[0] - 0.12), 0.0, 0.0)
        ),
        lambda: laws.motor("line", stall="N*m", no_load="rad/s")(
            lambda speed, t, p: p.stall - p.stall / p.no_load * speed
        ),
        lambda: laws.motor("kloss", breakdown="N*m", slip="1", synchronous="rad/s")(kloss),
    )


def test_a_load_of_ones_own_acts_on_the_ideal_machine_like_a_spring_and_a_force():
    catalogue, angles = drivers(), np.linspace(0.0, 6.0, 13)
    own = {"on": "slider", "law": "mine", "f": "50 N", "k": "0.1 N/mm"}
    spring = {"between": ["ground", "slider"], "anchor": ["-10 m", "0 m"], "stiffness": "100 N/m"}
    spring |= {"free_length": "10.62 m"}  # 10 m + 0.12 m + 50 N / 100 N/m
    reactions = [
        ideal_motion(grid.load(with_joint(CRANK, contact=FLORES) | {"loads": {"l": load}}, catalogue).case(0), angles)
        for load in (own, spring)
    ]
    result, expected = (motion.reactions["rod-slider"] for motion in reactions)
    assert np.ptp(result) > 10.0
    np.testing.assert_allclose(result, expected, atol=1e-9)


def test_a_machine_is_drawn_alike_before_its_load_and_motor_have_run(monkeypatch):
    free = {"initial_speed": "500 rpm", "start_angle": "30 deg"}
    drive = free | {"motor": {"law": "line", "stall": "5 N*m", "no_load": "1000 rpm"}}
    loads = {"l": {"on": "slider", "law": "mine", "f": "50 N", "k": "0 N/m"}}
    case = grid.load(with_joint(CRANK, contact=FLORES) | {"drive": drive, "loads": loads}, drivers()).case(0)
    known = simulation.sketch(case)
    monkeypatch.setattr(contract, "OWN_RECIPES", {})
    unknown = simulation.sketch(case)
    assert [joint.position.tolist() for joint in unknown.joints] == [joint.position.tolist() for joint in known.joints]
    assert [load.name for load in unknown.loads] == ["l"]
    assert refusal(simulation.mechanism_of(case), case) is None
    with pytest.raises(InputError, match="is of a law file that has not run here"):
        ideal_motion(case, np.zeros(1))


@pytest.mark.slow
def test_loads_and_motors_of_ones_own_move_a_machine_like_those_of_the_package():
    catalogue, crank = drivers(), with_joint(CRANK, contact=FLORES)
    loads = ({"on": "slider", "force": ["50 N", "0 N"]}, {"on": "slider", "law": "mine", "f": "50 N", "k": "0 N/m"})
    expected, result = (figures_of(crank | {"loads": {"l": load}}, catalogue) for load in loads)
    assert result == expected
    free = {"initial_speed": "500 rpm", "inertia": "1e-3 kg*m^2"}
    motors = (
        {"stall_torque": "5 N*m", "no_load_speed": "1000 rpm"},
        {"law": "line", "stall": "5 N*m", "no_load": "1000 rpm"},
    )
    expected, result = (figures_of(crank | {"drive": free | {"motor": motor}}, catalogue) for motor in motors)
    assert result["rod_slider_force_peak"] == pytest.approx(expected["rod_slider_force_peak"], rel=1e-6)
    induction = {"law": "kloss", "breakdown": "5 N*m", "slip": 0.1, "synchronous": "1000 rpm"}
    result = figures_of(crank | {"drive": free | {"motor": induction}}, catalogue)
    assert abs(result["energy_residual"]) < 1e-6


# ---------------------------------------------------------------------------------------------- what is refused


def power(p, penetration):
    return p.stiffness * penetration**1.5


@pytest.mark.parametrize(
    ("law", "options", "message"),
    [
        (lambda d, v, v0, p: power(p, d) * math.log(d), {}, "fails with ValueError"),
        (lambda d, v, v0, p: power(p, d) / d, {}, "fails with ZeroDivisionError"),
        (lambda d, v, v0, p: 0.0 * p.stiffness, {}, "gives 0 N at rest"),
        (lambda d, v, v0, p: -power(p, d), {}, "it must push the surfaces apart"),
        (lambda d, v, v0, p: power(p, d) * (1.0 - 0.1 * v / v0), {"may_gain": True}, ""),
        (lambda d, v, v0, p: power(p, d) + (9.0 if d > 1e-5 else 0.0), {"kinks": [1e-5]}, ""),
    ],
)
def test_a_law_that_no_run_could_use_is_refused_before_it(law, options, message):
    catalogue = catalogue_of(lambda: laws.contact("mine", **options)(law))
    source = with_joint(PAIR, contact={"law": "mine", "stiffness": STIFFNESS})
    if not message:
        assert len(grid.load(source, catalogue)) == 1
        return
    with pytest.raises(InputError) as caught:
        grid.load(source, catalogue)
    assert "joints.pair.contact.law" in str(caught.value)
    assert "test_own_laws.py" in str(caught.value)
    assert message in str(caught.value)


def test_a_film_without_limit_at_the_centre_is_refused():
    catalogue = catalogue_of(
        lambda: laws.film("mine")(lambda x, y, vx, vy, speed, p: (-p.viscosity * vx / abs(x), -p.viscosity * vy))
    )
    with pytest.raises(InputError, match=r"fails with ZeroDivisionError.* at ratio 0"):
        grid.load(with_joint(CRANK, film={"law": "mine", "viscosity": "0.05 Pa*s"}), catalogue)


def test_a_law_that_never_carries_the_load_of_a_seated_start_is_refused():
    catalogue = catalogue_of(lambda: laws.contact("mine")(lambda d, v, v0, p: 5.0 * d / (d + 1e-5)))
    source = with_joint(CRANK, contact={"law": "mine"})
    source["simulate"] = source["simulate"] | {"start": "seated"}
    with pytest.raises(InputError, match=r"joints: a contact law never carries \d"):
        grid.load(source, catalogue)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (lambda normal, slip, p: p.mu * normal / slip, "fails with ZeroDivisionError"),
        (lambda normal, slip, p: None, "fails with TypeError"),
    ],
)
def test_friction_that_fails_is_refused(law, message):
    catalogue = catalogue_of(lambda: laws.friction("mine", mu="1")(law))
    with pytest.raises(InputError, match=message):
        grid.load(with_joint(CRANK, contact=FLORES, friction={"law": "mine", "mu": 0.1}), catalogue)


def test_the_sign_of_friction_does_not_matter():
    catalogue = catalogue_of(
        lambda: laws.friction("up", mu="1")(lambda normal, slip, p: p.mu * normal * math.tanh(slip)),
        lambda: laws.friction("down", mu="1")(lambda normal, slip, p: -p.mu * normal * math.tanh(slip)),
    )
    for name in ("up", "down"):
        joint = joint_of(with_joint(CRANK, contact=FLORES, friction={"law": name, "mu": 0.1}), catalogue)
        assert friction_force(registry.compile_friction(joint), 10.0, 0.5) == -0.1 * 10.0 * math.tanh(0.5)


# ---------------------------------------------------------------------------------------------- in a grid


def test_keys_of_a_law_have_units_and_defaults():
    key = laws.key("N*s/m", at_least=0.0, default="5 N*s/m", doc="of the damper")
    catalogue = catalogue_of(
        lambda: laws.contact("mine", c=key)(lambda d, v, v0, p: p.elastic_force(d) + p.c * v * d / (d + 1e-6))
    )
    contact = {"law": "mine", "stiffness": STIFFNESS}
    assert joint_of(with_joint(PAIR, contact=contact), catalogue).contact.values["c"] == 5.0
    swept = with_joint(PAIR, contact=contact) | {"sweep": {"joints.pair.contact.c": ["1 N*s/mm", "2 kN*s/m"]}}
    assert grid.load(swept, catalogue).axes == {"joints.pair.contact.c": (1000.0, 2000.0)}
