"""Deflections and stresses of links that bend, and their fatigue, from the polynomials over the steps of a run."""

import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import column_name
from ...contracts.machine import Body
from ...mechanics.coupling.shaking import signal_count
from ...mechanics.machines import planar
from ...mechanics.observe import START
from ...mechanics.solver.signal_sums import TO_FINE_POINTS
from ...mechanics.solver.slow_sums import SIGNALS
from ..setup.scene import Scene
from .fatigue import Rainflow, damage
from .mounts import MountSignals
from .polynomials import largest_size

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

    def output_errors(self, rows: np.ndarray, turns: np.ndarray) -> np.ndarray:
        """Return the displacement of the output (steps, nodes) by the shortening of the chord, to first order.

        turns : (steps, nodes) of the crank since the start
        """
        shortened = np.einsum("k,ckm->cm", self.shortening, rows[:, self.modes] ** 2)
        levers = np.interp(turns % 1.0, np.linspace(0.0, 1.0, len(self.levers)), self.levers)
        errors: np.ndarray = levers * shortened
        return errors

    def deflections(self, rows: np.ndarray) -> np.ndarray:
        """Return the deflection (steps, nodes) m of the middle from recorded steps."""
        deflections: np.ndarray = np.einsum("k,ckm->cm", self.shapes, rows[:, self.modes])
        return deflections


def _link_of(name: str, body: Body, first: int, life: tuple | None, levers: np.ndarray) -> LinkStress:
    """Return the LinkStress of a link whose signals begin at column `first` of the recording."""
    elastic = body.elastic
    assert elastic is not None  # only links that bend
    assert elastic.bending is not None
    bending, length = elastic.bending, planar.line_of(body, elastic).length
    wave_numbers = math.pi * np.arange(1, bending.modes + 1) / length
    shapes = np.sin(length * np.outer(planar.STATIONS, wave_numbers))
    first_force = first + bending.modes
    return LinkStress(
        column_name(name),
        length,
        slice(first, first_force),
        slice(first_force, first_force + len(planar.STATIONS)),
        shapes[MIDDLE],
        -bending.young * bending.edge * shapes * wave_numbers**2,
        bending.area,
        planar.first_rate(body, elastic) / (2.0 * math.pi),
        life,
        0.25 * length * wave_numbers**2,
        levers,
    )


def crank_column(scene: Scene) -> int:
    """Return the column of the recording with the crank's angle."""
    return SIGNALS + int(signal_count(scene.value.shaking))


def links_of(scene: Scene) -> list[LinkStress]:
    """Return the links of a scene that bend, in the order of their signals."""
    machine, links, first = scene.machine, [], crank_column(scene) + 1
    assert machine is not None  # only planar machines have links that bend
    values, section = scene.case.mechanism.values, "bodies." if scene.case.outline.bodies else ""
    for name, body in machine.bodies.items():
        if body.elastic and body.elastic.bending:
            path = f"{section}{name}.elastic.stress_life"
            life = tuple(values.get(f"{path}.{key}", math.nan) for key in ("strength", "exponent", "cycles"))
            levers = planar.levers(planar.ideal_of(planar.with_segments(machine)), name, *body.elastic[:2])
            links.append(_link_of(name, body, first, None if math.isnan(life[0]) else life, levers))
            first = links[-1].forces.stop
    return links


def output_bends(scene: Scene) -> bool:
    """Return whether the output is a point of a link that bends, off its pins, which moves relative to the chord."""
    assert scene.machine is not None  # as above
    aim = scene.machine.aim
    elastic = scene.machine.bodies[aim.body].elastic
    return bool(aim.point and elastic and elastic.bending and aim.point not in (elastic.near, elastic.far))


class LinkSignals:
    """Largest deflections and stresses of the links of a run, and its stress histories where a life is asked for."""

    def __init__(self, scene: Scene):
        """Prepare for the run of a scene."""
        self.links, self.crank_column = links_of(scene), crank_column(scene)
        self.output_bends = output_bends(scene)
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
        if self.links:
            errors = sum(link.output_errors(rows, turns) for link in self.links)
            self.output_error = largest_size(np.asarray(errors), self.output_error)
        for i, link in enumerate(self.links):
            self.deflections[i] = largest_size(link.deflections(rows), self.deflections[i])
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
    fine = stresses @ TO_FINE_POINTS
    joined = np.concatenate([stresses[..., START : START + 1], fine], axis=-1).reshape(steps, -1, fine.shape[-1] + 1)
    return joined.transpose(1, 0, 2).reshape(joined.shape[1], -1)
