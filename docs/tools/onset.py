"""Draws docs/onset.svg: the force of a contact that never ends, after two starts, with either rule for the onset rate.

`python docs/tools/onset.py` runs the four cases and writes the picture.
"""

from pathlib import Path

import numpy as np

import clearsweep

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs/onset.svg"
CASE = {
    "drive.speed": "5000 rpm",
    "joints.rod-slider.clearance": "0.1 mm",
    "joints.rod-slider.contact.stiffness": 1e10,
    "joints.rod-slider.contact.restitution": 0.7,
    "joints.rod-slider.wear": None,
    "simulate.revolutions": 40,
    "simulate.discard": 20,
}
STARTS = {"centred": "#0072B2", "seated": "#D55E00"}  # and their colours
WIDTH, HEIGHT, LEFT, TOP, GAP = 720, 250, 46, 30, 24  # px
LARGEST = 6.0  # kN


def force(onset: str, start: str) -> np.ndarray:
    """Return the normal force (N) at every degree of the last revolution."""
    changes = CASE | {"joints.rod-slider.contact.onset": onset, "simulate.start": start}
    scene = clearsweep.load_case(ROOT / "configs/slider_crank_restitution.yaml", changes)
    period = 2.0 * np.pi / scene.value.reference_rate
    times = (39.0 + np.arange(361) / 360.0) * period
    return clearsweep.simulate(scene, times)["joints/rod_slider/force_normal"]


def panel(onset: str, left: float, width: float) -> list[str]:
    """Return the drawing of both starts with one rule."""
    bottom, high = HEIGHT - 34, HEIGHT - 34 - TOP
    parts = [
        f'<rect x="{left:.0f}" y="{TOP}" width="{width:.0f}" height="{high}" class="frame"/>',
        f'<text x="{left + 4:.0f}" y="{TOP - 8}" class="name">onset: {onset}</text>',
    ]
    for angle in (0, 90, 180, 270, 360):
        x = left + width * angle / 360
        parts.append(f'<text x="{x:.0f}" y="{bottom + 14}" text-anchor="middle" class="text">{angle}°</text>')
    for start, colour in STARTS.items():
        values = force(onset, start) / 1e3
        print(f"{onset}, {start}: largest {values.max():.3f} kN")
        places = (
            f"{left + width * k / 360:.1f},{bottom - high * value / LARGEST:.1f}" for k, value in enumerate(values)
        )
        dashes = "" if start == "centred" else ' stroke-dasharray="4 3"'
        parts.append(f'<polyline points="{" ".join(places)}" fill="none" stroke="{colour}"{dashes}/>')
    return parts


def picture() -> str:
    """Return the picture as SVG."""
    width = (WIDTH - LEFT - GAP - 12) / 2
    parts = panel("first", LEFT, width) + panel("renewed", LEFT + width + GAP, width)
    for value in (0, 2, 4, 6):
        y = HEIGHT - 34 - (HEIGHT - 34 - TOP) * value / LARGEST
        parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.0f}" text-anchor="end" class="text">{value} kN</text>')
    for place, (start, colour) in enumerate(STARTS.items()):
        x = LEFT + 150 + 90 * place
        parts.append(f'<text x="{x}" y="{TOP - 8}" class="text" style="fill:{colour}">start: {start}</text>')
    parts.append(f'<text x="{WIDTH / 2}" y="{HEIGHT - 4}" text-anchor="middle" class="text">crank angle</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img">'
    title = "<title>Normal force over the 40th revolution after two starts, with both rules</title>"
    style = (
        "<style>.frame{fill:#fff;stroke:#c3ccd5}.name{font:bold 12px sans-serif;fill:#14303f}"
        ".text{font:11px sans-serif;fill:#333}</style>"
    )
    return "\n".join([head, title, style, '<rect width="100%" height="100%" fill="#fff"/>', *parts, "</svg>\n"])


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
