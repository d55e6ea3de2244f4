"""What deforms in a run, from the polynomials over its steps: links that bend, their fatigue, and housings."""

import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import column_name
from ...mechanics.machines import planar
from ...mechanics.machines.contract import signal_count
from ...mechanics.observe import START
from ...mechanics.solver.signal_sums import EXCESS, FINE_POINTS, NODE_COUNT, TO_FINE_POINTS, values_at
from ...mechanics.solver.slow_sums import SIGNALS
from ...tracing import portable
from ..setup.scene import Scene

ZOOM_POINTS = FINE_POINTS[0] * np.linspace(-1.0, 1.0, 65)  # about the largest of the fine points


def largest_size(values: np.ndarray, bound: float) -> float:
    """Return the largest size of values (steps, ..., nodes) in recorded steps and between their nodes, or `bound`.

    Between nodes only steps are searched whose values there may be larger.
    """
    flat = values.reshape(-1, NODE_COUNT)
    low, high = flat.min(axis=1), flat.max(axis=1)
    size = np.maximum(high, -low)
    largest = max(bound, float(size.max()))
    candidates = flat[size + EXCESS * (high - low) > largest]
    fine = np.abs(portable.product(candidates, TO_FINE_POINTS))
    if not fine.size or fine.max() <= bound:
        return largest
    step, point = np.unravel_index(int(fine.argmax()), fine.shape)
    nearby = np.clip(FINE_POINTS[point] + ZOOM_POINTS, 0.0, 1.0)
    return max(largest, float(np.abs(portable.product(candidates[step], values_at(nearby))).max()))


END_POINTS = 3  # turning points between which the last two ranges lie


class Rainflow:
    """Rainflow counting of a history that comes in pieces: the rules of ASTM E1049-85, section 5.4.4.

    A range that the next one covers is a full cycle, or half a cycle if it begins at the first turning point that is
    left.  What is left at the end counts as half cycles.
    """

    def __init__(self) -> None:
        self._points: list[float] = []  # turning points that are left, the last of them not yet known to be one

    def add(self, values: np.ndarray) -> np.ndarray:
        """Return the cycles (n, 2) that `values`, the next part of the history, close: range and count, 1 or 0.5."""
        closed: list[tuple[float, float]] = []
        for value in turning_points(np.asarray(values)).tolist():
            self._append(value, closed)
        return np.array(closed).reshape(-1, 2)

    def _append(self, value: float, closed: list[tuple[float, float]]) -> None:
        """Add a value; put the cycles that it closes to `closed`."""
        points = self._points
        if len(points) >= 2 and (value - points[-1]) * (points[-1] - points[-2]) >= 0.0:
            points.pop()  # the last point was no turning point
        elif points == [value]:
            return
        points.append(value)
        while len(points) >= END_POINTS and abs(points[-1] - points[-2]) >= abs(points[-2] - points[-3]):
            closed.append((abs(points[-2] - points[-3]), 0.5 if len(points) == END_POINTS else 1.0))
            if len(points) == END_POINTS:
                del points[0]
            else:
                del points[-3:-1]

    def left(self) -> np.ndarray:
        """Return the half cycles (n, 2) of the turning points that are left: range and count."""
        ranges = np.abs(np.diff(self._points))
        return np.stack([ranges, np.full(len(ranges), 0.5)], -1)


def turning_points(values: np.ndarray) -> np.ndarray:
    """Return the first value of a history (n,), those where it turns, and the last one."""
    values = values[np.append(True, np.diff(values) != 0.0)] if len(values) else values
    if len(values) < END_POINTS:
        return values
    slopes = np.sign(np.diff(values))
    points: np.ndarray = values[np.concatenate([[True], slopes[1:] != slopes[:-1], [True]])]
    return points


def damage(cycles: np.ndarray, strength: float, exponent: float, life: float) -> float:
    """Return the share of a life that cycles (n, 2), ranges (Pa) and counts, use up: the sum of Palmgren and Miner.

    A stress amplitude S breaks after `life` (strength / S)^exponent cycles, whatever the mean stress.
    """
    ranges, counts = cycles.T
    return math.fsum(counts * (0.5 * ranges / strength) ** exponent) / life


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


LARGEST_DEFLECTION = 0.25  # of the length: the chord is 15 % shorter, and the second order no longer describes it
MIDDLE = len(planar.STATIONS) // 2


class LinkStress(NamedTuple):
    """What turns the signals of a link into deflection and stress, and where its signals are."""

    name: str  # as in columns
    length: float  # m
    modes: slice  # columns of the recording
    forces: slice
    shapes: np.ndarray  # (modes,) deflection of the middle for a unit of each mode
    bending: np.ndarray  # (stations, modes) Pa/m, stress at the left edge for a unit of each mode
    area: float  # m^2
    frequency: float  # Hz, first mode between pins
    life: tuple | None  # strength (Pa), exponent and cycles of its stress-life line
    shortening: np.ndarray  # (modes,) 1/m, of the chord for the square of each mode
    levers: np.ndarray  # (stations of a revolution + 1,) displacement of the output for a unit of it

    def stresses(self, rows: np.ndarray) -> np.ndarray:
        """Return the stress (steps, 2, stations, nodes) Pa at the left and the right edge from recorded steps."""
        bent = np.einsum("ik,ckm->cim", self.bending, rows[:, self.modes])
        normal = rows[:, self.forces] / self.area
        stresses: np.ndarray = np.stack([normal + bent, normal - bent], axis=1)
        return stresses


def crank_column(scene: Scene) -> int:
    """Return the column of the recording with the crank's angle."""
    return SIGNALS + int(signal_count(scene.value.shaking))


