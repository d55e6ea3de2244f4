"""What an elastic law declares.

A law that folds back, or grows without bound, at some penetration is followed up to where its tangent stiffness is
twice the secant one, and along that tangent from there on: the force always grows, and never ends.
"""

from ...compiled.family import family


@family
def elastic_force(elastic, pen):
    """Return the elastic force (N) at penetration `pen` (m, at least 0)."""


@family
def parity(elastic):
    """Return -1 where the force is, at small penetration, an odd power of the root of the penetration; else 1."""


FAMILIES = (elastic_force, parity)  # a type of this kind is a member of each


def elastic_form(form, *, odd: bool):
    """Return the decorator that enters the `elastic_force` of a type.

    `odd` : at small penetration the force is an odd power of the root of the penetration.
    """

    def enter(body):
        parity.member(form)(_odd if odd else _even)
        return elastic_force.member(form)(body)

    return enter


def _odd(elastic):
    return -1.0


def _even(elastic):
    return 1.0


NEEDS = ("length", "material")  # of the laws of cylinders
