"""Results of a case: figures, events, wear and time histories.  Their meaning is in `layout`."""

import html
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..language import wording

if TYPE_CHECKING:
    import xarray  # optional; imported only on demand

EVENT_KINDS = ("on", "off")
#: Of an event; longer names of contacts widen `joint`.
EVENT_DTYPE = np.dtype([("t", "f8"), ("joint", "U16"), ("kind", "U3"), ("rate", "f8"), ("force_peak", "f8")])
PARTIAL_STATUSES = ("stalled", "time-limit")  # of a free crank, whose motion up to there is as good as any other
OUTSIDE_MODEL = "bent-too-far"  # a link deflected beyond what its model describes
HISTORY = "history/"  # prefix of a life's datasets
#: Figures that differ between runs of the same case.
TIMINGS = frozenset({"run_time", "setup_time"})


class Peak(NamedTuple):
    """The revolution of a case with its largest normal force."""

    turns: float  # revolutions before its first sample
    path: "Trajectory"  # up to its end; it has histories of this revolution only


@dataclass(frozen=True, repr=False)
class Trajectory:
    """One case's result: histories by channel name, events, wear, figures of merit, and how the run ended.

    Attributes
    ----------
    channels : dict of str to (n,) float64 array; `t` in s is one of them. Empty if no history was requested.
    events : structured array (EVENT_DTYPE) of the whole run: t (s), joint, kind, rate (m/s, closing positive),
        force_peak (N, largest normal force of the contact that ends there, 0 at an onset).
    wear : dict of joint name to (bearing, journal), each a (bins,) array of depths in m, of a joint in space
        (bins, length bins).
    poincare : dict of 'poincare/rod_slider/x' and the like to (revolutions,) arrays: journal x, y (m), vx, vy (m/s) at
        crank angle 0 of every revolution, and its number 'poincare/revolution'. Empty if no history was stored.
    history : dict of 'revolutions', 'rod_slider/wear_depth_max' and the like to (nodes, ...) arrays: the course
        of a life from its first block to its limit, as below `history/` in orbits.h5. Empty without `life`.
    summary : dict of column name to value; None if a value could not be computed.
    status, message : 'ok' and '', or a word and the sentence that explains it.
    units : dict of channel or column name to SI unit.
    """

    status: str
    message: str
    summary: dict[str, Any]
    channels: dict[str, np.ndarray] = field(default_factory=dict)
    events: np.ndarray = field(default_factory=lambda: np.empty(0, EVENT_DTYPE))
    wear: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    poincare: dict[str, np.ndarray] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    history: dict[str, np.ndarray] = field(default_factory=dict)

    def __repr__(self) -> str:
        if self.status != "ok":
            return f"<Trajectory {self.status}: {self.message}>"
        span = f" from {self.t[0]:.6g} to {self.t[-1]:.6g} s" if self.t.size else ""
        life = f", a life of {self.history['revolutions'][-1]:.6g} revolutions" if self.history else ""
        return (
            f"<Trajectory ok: {self.t.size:,} samples of {len(self.channels)} channels{span}, {len(self.events):,} "
            f"events, {len(self.summary)} figures{life}{f'; {self.message}' if self.message else ''}>"
        )

    def _repr_html_(self) -> str:
        """Return the preview for a notebook: orbits and normal forces of the joints, and figures with units."""

        joints = [name.split("/")[1] for name in self.channels if name.endswith("/force_normal")]
        drawings = "".join(drawing for joint in joints for drawing in _joint_drawings(self.channels, joint))
        rows = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{_figure_text(value, self.units.get(name, '1'))}</td></tr>"
            for name, value in self.summary.items()
        )
        figure_table = f"<details><summary>{len(self.summary)} figures</summary><table>{rows}</table></details>"
        return f"<p><code>{html.escape(repr(self))}</code></p><div>{drawings}</div>{figure_table}"

    def samples(self, name: str) -> np.ndarray:
        """Return the time history (n,) of a channel; nan if the case has none, such as elements of a larger bearing."""
        return self.channels.get(name, np.full(len(self.t), np.nan))

    def to_xarray(self) -> "xarray.Dataset":
        """Return the time histories as an xarray.Dataset over `t` (s), unit of each and figures in `attrs`.

        Needs xarray, which `pip install "clearsweep[xarray]"` installs; an ImportError says so.
        """
        histories = {
            name: ("t", values, {"units": self.units.get(name, "")})
            for name, values in self.channels.items()
            if name != "t"
        }
        figures = {name: value for name, value in self.summary.items() if value is not None}
        return dataset(
            histories, {"t": ("t", self.t, {"units": "s"})}, {"status": self.status, "message": self.message} | figures
        )

    @property
    def t(self) -> np.ndarray:
        """Return the times of the samples, s."""
        return self.channels.get("t", np.empty(0))

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the time history called `name`; a KeyError names the available ones."""
        if name in self.poincare:
            return self.poincare[name]
        name = str(name)
        if name.removeprefix(HISTORY) in self.history:
            return self.history[name.removeprefix(HISTORY)]
        if name not in self.channels:
            message = f"no channel {name!r}; there are {', '.join(self.channels) or 'none (no history was asked for)'}"
            raise KeyError(message)
        return self.channels[name]


def dataset(
    variables: Mapping[str, Any], coordinates: Mapping[str, Any], attributes: Mapping[str, Any]
) -> "xarray.Dataset":
    """Return an xarray.Dataset; where xarray is missing, an ImportError says how to install it."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError('to_xarray needs xarray: pip install "clearsweep[xarray]"') from error
    return xarray.Dataset(variables, coordinates, attributes)


