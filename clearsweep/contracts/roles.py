"""Roles of varied values: what the designer chooses, what must hold at every value, and what is uncertain."""

CHOICE = "choice"  # the designer decides
CONDITION = "condition"  # the design must meet the limits at every value
UNCERTAINTY = "uncertainty"  # unknown: the worst over its values, or its distribution, counts
MODEL = "model"  # a law or its smoothing: an uncertainty, too
NUMERICS = "numerics"  # never an answer: the finest value decides, the others show convergence
ROLES = (CHOICE, CONDITION, UNCERTAINTY, MODEL, NUMERICS)
#: Order in which the uses of a quantity of one's own decide its role.
PRECEDENCE = (CONDITION, UNCERTAINTY, MODEL, CHOICE, NUMERICS)
