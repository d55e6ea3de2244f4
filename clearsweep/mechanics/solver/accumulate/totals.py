"""What is summed, counted and maximised along the motion; all of it from the steps themselves, none from samples."""

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
from ..run_control import STEPPER_IN_WINDOW
from .step_sums import (
    HIGHEST_ACCELERATION,
    HIGHEST_DEPTH,
    HIGHEST_ERROR,
    HIGHEST_FORCE,
    HIGHEST_LOAD,
    HIGHEST_TORQUE,
    LENGTH,
    NEEDS_PEAK_SEARCH,
    NO_PEAK,
    SUM_ACCELERATION,
    SUM_DRIVE,
    SUM_FORCE,
    SUM_FORCE_SQUARE,
    SUM_GRAVITY,
    SUM_LOST,
    SUM_RUBBED,
    SUM_STORED,
    course_of,
    highest_inside,
    sum_of,
)

# Columns of Totals.whole: five integrals of power since the start (J), the balance they make, figures of the window.
WORK_DRIVE, WORK_GRAVITY, ENERGY_STORED, ENERGY_LOST, ENERGY_RUBBED, KINETIC_START, KINETIC_MAX, RESIDUAL = range(8)
ACCELERATION_SQUARE, ACCELERATION_MAX, TORQUE_MAX, ERROR_MAX = range(8, 12)
OPENED, SPEED_MIN, SPEED_MAX, WHOLE = range(12, 16)  # s, when the window began; rad/s, of a free crank
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


HIGHEST_BIN = PARTS + 1  # in Totals.bins: the highest that was entered
#: Rows of Totals.spent: of each part of the step, how it compares with others in time, a histogram.Ramp, and for how
#: long a film pulls (s).
LASTING, BEGUN, ENDED, DENSITY, PULLED, SPENT = range(6)


class Totals(NamedTuple):
    """Sums and maxima of one integration."""

    whole: np.ndarray  # (WHOLE,) of the mechanism
    joint: np.ndarray  # (contacts, JOINT)
    histogram: np.ndarray  # (contacts, BINS, 2) s, at a force within each bin; s/N, by how much more in each one above
    dry: np.ndarray  # the same of the dry share of the force, above zero; (0, BINS, 2) where no joint has a film
    step_values: np.ndarray  # (contacts, COURSES, PARTS + 1) see histogram, at even places of the step
    bins: np.ndarray  # (contacts, HIGHEST_BIN + 1) int64, those of the force between the parts of the step
    spent: np.ndarray  # (contacts, SPENT, PARTS) what each part adds to the histogram
    length: np.ndarray  # (1,) its length
    between: np.ndarray  # (2 coordinates + 1, MOMENTS) the state within the step, where there is wear
    workspace: np.ndarray  # for the wear of a step, see joint.wear.step
    wear: np.ndarray  # (2 contacts bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (contacts, ACCOUNT) see joint.wear.contract
    friction: np.ndarray  # (friction loads,) J, taken by each in the window


OF_STEPS = "whole", "joint", "bins", "spent"  # of its fields: what every step changes


class Accumulators(NamedTuple):
    """What a step is judged by and entered in, see `event.Work`, Totals and Turns."""

    y: tuple
    mode: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple
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
    """Enter a step that is accepted; `time` is its place in the state.

    Maxima are those at the ends of the step.  Where a larger one may lie between, NEEDS_PEAK_SEARCH of its `step` is
    set, and what is to be searched for keeps its HIGHEST; of all else that becomes NO_PEAK.
    """
    step, counted = accumulators.step, accumulators.stepper[STEPPER_IN_WINDOW] != 0.0
    step[NEEDS_PEAK_SEARCH] = 0.0
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
            step[sum_of(j, HIGHEST_FORCE)] = step[sum_of(j, HIGHEST_DEPTH)] = step[sum_of(j, HIGHEST_LOAD)] = NO_PEAK
            if counted:
                raise_to(accumulators.joint, (j, DEPTH_MAX), accumulators.o[column_of(j, DEPTH), END])
    enter_motion(accumulators, counted)


@inlined
def raise_to(maxima, place, value):
    """Raise a maximum to a value."""
    maxima[place] = max(maxima[place], value)


@inlined
def seek_above(step, place, some, least):
    """Request a search between the stages for the maximum at `place`, if `some`, where it exceeds `least`."""
    if some and step[place] > least:
        step[NEEDS_PEAK_SEARCH] = 1.0
    else:
        step[place] = NO_PEAK


