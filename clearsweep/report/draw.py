"""Each drawing of a report, made on the matplotlib axes it is given; nothing here knows about pages or files."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.patches import Circle
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, MultipleLocator, NullLocator

from .. import wording
from ..wording import Scale
from .findings import Effect
from .study import Axis

BLUE, RED, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"  # Okabe and Ito 2008
INK, GREY, PALE = "#1f2933", "#6b7785", "#c3ccd5"
JOINT_COLOURS = (BLUE, RED, GREEN)
CURVES = (BLUE, RED, GREEN, ORANGE, PURPLE, "#56B4E9", INK)  # of many curves; the next seven are dashed
WRITTEN = (9, 8)  # rows and columns of a heat map up to which its cells carry numbers
CELLS_VECTOR = 150  # and with more than this are drawn as pixels
BINS_DRAWN = 41  # edges of a histogram's bars, at most
POINTS_VECTOR = 300  # clouds with more points than this are drawn as pixels
TICKS_NAMED = 9  # axes with more values than this name only some of them
SLANTED = {"rotation": 40, "ha": "right", "rotation_mode": "anchor"}  # names that do not fit beside each other
WIDTH = 36  # characters that fit beside each other below a figure
DECADES = 8.0  # a figure whose values spread over a larger factor than this is drawn on a logarithmic scale


def orbit(ax: Axes, x: np.ndarray, y: np.ndarray, force: np.ndarray, clearance: float) -> None:
    """Draw the path of the journal centre (m) inside the clearance circle, in contact coloured by the force (N)."""
    scale = wording.scale("m", clearance)
    x, y, radius = x / scale.factor, y / scale.factor, clearance / scale.factor
    ax.add_patch(Circle((0.0, 0.0), radius, facecolor="#f3f6f9", edgecolor=INK, linewidth=1.0, zorder=0))
    ax.plot(x, y, color=GREY, linewidth=0.5, alpha=0.8, rasterized=len(x) > 5000)
    touching = force > 0.0
    reach = 1.08 * max(radius, float(np.hypot(x, y).max(initial=0.0)))
    if touching.any():
        unit = wording.scale("N", force)
        points = ax.scatter(
            x[touching],
            y[touching],
            c=force[touching] / unit.factor,
            s=4,
            cmap="viridis",
            zorder=3,
            linewidths=0,
            rasterized=True,
        )
        _bar(ax, points, f"normal force [{unit.unit}]")
    ax.set(
        xlim=(-reach, reach),
        ylim=(-reach, reach),
        aspect="equal",
        xlabel=f"journal x [{scale.unit}]",
        ylabel=f"journal y [{scale.unit}]",
    )
    ax.xaxis.set_major_locator(MaxNLocator(5))
    ax.yaxis.set_major_locator(MaxNLocator(5))


def force(ax: Axes, angle: np.ndarray, normal: np.ndarray, levels: Sequence[tuple[str, float]]) -> None:
    """Draw the normal force (N) over the crank angle (rad), with named levels (N) as horizontal lines."""
    scale = wording.scale("N", [*normal, *(level for _, level in levels)])
    ax.fill_between(
        np.degrees(angle), normal / scale.factor, color=BLUE, alpha=0.25, linewidth=0, rasterized=len(angle) > 5000
    )
    ax.plot(np.degrees(angle), normal / scale.factor, color=BLUE, linewidth=0.7, rasterized=len(angle) > 5000)
    for (name, level), colour, dash in zip(levels, (RED, INK), ("--", ":"), strict=False):
        ax.axhline(level / scale.factor, color=colour, linewidth=1.1, linestyle=dash, label=name)
    ax.set(ylabel=f"normal force [{scale.unit}]", ylim=(0.0, None))
    _over_crank(ax, angle, legend=bool(levels))


def against_ideal(
    ax: Axes, angle: np.ndarray, actual: np.ndarray, ideal: np.ndarray | None, unit: str, name: str
) -> None:
    """Draw a quantity (SI) over the crank angle (rad) and, where there is one, its course in the ideal mechanism."""
    scale = wording.scale(unit, actual)
    ax.plot(
        np.degrees(angle),
        actual / scale.factor,
        color=BLUE,
        linewidth=0.7,
        label="with clearance",
        rasterized=len(angle) > 5000,
    )
    if ideal is not None:
        ax.plot(np.degrees(angle), ideal / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="ideal")
    ax.set(ylabel=f"{name} [{scale.unit}]")
    _over_crank(ax, angle, legend=ideal is not None)


def over_time(ax: Axes, t: np.ndarray, values: np.ndarray, unit: str, name: str) -> None:
    """Draw a quantity (SI) over time (s)."""
    scale, clock = wording.scale(unit, values), wording.scale("s", t)
    ax.plot(t / clock.factor, values / scale.factor, color=BLUE, linewidth=0.8, rasterized=len(t) > 5000)
    ax.set(xlabel=f"time [{clock.unit}]", ylabel=f"{name} [{scale.unit}]")
    _quiet(ax)


def phase(ax: Axes, x: np.ndarray, v: np.ndarray) -> None:
    """Draw rate (m/s) over displacement (m)."""
    place, rate = wording.scale("m", x), wording.scale("m/s", v)
    ax.plot(x / place.factor, v / rate.factor, color=BLUE, linewidth=0.8, rasterized=len(x) > 5000)
    ax.set(xlabel=f"displacement [{place.unit}]", ylabel=f"rate [{rate.unit}]")
    _quiet(ax)


def wear(ax: Axes, bearing: np.ndarray, journal: np.ndarray) -> None:
    """Draw the wear depths (m, one per angular bin of each body's own frame) on polar axes."""
    scale = wording.scale("m", [*bearing, *journal])
    for depth, name, colour, dash in ((bearing, "bearing", BLUE, "-"), (journal, "journal", RED, "--")):
        middle = (np.arange(len(depth)) + 0.5) * 2.0 * np.pi / len(depth)
        ax.plot(
            np.append(middle, middle[0]),
            np.append(depth, depth[0]) / scale.factor,
            color=colour,
            linewidth=1.2,
            linestyle=dash,
            label=name,
        )
    ax.set_rlabel_position(22.5)
    ax.set_xticks(np.radians(np.arange(0, 360, 45)))
    ax.yaxis.set_major_locator(MaxNLocator(4))
    ax.set_ylim(0.0, None)
    ax.tick_params(axis="y", labelsize=7)
    ax.grid(color=PALE, linewidth=0.5)
    ax.legend(loc="upper left", bbox_to_anchor=(0.92, 1.12), frameon=False, title=f"depth [{scale.unit}]")


def events(ax: Axes, angle: np.ndarray, rate: np.ndarray, floor: float) -> None:
    """Draw the closing rate (m/s) of every contact onset over the crank angle (rad), and the elastic limit."""
    scale = wording.scale("m/s", [*rate, floor])
    ax.vlines(np.degrees(angle), 0.0, rate / scale.factor, color=BLUE, linewidth=0.6, rasterized=len(angle) > 500)
    ax.plot(np.degrees(angle), rate / scale.factor, ".", color=BLUE, markersize=4, rasterized=len(angle) > 500)
    ax.axhline(floor / scale.factor, color=RED, linewidth=1.1, linestyle="--", label="elastic up to here (steel)")
    ax.set(ylabel=f"closing rate at onset [{scale.unit}]", ylim=(0.0, None))
    _over_crank(ax, np.array([0.0, 2.0 * np.pi * np.ceil(angle.max() / (2.0 * np.pi))]), legend=True)  # whole turns


def effect(
    ax: Axes, curves: Sequence[tuple[str, str, bool, Effect]], unit: str, limits: tuple[float, float], name: str
) -> None:
    """Draw medians of a figure over the values of one axis; a curve is (name, colour, with 10-90 % band, effect)."""
    axis = curves[0][3].axis
    scale = wording.scale(unit, limits)
    places, spaced = _places(axis)
    strength = 0.15 if len(curves) <= 2 else 0.06
    named, joints = spaced == "name", list(dict.fromkeys(colour for _, colour, band, _ in curves if band))
    for word, colour, band, one in curves:
        if named:  # side by side, and no line: between names there is nothing
            beside = joints.index(colour) if colour in joints else 0
            places = np.arange(len(axis.values)) + 0.16 * (beside - 0.5 * (len(joints) - 1))
        if band and named:
            ax.vlines(places, one.low / scale.factor, one.high / scale.factor, color=colour, alpha=0.3, linewidth=6)
        elif band:
            low, high = one.low / scale.factor, one.high / scale.factor
            ax.fill_between(places, low, high, color=colour, alpha=strength, linewidth=0)
        ax.plot(
            places,
            one.medians / scale.factor,
            color=colour,
            linewidth=1.5,
            linestyle="" if named else "-" if band else "--",
            label=word,
            markersize=4,
            marker=("o" if band else "s") if named or len(places) <= TICKS_NAMED else None,
        )
    ax.set(xlabel=axis.label(), ylabel=_with_unit(name, scale))
    if spaced == "log":
        ax.set_xscale("log")
    if named:
        ax.set_xlim(-0.5, len(places) - 0.5)
    if named or len(places) <= TICKS_NAMED:
        _name_values(ax.xaxis, axis, _places(axis)[0])
    elif spaced == "log":
        _logarithmic(ax, "x")
    if limits[0] > 0.0 and limits[1] > DECADES * limits[0]:
        _logarithmic(ax, "y")
    ax.set_ylim(limits[0] / scale.factor * 0.9, limits[1] / scale.factor * 1.1)
    _quiet(ax)
    if len(curves) > 1:
        ax.legend(
            loc="lower left",
            bbox_to_anchor=(-0.12, 1.0),
            ncols=3,
            columnspacing=1.0,
            handlelength=1.6,
            frameon=False,
            borderaxespad=0.2,
        )


def strip(ax: Axes, groups: Sequence[tuple[str, np.ndarray]], name: str, scale: Scale) -> None:
    """Draw one row of points (SI, scaled) for each name, from the bottom up, with a bar at its median."""
    for place, (_, values) in enumerate(groups):
        ax.plot(
            values / scale.factor,
            np.full(len(values), place),
            "o",
            color=BLUE,
            markersize=4.5,
            alpha=0.55,
            markeredgewidth=0,
            rasterized=len(values) > POINTS_VECTOR,
        )
        ax.plot(np.median(values) / scale.factor, place, "|", color=RED, markersize=11, markeredgewidth=2.2)
    everything = np.concatenate([values for _, values in groups])
    if everything.min() > 0.0 and everything.max() > 4.0 * everything.min():  # else a logarithmic axis has no ticks
        _logarithmic(ax, "x")
    _rows(ax, [law for law, _ in groups])
    ax.set_xlabel(_with_unit(name, scale))


def returned(ax: Axes, rows: Sequence[tuple[str, float, float]]) -> None:
    """Draw, name by name, the restitution given back beside that asked for (NaN: none); a row is (name, asked, got)."""
    names = list(dict.fromkeys(row[0] for row in rows))[::-1]
    for number, (name, asked, got) in enumerate(rows):
        place = names.index(name)
        ax.plot([asked, got], [place, place], "-", color=GREY, linewidth=1.2, zorder=1)
        ax.plot(
            asked,
            place,
            "o",
            markerfacecolor="white",
            color=INK,
            markersize=6,
            label="asked for" if number == 0 else None,
        )
        ax.plot(got, place, "D", color=RED, markersize=4.5, label="given back" if number == 0 else None)
    _rows(ax, names)
    ax.set_xlabel("restitution")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, borderaxespad=0.2)


