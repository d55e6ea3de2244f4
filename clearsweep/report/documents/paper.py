"""The figures of a page as files for a paper, with the width of its column or page, and embedded fonts."""

import contextlib
import io
import os
import re
import unicodedata
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.text import Text

from ...language import phases
from ...language.errors import InputError
from ...store import durable
from ..blocks.picture import STYLE, Picture, drawn
from ..blocks.section import Section
from ..blocks.table import in_markdown

FORMS = ("svg", "pdf", "png")
COLUMN, PAGE = 85.0, 170.0  # mm, usual widths of figures in journals
WIDTHS = {"auto": None, "85": COLUMN, "170": PAGE}
LARGEST_TEXT = 8.0 / 9.0  # scale from the page, whose text has 9 points, to the 6 to 8 points that journals require
HIGHEST = 110.0  # mm, height of a figure of page width, unless its rows need more
DOTS = 600  # per inch, in PNG files and in images inside the other formats
INCH = 25.4  # mm
INDEX = "figures.md"
#: Letters are outlines in an SVG and an embedded TrueType font in a PDF, as journals require.
FONTS: dict[Any, Any] = {"svg.fonttype": "path", "pdf.fonttype": 42, "svg.hashsalt": "paper"}
NO_DATE: dict[str, dict] = {
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
    "png": {},
}  # the bytes depend only on the run


class Wanted(NamedTuple):
    """Directory, format and width of the figures."""

    directory: Path
    form: str = "svg"  # one of FORMS
    width: str = "auto"  # one of WIDTHS; auto: COLUMN or PAGE, by the size on the page


def write(sections: Iterable[Section], wanted: Wanted) -> list[Path]:
    """Write every picture of the sections, and a list of them in INDEX; return the files.

    Raises InputError for an unknown form or width.
    """
    for given, known, what in ((wanted.form, FORMS, "format"), (wanted.width, WIDTHS, "width")):
        if given not in known:
            raise InputError(f"{what} of figures: found {given!r}; expected one of {', '.join(known)}")
    wanted.directory.mkdir(parents=True, exist_ok=True)
    lines, files = ["| file | figure | what it shows |", "| --- | --- | --- |"], []
    listed, phase = named(sections), phases.innermost()
    for number, (name, picture) in enumerate(listed):
        if phase:
            phase.note(share=number / len(listed))
        file = wanted.directory / f"{name}.{wanted.form}"
        durable.replace(file, image(picture, wanted.form, WIDTHS[wanted.width]))
        files.append(file)
        lines.append(f"| {file.name} | {_cell(picture.title)} | {_cell(f'{picture.caption} {picture.alt}')} |")
    durable.replace(wanted.directory / INDEX, ("\n".join(lines) + "\n").encode())
    return [*files, wanted.directory / INDEX]


def named(sections: Iterable[Section]) -> list[tuple[str, Picture]]:
    """Return (name, picture) of every picture; unique names consist of the section's key, the part and the title."""
    pictures: dict[str, Picture] = {}
    for section in sections:
        for part, picture in section.pictures:
            name = _slug(f"{section.key} {part} {picture.title}")
            earlier = sum(known == name or re.fullmatch(rf"{name}-\d+", known) is not None for known in pictures)
            pictures[f"{name}-{earlier + 1}" if earlier else name] = picture
    return list(pictures.items())


def image(picture: Picture, form: str, width: float | None = None) -> bytes:
    """Return the bytes of a picture's file, `width` mm wide.

    If `width` is None, it is COLUMN or PAGE, by the size of the picture on the page.
    """
    width = width or (PAGE if picture.wide else COLUMN)
    size = width / INCH, _height(picture, width) / INCH
    scale = min(LARGEST_TEXT, size[0] / picture.size[0])
    with rc_context({**STYLE, **FONTS}):
        figure, _ = drawn(picture._replace(size=size))
        for text in figure.findobj(Text):
            text.set_fontsize(scale * float(text.get_fontsize()))
        stream = io.BytesIO()
        with _without_source_date():
            figure.savefig(stream, format=form, dpi=DOTS, metadata=NO_DATE[form])
    return stream.getvalue()


@contextlib.contextmanager
def _without_source_date() -> Iterator[None]:
    """Hide SOURCE_DATE_EPOCH, which matplotlib reads even if it writes no date."""
    date = os.environ.pop("SOURCE_DATE_EPOCH", None)
    try:
        yield
    finally:
        if date is not None:
            os.environ["SOURCE_DATE_EPOCH"] = date


def _height(picture: Picture, width: float) -> float:
    """Return the height (mm) of a picture of this width (mm)."""
    wide, high = picture.size
    return max(min(width * high / wide, HIGHEST), min(width / wide, INCH) * high)


def _slug(words: str) -> str:
    plain = unicodedata.normalize("NFKD", words).encode("ascii", "ignore").decode().lower()
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-")


def _cell(text: str) -> str:
    return in_markdown(text.strip())
