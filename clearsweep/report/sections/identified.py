"""Results of `identify`, and measured signals over computed ones."""

import itertools
import math
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from ...answers import features
from ...answers.questions import certainty_text, identification_sentences
from ...grid.written.tables import MeasuredSignals, read_signals
from ...language import wording
from ...language.errors import InputError
from ..axis import Axis
from ..blocks.section import Block, Gallery, Picture, Section, Sentences, capitalise, section, without_empty
from ..blocks.table import Column, Quantity, Table, columns_of
from ..draw import BLUE, RED, set_plain_axes
from ..one_case.motion import saved_channels
from ..plot import BLUES, Axes, ColourScale
from ..study import Study

# Comparison of measured and computed signals: the nearest case, the offset of the crank angle.

MIN_REVOLUTIONS = 3  # revolutions required in a measurement
MAX_CASES = 200  # compared cases; of more, evenly spaced ones
ACCELERATION = "acceleration"  # header of the output body's acceleration


class SignalComparison(NamedTuple):
    """One measured signal and the computed one of a case; SI."""

    channel: str
    unit: str
    file: str
    case_id: str
    compared: int  # cases
    measured: np.ndarray  # (turns, samples of a revolution), with corrected crank angle
    computed: np.ndarray  # the same of the case
    angle: float  # rad, offset of the measured angle
    misfit: float  # rms of the difference of the mean revolutions over the rms measured


def compare_signals(study: Study, file: str | PathLike) -> list[SignalComparison]:
    """Return the signals of a file with those of the nearest case; raise InputError if they cannot be compared."""
    stored = study.run.layout.stored
    units = {
        channel.name: channel.unit for channel in stored if channel.unit and channel.name not in ("t", "crank_angle")
    }
    channels = [name for name in ("slider/a", "output/a", "rocker/a") if name in units]
    short_names = {ACCELERATION: channels[0]} if channels else {}
    names = {name: name for name in units} | short_names
    signals = read_signals(file, {name: units[channel] for name, channel in names.items()})
    ids = study.cases.index
    indices = np.unique(np.linspace(0, len(ids) - 1, min(len(ids), MAX_CASES)).astype(int))
    compared_ids = [ids[index] for index in indices]
    orbits = {case_id: orbit for case_id in compared_ids if (orbit := saved_channels(study.run, case_id))}
    if not orbits:
        raise InputError(f"{file}: this run has no time histories to compare with; run it with save: {{orbits: last}}")
    best: dict[str, SignalComparison] = {}
    for name, values in signals.signals.items():
        channel = names[name]
        for case_id, orbit in orbits.items():
            angle, factor = orbit["crank_angle"], 1.0
            if signals.over != "crank_angle":  # over time: rad/s, the mean speed of the case
                factor = (angle[-1] - angle[0]) / (orbit["t"][-1] - orbit["t"][0])
            compared_pair = _compare_with_case(factor * signals.abscissa, values, angle, orbit[channel], signals)
            if channel not in best or compared_pair[3] < best[channel].misfit:
                best[channel] = SignalComparison(
                    channel, units[channel], signals.file, case_id, len(orbits), *compared_pair
                )
    return list(best.values())


