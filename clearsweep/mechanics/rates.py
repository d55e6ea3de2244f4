"""The right-hand side: rates of the state, and what the motion does on the way (observables).

State, a vector of n numbers: coordinates q, their rates v, time t, one s per joint, the square root of the penetration
while the joint is in contact, and what laws with a memory remember.  The independent variable is not time but tau, with

    dt/dtau = kappa,   1/kappa = sigma * sum over joints in contact of 1/s,   kappa = 1 without contact,

and ds/dtau = kappa (rate + relaxation) / (2 s).  A Hertzian contact is singular in time: its force goes with t^1.5 at
both ends, which costs any high-order method its order there.  In tau it is smooth: the force is K s^3 and s passes
through zero like a straight line, so that entry and separation are ordinary points and the separation is a simple root.
The relaxation keeps s^2 and the penetration of the coordinates together (Baumgarte 1972, one integration constant).
"""

from typing import NamedTuple

from numba import types

from ..catalogue import Channel
from .compiled.dual import Seeded, lifted, slope
from .compiled.family import Entry, entry, inlined, kernel, shaped
from .joint.dry import FREE
from .joint.loads import loads_of, remember
from .joint.stick import held
from .mechanism.contract import accelerate, describe, energy, gaps, output_error, place
from .solver.dop853 import END, ROWS

# Columns of the observables, then a block of JOINT_WIDTH for every joint.
KAPPA, DRIVE, GRAVITY, ACCELERATION, TORQUE, KINETIC, ERROR, ERROR_RATE, JOINTS = 0, 1, 2, 3, 4, 5, 6, 7, 8
NORMAL, STORED, LOST, RUBBED, SPEED, RAW, DEPTH, RATE, JOINT_WIDTH = 0, 1, 2, 3, 4, 5, 6, 7, 8

MOST_CHANNELS = 30  # of a slider-crank with three joints


class Scene(NamedTuple):
    """A mechanism and its clearance joints; its type chooses the compiled code, its values are the parameters."""

    mechanism: tuple  # its compiled form
    joints: tuple  # one Joint per open joint, in the order of the sites
    coordinates: tuple  # as many zeros as there are coordinates: their number is part of the type
    pace: float  # rad/s, the scale of time: crank speed, or approach speed over clearance
    sigma: float  # m^0.5, sets the unit of tau; any positive number
    memories: tuple = ()  # the size of each number that laws remember: how many there are is part of the type


@inlined
def look(scene, y, state, onset):
    """Return the pose at the state `y`, and the Gaps, Loads and Motion that follow from it."""
    p = place(scene.mechanism, y)
    relative = gaps(scene.mechanism, p)
    first = 2 * len(scene.coordinates) + 1
    loads = loads_of(scene.joints, relative, y, first, first + len(scene.joints), state, onset, 0)
    loads = held(scene, y, p, relative, loads, state)
    return p, relative, loads, accelerate(scene.mechanism, p, loads)


@kernel
def clock(scene, y, state):
    """Return kappa = dt/dtau at the state `y`, s."""
    first = 2 * len(scene.coordinates) + 1
    if len(scene.joints) == 1:
        return y[first] / scene.sigma if state[0] != FREE else 1.0
    slowness = 0.0
    for j in range(len(scene.joints)):
        if state[j] != FREE:
            slowness += 1.0 / y[first + j]
    return 1.0 / (scene.sigma * slowness) if slowness != 0.0 else 1.0


@inlined
def catching_up(pace, rate, depth, root):
    """Return half of what the square of a root of penetration changes by, m/s: it follows the depth."""
    return 0.5 * (rate + pace * (depth - root * root))


@inlined
def rates(scene, y, state, onset, k, o, row):
    """Put the rates of `y` with respect to tau into `k[row]` and the observables into `o[row]`.

    y : (n,) state; k : (16, n); o : (16, JOINTS + JOINT_WIDTH * joints); state, onset : (joints,) what each joint does
    and the rate (m/s) at which its contact began.
    """
    n = len(scene.coordinates)
    time = 2 * n
    first = time + 1
    p, _, loads, motion = look(scene, y, state, onset)
    kinetic, gravity_power = energy(scene.mechanism, p)

    kappa = clock(scene, y, state)
    for i in range(n):
        k[row, i] = kappa * y[n + i]
        k[row, n + i] = kappa * motion.accelerations[i]
    k[row, time] = kappa
    o[row, KAPPA] = kappa
    o[row, DRIVE] = motion.torque * scene.pace
    o[row, GRAVITY] = gravity_power
    o[row, ACCELERATION] = motion.output
    o[row, TORQUE] = motion.torque
    if row == 0 or row >= END:  # wanted where the state is accurate, at the ends of a step and on the interpolant
        o[row, KINETIC] = kinetic
        o[row, ERROR], o[row, ERROR_RATE] = output_error(scene.mechanism, p)
    for j in range(len(scene.joints)):
        load = loads[j]
        root = y[first + j]
        block = JOINTS + JOINT_WIDTH * j
        closing = 0.0
        if state[j] != FREE:
            closing = catching_up(scene.pace, load.rate, load.depth, root)
            closing *= 1.0 / scene.sigma if len(scene.joints) == 1 else kappa / root  # kappa / s, also at s = 0
        k[row, first + j] = closing
        o[row, block + NORMAL] = load.normal
        o[row, block + STORED] = load.elastic * load.rate
        o[row, block + LOST] = (load.normal - load.elastic) * load.rate
        o[row, block + RUBBED] = -load.tangential * load.slip
        o[row, block + SPEED] = load.slip
        o[row, block + RAW] = load.raw
        o[row, block + DEPTH] = load.depth
        o[row, block + RATE] = load.rate
    remember(scene.joints, loads, y, kappa, state, k[row], first + len(scene.joints), 0)


