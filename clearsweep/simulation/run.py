"""One integration of a scene: its buffers, how accurate it is to be, and the compiled calls that do it."""

import functools
import math
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..mechanics.attempt import attempt_of
from ..mechanics.compiled.family import NO_ENTRY, flatten, put_numbers
from ..mechanics.compiled.kept import Kept
from ..mechanics.compiled.rows import Board
from ..mechanics.joint import registry
from ..mechanics.joint.contract import (
    ONSET_FLOOR,
    contact_modes,
    every_contact,
    every_internal_state,
    every_latched,
    touches,
)
from ..mechanics.joint.guards import guards_of
from ..mechanics.joint.loss.contract import awaits_mass, keeps_onset
from ..mechanics.joint.lubricated import film_depths
from ..mechanics.joint.places import after_joint, as_it_is, first_place, observed_columns
from ..mechanics.joint.wear.contract import ACCOUNT, FINEST, SLID
from ..mechanics.joint.wear.step import room_of, wear_of
from ..mechanics.observe import histogram
from ..mechanics.observe import tally as tallies
from ..mechanics.observe.along import Attempt, step_width
from ..mechanics.observe.between import BETWEEN
from ..mechanics.observe.record import Record
from ..mechanics.rates import rates_of, samples_of, slopes_of
from ..mechanics.solver import dop853, loop, newton, plan
from ..mechanics.solver import event as events
from . import watch
from .lyapunov import Perturbed
from .revolutions import NO_MARKS, Marks, room_for
from .scene import Scene, unit_of
from .turning import PATIENCE, knots_of
from .watch import Watcher

#: Error that one step may make, per tolerance: of the coordinates in clearances, of their rates in clearances times
#: crank rate, of the root of penetration in roots of the clearance.  Errors of the coordinates turn the contact force a
#: little; those of the root of penetration are errors of its size, so they count most.  Chosen on the one-joint
#: reference trajectories: 15 to 20 % fewer evaluations at equal error than with 1, 1, 1 or a relative tolerance.
PLACE_WEIGHT, RATE_WEIGHT, ROOT_WEIGHT = 30.0, 3.0, 0.1
OILED = 0.1  # of RATE_WEIGHT where there is a film: a small error of a rate is a large one of its damping force
LONGEST = 0.02  # turns of the crank a step may span: keeps located maxima and histograms of slow motions sharp
ROUNDING = 1e-15  # of the mechanism's size and speed: no tolerance below it

TIME_BUDGET = -1  # a status besides those of the loop
MOST = 2**62  # steps or events that may be counted

Lane = dict[str, np.ndarray]  # arrays of one of the cases that lie side by side, see `board_of`

_METHODS = {"auto": plan.AUTO, "explicit": events.EXPLICIT, "implicit": events.IMPLICIT}


def period(scene: Scene) -> float:
    """Return how long (s) the crank takes for a turn."""
    return 2.0 * math.pi / scene.value.reference_rate


def board_of(scene: Scene) -> Board:
    """Return room for cases of the type of `scene`: for parameters and for what a step reads and fills."""
    contacts, n = len(every_contact(scene.value.joints)), scene.start.size
    state = (n,), float
    return Board(
        {
            "parameters": (flatten(scene.value).shape, float),
            **dict.fromkeys(("y", "end", "z", "scale"), state),
            "k": ((dop853.ROWS, n), float),
            "o": ((dop853.ROWS, observed_columns(scene.value.joints)), float),
            "mode": ((contacts,), np.int64),
            "latched": ((contacts + len(every_latched(scene.value.joints)),), float),
            "step": ((step_width(contacts, n),), float),
            "ahead": ((plan.AHEAD,), float),
            **dict.fromkeys(("clearance", "highest", "since"), ((contacts,), float)),
            "rubs": ((contacts,), np.int64),
            "film": ((contacts, 2), float),
            "whole": ((tallies.WHOLE,), float),
            "joint": ((contacts, tallies.JOINT), float),
            "bins": ((contacts, 2 * histogram.PARTS), np.int64),
            "spent": ((contacts, tallies.BELOW + 1), float),
        }
    )


def shared(lane: Lane) -> tuple[Attempt, tallies.Ledger]:
    """Return those arrays that a step works on, and those by which it is judged and in which it is entered."""
    tried: Any = [lane[name] for name in Attempt._fields]
    entered: Any = [lane[name] for name in tallies.Ledger._fields]
    return Attempt(*tried), tallies.Ledger(*entered)


