"""Writes vector expressions into the generated functions of a tree.

A vector is represented by its name, or None if zero; vectors of a body are in the fixed frame.
"""

from ..planar.writer import Lines
from .form import Sleeve, Slide
from .machine_type import MachineType

ZERO = "Vector(0.0, 0.0, 0.0)"
UP = "Vector(0.0, 0.0, 1.0)"
AXES = "xyz"


class Writer:
    """Lines of a generated function of a tree."""

    def __init__(self, tree: MachineType, *arguments: str):
        self.tree, self.lines = tree, Lines(*arguments)

    def let(self, expression: str | None) -> str | None:
        """Return a name for an expression."""
        return self.lines.let(expression)

    def all_of(self, *vectors: str | None) -> str | None:
        """Return the sum of vectors."""
        present_vectors = [vector for vector in vectors if vector is not None]
        total = present_vectors[0] if present_vectors else None
        for each in present_vectors[1:]:
            total = self.let(f"plus({total}, {each})")
        return total

    def difference(self, a: str | None, b: str | None) -> str:
        """Return a - b."""
        if b is None:
            return a or ZERO
        return f"minus({a or ZERO}, {b})"

    def cross(self, a: str | None, b: str | None) -> str | None:
        """Return a x b."""
        return None if a is None or b is None else self.let(f"cross({a}, {b})")

    def z_of(self, body: int) -> str:
        """Return the z axis of a body or the ground."""
        if self.tree.up(body):
            return UP
        name = self.let(f"axis_z({self.frame(body)})")
        assert name is not None
        return name

    def frame(self, body: int) -> str:
        """Return the Frame of a body."""
        return f"f{body}"

    def arm(self, body: int, point: str) -> str | None:
        """Return a point of a body, in its own frame, from its centre of mass in the fixed frame."""
        if body == 0:
            return point
        return self.let(f"in_fixed({self.frame(body)}, minus({point}, mechanism.parts[{body - 1}].center))")

    def near(self, body: int) -> str | None:
        """Return the attachment point of a body from the centre of mass of its parent."""
        return self.arm(self.tree.part(body).parent, f"mechanism.attachments[{body - 1}].near")

    def own(self, body: int) -> str | None:
        """Return the centre of mass of a body from its attachment point."""
        return self.let(
            f"in_fixed({self.frame(body)}, "
            f"minus(mechanism.parts[{body - 1}].center, mechanism.attachments[{body - 1}].far))"
        )

    def shift(self, body: int, amount: str) -> str | None:
        """Return the displacement (m) of a sliding body, in the fixed frame."""
        part = self.tree.part(body)
        if part.form is Slide:
            return self.let(f"times({amount}, {self.axis(body)})")
        return self.let(f"times({amount}, {self.z_of(part.parent)})") if part.form is Sleeve else None

    def axis(self, body: int) -> str | None:
        """Return the axis along which a body slides, in the fixed frame."""
        axis, parent = f"mechanism.attachments[{body - 1}].axis", self.tree.part(body).parent
        return self.let(f"in_fixed({self.frame(parent)}, {axis})" if parent else axis)


class Posed(Writer):
    """Lines of a generated function of a pose."""

    def frame(self, body: int) -> str:
        """Return the Frame of a body or the ground."""
        name = self.let(f"pose.frames[{body - 1}]" if body else "on_ground(1.0, 0.0)")
        assert name is not None
        return name

    def spin(self, body: int) -> str | None:
        """Return the angular velocity of a body in the fixed frame, None of the ground."""
        return self.let(f"pose.spins[{body - 1}]") if body else None

    def at(self, body: int) -> str | None:
        """Return the position of a body's centre of mass."""
        return self.let(f"pose.centres_of_mass[{body - 1}]") if body else None

    def velocity(self, body: int) -> str | None:
        """Return the velocity of a body's centre of mass."""
        return self.let(f"pose.velocities[{body - 1}]") if body else None

    def fixed(self, body: int, own_values: str) -> str | None:
        """Return a vector of a body's frame in the fixed frame."""
        return self.let(f"in_fixed({self.frame(body)}, {own_values})") if body else self.let(own_values)
