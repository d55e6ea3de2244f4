"""Figures of links that bend: deflection, stress, first rate, and fatigue."""

from ...contracts.catalogue import Entry, Figure

FIGURES = (
    Figure(
        "error_bending",
        "{output}",
        "largest distance by which the bending of links alone displaces the {output}, to first order; null: the output "
        "is a point of a link that bends",
        of="output",
        needs=("bends",),
        tables=(Entry("output", "{output} error by bending", 1, if_any=True),),
    ),
    Figure(
        "deflection_max",
        "m",
        "largest deflection of the middle of {link} from the chord between its pins",
        of="link",
        needs=("bends",),
        tables=(Entry("output", "deflection", 6), Entry("case", "deflection", 11)),
    ),
    Figure(
        "stress_max",
        "Pa",
        "largest stress of {link} by bending and normal force, at the worst of 11 stations",
        of="link",
        needs=("bends",),
        tables=(Entry("output", "stress", 7), Entry("case", "stress", 12)),
    ),
    Figure(
        "frequency",
        "1/s",
        "first bending mode (Hz) of {link} between its pins",
        of="link",
        needs=("bends",),
        differs=False,
    ),
)
