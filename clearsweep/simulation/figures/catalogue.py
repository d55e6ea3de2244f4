"""Defines the figures of merit, one block each: name, unit, description, and formula over the sums of the motion.

A new figure needs only its block: columns, units, `until`, `limits`, the JSON Schema and all tables follow.  The order
is that of the columns.
"""

import contextlib
import dataclasses
import math
import sys
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ... import grid
from ...answers.validity import OWN_FIGURE, join_remarks
from ...contracts.case import Case, OwnFigure, Save
from ...contracts.catalogue import NOTHING, Entry, Figure, figure, shown
from ...contracts.layout import TIME, Layout
from ...contracts.results import Trajectory
from ...language.errors import InputError, did_you_mean, quoted
from ...mechanics.laws.contract import ONSET_FLOOR, compile_law
from ...mechanics.solver.integration import Work
from . import parts, peaks, wear
from .peaks import CRANK_SPEED_AFTER, FORCE_PEAK_START, PEAKS, PERIOD, SPATIAL, START_UP_TIME, finite, ideal_peak
from .sums import ForceExceeded, Mean, PerRevolution, RootMean, figure_of_joint
from .wear import LIFE
from .window import Window, by_joint

ROUNDING_ERROR = 1e-12  # m or rad: smaller errors of an output are rounding of positions of some metres or turns


def field_of_totals(name: str, of: str = "joint") -> Callable[[Window, int], float]:
    """Return the formula of a figure that is itself a field of ContactTotals or MechanismTotals."""
    return lambda window, index: getattr(window.totals.joint[index] if of == "joint" else window.totals.mechanism, name)


def output_error(window: Window, _: int) -> float:
    """Return the largest error (m or rad) of the output, 0 where it is rounding of the position."""
    error = window.totals.mechanism.error_max
    return error if error > ROUNDING_ERROR else 0.0


def relative_residual(window: Window, _: int) -> float | None:
    """Return the largest energy imbalance over the largest kinetic energy, None where it changes but nothing moves."""
    residual, kinetic = window.totals.mechanism.residual, window.totals.mechanism.kinetic_max
    if kinetic:
        return float(residual / kinetic)
    return None if residual else 0.0


def depth(window: Window, index: int) -> float:
    """Return the largest penetration (m) of the journal, negative if it never touched the bearing."""
    return float(max(window.totals.joint[index].depth_max, -window.joints[index].clearance))


def eccentricity(window: Window, index: int) -> float:
    """Return the largest distance (m) of the journal centre from the bearing centre."""
    totals = window.totals.joint[index]
    is_rolling = window.layout.joints[index].is_rolling
    return window.joints[index].clearance + (totals.eccentricity_depth if is_rolling else depth(window, index))


def restitution(window: Window, index: int) -> float | None:
    """Return the mean ratio of rebound to approach speed, 0 if a contact keeps the bodies; None without contact.

    A contact that keeps the bodies leaves a ratio below the tolerance, or never ends.
    """
    joint = window.totals.joint[index]
    if not joint.rebounds:
        return 0.0 if joint.onset_max > ONSET_FLOOR else None
    ratio = joint.restitution / joint.rebounds
    return ratio if ratio > window.case.simulate.tolerance else 0.0


def crank_speed(name: str, text: str) -> Figure:
    """Return the figure `name` of a free crank's speed; `text` describes it."""
    return figure(
        f"crank_speed_{name} [rad/s]: {text} of a free crank",
        needs=("free",),
        value=field_of_totals(f"speed_{name}", "case"),
        tables=shown(f"crank speed {name}", output=5),
    )


