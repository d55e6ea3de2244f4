"""The report: one self-contained HTML file; its tables and pictures as files."""

import itertools
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from ...language import phases, wording
from ...store import durable
from .. import sections
from ..blocks import interactive
from ..blocks.picture import Picture, svg
from ..blocks.section import Block, Section
from ..data.study import Study
from ..sections import overlay
from ..statistics.overlay import compare_signals
from . import paper


class Page(NamedTuple):
    """A page before writing: its name, its kind, the varying axes, its sections."""

    name: str
    kind: str
    varied: str
    axes: list[str]
    parts: list[Section]

    def write(self, out: Path) -> Path:
        """Write the page as one self-contained HTML file; the bytes depend only on the run."""
        durable.check_regular(out)  # before the work
        with phases.phase("drawing the report"):
            return save(self.text(), out)

    def text(self) -> str:
        """Return the page as HTML."""
        return fill(
            "page.html.j2",
            name=self.name,
            kind=self.kind,
            varied=self.varied,
            axes=self.axes,
            sections=[section for section in self.parts if not section.subject],
            more=self._more(),
            count=sum(len(section.pictures) for section in self.parts),
            script=interactive.script() if any(section.moves for section in self.parts) else None,
            script_style=interactive.style(),
        )

    def _more(self) -> list[tuple[str, list[Section]]]:
        """Return the folded sections, by subject."""
        folded = [section for section in self.parts if section.subject]
        subjects = dict.fromkeys(section.subject for section in folded)
        return [(subject, [each for each in folded if each.subject == subject]) for subject in subjects]

    def write_tables(self, directory: Path) -> list[Path]:
        """Write the tables of every section into a directory; return the files.

        Each table is written as CSV, in SI with units in the header, and as Markdown, as shown on the page.
        """
        directory.mkdir(parents=True, exist_ok=True)
        return [file for section in self.parts for table in section.tables for file in table.write(directory)]

    def write_figures(self, wanted: paper.Wanted) -> list[Path]:
        """Write the pictures of every section, each under its name, and a list of them; return the files."""
        with phases.phase("drawing the figures"):
            return paper.write(self.parts, wanted)

    def write_all(self, out: Path, tables: Path | None, wanted: paper.Wanted | None) -> dict[str, Any]:
        """Write the page, its tables and its figures; return their paths under `report`, `tables` and `figures`."""
        files: dict[str, Any] = {"report": str(self.write(out))}
        if tables:
            self.write_tables(tables)
            files["tables"] = str(tables)
        if wanted:
            files["figures"] = [str(file) for file in self.write_figures(wanted)]
        return files


def of(study: Study, measured: str | PathLike | None = None) -> Page:
    """Return the page of a run; the signals in a file `measured` are compared with the computed ones."""
    comparison = [overlay.section(study, compare_signals(study, measured))] if measured else []
    record = study.run.grid
    return Page(
        name=record.get("name") or "clearsweep run",
        kind=f"{study.mechanism} with joint clearance" if study.driven else study.mechanism,
        varied="Varied" if record.get("sample") else "Swept",
        axes=[f"{axis.name} {axis.listed()}" for axis in study.swept()],
        parts=[*comparison, *sections.of(study)],
    )


def fill(template: str, *, count: int = 0, **content: object) -> str:
    """Return a template of this package filled with content; text is escaped, and `count` pictures are drawn."""
    numbers = itertools.count(1)  # so that ids in different SVGs are distinct

    def drawing(picture: Picture) -> Markup:
        number = next(numbers)
        if count and (opened := phases.innermost()):
            opened.note(share=(number - 1) / count)
        return Markup(svg(picture, f"f{number}"))

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
    """Write a page atomically; return its path."""
    out.parent.mkdir(parents=True, exist_ok=True)
    durable.replace(out, text.encode())
    return out


def _form(block: Block) -> str:
    """Return the name of the macro for a block."""
    return type(block).__name__.lower()
