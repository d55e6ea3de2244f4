"""Pictures of one case: its joints, its output with the ideal mechanism, its drive, its contact onsets.

Pictures are chosen from the layout, channel by channel, so no mechanism is known by name.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np

from ... import simulation
from ...contracts.case import column_name, value_at
from ...contracts.catalogue import GROUND
from ...contracts.layout import TIME, TORSIONAL, Column
from ...language import wording
from ...store import StoredRun
from .. import effects
from ..blocks.section import FLAT_SIZE, SQUARE_SIZE, Picture, capitalise
from ..draw import BLUE, GREY, INK, RED, draw_colour_bar, set_crank_angle_axis, set_plain_axes
from ..plot import Axes, ColourScale, multiples_of, round_ticks
from ..study import Joint, Study, joint_with_laws, known, resolve_cases
from .joints import bearing_pictures, spatial_pictures

# Pictures of one case: its joints, its output with the ideal mechanism, its drive, its contact onsets.
#
# Pictures are chosen from the layout, channel by channel, so no mechanism is known by name.

FULL_TURN = 2.0 * np.pi
SPEED = "crank speed"
SAME_ANGLE = 1e-9  # rad, largest change of the difference of two angles that are those of one body
ORBIT_CHANNELS = ("x", "y", "force_normal")  # channels of a joint needed for its orbit
DRAWN_PENETRATION = 0.4  # of the clearance: drawn height of the deepest penetration in an unrolled gap
#: Levels in the picture of a joint's force.
REFERENCE_FORCES = (("force_p99", "p99"), ("force_peak_ideal", "ideal peak"))


class History(NamedTuple):
    """The saved time histories of a case."""

    channels: Mapping  # name -> values in SI
    time: np.ndarray  # s
    angle: np.ndarray | None  # rad, of the drive, from 0 to 2 pi at first; None without a rotating drive
    first_angle: float = 0.0  # rad, full turns before that
    is_over_time: bool = False  # whether pictures are over time, see `Study`

    def values(self, name: str) -> np.ndarray:
        """Return the values (SI) of one channel."""
        return np.asarray(self.channels[name], float)

    def painter(
        self,
        values: np.ndarray,
        unit: str,
        name: str,
        ideal: np.ndarray | None = None,
        levels: Sequence[tuple[str, float]] = (),
    ) -> Callable[[Axes], None]:
        """Return a function that draws a quantity (SI) over the angle of the drive, or over time.

        That is without rotation, and for a start-up.  levels : names and heights of lines over the angle
        """
        angle = None if self.is_over_time else self.angle

        def paint(ax: Axes) -> None:
            if angle is None:
                scale, time_scale = wording.scale(unit, values, speed="speed" in name), wording.scale("s", self.time)
                abscissae, widths = self.time / time_scale.factor, (0.8, 1.2)
            else:
                scale = wording.scale(unit, [*values, *(level for _, level in levels)])
                abscissae, widths = np.degrees(angle), (0.7, 1.4)
            label = "" if ideal is None else "with clearance"
            ax.plot(abscissae, values / scale.factor, color=BLUE, linewidth=widths[0], label=label)
            if ideal is not None:
                style: dict[str, Any] = {"color": RED, "linewidth": widths[1], "linestyle": "--", "label": "ideal"}
                ax.plot(abscissae, ideal / scale.factor, **style)
            ax.yaxis.label = f"{name} [{scale.unit}]"
            if angle is not None:
                for (level_name, level), colour, dash in zip(levels, (RED, INK), ("--", ":"), strict=False):
                    style = {"color": colour, "linewidth": 1.1, "linestyle": dash, "label": level_name}
                    ax.axhline(level / scale.factor, **style)
                set_crank_angle_axis(ax, angle, has_legend=ideal is not None or bool(levels))
                return
            ax.xaxis.label = f"time [{time_scale.unit}]"
            set_plain_axes(ax)
            if ideal is not None:
                ax.set_legend("above", columns=2)

        return paint


class JointHistory(NamedTuple):
    """A quantity of a joint over the history of a case, with and without clearance."""

    name: str
    unit: str  # SI
    actual: np.ndarray
    ideal: np.ndarray | None = None


def saved_channels(run: StoredRun, case_id: str) -> Mapping | None:
    """Return the saved channels of a case by name, or None if no history was saved."""
    channels = run.orbit_columns(case_id)
    return channels if max(map(len, channels.values()), default=0) > 1 else None


def history_of(study: Study, case_id: str, channels: Mapping) -> History:
    """Return the History of a case from its channels."""
    time, speed = np.asarray(channels[TIME], float), study.value(case_id, "drive.speed")
    angle = None if speed is None or "crank_angle" in channels else float(speed) * time
    angle = np.asarray(channels["crank_angle"], float) if "crank_angle" in channels else angle
    first_angle = 0.0 if angle is None else FULL_TURN * np.floor(angle[0] / FULL_TURN + 1e-9)
    return History(channels, time, None if angle is None else angle - first_angle, first_angle, study.is_over_time)


def crank_speed(history: History) -> np.ndarray:
    """Return the speed (rad/s) of the crank at every sample of a rotating drive."""
    assert history.angle is not None
    for name in history.channels:
        body, _, quantity = name.rpartition("/")
        if quantity == "angle" and f"{body}/rate" in history.channels:
            difference = history.values(name) - history.angle
            if np.ptp(difference) < SAME_ANGLE:
                return history.values(f"{body}/rate")
    return np.gradient(history.angle, history.time, edge_order=2)


def bending_links(channels: Mapping) -> list[str]:
    """Return the links that bend, as in channels, whose deflection and stress are stored."""
    names = [name.removesuffix("/deflection") for name in channels if name.endswith("/deflection")]
    return [name for name in names if f"{name}/stress" in channels]


def joint_histories(study: Study, case_id: str, history: History) -> list[JointHistory]:
    """Return the histories of joint forces, output acceleration and torque, each with its ideal."""
    ideal, histories = _ideal_motion(study, case_id, history), []
    if history.is_over_time and history.angle is not None:
        histories.append(JointHistory(SPEED, "rad/s", crank_speed(history)))
    for joint in study.joints:
        if f"joints/{joint.name}/force_normal" not in history.channels:
            continue
        reaction = ideal.reactions.get(joint.title) if ideal else None
        ideal_values = None if reaction is None else np.hypot(reaction[..., 0], reaction[..., 1])
        force = history.values(f"joints/{joint.name}/force_normal")
        unit = study.run.layout.units[f"joints/{joint.name}/force_normal"]
        histories.append(JointHistory(f"normal force{study.joint_text(joint, ', {}')}", unit, force, ideal_values))
    histories += [
        JointHistory(f"{quantity} of {name.replace('_', '-')}", unit, history.values(f"{name}/{quantity}"))
        for name in bending_links(history.channels)
        for quantity, unit in (("deflection", "m"), ("stress", "Pa"))
    ]
    acceleration = _acceleration_channel(study, history)
    if acceleration:
        ideal_values = ideal.acceleration if ideal else None
        name = f"{study.run.layout.output} acceleration"
        histories.append(JointHistory(name, acceleration.unit, history.values(acceleration.name), ideal_values))
    torques = [channel for channel in _mechanism_channels(study, history) if channel.name.endswith("/torque")]
    torque = ideal.torque if ideal else None
    return histories + [
        JointHistory(_channel_label(channel), channel.unit, history.values(channel.name), torque) for channel in torques
    ]


def motion_pictures(study: Study, case_id: str, channels: Mapping) -> list[Picture]:
    """Return the pictures of one case from its channels, as far as available."""
    history = history_of(study, case_id, channels)
    speed = _speed_pictures(history)
    joints = [picture for joint in study.joints for picture in _joint_pictures(study, case_id, joint, history)]
    output = _output_pictures(study, case_id, history)
    if not output:
        return [*speed, *_channel_pictures(study, history), *joints]
    return [*speed, *joints, *output, *_torque_pictures(study, case_id, history)]


def _speed_pictures(history: History) -> list[Picture]:
    """Return the crank speed over time of a start-up, [] for another motion."""
    if not history.is_over_time or history.angle is None:
        return []
    speed = crank_speed(history)
    alt = f"Crank speed over time, at most {wording.scale('rad/s', speed, speed=True).text(float(speed.max()), 4)}."
    return [Picture("Crank speed", "", alt, history.painter(speed, "rad/s", SPEED), FLAT_SIZE, shown_in_player=True)]


def onset_pictures(study: Study, case_id: str, events: Mapping | np.ndarray, channels: Mapping) -> list[Picture]:
    """Return a picture of the closing rates at contact onsets for each of their units, or [] without events or drive.

    If the speed is not constant, the picture covers the part of the run whose samples are saved in `channels`.
    """
    speed, time = study.value(case_id, "drive.speed"), np.asarray(events["t"], float)
    start = study.value(case_id, "drive.start_angle") or 0.0
    is_shown = np.asarray(events["kind"]).astype(str) == "on"
    if isinstance(speed, Mapping | None) and study.is_driven:
        sample_times = np.asarray(channels[TIME], float)
        is_shown &= (time >= sample_times[0]) & (time <= sample_times[-1])
        angles = np.interp(time, sample_times, np.asarray(channels["crank_angle"], float))
    elif speed is not None:
        angles = float(start) + float(speed) * time
    if not study.is_driven or not is_shown.any():
        return []
    torsional = [name for joint in study.joints if TORSIONAL in joint.layout.features for name in joint.layout.contacts]
    turns = np.isin(np.asarray(events["joint"]).astype(str), torsional)
    pictures = []
    for unit, chosen in (("m/s", is_shown & ~turns), ("rad/s", is_shown & turns)):
        if not chosen.any():
            continue
        rate = np.asarray(events["rate"], float)[chosen]
        yield_speeds = effects.yield_speeds(study, case_id, float(rate.max())) if unit == "m/s" else []
        alt = f"{int(chosen.sum())} contact onsets, the fastest at {_largest_text(rate, unit)}."
        paint = partial(_paint_onsets, angle=angles[chosen], rate=rate, limits=yield_speeds, unit=unit)
        caption = "Closing rate at each onset of the whole run."
        pictures.append(Picture("Contact onsets", caption, alt, paint, FLAT_SIZE))
    return pictures


def _paint_onsets(
    ax: Axes, angle: np.ndarray, rate: np.ndarray, limits: Sequence[tuple[str, float]], unit: str
) -> None:
    """Draw closing rates (`unit`, m/s or rad/s) of contact onsets over the crank angle (rad), and those of yield."""
    scale = wording.scale(unit, [*rate, *(limit for _, limit in limits)])
    ax.vlines(np.degrees(angle), 0.0, rate / scale.factor, color=BLUE, linewidth=0.6)
    ax.plot(np.degrees(angle), rate / scale.factor, ".", color=BLUE, markersize=4)
    for (name, limit), dash in zip(limits, cycle(("--", ":", "-."))):
        label = f"first yield ({name})"
        ax.axhline(limit / scale.factor, color=RED, linewidth=1.1, linestyle=dash, label=label)
    ax.yaxis.label = f"closing rate at onset [{scale.unit}]"
    ax.set_ylim(0.0, None)
    full_turns = np.array([0.0, 2.0 * np.pi * np.ceil(angle.max() / (2.0 * np.pi))])
    set_crank_angle_axis(ax, full_turns, has_legend=bool(limits))


def _output_pictures(study: Study, case_id: str, history: History) -> list[Picture]:
    """Return the output's acceleration and position error, with the ideal mechanism if available.

    The channel of the position is recognised by its unit, which is that of the error.
    """
    output = study.run.layout.output
    unit = study.unit(study.column("error_max"))
    name_by_unit = {channel.unit: channel.name for channel in reversed(_body_channels(study, history, output))}
    ideal, acceleration_channel = _ideal_motion(study, case_id, history), _acceleration_channel(study, history)
    output_pictures = []
    if acceleration_channel:
        acceleration, ideal_values = history.values(acceleration_channel.name), ideal.acceleration if ideal else None
        largest, *ideal_text = largest_texts([acceleration, ideal_values], acceleration_channel.unit)
        alt = f"{capitalise(output)} acceleration, at most {largest}"
        alt += f"; the ideal mechanism reaches {ideal_text[0]}." if ideal_text else "."
        paint = history.painter(acceleration, acceleration_channel.unit, f"{output} acceleration", ideal_values)
        title = f"{capitalise(output)} acceleration against the ideal mechanism"
        output_pictures.append(Picture(title, "", alt, paint, FLAT_SIZE, shown_in_player=True))
    if unit in name_by_unit and ideal:
        error = history.values(name_by_unit[unit]) - ideal.position
        title, paint = f"{capitalise(output)} position", history.painter(error, unit, f"{output} error")
        caption = f"{title} less that of the ideal mechanism."
        alt = f"{capitalise(output)} error, at most {_largest_text(error, unit)}."
        output_pictures.append(Picture(f"{title} error", caption, alt, paint, FLAT_SIZE))
    return output_pictures


def _acceleration_channel(study: Study, history: History) -> Column | None:
    """Return the channel of the output's acceleration: its unit is that of the position per s^2."""
    unit = f"{study.unit(study.column('error_max'))}/s^2"
    channels = _body_channels(study, history, study.run.layout.output)
    return next((channel for channel in channels if channel.unit == unit), None)


