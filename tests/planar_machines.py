"""Planar machines for tests, and their equations of motion in absolute coordinates with multipliers."""

import math

import numpy as np

from clearsweep.contracts.machine import Aim, Body, BodyPoint, Constant, Guide, Machine, Pin
from clearsweep.mechanics.joints.contract import Load
from clearsweep.mechanics.machines.contract import Motion, accelerate, describe, pose_at
from clearsweep.mechanics.machines.planar.closure import Closure

CRANK = Body(0.3, 1e-4, (0.025, 0.0), {"pivot": (0.0, 0.0), "pin": (0.05, 0.0)})
ROD = Body(0.21, 2.5e-4, (0.06, 0.0), {"big": (0.0, 0.0), "small": (0.12, 0.0)})
SLIDER = Body(0.14, 1e-4, (0.0, 0.0), {"pin": (0.0, 0.0)})
TRIAD_DRIVE = Constant(8.0)
QUICK_RETURN_DRIVE = Constant(12.0)
V_TWIN_DRIVE = Constant(2000.0 * math.pi / 30.0)
FOUR_BAR_DRIVE = Constant(20.0 * math.pi)
SLIDER_CRANK_DRIVE = Constant(100.0)


def ground(**points):
    """Return the ground with points."""
    return Body(0.0, 0.0, (0.0, 0.0), points)


def pin(name, proximal, distal):
    """Return a Pin between 'body.point' and 'body.point'."""
    return Pin(name, BodyPoint(*proximal.split(".")), BodyPoint(*distal.split(".")))


def guide(name, proximal, distal, axis=0.0):
    """Return a Guide between 'body.point' and 'body.point'; axis in rad."""
    return Guide(name, BodyPoint(*proximal.split(".")), BodyPoint(*distal.split(".")), axis)


def slider_crank(drive=SLIDER_CRANK_DRIVE, offset=0.0, loads=(), gravity=9.81):
    """Return a slider-crank."""
    return Machine(
        {"ground": ground(main=(0.0, 0.0), rail=(0.0, offset)), "crank": CRANK, "rod": ROD, "slider": SLIDER},
        (
            pin("ground-crank", "ground.main", "crank.pivot"),
            pin("crank-rod", "crank.pin", "rod.big"),
            pin("rod-slider", "rod.small", "slider.pin"),
            guide("slider-ground", "ground.rail", "slider.pin"),
        ),
        "ground-crank",
        drive,
        gravity,
        Aim("slider", "pin", 0.0),
        loads=loads,
    )


def four_bar(drive=FOUR_BAR_DRIVE, loads=(), start=None, gravity=9.81):
    """Return the four-bar of the reference trajectories."""
    rocker = Body(0.25, 2.2e-4, (0.05, 0.0), {"foot": (0.0, 0.0), "pin": (0.1, 0.0)})
    return Machine(
        {"ground": ground(main=(0.0, 0.0), foot=(0.13, 0.0)), "crank": CRANK, "coupler": ROD, "rocker": rocker},
        (
            pin("ground-crank", "ground.main", "crank.pivot"),
            pin("crank-coupler", "crank.pin", "coupler.big"),
            pin("coupler-rocker", "coupler.small", "rocker.pin"),
            pin("rocker-ground", "rocker.foot", "ground.foot"),
        ),
        "ground-crank",
        drive,
        gravity,
        Aim("rocker"),
        start={"coupler": 0.9, "rocker": 1.6} if start is None else start,
        loads=loads,
    )


