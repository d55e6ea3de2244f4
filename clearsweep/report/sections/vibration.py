"""Vibration on the page: the shaking force, its orders, waterfalls, envelopes, and velocities in zones."""

import itertools
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from ... import simulation
from ...contracts.vibration import BEARING_PARTS, NO_SEVERITY, SEVERITIES, ZONES, zone_of
from ...language import wording
from ..axis import Axis
from ..blocks.section import FLAT_SIZE, SQUARE_SIZE, Gallery, Picture, Section, section
from ..blocks.table import Table, case_table, columns_in_table
from ..draw import BLUE, GREY, ORANGE, RED, draw_colour_bar, label_values, label_with_unit, set_plain_axes
from ..draw.comparison import MAP_SIZE, draw_kinds
from ..effects import main_effects_of
from ..one_case.motion import saved_channels
from ..plot import Axes, ColourScale
from ..study import Study, known, reduce_over_other_axes, resolve_cases

PEAK = "frame_force_peak"
NOTE = (
    "The force on the frame is minus the sum of m (a - g) of all bodies; the frame reacts every load unless `reacted: "
    "false`. Spectra are those of the polynomials over the steps, over whole turns; a picture of a run-up is of its "
    "saved samples."
)
MIN_ROWS = 3  # of a waterfall
RUN_UP_ORDERS = 10  # of a waterfall of saved samples
ZONE_COLOURS = ("#d9f0d3", "#fff7c4", "#fddbb0", "#f6b8ae")  # of the zones A to D
LEAST_AMPLITUDE = 1e-4  # of the largest: smaller amplitudes of a waterfall look alike
MAX_LABELLED_ROWS = 12
HODOGRAPH_STYLES: tuple[dict[str, Any], ...] = (  # of the path with clearance, and without
    {"color": BLUE, "linewidth": 1.1},
    {"color": RED, "linewidth": 1.4, "linestyle": "--"},
)


