"""All compiled code, with the descriptions of its laws.  Imports numpy, llvmlite, scipy and the catalogue."""

from ..tracing import cache

cache.prepare_cache()  # before anything here imports the compiler
