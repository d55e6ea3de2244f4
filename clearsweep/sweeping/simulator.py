"""The functions of `clearsweep.simulation` that sweeps use, as one value that can travel to a worker process."""

from typing import NamedTuple

from .. import simulation
from .worker import Simulator


class _Functions(NamedTuple):
    catalogue: object = simulation.catalogue
    load: object = simulation.load
    signature: object = simulation.signature
    compile_for: object = simulation.compile_for
    solve: object = simulation.solve
    derived: object = simulation.derived
    warnings: object = simulation.warnings


SIMULATION: Simulator = _Functions()
