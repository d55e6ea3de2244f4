"""Sums, counts and maxima of the motion, computed from the steps, never from samples."""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import abreast, total_of, where
from ...compiled.family import inlined
from ...joint.contract import acts, touches
from ...observe.histogram import PARTS, force_bin, ramp_of
from ...observe.observables import (
    ACCELERATION,
    DEPTH,
    ERROR,
    ERROR_RATE,
    KAPPA,
    KINETIC,
    LOAD,
    NORMAL,
    TORQUE,
    column_of,
    put_load,
)
from ...observe.stages import END, NODES, START
from .step_sums import (
    NO_PEAK,
    highest_inside,
)

# Columns of Totals.whole: five integrals of power since the start (J), their balance, figures of the window.
WORK_DRIVE, WORK_GRAVITY, ENERGY_STORED, ENERGY_LOST, ENERGY_RUBBED, KINETIC_START, KINETIC_MAX, RESIDUAL = range(8)
ACCELERATION_SQUARE, ACCELERATION_MAX, TORQUE_MAX, ERROR_MAX = range(8, 12)
OPENED, SPEED_MIN, SPEED_MAX, WHOLE = range(12, 16)  # s, start of the window; rad/s, of a free crank
# Columns of Totals.joint: figures of the window, LOAD_MAX in N^2 and taken where there is friction; then PEAK (N) and
# APPROACH (m/s) of the present contact.  FRICTION_ENERGY (J) is that of dry friction.  LOAD_TIME and DRY_FORCE_TIME
# (N s) are integrals of the sizes of the normal force and of its dry share, where there is a film.
(
    FORCE_SQUARE,
    CONTACT_TIME,
    FORCE_MAX,
    LOAD_MAX,
    DEPTH_MAX,
    ONSET_MAX,
    ONSETS,
    CLIPS,
    RESTITUTION,
    REBOUNDS,
    BEYOND_TIME,
    FORCE_TIME,
    FRICTION_ENERGY,
    LOAD_TIME,
    DRY_FORCE_TIME,
    HELD_TIME,
    DRAINED_ENERGY,
    FED_ENERGY,
    HEAT,
    DRY_MAX,
    PRESSURE_MAX,
    SPEED_MOST,
    PEAK,
    APPROACH,
    JOINT,
) = range(25)


HIGHEST_BIN = PARTS + 1  # in Totals.bins: the highest bin used
#: Rows of Totals.spent, for each part of the step: its duration relative to other parts, a histogram.Ramp, and the
#: time (s) during which a film pulls.
LASTING, BEGUN, ENDED, DENSITY, PULLED, SPENT = range(6)


class Totals(NamedTuple):
    """Sums and maxima of one integration."""

    whole: np.ndarray  # (WHOLE,) of the mechanism
    joint: np.ndarray  # (contacts, JOINT)
    histogram: np.ndarray  # (contacts, BINS, 2) s, at a force within each bin; s/N, increment in each bin above it
    dry: np.ndarray  # the same for the dry share of the force, above zero; (0, BINS, 2) without films
    step_values: np.ndarray  # (contacts, COURSES, PARTS + 1) at equidistant places of the step, see histogram
    bins: np.ndarray  # (contacts, HIGHEST_BIN + 1) int64, bins of the force between the parts of the step
    spent: np.ndarray  # (contacts, SPENT, PARTS) contribution of each part to the histogram
    length: np.ndarray  # (1,) length of the step
    between: np.ndarray  # (2 coordinates + 1, MOMENTS) the state within the step, with wear
    workspace: np.ndarray  # for the wear of a step, see joint.wear.step
    wear: np.ndarray  # (2 contacts bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (contacts, ACCOUNT) see joint.wear.contract
    friction: np.ndarray  # (friction loads,) J, work of each in the window


OF_STEPS = "whole", "joint", "bins", "spent"  # fields that every step changes


class Accumulators(NamedTuple):
    """Arrays of the assessment and accumulation of a step, see `event.Work`, Totals and Turns."""

    y: tuple
    mode: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple
    contact_steps: tuple
    profiles: tuple
    stepper: tuple
    clearance: tuple
    film: tuple
    rubs: tuple
    whole: tuple
    joint: tuple
    bins: tuple
    spent: tuple
    highest: tuple
    since: tuple


