"""Assesses results: whether they are plausible, and whether they meet the limits of a grid."""
