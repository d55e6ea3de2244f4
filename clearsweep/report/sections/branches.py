"""Random starts on the page: which motion each of them leads to."""

from functools import partial

import numpy as np

from ...answers.branches import motions_of
from ...contracts.catalogue import STARTS
from ...simulation import random_places
from ..blocks.picture import Picture
from ..draw.maps import draw_basins
from ..one_case.motion import SQUARE_SIZE
from ..study import Joint, Study, answer_of_study, words_of


def basins(study: Study, joint: Joint) -> list[Picture]:
    """Return the picture of the random starts of a point with several motions, if one joint is open."""
    points = (answer_of_study(study).get("branches") or {}).get("motions") or []
    joints = study.base.get("joints", {})
    if not points or len(joints) != 1 or STARTS[1] not in study.cases:
        return []
    point = max(points, key=lambda each: len(each["motions"]))
    rows = np.ones(len(study.cases), bool)
    for path, value in point["values"].items():
        rows &= study.cases[path].to_numpy() == value
    columns = [joint.column(f"force_peak_median{end}") for end in ("", "_low", "_high")]
    statistic = np.stack([study.cases[column].to_numpy(float)[rows] for column in columns], -1)
    is_known = np.isfinite(statistic).all(axis=1)
    has_flanks = any(key in joints[joint.title] for key in ("backlash", "play"))
    draws, seed = study.cases[STARTS[1]].to_numpy(float)[rows][is_known], study.base["simulate"]["seed"]
    starts = [np.concatenate(random_places(int(seed), int(draw), [has_flanks])) for draw in draws]
    flanks, journal = ("position [play / 2]", "rate [play / 2 x crank speed]"), ("journal x [c]", "journal y [c]")
    names = flanks if has_flanks else journal
    motions = motions_of(statistic[is_known])
    setting = words_of(study).setting(point["values"])
    rates = "" if has_flanks else " Their rates are random, too, so the colours may mix."
    labels = [words_of(study).figures(columns[0], [motion["median"]])[0] for motion in point["motions"]]
    return [
        Picture(
            f"Random starts and their motions{study.joint_text(joint, ', joint {}')}",
            f"At {setting}. The colours are the medians of the force peaks of the motions.{rates}",
            f"{len(starts)} random starts, coloured by {len(labels)} motions.",
            partial(draw_basins, places=np.array(starts)[:, :2], motions=motions, labels=labels, axes=names),
            SQUARE_SIZE,
        )
    ]
