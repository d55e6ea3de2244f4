"""Parameters for any registered law, derived from its description."""

import functools
import math

import numpy as np
import pint
import pytest

from clearsweep.contracts.case import Contact, Friction, Joint, Material, Materials
from clearsweep.mechanics.describe import REFERENCE
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.laws.loss import contact_force
from clearsweep.tracing.objects import machine_code

ASKED = (0.10, 0.20, 0.30, 0.40, 0.50, 0.60, 0.70, 0.80, 0.90, 0.95, 0.99)
SAMPLES = {
    "1": 0.25,
    "N/m": 1e8,
    "N/m^exponent": 6.61e10,
    "N*s/m": 100.0,
    "N*s/m^1.5": 1e4,
    "kg": 0.1,
    "m": 1e-3,
    "m/s": 1e-3,
    "s/m": 10.0,
    "1/m": 1e5,
    "Pa": 5e8,
}
RECIPES = registry.RECIPES


def few(family, *every_day):
    """Return the names of a family for tests that compile a scene for each; `make test-all` runs the others."""
    return [name if name in every_day else pytest.param(name, marks=pytest.mark.slow) for name in names(family)]


def names(family):
    return [name for of, name in RECIPES if of == family]


def takes_restitution(family, name):
    return "restitution" in {field.name for field in RECIPES[family, name].law.fields}


def numbers(law):
    """Return field -> a value in its range; fields with the same unit get increasing values if the law allows it."""
    chosen, seen = {}, {}
    for field in law.fields:
        if field.name in law.one_of[1:]:  # in place of the first
            continue
        assert field.unit in SAMPLES, f"{law.name}: give the unit {field.unit} a sample"
        seen[field.unit] = seen.get(field.unit, 0) + 1
        chosen[field.name] = SAMPLES[field.unit] * seen[field.unit] if field.default is None else field.default
        assert field.contains(chosen[field.name])
    for order in law.orders:
        chosen[order.low], chosen[order.high] = sorted((chosen[order.low], chosen[order.high]))
    return chosen


def joint(law="hertz", elastic="power", friction=None, **changes):
    """Return a joint of a case with these laws; `changes` replaces any of their parameters."""
    return resolved(written(law, elastic, friction, **changes))


def resolved(section):
    """Return a joint section in SI as a joint of a case."""
    contact, friction = dict(section["contact"]), dict(section.get("friction", {}))
    material = contact.pop("material", None)
    return Joint(
        "rod-slider",
        contact=Contact(contact.pop("law"), contact.pop("elastic", None), contact, material and materials(material)),
        friction=Friction(friction.pop("law"), friction) if friction else None,
        **{key: value for key, value in section.items() if key not in ("contact", "friction")},
    )


def materials(section):
    """Return the materials of a section in SI: one for both bodies, or bearing's and journal's."""
    return Materials(*(Material(**section.get(body, section)) for body in ("bearing", "journal")))


STEEL = {"young": 207e9, "poisson": 0.3}


def written(law="hertz", elastic="power", friction=None, **changes):
    """Return the joint in the form of a grid file, in SI."""
    contact = {"law": law} | numbers(RECIPES["law", law].law)
    section = {key: getattr(REFERENCE, key) for key in ("clearance", "bearing_radius", "length")}
    if RECIPES["law", law].law.uses_elastic:
        contact |= {"elastic": elastic} | numbers(RECIPES["elastic", elastic].law)
        contact["material"] = STEEL
    if friction:
        section["friction"] = {"law": friction} | numbers(RECIPES["friction", friction].law)
    for part in (contact, section, section.get("friction", {})):
        part |= {key: value for key, value in changes.items() if key in part}
    return section | {"contact": contact}


def force(elastic, pen, **changes):
    """Return the elastic force (N) of a named law in the reference joint."""
    return elastic_force(RECIPES["elastic", elastic].make(joint(elastic=elastic, **changes)), pen)


UNITS = pint.UnitRegistry()


@functools.cache
def length_power(unit, exponent=1.5):
    """Return the power of a length in a unit."""
    text = unit.replace("^exponent", f"^{exponent}").replace("^", "**")
    return float(UNITS(text).dimensionality.get("[length]", 0)) if unit != "1" else 0.0


def in_millimetres(section):
    """Return a joint with units in which a length has a thousand times its value in metres."""
    units = {"bearing_radius": "m", "clearance": "m", "length": "m", "young": "Pa", "poisson": "1"}
    for recipe in RECIPES.values():
        units |= {field.name: field.unit for field in recipe.law.fields if recipe.law.family == "friction"}
    contact, friction = section["contact"], section.get("friction", {})
    for family, words in (("law", contact), ("elastic", contact), ("friction", friction)):
        chosen = words.get("law" if family != "elastic" else "elastic")
        if chosen:
            units |= {field.name: field.unit for field in RECIPES[family, chosen].law.fields}

    def scaled(part):
        return {
            key: scaled(value)
            if isinstance(value, dict)
            else value
            if isinstance(value, str)
            else value * 1e3 ** length_power(units[key], contact.get("exponent", 1.5))
            for key, value in part.items()
        }

    return resolved(scaled(section))


_elastic, _contact, _friction = map(machine_code, (elastic_force, contact_force, friction_force))


def compiled_elastic(term, pens):
    """Return the elastic forces of compiled code."""
    return np.array([_elastic(term, float(pen)) for pen in pens])


def compiled_contact(law, term, pen, rates, onset_rate):
    """Return the forces of compiled code over the rates."""
    return np.array([_contact(law, term, float(pen), float(rate), float(onset_rate))[0] for rate in rates])


def compiled_friction(term, normal, slips):
    """Return the tangential forces of compiled code."""
    return np.array([_friction(term, float(normal), float(slip)) for slip in slips])


def all_finite(values):
    return all(math.isfinite(value) for value in values)
