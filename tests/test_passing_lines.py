"""Lines of rolling bearings in the vibration: a signal of known amplitude, and the Fourier sum of sampled histories."""

import copy
import math

import numpy as np
import pytest
from fake_physics import BODIES
from test_rolling import BALL

import clearsweep
from clearsweep import simulation
from clearsweep.grid import load
from clearsweep.simulation.running.vibration import WINDOW, window_transform

PARTS = "cage", "element", "inner", "outer"
GRID = {
    "mechanism": BODIES,
    "drive": {"speed": "1500 rpm"},
    "joints": {
        "crank-rod": BALL,
    },
    "simulate": {"revolutions": 15, "discard": 3, "tolerance": 1e-9},
    "save": {"orbits": "none"},
    "vibration": {
        "at": {"frame": {"mass": "40 kg"}, "slider": {}, "middle": {"body": "rod", "point": ["60 mm", "0 mm"]}},
        "band": ["10 Hz", "1 kHz"],
    },
}
RATE = 2.0 * math.pi * 25.0


def blackman_harris(count):
    """Return the window at `count` times from the first to before the last, of mean 1."""
    angle = 2.0 * math.pi * np.arange(count) / count
    return sum((-1) ** k * term * np.cos(k * angle) for k, term in enumerate(WINDOW)) / WINDOW[0]


@pytest.mark.parametrize("line", [6.0, 6.37, 40.5, 101.93])
def test_a_sine_between_lines_has_its_amplitude(line):
    """Its whole spectrum also has a sine 1000 times as large, six lines away."""
    times = np.arange(4096) / 4096
    signal = 0.7 * np.cos(2.0 * math.pi * line * times + 0.4) + 700.0 * np.sin(2.0 * math.pi * (line + 6.0) * times)
    spectrum = 2.0 * np.fft.rfft(signal)[:400] / len(times)
    result = abs(spectrum @ window_transform(line - np.arange(400)))
    assert result == pytest.approx(0.7, abs=700.0 * 10 ** (-92 / 20) + 1e-3)
    alone = 2.0 * np.fft.rfft(0.7 * np.cos(2.0 * math.pi * line * times + 0.4))[:400] / len(times)
    assert abs(alone @ window_transform(line - np.arange(400))) == pytest.approx(0.7, rel=2e-4)


@pytest.mark.slow  # compiles a rolling bearing with vibration
def test_passing_lines_are_those_of_sampled_histories():
    """Of the histories less their mean turn, as spectra leave out the orders of the crank."""
    scene = clearsweep.load_case(GRID)
    count = 12 * 4096
    times = 2.0 * math.pi / RATE * (3.0 + 12.0 * np.arange(count + 1) / count)
    motion = clearsweep.simulate(scene, times=times)
    channels, figures = motion.channels, motion.summary
    masses = {"crank": 0.3, "rod": 0.21, "slider": 0.14}
    momenta = [sum(m * channels[f"{body}/v{axis}"] for body, m in masses.items()) for axis in "xy"]
    forces = [-np.gradient(momentum, times) for momentum in momenta]
    velocities = {
        "slider": [channels["slider/vx"]],
        "middle": [channels["rod/vx"], channels["rod/vy"]],
        "frame": forces,
    }
    window, known = blackman_harris(count), 0
    for part in PARTS:
        frequency = figures[f"crank_rod_{part}_frequency"]
        wave = window * np.exp(-2j * math.pi * frequency * times[:-1])
        order = frequency / 25.0
        for place, signals in velocities.items():
            turns = [signal[:-1].reshape(12, -1) for signal in signals]
            sums = [abs(2.0 * np.mean((turn - turn.mean(axis=0)).ravel() * wave)) for turn in turns]
            value = max(sums) / (40.0 * 2.0 * math.pi * frequency if place == "frame" else 1.0)
            result = figures[f"{place}_crank_rod_{part}_velocity"]
            if abs(order - round(order)) * 12.0 < len(WINDOW):
                assert result is None
                continue
            known += 1
            assert result == pytest.approx(value, rel=5e-3 if place == "frame" else 1e-4), (place, part)
    assert known >= 6


def test_columns_are_those_of_places_that_move_and_bearings():
    columns = load(GRID, simulation.catalogue()).layout.units
    expected = {f"{at}_crank_rod_{part}_velocity" for at in ("frame", "slider", "middle") for part in PARTS}
    assert expected == {name for name in columns if name.endswith("_velocity") and "crank_rod" in name}
    still = copy.deepcopy(GRID)
    still["vibration"]["at"] = {"frame": {}}
    assert not any(name.endswith("_velocity") for name in load(still, simulation.catalogue()).layout.units)
    plain = copy.deepcopy(GRID)
    plain["joints"]["crank-rod"] = {
        "clearance": 1e-4,
        "bearing_radius": 0.01,
        "contact": {"law": "hertz", "stiffness": 6.61e10},
    }
    assert not any(name.endswith("_velocity") for name in load(plain, simulation.catalogue()).layout.units)
