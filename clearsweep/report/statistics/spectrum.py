"""Harmonics of the crank in a history."""

from typing import NamedTuple

import numpy as np

TURN = 2.0 * np.pi


class Spectrum(NamedTuple):
    """Amplitudes over the crank's orders (oscillations per revolution) of a history of full revolutions."""

    order: np.ndarray  # (n,) multiples of 1 / turns, starting there
    amplitude: np.ndarray  # (n,) in the unit of the history
    turns: int  # of the history: its last order is half of the samples of a turn


def of_history(angle: np.ndarray, values: np.ndarray) -> Spectrum | None:
    """Return the spectrum of values at equal steps of the crank angle (rad); None for less than a revolution.

    No window is applied: over full revolutions, periodic components are at integer orders only.
    """
    steps = len(angle) - 1
    if steps < 2:
        return None
    a_turn = TURN * steps / (angle[-1] - angle[0])  # samples
    turns = int(np.floor(steps / a_turn + 1e-6))
    count = round(turns * a_turn)
    if turns < 1 or abs(count - turns * a_turn) > 1e-3:
        return None
    amplitudes = np.abs(np.fft.rfft(values[-count:])) * 2.0 / count
    if count % 2 == 0:
        amplitudes[-1] *= 0.5  # the highest order has no mirrored one
    return Spectrum(np.arange(1, len(amplitudes)) / turns, amplitudes[1:], turns)
