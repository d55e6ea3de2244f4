"""Modes of a contact: what acts, and which events are searched for."""

from ...tracing.compiled.family import kernel

# A mode is a number below 63 whose bits inform the loop; bits from LAWS_OWN on distinguish the modes of a law.
# ACTS: there is a force.  MEETS: apart, search for an onset.  TOUCHES: touching, search for a separation.
ACTS, MEETS, TOUCHES, LAWS_OWN = 1, 2, 4, 8
FREE = MEETS  # apart and without force
PRESSED = ACTS | TOUCHES
# Modes of laws, listed here so that numbers stay unique.
CLIPPED = PRESSED + LAWS_OWN  # penetrating, but the normal force is clipped because it would pull
STUCK = PRESSED + 2 * LAWS_OWN  # pressed, and the surfaces stick
AT_LIMIT_UP = PRESSED + 3 * LAWS_OWN  # as STUCK, but the tangential force has reached its limit, upwards
AT_LIMIT_DOWN = PRESSED + 4 * LAWS_OWN  # the same downwards
STICKING = (STUCK, AT_LIMIT_UP, AT_LIMIT_DOWN)
TOUCHING = tuple(mode for mode in range(63) if mode & TOUCHES)  # all modes of touching surfaces


@kernel
def acts(mode):
    """Return whether a contact in this mode exerts a force."""
    return mode & ACTS != 0


@kernel
def meets(mode):
    """Return whether the surfaces of a contact in this mode are apart and may come to touch."""
    return mode & MEETS != 0


@kernel
def touches(mode):
    """Return whether the surfaces of a contact in this mode touch."""
    return mode & TOUCHES != 0
