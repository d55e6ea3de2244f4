"""Checks that stiff, extreme and degenerate cases end as expected and stay within the bounds of mechanics.

A case runs two revolutions (impact pair: ten impacts) with the default tolerance and budgets.  It passes if

* it ends `ok` and all its values are finite,
* its energies balance to ENERGY_TOLERANCES tolerances per revolution,
* a journal is outside its clearance only during a contact of the event log,
* no penetration exceeds its bound.

The bound on the penetration of a joint.  Let a body of reduced mass m touch at the rate v and be pushed on by a load of
at most F.  Its deepest penetration d has K d^(n+1) / (n+1) <= E + F d with E = 1/2 m v^2 2 [chi - ln(1 + chi)] / chi^2:
the elastic energy of the deepest point is what the damper leaves of the onset energy (the phase curve of
F = K pen^n (1 + chi rate / v)), and the work of the load.  Alone, the first gives d1 = ((n+1) E / K)^(1/(n+1)) and the
second, a load that is applied at once, d2 = ((n+1) F / K)^(1/n); as (d1 + d2)^n >= d1^n + d2^n, d <= d1 + d2.  Of an
elastic force that is no power of d its energy W takes the left side's place, and the bound is where W(d) = E + F d.
The values of m, E and F:

m : the largest reduced mass of the mechanism in which only that joint is open, over all crank angles and directions
    (closing the other joints can only increase it);
E : sum over all open joints, each with its largest onset rate of this run, because an impact in one joint acts on the
    others through the bodies between them;
F : the largest load of the joint in the ideal mechanism, times LOAD_FACTOR because clearance displaces the bodies, plus
    m u^2 / c of the journal that follows the circle of its bearing at the rate u, the largest along the surface in the
    samples in contact, at the clearance c; times 1 + mu because friction adds to it.  The ideal mechanism has no stops:
    theirs is m times the largest acceleration towards them that the bodies have at rest next to them without contact.

A film in a joint only adds resistance.  The dry contact behind it carries the full load from the end of the transition
on, so the bound is larger by that depth.  A joint with only a film has no bound; the table shows its deepest position.

The bound excludes sliding friction, which turns work of the drive into an oscillation normal to the surface.  A case
beyond the bound fails nevertheless.  Two numbers then show the cause: the energy residual over the elastic energy of
the deepest contact (work of the drive), and the difference from the depth at a tenth of the tolerance (error of the
step).
For cases in space no bound is known, and samples are not checked.
"""

import dataclasses
import itertools
import math
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from .. import grid
from ..contracts.case import Joint as CaseJoint
from ..contracts.layout import JointLayout
from ..contracts.machine import Constant, Machine, Motor
from ..contracts.results import Trajectory
from ..mechanics.joints.contract import Load
from ..mechanics.joints.guide import CORNERS
from ..mechanics.joints.lubricated import Film, Lubricated
from ..mechanics.joints.rolling import Rolling, element_approaches
from ..mechanics.laws.contract import ONSET_FLOOR
from ..mechanics.laws.elastic import POWERS, elastic_energy
from ..mechanics.laws.hysteresis import RateFactor
from ..mechanics.machines import contract, planar
from ..simulation.analyses.trajectory import simulate
from ..simulation.figures.window import by_joint
from ..simulation.machine.ideal import ideal_peaks
from ..simulation.running.run import integration_of
from ..simulation.setup import scene
from ..sweeping.pool.executors import EXECUTORS, cores
from ..sweeping.pool.system import no_preparation
from ..tracing.compiled.dual import Moving, slope
from . import extremes
from .extremes import ExtremeCase, tune_case

ENERGY_TOLERANCES = 1000.0  # tolerances per revolution
LOAD_FACTOR = 2.0
NO_LOAD = Load(0.0, 0.0, 0.0, 0.0, ())
BOUND_TOLERANCE = 1e-6  # of the bound, and of the clearance outside of contacts; or ten tolerances if more
SAMPLES = 4000  # samples of every joint per run
QUICK_CASES = 30
ANGLES = np.linspace(0.0, 2.0 * math.pi, 361)


