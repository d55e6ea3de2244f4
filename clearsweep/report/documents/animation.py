"""One case in motion as a GIF or WebP file: bodies, slots, and the gap of every joint magnified in its place."""

import io
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...contracts.machine import GROUND
from ...language import wording
from ...language.errors import InputError
from ..blocks.section import Picture
from ..draw import BLUE, GREY, INK, RED
from ..draw.machine import BODY_COLOURS
from ..one_case.motion import History, has_straight_walls, history_of
from ..plot import Axes
from ..sections.cases import load_sketch, moving_bodies
from ..study import Study
from .paper import drawing_bytes, panels_svg

FORMS = {".gif": "GIF", ".webp": "WEBP"}
FRAMES, FRAME_TIME = 60, 60  # frames of a turn or of a start-up; ms of each
SIZE, DOTS = (5.2, 4.2), 100  # inches; dots per inch
GAP_SIZE, MARGIN = 0.07, 0.12  # of the drawing: radius of a drawn gap, and free space around the bodies
BLOCK = {"marker": "s", "markersize": 11}  # a body with one joint
MARK = b"drawn by clearsweep"  # recognised by `durable.check_output`


class _Gap(NamedTuple):
    """A journal in its bearing; n samples."""

    clearance: float  # m
    place: np.ndarray  # (n, 2) m, of the bearing in the fixed frame
    offset: np.ndarray  # (n, 2), of the journal centre, in clearances
    force: np.ndarray  # (n,) N


class _Scene(NamedTuple):
    """All that is drawn; n samples, positions in m in the fixed frame."""

    bodies: list[np.ndarray]  # (n, joints, 2)
    slots: list[tuple[int, np.ndarray]]  # number of the body, (n, points, 2)
    fixed: list[np.ndarray]  # (points, 2), walls of slots in the ground
    pivots: np.ndarray  # (pivots, 2)
    gaps: list[_Gap]


def animation_bytes(study: Study, case_id: str, channels: Mapping, ending: str) -> bytes:
    """Return a case in motion as the bytes of a GIF or WebP file: the turn with the largest force, or a start-up.

    Raises InputError without Pillow, and for a machine without a picture.
    """
    try:
        from PIL import Image
    except ImportError:
        raise InputError(f"show: a file that ends in {ending} needs Pillow; run `pip install pillow`") from None
    history = history_of(study, case_id, channels)
    scene = _scene(study, case_id, history)
    note = f"gap magnified {_gap_radius(scene) / scene.gaps[0].clearance:.2g} times" if scene.gaps else ""
    frames = []
    for k in _frame_indices(study, history):
        turn = "" if history.angle is None else f"{np.degrees(history.angle[k]):.0f}°"
        time = wording.quantity_text(float(history.time[k]), "s") if study.is_over_time else ""
        title = ", ".join(filter(None, [time, turn, note]))
        png = drawing_bytes(
            panels_svg([Picture(title, "", "", partial(_draw, scene=scene, k=k), SIZE)]), "png", dots_per_inch=DOTS
        )
        frames.append(Image.open(io.BytesIO(png)).convert("RGB"))
    stream = io.BytesIO()
    style: dict[str, Any] = {"comment": MARK} if ending == ".gif" else {"xmp": MARK}
    frames[0].save(stream, FORMS[ending], save_all=True, append_images=frames[1:], duration=FRAME_TIME, loop=0, **style)
    return stream.getvalue()


def _scene(study: Study, case_id: str, history: History) -> _Scene:
    """Return what is drawn of a case."""
    sketch = load_sketch(study, case_id)
    bodies = moving_bodies(sketch, history.channels) if sketch else []
    if sketch is None or not bodies:
        raise InputError(f"case {case_id}: a mechanism of this type has no animation; choose .html, .svg, .png or .csv")
    slots = [(number, _moved(body, wall)) for number, body in enumerate(bodies) for wall in body["walls"]]
    gaps = []
    for joint in study.joints:
        clearance = study.radial_clearance(case_id, joint)
        sketched = next(each for each in sketch.joints if each.name == joint.title)
        if clearance is None or has_straight_walls(study, joint):
            continue
        x, y, force = (history.values(f"joints/{joint.name}/{key}") for key in ("x", "y", "force_normal"))
        clearance, place = float(clearance), _place(sketched.position, bodies, len(x))
        gaps.append(_Gap(clearance, place, np.stack([x, y], -1) / clearance, force))
    pinned = [joint for joint in sketch.joints if joint.grounded and joint.guide is None and joint.slot is None]
    return _Scene(
        [_moved(body, body["points"]) for body in bodies],
        slots,
        [joint.slot for joint in sketch.joints if joint.slot is not None and joint.guiding_body == GROUND],
        np.array([joint.position for joint in pinned]).reshape(-1, 2),
        gaps,
    )


