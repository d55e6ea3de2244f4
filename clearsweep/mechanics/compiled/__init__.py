"""What every kernel stands on: code chosen by type, dual numbers, angles, the cache of compiled code."""
