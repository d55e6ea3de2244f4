"""Values between the stages of a step, and the sums that need them or apply to some cases only."""

import math
from typing import NamedTuple

import numpy as np

from ...tracing.compiled.choosing import lane_range, rolled_range, total_of
from ...tracing.compiled.family import inlined, invoke, invoke_each, kernel
from .. import observe
from ..laws.contract import REPORTING, acts, touches
from .collocation import WEIGHTS, dense_component, dense_state
from .integration import IMPLICIT, evaluate_dense
from .radau import STAGE_WEIGHTS
from .totals import (
    BINNED_STEPS,
    CONTACT_FIGURES,
    FINE_BIN,
    FIRST_BIN_TIME,
    FIRST_FIGURE,
    HIGHEST_BIN,
    LAST_FINE_BIN,
    NEXT_FINE_BIN,
    NO_PEAK,
    PULLING_TIME,
    RELATIVE_DURATION,
    MechanismTotals,
    integral_of_magnitude,
    integral_of_negative_part,
    interior_peak,
    stage_integral,
)

# ----------------------------------------------------------------------------------------------------------------------
# Values between the stages of a step, from its dense output: positions, maxima, time histories, states at marks.


POINT_FRACTIONS = np.minimum(np.arange(observe.STATE_POINTS) / (observe.QUARTER_POINTS + 1), 1.0)


@kernel
def evaluate_dense_states(pointer, dense_states):
    """Write coordinates, their rates and the time at points within the step to `dense_states`.

    dense_states : (2 coordinates + 1, STATE_POINTS), at every quarter of the step, then its end again.
    """
    y, end_value, f = pointer[0].y, pointer[0].end, pointer[0].f
    for i in range(dense_states.shape[0]):
        for index in lane_range(observe.STATE_POINTS):
            x = POINT_FRACTIONS[index]
            u = 2.0 * x - 1.0
            total = f[i, observe.STAGES - 1]
            for m in range(observe.STAGES - 2, -1, -1):
                total = total * u + f[i, m]
            dense_states[i, index] = y[i] + x * total
        for index in range(observe.QUARTER_POINTS + 1, observe.STATE_POINTS):
            dense_states[i, index] = end_value[i]


@kernel
def node_of_maximum(o, column, sign):
    """Return the node of the stage with the largest value of an observable times `sign`."""
    highest_node = 0
    for m in range(1, observe.NODES.size):
        if sign * o[column, observe.NODES[m]] > sign * o[column, observe.NODES[highest_node]]:
            highest_node = m
    return highest_node


@kernel
def observable_at(pointer, x, column):
    """Return the observable at the fraction `x` (0 to 1) of the step, from the dense output in `work.f`."""
    work = pointer[0]
    evaluate_dense(pointer, x)
    for j in range(work.mode.size):
        if work.has_friction[j]:
            observe.put_load(work.o, observe.SCRATCH, j)
    return work.o[column, observe.SCRATCH]


@kernel
def refine_peak(pointer, column, sign, node):
    """Return the largest value of the observable times `sign` near the stage `node`, by successive parabolas."""
    m = min(max(node, 1), observe.NODES.size - 2)
    a, b, c = observe.NODE_FRACTIONS[m - 1], observe.NODE_FRACTIONS[m], observe.NODE_FRACTIONS[m + 1]
    fa = sign * observable_at(pointer, a, column)
    fb = sign * observable_at(pointer, b, column)
    fc = sign * observable_at(pointer, c, column)
    largest = max(fa, fb, fc)
    for _ in range(3):
        curvature = (fa - fb) / (a - b) - (fb - fc) / (b - c)
        if curvature * (a - c) >= 0.0:  # not concave: the maximum is at an end
            break
        x = 0.5 * (a + b) - 0.5 * (a - c) * (fa - fb) / ((a - b) * curvature)
        x = min(max(x, 0.0), 1.0)
        if x in (a, b, c):
            break
        fx = sign * observable_at(pointer, x, column)
        largest = max(largest, fx)
        if abs(x - a) > abs(x - c):  # drop the farther end
            a, fa, b, fb = b, fb, x, fx
        else:
            b, fb, c, fc = x, fx, b, fb
    return largest


