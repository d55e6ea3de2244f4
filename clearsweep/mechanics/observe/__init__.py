"""Observables at the stages of a step, and histograms of forces."""