@inlined
def accumulate_step(accumulators, time):
    """Add an accepted step to the totals; `time` is the place of the time in the state.

    Maxima are those at the ends of the step.  Where a larger one may lie between, NEEDS_PEAK_SEARCH of its `step` is
    set
    and HIGHEST is kept for the maxima to search for; all other HIGHEST are set to NO_PEAK.
    """
    counted = accumulators.stepper.in_window != 0.0
    accumulators.step.needs_peak_search = 0.0
    enter_powers(accumulators, counted)
    for j in range(accumulators.mode.size):
        duration = accumulators.end[time] - accumulators.y[time]
        accumulators.since[j] = max(accumulators.since[j], accumulators.highest[j])  # of the step before
        accumulators.highest[j] = 0.0
        if counted and touches(accumulators.mode[j]):
            accumulators.joint[j, CONTACT_TIME] += duration
        if acts(accumulators.mode[j]):
            enter_contact(accumulators, j, counted, duration)
        else:
            highest = accumulators.contact_steps[j]
            highest.highest_force = highest.highest_depth = highest.highest_load = NO_PEAK
            if counted:
                raise_to(accumulators.joint, (j, DEPTH_MAX), accumulators.o[column_of(j, DEPTH), END])
    enter_motion(accumulators, counted)


@inlined
def raise_to(maxima, index, value):
    """Raise a maximum to a value."""
    maxima[index] = max(maxima[index], value)


@inlined
def sought_above(step, highest, some, least):
    """Return `highest`, and request a search for the maximum between the stages, if `some` and it exceeds `least`."""
    if some and highest > least:
        step.needs_peak_search = 1.0
        return highest
    return NO_PEAK


@inlined
def enter_powers(accumulators, counted):
    """Integrate powers and squares with the weights of the method, at its order."""
    total, joint, step, h = accumulators.whole, accumulators.joint, accumulators.step, accumulators.step.length
    total[WORK_DRIVE] += h * step.sum_drive
    total[WORK_GRAVITY] += h * step.sum_gravity
    if counted:
        total[ACCELERATION_SQUARE] += h * step.sum_acceleration
    for j in range(accumulators.mode.size):
        if acts(accumulators.mode[j]):
            sums = accumulators.contact_steps[j]
            total[ENERGY_STORED] += h * sums.sum_stored
            total[ENERGY_LOST] += h * sums.sum_lost
            total[ENERGY_RUBBED] += h * sums.sum_rubbed
            if counted:
                joint[j, FORCE_SQUARE] += h * sums.sum_force_square
                joint[j, FORCE_TIME] += h * sums.sum_force
                # the tangential force includes the shear of a film
                if accumulators.rubs[j] != 0 and accumulators.film[j, 1] == math.inf:
                    joint[j, FRICTION_ENERGY] += h * sums.sum_rubbed
    kinetic = accumulators.o[KINETIC, END]
    gain = kinetic - total[KINETIC_START] + total[ENERGY_STORED] + total[ENERGY_LOST] + total[ENERGY_RUBBED]
    imbalance = abs(total[WORK_DRIVE] + total[WORK_GRAVITY] - gain)
    raise_to(total, RESIDUAL, imbalance if imbalance <= math.inf else math.inf)  # a maximum skips nan
    raise_to(total, KINETIC_MAX, kinetic)


