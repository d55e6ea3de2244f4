"""An independent slider-crank with clearance: absolute coordinates, multipliers, numpy and scipy.

It uses no code of the package.  Crank, rod and slider have all their nine coordinates.  The drive, the guide and the
joints without clearance are constraints on accelerations.  Contacts follow docs/model.md; scipy locates the events.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

NAMES = ("ground-crank", "crank-rod", "rod-slider")
GROUND = None


class Karnopp(NamedTuple):
    """Friction that sticks within a band of the sliding speed."""

    coefficient: float  # 1
    static: float  # 1
    stribeck: float  # m/s
    band: float  # m/s

    def kinetic(self, slip):
        """Return the tangential over the normal force of sliding surfaces."""
        fall = (self.static - self.coefficient) * math.exp(-((slip / self.stribeck) ** 2))
        return -math.copysign(self.coefficient + fall, slip)


class Damped:
    """F = K pen^1.5 (1 + 0.75 (1 - e^2) rate / onset rate), at least 0: Lankarani & Nikravesh 1990."""

    events = ("raw",)

    def __init__(self, stiffness, restitution):
        """Take stiffness (N/m^1.5) and restitution (1)."""
        self.stiffness, self.chi = stiffness, 0.75 * (1.0 - restitution**2)

    def raw(self, contact, pen, rate):
        """Return the force (N) before clipping."""
        return self.stiffness * max(pen, 0.0) ** 1.5 * (1.0 + self.chi * rate / contact.onset)


class Yielding:
    """F = K pen^1.5 while it deepens, K ((pen - left) / e^2)^1.5 below the deepest, left = (1 - e^2) deepest."""

    events = ("turn", "reach")

    def __init__(self, stiffness, restitution):
        """Take stiffness (N/m^1.5) and restitution (1)."""
        self.stiffness, self.given_back = stiffness, restitution**2

    def raw(self, contact, pen, rate):
        """Return the force (N)."""
        if contact.deepest == 0.0:
            return self.stiffness * max(pen, 0.0) ** 1.5
        left = (1.0 - self.given_back) * contact.deepest
        return self.stiffness * (max(pen - left, 0.0) / self.given_back) ** 1.5


class Contact:
    """State of a contact that changes only at events."""

    def __init__(self, law, friction, sizes, bodies):
        """Take laws, (clearance, bearing radius) in m, and ((body, its pin), (body, its pin), sign of the gap)."""
        self.law, self.friction, (self.clearance, self.bearing) = law, friction, sizes
        self.journal, self.bodies = self.bearing - self.clearance, bodies
        self.touching, self.stuck, self.onset, self.deepest, self.sense = False, False, 1.0, 0.0, 1.0


class Crank:
    """One scene of a grid in SI; `opened` gives each open joint a law, a friction or None, and two sizes (m)."""

    def __init__(self, mechanism, speed, opened):
        """Read the parameters."""
        crank, rod = mechanism["crank"], mechanism["rod"]
        self.radius, self.length, self.speed = crank["length"], rod["length"], speed
        here, there = crank.get("center", 0.5 * self.radius), rod.get("center", 0.5 * self.length)
        self.centers = here, there
        self.gravity = mechanism.get("gravity", 0.0)
        self.masses = np.array([crank["mass"]] * 2 + [crank["inertia"]] + [rod["mass"]] * 2 + [rod["inertia"]])
        self.masses = np.append(self.masses, [mechanism["slider"]["mass"]] * 2 + [1.0])
        pins = {
            "ground-crank": ((GROUND, 0.0), (0, -here), 1.0),
            "crank-rod": ((0, self.radius - here), (1, -there), 1.0),
            "rod-slider": ((1, self.length - there), (2, 0.0), -1.0),  # the journal is on the rod
        }
        self.ideal = [pins[name] for name in NAMES if name not in opened]
        self.names = [name for name in NAMES if name in opened]
        self.contacts = [Contact(*opened[name], pins[name]) for name in self.names]
        self.events = []

    # ------------------------------------------------------------------------------------------ where things are

    def pin(self, y, body, distance):
        """Return position, velocity and bias acceleration (at zero coordinate accelerations) of a pin of a body."""
        if body is GROUND:
            return np.zeros(2), np.zeros(2), np.zeros(2)
        at, rate = y[3 * body : 3 * body + 3], y[9 + 3 * body : 12 + 3 * body]
        arm = distance * np.array([math.cos(at[2]), math.sin(at[2])])
        return at[:2] + arm, rate[:2] + rate[2] * np.array([-arm[1], arm[0]]), -(rate[2] ** 2) * arm

    def gap(self, y, bodies):
        """Return relative position, velocity and bias acceleration of the distal pin, and its rows."""
        (near, near_arm), (far, far_arm), _ = bodies
        before, after = self.pin(y, near, near_arm), self.pin(y, far, far_arm)
        rows = np.zeros((2, 9))
        for body, arm, sign in ((near, near_arm, -1.0), (far, far_arm, 1.0)):
            if body is not GROUND:
                c, s = arm * math.cos(y[3 * body + 2]), arm * math.sin(y[3 * body + 2])
                rows[0, 3 * body], rows[0, 3 * body + 2] = sign, -sign * s
                rows[1, 3 * body + 1], rows[1, 3 * body + 2] = sign, sign * c
        return *(b - a for a, b in zip(before, after, strict=True)), rows

    def seen(self, y, contact):
        """Return depth, rate, slip, normal and tangent of a contact, rows and bias acceleration of slip."""
        place, moving, free, rows = self.gap(y, contact.bodies)
        (near, _), (far, _), side = contact.bodies
        place, moving, free, rows = side * place, side * moving, side * free, side * rows
        e = math.hypot(*place)
        n = place / e if e > 0.0 else np.array([1.0, 0.0])
        t = np.array([-n[1], n[0]])
        journal, bearing = (far, near) if side > 0.0 else (near, far)
        row, slip = t @ rows, moving @ t
        for body, arm in ((journal, contact.journal), (bearing, -contact.bearing)):
            if body is not GROUND:
                row[3 * body + 2] += arm
                slip += arm * y[11 + 3 * body]
        free_slip = free @ t - (moving @ n) * (moving @ t) / max(e, 1e-300)
        return e - contact.clearance, moving @ n, slip, n @ rows, row, free_slip

    # ------------------------------------------------------------------------------------------ how they move

    def forces(self, y):
        """Return the accelerations (9,), and (normal, tangential, slip, depth) of each open joint.

        Generalised forces act along the rows of depth and slip: -N rows of depth + T rows of slip.
        """
        applied = np.zeros(9)
        applied[1::3] = -self.gravity * self.masses[1::3]
        seen = [self.seen(y, contact) for contact in self.contacts]
        normals, tangentials, sticking = [], [], []
        for contact, (depth, rate, slip, deep, sliding, _) in zip(self.contacts, seen, strict=True):
            normal = max(contact.law.raw(contact, depth, rate), 0.0) if contact.touching else 0.0
            tangential = 0.0
            if contact.friction is not None and normal > 0.0:
                if contact.stuck:
                    sticking.append(len(normals))
                else:
                    tangential = normal * contact.friction.kinetic(slip)
            normals.append(normal)
            tangentials.append(tangential)
            applied = applied - normal * deep + tangential * sliding
        rows, right = [np.eye(9)[2], np.eye(9)[7], np.eye(9)[8]], [0.0, 0.0, 0.0]
        for bodies in self.ideal:
            _, _, free, both = self.gap(y, bodies)
            rows += [*both]
            right += [*-free]
        rows = np.array(rows)
        m = len(rows)
        whole = np.zeros((9 + m, 9 + m))
        whole[range(9), range(9)] = self.masses
        whole[:9, 9:], whole[9:, :9] = rows.T, rows
        sides = np.zeros((9 + m, 1 + len(sticking)))
        sides[:9, 0], sides[9:, 0] = applied, right
        for k, j in enumerate(sticking):
            sides[:9, 1 + k] = seen[j][4]
        result = np.linalg.solve(whole, sides)[:9]
        acceleration = result[:, 0]
        if sticking:
            acceleration, bearing = self.hold(result, seen, sticking, normals)
            for j, force in zip(sticking, bearing, strict=True):
                tangentials[j] = force
        message = [
            (normal, tangential, first[2], first[0])
            for normal, tangential, first in zip(normals, tangentials, seen, strict=True)
        ]
        return acceleration, message

    def hold(self, result, seen, sticking, normals):
        """Return accelerations and forces (N) that let all slips decay at the crank's rate, each as far as possible.

        The slips' rates are b + A T.  Of all combinations of free forces and forces at either limit, exactly one is
        consistent.
        """
        rows = np.array([seen[j][4] for j in sticking])
        expected = np.array([-self.speed * seen[j][2] - seen[j][5] for j in sticking])
        gain, base = rows @ result[:, 1:], rows @ result[:, 0] - expected
        limits = np.array([self.limit(self.contacts[j].friction) * normals[j] for j in sticking])
        best, least = None, math.inf
        for choice in itertools.product((0, 1, -1), repeat=len(sticking)):
            ends = np.array(choice)
            force, inside = ends * limits, np.flatnonzero(ends == 0)
            if inside.size:
                force[inside] = np.linalg.solve(gain[np.ix_(inside, inside)], -(base + gain @ force)[inside])
            rest = base + gain @ force
            scale = np.abs(base).max() + 1e-300
            beyond = max(np.max((np.abs(force) - limits) / limits), np.max(ends * rest / scale))  # T opposes the rest
            if beyond < least:
                best, least = force, beyond
        assert least < 1e-9
        return result[:, 0] + result[:, 1:] @ best, best

    @staticmethod
    def limit(friction):
        """Return the limit of sticking over the normal force: the static coefficient or that at the band's edge."""
        return max(friction.static, abs(friction.kinetic(friction.band)))

    def rates(self, t, y):
        """Return the rates of the state: of nine coordinates and of their rates."""
        return np.concatenate([y[9:], self.forces(y)[0]])

    # ------------------------------------------------------------------------------------------ from event to event

    def watched(self):
        """Return (joint, kind, function) of all possible next events."""
        result = []
        for j, contact in enumerate(self.contacts):
            if not contact.touching:
                result.append((j, "onset", self._event(j, lambda c, d, r, s: d, 1.0)))
                continue
            result.append((j, "separation", self._event(j, lambda c, d, r, s: d, -1.0)))
            if "raw" in contact.law.events:
                result.append(
                    (j, "raw", self._event(j, lambda c, d, r, s: c.law.raw(c, d, r) if d > 1e-12 else 1.0, 0.0))
                )
            if "turn" in contact.law.events and contact.deepest == 0.0:
                result.append((j, "turn", self._event(j, lambda c, d, r, s: r, -1.0)))
            elif "reach" in contact.law.events:
                result.append((j, "reach", self._event(j, lambda c, d, r, s: d - c.deepest, 1.0)))
            if contact.friction is not None and contact.friction.band > 0.0:
                if contact.stuck:  # slightly beyond the band, otherwise it would stick again at once
                    result.append((j, "slip", self._event(j, lambda c, d, r, s: abs(s) - 1.001 * c.friction.band, 1.0)))
                else:
                    result.append((j, "stick", self._event(j, lambda c, d, r, s: c.sense * s - c.friction.band, -1.0)))
        return result

    def _event(self, j, function, direction):
        def value(t, y):
            depth, rate, slip = self.seen(y, self.contacts[j])[:3]
            return function(self.contacts[j], depth, rate, slip)

        value.terminal, value.direction = True, direction
        return value

    def pass_event(self, t, y, j, what):
        """Change the state of a contact at an event."""
        contact = self.contacts[j]
        depth, rate, slip = self.seen(y, contact)[:3]
        if what == "onset":
            contact.touching, contact.onset, contact.deepest = True, max(rate, 1e-3), 0.0
            contact.stuck = bool(contact.friction) and abs(slip) < contact.friction.band
        elif what == "separation":
            contact.touching = contact.stuck = False
            contact.deepest = 0.0
        elif what in ("turn", "reach"):
            contact.deepest = depth if what == "turn" else 0.0
        elif what in ("stick", "slip"):
            contact.stuck = what == "stick"
        contact.sense = math.copysign(1.0, slip)
        if what != "raw":
            self.events.append((t, self.names[j], what))

    def run(self, y, times, rtol=1e-11, longest=math.inf):
        """Return the states (times, 18) and (times, joints, 4) normal, tangential, slip, depth from `y` on."""
        t, states, message = times[0], np.zeros((len(times), 18)), np.zeros((len(times), len(self.names), 4))
        while t < times[-1]:
            watched = self.watched()
            result = solve_ivp(
                self.rates,
                (t, times[-1]),
                y,
                "DOP853",
                events=[function for *_, function in watched],
                rtol=rtol,
                atol=1e-14,
                dense_output=True,
                max_step=longest,
            )
            for i in np.flatnonzero((times >= t) & (times <= result.t[-1])):
                states[i] = result.sol(times[i])
                message[i] = self.forces(states[i])[1]
            t, y = result.t[-1], result.y[:, -1]
            if result.status == 1:
                for (j, what, _), at in zip(watched, result.t_events, strict=True):
                    if len(at):
                        self.pass_event(t, y, j, what)
        return states, message


