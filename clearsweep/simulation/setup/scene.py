"""Builds a scene (types and numbers) from a case (names and numbers): only here do names become types."""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from ... import grid
from ...answers.verdict import NO_LIMITS, LimitsAndFigures
from ...contracts.case import Case
from ...contracts.catalogue import Catalogue, Figure, Mechanism
from ...contracts.layout import CaseFeatures, Layout, features_of
from ...contracts.machine import STARTED_FRACTION, Constant, Machine, Motor, Path, Schedule
from ...language.errors import InputError
from ...mechanics.coupling import rates
from ...mechanics.coupling.state import every_state
from ...mechanics.joints import registry
from ...mechanics.joints.contract import contact_modes, every_contact, every_latched, state_kinds_of
from ...mechanics.joints.lubricated import film_depths
from ...mechanics.joints.worn import has_worn_shape, seated_position
from ...mechanics.laws.contract import ONSET_FLOOR, OWN_RECIPES
from ...mechanics.machines import MECHANISMS, planar
from ...mechanics.machines.contract import Built, body_angles
from ...mechanics.machines.described import unclosed
from ...mechanics.wear import Worn
from ...searches import SEARCHES
from ...tracing.compiled.family import flatten, numbers_of
from ..figures.catalogue import FIGURES, check_channels
from ..machine.ideal import ideal_motion, machine_of, mechanism_of, start_angles
from ..machine.shaking import shaking_of
from . import places

# The independent variable of a run and the ends of its revolutions: time, or the angle of a free crank.

STALL_TURNS = 100.0  # turns at nominal speed after which a free crank that hardly moves counts as stalled


class Clock:
    """Shows the independent variable of a run."""

    free = False  # whether a run is measured along the angle of a free crank

    def value_after(self, revolutions: float) -> float:
        """Return the time (s), or the angle (rad) of a free crank, after a number of revolutions; inf if never."""
        raise NotImplementedError

    def values_after(self, revolutions: np.ndarray) -> np.ndarray:
        """Return the values after arrays of revolutions."""
        return np.array([self.value_after(turns) for turns in revolutions])


@dataclass(frozen=True)
class EvenClock(Clock):
    """Clock of a steady machine, which shows time, or of a free crank, which shows its angle."""

    period: float  # s or rad, of a revolution
    start: float = 0.0
    free: bool = False

    def value_after(self, revolutions: Any) -> Any:
        """Return the time (s) or the angle (rad) after numbers of revolutions."""
        return self.start + self.period * revolutions

    values_after = value_after


@dataclass(frozen=True)
class ScheduledClock(Clock):
    """Clock of a crank whose speed follows a table; it shows time."""

    times: np.ndarray  # (rows,) s, first row at 0 or before
    speeds: np.ndarray  # (rows,) rad/s, positive in the direction of the crank's turning
    angles: np.ndarray  # (rows,) rad, from the start to each row

    def value_after(self, revolutions: float) -> float:
        """Return the time (s) after a number of revolutions, or inf if the crank comes to rest before."""
        angle = 2.0 * math.pi * revolutions
        row = int(np.searchsorted(self.angles, angle, side="right")) - 1
        row = min(max(row, 0), len(self.times) - 1)
        remaining_angle, speed = angle - self.angles[row], self.speeds[row]
        if remaining_angle == 0.0:
            return float(self.times[row])
        if row == len(self.times) - 1:
            return float(self.times[row] + remaining_angle / speed) if speed > 0.0 else math.inf
        acceleration = (self.speeds[row + 1] - speed) / (self.times[row + 1] - self.times[row])
        end_speed = math.sqrt(max(speed * speed + 2.0 * acceleration * remaining_angle, 0.0))
        return float(self.times[row] + 2.0 * remaining_angle / (speed + end_speed))


@dataclass(frozen=True)
class PathClock(Clock):
    """Clock of a crank whose angle follows a table; it shows time."""

    path: Path
    direction: float  # 1, or -1 for a crank that turns clockwise

    def value_after(self, revolutions: float) -> float:
        """Return the time (s) after a number of revolutions, or inf if the crank never makes them."""
        return planar.passage_time(self.path, self.path.start_angle + self.direction * 2.0 * math.pi * revolutions)


