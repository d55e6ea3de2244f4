"""Figures of parts of a machine: gears and couplings, rolling bearings, links that bend, housings, and vibration."""

import math
import operator
from functools import partial
from typing import Any

from ...contracts.case import Rolling
from ...contracts.catalogue import ENDLESS, NOTHING, Entry, Figure, figure, shown
from ...contracts.vibration import BEARING_PARTS, IDEAL
from ...mechanics.joints.rolling import FATIGUE_FORCE
from ...mechanics.laws.bearings import equivalent_loads, load_powers, passing_rates, rating_life
from .sums import FreeShare, PerRevolution
from .window import Window


def twist_range(window: Window, index: int) -> tuple[float, float]:
    """Return the least and the largest angle (rad) of the second body from the middle of the play, first body fixed.

    Positive is the side of the drive flank: the second body lags behind.
    """
    sums, joint = window.totals.joint[index], window.joints[index]
    arm = abs(joint.arm_distal)  # type: ignore[attr-defined]  # of a joint with play in rotation
    return -(joint.clearance + sums.coast_depth) / arm, (joint.clearance + sums.drive_depth) / arm


def torque_peak(window: Window, index: int) -> float:
    """Return the largest torque (N m) of the contact forces on the second body."""
    return float(window.totals.joint[index].force_max * abs(window.joints[index].arm_distal))  # type: ignore[attr-defined]


def torque_peak_ideal(window: Window, index: int) -> float | None:
    """Return the largest torque (N m) on the second body without play, or None if it is unknown."""
    force = window.ideal.get(window.case.joints[index].name)
    return None if force is None else force * abs(window.joints[index].arm_distal)  # type: ignore[attr-defined]


of_flanks = partial(figure, of="joint", needs=("flanked",))
FLANKED = (
    of_flanks(
        "impacts_per_cycle [1]: contact onsets on both flanks in the window per revolution, or per cycle; a run over "
        "a time is one cycle",
        needs=("flanked", "turns"),
        sums=PerRevolution("onsets"),
        tables=shown("impacts per cycle", forces=27, if_any=True),
    ),
    of_flanks(
        "free_share [1]: share of the window's time without contact on either flank",
        sums=FreeShare("contact_time"),
        tables=shown("time in the play", forces=28, if_any=True),
    ),
    of_flanks(
        "lost_motion [rad]: range of the angle of the second body relative to the first, play and deflection; the "
        "width of the loop of output over input of a drive that reverses",
        value=lambda window, index: -operator.sub(*twist_range(window, index)),
        tables=(Entry("forces", "lost motion", 29, if_any=True), Entry("case", "lost motion", 11)),
    ),
    of_flanks(
        "transmission_error [rad]: largest angle of the second body from where it would be without play and deflection",
        value=lambda window, index: max(map(abs, twist_range(window, index))),
        tables=shown("transmission error", forces=30, if_any=True),
    ),
    of_flanks(
        "torque_peak [N*m]: largest torque of the flanks on the second body, located",
        value=torque_peak,
        tables=(Entry("forces", "torque peak", 31, if_any=True), Entry("case", "torque peak", 12)),
    ),
    of_flanks(
        "torque_peak_ideal [N*m]: largest torque on the second body in the ideal mechanism",
        needs=("flanked", "turns"),
        value=torque_peak_ideal,
        differs=False,
        tables=shown("ideal torque peak", forces=32, if_any=True),
    ),
)


of_bearing = partial(figure, of="joint", needs=("rolling",))


def _bearing_of(window: Window, index: int) -> Rolling:
    bearing = window.case.joints[index].rolling
    assert bearing is not None  # only rolling bearings have these figures
    return bearing


def static_safety(window: Window, index: int) -> float | None:
    """Return C0 / P0 of a rolling bearing (ISO 76:2006), or None without load.

    P0, the equivalent static load of a radial bearing without axial load, is the largest resultant of its elements.
    """
    rating, load = _bearing_of(window, index).capacity.static, window.totals.joint[index].force_max
    assert rating is not None  # only bearings with this rating have this figure
    return float(rating / load) if load > 0.0 else None


def life_in_revolutions(window: Window, index: int) -> float:
    """Return the rating life of a rolling bearing (1e6 revolutions), infinite if it is not loaded while it turns.

    Each load counts by the speed at which the rings turn relative to each other.
    """
    bearing, totals = _bearing_of(window, index), window.totals.joint[index]
    if not totals.inner_fatigue > 0.0:
        return math.inf
    elements_turned = bearing.elements * totals.relative_turn
    means = (
        fatigue / elements_turned * FATIGUE_FORCE**power
        for fatigue, power in zip((totals.inner_fatigue, totals.outer_fatigue), load_powers(bearing), strict=True)
    )
    return rating_life(bearing, equivalent_loads(bearing, *means))


