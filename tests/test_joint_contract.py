"""Joints and laws of no place in the package, made up here alone: the loop takes them as they are."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest
from mechanism_cases import PAIR, changed, slider_crank

import clearsweep
from clearsweep.mechanics.joints import contract
from clearsweep.mechanics.joints.contract import Contact, ContactModes, Load, Part
from clearsweep.mechanics.laws import contract as laws
from clearsweep.mechanics.laws.contract import ACTS, FREE, NEVER, PRESSED, TOUCHING, Guard, InternalState, touches
from clearsweep.mechanics.laws.friction import Frictionless, friction_force
from clearsweep.mechanics.observe import STAGES
from clearsweep.simulation.running.run import integration_of
from clearsweep.tracing.compiled import calculus
from clearsweep.tracing.compiled.family import kernel


def with_joint(scene, joint):
    """Return the scene of one joint with another one in its place, out of contact."""
    roots = 2 * len(scene.value.coordinates) + 1
    began = [number for _, _, number in contract.every_internal_state((joint,))]
    start = np.concatenate([scene.start[:roots], np.zeros(len(contract.every_contact((joint,)))), began])
    return dataclasses.replace(scene, value=scene.value._replace(joints=(joint,)), start=start)


def rubbing(friction, **changes):
    """Return the scene of a slider-crank with this friction law between rod and slider."""
    changes = {"simulate.revolutions": 0.3, "simulate.method": "explicit", "save.orbits": "all"} | changes
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    return with_joint(scene, scene.value.joints[0]._replace(friction=friction))


def run_to(scene, end):
    """Return the Run of a scene from its start to `end` (s)."""
    return integration_of(scene, np.empty(0), end)


TURN = 60.0 / 5000.0  # s


# ---------------------------------------------------------------------------------------------- internal states


class Warming(NamedTuple):
    """Bristles that warm up: T = -N stiffness z, C W' = -T slip - cooling C W."""

    coefficient: float  # 1
    stiffness: float  # 1/m
    capacity: float  # J/K
    cooling: float  # 1/s
    bend: float = 0.0  # z, m
    warmth: float = 5.0  # W, K


@friction_force.member(Warming)
def _warming(friction, normal, slip):
    return -normal * friction.stiffness * friction.bend


@laws.internal_state.member(Warming)
def _bend_and_warmth(friction):
    return InternalState(friction.coefficient / friction.stiffness, False), InternalState(1.0, True)


@laws.internal_rates.member(Warming)
def _bends_and_warms(friction, contact):
    slip = contact.slip
    rest = 1.0 - friction.stiffness * friction.bend * calculus.copysign(1.0, slip) / friction.coefficient
    heat = -contact.tangential * slip / friction.capacity - friction.cooling * friction.warmth
    return slip * rest, heat


def test_what_is_kept_continues_over_separations_and_the_rest_starts_again():
    run = run_to(rubbing(Warming(0.1, 1e5, 2.0, 0.0)), 0.3 * TURN)
    assert run.work.counts.separations >= 5
    rubbed = run.totals.mechanism.energy_friction
    assert rubbed > 1e-3
    assert 2.0 * (run.work.end[-1] - 5.0) == pytest.approx(rubbed, rel=1e-6)
    assert run.work.mode[0] == FREE
    assert run.work.end[-2] == 0.0


def test_what_is_kept_has_its_rate_in_free_flight():
    scene = rubbing(Warming(0.1, 1e5, 2.0, 1e3))
    last = run_to(scene, 0.3 * TURN).events[-1]
    assert last[2] == 2  # a separation
    start, end = (run_to(scene, moment).work.end for moment in (last[0] + 1e-7, 0.3 * TURN))
    time = 2 * len(scene.value.coordinates)
    assert end[-1] == pytest.approx(start[-1] * math.exp(-1e3 * (end[time] - start[time])), rel=1e-8, abs=0.0)


def test_both_internal_states_have_exact_derivatives():
    explicit = run_to(rubbing(Warming(0.1, 1e5, 2.0, 1e3)), 0.1 * TURN)
    implicit = run_to(rubbing(Warming(0.1, 1e5, 2.0, 1e3), **{"simulate.method": "implicit"}), 0.1 * TURN)
    assert implicit.work.end[-1] == pytest.approx(explicit.work.end[-1], rel=1e-6, abs=0.0)
    assert (
        implicit.work.counts.rejected < 0.2 * implicit.work.counts.steps
    )  # Newton's method converges: few rejected steps


# ---------------------------------------------------------------------------------------------- guards


class Fuse(NamedTuple):
    """Friction that is gone for good once it has rubbed off `limit` (J)."""

    coefficient: float  # 1
    velocity_scale: float  # m/s
    limit: float  # J
    spent: float = 0.0  # J
    blown: float = 0.0  # 0 or 1


@friction_force.member(Fuse)
def _fuse(friction, normal, slip):
    left = 1.0 if friction.blown == 0.0 else 0.0
    return -friction.coefficient * left * normal * calculus.tanh(slip / friction.velocity_scale)


@laws.internal_state.member(Fuse)
def _spent_and_blown(friction):
    return InternalState(friction.limit, True), InternalState(1.0, True)


@laws.internal_rates.member(Fuse)
def _spends(friction, contact):
    return -contact.tangential * contact.slip, 0.0


@laws.guards.member(Fuse)
def _blows(friction):
    return (Guard(TOUCHING),)


@laws.guard_values.member(Fuse)
def _beyond_the_limit(friction, start, contact, root):
    return (friction.spent - friction.limit if friction.blown == 0.0 else NEVER,)