def measure(*, quick: bool = False, report_progress: Callable[[str], None] = lambda step: None) -> dict[str, Any]:
    """Return the results of all cases of the table, `rows`, and their summary; a process for each core runs them.

    `quick` runs, in this process, some of each group, and none of other machines, each kind of which compiles a
    scene; `report_progress` is called with messages.
    """
    begin = time.perf_counter()
    cases = extremes.extreme_cases()
    machines = (extremes.machine_cases, extremes.film_cases, extremes.spatial_cases)
    all_cases = [*cases, *(case for machine_cases in machines for case in machine_cases())]
    selected = select_evenly(cases, QUICK_CASES) if quick else all_cases
    report_progress(f"stability: {len(selected)} cases")
    pool = EXECUTORS["serial" if quick else "local"](cores(), None, no_preparation)
    try:
        futures = [pool.submit(run_case, case) for case in selected]
        rows = [future.result() for future in futures]
    finally:
        pool.close()
    failures = [row for row in rows if row["failure"]]
    return {
        "cases": len(rows),
        "passed": len(rows) - len(failures),
        "share_passed": 1.0 - len(failures) / len(rows),
        "seconds": time.perf_counter() - begin,
        "largest_share_of_penetration_bound": max(row["share_of_bound"] or 0.0 for row in rows),
        "largest_share_of_energy_bound": max(row["share_of_energy"] or 0.0 for row in rows),
        "failures": failures,
        "rows": rows,
    }


