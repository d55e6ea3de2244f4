"""Drawings on given matplotlib axes, independent of pages and files."""
