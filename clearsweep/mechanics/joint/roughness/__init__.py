"""Roughness of the surfaces of a joint, in series with its elastic law: one block a law."""