def links_of(scene: Scene) -> list[LinkStress]:
    """Return the links of a scene that bend, in the order of their signals."""
    machine, links, first = scene.machine, list[LinkStress](), crank_column(scene) + 1
    assert machine is not None  # only planar machines have links that bend
    values, section = scene.case.mechanism.values, "bodies." if scene.case.outline.bodies else ""
    for name, body in machine.bodies.items():
        elastic = body.elastic
        if not elastic or not elastic.bending:
            continue
        bending, length = elastic.bending, planar.line_of(body, elastic).length
        wave_numbers = math.pi * np.arange(1, bending.modes + 1) / length
        shapes = np.sin(length * np.outer(planar.STATIONS, wave_numbers))
        path = f"{section}{name}.elastic.stress_life"
        life = tuple(values.get(f"{path}.{key}", math.nan) for key in ("strength", "exponent", "cycles"))
        link = LinkStress(
            column_name(name),
            length,
            slice(first, first + bending.modes),
            slice(first + bending.modes, first + bending.modes + len(planar.STATIONS)),
            shapes[MIDDLE],
            -bending.young * bending.edge * shapes * wave_numbers**2,
            bending.area,
            planar.first_rate(body, elastic) / (2.0 * math.pi),
            None if math.isnan(life[0]) else life,
            0.25 * length * wave_numbers**2,
            planar.levers(planar.ideal_of(planar.with_segments(machine)), name, *elastic[:2]),
        )
        links.append(link)
        first = link.forces.stop
    return links


class LinkSignals:
    """Largest deflections and stresses of the links of a run, and its stress histories where a life is asked for."""

    def __init__(self, scene: Scene):
        """Prepare for the run of a scene."""
        self.links, self.crank_column = links_of(scene), crank_column(scene)
        assert scene.machine is not None  # as above
        aim, bodies = scene.machine.aim, scene.machine.bodies
        elastic = bodies[aim.body].elastic
        #: The output is a point of a link that bends, off its pins, which moves relative to the chord.
        self.output_bends = bool(
            elastic and elastic.bending and aim.point and aim.point not in (elastic.near, elastic.far)
        )
        self.scene, self.first_mount = scene, self.links[-1].forces.stop if self.links else self.crank_column + 1
        self.start_angle = scene.case.drive.start_angle if scene.case.drive else 0.0
        self.reset()

    def reset(self) -> None:
        """Forget all recorded signals."""
        self.deflections = np.zeros(len(self.links))  # m, largest size of each
        self.stresses = np.zeros(len(self.links))  # Pa
        self.output_error = 0.0  # of the output, by the bending of all links
        counts = [2 * len(planar.STATIONS) if link.life else 0 for link in self.links]
        self.rainflows = [[Rainflow() for _ in range(count)] for count in counts]  # of each edge at each station
        self.damages = [np.zeros(count) for count in counts]  # share of the life that their closed cycles use up
        self.mounts = MountSignals(self.scene, self.first_mount)

    def bends_too_far(self) -> bool:
        """Return whether a link has deflected beyond its model."""
        lengths = np.array([link.length for link in self.links])
        return bool(np.any(self.deflections > LARGEST_DEFLECTION * lengths))

    def add(self, rows: np.ndarray) -> None:
        """Add recorded steps (steps, columns, nodes)."""
        if not len(rows):
            return
        turns = (rows[:, self.crank_column] - self.start_angle) / (2.0 * math.pi)
        self.mounts.add(rows, turns)
        errors = np.zeros(turns.shape)  # of the output, by the shortening of chords, to first order
        for link in self.links:
            levers = np.interp(turns % 1.0, np.linspace(0.0, 1.0, len(link.levers)), link.levers)
            errors += levers * np.einsum("k,ckm->cm", link.shortening, rows[:, link.modes] ** 2)
        self.output_error = largest_size(errors, self.output_error)
        for i, link in enumerate(self.links):
            middle = np.einsum("k,ckm->cm", link.shapes, rows[:, link.modes])
            self.deflections[i] = largest_size(middle, self.deflections[i])
            stresses = link.stresses(rows)
            self.stresses[i] = largest_size(stresses, self.stresses[i])
            for k, history in enumerate(_edge_histories(stresses) if link.life else ()):
                self.damages[i][k] += damage(self.rainflows[i][k].add(history), *(link.life or ()))

    def figures(self, output: str) -> dict[str, float | None]:
        """Return the columns of links that bend; output : name of the machine's output."""
        values: dict[str, float | None] = {**self.mounts.figures(output)}
        if self.links:
            values[f"{output}_error_bending"] = None if self.output_bends else self.output_error
        for i, (link, deflection, stress) in enumerate(zip(self.links, self.deflections, self.stresses, strict=True)):
            if link.life:
                left = [damage(rainflow.left(), *link.life) for rainflow in self.rainflows[i]]
                values[f"{link.name}_damage"] = float(np.max(self.damages[i] + left))
            values[f"{link.name}_deflection_max"] = float(deflection)
            values[f"{link.name}_stress_max"] = float(stress)
            values[f"{link.name}_frequency"] = link.frequency
        return values


def _edge_histories(stresses: np.ndarray) -> np.ndarray:
    """Return stresses (steps, 2, stations, nodes) at the start and fine points of all steps: (2 stations, points)."""
    steps = len(stresses)
    fine = portable.product(stresses, TO_FINE_POINTS)
    joined = np.concatenate([stresses[..., START : START + 1], fine], axis=-1).reshape(steps, -1, fine.shape[-1] + 1)
    return joined.transpose(1, 0, 2).reshape(joined.shape[1], -1)
