"""Motion of cases: kinds and periods, journals once per revolution, harmonics of the crank."""

import itertools
from typing import NamedTuple

import numpy as np

from ..contracts.catalogue import STARTS
from .axis import Axis
from .study import VARYING_SECTIONS, Joint, Study, indices_by_value, recorded_revolutions

# The kind of motion of each case: contact of its journal, and the number of revolutions of its period.

SHORT_CONTACT = 10.0  # degrees of the crank: a shorter contact is an impact
CONTACTS = ("continuous contact", "contact and flight", "impacts", "free flight")
PERIODS = ("1", "2", "n", "irregular")


class Kinds(NamedTuple):
    """The kinds of some cases, (n,) each; -1 if unknown."""

    contact: np.ndarray  # index in CONTACTS
    period: np.ndarray  # index in PERIODS
    flight: np.ndarray  # share of the window's time
    impact: np.ndarray  # the same for contacts shorter than SHORT_CONTACT; NaN without events
    lasting: np.ndarray  # for other contacts

    def shares(self) -> dict[str, np.ndarray]:
        """Return name -> share of the window's time, (n,) each; without events, all contacts are one share."""
        known = np.isfinite(self.impact)
        if not known.any():
            return {"free flight": self.flight, "contact": 1.0 - self.flight}
        lasting = np.where(known, self.lasting, 1.0 - self.flight)
        return {"free flight": self.flight, "impacts": np.where(known, self.impact, 0.0), "lasting contact": lasting}


def classify_motion(study: Study, joint: Joint) -> Kinds:
    """Return the kinds of all finished cases, by the contacts of one joint."""
    return study.cases.cached(("kinds", joint.name), lambda: _classify_motion(study, joint))


def _classify_motion(study: Study, joint: Joint) -> Kinds:
    contact_share = study.cases[joint.column("contact_fraction")]
    onsets = study.cases[joint.column("impacts_per_rev")]
    with np.errstate(all="ignore"):
        mean_duration = 360.0 * contact_share / onsets  # mean duration of a contact, degrees
    contact = _first_true(
        [contact_share == 0.0, onsets == 0.0, mean_duration < SHORT_CONTACT, np.isfinite(mean_duration)],
        [3, 0, 2, 1],
        -1,
    )
    impact = short_contacts(study, joint)
    lasting = np.clip(contact_share - impact, 0.0, None) if np.isfinite(impact).any() else impact
    period = np.full(len(study.cases), -1, np.int8)
    if "period" in study.cases:
        revolutions = study.cases["period"]
        period = _first_true([revolutions == 1.0, revolutions == 2.0, revolutions > 2.0], [0, 1, 2], 3)
    return Kinds(contact, period, 1.0 - contact_share, impact, lasting)


def _first_true(conditions: list[np.ndarray], codes: list[int], default: int) -> np.ndarray:
    """Return the index of the first true condition in each case, as a byte."""
    return np.select(conditions, list(map(np.int8, codes)), np.int8(default))


def short_contacts(study: Study, joint: Joint) -> np.ndarray:
    """Return the share of the window's time in contacts shorter than SHORT_CONTACT, for every finished case.

    It is NaN without events, for a free crank, and for joints with several contact points.
    """
    speed = study.base.get("drive", {}).get("speed")
    if "drive.speed" in study.cases:
        speed = study.cases["drive.speed"]
    count, contacts = len(study.cases), study.run.layout.contacts
    blocks = iter(study.run.event_blocks())
    block = next(blocks, None)
    if block is None or joint.name not in contacts or not np.issubdtype(np.asarray(speed).dtype, np.number):
        return np.broadcast_to(np.nan, count)  # takes no memory
    revolution_time = 2.0 * np.pi / np.abs(np.broadcast_to(np.asarray(speed, float), count))  # s
    discarded, recorded = recorded_revolutions(study.cases, study.base)
    window_start, is_selected = discarded * revolution_time, study.cases.selected
    short_time, first_case = np.zeros(count), 0
    for counts, events in itertools.chain((block,), blocks):
        selected = is_selected[first_case : first_case + len(counts)]
        first_case += len(counts)
        event_rows = np.flatnonzero(np.repeat(selected, counts) & (events["joint"] == contacts.index(joint.name)))
        case = np.repeat(np.cumsum(selected) - 1, counts)[event_rows] + int(
            is_selected[: first_case - len(counts)].sum()
        )
        t, is_separation = events["t"][event_rows], events["kind"][event_rows] == 1
        pair = np.flatnonzero(~is_separation[:-1] & is_separation[1:] & (case[:-1] == case[1:]))
        case, onset, separation = case[pair], t[pair], t[pair + 1]
        is_short = (separation - onset < SHORT_CONTACT / 360.0 * revolution_time[case]) & (
            separation > window_start[case]
        )
        case, onset, separation = case[is_short], onset[is_short], separation[is_short]
        short_time += np.bincount(case, separation - np.maximum(onset, window_start[case]), minlength=count)
    return short_time / (revolution_time * recorded)


def shares_by_value(study: Study, joint: Joint, axis: Axis) -> tuple[list[str], list[tuple]]:
    """Return the names of shares of time, and a row for each value of an axis.

    A row contains the value, the number of its cases, the means of their shares of time, the shares of PERIODS.
    """
    kinds, rows = classify_motion(study, joint), []
    times = kinds.shares()
    for value, cases in zip(axis.values, indices_by_value(study.indices_on(axis), len(axis.values)), strict=True):
        if len(cases):
            means = [float(share[cases].mean()) for share in times.values()]
            periods = [float(np.mean(kinds.period[cases] == code)) for code in range(len(PERIODS))]
            rows.append((value, len(cases), *means, *periods))
    return list(times), rows


