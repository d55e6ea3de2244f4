"""Reads grid files: checks them, converts to SI and enumerates cases.  Imports neither llvmlite nor numpy."""

from ..contracts.catalogue import Catalogue, Field, Law
from .assumed_units import as_written
from .changes import SET, SWEEP, Changed, read_options
from .defined import NOTHING, Definitions
from .defined import of_resolved as defined_by
from .enumeration import Words
from .fits import fits_of_record as noted_fits
from .grid import SCHEMA_VERSION, Grid, identity
from .identified import Identify, Turned, turns_of
from .iso286 import Fit
from .json_schema import schema
from .key_help import key_names, key_text
from .key_units import key_units
from .labels import noted as noted_labels
from .law_check import base_laws
from .load import load, starter
from .memory import check_disk, check_memory, first_case_history, history_bytes, largest_history, recorded_history
from .optimised import Optimise
from .page import markdown
from .refine import Refine
from .resolve import leaves
from .seek import Seek

__all__ = [
    "NOTHING",
    "SCHEMA_VERSION",
    "SET",
    "SWEEP",
    "Catalogue",
    "Changed",
    "Definitions",
    "Field",
    "Fit",
    "Grid",
    "Identify",
    "Law",
    "Optimise",
    "Refine",
    "Seek",
    "Turned",
    "Words",
    "as_written",
    "base_laws",
    "check_disk",
    "check_memory",
    "defined_by",
    "first_case_history",
    "history_bytes",
    "identity",
    "key_names",
    "key_text",
    "key_units",
    "largest_history",
    "leaves",
    "load",
    "markdown",
    "noted_fits",
    "noted_labels",
    "read_options",
    "recorded_history",
    "schema",
    "starter",
    "turns_of",
]