def vibration_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or the grid has no `vibration`."""
    if study.cases.empty or not study.has(PEAK):
        return []
    worst = study.cases.worst_case(PEAK)
    pictures = [*_force_pictures(study, worst), *_envelopes(study, worst), *_waterfalls(study)]
    pictures += [*_run_up(study, worst), *[picture for place in _places(study) for picture in _zones(study, place)]]
    gallery = Gallery(f"{NOTE} The worst case has the largest force on the frame.", pictures)
    return section("vibration", "Vibration", gallery, _table(study))


def _places(study: Study, figure: str = "velocity_rms") -> list[str]:
    """Return the places with a figure, as in columns."""
    names = [column.name for column in study.run.layout.columns if column.figure == figure]
    return [name.removesuffix(f"_{figure}") for name in names]


def _table(study: Study) -> Table:
    """Return the figures of vibration of all cases, the largest force first."""
    columns = [*columns_in_table(study, "vibration")]
    columns = [each for each in columns if not each[0].endswith(tuple(_PLACE_COLUMNS))]
    for place in _places(study, "kurtosis"):
        columns += [(f"{place}_{name}", f"{place.replace('_', ' ')} {text}") for name, text in _PLACE_COLUMNS.items()]
    table = case_table(study, "vibration", "Vibration of all cases", columns, PEAK)
    turns, resolution = (float(np.nanmedian(study.cases[name])) for name in ("vibration_turns", "vibration_resolution"))
    text = f" Spectra are over {turns:g} turns, with lines {resolution:.4g}{wording.BLANK}Hz apart."
    return table._replace(note=table.note + text)


_PLACE_COLUMNS = {"velocity_rms": "velocity rms", "zone": "zone", "kurtosis": "kurtosis", "crest": "crest"}


def _orders(study: Study, case_id: str, column: str) -> np.ndarray:
    """Return a figure of a case by order (orders,); column : with {} in place of the order."""
    names = itertools.takewhile(study.has, map(column.format, itertools.count(1)))
    return np.array([float(study.cases.at(case_id, name)) for name in names])


def _force_pictures(study: Study, worst: str) -> Iterator[Picture]:
    """Yield the path of the force over a turn, where it is saved, and its orders along x and y."""
    setting = study.setting(worst) or "the case"
    channels = saved_channels(study.run, worst)
    if channels is not None and "frame/force_x" in channels and "crank_angle" in channels:
        angle = np.asarray(channels["crank_angle"], float)
        in_turn = angle > angle[-1] - 2.0 * np.pi
        force = np.array([np.asarray(channels[f"frame/force_{axis}"], float)[in_turn] for axis in "xy"])
        ideal = known(lambda: simulation.ideal_frame_force(resolve_cases(study, [worst])[0], angle[in_turn]))
        peak = wording.quantity_text(float(np.hypot(*force).max()), "N")
        paths = {"with clearance": force} | ({} if ideal is None else {"ideal": ideal})

        def paint(ax: Axes) -> None:
            scale = wording.scale("N", float(np.abs(force).max()))
            for (name, path), style in zip(paths.items(), HODOGRAPH_STYLES, strict=False):
                ax.plot(*(path / scale.factor), label=name, **style)
            ax.plot([0.0], [0.0], "+", color=GREY, markersize=6)
            ax.set_square(1.08 * max(float(np.abs(path).max()) for path in paths.values()) / scale.factor)
            ax.set_labels(f"force along x [{scale.unit}]", f"force along y [{scale.unit}]")
            set_plain_axes(ax)
            ax.set_legend("above", columns=2)

        yield Picture(
            "Shaking force over the last turn",
            f"Worst case: {setting}.",
            f"Path of the end of the force on the frame over a turn; largest {peak}.",
            paint,
            SQUARE_SIZE,
        )
    for axis in "xy":
        amplitudes = _orders(study, worst, f"frame_force_{axis}_order_{{}}")
        if amplitudes.any():
            ideal = _orders(study, worst, f"frame_force_{axis}_order_{{}}_ideal")
            strongest = int(amplitudes.argmax())
            text = wording.quantity_text(float(amplitudes[strongest]), "N")
            marks = _passing_orders(study, worst)
            caption = " Dashed: orders at which elements of rolling bearings pass, the cage and an element turn."
            yield _orders_picture(
                f"Orders of the force along {axis}",
                f"Worst case: {setting}.{caption if marks else ''}",
                f"Amplitudes of the force along {axis} by order of the crank; largest {text} at order {strongest + 1}.",
                ("N", amplitudes, ideal),
                marks,
            )


def _orders_picture(
    title: str,
    caption: str,
    alt: str,
    figure: tuple[str, np.ndarray, np.ndarray | None],
    marks: Sequence[tuple[float, str]] = (),
) -> Picture:
    """Return amplitudes over the order of the crank as bars, next to those without clearance.

    figure : unit, amplitudes (orders,), those without clearance; marks : orders at which elements of rolling bearings
    pass, each with its name
    """
    unit, amplitudes, ideal = figure

    def paint(ax: Axes) -> None:
        values = [amplitudes] if ideal is None else [amplitudes, ideal]
        scale, width = wording.scale(unit, float(max(map(np.max, values)))), 0.8 / len(values)
        orders = np.arange(1, len(amplitudes) + 1, dtype=float)
        names = ("with clearance", "ideal")
        for k, (heights, colour) in enumerate(zip(values, (BLUE, ORANGE), strict=False)):
            place = orders + (k - 0.5 * (len(values) - 1)) * width
            ax.bar(place, heights / scale.factor, width, color=colour, label=names[k] if values[1:] else "")
        top = max(float(np.max(heights)) for heights in values) / scale.factor
        for order, text in marks:
            if order < len(amplitudes) + 0.6:
                ax.axvline(order, color=RED, linewidth=0.9, linestyle="--")
                ax.text(order, top, text, colour=RED, size=7.0, ha="left", va="top", offset=2.0)
        ax.set_xlim(0.4 if not marks else 0.0, len(amplitudes) + 0.6)
        ax.set_labels("order of the crank [1 / turn]", label_with_unit("amplitude", scale))
        set_plain_axes(ax)
        if values[1:]:
            ax.set_legend("above", columns=2)

    return Picture(title, caption, alt, paint, FLAT_SIZE)


def _passing_orders(study: Study, case_id: str) -> list[tuple[float, str]]:
    """Return the orders of the crank, each with a name, of the passing frequencies of rolling bearings in a case."""
    speed = study.value(case_id, "drive.speed")
    if not isinstance(speed, float) or speed == 0.0:
        return []
    return [
        (2.0 * np.pi * float(study.cases.at(case_id, joint.column(f"{part}_frequency"))) / abs(speed), part + text)
        for joint in study.joints
        for text in [study.joint_text(joint, " of {}")]
        for part in (BEARING_PARTS if joint.layout.is_rolling else ())
    ]


def _envelopes(study: Study, worst: str) -> Iterator[Picture]:
    """Yield the spectrum of the envelope of the acceleration of each place in the worst case."""
    for place in _places(study):
        amplitudes = _orders(study, worst, f"{place}_envelope_order_{{}}")
        if amplitudes.any():
            name = place.replace("_", " ")
            yield _orders_picture(
                f"Envelope of the acceleration of {name}",
                "Worst case. Lines at the crank's order and at the impacts of a turn show looseness.",
                f"Amplitudes of the envelope of {name} by order; largest at order {int(amplitudes.argmax()) + 1}.",
                ("m/s^2", amplitudes, None),
            )


def _waterfalls(study: Study) -> Iterator[Picture]:
    """Yield the orders of the force over a swept crank speed, of the cases of each the largest."""
    axis = next((axis for axis in study.levels() if axis.path == "drive.speed" and axis.is_numeric), None)
    if axis is None or len(axis.values) < MIN_ROWS:
        return
    indices, speeds = study.indices_on(axis), [axis.number_text(value) for value in axis.values]
    for direction in "xy":
        figure = f"frame_force_{direction}_order"
        names = [column.name for column in study.run.layout.columns if column.figure == figure]
        values = np.stack([study.cases[name] for name in names or [PEAK]], axis=-1)
        rows = [values[indices == k] for k in range(len(axis.values))]
        amplitudes = np.array([row.max(axis=0) if len(row) else np.full(values.shape[1], np.nan) for row in rows])
        if names and np.nanmax(amplitudes) > 0.0:
            texts = (
                f"Waterfall of the force along {direction}",
                f"Largest over the other axes, for each {axis.name}.",
                f"Amplitudes of the force along {direction} by order and {axis.name}, as colours.",
            )
            yield Picture(*texts, _waterfall(amplitudes, speeds, axis.label()), MAP_SIZE)


def _waterfall(amplitudes: np.ndarray, rows: Sequence[str], label: str) -> Callable[[Axes], None]:
    """Return the painter of amplitudes (rows, orders) N over the order of the crank as colours, a row for each speed.

    rows : their names; label : of the rows' side
    """

    def paint(ax: Axes) -> None:
        largest = float(np.nanmax(amplitudes))
        scale = wording.scale("N", largest)
        colours = ColourScale(LEAST_AMPLITUDE * largest / scale.factor, largest / scale.factor, is_log=True)
        shown = np.maximum(amplitudes, LEAST_AMPLITUDE * largest) / scale.factor
        ax.cells(np.arange(0.5, amplitudes.shape[1] + 1.0), np.arange(-0.5, len(rows)), shown, colours)
        orders = range(1, amplitudes.shape[1] + 1, -(-amplitudes.shape[1] // MAX_LABELLED_ROWS))
        ax.xaxis.set_ticks(list(orders), list(map(str, orders)))
        step = -(-len(rows) // MAX_LABELLED_ROWS)
        ax.yaxis.set_ticks(list(range(0, len(rows), step)), list(rows)[::step])
        ax.set_labels("order of the crank [1 / turn]", label)
        draw_colour_bar(ax, colours, label_with_unit("amplitude", scale))

    return paint


def _run_up(study: Study, worst: str) -> Iterator[Picture]:
    """Yield the orders of the force in each saved turn of the worst case, if the speed of its crank changes."""
    channels = saved_channels(study.run, worst)
    drive = study.base.get("drive", {})
    is_steady = not {"motor", "torque"} & {*drive} and not isinstance(drive.get("speed"), dict)
    if is_steady or channels is None or "frame/force_x" not in channels:
        return
    time, angle, force = (np.asarray(channels[name], float) for name in ("t", "crank_angle", "frame/force_x"))
    turns = int((angle[-1] - angle[0]) / (2.0 * np.pi) + 1e-6)
    if turns < MIN_ROWS:
        return
    samples = (len(angle) - 1) // turns
    amplitudes, speeds = [], []
    for k in range(turns):
        part = slice(k * samples, (k + 1) * samples)
        amplitudes.append(2.0 / samples * np.abs(np.fft.rfft(force[part]))[1 : RUN_UP_ORDERS + 1])
        speeds.append(60.0 / (time[(k + 1) * samples] - time[k * samples]))
    rows = [f"{speed:.4g}" for speed in speeds]
    yield Picture(
        "Waterfall of the run-up: force along x",
        f"Worst case, {turns} turns, from saved samples.",
        f"Amplitudes of the force along x by order in each of {turns} turns, from {rows[0]} to {rows[-1]} rpm.",
        _waterfall(np.array(amplitudes), rows, "crank speed of the turn [rpm]"),
        MAP_SIZE,
    )


def _zones(study: Study, place: str) -> Iterator[Picture]:
    """Yield the zones of the velocity of a place over the one or two axes with the largest effect."""
    column, settings = f"{place}_velocity_rms", study.run.grid.get("vibration") or {}
    bounds = tuple(settings.get("zones") or SEVERITIES[settings.get("severity", NO_SEVERITY)])
    axes: list[Axis] = [effect.axis for effect in main_effects_of(study, column)][:2]
    if not bounds or not axes:
        return
    name, velocity = place.replace("_", " "), study.cases[column]
    if not axes[1:]:
        indices = study.indices_on(axes[0])
        curves = []
        for text, values in (("with clearance", velocity), ("ideal", study.cases[f"{column}_ideal"])):
            highest = [np.nanmax(values[indices == k], initial=np.nan) for k in range(len(axes[0].values))]
            curves += [(text, np.array(highest))] if np.isfinite(highest).any() else []

        def paint(ax: Axes) -> None:
            largest = max(float(np.nanmax(values)) for _, values in curves)
            scale, top = wording.scale("m/s", largest), 1.1 * max(largest, bounds[0])
            edges = [0.0, *[bound for bound in bounds if bound < top], top]
            for k, (low, high) in enumerate(itertools.pairwise(edges)):
                ax.axhspan(low / scale.factor, high / scale.factor, color=ZONE_COLOURS[k], zorder=0.0)
                ax.add_legend_entry(f"zone {ZONES[k]}", ZONE_COLOURS[k])
            positions = np.arange(len(axes[0].values), dtype=float)
            for (name, values), colour in zip(curves, (BLUE, GREY), strict=False):
                ax.plot(positions, values / scale.factor, "o-", color=colour, markersize=3.5, label=name)
            label_values(ax.xaxis, axes[0], positions)
            ax.set_ylim(0.0, top / scale.factor)
            ax.set_labels(axes[0].label(), f"velocity, rms [{scale.unit}]")
            set_plain_axes(ax)
            ax.set_legend("above", columns=3)

        alt = f"Velocity of {name} over {axes[0].name}, with the zones as bands."
        yield Picture(f"Velocity of {name} in zones", "The largest of each value.", alt, paint, FLAT_SIZE)
        return
    x_axis, y_axis = sorted(axes, key=study.axes.index)
    table = reduce_over_other_axes(study, velocity, (x_axis, y_axis), np.max)
    zones = np.vectorize(lambda value: ZONES.index(zone_of(value, bounds)) if np.isfinite(value) else np.nan)(table)
    scale = wording.scale("m/s", float(np.nanmax(table)))
    texts = np.vectorize(lambda value: scale.number_text(value, 3) if np.isfinite(value) else "")(table)
    counts = ", ".join(f"{zone}: {int((zones == k).sum())}" for k, zone in enumerate(ZONES))
    yield Picture(
        f"Zones of {name}: {x_axis.name} {wording.TIMES} {y_axis.name}",
        f"Numbers: velocity, rms [{scale.unit}].",
        f"Map of the zones of the velocity of {name}, cells of each: {counts}.",
        partial(draw_kinds, table=zones, cell_texts=texts, axes=(x_axis, y_axis), names=[f"zone {z}" for z in ZONES]),
        MAP_SIZE,
    )
