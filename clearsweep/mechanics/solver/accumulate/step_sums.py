"""Quantities of one whole step: error, sums, profiles, maxima."""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.choosing import lane_range
from ....tracing.compiled.family import inlined
from ....tracing.fields import Fields
from ...laws.contract import acts, meets
from ...observe import (
    ACCELERATION,
    CONTACT_WIDTH,
    CONTACTS,
    DEPTH,
    DRIVE,
    END,
    GRAVITY,
    KAPPA,
    LOST,
    NODE_FRACTIONS,
    NODES,
    NORMAL,
    PARTS,
    SLIP,
    STAGES,
    START,
    STORED,
    TANGENTIAL,
    TO_PART_ENDS,
    TORQUE,
    column_of,
)


class Step(Fields):
    """Length and results of a trial step; a sum is over the stages, each with its weight and dt/dtau."""

    length: float  # along tau
    part: float  # of a sweep, see `collocation`
    preconditioned: float  # nonzero if its iteration is preconditioned
    error: float  # divided by the allowed error
    change: float  # mean square over stages and components of the latest change, divided by the allowed error
    contraction: float  # ratio of the change of a sweep to that of the sweep before
    sweeps: float  # number of sweeps
    proposal: float  # length of the next step as far as the error of this one allows
    accepted: float  # nonzero if the step is accurate and contains no event
    stiff: float  # nonzero if a stiff component may limit the step
    needs_peak_search: float  # nonzero if a maximum between its stages may exceed the values at its ends
    sum_drive: float  # W, power of the drive
    sum_gravity: float  # W, power of gravity and loads
    sum_acceleration: float  # square of the output's acceleration
    highest_acceleration: float  # size at the stages where a maximum may lie within the step, else NO_PEAK
    highest_torque: float  # N m, likewise
    highest_error: float  # of the output, likewise


class ContactStep(Fields):
    """Results of a trial step for a contact."""

    sum_stored: float  # W, stored in elastic deformation
    sum_lost: float  # W, dissipated by the normal force
    sum_friction: float  # W, dissipated by friction
    sum_force: float  # N, normal force
    sum_force_square: float  # N^2
    fastest: float  # m per unit of tau, largest journal speed at the start and all stages but the last
    highest_force: float  # N, at the stages where a maximum may lie within the step, else NO_PEAK
    highest_depth: float  # m, likewise
    highest_load: float  # N^2, likewise


NO_PEAK = -math.inf  # the highest value of an observable without maximum between the ends of the step


class TrialStep(NamedTuple):
    """Inputs and results of a trial step, see `integration.Work`."""

    y: tuple
    mode: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple
    contact_steps: tuple
    profiles: tuple


@inlined
def sum_stages(trial, weights):
    """Write the sums of powers and squares over the stages, with `weights`, for acting contacts."""
    o, step = trial.o, trial.step
    drive = gravity = square = 0.0
    for row in range(weights.size):
        if weights[row] != 0.0:
            weight = weights[row] * o[KAPPA, row]
            drive, gravity = drive + weight * o[DRIVE, row], gravity + weight * o[GRAVITY, row]
            square = square + weight * (o[ACCELERATION, row] * o[ACCELERATION, row])
    step.sum_drive, step.sum_gravity, step.sum_acceleration = drive, gravity, square
    for c in range(trial.mode.size):
        if not acts(trial.mode[c]):
            continue
        block, sums = CONTACTS + CONTACT_WIDTH * c, trial.contact_steps[c]
        stored = dissipated = friction = total = square = 0.0
        for row in range(weights.size):
            if weights[row] != 0.0:
                weight, force = weights[row] * o[KAPPA, row], o[block + NORMAL, row]
                stored, dissipated = (
                    stored + weight * o[block + STORED, row],
                    dissipated + weight * o[block + LOST, row],
                )
                friction = friction - weight * (o[block + TANGENTIAL, row] * o[block + SLIP, row])
                total, square = total + weight * force, square + weight * (force * force)
        sums.sum_stored, sums.sum_lost, sums.sum_friction = stored, dissipated, friction
        sums.sum_force, sums.sum_force_square = total, square


