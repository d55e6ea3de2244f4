"""Free bodies of a planar machine that start where and as fast as their `initial` says."""

import itertools
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from right_grids import grid_of

import clearsweep
from clearsweep import simulation
from clearsweep.language.errors import InputError
from clearsweep.mechanics.laws.contract import FREE, PRESSED
from clearsweep.mechanics.solver.step_control import MAX_PATTERN_BITS, PIECE_BITS, contact_pattern
from clearsweep.sweeping import estimate

pytestmark = pytest.mark.heavy

STILL = [0.0, 0.0]
CONTACT = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
BALL = {"x": 2e-3, "y": -1e-3, "angle": 0.3, "vx": 1.0, "vy": 0.5, "rate": 20.0}


def grid(gravity=0.0, **initial):
    """Return a ball in a ring of 50 mm, next to a wheel that is driven."""
    source = grid_of("bodies that fall")
    source["mechanism"]["gravity"], source["mechanism"]["bodies"]["ball"]["initial"] = gravity, initial
    return source


def test_a_free_body_flies_from_where_it_starts_as_a_body_in_free_fall():
    result = clearsweep.simulate(clearsweep.load_case(grid(9.81, **BALL)))
    assert len(result.events) == 0
    t = result.t
    assert result["ball/x"] == pytest.approx(2e-3 + t, abs=1e-12)
    assert result["ball/y"] == pytest.approx(-1e-3 + 0.5 * t - 0.5 * 9.81 * t**2, abs=1e-12)
    assert result["ball/angle"] == pytest.approx(0.3 + 20.0 * t, abs=1e-11)
    assert result.summary["ring_force_peak_ideal"] is None
    assert result.summary["ring_force_peak_ratio"] is None


def test_what_is_left_out_is_zero_and_an_elastic_rebound_keeps_the_speed():
    result = clearsweep.simulate(clearsweep.load_case(grid(vx=5.0)))
    assert [str(kind) for kind in result.events["kind"]] == ["on", "off"]
    assert result.events["t"][0] == pytest.approx(0.01, rel=1e-9)
    assert result["ball/vx"][-1] == pytest.approx(-5.0, rel=1e-8)
    assert np.all(result["ball/angle"] == 0.0)


def test_a_rod_between_two_clearances_keeps_its_ideal_motion_for_comparison():
    """Its joints determine it where they are ideal, so that only its start changes."""
    source = grid()
    bodies, joints = source["mechanism"]["bodies"], source["mechanism"]["joints"]
    del bodies["ball"], joints["ring"]
    bodies["wheel"]["points"]["pin"] = [0.05, 0.0]
    bodies["rod"] = {"mass": 0.2, "inertia": 1e-4, "points": {"big": STILL, "small": [0.12, 0.0]}}
    bodies["slider"] = {"mass": 0.1, "inertia": 1e-5, "points": {"pin": STILL}}
    joints["big"] = {"type": "revolute", "between": ["wheel.pin", "rod.big"]}
    joints["small"] = {"type": "revolute", "between": ["rod.small", "slider.pin"]}
    joints["guide"] = {"type": "prismatic", "between": ["ground.axle", "slider.pin"]}
    joint = {"clearance": 1e-4, "bearing_radius": 0.01, "contact": CONTACT}
    source["joints"] = {"big": joint, "small": joint}
    source["drive"]["speed"] = 100.0
    as_before = clearsweep.simulate(clearsweep.load_case(source), times=[0.0])
    bodies["rod"]["initial"] = {"x": 0.05005, "angle": 0.0, "vy": 5.0, "rate": -30.0}
    moved = clearsweep.simulate(clearsweep.load_case(source), times=[0.0])
    assert moved["rod/x"][0] == 0.05005
    assert moved["rod/rate"][0] == -30.0
    assert moved["joints/big/x"][0] == pytest.approx(as_before["joints/big/x"][0] + 5e-5, abs=1e-12)
    for joint in ("big", "small"):
        ideal = f"{joint}_force_peak_ideal"
        assert moved.summary[ideal] == as_before.summary[ideal] > 0.0