@inlined
def enter_contact(accumulators, j, counted, duration):
    """Add the largest force (N) and depth (m) of acting contact `j`, and the profile of its force."""
    o, joint, step, highest = accumulators.o, accumulators.joint, accumulators.step, accumulators.contact_steps[j]
    force, depth, load = column_of(j, NORMAL), column_of(j, DEPTH), column_of(j, LOAD)
    least = 0.9 * min(joint[j, PEAK], accumulators.since[j])
    highest.highest_force = sought_above(step, highest.highest_force, True, least)
    largest = max(o[force, START], o[force, END])
    raise_to(joint, (j, PEAK), largest)
    accumulators.highest[j] = largest
    # with a film, of the eccentricity: the least distance from the bearing is needed, too
    margin = 0.02 * accumulators.clearance[j] if accumulators.film[j, 1] < math.inf else 0.0
    least = 0.98 * joint[j, DEPTH_MAX] - margin
    highest.highest_depth = sought_above(step, highest.highest_depth, counted, least)
    highest.highest_load = NO_PEAK
    if not counted:
        return
    raise_to(joint, (j, FORCE_MAX), largest)
    raise_to(joint, (j, DEPTH_MAX), max(o[depth, START], o[depth, END]))
    enter_course(accumulators, j, duration)
    if accumulators.rubs[j] != 0:
        for row in NODES:
            put_load(o, row, j)
        highest.highest_load = sought_above(step, highest_inside(o, load, 1.0), True, 0.96 * joint[j, LOAD_MAX])
        raise_to(joint, (j, LOAD_MAX), max(o[load, START], o[load, END]))


@inlined
def enter_course(accumulators, j, duration):
    """Distribute the step's time (s) over bins by the profile of contact `j`'s force, all parts of the step at once."""
    histograms, bins, film = accumulators.spent, accumulators.bins, accumulators.film[j, 1] < math.inf
    kappa, force = accumulators.profiles[0], accumulators.profiles[1 + j]
    for i in abreast(PARTS):
        histograms[j, LASTING, i] = max(kappa[i], 0.0) + max(kappa[i + 1], 0.0)
    share = duration / total_of(histograms[j, LASTING])
    for i in abreast(PARTS):
        start_value, end_value = force[i], force[i + 1]
        lasting = histograms[j, LASTING, i] * share
        pulls = film and start_value * end_value < 0.0  # part of the time; noise of a contact close to 0 is excluded
        pushing = lasting * where(
            pulls, max(start_value, end_value) / where(pulls, abs(end_value - start_value), 1.0), 1.0
        )
        start_value, end_value = max(start_value, 0.0), max(end_value, 0.0)
        begin_bin, end_bin = force_bin(start_value), force_bin(end_value)
        ramp = ramp_of((start_value, end_value), (begin_bin, end_bin), pushing)
        bins[j, i], bins[j, i + 1] = begin_bin, end_bin
        histograms[j, BEGUN, i], histograms[j, ENDED, i], histograms[j, DENSITY, i] = ramp
        histograms[j, PULLED, i] = lasting - pushing
    highest = bins[j, HIGHEST_BIN]
    for i in range(PARTS + 1):
        highest = max(highest, bins[j, i])
    bins[j, HIGHEST_BIN] = highest


@inlined
def enter_motion(accumulators, counted):
    """Add the largest slider acceleration (m/s^2), torque (N m) and slider error (m)."""
    o, total, step = accumulators.o, accumulators.whole, accumulators.step
    largest, sign = max(abs(o[ERROR, START]), abs(o[ERROR, END])), math.copysign(1.0, o[ERROR, END])
    start_slope, end_slope = sign * o[ERROR_RATE, START], sign * o[ERROR_RATE, END]
    highest = largest + 0.25 * step.length * o[KAPPA, START] * min(
        start_slope, -end_slope
    )  # a parabola's rise above the higher end
    step.highest_error = highest if start_slope > 0.0 and end_slope < 0.0 else NO_PEAK
    least = 0.98 * total[ACCELERATION_MAX]
    step.highest_acceleration = sought_above(step, step.highest_acceleration, counted, least)
    step.highest_torque = sought_above(step, step.highest_torque, counted, 0.98 * total[TORQUE_MAX])
    step.highest_error = sought_above(step, step.highest_error, counted, total[ERROR_MAX])
    if counted:
        raise_to(total, ACCELERATION_MAX, max(abs(o[ACCELERATION, START]), abs(o[ACCELERATION, END])))
        raise_to(total, TORQUE_MAX, max(abs(o[TORQUE, START]), abs(o[TORQUE, END])))
        raise_to(total, ERROR_MAX, largest)
