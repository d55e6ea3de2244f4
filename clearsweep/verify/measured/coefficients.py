"""Stiffness and damping of a film in equilibrium with its load: the slope of its force there."""

import math

import numpy as np

from ...mechanics.joints import registry
from ...mechanics.joints.dry import Gap
from ...mechanics.joints.lubricated import film_load
from ...simulation.setup.scene import load_case
from . import film_at_rest

STEP = 1e-5  # of the clearance, and of clearance times speed; the error of central differences is quadratic in it
AXES = ("x", "y")


def film_coefficients(
    law: str, slenderness: float, sommerfeld: float, ratio: float, attitude: float
) -> dict[str, float]:
    """Return stiffness K (W / c) and damping B (W / (c w)) of a film with a journal in equilibrium.

    ratio, attitude : eccentricity ratio and angle (rad) from the load to the eccentricity, in the sense of rotation.

    x is along the load, y rotated from it by 90 degrees with the shaft: K_xy = -dF_x / dy c / W, B_xy = -dF_x / dy' c w
    / W (Lund & Thomsen 1978).  For a law with different damping in closing and opening motion, the mean of both is
    used.
    """
    load = film_at_rest.load_of(slenderness, sommerfeld)
    scene = load_case(film_at_rest.grid_of(law, slenderness, sommerfeld))
    (joint,) = scene.case.joints
    term = registry.compile_joint(joint, str(joint.journal))
    clearance, speed = film_at_rest.CLEARANCE, film_at_rest.SPEED
    scales = clearance * np.array([1.0, 1.0, speed, speed])
    equilibrium = np.array([ratio * math.cos(attitude), ratio * math.sin(attitude), 0.0, 0.0])

    def force(motion: np.ndarray) -> np.ndarray:
        """Return the (2,) force on the journal over the load, for its (4,) position and velocity over `scales`."""
        x, y, vx, vy = (float(number) for number in motion * scales)
        film = film_load(term, Gap(x, y, vx, vy, spin_proximal=0.0, spin_distal=speed))
        radial_direction, tangential_direction = np.array([film.nx, film.ny]), np.array([-film.ny, film.nx])
        return np.asarray((film.radial * radial_direction + film.tangential * tangential_direction) / load)

    slopes = [
        (force(equilibrium - STEP * direction) - force(equilibrium + STEP * direction)) / (2.0 * STEP)
        for direction in np.eye(4)
    ]
    stiffness, damping = np.array(slopes[:2]).T, np.array(slopes[2:]).T
    result = {}
    for i, row_axis in enumerate(AXES):
        for j, column_axis in enumerate(AXES):
            result[f"stiffness K{row_axis}{column_axis}"] = float(stiffness[i, j])
            result[f"damping B{row_axis}{column_axis}"] = float(damping[i, j])
    return result


def whirl_threshold(values: dict[str, float]) -> float:
    """Return the whirl threshold of a rigid rotor of this weight, speed w over sqrt(g / c); inf if it never whirls.

    values : result of `film_coefficients`.  Routh's criterion: at the threshold M s^2 c / W is the `whirl_stiffness`,
    s the whirl speed, and `whirl_ratio_squared` is (s / w)^2 (Lund & Thomsen 1978).
    """
    names = [first + second for first in AXES for second in AXES]
    k, b = ({name: values[f"{kind}{name}"] for name in names} for kind in ("stiffness K", "damping B"))
    whirl_stiffness = (k["xx"] * b["yy"] + k["yy"] * b["xx"] - k["xy"] * b["yx"] - k["yx"] * b["xy"]) / (
        b["xx"] + b["yy"]
    )
    whirl_ratio_squared = ((k["xx"] - whirl_stiffness) * (k["yy"] - whirl_stiffness) - k["xy"] * k["yx"]) / (
        b["xx"] * b["yy"] - b["xy"] * b["yx"]
    )
    return (
        math.sqrt(whirl_stiffness / whirl_ratio_squared)
        if whirl_ratio_squared > 0.0 and whirl_stiffness > 0.0
        else math.inf
    )
