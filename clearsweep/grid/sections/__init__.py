"""Sections of a grid that choose, add or judge cases."""
