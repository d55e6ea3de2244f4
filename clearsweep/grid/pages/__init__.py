"""Texts generated from the keys: the JSON Schema, the page of keys, the texts of `clearsweep list`."""
