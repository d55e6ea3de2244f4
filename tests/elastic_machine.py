"""An independent slider-crank with an elastic rod: Lagrange's equations of masses along the rotating line of the rod.

The slider pin has clearance with Lankarani's and Nikravesh's law.  Coordinates: angle of the rod, displacement of each
mass along it, position of the slider; integrated with scipy from event to event.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp

CRANK, LENGTH, MASS, INERTIA, SLIDER = 0.05, 0.12, 0.21, 2.5e-4, 0.14
CLEARANCE, STIFFNESS, RESTITUTION = 0.5e-3, 6.61e10, 0.9


class Rod:
    """The machine at a crank speed (rad/s) with an axial stiffness (N/m) of its rod in segments."""

    def __init__(self, speed: float, axial: float, segments: int, damping: float = 0.0):
        self.speed, self.spring, self.segments = speed, segments * axial, segments
        self.damping = self.spring * 2.0 * damping / (math.pi * math.sqrt(axial / MASS))
        self.mass = np.full(segments + 1, MASS / segments)
        self.mass[[0, -1]] *= 0.5
        self.at = LENGTH * np.arange(segments + 1) / segments
        self.lump = INERTIA - float(np.sum(self.mass * (self.at - 0.5 * LENGTH) ** 2))

    def gap(self, time: float, y: np.ndarray) -> tuple[float, float, np.ndarray]:
        """Return eccentricity (m), its rate (m/s), and the direction from the rod's pin to the slider's."""
        n, angle = self.segments, self.speed * time
        (phi, *u, s), (dphi, *du, ds) = y[: n + 2], y[n + 2 :]
        e, across = np.array([math.cos(phi), math.sin(phi)]), np.array([-math.sin(phi), math.cos(phi)])
        pin = CRANK * np.array([math.cos(angle), math.sin(angle)])
        moving = CRANK * self.speed * np.array([-math.sin(angle), math.cos(angle)])
        apart = np.array([s, 0.0]) - pin - (LENGTH + u[-1]) * e
        parting = np.array([ds, 0.0]) - moving - du[-1] * e - (LENGTH + u[-1]) * dphi * across
        size = float(np.hypot(*apart))
        way = apart / size if size else np.array([1.0, 0.0])
        return size, float(parting @ way), way

    def rates(self, time: float, y: np.ndarray, onset: float | None) -> np.ndarray:
        """Return the derivatives; `onset` is the rate at which a contact began, None in free flight."""
        n, angle = self.segments, self.speed * time
        phi, dphi, u, du = y[0], y[n + 2], np.array([0.0, *y[1 : n + 1]]), np.array([0.0, *y[n + 3 : 2 * n + 3]])
        e, across = np.array([math.cos(phi), math.sin(phi)]), np.array([-math.sin(phi), math.cos(phi)])
        pin = -CRANK * self.speed**2 * np.array([math.cos(angle), math.sin(angle)])
        push = np.zeros(2)  # N, on the slider
        if onset is not None:
            size, rate, way = self.gap(time, y)
            depth = max(size - CLEARANCE, 0.0)
            push = -STIFFNESS * depth**1.5 * (1.0 + 0.75 * (1.0 - RESTITUTION**2) * rate / onset) * way
        reach = self.at + u
        tension = np.array([0.0, *(self.spring * np.diff(u) + self.damping * np.diff(du)), 0.0])
        right = np.zeros(n + 2)  # angle, displacements of masses 1 to n, slider
        right[0] = -np.sum(self.mass * reach * (pin @ across + 2.0 * du * dphi)) - reach[-1] * (push @ across)
        right[1 : n + 1] = (np.diff(tension) - self.mass * (pin @ e - reach * dphi**2))[1:]
        right[n] -= push @ e
        right[n + 1] = push[0]
        weight = np.array([np.sum(self.mass * reach**2) + self.lump, *self.mass[1:], SLIDER])
        return np.concatenate([y[n + 2 :], right / weight])

    def start(self) -> np.ndarray:
        """Return the state at crank angle 0: unstretched, pins concentric, with the rates of the rigid machine."""
        rate = -CRANK * self.speed / LENGTH
        return np.array([0.0, *np.zeros(self.segments), CRANK + LENGTH, rate, *np.zeros(self.segments), 0.0])

    def run(self, end: float) -> tuple[list[tuple[float, float]], np.ndarray]:
        """Return (time (s), closing rate (m/s)) of every contact onset, and the state at the time `end` (s)."""
        time, y, onset, begun = 0.0, self.start(), None, []
        while time < end:

            def touches(t, y):
                return self.gap(t, y)[0] - CLEARANCE

            touches.terminal, touches.direction = True, -1.0 if onset is not None else 1.0
            result = solve_ivp(
                lambda t, y, rate=onset: self.rates(t, y, rate),
                (time, end),
                y,
                "DOP853",
                events=touches,
                rtol=1e-12,
                atol=1e-16,
            )
            time, y = float(result.t[-1]), result.y[:, -1]
            if result.status == 1 and onset is None:
                onset = self.gap(time, y)[1]
                begun.append((time, onset))
            elif result.status == 1:
                onset = None
        return begun, y
