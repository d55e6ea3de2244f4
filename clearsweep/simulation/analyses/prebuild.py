"""Compiles the integration loop, which is the same for all cases, into the package.

`python -m clearsweep.simulation.analyses.prebuild [LEVEL ...]`: for these levels of processors (x86-64-v4, x86-64-v3,
aarch64), or else for that of this machine.  A wheel built afterwards contains the code, so users need not wait for it.
"""

import sys
import time

from ...grid import load
from ...tracing import cache, objects
from .. import catalogue
from .trajectory import compile_loop

IMPACT_PAIR = {  # any case is suitable
    "mechanism": {"type": "impact-pair", "masses": ["1 kg", "1 kg"], "speed": "1 m/s"},
    "joints": {
        "pair": {"bearing_radius": "10 mm", "clearance": "0.1 mm", "contact": {"law": "hertz", "stiffness": 1e10}}
    },
    "simulate": {"impacts": 1},
}


def main(levels: list[str]) -> int:
    """Compile the loop for processor levels and print each; return the exit code."""
    case = load(IMPACT_PAIR, catalogue()).case(0)
    cache.empty_package()
    for level in levels or [objects.level()]:
        known_levels = (*objects.LEVELS, *objects.OTHER_PROCESSORS)
        if level not in known_levels and level != objects.level():
            print(f"{level}: unknown processor level; known: {', '.join(known_levels)}", file=sys.stderr)
            return 2
        begin = time.perf_counter()
        with objects.compiling_for_package(level) as folder:
            compile_loop(case)
        print(f"integration loop for {level} in {folder}, {time.perf_counter() - begin:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
