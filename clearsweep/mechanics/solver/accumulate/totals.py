"""Sums, counts and maxima of the motion, computed from the steps, never from samples."""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.choosing import lane_range, total_of, where
from ....tracing.compiled.family import inlined
from ....tracing.fields import Fields
from ...laws.contract import acts, touches
from ...observe import (
    ACCELERATION,
    DEPTH,
    END,
    ERROR,
    ERROR_RATE,
    KAPPA,
    KINETIC,
    LOAD,
    NODES,
    NORMAL,
    PARTS,
    START,
    TO_PART_MEANS,
    TORQUE,
    column_of,
    force_bin,
    put_load,
    ramp_of,
)
from .step_sums import NO_PEAK, interior_peak


class MechanismTotals(Fields):
    """Sums and maxima of the mechanism: of power since the start, then figures of the window."""

    work_drive: float  # J
    work_gravity: float  # J, of gravity and loads
    energy_stored: float  # J, in elastic deformation
    energy_lost: float  # J, dissipated by normal forces
    energy_friction: float  # J, dissipated by friction
    kinetic_start: float  # J, kinetic energy at the start
    kinetic_max: float  # J, its largest value
    residual: float  # J, largest imbalance of these
    target_speed: float  # rad/s, of a free crank; 0: none
    target_time: float  # s, at which the crank first reaches this speed; inf: not yet
    acceleration_square: float  # integral of the square of the output's acceleration over time
    acceleration_max: float
    torque_max: float  # N m
    error_max: float  # of the output
    window_start: float  # s, start of the window
    speed_min: float  # rad/s, of a free crank
    speed_max: float
    min_speed_after_target: float  # rad/s, least speed of a free crank after it reached its target speed


class Largest(float):
    """A number of a contact; of several contacts of a joint the largest counts, instead of their sum."""


class Resultant(float):
    """A number of a contact; of several contacts of a joint that of their resultant counts, if there is one."""


class ContactTotals(Fields):
    """Figures of the window for a contact, then quantities of its present contact."""

    force_square: Resultant  # N^2 s
    contact_time: Largest  # s
    force_max: Resultant  # N
    force_max_to_target: Resultant  # N, its value when a free crank reaches its target speed
    load_max: Resultant  # N^2, square of the resultant of normal and friction force, where there is friction
    depth_max: Largest  # m
    onset_max: Largest  # m/s
    onsets: float  # number of onsets
    clips: float  # passages of guards that are counted
    restitution: float  # sum of the ratios of rebound and approach
    rebounds: float  # number of these ratios
    beyond_time: Largest  # s, beyond the limit of its elastic law
    force_time: float  # N s
    friction_energy: float  # J, of dry friction
    load_time: float  # N s, of the magnitude of the normal force, where there is a film
    dry_force_time: float  # N s, of the magnitude of its dry part
    clamped_time: float  # s, at a depth beyond the limit of the film formula
    film_energy: float  # J
    generated_energy: float  # J
    heat: float  # J
    dry_max: Largest  # N
    pressure_max: Largest  # Pa
    shear_speed_max: Largest  # m/s
    peak: Largest  # N, of the present contact
    approach: Largest  # m/s, onset rate of the present contact


FIRST_FIGURE = MechanismTotals.index_of("acceleration_square")  # what is reset where the window opens
CONTACT_FIGURES = ContactTotals.index_of("peak")  # number of fields that are reset there
#: In Totals.bins: the highest bin used; the lowest bin of the forces that are distributed by fine parts; the steps of
#: the contact so far, and their number at which this bin is computed again.
HIGHEST_BIN, FINE_BIN, BINNED_STEPS, NEXT_FINE_BIN, BIN_COLUMNS = range(PARTS + 1, PARTS + 6)
#: Rows of Totals.part_times, for each part of the step: its duration relative to other parts, a histogram.Ramp, and the
#: time (s) during which a film pulls.
RELATIVE_DURATION, FIRST_BIN_TIME, LAST_BIN_TIME, TIME_PER_FORCE, PULLING_TIME, PART_TIME_ROWS = range(6)


class Totals(NamedTuple):
    """Sums and maxima of one integration."""

    mechanism: MechanismTotals
    joint: ContactTotals  # (contacts,)
    histogram: np.ndarray  # (contacts, BINS, 2) s, at a force within each bin; s/N, increment in each bin above it
    dry: np.ndarray  # the same for the dry part of the force, above zero; (0, BINS, 2) without films
    step_values: np.ndarray  # (contacts, STEP_VALUE_ROWS, PARTS + 1) at equidistant places of the step, see histogram
    bins: np.ndarray  # (contacts, BIN_COLUMNS) int64, bins of the force between the parts of the step
    part_times: np.ndarray  # (contacts, PART_TIME_ROWS, PARTS) contribution of each part to the histogram
    length: np.ndarray  # (1,) length of the step
    dense_states: np.ndarray  # (2 coordinates + 1, STATE_POINTS) the state within the step, with wear
    workspace: np.ndarray  # for the wear of a step, see wear.step
    wear: np.ndarray  # (2 contacts bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (contacts, ACCOUNT_SIZE) see wear.contract
    friction: np.ndarray  # (friction loads,) J, work of each in the window