of_joint = partial(figure, of="joint")
of_until = partial(figure, needs=("until",), differs=False)
JOINT = (
    of_joint(
        "force_peak [N]: largest normal force in the window, located",
        value=field_of_totals("force_max"),
        tables=shown("force peak", forces=1, sample=3) + shown("peak", case=3),
    ),
    of_joint(
        "force_rms [N]: root mean square of the normal force over the window's time, free flight counting as zero",
        sums=RootMean("force_square"),
        tables=shown("force rms", forces=3, sample=2, effects=2) + shown("rms", case=2),
    ),
    of_joint(
        "force_p99 [N]: normal force exceeded during 1 % of the window's time; shorter impacts do not count",
        sums=ForceExceeded(),
        tables=shown("force p99", forces=2, sample=1, wear=60) + shown("p99", case=1),
    ),
    of_joint(
        "corner_force_peak [N]: largest normal force of a guide's corner in the window, located",
        needs=("guide",),
        value=field_of_totals("corner_force_max"),
        tables=shown("corner force peak", forces=25, if_any=True),
    ),
    of_joint(
        "corner_force_rms [N]: root mean square of the normal force of a guide's corner over the window's time, the "
        "largest of its corners",
        needs=("guide",),
        sums=RootMean("corner_force_square"),
        tables=shown("corner force rms", forces=26, if_any=True),
    ),
    of_joint(
        "impacts_per_rev [1]: contact onsets in the window per revolution or cycle; their number where nothing turns",
        sums=PerRevolution("onsets"),
        tables=shown("impacts{per_rev}", forces=6, sample=4) + shown("impacts{per_revolution}", case=6),
    ),
    of_joint(
        "contact_fraction [1]: share of the window's time in contact",
        sums=Mean("contact_time"),
        tables=shown("time in contact", forces=7, case=7),
    ),
    of_joint(
        "onset_rate_max [m/s]: largest closing rate at a contact onset",
        value=field_of_totals("onset_max"),
        tables=shown("fastest onset", forces=8, case=8),
    ),
    of_joint(
        "yield_speed [m/s]: approach speed at which the contact first yields, by its elastic law and the largest "
        "effective mass at the start of the run; null: unknown",
        needs=("strength",),
        differs=False,
        tables=shown("first yield from", forces=8, if_any=True),
    ),
    of_joint(
        "onset_rate [m/s]: onset rate that the contact's law uses at the end of the window; null: no contact, or it "
        "uses none",
        value=lambda window, index: finite(window.onset_rate[index]),
        differs=False,
        null=NOTHING,
    ),
    of_joint(
        "penetration_max [m]: largest penetration",
        value=lambda window, index: max(depth(window, index), 0.0),
        tables=shown("penetration", forces=9),
    ),
    of_joint(
        "eccentricity_max [m]: largest distance of the journal centre from the bearing centre; of a guide or a joint "
        "in space, clearance plus largest penetration of a corner or wall",
        value=eccentricity,
    ),
    of_joint(
        "law_limit_fraction [1]: share of the window's time at a penetration beyond the elastic law's range",
        sums=Mean("beyond_time"),
        tables=shown("time past its law's range", forces=10, if_any=True),
    ),
    of_joint(
        "force_clips [1]: number of times that a contact force became tensile and was clipped at zero",
        value=field_of_totals("clips"),
        tables=shown("clips", forces=11, if_any=True),
    ),
    of_joint(
        "friction_power [W]: mean power of dry friction over the window",
        needs=("friction",),
        sums=Mean("friction_energy"),
        tables=(Entry("forces", "friction power", 12, if_any=True), Entry("case", "friction power", 8)),
    ),
    of_joint(
        "temperature [K]: temperature of both bodies of a dry joint, from its heat balance",
        needs=("thermal",),
        value=lambda window, index: window.case.joints[index].temperature,
        tables=(Entry("forces", "temperature", 13, if_any=True), Entry("case", "temperature", 9)),
    ),
    of_joint(
        "clearance_warm [m]: radial clearance at that temperature",
        needs=("thermal",),
        value=lambda window, index: window.case.joints[index].clearance,
        tables=(Entry("forces", "warm clearance", 14, if_any=True), Entry("case", "warm clearance", 10)),
    ),
    of_joint(
        "temperature_ci [K]: half-width of the 95 % interval of that temperature, from the revolutions",
        needs=("thermal",),
        differs=False,
    ),
    of_joint(
        "force_peak_ideal [N]: largest reaction of the same joint in the ideal mechanism; null: no stop touches there",
        needs=("turns",),
        value=ideal_peak,
        differs=False,
        tables=shown("ideal peak", forces=4, case=4),
    ),
    *peaks.FILM,
    *PEAKS,
    FORCE_PEAK_START,
    *SPATIAL,
    *parts.ROLLING,
    *wear.WEAR,
    *LIFE,
    *parts.FLANKED,
    of_joint(
        "restitution [1]: mean ratio of rebound speed to approach speed; 0: the surfaces never part; null: no rebound "
        "after an approach of more than 1 mm/s",
        needs=("rests",),
        value=restitution,
        tables=shown("restitution", output=50, sample=50, effects=6),
        null=NOTHING,
    ),
)
MECHANISM = (
    figure(
        "acceleration_peak [{output}/s^2]: largest absolute {output} acceleration",
        of="output",
        value=field_of_totals("acceleration_max", "output"),
        tables=shown("{output} acc. peak", output=2, sample=21),
    ),
    figure(
        "acceleration_rms [{output}/s^2]: root mean square of the {output} acceleration over time",
        of="output",
        sums=RootMean("acceleration_square"),
        tables=shown("{output} acc. rms", output=3),
    ),
    figure(
        "error_max [{output}]: largest distance of the {output} from its position in the ideal mechanism",
        of="output",
        value=output_error,
        tables=shown("{output} error", output=1, forces=12, sample=20, case=9, effects=5),
    ),
    crank_speed("min", "least speed"),
    crank_speed("max", "largest speed"),
    START_UP_TIME,
    CRANK_SPEED_AFTER,
    figure(
        "crank_torque_peak [N*m]: largest absolute drive torque",
        needs=("turns",),
        value=field_of_totals("torque_max", "case"),
        tables=shown("crank torque peak", output=4, sample=22),
    ),
)
#: Figures of observed runs only, under these names: see `Perturbed` and `ConvergenceObserver`.
OBSERVED = (
    figure(
        "lyapunov_exponent [1/s]: largest Lyapunov exponent: mean rate at which a disturbance grows",
        needs=("horizon",),
        tables=shown("Lyapunov exponent", certainty=6),
    ),
    figure(
        "horizon_revolutions [1]: revolutions until a disturbance grows from tolerance times clearance to 1 % of the "
        "clearance; null: never",
        needs=("horizon",),
        differs=False,
        tables=shown("horizon (rev.)", certainty=7),
    ),
    of_until("revolutions_run [1]: length of the run, `discard` included", tables=shown("revolutions", certainty=1)),
    of_until(
        "window_from [1]: revolutions before the window of the figures: `discard`, or those before the motion was "
        "found to be periodic"
    ),
    of_until(
        "settled [1]: 1: the interval is narrow enough; 0: max_revolutions ended the run",
        kind="int",
        tables=shown("settled", certainty=3),
    ),
    of_until(
        "figure_ci [{until}]: half-width of the 95 % interval of {until}, from blocks of revolutions",
        tables=shown("95 % interval, half", certainty=5),
    ),
)
RESIDUAL = figure(
    "energy_residual [1]: largest energy imbalance at a step or event end over the largest kinetic energy",
    value=relative_residual,
    differs=False,
)
#: Work counts of a case, even if it failed; further runs are included.
WORK_COUNTS = (
    figure("steps [1]: accepted steps", value=lambda window, _: window.counts.steps, kind="int", differs=False),
    figure(
        "steps_rejected [1]: rejected steps", value=lambda window, _: window.counts.rejected, kind="int", differs=False
    ),
    figure(
        "rhs_evaluations [1]: evaluations of the equations of motion, including those that locate events",
        value=lambda window, _: window.counts.evaluations,
        kind="int",
        differs=False,
    ),
    figure(
        "run_time [s]: processor time of the integration",
        value=lambda window, _: window.integration_time,
        differs=False,
    ),
)
#: Known last; the caller that solves a case sets it.
SETUP = figure(
    "setup_time [s]: processor time of the ideal mechanism and the figures; not part of run_time", differs=False
)
FIGURES = (*JOINT, *MECHANISM, *parts.LINKS, *parts.VIBRATION, *PERIOD, *OBSERVED, RESIDUAL, *WORK_COUNTS, SETUP)


