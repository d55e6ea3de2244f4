"""Figures of rolling bearings."""

from ...contracts.catalogue import ENDLESS, Entry, Figure
from .window import Window


def static_safety(window: Window, index: int) -> float | None:
    """Return C0 / P0 of a rolling bearing (ISO 76:2006), or None without load.

    P0, the equivalent static load of a radial bearing without axial load, is the largest resultant of its elements.
    """
    bearing, load = window.case.joints[index].rolling, window.totals.joint[index].force_max
    assert bearing is not None  # only rolling bearings have this figure
    assert bearing.capacity.static is not None  # with this rating
    return float(bearing.capacity.static / load) if load > 0.0 else None


ROLLING = (
    Figure(
        "element_load_max",
        "N",
        "largest force of a rolling element in the window, located",
        of="joint",
        needs=("rolling",),
        value=lambda window, index: window.totals.joint[index].element_force_max,
        tables=(Entry("forces", "element load", 27, if_any=True), Entry("case", "element load", 11)),
    ),
    Figure(
        "elements_loaded_max",
        "1",
        "largest number of rolling elements that carry load at a time",
        of="joint",
        needs=("rolling",),
        value=lambda window, index: round(window.totals.joint[index].elements_loaded),
        kind="int",
        tables=(Entry("forces", "elements loaded", 28, if_any=True),),
    ),
    Figure(
        "static_safety",
        "1",
        "static load rating over the largest equivalent static load, which is the force peak (ISO 76); null: no load",
        of="joint",
        needs=("rolling", "static"),
        value=static_safety,
        tables=(Entry("forces", "static safety", 29, if_any=True), Entry("case", "static safety", 12)),
        null=ENDLESS,
    ),
)
