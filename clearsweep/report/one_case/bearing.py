"""The rolling bearing of one case: the bearing with the loads of its elements, and the loads around it."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from ...language import wording
from ..blocks.picture import Dot, Picture
from ..draw import RED
from ..draw.bearing import LoadedElements, draw_bearing, draw_load_distribution
from ..study import Joint, Study, joint_of, resolve_cases

SQUARE_SIZE, FLAT_SIZE = (4.2, 3.05), (4.2, 3.3)  # inches


def loaded_elements(joint: Joint, channels: Mapping) -> LoadedElements | None:
    """Return the elements of a rolling bearing over the saved samples, or None if they are not all stored."""
    forces = (f"element_{k + 1}_force" for k in range(joint.layout.corners))
    names = [f"joints/{joint.name}/{name}" for name in ("cage_angle", *forces)]
    if not all(name in channels for name in names):
        return None
    cage, *loads = (np.asarray(channels[name], float) for name in names)
    loads = [load for load in loads if not np.isnan(load).all()]  # other bearings of the run have more elements
    angles = cage[:, None] + 2.0 * np.pi * np.arange(len(loads)) / len(loads)
    return LoadedElements(angles, np.maximum(np.stack(loads, axis=-1), 0.0))


def bearing_pictures(study: Study, case_id: str, joint: Joint, channels: Mapping) -> list[Picture]:
    """Return the bearing at the largest load of an element, and the loads around it; [] where they are not stored."""
    elements = loaded_elements(joint, channels)
    bearing = joint_of(resolve_cases(study, [case_id])[0], joint).rolling
    if elements is None or bearing is None or not elements.loads.any():
        return []
    joint_text, peak = study.joint_text(joint, ", joint {}"), elements.peak
    largest = wording.quantity_text(float(elements.loads[peak].max()), "N")
    loaded = int((elements.loads[peak] > 0.0).sum())
    path = 500.0 * bearing.pitch_diameter * np.stack([np.cos(elements.angles[:, 0]), np.sin(elements.angles[:, 0])], -1)
    return [
        Picture(
            f"Loads of the elements{joint_text}",
            "At the largest load of an element among the samples. Red: loads, to scale. The dot follows an element.",
            f"The bearing with {loaded} of {len(elements.loads[peak])} elements loaded, at most {largest}.",
            partial(draw_bearing, bearing=bearing, angles=elements.angles[peak], loads=elements.loads[peak]),
            SQUARE_SIZE,
            dots=(Dot(path, RED),),
        ),
        Picture(
            f"Load distribution{joint_text}",
            "Loads of all saved samples over the angle of the element in the fixed frame.",
            f"Load of the elements over their angle, at most {largest}.",
            partial(draw_load_distribution, elements=elements),
            FLAT_SIZE,
        ),
    ]