def _moved(body: Mapping, points: Any) -> np.ndarray:
    """Return points (m) of a body, relative to its centre of mass at the start, at every sample: (n, points, 2)."""
    turn = body["angle"] - body["began"]
    (x, y), c, s = np.asarray(points, float).T, np.cos(turn)[:, None], np.sin(turn)[:, None]
    return np.stack([body["x"][:, None] + c * x - s * y, body["y"][:, None] + s * x + c * y], -1)


def _place(position: np.ndarray, bodies: list[dict], samples: int) -> np.ndarray:
    """Return the place (n, 2) m over time of a joint that is at `position` at the start."""
    for body in bodies:
        points = np.asarray(body["points"], float) + body["center"]
        if np.any(np.hypot(*(points - position).T) < 1e-9):
            return _moved(body, [position - body["center"]])[:, 0]
    return np.tile(position, (samples, 1))


def _frame_indices(study: Study, history: History) -> np.ndarray:
    """Return the drawn samples: evenly over the turn with the largest force, or over the time of a start-up."""
    if history.angle is None or study.is_over_time:
        times = np.linspace(history.time[0], history.time[-1], FRAMES)
        return np.searchsorted(history.time, times).clip(max=len(history.time) - 1)
    force = study.leading_values(history.channels)
    first = np.floor((history.angle[force.argmax()] - history.angle[0]) / (2.0 * np.pi)) * 2.0 * np.pi
    angles = (
        history.angle[0]
        + min(first, max(np.ptp(history.angle) - 2.0 * np.pi, 0.0))
        + np.linspace(0.0, 2.0 * np.pi, FRAMES, endpoint=False)
    )
    return np.searchsorted(history.angle, angles).clip(max=len(history.angle) - 1)


def _corners(scene: _Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower left and the upper right corner (m) of all that moves."""
    parts = [*scene.bodies, *(wall for _, wall in scene.slots), *scene.fixed, scene.pivots]
    points = np.concatenate([part.reshape(-1, 2) for part in parts])
    return points.min(axis=0), points.max(axis=0)


def _gap_radius(scene: _Scene) -> float:
    """Return the radius (m) in the drawing of the circle in which a journal centre moves."""
    low, high = _corners(scene)
    return GAP_SIZE * float(max(high - low))


def _draw(ax: Axes, scene: _Scene, k: int) -> None:
    """Draw a sample."""
    for wall in scene.fixed:
        ax.plot(*wall.T, color=INK, linewidth=1.2)
    for number, wall in scene.slots:
        ax.plot(*wall[k].T, color=BODY_COLOURS[number % len(BODY_COLOURS)], linewidth=1.4)
    for number, points in enumerate(scene.bodies):
        marker: dict[str, Any] = {"marker": "o", "markersize": 4} if points.shape[1] > 1 else BLOCK
        outline = points[k] if points.shape[1] < 3 else np.concatenate([points[k], points[k][:1]])
        ax.plot(*outline.T, color=BODY_COLOURS[number % len(BODY_COLOURS)], linewidth=3.0, **marker)
    ax.plot(*scene.pivots.T, color=GREY, linestyle="", marker="D", markersize=6)
    radius = _gap_radius(scene)
    for gap in scene.gaps:
        colour = RED if gap.force[k] > 0.0 else BLUE
        ax.circle(tuple(gap.place[k]), radius, edgecolor=INK, linewidth=1.0, zorder=5)
        journal = gap.place[k] + radius * gap.offset[k]
        ax.circle(tuple(journal), 0.25 * radius, facecolor=colour, edgecolor=INK, linewidth=0.6, zorder=6)
    low, high = _corners(scene)
    margin = MARGIN * float(max(high - low))
    ax.equal_aspect = True
    ax.set_xlim(low[0] - margin, high[0] + margin)
    ax.set_ylim(low[1] - margin, high[1] + margin)
    ax.hide_edges("top", "right", "bottom", "left")
    ax.set_tick_length(0.0)
    ax.xaxis.formatter = ax.yaxis.formatter = lambda value: ""