@kernel
def maximum_in_step(pointer, column, sign):
    """Return the largest value of the observable times `sign` near its highest stage, from the dense output."""
    return refine_peak(pointer, column, sign, node_of_maximum(pointer[0].o, column, sign))


class Record(NamedTuple):
    """Times and samples of the time histories."""

    times: np.ndarray  # (samples,) s, or rad of a free crank, increasing
    samples: np.ndarray  # (samples, channels)
    independent: int  # index in the state of the quantity that `times` gives


@kernel
def fraction_at(pointer, independent, target):
    """Return the fraction (0 to 1) of the step at which component `independent` of the state equals `target`."""
    work = pointer[0]
    a, b = 0.0, 1.0
    x = (target - work.y[independent]) / (work.end[independent] - work.y[independent])
    for _ in range(60):
        residual = dense_component(x, independent, work.y, work.f) - target
        if residual > 0.0:
            b = x
        else:
            a = x
        step = 1e-7  # a difference quotient suffices: only the root matters
        slope = (dense_component(x + step, independent, work.y, work.f) - residual - target) / step
        newton = x - residual / slope if slope > 0.0 else 0.5 * (a + b)
        if not a <= newton <= b:
            newton = 0.5 * (a + b)
        if abs(newton - x) <= 1e-15:
            return newton
        x = newton
    return x


@kernel
def write_sample(pointer, y, out):
    """Write the time histories at the state `y` to `out`, in the order of the channels."""
    work = pointer[0]
    invoke(work.sample.code, work.sample.parameters, (y, work.mode, work.latched, work.journal_sides, out), out.size)


@kernel
def write_samples(pointer):
    """Write the samples within the latest step, from its dense output."""
    work = pointer[0]
    record = work.record
    independent = record.independent
    i = work.counts.samples
    while i < record.times.size and record.times[i] <= work.end[independent]:
        dense_state(fraction_at(pointer, independent, record.times[i]), work.y, work.f, work.z)
        work.z[independent] = record.times[i]
        for j in range(work.mode.size):  # just before a separation rounding may put the interpolant below zero
            work.z[work.time + 1 + j] = max(work.z[work.time + 1 + j], 0.0)
        write_sample(pointer, work.z, record.samples[i])
        i += 1
    work.counts.samples = i


def sample_states(work, states, out):
    """Write the time histories at `states` (states, n) to `out` (states, channels), without forces."""
    repeated_arrays = [
        np.broadcast_to(array, (len(states), array.size)) for array in (work.mode, work.latched, work.journal_sides)
    ]
    invoke_each(work.sample.code, work.sample.parameters, (states, *repeated_arrays, out), out.shape[1])


PROBE_DISTANCE = 1e-4  # of a step: distance from a mark at which a rising force is detected


class RevolutionMarks(NamedTuple):
    """States and force peaks at marks along the motion."""

    marks: np.ndarray  # (marks,) s, or rad of a free crank, increasing
    states: np.ndarray  # (marks, n) the state at each mark
    peaks: np.ndarray  # (marks, contacts) N, largest normal force since the previous mark
    step_peak: np.ndarray  # (contacts,) N, largest normal force of the current step, 0 if none acts
    peak_since_mark: np.ndarray  # (contacts,) N, largest of the earlier steps since the last mark
    passed: np.ndarray  # (1,) int64, number of marks passed


@kernel
def record_start(pointer):
    """Record the state at a mark at the start of the run."""
    work = pointer[0]
    revolutions, i = work.revolutions, work.revolutions.passed[0]
    if i < revolutions.marks.size and revolutions.marks[i] <= work.y[work.independent]:
        for c in range(revolutions.states.shape[1]):
            revolutions.states[i, c] = work.y[c]
        revolutions.passed[0] = i + 1


