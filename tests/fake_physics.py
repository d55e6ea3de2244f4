"""Mechanics made up by formula, for testing sweeps; gravity (m/s^2) says what becomes of a case."""

import gc
import os
import signal
import time

import numpy as np

from clearsweep import results
from clearsweep.grid import Catalogue, Field, Law

GOOD, RAISES, DIES, HANGS, FAILS, LOCKS = 0.0, 500.0, 600.0, 700.0, 800.0, 900.0  # below 10: s of sleep

_POWER = (Field("stiffness", "N/m^exponent"), Field("exponent", "1", default=1.5))
_LOSS = (Field("restitution", "1", high=1.0, high_open=False),)
CATALOGUE = Catalogue(
    (
        Law("law", "hertz", "no loss", "", ""),
        Law("law", "lankarani-nikravesh", "loss", "", "", _LOSS),
        Law("elastic", "power", "power law", "", "", _POWER),
        Law(
            "wear",
            "archard",
            "wear",
            "",
            "",
            (
                Field("coefficient", "m^2/N", optional=True),
                Field("bearing_coefficient", "m^2/N", optional=True),
                Field("journal_coefficient", "m^2/N", optional=True),
            ),
        ),
        Law("pressure", "hertz-line", "line contact", "", "", needs=("modulus",)),
    )
)
BODIES = {
    "type": "slider-crank",
    "crank": {"length": "50 mm", "mass": 0.3, "inertia": 1e-4},
    "rod": {"length": "120 mm", "mass": 0.21, "inertia": 2.5e-4},
    "slider": {"mass": "0.14 kg"},
}
CONTACT = {"law": "lankarani-nikravesh", "stiffness": "6.61e10 N/m^1.5", "restitution": 0.9}
WEAR = {"law": "archard", "coefficient": "2e-14 m^2/N", "bins": 36}


def grid(masses=3, gravities=(GOOD,), orbits="last", wear=False, **more) -> dict:
    """Return a grid with masses x gravities cases, as a user would write it."""
    joint = {"clearance": "0.5 mm", "bearing_radius": "10 mm", "length": "20 mm", "contact": CONTACT}
    if wear:
        joint["wear"] = WEAR
    return {
        "name": "made-up",
        "mechanism": BODIES,
        "drive": {"speed": "5000 rpm"},
        "joints": {"rod-slider": joint},
        "save": {"orbits": orbits, "samples": 20, **({"revolutions": 2} if orbits == "last" else {})},
        "sweep": {
            "mechanism.slider.mass": [0.1 + 0.001 * k for k in range(masses)],
            "mechanism.gravity": list(gravities),
        },
        **more,
    }


class Fake:
    """A stand-in for the mechanics."""

    @staticmethod
    def catalogue():
        """Return a few laws."""
        return CATALOGUE

    @staticmethod
    def signature(case):
        """Return the law's name."""
        return case.joints[0].contact.law

    @staticmethod
    def load():
        """Do nothing."""

    @staticmethod
    def compile_for(case):
        """Do nothing."""

    @staticmethod
    def derived(case):
        """Return a made-up derived value."""
        return {"joints.rod-slider.contact.stiffness": (6.61e10, "N/m^1.5")}

    @staticmethod
    def warnings(case):
        """Return nothing to warn of."""
        return []

    @staticmethod
    def solve(case):
        """Return a made-up trajectory, or fail in the way that the case's gravity says."""
        gravity = case.mechanism.values["gravity"]
        if gravity == RAISES:
            raise ZeroDivisionError("made to fail")
        if gravity == DIES:
            os.kill(os.getpid(), signal.SIGKILL)
        if gravity == LOCKS:
            from pebble.pool.channel import ChannelMutex

            mutex = next(item for item in gc.get_objects() if isinstance(item, ChannelMutex))
            mutex.acquire(timeout=10.0)
            os.kill(os.getpid(), signal.SIGKILL)  # the pool's queue stays locked
        if gravity == HANGS:
            time.sleep(1e4)
        if gravity == FAILS:
            return results.Trajectory("step-budget", "the step budget was used up", {"rod_slider_force_peak": np.nan})
        time.sleep(gravity)
        return trajectory(case)


def trajectory(case) -> results.Trajectory:
    """Return histories, events, wear and figures that depend on the slider's mass alone."""
    mass = case.mechanism.values["slider.mass"]
    bins = case.joints[0].wear.bins if case.joints[0].wear else 0
    layout = results.Layout("slider-crank", (results.JointLayout("rod_slider", bins),))
    count = 0 if case.save.orbits == "none" else 41
    chance = np.random.default_rng(int(1e6 * mass))
    channels = {column.name: mass * np.arange(count) + place for place, column in enumerate(results.channels(layout))}
    events = np.zeros(int(chance.integers(0, 5)) if count else 0, results.EVENT_DTYPE)
    events["joint"], events["kind"], events["t"] = "rod_slider", "on", mass
    events["kind"][1::2] = "off"
    figures = {
        column.name: int(1e5 * mass) if column.kind == "int" else mass * (place + 1)
        for place, column in enumerate(results.summary_columns(layout))
    }
    wear = {"rod_slider": (np.full(bins, mass), np.full(bins, 2.0 * mass))} if bins else {}
    return results.Trajectory("ok", "", figures, channels if count else {}, events, wear)
