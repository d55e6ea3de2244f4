"""Determines whether kernels run as plain Python, slow but debuggable: if CLEARSWEEP_DISABLE_JIT is set and not 0."""

import os

_PLAIN = os.environ.get("CLEARSWEEP_DISABLE_JIT", "0") not in ("", "0")


def is_plain() -> bool:
    """Return whether nothing is compiled."""
    return _PLAIN
