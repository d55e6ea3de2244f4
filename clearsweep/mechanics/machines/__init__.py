"""Mechanisms: positions and accelerations of the bodies, and the ideal motion without clearance."""

from . import four_bar, impact_pair, slider_crank, topology

__all__ = ["MECHANISMS"]

#: Every mechanism that a grid can name, by its name; the first is the default.
KINDS = (slider_crank, four_bar, topology, impact_pair)
MECHANISMS = {kind.MECHANISM.name: kind.MECHANISM for kind in KINDS}
