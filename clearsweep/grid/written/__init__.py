"""Reads written input: documents, overrides, tables, and expressions of defined quantities."""
