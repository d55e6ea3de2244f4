"""The slider-crank: crank at constant speed, rod, slider, and clearance in any of the three revolute joints."""

import math

import numpy as np

from ....contracts.catalogue import Channel, Field, JointSite, Keys, Mechanism, Order, Output
from ....contracts.outline import Outline
from .. import described, spatial
from ..contract import Built, Ideal, IdealMotion, Open
from . import general, masses, motion  # noqa: F401 - enter the equations of motion
from .ideal import reactions, slider, torque
from .pose import ROD, SLIDER, Links, Places, SliderCrank, places

_LENGTH = Field("length", "m", "distance between its pins")
_CENTER = Field(
    "center",
    "m",
    "distance of the centre of mass from the pin nearer the drive; default: half the length",
    -math.inf,
    optional=True,
)
_CRANK = (
    _LENGTH,
    Field("mass", "kg", "mass", low_open=False),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass", low_open=False),
    _CENTER,
)
_ROD = (
    _LENGTH,
    Field("mass", "kg", "mass"),
    Field("inertia", "kg*m^2", "moment of inertia about the centre of mass"),
    _CENTER,
)
_SLIDER = (
    Field("mass", "kg", "mass"),
    Field("offset", "m", "of the line on which it moves, along y; default 0", -math.inf, optional=True),
    Field("inertia", "kg*m^2", "about the centre of mass; needed where slider-ground has clearance", optional=True),
)
_SITES = (
    JointSite("ground-crank", "ground", "crank"),
    JointSite("crank-rod", "crank", "rod"),
    JointSite("rod-slider", "rod", "slider", journal="rod"),
)
_GUIDE = JointSite("slider-ground", "ground", "slider", "guide")
_BODIES = ("ground", "crank", "rod", "slider")
_OUTPUT = Output("slider", "m")
_CHANNELS = (
    Channel("crank_angle", "rad", "crank angle, unwrapped"),
    Channel("crank/torque", "N*m", "drive torque on the crank"),
    Channel("slider/x", "m", "position of the slider"),
    Channel("slider/v", "m/s", "velocity of the slider"),
    Channel("slider/a", "m/s^2", "acceleration of the slider"),
    Channel("rod/angle", "rad", "angle of the line from crank pin to slider pin, counter-clockwise"),
    Channel("rod/rate", "rad/s", "its rate"),
    Channel("rod/x", "m", "rod's centre of mass, x"),
    Channel("rod/y", "m", "rod's centre of mass, y"),
    Channel("rod/vx", "m/s", "velocity of the rod's centre of mass, x"),
    Channel("rod/vy", "m/s", "velocity of the rod's centre of mass, y"),
    *described.body_channels("crank"),
    *(channel for channel in described.body_channels("slider") if channel.name != "slider/x"),
)


_LINKS = [name.replace("_", ".") for name in Links._fields if name != "speed"]
_KEYS = (
    Keys("mechanism.crank", "the crank", _CRANK),
    *described.elastic_keys("mechanism.crank"),
    Keys("mechanism.rod", "the rod", _ROD),
    *described.elastic_keys("mechanism.rod"),
    Keys("mechanism.slider", "the slider", _SLIDER),
    Keys(
        "mechanism",
        "",
        (Field("gravity", "m/s^2", "gravity, along -y", -math.inf, default=0.0),),
        flags=(spatial.FLAG,),
    ),
)


def build(bodies, drive, joints, offsets) -> Built:
    """Return the slider-crank at crank angle 0, its pins apart by `offsets` and at rest relative to each other."""
    links = Links(*[bodies[name] for name in _LINKS], speed=drive)
    mechanism = SliderCrank(links, tuple([Open() if site.name in joints else Ideal() for site in _SITES]))
    at = places(mechanism)
    lengths = [1.0] * at.count
    lengths[ROD] = links.rod_length  # an angle
    start = _start(links, at, [offsets.get(site.name, (0.0, 0.0)) for site in _SITES])
    return Built(mechanism, np.array(start), np.array(lengths), links.crank_length + links.rod_length, drive)


def _start(links: Links, at: Places, offsets: list) -> list:
    """Return coordinates, their rates and time; offsets : m, m, of the distal pin from the proximal one, A to C."""
    radius, length, center, speed = links.crank_length, links.rod_length, links.rod_center, links.speed
    a, b, c = offsets
    pin_x, pin_y = a[0] + radius + b[0], a[1] + 0.0 + b[1]  # of the crank
    sin2 = -(pin_y + c[1]) / length
    cos2 = math.sqrt(1.0 - sin2**2)
    rate = -radius * speed / (length * cos2)
    count = at.count
    start = [0.0] * (2 * count + 1)
    start[ROD], start[SLIDER] = math.asin(sin2), pin_x + length * cos2 + c[0]
    start[count + ROD], start[count + SLIDER] = rate, -length * rate * sin2
    if at.center:
        start[at.center : at.center + 2] = pin_x + center * cos2, pin_y + center * sin2
        swing = center * rate
        start[count + at.center : count + at.center + 2] = 0.0 + swing * -sin2, radius * speed + swing * cos2
    if at.pivot:
        start[at.pivot : at.pivot + 2] = a
    return start


def ideal(bodies, drive, angles) -> IdealMotion:
    """Return the motion of the slider and the reactions without clearance at crank angles `angles` (rad)."""
    x, v, a = slider(bodies["crank.length"], bodies["rod.length"], angles, drive)
    forces = reactions(bodies, drive, angles)
    return IdealMotion(x, v, a, forces, torque(bodies, forces["crank-rod"], angles))


def outlined(outline: Outline) -> Mechanism:
    """Return the slider-crank with the drive and the loads of a grid; without any, with its own equations."""
    if outline.spatial:
        return spatial.mechanism(outline, MECHANISM)
    joints = tuple(site.name for site in (*_SITES, _GUIDE))
    sections = described.keys_of(outline, dict.fromkeys(_BODIES, ()), joints)
    mechanism = MECHANISM._replace(keys=(*_KEYS, *sections), free=outline.free)
    if not outline.general:
        return mechanism
    channels = described.channels_of(_BODIES, _OUTPUT, ("place", "v", "a"), outline.elastic)
    return mechanism._replace(channels=channels, build=None, ideal=None, refusal=described.refusal)


MECHANISM = Mechanism(
    "slider-crank",
    "crank at constant speed, rod, slider; clearance in any of its three revolute joints",
    "Newton-Euler in minimal coordinates; ideal: x = r cos(t) + sqrt(l^2 - r^2 sin^2(t))",
    "Newton-Euler; coordinates by which joints are open, see mechanics/mechanism",
    "The rod is longer than the crank; the slider moves along the x axis, past the crank's pivot by its offset.",
    bodies=_BODIES,
    joints=(*_SITES, _GUIDE),
    keys=_KEYS,
    channels=_CHANNELS,
    turns=True,
    build=build,
    output=_OUTPUT,
    orders=(Order("mechanism.crank.length", "mechanism.rod.length", "the crank turns fully only with a longer rod"),),
    ideal=ideal,
    outlined=outlined,
    machine=general.machine,
)