def _torque_pictures(study: Study, case_id: str, history: History) -> list[Picture]:
    """Return the torque of the drive with that of the ideal mechanism, if the mechanism has this channel."""
    ideal, torque_pictures = _ideal_motion(study, case_id, history), []
    for channel in _mechanism_channels(study, history):
        if channel.name.endswith("/torque"):
            values, name = history.values(channel.name), _channel_label(channel)
            is_crank_free = study.has("crank_speed_min")
            caption = "Torque of the drive." if is_crank_free else "Torque that keeps the crank speed constant."
            alt = f"{capitalise(name)}, at most {_largest_text(values, channel.unit)}."
            paint = history.painter(values, channel.unit, name, ideal.torque if ideal else None)
            torque_pictures.append(Picture(capitalise(name), caption, alt, paint, FLAT_SIZE, shown_in_player=True))
    return torque_pictures


def _channel_pictures(study: Study, history: History) -> list[Picture]:
    """Return one picture for each channel of the mechanism; a rate is drawn over the quantity before it."""
    channel_pictures, previous = [], None
    for channel in _mechanism_channels(study, history):
        values, name = history.values(channel.name), _channel_label(channel)
        if previous and channel.unit == f"{previous.unit}/s":
            channel_pictures.append(_phase_portrait(previous, channel, history))
        else:
            caption = f"{capitalise(channel.description)}." if channel.description else ""
            alt = f"{capitalise(name)}, at most {_largest_text(values, channel.unit)}."
            channel_pictures.append(
                Picture(capitalise(name), caption, alt, history.painter(values, channel.unit, name), FLAT_SIZE)
            )
        previous = channel
    return channel_pictures