def clock_of(machine: Machine | None, period: float, *, is_timed: bool = False) -> Clock:
    """Return the clock of a machine; `period` (s): a revolution at its nominal speed, or a cycle if it `is_timed`."""
    if machine is None or is_timed or isinstance(machine.drive, Constant):
        return EvenClock(period)
    if isinstance(machine.drive, Motor):
        return EvenClock(2.0 * math.pi, machine.drive.start_angle, free=True)
    if isinstance(machine.drive, Path):
        return PathClock(machine.drive, planar.direction_of(machine.drive))
    assert isinstance(machine.drive, Schedule)  # the only other drive
    return scheduled_clock(machine.drive)


def scheduled_clock(schedule: Schedule) -> ScheduledClock:
    """Return the clock of a speed table from t = 0 on; the speed is constant before the first row."""
    is_later, turned = schedule.times > 0.0, planar.direction_of(schedule) * schedule.speeds
    times = np.concatenate([[0.0], schedule.times[is_later]])
    speeds = np.concatenate([[np.interp(0.0, schedule.times, turned)], turned[is_later]])
    angles = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * np.diff(times))])
    return ScheduledClock(times, speeds, angles)


def knots_of(machine: Machine | None, *, is_timed: bool) -> list[float]:
    """Return the times (s) at which an acceleration or the slope of a load jumps; empty for a run over angles."""
    has_times = machine is not None and (is_timed or not isinstance(machine.drive, Motor))
    return planar.discontinuity_times(machine) if machine and has_times else []


def start_up(machine: Machine | None) -> tuple[float, float]:
    """Return the speed (rad/s) at which a motor counts as started, and the time (s) of this.

    The speed is 0 for other drives and for constant torque; the time is 0 if the crank starts fast enough, else inf.
    """
    if machine is None or not isinstance(machine.drive, Motor) or math.isinf(machine.drive.no_load_speed):
        return 0.0, math.inf
    speed = STARTED_FRACTION * machine.drive.no_load_speed
    return speed, 0.0 if machine.drive.initial_speed >= speed else math.inf


# Inputs of all runs of a scene: its initial state, error scales, and numbers of its contacts.

#: Allowed error of one step, per tolerance: of coordinates in clearances, of rates in clearances times
#: crank speed, of roots of penetration in roots of the clearance.  Errors of coordinates rotate the contact force a
#: little; those of a root of penetration change its magnitude, so they count most.  Chosen on the one-joint
#: reference trajectories: 15 to 20 % fewer evaluations at equal error than with 1, 1, 1 or a relative tolerance.
POSITION_WEIGHT, RATE_WEIGHT, ROOT_WEIGHT = 30.0, 3.0, 0.1
FILM_RATE_FACTOR = 0.1  # of RATE_WEIGHT with a film: a small error of a rate is a large one of the damping force
#: Revolutions below which the scale of errors of rates is a tenth of the clearance over the run's duration, not that of
#: the crank.
SHORT_RUN = 0.1 / (2.0 * math.pi)
ROUNDING = 1e-15  # of the mechanism's size and speed: least tolerance
LENGTH_UNIT = 1e-4  # of the mechanism's size: in place of a clearance where no joint has one


class InitialState(NamedTuple):
    """Arrays of the initial state of a motion."""

    parameters: Any  # numbers of the compiled scene, see `family.flatten`; names as in Work
    y: Any
    weight: Any
    latched: Any
    clearance: Any
    film: Any


class SceneInputs(NamedTuple):
    """Inputs that all runs of a scene share."""

    initial_values: list[float]  # the arrays of an InitialState, concatenated
    loop_inputs: list[float]  # knots, initial values of internal states, sides and depth limits of the contacts
    knots: int  # number of the first of these
    has_friction: tuple[bool, ...]  # by contact
    sliding_distance: tuple[float, ...]  # m, by contact: of earlier wear


def scene_inputs(scene: "Scene") -> SceneInputs:
    """Return the inputs that all runs of a scene share."""
    case, built, value, start = scene.case, scene.built, scene.value, scene.start
    modes = [contact_modes(joint) for joint in value.joints]

    def by_contact(values: Iterable[Any]) -> list[Any]:
        """Return values of the joints for each of their contacts."""
        return [each for each, of_joint in zip(values, modes, strict=True) for _ in of_joint]

    sides = by_contact(joint.side for joint in value.joints)
    internal, latched = _internal_states(value)
    knots = knots_of(scene.machine, is_timed=case.simulate.period is not None)
    latches = [ONSET_FLOOR] * len(sides) + [began for _, began in latched]
    worn = (scene.worn.get(joint.name) for joint in case.joints)
    initial = InitialState(
        parameters=numbers_of(value),
        y=start.tolist(),
        weight=_weights(case, built, value, len(sides), [state.scale for _, state, _ in internal]),
        latched=latches if scene.earlier_end is None else places.latched_of(scene.earlier_end, value.joints, built),
        clearance=by_contact(joint.clearance for joint in value.joints),
        film=chain.from_iterable(by_contact(map(film_depths, value.joints))),
    )
    limit_depths = by_contact(map(registry.penetration_limit, case.joints))  # m, to which each elastic law is valid
    return SceneInputs(
        initial_values=list(chain.from_iterable(initial)),
        loop_inputs=[*knots, *[began for _, _, began in internal], *sides, *limit_depths],
        knots=len(knots),
        has_friction=tuple(by_contact(joint.friction is not None or joint.film is not None for joint in case.joints)),
        sliding_distance=tuple(by_contact(each.sliding_distance if each else 0.0 for each in worn)),
    )


