"""Figures of forces, positions and films in the window of a run."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from ...contracts.catalogue import ENDLESS, Figure, figure, shown
from ...mechanics.joints.spatial import jam_angle
from ...mechanics.laws.film import film_pressure
from .sums import DryLoadRatio, DryTime, Mean, PerRevolution
from .window import Window

# Figures of merit of single revolutions: quantiles of their force peaks, and the period of the motion.

PEAK_TOLERANCE = 1e-9  # relative difference below which two peaks are the same
of_joint = partial(figure, of="joint")
of_turns = partial(of_joint, needs=("turns",))


def ideal_peak(window: Window, index: int) -> float | None:
    """Return the largest reaction (N) of the ideal mechanism."""
    return window.ideal.get(window.case.joints[index].name_in_machine)


def load_peak(window: Window, index: int) -> float:
    """Return the largest resultant (N) of normal and friction force."""
    joint = window.totals.joint[index]
    return float(max(joint.force_max, math.sqrt(joint.load_max)))


def peak_ratio(window: Window, index: int) -> float | None:
    """Return the largest resultant over the largest reaction without clearance, or None if there is no reaction."""
    ideal = ideal_peak(window, index)
    return load_peak(window, index) / ideal if ideal else None


def peak_turn(window: Window, index: int) -> int | None:
    """Return the revolution of the largest normal force, or None if that revolution is incomplete."""
    highest, largest = window.spreads[index].highest, window.totals.joint[index].force_max
    return highest[1] if highest and highest[0] >= (1.0 - PEAK_TOLERANCE) * largest > 0.0 else None


def peak_quantile_figures(name: str, text: str, heading: str) -> tuple[Figure, ...]:
    """Return the figures of a quantile of force peaks per revolution: its value and the ends of its interval."""

    def value(end: str) -> Callable[[Window, int], float | None]:
        return lambda window, index: getattr(getattr(window.spreads[index], name), end)

    column = f"force_peak_{name}"
    end = f"end of the 95 % interval of {column}; null: too few revolutions"
    return (
        of_turns(f"{column} [N]: {text}", value=value("value"), tables=shown(heading, forces=3)),
        of_turns(f"{column}_low [N]: lower {end}", value=value("low"), differs=False),
        of_turns(f"{column}_high [N]: upper {end}", value=value("high"), differs=False),
    )


PEAKS = (
    of_joint(
        "force_peak_revolution [1]: number of the revolution with the largest normal force, from 1 and including "
        "`discard`; null: no complete revolution has it",
        needs=("turns", "error_check"),
        kind="int",
        value=peak_turn,
        differs=False,
    ),
    *peak_quantile_figures(
        "median", "median of the largest normal forces of the window's revolutions", "median of revolutions"
    ),
    *peak_quantile_figures(
        "p95", "95 % quantile of the largest normal forces of the window's revolutions", "95 % of revolutions"
    ),
    of_turns(
        "force_peak_million [N]: largest normal force to expect in 10^6 revolutions (median), by extreme-value "
        "statistics of the window's revolutions; of a periodic motion, the largest of its last three periods; null: "
        "fewer than 100 independent revolutions",
        value=lambda window, index: window.spreads[index].of_million.value,
        differs=False,
        tables=shown("expected in 10⁶ revolutions", forces=3, if_any=True),
    ),
    of_turns(
        "force_peak_million_high [N]: normal force that the largest of 10^6 revolutions exceeds with a probability of "
        "2.5 %; null as for the median",
        value=lambda window, index: window.spreads[index].of_million.high,
        differs=False,
    ),
    of_joint(
        "load_peak [N]: largest resultant of normal and friction force in the window, located",
        value=load_peak,
        tables=shown("load peak", forces=3, sample=3, case=3),
    ),
    of_turns(
        "force_peak_ratio [1]: load_peak over force_peak_ideal, both resultants; null: the latter is zero or null",
        value=peak_ratio,
        tables=shown("load / ideal", forces=5, sample=3, case=4),
    ),
)
#: Figures from the state at the ends of revolutions.
PERIOD = (
    figure(
        "period [1]: revolutions after which the motion repeats; null: no repetition within the window",
        needs=("turns",),
        kind="int",
        value=lambda window, _: window.repetition and window.repetition.period,
        differs=False,
        tables=shown("period", certainty=2),
    ),
    figure(
        "periodic_from [1]: revolutions of the run, `discard` included, after which the motion repeats itself with "
        "this period; null: as for the period",
        needs=("turns",),
        value=lambda window, _: window.repetition and window.repetition.begin,
        differs=False,
        tables=shown("periodic from (rev.)", certainty=2),
    ),
)


# Figures of a start by a motor: its duration, the least speed after it, and the largest forces during it.


def finite(value: float) -> float | None:
    """Return a value, or None if it is not finite: it was not reached, or has no limit."""
    return float(value) if math.isfinite(value) else None


def max_force_to_start(window: Window, index: int) -> float | None:
    """Return the largest normal force (N) in a joint until the start-up time, or None if this is not in the window."""
    mechanism_totals = window.totals.mechanism
    is_in_window = mechanism_totals.window_start < mechanism_totals.target_time < math.inf
    return float(window.totals.joint[index].force_max_to_target) if is_in_window else None


START_UP_TIME = figure(
    "start_up_time [s]: time until a free crank first reaches 95 % of its motor's no-load speed; 0: it starts faster; "
    "null: not reached, or no such speed",
    needs=("free",),
    value=lambda window, _: finite(window.totals.mechanism.target_time),
    differs=False,
    tables=shown("start-up time", output=6),
)
CRANK_SPEED_AFTER = figure(
    "crank_speed_after [rad/s]: least speed of a free crank after `start_up_time`; null: not reached, or no such speed",
    needs=("free",),
    value=lambda window, _: finite(window.totals.mechanism.min_speed_after_target),
    differs=False,
    tables=shown("least crank speed after the start", output=7),
)
FORCE_PEAK_START = of_joint(
    "force_peak_start [N]: largest normal force until `start_up_time`, to the end of this step; null: not reached, or "
    "before the window",
    needs=("free",),
    value=max_force_to_start,
    differs=False,
)


# Figures of spatial joints: tilt, edge loading and flange contacts.


def edge_load_share(window: Window, index: int) -> float:
    """Return the imbalance of wall loads: difference of normal forces over their sum, both averaged over time."""
    joint = window.totals.joint[index]
    return float(joint.uneven_time / joint.force_time) if joint.force_time else 0.0


of_spatial = partial(of_joint, needs=("spatial",))
SPATIAL = (
    of_spatial(
        "tilt_max [rad]: largest angle between the axes of bearing and journal",
        value=lambda window, index: window.totals.joint[index].tilt_max,
        tables=shown("tilt", forces=20),
    ),
    of_spatial(
        "tilt_limit [rad]: tilt at which the journal jams between the walls; null: no limit",
        value=lambda window, index: finite(jam_angle(window.joints[index])),
        differs=False,
        null=ENDLESS,
        tables=shown("tilt that jams", forces=21),
    ),
    of_spatial(
        "edge_load_share [1]: difference of the walls' normal forces over their sum, as means over time; 0: even, 1: "
        "one edge carries all",
        value=edge_load_share,
        tables=shown("edge load share", forces=22),
    ),
    of_joint(
        "axial_force_peak [N]: largest normal force at a flange, located",
        needs=("spatial", "axial"),
        value=lambda window, index: window.totals.joint[index].axial_force_max,
        tables=shown("axial force peak", forces=23),
    ),
    of_joint(
        "axial_impacts_per_rev [1]: contact onsets at the flanges in the window per revolution",
        needs=("spatial", "axial"),
        sums=PerRevolution("axial_onsets"),
        tables=shown("axial impacts{per_rev}", forces=24),
    ),
)


# Figures of merit of films, in column order, before those of wear; see `figures`.


def film_thickness(window: Window, index: int) -> float:
    """Return the least film thickness (m) in a joint, 0 if its surfaces touch."""
    return float(max(-window.totals.joint[index].depth_max, 0.0))


def pressure(window: Window, index: int) -> float | None:
    """Return the largest film pressure (Pa) in a joint, or None if its law has none."""
    joint: Any = window.joints[index]  # mypy takes it for a dry joint
    law = joint.film
    return window.totals.joint[index].pressure_max if type(law) in film_pressure.members else None


def taylor(window: Window, index: int) -> float:
    """Return the largest Taylor number of the flow in the film of a joint: rho U c / mu times sqrt(c / R)."""
    joint: Any = window.case.joints[index]  # a joint with a film has a radius
    film = joint.film
    flow = film.density * window.totals.joint[index].shear_speed_max * joint.clearance / film.viscosity
    return float(flow * math.sqrt(joint.clearance / joint.bearing_radius))


of_film = partial(of_joint, needs=("film",))
FILM = (
    of_film(
        "force_peak_dry [N]: largest dry share of the normal force, located",
        value=lambda window, index: window.totals.joint[index].dry_max,
        tables=shown("dry force peak", film=8),
    ),
    of_film(
        "film_thickness_min [m]: least film thickness, clearance minus eccentricity; 0 where the surfaces touch",
        value=film_thickness,
        tables=shown("least film", film=1, effects=7),
    ),
    of_film(
        "film_pressure_max [Pa]: largest pressure in the film; null: the law has no pressure",
        value=pressure,
        tables=shown("pressure", film=2),
    ),
    of_film(
        "film_fraction [1]: share of the window's time with load on the film only: 1 - dry_fraction",
        sums=DryTime(above=False),
        tables=shown("time on film alone", film=4),
    ),
    of_film(
        "dry_fraction [1]: share of the window's time with a dry force above 0.1 % of the mean normal force",
        sums=DryTime(above=True),
        tables=shown("time on dry contact", film=5),
    ),
    of_film(
        "dry_load_share [1]: mean dry force over mean normal force (film and dry); null: no contact behind the film",
        sums=DryLoadRatio("dry_force_time", "load_time"),
        tables=shown("dry share of the load", film=5),
    ),
    of_film(
        "film_limit_fraction [1]: share of the window's time at an eccentricity beyond film.limit; the formula is "
        "then evaluated at the limit",
        sums=Mean("clamped_time"),
        tables=shown("time past its limit", film=6),
    ),
    of_film(
        "film_loss [W]: mean power loss of the film, shear included",
        sums=Mean("film_energy"),
        tables=shown("loss", film=3),
    ),
    of_film(
        "film_temperature [K]: temperature of the oil, given or from its heat balance; null: neither",
        value=lambda window, index: window.case.joints[index].film.temperature,
        tables=shown("temperature", film=10),
    ),
    of_film(
        "film_temperature_ci [K]: half-width of the 95 % interval of a temperature from a heat balance",
        differs=False,
        tables=shown("95 % interval, half", film=11),
    ),
    of_film(
        "film_viscosity [Pa*s]: dynamic viscosity of the oil at its temperature",
        value=lambda window, index: window.case.joints[index].film.viscosity,
        differs=False,
        tables=shown("viscosity", film=12),
    ),
    of_film(
        "film_taylor [1]: largest Taylor number of the film, at clearance and largest speed of its surfaces; laminar "
        "below about 41",
        value=taylor,
        tables=shown("Taylor number", film=9),
    ),
)
