"""Compiled numerics: contact laws, joints, mechanisms and the integrator.  Imports numpy, numba and math alone."""
