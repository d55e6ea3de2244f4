"""The stages of a step, the observables of the motion there, and the histogram of a force over time.

Observables are in columns that are accessed by name.  KAPPA to ERROR_RATE are columns of the whole mechanism; a block
for every contact follows.  LOAD, the square of the resultant of normal and tangential force (N^2), and FRICTION_POWER,
the power of friction (W, dissipated), are filled in on demand, by `put_load` and `put_friction_power`.  If a joint has
a film, another block for every contact follows: the dry fraction of its normal force (N), the powers (W) of film and
dry friction, its largest pressure (Pa), the shear speed (m/s) of the surfaces, and the power (W) of its pressure only.
The power (W) of each friction load follows, negative if it dissipates energy.

The histogram follows from the profile of the force over each step; so do its quantiles, such as the p99 of a force.
"""

import ctypes
from typing import NamedTuple

import numpy as np

from ..tracing.compiled.choosing import bits_of, lane_range, number_of, rolled_range, where
from ..tracing.compiled.family import Routine, inlined, kernel, shaped

#: The stages as fractions of the step: Radau's points, zeros of d^7/dx^7 x^7 (x - 1)^8.
POINTS = (
    0.022479386438712497,
    0.11467905316090424,
    0.26578982278458946,
    0.45284637366944464,
    0.6473752828868303,
    0.8197593082631076,
    0.9437374394630779,
    1.0,
)
STAGES = len(POINTS)
#: Rows of rates and observables: at the stages, the last of which is the END of the step, at its START, and in any
#: state on the interpolant; from FIRST_IMPLICIT_ROW on those of the implicit method.
END, START, SCRATCH, FIRST_IMPLICIT_ROW, ROW_COUNT = 7, 8, 9, 10, 16
#: The rows at distinct times of a step, in order: its start and its stages; and these times as fractions of the step.
NODES = np.array([START, *range(STAGES)])
NODE_FRACTIONS = np.array([0.0, *POINTS])


