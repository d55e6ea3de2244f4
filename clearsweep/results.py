"""What a case gives: the names, units and meaning of its figures and time histories, and the values themselves."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .case import Case

#: Approach speed in m/s above which steel may yield: about 1e-5 sqrt(E/rho), E = 207 GPa, rho = 7850 kg/m^3.
#: Love's criterion for impacts that stay elastic, as Lankarani and Nikravesh 1990 use it.
ELASTIC_ONSET = 0.05

EVENT_KINDS = ("on", "off")
EVENT_DTYPE = np.dtype([("t", "f8"), ("joint", "U16"), ("kind", "U3"), ("rate", "f8"), ("force_peak", "f8")])


class JointLayout(NamedTuple):
    """The optional parts of one clearance joint that decide what is stored about it."""

    name: str  # 'rod_slider': the name of the joint in columns and channels
    wear_bins: int = 0  # angular bins of each body; 0 where no wear is computed


class Layout(NamedTuple):
    """What a scene has; every case of a grid shares it, and columns and datasets follow from it alone."""

    mechanism: str  # 'slider-crank' or 'impact-pair'
    joints: tuple[JointLayout, ...]  # in the order ground_crank, crank_rod, rod_slider (those with clearance)
    horizon: bool = False  # simulate.horizon
    error_check: bool = False  # simulate.error_check
    until: str = ""  # simulate.until.figure

    @classmethod
    def of(cls, case: Case) -> "Layout":
        """Return the layout of a case, and so of all cases of its grid."""
        joints = tuple(JointLayout(joint.column, joint.wear.bins if joint.wear else 0) for joint in case.joints)
        simulate = case.simulate
        until = simulate.until.figure if simulate.until else ""
        return cls(case.mechanism.type, joints, simulate.horizon, simulate.error_check, until)


class Column(NamedTuple):
    """A figure of merit of one case (a column of the summary) or a time history (a channel of the orbits)."""

    name: str
    unit: str
    description: str
    kind: str = "float"  # 'float', 'int' or 'text'


def summary_columns(layout: Layout) -> tuple[Column, ...]:
    """Return the figures of merit that a scene of this layout has, in the order of the summary's columns."""
    columns = []
    for joint in layout.joints:
        columns += [Column(f"{joint.name}_{name}", unit, text) for name, unit, text in _JOINT_FIGURES]
        if layout.mechanism == "slider-crank":
            columns.append(
                Column(
                    f"{joint.name}_force_peak_ideal", "N", "largest reaction of the same joint in the ideal mechanism"
                )
            )
        if joint.wear_bins:
            columns += [Column(f"{joint.name}_{name}", unit, text) for name, unit, text in _WEAR_FIGURES]
    if layout.mechanism == "slider-crank":
        columns += _SLIDER_CRANK_FIGURES
    else:
        columns.append(Column("pair_restitution", "1", "mean of rebound over approach speed"))
    units = {column.name: column.unit for column in columns}
    if layout.horizon:
        columns.append(_EXPONENT)
    if layout.error_check:
        columns = [beside for column in columns for beside in (column, *_difference(column))]
    if layout.horizon:
        columns.append(_HORIZON)
    if layout.until:
        text = f"half-width of the 95 % interval of {layout.until}, from blocks of revolutions"
        columns += [*_LENGTH_FIGURES, Column("figure_ci", units.get(layout.until, "1"), text)]
    return (*columns, *_COST_FIGURES)


def _difference(column: Column) -> tuple[Column, ...]:
    """Return the column in which the error check of a figure stands; none for what does not depend on the motion."""
    if column.name.endswith("_ideal"):
        return ()
    text = f"absolute difference of {column.name} from a run at a tenth of the tolerance"
    return (Column(f"{column.name}{DIFFERENCE}", column.unit, text),)


def differ(summary: dict, tighter: dict) -> None:
    """Enter into a summary how far its figures are from those at a tighter tolerance, and add what the latter cost."""
    for name in [name for name in summary if name.endswith(DIFFERENCE)]:
        values = (summary[name.removesuffix(DIFFERENCE)], tighter[name.removesuffix(DIFFERENCE)])
        summary[name] = None if None in values else abs(values[0] - values[1])
    for name in ("steps", "steps_rejected", "rhs_evaluations", "run_time"):
        summary[name] += tighter[name]


def settling(layout: Layout) -> tuple[str, ...]:
    """Return the figures that settle as a run grows longer, so that its blocks give them an interval."""
    names = [f"{joint.name}_{name}" for joint in layout.joints for name in _SETTLING]
    names += [f"{joint.name}_wear_rate_max" for joint in layout.joints if joint.wear_bins]
    return (*names, "slider_acceleration_rms")


