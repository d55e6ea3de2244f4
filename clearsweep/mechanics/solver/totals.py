"""Sums, counts and maxima of the motion, computed from the steps, never from samples."""

import math
from typing import Annotated, NamedTuple

import numpy as np

from ...tracing.compiled.choosing import lane_range, total_of, where
from ...tracing.compiled.family import inlined
from ...tracing.memory import Fields
from .. import observe
from ..laws.contract import REPORTING, acts, meets, touches

# ----------------------------------------------------------------------------------------------------------------------
# Quantities of one whole step: error, sums, profiles, maxima.


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


@inlined
def sum_stages(work, weights):
    """Write the sums of powers and squares over the stages, with `weights`, for acting contacts."""
    o, step = work.o, work.step
    drive = gravity = square = 0.0
    for row in range(weights.size):
        if weights[row] != 0.0:
            weight = weights[row] * o[observe.KAPPA, row]
            drive, gravity = drive + weight * o[observe.DRIVE, row], gravity + weight * o[observe.GRAVITY, row]
            square = square + weight * (o[observe.ACCELERATION, row] * o[observe.ACCELERATION, row])
    step.sum_drive, step.sum_gravity, step.sum_acceleration = drive, gravity, square
    for c in range(work.mode.size):
        if work.mode[c] == REPORTING:
            reported = work.contact_steps[c]
            reported.sum_force = stage_integral(o, observe.column_of(c, observe.NORMAL), weights)
            reported.sum_stored = stage_integral(o, observe.column_of(c, observe.STORED), weights)
            reported.sum_lost = stage_integral(o, observe.column_of(c, observe.LOST), weights)
        if not acts(work.mode[c]):
            continue
        block, sums = observe.CONTACTS + observe.CONTACT_WIDTH * c, work.contact_steps[c]
        stored = dissipated = friction = total = square = 0.0
        for row in range(weights.size):
            if weights[row] != 0.0:
                weight, force = weights[row] * o[observe.KAPPA, row], o[block + observe.NORMAL, row]
                stored = stored + weight * o[block + observe.STORED, row]
                dissipated = dissipated + weight * o[block + observe.LOST, row]
                friction = friction - weight * (o[block + observe.TANGENTIAL, row] * o[block + observe.SLIP, row])
                total, square = total + weight * force, square + weight * (force * force)
        sums.sum_stored, sums.sum_lost, sums.sum_friction = stored, dissipated, friction
        sums.sum_force, sums.sum_force_square = total, square


@inlined
def stage_integral(o, column, weights):
    """Return the weighted sum of an observable over the stages; times the step's length it is the integral."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[observe.KAPPA, row] * o[column, row]
    return total


@inlined
def integral_of_negative_part(o, column, weights):
    """Return the `stage_integral` of the negative part of an observable, as a positive number."""
    total = 0.0
    for row in range(weights.size):
        total -= weights[row] * o[observe.KAPPA, row] * min(o[column, row], 0.0)
    return total


@inlined
def integral_of_magnitude(o, column, weights):
    """Return the `stage_integral` of the absolute value of an observable."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[observe.KAPPA, row] * abs(o[column, row])
    return total


@inlined
def write_profile(o, column, profile):
    """Write the profile of an observable to `profile` (PARTS + 1,)."""
    profile[0] = o[column, observe.START]
    for i in lane_range(observe.PARTS):
        profile[1 + i] = observe.value_at(o, column, observe.TO_PART_ENDS, i)


@inlined
def write_sums(work, weights):
    """Write the sums, profiles and maxima of a step; the rows with nonzero `weights` contain its observables."""
    sum_stages(work, weights)
    write_profile(work.o, observe.KAPPA, work.profiles[0])
    for c in range(work.mode.size):
        if acts(work.mode[c]):
            write_profile(work.o, observe.column_of(c, observe.NORMAL), work.profiles[1 + c])
    write_largest_speeds(work)
    write_peaks(work)


@inlined
def write_largest_speeds(work):
    """Write the largest speed of journals in free flight at the start and all stages but the last."""
    o = work.o
    for c in range(work.mode.size):
        if not meets(work.mode[c]):
            continue
        fastest = o[observe.column_of(c, observe.SLIP), observe.START] * o[observe.KAPPA, observe.START]
        for row in range(observe.END):
            fastest = max(fastest, o[observe.column_of(c, observe.SLIP), row] * o[observe.KAPPA, row])
        work.contact_steps[c].fastest = fastest


