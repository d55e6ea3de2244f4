"""clearsweep simulates mechanisms with joint clearance: their forces, their wear and their position errors.

Public names are resolved on first use, so that `clearsweep --help` loads neither llvmlite nor pandas.
"""

import importlib
import os
from typing import Any

if os.name == "nt":
    raise ImportError(
        "clearsweep does not run on Windows, which lacks the file locks and signals that it relies on; "
        "use the Windows Subsystem for Linux (WSL 2)"
    )
os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")  # gives memory back; Arrow's own allocators keep 40 MB
os.environ.setdefault("JE_ARROW_MALLOC_CONF", "background_thread:false")  # of an allocator that is not used

__version__ = "0.1.0"

#: Changes whenever the numbers a case gives change; it is part of every case's identity.
MODEL_VERSION = "30"

_HOMES = {
    "load_case": "simulation",
    "simulate": "simulation",
    "sweep": "sweeping.sweep",
    "merge": "sweeping.merge",
    "open": "report",
    "Trajectory": "contracts.results",
    "ClearsweepError": "language.errors",
    "InputError": "language.errors",
    "DirectoryError": "language.errors",
    "StorageError": "language.errors",
}
__all__ = [
    "MODEL_VERSION",
    "ClearsweepError",
    "DirectoryError",
    "InputError",
    "StorageError",
    "Trajectory",
    "__version__",
    "load_case",
    "merge",
    "open",
    "simulate",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'clearsweep' has no attribute {name!r}; it has {', '.join(__all__)}")
    return getattr(importlib.import_module(f"clearsweep.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
