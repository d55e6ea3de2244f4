"""Which scenes can go side by side: those whose formulas take no decision and need nothing that lanes do not know.

A law, or a mechanism, whose code branches on numbers is integrated for one case at a time; nothing has to be declared.
Where a formula is to choose all the same, it does so by `where` or `either`, see `compiled.choosing`.
"""

import dis
import itertools
import math
import types

from .compiled.lanes import TAUGHT
from .joint.contract import internal_rates
from .joint.dry import Joint
from .joint.elastic.contract import elastic_energy, elastic_force, energy_stiffness
from .joint.friction.contract import friction_force, static_limit
from .joint.loss.contract import awaits_mass, contact_force, with_mass
from .mechanism.contract import accelerate, energy, gaps, impact_masses, output_error, place

OF_MECHANISMS = (place, gaps, accelerate, impact_masses, energy, output_error)
OF_LAWS = (contact_force, elastic_force, elastic_energy, energy_stiffness, friction_force, with_mass, awaits_mass)
UNKNOWN = ("%", "//")
ROOM, COMPILED = __package__, f"{__package__}.compiled"


def carried(scene) -> bool:
    """Return whether scenes of the type of `scene` can go side by side."""
    laws = [law for joint in scene.joints for law in _terms(joint)]
    return (
        all(type(joint) is Joint for joint in scene.joints)
        and not any(type(law) in family.members for law in laws for family in (internal_rates, static_limit))
        and not any(branches(family.body_of(scene.mechanism)) for family in OF_MECHANISMS)
        and not any(branches(family.body_of(law)) for law in laws for family in OF_LAWS if type(law) in family.members)
    )


def _terms(joint):
    """Yield the laws in nested tuples."""
    for part in joint:
        if isinstance(part, tuple):
            yield part
            yield from _terms(part)


def branches(function) -> bool:
    """Return whether a kernel, or one that it calls, takes a decision, or does what numbers in lanes do not know.

    Laws that it calls are asked themselves.
    """
    steps = list(dis.get_instructions(function))
    if any("JUMP_IF" in step.opname or "_IF_" in step.opname or step.argrepr in UNKNOWN for step in steps):
        return True
    of_math = {name.argval for module, name in itertools.pairwise(steps) if module.argval == "math"}
    if any(callable(one) and one not in TAUGHT for one in (getattr(math, name, None) for name in of_math)):
        return True
    called = (function.__globals__.get(name) for name in function.__code__.co_names)
    return any(_asked(one) and any(map(branches, _bodies(one))) for one in called)


def _asked(one) -> bool:
    """Return whether what a name stands for is a kernel of this package whose decisions are its own."""
    ours = isinstance(one, types.FunctionType) and one.__module__.startswith(ROOM)
    return ours and not one.__module__.startswith(COMPILED) and one not in OF_LAWS


def _bodies(one):
    """Return the bodies of a kernel or of a family."""
    return [body for entered in one.members.values() for _, body in entered] if hasattr(one, "members") else [one]