@inlined
def write_peaks(work):
    """Write the highest values of observables that may have a peak; of contacts, only acting ones."""
    o, step = work.o, work.step
    step.highest_acceleration = interior_peak(
        o, observe.ACCELERATION, math.copysign(1.0, o[observe.ACCELERATION, observe.END])
    )
    step.highest_torque = interior_peak(o, observe.TORQUE, math.copysign(1.0, o[observe.TORQUE, observe.END]))
    for c in range(work.mode.size):
        if not acts(work.mode[c]):
            continue
        work.contact_steps[c].highest_force = interior_peak(o, observe.column_of(c, observe.NORMAL), 1.0)
        work.contact_steps[c].highest_depth = interior_peak(o, observe.column_of(c, observe.DEPTH), 1.0)


@inlined
def interior_peak(o, column, sign):
    """Return the largest value of an observable times `sign` at the nodes, or NO_PEAK if it has no peak in the step.

    There is a peak if a stage is higher than both ends, or if the observable rises at the start of the step and falls
    at its end.  The slopes are those of parabolas through three nodes, a tenth of the step outside its start and end.
    So a peak near the end of a step counts in both steps.
    """
    start_slope = end_slope = 0.0
    for m in range(3):
        start_slope += START_SLOPE[m] * o[column, observe.NODES[START_NODES[m]]]
        end_slope += END_SLOPE[m] * o[column, observe.NODES[END_NODES[m]]]
    highest_end = max(sign * o[column, observe.START], sign * o[column, observe.END])
    highest = highest_end
    for m in range(observe.STAGES - 1):
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
START_SLOPE = _slope_weights(observe.NODE_FRACTIONS[START_NODES], -0.1)
END_SLOPE = _slope_weights(observe.NODE_FRACTIONS[END_NODES], 1.1)


# ----------------------------------------------------------------------------------------------------------------------
# Sums, counts and maxima of the motion, computed from the steps, never from samples.


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


class ContactTotals(Fields):
    """Figures of the window for a contact, then quantities of its present contact."""

    force_square: observe.Resultant  # N^2 s
    contact_time: observe.Resultant  # s; of a resultant, in which any of its contacts touches
    binned_time: float  # s, in the histogram
    force_max: observe.Resultant  # N
    force_max_to_target: observe.Resultant  # N, its value when a free crank reaches its target speed
    load_max: observe.Resultant  # N^2, square of the resultant of normal and friction force, where there is friction
    depth_max: observe.Largest  # m
    onset_max: observe.Largest  # m/s
    onsets: float  # number of onsets
    clips: float  # passages of guards that are counted
    restitution: float  # sum of the ratios of rebound and approach
    rebounds: float  # number of these ratios
    beyond_time: observe.Largest  # s, beyond the limit of its elastic law
    force_time: float  # N s
    friction_energy: float  # J, of dry friction
    load_time: float  # N s, of the magnitude of the normal force, where there is a film
    dry_force_time: float  # N s, of the magnitude of its dry part
    clamped_time: float  # s, at a depth beyond the limit of the film formula
    film_energy: float  # J
    generated_energy: float  # J
    heat: float  # J
    inner_fatigue: float  # rad, relative turns of rings, weighted by loads, see `joints.rolling.fatigue_loads`
    outer_fatigue: float  # rad
    dry_max: observe.Largest  # N
    pressure_max: observe.Largest  # Pa
    shear_speed_max: observe.Largest  # m/s
    peak: observe.Largest  # N, of the present contact
    approach: observe.Largest  # m/s, onset rate of the present contact


FIRST_FIGURE = MechanismTotals.index_of("acceleration_square")  # what is reset where the window opens
CONTACT_FIGURES = ContactTotals.index_of("peak")  # number of fields that are reset there
#: In Totals.bins: the highest bin used; the lowest and highest bin of the forces that are distributed by fine parts;
#: the steps of the contact so far, and their number at which these bins are computed again.
HIGHEST_BIN, FINE_BIN, LAST_FINE_BIN, BINNED_STEPS, NEXT_FINE_BIN, BIN_COLUMNS = range(
    observe.PARTS + 1, observe.PARTS + 7
)
#: Rows of Totals.part_times, for each part of the step: its duration relative to other parts, a histogram.Ramp, and the
#: time (s) during which a film pulls.
RELATIVE_DURATION, FIRST_BIN_TIME, LAST_BIN_TIME, TIME_PER_FORCE, PULLING_TIME, PART_TIME_ROWS = range(6)


