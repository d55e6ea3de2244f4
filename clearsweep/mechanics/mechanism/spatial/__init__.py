"""Machines in space whose bodies hang on each other in a tree: what the joints with clearance leave of their loops.

A body hangs on the ground or on another one by a joint without clearance: `form` has the kinds.  What is left after
every loop is opened by a clearance has no constraints, so there are as many coordinates as degrees of freedom, but for
the length of quaternions.
"""

from .build import build, seats
from .spanning_tree import UntiedError, spanning_tree

__all__ = ["UntiedError", "build", "seats", "spanning_tree"]
