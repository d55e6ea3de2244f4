"""Motion on the page: its kinds, the tables of peaks, the revolution of the largest."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ...answers.figure_sentences import motions_of
from ...contracts.catalogue import STARTS
from ...contracts.layout import DIFFERENCE
from ...language import wording
from ...simulation import random_places
from ..axis import PEAK, Axis
from ..blocks.section import (
    FLAT_SIZE,
    SQUARE_SIZE,
    Block,
    Detail,
    Gallery,
    Note,
    Picture,
    Points,
    Section,
    Sentences,
    capitalise,
    section,
)
from ..blocks.table import CaseRows, Quantity, Table, case_table, columns_in_table, columns_of, count_cell
from ..draw import (
    BLUE,
    GREY,
    INK,
    PALE,
    RED,
    draw_colour_bar,
    label_values,
    set_log_scale,
    set_plain_axes,
)
from ..draw.comparison import KIND_COLOURS, LEGEND, draw_kinds
from ..effects import main_effects_of
from ..motion import (
    CONTACTS,
    MIN_POINTS,
    PERIODS,
    SHORT_CONTACT,
    Spectrum,
    classify_motion,
    harmonic_spectrum,
    poincare_points,
    points_along_axis,
    shares_by_value,
)
from ..one_case.motion import JointHistory, history_of, joint_histories, largest_texts, saved_channels
from ..plot import Axes, ColourScale, round_ticks
from ..study import Joint, Study, answer_of_study, cases_by_cell, reduce_over_other_axes, words_of

# Kinds of motion: contact, flight or impacts; periodic or not; Poincaré sections and spectra.

MAX_DIAGRAMS = 4  # along which journals are drawn, at most
MIN_CASES = 3  # cases that make a diagram
MAX_BARS = 30  # values of an axis whose shares are drawn side by side
POINCARE_NOTE = (
    "These pictures show the journal at crank angle 0 of every revolution of the recorded window. A motion with a "
    "period of n revolutions appears as n points, and irregular motion as a cloud."
)
SMALL_SIZE = (3.5, 2.9)  # inches
MOTION_COLOURS = (BLUE, RED, INK, GREY)  # of motions that coexist
SHARE_COLOURS = {"free flight": "#f0c48c", "impacts": "#e0824a", "lasting contact": "#86b8dc", "contact": "#86b8dc"}
MAX_ORDER = 40  # crank orders shown in a spectrum
PIXEL = 0.75  # points: a pixel of a screen
MIN_AMPLITUDE = 1e-5  # of the largest amplitude, lower limit of the drawing of a spectrum


def motion_type_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no drive turns the mechanism or no case finished."""
    joint = study.most_loaded_joint()
    if study.cases.empty or study.is_start_up or not study.is_driven or not study.has(joint.column("contact_fraction")):
        return []
    note = "The period is the number of revolutions after which the force repeats. Irregular motion has no such period."
    if not _is_lubricated(study, joint):
        joint_text = study.joint_text(joint, " of joint {}")
        note = f"Contacts{joint_text} count as impacts if they last at most {SHORT_CONTACT:g}° of crank angle. {note}"
    sections = [*_bifurcation_diagrams(study, joint), *basins(study, joint)]
    sections += [*_poincare_sections(study, joint), *_spectra(study, joint)]
    maps = Gallery(note, [*_maps(study, joint), *_share_pictures(study, joint)], small=True)
    blocks: list[Block] = [maps, _table(study, joint), Gallery(POINCARE_NOTE, sections)]
    return section("motion-type", "Impacts and kinds of motion", *blocks)


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
    of_joint = classify_motion(study, joint)
    kind_values = [("Contact", of_joint.contact, CONTACTS), ("Period", of_joint.period, PERIODS)]
    for name, values, words in kind_values[_is_lubricated(study, joint) :]:
        valid = np.where(values < 0, np.nan, values)
        if np.isfinite(valid).any():
            maps.append(
                _kind_map(f"{name}: {x_axis.name} {wording.TIMES} {y_axis.name}", study, valid, (x_axis, y_axis), words)
            )
    caption = "Each cell is one case."
    if others:
        over = wording.sentence_list(others)
        caption = f"Each cell shows the most irregular motion over {over} and the number of such cases."
    return [picture._replace(caption=caption) for picture in maps]


