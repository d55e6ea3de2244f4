"""Radau IIA of order 9: five stages, the last at the end of the step; L-stable, so stiff components decay at once.

Hairer & Wanner, "Solving Ordinary Differential Equations II", 2nd ed., section IV.5: collocation at the zeros of the
fourth derivative of x^4 (x - 1)^5.  All other constants follow from the matrix.
"""

import math

import numpy as np

from ..observe.stages import END, OTHERS, SHARES
from .collocation import shapes

A = np.array(
    [
        [0.07299886431790333, -0.02673533110794557, 0.018676929763984353, -0.01287910609330644, 0.005042839233882015],
        [0.15377523147918246, 0.14621486784749352, -0.03644456890512809, 0.02123306311930472, -0.007935579902728777],
        [0.14006304568480987, 0.29896712949128346, 0.16758507013524895, -0.03396910168661774, 0.010944288744192253],
        [0.14489430810953477, 0.2765000687601592, 0.32579792291042103, 0.12875675325490976, -0.015708917378805327],
        [0.14371356079122594, 0.28135601514946207, 0.31182652297574126, 0.22310390108357075, 0.04],
    ]
)
STAGES = len(A)
C = np.append(A[:-1].sum(axis=1), 1.0)  # shares of the step at the stages
ORDER = STAGES + 1  # of the error estimate: power of the step length with which it decreases

GAMMA = 6.286704751729277  # the real eigenvalue of the inverse of A


def _error_weights():
    """Return the weights of the stages in the error estimate, f(y) + GAMMA / h of their sum (IV.8.19).

    It is the difference from a quadrature of one order less than the stages, which also uses f(y) at 1 / GAMMA.
    """
    powers = np.arange(STAGES)
    moments = 1.0 / (powers + 1.0)
    moments[0] -= 1.0 / GAMMA
    weights = np.linalg.solve(C ** powers[:, None], moments)
    return (weights - A[-1]) @ np.linalg.inv(A)


E = _error_weights()
#: Error estimate without stiffness over the sixth derivative times h^6, from y' = t^5 / 5!.
ERROR = abs(E @ C**ORDER) / math.factorial(ORDER)
DENSE = np.linalg.inv(shapes(C)[:, :STAGES])  # from the stages to the first rows of the dense output
#: From start and stages to the stages of the explicit method, by the polynomial through all.
LOOK = np.vander(SHARES[1 : 1 + END], ORDER) @ np.linalg.inv(np.vander(np.append(0.0, C)))
ROWS = np.arange(OTHERS, OTHERS + STAGES)  # rows of the rates and observables of the stages
STAGE_WEIGHTS = np.zeros(OTHERS + STAGES)
STAGE_WEIGHTS[ROWS] = A[-1]
PLACES = np.array([0, 2, 4])  # stages at which Jacobians are evaluated
SPREAD = np.vander(C, PLACES.size) @ np.linalg.inv(np.vander(C[PLACES]))  # from these to all stages, by a parabola
