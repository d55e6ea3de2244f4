"""Substitute mechanics by formula, and sweeps with it; gravity (m/s^2) selects the outcome of a case.

Workers import this file, so it must be light: modules needed only by the parent are imported where they are used.
"""

import gc
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from clearsweep.contracts import results
from clearsweep.contracts.catalogue import (
    CHOICE,
    CONDITION,
    Catalogue,
    Channel,
    Field,
    Figure,
    JointSite,
    Keys,
    Law,
    Mechanism,
    Output,
)
from clearsweep.contracts.layout import Layout
from clearsweep.language.errors import InputError
from clearsweep.searches import SEARCHES

GOOD, REFUSED, RAISES, DIES, HANGS, FAILS, LOCKS = 0.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0  # below 10: s of sleep

_POWER = (Field("stiffness", "N/m^exponent"), Field("exponent", "1", default=1.5))
_LOSS = (Field("restitution", "1", high=1.0, high_open=False),)
_WEAR = tuple(Field(f"{of}coefficient", "m^2/N", optional=True) for of in ("", "bearing_", "journal_"))
_BODY = (Field("length", "m"), Field("mass", "kg"), Field("inertia", "kg*m^2"))
_OF_JOINT = {
    **dict.fromkeys(("force_peak", "force_rms", "force_p99", "force_peak_ideal"), "N"),
    **dict.fromkeys(("impacts_per_rev", "contact_fraction", "law_limit_fraction", "force_clips"), "1"),
    **{"onset_rate_max": "m/s", "penetration_max": "m", "eccentricity_max": "m"},
}
_WORN = ("depth_max", "rate_max", "volume", "narrow_arcs")
#: Names allowed in a grid, and figures of a case; workers that import it are as light as without compiled code.
CATALOGUE = Catalogue(
    searches=SEARCHES,
    laws=(
        Law("law", "hertz", "no loss", "", ""),
        Law("law", "lankarani-nikravesh", "loss", "", "", _LOSS),
        Law("elastic", "power", "power law", "", "", _POWER),
        Law("wear", "archard", "wear", "", "", _WEAR),
        Law("pressure", "mean", "even", "", ""),
        Law("pressure", "hertz-line", "line contact", "", "", needs=("modulus",)),
    ),
    mechanisms=(
        Mechanism(
            *("slider-crank", "made up", "", "", ""),
            bodies=("ground", "crank", "rod", "slider"),
            joints=(JointSite("rod-slider", "rod", "slider", journal="rod"),),
            keys=(
                Keys("mechanism.crank", "the crank", _BODY, role=CHOICE),
                Keys("mechanism.rod", "the rod", _BODY, role=CHOICE),
                Keys("mechanism.slider", "the slider", (Field("mass", "kg"),), role=CHOICE),
                Keys("mechanism", "", (Field("gravity", "m/s^2", low_open=False, default=0.0),), role=CONDITION),
                Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied", role=CONDITION),
            ),
            channels=tuple(
                Channel(name, "m", "made up")
                for name in ("crank_angle", "crank/torque", "slider/x", "slider/v", "slider/a")
            ),
            turns=True,
            build=None,
            output=Output("slider", "m"),
        ),
    ),
    figures=(
        *(Figure(name, unit, "made up", of="joint") for name, unit in _OF_JOINT.items()),
        *(Figure(f"wear_{name}", "m", "made up", of="joint", needs=("wear",)) for name in _WORN),
        Figure("life_revolutions", "1", "made up", of="joint", needs=("limited",)),
        *(Figure(f"acceleration_{name}", "{output}/s^2", "made up", of="output") for name in ("peak", "rms")),
        Figure("error_max", "{output}", "made up", of="output"),
        Figure("crank_torque_peak", "N*m", "made up"),
        Figure("energy_residual", "1", "made up"),
        *(Figure(name, "1", "made up", kind="int") for name in ("steps", "steps_rejected", "rhs_evaluations")),
        Figure("run_time", "s", "made up"),
    ),
    joint_channels=(
        *(Channel(name, "m", "of the journal") for name in ("x", "y")),
        Channel("force_normal", "N", "on the journal"),
    ),
)
BODIES = {
    "type": "slider-crank",
    "crank": {"length": "50 mm", "mass": "0.3 kg", "inertia": "1e-4 kg*m^2"},
    "rod": {"length": "120 mm", "mass": "0.21 kg", "inertia": "2.5e-4 kg*m^2"},
    "slider": {"mass": "0.14 kg"},
}
CONTACT = {"law": "lankarani-nikravesh", "stiffness": "6.61e10 N/m^1.5", "restitution": 0.9}
WEAR = {"law": "archard", "coefficient": "2e-14 m^2/N", "bins": 36}


