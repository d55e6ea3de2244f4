"""Wear laws and the pressures they act on, one block a law; how the wear of a step is entered."""
