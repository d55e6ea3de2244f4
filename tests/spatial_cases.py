"""Slider-cranks with spatial joints for tests."""

import copy

from clearsweep.mechanics.machines.spatial.form import MachineType

ROD = {"length": 0.12, "mass": 0.21, "inertia": [2e-5, 2.5e-4, 2.5e-4], "center": [0.06, 0.0, 0.0]}
CONTACT = {
    "law": "lankarani-nikravesh",
    "stiffness": 1e9,
    "exponent": 1.5,
    "restitution": 0.7,
    "onset": "first",
}
JOINT = {
    "type": "spatial",
    "clearance": 2e-4,
    "axial_clearance": 2e-4,
    "bearing_radius": 0.01,
    "length": 0.02,
    "flange": True,
    "walls": "ends",
    "contact": CONTACT,
}
RPM = 0.10471975511965977  # rad/s
OTHER = {"crank-rod": "rod-slider", "rod-slider": "crank-rod"}


def spatial(*opened, ideal="spherical", **joint):
    """Return a grid dict with spatial clearance at `opened`; the closed joint is of type `ideal`; `joint`: keys of the
    joint.

    A key with the value None is omitted.
    """
    opened = opened or ("crank-rod",)
    keys = {key: value for key, value in (JOINT | joint).items() if value is not None}
    return {
        "mechanism": {
            "type": "slider-crank",
            "spatial": True,
            "crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4},
            "rod": copy.deepcopy(ROD),
            "slider": {"mass": 0.14},
            "gravity": [0.0, 0.0, 0.0],
        }
        | ({"ideal": {OTHER[opened[0]]: ideal}} if len(opened) == 1 else {}),
        "drive": {"speed": 1000 * RPM},
        "joints": {name: copy.deepcopy(keys) for name in opened},
        "simulate": {"revolutions": 0.5, "discard": 0, "tolerance": 1e-12},
        "save": {"orbits": "none"},
    }


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
