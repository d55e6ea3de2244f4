"""A run prepared for reading: its axes, cases and figures, in units for people."""
