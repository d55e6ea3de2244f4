"""Joints whose surfaces have worn."""
