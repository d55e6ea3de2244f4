"""Machines of other programs and of textbooks: their grids, their solutions, and the time steppers of the programs."""

import itertools
import json
import math
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import clearsweep

PRINTED = json.loads(Path(__file__).with_name("published.json").read_text(encoding="utf-8"))
"""Figures of ADAMS 2013 (in the tests of Project Chrono), Exudyn, MATLAB (in Exudyn) and Siconos."""
G = 9.81
STILL = [0.0, 0.0]
FIRM = {"law": "kelvin-voigt", "stiffness": 1e6, "damping": 1e3}
FAR = {"clearance": 1e3, "bearing_radius": 2e3, "contact": {"law": "hertz", "stiffness": 1e6}}
LONG = 1e5  # m, length of a spring whose direction is to be constant


def grid_of(duration, bodies, joints, loads=None, *, ground=None, gravity=0.0, tolerance=1e-9):
    """Return the grid of free bodies next to a wheel that turns once in `duration` (s).

    `bodies`: name -> mass, inertia, initial; `joints`: name -> type, both bodies, settings.
    """
    made = {"ground": {"points": {"p": STILL, **(ground or {})}}}
    made["wheel"] = {"mass": 1.0, "inertia": 1e-4, "points": {"p": STILL}}
    for name, (mass, inertia, initial) in bodies.items():
        made[name] = {"mass": mass, "inertia": inertia, "center": STILL, "points": {"p": STILL}, "initial": initial}
    pairs = {"axle": {"type": "revolute", "between": ["ground.p", "wheel.p"]}}
    for name, (kind, first, second, _) in joints.items():
        between = [body if "." in body else f"{body}.p" for body in (first, second)]
        pairs[name] = {"type": kind, "between": between}
    machine = {"type": "planar", "gravity": gravity, "bodies": made, "joints": pairs}
    return {
        "mechanism": machine | {"driven": "axle", "output": {"body": "wheel"}},
        "drive": {"speed": 2.0 * math.pi / duration},
        "joints": {name: settings for name, (_, _, _, settings) in joints.items()},
        "loads": loads or {},
        "simulate": {"revolutions": 1, "discard": 0, "tolerance": tolerance},
        "save": {"orbits": "all"},
    }


def run(grid, times=None):
    """Return the Trajectory of a grid, which has to end well."""
    path = clearsweep.simulate(clearsweep.load_case(grid), times=times)
    assert path.status == "ok", path.message
    return path


def guide(clearance, contact, length=1e-6, **more):
    """Return the settings of a guide; a body of that length hardly tilts."""
    return {"clearance": clearance, "length": length, "height": 1e-3, "contact": contact} | more


def spring_to_ground(stiffness):
    """Return a spring between the ground and `block` along x, without force at x = 0."""
    ends = {"between": ["ground", "block"], "anchor": [-LONG, 0.0], "point": "p"}
    return ends | {"stiffness": stiffness, "free_length": LONG}


def on_a_rail(duration, friction, loads, **initial):
    """Return the grid of a block of 1 kg on a rail, with friction."""
    rail = guide(1e-3, FIRM, length=1.0, friction=friction)
    block = {"block": (1.0, 1.0, {"y": -1e-3} | initial)}
    return grid_of(duration, block, {"guide": ("prismatic", "ground", "block", rail)}, loads)


# ---------------------------------------------------------------------------------------------- friction in oscillators