_JOINT_FIGURES = (
    ("force_peak", "N", "largest normal force in the window, located"),
    ("force_rms", "N", "root mean square of the normal force over the window's time, free flight counting as zero"),
    ("force_p99", "N", "normal force exceeded during 1 % of the window's time"),
    ("impacts_per_rev", "1", "contact onsets in the window per revolution (impact-pair: in all)"),
    ("contact_fraction", "1", "share of the window's time in contact"),
    ("onset_rate_max", "m/s", "largest closing rate at a contact onset"),
    ("penetration_max", "m", "largest penetration"),
    ("eccentricity_max", "m", "largest distance of the journal centre from the bearing centre"),
    ("law_limit_fraction", "1", "share of the window's time at a penetration beyond the elastic law's range"),
    ("force_clips", "1", "times a contact's force law turned to traction and was clipped at zero"),
)
_WEAR_FIGURES = (
    ("wear_depth_max", "m", "largest wear depth in the window, of both bodies"),
    ("wear_rate_max", "m/s", "largest wear depth over the window's time"),
    ("wear_volume", "m^3", "volume worn off both bodies in the window"),
    ("wear_narrow_arcs", "1", "contact arcs narrower than five wear bins when worn (share of the wear steps)"),
)
_SLIDER_CRANK_FIGURES = (
    Column("slider_acceleration_peak", "m/s^2", "largest slider acceleration, absolute"),
    Column("slider_acceleration_rms", "m/s^2", "root mean square of the slider acceleration over time"),
    Column("slider_error_max", "m", "largest distance of the slider from its place in the ideal mechanism"),
    Column("crank_torque_peak", "N*m", "largest drive torque, absolute"),
)
_SETTLING = ("force_rms", "force_p99", "impacts_per_rev", "contact_fraction", "law_limit_fraction")
DIFFERENCE = "_difference"  # what the name of a figure's error check ends in
_EXPONENT = Column("lyapunov_exponent", "1/s", "largest Lyapunov exponent: mean rate at which a disturbance grows")
_HORIZON = Column(
    "horizon_revolutions",
    "1",
    "revolutions until a disturbance of the tolerance times the clearance is 1 % of the clearance; null: it never is",
)
_LENGTH_FIGURES = (
    Column("revolutions_run", "1", "length of the run, `discard` included"),
    Column("period", "1", "revolutions after which the motion repeats itself; null: it was not seen to", "int"),
    Column("settled", "1", "1: periodic, or the interval is narrow enough; 0: max_revolutions ended the run", "int"),
)
_COST_FIGURES = (
    Column("energy_residual", "1", "largest energy imbalance at a step or event end over the largest kinetic energy"),
    Column("steps", "1", "accepted steps", "int"),
    Column("steps_rejected", "1", "rejected steps", "int"),
    Column("rhs_evaluations", "1", "evaluations of the equations of motion, locating events included", "int"),
    Column("run_time", "s", "time spent integrating"),
)


#: Figures that differ from run to run of the same case.
TIMINGS = frozenset({"run_time"})


def channels(layout: Layout) -> tuple[Column, ...]:
    """Return the time histories a scene of this layout has, `t` first."""
    head = [Column("t", "s", "time")]
    if layout.mechanism == "impact-pair":
        head += [
            Column("pair/x", "m", "displacement of the second body relative to the first"),
            Column("pair/v", "m/s", "its rate"),
        ]
    else:
        head += _SLIDER_CRANK_CHANNELS
    for joint in layout.joints:
        head += [Column(f"joints/{joint.name}/{name}", unit, text) for name, unit, text in _JOINT_CHANNELS]
    return tuple(head)


_SLIDER_CRANK_CHANNELS = (
    Column("crank_angle", "rad", "crank angle, unwrapped"),
    Column("crank/torque", "N*m", "drive torque on the crank"),
    Column("slider/x", "m", "position of the slider"),
    Column("slider/v", "m/s", "velocity of the slider"),
    Column("slider/a", "m/s^2", "acceleration of the slider"),
    Column("rod/angle", "rad", "angle of the line from crank pin to slider pin, counter-clockwise"),
    Column("rod/rate", "rad/s", "its rate"),
    Column("rod/x", "m", "rod's centre of mass, x"),
    Column("rod/y", "m", "rod's centre of mass, y"),
    Column("rod/vx", "m/s", "velocity of the rod's centre of mass, x"),
    Column("rod/vy", "m/s", "velocity of the rod's centre of mass, y"),
)
_JOINT_CHANNELS = (
    ("x", "m", "journal centre relative to the bearing centre, fixed frame, x"),
    ("y", "m", "journal centre relative to the bearing centre, fixed frame, y"),
    ("vx", "m/s", "its rate, x"),
    ("vy", "m/s", "its rate, y"),
    ("force_normal", "N", "normal force, at least 0, pushing the journal back to the centre"),
    ("force_tangential", "N", "tangential force on the journal along the outward normal turned by +90 degrees"),
)


@dataclass(frozen=True)
class Trajectory:
    """One case's result: histories by channel name, events, wear, figures of merit, and how the run ended.

    Attributes
    ----------
    channels : dict of str to (n,) float64 array; `t` in s is one of them. Empty where no history was asked for.
    events : structured array (EVENT_DTYPE) of the whole run: t (s), joint, kind, rate (m/s, closing positive),
        force_peak (N, largest normal force of the contact that ends there, 0 at an onset).
    wear : dict of joint name to (bearing, journal), each a (bins,) array of depths in m.
    summary : dict of column name to value; None for what could not be computed.
    status, message : 'ok' and '', or a word and the sentence that explains it.
    """

    status: str
    message: str
    summary: dict
    channels: dict = field(default_factory=dict)
    events: np.ndarray = field(default_factory=lambda: np.empty(0, EVENT_DTYPE))
    wear: dict = field(default_factory=dict)

    @property
    def t(self) -> np.ndarray:
        """Times of the samples, s."""
        return self.channels.get("t", np.empty(0))

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the time history called `name`; a KeyError names those there are."""
        if name not in self.channels:
            raise KeyError(
                f"no channel {name!r}; there are {', '.join(self.channels) or 'none (no history was asked for)'}"
            )
        return self.channels[name]