@kernel
def split_peaks(pointer, i, x):
    """Split the largest forces of the step into those before and after mark `i`, at the fraction `x` of the step."""
    work = pointer[0]
    revolutions, mark_row = work.revolutions, observe.END
    if x < 1.0:
        evaluate_dense(pointer, x)
        mark_row = observe.SCRATCH
    for j in range(work.mode.size):
        column, step_peak = observe.column_of(j, observe.NORMAL), revolutions.step_peak[j]
        force_at_mark = work.o[column, mark_row] if step_peak > 0.0 else 0.0
        peak_after = max(force_at_mark, work.o[column, observe.END]) if step_peak > 0.0 else 0.0
        peak_before = force_at_mark
        if step_peak > peak_after:
            is_rising = x < 1.0 and observable_at(pointer, min(x + PROBE_DISTANCE, 1.0), column) > force_at_mark
            peak_before, peak_after = (force_at_mark, step_peak) if is_rising else (step_peak, peak_after)
            if x < 1.0:
                evaluate_dense(pointer, x)
        revolutions.peaks[i, j] = max(revolutions.peak_since_mark[j], peak_before)
        revolutions.peak_since_mark[j], revolutions.step_peak[j] = 0.0, peak_after


@kernel
def record_marks(pointer):
    """Record and pass the marks within the current step."""
    work = pointer[0]
    revolutions = work.revolutions
    i = revolutions.passed[0]
    while i < revolutions.marks.size and revolutions.marks[i] <= work.end[work.independent]:
        x = 1.0
        if revolutions.marks[i] < work.end[work.independent]:
            x = fraction_at(pointer, work.independent, revolutions.marks[i])
        split_peaks(pointer, i, x)
        if x < 1.0:
            dense_state(x, work.y, work.f, work.z)
        for c in range(revolutions.states.shape[1]):
            revolutions.states[i, c] = work.z[c] if x < 1.0 else work.end[c]
        i += 1
    revolutions.passed[0] = i


# ----------------------------------------------------------------------------------------------------------------------
# Sums of a step that `totals.accumulate_step` leaves out: they need a search, or apply to some cases only.


MIN_BINNED_STEPS = 8  # between two computations of the forces that are distributed by fine parts


@kernel
def add_profiles(pointer):
    """Add the profiles over a step of all acting contacts to their histograms, wear and film."""
    work = pointer[0]
    has_wear = work.wear.code != 0
    for j in range(work.mode.size):
        if acts(work.mode[j]):
            if work.has_histogram[j] != 0:
                add_force_times(pointer, j)
            if has_wear or work.limit_depth[j] < math.inf or work.film[j, 1] < math.inf:
                add_contact_profile(pointer, j, work.end[work.time] - work.y[work.time])


@kernel
def choose_fine_bins(pointer, j):
    """Set the bins of the forces of contact `j` that are distributed by fine parts: high ones, then those near p99."""
    work = pointer[0]
    totals, bins = work.totals, work.totals.bins
    revolution, elapsed = 2.0 * math.pi / work.reference_rate, work.end[work.time] - totals.mechanism.window_start
    longest = observe.FINE_SHARES[0] * max(elapsed, revolution)
    bins[j, FINE_BIN], bins[j, LAST_FINE_BIN] = 0, observe.BINS
    if totals.joint[j].binned_time >= longest:
        bins[j, FINE_BIN] = observe.force_bin(
            observe.force_quantile_of(totals.histogram, j, bins[j, HIGHEST_BIN], longest)
        )
    is_steady = work.crank < 0 and work.knots.size == 0  # what speeds up, or follows a table, may press harder later
    if is_steady and elapsed > revolution and bins[j, FINE_BIN] > 0:
        rarest = observe.force_quantile_of(totals.histogram, j, bins[j, HIGHEST_BIN], observe.FINE_SHARES[1] * elapsed)
        bins[j, LAST_FINE_BIN] = observe.force_bin(rarest)
    bins[j, NEXT_FINE_BIN] = bins[j, BINNED_STEPS] + bins[j, BINNED_STEPS] // 4 + MIN_BINNED_STEPS