def column_of(layout: Layout, name: str) -> tuple[Figure, int | None]:
    """Return the figure of a column of the summary and the index of its joint, or None."""
    column = next(column for column in layout.columns if column.name == name)
    figure = next(figure for figure in FIGURES if figure.name == column.figure)
    return figure_of_joint(figure, layout, column.joint), _joint_indices(layout).get(column.joint)


def _joint_indices(layout: Layout) -> dict[str, int]:
    indices = {joint.name: index for index, joint in enumerate(layout.joints)}
    return indices | {joint: index for index, joint in enumerate(layout.rubbing)}


def figures_of(window: Window, *, failed: bool = False) -> dict:
    """Return all columns: figures that follow from sums, None for others; for a `failed` run only the work counts."""
    formulas_of_layout = layout_formulas(window.layout)
    values = formulas_of_layout.empty_columns.copy()
    for name, formula, index, kind in formulas_of_layout.work_formulas if failed else formulas_of_layout.formulas:
        value = formula(window, index)
        values[name] = value if value is None else kind(value)
    return values


_Formula = tuple[str, Callable, int | None, type]  # (column, formula of its figure, index of its joint, kind of number)


class LayoutFormulas(NamedTuple):
    """Values that all cases of a layout share."""

    layout: Layout | None
    figures: tuple[Figure, ...]  # FIGURES
    empty_columns: dict[str, None]  # its columns
    units: dict[str, str]  # of columns and channels
    formulas: list[_Formula]
    work_formulas: list[_Formula]  # columns of work counts


