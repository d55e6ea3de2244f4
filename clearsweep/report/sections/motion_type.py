"""Kinds of motion: contact, flight or impacts; periodic or not; Poincaré sections and spectra."""

from collections.abc import Sequence

import numpy as np

from ...language import wording
from ..blocks.picture import Picture, capital
from ..blocks.section import Block, Gallery, Section, without_empty
from ..blocks.table import Column, Quantity, Table, count_cell
from ..data.axis import Axis
from ..data.study import Joint, Study, cells, largest, over_other_axes
from ..draw import kinds as draw
from ..one_case.motion import FLAT_SIZE, SQUARE_SIZE, history_of, joint_histories, saved_channels
from ..statistics import kinds, spectrum, strobe
from ..statistics.kinds import CONTACTS, PERIODS
from ..statistics.main_effects import main_effects_of

AXES = 4  # along which journals are drawn, at most
LEAST = 3  # cases that make a diagram
BARS = 30  # values of an axis whose shares are drawn side by side
SMALL = (3.5, 2.9)  # inches


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no drive turns the mechanism or no case finished."""
    joint = study.hardest_joint()
    if study.cases.empty or study.is_start_up or not study.is_driven or not study.has(joint.column("contact_fraction")):
        return []
    note = "The period is the number of revolutions after which the force repeats. Irregular motion has no such period."
    if not _lubricated(study, joint):
        where = study.joint_text(joint, " of joint {}")
        note = f"Contacts{where} count as impacts if they last at most {kinds.SHORT_CONTACT:g}° of crank angle. {note}"
    blocks: list[Block] = [
        Gallery(note, [*_maps(study, joint), *_shares(study, joint)], small=True),
        _table(study, joint),
        Gallery(_of_points(study), [*_diagrams(study, joint), *_once_a_turn(study, joint), *_spectra(study, joint)]),
    ]
    return [Section("motion-type", "Impacts and kinds of motion", without_empty(blocks))]


def _lubricated(study: Study, joint: Joint) -> bool:
    """Return whether a joint has a film, which carries the journal even while it does not touch the bearing."""
    return study.has(joint.column("film_thickness_min"))


def _maps(study: Study, joint: Joint) -> list[Picture]:
    """Return the maps of the least regular kind over the two axes with the largest effect on the leading figure."""
    ranked = [effect.axis for effect in main_effects_of(study, joint.column(study.lead.figure))][:2]
    if len(ranked) < 2:
        return []
    across, up = sorted(ranked, key=study.axes.index)
    others = [axis.name for axis in study.swept() if axis not in ranked]
    maps = []
    of_joint = kinds.of_joint(study, joint)
    drawn = [("Contact", of_joint.contact, CONTACTS), ("Period", of_joint.period, PERIODS)]
    for name, values, words in drawn[_lubricated(study, joint) :]:
        known = np.where(values < 0, np.nan, values)
        if np.isfinite(known).any():
            maps.append(_map(f"{name}: {across.name} {wording.TIMES} {up.name}", study, known, (across, up), words))
    several = (
        f"Each cell shows the most irregular motion over {wording.sentence_list(others)} and the number of such cases."
    )
    caption = several if others else "Each cell is one case."
    return [picture._replace(caption=caption) for picture in maps]


def _map(title: str, study: Study, values: np.ndarray, axes: tuple[Axis, Axis], words: tuple[str, ...]) -> Picture:
    table = over_other_axes(study, values, axes, largest)
    alike = [
        f"{int((values[cases] == values[cases].max()).sum())} of {len(cases)}" if len(cases) > 1 else ""
        for cases in cells(study, values, axes)
    ]
    counts = [f"{words[place]}: {int((table == place).sum())}" for place in range(len(words))]
    alt = f"Map, cells of each kind. {'; '.join(counts)}."
    return Picture(
        title, "", alt, lambda ax: draw.draw_kinds(ax, table, np.reshape(alike, table.shape), axes, words), SMALL
    )


def _shares(study: Study, joint: Joint) -> list[Picture]:
    """Return the shares of time and of periods over the axis with the largest effect on the force."""
    ranked = [effect.axis for effect in main_effects_of(study, joint.column(study.lead.figure))]
    axis = next((axis for axis in ranked if len(axis.values) <= BARS), None)
    if axis is None:
        return []
    names, rows = kinds.by_value(study, joint, axis)
    shown_axis = axis._replace(values=tuple(row[0] for row in rows))
    parts = np.array([row[2:] for row in rows], float).T
    times, periods = parts[: len(names)], parts[len(names) :]
    pictures = []
    if not _lubricated(study, joint):
        pictures.append(_bars("Share of time", shown_axis, times, names, [draw.SHARE_COLOURS[name] for name in names]))
    if periods.any():
        pictures.append(_bars("Cases by period", shown_axis, periods, PERIODS, draw.KIND_COLOURS))
    return pictures


def _bars(title: str, axis: Axis, parts: np.ndarray, names: Sequence[str], colours: Sequence[str]) -> Picture:
    mean = "; ".join(f"{name} {wording.percent(part.mean())}" for name, part in zip(names, parts, strict=True))
    return Picture(
        f"{title} over {axis.name}",
        "Each bar is the mean of all cases with that value.",
        f"{title} over {axis.name}; in all {mean}.",
        lambda ax: draw.draw_shares(ax, axis, parts, names, colours),
        SMALL,
    )


def _table(study: Study, joint: Joint) -> Table:
    """Return the shares for each value of every axis."""
    rows, times = [], list[str]()
    for axis in study.levels():
        names, counts = kinds.by_value(study, joint, axis)
        times = [] if _lubricated(study, joint) else names
        for value, cases, *parts in counts:
            shares = (Quantity(part, wording.percent(part)) for part in parts[len(names) - len(times) :])
            rows.append((axis.name, Quantity(value, axis.text(value)), count_cell(cases), *shares))
    heads = ("axis", "value", "cases", *times, *(f"period {name}" for name in PERIODS[:3]), PERIODS[3])
    note = "Each row gives mean shares of the time and shares of the periods, over all cases with that value."
    return Table("kinds_of_motion", "Kinds of motion", note, tuple(map(Column, heads)), rows)


def _of_points(study: Study) -> str:
    return (
        "These pictures show the journal at crank angle 0 of every revolution of the recorded window. A motion with a "
        "period of n revolutions appears as n points, and irregular motion as a cloud."
    )


def _diagrams(study: Study, joint: Joint) -> list[Picture]:
    """Return the diagrams along the numeric axes, the one with the largest effect on the force first."""
    lead = joint.column(study.lead.figure)
    reference = study.worst(joint)
    ranked = [effect.axis for effect in main_effects_of(study, lead)]
    ranked += [axis for axis in study.swept() if axis.is_scattered]
    diagrams = [_diagram(study, joint, axis, reference) for axis in ranked if axis.numeric]
    return [picture for picture in diagrams if picture][:AXES]


def _diagram(study: Study, joint: Joint, axis: Axis, reference: str) -> Picture | None:
    points = strobe.along_axis(study, joint, axis, reference)
    if points.cases < LEAST:
        return None
    fixed_setting = study.setting(reference, without=axis) if not axis.is_scattered else ""
    return Picture(
        f"Bifurcation diagram over {axis.name}{study.joint_text(joint, ', joint {}')}",
        f"{f'At {fixed_setting}. ' if fixed_setting else ''}The dotted lines are the clearance.",
        f"Journal at crank angle 0 against {axis.name}: {points.x.size} points of {points.cases} cases.",
        lambda ax: draw.draw_bifurcation(ax, points, axis),
        FLAT_SIZE,
    )


def _once_a_turn(study: Study, joint: Joint) -> list[Picture]:
    """Return the Poincaré section of the most loaded case: positions and velocities."""
    case_id = study.worst(joint)
    frame = strobe.of_case(study, joint, case_id)
    if len(frame) < strobe.MIN_POINTS:
        return []
    clearance = study.value(case_id, f"joints.{joint.title}.clearance")
    where, count = study.joint_text(joint, ", joint {}"), wording.count(len(frame), "revolution")
    revolution, x, y, vx, vy = (frame[name].to_numpy(float) for name in ("revolution", "x", "y", "vx", "vy"))
    circle = None if clearance is None else float(clearance)
    caption, alt = "The worst case.", f"of the worst case at crank angle 0, {count}."
    return [
        Picture(
            f"Poincaré section: positions{where}",
            caption,
            f"Positions of the journal {alt}",
            lambda ax: draw.draw_section(ax, revolution, x, y, circle),
            SQUARE_SIZE,
        ),
        Picture(
            f"Poincaré section: velocities{where}",
            caption,
            f"Velocities of the journal {alt}",
            lambda ax: draw.draw_velocities(ax, revolution, vx, vy),
            SQUARE_SIZE,
        ),
    ]


def _spectra(study: Study, joint: Joint) -> list[Picture]:
    """Return the spectra of the joint's force and the output's acceleration in the most loaded case."""
    case_id = study.worst(joint)
    path = saved_channels(study.run, case_id)
    saved = history_of(study, case_id, path) if path is not None else None
    if saved is None or saved.angle is None:
        return []
    wanted = (f"normal force{study.joint_text(joint, f', {joint.title}')}", f"{study.run.layout.output} acceleration")
    spectra = []
    for curve in joint_histories(study, case_id, saved):
        actual = spectrum.of_history(saved.angle, curve.actual) if curve.name in wanted else None
        if actual is None or not actual.amplitude.any():
            continue
        ideal = None if curve.ideal is None else spectrum.of_history(saved.angle, curve.ideal)
        spectra.append(_spectrum(curve.name, curve.unit, actual, ideal))
    return spectra


def _spectrum(name: str, unit: str, actual: spectrum.Spectrum, ideal: spectrum.Spectrum | None) -> Picture:
    strongest = float(actual.order[actual.amplitude.argmax()])
    most = wording.text(float(actual.amplitude.max()), unit)
    return Picture(
        f"Spectrum of {name}",
        f"Worst case, {wording.count(actual.revolutions, 'revolution')}. Pale lines are harmonics of the crank.",
        f"{capital(name)} over orders of the crank; largest amplitude {most} at order {strongest:g}.",
        lambda ax: draw.draw_spectrum(ax, actual, ideal, unit, name),
        FLAT_SIZE,
    )
