"""Figures of vibration: force and moment on the frame, the drive's torque and power, and the motion of places."""

from functools import partial
from typing import Any

from ...contracts.catalogue import NOTHING, Entry, Figure
from ...contracts.vibration import IDEAL

_figure = partial(Figure, needs=("vibration",))
_place_figure = partial(_figure, of="place")
_motion_figure = partial(Figure, needs=("vibration", "moves"), of="place")


def _with_ideal(name: str, unit: str, text: str, **other: Any) -> tuple[Figure, Figure]:
    """Return a figure of the force on the frame, and that of the ideal machine."""
    ideal = {"of": other["of"]} if "of" in other else {}
    return (
        _figure(name, unit, text, **other),
        _figure(f"{name}{IDEAL}", unit, f"{text}, without clearance", differs=False, **ideal),
    )


_PEAK_ENTRY = (Entry("vibration", "frame force peak", 1),)
FIGURES = (
    *_with_ideal("frame_force_peak", "N", "largest force of the mechanism on its frame", tables=_PEAK_ENTRY),
    *_with_ideal(
        "frame_force_rms",
        "N",
        "root mean square of the force of the mechanism on its frame, its mean included",
        tables=(Entry("vibration", "frame force rms", 2),),
    ),
    *_with_ideal("frame_force_x_peak", "N", "largest size of this force along x, the crank's zero angle"),
    *_with_ideal("frame_force_y_peak", "N", "largest size of this force along y"),
    *_with_ideal(
        "frame_moment_peak",
        "N*m",
        "largest size of the moment of the mechanism on its frame, the reaction of the drive on it included",
        tables=(Entry("vibration", "frame moment peak", 3),),
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
    _figure("crank_torque_rms", "N*m", "root mean square of the drive torque"),
    _figure("crank_torque_ripple", "N*m", "largest minus smallest drive torque"),
    _figure("drive_power_peak", "W", "largest size of the drive's power"),
    _figure("drive_power_mean", "W", "mean power of the drive"),
    _figure("drive_power_reactive", "W", "root mean square of the drive's power about its mean: what flows to and fro"),
    _figure(
        "impact_power",
        "W",
        "energy that the normal forces of all contacts dissipate, per second: what impacts turn into noise and heat",
    ),
    _figure("vibration_turns", "1", "whole revolutions in a stretch of the window with a spectrum", differs=False),
    _figure("vibration_resolution", "1/s", "distance of the lines of this spectrum (Hz)", differs=False),
    _motion_figure(
        "velocity_rms",
        "m/s",
        "root mean square of the velocity of {place} in the band, of x and y the larger",
        tables=(Entry("vibration", "velocity rms", 10),),
    ),
    _motion_figure("velocity_rms_ideal", "m/s", "velocity_rms of {place} without clearance", differs=False),
    *(
        _place_figure(
            f"velocity_{axis}_rms",
            "m/s",
            f"root mean square of the velocity of {{place}} in the band, along {axis}",
            needs=("vibration", "moves", "across"),
        )
        for axis in "xy"
    ),
    _place_figure(
        "zone",
        "",
        "zone of this velocity, A to D",
        needs=("vibration", "moves", "zones"),
        kind="text",
        differs=False,
    ),
    _place_figure(
        "kurtosis",
        "1",
        "fourth moment over the square of the variance of the acceleration of {place}, 3 for Gauss; of a frame, of the "
        "force on it; of x and y the direction with the larger root mean square",
        null=NOTHING,
        tables=(Entry("vibration", "kurtosis", 11),),
    ),
    _place_figure(
        "crest",
        "1",
        "largest size of this signal over its root mean square",
        null=NOTHING,
        tables=(Entry("vibration", "crest", 12),),
    ),
    _place_figure("skewness", "1", "third moment over the variance to 3/2 of this signal", null=NOTHING),
    _motion_figure("band_energy", "m^2/s^4", "mean square of the acceleration of {place} in the band"),
    _motion_figure(
        "envelope_order",
        "m/s^2",
        "amplitude of the envelope of this acceleration in the band at {order} times the crank speed",
    ),
)
