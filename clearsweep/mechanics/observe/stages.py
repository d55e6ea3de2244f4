"""The stages of a step, and their rows in arrays."""

import numpy as np

#: The stages as fractions of the step: Radau's points, zeros of d^7/dx^7 x^7 (x - 1)^8.
POINTS = (
    0.022479386438712497,
    0.11467905316090424,
    0.26578982278458946,
    0.45284637366944464,
    0.6473752828868303,
    0.8197593082631076,
    0.9437374394630779,
    1.0,
)
STAGES = len(POINTS)
#: Rows of rates and observables: at the stages, the last of which is the END of the step, at its START, and in any
#: state on the interpolant; from FIRST_IMPLICIT_ROW on those of the implicit method.
END, START, SCRATCH, FIRST_IMPLICIT_ROW, ROW_COUNT = 7, 8, 9, 10, 16
#: The rows at distinct times of a step, in order: its start and its stages; and these times as fractions of the step.
NODES = np.array([START, *range(STAGES)])
NODE_FRACTIONS = np.array([0.0, *POINTS])
