"""A profile of known dimension and scale."""

import math

import numpy as np


def profile(dimension, scale=1e-10, rows=4000, seed=1):
    """Return places and heights (m) of a Weierstrass-Mandelbrot profile, its waves far shorter than its steps, too."""
    x = np.arange(rows) * 1e-6
    draw, heights = np.random.default_rng(seed), np.zeros(rows)
    for n in range(math.floor(math.log(0.1 / x[-1]) / math.log(1.5)), math.ceil(math.log(5e8) / math.log(1.5))):
        heights += 1.5 ** ((dimension - 2.0) * n) * np.cos(
            2.0 * math.pi * 1.5**n * x + draw.uniform(0.0, 2.0 * math.pi)
        )
    return x, scale ** (dimension - 1.0) * heights
