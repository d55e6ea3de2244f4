"""The report: one self-contained HTML file; its tables and pictures as files."""

import itertools
import re
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup, escape

from ...language import phases, wording
from ...store import durable
from .. import sections
from ..blocks.picture import Picture, draw_svg
from ..blocks.section import Block, Section, page_script, safe_json, style_sheets
from ..sections.identified import compare_signals, overlay_section
from ..study import Study
from .paper import FigureOptions, write_figures


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
        return render(
            "page.html.j2",
            name=self.name,
            kind=self.subtitle,
            varied=self.axes_verb,
            axes=self.axes,
            sections=[section for section in self.sections if not section.subject],
            more=self._folded_sections(),
            picture_count=sum(len(section.pictures) for section in self.sections),
            script=page_script() if any(section.has_scripts for section in self.sections) else None,
            script_style=style_sheets(),
        )

    def _folded_sections(self) -> list[tuple[str, list[Section]]]:
        """Return the folded sections, by subject."""
        folded = [section for section in self.sections if section.subject]
        subjects = dict.fromkeys(section.subject for section in folded)
        return [(subject, [section for section in folded if section.subject == subject]) for subject in subjects]

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
        axes=[f"{axis.name} {axis.values_text()}" for axis in study.swept()],
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

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {
        "drawing": drawing,
        "form": _macro_name,
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


def _macro_name(block: Block) -> str:
    """Return the name of the macro for a block."""
    return type(block).__name__.lower()