_LATEST_FORMULAS = [LayoutFormulas(None, (), {}, {}, [], [])]  # result of the last call


def layout_formulas(layout: Layout) -> LayoutFormulas:
    """Return the values that all cases of a layout share, created once for successive cases."""
    if _LATEST_FORMULAS[0].layout is not layout or _LATEST_FORMULAS[0].figures is not FIGURES:
        blank = dict.fromkeys(column.name for column in layout.columns)
        formulas, cost = _formulas(layout, FIGURES), _formulas(layout, WORK_COUNTS)
        _LATEST_FORMULAS[0] = LayoutFormulas(layout, FIGURES, blank, layout.units, formulas, cost)
    return _LATEST_FORMULAS[0]


def _formulas(layout: Layout, figures: tuple[Figure, ...]) -> list[_Formula]:
    """Return the formulas of the columns of some figures in a layout."""
    figures_by_name, indices = {figure.name: figure for figure in figures}, _joint_indices(layout)
    formulas: list[_Formula] = []
    for column in layout.columns:
        figure = column.figure in figures_by_name and figure_of_joint(
            figures_by_name[column.figure], layout, column.joint
        )
        formula = figure and (figure.sums.value if figure.settles else figure.value)
        if figure and formula:
            formulas.append((column.name, formula, indices.get(column.joint), int if figure.kind == "int" else float))
    return formulas


# 95 % intervals of figures from blocks of revolutions (batch means).
#
# A figure is computed for blocks of equal numbers of revolutions, from the growth of its sums in each. Its interval is
# that of the mean of the blocks, see `sums.half_width`. As a run grows, blocks are merged in pairs whenever there are
# more than MAX_BLOCKS, which reduces their dependence. In a periodic motion every block is a period.
#
# A figure that is the same in all blocks is not known for that reason: the event that changes it may still come. Its
# interval is that of what was not observed.

MIN_REVOLUTIONS = 30  # fewer revolutions of a chaotic motion make the interval unreliable
MAX_BLOCKS = 32  # more do not improve the interval
UNOBSERVED = 3.0  # divided by the revolutions: upper end of the 95 % interval of the rate of an unobserved event
EQUAL_TOLERANCE = 1e-9  # relative: figures of blocks that differ by less, the rounding of their sums, are equal


class Interval(NamedTuple):
    """Mean of a figure over the blocks, and its interval."""

    value: float
    half_width: float  # half-width of the 95 % interval, in the unit of the figure; inf if unknown
    blocks: int
    revolutions: int  # in all blocks

    def within(self, relative: float) -> bool:
        """Return whether the half-width is at most `relative` times the value."""
        return self.half_width <= relative * abs(self.value)


class Blocks:
    """Sums of some figures of a scene at the ends of the blocks of a run."""

    def __init__(self, layout: Layout, figures: Iterable[str], period: int | None = None):
        """Prepare for the start of a window; `period` : revolutions of a periodic motion, whose blocks are periods."""
        self.layout = layout
        self.figures = {name: column_of(layout, name) for name in figures}
        # time (s) and figure -> its sums, at the start of the first block and the end of every one
        self.sums_at_ends: list[tuple[float, dict[str, Any]]] = []
        self.turns, self.stride = 0, period or 1  # revolutions recorded, and revolutions in a block
        self.period = period

    def record(self, work: Work) -> bool:
        """Record the sums at the end of a revolution of a run (integration.Work); return whether a block ends here."""
        is_block_end = self.turns % self.stride == 0
        self.turns += 1
        if is_block_end:
            contact_totals: Any = work.totals  # mypy takes it for a tuple of anything
            totals = by_joint(contact_totals, self.layout)
            sums = {name: figure.sums.take(totals, index) for name, (figure, index) in self.figures.items()}
            self.sums_at_ends.append((float(work.y[work.time]), sums))
            if len(self.sums_at_ends) > MAX_BLOCKS + 1:
                del self.sums_at_ends[1::2]
                self.stride *= 2
        return is_block_end

    def interval(self, name: str) -> Interval:
        """Return the mean of a figure over all blocks, and its interval."""
        if len(self.sums_at_ends) < 2:
            return Interval(math.nan, math.inf, 0, 0)
        times = np.array([time for time, _ in self.sums_at_ends])
        figure, _ = self.figures[name]
        value, half_width = figure.sums.over_blocks(
            times, [sums_at_end[name] for _, sums_at_end in self.sums_at_ends], self.stride
        )
        blocks = len(times) - 1
        revolutions = blocks * self.stride
        if self.period is None and half_width <= EQUAL_TOLERANCE * abs(value):
            half_width = UNOBSERVED / revolutions if figure.unit == "1" else math.inf
        return Interval(float(value), float(half_width), blocks, revolutions)


