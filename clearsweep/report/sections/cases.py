"""Cases on the page: those that are played or drawn, with the data of the player, and the table of all."""

from collections.abc import Iterable, Mapping

import numpy as np
from markupsafe import Markup

from ... import simulation
from ...answers.verdict import MARGIN_COLUMN
from ...contracts.layout import JointLayout
from ...contracts.machine import GROUND
from ...language import wording
from ...searches import SENSES
from ..axis import Axis
from ..blocks.section import Block, Detail, Interactive, Note, Section, capitalise, encode_floats
from ..blocks.table import columns_in_table
from ..draw.comparison import needs_log_scale
from ..one_case.joints import loaded_elements
from ..one_case.motion import (
    ORBIT_CHANNELS,
    SPEED,
    History,
    bending_links,
    has_straight_walls,
    history_of,
    joint_histories,
    motion_pictures,
    onset_pictures,
    saved_channels,
)
from ..study import P99_OVER_IDEAL, Joint, Study, case_ranking_of, joint_of, known, resolve_cases, worst_case

# Data of the player of a page, which shows one case in motion.

#: Of the largest value of a curve: smaller values, such as a torque at a dead centre, are rounding.
RELATIVE_ROUNDING = 1e-12
MAX_SAMPLES = 3000  # samples: longer histories are cut to those around the largest force
DRAWN_DEFLECTION = 0.06  # of the length of a link: its largest deflection as drawn
DRAWN_HOUSING = 0.04  # of the size of a mechanism: the largest motion of a housing as drawn
DRAWN_PENETRATION = 0.25  # of the clearance: drawn height of the deepest penetration
NO_SCRIPTS = "The animation needs scripts. clearsweep show DIR CASE draws the motion without scripts."


def player_data(study: Study, case_id: str, channels: Mapping) -> Interactive | None:
    """Return the data of a case for the player, or None without rotation, picture or complete channels."""
    if not all(f"joints/{joint.name}/{name}" in channels for joint in study.joints for name in ORBIT_CHANNELS):
        return None
    history, sketch = history_of(study, case_id, channels), load_sketch(study, case_id)
    bodies = moving_bodies(sketch, channels) if sketch else []
    if history.angle is None or sketch is None or not bodies:
        return None
    samples = _shown_samples(study, channels)
    data = {
        "time": encode_floats(history.time[samples]) if study.is_over_time else None,
        "angle": encode_floats(np.degrees(history.angle[samples])),
        "bodies": [_shown_body(body, samples) for body in bodies],
        "ground": [
            _support(joint, channels, samples, sketch)
            for joint in sketch.joints
            if joint.grounded and joint.guide is None and joint.slot is None
        ],
        "walls": [
            joint.slot.tolist() for joint in sketch.joints if joint.slot is not None and joint.guiding_body == GROUND
        ],
        "joints": _joints(study, case_id, channels, samples, sketch),
        "charts": _charts(study, case_id, history, samples),
    }
    return Interactive("player", f"motion-of-{case_id}", f"Case {case_id} in motion", data, NO_SCRIPTS)


def _support(joint: simulation.SketchedJoint, channels: Mapping, samples: slice, sketch: simulation.Sketch) -> dict:
    """Return a joint at the ground for the player; if its housing yields, with its motion and the factor on that."""
    paths = [f"joints/{joint.name.replace('-', '_')}/mount_{axis}" for axis in "xy"]
    if not all(path in channels for path in paths):
        return {"place": joint.position.tolist()}
    x, y = (np.asarray(channels[path], float)[samples] for path in paths)
    size = float(np.ptp(np.concatenate([body.points for body in sketch.bodies]), axis=0).max())
    magnified = _magnification(DRAWN_HOUSING * size, float(np.hypot(x, y).max()))
    return {
        "name": joint.name,
        "place": joint.position.tolist(),
        "x": encode_floats(x),
        "y": encode_floats(y),
        "magnified": magnified,
    }