@kernel
def add_force_times(pointer, j):
    """Add the time of a step to the histogram of the force of contact `j`."""
    work = pointer[0]
    totals, bins, part_times = work.totals, work.totals.bins, work.totals.part_times
    if bins[j, BINNED_STEPS] >= bins[j, NEXT_FINE_BIN]:
        choose_fine_bins(pointer, j)
    duration = work.end[work.time] - work.y[work.time]
    bins[j, BINNED_STEPS] += 1
    totals.joint[j].binned_time += duration
    scale = duration / total_of(part_times[j, RELATIVE_DURATION])
    force, has_film, ramps = work.profiles[1 + j], work.film[j, 1] < math.inf, part_times[j, FIRST_BIN_TIME:]
    lowest, highest = bins[j, 0], bins[j, 0]
    for i in range(1, observe.PARTS + 1):
        lowest, highest = min(lowest, bins[j, i]), max(highest, bins[j, i])
    bins[j, HIGHEST_BIN] = max(bins[j, HIGHEST_BIN], highest)
    if highest >= bins[j, FINE_BIN] and lowest <= bins[j, LAST_FINE_BIN] and highest > lowest + 1:
        fine_sums, fine_bins = totals.fine_sums, totals.fine_bins
        observe.write_fine_ramps(
            work.o, (observe.KAPPA, observe.column_of(j, observe.NORMAL)), scale, fine_sums, fine_bins
        )
        for i in rolled_range(observe.PARTS):
            lower, higher = min(bins[j, i], bins[j, i + 1]), max(bins[j, i], bins[j, i + 1])
            pulls = has_film and force[i] * force[i + 1] < 0.0  # for a part of the time
            if higher >= bins[j, FINE_BIN] and lower <= bins[j, LAST_FINE_BIN] and not pulls:
                observe.add_fine_part(totals.histogram, j, i, fine_sums, fine_bins)
                ramps[0, i], ramps[1, i], ramps[2, i] = 0.0, 0.0, 0.0
            bins[j, HIGHEST_BIN] = max(bins[j, HIGHEST_BIN], fine_bins[observe.FINE_ROWS, i])
    observe.add_ramps(totals.histogram, j, bins[j], ramps)
    if has_film:
        totals.histogram[j, 0, 0] += total_of(part_times[j, PULLING_TIME])


@kernel
def add_contact_profile(pointer, j, duration):
    """Write the profiles of contact `j` over a step of `duration` (s), and add its times beyond limits (s)."""
    work = pointer[0]
    totals = work.totals
    step_values, kappa, force = totals.step_values[j], work.profiles[0], work.profiles[1 + j]
    has_limit, has_wear, has_film = work.limit_depth[j] < math.inf, work.wear.code != 0, work.film[j, 1] < math.inf
    for i in range(observe.PARTS + 1):
        step_values[observe.FORCE_ROW, i], step_values[observe.KAPPA_ROW, i] = force[i], max(kappa[i], 0.0)
    observe.write_row(work.o, observe.column_of(j, observe.DEPTH), step_values, observe.DEPTH_ROW)
    if has_wear:
        observe.write_row(work.o, observe.column_of(j, observe.SLIP), step_values, observe.SLIP_ROW)
        for m in range(observe.NODES.size):
            observe.put_friction_power(work.o, observe.NODES[m], j)
        observe.write_row(work.o, observe.column_of(j, observe.FRICTION_POWER), step_values, observe.FRICTION_POWER_ROW)
    if has_limit:
        totals.joint[j].beyond_time += observe.fraction_above(step_values, work.limit_depth[j]) * duration
    if has_film:
        totals.joint[j].clamped_time += observe.fraction_above(step_values, work.film[j, 1]) * duration
        is_dry = observe.fraction_above(step_values, work.film[j, 0]) > 0.0
        if is_dry or has_wear:
            observe.write_row(
                work.o, observe.film_column(work.mode.size, j, observe.DRY_FORCE), step_values, observe.FORCE_ROW
            )  # the film itself causes no wear
        if is_dry:
            rows = totals.part_times[j, FIRST_BIN_TIME:], totals.bins[j]  # those of the force are in its histogram
            observe.add_profile(totals.dry, j, step_values, duration, rows)
        if has_wear:
            observe.write_row(
                work.o,
                observe.film_column(work.mode.size, j, observe.DRY_FRICTION_POWER),
                step_values,
                observe.FRICTION_POWER_ROW,
            )