class Totals(NamedTuple):
    """Sums and maxima of one integration; lengths as in `integration.Work`."""

    mechanism: MechanismTotals
    joint: ContactTotals  # (contacts,)
    histogram: Annotated[np.ndarray, observe.BINS, 2]  # (contacts,) s, in each bin; s/N, increment in those above
    dry: Annotated[
        np.ndarray, observe.BINS, 2
    ]  # the same for the dry part of the force, above zero; (0,) without films
    step_values: Annotated[np.ndarray, observe.STEP_VALUE_ROWS, observe.PARTS + 1]  # (contacts,) at equidistant places
    bins: Annotated[np.ndarray, BIN_COLUMNS]  # (contacts,) int64, bins of the force between the parts of the step
    part_times: Annotated[np.ndarray, PART_TIME_ROWS, observe.PARTS]  # (contacts,) contribution of each part
    fine_sums: Annotated[
        np.ndarray, observe.FINE_ROWS + 2, 2, observe.PARTS
    ]  # of fine parts, see `observe.add_fine_part`
    fine_bins: Annotated[np.ndarray, observe.FINE_ROWS + 1, observe.PARTS]  # int64, their bins
    length: np.ndarray  # (1,) length of the step
    dense_states: Annotated[
        np.ndarray, observe.STATE_POINTS
    ]  # (2 coordinates + 1,) the state within the step, with wear
    workspace: np.ndarray  # for the wear of a step, see wear.bins
    wear: np.ndarray  # (2 contacts bins,) m, wear depth of bearing and journal of every joint
    account: np.ndarray  # (contacts, ACCOUNT_SIZE) see wear.Account
    friction: np.ndarray  # (friction loads,) J, work of each in the window


@inlined
def accumulate_step(work):
    """Add an accepted step to the totals.

    Maxima are those at start and end of the step.  If a larger one may lie between, `step.needs_peak_search` is set and
    its highest value in the step is left for the search; those of all other quantities are set to NO_PEAK.
    """
    in_window, peaks = work.stepper.in_window != 0.0, work.revolutions
    work.step.needs_peak_search = 0.0
    add_powers(work, in_window)
    latest_resultant = -1  # whose time in contact has this step
    for j in range(work.mode.size):
        duration = work.end[work.time] - work.y[work.time]
        peaks.peak_since_mark[j] = max(peaks.peak_since_mark[j], peaks.step_peak[j])  # of the step before
        peaks.step_peak[j] = 0.0
        if in_window and touches(work.mode[j]):
            work.totals.joint[j].contact_time += duration
            resultant = work.resultant[j]
            if resultant > latest_resultant:
                work.totals.joint[resultant].contact_time += duration
                latest_resultant = resultant
        if acts(work.mode[j]):
            add_contact_maxima(work, j, in_window, duration)
        else:
            contact_step = work.contact_steps[j]
            contact_step.highest_force = contact_step.highest_depth = contact_step.highest_load = NO_PEAK
            if in_window:
                work.totals.joint[j].depth_max = max(
                    work.totals.joint[j].depth_max, work.o[observe.column_of(j, observe.DEPTH), observe.END]
                )
    add_motion_maxima(work, in_window)


@inlined
def request_search(step, highest, is_counted, threshold):
    """Return `highest` and request a peak search if it is counted and exceeds `threshold`; otherwise return NO_PEAK."""
    if is_counted and highest > threshold:
        step.needs_peak_search = 1.0
        return highest
    return NO_PEAK


@inlined
def add_powers(work, in_window):
    """Add the integrals of powers (J) and squares over a step; update the largest energy imbalance (J)."""
    mechanism, joint, step, h = work.totals.mechanism, work.totals.joint, work.step, work.step.length
    mechanism.work_drive += h * step.sum_drive
    mechanism.work_gravity += h * step.sum_gravity
    if in_window:
        mechanism.acceleration_square += h * step.sum_acceleration
    for j in range(work.mode.size):
        if acts(work.mode[j]):
            sums, figures = work.contact_steps[j], joint[j]
            mechanism.energy_stored += h * sums.sum_stored
            mechanism.energy_lost += h * sums.sum_lost
            mechanism.energy_friction += h * sums.sum_friction
            if in_window:
                figures.force_square += h * sums.sum_force_square
                figures.force_time += h * sums.sum_force
                # the tangential force includes the shear of a film
                if work.has_friction[j] != 0 and work.film[j, 1] == math.inf:
                    figures.friction_energy += h * sums.sum_friction
        elif in_window and work.mode[j] == REPORTING:
            reported, figures = work.contact_steps[j], joint[j]
            figures.force_time += h * reported.sum_force
            figures.inner_fatigue += h * reported.sum_stored
            figures.outer_fatigue += h * reported.sum_lost
    kinetic = work.o[observe.KINETIC, observe.END]
    energy_gain = (
        kinetic - mechanism.kinetic_start + mechanism.energy_stored + mechanism.energy_lost + mechanism.energy_friction
    )
    imbalance = abs(mechanism.work_drive + mechanism.work_gravity - energy_gain)
    mechanism.residual = max(
        mechanism.residual, imbalance if imbalance <= math.inf else math.inf
    )  # a maximum skips nan
    mechanism.kinetic_max = max(mechanism.kinetic_max, kinetic)


