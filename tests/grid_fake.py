"""A small catalogue of laws and a demo grid, for tests that run no compiled code."""

import copy
from pathlib import Path

from clearsweep import grid, simulation
from clearsweep.contracts.catalogue import Order
from clearsweep.grid import Field, Law

CONFIGS = Path(__file__).parent.parent / "configs"
RESTITUTION = Field("restitution", "1", "wanted restitution", 0.0, 1.0, high_open=False)
COEFFICIENT = Field("coefficient", "1", "friction coefficient", low_open=False)


def law(family, name, *fields, uses_elastic=True):
    return Law(family, name, "", "", "", fields, uses_elastic)


CATALOGUE = simulation.catalogue()._replace(
    laws=(
        law("law", "hertz"),
        *(law("law", name, RESTITUTION) for name in ("lankarani-nikravesh", "hunt-crossley", "flores", "exact")),
        law(
            "law",
            "kelvin-voigt",
            Field("stiffness", "N/m", "spring"),
            Field("damping", "N*s/m", "damper", low_open=False),
            uses_elastic=False,
        ),
        law(
            "elastic",
            "power",
            Field("stiffness", "N/m^exponent", "contact stiffness"),
            Field("exponent", "1", "exponent of the penetration", default=1.5),
        ),
        law("friction", "tanh", COEFFICIENT, Field("velocity_scale", "m/s", "scale of the sliding speed")),
        law(
            "friction", "ambrosio", COEFFICIENT, Field("v0", "m/s", "dead band"), Field("v1", "m/s", "full slip")
        )._replace(orders=(Order("v0", "v1", "friction grows from v0 to v1"),)),
        law("wear", "archard"),
        law("pressure", "mean"),
        law("pressure", "hertz-line", Field("pressure_modulus", "Pa", "E* of both bodies", optional=True))._replace(
            needs=("modulus",)
        ),
    )
)
TEXT = """\
name: demo
mechanism:
  type: slider-crank
  crank:  {length: 50 mm, mass: 0.30 kg, inertia: 1e-4 kg*m^2}
  rod:    {length: 120 mm, mass: 0.21 kg, inertia: 2.5e-4 kg*m^2, center: 60 mm}
  slider: {mass: 0.14 kg}
drive: {speed: 5000 rpm}
joints:
  rod-slider:
    clearance: 0.5 mm
    bearing_radius: 10 mm
    length: 20 mm
    contact:
      law: lankarani-nikravesh
      stiffness: 6.61e10 N/m^1.5
      restitution: 0.9
    friction: {law: ambrosio, coefficient: 0.05, v0: 1 mm/s, v1: 10 mm/s}
    wear: {law: archard, coefficient: 2e-14 m^2/N}
simulate: {revolutions: 10, discard: 2, tolerance: 1e-8}
save: {orbits: last, samples: 720}
"""
JOINT = "joints.rod-slider"
CONTACT = f"{JOINT}.contact"


def load(source, overrides=None):
    return grid.load(source, CATALOGUE, overrides)


def sweep(base, axes):
    return copy.deepcopy(base) | {"sweep": axes}


def ids(cases):
    return [cases.case_id(k) for k in range(len(cases))]
