"""Texts as SVG, and their widths, from the widths of DejaVu Sans in thousandths of the font size."""

import html

from ...language import wording

_FIRST_CODE = 32  # code of the first letter of the table
_WIDTH_ROWS = (
    (318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636),
    (636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632),
    (575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635, 611, 732, 684, 989, 685),
    (611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579),
    (278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838),
)
_WIDTHS = [width for row in _WIDTH_ROWS for width in row]
_OTHER_WIDTHS = {
    "\u00a0": 318,
    "°": 500,
    "²": 401,
    "³": 401,
    "⁻": 528,
    "·": 318,
    wording.DASH: 500,
    "\u202f": 200,
    wording.MINUS: 838,
    wording.TIMES: 838,
}
_DEFAULT_WIDTH = 600
INK = "#1f2933"
_FAMILY = "font-family: 'DejaVu Sans', sans-serif"
LINE_HEIGHT = 1.17  # line height over font size


def text_width(text: str, size: float) -> float:
    """Return the width (points) of a text, or of its widest line; size : font size (points)."""
    return max(sum(map(_letter_width, line)) for line in text.split("\n")) * size / 1000.0


def text_height(text: str, size: float) -> float:
    """Return the height of a text in points."""
    return LINE_HEIGHT * size * (text.count("\n") + 1)


def _letter_width(letter: str) -> int:
    index = ord(letter) - _FIRST_CODE
    return _WIDTHS[index] if 0 <= index < len(_WIDTHS) else _OTHER_WIDTHS.get(letter, _DEFAULT_WIDTH)


def text_svg(
    text: str,
    x: float,
    y: float,
    size: float,
    anchor: str,
    *,
    rotation: float = 0.0,
    is_centred: bool = False,
    style: str = "",
) -> str:
    """Return a text as SVG; `is_centred`: y is its centre, not its first baseline; rotation : degrees."""
    if not text:
        return ""
    lines = text.split("\n")
    y = y + (0.36 * size - 0.5 * 1.17 * size * (len(lines) - 1) if is_centred else 0.0)
    transform = f' transform="rotate({rotation:g} {x:.2f} {y:.2f})"' if rotation else ""
    style_text = f"font-size: {size:g}px; {_FAMILY}; text-anchor: {anchor}; {style or f'fill: {INK}'}"
    content = html.escape(lines[0])
    if len(lines) > 1:
        rows = (
            f'<tspan x="{x:.2f}" dy="{1.17 * size if k else 0:.2f}">{html.escape(line)}</tspan>'
            for k, line in enumerate(lines)
        )
        content = "".join(rows)
    return f'<text x="{x:.2f}" y="{y:.2f}"{transform} style="{style_text}">{content}</text>'
