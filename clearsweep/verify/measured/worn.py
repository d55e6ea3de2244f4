"""Trends of measured wear: volume and profile of a bushing, and where a joint in space wears deepest."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...contracts.results import Trajectory
from ...simulation.scene import load_case
from ...simulation.trajectory import simulate
from .drawing import COLOURS, tidy
from .points import Row, reference

NAME = "Trends of wear"
TEXT = """No measured depth with all parameters was available. Two trends are compared.

* **A slider-crank with a PTFE bushing** (Mukras et al.; the parameters of the grid are remembered or this project's
  own). Published: an elastic foundation and a contact force with finite elements predict the same worn volume, but
  only the latter predicts the profile. Here the volumes of four pressure laws agree to 3 %, as published: volume is
  coefficient times load times sliding distance, whatever the law. The profiles agree to 7 % (rms over the mean), so
  the second half of the trend is not seen. Likely causes: the load turns round the bushing in every revolution,
  which smears the arc that a law decides, and the run is too short for the worn shape to act back on the pressure.
* **A joint in space** (Zhang et al. 2023): the bearing wears deepest at its edges. So it does here, in a bearing
  that is aligned and in one tilted by 0.3 deg."""
PRESSURES = ("persson", "winkler", "hertz-line", "mean")
TILTS = {"aligned": 0.0, "tilted by 0.3 deg": np.radians(0.3)}


def bushing(pressure: str) -> dict[str, Any]:
    """Return the grid of a slider-crank whose PTFE bushing runs dry at 30 rpm under a spring."""
    material = {"bearing": {"young": 0.5e9, "poisson": 0.46}, "journal": {"young": 206e9, "poisson": 0.3}}
    spring = {"between": ["ground", "slider"], "anchor": [0.4, 0.0], "stiffness": 2000.0, "free_length": 0.2}
    return {
        "mechanism": {
            "type": "slider-crank",
            "crank": {"length": 0.0762, "mass": 3.0, "inertia": 3e-3},
            "rod": {"length": 0.2032, "mass": 2.0, "inertia": 8e-3},
            "slider": {"mass": 8.0},
        },
        "drive": {"speed": "30 rpm"},
        "loads": {"spring": spring},
        "joints": {
            "crank-rod": {
                "clearance": 1e-4,
                "bearing_radius": 9.5e-3,
                "length": 0.013,
                "contact": {"law": "flores", "restitution": 0.5, "material": material},
                "friction": {"law": "ambrosio", "coefficient": 0.13, "v0": 1e-4, "v1": 1e-3},
                "wear": {
                    "law": "archard",
                    "bearing_coefficient": 5.05e-13,
                    "journal_coefficient": 0.0,
                    "pressure": pressure,
                },
            }
        },
        "simulate": {"revolutions": 4, "discard": 1, "tolerance": 1e-6, "start": "seated"},
        "save": {"orbits": "none"},
    }


def in_space(tilt: float) -> dict[str, Any]:
    """Return the grid of a slider-crank with a joint in space whose bearing is tilted (rad)."""
    contact = {"law": "lankarani-nikravesh", "stiffness": 6.61e10, "exponent": 1.5, "restitution": 0.7}
    return {
        "mechanism": {
            "type": "slider-crank",
            "spatial": True,
            "crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4},
            "rod": {"length": 0.12, "mass": 0.21, "inertia": [2e-5, 2.5e-4, 2.5e-4], "center": 0.06},
            "slider": {"mass": 0.14},
            "gravity": 9.81,
            "ideal": {"rod-slider": "spherical"},
        },
        "drive": {"speed": "1000 rpm"},
        "joints": {
            "crank-rod": {
                "type": "spatial",
                "clearance": 2e-4,
                "axial_clearance": 2e-4,
                "bearing_radius": 0.01,
                "length": 0.02,
                "flange": True,
                "tilt": [tilt, 0.0],
                "contact": contact,
                "friction": {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2},
                "wear": {"law": "archard", "coefficient": 2e-14, "bins": 180, "length_bins": 20},
            }
        },
        "simulate": {"revolutions": 6, "discard": 2, "tolerance": 1e-8},
        "save": {"orbits": "none"},
    }


def run(source: dict[str, Any]) -> Trajectory:
    """Return the run of a grid.  Raises RuntimeError where it fails."""
    trajectory = simulate(load_case(source))
    if trajectory.status != "ok":
        raise RuntimeError(f"a worn joint did not run: {trajectory.message}")
    return trajectory


def deepest(trajectory: Trajectory) -> float:
    """Return where along the bearing it is worn deepest: 0 in the middle, 1 in the strip at an edge."""
    depth = trajectory.wear["crank_rod"][0].max(axis=0)
    middle = 0.5 * (len(depth) - 1)
    return float(abs(int(np.argmax(depth)) - middle) / middle)


def profiles() -> dict[str, np.ndarray]:
    """Return the (bins,) depth (m) of the bushing by pressure law."""
    return {law: run(bushing(law)).wear["crank_rod"][0] for law in PRESSURES}


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of both trends; `quick`: of two laws of the first."""
    laws = PRESSURES[: 2 if quick else None]
    volume = {law: run(bushing(law)).summary["crank_rod_wear_volume"] for law in laws}
    ratios = {(f"{law} over persson", "ratio of worn volumes"): volume[law] / volume["persson"] for law in laws[1:]}
    rows = reference(NAME, "bushing").rows(ratios)
    if quick:
        return rows
    places = {(name, "place of the deepest wear"): deepest(run(in_space(tilt))) for name, tilt in TILTS.items()}
    return rows + reference(NAME, "in space").rows(places)


def picture(rows: list[Row]) -> Figure:
    """Draw the worn profile of the bushing by pressure law."""
    page = Figure(figsize=(6.0, 3.4), layout="constrained")
    panel = page.subplots()
    for (law, depth), colour in zip(profiles().items(), COLOURS, strict=False):
        panel.plot(np.arange(len(depth)) * 360.0 / len(depth), 1e9 * depth, color=colour, label=law)
    panel.set(xlabel="angle on the bushing [deg]", ylabel="worn in 3 revolutions [nm]")
    panel.legend(frameon=False)
    tidy(panel)
    return page