def _phase_portrait(quantity: Column, rate: Column, history: History) -> Picture:
    """Return the phase portrait of a quantity and its rate."""
    abscissa, ordinate = (
        (history.values(channel.name), channel.unit, _channel_label(channel)) for channel in (quantity, rate)
    )
    title = f"Phase portrait: {_channel_label(rate)} over {_channel_label(quantity)}"
    return Picture(title, "", f"{title}.", partial(_paint_over, quantity=abscissa, rate=ordinate), SQUARE_SIZE)


def _paint_over(ax: Axes, quantity: tuple[np.ndarray, str, str], rate: tuple[np.ndarray, str, str]) -> None:
    """Draw a rate over its quantity; each : values in SI, unit, name."""
    (x_scale, v_scale) = (wording.scale(unit, values) for values, unit, _ in (quantity, rate))
    ax.plot(quantity[0] / x_scale.factor, rate[0] / v_scale.factor, color=BLUE, linewidth=0.8)
    ax.set_labels(f"{quantity[2]} [{x_scale.unit}]", f"{rate[2]} [{v_scale.unit}]")
    set_plain_axes(ax)


def _joint_pictures(study: Study, case_id: str, joint: Joint, history: History) -> list[Picture]:
    """Return the orbit of the journal, if it is planar with known clearance, and the normal force."""
    if not all(f"joints/{joint.name}/{name}" in history.channels for name in ORBIT_CHANNELS):
        return _force_pictures(study, case_id, joint, history)
    if joint.layout.flanked:
        return [*_play_pictures(study, joint, history), *_force_pictures(study, case_id, joint, history)]
    if joint.layout.is_rolling:
        pictures = bearing_pictures(study, case_id, joint, history.channels)
        return [*pictures, *_force_pictures(study, case_id, joint, history)]
    x, y, force = (history.values(f"joints/{joint.name}/{name}") for name in ORBIT_CHANNELS)
    joint_text = study.joint_text(joint, ", joint {}")
    clearance = study.radial_clearance(case_id, joint)
    orbit_pictures = []
    if clearance is not None and _has_orbit(study, joint):
        max_eccentricity = float(np.hypot(x, y).max())
        eccentricity_text, clearance_text = wording.texts_in_common_unit((max_eccentricity, float(clearance)), "m")
        orbit_pictures.append(
            Picture(
                f"Journal orbit{joint_text}",
                "The circle is the radial clearance; outside it the bodies touch.",
                f"Path of the journal centre, at most {eccentricity_text} from the bearing centre; clearance "
                f"{clearance_text}.",
                partial(_paint_orbit, curve=(x, y, force), clearance=float(clearance)),
                SQUARE_SIZE,
                shown_in_player=True,
            )
        )
        if joint == study.most_loaded_joint():
            orbit_pictures.append(_unrolled_orbit(joint_text, (x, y, force), float(clearance)))
    return [
        *orbit_pictures,
        *_spatial_pictures(study, case_id, joint, history),
        *_force_pictures(study, case_id, joint, history),
    ]


