"""Harmonics of the crank in a history."""

from typing import NamedTuple

import numpy as np

TURN = 2.0 * np.pi


class Spectrum(NamedTuple):
    """Amplitudes over the crank's orders (oscillations per revolution) of a history of full revolutions."""

    order: np.ndarray  # (n,) multiples of 1 / turns, starting there
    amplitude: np.ndarray  # (n,) in the unit of the history
    revolutions: int  # of the history: its last order is half of the samples of a turn


def harmonic_spectrum(angle: np.ndarray, values: np.ndarray) -> Spectrum | None:
    """Return the spectrum of values at equal steps of the crank angle (rad); None for less than a revolution.

    No window is applied: over full revolutions, periodic components are at integer orders only.
    """
    steps = len(angle) - 1
    if steps < 2 or not angle[-1] > angle[0]:
        return None
    samples_per_revolution = TURN * steps / (angle[-1] - angle[0])  # samples
    revolutions = int(np.floor(steps / samples_per_revolution + 1e-6))
    count = round(revolutions * samples_per_revolution)
    if revolutions < 1 or abs(count - revolutions * samples_per_revolution) > 1e-3:
        return None
    amplitudes = np.abs(np.fft.rfft(values[-count:])) * 2.0 / count
    if count % 2 == 0:
        amplitudes[-1] *= 0.5  # the highest order has no mirrored one
    return Spectrum(np.arange(1, len(amplitudes)) / revolutions, amplitudes[1:], revolutions)
