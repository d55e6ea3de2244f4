"""The structure of a tree, read from its compiled type."""

from .form import Ball, Driven, Hinge, Loose, Sleeve, Slide, Tree

COORDINATES = {Driven: 0, Hinge: 1, Slide: 1, Sleeve: 2, Ball: 4, Loose: 7}
SPEEDS = {Driven: 0, Hinge: 1, Slide: 1, Sleeve: 2, Ball: 3, Loose: 6}


class BodyNode:
    """A body in the type of a tree: attachment, parent, first coordinate and first speed."""

    def __init__(self, form: type, parent: int, coordinate: int, speed: int):
        self.form, self.parent, self.coordinate, self.speed = form, parent, coordinate, speed

    @property
    def turns_freely(self) -> bool:
        """Return whether the body has a quaternion."""
        return self.form in (Ball, Loose)


class MachineType:
    """The structure of a Tree."""

    def __init__(self, kinds: tuple):
        assert kinds[0] is Tree
        field = {name: kinds[1 + index] for index, name in enumerate(Tree._fields)}
        self.parts: list[BodyNode] = []
        coordinate = speed = 0
        for kind in field["attachments"][1:]:
            parent = _number(kind, "parent") if "parent" in kind[0]._fields else 0
            self.parts.append(BodyNode(kind[0], parent, coordinate, speed))
            coordinate, speed = coordinate + COORDINATES[kind[0]], speed + SPEEDS[kind[0]]
        self.coordinates, self.speeds = coordinate, speed
        self.openings = [(_number(kind, "bearing"), _number(kind, "journal")) for kind in field["openings"][1:]]
        self.reported = [len(kind) - 1 for kind in field["reported"][1:]]
        self.aim, self.aimed = field["aim"][0], _number(field["aim"], "body")
        self.crank = 1 + next(i for i, part in enumerate(self.parts) if part.form is Driven)

    def part(self, body: int) -> BodyNode:
        """Return a body that moves by its number."""
        return self.parts[body - 1]

    def is_vertical(self, body: int) -> bool:
        """Return whether the z axis of a body is that of the fixed frame."""
        while body and self.part(body).form in (Driven, Hinge, Slide, Sleeve):
            body = self.part(body).parent
        return body == 0


def _number(kind: tuple, name: str) -> int:
    return len(kind[1 + kind[0]._fields.index(name)]) - 1
