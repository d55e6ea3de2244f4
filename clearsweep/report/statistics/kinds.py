"""The kind of motion of each case: contact of its journal, and the number of revolutions of its period."""

import itertools
from typing import NamedTuple

import numpy as np

from ..data.axis import Axis
from ..data.study import Joint, Study, indices_by_value, recorded_revolutions

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
    contact_share = study.cases[joint.column("contact_fraction")].to_numpy(float)
    onsets = study.cases[joint.column("impacts_per_rev")].to_numpy(float)
    with np.errstate(all="ignore"):
        mean_duration = 360.0 * contact_share / onsets  # mean duration of a contact, degrees
    contact = _first_true(
        [contact_share == 0.0, onsets == 0.0, mean_duration < SHORT_CONTACT, np.isfinite(mean_duration)],
        [3, 0, 2, 1],
        -1,
    )
    impact = short_contacts(study, joint)
    lasting = np.clip(contact_share - impact, 0.0, None) if np.isfinite(impact).any() else impact
    return Kinds(contact, _periods(study), 1.0 - contact_share, impact, lasting)


def _periods(study: Study) -> np.ndarray:
    """Return the index in PERIODS of every finished case; -1 if unknown."""
    if "period" not in study.cases:
        return np.full(len(study.cases), -1, np.int8)
    period = study.cases["period"].to_numpy(float)
    return _first_true([period == 1.0, period == 2.0, period > 2.0], [0, 1, 2], 3)


def _first_true(conditions: list[np.ndarray], codes: list[int], default: int) -> np.ndarray:
    """Return the index of the first true condition in each case, as a byte."""
    return np.select(conditions, list(map(np.int8, codes)), np.int8(default))


def short_contacts(study: Study, joint: Joint) -> np.ndarray:
    """Return the share of the window's time in contacts shorter than SHORT_CONTACT, for every finished case.

    It is NaN without events, for a free crank, and for joints with several contact points.
    """
    speed = study.base.get("drive", {}).get("speed")
    if "drive.speed" in study.cases:
        speed = study.cases[
            "drive.speed"
        ].to_numpy()  # of a Series numpy requests attributes, which pandas looks up in ids
    count, contacts = len(study.cases), study.run.layout.contacts
    blocks = iter(study.run.event_blocks())
    block = next(blocks, None)
    if block is None or joint.name not in contacts or not np.issubdtype(np.asarray(speed).dtype, np.number):
        return np.broadcast_to(np.nan, count)  # takes no memory
    revolution_time = 2.0 * np.pi / np.broadcast_to(np.asarray(speed, float), count)  # s
    discarded, recorded = (part.to_numpy(float) for part in recorded_revolutions(study.cases, study.base))
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
