"""Errors, units, numbers as people read them, user-defined figures: all that is said and understood in words."""