def seat(crank, y):
    """Press all contacts in the state `y`, as at the start of a seated run."""
    for contact in crank.contacts:
        slip = crank.seen(y, contact)[2]
        contact.touching, contact.onset, contact.sense = True, 1e-3, math.copysign(1.0, slip)
        contact.stuck = contact.friction is not None and abs(slip) < contact.friction.band


def start_of(crank, result, k=0):
    """Return the state at sample `k` of a run's time histories, the common start of both programs."""
    radius, length, (here, there), t = crank.radius, crank.length, crank.centers, result.t[k]
    angle, spin = np.array([crank.speed * t, result["rod/angle"][k]]), np.array([crank.speed, result["rod/rate"][k]])
    distance = np.array([np.cos(angle), np.sin(angle)]).T
    across = spin[:, None] * np.array([-distance[:, 1], distance[:, 0]]).T
    gaps = {}
    for name in NAMES:
        side, column = (-1.0 if name == "rod-slider" else 1.0), name.replace("-", "_")
        keys = [f"joints/{column}/{key}" for key in ("x", "y", "vx", "vy")]
        values = [side * result[key][k] if name in crank.names else 0.0 for key in keys]
        gaps[name] = np.array(values).reshape(2, 2)
    pivot = gaps["ground-crank"]
    crank_pin = pivot + np.array([radius * distance[0], radius * across[0]])
    rod = crank_pin + gaps["crank-rod"]
    slider = rod + np.array([length * distance[1], length * across[1]]) + gaps["rod-slider"]
    bodies = (
        pivot + here * np.array([distance[0], across[0]]),
        rod + there * np.array([distance[1], across[1]]),
        slider,
    )
    y = np.zeros(18)
    for body, at in enumerate(bodies):
        y[3 * body : 3 * body + 2], y[9 + 3 * body : 11 + 3 * body] = at
    y[[2, 5]], y[[11, 14]] = angle, spin
    assert abs(y[7]) < 1e-14  # the slider is on its line
    return y
