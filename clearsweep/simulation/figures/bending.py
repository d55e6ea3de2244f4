"""Figures of links that bend, deflection, stress, first rate and fatigue, and of housings that yield."""

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
    Figure(
        "damage",
        "1",
        "share of the fatigue life of {link} that its stress in the window uses up, at the worst edge of 11 stations",
        of="link",
        needs=("bends", "fatigue"),
        tables=(Entry("output", "damage", 8, if_any=True), Entry("case", "damage", 13)),
    ),
    Figure(
        "error_mounts",
        "{output}",
        "largest distance by which the motion of housings alone displaces the {output}, to first order",
        of="output",
        needs=("mounted",),
        tables=(Entry("output", "{output} error by housings", 2, if_any=True),),
    ),
    Figure(
        "mount_motion_max",
        "m",
        "largest distance of the housing of {mount} from where its springs have no force",
        of="mount",
        needs=("mounted",),
        tables=(Entry("output", "motion of the housing", 9), Entry("case", "motion of the housing", 14)),
    ),
)
