"""Members of the families of `contract` for planar machines; they run its programs."""

from ....tracing.compiled.family import known
from ..contract import (
    accelerate,
    body_angles,
    crank_rate,
    describe,
    energy,
    friction_laws,
    friction_powers,
    friction_slips,
    gaps,
    impact_masses,
    load_power,
    output_error,
    pose_at,
    with_friction_laws,
)
from .cycle import evaluate_cycle
from .dynamics import impact_masses_of, motion_of
from .equations import body_angles_of, crank_rate_of, energy_of, gaps_of, histories_of, output_and_crank_of
from .form import Planar
from .friction import accelerate_with_friction, friction_powers_of, friction_slips_of
from .loads import FRICTION_LOADS
from .pose_generation import pose_of


@pose_at.member(Planar)
def _pose_at_planar(mechanism, y):
    return pose_of(mechanism, y)


@gaps.member(Planar)
def _gaps_planar(mechanism, pose):
    return gaps_of(mechanism, pose)


@accelerate.member(Planar)
def _accelerate_planar(mechanism, pose, loads):
    if friction_laws(mechanism):
        return accelerate_with_friction(mechanism, pose, loads)
    return motion_of(mechanism, pose, loads)


@impact_masses.member(Planar)
def _impact_masses_planar(mechanism, pose, joint_gaps):
    return impact_masses_of(mechanism, pose, joint_gaps)


@energy.member(Planar)
def _energy_planar(mechanism, pose):
    return energy_of(mechanism, pose)


@crank_rate.member(Planar)
def _crank_rate_planar(mechanism, pose, nominal):
    return crank_rate_of(mechanism, pose)


@load_power.member(Planar)
def _load_power_planar(mechanism, motion):
    powers = friction_powers_of(motion)
    total = powers[0] if powers else 0.0
    for i in range(1, len(powers)):
        total = total + powers[i]
    return total


@friction_laws.member(Planar)
def _friction_laws_planar(mechanism):
    return _friction_laws_of(mechanism)


@known
def _friction_laws_of(mechanism):
    return tuple(load.friction for load in mechanism.loads if isinstance(load, FRICTION_LOADS))


@with_friction_laws.member(Planar)
def _with_friction_laws_planar(mechanism, laws):
    return _with_friction_laws(mechanism, laws)


@known
def _with_friction_laws(mechanism, laws):
    remaining = iter(laws)
    loads = (
        load._replace(friction=next(remaining)) if isinstance(load, FRICTION_LOADS) else load
        for load in mechanism.loads
    )
    return mechanism._replace(loads=tuple(loads))


@friction_slips.member(Planar)
def _friction_slips_planar(mechanism, motion):
    return friction_slips_of(motion)


@friction_powers.member(Planar)
def _friction_powers_planar(mechanism, motion):
    return friction_powers_of(motion)


@body_angles.member(Planar)
def _body_angles_planar(mechanism, y):
    return body_angles_of(mechanism, pose_of(mechanism, y))


@output_error.member(Planar)
def _output_error_planar(mechanism, pose):
    output, output_rate, angle, rate = output_and_crank_of(mechanism, pose)
    ideal_output, slope = evaluate_cycle(mechanism.cycle, 0, angle)
    return output - ideal_output, output_rate - slope * rate


@describe.member(Planar)
def _describe_planar(mechanism, y, pose, motion, out):
    values = histories_of(mechanism, pose, motion)
    for i in range(len(values)):
        out[i] = values[i]
    return len(values)
