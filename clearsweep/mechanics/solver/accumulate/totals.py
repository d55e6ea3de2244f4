"""What is summed, counted and maximised along the motion; all of it from the steps themselves, none from samples.

What every step adds is entered for one case or for several side by side: sums, and maxima as seen at its ends.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import none_of, where
from ...compiled.dual import as_type_of
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
from ..run_control import WINDOWED
from .step_sums import (
    ACCEPTED,
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
BELOW = 2 * (PARTS + 1)  # in Totals.spent: s, for how long a film pulls


class Totals(NamedTuple):
    """Sums and maxima of one integration."""

    whole: np.ndarray  # (WHOLE,) of the mechanism
    joint: np.ndarray  # (contacts, JOINT)
    histogram: np.ndarray  # (contacts, BINS, 2) s, at a force within each bin; s/N, by how much more in each one above
    dry: np.ndarray  # the same of the dry share of the force, above zero; (0, BINS, 2) where no joint has a film
    step_values: np.ndarray  # (contacts, COURSES, PARTS + 1) see histogram, at even places of the step
    bins: np.ndarray  # (contacts, HIGHEST_BIN + 1) int64, those of the force between the parts of the step
    spent: np.ndarray  # (contacts, BELOW + 1) what each adds to the two columns of the histogram
    length: np.ndarray  # (1,) its length
    between: np.ndarray  # (2 coordinates + 1, MOMENTS) the state within the step, where there is wear
    workspace: np.ndarray  # for the wear of a step, see joint.wear.step
    wear: np.ndarray  # (2 contacts bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (contacts, ACCOUNT) see joint.wear.contract
    friction: np.ndarray  # (friction loads,) J, taken by each in the window


IN_LANES = "whole", "joint", "bins", "spent"  # of its fields


class Accumulators(NamedTuple):
    """What a step is judged by and entered in, see `event.Work`, Totals and Turns: arrays, or rows of cases."""

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
    """Enter the steps that are accepted, see `acceptance.assess_step`; `time` is its place in the state.

    Maxima are those at the ends of the step.  Where a larger one may lie between, SEEKS of its `step` is set, and what
    is to be searched for keeps its HIGHEST; of all else that becomes NO_PEAK.
    """
    step, stepper = accumulators.step, accumulators.stepper
    accepted = step[ACCEPTED] != 0.0
    counted = accepted & (stepper[WINDOWED] != 0.0)
    step[NEEDS_PEAK_SEARCH] = as_type_of(0.0, step[LENGTH])
    enter_powers(accumulators, accepted, counted)
    for j in range(accumulators.mode.size):
        enter_contact(accumulators, j, accepted, counted, accumulators.end[time] - accumulators.y[time])
    enter_motion(accumulators, counted)


@inlined
def add(sums, place, some, amount):
    """Add an amount to a sum where `some` is true."""
    sums[place] = where(some, sums[place] + amount, sums[place])


@inlined
def raise_to(maxima, place, some, value):
    """Raise a maximum to a value where `some` is true."""
    maxima[place] = where(some, max(maxima[place], value), maxima[place])


@inlined
def seek_above(step, place, some, least):
    """Request a search between the stages for the maximum at `place`, where it exceeds the `least` relevant value."""
    peak_possible = some & (step[place] > least)
    step[place] = where(step[ACCEPTED] != 0.0, where(peak_possible, step[place], NO_PEAK), step[place])
    step[NEEDS_PEAK_SEARCH] = where(peak_possible, 1.0, step[NEEDS_PEAK_SEARCH])


@inlined
def enter_powers(accumulators, accepted, counted):
    """Integrate powers and squares by the weights of the method, whose order it has."""
    o, whole, joint, step, h = (
        accumulators.o,
        accumulators.whole,
        accumulators.joint,
        accumulators.step,
        accumulators.step[LENGTH],
    )
    add(whole, WORK_DRIVE, accepted, h * step[SUM_DRIVE])
    add(whole, WORK_GRAVITY, accepted, h * step[SUM_GRAVITY])
    add(whole, ACCELERATION_SQUARE, counted, h * step[SUM_ACCELERATION])
    for j in range(accumulators.mode.size):
        acting = acts(accumulators.mode[j])
        add(whole, ENERGY_STORED, accepted & acting, h * step[sum_of(j, SUM_STORED)])
        add(whole, ENERGY_LOST, accepted & acting, h * step[sum_of(j, SUM_LOST)])
        add(whole, ENERGY_RUBBED, accepted & acting, h * step[sum_of(j, SUM_RUBBED)])
        add(joint, (j, FORCE_SQUARE), counted & acting, h * step[sum_of(j, SUM_FORCE_SQUARE)])
        add(joint, (j, FORCE_TIME), counted & acting, h * step[sum_of(j, SUM_FORCE)])
        dry = (accumulators.rubs[j] != 0) & (
            accumulators.film[j, 1] == math.inf
        )  # the shear of a film is in its tangential force
        add(joint, (j, FRICTION_ENERGY), counted & acting & dry, h * step[sum_of(j, SUM_RUBBED)])
    kinetic = o[KINETIC, END]
    gain = kinetic - whole[KINETIC_START] + whole[ENERGY_STORED] + whole[ENERGY_LOST] + whole[ENERGY_RUBBED]
    imbalance = abs(whole[WORK_DRIVE] + whole[WORK_GRAVITY] - gain)
    raise_to(whole, RESIDUAL, accepted, where(imbalance <= math.inf, imbalance, math.inf))  # a maximum passes over nan
    raise_to(whole, KINETIC_MAX, accepted, kinetic)


@inlined
def enter_contact(accumulators, j, accepted, counted, duration):
    """Enter the largest force and depth of contact `j`, and how long it lasts."""
    o, joint, step, rubs = accumulators.o, accumulators.joint, accumulators.step, accumulators.rubs[j] != 0
    acting = acts(accumulators.mode[j])
    force, depth, load = column_of(j, NORMAL), column_of(j, DEPTH), column_of(j, LOAD)
    accumulators.since[j] = max(accumulators.since[j], accumulators.highest[j])  # of the step before
    seek_above(step, sum_of(j, HIGHEST_FORCE), accepted & acting, 0.9 * min(joint[j, PEAK], accumulators.since[j]))
    best = max(o[force, START], o[force, END])
    raise_to(joint, (j, PEAK), accepted & acting, best)
    raise_to(joint, (j, FORCE_MAX), counted & acting, best)
    accumulators.highest[j] = where(accepted, where(acting, best, 0.0), accumulators.highest[j])
    add(joint, (j, CONTACT_TIME), counted & touches(accumulators.mode[j]), duration)
    # of the eccentricity where there is a film, as its least distance from the bearing is wanted, too
    least = 0.98 * joint[j, DEPTH_MAX] - where(
        accumulators.film[j, 1] < math.inf, 0.02 * accumulators.clearance[j], 0.0
    )
    seek_above(step, sum_of(j, HIGHEST_DEPTH), counted & acting, least)
    raise_to(joint, (j, DEPTH_MAX), counted, max(where(acting, o[depth, START], o[depth, END]), o[depth, END]))
    step[sum_of(j, HIGHEST_LOAD)] = as_type_of(NO_PEAK, duration)
    if none_of(counted & acting):
        return
    enter_course(accumulators, j, duration)
    if none_of(rubs):
        return
    for row in NODES:
        put_load(o, row, j)
    step[sum_of(j, HIGHEST_LOAD)] = highest_inside(o, load, as_type_of(1.0, duration))
    seek_above(step, sum_of(j, HIGHEST_LOAD), counted & acting & rubs, 0.96 * joint[j, LOAD_MAX])
    raise_to(joint, (j, LOAD_MAX), counted & acting & rubs, max(o[load, START], o[load, END]))


@inlined
def enter_course(accumulators, j, duration):
    """Divide the step's time among bins by the course of contact `j`'s force."""
    step, contacts, spent = accumulators.step, accumulators.mode.size, accumulators.spent
    force, kappa, film = course_of(contacts, j), course_of(contacts, -1), accumulators.film[j, 1] < math.inf
    total = below = as_type_of(0.0, duration)
    for i in range(PARTS):
        total = total + (max(step[kappa + i], 0.0) + max(step[kappa + i + 1], 0.0))
    ended = density = total * 0.0
    here = force_bin(max(step[force], 0.0))
    highest = max(accumulators.bins[j, HIGHEST_BIN], here)
    for i in range(PARTS):
        begin, end = step[force + i], step[force + i + 1]
        lasting = (max(step[kappa + i], 0.0) + max(step[kappa + i + 1], 0.0)) * (duration / total)
        pushing = lasting
        if not none_of(film):  # whose force is negative for a part of the time; that of a contact merely close to 0
            pulls = film & (begin * end < 0.0)
            pushing = lasting * where(pulls, max(begin, end) / where(pulls, abs(end - begin), 1.0), 1.0)
            below = below + (lasting - pushing)
        there = force_bin(max(end, 0.0))
        part = ramp_of((max(begin, 0.0), max(end, 0.0)), (here, there), pushing)
        accumulators.bins[j, i] = here
        spent[j, 2 * i], spent[j, 2 * i + 1] = ended + part.begun, part.density - density
        ended, density, here, highest = part.ended, part.density, there, max(highest, there)
    accumulators.bins[j, PARTS], accumulators.bins[j, HIGHEST_BIN] = here, highest
    spent[j, 2 * PARTS], spent[j, 2 * PARTS + 1], spent[j, BELOW] = ended, -density, below


@inlined
def enter_motion(accumulators, counted):
    """Enter the largest slider acceleration, torque and slider error."""
    o, whole, step = accumulators.o, accumulators.whole, accumulators.step
    for column, place, within in (
        (ACCELERATION, ACCELERATION_MAX, HIGHEST_ACCELERATION),
        (TORQUE, TORQUE_MAX, HIGHEST_TORQUE),
    ):
        seek_above(step, within, counted, 0.98 * whole[place])
        raise_to(whole, place, counted, max(abs(o[column, START]), abs(o[column, END])))
    best, sign = max(abs(o[ERROR, START]), abs(o[ERROR, END])), math.copysign(1.0, o[ERROR, END])
    rise, fall = sign * o[ERROR_RATE, START], sign * o[ERROR_RATE, END]
    highest = best + 0.25 * step[LENGTH] * o[KAPPA, START] * min(rise, -fall)  # a parabola's rise above the higher end
    step[HIGHEST_ERROR] = where((rise > 0.0) & (fall < 0.0), highest, NO_PEAK)
    seek_above(step, HIGHEST_ERROR, counted, whole[ERROR_MAX])
    raise_to(whole, ERROR_MAX, counted, best)
