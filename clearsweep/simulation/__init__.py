"""Simulates one case: from its values to its motion and its figures.

Sweeps and reports reach the mechanics through these functions only.
"""

from ..contracts.case import Case
from ..contracts.results import Trajectory
from ..mechanics.joints.registry import (
    elastic_choices,
    elastic_forces,
    has_laws,
    jam_angle,
    penetration_limit,
    restitution,
)
from ..mechanics.machines.contract import IdealMotion
from ..mechanics.wear import MAX_BINS
from .advice import (
    SUITABLE,
    Recommendation,
    advice_text,
    alternatives,
    elastic_ratings,
    laws_text,
    recommendations,
    recommendations_for,
    recommended_texts,
)
from .analyses.life import Log
from .analyses.repeated import build
from .analyses.trajectory import (
    compile_for,
    compile_loop,
    peak_revolution,
    pin_reactions,
    reactions_unknown,
    simulate,
)
from .machine.ideal import ideal_motion, ideal_peaks, mechanism_of
from .machine.shaking import ideal_frame_force
from .machine.sketch import Sketch, SketchedBody, SketchedJoint, SketchedLoad, sketch
from .remarks import BendingLink, ElasticLink, bending_links, elastic_links, warnings
from .setup.places import random_places
from .setup.scene import catalogue, derived, load_case, signature


def load() -> None:
    """Do nothing: importing this module has loaded everything that cases need."""


def solve(case: Case, log: Log | None = None) -> Trajectory:
    """Return the result of a resolved case; a life resumes from its `log`."""
    return simulate(build(case), log=log, events=False)
