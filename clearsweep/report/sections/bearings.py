"""Rolling bearings on the page: their rating life over the clearance."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from ...language import wording
from ..axis import Axis
from ..blocks.picture import Picture
from ..blocks.section import Gallery, Section, without_empty
from ..draw.bearing import draw_life
from ..one_case.motion import FLAT_SIZE
from ..study import Joint, Study

LIFE = "life_l10r"
NOTE = (
    "The rating life of a rolling bearing is usually longest at a slightly negative to small clearance. A preload "
    "loads all elements, and in a loose bearing few elements carry all. A class has to leave room for its scatter."
)
MIN_VALUES = 3  # of the clearance, of a picture


def bearing_sections(study: Study) -> list[Section]:
    """Return the section, or [] if no clearance of a rolling bearing with a life is varied."""
    if study.cases.empty:
        return []
    pictures = [picture for joint in study.joints for picture in _life_over_clearance(study, joint)]
    return [Section("bearings", "Rolling bearings", without_empty([Gallery(NOTE, pictures)]))] if pictures else []


def _life_over_clearance(study: Study, joint: Joint) -> Iterator[Picture]:
    """Yield the life of a bearing over its clearance: the shortest and, of several cases at a value, the longest."""
    path, column = f"joints.{joint.title}.clearance", joint.column(LIFE)
    axis: Axis | None = next((axis for axis in study.levels() if axis.path == path), None)
    if axis is None or not study.has(column) or len(axis.values) < MIN_VALUES:
        return
    indices, lives = study.indices_on(axis), study.cases[column].to_numpy(float)
    groups = [lives[(indices == k) & np.isfinite(lives)] for k in range(len(axis.values))]
    if not all(map(len, groups)):
        return
    shortest, longest = (np.array([function(group) for group in groups]) for function in (np.min, np.max))
    is_spread = bool((longest > shortest).any())
    curves = [("shortest", shortest), ("longest", longest)] if is_spread else [("", shortest)]
    best = int(shortest.argmax())
    text = wording.quantity_text(float(shortest[best]), "h", 4)
    yield Picture(
        f"Rating life over the clearance{study.joint_text(joint, ', joint {}')}",
        "Of all cases at a clearance." if is_spread else "",
        f"Rating life over {axis.name}, longest with {text} at {axis.text(axis.values[best])}.",
        partial(draw_life, axis=axis, lives=curves),
        FLAT_SIZE,
    )
