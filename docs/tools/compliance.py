"""Prints the table of docs/trust.md on links and housings that yield: force peaks over those of the rigid machine.

It takes some minutes: python docs/tools/compliance.py
"""

from pathlib import Path
from typing import Any, NamedTuple

from ruamel.yaml import YAML

import clearsweep

ROOT = Path(__file__).parents[2]
MODULUS, DAMPING = 207e9, 0.01  # Pa, 1: steel
HOUSING = {"mass": 10.0, "stiffness": 1e8, "damping": "5 %"}  # kg, N/m


class Machine(NamedTuple):
    """A shipped machine, the link of it that yields, and the speeds of its crank."""

    grid: str
    link: str
    length: float  # m
    section: tuple[float, float]  # m, across the plane and in it
    speeds: tuple[int, ...]  # rpm
    revolutions: int


MACHINES = (
    Machine("error_budget", "rod", 0.12, (0.01, 0.02), (750, 1500, 3000), 30),
    Machine("one_case", "rod", 0.12, (0.01, 0.02), (1000, 2000, 5000), 13),
    Machine("four_bar", "coupler", 0.12, (0.01, 0.02), (150, 300, 600), 8),
)


def variants(machine: Machine) -> dict[str, dict[str, Any]]:
    """Return the changes of a grid for each kind of compliance."""
    width, height = machine.section
    elastic = f"mechanism.{machine.link}.elastic"
    axial = {"axial_stiffness": MODULUS * width * height / machine.length, "damping": DAMPING}
    bending = {"section": list(machine.section), "young": MODULUS, "bending": 2, "damping": DAMPING}
    return {
        "rigid": {},
        "axial": {elastic: axial},
        "bending": {elastic: bending},
        "housing": {"mechanism.mounts.ground-crank": HOUSING},
    }


def force_peak(machine: Machine, speed: int, changes: dict[str, Any]) -> float:
    """Return the largest force peak (N) of all joints."""
    grid = YAML(typ="safe").load((ROOT / f"configs/{machine.grid}.yaml").read_text(encoding="utf-8"))
    for name in ("cases", "sweep", "limits", "save"):
        grid.pop(name, None)
    if machine.grid == "error_budget":
        del grid["mechanism"]["rod"]["elastic"], grid["mechanism"]["mounts"]
    for path, value in changes.items():
        *parents, last = path.split(".")
        section = grid
        for key in parents:
            section = section.setdefault(key, {})
        section[last] = value
    grid["drive"] = {"speed": f"{speed} rpm"}
    grid["simulate"] = {"revolutions": machine.revolutions, "discard": 3, "tolerance": 1e-7}
    grid["save"] = {"orbits": "none"}
    summary = clearsweep.simulate(clearsweep.load_case(grid)).summary
    return max(value for name, value in summary.items() if name.endswith("_force_peak"))


def main() -> None:
    """Print one row for each machine and speed."""
    print("| machine | speed | peak, rigid | axial | bending | housing |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    for machine in MACHINES:
        for speed in machine.speeds:
            peaks = {name: force_peak(machine, speed, changes) for name, changes in variants(machine).items()}
            rigid = peaks.pop("rigid")
            shares = " | ".join(f"{100.0 * (peak / rigid - 1.0):+.0f} %" for peak in peaks.values())
            print(f"| `{machine.grid}` | {speed} rpm | {rigid:.4g} N | {shares} |", flush=True)


if __name__ == "__main__":
    main()
