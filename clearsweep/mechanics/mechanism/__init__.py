"""Mechanisms: where the bodies are, how they accelerate, what they would do without clearance."""

from . import four_bar, impact_pair, slider_crank, topology

__all__ = ["MECHANISMS"]

#: Every mechanism that a grid can name, by its name; the first one is meant where none is named.
KINDS = (slider_crank, four_bar, topology, impact_pair)
MECHANISMS = {kind.MECHANISM.name: kind.MECHANISM for kind in KINDS}