class Accumulators(NamedTuple):
    """Arrays of the assessment and accumulation of a step, see `integration.Work`, Totals and RevolutionMarks."""

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
    has_friction: tuple
    mechanism: tuple
    joint: tuple
    bins: tuple
    part_times: tuple
    step_peak: tuple
    peak_since_mark: tuple


@inlined
def accumulate_step(accumulators, time):
    """Add an accepted step to the totals; `time` is the index of the time in the state.

    Maxima are those at start and end of the step.  If a larger one may lie between, `step.needs_peak_search` is set and
    its highest value in the step is left for the search; those of all other quantities are set to NO_PEAK.
    """
    in_window = accumulators.stepper.in_window != 0.0
    accumulators.step.needs_peak_search = 0.0
    add_powers(accumulators, in_window)
    for j in range(accumulators.mode.size):
        duration = accumulators.end[time] - accumulators.y[time]
        accumulators.peak_since_mark[j] = max(
            accumulators.peak_since_mark[j], accumulators.step_peak[j]
        )  # of the step before
        accumulators.step_peak[j] = 0.0
        if in_window and touches(accumulators.mode[j]):
            accumulators.joint[j].contact_time += duration
        if acts(accumulators.mode[j]):
            add_contact_maxima(accumulators, j, in_window, duration)
        else:
            contact_step = accumulators.contact_steps[j]
            contact_step.highest_force = contact_step.highest_depth = contact_step.highest_load = NO_PEAK
            if in_window:
                accumulators.joint[j].depth_max = max(
                    accumulators.joint[j].depth_max, accumulators.o[column_of(j, DEPTH), END]
                )
    add_motion_maxima(accumulators, in_window)


@inlined
def request_search(step, highest, is_counted, threshold):
    """Return `highest` and request a peak search if it is counted and exceeds `threshold`; otherwise return NO_PEAK."""
    if is_counted and highest > threshold:
        step.needs_peak_search = 1.0
        return highest
    return NO_PEAK


@inlined
def add_powers(accumulators, in_window):
    """Add the integrals of powers (J) and squares over a step; update the largest energy imbalance (J)."""
    mechanism, joint, step, h = accumulators.mechanism, accumulators.joint, accumulators.step, accumulators.step.length
    mechanism.work_drive += h * step.sum_drive
    mechanism.work_gravity += h * step.sum_gravity
    if in_window:
        mechanism.acceleration_square += h * step.sum_acceleration
    for j in range(accumulators.mode.size):
        if acts(accumulators.mode[j]):
            sums, figures = accumulators.contact_steps[j], joint[j]
            mechanism.energy_stored += h * sums.sum_stored
            mechanism.energy_lost += h * sums.sum_lost
            mechanism.energy_friction += h * sums.sum_friction
            if in_window:
                figures.force_square += h * sums.sum_force_square
                figures.force_time += h * sums.sum_force
                # the tangential force includes the shear of a film
                if accumulators.has_friction[j] != 0 and accumulators.film[j, 1] == math.inf:
                    figures.friction_energy += h * sums.sum_friction
    kinetic = accumulators.o[KINETIC, END]
    energy_gain = (
        kinetic - mechanism.kinetic_start + mechanism.energy_stored + mechanism.energy_lost + mechanism.energy_friction
    )
    imbalance = abs(mechanism.work_drive + mechanism.work_gravity - energy_gain)
    mechanism.residual = max(
        mechanism.residual, imbalance if imbalance <= math.inf else math.inf
    )  # a maximum skips nan
    mechanism.kinetic_max = max(mechanism.kinetic_max, kinetic)


