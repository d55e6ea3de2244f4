"""Drawings on given axes, independent of pages and files."""
