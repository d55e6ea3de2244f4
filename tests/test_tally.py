"""The histogram of a force over time."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.mechanics.observe import (
    BINS,
    EDGES,
    FINE_ROWS,
    KAPPA,
    NODE_FRACTIONS,
    NODES,
    PARTS,
    TO_PART_MEANS,
    WIDTHS,
    add_fine_part,
    add_ramps,
    force_bin,
    force_quantile,
    force_quantiles,
    put_ramp,
    time_above,
    write_fine_ramps,
)
from clearsweep.mechanics.solver.loop import has_finite_sums
from clearsweep.mechanics.solver.totals import (
    BIN_COLUMNS,
    FIRST_BIN_TIME,
    PART_TIME_ROWS,
    PULLING_TIME,
    ContactTotals,
    MechanismTotals,
    add_force_profile,
)


def add_span(histogram, ends, duration):
    """Enter a force that goes from one end to the other into a histogram."""
    ramps, bins = np.zeros((3, PARTS)), np.full(PARTS + 1, force_bin(ends[1]))
    put_ramp(ramps, bins, 0, ends, duration)
    add_ramps(histogram[np.newaxis], 0, bins, ramps)


def filled(ends, duration):
    """Return the histogram of a force that goes from one end to the other."""
    histogram = np.zeros((BINS, 2))
    add_span(histogram, ends, duration)
    return histogram


def spent_in(histogram):
    """Return the time in each bin of a histogram."""
    return histogram[:, 0] + (np.cumsum(histogram[:, 1]) - histogram[:, 1]) * WIDTHS


@pytest.mark.parametrize("highest", [4.0, 4.0001, 5.3, 4096.0])
def test_a_ramp_is_exceeded_for_the_rest_of_its_duration(highest):
    """Also where it ends at the edge of a bin, in which it then spends no time."""
    histogram = filled((0.0, highest), 1.0)
    for share in (0.9, 0.5, 0.1):
        assert force_quantile(histogram, share) == pytest.approx((1.0 - share) * highest, rel=1e-6)


def test_a_histogram_without_contact_exceeds_nothing():
    assert force_quantile(np.zeros((BINS, 2)), 0.01) == 0.0


@pytest.mark.parametrize("ends", [(3.001, 3.005), (3.001, 3.0079), (3.001, 3.0201), (0.3, 40.0), (40.0, 0.3)])
def test_a_ramp_spends_in_each_bin_the_share_of_its_duration_that_the_bin_covers(ends):
    """Within a bin, across one edge, across a whole bin, and across many, upwards and down."""
    covered = np.diff(np.clip(EDGES, min(ends), max(ends)))
    assert spent_in(filled(ends, 0.7)) == pytest.approx(0.7 * covered / covered.sum(), rel=1e-9, abs=1e-14)


@pytest.mark.parametrize("force", [1e-3, 1.0, 777.7, 1e6])
def test_a_steady_force_is_resolved_to_a_256th(force):
    assert force_quantile(filled((force, force), 1.0), 0.5) == pytest.approx(force, rel=1.0 / 256.0, abs=0.0)


def test_forces_exceeded_follow_from_sums_of_time_above_each_bin():
    """For several contacts at once, with bins that many ramps cross, so that their densities add up."""
    random = np.random.default_rng(3)
    histograms, highest = np.zeros((3, BINS, 2)), np.zeros(3, np.int64)
    for histogram, most, j in zip(histograms, (1e-3, 80.0, 7e4), range(3), strict=True):
        for _ in range(100):
            ends = most * random.random(2)
            add_span(histogram, ends, 1.0)
            highest[j] = max(highest[j], *map(force_bin, ends))
    duration = 40.0
    forces = force_quantiles(histograms, highest, duration)
    for histogram, top, force in zip(histograms, highest, forces, strict=True):
        spent = spent_in(histogram)[: top + 1]  # rounding grows with the width of the empty bins above
        above = np.cumsum(spent[::-1])[::-1]  # during the time of each bin and all higher ones
        place = np.flatnonzero(above >= duration)[-1]
        share = (above[place] - duration) / spent[place]
        assert force == pytest.approx(EDGES[place] + share * WIDTHS[place], rel=1e-9)


def test_a_sum_that_is_not_finite_is_found():
    arrays = {name: np.zeros((1, 32, 2)) for name in ("histogram", "dry")}
    arrays |= {"account": np.zeros((1, 2)), "wear": np.zeros(2), "friction": np.zeros(2)}
    numbered = {"mechanism": MechanismTotals.zeros(), "joint": ContactTotals.zeros(1)}
    totals = SimpleNamespace(**arrays, **numbered, bins=np.full((1, BIN_COLUMNS), 3))
    totals.mechanism.speed_min = totals.joint[0].depth_max = math.inf  # before its first value
    assert has_finite_sums(totals)
    for array in (*arrays.values(), *(fields.numbers for fields in numbered.values())):
        array.flat[1] = math.nan
        assert not has_finite_sums(totals)
        array.flat[1] = 0.0
    totals.histogram[0, 16, 0] = math.nan  # far above the highest bin nothing is read
    assert has_finite_sums(totals)


@pytest.mark.parametrize(("first", "film", "pulling"), [(0.0, np.inf, 0.0), (-50.0, 1e-6, 1.0 / 3.0)])
def test_the_time_of_a_step_is_that_of_its_force_at_an_even_rate(first, film, pulling):
    """From `first` to 100 N; a film pulls where its force is negative, and that time is one without force."""
    profiles = np.array([np.full(PARTS + 1, 3.0), np.linspace(first, 100.0, PARTS + 1)])
    o = np.full((KAPPA + 1, NODES.max() + 1), 3.0)
    rows = {"profiles": profiles, "o": o, "mode": np.zeros(1), "film": np.array([[0.0, film]])}
    ledger = SimpleNamespace(bins=np.zeros((1, BIN_COLUMNS), int), part_times=np.zeros((1, PART_TIME_ROWS, PARTS)))
    add_force_profile(SimpleNamespace(**rows, totals=ledger), 0, 2.0)
    histogram = np.zeros((BINS, 2))
    add_ramps(histogram[np.newaxis], 0, ledger.bins[0], ledger.part_times[0, FIRST_BIN_TIME:])
    assert spent_in(histogram).sum() + ledger.part_times[0, PULLING_TIME].sum() == pytest.approx(2.0, rel=1e-12)
    assert ledger.bins[0, : PARTS + 1].max() == force_bin(100.0)
    assert not histogram[force_bin(100.0) + 1 :].any()
    for share in (0.9, 0.5, 0.1):
        exceeded = force_quantile(histogram, 2.0 * (1.0 - pulling) * share)
        assert exceeded == pytest.approx(100.0 * (1.0 - share), rel=1e-6)


def test_a_part_of_a_long_step_is_not_taken_for_a_ramp():
    """The force is a parabola over the step, and dt/dtau a straight line; the time above a force is known."""
    x = NODE_FRACTIONS
    o = np.zeros((2, NODES.max() + 1))
    o[0, NODES], o[1, NODES] = 1.0 + x, 1001.0 - 1600.0 * (x - 0.375) ** 2
    histogram, shares = np.zeros((1, BINS, 2)), TO_PART_MEANS.T @ o[0, NODES]
    assert shares == pytest.approx(1.0 + (np.arange(PARTS) + 0.5) / PARTS)
    sums, bins = np.zeros((FINE_ROWS + 2, 2, PARTS)), np.zeros((FINE_ROWS + 1, PARTS), int)
    write_fine_ramps(o, (0, 1), 2.0 / shares.sum(), sums, bins)
    for part in range(PARTS):
        add_fine_part(histogram, 0, part, sums, bins)
    assert bins[FINE_ROWS].max() == force_bin(1001.0)
    for force in (600.0, 900.0, 990.0):
        half = math.sqrt((1001.0 - force) / 1600.0)
        begin, end = max(0.375 - half, 0.0), min(0.375 + half, 1.0)
        above = 2.0 * (end - begin + 0.5 * (end**2 - begin**2)) / 1.5
        assert time_above(force, histogram[0]) == pytest.approx(above, rel=3e-3)  # as far as bins resolve it
        edge = EDGES[force_bin(force)]
        half = math.sqrt((1001.0 - edge) / 1600.0)
        begin, end = max(0.375 - half, 0.0), min(0.375 + half, 1.0)
        above = 2.0 * (end - begin + 0.5 * (end**2 - begin**2)) / 1.5
        assert time_above(edge, histogram[0]) == pytest.approx(above, rel=2e-3)  # 3 % by eight ramps


SAMPLES = 20_000  # as plain Python, more of them take minutes


@pytest.mark.parametrize("onset", ["first", "renewed"])
def test_p99_is_that_of_the_sampled_force_at_every_tolerance(onset):
    """Steps of a high order are long; a loose tolerance makes them longer."""
    changes = {
        "joints.rod-slider.clearance": 3e-4,
        "joints.rod-slider.contact.restitution": 0.1,
        "joints.rod-slider.contact.onset": onset,
        "joints.rod-slider.friction": {"law": "tanh", "coefficient": 0.05, "velocity_scale": 1e-3},
        "simulate.revolutions": 0.5,
        "simulate.discard": 0.25,
    }
    percentiles = []
    for tolerance in (1e-3, 1e-6, 1e-9):
        source = slider_crank("rod-slider", changes=changes | {"simulate.tolerance": tolerance})
        scene = clearsweep.load_case(source)
        turn = 2.0 * math.pi / scene.value.reference_rate
        times = turn * (0.25 + 0.25 * (np.arange(SAMPLES) + 0.5) / SAMPLES)
        result = clearsweep.simulate(scene, times=times)
        sampled = np.sort(result["joints/rod_slider/force_normal"])[99 * SAMPLES // 100]
        percentiles.append(result.summary["rod_slider_force_p99"])
        assert percentiles[-1] == pytest.approx(sampled, rel=1e-3)
    assert percentiles[1] == pytest.approx(percentiles[2], rel=2e-5)
