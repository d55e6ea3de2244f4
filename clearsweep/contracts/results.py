"""Results of a case: figures, events, wear and time histories.  Their meaning is in `layout`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    import xarray  # optional; imported only on demand

EVENT_KINDS = ("on", "off")
EVENT_DTYPE = np.dtype([("t", "f8"), ("joint", "U16"), ("kind", "U3"), ("rate", "f8"), ("force_peak", "f8")])
PARTIAL_STATUSES = ("stalled", "time-limit")  # of a free crank, whose motion up to there is as good as any other
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
        from .preview import preview_html

        return preview_html(repr(self), self.channels, self.summary, self.units)

    def to_xarray(self) -> "xarray.Dataset":
        """Return the time histories as an xarray.Dataset over `t` (s), unit of each and figures in `attrs`.

        Needs xarray, which `pip install "clearsweep[xarray]"` installs; an ImportError says so.
        """
        try:
            import xarray
        except ImportError as error:
            raise ImportError('to_xarray needs xarray: pip install "clearsweep[xarray]"') from error
        histories = {
            name: ("t", values, {"units": self.units.get(name, "")})
            for name, values in self.channels.items()
            if name != "t"
        }
        figures = {name: value for name, value in self.summary.items() if value is not None}
        return xarray.Dataset(
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
        if name.removeprefix(HISTORY) in self.history:
            return self.history[name.removeprefix(HISTORY)]
        if name not in self.channels:
            raise KeyError(
                f"no channel {name!r}; there are {', '.join(self.channels) or 'none (no history was asked for)'}"
            )
        return self.channels[name]
