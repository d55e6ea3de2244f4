"""Quantities of one whole step: error, sums, profiles, maxima.

They are in `Work.step`, after the step's length and error.  The sums run over the stages, each weighted, times dt/dtau.
The highest value of an observable at the stages is stored where a maximum may lie within the step, else NO_PEAK.  The
profiles of dt/dtau and of every contact's force over the step follow.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import abreast
from ...compiled.family import inlined
from ...joint.contract import acts, meets
from ...observe.histogram import COURSE, PARTS
from ...observe.observables import (
    ACCELERATION,
    CONTACT_WIDTH,
    CONTACTS,
    DEPTH,
    DRIVE,
    GRAVITY,
    KAPPA,
    LOST,
    NORMAL,
    SLIP,
    STORED,
    TANGENTIAL,
    TORQUE,
    column_of,
)
from ...observe.stages import END, NODES, SHARES, STAGES, START

(
    LENGTH,
    ERROR,
    CHANGE,  # mean square over the stages of the last change of a component, over the allowed error
    CONTRACTION,  # ratio of the change of a sweep to that of the sweep before
    SWEEPS,  # number of sweeps
    ACCEPTED,  # nonzero if the step is accurate and contains no event
    STIFF,  # nonzero if a stiff component may limit the step
    NEEDS_PEAK_SEARCH,  # nonzero if a maximum between its stages may exceed the values at its ends
    SUM_DRIVE,
    SUM_GRAVITY,
    SUM_ACCELERATION,
    HIGHEST_ACCELERATION,
    HIGHEST_TORQUE,
    HIGHEST_ERROR,
    SUMS,
) = range(15)
(
    SUM_STORED,
    SUM_LOST,
    SUM_RUBBED,
    SUM_FORCE,
    SUM_FORCE_SQUARE,
    FASTEST,  # m per unit of tau, largest journal speed at the start and all stages but the last
    HIGHEST_FORCE,
    HIGHEST_DEPTH,
    HIGHEST_LOAD,
    SUMS_OF_CONTACT,
) = range(10)
NO_PEAK = -math.inf  # HIGHEST of an observable without maximum between the ends of the step


class TrialStep(NamedTuple):
    """Inputs and results of a trial step, see `event.Work`."""

    y: tuple
    mode: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple


@inlined
def step_width(contacts):
    """Return the length of `Work.step`."""
    return SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contacts)


@inlined
def sum_of(contact, quantity):
    """Return the place of a sum of a contact: SUM_STORED to HIGHEST_LOAD."""
    return SUMS + SUMS_OF_CONTACT * contact + quantity


@inlined
def course_of(contacts, contact):
    """Return the first place of the profile of a contact's force; of dt/dtau if `contact` is -1."""
    return SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contact)


@inlined
def sum_along(trial, weights):
    """Write the sums of powers and squares over the stages, with `weights`, to `step`, for acting contacts."""
    o, step = trial.o, trial.step
    drive = gravity = square = 0.0
    for row in range(weights.size):
        if weights[row] != 0.0:
            share = weights[row] * o[KAPPA, row]
            drive, gravity = drive + share * o[DRIVE, row], gravity + share * o[GRAVITY, row]
            square = square + share * (o[ACCELERATION, row] * o[ACCELERATION, row])
    step[SUM_DRIVE], step[SUM_GRAVITY], step[SUM_ACCELERATION] = drive, gravity, square
    for c in range(trial.mode.size):
        if not acts(trial.mode[c]):
            continue
        block, start_slope = CONTACTS + CONTACT_WIDTH * c, SUMS + SUMS_OF_CONTACT * c
        stored = lost = rubbed = total = square = 0.0
        for row in range(weights.size):
            if weights[row] != 0.0:
                share, force = weights[row] * o[KAPPA, row], o[block + NORMAL, row]
                stored, lost = stored + share * o[block + STORED, row], lost + share * o[block + LOST, row]
                rubbed = rubbed - share * (o[block + TANGENTIAL, row] * o[block + SLIP, row])
                total, square = total + share * force, square + share * (force * force)
        step[start_slope + SUM_STORED], step[start_slope + SUM_LOST], step[start_slope + SUM_RUBBED] = (
            stored,
            lost,
            rubbed,
        )
        step[start_slope + SUM_FORCE], step[start_slope + SUM_FORCE_SQUARE] = total, square


