"""The equations of motion of docs/model.md, put together from virtual powers, give the accelerations of the code."""

import itertools
from typing import NamedTuple

import numpy as np
import pytest

from clearsweep.mechanics.joint.contract import PRESSED
from clearsweep.mechanics.joint.dry import Gap, Joint, joint_load
from clearsweep.mechanics.joint.elastic.power import PowerThreeHalves
from clearsweep.mechanics.joint.friction.sliding import Tanh
from clearsweep.mechanics.joint.loss.hysteresis import Lossless
from clearsweep.mechanics.mechanism.contract import Ideal, Open, accelerate, gaps, place
from clearsweep.mechanics.mechanism.slider_crank.pose import Links, SliderCrank

LINKS = Links(0.05, 0.02, 0.3, 1e-4, 0.12, 0.07, 0.21, 2.5e-4, 0.14, 9.81, 300.0)


class Load(NamedTuple):
    """What the equations of motion take of a joint."""

    fx: float  # N, on the distal body
    fy: float  # N
    moment_proximal: float  # N m
    moment_distal: float  # N m


OPENINGS = [opening for count in (1, 2, 3) for opening in itertools.combinations("ABC", count)]
STEP = 1e-30  # of the complex step, whose derivative has no rounding


def positions(opening, q, theta):
    """Return (r1, r2, r3, e_A, e_B, e_C), (6, 2), as the page's table of coordinates has them; any kind of number."""
    l1, s1, l2, s2 = LINKS.crank_length, LINKS.crank_center, LINKS.rod_length, LINKS.rod_center
    u1, u2 = (np.array([np.cos(angle), np.sin(angle)]) for angle in (theta, q[0]))
    zero, slider = np.zeros(2), np.array([q[1], 0.0])
    if opening == ("C",):
        a, b = zero, l1 * u1
    elif opening == ("B",):
        a, b = zero, slider - l2 * u2
    elif opening == ("A",):
        b = slider - l2 * u2
        a = b - l1 * u1
    elif opening == ("A", "B"):
        a, b = np.array(q[2:4]), slider - l2 * u2
    elif opening == ("A", "C"):
        a = np.array(q[2:4])
        b = a + l1 * u1
    else:
        b = np.array(q[2:4]) - s2 * u2
        a = np.array(q[4:6]) if opening == ("A", "B", "C") else zero
    return np.array([a + s1 * u1, b + s2 * u2, slider, a, b - a - l1 * u1, slider - b - l2 * u2])


def slopes(opening, q, theta):
    """Return the derivatives of the positions with respect to coordinates and crank angle, (6, 2, n + 1)."""
    columns = []
    for i in range(len(q) + 1):
        shifted = np.append(q, theta).astype(complex)
        shifted[i] += 1j * STEP
        columns.append(positions(opening, shifted[:-1], shifted[-1]).imag / STEP)
    return np.stack(columns, axis=-1)


def expected(opening, q, v, theta, loads):
    """Return accelerations and drive torque by the principle of virtual power."""
    n, speed = len(q), LINKS.speed
    motion = np.append(v, speed)
    jacobian = slopes(opening, q, theta)

    def velocity(share):
        moved = np.append(q, theta) + share * motion
        return slopes(opening, moved[:-1], moved[-1]) @ motion

    def difference(h):
        return (velocity(h) - velocity(-h)) / (2.0 * h)

    bias = (4.0 * difference(1e-6) - difference(2e-6)) / 3.0  # accelerations while the coordinates do not accelerate
    masses = np.array([LINKS.crank_mass, LINKS.rod_mass, LINKS.slider_mass])
    gravity = np.array([0.0, -LINKS.gravity])
    mass = np.einsum("b,bxi,bxj->ij", masses, jacobian[:3], jacobian[:3])
    mass[0, 0] += LINKS.rod_inertia
    right = np.einsum("b,bxi,bx->i", masses, jacobian[:3], gravity - bias[:3])
    turned = {"A": (None, n), "B": (n, 0), "C": (0, None)}  # coordinates that are angles of proximal and distal body
    for joint, load in zip(opening, loads, strict=True):
        right += np.array([load.fx, load.fy]) @ jacobian[3 + "ABC".index(joint)]
        for place_, moment in zip(turned[joint], (load.moment_proximal, load.moment_distal), strict=True):
            if place_ is not None:
                right[place_] += moment
    accelerations = np.linalg.solve(mass[:n, :n], right[:n])
    return accelerations, mass[n, :n] @ accelerations - right[n]


