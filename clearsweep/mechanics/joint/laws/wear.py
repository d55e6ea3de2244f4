"""Wear laws and the pressures they act on."""

import math

from ..wear.archard import Archard
from ..wear.pressure import HertzLine
from .material import plane_strain_modulus, relative_radius
from .recipe import enter


def _archard(joint):
    wear, contact = joint.wear, joint.contact
    radius = relative_radius(joint)
    if contact.material:
        modulus = plane_strain_modulus(contact.material)
    else:
        modulus = 3.0 * contact.values["stiffness"] / (4.0 * math.sqrt(radius))
    return Archard(
        wear.values["bearing_coefficient"],
        wear.values["journal_coefficient"],
        float(wear.bins),
        joint.length,
        HertzLine(modulus, radius),
    )


enter(
    "wear",
    "archard",
    "depth grows with pressure and sliding",
    "dh = k p |slip| dt",
    "Archard 1953, J. Appl. Phys. 24:981",
    _archard,
    notes="k in m^2/N; 1 mm^3/(N m) = 1e-9 m^2/N.  k times the hardness must be far below 1.",
)
enter(
    "pressure",
    "hertz-line",
    "Hertzian line contact",
    "half-width a = sqrt(4 f R / (pi E*)), f = F / length",
    "Johnson 1985, Contact Mechanics, section 4.2(c)",
    _archard,
    notes="E* from `material`; without it from the stiffness of the power law, E* = 3 K / (4 sqrt(R)).",
)
