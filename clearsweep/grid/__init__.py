"""Reads grid files: checks them, converts to SI and enumerates cases.  Imports neither llvmlite nor numpy."""

from ..contracts.catalogue import Catalogue, Field, Law
from .cases import LawAssignment
from .grid import SCHEMA_VERSION, CaseLabels, Grid, identity
from .keys.outline import key_units
from .library.iso286 import Fit
from .loading import (
    check_disk,
    check_memory,
    first_case_history,
    history_bytes,
    largest_history,
    load,
    recorded_history,
    starter,
    write_starter,
)
from .pages.key_help import key_names, key_text, markdown
from .pages.schema import schema
from .reading.values import as_written
from .sections.fits import recorded_fits
from .sections.section import ADDED
from .sections.variations import recorded_labels
from .written.definitions import NO_DEFINITIONS, Definitions, definitions_of_resolved
from .written.document import SET_OPTION, SWEEP_OPTION, OverriddenGrid, leaves, read_options
from .written.law_execution import guarded, has_run, reported, run_all
from .written.trust import allowing, list_text, revoke, trust

__all__ = [
    "ADDED",
    "NO_DEFINITIONS",
    "SCHEMA_VERSION",
    "SET_OPTION",
    "SWEEP_OPTION",
    "CaseLabels",
    "Catalogue",
    "Definitions",
    "Field",
    "Fit",
    "Grid",
    "Law",
    "LawAssignment",
    "OverriddenGrid",
    "allowing",
    "as_written",
    "check_disk",
    "check_memory",
    "definitions_of_resolved",
    "first_case_history",
    "guarded",
    "has_run",
    "history_bytes",
    "identity",
    "key_names",
    "key_text",
    "key_units",
    "largest_history",
    "leaves",
    "list_text",
    "load",
    "markdown",
    "read_options",
    "recorded_fits",
    "recorded_history",
    "recorded_labels",
    "reported",
    "revoke",
    "run_all",
    "schema",
    "starter",
    "trust",
    "write_starter",
]