def sides(opening, state, motion, loads):
    """Return left and right sides of the page's equations of an opening, with these accelerations, as two arrays."""
    q, v, theta = state
    l1, s1, m1 = LINKS.crank_length, LINKS.crank_center, LINKS.crank_mass
    l2, s2, m2, j2 = LINKS.rod_length, LINKS.rod_center, LINKS.rod_mass, LINKS.rod_inertia
    m3, gravity, speed = LINKS.slider_mass, LINKS.gravity, LINKS.speed
    u1, n1 = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
    u2, n2 = np.array([np.cos(q[0]), np.sin(q[0])]), np.array([-np.sin(q[0]), np.cos(q[0])])
    h, k, g, rate = l2 - s2, l1 - s1, np.array([0.0, -gravity]), v[0]
    alpha, x2, *rest = motion.accelerations
    first, second = np.array(rest[:2]), np.array(rest[2:4])
    on = {joint: np.array([load.fx, load.fy]) for joint, load in zip(opening, loads, strict=True)}
    by = dict(zip(opening, loads, strict=True))
    left, right = [], []

    def equation(one, other):
        left.extend(np.atleast_1d(one))
        right.extend(np.atleast_1d(other))

    if opening in (("B",), ("A", "B"), ("A",)):
        hung = m1 if opening == ("A",) else 0.0
        force = on["A"] - m1 * k * speed**2 * u1 + m1 * g if hung else on["B"]
        moment = 0.0 if hung else by["B"].moment_distal
        swing = m2 * h + hung * l2
        equation(
            (j2 + m2 * h**2 + hung * l2**2) * alpha + swing * u2[1] * x2,
            moment - l2 * n2 @ force + m2 * h * gravity * u2[0],
        )
        equation(swing * u2[1] * alpha + (m2 + m3 + hung) * x2, force[0] - swing * rate**2 * u2[0])
        pin = np.array([x2, 0.0]) - l2 * (alpha * n2 - rate**2 * u2)  # of the rod's end b
        on_rod = force - hung * pin if hung else on["B"]
    else:
        equation(m3 * x2, on["C"][0])
        if "B" in opening:
            equation(m2 * first, on["B"] - on["C"] + m2 * g)
            moment = by["B"].moment_distal + by["C"].moment_proximal
            equation(j2 * alpha, moment - s2 * n2 @ on["B"] - h * n2 @ on["C"])
            on_rod = on["B"]
        else:
            pin = (first if "A" in opening else 0.0) - l1 * speed**2 * u1
            moment = by["C"].moment_proximal - l2 * n2 @ on["C"]
            equation((j2 + m2 * s2**2) * alpha + m2 * s2 * n2 @ pin, moment - m2 * s2 * gravity * u2[0])
            on_rod = m2 * (pin + s2 * (alpha * n2 - rate**2 * u2) - g) + on["C"]
            if "A" in opening:
                turning = m2 * s2 * (alpha * n2 - rate**2 * u2) + m1 * k * speed**2 * u1
                equation((m1 + m2) * pin + turning, on["A"] - on["C"] + (m1 + m2) * g)
    if "A" in opening and "B" in opening:
        pivot = second if "C" in opening else first
        equation(m1 * (pivot - s1 * speed**2 * u1), on["A"] - on["B"] + m1 * g)
    on_crank = (by["A"].moment_distal if "A" in opening else 0.0) + (by["B"].moment_proximal if "B" in opening else 0.0)
    fixed = l1 * n1 @ on_rod + m1 * s1 * gravity * u1[0] - on_crank
    equation(motion.torque, s1 * n1 @ on["A"] + k * n1 @ on_rod - on_crank if "A" in opening else fixed)
    return np.array(left, float), np.array(right, float)