@kernel
def add_film_sums(pointer, h, j):
    """Add heat (J) and force sums of contact `j`, which has a film; update its largest dry force and pressure (Pa)."""
    work = pointer[0]
    o, sums, figures, contacts = work.o, work.contact_steps[j], work.totals.joint[j], work.mode.size
    weights = STAGE_WEIGHTS if work.method.current == IMPLICIT else WEIGHTS
    figures.heat += h * (sums.sum_lost + sums.sum_friction)
    figures.film_energy += h * stage_integral(o, observe.film_column(contacts, j, observe.FILM_POWER), weights)
    figures.generated_energy += h * integral_of_negative_part(
        o, observe.film_column(contacts, j, observe.PRESSURE_POWER), weights
    )
    figures.friction_energy += h * stage_integral(
        o, observe.film_column(contacts, j, observe.DRY_FRICTION_POWER), weights
    )
    dry_column = observe.film_column(contacts, j, observe.DRY_FORCE)
    figures.dry_force_time += h * integral_of_magnitude(o, dry_column, weights)
    figures.load_time += h * integral_of_magnitude(o, observe.column_of(j, observe.NORMAL), weights)
    largest = max(o[dry_column, observe.START], o[dry_column, observe.END])
    if interior_peak(o, dry_column, 1.0) > 0.9 * figures.dry_max:
        largest = max(largest, maximum_in_step(pointer, dry_column, 1.0))
    figures.dry_max = max(figures.dry_max, largest)
    pressure_column = observe.film_column(contacts, j, observe.PEAK_PRESSURE)
    largest = max(o[pressure_column, observe.START], o[pressure_column, observe.END])
    if largest > 0.95 * figures.pressure_max:  # between the ends of a step only the interpolant gives it
        largest = max(largest, refine_peak(pointer, pressure_column, 1.0, observe.NODES.size // 2))
    figures.pressure_max = max(figures.pressure_max, largest)
    figures.shear_speed_max = max(
        figures.shear_speed_max, o[observe.film_column(contacts, j, observe.SHEAR_SPEED), observe.END]
    )


@kernel
def add_friction_loads(pointer, h):
    """Add the work (J) of friction loads over a step of length `h`; their powers are observed before the signals."""
    work = pointer[0]
    weights = STAGE_WEIGHTS if work.method.current == IMPLICIT else WEIGHTS
    work_of_loads = work.totals.friction
    for i in range(work_of_loads.size):
        work_of_loads[i] -= h * stage_integral(work.o, work.signals - work_of_loads.size + i, weights)


@kernel
def search_maxima(pointer):
    """Raise maxima that may lie between the stages to those of the dense output, see `totals.accumulate_step`."""
    work = pointer[0]
    mechanism = work.totals.mechanism
    step = work.step
    revolutions = work.revolutions
    in_window = work.stepper.in_window != 0.0
    for j in range(work.mode.size):
        figures, contact_step = work.totals.joint[j], work.contact_steps[j]
        if contact_step.highest_force > NO_PEAK:
            largest = maximum_in_step(pointer, observe.column_of(j, observe.NORMAL), 1.0)
            figures.peak, revolutions.step_peak[j] = max(figures.peak, largest), max(revolutions.step_peak[j], largest)
            if in_window:
                figures.force_max = max(figures.force_max, largest)
        if contact_step.highest_depth > NO_PEAK:
            figures.depth_max = max(
                figures.depth_max, maximum_in_step(pointer, observe.column_of(j, observe.DEPTH), 1.0)
            )
        if work.has_friction[j] != 0 and contact_step.highest_load > NO_PEAK:
            figures.load_max = max(figures.load_max, maximum_in_step(pointer, observe.column_of(j, observe.LOAD), 1.0))
    if step.highest_acceleration > NO_PEAK:
        largest = maximum_in_step(
            pointer, observe.ACCELERATION, math.copysign(1.0, work.o[observe.ACCELERATION, observe.END])
        )
        mechanism.acceleration_max = max(mechanism.acceleration_max, largest)
    if step.highest_torque > NO_PEAK:
        largest = maximum_in_step(pointer, observe.TORQUE, math.copysign(1.0, work.o[observe.TORQUE, observe.END]))
        mechanism.torque_max = max(mechanism.torque_max, largest)
    if step.highest_error > NO_PEAK:
        sign = math.copysign(1.0, work.o[observe.ERROR, observe.END])
        mechanism.error_max = max(
            mechanism.error_max, refine_peak(pointer, observe.ERROR, sign, observe.NODES.size // 2)
        )


@kernel
def record_target_speed(pointer):
    """Record when (s) a free crank first reaches its target speed, and the largest forces (N) up to this step."""
    work = pointer[0]
    mechanism, index = work.totals.mechanism, work.crank + work.time // 2
    if mechanism.target_time == math.inf and work.y[index] < mechanism.target_speed <= work.end[index]:
        dense_state(fraction_at(pointer, index, mechanism.target_speed), work.y, work.f, work.z)
        mechanism.target_time = work.z[work.time]
        for j in range(work.mode.size):
            work.totals.joint[j].force_max_to_target = work.totals.joint[j].force_max


@kernel
def add_crank_speed(pointer, h):
    """Update the extreme speeds (rad/s) of a free crank, from the cubic through the ends of the step."""
    work = pointer[0]
    mechanism, index = work.totals.mechanism, work.crank + work.time // 2
    start_value, end_value = work.y[index], work.end[index]
    start_slope, end_slope = h * work.k[index, observe.START], h * work.k[index, observe.END]
    linear_term = 3.0 * (end_value - start_value) - 2.0 * start_slope - end_slope
    curvature = start_slope + end_slope - 2.0 * (end_value - start_value)
    low, high = min(start_value, end_value), max(start_value, end_value)
    discriminant = linear_term * linear_term - 3.0 * curvature * start_slope
    if discriminant >= 0.0:
        root_sum = linear_term + math.copysign(
            math.sqrt(discriminant), linear_term
        )  # both stationary points without cancellation
        for u in (
            -root_sum / (3.0 * curvature) if curvature != 0.0 else 2.0,
            -start_slope / root_sum if root_sum != 0.0 else 2.0,
        ):
            if 0.0 < u < 1.0:
                value = start_value + u * (start_slope + u * (linear_term + u * curvature))
                low, high = min(low, value), max(high, value)
    mechanism.speed_min, mechanism.speed_max = min(mechanism.speed_min, low), max(mechanism.speed_max, high)
    if mechanism.target_time < math.inf:
        mechanism.min_speed_after_target = min(mechanism.min_speed_after_target, low)


@kernel
def add_wear(pointer, h):
    """Add the wear depths (m) of the step of length `h` along tau."""
    work = pointer[0]
    totals = work.totals
    totals.length[0] = h
    evaluate_dense_states(pointer, totals.dense_states)
    step = (totals.dense_states, work.mode, totals.step_values, totals.length, totals.workspace)
    invoke(
        work.wear.code,
        work.wear.parameters,
        (*step, totals.wear, totals.account),
        totals.wear.size // (2 * work.mode.size),
    )


#: Columns of `Work.recording` before the signals of the scene: dt/dx (s) for the fraction x of the step, a free column,
#: torque (N m) and power (W) of the drive, and the power (W) that the dry normal forces dissipate.
DURATION, FREE, DRIVE_TORQUE, DRIVE_POWER, DISSIPATED, SIGNALS = range(6)


@inlined
def _dry_normal_loss(work, j, row):
    """Return the power (W) that the dry normal force of contact `j` loses if there is a film: all but the others'."""
    if not touches(work.mode[j]):
        return 0.0
    o, contacts = work.o, work.mode.size
    tangential, slip = o[observe.column_of(j, observe.TANGENTIAL), row], o[observe.column_of(j, observe.SLIP), row]
    others = o[observe.film_column(contacts, j, observe.FILM_POWER), row]
    others += o[observe.film_column(contacts, j, observe.DRY_FRICTION_POWER), row]
    return o[observe.column_of(j, observe.LOST), row] - tangential * slip - others


@kernel
def record_signals(pointer, h):
    """Record the observables of a step of length `h` from which the figures of vibration follow, at all its nodes."""
    work = pointer[0]
    o, values = work.o, work.recording[int(work.stepper.recorded)]
    for row in range(observe.NODES.size):
        values[DURATION, row] = h * o[observe.KAPPA, row]
        values[DRIVE_TORQUE, row], values[DRIVE_POWER, row] = o[observe.TORQUE, row], o[observe.DRIVE, row]
        dissipated = 0.0
        for j in range(work.mode.size):
            if work.film[j, 1] < math.inf:
                dissipated += _dry_normal_loss(work, j, row)
            elif work.mode[j] != REPORTING:
                dissipated += o[observe.column_of(j, observe.LOST), row]
        values[DISSIPATED, row] = dissipated
    for column in range(values.shape[0] - SIGNALS):
        for row in range(observe.NODES.size):
            values[SIGNALS + column, row] = o[work.signals + column, row]
    work.stepper.recorded += 1.0


@kernel
def add_slow_sums(pointer, h):
    """Add the slow sums of an accepted step of length `h` along tau."""
    work = pointer[0]
    record, in_window = work.record, work.stepper.in_window != 0.0
    work.counts.steps += 1
    if work.step.needs_peak_search != 0.0:
        search_maxima(pointer)
    if in_window:
        touching = False
        for j in range(work.mode.size):
            touching = touching or touches(work.mode[j])
            if acts(work.mode[j]) and work.film[j, 1] < math.inf:
                add_film_sums(pointer, h, j)
        add_profiles(pointer)
        add_friction_loads(pointer, h)
        if work.crank >= 0:
            add_crank_speed(pointer, h)
        if work.wear.code != 0 and touching:
            add_wear(pointer, h)
        if work.recording.shape[0]:
            record_signals(pointer, h)
    if work.crank >= 0:
        record_target_speed(pointer)
    record_marks(pointer)
    i = work.counts.samples
    if i < record.times.size and record.times[i] <= work.end[record.independent]:
        write_samples(pointer)


@kernel
def begin_window(pointer):
    """Reset the figures; keep the energies and the current contacts."""
    totals = pointer[0].totals
    for column in range(FIRST_FIGURE, MechanismTotals.SIZE):
        totals.mechanism.numbers[column] = 0.0
    for j in range(pointer[0].mode.size):
        for column in range(CONTACT_FIGURES):
            totals.joint.numbers[j, column] = 0.0
        totals.joint[j].depth_max = -math.inf
    for i in range(totals.friction.size):
        totals.friction[i] = 0.0
    totals.mechanism.window_start = (
        pointer[0].end[pointer[0].time] if pointer[0].counts.steps else pointer[0].y[pointer[0].time]
    )
    totals.mechanism.speed_min, totals.mechanism.speed_max = math.inf, -math.inf
    totals.mechanism.min_speed_after_target = math.inf