def length_unit(joints: tuple, built: Built) -> float:
    """Return the length (m) by which motions are measured: the least clearance, or a share of the machine's size."""
    return float(min([joint.clearance for joint in joints], default=LENGTH_UNIT * built.size))


def initial_shapes(value: rates.Scene, start: np.ndarray) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of an InitialState."""
    contacts, latched = len(every_contact(value.joints)), _internal_states(value)[1]
    shapes = flatten(value).shape, start.shape, start.shape, (contacts + len(latched),)
    return InitialState(*shapes, (contacts,), (contacts, 2))._asdict()


def _internal_states(value: rates.Scene) -> tuple[list, list]:
    """Return the internal state of a scene's laws: the integrated part and the latched part."""
    return every_state(value), every_latched(value.joints) if state_kinds_of(value).latched else []


def _weights(case: Case, built: Built, value: rates.Scene, contacts: int, internal: list[float]) -> list[float]:
    """Return one over the allowed error of one step in each component of the state; `internal`: scales of its laws."""
    tolerance, mechanism_size, lengths = case.simulate.tolerance, built.size, built.lengths.tolist()
    clearance, has_film = length_unit(value.joints, built), any(joint.film for joint in case.joints)
    rate_weight = FILM_RATE_FACTOR * RATE_WEIGHT if has_film else RATE_WEIGHT
    length_error = max(POSITION_WEIGHT * tolerance * clearance, ROUNDING * mechanism_size)
    rate_error = max(rate_weight * tolerance * clearance, ROUNDING * mechanism_size) * value.reference_rate
    turns = case.simulate.turns(value.reference_rate)
    if 0.0 < turns < SHORT_RUN:  # the crank is slow compared with the motion
        rate_error *= SHORT_RUN / turns
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


_LAYOUTS: dict[CaseFeatures, tuple[tuple[tuple[Figure, ...], Mechanism], Layout]] = {}  # with their sources
SEAT_ITERATIONS = 3  # iterations on worn shapes: body angles depend slightly on the seats


@dataclass(frozen=True)
class Scene:
    """A case ready to run: its compiled form and its initial state."""

    case: Case
    mechanism: Mechanism
    built: Built
    value: rates.Scene
    layout: Layout
    start: np.ndarray  # (n,) initial state, see mechanics.rates
    in_contact: bool  # some joint starts in contact
    machine: Machine | None  # planar machine; None: the mechanism has its own equations
    crank_clock: Clock
    worn: Mapping[str, Worn] = field(default_factory=dict)  # earlier wear by joint; a missing joint is unworn
    deadline: float = math.inf  # s, processor time at which the case is abandoned
    keep_events: bool = False  # whether its runs return their events
    verdict: LimitsAndFigures = NO_LIMITS  # user-defined figures and limits, which are not part of the case
    build_time: float = 0.0  # s, processor time to build it
    earlier_end: places.Carried | None = None  # the end of the case before it in its chain

    @cached_property
    def inputs(self) -> SceneInputs:
        """Return the inputs that all its runs share."""
        return scene_inputs(self)

    def with_settings(self, **settings: Any) -> "Scene":
        """Return the scene with changed values in `simulate`."""
        return replace(self, case=self.case._replace(simulate=self.case.simulate._replace(**settings)))

    def for_run(self, deadline: float, *, keep_events: bool) -> "Scene":
        """Return the scene with another deadline (s), whose run returns its events or not.

        Every case needs one, and this takes a fifth of the time of `replace`.
        """
        copied = object.__new__(Scene)
        copied.__dict__.update(self.__dict__, inputs=self.inputs, deadline=deadline, keep_events=keep_events)
        return copied