@inlined
def add_contact_maxima(accumulators, j, in_window, duration):
    """Add the largest force (N) and depth (m) of acting contact `j`, and the profile of its force."""
    o, step = accumulators.o, accumulators.step
    figures, contact_step = accumulators.joint[j], accumulators.contact_steps[j]
    force, depth, load = column_of(j, NORMAL), column_of(j, DEPTH), column_of(j, LOAD)
    threshold = 0.9 * min(figures.peak, accumulators.peak_since_mark[j])
    contact_step.highest_force = request_search(step, contact_step.highest_force, True, threshold)
    largest = max(o[force, START], o[force, END])
    figures.peak = max(figures.peak, largest)
    accumulators.step_peak[j] = largest
    # with a film, of the eccentricity: the least distance from the bearing is needed, too
    margin = 0.02 * accumulators.clearance[j] if accumulators.film[j, 1] < math.inf else 0.0
    threshold = 0.98 * figures.depth_max - margin
    contact_step.highest_depth = request_search(step, contact_step.highest_depth, in_window, threshold)
    contact_step.highest_load = NO_PEAK
    if not in_window:
        return
    figures.force_max = max(figures.force_max, largest)
    deepest = max(o[depth, START], o[depth, END])
    figures.depth_max = max(figures.depth_max, deepest)
    add_force_profile(accumulators, j, duration)
    if accumulators.has_friction[j] != 0:
        for row in NODES:
            put_load(o, row, j)
        contact_step.highest_load = request_search(step, interior_peak(o, load, 1.0), True, 0.96 * figures.load_max)
        largest = max(o[load, START], o[load, END])
        figures.load_max = max(figures.load_max, largest)


@inlined
def add_force_profile(accumulators, j, duration):
    """Distribute the step's time (s) over bins by the profile of contact `j`'s force, all parts of the step at once."""
    part_times, bins, film = accumulators.part_times, accumulators.bins, accumulators.film[j, 1] < math.inf
    o, force = accumulators.o, accumulators.profiles[1 + j]
    for i in lane_range(PARTS):
        mean = TO_PART_MEANS[0, i] * o[KAPPA, NODES[0]]
        for m in range(1, NODES.size):
            mean += TO_PART_MEANS[m, i] * o[KAPPA, NODES[m]]
        part_times[j, RELATIVE_DURATION, i] = max(mean, 0.0)
    scale = duration / total_of(part_times[j, RELATIVE_DURATION])
    for i in lane_range(PARTS):
        start_value, end_value = force[i], force[i + 1]
        duration_of_part = part_times[j, RELATIVE_DURATION, i] * scale
        changes_sign = (
            film and start_value * end_value < 0.0
        )  # part of the time; noise of a contact close to 0 is excluded
        pushing = duration_of_part * where(
            changes_sign, max(start_value, end_value) / where(changes_sign, abs(end_value - start_value), 1.0), 1.0
        )
        start_value, end_value = max(start_value, 0.0), max(end_value, 0.0)
        begin_bin, end_bin = force_bin(start_value), force_bin(end_value)
        ramp = ramp_of((start_value, end_value), (begin_bin, end_bin), pushing)
        bins[j, i], bins[j, i + 1] = begin_bin, end_bin
        part_times[j, FIRST_BIN_TIME, i], part_times[j, LAST_BIN_TIME, i], part_times[j, TIME_PER_FORCE, i] = ramp
        part_times[j, PULLING_TIME, i] = duration_of_part - pushing
    highest = bins[j, HIGHEST_BIN]
    for i in range(PARTS + 1):
        highest = max(highest, bins[j, i])
    bins[j, HIGHEST_BIN] = highest


@inlined
def add_motion_maxima(accumulators, in_window):
    """Add the largest slider acceleration (m/s^2), torque (N m) and slider error (m)."""
    o, mechanism, step = accumulators.o, accumulators.mechanism, accumulators.step
    largest, sign = max(abs(o[ERROR, START]), abs(o[ERROR, END])), math.copysign(1.0, o[ERROR, END])
    start_slope, end_slope = sign * o[ERROR_RATE, START], sign * o[ERROR_RATE, END]
    parabola_peak = largest + 0.25 * step.length * o[KAPPA, START] * min(
        start_slope, -end_slope
    )  # a parabola's rise above the higher end
    step.highest_error = parabola_peak if start_slope > 0.0 and end_slope < 0.0 else NO_PEAK
    threshold = 0.98 * mechanism.acceleration_max
    step.highest_acceleration = request_search(step, step.highest_acceleration, in_window, threshold)
    step.highest_torque = request_search(step, step.highest_torque, in_window, 0.98 * mechanism.torque_max)
    step.highest_error = request_search(step, step.highest_error, in_window, mechanism.error_max)
    if in_window:
        acceleration = max(abs(o[ACCELERATION, START]), abs(o[ACCELERATION, END]))
        torque = max(abs(o[TORQUE, START]), abs(o[TORQUE, END]))
        mechanism.acceleration_max = max(mechanism.acceleration_max, acceleration)
        mechanism.torque_max = max(mechanism.torque_max, torque)
        mechanism.error_max = max(mechanism.error_max, largest)
