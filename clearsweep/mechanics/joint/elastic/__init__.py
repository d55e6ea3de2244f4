"""Elastic laws: the normal force over penetration, one block a law."""