def catalogue() -> Catalogue:
    """Return everything that a grid can name and that its cases can report."""
    return Catalogue(
        registry.all_laws(),
        tuple(MECHANISMS.values()),
        FIGURES,
        *rates.CHANNELS,
        start_problem=_start_problem,
        searches=SEARCHES,
        enter_laws=registry.enter_laws,
    )


def _start_problem(case: Case) -> tuple[str, str] | None:
    """Return the path at fault and a sentence if a case cannot start, else None.

    Only a start that the grid describes, or bodies or laws that it defines, can be impossible.
    """
    outline, is_placed = case.outline, case.simulate.start != "centred"
    if not (outline.bodies or outline.laws or is_placed or mechanism_of(case).spatial):
        return None
    with grid.guarded(case.law_files):  # what these laws do as Python is known only after this
        problem = _problem_of(lambda: list(registry.own_law_remarks(case)))
    problem = problem or _problem_of(lambda: build(case._replace(before=())))
    return problem or _problem_of(lambda: check_channels(case, [channel.name for channel in layout_of(case).channels]))


def _problem_of(act: Callable[[], Any]) -> tuple[str, str] | None:
    """Return the path and the sentence of the InputError that an action raises, else None."""
    try:
        act()
    except InputError as error:
        path, _, sentence = str(error).partition(": ")
        return path, sentence
    return None


def load_case(source: str | PathLike | Mapping, overrides: Mapping[str, Any] | None = None) -> Scene:
    """Return the scene of a grid without `sweep`, given as a path or a dict.

    `overrides` maps dotted paths to replacement values.  Raises InputError.
    """
    loaded = grid.load(source, catalogue(), overrides)
    if len(loaded) != 1:
        raise InputError(
            f"{loaded.source or 'the grid'}: sweeps {', '.join(loaded.axes)}; expected one case: override the swept "
            "paths, or use clearsweep.sweep"
        )
    return replace(build(loaded.case(0)), verdict=loaded.verdict)


def layout_of(case: Case) -> Layout:
    """Return the layout of a case; cases with the same features share one, since creating it takes 70 us."""
    features, sources = features_of(case), (FIGURES, MECHANISMS[case.mechanism.type])
    stored = _LAYOUTS.get(features)
    if stored is None or any(old is not new for old, new in zip(stored[0], sources, strict=True)):
        stored = _LAYOUTS[features] = sources, Layout.with_features(features, catalogue())
    return stored[1]


def enter_laws(case: Case) -> None:
    """Run the law files of a case whose laws this process does not have yet.  Raises InputError if one may not run."""
    if case.law_files and case.outline.laws not in OWN_RECIPES:
        registry.enter_laws(grid.run_all(case.law_files), case.outline.laws)


