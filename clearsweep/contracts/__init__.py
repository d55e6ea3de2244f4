"""Data types that all rooms share: a case, a machine, results, and their names and units."""
