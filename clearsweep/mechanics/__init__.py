"""All that is compiled, and its description beside it.  Imports numpy, numba, scipy and the catalogue."""

from .compiled import cache

cache.prepare()  # before anything here imports the compiler
