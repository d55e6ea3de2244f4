"""Wear in a mechanism against a second program: its motion, the documented pressure, and its own sums over both."""

import functools
import math

import numpy as np
import pytest
from absolute_crank import Crank, Damped, seat, start_of
from mechanism_cases import SLIDER_CRANK, slider_crank
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq
from wear_oracle import Sizes, bin_edges, persson, spread

import clearsweep
from clearsweep import grid as grid_of
from clearsweep import simulation
from clearsweep.mechanics.wear import Worn

pytestmark = [pytest.mark.heavy, pytest.mark.compiled, pytest.mark.slow]

SIZES, LENGTH, BINS = Sizes(5e-5, 0.01), 0.02, 180
MODULUS = 5e9  # Pa: a bearing of plastic, so that arcs are wide
RUNNING_IN = {"bearing_initial": 4e-14, "journal_initial": 2e-14, "distance": 0.02}  # m^2/N, m
STEADY = {"bearing_coefficient": 1e-14, "journal_coefficient": 5e-15}  # m^2/N
CONTACT = {"law": "lankarani-nikravesh", "stiffness": 6.61e10, "restitution": 0.3, "onset": "first"}
TURN, SETTLED = 60.0 / 5000.0, 6  # s, revolutions


def grid(revolutions, running_in, **more):
    """Return the grid of a joint that has settled on its bearing and wears from then on."""
    wear = {"law": "archard", "pressure": "persson", "pressure_modulus": MODULUS, "bins": BINS} | STEADY
    changes = {"joints.rod-slider.contact": CONTACT, "joints.rod-slider.clearance": SIZES.clearance}
    changes |= {"joints.rod-slider.wear": wear | ({"running_in": running_in} if running_in else {})}
    changes |= {"simulate.revolutions": revolutions, "simulate.discard": SETTLED, "simulate.tolerance": 1e-11}
    return slider_crank("rod-slider", changes=changes | more)


class Rubbed:
    """One revolution of the second program from the state of a run, wear summed up over even times."""

    def __init__(self, result, samples=6001):
        """Go on from the settled motion; found : a run whose first sample is at the end of `discard`."""
        crank = Crank(
            SLIDER_CRANK["mechanism"], 2.0 * math.pi / TURN, {"rod-slider": (Damped(6.61e10, 0.3), None, SIZES)}
        )
        start = start_of(crank, result)
        seat(crank, start)
        crank.contacts[0].onset = result.summary["rod_slider_onset_rate"]
        self.times = np.linspace(result.t[0], result.t[0] + TURN, samples)
        states, message = crank.run(start, self.times)
        assert crank.events == []  # it never parts
        self.load, self.slip = message[:, 0, 0] / LENGTH, np.abs(message[:, 0, 2])
        end = states[:, 3:5] + 0.06 * np.array([np.cos(states[:, 5]), np.sin(states[:, 5])]).T
        off = end - states[:, 6:8]  # the journal, on the rod, in the bearing of the slider
        angle = np.arctan2(off[:, 1], off[:, 0])
        self.angles = angle, angle - states[:, 5]
        self.sliding_distance = np.concatenate(
            [[0.0], np.cumsum(0.5 * np.diff(self.times) * (self.slip[1:] + self.slip[:-1]))]
        )
        self.states = states

    @functools.cached_property
    def arcs(self):
        """Return half of the arc (rad) and the pressure of each moment, the same arc on both bodies."""
        return [persson(load, SIZES.bearing, 0.0, MODULUS, SIZES) for load in self.load]

    def worn(self, body, coefficients):
        """Return the bins (m) of bearing (0) or journal (1) after the revolution; coefficients : at each time."""
        radius = (SIZES.bearing, SIZES.bearing - SIZES.clearance)[body]
        worn = np.zeros(BINS)
        weights = np.full(len(self.times), self.times[1] - self.times[0])
        weights[[0, -1]] *= 0.5
        for k, (half, pressure) in enumerate(self.arcs):
            edges = bin_edges(self.angles[body][k], BINS)
            order = np.argsort(edges[:, 0])
            sums, _ = spread(pressure, half, SIZES.bearing, np.append(edges[order, 0], math.inf), 401)
            worn[order] += weights[k] * coefficients[k] * self.slip[k] * sums
        return worn / (radius * 2.0 * math.pi / BINS)

    def falling(self, body):
        """Return the coefficient (m^2/N) of a body at each time while it runs in."""
        steady, first = list(STEADY.values())[body], list(RUNNING_IN.values())[body]
        return steady + (first - steady) * np.exp(-self.sliding_distance / RUNNING_IN["distance"])