@pytest.mark.parametrize("opening", OPENINGS, ids="".join)
def test_the_code_accelerates_as_the_page_says(opening):
    chance = np.random.default_rng(7)
    sites = tuple(Open() if joint in opening else Ideal() for joint in "ABC")
    mechanism = SliderCrank(LINKS, sites)
    n = 2 * len(opening)
    for _ in range(5):
        q = np.concatenate([chance.uniform(-0.5, 0.5, 1), [0.15], chance.uniform(-0.1, 0.1, n - 2)])
        v = chance.uniform(-1.0, 1.0, n) * np.append(100.0, np.full(n - 1, 10.0))
        time = chance.uniform(0.0, 0.02)
        numbers = chance.uniform(-1.0, 1.0, (len(opening), 4)) * [1000.0, 1000.0, 5.0, 5.0]
        loads = tuple(Load(*row) for row in numbers)
        y = np.concatenate([q, v, [time]])
        motion = accelerate(mechanism, place(mechanism, y), loads)
        accelerations, torque = expected(opening, q, v, LINKS.speed * time, loads)
        np.testing.assert_allclose(
            motion.accelerations[:n], accelerations, rtol=1e-7, atol=1e-7 * abs(accelerations).max()
        )
        assert motion.torque == pytest.approx(torque, rel=1e-6, abs=1e-6)
        left, right = sides(opening, (q, v, LINKS.speed * time), motion, loads)
        assert len(left) == n + 1
        np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-9 * abs(left).max())


@pytest.mark.parametrize("opening", OPENINGS, ids="".join)
def test_the_gaps_are_those_of_the_page(opening):
    sites = tuple(Open() if joint in opening else Ideal() for joint in "ABC")
    mechanism = SliderCrank(LINKS, sites)
    n = 2 * len(opening)
    q, v = np.linspace(0.1, 0.2, n), np.linspace(-3.0, 3.0, n)
    y = np.concatenate([q, v, [1e-3]])
    theta = LINKS.speed * 1e-3
    rates = slopes(opening, q, theta) @ np.append(v, LINKS.speed)
    relative = gaps(mechanism, place(mechanism, y))
    for joint in "ABC":
        row = 3 + "ABC".index(joint)
        where, rate = positions(opening, q, theta)[row], rates[row]
        if joint in opening:
            gap = relative[opening.index(joint)]
            np.testing.assert_allclose([gap.x, gap.y, gap.vx, gap.vy], [*where, *rate], rtol=1e-11, atol=1e-11)
        else:
            np.testing.assert_allclose(where, 0.0, atol=1e-15)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_powers_on_both_bodies_add_up_and_leave_the_couple_of_two_contact_points(side):
    """Also against the two bodies turning as one: what they slide at is the penetration times their rate."""
    joint = Joint(5e-4, 0.01, 0.0095, side, Lossless(), PowerThreeHalves(1e9), Tanh(0.3, 1e-3), ())
    pen, spin = 2e-5, (70.0, -20.0)
    gap = Gap(3.12e-4, 4.16e-4, 0.2, -0.4, *spin)
    one = joint_load(joint, gap, PRESSED, pen, 0.1)
    (contact,) = one.contacts
    power = one.fx * gap.vx + one.fy * gap.vy + one.moment_proximal * spin[0] + one.moment_distal * spin[1]
    taken = -contact.normal * contact.rate + contact.tangential * contact.slip
    assert power == pytest.approx(taken, rel=1e-12, abs=0.0)
    couple = gap.x * one.fy - gap.y * one.fx + one.moment_proximal + one.moment_distal
    assert couple == pytest.approx(pen * contact.tangential, rel=1e-9, abs=0.0)
    rigid = gap._replace(vx=-50.0 * gap.y, vy=50.0 * gap.x, spin_proximal=50.0, spin_distal=50.0)
    (contact,) = joint_load(joint, rigid, PRESSED, pen, 0.1).contacts
    assert contact.slip == pytest.approx(50.0 * pen, rel=1e-9, abs=0.0)
