"""What every kernel rests on: code chosen by type, dual numbers, angles, the cache of compiled code."""