# HTML preview of a trajectory in a notebook: figures and two small drawings of each joint, without a library.

SIZE, MARGIN = 200, 6  # size of a drawing and margin around it, px
MAX_POINTS = 2000  # points of a curve


def _figure_text(value: object, unit: str) -> str:
    return wording.quantity_text(float(value), unit, 5) if isinstance(value, int | float) else wording.DASH


def _joint_drawings(channels: Mapping[str, np.ndarray], joint: str) -> list[str]:
    """Return drawings of a joint's journal orbit and of its normal force over time."""
    joint_name, force = wording.joint_name(joint), channels[f"joints/{joint}/force_normal"]
    x, y = channels[f"joints/{joint}/x"], channels[f"joints/{joint}/y"]
    eccentricity_text = wording.quantity_text(float(np.hypot(x, y).max()), "m")
    force_text = wording.quantity_text(float(force.max()), "N")
    force_title = f"{joint_name}: normal force over time, up to {force_text}"
    orbit_title = f"{joint_name}: orbit, up to {eccentricity_text}"
    return [_curve_svg(x, y, orbit_title, equal=True), _curve_svg(channels["t"], force, force_title, width=2 * SIZE)]


def _curve_svg(x: np.ndarray, y: np.ndarray, caption: str, *, width: int = SIZE, equal: bool = False) -> str:
    """Return a curve with its title as SVG; `equal`: both axes have the same scale."""
    stride = max(1, len(x) // MAX_POINTS)
    x, y = np.asarray(x[::stride]), np.asarray(y[::stride])
    centres = [(values.max() + values.min()) / 2.0 for values in (x, y)]
    half_ranges = [np.ptp(x) / 2.0, np.ptp(y) / 2.0]
    half_ranges = [max(half_ranges)] * 2 if equal else half_ranges
    x_pixels = width / 2 + (width / 2 - MARGIN) * (x - centres[0]) / (half_ranges[0] or 1.0)
    y_pixels = SIZE / 2 - (SIZE / 2 - MARGIN) * (y - centres[1]) / (half_ranges[1] or 1.0)
    point_list = " ".join(f"{x_pixel:.1f},{y_pixel:.1f}" for x_pixel, y_pixel in zip(x_pixels, y_pixels, strict=True))
    return (
        f'<figure style="display:inline-block;margin:0 1em 0 0"><figcaption>{html.escape(caption)}</figcaption>'
        f'<svg width="{width}" height="{SIZE}" role="img" aria-label="{html.escape(caption)}">'
        f'<polyline fill="none" stroke="#0072B2" stroke-width="0.8" points="{point_list}"/></svg></figure>'
    )
