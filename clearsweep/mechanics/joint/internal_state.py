"""Laws that remember: a number beside the motion, kept for every contact from its onset to its separation.

Such a law has the number as its last field, as if it were a parameter.  The state vector holds it after the roots of
penetration, joint by joint, that of the normal law before that of friction; a law is handed its own before it is asked
for anything.  A law without a memory needs no member here, and nothing is compiled for it.
"""

from ..compiled.family import family


@family
def memory(law):
    """Return the size by which what a law remembers is measured, as a tuple of one; () for a law without memory."""


@family
def recalled(law, y, place):
    """Return the law with what it remembers, which stands in the state `y` at `place`."""


@family
def memory_rate(law, slip):
    """Return the rate (per s) of what a law remembers, at sliding speed `slip` (m/s)."""


@memory.member(None)
def _nothing(law):
    return ()


@recalled.member(None)
def _as_it_is(law, y, place):
    return law


@memory_rate.member(None)
def _lasting(law, slip):
    return 0.0
