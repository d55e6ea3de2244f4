"""Problems with known answers: quadruple-precision trajectories of slider-cranks, and impacts of two bodies.

`references/planar.json` describes the origin of its trajectories and its rows.  A problem builds its scene, gives the
output times, and assesses the solution of an integrator.
"""

import copy
import json
import math
from importlib import resources
from typing import NamedTuple

import numpy as np
from scipy.special import lambertw

from .. import grid
from ..contracts.case import column_name
from ..mechanics.solver.integration import ONSET, SEPARATION
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from .rivals import Solution

CRANK, ROD = 0.05, 0.12  # m
STIFF_TURNS, REFERENCE_TOLERANCE = 0.25, 1e-12  # revolutions; tolerance of the trajectory of the stiff problem
EVENT_KINDS = {"on": ONSET, "off": SEPARATION}


class Errors(NamedTuple):
    """Errors of a solution, None where undefined."""

    first_half: float | None  # largest error of a sample in the first half of the run, over its scale
    whole: float  # the same over the whole run; impact pair: largest error of a restitution
    events: int  # contact onsets and separations found
    events_exact: bool  # correct number, joints and kinds in the correct order
    peaks: float | None  # largest relative error of a force peak in the first half
    first_peaks: float | None  # as peaks, of the first three force peaks


class ReferenceTrajectory(NamedTuple):
    """A slider-crank whose motion is known at given times."""

    name: str
    title: str
    grid: dict
    scales: np.ndarray  # (2 coordinates,) 0.05 rad, 0.05 m, crank rate, crank rate x crank length
    samples: np.ndarray  # (samples, 2 coordinates) in the order of the compiled state
    times: np.ndarray  # (samples,) s, equidistant, the last one is the end
    events: np.ndarray  # (events, 5) time (s), joint, ONSET or SEPARATION, rate (m/s), force peak (N, nan: not known)
    revolutions: float
    separations: int = 0
    measure: str = "pointwise"
    min_rival_tolerance: float = 0.0  # tolerance below which the rivals would take minutes

    @property
    def end(self) -> float:
        """Return the length of the run, s."""
        return self.times[-1]

    def assess(self, solution: Solution) -> Errors:
        """Return the errors of a solution at the samples."""
        half_count = len(self.times) // 2
        is_complete = solution.states.shape == self.samples.shape and bool(np.all(np.isfinite(solution.states)))
        error = (
            np.abs(solution.states - self.samples) / self.scales
            if is_complete
            else np.full((2 * half_count, 1), np.nan)
        )
        are_events_exact = _have_same_events(solution.events, self.events)
        peaks = self._peak_error(solution) if is_complete else None
        first_peaks = self._peak_error(solution, 3) if is_complete else None
        return Errors(
            float(error[:half_count].max()),
            float(error.max()),
            len(solution.events),
            are_events_exact,
            peaks,
            first_peaks,
        )

    def _peak_error(self, solution: Solution, count: int | None = None) -> float | None:
        """Return the largest relative error of the force peaks (or of `count` of them) in the first half."""
        computed, reference = (
            log[(log[:, 2] == SEPARATION) & (log[:, 0] <= 0.5 * self.end), 4][:count]
            for log in (solution.events, self.events)
        )
        if len(computed) != len(reference) or not len(reference) or not np.all(computed > 0.0):
            return None
        return float(np.nanmax(np.abs(computed / reference - 1.0)))  # nan: an unknown peak


class ImpactPair(NamedTuple):
    """Two bodies that bounce against each other; the ratio of rebound to approach speed is known in closed form."""

    name: str
    title: str
    grid: dict
    restitution: float  # the ratio, of every impact
    separations: int
    end: float  # s, later than the last separation
    times: np.ndarray = np.empty(0)
    revolutions: float = 1.0  # cost is measured over the whole run
    measure: str = "restitution"
    min_rival_tolerance: float = 0.0

    @property
    def events(self) -> np.ndarray:
        """Return the events in the form of `Trajectory.events`, with joint and kind only."""
        return np.array([(0.0, 0.0, kind, 0.0, 0.0) for kind in (ONSET, SEPARATION)] * self.separations)

    def assess(self, solution: Solution) -> Errors:
        """Return the largest error of the ratio of rebound to approach speed."""
        are_events_exact = _have_same_events(solution.events, self.events)
        rates = solution.events[:, 3]
        worst = float(np.max(np.abs(-rates[1::2] / rates[::2] - self.restitution))) if are_events_exact else math.nan
        return Errors(None, worst, len(solution.events), are_events_exact, None, None)


def _have_same_events(computed: np.ndarray, reference: np.ndarray) -> bool:
    return len(computed) == len(reference) and bool(np.all(computed[:, 1:3] == reference[:, 1:3]))


def scene_of(problem, tolerance: float, method: str = "auto"):
    """Return the Scene of a problem, to be integrated with `tolerance`; no history is stored."""
    settings = {"simulate.tolerance": tolerance, "simulate.method": method}
    return scene.build(grid.load(problem.grid, scene.catalogue(), settings).case(0))


def restitution_of(factor: float) -> float:
    """Return the ratio of rebound to approach speed under F = F_elastic (1 + chi u), chi being `factor`.

    It is (1 + W(-(1 + chi) exp(-(1 + chi)))) / chi with Lambert's W, for any elastic law, masses and speed.
    """
    return float(1.0 + lambertw(-(1.0 + factor) * math.exp(-(1.0 + factor))).real) / factor