@inlined
def integral_of(o, column, weights):
    """Return the sum of an observable over the stages with `weights`; times the step's length, its integral."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[KAPPA, row] * o[column, row]
    return total


@inlined
def negative_part_of(o, column, weights):
    """Return the sum of the negative part of an observable, as a positive number."""
    total = 0.0
    for row in range(weights.size):
        total -= weights[row] * o[KAPPA, row] * min(o[column, row], 0.0)
    return total


@inlined
def integral_of_size(o, column, weights):
    """Return the sum of the absolute value of an observable."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[KAPPA, row] * abs(o[column, row])
    return total


@inlined
def follow_along(trial):
    """Write the profiles of dt/dtau and of the forces of acting contacts to `step`: polynomials through the stages."""
    contacts = trial.mode.size
    follow_column(trial, KAPPA, course_of(contacts, -1))
    for c in range(contacts):
        if acts(trial.mode[c]):
            follow_column(trial, column_of(c, NORMAL), course_of(contacts, c))


@inlined
def follow_column(trial, column, start_slope):
    """Write the profile of an observable to `step`, starting at `start_slope`."""
    trial.step[start_slope] = trial.o[column, START]
    for i in abreast(PARTS):
        total = COURSE[0, i] * trial.o[column, NODES[0]]
        for m in range(1, NODES.size):
            total += COURSE[m, i] * trial.o[column, NODES[m]]
        trial.step[start_slope + 1 + i] = total


@inlined
def sum_up(trial, weights):
    """Write the sums, profiles and maxima of a step to `step`; its rows of `weights` are filled."""
    sum_along(trial, weights)
    follow_along(trial)
    look_for_speeds(trial)
    look_for_peaks(trial)


@inlined
def look_for_speeds(trial):
    """Write the largest speed of journals in free flight at the start and all stages but the last to `step`."""
    o, step = trial.o, trial.step
    for c in range(trial.mode.size):
        if not meets(trial.mode[c]):
            continue
        fastest = o[column_of(c, SLIP), START] * o[KAPPA, START]
        for row in range(END):
            fastest = max(fastest, o[column_of(c, SLIP), row] * o[KAPPA, row])
        step[sum_of(c, FASTEST)] = fastest


@inlined
def look_for_peaks(trial):
    """Write the highest values of observables that may have a peak to `step`; of contacts, only acting ones."""
    o, step = trial.o, trial.step
    step[HIGHEST_ACCELERATION] = highest_inside(o, ACCELERATION, math.copysign(1.0, o[ACCELERATION, END]))
    step[HIGHEST_TORQUE] = highest_inside(o, TORQUE, math.copysign(1.0, o[TORQUE, END]))
    for c in range(trial.mode.size):
        if not acts(trial.mode[c]):
            continue
        step[sum_of(c, HIGHEST_FORCE)] = highest_inside(o, column_of(c, NORMAL), 1.0)
        step[sum_of(c, HIGHEST_DEPTH)] = highest_inside(o, column_of(c, DEPTH), 1.0)


@inlined
def highest_inside(o, column, sign):
    """Return the largest value of an observable times `sign` at the nodes, or NO_PEAK if it has no peak in the step.

    A peak rises at the start of the step and falls at its end, or nearly so.  The slopes are those of parabolas through
    three nodes at either end, a tenth of the step outside, so that a peak near an end counts in both steps.
    """
    start_slope = end_slope = 0.0
    for m in range(3):
        start_slope += RISE[m] * o[column, NODES[FIRST[m]]]
        end_slope += FALL[m] * o[column, NODES[FINAL[m]]]
    if not (sign * start_slope > 0.0 > sign * end_slope):
        return NO_PEAK
    highest = sign * o[column, START]
    for m in range(STAGES):
        highest = max(highest, sign * o[column, m])
    return highest


def _slope(nodes, point):
    """Return the weights of the slope at `point` of the parabola through values at three `nodes`."""
    a, b, c = nodes
    return np.array(
        [
            (2 * point - b - c) / ((a - b) * (a - c)),
            (2 * point - a - c) / ((b - a) * (b - c)),
            (2 * point - a - b) / ((c - a) * (c - b)),
        ]
    )


FIRST, FINAL = np.array([0, 2, 3]), np.array([5, 6, 8])  # of NODES, some tenths of the step apart
RISE, FALL = _slope(SHARES[FIRST], -0.1), _slope(SHARES[FINAL], 1.1)