def den_hartog():
    """J. P. Den Hartog (1931), Trans. ASME 53:107: amplitude of a forced oscillator with Coulomb friction.

    X = (P/k) sqrt(V^2 - (F/P)^2 U^2), V = 1/(1 - b^2), U = sin(pi/b)/(b (1 + cos(pi/b))), b: ratio of frequencies.
    """
    angles = np.linspace(0.0, 360.0, 721)
    push = {"crank_angle [deg]": angles.tolist(), "fx [N]": (10.0 * np.cos(np.radians(angles))).tolist()}
    push["fx [N]"][-1] = push["fx [N]"][0]
    exact, amplitudes = [], []
    for ratio, share in ((0.5, 0.2), (0.8, 0.5), (1.3, 0.3), (2.0, 0.4)):
        gain = 1.0 / (1.0 - ratio**2)
        shift = math.sin(math.pi / ratio) / (ratio * (1.0 + math.cos(math.pi / ratio)))
        exact.append(0.1 * math.sqrt(gain**2 - (share * shift) ** 2))
        friction = {"law": "tanh", "coefficient": share, "velocity_scale": 1e-5}
        loads = {"press": {"on": "block", "force": [0.0, -10.0]}, "push": {"on": "block", "table": push}}
        grid = on_a_rail(2.0 * math.pi / (10.0 * ratio), friction, loads | {"spring": spring_to_ground(100.0)})
        grid["simulate"] |= {"revolutions": 60, "discard": 58}
        grid["save"] = {"orbits": "last", "revolutions": 2, "samples": 2000}
        amplitudes.append(0.5 * np.ptp(run(grid)["block/x"]))
    return {"amplitude at four frequencies, m": (exact, amplitudes)}


def belt():
    """Return the cycle of a block on a belt: friction 1.5 N at rest and 1 N in motion, spring 4 N/m, belt 0.05 m/s."""
    speed, excess, rate = 0.05, 0.125, 2.0
    slip_time = 2.0 / rate * (math.pi - math.atan(rate * excess / speed))
    friction = {"law": "karnopp", "coefficient": 1.0, "static_coefficient": 1.5}
    friction |= {"stribeck_velocity": 1e-8, "band": 1e-10}
    pull = {"on": "block", "table": {"time [s]": [0.0, 60.0], "fx [N]": [0.0, 12.0]}}
    loads = {"press": {"on": "block", "force": [0.0, -1.0]}, "pull": pull, "spring": spring_to_ground(4.0)}
    times = np.linspace(0.0, 60.0, 60_001)
    path = run(on_a_rail(60.0, friction, loads), times)
    v = path["block/vx"]
    starts = times[1:][(v[1:] > 1e-4) & (v[:-1] <= 1e-4)]
    ends = times[1:][(v[1:] <= 1e-4) & (v[:-1] > 1e-4)]
    rest = np.interp(0.5 * (starts[1:] + ends[:-1]), times, path["block/x"])
    return {
        "period, s": (2.0 * excess / speed + slip_time, np.mean(np.diff(starts))),
        "length of a slip, m": (2.0 * excess + speed * slip_time, np.mean(np.diff(rest))),
        "peak speed on the belt, m/s": (speed + math.hypot(rate * excess, speed), np.max(v)),
    }


def coulomb_oscillator(times):
    """Return the places (m) of m = k = F = 1 from 12 m at 6 m/s: half circles around +-1 in the phase plane."""
    start, angle = math.hypot(13.0, 6.0), math.atan2(6.0, 13.0)
    places = np.where(times < angle, start * np.cos(angle - times) - 1.0, 0.0)
    amplitude, side, begin = start - 1.0, 1.0, angle
    while amplitude > 1.0:
        inside = (times >= begin) & (times < begin + math.pi)
        places[inside] = side * (1.0 + (amplitude - 1.0) * np.cos(times[inside] - begin))
        amplitude, side, begin = amplitude - 2.0, -side, begin + math.pi
    places[times >= begin] = side * amplitude
    return places


def siconos_oscillator():
    """Return the places of Siconos' FrictionOscillator, exact and computed."""
    friction = {"law": "karnopp", "coefficient": 1.0, "static_coefficient": 1.0}
    friction |= {"stribeck_velocity": 1e-3, "band": 1e-6}
    loads = {"press": {"on": "block", "force": [0.0, -1.0]}, "spring": spring_to_ground(1.0)}
    grid = on_a_rail(40.0, friction, loads, x=12.0, vx=6.0)
    times = np.linspace(0.0, 40.0, 81)
    return {"place to 40 s, m": (coulomb_oscillator(times), run(grid, times)["block/x"])}