def _kind_map(title: str, study: Study, values: np.ndarray, axes: tuple[Axis, Axis], words: tuple[str, ...]) -> Picture:
    table = reduce_over_other_axes(study, values, axes, np.max)
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
        lambda ax: draw_kinds(ax, table, np.reshape(most_irregular_counts, table.shape), axes, words),
        SMALL_SIZE,
    )


def _share_pictures(study: Study, joint: Joint) -> list[Picture]:
    """Return the shares of time and of periods over the axis with the largest effect on the force."""
    ranked_axes = [effect.axis for effect in main_effects_of(study, joint.column(study.lead.figure))]
    axis = next((axis for axis in ranked_axes if len(axis.values) <= MAX_BARS), None)
    if axis is None:
        return []
    names, rows = shares_by_value(study, joint, axis)
    shown_axis = axis._replace(values=tuple(row[0] for row in rows))
    shares = np.array([row[2:] for row in rows], float).T
    times, periods = shares[: len(names)], shares[len(names) :]
    pictures = []
    if not _is_lubricated(study, joint):
        pictures.append(_share_bars("Share of time", shown_axis, times, names, [SHARE_COLOURS[name] for name in names]))
    if periods.any():
        pictures.append(_share_bars("Cases by period", shown_axis, periods, PERIODS, KIND_COLOURS))
    return pictures


def _share_bars(title: str, axis: Axis, shares: np.ndarray, names: Sequence[str], colours: Sequence[str]) -> Picture:
    """Return stacked bars of shares, (names, values of the axis), one bar per value."""
    means = "; ".join(f"{name} {wording.percent_text(share.mean())}" for name, share in zip(names, shares, strict=True))

    def paint(ax: Axes) -> None:
        positions, bottom = np.arange(len(axis.values), dtype=float), np.zeros(len(axis.values))
        for share, name, colour in zip(shares, names, colours, strict=True):
            ax.bar(positions, 100.0 * share, 0.86, bottom, color=colour, label=name)
            bottom += 100.0 * share
        label_values(ax.xaxis, axis, positions)
        ax.set_labels(axis.label(), "share [%]")
        ax.set_ylim(0.0, 100.0)
        set_plain_axes(ax)
        ax.set_legend("above", columns=4, **LEGEND)

    note = "Each bar is the mean of all cases with that value."
    return Picture(f"{title} over {axis.name}", note, f"{title} over {axis.name}; in all {means}.", paint, SMALL_SIZE)


def _table(study: Study, joint: Joint) -> Table:
    """Return the shares for each value of every axis."""
    rows, time_names = [], list[str]()
    for axis in study.levels():
        names, counts = shares_by_value(study, joint, axis)
        time_names = [] if _is_lubricated(study, joint) else names
        for value, cases, *values in counts:
            shares = (Quantity(share, wording.percent_text(share)) for share in values[len(names) - len(time_names) :])
            rows.append((axis.name, Quantity(value, axis.text(value)), count_cell(cases), *shares))
    shares_of_period = (*(f"period {name}" for name in PERIODS[:3]), PERIODS[3])
    columns = columns_of(" | ".join(("axis", "value", "cases", *time_names, *shares_of_period)))
    note = "Each row gives mean shares of the time and shares of the periods, over all cases with that value."
    return Table("kinds_of_motion", "Kinds of motion", note, columns, rows)


def _bifurcation_diagrams(study: Study, joint: Joint) -> list[Picture]:
    """Return the diagrams along the numeric axes, the one with the largest effect on the force first."""
    lead = joint.column(study.lead.figure)
    reference = study.worst(joint)
    ranked = [effect.axis for effect in main_effects_of(study, lead)]
    ranked += [axis for axis in study.swept() if axis.is_scattered]
    diagrams = [
        _bifurcation_diagram(study, joint, axis, reference)
        for axis in ranked
        if axis.is_numeric and axis.path not in STARTS
    ]
    return [picture for diagram in [each for each in diagrams if each][:MAX_DIAGRAMS] for picture in diagram]


