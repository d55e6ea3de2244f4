"""Searches: each asks for cases, reads their figures, and answers."""