@pytest.fixture(scope="module")
def both():
    """Return a run of one revolution and the second program after it."""
    times = np.linspace(SETTLED * TURN, (SETTLED + 1) * TURN, 101)
    result = clearsweep.simulate(clearsweep.load_case(grid(SETTLED + 1, RUNNING_IN)), times=times)
    assert result.status == "ok"
    return result, Rubbed(result)


def test_perssons_pressure_wears_both_bodies_as_the_second_program_says(both):
    result, own = both
    assert result["joints/rod_slider/force_normal"] == pytest.approx(own.load[::60] * LENGTH, rel=1e-6)
    for body, depths in enumerate(result.wear["rod_slider"]):
        expected = own.worn(body, own.falling(body))
        assert depths.sum() == pytest.approx(expected.sum(), rel=1e-4)
        assert depths == pytest.approx(expected, rel=0.0, abs=1e-4 * expected.max())
    half = np.array([first for first, _ in own.arcs])
    assert half.max() > 0.5  # rad: conformal
    peaks = np.array([pressure(np.zeros(1))[0] for _, pressure in own.arcs])
    summary = result.summary
    assert summary["rod_slider_pressure_peak"] == pytest.approx(peaks.max(), rel=1e-4)
    assert summary["rod_slider_pv_peak"] == pytest.approx((peaks * own.slip).max(), rel=1e-4)
    sums = [spread(pressure, first, SIZES.bearing, np.zeros(1), 2001)[1] for first, pressure in own.arcs]
    mean = np.mean(np.array(sums) / (2.0 * SIZES.bearing * half))
    assert summary["rod_slider_pressure_mean"] == pytest.approx(mean, rel=1e-3)


def test_a_joint_that_runs_in_lives_as_long_as_the_second_program_says(both):
    """The motion does not change, so the deepest bin is a sum over revolutions of a coefficient that falls."""
    _, own = both
    per_turn, distance, limit = own.sliding_distance[-1], 150.0, 2e-5
    once = np.ones(len(own.times))
    bins = [own.worn(body, once).max() for body in range(2)]  # m per revolution and m^2/N

    def depth(turns):
        fresh = distance / per_turn * (1.0 - math.exp(-turns * per_turn / distance))
        message = zip(bins, STEADY.values(), list(RUNNING_IN.values())[:2], strict=True)
        return max(single * (steady * turns + (first - steady) * fresh) for single, steady, first in message)

    expected = brentq(lambda turns: depth(turns) - limit, 1.0, 1e9)
    life = {"limit": limit, "joint": "rod-slider", "max_revolutions": 20, "tolerance": 0.02}
    more = {"life": life, "save.orbits": "last", "save.revolutions": 1, "save.samples": 36}
    result = clearsweep.simulate(clearsweep.load_case(grid(SETTLED + 8, RUNNING_IN | {"distance": distance}, **more)))
    assert result.status == "ok"
    summary = result.summary
    # blocks of some revolutions represent their beginnings, so a life comes out too long by half a block at most
    assert summary["rod_slider_life_revolutions"] == pytest.approx(expected, rel=2e-3)


# ---------------------------------------------------------------------------------------------- worn springs