def siconos_oscillator_steps(step, times):
    """Return the places of Siconos' stepper (Euler-Moreau, theta = 1/2): the friction ends or reverses the motion."""
    x, v, places, k = 12.0, 6.0, [], 0
    for time in times:
        for _ in range(round(time / step) - k):
            free = v - step * x - 0.25 * step**2 * v
            then = math.copysign(max(abs(free) - step, 0.0), free) / (1.0 + 0.25 * step**2)
            x, v = x + 0.5 * step * (v + then), then
        k = round(time / step)
        places.append(x)
    return np.array(places)


# ---------------------------------------------------------------------------------------------- impacts


def kelvin_voigt_bounces(gap, speed, stiffness, damping, end, *, clipped):
    """Return the place (m) at `end` (s) of 0.25 kg that bounces on a spring and damper, whose floor is at 0.05 m.

    Without clipping the floor also draws, until the body leaves it; clipped, it lets go once the force is zero.
    """

    def flight(_, state):
        return [state[1], -G]

    def contact(_, state):
        return [state[1], -G - (stiffness * state[0] + damping * state[1]) / 0.25]

    def lands(_, state):
        return state[0]

    def leaves(_, state):
        return -(stiffness * state[0] + damping * state[1]) if clipped else -state[0]

    lands.terminal = leaves.terminal = True
    lands.direction = leaves.direction = -1.0
    time, state, touching = 0.0, [gap, speed], False
    while time < end:
        phase, event = (contact, leaves) if touching else (flight, lands)
        path = solve_ivp(phase, (time, end), state, "DOP853", events=event, rtol=1e-12, atol=1e-14)
        time, state, touching = path.t[-1], path.y[:, -1], not touching
    return 0.05 + state[0]


def exudyn_floor(law, gap, speed, stiffness, damping, end):
    """Return the exact and the computed place of a mass that bounces on a linear floor; two corners share it."""
    exact = kelvin_voigt_bounces(gap, speed, stiffness, damping, end, clipped=law == "kelvin-voigt")
    floor = {"law": law, "stiffness": 0.5 * stiffness, "damping": 0.5 * damping}
    mass = {"block": (0.25, 1.0, {"y": gap - 0.1, "vy": speed})}
    joint = {"guide": ("prismatic", "ground", "block", guide(0.1, floor, length=1.0))}
    path = run(grid_of(end, mass, joint, gravity=G, tolerance=1e-10))
    return exact, path["block/y"][-1] + 0.15


def exudyn_floors():
    """Return the figures of Exudyn's contactCoordinateTest (also clipped) and postNewtonStepContactTest."""
    soft = exudyn_floor("kelvin-voigt-unclipped", 0.01, -1.0, 2e4, 0.0, 0.5)
    return {
        "place at 0.25 s, m": exudyn_floor("kelvin-voigt-unclipped", 0.05, 0.0, 2e6, 200.0, 0.25),
        "the same, the floor does not draw, m": exudyn_floor("kelvin-voigt", 0.05, 0.0, 2e6, 200.0, 0.25),
        "place at 0.5 s on a softer floor, m": soft,
    }


def newton_bounces(times, restitution):
    """Return the heights (m) of a body that falls by 1 m and bounces."""
    fall = math.sqrt(2.0 / G)
    heights, begin, speed = 1.0 - 0.5 * G * times**2, fall, math.sqrt(2.0 * G) * restitution
    while begin < times[-1]:
        t = times - begin
        heights = np.where(t > 0.0, speed * t - 0.5 * G * t**2, heights)
        begin, speed = begin + 2.0 * speed / G, speed * restitution
    return heights


def bouncing_ball():
    """Return the heights of Siconos' BouncingBallED: restitution 0.9."""
    times = np.linspace(0.0, 6.0, 601)
    contact = {"law": "exact", "stiffness": 1e16, "restitution": 0.9}
    joint = {"floor": ("prismatic", "ground", "ball", guide(1.0, contact))}
    grid = grid_of(6.0, {"ball": (1.0, 1e3, {"y": 0.0})}, joint, gravity=G, tolerance=1e-11)
    return {"height to 6 s, m": (newton_bounces(times, 0.9), run(grid, times)["ball/y"] + 1.0)}


