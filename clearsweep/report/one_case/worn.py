"""The wear of one case: pictures of the depth around each body."""

import base64
from functools import partial

import numpy as np

from ... import simulation
from ...language import wording
from ..blocks.picture import Picture
from ..blocks.section import Interactive
from ..data.study import Joint, Study, joint_of, resolve_cases
from ..draw import wear

POLAR_SIZE, FLAT_SIZE, UNROLLED_SIZE = (3.3, 3.5), (3.5, 3.3), (4.2, 2.9)  # inches
MAX_CASES, SECTORS = 30, 120  # cases to choose from in all joints, and sectors of the circle on the page
Depths = tuple[np.ndarray, np.ndarray]


def body_names(study: Study, joint: Joint) -> tuple[str, str]:
    """Return the carriers of bearing and journal, such as 'Bearing in the slider', 'Journal on the rod'."""
    mechanism = simulation.catalogue().mechanism(study.mechanism)
    sites = {site.name: site for site in mechanism.joints} if mechanism else {}
    site, journal = sites.get(joint.title), study.base["joints"].get(joint.title, {}).get("journal")
    if site is None or journal not in site.journals:
        return "Bearing", "Journal"
    bearing = next(body for body in site.journals if body != journal)
    return f"Bearing in the {bearing}", f"Journal on the {journal}"


def wear_pictures(study: Study, joint: Joint, case_id: str, depths: Depths) -> list[Picture]:
    """Return the depths (m) around bearing and journal on one scale, and both along their surfaces.

    A body without wear has no picture of its own.  A spatial joint has a map of each body.
    """
    names = body_names(study, joint)
    if depths[0].ndim > 1:
        return _maps(study, joint, case_id, depths)
    depths = (np.asarray(depths[0], float), np.asarray(depths[1], float))
    scale, largest = wording.scale("m", [*depths[0], *depths[1]]), float(max(map(np.max, depths)))
    pictures = [
        Picture(
            body_name,
            depth_text(depth),
            f"{body_name}: wear depth around it. {depth_text(depth)}",
            partial(wear.draw_around, depth=depth, body=body, scale=scale, max_depth=largest),
            POLAR_SIZE,
            "polar",
        )
        for body, (body_name, depth) in enumerate(zip(names, depths, strict=True))
        if depth.any()
    ]
    if pictures:
        text = "Wear depth of bearing and journal against the angle on the body."
        paint = partial(wear.draw_over_angle, depths=depths, scale=scale)
        pictures.append(Picture("Depth along the surface", "", text, paint, FLAT_SIZE))
    return pictures


def _maps(study: Study, joint: Joint, case_id: str, depths: Depths) -> list[Picture]:
    """Return the wear depths (m) over angle and length of both bodies of a joint in space."""
    (case,) = resolve_cases(study, [case_id])
    case_joint = joint_of(case, joint)
    return [
        Picture(
            name,
            depth_text(deepest_along_axis(depth)),
            f"{name}: wear depth over angle and length. {depth_text(deepest_along_axis(depth))}",
            partial(wear.draw_unrolled, depth=np.asarray(depth, float), length=float(length or 0.0)),
            UNROLLED_SIZE,
        )
        for name, depth, length in zip(
            body_names(study, joint), depths, (case_joint.length, case_joint.journal_length), strict=True
        )
    ]


def deepest_along_axis(depth: np.ndarray) -> np.ndarray:
    """Return the depths (m) of a body by angular bin; of a spatial joint, the deepest along its axis."""
    return np.asarray(depth, float) if depth.ndim == 1 else np.asarray(depth.max(axis=1), float)


def ranking_column(study: Study, joint: Joint) -> str:
    """Return the column that ranks the wear of a joint: its rate, or its depth if there is no rate."""
    rate = joint.column("wear_rate_max")
    return rate if study.has(rate) else joint.column("wear_depth_max")


def selectable_cases(study: Study, joint: Joint) -> Interactive | None:
    """Return the wear of the joint's most worn cases except the first, for comparison with it.

    Return None if there are no others.
    """
    column = ranking_column(study, joint)
    case_indices = study.cases.ordered(column)[
        : min(int((study.cases[column] > 0.0).sum()), MAX_CASES // len(study.joints))
    ]
    if len(case_indices) < 2:
        return None
    case_indices = case_indices[1:]
    label = f"Wear depth around the bodies of joint {joint.title} in a chosen case"
    cases = [_script_data(study, joint, case_id) for case_id in study.cases.index[case_indices]]
    data = {"title": f"Joint {joint.title}, another case: ", "bodies": body_names(study, joint), "cases": cases}
    return Interactive("worn", f"worn-{joint.name}", label, data, "")


def _script_data(study: Study, joint: Joint, case_id: str) -> dict:
    """Return the depths around the bodies of a joint for the page's script: bytes, relative to the deepest."""
    depths = [deepest_along_axis(depth) for depth in study.run.wear(case_id)[joint.name]]
    largest = max(float(depth.max()) for depth in depths)
    scale = largest or 1.0  # arbitrary without wear
    fractions = [wear.deepest_per_sector(depth, SECTORS) / scale for depth in depths]
    text = wording.quantity_text(largest, "m")
    return {
        "name": f"{study.setting(case_id)}: {text}",
        "most": text,
        "said": [depth_text(depth) for depth in depths],
        "mean": [float(depth.mean() / scale) for depth in depths],
        "depths": [
            base64.b64encode(np.rint(255.0 * fraction).astype(np.uint8).tobytes()).decode() for fraction in fractions
        ],
    }


def depth_text(depth: np.ndarray) -> str:
    """Return the place of the deepest wear of a body, and its mean depth, in words."""
    angle = 360.0 * (int(depth.argmax()) + 0.5) / len(depth)
    deepest, mean = wording.texts_in_common_unit((float(depth.max()), float(depth.mean())), "m")
    return f"deepest {deepest} at {angle:.0f}°, mean {mean}"
