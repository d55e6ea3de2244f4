"""The revolution of the peak: force, acceleration and torque of the worst cases, with and without clearance."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ...language import wording
from ..blocks.picture import Picture, capitalise
from ..blocks.section import Block, Detail, Section, Sentences
from ..data.study import Joint, Study
from ..data.table_columns import columns_in_table
from ..one_case.motion import FLAT_SIZE, JointHistory, history_of, joint_histories, largest_texts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NOTE_ON_CASES = (
    "Each case is shown over the revolution with its largest normal force. The cases are those with the largest load "
)
NOTE_ON_FORCES = "divided by the largest reaction without clearance. Dashed lines show the mechanism without clearance."


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no such revolution was saved."""
    saved = [
        case_id for case_id in study.run.worst if study.cases.row_of(case_id) >= 0
    ]  # without those that check laws
    if not saved:
        return []
    blocks: list[Block] = [Sentences([NOTE_ON_CASES + NOTE_ON_FORCES])]
    blocks += [_case_detail(study, rank, case_id) for rank, case_id in enumerate(saved, start=1)]
    return [Section("peak-revolution", "Revolution of the peak", blocks)]


def _case_detail(study: Study, rank: int, case_id: str) -> Detail:
    """Return one case: its peak, and the histories around it."""
    channels = study.run.peak_revolution(case_id)
    joint = next(joint for joint in study.joints if joint.name == channels.attrs["joint"])
    history = history_of(study, case_id, channels)
    pictures = [
        _picture(curve, history.painter(*_painter_arguments(curve)))
        for curve in joint_histories(study, case_id, history)
    ]
    figures = [(name, study.text(case_id, column)) for column, name in columns_in_table(study, "case", joint)]
    label = f"Worst case {rank}" if len(study.run.worst) > 1 else "Worst case"
    return Detail(
        label, case_id, study.setting(case_id), [*_peak_location(joint, channels, history.angle), *figures], pictures
    )


def _peak_location(joint: Joint, channels: pd.DataFrame, angle: np.ndarray | None) -> list[tuple[str, str]]:
    """Return the revolution and the place in it of the largest sample of the force."""
    facts = [
        ("joint", joint.title),
        ("revolution", f"{channels.attrs['turns']:.4g} to {channels.attrs['turns'] + 1.0:.4g}"),
    ]
    if angle is not None:
        degrees = np.degrees(angle[int(np.argmax(channels[f"joints/{joint.name}/force_normal"]))]) % 360.0
        facts.append(("peak at", f"{degrees:.1f}{wording.BLANK}°"))
    return facts


def _painter_arguments(curve: JointHistory) -> tuple:
    return curve.actual, curve.unit, curve.name, curve.ideal


def _picture(curve: JointHistory, paint: "Callable[[Axes], None]") -> Picture:
    """Return one quantity over the revolution."""
    largest_text, *ideal_text = largest_texts(
        [curve.actual, *([] if curve.ideal is None else [curve.ideal])], curve.unit
    )
    alt = f"{capitalise(curve.name)} over the revolution of the peak, at most {largest_text} among the samples"
    if ideal_text:
        alt += f"; without clearance {ideal_text[0]}"
    return Picture(capitalise(curve.name), "", f"{alt}.", paint, FLAT_SIZE)
