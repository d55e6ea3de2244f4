"""The picture of a mechanism, alone or at the top of a report."""

import io
import math
from pathlib import Path

from ... import grid, simulation
from ...contracts.case import Case
from ...contracts.machine import GROUND
from ...language.errors import InputError
from ...store import durable
from ..blocks.picture import Picture, svg
from ..draw import mechanism

ENDINGS = (".svg", ".png")
WIDTH, HIGHEST = 6.4, 4.2  # inches


def picture(case: Case) -> Picture | None:
    """Return the picture of the mechanism of a case, or None if it does not consist of bodies in a plane."""
    sketch = simulation.sketch(case)
    if sketch is None:
        return None
    bodies = ", ".join(body.name for body in sketch.bodies if body.name != GROUND)
    opened = ", ".join(joint.name for joint in sketch.joints if joint.has_clearance) or "none"
    elastic = ", ".join(body.name for body in sketch.bodies if body.elastic_ends is not None)
    angle = f"{math.degrees(sketch.angle):.6g}°"
    return Picture(
        f"The mechanism at crank angle {angle}",
        "Red: joints with clearance.  +: centres of mass." + ("  Zigzag: elastic links." if elastic else ""),
        f"Bodies {bodies}; with clearance: {opened}.{f' Elastic: {elastic}.' if elastic else ''}",
        lambda ax: mechanism.paint(ax, sketch),
        (WIDTH, min(mechanism.height(sketch, WIDTH), HIGHEST)),
    )


def draw(source: Path, out: Path) -> Path:
    """Draw the mechanism of the first case of a grid as SVG or PNG by the ending of `out`; return `out`."""
    if out.suffix.lower() not in ENDINGS:
        raise InputError(f"{out}: cannot draw a file that ends in {out.suffix!r}; use one of {', '.join(ENDINGS)}")
    durable.check_regular(out)
    loaded = grid.load(source, simulation.catalogue())
    shown = picture(loaded.case(0))
    if shown is None:
        raise InputError(f"{source}: a mechanism of this type has no picture; run it and see the report")
    out.parent.mkdir(parents=True, exist_ok=True)
    durable.replace(out, svg(shown, "m").encode() if out.suffix.lower() == ".svg" else _png(shown))
    return out


def _png(shown: Picture) -> bytes:
    from matplotlib import rc_context

    from ..blocks import matplotlib_figure

    stream = io.BytesIO()
    with rc_context(matplotlib_figure.STYLE):
        figure, axes = matplotlib_figure.draw_figure(shown)
        axes.set_title(shown.title, fontsize=10)
        figure.savefig(stream, format="png")
    return stream.getvalue()
