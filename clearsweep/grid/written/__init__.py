"""What a user wrote: documents, overrides, tables, and expressions of defined quantities."""
