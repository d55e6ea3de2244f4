"""How often the 95 % intervals of `until` and of a life contain the truth: `python tests/interval_coverage.py`.

The trials are of two kinds. In the first, a made-up series of wear per revolution, whose mean is known, goes through
the rule that ends a run. In the second, lives of a chaotic slider-crank, which differ in their start alone, are
compared with the mean of long runs.
"""

import argparse
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from mechanism_cases import slider_crank
from scipy import signal, special

import clearsweep
from clearsweep.mechanics.observe import BINS
from clearsweep.mechanics.solver.totals import ContactTotals, MechanismTotals
from clearsweep.simulation import load_case
from clearsweep.simulation.analyses import repeated
from clearsweep.simulation.setup.scene import Scene
from clearsweep.simulation.setup.start import NO_MARKS

TURN = 0.02  # s, of a revolution
FIGURE = "rod_slider_wear_rate_max"
WEAR = {"law": "archard", "coefficient": 2e-14, "bins": 90}
#: Of the chaotic slider-crank whose lives are repeated.
CHAOTIC = {
    "drive.speed": "3000 rpm",
    "mechanism.gravity": 0.0,
    "joints.rod-slider.clearance": "0.2 mm",
    "joints.rod-slider.contact": {"law": "exact", "stiffness": 6.61e10, "restitution": 0.8},
    "joints.rod-slider.friction": {"law": "tanh", "coefficient": 0.01, "velocity_scale": 1e-3},
    "joints.rod-slider.wear": WEAR,
    "save.orbits": "none",
    "simulate.tolerance": 1e-8,
}
LIMIT = 2e-5  # m
TRUE_RUNS, TRUE_REVOLUTIONS = 4, 4000
SETTINGS = ((10, 2, 0.05), (15, 5, 0.05), (15, 5, 0.1), (40, 30, 0.05))  # revolutions, discard, life.tolerance


class Coverage(NamedTuple):
    """Outcome of some trials of one kind."""

    trials: int
    inside: int
    above: int  # intervals above the truth
    below: int
    revolutions: float  # mean over the trials

    def __str__(self) -> str:
        """Return the outcome in words."""
        return (
            f"{100.0 * self.inside / self.trials:.1f} % of {self.trials} intervals contain the truth, {self.above} are "
            f"above it, {self.below} below; {self.revolutions:.0f} revolutions"
        )


def coverage_of(intervals: list[tuple[float, float, float]], truth: float) -> Coverage:
    """Return the coverage of (low, high, revolutions)."""
    lows, highs, revolutions = np.array(intervals).T
    above, below = int(np.sum(lows > truth)), int(np.sum(highs < truth))
    return Coverage(len(intervals), len(intervals) - above - below, above, below, float(revolutions.mean()))


# ---------------------------------------------------------------------------------------------- made-up series


def autoregressive(random: np.random.Generator, count: int, correlation: float) -> np.ndarray:
    """Return `count` standard normal numbers of which neighbours have this correlation."""
    noise = random.normal(size=count + 100) * math.sqrt(1.0 - correlation**2)
    return signal.lfilter([1.0], [1.0, -correlation], noise)[100:]


def logistic(random: np.random.Generator, count: int) -> np.ndarray:
    """Return an orbit of the logistic map x -> 4 x (1 - x), of mean 1/2 and chaotic."""
    values = np.empty(count)
    value = random.uniform(0.1, 0.9)
    for index in range(count):
        values[index] = value = 4.0 * value * (1.0 - value)
    return values


#: Name -> series of wear per revolution of mean 1.
SERIES: dict[str, Callable[[np.random.Generator, int], np.ndarray]] = {
    "independent": lambda random, count: 1.0 + 0.15 * random.normal(size=count),
    "correlation 0.5": lambda random, count: 1.0 + 0.15 * autoregressive(random, count, 0.5),
    "correlation -0.4": lambda random, count: 1.0 + 0.15 * autoregressive(random, count, -0.4),
    "skewed": lambda random, count: 0.8 + 0.2 * random.exponential(size=count),
    "skewed, correlation 0.3": lambda random, count: np.exp(0.25 * autoregressive(random, count, 0.3) - 0.03125),
    "bounded": lambda random, count: 0.7 + 0.6 * special.ndtr(autoregressive(random, count, 0.2)),
    "logistic map": lambda random, count: 0.7 + 0.6 * logistic(random, count),
}