def _bifurcation_diagram(study: Study, joint: Joint, axis: Axis, reference: str) -> list[Picture]:
    """Return the diagrams of x and y of a journal along an axis, or [] with too few cases."""
    points = points_along_axis(study, joint, axis, reference)
    if points.cases < MIN_CASES:
        return []
    abscissae, down = axis.scale.from_si(points.value), points.is_downward
    branches = (("up", BLUE, ~down), ("down", RED, down)) if down.any() else (("", INK, ~down),)

    def paint(ax: Axes, coordinate: str, values: np.ndarray) -> None:
        scale = wording.scale("m", [*np.abs(values), *points.clearance])
        if np.isfinite(points.clearance).all():
            for sign in (-1.0, 1.0):
                ax.plot(abscissae, sign * points.clearance / scale.factor, color=GREY, linewidth=0.8, linestyle=":")
        for name, colour, is_drawn in branches:
            marks = abscissae[is_drawn], values[is_drawn] / scale.factor
            ax.plot(*marks, "o", color=colour, markersize=PIXEL if not name else 3.0 * PIXEL, label=name)
        if axis.is_geometric:
            set_log_scale(ax, "x")
        ax.set_labels(axis.label(), f"journal {coordinate} [{scale.unit}]")
        set_plain_axes(ax)
        if down.any():
            ax.set_legend("above", columns=2, **LEGEND)

    fixed_setting = study.setting(reference, omitted_axis=axis) if not axis.is_scattered else ""
    return [
        Picture(
            f"Bifurcation diagram of {coordinate} over {axis.name}{study.joint_text(joint, ', joint {}')}",
            f"{f'At {fixed_setting}. ' if fixed_setting else ''}The dotted lines are the clearance.",
            f"Journal {coordinate} at crank angle 0 over {axis.name}: {points.x.size} points of {points.cases} cases.",
            partial(paint, coordinate=coordinate, values=values),
            FLAT_SIZE,
        )
        for coordinate, values in (("x", points.x), ("y", points.y))
    ]