def v_twin(drive=V_TWIN_DRIVE, loads=(), gravity=9.81):
    """Return the V-twin of the reference trajectories."""
    return Machine(
        {
            "crank": CRANK,
            "rodleft": ROD,
            "rodright": ROD,
            "pistonleft": SLIDER,
            "pistonright": SLIDER,
            "ground": ground(main=(0.0, 0.0), rail=(0.0, 0.0)),
        },
        (
            pin("main", "ground.main", "crank.pivot"),
            pin("big-left", "crank.pin", "rodleft.big"),
            pin("big-right", "crank.pin", "rodright.big"),
            pin("small-left", "rodleft.small", "pistonleft.pin"),
            pin("small-right", "rodright.small", "pistonright.pin"),
            guide("guide-left", "ground.rail", "pistonleft.pin", math.radians(45.0)),
            guide("guide-right", "ground.rail", "pistonright.pin", math.radians(-45.0)),
        ),
        "main",
        drive,
        gravity,
        Aim("pistonleft", "pin", math.radians(45.0)),
        start={"rodleft": math.radians(62.0), "rodright": math.radians(-62.0)},
        loads=loads,
    )


def quick_return(drive=QUICK_RETURN_DRIVE, loads=(), gravity=9.81):
    """Return a crank-shaper: a block on the crank's pin slides along a rocker, which drives a ram through a link."""
    arm = Body(0.8, 4e-3, (0.12, 0.01), {"foot": (0.0, 0.0), "slot": (0.0, 0.0), "head": (0.3, 0.0)})
    link = Body(0.2, 1e-4, (0.03, 0.002), {"near": (0.0, 0.0), "far": (0.07, 0.0)})
    block = Body(0.05, 2e-5, (0.001, 0.002), {"pin": (0.0, 0.0)})
    return Machine(
        {
            "ground": ground(main=(0.0, 0.14), foot=(0.0, 0.0), rail=(0.0, 0.31)),
            "crank": CRANK,
            "block": block,
            "rocker": arm,
            "link": link,
            "ram": Body(0.5, 1e-3, (0.01, 0.02), {"pin": (0.0, 0.0)}),
        },
        (
            pin("main", "ground.main", "crank.pivot"),
            pin("crank-block", "crank.pin", "block.pin"),
            guide("slot", "rocker.slot", "block.pin"),
            pin("foot", "ground.foot", "rocker.foot"),
            pin("head", "rocker.head", "link.near"),
            pin("draw", "link.far", "ram.pin"),
            guide("bed", "ground.rail", "ram.pin"),
        ),
        "main",
        drive,
        gravity,
        Aim("ram", "pin", 0.0),
        start={"block": 1.2, "rocker": 1.2, "link": 0.2},
        loads=loads,
    )


def triad(drive=TRIAD_DRIVE, gravity=9.81):
    """Return a machine whose loops do not separate into pairs: three links carry a plate, the crank moves a foot."""
    plate = Body(0.6, 2e-3, (0.1, 0.05), {"a": (0.0, 0.0), "b": (0.2, 0.0), "c": (0.1, 0.15)})
    link = Body(0.1, 1e-4, (0.08, 0.0), {"near": (0.0, 0.0), "far": (0.16, 0.0)})
    small = Body(0.1, 1e-5, (0.01, 0.0), {"pivot": (0.0, 0.0), "pin": (0.01, 0.0)})
    return Machine(
        {
            "ground": ground(main=(0.0, 0.0), right=(0.25, 0.0), top=(0.23, 0.4)),
            "crank": small,
            "plate": plate,
            "left": link,
            "right": link,
            "top": link,
        },
        (
            pin("main", "ground.main", "crank.pivot"),
            pin("crank-left", "crank.pin", "left.near"),
            pin("left-plate", "left.far", "plate.a"),
            pin("right-foot", "ground.right", "right.near"),
            pin("right-plate", "right.far", "plate.b"),
            pin("top-foot", "ground.top", "top.near"),
            pin("top-plate", "top.far", "plate.c"),
        ),
        "main",
        drive,
        gravity,
        Aim("plate"),
        start={"left": 1.5, "right": 1.7, "top": -2.5, "plate": 0.1},
    )


# ---------------------------------------------------------------------------------------------- absolute coordinates


def some_loads(count, rng):
    """Return loads of joints: N and N m."""
    return tuple(Load(*(rng.normal(size=4) * (100.0, 100.0, 1.0, 1.0)), ()) for _ in range(count))