@laws.latched.member(Fuse)
def _stays_blown(friction, event, contact, root):
    return friction.spent, 1.0 if event == 0 else friction.blown


def blown_run():
    """Return the run of a fuse that blows about half way."""
    return run_to(rubbing(Fuse(0.1, 1e-2, 2e-2)), 0.3 * TURN)


def test_a_guard_of_a_law_is_located_where_its_function_is_zero():
    run, never = blown_run(), run_to(rubbing(Fuse(0.1, 1e-2, 1e3)), 0.3 * TURN)
    assert never.work.end[-1] == 0.0
    assert never.totals.mechanism.energy_friction > 3e-2
    assert run.work.end[-1] == 1.0
    assert run.totals.mechanism.energy_friction == pytest.approx(2e-2, rel=1e-9)
    assert run.work.end[-2] == pytest.approx(2e-2, rel=1e-9)
    assert run.totals.mechanism.residual < 1e-7 * run.totals.mechanism.kinetic_max


# ---------------------------------------------------------------------------------------------- kinds of joints


class Cushion(NamedTuple):
    """A linear spring between the pins, which acts without contact, as a film does."""

    clearance: float  # m
    side: float
    stiffness: float  # N/m


@contract.contact_modes.member(Cushion)
def _acts_always(joint):
    return (ContactModes(ACTS, ACTS),)


@contract.parts.member(Cushion)
def _no_law(joint):
    return (Part(Frictionless(), 0),)


@contract.load.member(Cushion)
def _spring(joint, gap, place, present):
    off = calculus.sqrt(gap.x * gap.x + gap.y * gap.y)
    force = joint.stiffness * off
    contact = Contact(
        normal=force,
        tangential=0.0,
        slip=0.0,
        rate=(gap.x * gap.vx + gap.y * gap.vy) / off if off > 0.0 else abs(gap.vx),
        depth=off - joint.clearance,
        elastic=force,
        raw=force,
    )
    fx, fy = -joint.stiffness * gap.x, -joint.stiffness * gap.y
    return Load(fx=fx, fy=fy, moment_proximal=0.0, moment_distal=0.0, contacts=(contact,))


def test_a_joint_that_acts_without_contact_is_never_searched_for_one():
    scene = with_joint(clearsweep.load_case(changed(PAIR, {"simulate.tolerance": 1e-11})), Cushion(1e-3, 1.0, 1e7))
    rate = math.sqrt(1e7 / 0.1)  # rad/s, of 0.1 kg
    end = 3.3 / rate
    run = run_to(scene, end)
    assert run.work.end[0] == pytest.approx(math.sin(3.3) / rate, rel=1e-9, abs=0.0)
    assert run.totals.joint[0].force_max == pytest.approx(1e7 / rate, rel=1e-8)
    square = 0.5 * (1e7 / rate) ** 2 * (end - math.sin(2.0 * 3.3) / (2.0 * rate))
    assert run.totals.joint[0].force_square == pytest.approx(square, rel=1e-8)
    assert run.totals.joint[0].contact_time == 0.0
    assert run.totals.mechanism.residual < 1e-9 * run.totals.mechanism.kinetic_max
    assert len(run.events) == 0
    assert run.work.counts.locating <= 4 * STAGES  # for the end alone


class Walls(NamedTuple):
    """A gap between two walls, each a contact of its own with the force of Hertz's exponent."""

    clearance: float  # m, to either wall
    side: float
    stiffness: float  # N/m^1.5


@contract.contact_modes.member(Walls)
def _two(joint):
    return ContactModes(FREE, PRESSED), ContactModes(FREE, PRESSED)


@contract.parts.member(Walls)
def _none_at_either(joint):
    return Part(Frictionless(), 0), Part(Frictionless(), 1)


@kernel
def wall(joint, way, gap, contact, present):
    """Return the Contact with the wall in the direction `way`."""
    depth, root, touching = way * gap.x - joint.clearance, present.y[present.roots + contact], present.mode[contact]
    force = joint.stiffness * root * root * root if touches(touching) else 0.0 * root
    return Contact(
        normal=force, tangential=0.0, slip=abs(gap.vx), rate=way * gap.vx, depth=depth, elastic=force, raw=force
    )


@contract.load.member(Walls)
def _walls(joint, gap, place, present):
    right = wall(joint, 1.0, gap, place.contact, present)
    left = wall(joint, -1.0, gap, place.contact + 1, present)
    fx = left.normal - right.normal
    return Load(fx=fx, fy=0.0, moment_proximal=0.0, moment_distal=0.0, contacts=(right, left))


def test_two_contacts_of_a_joint_have_their_own_onsets():
    """The gap of the impact pair, a circle there, is one between two walls: the motion is the same."""
    case = changed(
        PAIR,
        {
            "simulate.impacts": 5,
            "simulate.tolerance": 1e-11,
            "save.orbits": "all",
            "joints.pair.contact": {"law": "hertz", "stiffness": 6.61e10},
        },
    )
    scene = clearsweep.load_case(case)
    circle, walls = (run_to(made, math.inf) for made in (scene, with_joint(scene, Walls(1e-3, 1.0, 6.61e10))))
    assert len(walls.events) == len(circle.events) == 10
    assert walls.events[:, 0] == pytest.approx(circle.events[:, 0], rel=1e-9, abs=0.0)
    assert list(walls.events[:, 1]) == [0, 0, 1, 1] * 2 + [0, 0]
    assert list(circle.events[:, 1]) == [0] * 10
    assert walls.totals.joint.column("force_max") == pytest.approx(circle.totals.joint[0].force_max, rel=1e-9)
    assert list(walls.totals.joint.column("onsets")) == [3, 2]
