"""Figures of merit of films, in column order, before those of wear; see `figures`."""

import math
from typing import Any

from ...contracts.catalogue import Entry, Figure
from ...mechanics.laws.film import film_pressure
from .sums import DryLoadRatio, DryTime, Mean
from .window import Window


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


FILM = (
    Figure(
        "force_peak_dry",
        "N",
        "largest dry share of the normal force, located",
        of="joint",
        needs=("film",),
        value=lambda window, index: window.totals.joint[index].dry_max,
        tables=(Entry("film", "dry force peak", 8),),
    ),
    Figure(
        "film_thickness_min",
        "m",
        "least film thickness, clearance minus eccentricity; 0 where the surfaces touch",
        of="joint",
        needs=("film",),
        value=film_thickness,
        tables=(Entry("film", "least film", 1), Entry("effects", "least film", 7)),
    ),
    Figure(
        "film_pressure_max",
        "Pa",
        "largest pressure in the film; null: the law has no pressure",
        of="joint",
        needs=("film",),
        value=pressure,
        tables=(Entry("film", "pressure", 2),),
    ),
    Figure(
        "film_fraction",
        "1",
        "share of the window's time with load on the film only: 1 - dry_fraction",
        of="joint",
        needs=("film",),
        sums=DryTime(above=False),
        tables=(Entry("film", "time on film alone", 4),),
    ),
    Figure(
        "dry_fraction",
        "1",
        "share of the window's time with a dry force above 0.1 % of the mean normal force",
        of="joint",
        needs=("film",),
        sums=DryTime(above=True),
        tables=(Entry("film", "time on dry contact", 5),),
    ),
    Figure(
        "dry_load_share",
        "1",
        "mean dry force over mean normal force (film and dry); null: no contact behind the film",
        of="joint",
        needs=("film",),
        sums=DryLoadRatio("dry_force_time", "load_time"),
        tables=(Entry("film", "dry share of the load", 5),),
    ),
    Figure(
        "film_limit_fraction",
        "1",
        "share of the window's time at an eccentricity beyond film.limit; the formula is then evaluated at the limit",
        of="joint",
        needs=("film",),
        sums=Mean("clamped_time"),
        tables=(Entry("film", "time past its limit", 6),),
    ),
    Figure(
        "film_loss",
        "W",
        "mean power loss of the film, shear included",
        of="joint",
        needs=("film",),
        sums=Mean("film_energy"),
        tables=(Entry("film", "loss", 3),),
    ),
    Figure(
        "film_temperature",
        "K",
        "temperature of the oil, given or from its heat balance; null: neither",
        of="joint",
        needs=("film",),
        value=lambda window, index: window.case.joints[index].film.temperature,
        tables=(Entry("film", "temperature", 10),),
    ),
    Figure(
        "film_temperature_ci",
        "K",
        "half-width of the 95 % interval of a temperature from a heat balance",
        of="joint",
        needs=("film",),
        differs=False,
        tables=(Entry("film", "95 % interval, half", 11),),
    ),
    Figure(
        "film_viscosity",
        "Pa*s",
        "dynamic viscosity of the oil at its temperature",
        of="joint",
        needs=("film",),
        value=lambda window, index: window.case.joints[index].film.viscosity,
        differs=False,
        tables=(Entry("film", "viscosity", 12),),
    ),
    Figure(
        "film_taylor",
        "1",
        "largest Taylor number of the film, at clearance and largest speed of its surfaces; laminar below about 41",
        of="joint",
        needs=("film",),
        value=taylor,
        tables=(Entry("film", "Taylor number", 9),),
    ),
)
