"""The functions of `clearsweep.simulation` that sweeps use, as one value that can be sent to a worker process."""

from collections.abc import Callable, Hashable
from typing import NamedTuple

from ... import simulation
from ...contracts.case import Case
from ...contracts.catalogue import Catalogue
from ...contracts.results import Peak, Trajectory
from .worker import Simulator


def _recommended(case: Case) -> list[str]:
    return simulation.recommended_texts(simulation.recommendations(case))


class _Functions(NamedTuple):
    catalogue: Callable[[], Catalogue] = simulation.catalogue
    load: Callable[[], None] = simulation.load
    signature: Callable[[Case], Hashable] = simulation.signature
    compile_for: Callable[[Case], None] = simulation.compile_for
    compile_loop: Callable[[Case], None] = simulation.compile_loop
    solve: Callable[..., Trajectory] = simulation.solve
    peak: Callable[[Case, int, float, float | None], Peak] = simulation.peak_revolution
    derived: Callable[[Case], dict[str, tuple[float, str]]] = simulation.derived
    warnings: Callable[[Case], list[str]] = simulation.warnings
    recommended: Callable[[Case], list[str]] = _recommended
    alternatives: Callable[[Case], dict[str, list[str]]] = simulation.alternatives


SIMULATION: Simulator = _Functions()