def siconos_start():
    """Return time, place and speed at which the ball of Siconos' BouncingBallTS-CompliantContact is free."""
    time = 0.2515
    return time, 1.0 - 0.5 * G * time**2, -G * time


def ball_on_a_spring(times):
    """Return the places of that ball between a spring (100 N/m below 0.1 m) and a roof (0.7 m, restitution 1)."""

    def rates(_, state):
        return [state[1], -G + max(0.0, 100.0 * (0.1 - state[0]))]

    def at_floor(_, state):
        return state[0] - 0.1

    def at_roof(_, state):
        return 0.7 - state[0]

    at_floor.terminal, at_roof.terminal, at_roof.direction = True, True, -1.0
    time, *state = siconos_start()
    places, exact = [], {"dense_output": True, "rtol": 1e-12, "atol": 1e-13}
    while time < times[-1]:
        at_floor.direction = 1.0 if state[0] < 0.2 and state[1] < 0.0 else -1.0
        path = solve_ivp(rates, (time, times[-1]), state, "DOP853", events=(at_floor, at_roof), **exact)
        inside = times[(times > time) & (times <= path.t[-1])]
        places += list(path.sol(inside)[0]) if inside.size else []
        time, state = path.t[-1], path.y[:, -1]
        if path.t_events[1].size:
            state = [0.7, -state[1]]
    return np.array(places)


def compliant_ball():
    """Return the places of that ball, exact and with a roof of finite stiffness."""
    times = np.array(PRINTED["siconos_ball"]["t"])
    begin, place, speed = siconos_start()
    joints = {
        "floor": (
            "prismatic",
            "ground",
            "ball",
            guide(2.0, {"law": "kelvin-voigt", "stiffness": 50.0, "damping": 0.0}),
        ),
        "roof": ("prismatic", "ground.over", "ball", guide(1.0, {"law": "hertz", "stiffness": 1e16})),
    }
    ball = {"ball": (1.0, 1e3, {"y": place - 2.1, "vy": speed})}
    grid = grid_of(8.0, ball, joints, ground={"over": [0.0, -2.4]}, gravity=G, tolerance=1e-11)
    return {"place to 8.25 s, m": (ball_on_a_spring(times), run(grid, times - begin)["ball/y"] + 2.1)}


def siconos_ball_steps(step, times):
    """Return the places of Siconos' stepper of that ball.

    A contact is active if it closes within half a step. The floor's force belongs to the place two steps later, and
    half of the step is added to its compliance of 0.01 m/N.
    """
    time, q, v = siconos_start()
    compliance, places = 0.01 + 0.5 * step * 1.01, []
    for end in times:
        for _ in range(round((end - time) / step)):
            then = v - step * G
            if q + 0.5 * step * v < 0.1:
                then += step * max(0.0, (0.1 - q - 2.0 * step * v + 0.5 * step**2 * G) / compliance)
            if q + 0.5 * step * v > 0.7 and v > 0.0:
                then = -v
            q, v = q + 0.5 * step * (v + then), then
        time = end
        places.append(q)
    return np.array(places)


STICK = {"x": 0.3535533905932737, "y": 0.3635533905932737, "angle": 0.75 * math.pi, "vx": -0.5, "vy": 0.1, "rate": 0.1}


def slide_and_rebound(u, w, coupling, friction):
    """Return the impulse (N s) of an impact without loss, by friction and normal impulse: (tangential, normal).

    `u`, `w`: tangential and normal velocity of the point; `coupling`: its inverse mass. Of a slip that stops, friction
    is too weak to keep it at rest. The normal force works zero in all (Stronge's energetic restitution of 1).
    """
    tangential = normal = work = 0.0
    while True:
        slip = math.copysign(1.0, u) if abs(u) > 1e-12 else math.copysign(1.0, coupling[0, 1])
        du, dw = coupling @ (-friction * slip, 1.0)
        ends = [-u / du] if u * du < 0.0 and abs(u) > 1e-12 else []
        root = (-w + math.sqrt(w**2 - 2.0 * dw * work)) / dw
        part = min([root, *ends])
        work += w * part + 0.5 * dw * part**2
        tangential, normal = tangential - friction * slip * part, normal + part
        u, w = u + du * part, w + dw * part
        if part == root:
            return tangential, normal


