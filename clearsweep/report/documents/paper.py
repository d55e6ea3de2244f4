"""The figures of a page as files for a paper, with the width of its column or page, and embedded fonts."""

import contextlib
import os
import re
import sys
import unicodedata
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from ...language import phases
from ...language.errors import InputError
from ...store import durable
from ..blocks.section import Picture, Section, painted
from ..blocks.table import escape_markdown
from ..plot.items import PAPER, text_svg

FORMS = ("svg", "pdf", "png")
DOTS_PER_INCH = 600  # in PNG files and in images inside the other formats
COLUMN_WIDTH, PAGE_WIDTH = 85.0, 170.0  # mm, usual widths of figures in journals
WIDTHS = {"auto": None, "85": COLUMN_WIDTH, "170": PAGE_WIDTH}
MAX_TEXT_SCALE = 8.0 / 9.0  # scale from the page, whose text has 9 points, to the 6 to 8 points that journals require
MAX_HEIGHT = 110.0  # mm, height of a figure of page width, unless its rows need more
MM_PER_INCH = 25.4  # mm
INDEX = "figures.md"


class FigureOptions(NamedTuple):
    """Where and how the figures of a page are written."""

    directory: Path
    form: str = "svg"  # one of FORMS
    width: str = "auto"  # one of WIDTHS; auto: COLUMN_WIDTH or PAGE_WIDTH, by the size on the page


def write_figures(sections: Iterable[Section], options: FigureOptions) -> list[Path]:
    """Write every picture of the sections, and a list of them in INDEX; return the files.

    Raises InputError for an unknown form or width.
    """
    for value, allowed, option in ((options.form, FORMS, "format"), (options.width, WIDTHS, "width")):
        if value not in allowed:
            raise InputError(f"{option} of figures: found {value!r}; expected one of {', '.join(allowed)}")
    options.directory.mkdir(parents=True, exist_ok=True)
    lines, files = ["| file | figure | what it shows |", "| --- | --- | --- |"], []
    pictures, phase = named_pictures(sections), phases.innermost_phase()
    for number, (name, picture) in enumerate(pictures):
        if phase:
            phase.note(share=number / len(pictures))
        file = options.directory / f"{name}.{options.form}"
        durable.replace_output(file, picture_bytes(picture, options.form, WIDTHS[options.width]))
        files.append(file)
        cells = file.name, _table_cell(picture.title), _table_cell(f"{picture.caption} {picture.alt}")
        lines.append(f"| {' | '.join(cells)} |")
    durable.replace_output(options.directory / INDEX, ("\n".join(lines) + "\n").encode(), lines[0].encode())
    return [*files, options.directory / INDEX]


def named_pictures(sections: Iterable[Section]) -> list[tuple[str, Picture]]:
    """Return (name, picture) of every picture; unique names consist of the section's key, the part and the title."""
    pictures: dict[str, Picture] = {}
    for section in sections:
        for part_title, picture in section.pictures:
            words = unicodedata.normalize("NFKD", f"{section.key} {part_title} {picture.title}")
            ascii_words = words.encode("ascii", "ignore").decode().lower()
            name = re.sub(r"[^a-z0-9]+", "-", ascii_words).strip("-")
            earlier_count = sum(other == name or re.fullmatch(rf"{name}-\d+", other) is not None for other in pictures)
            pictures[f"{name}-{earlier_count + 1}" if earlier_count else name] = picture
    return list(pictures.items())


def picture_bytes(picture: Picture, form: str, width: float | None = None) -> bytes:
    """Return the bytes of a picture's file, `width` mm wide.

    If `width` is None, it is COLUMN_WIDTH or PAGE_WIDTH, by the size of the picture on the page.
    """
    width = width or (PAGE_WIDTH if picture.is_wide else COLUMN_WIDTH)
    # Height (mm) of a picture of this width (mm)
    picture_width, picture_height = picture.size
    least_height = min(width / picture_width, MM_PER_INCH) * picture_height
    height = max(min(width * picture_height / picture_width, MAX_HEIGHT), least_height)
    size = width / MM_PER_INCH, height / MM_PER_INCH
    scale = min(MAX_TEXT_SCALE, size[0] / picture.size[0])
    sheet, box = painted(picture._replace(size=(size[0] / scale, size[1] / scale)))
    return drawing_bytes(sheet.svg("figure", box), form, scale)


def drawing_bytes(svg: str, form: str, scale: float = 1.0, *, dots_per_inch: int = DOTS_PER_INCH) -> bytes:
    """Return a drawing of `plot`, `scale` times its size, as the bytes of a file of one of FORMS."""
    _import_matplotlib()
    from .figure_file import file_bytes  # loads all of matplotlib, which a page does without

    with hidden_variable("SOURCE_DATE_EPOCH"):  # which matplotlib reads even if it writes no date
        return file_bytes(svg, form, scale, dots_per_inch)


PANEL_COLUMNS, TITLE_HEIGHT = 2, 20.0  # of pictures in one drawing; points


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


def _import_matplotlib() -> None:
    """Load matplotlib even if MPLBACKEND names an unknown backend: figures are drawn into files without a backend."""
    if "matplotlib" in sys.modules:
        return
    with hidden_variable("MPLBACKEND") as backend:
        import matplotlib
    if backend:
        with contextlib.suppress(ValueError):
            matplotlib.rcParams["backend"] = backend


@contextlib.contextmanager
def hidden_variable(name: str) -> Iterator[str | None]:
    """Remove a variable of the environment for as long as this context lasts; return its value."""
    value = os.environ.pop(name, None)
    try:
        yield value
    finally:
        if value is not None:
            os.environ[name] = value


def _table_cell(text: str) -> str:
    return escape_markdown(text.strip())