def _tally_of(scene: Scene, contacts: int, lane: Lane) -> tallies.Tally:
    """Return room for what is summed up of so many contacts."""
    parts = scene.layout.joints
    worn = any(part.wear_bins for part in parts)
    bins = max(min(part.wear_bins, FINEST) * part.wear_rows for part in parts)
    return tallies.Tally(
        whole=lane["whole"],
        joint=lane["joint"],
        bins=lane["bins"],
        spent=lane["spent"],
        time=np.zeros((contacts, histogram.BINS)),
        ramp=np.zeros((contacts, histogram.BINS)),
        course=np.zeros((contacts, histogram.COURSES, histogram.PARTS + 1)),
        length=np.zeros(1),
        between=np.zeros((BETWEEN, 2 * len(scene.value.coordinates) + 1)),
        room=np.zeros(room_of(contacts, bins) if worn else 0),
        wear=np.zeros(2 * contacts * bins),
        account=np.zeros((contacts, ACCOUNT)),
    )


class Form(NamedTuple):
    """What has to be equal of scenes of one type that one Run can integrate one after the other."""

    layout: Layout
    samples: int
    marks: int
    knots: int

    @classmethod
    def of(cls, scene: Scene, times: np.ndarray, marks: Marks) -> "Form":
        """Return the form of a run with reports at `times` and with `marks`."""
        return cls(scene.layout, times.size, marks.turns.size, knots_of(scene.machine).size)


