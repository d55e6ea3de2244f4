"""Data types that all packages share: a case, a machine, results, and their names and units."""
