"""Lubricating films: force and pressure of the oil between journal and bearing, and couples from its shear."""