def test_a_start_within_the_wall_is_refused_with_its_place_before_anything_runs(tmp_path):
    """Of a sweep if neither its first nor its last case can start; otherwise the cases say it, the dry run too."""
    file = tmp_path / "grid.json"
    file.write_text(json.dumps(grid(x=0.051)), encoding="utf-8")
    with pytest.raises(InputError, match=r"grid\.json:1:\d+: joints\.ring: its bodies penetrate each other by 1000 um"):
        clearsweep.sweep(file, out=tmp_path / "run")
    both = grid(x=0.051) | {"sweep": {"mechanism.bodies.ball.initial.x": [0.051, 0.0]}}
    estimated = estimate.estimate(both, out=tmp_path / "run", jobs=1)
    assert any(
        text.startswith("1 of 2 timed cases would fail, for example: refused: joints.ring: its bodies penetrate")
        for text in estimated.warnings
    )
    result = clearsweep.sweep(both, out=tmp_path / "run", executor="serial", show_progress=False)
    assert (result.ok, result.failed) == (1, 1)


def test_a_free_body_is_drawn_where_it_starts():
    case = clearsweep.load_case(grid(**BALL)).case
    (ball,) = (body for body in simulation.sketch(case).bodies if body.name == "ball")
    assert tuple(ball.center) == pytest.approx((2e-3, -1e-3))
    assert ball.angle == 0.3


# ---------------------------------------------------------------------------------------------- at limits


def test_a_pin_may_start_anywhere_along_its_slot():
    def slotted(distance):
        source = grid(x=distance, y=0.04)
        source["mechanism"]["joints"]["ring"] = {"type": "slot", "between": ["ground.ring", "ball.middle"], "axis": 0.0}
        source["joints"]["ring"]["slot_length"] = 2.0
        return clearsweep.load_case(source)

    slotted(-0.999)
    with pytest.raises(InputError, match=r"penetrate each other by 39442\.7 um"):  # hypot(1.08 - 1, 0.04) - 0.05 m
        slotted(1.08)


@pytest.mark.parametrize("rounding", [0.0, 1e-17, 5e-16])
@pytest.mark.parametrize("rate", [0.0, -0.1])
def test_bodies_may_touch_at_the_start_and_are_pressed_from_there_on(rounding, rate):
    """A ball let go on the ring deflects it as a suddenly applied weight does; a fast one as in an impact."""
    source = grid(9.81, y=-0.05 - rounding, vy=rate) | {"drive": {"speed": 10.0}}
    source["simulate"]["revolutions"] = 0.02
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert (path.events["t"][0], path.events["kind"][0]) == (0.0, "on")
    peak = path.summary["ring_force_peak"]
    deepest = (peak / 1e9) ** (2.0 / 3.0)  # m
    assert 0.4 * peak * deepest == pytest.approx(0.05 * rate**2 + 0.981 * deepest, rel=1e-6)


def sprung(free_length, damping=0.5):
    """Return the grid of a ball on a spring whose ends coincide at the start."""
    source = grid(9.81, x=0.0)
    source["joints"]["ring"] |= {"clearance": 10.0, "bearing_radius": 20.0}
    source["loads"] = {
        "string": {
            "between": ["ground", "ball"],
            "anchor": [0.0, 0.0],
            "point": "middle",
            "stiffness": 10.0,
            "free_length": free_length,
            "damping": damping,
        }
    }
    source["drive"] = {"speed": 2.0 * math.pi}
    return source


