"""Axes of a grid: mistakes under `sweep`, and what its cases share."""

import json
import pickle

import pytest
from fake_runs import CONFIGS, CONTACT, JOINT, TEXT, load

from clearsweep.grid.resolve import case_of

#: the lines under `sweep:`, and what the message begins with
AXES = {
    "empty": ("", "21:1: sweep: nothing is swept; write `dotted.path: [value, ...]`"),
    "no values": (f"{JOINT}.clearance: []", f"22:32: sweep.{JOINT}.clearance: the list is empty"),
    "one value": (
        "drive.speed: 5000 rpm",
        "22:16: sweep.drive.speed: found '5000 rpm'; expected a list such as [a, b] or",
    ),
    "duplicate": (
        f"{JOINT}.clearance: [0.5 mm, 1 mm, 500 um]",
        f"22:47: sweep.{JOINT}.clearance: duplicate value '500 um', the same as '0.5 mm' (line 22)",
    ),
    "wrong value": (
        f"{JOINT}.clearance:\n    - 0.5 mm\n    - 0.5 kg",
        f"24:7: {JOINT}.clearance: found '0.5 kg', whose unit kg",
    ),
    "out of range": (f"{CONTACT}.restitution: [0.5, 1.5]", f"22:48: {CONTACT}.restitution: found 1.5, out of range"),
    "wrong end": (
        f"{CONTACT}.restitution: {{linspace: [0.5, 1.5, 3]}}",
        f"22:59: {CONTACT}.restitution: found 1.5, out of range",
    ),
    "names nothing": (
        f"{JOINT}.clearanse: [1 mm]",
        f"22:3: sweep.{JOINT}.clearanse: names nothing; did you mean '{JOINT}.clearance'? (allowed next to it: ",
    ),
    "section": ("drive: [1]", "22:3: sweep.drive: names a section, not a value; such as drive.speed"),
    "absent section": (
        "joints.crank-rod.clearance: [1 mm]",
        "22:3: sweep.joints.crank-rod.clearance: there is no section 'joints.crank-rod'; write it before",
    ),
    "saved": ("save.samples: [90]", "22:3: sweep.save.samples: cannot be swept; write it outside"),
    "bins": (f"{JOINT}.wear.bins: [90, 360]", f"22:3: sweep.{JOINT}.wear.bins: cannot be swept"),
    "word": ("simulate.start: [centred, seated]", "22:3: sweep.simulate.start: cannot be swept"),
    "unknown law": (
        f"{CONTACT}.law: [hertz, flroes]",
        f"22:42: {CONTACT}.law: unknown law 'flroes'; did you mean 'flores'?",
    ),
    "spaced laws": (
        f"{CONTACT}.law: {{linspace: [hertz, flores, 2]}}",
        f"22:34: sweep.{CONTACT}.law: found a section; expected a list",
    ),
    "law without its keys": (
        f"{JOINT}.friction.law: [tanh, ambrosio]",
        f"17:15: {JOINT}.friction.velocity_scale: is missing for tanh (scale of the sliding speed)",
    ),
    "unused": (f"{CONTACT}.damping: [1, 2]", f"22:38: {CONTACT}.damping: is not used by law 'lankarani-nikravesh'"),
    "unknown generator": (
        "drive.speed: {space: [1, 2, 3]}",
        "22:16: sweep.drive.speed: found a section; expected a list",
    ),
    "two generators": (
        "drive.speed: {linspace: [1, 2, 3], geomspace: [1, 2, 3]}",
        "22:16: sweep.drive.speed: found a section",
    ),
    "two numbers": (
        "drive.speed: {linspace: [1, 2]}",
        "22:27: sweep.drive.speed: linspace: found a list of 2; expected [first, last, count]",
    ),
    "count 1": (
        "drive.speed: {linspace: [1, 2, 1]}",
        "22:27: sweep.drive.speed: linspace: found the count 1; expected a whole number from 2",
    ),
    "count 2.5": ("drive.speed: {linspace: [1, 2, 2.5]}", "22:27: sweep.drive.speed: linspace: found the count 2.5"),
    "huge count": (
        "drive.speed: {linspace: [1, 2, 1e12]}",
        "22:27: sweep.drive.speed: linspace: found the count 1000000000000",
    ),
    "equal ends": (
        "drive.speed: {linspace: [1, 1, 3]}",
        "22:27: sweep.drive.speed: linspace: 3 values from 1.0 to 1.0 (SI) are not all",
    ),
    "geomspace over 0": (
        "mechanism.gravity: {geomspace: [-1, 1, 3]}",
        "22:34: sweep.mechanism.gravity: geomspace: first and last have to be both",
    ),
    "huge exponent": (
        "drive.speed: {logspace: [0, 400, 3]}",
        "22:27: sweep.drive.speed: logspace: the exponents 0 and 400 lead beyond",
    ),
    "unit of logspace": (
        "drive.speed: {logspace: [0, 1, 3, mm]}",
        "22:27: sweep.drive.speed: logspace: found '1 mm', whose unit mm",
    ),
    "half steps": (
        "simulate.step_budget: {linspace: [1, 2, 3]}",
        "22:36: simulate.step_budget: found 1.5, out of range; allowed: a whole number",
    ),
    "unit of a swept exponent": (
        f"{CONTACT}.exponent: [1.4, 1.5]",
        f"15:18: {CONTACT}.stiffness: found '6.61e10 N/m^1.5', whose unit",
    ),
    "too wide": (
        f"{JOINT}.clearance: [0.1 mm, 11 mm]",
        f"22:32: {JOINT}.clearance: found 11 mm; allowed: below 10 mm",
    ),
    "half without a unit": (
        "drive.speed: [200 rpm, 0, 500]",
        "22:29: sweep.drive.speed: found 500 without a unit next to '200 rpm'; alone it would mean 500 rad/s",
    ),
    "an end without a unit": (
        "drive.speed: {linspace: [200, 500 rpm, 4]}",
        "22:28: sweep.drive.speed: found 200 without a unit next to '500 rpm'; alone it would mean 200 rad/s",
    ),
    "short run": (
        "simulate.revolutions: [2, 20]",
        "19:38: simulate.discard: found 2; allowed: below 2",
    ),
    "overridden": (
        f"{JOINT}.wear.hardness: [1e13]",
        f"18:39: {JOINT}.wear.coefficient: found 2e-14 m^2/N, times the hardness",
    ),
}


