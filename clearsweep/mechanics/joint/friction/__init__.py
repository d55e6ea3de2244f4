"""Friction laws: the tangential force over sliding speed, one block a law."""
