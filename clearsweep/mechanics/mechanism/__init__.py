"""Mechanisms: where the bodies are, how they accelerate, what they would do without clearance."""

from . import impact_pair, slider_crank

__all__ = ["MECHANISMS"]

#: Every mechanism that a grid can name, by its name; the first one is meant where none is named.
MECHANISMS = {mechanism.name: mechanism for mechanism in (slider_crank.MECHANISM, impact_pair.MECHANISM)}