@inlined
def whole_registers(count):
    """Return the least multiple of STAGES, the lanes of a register, that is not below `count`."""
    return -(-count // STAGES) * STAGES


# ---------------------------------------------------------------------------------------------- columns


KAPPA, DRIVE, GRAVITY, ACCELERATION, TORQUE, KINETIC, ERROR, ERROR_RATE, CONTACTS = range(9)
NORMAL, STORED, LOST, TANGENTIAL, SLIP, RAW, DEPTH, RATE, GUARD_QUANTITY, LOAD, FRICTION_POWER, CONTACT_WIDTH = range(
    12
)
DRY_FORCE, FILM_POWER, DRY_FRICTION_POWER, PEAK_PRESSURE, SHEAR_SPEED, PRESSURE_POWER, FILM_WIDTH = range(7)


#: Signals of a scene: time (s), first coordinate (the angle of a free crank), force x, y (N), square of the force
#: (N^2), moment (N m); then of each place velocity x, y (m/s) and acceleration x, y (m/s^2).
TIME, ANGLE, FORCE_X, FORCE_Y, FORCE_SQUARE, MOMENT, PLACES = range(7)
VX, VY, AX, AY, PLACE_WIDTH = range(5)


class Largest(float):
    """A number of a contact; of several contacts of a joint the largest counts, instead of their sum."""


class Resultant(float):
    """A number of a contact; of several contacts of a joint that of their resultant counts, if there is one."""


class Observed(NamedTuple):
    """Observables of a contact, in the order of their columns from NORMAL on."""

    normal: float  # N, normal force
    stored: float  # W, stored in elastic deformation
    lost: float  # W, dissipated by the normal force
    tangential: float  # N, friction force
    slip: float  # m/s, sliding speed; in free flight a bound of the rate of the depth
    raw: float  # N, normal force before clipping, minus the least force of its law
    depth: float  # m, eccentricity minus clearance
    rate: float  # m/s, of the eccentricity
    guard_quantity: float  # a further quantity that only guards use, see `joints.contract.guard_quantity`


@inlined
def column_count(contacts):
    """Return the number of observables."""
    return CONTACTS + CONTACT_WIDTH * contacts


@inlined
def column_of(contact, quantity):
    """Return the column of an observable of a contact: NORMAL to GUARD_QUANTITY."""
    return CONTACTS + CONTACT_WIDTH * contact + quantity


@inlined
def film_column(contacts, contact, quantity):
    """Return the column of a film observable, DRY_FORCE to PRESSURE_POWER, of one of `contacts` contacts."""
    return CONTACTS + CONTACT_WIDTH * contacts + FILM_WIDTH * contact + quantity


@inlined
def contact_observables_in(o, row, contact):
    """Return the Observed of a contact in row `row` of `o`; unused fields are not read."""
    block = CONTACTS + CONTACT_WIDTH * contact
    return Observed(*(o[block + quantity, row] for quantity in range(GUARD_QUANTITY + 1)))


@inlined
def put_load(o, row, contact):
    """Write the squared resultant force of a contact to row `row` of `o`."""
    normal, tangential = o[column_of(contact, NORMAL), row], o[column_of(contact, TANGENTIAL), row]
    o[column_of(contact, LOAD), row] = normal * normal + tangential * tangential


@inlined
def put_friction_power(o, row, contact):
    """Write the friction power of a contact to row `row` of `o`."""
    o[column_of(contact, FRICTION_POWER), row] = (
        -o[column_of(contact, TANGENTIAL), row] * o[column_of(contact, SLIP), row]
    )


# ---------------------------------------------------------------------------------------------- histogram of a force


# Histogram of the normal force over time: approximately logarithmic bins from the bits of the
# number: BIN_BITS of the mantissa, so the relative width of a bin is at most 2^-BIN_BITS.
BIN_BITS = 8
LOWEST_EXPONENT = -20  # exponent of 2 of the lowest force distinguished, N
BINS = 62 << BIN_BITS
FIRST_BIN = (1023 + LOWEST_EXPONENT) << BIN_BITS  # the bits of 2^LOWEST_EXPONENT
EDGES = ((np.arange(BINS + 1) + FIRST_BIN) << (52 - BIN_BITS)).view(np.float64)  # N
WIDTHS = np.diff(EDGES)  # N
PARTS = 8  # parts of a step for the histogram and for wear
FINE_PARTS = 16  # of a part of a step with forces near the quantile that is wanted
FINE_ROWS = FINE_PARTS + 2  # ends of the fine parts of both halves of a part
#: Of the window's time: forces exceeded for at most the first and at least the second are distributed by fine parts.
FINE_SHARES = 0.02, 0.005
QUARTER_POINTS = 3  # quarter points of a step at which positions are evaluated
STATE_POINTS = 8  # quarter points, both ends, and the last end again, to fill the vector lanes
# Rows of Totals.step_values: N, s, m/s, m, W
FORCE_ROW, KAPPA_ROW, SLIP_ROW, DEPTH_ROW, FRICTION_POWER_ROW, STEP_VALUE_ROWS = range(6)


def lagrange(nodes, points):
    """Return the (points, nodes) matrix of the polynomial through values at `nodes`, evaluated at `points`."""
    matrix = np.ones((points.size, nodes.size))
    for i in range(nodes.size):
        for m in range(nodes.size):
            if m != i:
                matrix[:, i] *= (points - nodes[m]) / (nodes[i] - nodes[m])
    return matrix


#: (nodes, PARTS): from values at the nodes of a step to those at the ends of its parts.
TO_PART_ENDS = np.ascontiguousarray(lagrange(NODE_FRACTIONS, np.arange(1, PARTS + 1) / PARTS).T)


#: (FINE_PARTS + 1, nodes, PARTS): the same to the ends of the fine parts of all parts.
TO_FINE_ENDS = np.ascontiguousarray(
    lagrange(NODE_FRACTIONS, np.arange(PARTS * FINE_PARTS + 1) / (PARTS * FINE_PARTS))
    .T[:, np.arange(FINE_PARTS + 1)[:, np.newaxis] + FINE_PARTS * np.arange(PARTS)]
    .swapaxes(0, 1)
)


def _part_integrals():
    """Return the (nodes, PARTS) matrix from values at the nodes of a step to their means over its parts."""
    places, weights = np.polynomial.legendre.leggauss(len(NODE_FRACTIONS))
    points = (np.arange(PARTS)[:, None] + 0.5 + 0.5 * places) / PARTS
    values = lagrange(NODE_FRACTIONS, points.ravel()).reshape(PARTS, len(places), -1)
    return np.ascontiguousarray((0.5 * weights[:, None] * values).sum(axis=1).T)


TO_PART_MEANS = _part_integrals()


@inlined
def value_at(o, column, table, point):
    """Return the polynomial through an observable at the nodes of a step, at a point of a `table` (nodes, points)."""
    total = table[0, point] * o[column, NODES[0]]
    for m in range(1, NODES.size):
        total += table[m, point] * o[column, NODES[m]]
    return total


class Ramp(NamedTuple):
    """Distribution of time among bins for a force that changes linearly."""

    first_bin_time: float  # s, in the first bin
    last_bin_time: float  # s, in the last bin, if different, minus the part from `density`
    density: float  # s/N, in the bins crossed; negative for a decreasing force


@inlined
def force_bin(force):
    """Return the histogram bin of `force` (N): the leading bits of exponent and mantissa, from 2^LOWEST_EXPONENT on."""
    return min(max((bits_of(force) >> (52 - BIN_BITS)) - FIRST_BIN, 0), BINS - 1)


@inlined
def bin_edge(index):
    """Return the lower edge (N) of the histogram bin `index`."""
    return number_of((index + FIRST_BIN) << (52 - BIN_BITS))


@inlined
def ramp_of(forces, bins, duration):
    """Return the Ramp of a force between two `forces` (N), not negative, in these `bins`, during `duration` (s)."""
    low, high = min(forces[0], forces[1]), max(forces[0], forces[1])
    lowest_bin, highest_bin = min(bins[0], bins[1]), max(bins[0], bins[1])
    is_single_bin = lowest_bin == highest_bin
    crosses_bins = highest_bin > lowest_bin + 1
    is_rising = forces[0] < forces[1]
    density = duration / where(is_single_bin, 1.0, high - low)
    lower = where(is_single_bin, duration, density * (bin_edge(lowest_bin + 1) - low))
    # without a whole bin in between, a huge density would leave rounding errors
    upper = where(
        is_single_bin, 0.0, density * (high - where(crosses_bins, bin_edge(highest_bin + 1), bin_edge(highest_bin)))
    )
    crossing_density = where(crosses_bins, density, 0.0)
    return Ramp(
        where(is_rising, lower, upper),
        where(is_rising, upper, lower),
        where(is_rising, crossing_density, -crossing_density),
    )


@inlined
def put_ramp(ramps, bins, i, forces, duration):
    """Write the Ramp of a force between two `forces` (N), during `duration` (s), to column `i`, and its bins."""
    first_bin, last_bin = force_bin(forces[0]), force_bin(forces[1])
    bins[i], bins[i + 1] = first_bin, last_bin
    ramps[0, i], ramps[1, i], ramps[2, i] = ramp_of(forces, (first_bin, last_bin), duration)


@inlined
def add_ramps(histogram, j, bins, ramps):
    """Add PARTS successive Ramps, columns of `ramps` (3, PARTS), of a force in `bins` (PARTS + 1,) at their ends."""
    histogram[j, bins[0], 0] += ramps[0, 0]
    histogram[j, bins[0], 1] += ramps[2, 0]
    for i in range(1, PARTS):
        index, time, density = bins[i], ramps[1, i - 1] + ramps[0, i], ramps[2, i] - ramps[2, i - 1]
        histogram[j, index, 0] += time
        histogram[j, index, 1] += density
    histogram[j, bins[PARTS], 0] += ramps[1, PARTS - 1]
    histogram[j, bins[PARTS], 1] -= ramps[2, PARTS - 1]


@kernel
def write_fine_ramps(o, columns, scale, sums, bins):
    """Write the Ramps of FINE_PARTS fine parts of each part of a step, added where two of a half meet; lanes are parts.

    The steps of a method of high order are so long that a part of them is far from a ramp.

    columns : of dt/dtau and of the force (N) in `o`; scale : s, of a part for dt/dtau = 1; sums, bins : as for
    `add_fine_part`; the last rows of both are workspace
    """
    last_ends, last_ramp, half = sums[FINE_ROWS], sums[FINE_ROWS + 1], FINE_PARTS // 2
    for i in lane_range(PARTS):
        for column in range(2):
            last_ends[column, i] = max(value_at(o, columns[column], TO_FINE_ENDS[0], i), 0.0)
        bins[FINE_ROWS, i] = 0
    for end in rolled_range(0, FINE_PARTS, half):
        row = end + end // half
        for i in lane_range(PARTS):
            last_ramp[0, i] = last_ramp[1, i] = 0.0
        for k in rolled_range(half):
            for i in lane_range(PARTS):
                kappa, force = (max(value_at(o, column, TO_FINE_ENDS[end + k + 1], i), 0.0) for column in columns)
                forces, duration = (last_ends[1, i], force), (last_ends[0, i] + kappa) * (scale * (0.5 / FINE_PARTS))
                last_ends[0, i], last_ends[1, i] = kappa, force
                bins_of_ends = force_bin(forces[0]), force_bin(force)
                bins[row + k, i], bins[row + k + 1, i] = bins_of_ends
                bins[FINE_ROWS, i] = max(bins[FINE_ROWS, i], *bins_of_ends)
                ramp = ramp_of(forces, bins_of_ends, duration)
                sums[row + k, 0, i] = last_ramp[0, i] + ramp.first_bin_time
                sums[row + k, 1, i] = ramp.density - last_ramp[1, i]
                last_ramp[0, i], last_ramp[1, i] = ramp.last_bin_time, ramp.density
        for i in lane_range(PARTS):
            sums[row + half, 0, i], sums[row + half, 1, i] = last_ramp[0, i], 0.0 - last_ramp[1, i]


@inlined
def add_fine_part(histogram, j, part, sums, bins):
    """Add a part of a step to histogram `j` by its fine parts, as `write_fine_ramps` wrote them.

    sums, bins : (FINE_ROWS + 2, 2, PARTS) and (FINE_ROWS + 1, PARTS) int64; for each end of a fine part the sums of
    times (s) and densities (s/N), and the bin
    """
    for row in range(FINE_ROWS):
        index, time, density = bins[row, part], sums[row, 0, part], sums[row, 1, part]
        histogram[j, index, 0] += time
        histogram[j, index, 1] += density


@kernel
def add_profile(histogram, j, step_values, duration, rows):
    """Divide a step's `duration` (s) among the bins of histogram `j`, (BINS, 2), by the force in its `step_values`.

    Parts of the step without force are left out.  rows : workspace, ramps (3, PARTS) and bins (PARTS + 1,) int64
    """
    (ramps, bins), total = rows, 0.0
    for i in range(PARTS):
        total += step_values[KAPPA_ROW, i] + step_values[KAPPA_ROW, i + 1]
    for i in lane_range(PARTS):
        forces = max(step_values[FORCE_ROW, i], 0.0), max(step_values[FORCE_ROW, i + 1], 0.0)
        duration_of_part = (step_values[KAPPA_ROW, i] + step_values[KAPPA_ROW, i + 1]) * (duration / total)
        put_ramp(ramps, bins, i, forces, where(max(*forces) > 0.0, duration_of_part, 0.0))
    add_ramps(histogram, j, bins, ramps)


@kernel
def force_quantile_of(histogram, j, highest, time_exceeded):
    """Return the force (N) that histogram `j` exceeds during `time_exceeded` (s), or 0 if contact was shorter."""
    index, higher_time, density, force = highest, 0.0, 0.0, -1.0
    while force < 0.0:  # from the top, as most bins are below the result
        density += histogram[j, index, 1]
        width = bin_edge(index + 1) - bin_edge(index)
        bin_time = density * width
        bin_time = histogram[j, index, 0] - bin_time
        higher_time += bin_time
        if higher_time >= time_exceeded and bin_time > 0.0:
            offset = (higher_time - time_exceeded) / bin_time * width
            force = bin_edge(index) + offset
        elif index == 0:
            force = 0.0
        index -= 1
    return force


def _force_quantiles(histogram, highest, duration, forces, count):
    """Write the force that each of `count` histograms exceeds to `forces`; arrays are bare pointers."""
    histogram, duration = shaped(histogram, (count, BINS, 2)), shaped(duration, (1,))[0]
    highest, forces = shaped(highest, (count,)), shaped(forces, (count,))
    for j in rolled_range(count):
        forces[j] = force_quantile_of(histogram, j, highest[j], duration)


_write_force_quantiles = Routine(_force_quantiles, "fiff")


def force_quantiles(histograms: np.ndarray, highest: list[int], time_exceeded: float) -> list[float]:
    """Return the force (N) that each histogram exceeds during `time_exceeded` (s), or 0 if contact was shorter.

    histograms : (contacts, BINS, 2), of the Totals; highest : by contact, the highest bin that may not be empty.
    """
    count = len(highest)
    forces = (ctypes.c_double * count)()
    highest_bins, duration = (ctypes.c_int64 * count)(*highest), (ctypes.c_double * 1)(time_exceeded)
    _write_force_quantiles((histograms, highest_bins, duration, forces), count)
    return list(forces)


def force_quantile(histogram: np.ndarray, time_exceeded: float) -> float:
    """Return the force (N) that one histogram, (BINS, 2), exceeds during `time_exceeded` (s)."""
    return force_quantiles(np.ascontiguousarray(histogram)[None], [BINS - 1], time_exceeded)[0]


def time_above(force: float, histogram: np.ndarray) -> float:
    """Return the time (s) at a higher force than `force` (N) in a histogram, (BINS, 2)."""
    bin_count = np.flatnonzero(histogram).max(initial=-1) // 2 + 1
    bin_base_time, increments = histogram[:bin_count].T
    bin_time = bin_base_time + (np.cumsum(increments) - increments) * np.diff(EDGES[: bin_count + 1])
    index = int(np.searchsorted(EDGES, force, side="right")) - 1
    if index < 0 or index >= bin_count:
        return float(bin_time.sum()) if index < 0 else 0.0
    low, high = EDGES[index], EDGES[index + 1]
    return float(bin_time[index + 1 :].sum() + bin_time[index] * (high - force) / (high - low))


@kernel
def write_row(o, column, step_values, row):
    """Write an observable at PARTS + 1 uniform points of the step to row `row` of `step_values`.

    The values are from the polynomial through the stages.
    """
    step_values[row, 0] = o[column, NODES[0]]
    for i in lane_range(PARTS):
        step_values[row, i + 1] = value_at(o, column, TO_PART_ENDS, i)


@kernel
def fraction_above(step_values, limit):
    """Return the fraction of a step's time with a penetration above `limit` (m)."""
    time_at_limit, total = 0.0, 0.0
    for i in range(PARTS + 1):
        total += step_values[KAPPA_ROW, i]
        if step_values[DEPTH_ROW, i] > limit:
            time_at_limit += step_values[KAPPA_ROW, i]
    return time_at_limit / total