def elastic(ax: Axes, depths: np.ndarray, curves: Sequence[tuple[str, np.ndarray, bool]]) -> None:
    """Draw forces (N) over penetration (m); a curve is (name, forces, whether it is used: the others are grey)."""
    scale = wording.scale("m", depths)
    for (name, forces, used), number in zip(curves, _counted(curves), strict=True):
        dash = ("-", "--", ":")[number // len(CURVES) % 3]
        ax.plot(
            depths / scale.factor,
            forces,
            color=CURVES[number % len(CURVES)] if used else PALE,
            linestyle=dash if used else "-",
            linewidth=1.6 if used else 1.1,
            label=name if used else None,
            zorder=2 if used else 1,
        )
    ax.set(xscale="log", yscale="log", xlabel=f"penetration [{scale.unit}]", ylabel="elastic force [N]")
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: wording.short(value, 2)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: wording.short(value, 2)))
    if not all(used for *_, used in curves):
        ax.plot([], [], color=PALE, linewidth=1.1, label="others")
    _quiet(ax)
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=2.4)


def _counted(curves: Sequence[tuple[str, np.ndarray, bool]]) -> list[int]:
    """Return how many used curves come before each."""
    return [sum(used for *_, used in curves[:place]) for place in range(len(curves))]


def _rows(ax: Axes, names: Sequence[str]) -> None:
    """Name the rows of a drawing, from the bottom up."""
    ax.set_yticks(np.arange(len(names)), names)
    ax.set_ylim(-0.6, len(names) - 0.4)
    ax.tick_params(axis="y", length=0)
    _quiet(ax)


