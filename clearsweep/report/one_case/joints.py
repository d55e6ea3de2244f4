"""The mechanism of one case as a picture, the forces in its joints, and their wear."""

import base64
import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from ... import simulation
from ...contracts.case import Case, Rolling, column_name
from ...contracts.case import Joint as CaseJoint
from ...contracts.machine import GROUND
from ...language import wording
from ...language.errors import InputError
from ..blocks.section import FLAT_SIZE, SQUARE_SIZE, Dot, Interactive, Picture
from ..draw import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PALE,
    RED,
    draw_colour_bar,
    label_with_unit,
    set_crank_angle_axis,
    set_plain_axes,
    set_polar_axes,
)
from ..draw.machine import draw_mechanism, picture_height
from ..plot import Axes, ColourScale, multiples_of
from ..study import Joint, Study, joint_of, resolve_cases

# The picture of a mechanism, alone or at the top of a report.

WIDTH, MAX_HEIGHT = 6.4, 4.2  # inches


def mechanism_picture(case: Case) -> Picture | None:
    """Return the picture of the mechanism of a case, or None if it does not consist of bodies in a plane."""
    sketch = simulation.sketch(case)
    if sketch is None:
        return None
    body_names = ", ".join(body.name for body in sketch.bodies if body.name != GROUND)
    open_names = ", ".join(joint.name for joint in sketch.joints if joint.has_clearance) or "none"
    elastic_names = ", ".join(body.name for body in sketch.bodies if body.elastic_ends is not None)
    angle_text = f"{math.degrees(sketch.angle):.6g}°"
    return Picture(
        f"The mechanism at crank angle {angle_text}",
        "Red: joints with clearance.  +: centres of mass." + ("  Zigzag: elastic links." if elastic_names else ""),
        f"Bodies {body_names}; with clearance: {open_names}.{f' Elastic: {elastic_names}.' if elastic_names else ''}",
        lambda ax: draw_mechanism(ax, sketch),
        (WIDTH, min(picture_height(sketch, WIDTH), MAX_HEIGHT)),
    )


# Forces in the joints of one case over time, in the fixed frame: loads for a finite-element model.

PIN_CHANNELS = ("x", "y", "force_normal", "force_tangential")  # channels of a pin in the plane


def joint_forces(case: Case, channels: Mapping, joints: tuple[Joint, ...]) -> dict[str, np.ndarray]:
    """Return `pin_forces` of a case with the forces in its joints without clearance, where they are known."""
    if simulation.reactions_unknown(case):
        return pin_forces(channels, joints)
    reactions = simulation.pin_reactions(simulation.build(case), np.asarray(channels["t"], float))
    forces = pin_forces({name: values[::2] for name, values in reactions.trajectory.channels.items()}, joints)
    for name, force in reactions.forces.items():
        forces[f"{name}/fx [N]"], forces[f"{name}/fy [N]"] = force.T
        if name in reactions.couples:
            forces[f"{name}/couple [N*m]"] = reactions.couples[name]
    return forces | ({"drive/torque [N*m]": reactions.torque} if reactions.forces else {})


def pin_forces(channels: Mapping, joints: tuple[Joint, ...]) -> dict[str, np.ndarray]:
    """Return time (s), crank angle (deg), and the force on the journal of each pin with clearance (N, fixed frame).

    The bearing has the opposite force.  The normal force pushes the journal to the centre of the bearing; the
    tangential one is along the outward normal turned by +90 degrees.
    """
    columns = {"time [s]": np.asarray(channels["t"], float)}
    if "crank_angle" in channels:
        columns["crank_angle [deg]"] = np.degrees(np.asarray(channels["crank_angle"], float))
    pins = [joint for joint in joints if all(f"joints/{joint.name}/{key}" in channels for key in PIN_CHANNELS)]
    if not pins:
        raise InputError(
            "no planar pin joint of this case has clearance, so there are no pin forces to write; "
            "give a pin joint a clearance"
        )
    for joint in pins:
        x, y, normal, tangential = (np.asarray(channels[f"joints/{joint.name}/{key}"], float) for key in PIN_CHANNELS)
        distance = np.hypot(x, y)
        normal_x, normal_y = (
            np.divide(component, distance, np.zeros_like(component), where=distance > 0.0) for component in (x, y)
        )
        columns[f"{joint.name}/fx [N]"] = -normal * normal_x - tangential * normal_y
        columns[f"{joint.name}/fy [N]"] = -normal * normal_y + tangential * normal_x
    return columns


