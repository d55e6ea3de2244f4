"""Wear laws and contact pressures, one block per law; accumulation of the wear of a step."""