def grid(masses=3, gravities=(GOOD,), orbits="last", wear=False, **more) -> dict:
    """Return a grid with masses x gravities cases, in the form of a user's file."""
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
            "mechanism.slider.mass": [f"{0.1 + 0.001 * k!r} kg" for k in range(masses)],
            "mechanism.gravity": list(gravities),
        },
        **more,
    }


class Fake:
    """A substitute for the mechanics."""

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
    def compile_loop(case):
        """Do nothing."""

    @staticmethod
    def derived(case):
        """Return a made-up derived value."""
        return {"joints.rod-slider.contact.stiffness": (6.61e10, "N/m^1.5")}

    @staticmethod
    def warnings(case):
        """Return no warnings."""
        return []

    @staticmethod
    def recommended(case):
        """Return no recommendation."""
        return []

    @staticmethod
    def alternatives(case):
        """Return two alternative laws, both valid."""
        return {"joints.rod-slider.contact.law": ["lankarani-nikravesh", "hertz"]}

    @staticmethod
    def peak(case, joint, revolutions, window_from=None):
        """Return a made-up revolution, the fourth, with the motion of the case."""
        return results.Peak(3.0, trajectory(case._replace(save=case.save._replace(orbits="last"))))

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory, or fail as the case's gravity specifies; record the start in a log."""
        if log:
            log.keep(str(case.mechanism.values["slider.mass"]).encode())
        gravity = case.mechanism.values["gravity"]
        if gravity == REFUSED:
            raise InputError("mechanism: cannot be put together")
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
    """Return histories, events, wear and figures that depend only on the slider's mass."""
    mass = case.mechanism.values["slider.mass"]
    bins = case.joints[0].wear.bins if case.joints[0].wear else 0
    layout = Layout.of(case, CATALOGUE)
    count = 0 if case.save.orbits == "none" else 41
    chance = np.random.default_rng(int(1e6 * mass))
    channels = {column.name: mass * np.arange(count) + place for place, column in enumerate(layout.channels)}
    events = np.zeros(int(chance.integers(0, 5)) if count else 0, results.EVENT_DTYPE)
    events["joint"], events["kind"], events["t"] = "rod_slider", "on", mass
    events["kind"][1::2] = "off"
    figures = {
        column.name: int(1e5 * mass) if column.kind == "int" else mass * (place + 1)
        for place, column in enumerate(layout.columns)
    }
    wear = {"rod_slider": (np.full(bins, mass), np.full(bins, 2.0 * mass))} if bins else {}
    history = _history(mass, bins) if case.life else {}
    return results.Trajectory("ok", "", figures, channels if count else {}, events, wear, history=history)


def _history(mass, bins):
    """Return a life with some nodes, which depends only on the slider's mass."""
    nodes = 2 + round(1e3 * mass) % 3
    of_joint = {name: mass * np.arange(nodes) for name in ("wear_depth_max", "clearance", "force_peak", "wear_rate")}
    of_joint |= {f"profile_{body}": np.outer(np.arange(nodes), np.full(bins, mass)) for body in ("bearing", "journal")}
    return {"revolutions": 10.0 * np.arange(nodes)} | {f"rod_slider/{name}": row for name, row in of_joint.items()}


class OtherVersion(Fake):
    """Substitute for the mechanics in workers with a different version of the model."""

    @staticmethod
    def load():
        """Change the version in a worker, the process that calls this."""
        for name, module in list(sys.modules.items()):
            if name.partition(".")[0] == "clearsweep" and "MODEL_VERSION" in vars(module):
                module.MODEL_VERSION = "another"


def await_file(name):
    """Return when another process has created a file of this name; fail after 30 s."""
    for _ in range(3000):
        if Path(name).exists():
            return
        time.sleep(0.01)
    raise TimeoutError(f"{name} did not come")


class Together(Fake):
    """Mechanics whose two parts only compile simultaneously."""

    @staticmethod
    def compile_for(case):
        """Signal the start, and wait for the loop."""
        Path("scene").touch()
        await_file("loop")

    @staticmethod
    def compile_loop(case):
        """Signal the start, and wait for the scene."""
        Path("loop").touch()
        await_file("scene")


def sweep(source, out=None, *, simulator=Fake, **options):
    """Call `clearsweep.sweep` with substitute mechanics."""
    from clearsweep.sweeping.sweep import Options, run_sweep

    return run_sweep(source, out, Options(**options), simulator)


def merge(directories, out, **options):
    """Call `clearsweep.merge` with substitute mechanics."""
    from clearsweep.sweeping.merge import merge as merge_runs

    return merge_runs(directories, out, simulator=Fake, **options)
