"""Basis of all kernels: code chosen by type, dual numbers, rotations, arrays at fixed addresses."""
