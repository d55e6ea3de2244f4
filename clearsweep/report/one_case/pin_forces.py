"""Forces in the joints of one case over time, in the fixed frame: loads for a finite-element model."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ... import simulation
from ...contracts.case import Case
from ...language.errors import InputError
from ..data.study import Joint

PIN_CHANNELS = ("x", "y", "force_normal", "force_tangential")  # channels of a pin in the plane


def joint_forces(case: Case, channels: Mapping, joints: tuple[Joint, ...]) -> pd.DataFrame:
    """Return `pin_forces` of a case with the forces in its joints without clearance, where they are known."""
    if simulation.reactions_unknown(case):
        return pin_forces(channels, joints)
    reactions = simulation.pin_reactions(simulation.build(case), np.asarray(channels["t"], float))
    forces = pin_forces({name: values[::2] for name, values in reactions.trajectory.channels.items()}, joints)
    for name, force in reactions.forces.items():
        forces[f"{name}/fx [N]"], forces[f"{name}/fy [N]"] = force.T
        if name in reactions.couples:
            forces[f"{name}/couple [N*m]"] = reactions.couples[name]
    return forces.assign(**{"drive/torque [N*m]": reactions.torque}) if reactions.forces else forces


def pin_forces(channels: Mapping, joints: tuple[Joint, ...]) -> pd.DataFrame:
    """Return time (s), crank angle (deg), and the force on the journal of each pin with clearance (N, fixed frame).

    The bearing has the opposite force.  The normal force pushes the journal to the centre of the bearing; the
    tangential one is along the outward normal turned by +90 degrees.
    """
    columns = {"time [s]": np.asarray(channels["t"], float)}
    if "crank_angle" in channels:
        columns["crank_angle [deg]"] = np.degrees(np.asarray(channels["crank_angle"], float))
    pins = [joint for joint in joints if all(f"joints/{joint.name}/{key}" in channels for key in PIN_CHANNELS)]
    if not pins:
        raise InputError(
            "no planar pin joint of this case has clearance, so there are no pin forces to write; "
            "give a pin joint a clearance"
        )
    for joint in pins:
        x, y, normal, tangential = (np.asarray(channels[f"joints/{joint.name}/{key}"], float) for key in PIN_CHANNELS)
        distance = np.hypot(x, y)
        normal_x, normal_y = (
            np.divide(component, distance, np.zeros_like(component), where=distance > 0.0) for component in (x, y)
        )
        columns[f"{joint.name}/fx [N]"] = -normal * normal_x - tangential * normal_y
        columns[f"{joint.name}/fy [N]"] = -normal * normal_y + tangential * normal_x
    return pd.DataFrame(columns)
