"""Vectors of the bodies of a tree in its programs; all are in the fixed frame unless stated."""

from collections.abc import Callable
from typing import Any

from ....tracing.compiled.formulas import Expr, Program
from ....tracing.compiled.vector import Vector, to_body_frame, to_fixed_frame
from .expressions import NO_VECTOR, SpatialVector
from .form import Sleeve, Slide
from .machine_type import MachineType
from .pose import axis_z, on_ground


class Bodies:
    """The bodies of a tree in a program whose first parameter is the Tree; subclasses define their frames."""

    def __init__(self, tree: MachineType, parameters: int):
        self.tree, self.program = tree, Program(parameters)
        self.mechanism = self.program.parameters[0]
        self.vertical = SpatialVector(self.program.known(Vector(0.0, 0.0, 1.0)))

    def call(self, function: Callable, *arguments: Any) -> SpatialVector:
        """Return the vector that a function returns; arguments : SpatialVectors, Exprs, or nested tuples of Exprs."""
        values = (x.value if isinstance(x, SpatialVector) else x for x in arguments)
        return SpatialVector(self.program.call(function, *values))

    def frame(self, body: int) -> Expr:
        """Return the Frame of a body."""
        raise NotImplementedError

    def to_fixed_frame(self, body: int, vector: SpatialVector) -> SpatialVector:
        """Return a vector of a body's frame, or of the ground's, in the fixed frame."""
        return self.call(to_fixed_frame, self.frame(body), vector) if body else vector

    def to_body_frame(self, body: int, vector: SpatialVector) -> SpatialVector:
        """Return a vector of the fixed frame in that of a body."""
        return self.call(to_body_frame, self.frame(body), vector)

    def z_axis(self, body: int) -> SpatialVector:
        """Return the z axis of a body or the ground."""
        return self.vertical if self.tree.is_vertical(body) else self.call(axis_z, self.frame(body))

    def arm(self, body: int, point: Expr) -> SpatialVector:
        """Return a point, given in the frame of its body, from the centre of mass."""
        vector = SpatialVector(point)
        return self.to_fixed_frame(body, vector - self._center(body)) if body else vector

    def near_arm(self, body: int) -> SpatialVector:
        """Return the attachment point of a body from the centre of mass of its parent."""
        return self.arm(self.tree.part(body).parent, self.mechanism.attachments[body - 1].near)

    def own_arm(self, body: int) -> SpatialVector:
        """Return the centre of mass of a body from its attachment point."""
        far_end = SpatialVector(self.mechanism.attachments[body - 1].far)
        return self.to_fixed_frame(body, self._center(body) - far_end)

    def _center(self, body: int) -> SpatialVector:
        return SpatialVector(self.mechanism.parts[body - 1].center)

    def slides(self, body: int) -> bool:
        """Return whether a body slides along an axis."""
        return self.tree.part(body).form in (Slide, Sleeve)

    def along_axis(self, body: int, amounts: Expr) -> SpatialVector:
        """Return the vector of an amount along the axis on which a body slides; zero for one that does not.

        amounts : of all coordinates
        """
        return amounts[self.tree.part(body).coordinate] * self.axis(body) if self.slides(body) else NO_VECTOR

    def axis(self, body: int) -> SpatialVector:
        """Return the axis along which a body slides."""
        part = self.tree.part(body)
        if part.form is Sleeve:
            return self.z_axis(part.parent)
        return self.to_fixed_frame(part.parent, SpatialVector(self.mechanism.attachments[body - 1].axis))


class PosedBodies(Bodies):
    """The bodies of a tree in a program whose second parameter is their Pose."""

    def __init__(self, tree: MachineType, parameters: int = 2):
        super().__init__(tree, parameters)
        self.pose = self.program.parameters[1]

    def frame(self, body: int) -> Expr:
        """Return the Frame of a body or the ground."""
        frame: Expr = self.pose.frames[body - 1] if body else self.program.call(on_ground, 1.0, 0.0)
        return frame

    def spin(self, body: int) -> SpatialVector:
        """Return the angular velocity of a body."""
        return self._quantity(self.pose.spins, body)

    def centre(self, body: int) -> SpatialVector:
        """Return the position of a body's centre of mass."""
        return self._quantity(self.pose.centres_of_mass, body)

    def velocity(self, body: int) -> SpatialVector:
        """Return the velocity of a body's centre of mass."""
        return self._quantity(self.pose.velocities, body)

    def _quantity(self, vectors: Expr, body: int) -> SpatialVector:
        """Return a vector of a body from the pose; it is zero for the ground."""
        return SpatialVector(vectors[body - 1]) if body else NO_VECTOR
