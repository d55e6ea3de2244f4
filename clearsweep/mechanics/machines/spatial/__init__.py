"""Spatial machines whose bodies form a tree, once the joints with clearance have opened all loops.

A body is attached to the ground or to another body by a joint without clearance; `form` has the kinds.  After
all loops are opened by clearances there are no constraints, so there are as many coordinates as degrees of freedom,
except for the length of quaternions.
"""