def test_a_spring_may_start_without_length():
    """A ball of 0.1 kg falls on its spring: the damped oscillator, up to its first return."""
    path = clearsweep.simulate(clearsweep.load_case(sprung(0.0)), times=np.linspace(0.0, 0.25, 26))
    decay, sag = 0.5 / 0.2, 0.0981  # 1/s, m
    rate = math.sqrt(100.0 - decay**2)
    t = path.t
    exact = -sag * (1.0 - np.exp(-decay * t) * (np.cos(rate * t) + decay / rate * np.sin(rate * t)))
    assert path["ball/y"] == pytest.approx(exact, abs=1e-9)


def test_a_slow_shaft_beside_a_fast_body_changes_nothing():
    def bounced(speed):
        source = grid(9.81, y=-0.04, vx=0.3) | {"drive": {"speed": speed}}
        source["simulate"] |= {"revolutions": 0.1 * speed / (2.0 * math.pi), "tolerance": 1e-10}
        return clearsweep.simulate(clearsweep.load_case(source), times=[0.0, 0.02])

    fast, slow = bounced(100.0), bounced(2e-7 * math.pi)
    assert slow.status == "ok"
    assert slow.summary["steps"] < 3 * fast.summary["steps"]
    assert slow["ball/y"][-1] == pytest.approx(fast["ball/y"][-1], abs=1e-8)


def test_a_film_beside_a_slow_shaft_does_not_end_in_ever_smaller_steps():
    source = grid(vx=0.1) | {"drive": {"speed": 2e-7 * math.pi}}
    film = {"law": "short", "viscosity": 0.1}
    source["joints"]["ring"] = {"clearance": 1e-3, "bearing_radius": 0.02, "length": 0.01, "film": film}
    source["simulate"] |= {"revolutions": 0.2 * 1e-7, "tolerance": 1e-8}
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "ok"
    assert path.summary["steps"] < 5000


def pattern(contacts, touching, pieces=()):
    """Return the index of a set of touching contacts, with the pieces of their laws, among the first lengths."""
    mode = np.full(contacts, FREE)
    mode[list(touching)] = PRESSED
    size, method = 2 << min(contacts + PIECE_BITS, MAX_PATTERN_BITS), SimpleNamespace(current=0)
    latched = np.append(np.zeros(contacts), pieces)
    work = SimpleNamespace(mode=mode, latched=latched, proposals=np.zeros(size), method=method)
    return contact_pattern((work,))


def test_sets_of_contacts_have_lengths_of_their_own_in_little_memory():
    assert len({pattern(4, touching) for n in range(5) for touching in itertools.combinations(range(4), n)}) == 16
    pairs = [pattern(50, touching) for touching in itertools.combinations(range(50), 2)]
    assert max(pairs) < 1 << MAX_PATTERN_BITS
    assert len(set(pairs)) > 0.7 * len(pairs)
    with_pieces = itertools.product(([], [0], [1], [0, 1]), range(-1, 6))
    assert len({pattern(2, touching, [float(piece)]) for touching, piece in with_pieces}) == 28


@pytest.mark.slow
def test_ten_guides_with_clearance_run():
    source = grid()
    bodies, joints = source["mechanism"]["bodies"], source["mechanism"]["joints"]
    del bodies["ball"], joints["ring"], source["joints"]["ring"]
    for i in range(10):
        bodies[f"b{i}"] = {"mass": 1.0, "inertia": 1.0, "points": {"p": STILL}, "initial": {"y": -5e-4 * (i + 1)}}
        bodies[f"b{i}"]["initial"] |= {"vy": -0.1} if i == 9 else {}
        before = f"b{i - 1}.p" if i else "ground.ring"
        joints[f"k{i}"] = {"type": "prismatic", "between": [before, f"b{i}.p"], "axis": 0.0}
        source["joints"][f"k{i}"] = {"clearance": 1e-3, "length": 0.1, "height": 1e-3, "contact": CONTACT}
    path = clearsweep.simulate(clearsweep.load_case(source))
    assert path.status == "ok"
    assert path.summary["k9_force_peak"] > 100.0  # N
    assert sum(path[f"b{i}/vy"][-1] for i in range(10)) < 0.0
