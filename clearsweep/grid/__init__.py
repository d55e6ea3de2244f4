"""What the user wrote, checked and in SI, and the cases it stands for.  Imports neither numba nor numpy."""

from ..catalogue import Catalogue, Field, Law
from .grid import SCHEMA_VERSION, Grid, identity, load, starter
from .json_schema import schema
from .key_units import key_units
from .reference import markdown

__all__ = [
    "SCHEMA_VERSION",
    "Catalogue",
    "Field",
    "Grid",
    "Law",
    "identity",
    "key_units",
    "load",
    "markdown",
    "schema",
    "starter",
]
