"""Pages: the report as one self-contained HTML file with its tables and pictures as files; one case, also in motion."""

import contextlib
import io
import itertools
import multiprocessing
import os
import re
import signal
import sys
import time
from collections.abc import Iterator, Mapping
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
import numpy as np
from markupsafe import Markup, escape

from ... import grid, simulation, store
from ...contracts.case import Case
from ...contracts.machine import GROUND
from ...contracts.results import Trajectory
from ...language import phases, wording
from ...language.errors import ClearsweepError, InputError
from ...store import StoredRun, durable
from ...tracing import cache
from .. import sections
from ..blocks.section import Picture, Section, draw_svg, page_script, safe_json, style_sheets
from ..draw import BLUE, GREY, INK, RED
from ..draw.machine import BODY_COLOURS
from ..one_case import joints
from ..one_case.joints import joint_forces, mechanism_picture
from ..one_case.motion import History, has_straight_walls, history_of, motion_pictures, onset_pictures
from ..plot import Axes
from ..sections.cases import load_sketch, moving_bodies
from ..sections.identified import compare_signals, overlay_section
from ..study import Study, open_partial, prepare, resolve_cases
from .paper import FigureOptions, drawing_bytes, panels_svg, write_figures

# The report: one self-contained HTML file; its tables and pictures as files.


class Page(NamedTuple):
    """A page before writing: its name, its kind, the varying axes, its sections."""

    name: str
    subtitle: str
    axes_verb: str
    axes: list[str]
    sections: list[Section]

    def write(self, out: Path) -> Path:
        """Write the page as one self-contained HTML file; the bytes depend only on the run."""
        durable.check_output(out)  # before the work
        with phases.phase("drawing the report"):
            return write_page(self.text(), out)

    def text(self) -> str:
        """Return the page as HTML."""
        subjects = dict.fromkeys(section.subject for section in self.sections if section.subject)
        return render(
            "page.html.j2",
            name=self.name,
            kind=self.subtitle,
            varied=self.axes_verb,
            axes=self.axes,
            sections=[section for section in self.sections if not section.subject],
            more=[(name, [each for each in self.sections if each.subject == name]) for name in subjects],
            picture_count=sum(len(section.pictures) for section in self.sections),
            script=page_script() if any(section.has_scripts for section in self.sections) else None,
            script_style=style_sheets(),
        )

    def write_tables(self, directory: Path) -> list[Path]:
        """Write the tables of every section into a directory; return the files.

        Each table is written as CSV, in SI with units in the header, and as Markdown, as shown on the page.
        """
        directory.mkdir(parents=True, exist_ok=True)
        return [file for section in self.sections for table in section.tables for file in table.write(directory)]

    def write_figures(self, options: FigureOptions) -> list[Path]:
        """Write the pictures of every section, each under its name, and a list of them; return the files."""
        with phases.phase("drawing the figures"):
            return write_figures(self.sections, options)

    def write_all(self, out: Path, tables: Path | None, options: FigureOptions | None) -> dict[str, Any]:
        """Write the page, its tables and its figures; return their paths under `report`, `tables` and `figures`."""
        files: dict[str, Any] = {"report": str(self.write(out))}
        if tables:
            self.write_tables(tables)
            files["tables"] = str(tables)
        if options:
            files["figures"] = [str(file) for file in self.write_figures(options)]
        return files


def page_of(study: Study, measured: str | PathLike | None = None) -> Page:
    """Return the page of a run; the signals in a file `measured` are compared with the computed ones."""
    comparison = [overlay_section(study, compare_signals(study, measured))] if measured else []
    record = study.run.grid
    return Page(
        name=record.get("name") or "clearsweep run",
        subtitle=f"{study.mechanism} with joint clearance" if study.is_driven else study.mechanism,
        axes_verb="Varied" if record.get("sample") else "Swept",
        axes=[
            f"{name} {values}{joints}"
            for name, joints, values in wording.of_joints((axis.name, axis.values_text()) for axis in study.swept())
        ],
        sections=[*comparison, *sections.all_sections(study)],
    )


