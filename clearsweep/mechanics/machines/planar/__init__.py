"""Planar machines: rigid bodies with revolute and prismatic joints in any topology, each joint ideal or open."""

from .build import build, channels, crank_speed, discontinuity_times, ideal, ideal_reactions
from .closure import ClosureError, MobilityError
from .ideal import AlwaysEqual, ideal_of, machine_key, rival_assembly, slot_travel

__all__ = [
    "AlwaysEqual",
    "ClosureError",
    "MobilityError",
    "build",
    "channels",
    "crank_speed",
    "discontinuity_times",
    "ideal",
    "ideal_of",
    "ideal_reactions",
    "machine_key",
    "rival_assembly",
    "slot_travel",
]
