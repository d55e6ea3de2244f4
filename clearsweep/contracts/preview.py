"""HTML preview of a trajectory in a notebook: figures and two small drawings of each joint, without a library."""

import html
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..language import wording

SIZE, MARGIN = 200, 6  # size of a drawing and margin around it, px
MAX_POINTS = 2000  # points of a curve


def preview_html(
    heading: str, channels: Mapping[str, np.ndarray], summary: Mapping[str, Any], units: Mapping[str, str]
) -> str:
    """Return the HTML preview of time histories and figures, both by name, with the SI `units` of figures."""
    joints = [name.split("/")[1] for name in channels if name.endswith("/force_normal")]
    drawings = "".join(drawing for joint in joints for drawing in _joint_drawings(channels, joint))
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{_figure_text(value, units.get(name, '1'))}</td></tr>"
        for name, value in summary.items()
    )
    figure_table = f"<details><summary>{len(summary)} figures</summary><table>{rows}</table></details>"
    return f"<p><code>{html.escape(heading)}</code></p><div>{drawings}</div>{figure_table}"


def _figure_text(value: object, unit: str) -> str:
    return wording.quantity_text(float(value), unit, 5) if isinstance(value, int | float) else wording.DASH


def _joint_drawings(channels: Mapping[str, np.ndarray], joint: str) -> list[str]:
    """Return drawings of a joint's journal orbit and of its normal force over time."""
    joint_name, force = wording.joint_name(joint), channels[f"joints/{joint}/force_normal"]
    x, y = channels[f"joints/{joint}/x"], channels[f"joints/{joint}/y"]
    eccentricity_text, force_text = (
        wording.quantity_text(float(np.hypot(x, y).max()), "m"),
        wording.quantity_text(float(force.max()), "N"),
    )
    force_title = f"{joint_name}: normal force over time, up to {force_text}"
    return [
        _curve_svg(x, y, f"{joint_name}: orbit, up to {eccentricity_text}", equal=True),
        _curve_svg(channels["t"], force, force_title, width=2 * SIZE),
    ]


def _curve_svg(x: np.ndarray, y: np.ndarray, caption: str, *, width: int = SIZE, equal: bool = False) -> str:
    """Return a curve with its title as SVG; `equal`: both axes have the same scale."""
    stride = max(1, len(x) // MAX_POINTS)
    x, y = np.asarray(x[::stride]), np.asarray(y[::stride])
    centres, half_ranges = (
        [(values.max() + values.min()) / 2.0 for values in (x, y)],
        [np.ptp(x) / 2.0, np.ptp(y) / 2.0],
    )
    half_ranges = [max(half_ranges)] * 2 if equal else half_ranges
    x_pixels = width / 2 + (width / 2 - MARGIN) * (x - centres[0]) / (half_ranges[0] or 1.0)
    y_pixels = SIZE / 2 - (SIZE / 2 - MARGIN) * (y - centres[1]) / (half_ranges[1] or 1.0)
    point_list = " ".join(f"{x_pixel:.1f},{y_pixel:.1f}" for x_pixel, y_pixel in zip(x_pixels, y_pixels, strict=True))
    return (
        f'<figure style="display:inline-block;margin:0 1em 0 0"><figcaption>{html.escape(caption)}</figcaption>'
        f'<svg width="{width}" height="{SIZE}" role="img" aria-label="{html.escape(caption)}">'
        f'<polyline fill="none" stroke="#0072B2" stroke-width="0.8" points="{point_list}"/></svg></figure>'
    )