def heat(ax: Axes, table: np.ndarray, across: Axis, up: Axis, scale: Scale, name: str) -> None:
    """Draw a figure (SI, shape (values of `up`, values of `across`), NaN where no case finished) as a heat map."""
    shown = table / scale.factor
    finite = shown[np.isfinite(shown)]
    wide = finite.size and finite.min() > 0.0 and finite.max() > DECADES * finite.min()
    norm = LogNorm(finite.min(), finite.max()) if wide else Normalize(*_ends(finite))
    ax.set_facecolor("#e8ebee")  # what shows through where no case finished
    edges = [np.arange(size + 1) - 0.5 for size in shown.shape[::-1]]
    mesh = ax.pcolormesh(
        *edges,
        np.ma.masked_invalid(shown),
        norm=norm,
        cmap="viridis",
        rasterized=shown.size > CELLS_VECTOR,
        edgecolors="face",
        linewidth=0.3,
    )
    if all(size <= most for size, most in zip(shown.shape, WRITTEN, strict=True)):
        for (row, column), value in np.ndenumerate(shown):
            known = np.isfinite(value)
            ax.text(
                column,
                row,
                wording.plain(value, 3) if known else wording.DASH,
                ha="center",
                va="center",
                fontsize=8,
                color="white" if known and norm(value) < 0.55 else "black",
            )
    _name_values(ax.xaxis, across, np.arange(len(across.values), dtype=float))
    _name_values(ax.yaxis, up, np.arange(len(up.values), dtype=float))
    ax.set(xlabel=across.label(), ylabel=up.label())
    ax.tick_params(length=0)
    _bar(ax, mesh, f"{name} [{scale.unit}]" if scale.unit else name, logarithmic=wide)


