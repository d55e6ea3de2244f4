"""Elastic laws: normal force as a function of penetration, one block per law."""
