"""Initial state and inputs of an integration, as arrays prepared for many cases before the first is run."""

import math
from collections.abc import Sequence
from itertools import accumulate, chain, pairwise
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..mechanics.compiled.family import flatten, numbers_of
from ..mechanics.coupling.state import every_state
from ..mechanics.joint import registry
from ..mechanics.joint.contract import (
    ONSET_FLOOR,
    contact_modes,
    every_contact,
    every_latched,
    states_of,
)
from ..mechanics.joint.lubricated import film_depths
from ..mechanics.solver import integration
from .crank_clock import STALL_TURNS, knots_of
from .revolutions import NO_MARKS, Marks
from .scene import Scene

#: Allowed error of one step, per tolerance: of coordinates in clearances, of rates in clearances times
#: crank speed, of roots of penetration in roots of the clearance.  Errors of coordinates rotate the contact force a
#: little; those of a root of penetration change its magnitude, so they count most.  Chosen on the one-joint
#: reference trajectories: 15 to 20 % fewer evaluations at equal error than with 1, 1, 1 or a relative tolerance.
POSITION_WEIGHT, RATE_WEIGHT, ROOT_WEIGHT = 30.0, 3.0, 0.1
FILM_RATE_FACTOR = 0.1  # of RATE_WEIGHT with a film: a small error of a rate is a large one of the damping force
MAX_STEP_TURNS = 0.02  # crank turns per step at most: keeps maxima and histograms of slow motions accurate
ROUNDING = 1e-15  # of the mechanism's size and speed: least tolerance
NO_TIMES = np.empty(0)  # to report
UNLIMITED = 2**62  # largest count of steps or events

_METHODS = {"auto": integration.AUTO, "explicit": integration.EXPLICIT, "implicit": integration.IMPLICIT}


def period(scene: Scene) -> float:
    """Return the time (s) of a revolution of the crank."""
    return 2.0 * math.pi / scene.value.reference_rate


class BatchKey(NamedTuple):
    """Properties that scenes of one type must share to reuse one Run."""

    layout: Layout
    samples: int
    marks: int
    knots: int


class RunInputs(NamedTuple):
    """Input arrays of the loop, under their names in Work, Record and RevolutionMarks."""

    times: np.ndarray
    marks: np.ndarray
    knots: np.ndarray
    began: np.ndarray
    side: np.ndarray
    limit_depth: np.ndarray


def inputs_of(values: np.ndarray, batch_key: BatchKey, contacts: int, internal: int) -> RunInputs:
    """Return views of the inputs in one array, for a number of contacts and `internal` states."""
    sizes = batch_key.samples, batch_key.marks, batch_key.knots, internal, contacts, contacts
    return RunInputs._make(values[first:end] for first, end in pairwise(accumulate(sizes, initial=0)))


class InitialState(NamedTuple):
    """Arrays of the initial state of a motion."""

    parameters: Any  # numbers of the compiled scene, see `family.flatten`; names as in Work
    y: Any
    weight: Any
    latched: Any
    clearance: Any
    film: Any


class Start(NamedTuple):
    """Initial state and inputs of an integration of a scene."""

    scene: Scene
    batch_key: BatchKey
    marks: Marks
    inputs: np.ndarray  # the arrays of a RunInputs, concatenated
    initial_values: np.ndarray  # the arrays of an InitialState, concatenated
    has_friction: Sequence[bool]  # by contact
    sliding_distance: Sequence[float]  # m, by contact: of earlier wear
    max_step: float  # s, longest step

    @property
    def times(self) -> np.ndarray:
        """Return the times at which results are reported."""
        return self.inputs[: self.batch_key.samples]


def start_of(scene: Scene, times: np.ndarray, marks: Marks = NO_MARKS) -> Start:
    """Return the Start of a scene with results at `times` and these `marks`."""
    contacts = ContactInputs(*zip(*_contact_inputs(scene), strict=True))
    internal, latched = _internal_states(scene)
    knots = knots_of(scene.machine)
    inputs = [  # in the order of RunInputs
        *scene.crank_clock.values_after(marks.turns).tolist(),
        *knots,
        *[began for _, _, began in internal],
        *contacts.side,
        *contacts.limit_depth,
    ]
    initial = InitialState(
        parameters=numbers_of(scene.value),
        y=scene.start.tolist(),
        weight=_weights(scene, len(contacts.side), [state.scale for _, state, _ in internal]),
        latched=[ONSET_FLOOR] * len(contacts.side) + [began for _, began in latched],
        clearance=contacts.clearance,
        film=chain.from_iterable(contacts.film),
    )
    return Start(
        scene=scene,
        batch_key=BatchKey(scene.layout, times.size, marks.turns.size, len(knots)),
        marks=marks,
        inputs=np.concatenate([times, inputs]),
        initial_values=np.array(list(chain.from_iterable(initial))),
        has_friction=contacts.has_friction,
        sliding_distance=contacts.sliding_distance,
        max_step=MAX_STEP_TURNS * period(scene) if scene.mechanism.turns else math.inf,
    )


