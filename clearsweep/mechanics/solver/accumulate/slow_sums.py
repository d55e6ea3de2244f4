"""Sums beyond `totals.accumulate_step`: they need a search, or apply to some cases only."""

import math

from ...compiled.choosing import total_of
from ...compiled.family import invoke, kernel
from ...joint.modes import acts, touches
from ...observe.histogram import (
    DEPTH_COURSE,
    FORCE,
    KAPPA_COURSE,
    PARTS,
    RUBBED_COURSE,
    SLIP_COURSE,
    add_course,
    fill,
    follow,
    share_beyond,
)
from ...observe.observables import (
    ACCELERATION,
    DEPTH,
    DRAINED,
    DRY,
    DRY_RUBBED,
    ERROR,
    LOAD,
    NORMAL,
    PRESSURE,
    PUMPED,
    RUBBED,
    SLIP,
    SPEED,
    TORQUE,
    column_of,
    film_column,
    put_rubbed,
)
from ...observe.stages import END, NODES, START
from ..collocation import WEIGHTS, dense_state
from ..integration import IMPLICIT
from ..radau import STAGE_WEIGHTS
from .step_sums import (
    NO_PEAK,
    highest_inside,
    integral_of,
    integral_of_size,
    negative_part_of,
)
from .totals import (
    BEGUN,
    CONTACT_FIGURES,
    DENSITY,
    ENDED,
    FIRST_FIGURE,
    PULLED,
    WholeTotals,
)
from .within_step import (
    evaluate_between,
    highest_between,
    record_marks,
    refined_peak,
    share_at,
    write_samples,
)


@kernel
def add_courses(pointer):
    """Add the profiles over a step of all acting contacts to their histograms, wear and film."""
    work = pointer[0]
    totals, worn = work.totals, work.wear.code != 0
    for j in range(work.mode.size):
        if acts(work.mode[j]):
            histograms = totals.spent
            fill(totals.histogram, j, totals.bins, (histograms[:, BEGUN], histograms[:, ENDED], histograms[:, DENSITY]))
            if work.film[j, 1] < math.inf:
                totals.histogram[j, 0, 0] += total_of(histograms[j, PULLED])
            if worn or work.limit_depth[j] < math.inf or work.film[j, 1] < math.inf:
                follow_contact(pointer, j, work.end[work.time] - work.y[work.time])


@kernel
def follow_contact(pointer, j, duration):
    """Follow contact `j` over a step of `duration` (s): its wear, its film, the limit of its law."""
    work = pointer[0]
    totals = work.totals
    step_values, kappa, force = totals.step_values[j], work.profiles[0], work.profiles[1 + j]
    limited, worn, film = work.limit_depth[j] < math.inf, work.wear.code != 0, work.film[j, 1] < math.inf
    for i in range(PARTS + 1):
        step_values[FORCE, i], step_values[KAPPA_COURSE, i] = force[i], max(kappa[i], 0.0)
    follow(work.o, column_of(j, DEPTH), step_values, DEPTH_COURSE)
    if worn:
        follow(work.o, column_of(j, SLIP), step_values, SLIP_COURSE)
        for m in range(NODES.size):
            put_rubbed(work.o, NODES[m], j)
        follow(work.o, column_of(j, RUBBED), step_values, RUBBED_COURSE)
    if limited:
        totals.joint[j].beyond_time += share_beyond(step_values, work.limit_depth[j]) * duration
    if film:
        totals.joint[j].held_time += share_beyond(step_values, work.film[j, 1]) * duration
        bears = share_beyond(step_values, work.film[j, 0]) > 0.0
        if bears or worn:
            follow(work.o, film_column(work.mode.size, j, DRY), step_values, FORCE)  # the film itself causes no wear
        if bears:
            add_course(totals.dry, j, step_values, duration)
        if worn:
            follow(work.o, film_column(work.mode.size, j, DRY_RUBBED), step_values, RUBBED_COURSE)


