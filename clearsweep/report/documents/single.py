"""One case, simulated again and drawn: orbit, force, output, drive, contact onsets and wear; its pin forces as CSV."""

import io
from pathlib import Path

import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure

from ... import simulation
from ...contracts.case import Case
from ...contracts.results import Trajectory
from ...language import phases, wording
from ...language.errors import InputError
from ...store import StoredRun, durable
from ..blocks.matplotlib_figure import STYLE
from ..blocks.picture import Picture
from ..one_case import joints
from ..one_case.joints import joint_forces
from ..one_case.motion import motion_pictures, onset_pictures
from ..study import Study, prepare, resolve_cases
from . import page, paper

MIN_SAMPLES = 1440  # per revolution at least, so that single contacts show
PANEL_COLUMNS = 2  # of panels in a PNG or SVG
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
    rows = -(-len(pictures) // PANEL_COLUMNS)
    with rc_context({**STYLE, "svg.hashsalt": "case"}):
        figure = Figure(figsize=(5.2 * PANEL_COLUMNS, 3.5 * rows + 0.6), dpi=150, layout="constrained")
        figure.suptitle(title, fontsize=10)
        for number, picture in enumerate(pictures, start=1):
            ax = figure.add_subplot(rows, PANEL_COLUMNS, number, projection=picture.projection)
            picture.paint(ax)
            ax.set_title(picture.title, fontsize=9, pad=22)
        file_format, stream = out.suffix[1:].lower(), io.BytesIO()
        figure.savefig(stream, format=file_format, metadata=paper.MARKS[file_format])
    durable.replace_output(out, stream.getvalue())
    return out
