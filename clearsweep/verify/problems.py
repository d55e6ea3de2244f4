"""Problems whose answers are known: quadruple-precision trajectories of slider-cranks, and the impact of two bodies.

`reference.json` says where its trajectories come from and what its rows hold.
"""

import json
import math
from importlib import resources
from typing import NamedTuple

import numpy as np
from scipy.special import lambertw

from .. import scene as scenes
from ..kernels.event import SEPARATION
from ..laws import exact_factor  # noqa: F401
from .yardsticks import Solution
