"""Claims about grids: which cases a file means, and what a case is called."""

import copy
import functools
import itertools
import json
import math
import re
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from fake_runs import CATALOGUE, CONFIGS, CONTACT, JOINT, TEXT, ids, load, sweep
from hypothesis import given
from hypothesis import strategies as st
from right_grids import PAGE, grid_of
from ruamel.yaml import YAML

import clearsweep
from clearsweep import grid, simulation
from clearsweep.contracts.layout import JointLayout
from clearsweep.grid.pages.schema import whole_schema
from clearsweep.language.errors import InputError


@pytest.fixture
def base(at):
    """The demo grid as a dict in SI."""
    return at(TEXT).resolved()


# ------------------------------------------------------------------------------------------------ the resolved case


def test_a_case_is_in_si_with_every_default_filled_in(at):
    demo = at(TEXT)
    assert (demo.name, demo.source, len(demo), demo.axes) == ("demo", "grid.yaml", 1, {})
    body = {"crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4, "center": 0.025}}
    body["rod"] = {"length": 0.12, "mass": 0.21, "inertia": 2.5e-4, "center": 0.06}
    contact = {"law": "lankarani-nikravesh", "elastic": "power", "stiffness": 6.61e10, "exponent": 1.5}
    wear = {"law": "archard", "bins": 360, "pressure": "mean", "bearing_coefficient": 2e-14}
    joint = {"clearance": 5e-4, "bearing_radius": 0.01, "length": 0.02, "journal": "rod"}
    joint["contact"] = contact | {"restitution": 0.9, "onset": "renewed"}
    joint["friction"] = {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2}
    joint["wear"] = wear | {"journal_coefficient": 2e-14, "coefficient_unit": "m^2/N"}
    words = {"start": "centred", "method": "auto"}
    budgets = {"step_budget": 1_000_000, "event_budget": 100_000, "time_budget": 600.0}
    assert demo.written_case(0) == {
        "mechanism": {"type": "slider-crank", **body, "slider": {"mass": 0.14}, "gravity": 0.0},
        "drive": {"speed": pytest.approx(5000 * math.pi / 30, rel=3e-16, abs=0.0)},
        "joints": {"rod-slider": joint},
        "simulate": {"revolutions": 10.0, "discard": 2.0, "tolerance": 1e-8, **words, **budgets},
        "save": {"orbits": "last", "revolutions": 2.0, "samples": 720},
    }


def test_an_impact_pair_has_two_masses_and_no_drive():
    pair = load(CONFIGS / "impact_pair.yaml")
    case = pair.written_case(0)
    assert case["mechanism"] == {"type": "impact-pair", "masses": [0.2, 0.2], "speed": 1.0}
    assert set(case) == {"mechanism", "joints", "simulate", "save"}
    assert set(case["simulate"]) == {"impacts", "tolerance", "step_budget", "event_budget", "time_budget", "method"}
    assert case["save"] == {"orbits": "last", "samples": 720}
    assert (pair.layout.mechanism, pair.layout.turns, pair.layout.output) == ("impact-pair", False, "")
    assert pair.layout.joints == (JointLayout("pair"),)


def test_the_masses_of_an_impact_pair_can_be_swept_and_overridden():
    axes = {"mechanism.masses.1": {"linspace": ["100 g", "300 g", 3]}}
    pair = load(
        load(CONFIGS / "impact_pair.yaml").resolved() | {"sweep": axes}, {"joints.pair.contact.restitution": 0.5}
    )
    assert [pair.written_case(k)["mechanism"]["masses"] for k in range(3)] == [[0.2, 0.1], [0.2, 0.2], [0.2, 0.3]]
    assert load(pair.resolved()).fixed_settings() == pair.fixed_settings()
    first = load(CONFIGS / "impact_pair.yaml", {"mechanism.masses.0": "1 kg", "joints.pair.contact.restitution": 0.5})
    assert first.written_case(0)["mechanism"]["masses"] == [1.0, 0.2]


def test_what_is_left_out_does_not_appear(at):
    plain = at(TEXT, {f"{JOINT}.friction": None, f"{JOINT}.wear": None, f"{JOINT}.length": None}).written_case(0)
    assert set(plain["joints"]["rod-slider"]) == {"clearance", "bearing_radius", "journal", "contact"}


def test_defaults_that_follow_from_other_values(base):
    cases = load(sweep(base, {"mechanism.crank.length": ["40 mm", "50 mm"]}), {"mechanism.crank.center": None})
    assert [cases.written_case(k)["mechanism"]["crank"]["center"] for k in range(2)] == [0.02, 0.025]
    short = load(base, {"simulate": {"revolutions": 1}, "save": None}).written_case(0)
    assert (short["simulate"]["discard"], short["save"]["revolutions"]) == (0.0, 1.0)


def test_material_replaces_the_stiffness(base):
    contact = load(base, {f"{CONTACT}.stiffness": None, f"{CONTACT}.material": {"young": "207 GPa", "poisson": 0.3}})
    contact = contact.written_case(0)["joints"]["rod-slider"]["contact"]
    assert "stiffness" not in contact
    assert contact["material"] == {"young": 2.07e11, "poisson": 0.3}


def test_each_body_may_have_its_own_wear_coefficient(base):
    wear = {"law": "archard", "coefficient": 1e-14, "journal_coefficient": 0}
    both = load(base, {f"{JOINT}.wear": wear}).written_case(0)
    assert both["joints"]["rod-slider"]["wear"]["bearing_coefficient"] == 1e-14
    assert both["joints"]["rod-slider"]["wear"]["journal_coefficient"] == 0.0


def test_the_layout_lists_clearance_joints_in_the_order_of_the_mechanism(base):
    joints = base["joints"] | {"ground-crank": copy.deepcopy(base["joints"]["rod-slider"])}
    del joints["ground-crank"]["wear"], joints["ground-crank"]["journal"]
    two = load(base | {"joints": joints})
    assert (two.layout.mechanism, two.layout.turns, two.layout.output) == ("slider-crank", True, "slider")
    assert two.layout.joints == (
        JointLayout("ground_crank", friction=True),
        JointLayout("rod_slider", 360, friction=True),
    )
    assert two.written_case(0)["joints"]["ground-crank"]["journal"] == "crank"


# ------------------------------------------------------------------------------------------------------ identity


def test_the_id_of_the_demo_case_is_pinned(at):
    """Changes only together with MODEL_VERSION or the keys of a case: else every stored result is orphaned."""
    assert at(TEXT).case_id(0) == "601185aafe0dd9df"


SAME = {
    "name": ("name: demo", "name: other"),
    "save": ("save: {orbits: last, samples: 720}", "save: {orbits: all, revolutions: 3, samples: 90}"),
    "unit": ("clearance: 0.5 mm", "clearance: 500 um"),
    "metres": ("clearance: 0.5 mm", "clearance: 5e-4 m"),
    "integer": ("revolutions: 10,", "revolutions: 10.0,"),
    "whole": ("2e-14 m^2/N}", "2e-14 m^2/N, bins: 360.0}"),
    "default": ("drive:", "  gravity: -0.0 m/s^2\ndrive:"),
    "order": ("crank:  {length: 50 mm, mass: 0.30 kg,", "crank:  {mass: 0.30 kg, length: 50 mm,"),
    "hertz": ("speed: 5000 rpm", "speed: 83.33333333333333333333 Hz"),
    "both": ("coefficient: 2e-14 m^2/N", "bearing_coefficient: 2e-14, journal_coefficient: 2e-14"),
    "left out": (", center: 60 mm", ""),
    "patience": ("tolerance: 1e-8", "tolerance: 1e-8, time_budget: 5 s"),
    "quoted": ("restitution: 0.9", "restitution: '0.9'"),
}


@pytest.mark.parametrize(("old", "new"), SAME.values(), ids=SAME)
def test_the_id_does_not_depend_on_how_a_case_is_written(at, old, new):
    assert old in TEXT
    assert at(TEXT.replace(old, new)).case_id(0) == at(TEXT).case_id(0)


OTHER = [
    ("clearance: 0.5 mm", "clearance: 0.50000000000001 mm"),
    ("law: ambrosio, ", "law: tanh, velocity_scale: 1 mm/s, "),
    ("revolutions: 10,", "revolutions: 11,"),
    ("tolerance: 1e-8", "tolerance: 1e-9"),
    ("tolerance: 1e-8", "tolerance: 1e-8, step_budget: 10"),
]


@pytest.mark.parametrize(("old", "new"), OTHER)
def test_the_id_depends_on_everything_that_is_computed_with(at, old, new):
    text = TEXT.replace(old, new)
    if "tanh" in new:
        text = text.replace(", v0: 1 mm/s, v1: 10 mm/s", "")
    assert at(text).case_id(0) != at(TEXT).case_id(0)


def test_the_id_depends_on_the_models_version(at, monkeypatch):
    before = at(TEXT).case_id(0)
    monkeypatch.setattr("clearsweep.grid.cases.MODEL_VERSION", "another")
    assert at(TEXT).case_id(0) != before


def test_a_swept_case_has_the_id_of_the_same_case_written_out(at, base):
    cases = at(TEXT + f"sweep:\n  {JOINT}.clearance: [0.1 mm, 0.5 mm]\n")
    assert cases.case_id(1) == at(TEXT).case_id(0) == load(base).case_id(0)


NO_GRIDS = "nothing", "an impact pair with a law of a file", "a crank without its bearing", "a yoke"
GRIDS = [*CONFIGS.glob("*.yaml"), *Path(grid.__file__).parent.glob("starters/*.yaml")]
GRIDS += [
    grid_of(name) for name in re.findall("^== (.*)$", PAGE.read_text(encoding="utf-8"), re.M) if name not in NO_GRIDS
]


def test_a_resolved_grid_loads_to_the_same_cases():
    for source in GRIDS:
        original = grid.load(source, simulation.catalogue())
        again = grid.load(json.loads(json.dumps(original.resolved())), simulation.catalogue())
        assert ids(again) == ids(original)
        assert len(set(ids(original))) == len(original)
        for name in ("axes", "layout", "search", "verdict", "limits", "roles"):
            assert getattr(again, name) == getattr(original, name), (source, name)
        assert again.fixed_settings() == original.fixed_settings()
        for index in (0, len(original) - 1):
            assert again.case(index)._replace(outline=None) == original.case(index)._replace(outline=None), source


def test_every_column_of_the_cases_may_have_a_limit():
    for source in GRIDS[::3]:
        names = [column.name for column in grid.load(source, simulation.catalogue()).layout.columns]
        limited = grid.load(source, simulation.catalogue(), {"limits": dict.fromkeys(names, 1)})
        assert [*limited.limits] == names, source


# ---------------------------------------------------------------------------------------------------------- axes


def test_the_cases_are_the_product_of_the_axes(base):
    axes = {f"{JOINT}.clearance": ["0.1 mm", "0.2 mm"], "drive.speed": [100, 200, 300], f"{CONTACT}.restitution": [0.5]}
    cases = load(sweep(base, axes))
    points = [cases.point(k) for k in range(len(cases))]
    assert points == [
        dict(zip(axes, values, strict=True)) for values in itertools.product([1e-4, 2e-4], [100, 200, 300], [0.5])
    ]
    assert list(cases.axes) == list(axes)
    for k, point in enumerate(points):
        assert cases.written_case(k)["joints"]["rod-slider"]["clearance"] == point[f"{JOINT}.clearance"]
        assert cases.written_case(k)["drive"]["speed"] == point["drive.speed"]
    for k in (-1, 6):
        with pytest.raises(IndexError):
            cases.case(k)


def test_spaced_axes_are_those_of_numpy_and_end_exactly(base):
    def axis(path, given):
        return load(sweep(base, {path: given})).axes[path]

    linear = axis(f"{CONTACT}.restitution", {"linspace": [0.5, 0.95, 4]})
    assert linear == pytest.approx(np.linspace(0.5, 0.95, 4), rel=1e-15, abs=0.0)
    assert linear == (0.5, 0.65, 0.8, 0.95)
    power = axis(f"{CONTACT}.stiffness", {"geomspace": ["1e9 N/m^1.5", "1e11 N/m^1.5", 5]})
    assert power == pytest.approx(np.geomspace(1e9, 1e11, 5), rel=1e-14)
    assert (power[0], power[-1]) == (1e9, 1e11)
    assert axis(f"{JOINT}.clearance", {"logspace": [-5, -3.5, 4]}) == pytest.approx(
        np.logspace(-5, -3.5, 4), rel=1e-14, abs=0.0
    )
    assert axis(f"{JOINT}.clearance", {"logspace": [-2, 0, 3, "mm"]}) == pytest.approx(
        [1e-5, 1e-4, 1e-3], rel=1e-15, abs=0.0
    )
    assert axis("simulate.step_budget", {"linspace": [10, 30, 3]}) == (10, 20, 30)
    assert axis("drive.speed", np.array([1.0, 2.0])) == (1.0, 2.0)


@given(st.integers(1, 400), st.integers(1, 400), st.integers(2, 30))
def test_a_linear_axis_has_the_bits_of_the_values_written_out(first, step, count):
    text = load(CONFIGS / "frictionless.yaml").resolved()
    listed = [f"{first + k * step} nm" for k in range(count)]
    spaced = {"linspace": [listed[0], listed[-1], count]}
    path = f"{JOINT}.clearance"
    assert load(sweep(text, {path: spaced})).axes == load(sweep(text, {path: listed})).axes


def test_a_refined_axis_keeps_the_cases_it_had(base):
    coarse, fine = (load(sweep(base, {f"{CONTACT}.restitution": {"linspace": [0.1, 0.7, n]}})) for n in (4, 7))
    assert set(ids(coarse)) <= set(ids(fine))


def test_laws_can_be_swept_and_only_keys_in_use_enter_a_case(at):
    text = TEXT.replace("    wear: {law: archard, coefficient: 2e-14 m^2/N}\n", "")
    text = text.replace("6.61e10 N/m^1.5", "6.61e10").replace(
        "restitution: 0.9", "restitution: 0.9\n      damping: 3 N*s/m"
    )
    cases = at(f"{text}sweep:\n  {CONTACT}.law: [hertz, kelvin-voigt, flores]\n")
    contacts = [cases.written_case(k)["joints"]["rod-slider"]["contact"] for k in range(3)]
    assert contacts[0] == {"law": "hertz", "elastic": "power", "stiffness": 6.61e10, "exponent": 1.5}
    assert contacts[1] == {"law": "kelvin-voigt", "stiffness": 6.61e10, "damping": 3.0}
    assert contacts[2] == contacts[0] | {"law": "flores", "restitution": 0.9, "onset": "renewed"}
    less = at(f"{text}sweep:\n  {CONTACT}.law: [flores]\n")
    assert less.case_id(0) == cases.case_id(2)
    assert less.fixed_settings() == cases.fixed_settings()
    assert (cases.unit(f"{CONTACT}.law"), cases.unit("drive.speed")) == ("", "rad/s")


def test_a_swept_key_that_a_swept_law_does_not_use_makes_no_duplicate_cases(base):
    axes = {f"{CONTACT}.restitution": [0.5, 0.9], "drive.speed": [1, 2], f"{CONTACT}.law": ["hertz", "flores", "exact"]}
    cases = load(sweep(base, axes))
    assert len(cases) == (1 + 2 + 2) * 2 == len(set(ids(cases)))
    points = [cases.point(k) for k in range(len(cases))]
    assert {(p[f"{CONTACT}.law"], p[f"{CONTACT}.restitution"]) for p in points} == {
        ("hertz", None),
        *itertools.product(("flores", "exact"), (0.5, 0.9)),
    }
    assert all(list(point) == list(axes) for point in points)


def test_all_ids_at_once_are_those_of_the_cases_one_by_one(base):
    """With laws, values that others follow from, axes in step, and more rows than are kept."""
    free = {"simulate.discard": None, "mechanism.crank.center": None, "save.revolutions": None}
    axes = {
        f"{CONTACT}.law": ["hertz", "flores"],
        f"{CONTACT}.restitution": [0.5, 0.9],
        "mechanism.crank.length": [0.04, 0.05],
        "simulate.revolutions": [2, 3.5],
    }
    step = {"drive.speed": [10.0, 20.0], f"{JOINT}.wear.coefficient": [1e-14, 3e-14]}
    laws = load(sweep(base, axes) | {"zip": step}, free | {f"{JOINT}.wear.bearing_coefficient": None})
    masses = load(
        load(CONFIGS / "impact_pair.yaml").resolved()
        | {"sweep": {"mechanism.masses.1": {"linspace": [0.1, 0.2, 4099]}, "mechanism.speed": [1.0, 2]}},
        {"joints.pair.contact.restitution": 0.5},
    )
    for cases in (laws, masses, load(base)):
        result = [f"{number:016x}" for number in cases.identities()]
        assert len(result) == len(cases)
        some = range(0, len(cases), max(1, len(cases) // 40))
        assert [result[k] for k in some] == [grid.identity(cases.written_case(k)) for k in some]
    points = [laws.written_case(k) for k in range(len(laws))]
    assert {point["simulate"]["discard"] for point in points} == {0.0, 2.0}
    assert {point["mechanism"]["crank"]["center"] for point in points} == {0.02, 0.025}


def test_the_stiffness_law_and_its_exponent_can_be_swept(base):
    free = {f"{JOINT}.wear": None}
    cases = load(sweep(base, {f"{CONTACT}.elastic": ["power"], f"{CONTACT}.exponent": [1, 1.5, 2]}), free)
    assert [cases.written_case(k)["joints"]["rod-slider"]["contact"]["exponent"] for k in range(3)] == [1.0, 1.5, 2.0]
    axes = {f"{CONTACT}.stiffness": [1e9, 1e10], f"{CONTACT}.exponent": [1, 1.5]}
    assert load(sweep(base, axes), free).unit(f"{CONTACT}.stiffness") == "N/m^exponent"
    assert load(sweep(base, {f"{CONTACT}.stiffness": [1e9, 1e10]})).unit(f"{CONTACT}.stiffness") == "N/m^1.5"


def test_ten_million_cases_take_no_more_memory_than_the_values_on_their_axes(base):
    axes = {
        f"{JOINT}.clearance": {"linspace": ["10 um", "0.5 mm", 100_000]},
        "drive.speed": {"linspace": [100, 500, 100]},
    }
    tracemalloc.start()
    try:
        cases = load(sweep(base, axes))
        last = cases.case(10**7 - 1)
        assert tracemalloc.get_traced_memory()[1] < 40e6  # bytes at the most; 8 a case would be 80e6
    finally:
        tracemalloc.stop()
    assert len(cases) == 10**7
    assert (last.joints[0].clearance, last.drive.speed) == (5e-4, 500.0)


# ------------------------------------------------------------------------------------------ which directory fits


def test_the_frame_contains_what_is_not_swept(at):
    text = TEXT + f"sweep:\n  drive.speed: [1000 rpm]\n  {JOINT}.clearance: [0.1 mm]\n"
    frame = at(text).fixed_settings()
    assert frame["swept"] == ["drive.speed", f"{JOINT}.clearance"]
    assert (frame["model_version"], frame["schema"]) == (clearsweep.MODEL_VERSION, grid.SCHEMA_VERSION)
    assert frame["save.samples"] == 720
    assert frame["mechanism.rod.center"] == 0.06
    assert "drive.speed" not in frame
    assert not {"name", "simulate.time_budget"} & set(frame)
    assert (
        at(
            text.replace("[0.1 mm]", "[0.1 mm, 0.2 mm]").replace("clearance: 0.5 mm", "clearance: 0.4 mm")
        ).fixed_settings()
        == frame
    )
    assert at(text.replace(", center: 60 mm", "").replace("name: demo", "name: x")).fixed_settings() == frame
    differing = at(
        text.replace("samples: 720", "samples: 90").replace("mass: 0.14 kg", "mass: 0.15 kg")
    ).fixed_settings()
    assert {key for key in frame if frame[key] != differing[key]} == {"save.samples", "mechanism.slider.mass"}


# ----------------------------------------------------------------------------------------------------- overrides


def test_an_override_replaces_a_value_or_an_axis_or_takes_a_key_away(at):
    assert (
        at(TEXT, {"drive.speed": "3000 rpm"}).written_case(0)["drive"]["speed"]
        == at(TEXT.replace("5000", "3000")).written_case(0)["drive"]["speed"]
    )
    text = TEXT + f"sweep:\n  drive.speed: [1000 rpm]\n  {JOINT}.clearance: [0.1 mm, 0.2 mm]\n"
    assert list(at(text, {"drive.speed": 300.0}).axes) == [f"{JOINT}.clearance"]
    assert at(text, {"drive.speed": 300.0, f"{JOINT}.clearance": "0.1 mm"}).axes == {}


# ------------------------------------------------------------------------------------------- what is shipped


def test_the_starter_is_a_grid_that_loads_and_explains_itself(at):
    text = grid.starter()
    assert len(at(text)) == 3 * 2 * 2 * 2
    assert text.count("#") > 20


def test_the_schema_names_every_key_with_unit_and_range():
    schema = whole_schema(CATALOGUE)
    json.dumps(schema, allow_nan=False)
    joint = schema["properties"]["joints"]["properties"]["rod-slider"]["properties"]
    assert "(m)" in json.dumps(joint["clearance"])
    assert joint["contact"]["properties"]["law"]["enum"] == list(CATALOGUE.names("law"))
    assert "N*s/m" in json.dumps(joint["contact"]["properties"]["damping"])
    assert set(schema["properties"]) >= {
        *("define", "mechanism", "joints", "simulate", "save", "name", "extends"),
        *("sweep", "zip", "cases", "sample", "figures", "limits", "roles", "uncertain", "seek", "refine"),
        *("optimise", "identify", "check_laws"),
    }


def expanded(part, definitions):
    """Return a schema with its references replaced by what they refer to."""
    if isinstance(part, list):
        return [expanded(item, definitions) for item in part]
    if not isinstance(part, dict):
        return part
    reference = part.get("$ref", "").removeprefix("#/$defs/")
    if reference.startswith("part-"):
        return expanded(definitions[reference], definitions)
    return {key: expanded(value, definitions) for key, value in part.items()}


def test_the_schema_for_editors_is_small_and_says_the_same():
    known = simulation.catalogue()
    small, whole = grid.schema(known), whole_schema(known)
    assert len(json.dumps(small, indent=0)) < 150_000
    assert small["$id"].startswith("https://")
    assert not {"if", "then", "else"} & small.keys()
    unshared = {key: expanded(value, small["$defs"]) for key, value in small.items() if key != "$defs"}
    assert unshared == {key: value for key, value in whole.items() if key != "$defs"}
    types = whole["properties"]["mechanism"]["properties"]["type"]["enum"]
    assert types == [mechanism.name for mechanism in known.mechanisms]


def accepts(schema, part, value):
    """Return whether a JSON Schema of this form accepts a value: an independent reading of its keywords."""
    if "$ref" in part and not accepts(schema, schema["$defs"][part["$ref"].removeprefix("#/$defs/")], value):
        return False
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    types = part.get("type", [])
    allowed = tuple(kinds[name] for name in ([types] if isinstance(types, str) else types))
    if allowed and (not isinstance(value, allowed) or (isinstance(value, bool) and bool not in allowed)):
        return False
    if "enum" in part and value not in part["enum"]:
        return False
    choices = [part[name] for name in ("anyOf", "oneOf") if name in part]
    if not all(any(accepts(schema, choice, value) for choice in choice_list) for choice_list in choices):
        return False
    if isinstance(value, str):
        return "pattern" not in part or re.search(part["pattern"], value) is not None
    if isinstance(value, list):
        firsts = part.get("prefixItems", [])
        items = [*firsts, *[part.get("items", {})] * (len(value) - len(firsts))]
        is_long = part.get("minItems", 0) <= len(value) <= part.get("maxItems", math.inf)
        return is_long and all(map(accepts, [schema] * len(value), items, value))
    if not isinstance(value, dict):
        return True
    others, known = part.get("additionalProperties", {}), part.get("properties", {})
    named = [(known.get(key, others), item) for key, item in value.items()]
    return value.keys() >= {*part.get("required", [])} and all(
        content is not False and accepts(schema, content if isinstance(content, dict) else {}, item)
        for content, item in named
    )


WRONG = {
    "a key": {f"{JOINT}.clearence": "0.1 mm"},
    "a law": {f"{JOINT}.contact.law": "flors"},
    "a mechanism": {"mechanism.type": "slidercrank"},
    "a section": {"simulat.revolutions": 3},
    "a list for a quantity": {f"{JOINT}.clearance": ["0.1 mm", "0.2 mm"]},
    "a truth value": {f"{JOINT}.clearance": True},
    "a friction law": {f"{JOINT}.friction.law": "coulumb"},
    "what is saved": {"save.orbits": "lasts"},
    "axes in a list": {"sweep": [1, 2]},
    "a number in words": {"simulate.revolutions": "many"},
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_the_schema_refuses(wrong):
    schema, content = grid.schema(simulation.catalogue()), YAML(typ="safe").load(TEXT)
    assert accepts(schema, schema, content)
    for path, value in wrong.items():
        *sections, key = path.split(".")
        functools.reduce(lambda section, name: section.setdefault(name, {}), sections, content)[key] = value
    assert not accepts(schema, schema, content)


def test_the_schema_accepts_every_shipped_grid():
    schema = grid.schema(simulation.catalogue())
    starters = Path(grid.__file__).parent / "starters"
    files = [*CONFIGS.glob("*.yaml"), *starters.glob("*.yaml")]
    assert len(files) > 30
    refused = [file.name for file in files if not accepts(schema, schema, YAML(typ="safe").load(file.read_text()))]
    assert not refused


def test_a_grid_extends_another_of_its_folder(at, tmp_path):
    (tmp_path / "base.yaml").write_text(TEXT, encoding="utf-8")
    alone = at(TEXT.replace("mass: 0.14 kg", "mass: 0.2 kg").replace("name: demo\n", ""))
    cases = at("extends: base.yaml\nmechanism: {slider: {mass: 0.2 kg}}\n")
    assert ids(cases) == ids(alone)
    assert cases.name == "grid"
    swept = at("extends: base.yaml\nsweep: {drive.speed: [100 rpm, 200 rpm]}\n")
    assert len(swept) == 2


def test_null_leaves_out_a_key_of_an_extended_grid(at, tmp_path):
    (tmp_path / "base.yaml").write_text(TEXT, encoding="utf-8")
    torque = "torque: 1 N*m, initial_speed: 100 rpm"
    assert at(f"extends: base.yaml\ndrive: {{speed: null, {torque}}}\n").case(0).drive.torque == 1.0


def test_a_link_cannot_be_extended(at, tmp_path):
    (tmp_path / "base.yaml").write_text(TEXT, encoding="utf-8")
    (tmp_path / "link.yaml").symlink_to(tmp_path / "base.yaml")
    with pytest.raises(InputError, match=r"link.yaml is a link or this file itself"):
        at(f"{TEXT}extends: link.yaml\n")


def test_loading_a_grid_imports_neither_the_compiler_nor_pandas_nor_h5py():
    heavy = "{'llvmlite', 'pandas', 'h5py', 'numpy', 'pint'}"
    code = f"import sys, clearsweep.grid; sys.exit(bool({heavy} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