@inlined
def add_contact_maxima(work, j, in_window, duration):
    """Add the largest force (N) and depth (m) of acting contact `j`, and the profile of its force."""
    o, step = work.o, work.step
    figures, contact_step = work.totals.joint[j], work.contact_steps[j]
    force, depth, load = (
        observe.column_of(j, observe.NORMAL),
        observe.column_of(j, observe.DEPTH),
        observe.column_of(j, observe.LOAD),
    )
    threshold = 0.9 * min(figures.peak, work.revolutions.peak_since_mark[j])
    contact_step.highest_force = request_search(step, contact_step.highest_force, True, threshold)
    largest = max(o[force, observe.START], o[force, observe.END])
    figures.peak = max(figures.peak, largest)
    work.revolutions.step_peak[j] = largest
    # with a film, of the eccentricity: the least distance from the bearing is needed, too
    margin = 0.02 * work.clearance[j] if work.film[j, 1] < math.inf else 0.0
    threshold = min(0.98 * figures.depth_max, where(margin > 0.0, 0.98, 1.02) * figures.depth_max) - margin
    contact_step.highest_depth = request_search(step, contact_step.highest_depth, in_window, threshold)
    contact_step.highest_load = NO_PEAK
    if not in_window:
        return
    figures.force_max = max(figures.force_max, largest)
    deepest = max(o[depth, observe.START], o[depth, observe.END])
    figures.depth_max = max(figures.depth_max, deepest)
    if work.has_histogram[j] != 0:
        add_force_profile(work, j, duration)
    if work.has_friction[j] != 0:
        for row in observe.NODES:
            observe.put_load(o, row, j)
        contact_step.highest_load = request_search(step, interior_peak(o, load, 1.0), True, 0.96 * figures.load_max)
        largest = max(o[load, observe.START], o[load, observe.END])
        figures.load_max = max(figures.load_max, largest)


@inlined
def add_force_profile(work, j, duration):
    """Distribute the step's time (s) over bins by the profile of contact `j`'s force, all parts of the step at once."""
    part_times, bins, film = work.totals.part_times, work.totals.bins, work.film[j, 1] < math.inf
    o, force = work.o, work.profiles[1 + j]
    for i in lane_range(observe.PARTS):
        part_times[j, RELATIVE_DURATION, i] = max(observe.value_at(o, observe.KAPPA, observe.TO_PART_MEANS, i), 0.0)
    scale = duration / total_of(part_times[j, RELATIVE_DURATION])
    for i in lane_range(observe.PARTS):
        start_value, end_value = force[i], force[i + 1]
        duration_of_part = part_times[j, RELATIVE_DURATION, i] * scale
        changes_sign = (
            film and start_value * end_value < 0.0
        )  # part of the time; noise of a contact close to 0 is excluded
        pushing = duration_of_part * where(
            changes_sign, max(start_value, end_value) / where(changes_sign, abs(end_value - start_value), 1.0), 1.0
        )
        forces = max(start_value, 0.0), max(end_value, 0.0)
        observe.put_ramp(part_times[j, FIRST_BIN_TIME:], bins[j], i, forces, pushing)
        part_times[j, PULLING_TIME, i] = duration_of_part - pushing


@inlined
def add_motion_maxima(work, in_window):
    """Add the largest slider acceleration (m/s^2), torque (N m) and slider error (m)."""
    o, mechanism, step = work.o, work.totals.mechanism, work.step
    largest, sign = (
        max(abs(o[observe.ERROR, observe.START]), abs(o[observe.ERROR, observe.END])),
        math.copysign(1.0, o[observe.ERROR, observe.END]),
    )
    start_slope, end_slope = sign * o[observe.ERROR_RATE, observe.START], sign * o[observe.ERROR_RATE, observe.END]
    parabola_peak = largest + 0.25 * step.length * o[observe.KAPPA, observe.START] * min(
        start_slope, -end_slope
    )  # a parabola's rise above the higher end
    step.highest_error = parabola_peak if start_slope > 0.0 and end_slope < 0.0 else NO_PEAK
    threshold = 0.98 * mechanism.acceleration_max
    step.highest_acceleration = request_search(step, step.highest_acceleration, in_window, threshold)
    step.highest_torque = request_search(step, step.highest_torque, in_window, 0.98 * mechanism.torque_max)
    step.highest_error = request_search(step, step.highest_error, in_window, mechanism.error_max)
    if in_window:
        acceleration = max(abs(o[observe.ACCELERATION, observe.START]), abs(o[observe.ACCELERATION, observe.END]))
        torque = max(abs(o[observe.TORQUE, observe.START]), abs(o[observe.TORQUE, observe.END]))
        mechanism.acceleration_max = max(mechanism.acceleration_max, acceleration)
        mechanism.torque_max = max(mechanism.torque_max, torque)
        mechanism.error_max = max(mechanism.error_max, largest)
