"""The bits of 500 scenes, and of short runs of every file of `configs/`, are those that were recorded.

`python tests/test_recorded_bits.py [runs] [scenes]` prints what moved, by default of the runs; with --write it records
all anew.  Bits may change on purpose, with a line in the changelog.  They are the same for all levels of x86-64, as
`test_portable` shows, with the libraries of constraints.txt.
"""

import argparse
import contextlib
import hashlib
import itertools
import json
import math
import platform
import re
import sys
from pathlib import Path

import law_cases
import numpy as np
import portable_bits
import pytest
from mechanism_cases import slider_crank
from traced_states import rates_of, states

import clearsweep

FILE = Path(__file__).parent / "recorded_bits.json"
COUNT, STRIDE = 500, 997
SAMPLES = 4  # of an array that are recorded, rounded, besides its bits
ROUNDING = 1e-4  # of these, relative to the largest
SHOWN = 40  # columns of a case in a message
GRIDS = sorted(path.name for path in portable_bits.CONFIGS.glob("*.yaml"))
CASES = ("first", "last")

RECORDED = json.loads(FILE.read_text()) if FILE.exists() else {"scenes": {}, "runs": {}}


def combinations():
    """Yield combinations of a loss, an elastic law and a law of friction that go together, in a fixed odd order."""
    every = [
        (law, elastic, friction)
        for law in law_cases.names("law")
        for elastic in (law_cases.names("elastic") if law_cases.RECIPES["law", law].law.uses_elastic else ["power"])
        for friction in ("", *law_cases.names("friction"))
    ]
    for i in range(len(every)):
        chosen = every[i * STRIDE % len(every)]
        with contextlib.suppress(clearsweep.InputError):
            scene_of(*chosen)
            yield chosen


def scene_of(law, elastic, friction):
    """Return the scene of a slider-crank with these laws."""
    section = law_cases.written(law, elastic, friction or None)
    changes = {f"joints.rod-slider.{key}": value for key, value in section.items()}
    return clearsweep.load_case(slider_crank("rod-slider", changes=changes))


def digest(law, elastic, friction):
    """Return a hash of the rates and observables of eight states of a scene."""
    scene = scene_of(law, elastic, friction)
    result = hashlib.sha256()
    for seed in (7, 8):
        done = rates_of(scene, states(scene, seed))
        result.update(done.k.tobytes() + done.o.tobytes())
    return result.hexdigest()[:16]


