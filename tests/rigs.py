"""Identifies made-up rigs, measured with noise, gain and an unknown angle, and compares the result with the truth.

    python tests/rigs.py --rigs 20 --cases 400             # the model's own law, at another tolerance
    python tests/rigs.py --rigs 20 --law flores            # a law that the model does not have
    python tests/rigs.py --show FILE                       # the table of an earlier run

Every rig is a line of the JSON file; an interrupted run continues after the last one.  A rig takes 40 s of a core.

"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML

import clearsweep

GRID = Path(__file__).parents[1] / "configs/rig.yaml"
JOINT = "joints.rod-slider"
CLEARANCE, STIFFNESS = f"{JOINT}.clearance", f"{JOINT}.contact.stiffness"
KEYS = (CLEARANCE, f"{JOINT}.contact.restitution", STIFFNESS, f"{JOINT}.friction.coefficient")
TRUE = {  # of configs/rig.csv, SI
    **dict(zip(KEYS, (87e-6, 0.6, 6.61e10, 0.02), strict=True)),
    "noise": 0.02,  # rms over that of the signal
    "gain": 1.03,
    "angle": 40.0,  # deg, offset of the encoder
}


def base():
    """Return the rig as a grid without `identify`."""
    whole = YAML(typ="safe").load(GRID.read_text(encoding="utf-8"))
    return {key: part for key, part in whole.items() if key != "identify"}


def drawn(chance):
    """Return a made-up rig, within the ranges of configs/rig.yaml, but not near their ends."""
    parts = chance.uniform((0.25, 0.15, 0.15, 0.15), (0.9, 0.9, 0.85, 0.85))
    ends = ((20e-6, 300e-6), (0.2, 0.95), (1e10, 3e11), (2e-3, 0.1))
    values = [low * (high / low) ** part for (low, high), part in zip(ends, parts, strict=True)]
    values[1] = 0.2 + 0.75 * parts[1]
    gain, angle = np.exp(0.04 * chance.standard_normal()), chance.uniform(0.0, 360.0)
    return dict(zip(KEYS, map(float, values), strict=True)) | {
        "noise": 0.02,
        "gain": float(gain),
        "angle": float(angle),
    }


def measure(file, rig, seed, *, law=None, revolutions=30, samples=1440, places=2):
    """Write the signal of a rig's accelerometer over its encoder's angle; `law` : a contact law of its own, or None."""
    changes = {key: value for key, value in rig.items() if "." in key}
    changes |= {f"{JOINT}.contact.law": law} if law else {}
    changes |= {"simulate.tolerance": 1e-9, "save.samples": samples, "save.revolutions": revolutions}
    case = clearsweep.load_case(base(), overrides=changes | {"simulate.revolutions": revolutions + 5})
    motion = clearsweep.simulate(case)
    chance = np.random.default_rng(seed)
    values, angle = rig["gain"] * motion["slider/a"], np.degrees(motion["crank_angle"])
    values = values + rig["noise"] * values.std() * chance.standard_normal(len(values))
    rows = zip(angle - angle[0] + rig["angle"], values, strict=True)
    lines = [f"{place:.{places}f},{value:.0f}" for place, value in rows]
    Path(file).write_text("crank_angle [deg],acceleration [m/s^2]\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return motion.summary["rod_slider_impacts_per_rev"]


def identify(folder, rig, seed, cases, law=None):
    """Return the result for a rig: its interval, its half-width over its median, misfit, times."""
    impacts = measure(folder / "rig.csv", rig, seed, law=law)
    whole = YAML(typ="safe").load(GRID.read_text(encoding="utf-8"))
    whole["identify"] |= {"from": {str(folder / "rig.csv"): {"slider/a": "acceleration"}}, "cases": cases}
    begin = time.process_time()
    result = clearsweep.sweep(whole, folder / "run", show_progress=False)
    computed = {parameter.path: parameter for parameter in result.search_result.parameters}
    least = computed[CLEARANCE]
    return {
        "seed": seed,
        "law": law or "",
        "cases": cases,
        "model_version": clearsweep.MODEL_VERSION,
        "true": rig,
        "impacts": impacts,
        "found": {path: [each.low, each.value, each.high, each.determined] for path, each in computed.items()},
        "inside": bool(least.low <= rig[CLEARANCE] <= least.high),
        "half_width": (least.high - least.low) / 2.0 / least.value,
        "explained": result.search_result.explained,
        "processor_seconds_beside_the_cases": time.process_time() - begin,
        "case_seconds": result.case_seconds,
    }


def table(rows):
    """Print the results, for each rig and in total."""
    for row in rows:
        low, middle, high, _ = row["found"][CLEARANCE]
        text = f"{row['true'][CLEARANCE] * 1e6:6.1f} um in {low * 1e6:6.1f} .. {middle * 1e6:6.1f} .. {high * 1e6:6.1f}"
        width, own = 100.0 * row["half_width"], row["processor_seconds_beside_the_cases"]
        verdict = ("inside" if row["inside"] else "OUTSIDE") + ("" if row["explained"] else ", misfit said")
        print(f"{row['seed']:3d} {row['law']:12s} {text}  {width:5.1f} %  {own:5.1f} s  {verdict}")
    inside = sum(row["inside"] for row in rows)
    good = sum(row["inside"] or not row["explained"] for row in rows)
    print(
        f"{inside} of {len(rows)} inside; inside or misfit said: {good}; half-width, median: "
        f"{100.0 * np.median([row['half_width'] for row in rows]):.1f} %"
    )


def main():
    """Identify rigs and print the results."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--rigs", type=int, default=20)
    reader.add_argument("--cases", type=int, default=400)
    reader.add_argument("--law")
    reader.add_argument("--out", type=Path, default=Path("results/inverse/rigs.jsonl"))
    reader.add_argument("--show", type=Path)
    reader.add_argument("--write", action="store_true", help="write configs/rig.csv anew")
    asked = reader.parse_args()
    if asked.write:
        measure(GRID.with_name("rig.csv"), TRUE, 0, revolutions=10, samples=720, places=1)
        return
    file = asked.show or asked.out
    file.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["seed"], row["law"]) for row in rows}
    for seed in range(0 if asked.show else asked.rigs):
        if (seed, asked.law or "") not in done:
            with tempfile.TemporaryDirectory() as folder:
                rows.append(
                    identify(Path(folder), drawn(np.random.default_rng([33, seed])), seed, asked.cases, asked.law)
                )
            with file.open("a") as lines:
                lines.write(json.dumps(rows[-1]) + "\n")
            table(rows[-1:])
    table(rows)


if __name__ == "__main__":
    main()
