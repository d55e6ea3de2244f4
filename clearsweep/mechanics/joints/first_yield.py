"""Approach speed at which the contact of a joint first yields, from the joint's elastic law.

Two cylinders yield below their surface at a largest pressure p0 of 1.67 times the yield strength, a ball and a socket
at 1.6 times it (Johnson 1985, Contact Mechanics, section 6.1).  The load that gives this pressure is Hertz's for a
narrow contact.  For a wide contact it is the load of the wide arc of `compatible`, and for a ball the
load 2/3 pi R_b^2 p0 of a pressure p0 cos(angle) over half of the bore.  An impact reaches this load if
the elastic energy W there equals that of the approach, v = sqrt(2 W / m).
"""

import math
from typing import Any

import numpy as np

from ...contracts.case import Joint
from ..laws.contract import RECIPES
from ..laws.cylinders import END_DEPTH, END_FORCE, END_Q
from ..laws.elastic import elastic_energy, plane_strain_modulus, relative_radius, static_penetration

LINE, BALL = "line", "ball"
LINE_PRESSURE, BALL_PRESSURE = 1.67, 1.6  # largest pressure over yield strength at first yield
END_PRESSURE = (1.0 + END_DEPTH) * math.sqrt(END_Q)  # p0 R_b / (E* c) at the end of the wide arc's formula


def contact_kind(joint: Joint) -> str:
    """Return the kind of a joint's contact, line or ball, or '' if its laws are neither or plastic."""
    law = RECIPES["law", joint.contact.law].law if joint.is_dry else None
    if law is None or law.yields or not law.uses_elastic or joint.is_guide or joint.is_spatial:
        return ""
    return RECIPES["elastic", joint.contact.elastic].law.contact if joint.contact.elastic else ""


def load_at_pressure(kind: str, pressure: float, joint: Joint, modulus: float) -> float:
    """Return the load (N) of a joint at a largest pressure (Pa) in a contact of this kind; modulus : E*, Pa."""
    radius = relative_radius(joint)
    assert joint.bearing_radius is not None  # it determines the relative radius
    if kind == BALL:
        narrow_load = math.pi**3 * radius**2 * pressure**3 / (6.0 * modulus**2)
        return min(narrow_load, 2.0 / 3.0 * math.pi * joint.bearing_radius**2 * pressure)
    assert joint.length is not None  # line contacts have a length
    ratio = pressure * joint.bearing_radius / (modulus * joint.clearance)
    scale_force = modulus * joint.length * joint.clearance
    if ratio >= END_PRESSURE:  # beyond, the pressure keeps its shape, nearly a cosine
        return 0.5 * math.pi * END_FORCE * scale_force * ratio / END_PRESSURE
    low, high = 0.0, END_Q
    for _ in range(200):
        midpoint = 0.5 * (low + high)
        low, high = (midpoint, high) if math.sqrt(midpoint) * _radius_ratio(midpoint) < ratio else (low, midpoint)
    return 0.5 * math.pi * scale_force * _radius_ratio(high) * high * (2.0 - high)


def _radius_ratio(q: float) -> float:
    """Return (c + pen) / c at `q`, see `compatible`; 1 at 0."""
    return 1.0 / (1.0 - q * (math.log(4.0 / q) - 1.0)) if q else 1.0


def yield_energy(joint: Joint, elastic: Any) -> float | None:
    """Return the elastic energy (J) at first yield of a joint's contact, or None if unknown.

    elastic : its compiled elastic law, including rough surfaces
    """
    kind, strength, radius = contact_kind(joint), joint.strength, joint.bearing_radius
    if not kind or strength is None or radius is None or (kind == LINE and joint.length is None):
        return None
    modulus = _modulus(joint, kind)
    if modulus is None:
        return None
    load = load_at_pressure(kind, (BALL_PRESSURE if kind == BALL else LINE_PRESSURE) * strength, joint, modulus)
    return float(elastic_energy(elastic, static_penetration(elastic, load)))


def _modulus(joint: Joint, kind: str) -> float | None:
    """Return E* (Pa) of a joint, from Hertz's stiffness if no material is given, or None if unknown."""
    contact = joint.contact
    if contact.material:
        return plane_strain_modulus(contact.material)
    stiffness = contact.values.get("stiffness")
    if kind == BALL and stiffness and contact.values.get("exponent") == 1.5:
        return 0.75 * stiffness / math.sqrt(relative_radius(joint))
    return None


def largest_mass(masses: np.ndarray) -> float | None:
    """Return the largest effective mass (kg) over all directions from those (3,) at 0, 45 and 90 degrees, or None.

    1 / m = n^T Y n of a symmetric Y, whose smaller eigenvalue belongs to the largest mass.
    """
    if not np.all(masses > 0.0):
        return None
    x, diagonal, y = 1.0 / masses
    coupling = diagonal - 0.5 * (x + y)
    smallest_inverse = 0.5 * (x + y) - math.hypot(0.5 * (x - y), coupling)
    return float(1.0 / smallest_inverse) if smallest_inverse > 1e-12 * (x + y) else None
