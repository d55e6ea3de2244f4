"""Answers of a run: judges its cases against limits, compares designs, and words the result in one place."""