def newton_rebound(u, w, coupling, friction):
    """Return the impulses of Siconos' law: the normal velocity is reversed, friction opposes the slip at the end."""
    for slip in (1.0, -1.0):
        normal = -2.0 * w / (coupling[1] @ (-friction * slip, 1.0))
        if slip * (u + normal * (coupling[0] @ (-friction * slip, 1.0))) > 0.0:
            return -friction * slip * normal, normal
    raise ValueError("the end sticks")


def stick_after_impacts(rebound=slide_and_rebound, end=0.2):
    """Return the velocities of the stick of 1 m and 1 kg that bounces on a floor at y = 0 (g = 10), at `end` (s)."""
    time, state = 0.0, np.array([STICK["y"], STICK["angle"], STICK["vx"], STICK["vy"], STICK["rate"]])

    def flown(t):
        y, angle, vx, vy, rate = state
        return np.array([y + vy * t - 5.0 * t**2, angle + rate * t, vx, vy - 10.0 * t, rate])

    def lowest(t):
        y, angle = flown(t)[:2]
        return y - 0.5 * abs(math.sin(angle))

    while True:
        tries = np.linspace(1e-7, end - time, 2001)
        below = next((i for i, t in enumerate(tries) if lowest(t) < 0.0), None)
        if below is None:
            return dict(zip(("vx", "vy", "rate"), flown(end - time)[2:], strict=True))
        t = brentq(lowest, tries[below - 1], tries[below], xtol=1e-15)
        time, state = time + t, flown(t)
        _, angle, vx, vy, rate = state
        side = -0.5 if math.sin(angle) > 0.0 else 0.5
        rx, ry = side * math.cos(angle), side * math.sin(angle)
        coupling = np.array([[1.0 + 12.0 * ry**2, -12.0 * rx * ry], [-12.0 * rx * ry, 1.0 + 12.0 * rx**2]])
        px, py = rebound(vx - rate * ry, vy + rate * rx, coupling, 0.01)
        state[2:] += px, py, 12.0 * (rx * py - ry * px)


def impacting_stick():
    """Return the velocities of Siconos' ImpactingStick at 0.2 s, with the law of impact of a stiff elastic contact."""
    exact = stick_after_impacts()
    friction = {"law": "tanh", "coefficient": 0.01, "velocity_scale": 1e-5}
    settings = guide(5.0, {"law": "hertz", "stiffness": 1e15}, length=1.0, friction=friction) | {"height": 1e-6}
    stick = {"stick": (1.0, 1.0 / 12.0, STICK | {"y": STICK["y"] - 5.0})}
    grid = grid_of(0.2, stick, {"floor": ("prismatic", "ground", "stick", settings)}, gravity=10.0, tolerance=1e-11)
    path = run(grid)
    names = {"vx": "vx, m/s", "vy": "vy, m/s", "rate": "rate, rad/s"}
    return {text: (exact[key], path[f"stick/{key}"][-1]) for key, text in names.items()}


CHAIN = 0.027940811934227528 * 0.95 ** (3.0 * np.arange(10))  # kg
CHAIN_STIFFNESS = 10117417835.787884 * 0.95 ** (0.5 * np.arange(9))  # N/m^1.5
CHAIN_RADII = 0.0095 * 0.95 ** np.arange(10)  # m
SHARED_GAPS = CHAIN_RADII[:-1] + CHAIN_RADII[1:] - CHAIN_RADII[8] - CHAIN_RADII[9]
SHARED_GAPS[[0, 8]] = 1e-3, 1e-12
"""Gaps (m) in Siconos' TaperedChainOfBalls: each contact takes the radii of the last pair. The first only delays."""


