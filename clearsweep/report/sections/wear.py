"""Wear: where each joint wears, and how much in every finished case."""

from functools import partial

import numpy as np

from ... import simulation, wording
from ...layout import JointLayout
from ..case_table import case_table
from ..draw import motion
from ..picture import Picture
from ..section import Block, Gallery, Section, Sentences, filled
from ..shown import shown
from ..study import Joint, Study, joint_of, resolved
from ..table import Table

NOTE = (
    "Polar depth on each body, angles counter-clockwise from that body's own x axis, which points along a crank or rod."
)

IN_SPACE = " Maps are unrolled: angle across, along the body's own axis z upwards from its middle."


def joint_layout(study: Study, joint: Joint) -> JointLayout:
    """Return what decides what is stored about a joint."""
    return next(each for each in study.run.layout.joints if each.name == joint.name)


def sections(study: Study) -> list[Section]:
    """Return the section; [] where no case finished or nothing wears."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    for joint in study.joints:
        if joint.wears:
            note = NOTE + IN_SPACE if joint_layout(study, joint).telling else NOTE
            blocks += [Gallery(note, _pictures(study, joint)), Sentences(_coarse(study, joint)), _table(study, joint)]
    return [Section("wear", "Wear", filled(blocks))]


def _coarse(study: Study, joint: Joint) -> list[str]:
    """Return in how many cases the bins are too coarse, and how many would do; [] where they are in none."""
    column = joint.column("wear_bins_enough")
    bins = joint_layout(study, joint).wear_bins
    if not study.has(column) or study.cases[column].max() <= bins:
        return []
    coarse = study.cases[column][study.cases[column] > bins]
    enough, most = int(coarse.max()), simulation.FINEST
    remedy = (
        f"`bins: {enough}` would do for all" if enough <= most else f"wear is kept in {most} at most, too few for all"
    )
    return [
        f"In joint {joint.title} {bins} bins are too coarse in {len(coarse):,} of "
        f"{wording.count(len(study.cases), 'case')}: more than 5 % of the wear comes from contact arcs narrower than "
        f"five bins, so that depths are means over the bins, not peaks; {remedy}."
    ]


def _table(study: Study, joint: Joint) -> Table:
    """Return the wear of one joint, the deepest first."""
    columns = shown(study, "wear", joint)
    key, title = f"wear_{joint.name}", f"Wear in joint {joint.title}"
    table = case_table(study, key, title, columns, joint.column("wear_depth_max"))
    return table._replace(
        note=f"{table.note} Depth and volume are those of the recorded window; per 1000 h and 10⁶ "
        "strokes, turns of the crank, at its rate. Pressure and pV are those of the contact arc, its largest unless it "
        "says mean; catalogues' limits mean force over diameter times length. Narrow arcs: share of the wear steps "
        "whose contact arc was narrower than five bins."
    )


def _pictures(study: Study, joint: Joint) -> list[Picture]:
    """Return the polar wear depth of the deepest worn case, and of the median one where there is one."""
    column = joint.column("wear_depth_max")
    if not study.has(column):
        return []
    ids = study.cases.ranked(column)
    drawn = _maps if joint_layout(study, joint).telling else _picture
    pictures = drawn(study, joint, "Deepest", ids[0])
    return pictures + (drawn(study, joint, "Median", ids[1]) if len(ids) > 2 else [])


def _maps(study: Study, joint: Joint, word: str, case_id: str) -> list[Picture]:
    """Return the wear depth over angle and length of both bodies of a joint in space."""
    (case,) = resolved(study, [case_id])
    held, depths = joint_of(case, joint), study.run.wear(case_id)[joint.name]
    bodies = (("bearing", held.length), ("journal", held.journal_length))
    return [
        Picture(
            f"{word} wear of the {body}, joint {joint.title}",
            "; ".join(filter(None, (study.setting(case_id), f"case {case_id}"))),
            f"Wear depth over angle and length: at most {wording.text(float(depth.max(initial=0.0)), 'm')}.",
            partial(motion.wear_map, depth=np.asarray(depth, float), length=float(length or 0.0)),
            size=(4.2, 2.9),
        )
        for depth, (body, length) in zip(depths, bodies, strict=True)
    ]


def _picture(study: Study, joint: Joint, word: str, case_id: str) -> list[Picture]:
    """Return the polar wear depth of both bodies of a joint."""
    bearing, journal = (np.asarray(depth, float) for depth in study.run.wear(case_id)[joint.name])
    deepest = [wording.text(float(depth.max(initial=0.0)), "m") for depth in (bearing, journal)]
    return [
        Picture(
            f"{word} wear, joint {joint.title}",
            "; ".join(filter(None, (study.setting(case_id), f"case {case_id}"))),
            f"Polar wear depth: at most {deepest[0]} on the bearing, {deepest[1]} on the journal.",
            lambda ax: motion.wear(ax, bearing, journal),
            size=(4.2, 3.4),
            projection="polar",
        )
    ]