def _poincare_sections(study: Study, joint: Joint) -> list[Picture]:
    """Return the Poincaré section of the most loaded case: positions and velocities, coloured by the revolution."""
    case_id = study.worst(joint)
    points = poincare_points(study, joint, case_id)
    if len(points.get("x", ())) < MIN_POINTS:
        return []
    revolution, x, y, vx, vy = (points[name].astype(float) for name in ("revolution", "x", "y", "vx", "vy"))
    clearance = study.radial_clearance(case_id, joint)

    def paint(ax: Axes, names: str, across: np.ndarray, up: np.ndarray, scale: wording.Scale) -> None:
        colours = ColourScale(float(revolution.min()), float(revolution.max()))
        ax.scatter(across / scale.factor, up / scale.factor, size=3.7, values=revolution, scale=colours, zorder=3)
        draw_colour_bar(ax, colours, "revolution", integers_only=True)
        for side, name in zip((ax.xaxis, ax.yaxis), names.split(), strict=True):
            side.tick_rule, side.label = round_ticks(5), f"journal {name} [{scale.unit}]"

    def paint_positions(ax: Axes) -> None:
        scale = wording.scale("m", [*np.abs(x), *np.abs(y), clearance])
        if clearance is not None:
            ax.circle((0.0, 0.0), float(clearance) / scale.factor, facecolor="#f3f6f9", edgecolor=INK, zorder=0)
        paint(ax, "x y", x, y, scale)
        ax.set_square(1.08 * max(float(np.hypot(x, y).max()), clearance or 0.0) / scale.factor)

    def paint_velocities(ax: Axes) -> None:
        paint(ax, "vx vy", vx, vy, wording.scale("m/s", [*np.abs(vx), *np.abs(vy)]))
        set_plain_axes(ax)

    joint_text, count = study.joint_text(joint, ", joint {}"), wording.count_text(len(x), "revolution")
    return [
        Picture(
            f"Poincaré section: {name}{joint_text}",
            "The worst case.",
            f"{capitalise(name)} of the journal of the worst case at crank angle 0, {count}.",
            draw,
            SQUARE_SIZE,
        )
        for name, draw in (("positions", paint_positions), ("velocities", paint_velocities))
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
        actual = harmonic_spectrum(history.angle, curve.actual) if curve.name in curve_names else None
        if actual is None or not actual.amplitude.any():
            continue
        ideal = None if curve.ideal is None else harmonic_spectrum(history.angle, curve.ideal)
        spectra.append(_spectrum(curve.name, curve.unit, actual, ideal))
    return spectra


def _spectrum(name: str, unit: str, actual: Spectrum, ideal: Spectrum | None) -> Picture:
    """Return amplitudes (SI) over the crank's orders, its harmonics marked, and those of the ideal mechanism."""
    strongest_order, max_amplitude = float(actual.order[actual.amplitude.argmax()]), float(actual.amplitude.max())

    def paint(ax: Axes) -> None:
        scale = wording.scale(unit, max_amplitude)
        in_range = actual.order <= MAX_ORDER
        ax.vlines(np.arange(1, MAX_ORDER + 1), 0.0, 1.0, color=PALE, linewidth=0.5, spans_height=True)
        floor = MIN_AMPLITUDE * max_amplitude / scale.factor
        heights = actual.amplitude[in_range] / scale.factor
        orders, tops = actual.order[in_range], heights.clip(min=floor)
        ax.vlines(orders, floor, tops, color=BLUE, linewidth=1.1, label="with clearance")
        if ideal is not None:
            is_drawn = (ideal.order <= MAX_ORDER) & (ideal.amplitude > MIN_AMPLITUDE * max_amplitude)
            heights = ideal.amplitude[is_drawn] / scale.factor
            ax.plot(ideal.order[is_drawn], heights, "_", color=RED, markersize=6, label="ideal")
            ax.set_legend("above", columns=2, **LEGEND)
        ax.set_log("y")
        ax.set_xlim(0.0, MAX_ORDER + 0.5)
        ax.set_ylim(floor, 3.0 * max_amplitude / scale.factor)
        ax.set_labels("order of the crank [1 / turn]", f"amplitude of {name} [{scale.unit}]")
        ax.hide_edges("top", "right")

    return Picture(
        f"Spectrum of {name}",
        f"Worst case, {wording.count_text(actual.revolutions, 'revolution')}. Pale lines are harmonics of the crank.",
        f"{capitalise(name)} over orders of the crank; largest amplitude {wording.quantity_text(max_amplitude, unit)} "
        f"at order {strongest_order:g}.",
        paint,
        FLAT_SIZE,
    )


# Tables of the figures of every finished case: forces of each joint, output and drive, and their accuracy.

HORIZON, PEAK_REVOLUTION = "horizon_revolutions", "force_peak_revolution"
MAX_CHECKED_FIGURES = 3  # figures of a joint whose error is shown if the grid requests it: the first ones


def peak_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    if study.is_driven:
        blocks.append(
            Note(
                "The peak is the largest force of the window; median and 95 % quantile are those of the peaks of its "
                "revolutions. They are equal if every revolution of the window is the same; a window that begins "
                "before the motion is periodic also contains its run-in. The load is the resultant of normal and "
                "friction force. p99 is exceeded during 1 % of the time, so it ignores shorter impacts. The ideal peak "
                "is the largest reaction of the same joint without clearance."
            )
        )
    # Figures of output and drive, or the measured restitution
    columns, output = columns_in_table(study, "output"), study.run.layout.output
    key, title = ("drive", "The drive") if study.is_driven else ("restitution", "Measured restitution")
    if output:
        key, title = output, f"{capitalise(output)} and drive"
    mechanism_table = case_table(study, key, title, columns, columns[0][0] if columns else "")
    tables = [*(_force_table(study, joint) for joint in study.joints), mechanism_table]
    return section("peaks", "Peaks", *blocks, *tables, Points(_error_check_sentences(study)), _accuracy_table(study))


def _force_table(study: Study, joint: Joint) -> Table:
    """Return forces and impacts of one joint, the largest force peak first."""
    lead, title = joint.column(PEAK.figure), f"Forces in joint {joint.title}"
    return case_table(study, f"peaks_{joint.name}", title, columns_in_table(study, "forces", joint), lead)


def _accuracy_table(study: Study) -> Table:
    """Return the accuracy of figures; empty unless the grid requests it."""
    columns, until_column = columns_in_table(study, "certainty"), study.run.layout.until
    if until_column:
        columns.insert([column for column, _ in columns].index("figure_ci"), (until_column, until_column))
    for joint in study.joints:
        for column, name in columns_in_table(study, "forces", joint)[:MAX_CHECKED_FIGURES]:
            columns.append((column + DIFFERENCE, f"error of {name}{study.joint_text(joint, ' ({})')}"))
    sort_column = next((column for column, _ in columns if study.has(column)), "")
    table = case_table(study, "certainty", "How certain the figures are", columns, sort_column)
    headings = [column.name for column in table.columns]
    for joint, text_of_case in _beyond_horizon(study):
        heading = f"error of force peak{study.joint_text(joint, ' ({})')}"
        if heading in headings and isinstance(table.rows, CaseRows):
            table.rows.texts[headings.index(heading)] = text_of_case
    return table._replace(
        note=f"{table.note} The error is the difference from a run at a tenth of the tolerance. The horizon is the "
        "number of revolutions after which two such runs are two samples of a chaotic motion. The error is meaningful "
        "only before the horizon."
    )


def _beyond_horizon(study: Study) -> list[tuple[Joint, dict[str, str]]]:
    """Return why the error of a force peak is meaningless: joint, and case_id -> text."""
    if not study.has(HORIZON):
        return []
    horizon, reasons = study.cases[HORIZON], []
    for joint in study.joints:
        revolution_column = joint.column(PEAK_REVOLUTION)
        if study.has(revolution_column):
            revolutions = study.cases[revolution_column]
            text_of_case = {
                study.cases.index[row]: f"peak in revolution {revolutions[row]:.0f}, horizon "
                f"{wording.number_text(horizon[row], 2)} "
                "revolutions: the error does not check convergence"
                for row in np.flatnonzero(revolutions > horizon)
            }
            reasons.append((joint, text_of_case))
    return reasons


def _error_check_sentences(study: Study) -> list[str]:
    """Return the numbers of cases in which the error of the largest force is meaningful, and in which it is not."""
    points = []
    for joint, beyond in _beyond_horizon(study):
        chaotic_count = int(np.count_nonzero(~np.isnan(study.cases[HORIZON])))
        joint_text = study.joint_text(joint, " in joint {}")
        if beyond:
            case_id, text = next(iter(beyond.items()))
            points.append(
                f"The error of the force peak{joint_text} does not check convergence in {len(beyond)} of "
                f"{wording.count_text(len(study.cases), 'case')}, because their peak lies beyond the horizon. An "
                f"example is case {wording.short_id(case_id)} ({text.partition(':')[0]})."
            )
        if chaotic_count > len(beyond):
            points.append(
                f"In {wording.count_text(chaotic_count - len(beyond), 'chaotic case')} the peak{joint_text} lies "
                "within the horizon: the error checks only these first revolutions."
            )
    return points


# The revolution of the peak: force, acceleration and torque of the worst cases, with and without clearance.

NOTE_ON_CASES = (
    "Each case is shown over the revolution with its largest normal force. The cases are those with the largest load "
)
NOTE_ON_FORCES = "divided by the largest reaction without clearance. Dashed lines show the mechanism without clearance."


def peak_revolution_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no such revolution was saved."""
    saved = [case_id for case_id in study.run.worst if study.cases.row_of(case_id) >= 0]  # no checks of laws
    if not saved:
        return []
    blocks: list[Block] = [Sentences([NOTE_ON_CASES + NOTE_ON_FORCES])]
    blocks += [_case_detail(study, rank, case_id) for rank, case_id in enumerate(saved, start=1)]
    return [Section("peak-revolution", "Revolution of the peak", blocks)]


def _case_detail(study: Study, rank: int, case_id: str) -> Detail:
    """Return one case: its peak, and the histories around it."""
    channels = study.run.peak_revolution(case_id)
    joint = study.joint(channels.attrs["joint"])
    history = history_of(study, case_id, channels)
    pictures = [
        _picture(curve, history.painter(curve.actual, curve.unit, curve.name, curve.ideal))
        for curve in joint_histories(study, case_id, history)
    ]
    figures = [(name, study.text(case_id, column)) for column, name in columns_in_table(study, "case", joint)]
    label = f"Worst case {rank}" if len(study.run.worst) > 1 else "Worst case"
    # Revolution and the place in it of the largest sample of the force
    facts = [
        ("joint", joint.title),
        ("revolution", f"{channels.attrs['turns']:.4g} to {channels.attrs['turns'] + 1.0:.4g}"),
    ]
    if history.angle is not None:
        degrees = np.degrees(history.angle[int(np.argmax(channels[f"joints/{joint.name}/force_normal"]))]) % 360.0
        facts.append(("peak at", f"{degrees:.1f}{wording.BLANK}°"))
    return Detail(label, case_id, study.setting(case_id), [*facts, *figures], pictures)


def _picture(curve: JointHistory, paint: Callable[[Axes], None]) -> Picture:
    """Return one quantity over the revolution."""
    largest_text, *ideal_text = largest_texts([curve.actual, curve.ideal], curve.unit)
    alt = f"{capitalise(curve.name)} over the revolution of the peak, at most {largest_text} among the samples"
    if ideal_text:
        alt += f"; without clearance {ideal_text[0]}"
    return Picture(capitalise(curve.name), "", f"{alt}.", paint, FLAT_SIZE)


def basins(study: Study, joint: Joint) -> list[Picture]:
    """Return the picture of the random starts of a point with several motions, if one joint is open."""
    points = (answer_of_study(study).get("branches") or {}).get("motions") or []
    joints = study.base.get("joints", {})
    if not points or len(joints) != 1 or STARTS[1] not in study.cases:
        return []
    point = max(points, key=lambda each: len(each["motions"]))
    rows = np.ones(len(study.cases), bool)
    for path, value in point["values"].items():
        rows &= study.cases[path] == value
    columns = [joint.column(f"force_peak_median{end}") for end in ("", "_low", "_high")]
    statistic = np.stack([study.cases[column][rows] for column in columns], -1)
    is_known = np.isfinite(statistic).all(axis=1)
    has_flanks = any(key in joints[joint.title] for key in ("backlash", "play"))
    draws, seed = study.cases[STARTS[1]][rows][is_known], study.base["simulate"]["seed"]
    starts = [np.concatenate(random_places(int(seed), int(draw), [has_flanks])) for draw in draws]
    flanks, journal = ("position [play / 2]", "rate [play / 2 x crank speed]"), ("journal x [c]", "journal y [c]")
    names = flanks if has_flanks else journal
    motions = motions_of(statistic[is_known])
    setting = words_of(study).setting(point["values"])
    rates = "" if has_flanks else " Their rates are random, too, so the colours may mix."
    labels = [words_of(study).figures(columns[0], [motion["median"]])[0] for motion in point["motions"]]
    places = np.array(starts)[:, :2]

    def paint(ax: Axes) -> None:
        for motion, label in enumerate(labels):
            of_motion, colour = places[motions == motion], MOTION_COLOURS[motion % len(MOTION_COLOURS)]
            ax.plot(of_motion[:, 0], of_motion[:, 1], "o", color=colour, markersize=3.0, label=label)
        ax.set_square(1.08)
        ax.set_labels(*names)
        ax.set_legend("above", columns=2, **LEGEND)

    return [
        Picture(
            f"Random starts and their motions{study.joint_text(joint, ', joint {}')}",
            f"At {setting}. The colours are the medians of the force peaks of the motions.{rates}",
            f"{len(starts)} random starts, coloured by {len(labels)} motions.",
            paint,
            SQUARE_SIZE,
        )
    ]
