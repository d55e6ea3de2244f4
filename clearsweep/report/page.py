"""The report: one HTML file that carries all it shows and asks nothing of the network, and its tables as CSV."""

import itertools
from pathlib import Path

import jinja2
from markupsafe import Markup

from .. import wording
from ..store import StoredRun, durable
from . import interactive, sections
from .picture import Picture, svg
from .section import Block, Section
from .study import Study, prepare


def write(run: StoredRun, out: Path, *, typical: bool = False) -> Path:
    """Write the report of a run as one self-contained HTML file; the same run gives the same bytes."""
    durable.check_regular(out)  # before the work
    return save(render(prepare(run, typical=typical)), out)


def write_tables(run: StoredRun, directory: Path) -> list[Path]:
    """Write the tables of every section as CSV (SI, unit in the header) into `directory`; return the files."""
    directory.mkdir(parents=True, exist_ok=True)
    return [table.write(directory) for section in sections.of(prepare(run)) for table in section.tables]


def render(study: Study) -> str:
    """Return the page of a run as HTML."""
    record = study.run.grid
    return render_sections(
        name=record.get("name") or "clearsweep run",
        kind=f"{study.mechanism} with joint clearance" if study.driven else study.mechanism,
        varied="Varied" if record.get("sample") else "Swept",
        axes=[f"{axis.name} {axis.listed()}" for axis in study.swept()],
        parts=sections.of(study),
    )


def render_sections(*, name: str, kind: str, varied: str, axes: list[str], parts: list[Section]) -> str:
    """Return a page of sections as HTML, under a name, what kind of page it is, and the axes that are varied."""
    return fill(
        "page.html.j2",
        name=name,
        kind=kind,
        varied=varied,
        axes=axes,
        sections=parts,
        script=interactive.script() if any(section.moves for section in parts) else None,
        script_style=interactive.style(),
    )


def fill(template: str, **content: object) -> str:
    """Return a template of this package filled with content; text is escaped, pictures are drawn."""
    numbers = itertools.count(1)  # so that the ids inside one SVG never meet those of another

    def drawing(picture: Picture) -> Markup:
        return Markup(svg(picture, f"f{next(numbers)}"))

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"drawing": drawing, "form": _form, "json": interactive.data, "short_id": wording.short_id}
    return environment.get_template(template).render(content)


def save(text: str, out: Path) -> Path:
    """Write a page so that it is either all there or not at all; return its path."""
    out.parent.mkdir(parents=True, exist_ok=True)
    durable.replace(out, text.encode())
    return out


def _form(block: Block) -> str:
    """Return the name of the macro that writes a block."""
    return type(block).__name__.lower()