class ContactInputs(NamedTuple):
    """Inputs that a contact has from its joint, or those of all contacts by field."""

    side: Any  # of the joint, see `dry.Joint`
    limit_depth: Any  # m, to which its elastic law is valid
    clearance: Any  # m
    film: Any  # m, see `film_depths`
    has_friction: Any  # whether there may be a tangential force
    sliding_distance: Any  # m, of earlier wear


def _contact_inputs(scene: Scene) -> list[ContactInputs]:
    """Return the inputs of all contacts."""
    contacts: list[ContactInputs] = []
    for joint, case_joint in zip(scene.value.joints, scene.case.joints, strict=True):
        earlier_wear = scene.worn.get(case_joint.name)
        inputs = ContactInputs(
            side=joint.side,
            limit_depth=registry.penetration_limit(case_joint),
            clearance=joint.clearance,
            film=film_depths(joint),
            has_friction=case_joint.friction is not None or case_joint.film is not None,
            sliding_distance=earlier_wear.sliding_distance if earlier_wear else 0.0,
        )
        contacts += [inputs] * len(contact_modes(joint))
    return contacts


def initial_shapes(scene: Scene) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of an InitialState."""
    contacts, latched = len(every_contact(scene.value.joints)), _internal_states(scene)[1]
    shapes = flatten(scene.value).shape, scene.start.shape, scene.start.shape, (contacts + len(latched),)
    return InitialState(*shapes, (contacts,), (contacts, 2))._asdict()


def _internal_states(scene: Scene) -> tuple[list, list]:
    """Return the internal state of a scene's laws: the integrated part and the latched part."""
    return every_state(scene.value), every_latched(scene.value.joints) if states_of(scene.value).latched else []


def _weights(scene: Scene, contacts: int, internal: list[float]) -> list[float]:
    """Return one over the allowed error of one step in each component of the state; `internal`: scales of its laws."""
    value, tolerance = scene.value, scene.case.simulate.tolerance
    clearance, mechanism_size = min([joint.clearance for joint in value.joints]), scene.built.size
    lengths, has_film = scene.built.lengths.tolist(), any(joint.film for joint in scene.layout.joints)
    rate_weight = FILM_RATE_FACTOR * RATE_WEIGHT if has_film else RATE_WEIGHT
    length_error = max(POSITION_WEIGHT * tolerance * clearance, ROUNDING * mechanism_size)
    rate_error = max(rate_weight * tolerance * clearance, ROUNDING * mechanism_size) * value.reference_rate
    time_error = max(POSITION_WEIGHT * tolerance, ROUNDING) / value.reference_rate
    root_error = ROOT_WEIGHT * tolerance * math.sqrt(clearance)
    allowed_errors = [
        *[length_error / length for length in lengths],
        *[rate_error / length for length in lengths],
        time_error,
        *[root_error] * contacts,
        *[tolerance * scale for scale in internal],
    ]
    return [1.0 / error for error in allowed_errors]


def control_of(scene: Scene, end: float, *, keep_events: bool) -> integration.Control:
    """Return the control of an integration up to `end` (s, or rad for a free crank)."""
    settings = scene.case.simulate
    has_crank, free = scene.mechanism.turns, scene.crank_clock.free
    window_start = scene.crank_clock.value_after(settings.discard) if has_crank else 0.0
    budget_units = max(settings.revolutions, 1.0) if has_crank else settings.impacts
    return integration.Control(
        window=window_start,
        end=end,
        separations=0 if has_crank else int(settings.impacts),
        step_budget=min(int(settings.step_budget * budget_units), UNLIMITED),
        event_budget=min(int(settings.event_budget * budget_units), UNLIMITED),
        method=_METHODS[settings.method],
        keep_events=keep_events,
        time_limit=settings.time_limit if free else math.inf,
        patience=STALL_TURNS * period(scene) if free else math.inf,
    )