def cloud(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    colour: tuple[np.ndarray, Axis] | None,
    names: tuple[str, str],
    scales: tuple[Scale, Scale],
) -> None:
    """Draw one point per case (SI, scaled); `colour` gives each the place of its value on an axis."""
    x, y = x / scales[0].factor, y / scales[1].factor
    style = {
        "s": 16 if len(x) <= POINTS_VECTOR else 6,
        "linewidths": 0,
        "alpha": 0.85,
        "rasterized": len(x) > POINTS_VECTOR,
    }
    if colour is None:
        ax.scatter(x, y, color=BLUE, **style)
    else:
        places, axis = colour
        norm = Normalize(0, max(len(axis.values) - 1, 1))
        ax.scatter(x, y, c=places, norm=norm, cmap="viridis", **style)
        _named_bar(ax, axis, norm)
    for which, values in (("x", x), ("y", y)):
        positive = values[np.isfinite(values)]
        if positive.size and positive.min() > 0.0 and positive.max() > DECADES * positive.min():
            _logarithmic(ax, which)
    ax.set(xlabel=_with_unit(names[0], scales[0]), ylabel=_with_unit(names[1], scales[1]))
    _quiet(ax)


def histogram(
    ax: Axes, values: np.ndarray, name: str, scale: Scale, marks: tuple[float, ...], limit: float | None
) -> None:
    """Draw how values (SI, scaled) are distributed, with marked values and a limit."""
    shown = values / scale.factor
    bins = "auto" if np.ptp(shown) > 1e-9 * np.abs(shown).max() else 1
    edges = np.histogram_bin_edges(shown, bins)
    edges = edges if len(edges) <= BINS_DRAWN else np.linspace(edges[0], edges[-1], BINS_DRAWN)
    ax.hist(shown, edges, weights=np.full(len(shown), 100.0 / len(shown)), color=BLUE, alpha=0.85, linewidth=0)
    for mark in marks:
        ax.axvline(mark / scale.factor, color=INK, linewidth=0.9, linestyle=":")
    if limit is not None:
        ax.axvline(limit / scale.factor, color=RED, linewidth=1.4)
    ax.set(xlabel=_with_unit(name, scale), ylabel="cases [%]")
    _quiet(ax)