def _play_pictures(study: Study, joint: Joint, history: History) -> list[Picture]:
    """Return the position of teeth or coupling halves over the angle of the crank, and its phase portrait."""
    channels = {channel.name: channel for channel in study.run.layout.channels}
    place, rate = (channels[f"joints/{joint.name}/{key}"] for key in ("x", "vx"))
    if rate.name not in history.channels:
        return []
    joint_text, pictures = study.joint_text(joint, ", joint {}"), list[Picture]()
    if loop := _output_over_input(study, joint, history):
        title = f"Output against input{joint_text}"
        caption = (
            "The loop of a drive that reverses is as high as the lost motion: the play and the deflection of flanks."
        )
        paint = partial(_paint_over, quantity=loop[0], rate=loop[1])
        pictures.append(Picture(title, caption, f"{title}: {loop[1][2]} over the {loop[0][2]}.", paint, SQUARE_SIZE))
    elif history.angle is not None:
        crank, values = (history.angle, "rad", "crank angle"), (history.values(place.name), place.unit, "position")
        is_stopped = "stops" in joint.layout.flanked
        title = f"Position {'between the stops' if is_stopped else 'in the play'} over the crank angle{joint_text}"
        caption = "Above zero: the drive flank. If the drive reverses, the loop is as wide as the lost motion."
        caption = "" if is_stopped else caption
        paint = partial(_paint_over, quantity=crank, rate=values)
        pictures.append(Picture(title, caption, f"{title}.", paint, SQUARE_SIZE))
    return [*pictures, _phase_portrait(place, rate, history)]


