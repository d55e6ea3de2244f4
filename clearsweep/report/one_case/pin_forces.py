"""Forces of the pins of one case over time, in the fixed frame: loads for a finite-element model."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ...language.errors import InputError
from ..data.study import Joint

NEEDED = ("x", "y", "force_normal", "force_tangential")  # channels of a pin in the plane


def pin_forces(channels: Mapping, joints: tuple[Joint, ...]) -> pd.DataFrame:
    """Return time (s), crank angle (deg), and the force on the journal of each pin with clearance (N, fixed frame).

    The bearing has the opposite force.  The normal force pushes the journal to the centre of the bearing; the
    tangential one is along the outward normal turned by +90 degrees.
    """
    columns = {"time [s]": np.asarray(channels["t"], float)}
    if "crank_angle" in channels:
        columns["crank_angle [deg]"] = np.degrees(np.asarray(channels["crank_angle"], float))
    pins = [joint for joint in joints if all(f"joints/{joint.name}/{key}" in channels for key in NEEDED)]
    if not pins:
        raise InputError("no pin of this case has forces in the plane; a pin has them if it has a clearance")
    for joint in pins:
        x, y, normal, tangential = (np.asarray(channels[f"joints/{joint.name}/{key}"], float) for key in NEEDED)
        distance = np.hypot(x, y)
        out_x, out_y = (np.divide(part, distance, np.zeros_like(part), where=distance > 0.0) for part in (x, y))
        columns[f"{joint.name}/fx [N]"] = -normal * out_x - tangential * out_y
        columns[f"{joint.name}/fy [N]"] = -normal * out_y + tangential * out_x
    return pd.DataFrame(columns)