def read(built, y):
    """Return positions and rates (3 bodies,) of all bodies in a state, in the order of `Closure`."""
    histories = describe(built.value, y, pose_at(built.value, y), Motion((), 0.0, 0.0))
    bodies = np.reshape(histories[6:], (-1, 6))
    return bodies[:, (0, 1, 4)].ravel(), bodies[:, (2, 3, 5)].ravel()


def advanced(built, y, loads):
    """Return positions, rates and accelerations (3 bodies,) of all bodies, and the Motion, under loads of open joints.

    The accelerations are fourth-order differences of the rates along the motion.
    """
    motion = accelerate(built.value, pose_at(built.value, y), loads)
    count, step = len(built.lengths), 1e-5
    slope = np.array([*y[count : 2 * count], *motion.accelerations, 1.0])
    near, far = (read(built, y + k * step * slope)[1] - read(built, y - k * step * slope)[1] for k in (1, 2))
    return *read(built, y), (8.0 * near - far) / (12.0 * step), motion


def multiplied(machine, opened, q, rates, force, crank):
    """Return accelerations (3 bodies,) and the multiplier of the crank's angle of a machine with joints `opened`.

    force : (3 bodies,) N and N m about the centres of mass; crank : angular acceleration of the crank, rad/s^2.
    """
    closure, step = Closure(machine), 1e-3 / np.max(np.abs(rates[2::3]))
    jacobian = closure.evaluate(q[None], np.zeros(1))[1]
    moves = step * np.outer((1.0, 2.0), rates)
    forward, backward = (closure.evaluate(q + side * moves, np.zeros(2))[1] for side in (1, -1))
    near, far = (forward - backward) @ rates
    lacking = ((8.0 * near - far) / (12.0 * step))[None]  # the change of the derivatives along the motion
    kept = [2 * j + k for j, joint in enumerate(machine.joints) if joint.name not in opened for k in (0, 1)]
    if crank is not None:
        kept.append(closure.rows - 1)
    rows, right = jacobian[0][kept], -lacking[0][kept]
    if crank is not None:
        right[-1] = crank
    bodies = [machine.bodies[name] for name in closure.names]
    mass = np.diag(np.concatenate([[body.mass, body.mass, body.inertia] for body in bodies]))
    whole = np.block([[mass, rows.T], [rows, np.zeros((len(kept), len(kept)))]])
    result = np.linalg.solve(whole, np.concatenate([force, right]))
    return result[: q.size], -result[-1]


def open_values(machine, opened, q):
    """Return the largest constraint (m, rad) of the joints that are not open."""
    values, _ = Closure(machine).evaluate(q[None], np.zeros(1))
    kept = [2 * j + k for j, joint in enumerate(machine.joints) if joint.name not in opened for k in (0, 1)]
    return float(np.max(np.abs(values[0][kept]), initial=0.0))


def weight_and_loads(machine, opened, q, loads):
    """Return the forces (3 bodies,) of gravity and of the loads of open joints on all bodies."""
    names = Closure(machine).names
    force = np.zeros(q.size)
    for i, name in enumerate(names):
        force[3 * i + 1] -= machine.bodies[name].mass * machine.gravity
    given = iter(loads)
    for joint in machine.joints:
        if joint.name not in opened:
            continue
        load = next(given)
        for at, sign, moment in (
            (joint.proximal, -1.0, load.moment_proximal),
            (joint.distal, 1.0, load.moment_distal),
        ):
            if at.body == "ground":
                continue
            i, body = 3 * names.index(at.body), machine.bodies[at.body]
            x, y = np.subtract(body.points[at.point], body.center)
            c, s = math.cos(q[i + 2]), math.sin(q[i + 2])
            arm = np.array([c * x - s * y, s * x + c * y])
            pull = sign * np.array([load.fx, load.fy])
            force[i : i + 2] += pull
            force[i + 2] += arm[0] * pull[1] - arm[1] * pull[0] + moment
    return force