@inlined
def stage_integral(o, column, weights):
    """Return the weighted sum of an observable over the stages; times the step's length it is the integral."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[KAPPA, row] * o[column, row]
    return total


@inlined
def integral_of_negative_part(o, column, weights):
    """Return the `stage_integral` of the negative part of an observable, as a positive number."""
    total = 0.0
    for row in range(weights.size):
        total -= weights[row] * o[KAPPA, row] * min(o[column, row], 0.0)
    return total


@inlined
def integral_of_magnitude(o, column, weights):
    """Return the `stage_integral` of the absolute value of an observable."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[KAPPA, row] * abs(o[column, row])
    return total


@inlined
def write_profiles(trial):
    """Write the profiles of dt/dtau and of the forces of acting contacts: polynomials through the stages."""
    write_profile(trial.o, KAPPA, trial.profiles[0])
    for c in range(trial.mode.size):
        if acts(trial.mode[c]):
            write_profile(trial.o, column_of(c, NORMAL), trial.profiles[1 + c])


@inlined
def write_profile(o, column, profile):
    """Write the profile of an observable to `profile` (PARTS + 1,)."""
    profile[0] = o[column, START]
    for i in lane_range(PARTS):
        total = TO_PART_ENDS[0, i] * o[column, NODES[0]]
        for m in range(1, NODES.size):
            total += TO_PART_ENDS[m, i] * o[column, NODES[m]]
        profile[1 + i] = total


@inlined
def write_sums(trial, weights):
    """Write the sums, profiles and maxima of a step; the rows with nonzero `weights` contain its observables."""
    sum_stages(trial, weights)
    write_profiles(trial)
    write_largest_speeds(trial)
    write_peaks(trial)


@inlined
def write_largest_speeds(trial):
    """Write the largest speed of journals in free flight at the start and all stages but the last."""
    o = trial.o
    for c in range(trial.mode.size):
        if not meets(trial.mode[c]):
            continue
        fastest = o[column_of(c, SLIP), START] * o[KAPPA, START]
        for row in range(END):
            fastest = max(fastest, o[column_of(c, SLIP), row] * o[KAPPA, row])
        trial.contact_steps[c].fastest = fastest


@inlined
def write_peaks(trial):
    """Write the highest values of observables that may have a peak; of contacts, only acting ones."""
    o, step = trial.o, trial.step
    step.highest_acceleration = interior_peak(o, ACCELERATION, math.copysign(1.0, o[ACCELERATION, END]))
    step.highest_torque = interior_peak(o, TORQUE, math.copysign(1.0, o[TORQUE, END]))
    for c in range(trial.mode.size):
        if not acts(trial.mode[c]):
            continue
        trial.contact_steps[c].highest_force = interior_peak(o, column_of(c, NORMAL), 1.0)
        trial.contact_steps[c].highest_depth = interior_peak(o, column_of(c, DEPTH), 1.0)


@inlined
def interior_peak(o, column, sign):
    """Return the largest value of an observable times `sign` at the nodes, or NO_PEAK if it has no peak in the step.

    There is a peak if a stage is higher than both ends, or if the observable rises at the start of the step and falls
    at its end.  The slopes are those of parabolas through three nodes, a tenth of the step outside its start and end.
    So a peak near the end of a step counts in both steps.
    """
    start_slope = end_slope = 0.0
    for m in range(3):
        start_slope += START_SLOPE[m] * o[column, NODES[START_NODES[m]]]
        end_slope += END_SLOPE[m] * o[column, NODES[END_NODES[m]]]
    highest_end = max(sign * o[column, START], sign * o[column, END])
    highest = highest_end
    for m in range(STAGES - 1):
        highest = max(highest, sign * o[column, m])
    if highest > highest_end or sign * start_slope > 0.0 > sign * end_slope:
        return highest
    return NO_PEAK


def _slope_weights(nodes, point):
    """Return the weights of the slope at `point` of the parabola through values at three `nodes`."""
    a, b, c = nodes
    return np.array(
        [
            (2 * point - b - c) / ((a - b) * (a - c)),
            (2 * point - a - c) / ((b - a) * (b - c)),
            (2 * point - a - b) / ((c - a) * (c - b)),
        ]
    )


START_NODES, END_NODES = np.array([0, 2, 3]), np.array([5, 6, 8])  # of NODES, some tenths of the step apart
START_SLOPE, END_SLOPE = (
    _slope_weights(NODE_FRACTIONS[START_NODES], -0.1),
    _slope_weights(NODE_FRACTIONS[END_NODES], 1.1),
)
