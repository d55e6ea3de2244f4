"""Kinds of motion: contact, flight or impacts; periodic or not; Poincaré sections and spectra."""

from collections.abc import Sequence

import numpy as np

from ...language import wording
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Block, Gallery, Section, without_empty
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.axis import Axis
from ..data.study import Joint, Study, cases_by_cell, largest, reduce_over_other_axes
from ..draw import kinds as draw
from ..one_case.motion import FLAT_SIZE, SQUARE_SIZE, history_of, joint_histories, saved_channels
from ..statistics import kinds, spectrum, strobe
from ..statistics.kinds import CONTACTS, PERIODS
from ..statistics.main_effects import main_effects_of

MAX_DIAGRAMS = 4  # along which journals are drawn, at most
MIN_CASES = 3  # cases that make a diagram
MAX_BARS = 30  # values of an axis whose shares are drawn side by side
SMALL_SIZE = (3.5, 2.9)  # inches


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no drive turns the mechanism or no case finished."""
    joint = study.most_loaded_joint()
    if study.cases.empty or study.is_start_up or not study.is_driven or not study.has(joint.column("contact_fraction")):
        return []
    note = "The period is the number of revolutions after which the force repeats. Irregular motion has no such period."
    if not _is_lubricated(study, joint):
        joint_text = study.joint_text(joint, " of joint {}")
        note = (
            f"Contacts{joint_text} count as impacts if they last at most {kinds.SHORT_CONTACT:g}° of crank angle. "
            f"{note}"
        )
    blocks: list[Block] = [
        Gallery(note, [*_maps(study, joint), *_share_pictures(study, joint)], small=True),
        _table(study, joint),
        Gallery(
            _poincare_note(study),
            [*_bifurcation_diagrams(study, joint), *_poincare_sections(study, joint), *_spectra(study, joint)],
        ),
    ]
    return [Section("motion-type", "Impacts and kinds of motion", without_empty(blocks))]


def _is_lubricated(study: Study, joint: Joint) -> bool:
    """Return whether a joint has a film, which carries the journal even while it does not touch the bearing."""
    return study.has(joint.column("film_thickness_min"))


def _maps(study: Study, joint: Joint) -> list[Picture]:
    """Return the maps of the least regular kind over the two axes with the largest effect on the leading figure."""
    ranked_axes = [effect.axis for effect in main_effects_of(study, joint.column(study.lead.figure))][:2]
    if len(ranked_axes) < 2:
        return []
    x_axis, y_axis = sorted(ranked_axes, key=study.axes.index)
    others = [axis.name for axis in study.swept() if axis not in ranked_axes]
    maps = []
    of_joint = kinds.classify_motion(study, joint)
    kind_values = [("Contact", of_joint.contact, CONTACTS), ("Period", of_joint.period, PERIODS)]
    for name, values, words in kind_values[_is_lubricated(study, joint) :]:
        valid = np.where(values < 0, np.nan, values)
        if np.isfinite(valid).any():
            maps.append(
                _kind_map(f"{name}: {x_axis.name} {wording.TIMES} {y_axis.name}", study, valid, (x_axis, y_axis), words)
            )
    caption_of_several = (
        f"Each cell shows the most irregular motion over {wording.sentence_list(others)} and the number of such cases."
    )
    caption = caption_of_several if others else "Each cell is one case."
    return [picture._replace(caption=caption) for picture in maps]


def _kind_map(title: str, study: Study, values: np.ndarray, axes: tuple[Axis, Axis], words: tuple[str, ...]) -> Picture:
    table = reduce_over_other_axes(study, values, axes, largest)
    most_irregular_counts = [
        f"{int((values[cases] == values[cases].max()).sum())} of {len(cases)}" if len(cases) > 1 else ""
        for cases in cases_by_cell(study, values, axes)
    ]
    count_texts = [f"{words[kind]}: {int((table == kind).sum())}" for kind in range(len(words))]
    alt = f"Map, cells of each kind. {'; '.join(count_texts)}."
    return Picture(
        title,
        "",
        alt,
        lambda ax: draw.draw_kinds(ax, table, np.reshape(most_irregular_counts, table.shape), axes, words),
        SMALL_SIZE,
    )


def _share_pictures(study: Study, joint: Joint) -> list[Picture]:
    """Return the shares of time and of periods over the axis with the largest effect on the force."""
    ranked_axes = [effect.axis for effect in main_effects_of(study, joint.column(study.lead.figure))]
    axis = next((axis for axis in ranked_axes if len(axis.values) <= MAX_BARS), None)
    if axis is None:
        return []
    names, rows = kinds.shares_by_value(study, joint, axis)
    shown_axis = axis._replace(values=tuple(row[0] for row in rows))
    shares = np.array([row[2:] for row in rows], float).T
    times, periods = shares[: len(names)], shares[len(names) :]
    pictures = []
    if not _is_lubricated(study, joint):
        pictures.append(
            _share_bars("Share of time", shown_axis, times, names, [draw.SHARE_COLOURS[name] for name in names])
        )
    if periods.any():
        pictures.append(_share_bars("Cases by period", shown_axis, periods, PERIODS, draw.KIND_COLOURS))
    return pictures


def _share_bars(title: str, axis: Axis, shares: np.ndarray, names: Sequence[str], colours: Sequence[str]) -> Picture:
    mean_text = "; ".join(
        f"{name} {wording.percent_text(share.mean())}" for name, share in zip(names, shares, strict=True)
    )
    return Picture(
        f"{title} over {axis.name}",
        "Each bar is the mean of all cases with that value.",
        f"{title} over {axis.name}; in all {mean_text}.",
        lambda ax: draw.draw_shares(ax, axis, shares, names, colours),
        SMALL_SIZE,
    )


def _table(study: Study, joint: Joint) -> Table:
    """Return the shares for each value of every axis."""
    rows, time_names = [], list[str]()
    for axis in study.levels():
        names, counts = kinds.shares_by_value(study, joint, axis)
        time_names = [] if _is_lubricated(study, joint) else names
        for value, cases, *values in counts:
            shares = (Quantity(share, wording.percent_text(share)) for share in values[len(names) - len(time_names) :])
            rows.append((axis.name, Quantity(value, axis.text(value)), count_cell(cases), *shares))
    headings = ("axis", "value", "cases", *time_names, *(f"period {name}" for name in PERIODS[:3]), PERIODS[3])
    note = "Each row gives mean shares of the time and shares of the periods, over all cases with that value."
    return Table("kinds_of_motion", "Kinds of motion", note, tuple(map(Column, headings)), rows)


def _poincare_note(study: Study) -> str:
    return (
        "These pictures show the journal at crank angle 0 of every revolution of the recorded window. A motion with a "
        "period of n revolutions appears as n points, and irregular motion as a cloud."
    )


def _bifurcation_diagrams(study: Study, joint: Joint) -> list[Picture]:
    """Return the diagrams along the numeric axes, the one with the largest effect on the force first."""
    lead = joint.column(study.lead.figure)
    reference = study.worst(joint)
    ranked = [effect.axis for effect in main_effects_of(study, lead)]
    ranked += [axis for axis in study.swept() if axis.is_scattered]
    diagrams = [_bifurcation_diagram(study, joint, axis, reference) for axis in ranked if axis.is_numeric]
    return [picture for picture in diagrams if picture][:MAX_DIAGRAMS]


def _bifurcation_diagram(study: Study, joint: Joint, axis: Axis, reference: str) -> Picture | None:
    points = strobe.points_along_axis(study, joint, axis, reference)
    if points.cases < MIN_CASES:
        return None
    fixed_setting = study.setting(reference, omitted_axis=axis) if not axis.is_scattered else ""
    return Picture(
        f"Bifurcation diagram over {axis.name}{study.joint_text(joint, ', joint {}')}",
        f"{f'At {fixed_setting}. ' if fixed_setting else ''}The dotted lines are the clearance.",
        f"Journal at crank angle 0 against {axis.name}: {points.x.size} points of {points.cases} cases.",
        lambda ax: draw.draw_bifurcation(ax, points, axis),
        FLAT_SIZE,
    )


def _poincare_sections(study: Study, joint: Joint) -> list[Picture]:
    """Return the Poincaré section of the most loaded case: positions and velocities."""
    case_id = study.worst(joint)
    frame = strobe.poincare_points(study, joint, case_id)
    if len(frame) < strobe.MIN_POINTS:
        return []
    clearance = study.value(case_id, f"joints.{joint.title}.clearance")
    joint_text, count = study.joint_text(joint, ", joint {}"), wording.count_text(len(frame), "revolution")
    revolution, x, y, vx, vy = (frame[name].to_numpy(float) for name in ("revolution", "x", "y", "vx", "vy"))
    circle = None if clearance is None else float(clearance)
    caption, alt = "The worst case.", f"of the worst case at crank angle 0, {count}."
    return [
        Picture(
            f"Poincaré section: positions{joint_text}",
            caption,
            f"Positions of the journal {alt}",
            lambda ax: draw.draw_section(ax, revolution, x, y, circle),
            SQUARE_SIZE,
        ),
        Picture(
            f"Poincaré section: velocities{joint_text}",
            caption,
            f"Velocities of the journal {alt}",
            lambda ax: draw.draw_velocities(ax, revolution, vx, vy),
            SQUARE_SIZE,
        ),
    ]


def _spectra(study: Study, joint: Joint) -> list[Picture]:
    """Return the spectra of the joint's force and the output's acceleration in the most loaded case."""
    case_id = study.worst(joint)
    channels = saved_channels(study.run, case_id)
    history = history_of(study, case_id, channels) if channels is not None else None
    if history is None or history.angle is None:
        return []
    curve_names = (
        f"normal force{study.joint_text(joint, f', {joint.title}')}",
        f"{study.run.layout.output} acceleration",
    )
    spectra = []
    for curve in joint_histories(study, case_id, history):
        actual = spectrum.harmonic_spectrum(history.angle, curve.actual) if curve.name in curve_names else None
        if actual is None or not actual.amplitude.any():
            continue
        ideal = None if curve.ideal is None else spectrum.harmonic_spectrum(history.angle, curve.ideal)
        spectra.append(_spectrum(curve.name, curve.unit, actual, ideal))
    return spectra


def _spectrum(name: str, unit: str, actual: spectrum.Spectrum, ideal: spectrum.Spectrum | None) -> Picture:
    strongest_order = float(actual.order[actual.amplitude.argmax()])
    amplitude_text = wording.quantity_text(float(actual.amplitude.max()), unit)
    return Picture(
        f"Spectrum of {name}",
        f"Worst case, {wording.count_text(actual.revolutions, 'revolution')}. Pale lines are harmonics of the crank.",
        f"{capitalise(name)} over orders of the crank; largest amplitude {amplitude_text} at order "
        f"{strongest_order:g}.",
        lambda ax: draw.draw_spectrum(ax, actual, ideal, unit, name),
        FLAT_SIZE,
    )
