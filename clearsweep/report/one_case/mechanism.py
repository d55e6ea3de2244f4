"""The picture of a mechanism, alone or at the top of a report."""

import io
import math
from pathlib import Path

from ... import grid, simulation
from ...contracts.case import Case
from ...contracts.machine import GROUND
from ...language.errors import InputError
from ...store import durable
from ..blocks.picture import Picture, draw_svg
from ..draw import mechanism

ENDINGS = (".svg", ".png")
WIDTH, MAX_HEIGHT = 6.4, 4.2  # inches
MARK = "<!-- drawn by clearsweep -->"  # recognised by `durable.check_output`


def mechanism_picture(case: Case) -> Picture | None:
    """Return the picture of the mechanism of a case, or None if it does not consist of bodies in a plane."""
    sketch = simulation.sketch(case)
    if sketch is None:
        return None
    body_names = ", ".join(body.name for body in sketch.bodies if body.name != GROUND)
    open_names = ", ".join(joint.name for joint in sketch.joints if joint.has_clearance) or "none"
    elastic_names = ", ".join(body.name for body in sketch.bodies if body.elastic_ends is not None)
    angle_text = f"{math.degrees(sketch.angle):.6g}°"
    return Picture(
        f"The mechanism at crank angle {angle_text}",
        "Red: joints with clearance.  +: centres of mass." + ("  Zigzag: elastic links." if elastic_names else ""),
        f"Bodies {body_names}; with clearance: {open_names}.{f' Elastic: {elastic_names}.' if elastic_names else ''}",
        lambda ax: mechanism.draw_mechanism(ax, sketch),
        (WIDTH, min(mechanism.picture_height(sketch, WIDTH), MAX_HEIGHT)),
    )


def draw_grid(source: Path, out: Path) -> Path:
    """Draw the mechanism of the first case of a grid as SVG or PNG by the ending of `out`; return `out`."""
    if out.suffix.lower() not in ENDINGS:
        raise InputError(f"{out}: cannot draw a file that ends in {out.suffix!r}; use one of {', '.join(ENDINGS)}")
    durable.check_output(out)
    loaded_grid = grid.load(source, simulation.catalogue())
    picture = mechanism_picture(loaded_grid.case(0))
    if picture is None:
        raise InputError(f"{source}: a mechanism of this type has no picture; run it and see the report")
    out.parent.mkdir(parents=True, exist_ok=True)
    is_svg = out.suffix.lower() == ".svg"
    durable.replace_output(out, f"{MARK}{draw_svg(picture, 'm')}".encode() if is_svg else _png_bytes(picture))
    return out


def _png_bytes(picture: Picture) -> bytes:
    from matplotlib import rc_context

    from ..blocks import matplotlib_figure

    stream = io.BytesIO()
    with rc_context(matplotlib_figure.STYLE):
        figure, axes = matplotlib_figure.draw_figure(picture)
        axes.set_title(picture.title, fontsize=10)
        figure.savefig(stream, format="png", metadata={"Software": "clearsweep"})
    return stream.getvalue()
