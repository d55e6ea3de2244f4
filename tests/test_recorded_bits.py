"""The bits that machine code gives for 500 scenes are those that were recorded: `python tests/test_recorded_bits.py`.

They may change with the rounding of a formula, on purpose, with a line in the changelog.
"""

import contextlib
import hashlib
import itertools
import json
import sys
from pathlib import Path

import law_cases
import pytest
from mechanism_cases import slider_crank
from traced_states import rates_of, states

import clearsweep

FILE = Path(__file__).parent / "recorded_bits.json"
COUNT, STRIDE = 500, 997


RECORDED = json.loads(FILE.read_text()) if FILE.exists() else {}


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


@pytest.mark.slow
@pytest.mark.parametrize("name", RECORDED)
def test_the_bits_of_a_scene_are_those_that_were_recorded(name):
    assert digest(*name.split("+")) == RECORDED[name]


def test_as_many_scenes_are_recorded_as_are_spoken_of():
    assert len(RECORDED) == COUNT


if __name__ == "__main__":
    made = {}
    for chosen in itertools.islice(combinations(), COUNT):
        made["+".join(chosen)] = digest(*chosen)
        print(len(made), *chosen, file=sys.stderr)
    FILE.write_text(json.dumps(made, indent=0) + "\n")