class Run:
    """The buffers of one integration and what it came to."""

    def __init__(
        self,
        scene: Scene,
        times: np.ndarray,
        *,
        turned: bool = False,
        marks: Marks = NO_MARKS,
        lane: Lane | None = None,
    ):
        """Prepare for reports at `times` (s), or where a free crank has `turned` as far (rad), and for `marks`.

        lane : where among cases that lie side by side; None: it is alone.
        """
        value, contacts = scene.value, every_contact(scene.value.joints)
        internal = every_internal_state(value.joints)
        n, many = scene.start.size, len(contacts)
        self.form = Form.of(scene, times, marks)
        self.parameters = flatten(value)  # compiled code holds its address
        moment = 2 * len(value.coordinates)
        along = 0 if scene.turning.free else moment
        samples = np.zeros((times.size, len(scene.layout.channels)))
        self.record = Record(np.zeros(times.size), samples, along if turned else moment)
        self.lane = lane = lane or board_of(scene).lane(0)
        self.tally = _tally_of(scene, many, lane)
        rates = attempt_of(value, lane["parameters"])
        self.work = events.Work(
            rates=rates if rates.code else rates_of(value, self.parameters),
            takes_steps=int(rates.code != 0),
            sample=samples_of(value, self.parameters) if times.size else NO_ENTRY,
            wear=wear_of(value, self.parameters) if self.tally.room.size else NO_ENTRY,
            time=moment,
            along=along,
            knots=np.zeros(self.form.knots),
            reference_rate=0.0,
            sigma=0.0,
            longest=0.0,
            f=np.zeros((7, n)),
            apart=np.array([modes.apart for _, modes in contacts]),
            pressed=np.array([modes.pressed for _, modes in contacts]),
            side=np.zeros(many),
            ended_by=np.array([-1 if state.kept else contact for contact, state, _ in internal], dtype=np.int64),
            began=np.zeros(len(internal)),
            guards=guards_of(value, self.parameters),
            limit_depth=np.zeros(many),
            counts=np.zeros(events.COUNTS, dtype=np.int64),
            method=np.zeros(3, dtype=np.int64),
            proposals=np.zeros(2 << many),
            control=np.zeros(len(plan.Control._fields)),
            log=np.empty((loop.LOG, 5)),
            slopes=np.zeros(2, dtype=np.int64),
            implicit=newton.implicit_of(n),
            tally=self.tally,
            record=self.record,
            turns=room_for(marks, n, lane),
            **{name: lane[name] for name in lane if name in events.Work._fields},
        )
        self.kept = Kept(self.work)
        self.begin(scene, times, marks)

    def begin(self, scene: Scene, times: np.ndarray, marks: Marks) -> None:
        """Stand at the start of a scene, of the type and Form of that which this was made for: as if it were new."""
        work: Any = self.work  # mypy takes its parts for tuples of anything
        lane, value, joints, guards = self.lane, scene.value, scene.value.joints, work.guards
        contacts = every_contact(joints)
        internal = every_internal_state(joints) if work.began.size else []
        described = [case for case, joint in zip(scene.case.joints, joints, strict=True) for _ in contact_modes(joint)]
        for array in (*self.tally, *work.implicit, guards.value, guards.passed, guards.event, *work.turns[1:]):
            array.fill(0)
        for array in (self.record.samples, work.counts, work.method, work.proposals, work.ahead, work.slopes):
            array.fill(0)
        put_numbers(value, self.parameters)
        lane["parameters"][:], lane["y"][:] = self.parameters, scene.start
        lane["scale"][:] = _scale(scene, len(contacts), [state.scale for _, state, _ in internal])
        lane["mode"][:] = work.pressed if scene.in_contact else work.apart
        lane["latched"][: len(contacts)] = ONSET_FLOOR
        lane["latched"][len(contacts) :] = [began for _, began in every_latched(joints)]
        self.kept.put(
            reference_rate=value.reference_rate,
            sigma=value.sigma,
            longest=LONGEST * period(scene) if scene.mechanism.turns else math.inf,
        )
        self.work, work.knots[:] = self.kept.value, knots_of(scene.machine)
        work.clearance[:], work.side[:] = zip(*[(joint.clearance, joint.side) for joint, _ in contacts], strict=True)
        work.film[:] = [film_depths(joint) for joint, _ in contacts]
        work.began[:] = [began for _, _, began in internal]
        work.rubs[:] = [joint.friction is not None or joint.film is not None for joint in described]
        work.limit_depth[:] = [registry.penetration_limit(joint) for joint in described]
        for row, joint in enumerate(described if scene.worn else ()):
            self.tally.account[row, SLID] = scene.worn[joint.name].slid if joint.name in scene.worn else 0.0
        self.record.times[:], work.turns.marks[:] = times, [scene.turning.at(turns) for turns in marks.turns.tolist()]
        self.value, self.deadline, self.marks = value, scene.deadline, marks
        self.status, self.events, self.duration = plan.OK, np.empty((0, 5)), 0.0
        self.logs: list[np.ndarray] = []  # of events, as they were taken away
        self.counts = work.counts.copy()  # what all of it took, runs beside this one included
        self.figures: dict[str, float | None] = {}  # those that were found on the way

    def go(self, control: plan.Control) -> tuple[int, np.ndarray]:
        """Return the status and the events of an integration from where this one stands to where `control` ends it."""
        self.heed(control)
        self.go_on()
        return self.status, np.concatenate(self.logs)

    def go_on(self) -> None:
        """Integrate, alone, to where this one ends."""
        addresses, status = np.array([self.kept.address]), np.zeros(1, dtype=np.int64)
        arrays, waits = shared(self.lane), True
        while waits:
            began = time.perf_counter()
            loop.integrate(self.kept, addresses, status, NO_ENTRY, *arrays)
            self.duration += time.perf_counter() - began
            waits = not self.ended(int(status[0]))

    def heed(self, control: plan.Control) -> None:
        """Let the integration go by `control` from here on."""
        self.work.control[:], self.work.ahead[plan.BEGUN], self.logs = control, 0.0, []

    def ended(self, status: int) -> bool:
        """Return whether the integration, at which something is to be looked at, has ended; if not, make it go on.

        What only a stiff motion needs is compiled when the motion turns out to be one.
        """
        work = self.work
        self.logs.append(work.log[: int(work.ahead[plan.LOGGED])].copy())
        self.status, work.ahead[plan.BEGUN] = status, 0.0
        if status == plan.TURNS_STIFF:
            work.slopes[:] = slopes_of(self.value, self.parameters)
            return False
        if status == plan.PAUSED and time.process_time() >= self.deadline:
            self.status = TIME_BUDGET
            return True
        return status != plan.PAUSED or bool(work.y[work.along] >= work.control[plan.PAUSE])

    def spent(self, other: "Run") -> None:
        """Add what a run beside this one took."""
        self.counts += other.counts
        self.duration += other.duration


def onset_rates(run: Run) -> np.ndarray:
    """Return the onset rate (m/s) that the law of each joint goes by where its integration stands, nan where none."""
    joints, work = run.value.joints, run.work
    rates, contact = np.full(len(joints), math.nan), 0
    for j, joint in enumerate(joints):
        if touches(work.mode.item(contact)) and keeps_onset(_law_in(run, j)):
            rates[j] = work.latched[contact]
        contact += len(contact_modes(joint))
    return rates