def select_evenly(table: list[ExtremeCase], count: int) -> list[ExtremeCase]:
    """Return `count` cases, evenly spaced within each group, without cases that are expensive to run or compile."""
    groups = [[case for case in table if case.group == name] for name in dict.fromkeys(case.group for case in table)]
    groups = [group for group in groups if group[0].group not in ("dear", "rough")]
    stride = math.ceil(count / len(groups))
    selected = [group[(2 * i + 1) * len(group) // (2 * stride)] for i in range(stride) for group in groups]
    return selected[:count]


def run_case(case: ExtremeCase) -> dict[str, Any]:
    """Return the row of a case; `failure` is empty if it passes."""
    case_scene, note = scene_of(case)
    return {"name": case.name, "note": note} | run_scene(case_scene)


def run_scene(case_scene: scene.Scene) -> dict[str, Any]:
    """Return status, costs and residuals of a scene; `failure` is empty if it passes."""
    turns = case_scene.case.simulate.revolutions if case_scene.layout.turns else 1.0
    times = None if case_scene.layout.turns else np.empty(0)
    if case_scene.crank_clock.free:  # times are unknown in advance: the grid's own samples
        times = None
    elif case_scene.layout.turns:
        times = np.linspace(0.0, case_scene.crank_clock.value_after(turns), SAMPLES + 1)
    trajectory = simulate(case_scene, times=times)
    summary = trajectory.summary
    row = {
        "status": trajectory.status,
        "failure": "",
        "rhs_evaluations": summary["rhs_evaluations"],
        "steps": summary["steps"],
        "run_time": summary["run_time"],
        "energy_residual": summary["energy_residual"],
        "share_of_energy": None,
        "share_of_bound": None,
    }
    onsets = trajectory.events["t"][trajectory.events["kind"] == "on"]
    row["first_onset"] = float(onsets[0]) if onsets.size else None
    if trajectory.status != "ok":
        return row | {"failure": f"{trajectory.status}: {trajectory.message}"}
    tolerance = ENERGY_TOLERANCES * case_scene.case.simulate.tolerance * turns
    row["share_of_energy"] = summary["energy_residual"] / tolerance
    if not case_scene.mechanism.spatial:
        row["share_of_bound"] = share_of_bound(case_scene, trajectory)
    return row | {"failure": _failure_text(case_scene, trajectory, row)}


def scene_of(case: ExtremeCase) -> tuple[scene.Scene, str]:
    """Return the Scene of a case, tuned and displaced as specified, and a note on that."""
    source, note = tune_case(case) if case.tuning else (case.grid, "")
    case_scene = scene.build(grid.load(source, scene.catalogue()).case(0))
    if case.displacement:
        clearance, length = case_scene.value.joints[0].clearance, case.grid["mechanism"]["rod"]["length"]
        start = case_scene.start.copy()
        start[0] = math.asin(-case.displacement[1] * clearance / length)
        pin = case.grid["mechanism"]["crank"]["length"]
        start[1] = pin + length * math.cos(start[0]) + case.displacement[0] * clearance
        case_scene = dataclasses.replace(case_scene, start=start)
    return case_scene, note


def _failure_text(case_scene: scene.Scene, trajectory: Trajectory, row: dict[str, Any]) -> str:
    """Return why a run that ended `ok` does not pass; empty if it does."""
    figures = [value for value in trajectory.summary.values() if isinstance(value, float)]
    if not np.all(np.isfinite(figures)) or not all(np.all(np.isfinite(v)) for v in trajectory.channels.values()):
        return "not finite: a figure or a sample"
    if row["share_of_energy"] > 1.0:
        return f"energy: the balance is off by {row['energy_residual']:.1e} of the largest kinetic energy"
    if case_scene.mechanism.spatial:
        return ""
    allowed = max(BOUND_TOLERANCE, 10.0 * case_scene.case.simulate.tolerance)
    if row["share_of_bound"] > 1.0 + allowed:
        return f"penetration: {row['share_of_bound']:.2f} of its bound; {_accuracy_note(case_scene)}"
    for index, layout in enumerate(case_scene.layout.joints if trajectory.channels else ()):
        escape = largest_escape(case_scene, trajectory, index, layout.name)
        if escape > allowed:
            return (
                f"contact lost: {layout.name} is {escape:.1e} clearances beyond its bearing, and no contact is logged"
            )
    return ""


def _accuracy_note(case_scene: scene.Scene) -> str:
    """Return a sentence on the accuracy of a penetration beyond its bound."""
    settings = case_scene.case.simulate
    tighter = settings._replace(tolerance=0.1 * settings.tolerance, step_budget=10 * settings.step_budget)
    end = case_scene.crank_clock.value_after(settings.revolutions) if case_scene.layout.turns else math.inf
    scenes = (
        dataclasses.replace(case_scene, case=case_scene.case._replace(simulate=each)) for each in (settings, tighter)
    )
    default_run, tighter_run = (integration_of(each, np.empty(0), end) for each in scenes)
    if tighter_run.status != default_run.status:
        return "it does not end at a tenth of the tolerance"
    depths, tighter_depths = (
        by_joint(integration.totals, case_scene.layout).joint.column("depth_max")
        for integration in (default_run, tighter_run)
    )
    contact_energy = max(
        elastic_energy(joint.elastic, depth) for joint, depth in zip(case_scene.value.joints, depths, strict=True)
    )
    difference = float(np.max(np.abs(tighter_depths / depths - 1.0)))
    return (
        f"at a tenth of the tolerance it differs by {difference:.1e} of itself, and the energies are out of balance by "
        f"{default_run.totals.mechanism.residual / contact_energy:.1e} of the contact's"
    )


def largest_escape(case_scene: scene.Scene, trajectory: Trajectory, index: int, name: str) -> float:
    """Return the largest penetration (clearances) of a joint in samples outside of its logged contacts."""
    clearance = float(case_scene.value.joints[index].clearance)
    if isinstance(case_scene.value.joints[index], Film):
        return 0.0  # without surface there is no penetration
    if case_scene.layout.joints[index].flanked:
        return _largest_overlap(case_scene, trajectory, index) / clearance
    if isinstance(case_scene.value.joints[index], Rolling):
        return _largest_approach(case_scene, trajectory, index, name) / clearance
    if case_scene.layout.joints[index].corners:
        return _largest_gap(case_scene, trajectory, index, name) / clearance - 1.0
    in_contact = _in_contact(trajectory, name, began=case_scene.in_contact)
    eccentricity = np.hypot(trajectory[f"joints/{name}/x"], trajectory[f"joints/{name}/y"])[~in_contact]
    return float(np.max(eccentricity, initial=0.0)) / clearance - 1.0


def _in_contact(trajectory: Trajectory, contact: str, *, began: bool) -> np.ndarray:
    """Return whether a contact was logged to be closed at the samples, (n,); `began` : at the start."""
    events = trajectory.events[trajectory.events["joint"] == contact]
    closed: np.ndarray = (np.searchsorted(events["t"], trajectory.t, side="right") + began) % 2 == 1
    return closed


def _largest_overlap(case_scene: scene.Scene, trajectory: Trajectory, index: int) -> float:
    """Return the largest overlap (m or rad) of two flanks outside logged contacts."""
    joint, layout = case_scene.value.joints[index], case_scene.layout.joints[index]
    place, first = trajectory[f"joints/{layout.name}/x"] - joint.middle, len(case_scene.value.coordinates)
    contacts = [name for each in case_scene.layout.joints for name in each.contacts]
    largest = -math.inf
    for side, contact in zip((1.0, -1.0), layout.contacts, strict=True):
        began = bool(case_scene.start[2 * first + 1 + contacts.index(contact)] > 0.0)
        in_contact = _in_contact(trajectory, contact, began=began)
        largest = max(largest, float(np.max((side * place)[~in_contact], initial=-math.inf)) - joint.reach)
    return largest


def _largest_approach(case_scene: scene.Scene, trajectory: Trajectory, index: int, name: str) -> float:
    """Return the largest approach (m) of both rings at an element of a bearing outside of its logged contacts."""
    first = sum(len(joint.contacts) for joint in case_scene.layout.joints[:index])
    roots = case_scene.start[2 * len(case_scene.value.coordinates) + 1 + first :]
    position = (trajectory[f"joints/{name}/{channel}"] for channel in ("x", "y", "cage_angle"))
    approaches, largest = element_approaches(case_scene.value.joints[index], *position), 0.0
    for k in range(approaches.shape[1]):
        in_contact = _in_contact(trajectory, f"{name}_{k + 1}", began=bool(roots[k] > 0.0))
        largest = max(largest, float(np.max(approaches[~in_contact, k], initial=0.0)))
    return largest


def _largest_gap(case_scene: scene.Scene, trajectory: Trajectory, index: int, name: str) -> float:
    """Return the largest distance (m) of a block's corner outside logged contacts from its centred position."""
    guide = case_scene.value.joints[index]
    angle = trajectory["slider/angle"]
    sideways = trajectory[f"joints/{name}/y"]
    farthest = 0.0
    for number, (forward, lateral) in enumerate(CORNERS, start=1):
        in_contact = _in_contact(trajectory, f"{name}_{number}", began=False)
        corner = sideways + 0.5 * (forward * guide.length * np.sin(angle) + lateral * guide.height * np.cos(angle))
        farthest = max(farthest, float(np.max((lateral * corner - 0.5 * guide.height)[~in_contact], initial=0.0)))
    return farthest


# ---------------------------------------------------------------------------------------------- bound


def share_of_bound(case_scene: scene.Scene, trajectory: Trajectory) -> float:
    """Return the largest penetration of a run over its bound, the largest of its joints."""
    energies, loads, summary = [], [], trajectory.summary
    joints = zip(case_scene.layout.joints, case_scene.case.joints, case_scene.value.joints, strict=True)
    dry_joints = [joint_terms for joint_terms in joints if not isinstance(joint_terms[2], Film)]
    for joint_layout, case_joint, joint in dry_joints:
        rate = summary[f"{joint_layout.name}_onset_rate_max"]
        impact = getattr(joint.law, "impact", joint.law)
        factor = getattr(impact, "factor", 0.0)
        factor *= rate if type(impact) is RateFactor else min(1.0, rate / ONSET_FLOOR)  # laws do not divide by less
        mass = reduced_mass(case_scene, joint_layout)
        energies.append(_damped_energy(mass, rate, factor))
        load = LOAD_FACTOR * ideal_peaks(case_scene.case).get(case_joint.name_in_machine, 0.0)  # N
        load += LOAD_FACTOR * mass * acceleration_at_stops(case_scene, case_joint, joint) if case_joint.stops else 0.0
        load += mass * _largest_curvature(trajectory, joint_layout, joint.clearance)
        loads.append(load * (1.0 + getattr(joint.friction, "coefficient", 0.0)))
    shares = []
    for (joint_layout, _, joint), load in zip(dry_joints, loads, strict=True):
        max_depth = penetration_bound(joint.elastic, sum(energies), load)
        max_depth += joint.corners.end if type(joint) in (Lubricated,) else 0.0
        max_depth += max(-joint.radial_clearance, 0.0) if isinstance(joint, Rolling) else 0.0
        shares.append(summary[f"{joint_layout.name}_penetration_max"] / max_depth if max_depth > 0.0 else 0.0)
    return max(shares, default=0.0)


def _largest_curvature(trajectory: Trajectory, joint_layout: JointLayout, clearance: float) -> float:
    """Return the largest u^2 / c (m/s^2) of a journal in its samples in contact; 0 for a guide's flat walls."""
    if joint_layout.corners or not trajectory.channels:
        return 0.0
    x, y, vx, vy = (trajectory[f"joints/{joint_layout.name}/{channel}"] for channel in ("x", "y", "vx", "vy"))
    radius = np.maximum(np.hypot(x, y), clearance)
    surface_rate = np.where(radius > clearance, (x * vy - y * vx) / radius, 0.0)
    return float(np.max(np.square(surface_rate), initial=0.0)) / clearance


def penetration_bound(elastic: Any, energy: float, load: float) -> float:
    """Return the bound (m) of a penetration under an energy (J) and a load (N)."""
    if type(elastic) in POWERS:
        stiffness, exponent = elastic.stiffness, elastic.exponent
        depth = ((exponent + 1.0) * energy / stiffness) ** (1.0 / (exponent + 1.0))
        return float(depth + ((exponent + 1.0) * load / stiffness) ** (1.0 / exponent))
    low, high = 0.0, 1e-9
    while elastic_energy(elastic, high) < energy + load * high:
        high *= 2.0
    for _ in range(60):
        midpoint = 0.5 * (low + high)
        is_below = elastic_energy(elastic, midpoint) < energy + load * midpoint
        low, high = (midpoint, high) if is_below else (low, midpoint)
    return high


def _damped_energy(mass: float, rate: float, factor: float) -> float:
    """Return the elastic energy (J) at the deepest point of a free impact; `factor` is chi."""
    if factor < 1e-4:
        return 0.5 * mass * rate**2  # the limit; the difference below cancels
    return mass * rate**2 * (factor - math.log1p(factor)) / factor**2


_MACHINE_MASSES: dict[tuple, float] = {}  # kg; variants of a case share most of them


def reduced_mass(case_scene: scene.Scene, joint_layout: JointLayout) -> float:
    """Return the largest reduced mass (kg) of a joint, the others closed, the crank driven at its speed.

    For a guide it is the total moving mass: only its block is struck there, and a rod that pushes it.
    """
    if case_scene.machine is None:  # two bodies on a line
        first, second = (case_scene.case.mechanism.values[f"masses.{k}"] for k in range(2))
        return float(first * second / (first + second))
    index = case_scene.layout.joints.index(joint_layout)
    name, term = case_scene.case.joints[index].name_in_machine, case_scene.value.joints[index]
    if joint_layout.corners and not joint_layout.flanked:
        return float(sum(body.mass for body in case_scene.machine.bodies.values()))
    key = case_scene.case.mechanism.type, tuple(sorted(case_scene.case.mechanism.values.items())), name, term.clearance
    if key in _MACHINE_MASSES:
        return _MACHINE_MASSES[key]
    largest = 0.0
    for angle, direction in itertools.product(ANGLES[:-1:15], ANGLES[:-1:45]):
        machine_at_angle = case_scene.machine._replace(drive=Constant(1.0, float(angle)), loads=())
        offset = 0.5 * term.clearance * np.array([math.cos(direction), math.sin(direction)])
        try:
            built = planar.build(machine_at_angle, {name: term}, {name: offset})
        except planar.ClosureError:  # a crank that only swings does not reach every angle
            continue
        pose = contract.pose_at(built.value, built.start)
        largest = max(largest, contract.impact_masses(built.value, pose, contract.gaps(built.value, pose))[0])
    _MACHINE_MASSES[key] = float(largest)
    return float(largest)


def acceleration_at_stops(case_scene: scene.Scene, joint: CaseJoint, term: Any) -> float:
    """Return the largest acceleration (1/s^2 or m/s^2) towards the stops of a joint, over crank angles."""
    machine, largest = case_scene.machine, 0.0
    assert machine is not None  # only machines have stops
    stops = next(each for each in machine.joints if each.name == joint.name_in_machine)
    ends = (stops.distal.body, 1.0), (stops.proximal.body, -1.0)
    movable = [(end, sense, initial) for end, sense in ends if (initial := machine.bodies[end].initial)]
    for angle, (side, stop) in itertools.product(ANGLES[:-1:15], zip((-1.0, 1.0), joint.stops, strict=True)):
        drive: Any = Constant(case_scene.value.reference_rate, float(angle))
        if isinstance(machine.drive, Motor):
            drive = machine.drive._replace(start_angle=float(angle), initial_speed=0.0)
        at_stop = machine._replace(drive=drive)
        with suppress(planar.ClosureError):  # a crank that only swings does not reach every angle
            built, gap = _built_with_gap(at_stop, stops.name, term)
            for end, sense, initial in movable[:1]:
                there = initial._replace(angle=initial.angle + sense * (stop - gap.x), rate=0.0)
                bodies = {**machine.bodies, end: machine.bodies[end]._replace(initial=there)}
                built, _ = _built_with_gap(at_stop._replace(bodies=bodies), stops.name, term)
            motion = contract.accelerate(built.value, contract.pose_at(built.value, built.start), (NO_LOAD,))
            moving = contract.pose_at(built.value, Moving(built.start, motion.accelerations))
            largest = max(largest, side * slope(contract.gaps(built.value, moving)[0].v))
    return largest


def _built_with_gap(machine: Machine, name: str, term: Any) -> tuple[contract.Built, Any]:
    """Return a machine in which only this joint is open, and its gap at the start."""
    built = planar.build(machine, {name: term}, {name: (0.0, 0.0)})
    return built, contract.gaps(built.value, contract.pose_at(built.value, built.start))[0]
