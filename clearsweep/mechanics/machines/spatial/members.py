"""Members of the families of `contract` for trees; they call the generated code."""

from ..contract import accelerate, body_angles, describe, energy, gaps, output_error, pose_at
from ..planar.cycle import evaluate_cycle
from .equations import generated
from .form import Tree

_pose_at, _gaps_of, _bearing_axes, _energy, _describe, _output, _accelerate = map(
    generated, ("pose_at", "gaps", "bearing_axes", "energy", "describe", "output", "accelerate")
)


@pose_at.member(Tree)
def _pose_at_tree(mechanism, y):
    return _pose_at(mechanism, y)


@gaps.member(Tree)
def _gaps_tree(mechanism, pose):
    return _gaps_of(mechanism, pose)


@accelerate.member(Tree)
def _accelerate_tree(mechanism, pose, loads):
    return _accelerate(mechanism, pose, loads)


@energy.member(Tree)
def _energy_tree(mechanism, pose):
    return _energy(mechanism, pose)


@body_angles.member(Tree)
def _body_angles_tree(mechanism, y):
    return _bearing_axes(mechanism, _pose_at(mechanism, y))


@output_error.member(Tree)
def _output_error_tree(mechanism, pose):
    output, output_rate = _output(mechanism, pose)
    ideal_output, slope = evaluate_cycle(mechanism.cycle, 0, pose.angle)
    return output - ideal_output, output_rate - slope * mechanism.speed


@describe.member(Tree)
def _describe_tree(mechanism, y, pose, motion, out):
    return _describe(mechanism, y, pose, motion, out)
