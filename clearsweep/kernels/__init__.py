"""Compiled numerics: contact laws, joints, mechanisms and the integrator.  Imports numpy, numba and math alone."""

from . import cache

cache.prepare()  # before anything here imports the compiler
