"""Loops of dyads in closed form, against Newton's method on the equations of the same loops."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planar_machines import ground, guide, pin

from clearsweep.contracts.machine import Aim, Body, Constant, Machine, Motor
from clearsweep.mechanics.machines import planar
from clearsweep.mechanics.machines.contract import pose_at
from clearsweep.tracing.compiled.choosing import lane_range
from clearsweep.tracing.compiled.dual import Dual, Seeded, slope
from clearsweep.tracing.objects import machine_code

LANES = 8
ROUNDING = 4e-15  # m and rad, in machines of half a metre
CRANK = Body(0.3, 1e-4, (0.02, 0.003), {"o": (0.0, 0.0), "a": (0.05, 0.0)})
shares, angles, sides = st.floats(0.0, 1.0), st.floats(-3.0, 3.0), st.sampled_from([-1.0, 1.0])
KINDS = "RRR", "RRP", "RPR", "RPP"


def body(length, centre):
    """Return a body with points at both ends of a length."""
    return Body(0.2, 1e-4, centre, {"o": (0.0, 0.0), "a": (length, 0.0)})


@st.composite
def machines(draw, kind):
    """Return a machine of one dyad on a crank: pins (R) and guides (P) in the order from the crank to the ground."""
    centres = [(0.1 * draw(shares), 0.1 * draw(shares) - 0.05) for _ in range(2)]
    turned, side = draw(angles), draw(sides)
    first, second = (0.35 + 0.1 * draw(shares) for _ in range(2))
    distance, offset = 0.3 + 0.2 * draw(shares), 0.1 * draw(shares) - 0.05
    foot = distance * math.cos(turned), distance * math.sin(turned)
    base, start = ground(main=(0.0, 0.0), foot=foot), {}
    if kind == "RRR":
        reach = math.dist(foot, (0.05, 0.0))
        inner = math.acos((first**2 + reach**2 - second**2) / (2.0 * first * reach))
        link = math.atan2(foot[1], foot[0] - 0.05) + side * inner
        pinned = 0.05 + first * math.cos(link) - foot[0], first * math.sin(link) - foot[1]
        start = {"link": link, "end": math.atan2(*pinned[::-1])}
        joints = pin("middle", "link.a", "end.a"), pin("last", "ground.foot", "end.o")
    elif kind == "RRP":
        base = ground(main=(0.0, 0.0), foot=(offset * math.sin(turned), -offset * math.cos(turned)))
        start = {"link": turned if side > 0.0 else turned + math.pi}
        joints = pin("middle", "link.a", "end.o"), guide("last", "ground.foot", "end.o", turned)
    elif kind == "RPR":
        start = dict.fromkeys(("link", "end"), math.atan2(-foot[1], 0.05 - foot[0]))
        second = offset  # the pin of the guide next to the line
        joints = guide("middle", "end.a", "link.o", 0.3 * turned), pin("last", "ground.foot", "end.o")
    else:
        joints = (
            guide("middle", "end.o", "link.o", turned + 0.5 + 2.0 * draw(shares)),
            guide("last", "ground.foot", "end.o", turned),
        )
    bodies = {"ground": base, "crank": CRANK, "link": body(first, centres[0]), "end": body(second, centres[1])}
    joints = pin("main", "ground.main", "crank.o"), pin("first", "crank.a", "link.o"), *joints
    return Machine(bodies, joints, "main", Constant(10.0), 9.81, Aim("end"), start=start)


def built_of(machine, turns, moved=0.0):
    """Return the compiled machine with its crank's pin moved (m), and its state after some turns of a free crank."""
    built = planar.build(machine._replace(drive=Motor(1.0, 100.0, 10.0, 0.0)), {}, {})
    first = built.value.joints[1]
    end = first.proximal._replace(point=first.proximal.point._replace(x=first.proximal.point.x + moved))
    value = built.value._replace(joints=(built.value.joints[0], first._replace(proximal=end), *built.value.joints[2:]))
    assert value.sides
    return value, built.start + np.array([2.0 * math.pi * turns, 0.0, 0.0])