@pytest.mark.parametrize(("lines", "message"), AXES.values(), ids=AXES)
def test_a_mistake_in_a_sweep_is_told_with_its_place(problems_in, lines, message):
    problems = problems_in(f"{TEXT}sweep:\n" + (f"  {lines}\n" if lines else ""))
    assert any(problem.startswith(f"grid.yaml:{message}") for problem in problems), problems


@pytest.mark.slow
def test_a_list_that_nobody_wrote_by_hand_is_refused(problems_in):
    values = ", ".join(str(k) for k in range(1, 100_002))
    (problem,) = problems_in(f"{TEXT}sweep:\n  drive.speed: [{values}]\n")
    assert "found a list of 100001 values; at most 100000" in problem
    assert "linspace" in problem


def test_what_does_not_vary_is_made_once_and_what_varies_for_every_case(at):
    swept = at(TEXT + f"sweep:\n  {CONTACT}.restitution: [0.5, 0.9]\n")
    pair = load(CONFIGS / "impact_pair.yaml").resolved() | {"sweep": {"mechanism.masses.1": [0.1, 0.2]}}
    for cases in (swept, load(pair, {"joints.pair.contact.restitution": 0.5})):
        made = [cases.case(k) for k in (0, 1, 0)]
        assert made[0] == made[2] != made[1]
        assert made[0].simulate is made[1].simulate
        for k, case in enumerate(made[:2]):
            assert case == case_of(json.loads(json.dumps(cases.written_case(k))), case.outline)
            assert case == pickle.loads(pickle.dumps(cases)).case(k)
    first, second = swept.case(0).joints[0], swept.case(1).joints[0]
    assert first.wear is second.wear
    assert (first.contact.values["restitution"], second.contact.values["restitution"]) == (0.5, 0.9)
