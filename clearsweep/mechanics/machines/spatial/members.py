"""Members of the families of `contract` for trees; they run the programs."""

from ..contract import accelerate, body_angles, describe, energy, gaps, output_error, pose_at
from ..planar.cycle import evaluate_cycle
from .dynamics import motion_of
from .form import Tree
from .kinematics import bearing_axes_of, energy_of, gaps_of, histories_of, output_of, pose_of


@pose_at.member(Tree)
def _pose_at_tree(mechanism, y):
    return pose_of(mechanism, y)


@gaps.member(Tree)
def _gaps_tree(mechanism, pose):
    return gaps_of(mechanism, pose)


@accelerate.member(Tree)
def _accelerate_tree(mechanism, pose, loads):
    return motion_of(mechanism, pose, loads)


@energy.member(Tree)
def _energy_tree(mechanism, pose):
    return energy_of(mechanism, pose)


@body_angles.member(Tree)
def _body_angles_tree(mechanism, y):
    return bearing_axes_of(mechanism, pose_of(mechanism, y))


@output_error.member(Tree)
def _output_error_tree(mechanism, pose):
    output, output_rate = output_of(mechanism, pose)
    ideal_output, slope = evaluate_cycle(mechanism.cycle, 0, pose.angle)
    return output - ideal_output, output_rate - slope * mechanism.speed


@describe.member(Tree)
def _describe_tree(mechanism, y, pose, motion, out):
    values = histories_of(mechanism, pose, y, motion)
    for i in range(len(values)):
        out[i] = values[i]
    return len(values)
