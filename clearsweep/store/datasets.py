"""The datasets of the orbits besides time histories and wear: events, sections, the history of a life."""

import math
from typing import NamedTuple

import h5py
import numpy as np

from ..contracts import results
from ..contracts.layout import SECTION_COUNT, Layout

CASE, SAMPLE, EVENT, SECTION, NODE = "case", "sample", "event", "section", "node"


class Dataset(NamedTuple):
    """One dataset of the orbits: an array of `shape` per `item` (case, sample, event, section or node of a life)."""

    path: str
    dtype: np.dtype
    unit: str
    description: str
    item: str  # CASE, SAMPLE, EVENT, SECTION or NODE
    shape: tuple[int, ...] = ()

    @property
    def width(self) -> int:
        """Return the number of values per `item`."""
        return math.prod(self.shape)


def event_datasets(layout: Layout) -> list[Dataset]:
    """Return the datasets of contact events."""
    joints = h5py.enum_dtype({name: code for code, name in enumerate(layout.contacts)}, basetype="i1")
    kinds = h5py.enum_dtype({kind: code for code, kind in enumerate(results.EVENT_KINDS)}, basetype="i1")
    return [
        Dataset("events/t", np.dtype("f8"), "s", "time of the event", EVENT),
        Dataset("events/joint", joints, "1", "joint of the event", EVENT),
        Dataset("events/kind", kinds, "1", "contact begins (on) or ends (off)", EVENT),
        Dataset("events/rate", np.dtype("f8"), "m/s", "closing rate, closing positive", EVENT),
        Dataset(
            "events/force_peak",
            np.dtype("f8"),
            "N",
            "largest normal force of the contact that ends there, 0 at an onset",
            EVENT,
        ),
    ]


def section_datasets(layout: Layout) -> list[Dataset]:
    """Return the datasets of values stored at crank angle 0 of every revolution."""
    if not layout.sections:
        return []
    channels = {channel.name: channel for channel in layout.channels}
    text = "turns of the crank, its angle over 2 pi, at each section"
    datasets = [Dataset(SECTION_COUNT, np.dtype("i8"), "1", text, SECTION)]
    for name, path in layout.sections:
        text = f"{channels[name].description}, at crank angle 0"
        datasets.append(Dataset(path, np.dtype("f8"), channels[name].unit, text, SECTION))
    return datasets


#: History of a life for each joint with wear: name, unit, description, and whether it has a value per bin.
_JOINT_HISTORIES = (
    ("wear_depth_max", "m", "largest wear depth of either body", False),
    ("clearance", "m", "largest eccentricity, over directions, at which the surfaces touch first", False),
    ("force_peak", "N", "largest normal force of the block at this node", False),
    ("wear_rate", "m/s", "largest wear rate of a bin", False),
    ("profile_bearing", "m", "wear depth of the bearing in angular bins of its own frame", True),
    ("profile_journal", "m", "wear depth of the journal in angular bins of its own frame", True),
)


def life_datasets(layout: Layout) -> list[Dataset]:
    """Return the datasets of the history of a life, node by node."""
    if not layout.life:
        return []
    text = "revolutions from the unworn start to the limit, or to the last block"
    datasets = [Dataset(f"{results.HISTORY}revolutions", np.dtype("f8"), "1", text, NODE)]
    for joint in layout.joints:
        for name, unit, text, has_bins in _JOINT_HISTORIES if joint.wear_bins else ():
            path, shape = f"{results.HISTORY}{joint.name}/{name}", (joint.wear_bins,) if has_bins else ()
            datasets.append(Dataset(path, np.dtype("f8"), unit, text, NODE, shape))
    return datasets