def summarised(value):
    """Return a figure as it is, an array as [hash of its bits, length, largest magnitude, samples], rounded."""
    if not isinstance(value, np.ndarray):
        return value
    numbers = np.asarray(value, dtype=float).ravel()
    places = [(k + 1) * numbers.size // SAMPLES - 1 for k in range(SAMPLES)] if numbers.size >= SAMPLES else []
    largest = np.abs(numbers).max(initial=0.0)
    rounded = (float(f"{x:.5g}") for x in (largest, *numbers[places]))
    return [portable_bits.digest(value), numbers.size, *rounded]


def run(name):
    """Return the columns of the first and of the last case of a grid, summarised, by the words of CASES."""
    return {
        case: {key: summarised(value) for key, value in portable_bits.columns(name, case == "last").items()}
        for case in CASES
    }


def difference(before, after):
    """Return the relative difference of a column from its record, as far as the record shows it: inf if not at all."""
    if isinstance(before, list) and isinstance(after, list):
        if before[1] != after[1]:
            return math.inf
        apart = max((abs(a - b) for a, b in zip(before[2:], after[2:], strict=True)), default=0.0)
        return apart / max(before[2], after[2]) if apart else 0.0
    if isinstance(before, int | float) and isinstance(after, int | float):
        return abs(after - before) / max(abs(before), abs(after))
    return math.inf


def spoken(value):
    """Return a recorded value as a few words."""
    if isinstance(value, list):
        _, count, *numbers = value
        return f"{count} numbers up to {numbers[0]:g}"
    return repr(value)


def moved(recorded, computed):
    """Return a line for each column whose bits differ from its record, the largest relative difference first."""
    lines = [(math.inf, f"{name}: gone") for name in recorded.keys() - computed.keys()]
    lines += [(math.inf, f"{name}: new") for name in computed.keys() - recorded.keys()]
    for name in recorded.keys() & computed.keys():
        before, after = recorded[name], computed[name]
        if repr(before) != repr(after):
            size = difference(before, after)
            size_text = f"< {ROUNDING:g}" if isinstance(before, list) and size < ROUNDING else f"{size:.2g}"
            lines.append((size, f"{name}: {size_text} ({spoken(before)} -> {spoken(after)})"))
    return [line for _, line in sorted(lines, key=lambda pair: (-pair[0], pair[1]))]


def report(name, runs):
    """Return what moved in the runs of a grid of `configs/`, a line for each column; '' if nothing did."""
    text, recorded = [], RECORDED["runs"].get(name)
    if recorded is None:
        return f"configs/{name} is not recorded"
    for case, computed in runs.items():
        lines = moved(recorded[case], computed)
        if lines:
            head = f"configs/{name}, {case} case: the bits of {len(lines)} of {len(computed)} columns moved"
            text += [head, *(f"  {line}" for line in lines[:SHOWN])]
            text += [f"  and {len(lines) - SHOWN} more"] if len(lines) > SHOWN else []
    return "\n".join(text)


on_the_recorded_system = pytest.mark.skipif(
    (sys.platform, platform.machine()) != ("linux", "x86_64"), reason="the bits are those of x86-64 and glibc"
)


@on_the_recorded_system
@pytest.mark.heavy
@pytest.mark.compiled
@pytest.mark.parametrize("name", GRIDS)
def test_the_bits_of_a_run_are_those_that_were_recorded(name):
    text = report(name, run(name))
    assert not text, f"{text}\nIf this is meant: python tests/test_recorded_bits.py --write, and say so in CHANGELOG.md"


def test_runs_are_recorded_of_the_files_that_there_are():
    assert sorted(RECORDED["runs"]) == GRIDS


def test_a_column_that_moves_is_named_with_its_relative_difference():
    x = np.linspace(0.0, 2.0, 9)
    record = {"peak": 4.0, "wear": None, "x": summarised(x), "v": summarised(x), "old": 1}
    later = {"peak": 5.0, "wear": 1.0, "x": summarised(x * (1.0 + 1e-12)), "v": summarised(x[::-1]), "new": 1}
    assert moved(record, json.loads(json.dumps(record))) == []
    assert moved(record, later) == [
        "new: new",
        "old: gone",
        "wear: inf (None -> 1.0)",
        "v: 1 (9 numbers up to 2 -> 9 numbers up to 2)",
        "peak: 0.2 (4.0 -> 5.0)",
        "x: < 0.0001 (9 numbers up to 2 -> 9 numbers up to 2)",
    ]


@on_the_recorded_system
@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize("name", RECORDED["scenes"])
def test_the_bits_of_a_scene_are_those_that_were_recorded(name):
    assert digest(*name.split("+")) == RECORDED["scenes"][name]


def test_as_many_scenes_are_recorded_as_are_spoken_of():
    assert len(RECORDED["scenes"]) == COUNT


def scenes():
    """Return the digests of COUNT scenes by their names; prints its progress."""
    made = {}
    for chosen in itertools.islice(combinations(), COUNT):
        made["+".join(chosen)] = digest(*chosen)
        print(len(made), *chosen, file=sys.stderr)
    return made


def main():
    """Print what moved, or record it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", help="runs (default), scenes")
    parser.add_argument("--write", action="store_true", help="record all anew")
    asked = parser.parse_args()
    made = {}
    for part in asked.parts or ["runs"]:
        made[part] = MADE[part]()
    for name, computed in made.get("runs", {}).items():
        print(report(name, computed) or f"configs/{name}: nothing moved")
    for line in moved(RECORDED["scenes"], made.get("scenes", RECORDED["scenes"])):
        print(line)
    if asked.write:
        text = json.dumps(RECORDED | made, indent=0)
        arrays_on_a_line = re.sub(r"\[[^]]*\]", lambda array: array[0].replace("\n", ""), text)
        FILE.write_text(arrays_on_a_line + "\n", encoding="utf-8")


MADE = {"runs": lambda: {name: run(name) for name in GRIDS}, "scenes": scenes}

if __name__ == "__main__":
    main()
