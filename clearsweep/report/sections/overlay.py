"""Measured and computed signals compared: over the crank angle, by rms, peaks and spectrum."""

import math
from typing import Any

import numpy as np

from ...answers import features
from ...language import wording
from ..blocks.picture import Picture
from ..blocks.section import Block, Gallery, Section, Sentences, without_empty
from ..blocks.table import Column, Table
from ..data.study import Study
from ..statistics.overlay import SignalComparison

SIZE = (6.5, 3.4)  # inches


def section(study: Study, comparison: list[SignalComparison]) -> Section:
    """Return the section on a measurement compared with a run."""
    blocks: list[Block] = []
    for signal in comparison:
        blocks += [Sentences(_sentences(study, signal)), Gallery("", _pictures(signal)), _table(signal)]
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


def _pictures(comparison: SignalComparison) -> list[Picture]:
    """Return both signals over the crank angle, and their spectra."""
    scale = wording.scale(comparison.unit, float(np.abs(comparison.measured).max()))

    def over_angle(ax: Any) -> None:
        degrees = 360.0 * np.arange(comparison.measured.shape[1]) / comparison.measured.shape[1]
        ax.plot(degrees, comparison.measured.T / scale.factor, color="0.75", linewidth=0.6)
        ax.plot(degrees, comparison.measured.mean(axis=0) / scale.factor, color="0.3", label="measured, mean")
        ax.plot(degrees, comparison.computed.mean(axis=0) / scale.factor, color="C3", label="computed")
        ax.set_xlabel("crank angle, °")
        ax.set_ylabel(f"{comparison.channel}, {scale.unit}")
        ax.legend()

    def spectra(ax: Any) -> None:
        for revolutions, color, name in (
            (comparison.measured, "0.3", "measured"),
            (comparison.computed, "C3", "computed"),
        ):
            amplitude = 2.0 * np.abs(np.fft.rfft(revolutions, axis=1)).mean(axis=0) / revolutions.shape[1]
            ax.semilogy(np.arange(1, len(amplitude)), amplitude[1:] / scale.factor, color=color, label=name)
        ax.set_xlabel("order of the crank")
        ax.set_ylabel(f"amplitude, {scale.unit}")
        ax.legend()

    title = f"{comparison.channel}: measured and computed"
    text = f"{title}; they differ by {100.0 * comparison.misfit:.3g} %."
    angle_picture = Picture(title, "Grey: every measured revolution.", text, over_angle, SIZE)
    spectrum_picture = Picture(f"{comparison.channel}: spectra", "", f"Spectra of {comparison.channel}.", spectra, SIZE)
    return [angle_picture, spectrum_picture]


def _table(comparison: SignalComparison) -> Table:
    """Return rms, peaks and bands of the spectrum of both."""
    both_features = [features.features_of(comparison.measured), features.features_of(comparison.computed)]
    rows = [
        ("rms", *(signal_features.rms for signal_features in both_features)),
        ("peak per revolution, median", *(signal_features.peak_median for signal_features in both_features)),
        ("peak per revolution, p95", *(signal_features.peak_p95 for signal_features in both_features)),
    ]
    for band, (low, high) in enumerate(features.BANDS):
        if max(signal_features.spectrum[band] for signal_features in both_features) < 1e-9 * both_features[0].rms:
            continue  # above the common band
        rows.append(
            (f"rms, orders {low} to {high}", *(signal_features.spectrum[band] for signal_features in both_features))
        )
    columns = (Column("feature"), Column("measured", comparison.unit), Column("computed", comparison.unit))
    key = f"overlay-{comparison.channel.replace('/', '-')}"
    return Table(key, f"Features of {comparison.channel}", "", columns, rows)
