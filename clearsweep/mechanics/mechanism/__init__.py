"""Mechanisms: where the bodies are, how they accelerate, what they would do without clearance."""