# Journals once per revolution, at crank angle 0: along an axis of a run, and in one case.

MAX_CASES = 120  # cases along an axis: more do not increase the density in print
MIN_POINTS = 3  # points of a case that make a picture


class Points(NamedTuple):
    """Positions of a journal at crank angle 0 of each revolution of some cases, concatenated; (n,) each."""

    value: np.ndarray  # of the axis, SI
    x: np.ndarray  # m
    y: np.ndarray  # m
    clearance: np.ndarray  # m, of the case; NaN if not a circle
    cases: int
    is_downward: np.ndarray = np.zeros(0, bool)  # whether the case was reached down the axis


def poincare_points(study: Study, joint: Joint, case_id: str) -> dict[str, np.ndarray]:
    """Return x, y (m), vx, vy (m/s) and `revolution` of a journal at crank angle 0 in the recorded window of a case.

    They are {} if there are none.
    """
    points = study.run.section_columns(case_id)
    if not len(points.get("revolution", ())):
        return {}
    discarded, _ = recorded_revolutions(study.cases, study.base)
    is_recorded = points["revolution"] >= discarded[study.cases.row_of(case_id)]
    columns = {"revolution": "revolution"} | {name: f"{joint.name}/{name}" for name in ("x", "y", "vx", "vy")}
    return {name: points[column][is_recorded] for name, column in columns.items()} if is_recorded.any() else {}


def points_along_axis(study: Study, joint: Joint, axis: Axis, reference: str) -> Points:
    """Return the points of the cases along an axis that share all other values with the case `reference`."""
    values = study.cases[axis.path]
    indices = [index for index in cases_along_axis(study, axis, reference) if np.isfinite(values[index])]
    histories = [(index, poincare_points(study, joint, study.cases.index[index])) for index in indices]
    histories = [(index, points) for index, points in histories if points]
    clearances = [study.radial_clearance(study.cases.index[index], joint) for index, _ in histories]
    counts = [len(points["x"]) for _, points in histories]

    def concatenate(name: str) -> np.ndarray:
        return np.concatenate([np.empty(0), *(points[name] for _, points in histories)])

    directions = study.cases.get(STARTS[0], np.full(len(study.cases), ""))  # of a carried axis
    return Points(
        np.repeat(values[[index for index, _ in histories]], counts),
        concatenate("x"),
        concatenate("y"),
        np.repeat(np.array(clearances, float), counts),
        len(histories),
        np.repeat((directions == "down")[[index for index, _ in histories]], counts),
    )


def cases_along_axis(study: Study, axis: Axis, reference: str) -> list[int]:
    """Return the indices of at most MAX_CASES cases along an axis, by value; their other values are those of a case.

    For a drawn or parallel axis, the axes drawn or parallel with it vary as well.
    """
    # Paths whose values change together with an axis: parallel or drawn
    record = study.run.grid
    groups = [{*(record.get(section) or {})} for section in VARYING_SECTIONS if section in ("zip", "cases")]
    groups.append({*(record.get("sample") or {}).get("drawn", {})})
    varied_together = next((group for group in groups if axis.path in group), {axis.path})
    is_alike, reference_row = np.ones(len(study.cases), bool), study.cases.row_of(reference)
    for other in study.swept():
        if other is not axis and other.path not in (*varied_together, *STARTS):
            indices = study.indices_on(other)
            is_alike &= indices == indices[reference_row]
    rows = np.flatnonzero(is_alike)
    rows = rows[np.argsort(study.cases[axis.path][rows], kind="stable")]
    return rows[np.unique(np.linspace(0, len(rows) - 1, min(len(rows), MAX_CASES)).round().astype(int))].tolist()


# Harmonics of the crank in a history.

TURN = 2.0 * np.pi


class Spectrum(NamedTuple):
    """Amplitudes over the crank's orders (oscillations per revolution) of a history of full revolutions."""

    order: np.ndarray  # (n,) multiples of 1 / turns, starting there
    amplitude: np.ndarray  # (n,) in the unit of the history
    revolutions: int  # of the history: its last order is half of the samples of a turn


def harmonic_spectrum(angle: np.ndarray, values: np.ndarray) -> Spectrum | None:
    """Return the spectrum of values at equal steps of the crank angle (rad); None for less than a revolution.

    No window is applied: over full revolutions, periodic components are at integer orders only.
    """
    steps = len(angle) - 1
    if steps < 2 or not angle[-1] > angle[0]:
        return None
    samples_per_revolution = TURN * steps / (angle[-1] - angle[0])  # samples
    revolutions = int(np.floor(steps / samples_per_revolution + 1e-6))
    count = round(revolutions * samples_per_revolution)
    if revolutions < 1 or abs(count - revolutions * samples_per_revolution) > 1e-3:
        return None
    amplitudes = np.abs(np.fft.rfft(values[-count:])) * 2.0 / count
    if count % 2 == 0:
        amplitudes[-1] *= 0.5  # the highest order has no mirrored one
    return Spectrum(np.arange(1, len(amplitudes)) / revolutions, amplitudes[1:], revolutions)