@inlined
def enter_powers(accumulators, counted):
    """Integrate powers and squares by the weights of the method, whose order it has."""
    whole, joint, step, h = accumulators.whole, accumulators.joint, accumulators.step, accumulators.step[LENGTH]
    whole[WORK_DRIVE] += h * step[SUM_DRIVE]
    whole[WORK_GRAVITY] += h * step[SUM_GRAVITY]
    if counted:
        whole[ACCELERATION_SQUARE] += h * step[SUM_ACCELERATION]
    for j in range(accumulators.mode.size):
        if acts(accumulators.mode[j]):
            whole[ENERGY_STORED] += h * step[sum_of(j, SUM_STORED)]
            whole[ENERGY_LOST] += h * step[sum_of(j, SUM_LOST)]
            whole[ENERGY_RUBBED] += h * step[sum_of(j, SUM_RUBBED)]
            if counted:
                joint[j, FORCE_SQUARE] += h * step[sum_of(j, SUM_FORCE_SQUARE)]
                joint[j, FORCE_TIME] += h * step[sum_of(j, SUM_FORCE)]
                # the shear of a film is in its tangential force
                if accumulators.rubs[j] != 0 and accumulators.film[j, 1] == math.inf:
                    joint[j, FRICTION_ENERGY] += h * step[sum_of(j, SUM_RUBBED)]
    kinetic = accumulators.o[KINETIC, END]
    gain = kinetic - whole[KINETIC_START] + whole[ENERGY_STORED] + whole[ENERGY_LOST] + whole[ENERGY_RUBBED]
    imbalance = abs(whole[WORK_DRIVE] + whole[WORK_GRAVITY] - gain)
    raise_to(whole, RESIDUAL, imbalance if imbalance <= math.inf else math.inf)  # a maximum passes over nan
    raise_to(whole, KINETIC_MAX, kinetic)


@inlined
def enter_contact(accumulators, j, counted, duration):
    """Enter the largest force and depth of contact `j`, which acts, and its force's course."""
    o, joint, step = accumulators.o, accumulators.joint, accumulators.step
    force, depth, load = column_of(j, NORMAL), column_of(j, DEPTH), column_of(j, LOAD)
    seek_above(step, sum_of(j, HIGHEST_FORCE), True, 0.9 * min(joint[j, PEAK], accumulators.since[j]))
    best = max(o[force, START], o[force, END])
    raise_to(joint, (j, PEAK), best)
    accumulators.highest[j] = best
    # of the eccentricity where there is a film, as its least distance from the bearing is wanted, too
    margin = 0.02 * accumulators.clearance[j] if accumulators.film[j, 1] < math.inf else 0.0
    seek_above(step, sum_of(j, HIGHEST_DEPTH), counted, 0.98 * joint[j, DEPTH_MAX] - margin)
    step[sum_of(j, HIGHEST_LOAD)] = NO_PEAK
    if not counted:
        return
    raise_to(joint, (j, FORCE_MAX), best)
    raise_to(joint, (j, DEPTH_MAX), max(o[depth, START], o[depth, END]))
    enter_course(accumulators, j, duration)
    if accumulators.rubs[j] != 0:
        for row in NODES:
            put_load(o, row, j)
        step[sum_of(j, HIGHEST_LOAD)] = highest_inside(o, load, 1.0)
        seek_above(step, sum_of(j, HIGHEST_LOAD), True, 0.96 * joint[j, LOAD_MAX])
        raise_to(joint, (j, LOAD_MAX), max(o[load, START], o[load, END]))


@inlined
def enter_course(accumulators, j, duration):
    """Divide the step's time among bins by the course of contact `j`'s force: all parts of the step at once."""
    step, contacts, spent, bins = accumulators.step, accumulators.mode.size, accumulators.spent, accumulators.bins
    force, kappa, film = course_of(contacts, j), course_of(contacts, -1), accumulators.film[j, 1] < math.inf
    for i in abreast(PARTS):
        spent[j, LASTING, i] = max(step[kappa + i], 0.0) + max(step[kappa + i + 1], 0.0)
    share = duration / total_of(spent[j, LASTING])
    for i in abreast(PARTS):
        begin, end = step[force + i], step[force + i + 1]
        lasting = spent[j, LASTING, i] * share
        pulls = film and begin * end < 0.0  # for a part of the time; that of a contact merely close to 0 is its own
        pushing = lasting * where(pulls, max(begin, end) / where(pulls, abs(end - begin), 1.0), 1.0)
        begin, end = max(begin, 0.0), max(end, 0.0)
        here, there = force_bin(begin), force_bin(end)
        part = ramp_of((begin, end), (here, there), pushing)
        bins[j, i], bins[j, i + 1] = here, there
        spent[j, BEGUN, i], spent[j, ENDED, i], spent[j, DENSITY, i] = part
        spent[j, PULLED, i] = lasting - pushing
    highest = bins[j, HIGHEST_BIN]
    for i in range(PARTS + 1):
        highest = max(highest, bins[j, i])
    bins[j, HIGHEST_BIN] = highest


@inlined
def enter_motion(accumulators, counted):
    """Enter the largest slider acceleration, torque and slider error."""
    o, whole, step = accumulators.o, accumulators.whole, accumulators.step
    best, sign = max(abs(o[ERROR, START]), abs(o[ERROR, END])), math.copysign(1.0, o[ERROR, END])
    rise, fall = sign * o[ERROR_RATE, START], sign * o[ERROR_RATE, END]
    highest = best + 0.25 * step[LENGTH] * o[KAPPA, START] * min(rise, -fall)  # a parabola's rise above the higher end
    step[HIGHEST_ERROR] = highest if rise > 0.0 and fall < 0.0 else NO_PEAK
    for column, place, within in (
        (ACCELERATION, ACCELERATION_MAX, HIGHEST_ACCELERATION),
        (TORQUE, TORQUE_MAX, HIGHEST_TORQUE),
    ):
        seek_above(step, within, counted, 0.98 * whole[place])
        if counted:
            raise_to(whole, place, max(abs(o[column, START]), abs(o[column, END])))
    seek_above(step, HIGHEST_ERROR, counted, whole[ERROR_MAX])
    if counted:
        raise_to(whole, ERROR_MAX, best)
