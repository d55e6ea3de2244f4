"""Members of the families of `contract` for trees; they call the generated code."""

from ..contract import accelerate, body_angles, describe, energy, gaps, output_error, place
from ..planar.cycle import at_angle
from .equations import generated
from .form import Tree

_placed, _gaps_of, _across, _energy_of, _described, _judged, _accelerated = map(
    generated, ("place", "gaps", "across", "energy", "describe", "output", "accelerate")
)


@place.member(Tree)
def _place_tree(mechanism, y):
    return _placed(mechanism, y)


@gaps.member(Tree)
def _gaps_tree(mechanism, pose):
    return _gaps_of(mechanism, pose)


@accelerate.member(Tree)
def _accelerate_tree(mechanism, pose, loads):
    return _accelerated(mechanism, pose, loads)


@energy.member(Tree)
def _energy_tree(mechanism, pose):
    return _energy_of(mechanism, pose)


@body_angles.member(Tree)
def _body_angles_tree(mechanism, y):
    return _across(mechanism, _placed(mechanism, y))


@output_error.member(Tree)
def _output_error_tree(mechanism, pose):
    output, output_rate = _judged(mechanism, pose)
    ideal_output, slope = at_angle(mechanism.turn, 0, pose.angle)
    return output - ideal_output, output_rate - slope * mechanism.speed


@describe.member(Tree)
def _describe_tree(mechanism, y, pose, motion, out):
    return _described(mechanism, y, pose, motion, out)