def mean_speed(window: Window, index: int) -> float:
    """Return the mean speed (1/s) of the inner ring relative to the outer one, without its sign."""
    return float(window.totals.joint[index].relative_turn / (2.0 * math.pi * window.duration))


def life_in_hours(window: Window, index: int) -> float:
    """Return the rating life of a rolling bearing (h) at its mean speed, infinite as `life_in_revolutions`."""
    revolutions = life_in_revolutions(window, index)
    return revolutions if math.isinf(revolutions) else 1e6 * revolutions / (3600.0 * mean_speed(window, index))


def _passing_frequency(name: str, text: str) -> Figure:
    """Return the figure of a passing frequency; `name`: its field in `PassingRates`."""
    return of_bearing(
        f"{name}_frequency [Hz]: {text}, at the mean speed of the inner ring relative to the outer one",
        value=lambda window, index: (
            mean_speed(window, index) * getattr(passing_rates(_bearing_of(window, index)), name)
        ),
    )


of_rated = partial(of_bearing, needs=("rolling", "dynamic"))
ROLLING = (
    of_rated(
        "life_l10r [h]: basic reference rating life of a rolling bearing, reached by 90 % (ISO/TS 16281); infinite: "
        "without load",
        value=life_in_hours,
        tables=(Entry("forces", "rating life", 30, if_any=True), Entry("case", "rating life", 13)),
    ),
    of_rated(
        "life_l10r_revolutions [1]: the same life in millions of revolutions of the inner ring relative to the outer "
        "one; infinite: without load",
        value=life_in_revolutions,
    ),
    of_rated(
        "light_load_fraction [1]: share of the window's time below the least load against skidding: 0.01 of the "
        "dynamic rating of ball bearings, 0.02 of roller bearings",
        value=lambda window, index: window.light_load_time[index] / window.duration,
        tables=shown("time too lightly loaded", forces=31, if_any=True),
    ),
    _passing_frequency("cage", "turns of the cage of a rolling bearing relative to the outer ring per second"),
    _passing_frequency("element", "turns of an element of a rolling bearing about itself per second"),
    _passing_frequency("inner", "elements of a rolling bearing that pass a point of the inner ring per second"),
    _passing_frequency("outer", "elements of a rolling bearing that pass a point of the outer ring per second"),
    of_bearing(
        "element_load_max [N]: largest force of a rolling element in the window, located",
        value=lambda window, index: window.totals.joint[index].element_force_max,
        tables=(Entry("forces", "element load", 27, if_any=True), Entry("case", "element load", 11)),
    ),
    of_bearing(
        "elements_loaded_max [1]: largest number of rolling elements that carry load at a time",
        value=lambda window, index: round(window.totals.joint[index].elements_loaded),
        kind="int",
        tables=shown("elements loaded", forces=28, if_any=True),
    ),
    of_flanks(
        "static_safety [1]: static load rating over the largest equivalent static load, which is the force peak (ISO "
        "76); null: no load",
        needs=("rolling", "static"),
        value=static_safety,
        tables=(Entry("forces", "static safety", 29, if_any=True), Entry("case", "static safety", 12)),
        null=ENDLESS,
    ),
)


of_link = partial(figure, of="link", needs=("bends",))
LINKS = (
    figure(
        "error_bending [{output}]: largest distance by which the bending of links alone displaces the {output}, to "
        "first order; null: the output is a point of a link that bends",
        of="output",
        needs=("bends",),
        tables=shown("{output} error by bending", output=1, if_any=True),
    ),
    of_link(
        "deflection_max [m]: largest deflection of the middle of {link} from the chord between its pins",
        tables=shown("deflection", output=6, case=11),
    ),
    of_link(
        "stress_max [Pa]: largest stress of {link} by bending and normal force, at the worst of 11 stations",
        tables=shown("stress", output=7, case=12),
    ),
    of_link("frequency [1/s]: first bending mode (Hz) of {link} between its pins", differs=False),
    figure(
        "damage [1]: share of the fatigue life of {link} that its stress in the window uses up, at the worst edge of "
        "11 stations",
        of="link",
        needs=("bends", "fatigue"),
        tables=(Entry("output", "damage", 8, if_any=True), Entry("case", "damage", 13)),
    ),
    figure(
        "error_mounts [{output}]: largest distance by which the motion of housings alone displaces the {output}, to "
        "first order",
        of="output",
        needs=("mounted",),
        tables=shown("{output} error by housings", output=2, if_any=True),
    ),
    figure(
        "mount_motion_max [m]: largest distance of the housing of {mount} from where its springs have no force",
        of="mount",
        needs=("mounted",),
        tables=shown("motion of the housing", output=9, case=14),
    ),
)


