"""Free bodies of a planar machine that start where and as fast as their `initial` says."""

import json
import math
from copy import deepcopy

import numpy as np
import pytest

import clearsweep
from clearsweep import simulation
from clearsweep.language.errors import InputError
from clearsweep.sweeping import estimate

pytestmark = pytest.mark.heavy

STILL = [0.0, 0.0]
CONTACT = {"law": "hertz", "stiffness": 1e9, "exponent": 1.5}
BALL = {"x": 2e-3, "y": -1e-3, "angle": 0.3, "vx": 1.0, "vy": 0.5, "rate": 20.0}


def grid(gravity=0.0, **initial):
    """Return a ball in a ring of 50 mm, next to a wheel that is driven."""
    return {
        "mechanism": {
            "type": "planar",
            "gravity": gravity,
            "bodies": {
                "ground": {"points": {"axle": STILL, "ring": STILL}},
                "wheel": {"mass": 1.0, "inertia": 1e-4, "points": {"axle": STILL}},
                "ball": {"mass": 0.1, "inertia": 1e-5, "points": {"middle": STILL}, "initial": initial},
            },
            "joints": {
                "axle": {"type": "revolute", "between": ["ground.axle", "wheel.axle"]},
                "ring": {"type": "revolute", "between": ["ground.ring", "ball.middle"]},
            },
            "driven": "axle",
            "output": {"body": "wheel"},
        },
        "drive": {"speed": 2.0 * math.pi / 0.02},
        "joints": {"ring": {"clearance": 0.05, "bearing_radius": 0.06, "contact": CONTACT}},
        "simulate": {"revolutions": 1, "discard": 0, "tolerance": 1e-11},
        "save": {"orbits": "all"},
    }


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


def messages_of(source):
    """Return the message with which a grid is refused."""
    with pytest.raises(InputError) as caught:
        clearsweep.load_case(source)
    return str(caught.value)


def test_a_start_within_the_wall_is_refused():
    assert "joints.ring: its bodies penetrate each other by 1000 um at the start" in messages_of(grid(x=0.051))


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


def test_a_body_that_an_ideal_joint_holds_has_no_initial():
    source = grid()
    source["mechanism"]["bodies"]["wheel"]["initial"] = {"rate": 1.0}
    assert "axle is ideal and fixes wheel" in messages_of(source)


def test_a_body_cannot_be_seated_and_have_a_start_of_its_own():
    source = grid()
    source["simulate"]["start"] = "seated"
    assert "seated conflicts with mechanism.bodies.ball.initial" in messages_of(source)


def test_the_output_is_not_a_body_without_an_ideal_motion():
    source = grid()
    source["mechanism"]["output"] = {"body": "ball"}
    assert "the output cannot be the free body 'ball'" in messages_of(source)


def test_a_free_body_is_drawn_where_it_starts():
    case = clearsweep.load_case(grid(**BALL)).case
    (ball,) = (body for body in simulation.sketch(case).bodies if body.name == "ball")
    assert tuple(ball.center) == pytest.approx((2e-3, -1e-3))
    assert ball.angle == 0.3


def test_the_identity_of_a_machine_without_initial_has_no_trace_of_it():
    source = deepcopy(grid())
    del source["mechanism"]["bodies"]["ball"]["initial"]
    assert "without clearance it has 2 degrees of freedom" in messages_of(source)
    source = grid(vx=1.0)
    assert "bodies.ball.initial.vx" in clearsweep.load_case(source).case.mechanism.values
    assert not any("wheel.initial" in key for key in clearsweep.load_case(source).case.mechanism.values)