def chain_in_contact(end):
    """Return the speeds (m/s) of ten balls that touch, of which the first moves at 1 m/s, by scipy."""

    def rates(_, state):
        force = CHAIN_STIFFNESS * np.maximum(state[:9] - state[1:10], 0.0) ** 1.5
        return np.concatenate([state[10:], (np.append(0.0, force) - np.append(force, 0.0)) / CHAIN])

    start = np.append(np.zeros(10), [1.0, *np.zeros(9)])
    return solve_ivp(rates, (0.0, end), start, "DOP853", rtol=1e-11, atol=1e-15).y[10:, -1]


def chain_of_balls(gaps, end, depth):
    """Return the speeds (m/s) of ten balls in a row; each is the journal in a pin of clearance `depth` (m)."""
    places = -np.append(0.0, np.cumsum(depth - np.asarray(gaps)))
    bodies = {f"b{i}": (CHAIN[i], 1.0, {"y": places[i], "vy": float(i == 0)}) for i in range(10)}
    joints = {}
    for i, stiffness in enumerate(CHAIN_STIFFNESS):
        contact = {"law": "hertz", "stiffness": stiffness, "exponent": 1.5}
        pin = {"clearance": depth, "bearing_radius": 2.0 * depth, "contact": contact}
        joints[f"k{i}"] = ("revolute", f"b{i}", f"b{i + 1}", pin)
    joints["far"] = ("revolute", "ground", "b0", FAR)
    path = run(grid_of(end, bodies, joints, tolerance=1e-12))
    return np.array([path[f"b{i}/vy"][-1] for i in range(10)])


def chains():
    """Return the last speeds of Siconos' TaperedChainOfBalls as it is meant, and with the gaps that it has."""
    touching = [1e-7, *[1e-12] * 8]
    return {
        "speeds of ten balls that touch, m/s": (chain_in_contact(1.5e-3), chain_of_balls(touching, 1.5e-3, 1e-3)),
        "speeds with the gaps of the reference, m/s": (
            PRINTED["siconos_chain"],
            chain_of_balls(SHARED_GAPS, 0.4, 10.0),
        ),
    }


def housner():
    """G. W. Housner (1963), Bull. Seism. Soc. Am. 53:403: a rigid block of 0.2 m by 0.6 m that rocks.

    It turns about one corner as a pendulum; each change of corners leaves 1 - (3/2) sin^2(alpha) of its rate.
    """
    radius, slope = math.hypot(0.1, 0.3), math.atan2(0.1, 0.3)
    remaining, tilt = 1.0 - 1.5 * math.sin(slope) ** 2, 0.4 * slope

    def rock(_, state):
        return [state[1], -0.75 * G / radius * math.sin(slope - state[0])]

    def upright(_, state):
        return state[0]

    def turns(_, state):
        return state[1]

    upright.terminal, upright.direction = True, -1.0
    time, state, impacts, peaks = 0.0, [tilt, 0.0], [], []
    for _ in range(5):
        path = solve_ivp(rock, (time, time + 2.0), state, "DOP853", events=(upright, turns), rtol=1e-12, atol=1e-13)
        peaks += list(path.y_events[1][-1:, 0]) if time else []
        time, state = path.t[-1], [0.0, -remaining * path.y[1, -1]]
        impacts.append(time)
    times = np.linspace(0.0, 2.5, 25_001)
    angle = run(rocking_block(radius, slope, tilt), times)["block/angle"]
    at = np.flatnonzero(np.diff(np.sign(angle)))[:5]
    crossings = times[at] + 1e-4 * angle[at] / (angle[at] - angle[at + 1])
    reached = [np.max(np.abs(angle[a:b])) for a, b in itertools.pairwise(at)]
    return {
        "times of five impacts, s": (impacts, crossings),
        "four peaks over the slope of the diagonal": (np.array(peaks) / slope, np.array(reached) / slope),
    }


