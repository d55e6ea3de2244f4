"""Reads a document into SI values and checks them."""
