"""Vibration on the page: the shaking force, its orders, waterfalls, envelopes, and velocities in zones."""

import itertools
from collections.abc import Iterator
from functools import partial

import numpy as np

from ... import simulation
from ...contracts.vibration import BEARING_PARTS, NO_SEVERITY, SEVERITIES, ZONES, zone_of
from ...language import wording
from ...language.errors import InputError
from ..axis import Axis
from ..blocks.section import FLAT_SIZE, SQUARE_SIZE, Gallery, Picture, Section, without_empty
from ..blocks.table import Table, case_table, columns_in_table
from ..draw.maps import MAP_SIZE, draw_hodograph, draw_kinds, draw_orders, draw_waterfall, draw_zones
from ..effects import main_effects_of
from ..one_case.motion import saved_channels
from ..study import Study, largest, reduce_over_other_axes, resolve_cases

PEAK = "frame_force_peak"
NOTE = (
    "The force on the frame is minus the sum of m (a - g) of all bodies; the frame reacts every load unless `reacted: "
    "false`. Spectra are those of the polynomials over the steps, over whole turns; a picture of a run-up is of its "
    "saved samples."
)
MIN_ROWS = 3  # of a waterfall
RUN_UP_ORDERS = 10  # of a waterfall of saved samples


def vibration_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or the grid has no `vibration`."""
    if study.cases.empty or not study.has(PEAK):
        return []
    worst = study.cases.worst_case(PEAK)
    pictures = [*_force_pictures(study, worst), *_envelopes(study, worst), *_waterfalls(study)]
    pictures += [*_run_up(study, worst), *[picture for place in _places(study) for picture in _zones(study, place)]]
    blocks = without_empty([Gallery(f"{NOTE} The worst case has the largest force on the frame.", pictures)])
    return [Section("vibration", "Vibration", [*blocks, _table(study)])]


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
        try:
            ideal = simulation.ideal_frame_force(resolve_cases(study, [worst])[0], angle[in_turn])
        except InputError:  # mechanism or laws of another version, or a load or motor of a law file
            ideal = None
        peak = wording.quantity_text(float(np.hypot(*force).max()), "N")
        yield Picture(
            "Shaking force over the last turn",
            f"Worst case: {setting}.",
            f"Path of the end of the force on the frame over a turn; largest {peak}.",
            partial(draw_hodograph, force=force, ideal=ideal),
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
            yield Picture(
                f"Orders of the force along {axis}",
                f"Worst case: {setting}.{caption if marks else ''}",
                f"Amplitudes of the force along {axis} by order of the crank; largest {text} at order {strongest + 1}.",
                partial(draw_orders, amplitudes=amplitudes, ideal=ideal, unit="N", name="amplitude", marks=marks),
                FLAT_SIZE,
            )


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
            yield Picture(
                f"Envelope of the acceleration of {name}",
                "Worst case. Lines at the crank's order and at the impacts of a turn show looseness.",
                f"Amplitudes of the envelope of {name} by order; largest at order {int(amplitudes.argmax()) + 1}.",
                partial(draw_orders, amplitudes=amplitudes, ideal=None, unit="m/s^2", name="amplitude"),
                FLAT_SIZE,
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
            yield Picture(
                f"Waterfall of the force along {direction}",
                f"Largest over the other axes, for each {axis.name}.",
                f"Amplitudes of the force along {direction} by order and {axis.name}, as colours.",
                partial(
                    draw_waterfall, amplitudes=amplitudes, rows=speeds, labels=(axis.label(), "amplitude"), unit="N"
                ),
                MAP_SIZE,
            )


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
    rows, labels = [f"{speed:.4g}" for speed in speeds], ("crank speed of the turn [rpm]", "amplitude")
    yield Picture(
        "Waterfall of the run-up: force along x",
        f"Worst case, {turns} turns, from saved samples.",
        f"Amplitudes of the force along x by order in each of {turns} turns, from {rows[0]} to {rows[-1]} rpm.",
        partial(draw_waterfall, amplitudes=np.array(amplitudes), rows=rows, labels=labels, unit="N"),
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
        yield Picture(
            f"Velocity of {name} in zones",
            "The largest of each value.",
            f"Velocity of {name} over {axes[0].name}, with the zones as bands.",
            partial(draw_zones, axis=axes[0], velocities=curves, bounds=bounds),
            FLAT_SIZE,
        )
        return
    x_axis, y_axis = sorted(axes, key=study.axes.index)
    table = reduce_over_other_axes(study, velocity, (x_axis, y_axis), largest)
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
