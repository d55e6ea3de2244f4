"""Friction laws: tangential force as a function of sliding speed, one block per law."""
