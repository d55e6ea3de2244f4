"""Joints with clearance: from the relative motion of two bodies to the forces between them."""
