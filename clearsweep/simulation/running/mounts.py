"""Motion of the housings of a machine, from the polynomials over the steps of a run."""

import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import column_name
from ...mechanics.machines import planar
from ..setup.scene import Scene
from .polynomials import largest_size


class Mounted(NamedTuple):
    """A housing, and where its motion is in the recording."""

    name: str  # of its joint, as in columns
    columns: slice  # x, y
    levers: np.ndarray  # (stations of a revolution + 1, 2) displacement of the output for a unit along x, y


class MountSignals:
    """Largest motion of the housings of a run, and what they do to the output."""

    def __init__(self, scene: Scene, first: int):
        """Prepare for the run of a scene whose housings begin at column `first` of the recording."""
        machine = scene.machine
        assert machine is not None  # only planar machines have housings
        ideal_machine = planar.ideal_of(planar.with_segments(machine))
        self.mounts = [
            Mounted(
                column_name(mount.joint),
                slice(first + 2 * i, first + 2 * i + 2),
                planar.levers_of_support(ideal_machine, mount.joint),
            )
            for i, mount in enumerate(machine.mounts)
        ]
        self.squares = np.zeros(len(self.mounts))  # m^2, of the largest motion of each
        self.output_error = 0.0  # of the output, by all housings

    def add(self, rows: np.ndarray, turns: np.ndarray) -> None:
        """Add recorded steps (steps, columns, nodes); turns : (steps, nodes) of the crank since the start."""
        errors = np.zeros(turns.shape)
        for i, mount in enumerate(self.mounts):
            motion, turned = rows[:, mount.columns], turns % 1.0
            self.squares[i] = largest_size((motion**2).sum(axis=1), self.squares[i])
            stations = np.linspace(0.0, 1.0, len(mount.levers))
            for axis in range(2):
                errors += np.interp(turned, stations, mount.levers[:, axis]) * motion[:, axis]
        if self.mounts:
            self.output_error = largest_size(errors, self.output_error)

    def figures(self, output: str) -> dict[str, float]:
        """Return the columns of housings; output : name of the machine's output."""
        values = {f"{output}_error_mounts": self.output_error} if self.mounts else {}
        for mount, square in zip(self.mounts, self.squares, strict=True):
            values[f"{mount.name}_mount_motion_max"] = math.sqrt(square)
        return values