def numbers_of(pose):
    """Return the numbers of a pose, those of its rates apart."""
    orientations = [number for orientation in pose.orientations for number in orientation[:3]]
    rates = [orientation.rate for orientation in pose.orientations] + [rate for _, rate in pose.travels]
    return [*orientations, *(travel for travel, _ in pose.travels)], rates


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data(), turns=st.floats(-3.0, 3.0), moved=st.floats(-1e-3, 1e-3))
def test_a_dyad_is_where_newtons_method_puts_it(kind, data, turns, moved):
    value, y = built_of(data.draw(machines(kind)), turns, moved)
    (places, rates), (expected, expected_rates) = (
        numbers_of(pose_at(form, y)) for form in (value, value._replace(sides=()))
    )
    assert places == pytest.approx(expected, rel=0.0, abs=ROUNDING)
    assert rates == pytest.approx(expected_rates, rel=0.0, abs=20.0 * ROUNDING * max(map(abs, expected_rates)))


@pytest.mark.parametrize("kind", KINDS)
@given(data=st.data(), turns=st.floats(-3.0, 3.0))
def test_a_dyad_has_the_derivatives_of_newtons_method(kind, data, turns):
    value, y = built_of(data.draw(machines(kind)), turns)
    for state in (Seeded(y, 0), nested(y)):
        closed, expected = (
            parts([*places, *rates])
            for places, rates in (numbers_of(pose_at(form, state)) for form in (value, value._replace(sides=())))
        )
        assert closed == pytest.approx(expected, rel=0.0, abs=1e-11 * max(map(abs, expected)))


def nested(y):
    """Return a state whose numbers have slopes of slopes."""
    return tuple([Dual(Dual(y[i], 0.3), Dual(1.0, 0.0)) for i in range(3)])


def parts(numbers):
    """Return the values and slopes of numbers at all depths."""
    return [leaf for x in numbers for leaf in (parts([x.value, x.slope]) if isinstance(x, Dual) else [x])]


@given(data=st.data(), exponent=st.floats(-15.0, -1.0), side=sides)
def test_a_dyad_closes_to_rounding_next_to_its_dead_centres(data, exponent, side):
    machine = data.draw(machines("RRR"))
    first, second = (machine.bodies[name].points["a"][0] for name in ("link", "end"))
    x, y = machine.bodies["ground"].points["foot"]
    pin_x = x + side * math.sqrt(((first + second) * (1.0 - 10.0**exponent)) ** 2 - y**2)
    value, state = built_of(machine, 0.0, pin_x - 0.05)
    link, end = pose_at(value, state).orientations[1:]
    gap = pin_x + first * link.c - x - second * end.c, first * link.s - y - second * end.s
    assert gap == pytest.approx((0.0, 0.0), abs=1e-15)
    for part in (link, end):
        assert math.hypot(part.c, part.s) == pytest.approx(1.0, abs=2e-15)


@given(data=st.data(), turns=st.floats(-3.0, 3.0))
def test_a_loop_that_cannot_close_has_no_position(data, turns):
    value, y = built_of(data.draw(machines("RRR")), turns, 5.0)
    assert math.isnan(pose_at(value, y).orientations[1].c)


@machine_code
def directions_in_lanes(value, y, out):
    """Write cosine and sine of the last body to out (2, LANES), from states y (n, LANES)."""
    for i in lane_range(LANES):
        pose = pose_at(value, y[:, i])
        out[0, i], out[1, i] = pose.orientations[-1].c, pose.orientations[-1].s


@pytest.mark.parametrize("kind", ["RRR", "RRP", "RPR"])
@given(data=st.data(), turns=st.floats(-3.0, 3.0))
def test_eight_dyads_in_lanes_are_each_alone(kind, data, turns):
    value, y = built_of(data.draw(machines(kind)), turns)
    in_lanes = np.repeat(y[:, None], LANES, axis=1)
    in_lanes[0] += np.linspace(0.0, 6.0, LANES)
    out = np.zeros((2, LANES))
    directions_in_lanes(value, in_lanes, out)
    alone = [pose_at(value, in_lanes[:, i]).orientations[-1] for i in range(LANES)]
    assert out == pytest.approx(np.array([[part.c for part in alone], [part.s for part in alone]]), rel=0.0, abs=1e-15)


def second_derivatives(value, y):
    """Return mixed second derivatives of the direction of the last body, by two directions of the state."""
    last = pose_at(value, nested(y)).orientations[-1]
    return slope(slope(last.c)), slope(slope(last.s))


compiled_derivatives = machine_code(second_derivatives)


@pytest.mark.parametrize("kind", ["RRR", "RRP", "RPR"])
@given(data=st.data(), turns=st.floats(-3.0, 3.0))
def test_compiled_dyads_have_second_derivatives(kind, data, turns):
    value, y = built_of(data.draw(machines(kind)), turns)
    assert compiled_derivatives(value, y) == pytest.approx(second_derivatives(value, y), rel=1e-12, abs=1e-12)
