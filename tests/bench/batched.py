"""diffrax's Dopri8 over a batch of cases, stopped at every contact onset and separation: `b_base` and its like alone.

`vmap` makes of the loop over steps one that all cases go through until the last has ended: each contact and each flight
takes as many steps as that of the slowest case.  Time is the crank's angle, rates are those per radian.
"""

import math

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from clearsweep.verify.accuracy import scene_of
from clearsweep.verify.rivals import LEAST_RELATIVE_TOLERANCE, MAX_STEP_TURNS, TINY_DEPTH

from .mechanics import FLOOR, parameters

jax.config.update("jax_enable_x64", True)

LACKS = (
    "diffrax takes all cases of a batch from event to event together, each stretch as many steps as its slowest case;\n"
    "larger batches took longer. Below tolerances of 1e-8 its error hardly falls, presumably that of the dense output\n"
    "on which it locates events. It keeps no figures, no log of events and no force peaks."
)
FIRST_FREE, FIRST_PRESSED = 1e-3, 1e-5  # first steps after an event, rad
LOCATED = 1e-12  # to which events are located
MOST, STEPS = 400, 5000  # stretches, and steps of each


def _reach(t, u, r):
    """Return the rod's and the crank's cosines and sines, the pins' distance in x and y (m) and in all."""
    angle, x = u[0] * r["angle"], u[1] * r["place"]
    c, s, c1, s1 = jnp.cos(angle), jnp.sin(angle), jnp.cos(t), jnp.sin(t)
    dx, dy = x - r["crank"] * c1 - r["rod"] * c, -r["crank"] * s1 - r["rod"] * s
    return c, s, c1, s1, dx, dy, jnp.maximum(jnp.sqrt(dx * dx + dy * dy), TINY_DEPTH)  # cases begin centred


def _closing(t, u, r):
    """Return the rate (m/s) at which the pins go apart."""
    c, s, c1, s1, dx, dy, away = _reach(t, u, r)
    spin, v = u[2] * r["angle"], u[3] * r["place"]
    vx, vy = v + r["crank"] * s1 + r["rod"] * spin * s, -r["crank"] * c1 - r["rod"] * spin * c
    return (vx * dx + vy * dy) / away * r["rate"]


def _field(t, u, r):
    """Return the rates of a state."""
    c, s, c1, s1, dx, dy, away = _reach(t, u, r)
    depth = jnp.maximum(away - r["clearance"], 0.0)
    normal = r["stiffness"] * depth * jnp.sqrt(depth) * (1.0 + r["loss"] * _closing(t, u, r) / r["onset"])
    force = jnp.where(r["pressed"], jnp.maximum(normal, 0.0), 0.0) / r["rate"] ** 2
    fx, fy = -force * dx / away, -force * dy / away
    ax, ay = -r["crank"] * c1, -r["crank"] * s1
    angle_rate = -r["rod"] * (c * fy - s * fx) - r["rod_mass"] * r["center"] * (c * ay - s * ax)
    inertia = r["rod_inertia"] + r["rod_mass"] * r["center"] ** 2
    return jnp.stack([u[2], u[3], angle_rate / (inertia * r["angle"]), fx / (r["slider_mass"] * r["place"])])


def _margin(t, y, args, **_):
    """Return how far a case is from its next event, in clearances."""
    return jnp.where(args["pressed"], 1.0, -1.0) * (_reach(t, y, args)[-1] - args["clearance"]) / args["place"]


def _case(u, record, end, tolerance):
    """Return the state of a case when the crank has turned by `end` (rad)."""
    control = diffrax.PIDController(rtol=LEAST_RELATIVE_TOLERANCE, atol=tolerance, dtmax=MAX_STEP_TURNS * 2.0 * math.pi)
    event = diffrax.Event(_margin, optimistix.Newton(LOCATED, LOCATED), direction=False)

    def under_way(carry):
        t, *_, count = carry
        return (t < end) & (count < MOST)

    def stretch(carry):
        t, u, pressed, onset, count = carry
        first, now = jnp.where(pressed, FIRST_PRESSED, FIRST_FREE), record | {"pressed": pressed, "onset": onset}
        result = diffrax.diffeqsolve(
            diffrax.ODETerm(_field),
            diffrax.Dopri8(),
            *(t, end, first, u, now),
            stepsize_controller=control,
            event=event,
            max_steps=STEPS,
            adjoint=diffrax.ForwardMode(),
            throw=False,
        )
        t, u, met = result.ts[-1], result.ys[-1], result.result == diffrax.RESULTS.event_occurred
        onset = jnp.where(met & ~pressed, jnp.maximum(_closing(t, u, record), FLOOR), onset)
        return t, u, pressed ^ met, onset, count + 1

    start = jnp.zeros(()), u, jnp.zeros((), bool), jnp.ones(()), jnp.zeros((), int)
    return jax.lax.while_loop(under_way, stretch, start)[1]


_BATCH = jax.jit(jax.vmap(_case, in_axes=(0, 0, None, None)))
_READ = ("crank", "rate", "rod", "center", "rod_mass", "rod_inertia", "slider_mass", "clearance", "stiffness", "loss")


def prepared(problems: list, tolerance: float):
    """Return a function that integrates problems of one mechanism and speed to a time (s) and returns the states."""
    scenes = [scene_of(problem, tolerance) for problem in problems]
    rows = np.concatenate([parameters(scene) for scene in scenes])
    record = {name: rows[name] for name in (*_READ, "place", "angle")}
    unit = np.stack([rows["angle"], rows["place"], rows["spin"], rows["speed"]], axis=1)
    start, rate = np.array([scene.start[:4] for scene in scenes]) / unit, rows["rate"][0]
    return lambda time: np.asarray(_BATCH(start, record, time * rate, tolerance)) * unit
