"""Trends of measured wear: volume and profile of a bushing, and the deepest wear of a spatial joint."""

import functools
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...contracts.results import Trajectory
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case
from .drawing import COLOURS, style_axes
from .points import Benchmark, Row, read_reference

NAME = "Trends of wear"
TEXT = """No measured depth with all parameters was available. Two trends are compared.

* **A slider-crank with a PTFE bushing** (Mukras et al.; the parameters of the grid are remembered or this project's
  own). Published: an elastic foundation and a contact force with finite elements predict the same worn volume, but
  only the latter predicts the profile. Here the volumes of four pressure laws agree to 3 %, as published: volume is
  coefficient times load times sliding distance, whatever the law. The profiles of a new bushing agree to 7 % (rms over
  the mean).
* **The same bushing worn by 60 um**, more than half of its clearance, while the worn shape acts back: once with a layer
  of springs (`elastic` and `pressure: winkler`), once with the pressure of a line contact (`hertz-line`). The layer
  presses over a wider arc. Its volume is 10 % larger, as the pressure all round is more than its resultant. At the same
  volume the profiles are 9 % apart (rms over the mean), and up to a quarter of the mean at one place; when new, 7 %.
* So the volume is alike within 10 %, and the profile differs more than that at single places: the published trend, but
  weaker. Likely cause: the load turns round the bushing in every revolution, which smears the arc that a law decides.
* **A joint in space** (Zhang et al. 2023): the bearing wears deepest at its edges. So it does here, in a bearing
  that is aligned and in one tilted by 0.3 deg."""
PRESSURES = ("persson", "winkler", "hertz-line", "mean")
WORN_IN_CONTACTS = {"foundation": {"elastic": "winkler", "thickness": 3e-3}, "line contact": {}}  # keys of its contact
WORN_DEPTH = 6e-5  # m
TILTS = {"aligned": 0.0, "tilted by 0.3 deg": np.radians(0.3)}


def bushing_grid(pressure: str) -> dict[str, Any]:
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


def worn_in_grid(kind: str) -> dict[str, Any]:
    """Return the grid of a bushing worn by WORN_DEPTH whose worn shape acts back; `kind`: key of WORN_IN_CONTACTS."""
    source = bushing_grid("winkler" if kind == "foundation" else "hertz-line")
    joint = source["joints"]["crank-rod"]
    joint["contact"] |= WORN_IN_CONTACTS[kind]
    joint["wear"] |= {"evolve": True, "bins": 180}
    return source | {"life": {"limit": WORN_DEPTH, "joint": "crank-rod"}}


@functools.cache
def worn_in_profiles() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the (nodes,) revolutions and (nodes, bins) depths (m) of both kinds of WORN_IN_CONTACTS."""
    histories = {kind: run(worn_in_grid(kind)).history for kind in WORN_IN_CONTACTS}
    return {kind: (history["revolutions"], history["crank_rod/profile_bearing"]) for kind, history in histories.items()}


def profile_difference(first: np.ndarray, second: np.ndarray) -> tuple[float, float]:
    """Return the difference of two profiles of the same volume, over their mean: rms, and largest."""
    difference = first / first.mean() - second / second.mean()
    return float(np.sqrt(np.mean(difference**2))), float(np.abs(difference).max())


def spatial_grid(tilt: float) -> dict[str, Any]:
    """Return the grid of a slider-crank with a spatial joint whose bearing is tilted (rad)."""
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
    """Return the run of a grid.  Raise RuntimeError if it fails."""
    trajectory = simulate(load_case(source))
    if trajectory.status != "ok":
        raise RuntimeError(f"a worn joint did not run: {trajectory.message}")
    return trajectory


def deepest_wear_position(trajectory: Trajectory) -> float:
    """Return the axial place of the deepest wear of the bearing: 0 in the middle, 1 in the strip at an edge."""
    depth = trajectory.wear["crank_rod"][0].max(axis=0)
    middle = 0.5 * (len(depth) - 1)
    return float(abs(int(np.argmax(depth)) - middle) / middle)


@functools.cache
def new_profiles() -> dict[str, np.ndarray]:
    """Return the (bins,) depth (m) of the new bushing by pressure law."""
    return {law: run(bushing_grid(law)).wear["crank_rod"][0] for law in PRESSURES}


def measure(*, quick: bool = False) -> list[Row]:
    """Return the rows of both trends; `quick` limits the first trend to two laws."""
    laws = PRESSURES[: 2 if quick else None]
    volume = {law: run(bushing_grid(law)).summary["crank_rod_wear_volume"] for law in laws}
    ratios = {(f"{law} over persson", "ratio of worn volumes"): volume[law] / volume["persson"] for law in laws[1:]}
    rows = read_reference(NAME, "bushing").rows(ratios)
    if quick:
        return rows
    rates = {kind: depths[-1].mean() / turns[-1] for kind, (turns, depths) in worn_in_profiles().items()}
    ratio = float(rates["line contact"] / rates["foundation"])
    rows += read_reference(NAME, "bushing").rows(
        {("line contact over foundation, worn in", "ratio of worn volumes"): ratio}
    )
    axial_positions = {
        (name, "place of the deepest wear"): deepest_wear_position(run(spatial_grid(tilt)))
        for name, tilt in TILTS.items()
    }
    return rows + read_reference(NAME, "in space").rows(axial_positions)


def picture(rows: list[Row]) -> Figure:
    """Draw the worn profile of the bushing by pressure law."""
    page = Figure(figsize=(9.0, 3.4), layout="constrained")
    new_panel, worn_panel = page.subplots(1, 2)
    for (law, depth), colour in zip(new_profiles().items(), COLOURS, strict=False):
        new_panel.plot(np.arange(len(depth)) * 360.0 / len(depth), 1e9 * depth, color=colour, label=law)
    for (kind, (_, depths)), colour in zip(worn_in_profiles().items(), COLOURS[1:], strict=False):
        depth = depths[-1]
        worn_panel.plot(np.arange(len(depth)) * 360.0 / len(depth), 1e6 * depth, color=colour, label=kind)
    new_panel.set(xlabel="angle on the bushing [deg]", ylabel="worn in 3 revolutions [nm]")
    worn_panel.set(xlabel="angle on the bushing [deg]", ylabel="worn in a life [um]")
    for panel in (new_panel, worn_panel):
        panel.legend(frameon=False)
        style_axes(panel)
    return page


BENCHMARK = Benchmark("worn", NAME, TEXT, measure, picture)
