"""One case, simulated again and drawn: orbit, force, output, drive, contact onsets and wear; its pin forces as CSV."""

from pathlib import Path

import pandas as pd

from ... import grid, simulation
from ...contracts.case import Case
from ...contracts.results import Trajectory
from ...language import phases, wording
from ...language.errors import InputError
from ...store import StoredRun, durable
from ..blocks.picture import Picture, draw_svg, painted
from ..one_case import joints
from ..one_case.joints import joint_forces, mechanism_picture
from ..one_case.motion import motion_pictures, onset_pictures
from ..plot.items import PAPER, text_svg
from ..study import Study, prepare, resolve_cases
from . import page
from .paper import drawing_bytes

MIN_SAMPLES = 1440  # per revolution at least, so that single contacts show
PANEL_COLUMNS, PANEL_SIZE, PANEL_DOTS = 2, (5.2, 3.2), 150  # of a PNG or SVG; inches; dots per inch
TITLE_HEIGHT = 20.0  # points
MECHANISM_ENDINGS = (".svg", ".png")
MARK = "<!-- drawn by clearsweep -->"  # recognised by `durable.check_output`
ENDINGS = (".html", ".png", ".svg", ".csv")


def show(run: StoredRun, case_id: str, out: Path) -> Path:
    """Simulate a case of a run again and draw it, as HTML, PNG or SVG by the ending of `out`; return `out`.

    As CSV the file has the forces in the joints over time.
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
        content = forces.to_csv(index=False, lineterminator="\n").encode()
        durable.replace_output(out, content, content.partition(b"\n")[0])
        return out
    pictures = case_pictures(study, case_id, result)
    with phases.phase("drawing"):
        if out.suffix.lower() == ".html":
            return page.write_page(_page(study, case_id, result, pictures), out)
        return _write_panels(pictures, f"{_title(study, case_id)}\n{study.setting(case_id)}".strip(), out)


def case_to_draw(study: Study, case_id: str) -> Case:
    """Return a case of a run in SI, set to save its history with a fine sampling."""
    case = resolve_cases(study, [case_id])[0]
    orbits = "last" if case.save.orbits == "none" else case.save.orbits
    return case._replace(save=case.save._replace(orbits=orbits, samples=max(case.save.samples, MIN_SAMPLES)))


def case_pictures(study: Study, case_id: str, result: Trajectory) -> list[Picture]:
    """Return the pictures of a simulated case with a history."""
    channels = result.channels
    pictures = motion_pictures(study, case_id, channels) + onset_pictures(
        study, case_id, pd.DataFrame(result.events), channels
    )
    for joint in study.joints:
        if joint.name in result.wear:
            wear_pictures = joints.wear_pictures(study, joint, case_id, result.wear[joint.name])
            pictures += [
                picture._replace(title=picture.title + study.joint_text(joint, ", joint {}"))
                for picture in wear_pictures
            ]
    return pictures


def _title(study: Study, case_id: str) -> str:
    return f"{study.run.grid.get('name') or 'case'}, case {wording.short_id(case_id)}"


def _page(study: Study, case_id: str, result: Trajectory, pictures: list[Picture]) -> str:
    return page.render(
        "case.html.j2",
        title=_title(study, case_id),
        setting=study.setting(case_id),
        status=result.status,
        message=result.message,
        pictures=pictures,
        rows=[(name, wording.quantity_text(value, study.unit(name))) for name, value in result.summary.items()],
    )


def _write_panels(pictures: list[Picture], title: str, out: Path) -> Path:
    svg = panels_svg([picture._replace(size=PANEL_SIZE) for picture in pictures], title)
    durable.replace_output(out, drawing_bytes(svg, out.suffix[1:].lower(), dots_per_inch=PANEL_DOTS))
    return out


def panels_svg(pictures: list[Picture], title: str = "") -> str:
    """Return pictures of one size below each other, in two columns if they are several, each under its title."""
    columns = min(PANEL_COLUMNS, len(pictures))
    picture_width, picture_height = (72.0 * side for side in pictures[0].size)
    title_lines, row_height = title.split("\n") if title else [], picture_height + TITLE_HEIGHT
    top = TITLE_HEIGHT * len(title_lines)
    width, height = columns * picture_width, top + -(-len(pictures) // columns) * row_height
    parts = [
        f'<svg width="{width:g}pt" height="{height:g}pt" viewBox="0 0 {width:g} {height:g}" '
        f'xmlns="http://www.w3.org/2000/svg"><rect width="{width:g}" height="{height:g}" style="fill: {PAPER}"/>'
    ]
    parts += [
        text_svg(line, 0.5 * width, TITLE_HEIGHT * (k + 0.7), 10.0, "middle") for k, line in enumerate(title_lines)
    ]
    for number, picture in enumerate(pictures):
        row, column = divmod(number, columns)
        sheet, box = painted(picture)
        heading = text_svg(picture.title, 0.5 * picture_width, 0.7 * TITLE_HEIGHT, 9.0, "middle")
        drawing = f'<g transform="translate(0 {TITLE_HEIGHT:g})">{sheet.svg(f"panel{number}", box)}</g>'
        place = f"translate({column * picture_width:g} {top + row * row_height:g})"
        parts.append(f'<g transform="{place}">{heading}{drawing}</g>')
    return "".join([*parts, "</svg>"])


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
        content = f"{MARK}{draw_svg(picture, 'm')}".encode()
    else:
        content = drawing_bytes(panels_svg([picture]), "png", dots_per_inch=PANEL_DOTS)
    durable.replace_output(out, content)
    return out
