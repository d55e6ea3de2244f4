"""Drawings on the matplotlib axes they are given; nothing here knows about pages or files."""
