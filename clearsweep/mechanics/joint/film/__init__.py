"""Lubricating films: the force of the oil between journal and bearing, its pressure, the couples of its shear."""
