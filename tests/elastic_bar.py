"""An impact on the end of an elastic bar whose other end is fixed: the continuous bar, and its model in a machine.

The end of a uniform bar moves under the force on it and the waves reflected from the other, fixed end
(d'Alembert): Z v(t) = F(t) + 2 sum over j of (-1)^j F(t - 2 j T), with Z = sqrt(k m) and T = sqrt(m / k).
"""

import math

import numpy as np
from planar_machines import slider_crank
from scipy.integrate import solve_ivp

from clearsweep.contracts.machine import Constant, Elastic
from clearsweep.mechanics.joints.contract import Load
from clearsweep.mechanics.machines import planar
from clearsweep.mechanics.machines.contract import accelerate, gaps, pose_at

STIFFNESS, MASS, SLIDER = 3.9e8, 0.21, 0.14  # N/m of the bar, kg, kg
CONTACT = 6.61e10  # N/m^1.5


def continuous(speed: float, steps: int = 40000) -> tuple[float, float]:
    """Return peak (N) and duration (s) of the impact of the slider on the continuous bar, by Heun's method."""
    impedance, travel_time = math.sqrt(STIFFNESS * MASS), math.sqrt(MASS / STIFFNESS)
    h = 2.0 * travel_time / (steps // 8)
    back = steps // 8  # steps until a wave returns
    force, wave = np.zeros(8 * steps), np.zeros(8 * steps)  # N; m/s, of reflected waves

    def rates(depth: float, pace: float, at: int) -> tuple[float, float, float]:
        push = CONTACT * max(depth, 0.0) ** 1.5
        return pace - (push / impedance + 2.0 * wave[at]), -push / SLIDER, push

    depth, pace, n = 0.0, speed, 0
    while True:
        if n >= back:
            wave[n] = -force[n - back] / impedance - wave[n - back]
        if n + 1 >= back:
            wave[n + 1] = -force[n + 1 - back] / impedance - wave[n + 1 - back]
        sinking, slowing, force[n] = rates(depth, pace, n)
        next_sinking, next_slowing, _ = rates(depth + h * sinking, pace + h * slowing, n + 1)
        after = depth + 0.5 * h * (sinking + next_sinking)
        if n and after <= 0.0:
            return float(np.max(force)), h * (n + depth / (depth - after))
        depth, pace, n = after, pace + 0.5 * h * (slowing + next_slowing), n + 1


def machine(segments: int):
    """Return a slider-crank with an elastic rod in line with its nearly fixed crank."""
    made = slider_crank(drive=Constant(1e-9), gravity=0.0)
    rod = made.bodies["rod"]._replace(elastic=Elastic("big", "small", STIFFNESS, segments))
    return made._replace(bodies={**made.bodies, "rod": rod})


class Clearance:
    """Joint parameters read by `planar.build`."""

    clearance = 1e-3


def in_segments(speed: float, segments: int) -> tuple[float, float]:
    """Return peak (N) and duration (s) of the same impact from the equations of motion of a machine in segments."""
    value, start, *_ = planar.build(machine(segments), {"rod-slider": Clearance()}, {})
    count = (len(start) - 1) // 2

    def pressed(y) -> tuple[float, tuple]:
        depth = -gaps(value, pose := pose_at(value, y))[0].x  # the slider moves towards the crank
        force = CONTACT * max(depth, 0.0) ** 1.5
        return force, accelerate(value, pose, (Load(force, 0.0, 0.0, 0.0, ()),)).accelerations

    def rates(_, y):
        return [*y[count : 2 * count], *pressed(y)[1], 1.0]

    def parted(_, y):
        return gaps(value, pose_at(value, y))[0].x if y[-1] > 1e-9 else -1.0

    parted.terminal, parted.direction = True, 1.0
    start = np.array(start)
    start[count + 1] = -speed
    result = solve_ivp(rates, (0.0, 2e-3), start, "DOP853", events=parted, rtol=1e-10, atol=1e-14, max_step=1e-6)
    return max(pressed(y)[0] for y in result.y.T), float(result.t_events[0][0])