def render(template: str, *, picture_count: int = 0, **content: object) -> str:
    """Return a template of this package filled with content; text is escaped, `picture_count` pictures are drawn."""
    numbers = itertools.count(1)  # so that ids in different SVGs are distinct

    def drawing(picture: Picture) -> Markup:
        number = next(numbers)
        if picture_count and (phase := phases.innermost_phase()):
            phase.note(share=(number - 1) / picture_count)
        return Markup(draw_svg(picture, f"f{number}"))

    compiled = cache.prepare_cache() / "pages"
    compiled.mkdir(mode=0o700, exist_ok=True)
    environment = jinja2.Environment(
        bytecode_cache=jinja2.FileSystemBytecodeCache(str(compiled)),
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {
        "drawing": drawing,
        "form": lambda block: type(block).__name__.lower(),  # the macro of a block
        "json": safe_json,
        "short_id": wording.short_id,
        "with_code": with_code,
        "is_words": is_words,
    }
    return environment.get_template(template).render(content)


def is_words(text: str) -> bool:
    """Return whether a card shows words, not a number; words are smaller, so that they fit."""
    return not any(character.isdigit() for character in text)


def with_code(text: str) -> Markup:
    """Return a sentence as HTML in which `words` between backquotes are code."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text))))


def write_page(text: str, out: Path) -> Path:
    """Write a page atomically; return its path."""
    out.parent.mkdir(parents=True, exist_ok=True)
    durable.replace_output(out, text.encode())
    return out


# One case, simulated again and drawn: orbit, force, output, drive, contact onsets and wear; its pin forces as CSV.

MIN_SAMPLES = 1440  # per revolution at least, so that single contacts show
PANEL_SIZE, PANEL_DOTS = (5.2, 3.2), 150  # of a PNG or SVG; inches; dots per inch
MECHANISM_ENDINGS = (".svg", ".png")
MARK = "drawn by clearsweep"  # recognised by `durable.check_output`
ENDINGS = (".html", ".png", ".svg", ".csv", ".gif", ".webp")


def show(run: StoredRun, case_id: str, out: Path) -> Path:
    """Simulate a case of a run again and draw it, as HTML, PNG or SVG by the ending of `out`; return `out`.

    As GIF or WebP the file shows the mechanism in motion.  As CSV the file has the forces in the joints over time.
    """
    if out.suffix.lower() not in ENDINGS:
        raise InputError(f"{out}: cannot write a file that ends in {out.suffix!r}; use one of {', '.join(ENDINGS)}")
    if out.suffix.lower() != ".csv":
        durable.check_output(out)  # before the work
    with phases.phase("reading the run"):
        study = prepare(run)
    if max(study.cases.row_of(case_id), study.failed.row_of(case_id)) < 0:
        raise InputError(f"no case {case_id!r} in this run; the column case_id of summary.parquet lists them")
    with phases.phase(f"simulating case {wording.short_id(case_id)}"):
        case = case_to_draw(study, case_id)
        result = simulation.solve(case)
    if len(result.channels.get("t", ())) < 2:
        raise InputError(f"case {case_id}: nothing to draw, the case ended with {result.status!r}: {result.message}")
    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix.lower() == ".csv":
        with phases.phase("forces in the joints"):
            forces = joint_forces(case, result.channels, study.joints)
        rows = zip(*(values.tolist() for values in forces.values()), strict=True)
        content = "".join(f"{','.join(cells)}\n" for cells in (forces, *(map(repr, row) for row in rows))).encode()
        durable.replace_output(out, content, content.partition(b"\n")[0])
        return out
    if out.suffix.lower() in ANIMATIONS:
        with phases.phase("drawing the motion"):
            durable.replace_output(out, animation_bytes(study, case_id, result.channels, out.suffix.lower()))
        return out
    pictures = case_pictures(study, case_id, result)
    with phases.phase("drawing"):
        if out.suffix.lower() == ".html":
            figures = [(name, wording.quantity_text(value, study.unit(name))) for name, value in result.summary.items()]
            shown: dict[str, Any] = {"title": _title(study, case_id), "setting": study.setting(case_id)}
            shown |= {"pictures": pictures, "status": result.status, "message": result.message, "rows": figures}
            return write_page(render("case.html.j2", **shown), out)
        title = f"{_title(study, case_id)}\n{study.setting(case_id)}".strip()
        svg = panels_svg([picture._replace(size=PANEL_SIZE) for picture in pictures], title)
        durable.replace_output(out, drawing_bytes(svg, out.suffix[1:].lower(), dots_per_inch=PANEL_DOTS))
        return out


def case_to_draw(study: Study, case_id: str) -> Case:
    """Return a case of a run in SI, set to save its history with a fine sampling."""
    case = resolve_cases(study, [case_id])[0]
    orbits = "last" if case.save.orbits == "none" else case.save.orbits
    if study.is_start_up:
        orbits = "all"
    return case._replace(save=case.save._replace(orbits=orbits, samples=max(case.save.samples, MIN_SAMPLES)))


def case_pictures(study: Study, case_id: str, result: Trajectory) -> list[Picture]:
    """Return the pictures of a simulated case with a history."""
    channels = result.channels
    pictures = motion_pictures(study, case_id, channels) + onset_pictures(study, case_id, result.events, channels)
    for joint in study.joints:
        if joint.name in result.wear:
            suffix = study.joint_text(joint, ", joint {}")
            wear_pictures = joints.wear_pictures(study, joint, case_id, result.wear[joint.name])
            pictures += [picture._replace(title=picture.title + suffix) for picture in wear_pictures]
    return pictures


def _title(study: Study, case_id: str) -> str:
    return f"{study.run.grid.get('name') or 'case'}, case {wording.short_id(case_id)}"


def draw_grid(source: Path, out: Path) -> Path:
    """Draw the mechanism of the first case of a grid as SVG or PNG by the ending of `out`; return `out`."""
    if out.suffix.lower() not in MECHANISM_ENDINGS:
        known = ", ".join(MECHANISM_ENDINGS)
        raise InputError(f"{out}: cannot draw a file that ends in {out.suffix!r}; use one of {known}")
    durable.check_output(out)
    picture = mechanism_picture(grid.load(source, simulation.catalogue()).case(0))
    if picture is None:
        raise InputError(f"{source}: a mechanism of this type has no picture; run it and see the report")
    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix.lower() == ".svg":
        content = f"<!-- {MARK} -->{draw_svg(picture, 'm')}".encode()
    else:
        content = drawing_bytes(panels_svg([picture]), "png", dots_per_inch=PANEL_DOTS)
    durable.replace_output(out, content)
    return out


INTERVAL = 5.0  # s between two pages at least, and between two loads by a browser
COST_SHARE = 0.2  # largest share of a core for drawing pages
NICENESS = 10  # cases have priority
REFRESH = f'<meta http-equiv="refresh" content="{INTERVAL:g}">\n'


@contextlib.contextmanager
def live_page(directory: Path, out: Path, system: str) -> Iterator[None]:
    """Rewrite the page of the finished cases of a run in `directory` for as long as this context lasts.

    The page is `out`; each is written atomically and makes the browser load the next one.  The last one no longer
    does.  system : unit system of its quantities
    """
    durable.check_output(out)
    context = multiprocessing.get_context("spawn")
    drawer = context.Process(target=_draw_pages, args=(directory, out, system, os.getpid()), daemon=True)
    drawer.start()
    try:
        yield
    finally:
        drawer.terminate()
        drawer.join()
        durable.remove_temporaries(out.parent)
        with contextlib.suppress(OSError, ClearsweepError):  # a stopped run leaves its last page, which stays as it is
            if REFRESH in (text := durable.read(out).decode()):
                write_page(text.replace(REFRESH, ""), out)


def _draw_pages(directory: Path, out: Path, system: str, parent: int) -> None:
    """Write pages until the parent process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal; the parent ends this process
    os.nice(NICENESS)
    sys.stderr = open(os.devnull, "w")  # noqa: SIM115 - until the process ends
    drawn: list[int] | None = None
    while os.getppid() == parent:
        begin = time.process_time()
        with contextlib.suppress(Exception), wording.unit_system(system):  # the run continues without its page
            drawn = draw_page(directory, out, drawn)
        time.sleep(max(INTERVAL, (time.process_time() - begin) * (1.0 / COST_SHARE - 1.0)))


def draw_page(directory: Path, out: Path, drawn: list[int] | None) -> list[int] | None:
    """Write the page of the finished cases, if there are others than those `drawn`; return their numbers."""
    state = store.status(directory)
    finished = [state["ok"], state["failed"]]
    if not state["holder"] or finished == drawn:
        return drawn
    kind = f"under way: {state['doing'] or 'starting'}; this page reloads itself"
    if not any(finished):
        page = Page(state["name"], kind, "", [], [])
    else:
        is_cut = store.is_cut(directory)
        run = store.BlockedRun(directory, partial=True) if is_cut else open_partial(directory, store.StoredRun)
        page = page_of(prepare(run))
        page = page._replace(subtitle=f"{page.subtitle} · {kind}")
    write_page(page.text().replace("<title>", f"{REFRESH}<title>", 1), out)
    return finished


# ---------------------------------------------------------------------------------------------- one case in motion


ANIMATIONS = {".gif": "GIF", ".webp": "WEBP"}
FRAMES, FRAME_TIME = 60, 60  # frames of a turn or of a start-up; ms of each
SIZE, DOTS = (5.2, 4.2), 100  # inches; dots per inch
GAP_SIZE, MARGIN = 0.07, 0.12  # of the drawing: radius of a drawn gap, and free space around the bodies
BLOCK = {"marker": "s", "markersize": 11}  # a body with one joint


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
    style: dict[str, Any] = {"comment": MARK.encode()} if ending == ".gif" else {"xmp": MARK.encode()}
    frames[0].save(
        stream, ANIMATIONS[ending], save_all=True, append_images=frames[1:], duration=FRAME_TIME, loop=0, **style
    )
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
    first = history.angle[0] + min(first, max(np.ptp(history.angle) - 2.0 * np.pi, 0.0))
    angles = first + np.linspace(0.0, 2.0 * np.pi, FRAMES, endpoint=False)
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
