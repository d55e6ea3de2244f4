"""Mechanisms: where the bodies are, how they accelerate, what they would do without clearance."""

from . import impact_pair, slider_crank  # noqa: F401 - each enters its mechanism
from .contract import MECHANISMS

__all__ = ["MECHANISMS"]
