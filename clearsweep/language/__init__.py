"""Errors, units, formatted numbers, expressions and progress: everything that is read from or shown to people."""
