"""The cases with which `scale` measures sweeps; workers import this file, so it must be light."""

import functools
import time
from pathlib import Path
from typing import Any

import fake_physics
import numpy as np

from clearsweep import grid
from clearsweep.contracts import results
from clearsweep.contracts.layout import Layout

COUNTS = {  # values on the three axes
    10_000: (20, 20, 25),
    100_000: (50, 50, 40),
    1_000_000: (100, 100, 100),
    10_000_000: (200, 200, 250),
    100_000_000: (400, 500, 500),
}
REAL = Path(__file__).parent.parent / "configs" / "thousand_cases.yaml"


def middles(low: float, high: float, count: int) -> list[float]:
    """Return the centres of equal parts: their mean depends little on their number."""
    return (low + (np.arange(count) + 0.5) * (high - low) / count).tolist()


def axes_of(count: int, ranges: dict[str, tuple[float, float]]) -> dict[str, list[float]]:
    """Return axes of `count` cases."""
    counts = COUNTS.get(count) or (count, 1, 1)
    return {path: middles(*ends, many) for (path, ends), many in zip(ranges.items(), counts, strict=True)}


def made_up(count: int, seconds: float = 0.0) -> dict[str, Any]:
    """Return a grid of substitutes of this duration (s) each."""
    ranges = {
        "mechanism.slider.mass": (0.1, 0.3),
        "mechanism.crank.length": (0.04, 0.06),
        "drive.speed": (100.0, 500.0),
    }
    source = fake_physics.grid(orbits="none", sweep=axes_of(count, ranges))
    source["mechanism"] = source["mechanism"] | {"gravity": seconds}
    return source


def real(count: int) -> dict[str, Any]:
    """Return a grid of real cases of about a millisecond: configs/thousand_cases.yaml for one revolution."""
    joint = "joints.rod-slider"
    ranges = {
        f"{joint}.clearance": (1e-4, 5e-4),
        f"{joint}.contact.restitution": (0.5, 0.95),
        "drive.speed": (105.0, 525.0),
    }
    from clearsweep import simulation

    written = grid.load(REAL, simulation.catalogue()).resolved()
    settings = written["simulate"] | {"revolutions": 1, "discard": 0}
    save = written["save"] | {"revolutions": 1}
    return written | {"simulate": settings, "save": save, "sweep": axes_of(count, ranges)}


class StandIn(fake_physics.Fake):
    """Cases that use the processor for the number of seconds given by their gravity."""

    @staticmethod
    def load():
        """Work out the columns, which is no part of the first case."""
        _columns("slider-crank")

    @staticmethod
    def solve(case: Any) -> results.Trajectory:
        """Return figures derived from the slider's mass."""
        begin = time.process_time()
        names = _columns(case.mechanism.type)
        mass = case.mechanism.values["slider.mass"]
        summary = {name: place if whole else mass * place for place, (name, whole) in enumerate(names)}
        while (spent := time.process_time() - begin) < case.mechanism.values["gravity"]:
            pass
        return results.Trajectory("ok", "", summary | {"run_time": spent})


@functools.cache
def _columns(_: str) -> list[tuple[str, bool]]:
    """Return names of the columns of substitutes, and whether they are integers."""
    case = grid.load(made_up(1), fake_physics.CATALOGUE).case(0)
    return [(column.name, column.kind == "int") for column in Layout.of(case, fake_physics.CATALOGUE).columns]


def timed(case: Any) -> results.Trajectory:
    """Return the result of a real case, with its total processor time (s) as `run_time`."""
    from clearsweep import simulation

    begin = time.process_time()
    trajectory = simulation.solve(case)
    trajectory.summary["run_time"] = time.process_time() - begin
    return trajectory
