"""A journal in its bearing in space, from the saved channels of a case."""

from collections.abc import Callable, Mapping

import numpy as np

from ... import simulation
from ...contracts.case import Case, column_name
from ...contracts.case import Joint as CaseJoint
from ...contracts.outline import GROUND
from ...language import wording
from ..blocks.picture import Dot, Picture
from ..draw import spatial

TALL_SIZE, FLAT_SIZE = (4.2, 3.6), (4.2, 3.3)  # inches
MAX_DOT_POSITIONS = 240  # places of a dot that moves: a browser goes straight between them


def spatial_pictures(
    case: Case, joint: CaseJoint, values: Callable[[str], np.ndarray], angle: np.ndarray
) -> list[Picture]:
    """Return the pictures of a spatial joint; values : channel -> its history in SI; angle : rad, of the crank."""
    ends_of_journal = journal_ends(case, joint, values)
    half_lengths = (0.5 * float(joint.journal_length or 0.0), 0.5 * float(joint.length or 0.0))
    tilt, jam_tilt = values(f"joints/{joint.column}/tilt"), _jam_tilt(joint)
    largest_text, frame_text = f"{np.degrees(tilt.max()):.3g}°", "the frame of the bearing, z along it"
    scale_factor, stride = wording.scale("m", joint.clearance).factor, -(-ends_of_journal.shape[1] // MAX_DOT_POSITIONS)
    dots = [
        Dot(end[::stride, :2] / scale_factor, colour)
        for end, colour in zip(ends_of_journal, spatial.END_COLOURS, strict=True)
    ]
    return [
        Picture(
            "The journal's axis in its bearing",
            f"Orbits of both ends in {frame_text}; the scale across it is larger. Circles are the radial clearance.",
            f"Orbits of both ends of the journal's axis; it tilts by {largest_text} at most.",
            lambda ax: spatial.draw_axis(ax, ends_of_journal, half_lengths, joint.clearance),
            TALL_SIZE,
            "3d",
        ),
        Picture(
            "Both ends along the bearing",
            "Click to play one revolution in 8 s.",
            "Orbits of both ends of the journal's axis, seen along the bearing.",
            lambda ax: spatial.draw_end_orbits(ax, ends_of_journal, joint.clearance),
            TALL_SIZE,
            dots=tuple(dots),
        ),
        Picture(
            "Tilt",
            "Angle between the axes of bearing and journal.",
            f"Tilt against crank angle, at most {largest_text}.",
            lambda ax: spatial.draw_tilt(ax, angle, tilt, jam_tilt),
            FLAT_SIZE,
        ),
    ]


def journal_ends(case: Case, joint: CaseJoint, values: Callable[[str], np.ndarray]) -> np.ndarray:
    """Return the positions (2, n, 3) m of both ends of the journal's axis in the frame of the bearing, z along it."""
    mechanism = simulation.mechanism_of(case)
    site = mechanism.site(joint.name)
    journal_body, bearing = site.journals
    bearing_frames, journal_frames = _frames(values, bearing), _frames(values, journal_body)
    rotation = bearing_frames @ _rotation_matrix(joint.tilt)
    centre = np.stack([values(f"joints/{joint.column}/{axis}") for axis in "xyz"], axis=-1)
    half_axis = 0.5 * float(joint.journal_length or 0.0) * journal_frames[:, :, 2]
    ends = np.stack([centre + half_axis, centre - half_axis])
    rotated: np.ndarray = np.einsum("nji,enj->eni", np.broadcast_to(rotation, (ends.shape[1], 3, 3)), ends)
    return rotated


def _frames(values: Callable[[str], np.ndarray], body: str) -> np.ndarray:
    """Return the rotation matrices (n, 3, 3) of a body; (1, 3, 3) of the ground."""
    if body == GROUND:
        return np.eye(3)[None]
    w, x, y, z = (values(f"{column_name(body)}/q{k}") for k in "wxyz")
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(rows), -1, 0)


def _rotation_matrix(vector: tuple[float, ...]) -> np.ndarray:
    """Return the rotation matrix of a rotation vector about x and y, by Rodrigues' formula."""
    a, b = vector
    angle = float(np.hypot(a, b))
    cross_product = np.array([[0.0, 0.0, b], [0.0, 0.0, -a], [-b, a, 0.0]])
    sine_term, cosine_term = (np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2) if angle else (1.0, 0.5)
    matrix: np.ndarray = np.eye(3) + sine_term * cross_product + cosine_term * (cross_product @ cross_product)
    return matrix


def _jam_tilt(joint: CaseJoint) -> float | None:
    """Return the tilt (rad) at which a journal jams, or None if nothing stops it."""
    limit = simulation.jam_angle(joint)
    return limit if np.isfinite(limit) else None


def is_spatial(channels: Mapping, joint: str) -> bool:
    """Return whether the channels are those of a spatial joint, named as in columns."""
    return f"joints/{joint}/tilt" in channels
