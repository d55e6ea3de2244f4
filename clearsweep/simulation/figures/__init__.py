"""Figures of merit, each a block with name, unit, description and formula; `catalogue` lists them in column order."""
