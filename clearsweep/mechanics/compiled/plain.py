"""Whether kernels run as plain Python, which is slow but can be looked into: where NUMBA_DISABLE_JIT is set, not 0."""

import os

_PLAIN = [os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0")]


def is_plain() -> bool:
    """Return whether nothing is compiled."""
    return _PLAIN[0]


def run_plain(wanted: bool) -> bool:
    """Let nothing be compiled from here on, or let it; return what was so far."""
    before, _PLAIN[0] = _PLAIN[0], wanted
    return before