def _over_crank(ax: Axes, angle: np.ndarray, legend: bool) -> None:
    """Set up the crank angle as abscissa."""
    degrees = np.round(np.degrees(angle), 3)  # so that whole turns end on a tick
    turns = (degrees.max() - degrees.min()) / 360.0 if len(degrees) else 1.0
    step = 90 if turns <= 1.01 else 180 if turns <= 2.5 else 360 * max(1, int(np.ceil(turns / 6)))
    ax.xaxis.set_major_locator(MultipleLocator(step))
    if len(degrees):
        ax.set_xlim(degrees.min(), max(degrees.max(), degrees.min() + 1.0))
    ax.set_xlabel("crank angle [°]")
    _quiet(ax)
    if legend:
        ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2)


def _places(axis: Axis) -> tuple[np.ndarray, str]:
    """Return where the values of an axis stand on an abscissa, and its kind."""
    if not axis.numeric:
        return np.arange(len(axis.values), dtype=float), "name"
    places = np.asarray(axis.values, float) / axis.scale.factor
    return places, "log" if places.min() > 0.0 and places.max() >= 8.0 * places.min() else "linear"


def _name_values(side, axis: Axis, places: np.ndarray) -> None:
    """Write the values of a grid axis at their places; only some of the numbers where they are many."""
    longest = max(len(_short(axis, value)) for value in axis.values)
    if not axis.numeric:
        slanted = side.axis_name == "x" and len(axis.values) * (longest + 2) > WIDTH
        side.set_ticks(places, axis.values, **(SLANTED if slanted else {}))
        return
    room = TICKS_NAMED if side.axis_name == "y" else max(2, WIDTH // (longest + 2))
    way = np.log(places) if side.get_scale() == "log" else places
    named, least = [0], 0.99 * (way.max() - way.min()) / room
    for k in range(1, len(way)):
        if abs(way[k] - way[named[-1]]) >= least:
            named.append(k)
    side.set_major_locator(NullLocator())
    side.set_minor_locator(NullLocator())
    side.set_ticks(places[named], [_short(axis, axis.values[k]) for k in named])


def _short(axis: Axis, value) -> str:
    return value if isinstance(value, str) else wording.short(value / axis.scale.factor, 3)


def _logarithmic(ax: Axes, which: str) -> None:
    getattr(ax, f"set_{which}scale")("log")
    side = getattr(ax, f"{which}axis")
    side.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    side.set_major_formatter(FuncFormatter(lambda value, _: wording.short(value, 2)))
    side.set_minor_locator(NullLocator())


def _bar(ax: Axes, drawn, name: str, logarithmic: bool = False) -> None:
    bar = ax.figure.colorbar(drawn, ax=ax, fraction=0.05, pad=0.03)
    bar.set_label(name)
    bar.outline.set_visible(False)
    bar.solids.set_rasterized(True)
    if logarithmic:
        bar.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        bar.ax.yaxis.set_minor_locator(NullLocator())
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: wording.short(value, 3)))


def _named_bar(ax: Axes, axis: Axis, norm: Normalize) -> None:
    bar = ax.figure.colorbar(ScalarMappable(norm, "viridis"), ax=ax, fraction=0.05, pad=0.03)
    _name_values(bar.ax.yaxis, axis, np.arange(len(axis.values), dtype=float))
    bar.set_label(axis.label())
    bar.outline.set_visible(False)
    bar.solids.set_rasterized(True)


def _quiet(ax: Axes) -> None:
    ax.grid(color=PALE, linewidth=0.5, alpha=0.7)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)


def _ends(finite: np.ndarray) -> tuple[float, float]:
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)


def _with_unit(name: str, scale: Scale) -> str:
    return f"{name} [{scale.unit}]" if scale.unit else name