LAYER = {"law": "hertz", "elastic": "winkler", "thickness": 5e-3, "material": {"young": 207e9, "poisson": 0.3}}
SPRING = 0.7 * 207e9 / (1.3 * 0.4 * 5e-3)  # Pa/m
OPEN, NODES = Sizes(0.5e-3, 0.01), np.polynomial.legendre.leggauss(24)
SPREAD = math.radians(1.0)  # of the Gaussian that smooths what is worn
WAVES = (2, 5e-5, 0.3), (3, 2e-5, 1.0)  # of bearing and journal: harmonic, m, rad


def mean_depths(wave, bins=360):
    """Return the mean depth (m) of h = a (1 + cos(m phi + b)) over each bin."""
    m, a, b = wave
    edges = np.arange(bins + 1) * 2.0 * math.pi / bins
    return np.diff(a * (edges + np.sin(m * edges + b) / m)) * bins / (2.0 * math.pi)


def smoothed(wave, phi, slope=False):
    """Return that h (m) after the Gaussian, or its slope (m/rad)."""
    m, a, b = wave
    left = a * math.exp(-0.5 * (m * SPREAD) ** 2)
    return -m * left * np.sin(m * phi + b) if slope else a + left * np.cos(m * phi + b)


class Bedded(Crank):
    """A slider-crank whose small end presses with springs wherever its worn surfaces overlap."""

    def overlap(self, y, phi):
        """Return by how much (m) the surfaces are in each other at angles (rad) of the fixed frame."""
        place = -self.gap(y, self.contacts[0].bodies)[0]
        worn = smoothed(WAVES[0], phi) + smoothed(WAVES[1], phi - y[5])
        return place[0] * np.cos(phi) + place[1] * np.sin(phi) - OPEN.clearance - worn

    def arc(self, y):
        """Return the angle of the deepest point and the ends of the arc (rad), and how deep (m) it is."""
        fan = np.linspace(-math.pi, math.pi, 721)
        top = fan[np.argmax(self.overlap(y, fan))]
        for _ in range(6):  # parabolas through three points close in on it
            step = 1e-4
            low, here, high = self.overlap(y, top + step * np.array([-1.0, 0.0, 1.0]))
            top += 0.5 * step * (low - high) / (low - 2.0 * here + high)
        deep = float(self.overlap(y, np.array([top]))[0])
        if deep <= 0.0:
            return top, (top, top), deep
        bend = (low - 2.0 * here + high) / step**2
        ends = []
        for sign in (-1.0, 1.0):
            end = top + sign * math.sqrt(-2.0 * deep / bend)
            for _ in range(8):
                value, beyond = self.overlap(y, np.array([end, end + 1e-7]))
                end -= value * 1e-7 / (beyond - value)
            ends.append(end)
        return top, tuple(ends), deep

    def pressed(self, y):
        """Return force on the journal (2,) N, moment on the rod (N m), and the sum of the pressure (N/m)."""
        _, (low, high), deep = self.arc(y)
        if deep <= 0.0:
            return np.zeros(2), 0.0, 0.0
        phi, weights = 0.5 * (low + high) + 0.5 * (high - low) * NODES[0], 0.5 * (high - low) * NODES[1]
        springs = SPRING * OPEN.bearing * weights * self.overlap(y, phi)  # N/m
        force = -LENGTH * np.array([springs @ np.cos(phi), springs @ np.sin(phi)])
        return force, -LENGTH * springs @ smoothed(WAVES[1], phi - y[5], slope=True), springs.sum()

    def seen(self, y, contact):
        """Return the depth alone, by which contacts begin and end."""
        return self.arc(y)[2], 1.0, 0.0

    def forces(self, y):
        """Return the accelerations, and the resultant (N) of the springs with nothing else."""
        contact = self.contacts[0]
        force, moment, _ = self.pressed(y) if contact.touching else (np.zeros(2), 0.0, 0.0)
        applied = -self.gap(y, contact.bodies)[3].T @ force
        applied[5] += moment
        kept, contact.touching = contact.touching, False
        self.contacts = []
        free, _ = super().forces(y)
        self.contacts, contact.touching = [contact], kept
        return free + self.answer(y, applied), [(math.hypot(*force), 0.0, 0.0, 0.0)]

    def answer(self, y, applied):
        """Return the accelerations that forces on the coordinates add."""
        rows = [np.eye(9)[k] for k in (2, 7, 8)]
        for bodies in self.ideal:
            rows += [*self.gap(y, bodies)[3]]
        rows = np.array(rows)
        whole = np.block([[np.diag(self.masses), rows.T], [rows, np.zeros((len(rows), len(rows)))]])
        return np.linalg.solve(whole, np.append(applied, np.zeros(len(rows))))[:9]


