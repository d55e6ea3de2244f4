"""Vectors of the bodies of a tree in its generated functions; all are in the fixed frame unless stated."""

from ..planar.expressions import Expr, FunctionCode
from .expressions import NO_VECTOR, SpatialVector
from .form import Sleeve, Slide
from .machine_type import MachineType


class TreeCode:
    """The code of a function of a tree, with the frame of each body in a variable."""

    def __init__(self, tree: MachineType, *arguments: str):
        self.tree, self.code = tree, FunctionCode(*arguments)
        self.vertical = self.vector("Vector(0.0, 0.0, 1.0)")

    def vector(self, text: str) -> SpatialVector:
        """Return code as a vector without assigning it to a variable."""
        return SpatialVector(text, self.code)

    def call(self, function: str, *arguments: Expr | SpatialVector | str) -> SpatialVector:
        """Return a variable with the vector that a function returns."""
        return self.vector(self.code.call(function, *map(str, arguments)).text)

    def frame(self, body: int) -> str:
        """Return the Frame of a body."""
        return f"f{body}"

    def to_fixed_frame(self, body: int, vector: SpatialVector) -> SpatialVector:
        """Return a vector of a body's frame, or of the ground's, in the fixed frame."""
        return self.call("to_fixed_frame", self.frame(body), vector) if body else vector

    def to_body_frame(self, body: int, vector: SpatialVector) -> SpatialVector:
        """Return a vector of the fixed frame in that of a body."""
        return self.call("to_body_frame", self.frame(body), vector)

    def z_axis(self, body: int) -> SpatialVector:
        """Return the z axis of a body or the ground."""
        return self.vertical if self.tree.is_vertical(body) else self.call("axis_z", self.frame(body))

    def arm(self, body: int, point: str) -> SpatialVector:
        """Return a point, given in the frame of its body, from the centre of mass."""
        if body == 0:
            return self.vector(point)
        return self.to_fixed_frame(body, self.vector(point) - self.vector(f"mechanism.parts[{body - 1}].center"))

    def near_arm(self, body: int) -> SpatialVector:
        """Return the attachment point of a body from the centre of mass of its parent."""
        return self.arm(self.tree.part(body).parent, f"mechanism.attachments[{body - 1}].near")

    def own_arm(self, body: int) -> SpatialVector:
        """Return the centre of mass of a body from its attachment point."""
        center = self.vector(f"mechanism.parts[{body - 1}].center")
        return self.to_fixed_frame(body, center - self.vector(f"mechanism.attachments[{body - 1}].far"))

    def along_axis(self, body: int, amount: str) -> SpatialVector:
        """Return the vector of this length along the axis on which a body slides; zero for one that does not."""
        if self.tree.part(body).form in (Slide, Sleeve):
            return self.code.expression(amount) * self.axis(body)
        return NO_VECTOR

    def axis(self, body: int) -> SpatialVector:
        """Return the axis along which a body slides."""
        part = self.tree.part(body)
        if part.form is Sleeve:
            return self.z_axis(part.parent)
        return self.to_fixed_frame(part.parent, self.vector(f"mechanism.attachments[{body - 1}].axis"))


class PosedTreeCode(TreeCode):
    """The code of a function of a pose of a tree."""

    def frame(self, body: int) -> str:
        """Return the Frame of a body or the ground."""
        return self.code.assign(f"pose.frames[{body - 1}]" if body else "on_ground(1.0, 0.0)").text

    def spin(self, body: int) -> SpatialVector:
        """Return the angular velocity of a body."""
        return self._quantity("spins", body)

    def centre(self, body: int) -> SpatialVector:
        """Return the position of a body's centre of mass."""
        return self._quantity("centres_of_mass", body)

    def velocity(self, body: int) -> SpatialVector:
        """Return the velocity of a body's centre of mass."""
        return self._quantity("velocities", body)

    def _quantity(self, name: str, body: int) -> SpatialVector:
        """Return a vector of a body from the pose; it is zero for the ground."""
        return self.vector(self.code.assign(f"pose.{name}[{body - 1}]").text) if body else NO_VECTOR
