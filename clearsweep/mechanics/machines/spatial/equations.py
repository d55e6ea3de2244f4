"""Generated functions of a tree's compiled form, created at the first use of its type."""

import functools
import linecache
from collections.abc import Callable

from ....tracing.compiled import attitude, calculus, vector
from ...joints.spatial import SpatialGap
from ..contract import Motion
from ..planar.machine_type import kinds_of
from . import pose
from .dynamics import accelerate_code
from .kinematics import bearing_axes_code, describe_code, energy_code, gaps_code, output_code, pose_code
from .machine_type import MachineType


def generated(name: str) -> Callable:
    """Return the function `name`, generated for the type of tree at its first call."""

    def body_of(mechanism):
        return _functions(kinds_of(mechanism))[name]

    def dispatch(mechanism, *arguments):
        return body_of(mechanism)(mechanism, *arguments)

    dispatch.body_of = body_of
    return dispatch


def source_text(kinds: tuple) -> str:
    """Return the code of all functions of a type of tree."""
    tree = MachineType(kinds)
    return "\n\n".join(
        generate(tree)
        for generate in (
            pose_code,
            gaps_code,
            bearing_axes_code,
            energy_code,
            describe_code,
            output_code,
            accelerate_code,
        )
    )


@functools.lru_cache(maxsize=1024)
def _functions(kinds: tuple) -> dict[str, Callable]:
    """Return all functions of a type of tree by their names."""
    text = source_text(kinds)
    name = f"<machine in space {hash(kinds):x}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)  # for tracebacks
    functions: dict = {
        "direction": calculus.direction,
        "SpatialGap": SpatialGap,
        "Motion": Motion,
    }
    for module in (vector, attitude, pose):
        functions |= {name: value for name, value in vars(module).items() if not name.startswith("_")}
    exec(compile(text, name, "exec"), functions)
    return functions
