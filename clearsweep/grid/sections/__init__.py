"""Sections of a grid that choose, add or assess cases."""