def _output_over_input(study: Study, joint: Joint, history: History) -> tuple | None:
    """Return the angle of the first body and the shift of the second one, each as (rad, unit, name); None if unknown.

    The shift is that from where the second body would be without play; wheels must turn on the ground.
    """
    section = value_at(study.base, f"mechanism.joints.{joint.title}") or {}
    bodies: list[str] = list(section.get("between", ())) if section.get("type") in ("gear", "coupling") else []
    names = [f"{column_name(body)}/angle" for body in bodies]
    pins = (value_at(study.base, "mechanism.joints") or {}).values()
    seats = [{end.partition(".")[0] for end in pin["between"]} for pin in pins if pin.get("type") == "revolute"]
    on_ground = section.get("type") == "coupling" or all({GROUND, body} in seats for body in bodies)
    if len(names) != 2 or not on_ground or not set(names) <= set(history.channels):
        return None
    first, second = map(history.values, names)
    shift = second + first / section.get("ratio", -1.0)
    return (first, "rad", f"angle of {bodies[0]}"), (shift, "rad", f"shift of {bodies[1]}")


def _force_pictures(study: Study, case_id: str, joint: Joint, history: History) -> list[Picture]:
    """Return the picture of the normal force, or torque, of a joint; [] if it is not stored."""
    channel = f"joints/{joint.name}/force_normal"
    if channel not in history.channels:
        return []
    force, joint_text = history.values(channel), study.joint_text(joint, ", joint {}")
    unit = study.run.layout.units[channel]
    quantity = "torque" if unit == "N*m" else "normal force"
    painted = history.painter(force, unit, quantity, levels=_reference_levels(study, case_id, joint))
    is_over_time = history.angle is None or history.is_over_time

    def paint(ax: Axes) -> None:
        painted(ax)
        if not is_over_time:
            ax.set_ylim(0.0, None)

    abscissa = "time" if is_over_time else "crank angle"
    alt = f"{capitalise(quantity)} over {abscissa}, at most {_largest_text(force, unit)} among the samples."
    return [Picture(f"{capitalise(quantity)}{joint_text}", "", alt, paint, FLAT_SIZE, shown_in_player=True)]


