"""One case, simulated again and drawn: orbit, force, slider, drive and contact onsets."""

from pathlib import Path

import pandas as pd
from matplotlib import rc_context
from matplotlib.figure import Figure

from .. import simulation, wording
from ..case import Case
from ..errors import InputError
from . import cases, figures, page
from .study import Study, prepare, resolved

SAMPLES = 1440  # per revolution at least, so that single contacts show
COLUMNS = 2  # of panels in a PNG or SVG
ENDINGS = (".html", ".png", ".svg")


def show(run, case_id: str, out: Path) -> Path:
    """Simulate a case of a run again and draw it, as HTML, PNG or SVG by the ending of `out`; return `out`."""
    if out.suffix.lower() not in ENDINGS:
        raise InputError(f"{out}: cannot draw a file that ends in {out.suffix!r}; use one of {', '.join(ENDINGS)}")
    study = prepare(run)
    if case_id not in study.cases.index and case_id not in study.failed.index:
        raise InputError(f"no case {case_id!r} in this run; the column case_id of summary.parquet lists them")
    result = simulation.solve(to_draw(study, case_id))
    panels = drawn(study, case_id, result)
    if not panels:
        raise InputError(f"case {case_id}: nothing to draw, the case ended with {result.status!r}: {result.message}")
    title = f"{study.run.grid.get('name') or 'case'}, case {case_id}"
    out.parent.mkdir(parents=True, exist_ok=True)
    if out.suffix.lower() == ".html":
        return page.save(_page(study, case_id, result, panels, title), out)
    return _sheet(panels, f"{title}\n{study.setting(case_id)}".strip(), out)


def to_draw(study: Study, case_id: str) -> Case:
    """Return a case of a run in SI, its history to be saved finely."""
    case = resolved(study, [case_id])[0]
    orbits = "last" if case.save.orbits == "none" else case.save.orbits
    return case._replace(save=case.save._replace(orbits=orbits, samples=max(case.save.samples, SAMPLES)))


def drawn(study: Study, case_id: str, result) -> list[cases.Panel]:
    """Return the panels of a simulated case; none where it left no history."""
    path = result.channels
    if len(path.get("t", ())) < 2:
        return []
    onsets = cases.impacts(study, case_id, pd.DataFrame(result.events))
    return cases.panels(study, case_id, path) + ([onsets] if onsets else [])


def _page(study: Study, case_id: str, result, panels: list[cases.Panel], title: str) -> str:
    canvas = figures.Canvas()
    units = study.units
    rows = [(name, wording.text(value, units.get(name, "1"))) for name, value in result.summary.items()]
    return page.fill(
        "case.html.j2",
        title=title,
        setting=study.setting(case_id),
        status=result.status,
        message=result.message,
        rows=rows,
        pictures=[cases.picture(panel, canvas) for panel in panels],
    )


def _sheet(panels: list[cases.Panel], title: str, out: Path) -> Path:
    rows = -(-len(panels) // COLUMNS)
    with rc_context({**figures.STYLE, "svg.hashsalt": "case"}):
        figure = Figure(figsize=(5.2 * COLUMNS, 3.5 * rows + 0.6), dpi=150, layout="constrained")
        figure.suptitle(title, fontsize=10)
        axes = figure.subplots(rows, COLUMNS, squeeze=False).flat
        for ax, panel in zip(axes, panels, strict=False):
            panel.paint(ax)
            ax.set_title(panel.title, fontsize=9, pad=22)
        for ax in list(axes)[len(panels) :]:
            ax.set_visible(False)
        temporary = out.with_name(f".{out.name}.part")
        figure.savefig(
            temporary, format=out.suffix[1:].lower(), metadata={"Date": None} if out.suffix.lower() == ".svg" else None
        )
        temporary.replace(out)
    return out