def _compare_with_case(
    angle: np.ndarray, values: np.ndarray, crank_angle: np.ndarray, computed: np.ndarray, signals: MeasuredSignals
) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return the measured and computed revolutions, the angle (rad) between them, and the misfit."""
    highest_order = features.highest_common_order(
        features.samples_per_revolution(angle), features.samples_per_revolution(crank_angle)
    )
    revolutions = features.split_revolutions(angle, values, 0.0, highest_order)
    if len(revolutions) < MIN_REVOLUTIONS:
        raise InputError(
            f"{signals.file}: has {(angle[-1] - angle[0]) / features.TURN:.3g} revolutions; at least {MIN_REVOLUTIONS} "
            "whole ones, from crank angle 0 on, are needed"
        )
    computed_revolutions = features.split_revolutions(crank_angle, computed, 0.0, highest_order)
    if not len(computed_revolutions):
        raise InputError(f"{signals.file}: the cases have less than a revolution saved; write save: {{revolutions: 2}}")
    lag = features.find_lag(revolutions.mean(axis=0), computed_revolutions.mean(axis=0))
    revolutions = np.roll(revolutions.ravel(), -lag).reshape(revolutions.shape)
    revolutions = revolutions[:-1] if lag else revolutions  # the last one contains the start of the first
    mean_revolution = revolutions.mean(axis=0)
    measured_rms = float(np.sqrt(((mean_revolution - mean_revolution.mean()) ** 2).mean()))
    difference_rms = float(np.sqrt(((mean_revolution - computed_revolutions.mean(axis=0)) ** 2).mean()))
    phase_shift = features.TURN * lag / revolutions.shape[1]
    return (
        revolutions,
        computed_revolutions,
        phase_shift - features.TURN * (phase_shift > features.TURN / 2.0),
        difference_rms / measured_rms if measured_rms else np.inf,
    )


# Identified parameters: intervals, distributions, and the fit of the best cases.

MAX_PAIRS = 6  # of keys that are drawn
BIN_COUNT = 40  # of a distribution
Parameter = tuple[Axis, dict[str, Any]]  # the axis of a key, and its value, interval and whether it is determined


def _parameters(study: Study) -> list[Parameter]:
    """Return the identified keys; [] if nothing was identified."""
    axes = {axis.path: axis for axis in study.axes}
    identified = study.run.grid.get("identified") or {}
    return [(axes[parameter["path"]], parameter) for parameter in identified.get("parameters", ())]


def identified_sections(study: Study) -> list[Section]:
    """Return the section, or [] if nothing was identified, or the run did not end."""
    identified: dict[str, Any] = study.run.grid.get("identified") or {}
    sample, parameters = study.run.identify if identified else None, _parameters(study)
    if sample is None or sample.empty:
        return []
    joint_count = len({axis.path.split(".")[1] for axis, _ in parameters if axis.path.startswith("joints.")})
    blocks: list[Block] = [
        Sentences([f"{_estimate_text(*parameter)}." for parameter in parameters]),
        Sentences(identification_sentences(identified, joint_count)),
        Gallery(
            "Dashed lines are the ends of the 95 % interval, the solid line is the median.",
            [_density_picture(*parameter, sample) for parameter in parameters],
        ),
        _parameter_table(parameters),
    ]
    return section("identify", "The identified machine", *blocks)


def folded_identified_sections(study: Study) -> list[Section]:
    """Return pairs of keys and the fit of each feature, or [] if nothing was identified."""
    if not identified_sections(study):
        return []
    pairs = itertools.islice(itertools.combinations([axis for axis, _ in _parameters(study)], 2), MAX_PAIRS)
    pictures = [_pair_picture(*pair, study.run.identify) for pair in pairs]
    table = _fit_table(study.run.grid["identified"])
    gallery = Gallery("Darker cells are more probable.", pictures)
    return section("identify-more", "Identified pairs and measured features", gallery, table)


def parameter_cards(study: Study) -> list[tuple[str, str, str]]:
    """Return a card for each key that was identified."""
    return [
        (capitalise(axis.name), axis.scale.text(parameter["value"]), _interval_text(axis, parameter))
        for axis, parameter in _parameters(study)
    ]


def _interval_text(axis: Axis, parameter: dict[str, Any]) -> str:
    """Return the interval of a key."""
    return f"95 %: {axis.scale.number_text(parameter['low'])} to {axis.scale.text(parameter['high'])}"


def _estimate_text(axis: Axis, parameter: dict[str, Any]) -> str:
    """Return a value, its interval, and its certainty."""
    text = (
        f"{axis.name} {axis.scale.text(parameter['value'])} "
        f"({_interval_text(axis, parameter)}){certainty_text(parameter)}"
    )
    return text[0].upper() + text[1:]


def _density_picture(axis: Axis, parameter: dict[str, Any], sample: Any) -> Picture:
    """Return the distribution of a key."""

    def paint(ax: Axes) -> None:
        values, weights = axis.scale.from_si(sample[axis.path].to_numpy()), sample["weight"].to_numpy()
        ax.hist(values, BIN_COUNT, weights=weights, color=BLUE, alpha=0.5, density=True)
        for name, style in (("low", "--"), ("value", "-"), ("high", "--")):
            ax.axvline(axis.scale.from_si(parameter[name]), color=BLUE, linestyle=style, linewidth=1.0)
        ax.set_labels(axis.label(), "probability density")
        ax.yaxis.set_ticks([])
        set_plain_axes(ax)

    return Picture(f"Probability of {axis.name}", "", f"{_estimate_text(axis, parameter)}.", paint)


def _pair_picture(x_axis: Axis, y_axis: Axis, sample: Any) -> Picture:
    """Return the distribution of a pair of keys."""

    def paint(ax: Axes) -> None:
        x, y = (axis.scale.from_si(sample[axis.path].to_numpy()) for axis in (x_axis, y_axis))
        counts, x_edges, y_edges = np.histogram2d(x, y, BIN_COUNT // 2, weights=sample["weight"].to_numpy())
        ax.cells(x_edges, y_edges, counts.T, ColourScale(0.0, float(counts.max()), BLUES))
        ax.set_labels(x_axis.label(), y_axis.label())

    title = f"{x_axis.name} and {y_axis.name}"
    return Picture(title, "", f"Probability of pairs of {title}.", paint)


def _parameter_table(parameters: list[Parameter]) -> Table:
    """Return a row for each key."""
    rows = []
    for axis, parameter in parameters:
        cells = [Quantity(parameter[name], axis.scale.text(parameter[name])) for name in ("value", "low", "high")]
        rows.append((axis.name, *cells, parameter["determined"]))
    columns = columns_of("key | median | from | to | determined")
    return Table("identify", "Keys with their 95 % intervals", "", columns, rows)


def _fit_table(identified: dict[str, Any]) -> Table:
    """Return a row for each feature."""
    rows = []
    for fit in identified["fits"]:
        cells = [Quantity(fit[key], wording.quantity_text(fit[key], fit["unit"])) for key in ("measured", "computed")]
        rows.append((fit["channel"], fit["feature"], *cells, fit["deviations"]))
    columns = columns_of("signal | feature | measured | computed | deviations")
    note = (
        "Computed values are medians of the best cases. Deviations are measured minus computed values, in standard "
        "deviations."
    )
    return Table("identify-fit", "Features measured and computed", note, columns, rows)


# Measured and computed signals compared: over the crank angle, by rms, peaks and spectrum.

SIZE = (6.5, 3.4)  # inches


def overlay_section(study: Study, comparison: list[SignalComparison]) -> Section:
    """Return the section on a measurement compared with a run."""
    blocks: list[Block] = []
    for signal in comparison:
        blocks += [Sentences(_sentences(study, signal)), Gallery("", _overlay_pictures(signal)), _table(signal)]
    return Section("overlay", "Measured and computed", without_empty(blocks))


def _sentences(study: Study, comparison: SignalComparison) -> list[str]:
    """Return the compared case, the correction of the angle, the misfit."""
    setting = study.setting(comparison.case_id)
    case = f"case {wording.short_id(comparison.case_id)}" + (f" ({setting})" if setting else "")
    return [
        f"{comparison.channel}, measured in {comparison.file}: {len(comparison.measured)} revolutions.",
        f"The best match among {wording.count_text(comparison.compared, 'case')} is {case}.",
        f"The measured crank angle has an offset of {math.degrees(comparison.angle):.3g}°, which this page corrects.",
        f"The mean revolutions differ by {100.0 * comparison.misfit:.3g} % (rms difference over the rms measured).",
    ]


def _overlay_pictures(comparison: SignalComparison) -> list[Picture]:
    """Return both signals over the crank angle, and their spectra."""
    scale = wording.scale(comparison.unit, float(np.abs(comparison.measured).max()))

    def over_angle(ax: Axes) -> None:
        degrees = 360.0 * np.arange(comparison.measured.shape[1]) / comparison.measured.shape[1]
        ax.plot(degrees, comparison.measured.T / scale.factor, color="#bfbfbf", linewidth=0.6)
        ax.plot(degrees, comparison.measured.mean(axis=0) / scale.factor, color="#4d4d4d", label="measured, mean")
        ax.plot(degrees, comparison.computed.mean(axis=0) / scale.factor, color=RED, label="computed")
        ax.set_labels("crank angle, °", f"{comparison.channel}, {scale.unit}")
        ax.set_legend("above", columns=2)

    def spectra(ax: Axes) -> None:
        for revolutions, color, name in (
            (comparison.measured, "#4d4d4d", "measured"),
            (comparison.computed, RED, "computed"),
        ):
            amplitude = 2.0 * np.abs(np.fft.rfft(revolutions, axis=1)).mean(axis=0) / revolutions.shape[1]
            ax.plot(np.arange(1, len(amplitude)), amplitude[1:] / scale.factor, color=color, label=name)
        ax.set_log("y")
        ax.set_labels("order of the crank", f"amplitude, {scale.unit}")
        ax.set_legend("above", columns=2)

    title = f"{comparison.channel}: measured and computed"
    text = f"{title}; they differ by {100.0 * comparison.misfit:.3g} %."
    angle_picture = Picture(title, "Grey: every measured revolution.", text, over_angle, SIZE)
    spectrum_picture = Picture(f"{comparison.channel}: spectra", "", f"Spectra of {comparison.channel}.", spectra, SIZE)
    return [angle_picture, spectrum_picture]


def _table(comparison: SignalComparison) -> Table:
    """Return rms, peaks and bands of the spectrum of both."""
    both = [features.features_of(comparison.measured), features.features_of(comparison.computed)]
    rows = [
        ("rms", *(each.rms for each in both)),
        ("peak per revolution, median", *(each.peak_median for each in both)),
        ("peak per revolution, p95", *(each.peak_p95 for each in both)),
    ]
    for band, (low, high) in enumerate(features.BANDS):
        if max(each.spectrum[band] for each in both) >= 1e-9 * both[0].rms:  # else above the common band
            rows.append((f"rms, orders {low} to {high}", *(each.spectrum[band] for each in both)))
    columns = (Column("feature"), Column("measured", comparison.unit), Column("computed", comparison.unit))
    key = f"overlay-{comparison.channel.replace('/', '-')}"
    return Table(key, f"Features of {comparison.channel}", "", columns, rows)