def _paint_orbit(ax: Axes, curve: tuple[np.ndarray, ...], clearance: float) -> None:
    """Draw the path of the journal centre in the clearance circle (m); curve : x, y (m), normal force (N)."""
    scale = wording.scale("m", clearance)
    x, y, radius = curve[0] / scale.factor, curve[1] / scale.factor, clearance / scale.factor
    ax.circle((0.0, 0.0), radius, facecolor="#f3f6f9", edgecolor=INK, zorder=0)
    ax.plot(x, y, color=GREY, linewidth=0.5, alpha=0.8)
    _draw_contact_points(ax, x, y, curve[2])
    ax.set_square(1.08 * max(radius, float(np.hypot(x, y).max(initial=0.0))))
    ax.set_labels(f"journal x [{scale.unit}]", f"journal y [{scale.unit}]")
    for side in (ax.xaxis, ax.yaxis):
        side.tick_rule = round_ticks(5)


def _draw_contact_points(ax: Axes, x: np.ndarray, y: np.ndarray, force: np.ndarray) -> None:
    """Draw the points of a path in contact, coloured by the force (N)."""
    in_contact = force > 0.0
    if in_contact.any():
        scale = wording.scale("N", force)
        forces = force[in_contact] / scale.factor
        colours = ColourScale(float(forces.min()), float(forces.max()))
        ax.scatter(x[in_contact], y[in_contact], size=2.0, values=forces, scale=colours, zorder=3)
        draw_colour_bar(ax, colours, f"normal force [{scale.unit}]")


def _unrolled_orbit(joint_text: str, curve: tuple[np.ndarray, ...], clearance: float) -> Picture:
    """Return the gap of a journal over the direction of its centre; curve : x, y (m), normal force (N)."""
    x, y, force = curve
    gap = clearance - np.hypot(x, y)
    deepest = max(float(-gap.min()), 0.0)
    magnification = 1.0  # of penetration relative to the gap: one digit, at least 1
    if deepest > 0.0:
        magnification = max(float(f"{DRAWN_PENETRATION * clearance / deepest:.1g}"), 1.0)

    def paint(ax: Axes) -> None:
        scale, direction = wording.scale("m", clearance), np.degrees(np.arctan2(y, x))
        height = np.where(gap < 0.0, magnification * gap, gap) / scale.factor
        seams = np.flatnonzero(np.abs(np.diff(direction)) > 180.0) + 1  # where a line crosses +-180 degrees
        line = np.insert(direction, seams, np.nan), np.insert(height, seams, np.nan)
        ax.plot(*line, color=GREY, linewidth=0.5, alpha=0.8)
        ax.axhspan(1.1 * min(float(height.min()), 0.0), 0.0, color="#f6e7dd", zorder=0)
        ax.axhline(0.0, color=INK, linewidth=1.0)
        _draw_contact_points(ax, direction, height, force)
        high = 1.05 * max(float(height.max()), 0.2 * clearance / scale.factor)
        low = 1.1 * min(float(height.min()), 0.0)
        depths = [-deepest, -0.5 * deepest] if deepest else []
        gap_ticks = np.asarray(round_ticks(max(1, round(4.0 * high / (high - low))))(0.0, high))
        gap_ticks = gap_ticks[(gap_ticks >= 0.0) & (gap_ticks <= high)]
        names = [wording.short_number_text(value / scale.factor, 2).replace("-", wording.MINUS) for value in depths]
        names += [wording.short_number_text(float(value), 3) for value in gap_ticks]
        ax.yaxis.set_ticks([*(magnification * value / scale.factor for value in depths), *gap_ticks], names)
        ax.set_xlim(-180.0, 180.0)
        ax.set_ylim(low, high)
        ax.set_labels("direction of the journal centre [°]", f"gap [{scale.unit}]")
        ax.xaxis.tick_rule = multiples_of(90)
        set_plain_axes(ax)

    note = f"; below zero is the penetration, magnified {magnification:g} times" if magnification > 1.0 else ""
    smallest_gap = wording.quantity_text(clearance - float(np.hypot(x, y).max()), "m").replace("-", wording.MINUS)
    return Picture(
        f"Journal orbit unrolled{joint_text}",
        f"The gap in the direction of the journal centre{note}.",
        f"Gap against the direction of the journal centre, at least {smallest_gap}.",
        paint,
        SQUARE_SIZE,
    )


