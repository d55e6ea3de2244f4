"""Recommendations and remarks on the values of a case."""