# Wear depths by angular bin.

MAX_SECTORS = 180  # of a circle, at most
BODY_STYLES = (("bearing", BLUE, "-"), ("journal", RED, "--"))  # name, colour, line


def deepest_per_sector(depth: np.ndarray, sectors: int) -> np.ndarray:
    """Return the depths (m) of a body in at most `sectors`: the deepest of adjacent bins."""
    if len(depth) <= sectors:
        return depth
    deepest: np.ndarray = np.maximum.reduceat(depth, np.arange(sectors) * len(depth) // sectors)
    return deepest


def _angles(depth: np.ndarray) -> np.ndarray:
    """Return the centres (rad) of the bins of a body."""
    centres: np.ndarray = (np.arange(len(depth)) + 0.5) * 2.0 * np.pi / len(depth)
    return centres


# The wear of one case: pictures of the depth around each body.

CIRCLE = np.linspace(0.0, 2.0 * np.pi, 73)  # rad, of points on a circle
POLAR_SIZE, SURFACE_SIZE, UNROLLED_SIZE = (3.3, 3.5), (3.5, 3.3), (4.2, 2.9)  # inches
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

    def paint_around(ax: Axes, depth: np.ndarray, colour: str) -> None:
        """Mark the deepest bin of a body, and its mean as a dotted circle."""
        scaled, drawn = depth / scale.factor, deepest_per_sector(depth, MAX_SECTORS) / scale.factor
        set_polar_axes(ax, 1.08 * largest / scale.factor)
        outline = drawn * np.cos(_angles(drawn)), drawn * np.sin(_angles(drawn))
        ax.fill(*outline, facecolor=colour, alpha=0.25, edgecolor=colour, linewidth=1.2)
        ax.plot(scaled.mean() * np.cos(CIRCLE), scaled.mean() * np.sin(CIRCLE), color=INK, linewidth=0.9, linestyle=":")
        deepest = _angles(scaled)[scaled.argmax()]
        mark = scaled.max() * np.cos(deepest), scaled.max() * np.sin(deepest)
        ax.plot(*mark, "o", color=colour, markersize=4.5)
        ax.xaxis.label = f"depth [{scale.unit}]"

    def paint_surfaces(ax: Axes) -> None:
        for depth, (name, colour, dash) in zip(depths, BODY_STYLES, strict=True):
            deepest = deepest_per_sector(depth, MAX_SECTORS)
            x, y = np.degrees(_angles(deepest)), deepest / scale.factor
            ax.plot(x, y, color=colour, linestyle=dash, linewidth=1.2, label=name)
        ax.xaxis.tick_rule = multiples_of(90)
        ax.set_xlim(0.0, 360.0)
        ax.set_labels("angle on the body [°]", f"depth [{scale.unit}]")
        ax.set_ylim(0.0, None)
        set_plain_axes(ax)
        ax.set_legend("above", columns=2)

    pictures = [
        Picture(
            body_name,
            depth_text(depth),
            f"{body_name}: wear depth around it. {depth_text(depth)}",
            partial(paint_around, depth=depth, colour=colour),
            POLAR_SIZE,
        )
        for body_name, depth, (_, colour, _) in zip(names, depths, BODY_STYLES, strict=True)
        if depth.any()
    ]
    text = "Wear depth of bearing and journal against the angle on the body."
    return pictures and [*pictures, Picture("Depth along the surface", "", text, paint_surfaces, SURFACE_SIZE)]


def _maps(study: Study, joint: Joint, case_id: str, depths: Depths) -> list[Picture]:
    """Return the wear depths (bins, length bins) m around and along both bodies of a joint in space, unrolled."""
    (case,) = resolve_cases(study, [case_id])
    case_joint = joint_of(case, joint)

    def paint(ax: Axes, depth: np.ndarray, length: float) -> None:
        scale, length_scale = wording.scale("m", depth.ravel()), wording.scale("m", length)
        edges = np.linspace(-0.5, 0.5, depth.shape[1] + 1) * length / length_scale.factor
        angles = np.linspace(0.0, 360.0, depth.shape[0] + 1)
        max_depth = max(depth.max(initial=0.0), np.finfo(float).tiny)
        colours = ColourScale(0.0, float(max_depth) / scale.factor)
        ax.cells(angles, edges, depth.T / scale.factor, colours)
        ax.set_labels("angle from the body's x axis [°]", f"along the axis [{length_scale.unit}]")
        ax.xaxis.tick_rule = multiples_of(90)
        draw_colour_bar(ax, colours, f"depth [{scale.unit}]")

    return [
        Picture(
            name,
            depth_text(deepest_along_axis(depth)),
            f"{name}: wear depth over angle and length. {depth_text(deepest_along_axis(depth))}",
            partial(paint, depth=np.asarray(depth, float), length=float(length or 0.0)),
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
    most = min(int((study.cases[column] > 0.0).sum()), MAX_CASES // len(study.joints))
    case_indices = study.cases.ordered(column)[1:most]
    if not len(case_indices):
        return None
    label = f"Wear depth around the bodies of joint {joint.title} in a chosen case"
    cases = [_script_data(study, joint, case_id) for case_id in study.cases.index[case_indices]]
    data = {"title": f"Joint {joint.title}, another case: ", "bodies": body_names(study, joint), "cases": cases}
    return Interactive("worn", f"worn-{joint.name}", label, data, "")


def _script_data(study: Study, joint: Joint, case_id: str) -> dict:
    """Return the depths around the bodies of a joint for the page's script: bytes, relative to the deepest."""
    depths = [deepest_along_axis(depth) for depth in study.run.wear(case_id)[joint.name]]
    largest = max(float(depth.max()) for depth in depths)
    scale = largest or 1.0  # arbitrary without wear
    fractions = [deepest_per_sector(depth, SECTORS) / scale for depth in depths]
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


# Loads of the elements of a rolling bearing.

LONGEST_ARROW = 0.9  # of an element's diameter: drawn length of the largest load
RING_THICKNESS = 0.35  # of an element's diameter, of a ring of unknown bore or outside diameter
LOAD_SECTORS = 72  # of the circle, in which loads are collected


class LoadedElements(NamedTuple):
    """The elements of a bearing over the saved samples of a case."""

    angles: np.ndarray  # (samples, elements) rad, in the fixed frame
    loads: np.ndarray  # (samples, elements) N

    @property
    def peak(self) -> int:
        """Return the sample with the largest load of an element."""
        return int(self.loads.max(axis=1).argmax())

    def by_sector(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the largest and the mean load (LOAD_SECTORS,) N of the elements in each sector; nan: none there."""
        sectors = np.floor(np.mod(self.angles, 2.0 * np.pi) / (2.0 * np.pi) * LOAD_SECTORS).astype(int) % LOAD_SECTORS
        counts = np.bincount(sectors.ravel(), minlength=LOAD_SECTORS)
        largest = np.full(LOAD_SECTORS, -np.inf)
        np.maximum.at(largest, sectors.ravel(), self.loads.ravel())
        sums = np.bincount(sectors.ravel(), self.loads.ravel(), LOAD_SECTORS)
        with np.errstate(invalid="ignore"):
            return np.where(counts > 0, largest, np.nan), sums / np.where(counts > 0, counts, np.nan)


def draw_bearing(ax: Axes, bearing: Rolling, angles: np.ndarray, loads: np.ndarray) -> None:
    """Draw the rings and the elements of a bearing at `angles` (Z,) rad, with their `loads` (Z,) N as bars inward."""
    diameter, pitch = 1e3 * bearing.element_diameter, 1e3 * bearing.pitch_diameter
    inner, outer = pitch - diameter, pitch + diameter
    thickness = 2.0 * RING_THICKNESS * diameter
    bore = 1e3 * bearing.bore if bearing.bore else max(inner - thickness, 0.2 * inner)
    outside = 1e3 * bearing.outside_diameter if bearing.outside_diameter else outer + thickness
    for size, face in ((outside, PALE), (outer, "#ffffff"), (inner, PALE), (bore, "#ffffff")):
        ax.circle((0.0, 0.0), 0.5 * size, facecolor=face, edgecolor=GREY, zorder=0.0)
    largest = max(float(loads.max()), np.finfo(float).tiny)
    for angle, load in zip(angles, loads, strict=True):
        direction = np.array([np.cos(angle), np.sin(angle)])
        centre = 0.5 * pitch * direction
        is_loaded = load > 0.0
        face, edge = (BLUE, INK) if is_loaded else ("#ffffff", GREY)
        ax.circle((float(centre[0]), float(centre[1])), 0.5 * diameter, facecolor=face, edgecolor=edge, zorder=1.0)
        if is_loaded:
            ends = np.outer([0.5 * inner, 0.5 * inner - LONGEST_ARROW * diameter * load / largest], direction)
            ax.plot(ends[:, 0], ends[:, 1], color=RED, linewidth=2.6)
    ax.set_square(0.54 * outside)
    ax.set_labels("x [mm]", "y [mm]")
    set_plain_axes(ax)


def draw_load_distribution(ax: Axes, elements: LoadedElements) -> None:
    """Draw the largest and the mean load of the elements over their angle, and the loads at the largest."""
    largest, mean = elements.by_sector()
    scale = wording.scale("N", float(elements.loads.max()))
    angles = (np.arange(LOAD_SECTORS) + 0.5) * 360.0 / LOAD_SECTORS
    ax.plot(angles, largest / scale.factor, color=BLUE, linewidth=1.4, label="largest")
    ax.plot(angles, mean / scale.factor, color=ORANGE, linewidth=1.2, linestyle="--", label="mean")
    at_peak = np.degrees(np.mod(elements.angles[elements.peak], 2.0 * np.pi))
    ax.plot(at_peak, elements.loads[elements.peak] / scale.factor, "o", color=RED, markersize=4.0, label="at the peak")
    ax.xaxis.tick_rule = multiples_of(90)
    ax.set_xlim(0.0, 360.0)
    ax.set_ylim(0.0, None)
    ax.set_labels("angle of the element [°]", label_with_unit("load of an element", scale))
    set_plain_axes(ax)
    ax.set_legend("above", columns=3)


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


# A journal in its bearing in space, from the saved channels of a case.

TALL_SIZE = (4.2, 3.6)  # inches
MAX_DOT_POSITIONS = 240  # places of a dot that moves: a browser goes straight between them
END_COLOURS = (BLUE, RED)  # of the end at +z, at -z
MAX_DRAWN_POSITIONS = 24  # number of drawn positions of the axis
AZIMUTH, ELEVATION = np.radians(-60.0), np.radians(25.0)  # of the view
#: (2, 3): x, y and z of a bearing on the picture, a parallel projection.
VIEW = np.array(
    [
        [-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0],
        [-np.sin(ELEVATION) * np.cos(AZIMUTH), -np.sin(ELEVATION) * np.sin(AZIMUTH), np.cos(ELEVATION)],
    ]
)


def spatial_pictures(
    case: Case, joint: CaseJoint, values: Callable[[str], np.ndarray], angle: np.ndarray
) -> list[Picture]:
    """Return the pictures of a spatial joint; values : channel -> its history in SI; angle : rad, of the crank."""
    ends, clearance = journal_ends(case, joint, values), joint.clearance
    half_lengths = (0.5 * float(joint.journal_length or 0.0), 0.5 * float(joint.length or 0.0))
    tilt, limit = values(f"joints/{joint.column}/tilt"), simulation.jam_angle(joint)
    largest_text, frame_text = f"{np.degrees(tilt.max()):.3g}°", "the frame of the bearing, z along it"
    scale, stride = wording.scale("m", clearance), -(-ends.shape[1] // MAX_DOT_POSITIONS)

    def paint_axis(ax: Axes) -> None:
        """Draw the path of both ends, seen from the side and above; the scale along the bearing fills the picture."""
        size = np.array([clearance, clearance, 0.6 * half_lengths[0] if half_lengths[0] > 0.0 else 1.0])
        circle = clearance * np.stack([np.cos(CIRCLE), np.sin(CIRCLE), np.zeros(CIRCLE.size)], -1)

        def draw_line(points: np.ndarray, colour: str, linewidth: float, zorder: float = 2.0) -> None:
            ax.plot(*(VIEW @ (points / size).T), color=colour, linewidth=linewidth, zorder=zorder)

        draw_line(np.array([[0.0, 0.0, -1.2], [0.0, 0.0, 1.2]]) * half_lengths[1], GREY, 0.8)
        for k in np.linspace(0, ends.shape[1] - 1, min(MAX_DRAWN_POSITIONS, ends.shape[1])).astype(int):
            draw_line(ends[:, k], PALE, 0.6, zorder=0.0)
        for end, colour, sign in zip(ends, END_COLOURS, (1.0, -1.0), strict=True):
            draw_line(circle + np.array([0.0, 0.0, sign * half_lengths[0]]), INK, 0.8)
            draw_line(end, colour, 0.6)
        radius, length = wording.quantity_text(clearance, "m"), wording.quantity_text(2.0 * half_lengths[0], "m")
        ax.set_labels(f"circles: radius {radius}", f"journal: {length} along the bearing")
        for side in (ax.xaxis, ax.yaxis):
            side.set_ticks([])
        ax.equal_aspect = True

    def paint_ends(ax: Axes) -> None:
        radius = clearance / scale.factor
        ax.plot(radius * np.cos(CIRCLE), radius * np.sin(CIRCLE), color=INK, linewidth=1.0)
        for end, colour, name in zip(ends, END_COLOURS, ("end +z", "end -z"), strict=True):
            ax.plot(*(end[:, :2].T / scale.factor), color=colour, linewidth=0.5, alpha=0.6, label=name)
        ax.equal_aspect = True
        ax.set_labels(f"x [{scale.unit}]", f"y [{scale.unit}]")
        ax.set_legend("above", columns=2)

    def paint_tilt(ax: Axes) -> None:
        ax.plot(np.degrees(angle), np.degrees(tilt), color=BLUE, linewidth=0.8)
        if np.isfinite(limit):
            ax.axhline(np.degrees(limit), color=RED, linewidth=1.1, linestyle="--", label="jams")
        ax.yaxis.label = "tilt [°]"
        ax.set_ylim(0.0, None)
        set_crank_angle_axis(ax, angle, has_legend=bool(np.isfinite(limit)))

    dots = (Dot(end[::stride, :2] / scale.factor, colour) for end, colour in zip(ends, END_COLOURS, strict=True))
    return [
        Picture(
            "The journal's axis in its bearing",
            f"Orbits of both ends in {frame_text}; the scale across it is larger. Circles are the radial clearance.",
            f"Orbits of both ends of the journal's axis; it tilts by {largest_text} at most.",
            paint_axis,
            TALL_SIZE,
        ),
        Picture(
            "Both ends along the bearing",
            "Click to play one revolution in 8 s.",
            "Orbits of both ends of the journal's axis, seen along the bearing.",
            paint_ends,
            TALL_SIZE,
            dots=tuple(dots),
        ),
        Picture(
            "Tilt",
            "Angle between the axes of bearing and journal.",
            f"Tilt against crank angle, at most {largest_text}.",
            paint_tilt,
            FLAT_SIZE,
        ),
    ]


def journal_ends(case: Case, joint: CaseJoint, values: Callable[[str], np.ndarray]) -> np.ndarray:
    """Return the positions (2, n, 3) m of both ends of the journal's axis in the frame of the bearing, z along it."""
    mechanism = simulation.mechanism_of(case)
    site = mechanism.site(joint.name)
    journal_body, bearing = site.journals
    bearing_frames, journal_frames = _frames(values, bearing), _frames(values, journal_body)
    # Rotation matrix of a rotation vector about x and y, by Rodrigues' formula
    a, b = joint.tilt
    angle = float(np.hypot(a, b))
    cross_product = np.array([[0.0, 0.0, b], [0.0, 0.0, -a], [-b, a, 0.0]])
    sine_term, cosine_term = (np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2) if angle else (1.0, 0.5)
    matrix: np.ndarray = np.eye(3) + sine_term * cross_product + cosine_term * (cross_product @ cross_product)
    rotation = bearing_frames @ matrix
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