def _spatial_pictures(study: Study, case_id: str, joint: Joint, history: History) -> list[Picture]:
    """Return the pictures of a spatial joint: the axis of its journal, its tilt; [] unless all channels are stored."""
    is_complete = all(channel.name in history.channels for channel in study.run.layout.channels)
    if history.angle is None or not is_complete or f"joints/{joint.name}/tilt" not in history.channels:
        return []
    case = known(lambda: resolve_cases(study, [case_id])[0])
    spatial_joint = known(lambda: joint_with_laws(case, joint)) if case else None
    return spatial_pictures(case, spatial_joint, history.values, history.angle) if case and spatial_joint else []


def has_straight_walls(study: Study, joint: Joint) -> bool:
    """Return whether a joint is a guide or a slot, whose walls are straight."""
    return not {"height", "slot_length"}.isdisjoint(value_at(study.base, f"joints.{joint.title}") or {})


def _has_orbit(study: Study, joint: Joint) -> bool:
    """Return whether the journal moves in a circle; not in a guide, a slot or the gap of an impact pair."""
    if has_straight_walls(study, joint):
        return False
    mechanism = simulation.catalogue().mechanism(study.mechanism)
    sites = mechanism.joints if mechanism else ()
    return not any(site.name == joint.title and site.kind == "line" for site in sites)


def _reference_levels(study: Study, case_id: str, joint: Joint) -> list[tuple[str, float]]:
    """Return the reference forces of the history of a case: name, N."""
    if study.cases.row_of(case_id) < 0:
        return []
    columns = [(name, joint.column(figure)) for figure, name in REFERENCE_FORCES]
    levels = [(name, float(study.cases.at(case_id, column))) for name, column in columns if study.has(column)]
    return [level for level in levels if np.isfinite(level[1])]


def _ideal_motion(study: Study, case_id: str, history: History) -> simulation.IdealMotion | None:
    """Return the ideal mechanism at the samples of a case, or None if there is none or it is unknown."""
    if history.angle is None:
        return None
    angle = history.angle + history.first_angle

    def compute() -> simulation.IdealMotion | None:
        return known(lambda: simulation.ideal_motion(resolve_cases(study, [case_id])[0], angle, history.time))

    return study.cases.cached(("ideal motion", case_id, angle.tobytes(), history.time.tobytes()), compute)


def _mechanism_channels(study: Study, history: History) -> list[Column]:
    """Return the channels of the mechanism, without those of its joints and the time."""
    channels = [channel for channel in study.run.layout.channels if channel.name in history.channels]
    return [channel for channel in channels if channel.name != TIME and not channel.name.startswith("joints/")]


def _body_channels(study: Study, history: History, body: str) -> list[Column]:
    return [channel for channel in _mechanism_channels(study, history) if body and channel.name.startswith(f"{body}/")]


def _channel_label(channel: Column) -> str:
    """Return the name of a channel in words: 'crank torque' for 'crank/torque'."""
    parts = channel.name.split("/")
    if parts[0] == "joints" and parts[-1] in _JOINT_WORDS:
        return f"{_JOINT_WORDS[parts[-1]]} of {wording.joint_name(parts[1])}"
    return channel.name.replace("/", " ").replace("_", " ")


_JOINT_WORDS = {"x": "position", "vx": "rate"}


def _largest_text(values: np.ndarray, unit: str) -> str:
    """Return the largest magnitude of a history with its unit."""
    return largest_texts([values], unit)[0]


def largest_texts(histories: Iterable[np.ndarray | None], unit: str) -> list[str]:
    """Return the largest magnitudes of compared histories that are known, all in one unit."""
    known = (values for values in histories if values is not None)
    return wording.texts_in_common_unit((float(np.abs(values).max()) for values in known), unit)
