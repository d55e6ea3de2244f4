"""Members of the families of `contract` for trees; they call the generated code."""

from ..contract import accelerate, body_angles, describe, energy, gaps, output_error, place
from ..planar.cycle import at_angle
from .equations import generated
from .form import Tree

_place, _gaps_of, _bearing_axes, _energy, _describe, _output, _accelerate = map(
    generated, ("place", "gaps", "across", "energy", "describe", "output", "accelerate")
)


@place.member(Tree)
def _place_tree(mechanism, y):
    return _place(mechanism, y)


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
    return _bearing_axes(mechanism, _place(mechanism, y))


@output_error.member(Tree)
def _output_error_tree(mechanism, pose):
    output, output_rate = _output(mechanism, pose)
    ideal_output, slope = at_angle(mechanism.turn, 0, pose.angle)
    return output - ideal_output, output_rate - slope * mechanism.speed


@describe.member(Tree)
def _describe_tree(mechanism, y, pose, motion, out):
    return _describe(mechanism, y, pose, motion, out)