of_vibration = partial(figure, needs=("vibration",))
of_place = partial(of_vibration, of="place")
of_motion = partial(figure, needs=("vibration", "moves"), of="place")


def _with_ideal(name: str, unit: str, text: str, **other: Any) -> tuple[Figure, Figure]:
    """Return a figure of the force on the frame, and that of the ideal machine."""
    ideal = {"of": other["of"]} if "of" in other else {}
    return (
        of_vibration(f"{name} [{unit}]: {text}", **other),
        of_vibration(f"{name}{IDEAL} [{unit}]: {text}, without clearance", differs=False, **ideal),
    )


_PEAK_ENTRY = shown("frame force peak", vibration=1)
VIBRATION = (
    *_with_ideal("frame_force_peak", "N", "largest force of the mechanism on its frame", tables=_PEAK_ENTRY),
    *_with_ideal(
        "frame_force_rms",
        "N",
        "root mean square of the force of the mechanism on its frame, its mean included",
        tables=shown("frame force rms", vibration=2),
    ),
    *_with_ideal("frame_force_x_peak", "N", "largest size of this force along x, the crank's zero angle"),
    *_with_ideal("frame_force_y_peak", "N", "largest size of this force along y"),
    *_with_ideal(
        "frame_moment_peak",
        "N*m",
        "largest size of the moment of the mechanism on its frame, the reaction of the drive on it included",
        tables=shown("frame moment peak", vibration=3),
    ),
    *_with_ideal("frame_moment_rms", "N*m", "root mean square of this moment, its mean included"),
    *(
        figure
        for axis in "xy"
        for figure in _with_ideal(
            f"frame_force_{axis}_order",
            "N",
            f"amplitude of the force on the frame along {axis} at {{order}} times the crank speed, over whole turns",
            of="order",
        )
    ),
    of_vibration("crank_torque_rms [N*m]: root mean square of the drive torque"),
    of_vibration("crank_torque_ripple [N*m]: largest minus smallest drive torque"),
    of_vibration("drive_power_peak [W]: largest size of the drive's power"),
    of_vibration("drive_power_mean [W]: mean power of the drive"),
    of_vibration(
        "drive_power_reactive [W]: root mean square of the drive's power about its mean: what flows to and fro"
    ),
    of_vibration(
        "impact_power [W]: energy that the normal forces of all dry contacts dissipate, per second: what impacts turn "
        "into noise and heat"
    ),
    of_vibration("vibration_turns [1]: whole revolutions in a stretch of the window with a spectrum", differs=False),
    of_vibration("vibration_resolution [1/s]: distance of the lines of this spectrum (Hz)", differs=False),
    of_motion(
        "velocity_rms [m/s]: root mean square of the velocity of {place} in the band, of x and y the larger",
        tables=shown("velocity rms", vibration=10),
    ),
    of_motion("velocity_rms_ideal [m/s]: velocity_rms of {place} without clearance", differs=False),
    *(
        of_place(
            f"velocity_{axis}_rms [m/s]: root mean square of the velocity of {{place}} in the band, along {axis}",
            needs=("vibration", "moves", "across"),
        )
        for axis in "xy"
    ),
    of_place(
        "zone []: zone of this velocity, A to D", needs=("vibration", "moves", "zones"), kind="text", differs=False
    ),
    of_place(
        "kurtosis [1]: fourth moment over the square of the variance of the acceleration of {place}, 3 for Gauss; of "
        "a frame, of the force on it; of x and y the direction with the larger root mean square",
        null=NOTHING,
        tables=shown("kurtosis", vibration=11),
    ),
    of_place(
        "crest [1]: largest size of this signal over its root mean square",
        null=NOTHING,
        tables=shown("crest", vibration=12),
    ),
    of_place("skewness [1]: third moment over the variance to 3/2 of this signal", null=NOTHING),
    of_motion("band_energy [m^2/s^4]: mean square of the acceleration of {place} in the band"),
    of_motion(
        "envelope_order [m/s^2]: amplitude of the envelope of this acceleration in the band at {order} times the "
        "crank speed"
    ),
    *(
        of_motion(
            f"{part}_velocity [m/s]: amplitude of the velocity of {{place}} at `J_{part}_frequency`, of what differs "
            "from turn to turn, of x and y the larger; null: less than four lines from a multiple of the crank "
            "speed, or beyond the band",
            needs=("vibration", "moves", "rolling"),
        )
        for part in BEARING_PARTS
    ),
)