def _reference_entries() -> dict:
    """Return the entries of the reference trajectories by name."""
    file = resources.files(__package__) / "references" / "planar.json"
    return json.loads(file.read_text(encoding="utf-8"))["problems"]


def all_problems() -> list:
    """Return all problems."""
    return [
        *(_reference_problem(name, entry) for name, entry in _reference_entries().items()),
        _stiff_problem(),
        _impact_pair_problem(),
    ]


def _stiff_problem() -> ReferenceTrajectory:
    """Return a heavily damped contact as a problem; its trajectory is our own at the tightest tolerance.

    scipy's methods, which share only the force law with it, give the same trajectory.
    """
    source = copy.deepcopy(_reference_problem("", _reference_entries()["b_base"]).grid)
    (joint,) = source["joints"]
    source["joints"][joint]["contact"] = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 1e6}
    source["simulate"]["revolutions"] = STIFF_TURNS
    speed = grid.load(source, scene.catalogue()).case(0).drive.speed
    times = np.arange(1, 41) / 40 * STIFF_TURNS * 2.0 * math.pi / speed
    scales = np.array([0.05, 0.05, speed, speed * CRANK])
    title = "rod-slider, damped by 1e6 N s/m; reference: ours at 1e-12"
    without_samples = ReferenceTrajectory(
        "b_damped",
        title,
        source,
        scales,
        np.empty((0, 0)),
        times,
        np.empty((0, 5)),
        STIFF_TURNS,
        min_rival_tolerance=1e-6,
    )
    reference = solution_of(without_samples, simulate(scene_of(without_samples, REFERENCE_TOLERANCE), times=times))
    return without_samples._replace(samples=reference.states, events=reference.events)


def _reference_problem(name: str, entry: dict) -> ReferenceTrajectory:
    """Return a reference trajectory as a problem."""
    joint = {
        "clearance": entry["clearance"],
        "bearing_radius": 0.01,
        "contact": {
            "law": "lankarani-nikravesh",
            "stiffness": entry["stiffness"],
            "restitution": entry["restitution"],
            "onset": "first",  # as for the references
        },
    }
    if "friction" in entry:
        joint["friction"] = entry["friction"]
    source = {
        "mechanism": {
            "type": "slider-crank",
            "crank": {"length": CRANK, "mass": 0.3, "inertia": 1e-4},
            "rod": {"length": ROD, "mass": 0.21, "inertia": 2.5e-4},
            "slider": {"mass": 0.14},
            "gravity": entry["gravity"],
        },
        "drive": {"speed": entry["speed"]},
        "joints": dict.fromkeys(entry["joints"], joint),
        "simulate": {"revolutions": entry["revolutions"], "discard": 0},
        "save": {"orbits": "none"},
    }
    samples = np.array(entry["samples"])
    names = [column_name(joint) for joint in entry["joints"]]
    events = [(t, names.index(joint), EVENT_KINDS[kind], rate, peak) for t, joint, kind, rate, peak in entry["events"]]
    speed = 2.0 * math.pi * entry["revolutions"] / samples[-1, 0]
    order, coordinate_count = (
        ([0, 1], 2) if len(names) == 1 else ([2, 3, 0, 1], 4)
    )  # two joints: the rod's centre comes first
    scales = np.array([0.05] * coordinate_count + [speed] + [speed * CRANK] * (coordinate_count - 1))
    values = samples[:, 1:][:, order + [coordinate_count + column for column in order]]
    return ReferenceTrajectory(
        name, entry["title"], source, scales, values, samples[:, 0], np.array(events, dtype=float), entry["revolutions"]
    )


def _impact_pair_problem() -> ImpactPair:
    """Return the impact pair as a problem."""
    source = {
        "mechanism": {"type": "impact-pair", "masses": [0.2, 0.2], "speed": 1.0},
        "joints": {
            "pair": {
                "clearance": 1e-3,
                "contact": {
                    "law": "lankarani-nikravesh",
                    "stiffness": 6.61e10,
                    "restitution": 0.9,
                    "onset": "first",  # supported by the rivals
                },
            }
        },
        "simulate": {"impacts": 5},
        "save": {"orbits": "none"},
    }
    ratio = restitution_of(0.75 * (1.0 - 0.9**2))
    return ImpactPair("impact_pair", "five impacts of two bodies", source, ratio, 5, 1.0)


def solution_of(problem, trajectory) -> Solution:
    """Return the Trajectory of `clearsweep.simulate` as a Solution."""
    summary, channels = trajectory.summary, trajectory.channels
    names = _channel_names(problem)
    states = np.column_stack([channels[name] for name in names]) if channels and names else np.empty((0, 0))
    events, joints = trajectory.events, [column_name(joint) for joint in problem.grid["joints"]]
    rows = [
        (event["t"], joints.index(event["joint"]), EVENT_KINDS[event["kind"]], event["rate"], event["force_peak"])
        for event in events
    ]
    return Solution(
        states, np.array(rows).reshape(-1, 5), summary["steps"], summary["steps_rejected"], summary["rhs_evaluations"]
    )


def _channel_names(problem) -> list[str]:
    """Return the channels with the compiled state of a problem with known samples, in its order."""
    if problem.measure == "restitution":
        return []
    rod = ["rod/x", "rod/y"] if len(problem.grid["joints"]) == 2 else []
    rates = ["rod/vx", "rod/vy"] if rod else []
    return ["rod/angle", "slider/x", *rod, "rod/rate", "slider/v", *rates]
