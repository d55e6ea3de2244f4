"""All that is compiled, and its description with it.  Imports numpy, llvmlite, scipy and the catalogue."""

from .trace import cache

cache.prepare()  # before anything here imports the compiler
