"""Errors, units, formatted numbers, expressions and progress: everything that is read from or shown to people."""

from typing import TYPE_CHECKING, Any

__all__ = ["np"]
if TYPE_CHECKING:
    import numpy as np
else:

    class _Numpy:
        """Numpy, loaded by its first use: what reads a grid does without it."""

        def __getattr__(self, name: str) -> Any:
            import numpy

            setattr(self, name, getattr(numpy, name))
            return getattr(numpy, name)

    np = _Numpy()
