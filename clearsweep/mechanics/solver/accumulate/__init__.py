"""Accumulation along the steps: time histories, sums, peaks, revolutions."""
