"""Wear proportional to pressure and sliding distance, or to the work of friction, and its decrease during
running-in."""

import math
from typing import NamedTuple

from ...contracts.case import Joint
from ...contracts.catalogue import Law
from ..laws.contract import compile_law, register
from .contract import MAX_BINS, wear_rate


class Archard(NamedTuple):
    """dh = k p |v| dt."""

    bearing_coefficient: float  # m^2/N
    journal_coefficient: float  # m^2/N
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, cumulative_pressure
    pv_limit: float  # W/m^2, inf: none


@wear_rate.member(Archard)
def _wear_rate_archard(law, sliding):
    pressure_times_speed = sliding.pressure_integral * sliding.sliding_speed
    return law.bearing_coefficient * pressure_times_speed, law.journal_coefficient * pressure_times_speed


class Energy(NamedTuple):
    """dh = alpha tau |v| dt, with the work of friction distributed like the pressure."""

    bearing_coefficient: float  # m^3/J
    journal_coefficient: float  # m^3/J
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, cumulative_pressure
    pv_limit: float  # W/m^2, inf: none


@wear_rate.member(Energy)
def _wear_rate_energy(law, sliding):
    return law.bearing_coefficient * sliding.friction_power, law.journal_coefficient * sliding.friction_power


class RunningIn(NamedTuple):
    """k = steady + (initial - steady) exp(-s / distance), s the sliding distance in contact."""

    law: tuple  # with coefficients of 1
    bearing_coefficients: tuple  # steady, initial: m^2/N or m^3/J
    journal_coefficients: tuple
    distance: float  # m
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, cumulative_pressure
    pv_limit: float  # W/m^2


@wear_rate.member(RunningIn)
def _wear_rate_running_in(law, sliding):
    bearing_rate, journal_rate = wear_rate(law.law, sliding)
    fresh_fraction = math.exp(-sliding.sliding_distance / law.distance)
    (steady, initial), (steady_journal, initial_journal) = law.bearing_coefficients, law.journal_coefficients
    return (
        (steady + (initial - steady) * fresh_fraction) * bearing_rate,
        (steady_journal + (initial_journal - steady_journal) * fresh_fraction) * journal_rate,
    )


def _make_wear_law(law_type, joint: Joint):
    """Return the compiled wear law of a joint, within RunningIn if the coefficient changes during running-in."""
    wear = joint.wear
    pressure, bins = compile_law("pressure", wear.pressure, joint), float(min(wear.bins, MAX_BINS))
    common_fields = bins, joint.length, pressure, wear.values.get("pv_limit", math.inf)
    bearing, journal = wear.coefficients().values()
    if wear.running_in is None:
        return law_type(*bearing, *journal, *common_fields)
    return RunningIn(law_type(1.0, 1.0, *common_fields), bearing, journal, wear.running_in["distance"], *common_fields)


register(
    Law(
        "wear",
        "archard",
        "depth proportional to pressure and sliding distance",
        "dh = k p |slip| dt",
        "Archard 1953, J. Appl. Phys. 24:981",
        notes="k in m^2/N; 1 mm^3/(N m) = 1e-9 m^2/N.  k times the hardness must be far below 1.  A coefficient "
        "without a unit, with a hardness, is that product, K = k H.",
    ),
    (Archard, RunningIn),
    lambda joint: _make_wear_law(Archard, joint),
)


register(
    Law(
        "wear",
        "energy",
        "depth proportional to the work of friction",
        "dh = alpha tau |slip| dt, tau = p T / N the friction on the area",
        "Fouvry, Liskiewicz, Kapsa, Hannel & Sauger 2003, Wear 255:287, worn volume over dissipated energy; that the "
        "work is spread like the pressure is an assumption",
        needs=("friction",),
        notes="`coefficient` is alpha in m^3/J, the volume worn off a body per work of friction: with Coulomb "
        "friction mu that of archard is mu alpha.  Energy in bristles counts as work until they return it.",
    ),
    (Energy, RunningIn),
    lambda joint: _make_wear_law(Energy, joint),
)