# ---------------------------------------------------------------------------------------------- figures of one's own


def records_samples(case: Case) -> bool:
    """Return whether a run of a case records samples: some are saved, or figures of one's own need them."""
    return case.save.orbits != "none" or bool(case.figures)


def recorded_part(case: Case) -> Save:
    """Return settings that save at least what a run of a case records."""
    return case.save._replace(orbits="all") if case.figures else case.save


def first_sample(case: Case) -> int:
    """Return the number of the first sample that a run of a case records."""
    return min(_first_saved(case), _first_in_window(case)) if case.figures else _first_saved(case)


def _first_saved(case: Case) -> int:
    save, revolutions = case.save, case.simulate.revolutions
    return round((revolutions - save.revolutions) * save.samples) if save.orbits == "last" else 0


def _first_in_window(case: Case) -> int:
    return math.ceil(case.simulate.discard * case.save.samples - 1e-9)


def with_own_figures(case: Case, trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with the figures of one's own of a case, and with the samples that the case saves only.

    A figure that fails, or gives no finite number, is missing, and a remark says why.
    """
    if not case.figures:
        return trajectory
    first = first_sample(case)
    histories = {name: values[_first_in_window(case) - first :] for name, values in trajectory.channels.items()}
    values, remarks = dict[str, float](), list[str]()
    for own in case.figures if trajectory.status == "ok" else ():
        try:
            values[own.name] = _value_of(own, case, histories)
        except InputError as error:
            remarks.append(f"{OWN_FIGURE}figures.{own.name}: {error}")
    saved = {name: samples[_first_saved(case) - first :] for name, samples in trajectory.channels.items()}
    return dataclasses.replace(
        trajectory,
        summary=trajectory.summary | values,
        message=join_remarks(trajectory.message, *remarks),
        channels={} if case.save.orbits == "none" else saved,
    )


class Channels(dict[str, np.ndarray]):
    """Time histories by the name of their channel."""

    unknown = ""  # a channel that was asked for in vain

    def __missing__(self, name: Any) -> np.ndarray:
        self.unknown = str(name)
        hint = did_you_mean(str(name), self) or f" (known: {', '.join(self)})"
        raise InputError(f"there is no channel {quoted(name)}{hint}")


def check_channels(case: Case, names: Iterable[str]) -> None:
    """Raise InputError if a figure of one's own reads a channel that a case does not have.

    The samples are made up, so that any other failure means nothing.
    """
    for own in case.figures:
        channels, mistake = Channels({name: np.ones(2) for name in names}), ""
        try:
            with np.errstate(all="ignore"), grid.guarded(case.law_files):
                _evaluated(own, case, channels)
        except InputError as error:
            mistake = str(error)
        if channels.unknown:
            raise InputError(f"figures.{own.name}.law: {mistake}")


def _evaluated(figure: OwnFigure, case: Case, channels: Channels) -> Any:
    """Return what the function of a figure returns.  Raises InputError."""
    for samples in channels.values():
        samples.flags.writeable = False
    owner: Any = figure  # of the law, as a joint is of others
    evaluate: Callable = compile_law("figure", figure.law, owner)
    with grid.reported(case.law_files), contextlib.redirect_stdout(sys.stderr):
        return evaluate(channels[TIME], channels)


def _value_of(figure: OwnFigure, case: Case, histories: dict[str, np.ndarray]) -> float:
    """Return a figure from the samples of the window; raise InputError if it fails or gives no finite number."""
    value = _evaluated(figure, case, Channels({name: samples.view() for name, samples in histories.items()}))
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    place = next(law.origin for file in case.law_files for law in file.laws if law.name == figure.law)
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise InputError(f"{place}: laws.figure '{figure.law}' gives {quoted(value)}; expected a number")
    if not math.isfinite(value):
        raise InputError(f"{place}: laws.figure '{figure.law}' gives {float(value)}; expected a finite number")
    return float(value)
