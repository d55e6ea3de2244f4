"""Slider-cranks with spatial joints for tests."""

import copy

from mechanism_cases import changed
from right_grids import grid_of

from clearsweep.mechanics.machines.spatial.form import MachineType

MACHINE = grid_of("a joint in space")
ROD, JOINT = MACHINE["mechanism"]["rod"], MACHINE["joints"]["crank-rod"]
RPM = 0.10471975511965977  # rad/s
OTHER = {"crank-rod": "rod-slider", "rod-slider": "crank-rod"}


def spatial(*opened, ideal="spherical", **joint):
    """Return a grid dict with spatial clearance at `opened`; the closed joint is of type `ideal`; `joint`: keys of the
    joint.

    A key with the value None is omitted.
    """
    opened = opened or ("crank-rod",)
    keys = {key: value for key, value in (JOINT | joint).items() if value is not None}
    closed = {OTHER[opened[0]]: ideal} if len(opened) == 1 else None
    return changed(MACHINE, {"mechanism.ideal": closed, "joints": {name: copy.deepcopy(keys) for name in opened}})


def planar(joint="crank-rod", **keys):
    """Return a grid dict with a planar joint."""
    grid = spatial(joint, axial_clearance=None, flange=None, walls=None, type=None, **keys)
    mechanism = grid["mechanism"]
    del mechanism["spatial"], mechanism["ideal"], mechanism["gravity"]
    mechanism["rod"] |= {"inertia": ROD["inertia"][2], "center": ROD["center"][0]}
    return grid


def limb(scene, form):
    """Return the number of the body attached by this type of joint, and the index of its first coordinate."""
    parts = MachineType(scene.value.mechanism).parts
    return next((k, part.coordinate) for k, part in enumerate(parts) if part.form is form)