def build(case: Case, worn: Mapping[str, Worn] | None = None, earlier_end: places.Carried | None = None) -> Scene:
    """Return the scene of a resolved case.  Raises InputError if its initial state is impossible.

    `worn` maps names of joints to their earlier wear; the run adds to it.  `earlier_end` is that of the case before it
    in its chain; `analyses.chain.build` knows it.
    """
    if case.before:
        raise LookupError("a case of a chain starts where the case before it ended: analyses.chain.build runs that one")
    begin, worn = time.thread_time(), dict(worn or {})
    enter_laws(case)
    mechanism = mechanism_of(case)
    machine = None if mechanism.build else machine_of(mechanism, case)
    flanked: dict[str, Any] = {each.name: each for each in machine.joints} if machine else {}
    joints: dict[str, Any] = {
        joint.name_in_machine: registry.compile_mesh(joint, flanked[joint.name_in_machine])
        if joint.flanked
        else registry.compile_joint(joint, mechanism.site(joint.name).distal, worn.get(joint.name))
        for joint in case.joints
    }
    terms: tuple[Any, ...] = tuple(joints.values())
    offsets, depth_roots = dict.fromkeys(joints, (0.0, 0.0)), np.zeros(len(every_contact(terms)))
    if case.simulate.start == "seated":
        ideal = ideal_motion(case, np.array(case.drive.start_angle if case.drive else 0.0))
        assert ideal is not None  # grids accept `start` only for mechanisms that have one
        offsets, depth_roots = places.seated_offsets(ideal.reactions, joints)
    built, seats = _build_mechanism(case, mechanism, machine, joints, offsets), offsets
    for _ in range(SEAT_ITERATIONS if depth_roots.any() and any(has_worn_shape(term) for term in terms) else 0):
        offsets = dict(seats)
        all_angles, contact = body_angles(built.value, built.start), 0
        for (name, term), angles in zip(joints.items(), all_angles, strict=True):
            if has_worn_shape(term):
                position, depth = seated_position(term, term.side * seats[name], angles)
                offsets[name], depth_roots[contact] = term.side * position, math.sqrt(depth)
            contact += len(contact_modes(term))
        built = _build_mechanism(case, mechanism, machine, joints, offsets)
    if any(joint.rolling for joint in case.joints):
        terms, depth_roots = places.with_elements_at_start(case, built, terms, depth_roots)
    if case.simulate.start in places.BRANCHES:
        built = places.with_places(case, built, terms, earlier_end)
    if mechanism.spatial:
        places.check_spatial_start(built, joints)
    if machine is not None and any(body.initial for body in machine.bodies.values()):
        places.check_planar_start(built, joints)
    if any(joint.flanked for joint in case.joints):
        places.press_flanks(built, joints, depth_roots)
    if machine is not None:
        places.check_slot_lengths(case, machine)
    sigma = math.sqrt(length_unit(terms, built))
    shaking = shaking_of(case, mechanism, built) if case.vibration else ()
    value = rates.Scene(built.value, terms, (0.0,) * len(built.lengths), built.rate, sigma, shaking)
    internal: Sequence[float] = [initial_value for _, _, initial_value in every_state(value)]
    if earlier_end is not None:
        depth_roots, internal = earlier_end.roots * np.sqrt(places.contact_units(terms)), earlier_end.internal.tolist()
    start = np.array([*built.start.tolist(), *depth_roots.tolist(), *internal])
    cycle = case.simulate.period
    length = 2.0 * math.pi / built.rate if cycle is None else cycle  # s
    layout, angle_clock = layout_of(case), clock_of(machine, length, is_timed=cycle is not None)
    elapsed = time.thread_time() - begin
    parts = case, mechanism, built, value, layout, start, bool(depth_roots.any()), machine, angle_clock, worn
    return Scene(*parts, keep_events=case.save.orbits != "none", build_time=elapsed, earlier_end=earlier_end)


def state_units(scene: Scene) -> np.ndarray:
    """Return the change of each coordinate for one clearance, and of each rate for clearance times crank speed."""
    unit = length_unit(scene.value.joints, scene.built) / scene.built.lengths
    return np.concatenate([unit, unit * scene.value.reference_rate])


def _build_mechanism(case: Case, mechanism: Mechanism, machine: Machine | None, joints: dict, offsets: dict) -> Built:
    """Return the mechanism of a case with its clearances; raise InputError if it cannot be assembled."""
    built: Built
    try:
        if machine is not None:
            built = planar.build(machine, joints, offsets)
        else:
            assert mechanism.build is not None  # without a machine the mechanism has its own equations
            speed = case.drive.speed if case.drive else None
            built = mechanism.build(case.mechanism.values, speed, joints, offsets)
    except planar.ClosureError as error:
        path, sentence = unclosed(error, case)
        raise InputError(f"mechanism.{path}: {sentence}") from error
    except planar.MobilityError as error:
        raise InputError(f"mechanism: {error}") from error
    return built


def signature(case: Case) -> tuple:
    """Return the key of the compiled code of a case: the types in its scene."""
    enter_laws(case)
    joints = tuple(
        (
            joint.name,
            *map(_type_text, registry.compile_contact(joint) if joint.is_dry else ()),
            *map(_type_text, registry.compile_film(joint) if joint.film else ()),
            _type_text(registry.compile_friction(joint)),
            _type_text(registry.compile_wear(joint)),
            (joint.wear is not None and joint.wear.evolve) or joint.profile is not None,
        )
        for joint in case.joints
    )
    return case.mechanism.type, case.outline, joints


def _type_text(term: tuple) -> str:
    """Return the name of a compiled type with those of the types in it: 'Archard(Mean)'."""
    field_texts = ", ".join(_type_text(field_value) for field_value in term if isinstance(field_value, tuple))
    return f"{type(term).__name__}({field_texts})" if field_texts else type(term).__name__


def derived(case: Case) -> dict[str, tuple[float, str]]:
    """Return the derived values of a case: dotted path -> (value, unit)."""
    of_joints = {
        f"joints.{joint.name}.{key}": value
        for joint in case.joints
        for key, value in registry.derived_values(joint).items()
    }
    return start_angles(case) | of_joints