def _law_in(run: Run, place: int) -> Any:
    """Return the law of a joint with the internal state that it has where its integration stands."""
    joints, work = run.value.joints, run.work
    law: Any = joints[place].law  # mypy takes it for a tuple of anything
    if not law._field_defaults:
        return law
    begins = functools.reduce(after_joint, joints[:place], first_place(joints, work.time + 1))
    return as_it_is(law, work.end, work.latched, begins)


def _phases(scene: Scene) -> list[int]:
    """Return where those of the latched numbers are that say by what rule of its own a law goes."""
    joints = scene.value.joints
    listed = enumerate(every_latched(joints), start=len(every_contact(joints)))
    return [place for place, (law, _) in listed if type(law) in awaits_mass.members]


def _scale(scene: Scene, contacts: int, internal: list[float]) -> np.ndarray:
    """Return the error (n,) that one step may make in each component of the state; `internal`: scales of its laws."""
    value, tolerance = scene.value, scene.case.simulate.tolerance
    clearance, size, lengths = min(joint.clearance for joint in value.joints), scene.built.size, scene.built.lengths
    oiled = any(joint.film for joint in scene.layout.joints)
    weight = OILED * RATE_WEIGHT if oiled else RATE_WEIGHT
    place = max(PLACE_WEIGHT * tolerance * clearance, ROUNDING * size)
    rate = max(weight * tolerance * clearance, ROUNDING * size) * value.reference_rate
    moment = max(PLACE_WEIGHT * tolerance, ROUNDING) / value.reference_rate
    root = ROOT_WEIGHT * tolerance * math.sqrt(clearance)
    return np.concatenate(
        [place / lengths, rate / lengths, [moment, *[root] * contacts, *(tolerance * scale for scale in internal)]]
    )


def integrated(
    scene: Scene,
    times: np.ndarray,
    end: float,
    watchers: Sequence[Watcher] = (),
    *,
    turned: bool = False,
    marks: Marks = NO_MARKS,
) -> Run:
    """Return the integration of a scene up to `end` (s; rad where the crank is free), reported at `times` as Run is."""
    run = Run(scene, times, turned=turned, marks=marks)
    keep_events = scene.case.save.orbits != "none" or times.size > 0
    integrate(scene, run, end, keep_events=keep_events, watchers=watchers)
    return run


def integrate(scene: Scene, run: Run, end: float, *, keep_events: bool, watchers: Sequence[Watcher] = ()) -> None:
    """Integrate a scene up to `end` (s; rad where the crank is free), in the eyes of `watchers`, see `watch`."""
    control = control_of(scene, end, keep_events=keep_events)
    if not scene.layout.horizon:
        call(run, control, scene, watchers)
        return
    beside = Run(scene, np.empty(0))
    perturbed = Perturbed(control, beside, unit_of(scene), scene.case.simulate.tolerance, _phases(scene))
    call(run, control, scene, (*watchers, perturbed))
    run.figures = perturbed.figures(period(scene))
    beside.counts += beside.work.counts
    run.spent(beside)


def control_of(scene: Scene, end: float, *, keep_events: bool) -> plan.Control:
    """Return how to integrate a scene up to `end` (s; rad where the crank is free)."""
    settings = scene.case.simulate
    turning, free = scene.mechanism.turns, scene.turning.free
    window = scene.turning.at(settings.discard) if turning else 0.0
    units = max(settings.revolutions, 1.0) if turning else settings.impacts
    return plan.Control(
        window=window,
        end=end,
        separations=0 if turning else int(settings.impacts),
        step_budget=min(int(settings.step_budget * units), MOST),
        event_budget=min(int(settings.event_budget * units), MOST),
        method=_METHODS[settings.method],
        keep_events=keep_events,
        limit=settings.time_limit if free else math.inf,
        patience=PATIENCE * period(scene) if free else math.inf,
    )


def start(run: Run, control: plan.Control) -> None:
    """Let a run go by `control`, by the method that this asks for from the beginning."""
    if control.method == events.IMPLICIT and run.work.ahead[plan.NEXT] == 0.0:
        run.work.method[:] = (events.IMPLICIT, 0, events.IMPLICIT)
    run.heed(control)


def call(run: Run, control: plan.Control, scene: Scene, watchers: Sequence[Watcher] = ()) -> None:
    """Integrate, at one go unless somebody watches."""
    start(run, control)
    if watchers:
        run.status, run.events = watch.drive(control, run, scene.case.simulate.discard, scene.turning.at, watchers)
    else:
        run.status, run.events = run.go(control)
    run.counts += run.work.counts