def rocking_block(radius, slope, tilt):
    """Return the grid of that block on a floor that hardly gives and lets no corner slide."""
    floor = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 2e4}
    rough = {"law": "tanh", "coefficient": 2.0, "velocity_scale": 1e-5}
    settings = {"clearance": 1.0, "length": 0.2, "height": 0.6, "contact": floor, "friction": rough}
    x, rise = 0.1 - radius * math.sin(slope - tilt), radius * math.cos(slope - tilt) - 0.3
    block = {"block": (1.0, (0.2**2 + 0.6**2) / 12.0, {"x": x, "y": rise - 1.0 + 1e-12, "angle": tilt})}
    grid = grid_of(2.5, block, {"floor": ("prismatic", "ground", "block", settings)}, gravity=G)
    grid["simulate"]["step_budget"] = 5_000_000
    return grid


def table_phases(strength, restitution=0.5):
    """Return the last two phases (rad) at which a ball lands on a vibrating table, from the exact map.

    `strength`: A w^2/g of the table A sin(w t). Lengths in A and times in 1/w; a flight ends at the table.
    P. J. Holmes (1982), J. Sound Vib. 84:173: with one landing a period cos(phase) = pi (1 - e)/((1 + e) A w^2/g).
    """

    def height(s, phase, speed):
        return math.sin(phase) + speed * s - 0.5 * s**2 / strength - math.sin(phase + s)

    phase = math.acos(math.pi * (1.0 - restitution) / ((1.0 + restitution) * strength)) + 1e-3
    speed, landed = math.pi / strength, []
    for _ in range(4000):
        s = brentq(height, 1.2 * math.pi, 2.8 * math.pi, args=(phase, speed), xtol=1e-14)
        before = speed - s / strength
        phase = (phase + s) % (2.0 * math.pi)
        speed = math.cos(phase) - restitution * (before - math.cos(phase))
        landed.append(phase)
    return sorted(landed[-2:])


def vibrating_table(strength, rate=60.0):
    """Return the grid of a ball on a table that a crank drives through a yoke; the ball begins in flight."""
    reach, lift = strength * G / rate**2, math.pi * G / rate
    phase = math.acos(math.pi / (3.0 * strength))
    flown = (2.0 * math.pi - phase) / rate
    start = {"y": -0.5 + reach * math.sin(phase) + lift * flown - 0.5 * G * flown**2, "vy": lift - G * flown}
    grid = grid_of(1.0, {"ball": (0.1, 1.0, start)}, {}, gravity=G, tolerance=1e-10)
    machine = grid["mechanism"]
    machine["bodies"]["wheel"]["points"]["pin"] = [reach, 0.0]
    for name, mass, inertia in (("block", 0.0, 0.0), ("yoke", 1.0, 1e-3)):
        machine["bodies"][name] = {"mass": mass, "inertia": inertia, "center": STILL, "points": {"p": STILL}}
    machine["joints"] |= {
        "pin": {"type": "revolute", "between": ["wheel.pin", "block.p"]},
        "slot": {"type": "prismatic", "between": ["block.p", "yoke.p"], "axis": 0.0},
        "lift": {"type": "prismatic", "between": ["ground.p", "yoke.p"], "axis": 0.5 * math.pi},
        "bowl": {"type": "revolute", "between": ["yoke.p", "ball.p"]},
    }
    machine["output"] = {"body": "yoke", "point": "p", "along": 0.5 * math.pi}
    grid |= {"drive": {"speed": rate}, "save": {"orbits": "last", "revolutions": 1}}
    contact = {"law": "exact", "stiffness": 2e14, "restitution": 0.5, "onset": "first"}
    grid["joints"] = {"bowl": {"clearance": 0.5, "bearing_radius": 1.0, "contact": contact}}
    grid["simulate"] |= {"discard": 399, "revolutions": 400}
    return grid


def bouncing_on_a_table():
    """Return the phases of landing before and after the motion doubles its period, at a strength of 1.5268."""
    exact, computed = [], []
    for strength in (1.45, 1.52, 1.54, 1.6):
        events = run(vibrating_table(strength)).events
        onsets = [event["t"] for event in events if str(event["kind"]) == "on"]
        computed += sorted(60.0 * time % (2.0 * math.pi) for time in onsets[-2:])
        exact += table_phases(strength)
    return {"phases of landing at A w^2/g of 1.45 to 1.6, rad": (exact, computed)}