def _magnification(drawn: float, largest: float) -> float:
    """Return the factor, of one digit and at least 1, that draws the `largest` of some lengths as `drawn`."""
    return float(f"{max(drawn / largest, 1.0):.1g}") if largest > 0.0 else 1.0


def _shown_body(body: dict, samples: slice) -> dict:
    """Return a body for the player: the shown samples of its motion."""
    shown = {key: encode_floats(body[key][samples]) for key in ("x", "y", "angle")}
    if body["bend"]:
        shown["bend"] = body["bend"] | {"deflection": encode_floats(body["bend"]["deflection"][samples])}
    return {key: body[key] for key in ("began", "points", "walls")} | shown


def _shown_samples(study: Study, channels: Mapping) -> slice:
    """Return the slice of displayed samples: those around the largest force, or every n-th of a whole start-up."""
    force = study.leading_values(channels)
    if len(force) <= MAX_SAMPLES:
        return slice(None)
    if study.is_over_time:
        return slice(0, None, -(-len(force) // MAX_SAMPLES))
    start = min(max(int(force.argmax()) - MAX_SAMPLES // 2, 0), len(force) - MAX_SAMPLES)
    return slice(start, start + MAX_SAMPLES)


def load_sketch(study: Study, case_id: str) -> simulation.Sketch | None:
    """Return the mechanism of a case at its start, or None if it has no picture or is from another version."""
    return known(lambda: simulation.sketch(resolve_cases(study, [case_id])[0]))


def moving_bodies(sketch: simulation.Sketch, channels: Mapping) -> list[dict]:
    """Return the moving bodies over time, or [] if a body has no channels.

    Each has its points, and the walls of its slots and its pitch circles, relative to the centre of mass at the start,
    and its position and angle over time.
    """
    bodies = []
    for body in sketch.bodies:
        name = body.name.replace("-", "_")
        if body.name == GROUND:
            continue
        if not {f"{name}/x", f"{name}/y"} <= set(channels):
            return []
        walls = [
            (joint.slot - body.center).tolist()
            for joint in sketch.joints
            if joint.slot is not None and joint.guiding_body == body.name
        ]
        walls += [(rim - body.center).tolist() for rim in body.rims]
        x, y = (np.asarray(channels[f"{name}/{key}"], float) for key in ("x", "y"))
        angle = np.asarray(channels.get(f"{name}/angle", np.full(len(x), body.angle)), float)
        bend = None
        if body.elastic_ends is not None and name in bending_links(channels):
            deflection = np.asarray(channels[f"{name}/deflection"], float)
            # How a link that bends is drawn: its ends from the centre of mass, deflection, and factor on that
            chord, ends = np.diff(body.elastic_ends, axis=0)[0], (body.elastic_ends - body.center).tolist()
            magnified = _magnification(DRAWN_DEFLECTION * float(np.hypot(*chord)), float(np.abs(deflection).max()))
            bend = {"name": body.name, "ends": ends, "deflection": deflection, "magnified": magnified}
            direction = np.arctan2(chord[1], chord[0]) + angle - body.angle
            mean = 2.0 / np.pi * deflection  # of the first mode: the centre of mass without it is on the chord
            x, y = x + mean * np.sin(direction), y - mean * np.cos(direction)
        points = (body.points - body.center).tolist()
        fixed = {"bend": bend, "began": body.angle, "center": body.center, "points": points, "walls": walls}
        bodies.append(fixed | {"x": x, "y": y, "angle": angle})
    return bodies


def _joints(study: Study, case_id: str, channels: Mapping, samples: slice, sketch: simulation.Sketch) -> list[dict]:
    """Return the joints over time: position and force of the journal or block, clearance, and the walls if straight."""
    joints = []
    for joint in study.joints:
        x, y, force = (
            np.asarray(channels[f"joints/{joint.name}/{key}"], float)[samples] for key in ("x", "y", "force_normal")
        )
        clearance = study.radial_clearance(case_id, joint)
        elements = _elements(study, case_id, joint, channels, samples)
        if clearance is None and elements is None:
            continue
        clearance, distance, walls = clearance or 0.0, np.hypot(x, y), None
        if has_straight_walls(study, joint):
            half_length, tilt = _block(study, case_id, joint, sketch, channels)
            distance = abs(y) + half_length * abs(np.sin(tilt[samples]))
            walls = {"half_length": half_length, "tilt": encode_floats(tilt[samples])}
        deepest = max(float(distance.max()) - float(clearance), 0.0)
        force_scale = wording.scale("N", force)
        joints.append(
            {
                "name": joint.title,
                "clearance": float(clearance),
                "said": wording.quantity_text(float(clearance), "m"),
                "magnified": _magnification(DRAWN_PENETRATION * float(clearance), deepest),
                "x": encode_floats(x),
                "y": encode_floats(y),
                "walls": walls,
                "elements": elements,
                "force": encode_floats(force / force_scale.factor),
                "most": float(force.max() / force_scale.factor),
                "unit": force_scale.unit,
            }
        )
    return joints


def _elements(study: Study, case_id: str, joint: Joint, channels: Mapping, samples: slice) -> dict | None:
    """Return the elements of a rolling bearing over time: loads over the largest, angle of the first; None without."""
    elements = loaded_elements(joint, channels) if joint.layout.is_rolling else None
    bearing = joint_of(resolve_cases(study, [case_id])[0], joint).rolling if elements else None
    if elements is None or bearing is None:
        return None
    loads = elements.loads[samples].T / max(float(elements.loads.max()), np.finfo(float).tiny)
    return {
        "angle": encode_floats(elements.angles[samples, 0]),
        "loads": [encode_floats(load) for load in loads],
        "share": bearing.element_diameter / bearing.pitch_diameter,
    }


def _block(
    study: Study, case_id: str, joint: Joint, sketch: simulation.Sketch, channels: Mapping
) -> tuple[float, np.ndarray]:
    """Return half the length (m) of a guide's block and its tilt (rad) between the walls; zeros for a pin in a slot."""
    sketched_joint = next(sketched for sketched in sketch.joints if sketched.name == joint.title)
    tilt = np.zeros(len(channels[f"joints/{joint.name}/y"]))
    if sketched_joint.guide is None:
        return 0.0, tilt
    start = {body.name: body.angle for body in sketch.bodies}
    for body, sign in ((sketched_joint.sliding_body, 1.0), (sketched_joint.guiding_body, -1.0)):
        channel = f"{body.replace('-', '_')}/angle"
        if channel in channels:
            tilt += sign * (np.asarray(channels[channel], float) - start[body])
    return 0.5 * float(study.value(case_id, f"joints.{joint.title}.length") or 0.0), tilt


def _zero_rounding_errors(values: np.ndarray) -> np.ndarray:
    """Return values; those within the rounding error of the largest are set to 0."""
    clean: np.ndarray = np.where(
        np.abs(values) < RELATIVE_ROUNDING * np.nanmax(np.abs(values), initial=0.0), 0.0, values
    )
    return clean


def _charts(study: Study, case_id: str, history: History, samples: slice) -> list[dict]:
    charts = []
    for curve in joint_histories(study, case_id, history):
        scale = wording.scale(curve.unit, curve.actual[samples], speed=curve.name == SPEED)
        curves = [("with clearance", _zero_rounding_errors(curve.actual), "accent", False)]
        if curve.ideal is not None:
            curves.append(("ideal", _zero_rounding_errors(curve.ideal), "mark", True))
        lines = [
            {"name": name, "values": encode_floats(values[samples] / scale.factor), "colour": colour, "dashed": dashed}
            for name, values, colour, dashed in curves
        ]
        charts.append({"name": curve.name, "unit": scale.unit, "lines": lines})
    return charts


# Cases on the page: those that are played or drawn, and the table of all.

# The motion of the worst case for the question of the grid, and of the cases that represent the leading figure.
#
# Pictures do not repeat the content of a player.

MECHANISM_ONLY = Joint("-", "", JointLayout("-"))  # figures of the mechanism alone
FIRST = ("joint", "peak", "load / ideal", " error", "film", "life")  # ends of the names of figures of the first screen
SHOWN_PEAK = 0.9  # of the force peak: curves that reach it show the peak
NOT_SAVED = Markup(
    "No time histories were saved (<code>save: {{orbits: none}}</code>). <code>clearsweep show {} {}</code> "
    "shows this case in motion."
)


def case_sections(study: Study) -> list[Section]:
    """Return the worst case in motion, or how to draw it; [] without a finished case, and for `identify`."""
    if study.cases.empty or case_ranking_of(study).question == "identify":
        return []
    worst = worst_case(study)
    worst_ids = [worst[0]] if worst else []
    title, is_best = case_ranking_of(study).title, case_ranking_of(study).question == "optimise"
    label = f"Worst case: {title[:1].lower()}{title[1:]}" if title else "Worst case"
    label = "Best case" if is_best else label if len(study.cases) > 1 else "The case"
    shown_id = next(iter([*worst_ids, *_representative_case_ids(study)]), None)
    blocks: list[Block] = []
    if shown_id is not None:
        shown = _details(study, [shown_id], {}, label)
        if not shown:  # without time histories: its figures, and the command that draws it
            remark = NOT_SAVED.format(study.run.directory, wording.short_id(shown_id))
            figures = _summary_values(study, shown_id)
            shown = [Detail(label, shown_id, study.setting(shown_id), figures, [], note=remark)]
        blocks += [
            detail._replace(figures=[pair for pair in detail.figures if pair[0].endswith(FIRST)]) for detail in shown
        ]
    heading = f"The {'best' if is_best else 'worst'} case" if len(study.cases) > 1 else "The motion"
    return [Section("cases", heading, blocks)]


def other_cases_sections(study: Study) -> list[Section]:
    """Return the cases with the largest, the median and the smallest leading figure, except the worst case."""
    if study.cases.empty:
        return []
    worst_id, ranked_ids = worst_case(study), _representative_case_ids(study)
    shown_id = worst_id[0] if worst_id else next(iter(ranked_ids), None)
    shown_id = None if case_ranking_of(study).question == "identify" else shown_id
    rank_words = ("largest", "smallest") if len(ranked_ids) == 2 else ("largest", "median", "smallest")
    name = capitalise(study.lead.name)
    labels = {
        case_id: f"{name}, the {rank_word} of all cases"
        for case_id, rank_word in zip(ranked_ids, rank_words, strict=False)
    }
    other_ids = [case_id for case_id in ranked_ids if case_id != shown_id]
    return [Section("other-cases", "Other cases in motion", [*_details(study, other_ids, labels, "")])]


def _representative_case_ids(study: Study) -> tuple[str, ...]:
    """Return the cases with the largest, the median and the smallest leading figure of the most loaded joint."""
    return study.cases.representative_cases(study.most_loaded_joint().column(study.lead.figure))


def _details(study: Study, case_ids: Iterable[str], labels: dict[str, str], default_label: str) -> list[Detail]:
    """Return the cases with saved time histories in motion, each with its label."""
    details = []
    for case_id in case_ids:
        channels = saved_channels(study.run, case_id)
        if channels is None:
            continue
        pictures = motion_pictures(study, case_id, channels)
        pictures += onset_pictures(study, case_id, study.run.event_columns(case_id), channels)
        animation = player_data(study, case_id, channels)
        of_player = tuple(picture for picture in pictures if picture.shown_in_player and animation)
        still = [picture for picture in pictures if not (picture.shown_in_player and animation)]
        label, figures = labels.get(case_id, default_label), _summary_values(study, case_id)
        detail = Detail(label, case_id, study.setting(case_id), figures, still, animation, player_pictures=of_player)
        details.append(detail._replace(note=peak_note(study, case_id, channels)))
    return details


def peak_note(study: Study, case_id: str, channels: Mapping) -> str:
    """Return a remark if the curves of a case do not contain the force peak of a joint, or ''."""
    for joint in study.joints:
        column, force = joint.column("force_peak"), channels.get(f"joints/{joint.name}/force_normal", ())
        if len(force) and np.max(force) < SHOWN_PEAK * study.cases.at(case_id, column):
            reached = wording.quantity_text(float(np.max(force)), study.unit(column))
            advice = (
                "" if "worst" in study.run.grid.get("save", {}) else " With save.worst a run stores its revolution."
            )
            return (
                f"The curves do not contain the force peak{study.joint_text(joint, ' of joint {}')}, "
                f"{study.text(case_id, column)}: they reach {reached}. They show the saved revolutions, and an "
                f"impact can lie between two samples.{advice}"
            )
    return ""


def _summary_values(study: Study, case_id: str) -> list[tuple[str, str]]:
    """Return name and value with unit of the figures of a case; if there are several joints, each is named."""
    mechanism_columns = {name for name, _ in columns_in_table(study, "case", MECHANISM_ONLY)}
    figures: list[tuple[str, str]] = []
    for joint in study.joints:
        figures += [("joint", joint.title)] if len(study.joints) > 1 else []
        columns = [entry for entry in columns_in_table(study, "case", joint) if entry[0] not in mechanism_columns]
        figures += [(name, study.text(case_id, column)) for column, name in columns]
    return figures + [
        (name, study.text(case_id, column)) for column, name in columns_in_table(study, "case", MECHANISM_ONLY)
    ]


# Table of all cases, which can be sorted, filtered and compared on the page.

MAX_CASES = 4_400  # cases: a page stays below 3 MB
LEADING_ROWS = 8  # of the table where it is seen at once
MAX_FIGURES_SHOWN = 5  # figures displayed at first, besides the swept values
TABLES = ("forces", "wear", "output", "certainty")  # tables whose figures are available


def leading_explorer_sections(study: Study) -> list[Section]:
    """Return the section of an optimised run, whose best cases are marked, or [] for other runs."""
    return _sections(study, "Cases that were tried") if _objectives(study) else []


def explorer_sections(study: Study) -> list[Section]:
    """Return the section; [] for runs with one case, or if it comes first."""
    return [] if _objectives(study) else _sections(study, "Explore")


def _sections(study: Study, title: str) -> list[Section]:
    if len(study.cases) < 2:
        return []
    case_indices = _displayed_cases(study)
    blocks: list[Block] = []
    if len(case_indices) < len(study.cases):
        blocks.append(
            Note(f"{len(case_indices)} of {len(study.cases)} cases: the worst ones, and others chosen at random.")
        )
    columns = [_axis_column(study, axis, case_indices) for axis in study.swept()]
    columns += _figure_columns(study, case_indices)
    data = {"ids": "".join(study.cases.index[case_indices]), "show": "clearsweep show DIR CASE", "columns": columns}
    if _objectives(study):
        data |= _marks_data(study, case_indices, columns)
    fallback_text = (
        "The tables below contain the same figures. Sorting, filtering and comparing them here needs scripts."
    )
    blocks.append(Interactive("explorer", "all-cases", "All cases, to sort, filter and compare", data, fallback_text))
    return [Section("explore", title, blocks)]


def _objectives(study: Study) -> list[str]:
    """Return the objectives of an optimised run, or [] for other runs."""
    section = study.run.grid.get("optimise") or {}
    return [name for sense in SENSES for name in section.get(sense, []) if study.has(name)]


def _is_best(study: Study) -> np.ndarray:
    """Return the best cases of an optimised run."""
    rows = study.run.optimise if _objectives(study) else None
    is_best: np.ndarray = np.isin(study.cases.index, [] if rows is None else rows["case_id"].tolist())
    return is_best


def _marks_data(study: Study, case_indices: np.ndarray, columns: list[dict]) -> dict:
    """Return the marked cases of an optimised run, and the columns that its points show first.

    With several objectives these are the first two, else the first swept value and the objective.
    """
    swept_columns = [index for index, column in enumerate(columns) if column.get("axis")]
    objective_columns = [index for index, column in enumerate(columns) if column.get("objective")]
    x_column, y_column, *_ = (
        (objective_columns + swept_columns)
        if len(objective_columns) > 1
        else (swept_columns + objective_columns)[:1] + objective_columns
    )
    return {
        "marked": np.flatnonzero(_is_best(study)[case_indices]).tolist(),
        "note": "The best cases are marked.",
        "points": [x_column, y_column, swept_columns[0] if len(objective_columns) > 1 else swept_columns[-1]],
        "rows": LEADING_ROWS,
    }


def _displayed_cases(study: Study) -> np.ndarray:
    """Return the indices of the displayed cases, ascending; ids are hashes, so the first ones are random."""
    if len(study.cases) <= MAX_CASES:
        return np.arange(len(study.cases))
    if _objectives(study):
        return np.union1d(np.flatnonzero(_is_best(study))[: MAX_CASES // 2], np.arange(MAX_CASES // 2))
    lead = study.cases[study.most_loaded_joint().column(study.lead.figure)]
    hardest = np.argsort(lead if study.lead.smallest else -lead, kind="stable")[: MAX_CASES // 2]
    return np.union1d(hardest, np.arange(MAX_CASES // 2))


def _axis_column(study: Study, axis: Axis, case_indices: np.ndarray) -> dict:
    values = study.cases[axis.path][case_indices]
    column = {"name": axis.name, "unit": axis.scale.unit, "axis": True, "drawn": True}
    if axis.is_numeric:
        return column | _encoded_numbers(axis.scale.from_si(values))
    index_of_value = {value: index for index, value in enumerate(axis.values)}
    return column | {
        "words": list(axis.values),
        "values": encode_floats([index_of_value.get(value, np.nan) for value in values]),
    }


def _figure_columns(study: Study, case_indices: np.ndarray) -> list[dict]:
    """Return the figures of all joints and of the mechanism, each once; objectives of an optimised run come first."""
    objectives = _objectives(study)
    headings = {name: name for name in objectives + [MARGIN_COLUMN] * bool(objectives)}  # as the grid has them
    objective_count = len(headings)
    for table in TABLES:
        for name, heading in columns_in_table(study, table):
            headings.setdefault(name, heading)
    lead_column = objectives[0] if objectives else study.most_loaded_joint().column(study.lead.figure)
    names = [name for name in headings if study.has(name)]
    if not objectives:
        names.sort(key=lambda name: name != lead_column)
    drawn_names = {*names[:MAX_FIGURES_SHOWN], *(joint.column(P99_OVER_IDEAL) for joint in study.joints[:1])}
    drawn_names = {*list(headings)[:objective_count]} or drawn_names
    minimised = (study.run.grid.get("optimise") or {}).get(SENSES[0], [])
    columns = []
    for name in names:
        scale = study.scale(name)
        column = {"name": headings[name], "unit": scale.unit, "drawn": name in drawn_names, "lead": name == lead_column}
        column |= {"objective": True, "rising": name in minimised} if name in objectives else {}
        columns.append(column | _encoded_numbers(study.cases[name][case_indices] / scale.factor))
    return columns


def _encoded_numbers(values: np.ndarray) -> dict:
    return {"values": encode_floats(values), "wide": needs_log_scale(values)}