@kernel
def note_film(pointer, h, j):
    """Add the heat and forces of contact `j`, which has a film; update its largest dry force (N) and pressure (Pa)."""
    work = pointer[0]
    o, sums, row, contacts = work.o, work.contact_steps[j], work.totals.joint[j], work.mode.size
    weights = STAGE_WEIGHTS if work.method.current == IMPLICIT else WEIGHTS
    row.heat += h * (sums.sum_lost + sums.sum_rubbed)
    row.drained_energy += h * integral_of(o, film_column(contacts, j, DRAINED), weights)
    row.fed_energy += h * negative_part_of(o, film_column(contacts, j, PUMPED), weights)
    row.friction_energy += h * integral_of(o, film_column(contacts, j, DRY_RUBBED), weights)
    dry = film_column(contacts, j, DRY)
    row.dry_force_time += h * integral_of_size(o, dry, weights)
    row.load_time += h * integral_of_size(o, column_of(j, NORMAL), weights)
    largest = max(o[dry, START], o[dry, END])
    if highest_inside(o, dry, 1.0) > 0.9 * row.dry_max:
        largest = max(largest, highest_between(pointer, dry, 1.0))
    row.dry_max = max(row.dry_max, largest)
    pressure = film_column(contacts, j, PRESSURE)
    largest = max(o[pressure, START], o[pressure, END])
    if largest > 0.95 * row.pressure_max:  # between the ends of a step only the interpolant gives it
        largest = max(largest, refined_peak(pointer, pressure, 1.0, NODES.size // 2))
    row.pressure_max = max(row.pressure_max, largest)
    row.speed_most = max(row.speed_most, o[film_column(contacts, j, SPEED), END])


@kernel
def note_friction(pointer, h):
    """Add the work (J) of friction loads over a step of length `h`; the last observables are their powers."""
    work = pointer[0]
    weights = STAGE_WEIGHTS if work.method.current == IMPLICIT else WEIGHTS
    loads = work.totals.friction
    for i in range(loads.size):
        loads[i] -= h * integral_of(work.o, work.o.shape[0] - loads.size + i, weights)


@kernel
def seek_maxima(pointer):
    """Raise maxima that may lie between the stages to those of the dense output, see `totals.accumulate_step`."""
    work = pointer[0]
    total, step, revolutions, counted = work.totals.whole, work.step, work.revolutions, work.stepper.in_window != 0.0
    for j in range(work.mode.size):
        row, highest = work.totals.joint[j], work.contact_steps[j]
        if highest.highest_force > NO_PEAK:
            largest = highest_between(pointer, column_of(j, NORMAL), 1.0)
            row.peak, revolutions.highest[j] = max(row.peak, largest), max(revolutions.highest[j], largest)
            if counted:
                row.force_max = max(row.force_max, largest)
        if highest.highest_depth > NO_PEAK:
            row.depth_max = max(row.depth_max, highest_between(pointer, column_of(j, DEPTH), 1.0))
        if work.rubs[j] != 0 and highest.highest_load > NO_PEAK:
            row.load_max = max(row.load_max, highest_between(pointer, column_of(j, LOAD), 1.0))
    if step.highest_acceleration > NO_PEAK:
        largest = highest_between(pointer, ACCELERATION, math.copysign(1.0, work.o[ACCELERATION, END]))
        total.acceleration_max = max(total.acceleration_max, largest)
    if step.highest_torque > NO_PEAK:
        largest = highest_between(pointer, TORQUE, math.copysign(1.0, work.o[TORQUE, END]))
        total.torque_max = max(total.torque_max, largest)
    if step.highest_error > NO_PEAK:
        sign = math.copysign(1.0, work.o[ERROR, END])
        total.error_max = max(total.error_max, refined_peak(pointer, ERROR, sign, NODES.size // 2))


@kernel
def note_awaited_speed(pointer):
    """Note the time at which a free crank first passes its awaited speed."""
    work = pointer[0]
    total, index = work.totals.whole, work.independent + work.time // 2
    if total.speed_reached == 0.0 and work.y[index] < total.speed_awaited <= work.end[index]:
        dense_state(share_at(pointer, index, total.speed_awaited), work.y, work.f, work.z)
        total.speed_reached = work.z[work.time]


@kernel
def note_speed(pointer, h):
    """Update the extreme speeds (rad/s) of a free crank, from the cubic through the ends of the step."""
    work = pointer[0]
    total, index = work.totals.whole, work.independent + work.time // 2
    start_value, end_value = work.y[index], work.end[index]
    start_slope, end_slope = h * work.k[index, START], h * work.k[index, END]
    linear_term, curvature = (
        3.0 * (end_value - start_value) - 2.0 * start_slope - end_slope,
        start_slope + end_slope - 2.0 * (end_value - start_value),
    )
    low, high = min(start_value, end_value), max(start_value, end_value)
    root = linear_term * linear_term - 3.0 * curvature * start_slope
    if root >= 0.0:
        root_sum = linear_term + math.copysign(
            math.sqrt(root), linear_term
        )  # both stationary points without cancellation
        for u in (
            -root_sum / (3.0 * curvature) if curvature != 0.0 else 2.0,
            -start_slope / root_sum if root_sum != 0.0 else 2.0,
        ):
            if 0.0 < u < 1.0:
                value = start_value + u * (start_slope + u * (linear_term + u * curvature))
                low, high = min(low, value), max(high, value)
    total.speed_min, total.speed_max = min(total.speed_min, low), max(total.speed_max, high)


@kernel
def note_wear(pointer, h):
    """Add the wear of the step of length `h`."""
    work = pointer[0]
    totals = work.totals
    totals.length[0] = h
    evaluate_between(pointer, totals.between)
    step = (totals.between, work.mode, totals.step_values, totals.length, totals.workspace)
    invoke(
        work.wear.code,
        work.wear.parameters,
        (*step, totals.wear, totals.account),
        totals.wear.size // (2 * work.mode.size),
    )


@kernel
def note_step(pointer, h):
    """Add the slow sums of an accepted step of length `h`."""
    work = pointer[0]
    record, time, counted = work.record, work.time, work.stepper.in_window != 0.0
    work.counts.steps += 1
    if work.step.needs_peak_search != 0.0:
        seek_maxima(pointer)
    if counted:
        touching = False
        for j in range(work.mode.size):
            touching = touching or touches(work.mode[j])
            if acts(work.mode[j]) and work.film[j, 1] < math.inf:
                note_film(pointer, h, j)
        add_courses(pointer)
        note_friction(pointer, h)
        if work.independent != time:
            note_speed(pointer, h)
        if work.wear.code != 0 and touching:
            note_wear(pointer, h)
    if work.independent != time:
        note_awaited_speed(pointer)
    record_marks(pointer)
    i = work.counts.samples
    if i < record.times.size and record.times[i] <= work.end[record.independent]:
        write_samples(pointer)


@kernel
def open_window(pointer):
    """Reset the figures; keep the energies and the current contacts."""
    totals = pointer[0].totals
    for column in range(FIRST_FIGURE, WholeTotals.SIZE):
        totals.whole.numbers[column] = 0.0
    for j in range(pointer[0].mode.size):
        for column in range(CONTACT_FIGURES):
            totals.joint.numbers[j, column] = 0.0
        totals.joint[j].depth_max = -math.inf
    for i in range(totals.friction.size):
        totals.friction[i] = 0.0
    totals.whole.opened = pointer[0].end[pointer[0].time] if pointer[0].counts.steps else pointer[0].y[pointer[0].time]
    totals.whole.speed_min, totals.whole.speed_max = math.inf, -math.inf
