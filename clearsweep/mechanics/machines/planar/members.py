"""Members of the families of `contract` for planar machines; they call the generated code."""

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
from .equations import generated
from .form import Planar
from .friction import friction_powers_of, friction_slips_of

(
    _pose_of,
    _gaps_of,
    _motion_of,
    _impact_masses_of,
    _energy_of,
    _describe,
    _body_angles_of,
    _output_of,
    _crank_rate_of,
    _friction_laws_of,
    _with_friction_laws,
) = map(
    generated,
    (
        "pose_at",
        "gaps",
        "accelerate",
        "impact_masses",
        "energy",
        "describe",
        "body_angles",
        "output",
        "crank_rate",
        "friction_laws",
        "with_friction_laws",
    ),
)


@pose_at.member(Planar)
def _pose_at_planar(mechanism, y):
    return _pose_of(mechanism, y)


@gaps.member(Planar)
def _gaps_planar(mechanism, pose):
    return _gaps_of(mechanism, pose)


@accelerate.member(Planar)
def _accelerate_planar(mechanism, pose, loads):
    return _motion_of(mechanism, pose, loads)


@impact_masses.member(Planar)
def _impact_masses_planar(mechanism, pose, joint_gaps):
    return _impact_masses_of(mechanism, pose, joint_gaps)


@energy.member(Planar)
def _energy_planar(mechanism, pose):
    return _energy_of(mechanism, pose)


@crank_rate.member(Planar)
def _crank_rate_planar(mechanism, pose, nominal):
    return _crank_rate_of(mechanism, pose)


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


@with_friction_laws.member(Planar)
def _with_friction_laws_planar(mechanism, laws):
    return _with_friction_laws(mechanism, laws)


@friction_slips.member(Planar)
def _friction_slips_planar(mechanism, motion):
    return friction_slips_of(motion)


@friction_powers.member(Planar)
def _friction_powers_planar(mechanism, motion):
    return friction_powers_of(motion)


@body_angles.member(Planar)
def _body_angles_planar(mechanism, y):
    return _body_angles_of(mechanism, _pose_of(mechanism, y))


@output_error.member(Planar)
def _output_error_planar(mechanism, pose):
    output, output_rate, angle, rate = _output_of(mechanism, pose)
    ideal_output, slope = evaluate_cycle(mechanism.cycle, 0, angle)
    return output - ideal_output, output_rate - slope * rate


@describe.member(Planar)
def _describe_planar(mechanism, y, pose, motion, out):
    return _describe(mechanism, pose, motion, out)