def test_springs_on_worn_surfaces_press_and_wear_as_the_second_program_says():
    """5000 rpm, 0.08 revolutions: normal forces agree to 2e-6 of the largest, worn volumes to 1e-4."""
    wear = {"law": "archard", "coefficient": 2e-14, "bins": 360, "pressure": "winkler", "evolve": True}
    changes = {"joints.rod-slider.contact": LAYER, "joints.rod-slider.wear": wear}
    changes |= {"simulate.revolutions": 0.08, "simulate.tolerance": 1e-11}
    case = grid_of.load(slider_crank("rod-slider", changes=changes), simulation.catalogue()).case(0)
    times = np.linspace(0.0, 0.08 * TURN, 2001)
    scene = simulation.build(case, {"rod-slider": Worn(*map(mean_depths, WAVES))})
    result = clearsweep.simulate(scene, times=times)
    crank = Bedded(SLIDER_CRANK["mechanism"], 2.0 * math.pi / TURN, {"rod-slider": (Damped(1.0, 1.0), None, OPEN)})
    states, message = crank.run(start_of(crank, result), times, longest=2e-6)
    assert [what for *_, what in crank.events].count("onset") > 1
    ends = [t for t, _, what in crank.events if what in ("onset", "separation")]
    assert result.events["t"] == pytest.approx(ends, rel=0.0, abs=2e-8)
    normal = message[:, 0, 0]
    assert result["joints/rod_slider/force_normal"] == pytest.approx(normal, rel=0.0, abs=1e-5 * normal.max())
    worn = np.zeros((2, 360))
    for y in states:
        top, (low, high), deep = crank.arc(y)
        if deep <= 0.0:
            continue
        _, moving, _, _ = crank.gap(y, crank.contacts[0].bodies)
        journal = OPEN.bearing - OPEN.clearance - smoothed(WAVES[1], top - y[5])
        force = crank.pressed(y)[0]  # sliding is across the resultant, rolling that of the deepest point
        slip = moving @ np.array([-force[1], force[0]]) / math.hypot(*force) + y[14] * journal
        phi = np.linspace(low, high, 401)
        sums = np.concatenate([[0.0], cumulative_trapezoid(SPRING * OPEN.bearing * crank.overlap(y, phi), phi)])
        for body, (turned, radius) in enumerate(((0.0, OPEN.bearing), (y[5], OPEN.bearing - OPEN.clearance))):
            edges = bin_edges(0.5 * (low + high) - turned, 360)
            order = np.argsort(edges[:, 0])
            positions = np.append(edges[order, 0], math.inf) + 0.5 * (low + high)
            lost = 2e-14 * abs(slip) * (times[1] - times[0]) * np.diff(np.interp(positions, phi, sums))
            worn[body, order] += lost / (radius * 2.0 * math.pi / 360)
    for depths, expected in zip(result.wear["rod_slider"], worn, strict=True):
        assert depths.sum() == pytest.approx(expected.sum(), rel=5e-4)
        assert depths == pytest.approx(expected, rel=0.0, abs=1e-3 * expected.max())