class MadeUpRun:
    """A run whose wear per revolution is given, for the rule that ends a run."""

    time = 0

    def __init__(self, rates: np.ndarray):
        """Prepare for these rates (m per revolution)."""
        self.rates, self.turns = rates, 0
        self.revolutions = SimpleNamespace(passed=np.zeros(1, int), marks=np.zeros(1))
        self.totals = SimpleNamespace(
            mechanism=MechanismTotals.zeros(),
            joint=ContactTotals.zeros(1),
            histogram=np.zeros((1, BINS, 2)),
            wear=np.zeros(2 * WEAR["bins"]),
        )

    @property
    def y(self) -> np.ndarray:
        """Return the state, which here is the time (s) alone."""
        return np.array([TURN * self.turns])

    def turn(self) -> None:
        """Let one revolution pass."""
        self.totals.wear[0] += self.rates[self.turns]
        self.turns += 1


class MadeUpLength(repeated.WindowLength):
    """The rule that ends a run, for a run that is made up."""

    def take_snapshot(self, work: MadeUpRun) -> None:
        """Take none: there is nothing to repeat."""


def interval_at_end(scene: Scene, rates: np.ndarray, relative: float) -> tuple[float, float, float]:
    """Return (low, high, revolutions) of the mean rate where the rule ends a run of these rates."""
    length = MadeUpLength(scene, NO_MARKS, (FIGURE,), (FIGURE, relative), len(rates))
    run = MadeUpRun(rates)
    while length.observe(run) != repeated.Decision.END and run.turns < len(rates):
        run.turn()
    value, width = TURN * length.interval.value, TURN * length.interval.half_width
    return value - width, value + width, run.turns


def made_up_coverage(name: str, relative: float, trials: int, seed: int = 1) -> Coverage:
    """Return the coverage of the intervals of a made-up series."""
    random = np.random.default_rng(seed)
    series = [SERIES[name](random, 2000) for _ in range(trials)]
    scene = load_case(slider_crank("rod-slider", changes={"joints.rod-slider.wear": WEAR, "simulate.discard": 0}))
    return coverage_of([interval_at_end(scene, rates, relative) for rates in series], 1.0)


# ---------------------------------------------------------------------------------------------- lives


def true_life() -> float:
    """Return the revolutions after which the deepest bin has LIMIT, from the mean of long runs."""
    length = {"simulate.revolutions": TRUE_REVOLUTIONS, "simulate.discard": 30}
    rates = [
        clearsweep.simulate(load_case(chaotic(length, 0.3 + 1.5 * place))).summary[FIGURE] for place in range(TRUE_RUNS)
    ]
    return LIMIT / (TURN * float(np.mean(rates)))


def chaotic(changes: dict, start_angle: float) -> dict:
    """Return the chaotic slider-crank with changes, started at an angle (rad)."""
    budgets = {"simulate.time_budget": 1e5}
    return slider_crank("rod-slider", changes=CHAOTIC | budgets | {"drive.start_angle": start_angle} | changes)


def life_interval(settings: tuple[int, int, float], start_angle: float) -> tuple[float, float, float]:
    """Return (low, high, revolutions of its block) of a life; settings : see SETTINGS."""
    revolutions, discard, tolerance = settings
    changes = {"simulate.revolutions": revolutions, "simulate.discard": discard}
    grid = chaotic(changes, start_angle) | {"life": {"limit": LIMIT, "joint": "rod-slider", "tolerance": tolerance}}
    summary = clearsweep.simulate(load_case(grid)).summary
    block = summary["rod_slider_wear_depth_max"] * summary["rod_slider_life_revolutions"] / LIMIT  # revolutions
    return summary["rod_slider_life_low"], summary["rod_slider_life_high"], block


def life_coverage(settings: tuple[int, int, float], trials: int, truth: float) -> Coverage:
    """Return the coverage of the intervals of lives; the revolutions are those of a block."""
    angles = 2.0 * math.pi * (np.arange(trials) + 0.5) / trials
    return coverage_of([life_interval(settings, angle) for angle in angles.tolist()], truth)


def main() -> None:
    """Print the coverage of every kind of trial."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=1000)
    parser.add_argument("--made-up-only", action="store_true", help="without lives, which take half a second each")
    options = parser.parse_args()
    for name in SERIES:
        for relative in (0.1, 0.05, 0.02):
            print(f"{name}, to {100.0 * relative:g} %: {made_up_coverage(name, relative, options.trials)}", flush=True)
    if options.made_up_only:
        return
    truth = true_life()
    print(f"life by {TRUE_RUNS} runs of {TRUE_REVOLUTIONS} revolutions: {truth:.6g} revolutions")
    for settings in SETTINGS:
        print(f"life, revolutions, discard, tolerance {settings}: {life_coverage(settings, options.trials, truth)}")


if __name__ == "__main__":
    main()