def rates_entry(scene, y, state, onset, k, o, row):
    """Evaluate `rates` with arrays from bare pointers; `scene` points at the Scene."""
    here = scene[0]
    joints = len(here.joints)
    n = 2 * len(here.coordinates) + 1 + joints + len(here.memories)
    columns = JOINTS + JOINT_WIDTH * joints
    rates(
        here,
        shaped(y, (n,)),
        shaped(state, (joints,)),
        shaped(onset, (joints,)),
        shaped(k, (ROWS, n)),
        shaped(o, (ROWS, columns)),
        row,
    )


@inlined
def differentiate(scene, y, state, onset, jacobian, place):
    """Put the derivatives of the `rates` at the state `y` into `jacobian[place]` (n, n): exact ones, by columns."""
    n = len(scene.coordinates)
    first = 2 * n + 1
    for column in range(first + len(scene.joints) + len(scene.memories)):
        z = Seeded(y, column)
        _, _, loads, motion = look(scene, z, state, onset)
        kappa = lifted(clock(scene, z, state))
        for i in range(n):
            jacobian[place, i, column] = slope(kappa * z[n + i])
            jacobian[place, n + i, column] = slope(kappa * motion.accelerations[i])
        jacobian[place, 2 * n, column] = slope(kappa)
        for j in range(len(scene.joints)):
            jacobian[place, first + j, column] = 0.0
            if state[j] != FREE:
                closing = catching_up(scene.pace, loads[j].rate, loads[j].depth, z[first + j])
                closing *= lifted(1.0 / scene.sigma if len(scene.joints) == 1 else kappa / z[first + j])
                jacobian[place, first + j, column] = slope(closing)
        remember(scene.joints, loads, z, kappa, state, jacobian[place, :, column], first + len(scene.joints), 0)


def slopes_entry(scene, y, state, onset, jacobian, place):
    """Evaluate `differentiate` with arrays from bare pointers, as in `rates_entry`."""
    here = scene[0]
    joints = len(here.joints)
    n = 2 * len(here.coordinates) + 1 + joints + len(here.memories)
    differentiate(
        here, shaped(y, (n,)), shaped(state, (joints,)), shaped(onset, (joints,)), shaped(jacobian, (3, n, n)), place
    )


#: The time histories of a joint, as `sample_entry` puts them.
JOINT_CHANNELS = (
    Channel("x", "m", "journal centre relative to the bearing centre, fixed frame, x"),
    Channel("y", "m", "journal centre relative to the bearing centre, fixed frame, y"),
    Channel("vx", "m/s", "its rate, x"),
    Channel("vy", "m/s", "its rate, y"),
    Channel("force_normal", "N", "normal force, at least 0, pushing the journal back to the centre"),
    Channel("force_tangential", "N", "tangential force on the journal along the outward normal turned by +90 degrees"),
)


def sample_entry(scene, y, state, onset, side, out, row):
    """Put the time histories' values at the state `y` into `out`, in the order of the channels."""
    here = scene[0]
    joints = len(here.joints)
    time = 2 * len(here.coordinates)
    values = shaped(out, (MOST_CHANNELS,))
    state, side = shaped(state, (joints,)), shaped(side, (joints,))
    y = shaped(y, (time + 1 + joints + len(here.memories),))
    pose, relative, loads, motion = look(here, y, state, shaped(onset, (joints,)))
    column = describe(here.mechanism, y, pose, motion, values)
    for j in range(joints):
        gap, load = relative[j], loads[j]
        values[column], values[column + 1] = side[j] * gap.x, side[j] * gap.y
        values[column + 2], values[column + 3] = side[j] * gap.vx, side[j] * gap.vy
        values[column + 4], values[column + 5] = load.normal, load.tangential
        column += 6


_STATE = (types.float64, types.int64, types.float64)  # y, state, onset
RATES_ARRAYS = (*_STATE, types.float64, types.float64)


def rates_of(scene, parameters) -> Entry:
    """Return the Entry that evaluates the right-hand side of `scene`."""
    return entry(rates_entry, scene, RATES_ARRAYS, parameters)


def slopes_of(scene, parameters) -> Entry:
    """Return the Entry that differentiates the right-hand side of `scene`."""
    return entry(slopes_entry, scene, (*_STATE, types.float64), parameters)


def samples_of(scene, parameters) -> Entry:
    """Return the Entry that evaluates the time histories' values of `scene`."""
    return entry(sample_entry, scene, (*_STATE, types.float64, types.float64), parameters)
