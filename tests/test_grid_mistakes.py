"""Claims about what a mistake in a grid is answered: its place, its key, what was found and what is allowed."""

import json
import os
import pickle
import time

import pytest
from fake_runs import CONFIGS, CONTACT, JOINT, TEXT, load
from hypothesis import given
from hypothesis import strategies as st

from clearsweep.contracts.case import Oil
from clearsweep.grid.resolve import case_of
from clearsweep.grid.written import OverriddenGrid, Problems, WrittenValue, apply_overrides, read_document
from clearsweep.language.errors import InputError, did_you_mean, quoted

ROOT = WrittenValue({})


@pytest.fixture
def base(at):
    """The demo grid as a dict in SI."""
    return at(TEXT).resolved()


def test_a_wrong_override_is_reported_as_one(problems_in):
    (problem,) = problems_in(TEXT, {f"{JOINT}.clearance": "0.5 kg"})
    assert problem.startswith(f"overrides: {JOINT}.clearance: found '0.5 kg'")
    (problem,) = problems_in(TEXT, {f"{JOINT}.clearanc": "0.5 mm"})
    assert problem.startswith(f"overrides: {JOINT}.clearanc: unknown key 'clearanc'; did you mean 'clearance'?")
    (problem,) = problems_in(TEXT, {"drive.speed.fast": 1})
    assert problem == (
        "overrides: drive.speed.fast: continues below '5000 rpm', which is a value and not a section; correct the path"
    )


# ---------------------------------------------------------------------------------------------------- mistakes

#: what is replaced, by what, and what the message begins with and contains
MISTAKES = {
    "a tag on another text": (
        "{revolutions: 10,",
        "{revolutions: !!int 0xzz,",
        "19:25: simulate.revolutions: found '0xzz'",
    ),
    "unknown law": (
        "law: lankarani-nikravesh",
        "law: herz",
        f"14:12: {CONTACT}.law: unknown law 'herz'; did you mean 'hertz'? (known: hertz, lankarani-nikravesh",
    ),
    "dimension": (
        "clearance: 0.5 mm",
        "clearance: 0.5 kg",
        f"10:16: {JOINT}.clearance: found '0.5 kg', whose unit kg has another dimension; expected a quantity in m",
    ),
    "negative": (
        "clearance: 0.5 mm",
        "clearance: -0.5 mm",
        f"10:16: {JOINT}.clearance: found -0.5 mm, out of range; allowed: above 0 (m)",
    ),
    "no clearance": ("clearance: 0.5 mm", "clearance: 0", f"10:16: {JOINT}.clearance: found 0, out of range"),
    "null": ("clearance: 0.5 mm", "clearance:", f"10:5: {JOINT}.clearance: found nothing; expected a quantity in m"),
    "truth": ("clearance: 0.5 mm", "clearance: true", f"10:16: {JOINT}.clearance: found true; expected"),
    "no is a word": (
        "clearance: 0.5 mm",
        "clearance: no",
        f"10:16: {JOINT}.clearance: found 'no', which does not begin",
    ),
    "list": ("clearance: 0.5 mm", "clearance: [1 mm]", f"10:16: {JOINT}.clearance: found a list; expected"),
    "unknown key": (
        "clearance: 0.5 mm",
        "clearanse: 0.5 mm",
        f"10:5: {JOINT}.clearanse: unknown key 'clearanse'; did you mean 'clearance'?",
    ),
    "missing key": (
        "    bearing_radius: 10 mm\n",
        "",
        f"10:5: {JOINT}.bearing_radius: is missing (radius of the bearing",
    ),
    "missing section": (
        "  slider: {mass: 0.14 kg}\n",
        "",
        "3:3: mechanism.slider: is missing; write the section 'slider'",
    ),
    "missing law": (
        "law: lankarani-nikravesh\n",
        "elastic: power\n",
        f"14:7: {CONTACT}.law: is missing; write one of hertz,",
    ),
    "duplicate key": (
        "    length: 20 mm\n",
        "    length: 20 mm\n    clearance: 1 mm\n",
        f"13:5: {JOINT}.clearance: duplicate key; it is also on line 10",
    ),
    "not a section": (
        "slider: {mass: 0.14 kg}",
        "slider: 0.14 kg",
        "6:11: mechanism.slider: found '0.14 kg'; expected a section with the keys mass",
    ),
    "unknown joint": (
        "rod-slider:",
        "rod-slidr:",
        "9:3: joints.rod-slidr: unknown key 'rod-slidr'; did you mean 'rod-slider'? (allowed: ground-crank, crank-rod",
    ),
    "unknown mechanism": (
        "type: slider-crank",
        "type: slidercrank",
        "3:9: mechanism.type: unknown word 'slidercrank'; did you mean 'slider-crank'? (known: slider-crank,",
    ),
    "restitution 0": (
        "restitution: 0.9",
        "restitution: 0",
        f"16:20: {CONTACT}.restitution: found 0, out of range; allowed: above 0 and at most 1",
    ),
    "restitution above 1": (
        "restitution: 0.9",
        "restitution: 95",
        f"16:20: {CONTACT}.restitution: found 95, out of range",
    ),
    "no restitution": (
        "      restitution: 0.9\n",
        "",
        f"14:7: {CONTACT}.restitution: is missing for lankarani-nikravesh",
    ),
    "unused key": (
        "law: lankarani-nikravesh",
        "law: hertz",
        f"16:20: {CONTACT}.restitution: is not used by law 'hertz', only by exact, flores",
    ),
    "key of another law": (
        "restitution: 0.9",
        "restitution: 0.9\n      damping: 1",
        f"17:16: {CONTACT}.damping: is not used by law 'lankarani-nikravesh', only by hunt-crossley, kelvin-voigt",
    ),
    "wrong exponent": (
        "6.61e10 N/m^1.5",
        "6.61e10 N/m",
        f"15:18: {CONTACT}.stiffness: found '6.61e10 N/m', whose unit N/m has another dimension; expected",
    ),
    "no stiffness": ("      stiffness: 6.61e10 N/m^1.5\n", "", f"14:7: {CONTACT}.stiffness: is missing for power"),
    "too wide": (
        "clearance: 0.5 mm",
        "clearance: 10 mm",
        f"10:16: {JOINT}.clearance: found 10 mm; allowed: below 10 mm",
    ),
    "discard": (
        "discard: 2",
        "discard: 10",
        "19:38: simulate.discard: found 10; allowed: below",
    ),
    "too much saved": (
        "samples: 720",
        "revolutions: 11",
        "20:35: save.revolutions: found 11; allowed: at most",
    ),
    "tolerance": (
        "tolerance: 1e-8",
        "tolerance: 1e-14",
        "19:52: simulate.tolerance: found 1e-14, out of range; allowed: at least 1e-13",
    ),
    "start": (
        "tolerance: 1e-8",
        "start: centered",
        "19:48: simulate.start: unknown word 'centered'; did you mean 'centred'?",
    ),
    "fractional samples": (
        "samples: 720",
        "samples: 0.5",
        "20:31: save.samples: found 0.5, out of range; allowed: a whole number at least 1",
    ),
    "journal": (
        "    length: 20 mm",
        "    length: 20 mm\n    journal: crank",
        f"13:14: {JOINT}.journal: unknown word 'crank' (known: rod, slider)",
    ),
    "short rod": (
        "rod:    {length: 120 mm",
        "rod:    {length: 40 mm",
        "4:20: mechanism.crank.length: found 50 mm; allowed: below 40 mm",
    ),
    "friction speeds": (
        "v0: 1 mm/s",
        "v0: 10 mm/s",
        f"17:54: {JOINT}.friction.v0: found 10 mm/s; allowed: below 10 mm/s",
    ),
    "wear without length": (
        "    length: 20 mm\n",
        "",
        f"17:11: {JOINT}.length: is missing; wear needs the joint's length",
    ),
    "wear without coefficient": (
        ", coefficient: 2e-14 m^2/N",
        "",
        f"18:11: {JOINT}.wear.coefficient: is missing; for example: 2e-14 m^2/N",
    ),
    "impossible wear": (
        "coefficient: 2e-14 m^2/N",
        "coefficient: 2e-8 m^2/N, hardness: 2 GPa",
        f"18:39: {JOINT}.wear.coefficient: found 2e-8 m^2/N; its product with the hardness 2 GPa is 40; allowed",
    ),
    "wear without modulus": (
        "coefficient: 2e-14 m^2/N}",
        "coefficient: 2e-14 m^2/N, pressure: hertz-line}",
        f"18:62: {CONTACT}.material: is missing; wear pressure 'hertz-line' needs material",
    ),
    "endless": (
        "revolutions: 10,",
        "revolutions: 1e300,",
        "19:25: simulate.revolutions: found 1e300, out of range; allowed: above 0 and at most 1000000000",
    ),
    "material and exponent": (
        "stiffness: 6.61e10 N/m^1.5",
        "exponent: 1.4\n      material: {young: 207 GPa, poisson: 0.3}",
        f"14:7: {CONTACT}.stiffness: is missing; `material` determines the stiffness only for the exponent 1.5",
    ),
    "unknown unit": (
        "speed: 5000 rpm",
        "speed: 5000 RPM",
        "7:16: drive.speed: found '5000 RPM'; unknown unit 'RPM'; did you mean 'rpm'?",
    ),
    "decimal comma": (
        "speed: 5000 rpm",
        "speed: 5,5 rpm",
        "7:18: drive.5 rpm: unknown key '5 rpm'; write numbers with a decimal point, not a comma",
    ),
    "torque curve": (
        "speed: 5000 rpm",
        "motor: {table: motor.csv}",
        "7:24: drive.motor.table: there is no file motor.csv; the name is relative to the grid's directory",
    ),
    "not a shaft speed": (
        "speed: 5000 rpm",
        "speed: 5000 1/s",
        "7:16: drive.speed: found '5000 1/s', whose unit 1/s has another dimension",
    ),
    "infinite": ("speed: 5000 rpm", "speed: .inf", "7:16: drive.speed: found '.inf', which is not a finite number"),
    "no speed": (
        "drive: {speed: 5000 rpm}\n",
        "",
        "1:1: drive.speed: is missing (constant crank speed, negative for a clockwise crank; other drives have angle, "
        "torque, motor or servo instead); expected",
    ),
    "name": ("name: demo", "name: ../demo", "1:7: name: found '../demo'; expected letters"),
    "tag": ("speed: 5000 rpm", "speed: !f 5000 rpm", "7:16: drive.speed: the YAML tag !f is not supported"),
    "tag on a section": (
        "drive: {speed: 5000 rpm}",
        "drive: !f {speed: 5000 rpm}",
        "7:8: drive: the YAML tag !f is not supported",
    ),
    "tag of a set": (
        "drive: {speed: 5000 rpm}",
        "drive: !!set {speed: 5000 rpm}",
        "7:8: drive: the YAML tag tag:yaml.org,2002:set is not supported",
    ),
    "alias in itself": (
        "drive: {speed: 5000 rpm}",
        "drive: &a {speed: *a}",
        "7:8: drive.speed: an alias contains itself",
    ),
}


@pytest.mark.parametrize(("old", "new", "message"), MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_is_reported_with_file_line_column_key_and_remedy(problems_in, old, new, message):
    assert TEXT.count(old) == 1
    problems = problems_in(TEXT.replace(old, new))
    assert any(problem.startswith(f"grid.yaml:{message}") for problem in problems), problems
    allowed = (
        2
        if new.startswith(("clearanse", "rod-slidr", "elastic", "exponent", "drive: &a"))
        or old.endswith("6.61e10 N/m^1.5\n")
        else 1
    )
    assert len(problems) <= allowed, problems


def test_all_mistakes_are_reported_at_once_in_the_order_of_the_file(problems_in):
    text = TEXT.replace("0.5 mm", "0.5 kg").replace("lankarani-nikravesh", "herz").replace("speed:", "sped:")
    text = text.replace("1e-8", "1").replace("name: demo", "name: ''") + "sweep:\n  nothing.here: [1]\n"
    problems = problems_in(text)
    assert [problem.split(":")[1] for problem in problems] == ["1", "7", "10", "14", "19", "22"]


def test_mistakes_of_a_dict_are_reported_without_a_place(base):
    base["drive"]["speed"] = "5 kg"
    base["joints"]["rod-slider"]["contact"]["law"] = 7
    with pytest.raises(InputError) as caught:
        load(base)
    assert [problem.split(": ")[0] for problem in caught.value.problems] == ["drive.speed", f"{CONTACT}.law"]


def test_keys_of_the_other_mechanism_are_unknown(problems_in):
    problems = problems_in(
        "mechanism: {type: impact-pair, masses: [1 kg], speed: 1 m/s, gravity: 1}\n"
        "drive: {speed: 1}\njoints: {pair: 3}\nsimulate: {revolutions: 1}\n"
    )
    assert "mechanism.masses: found a list; expected a list of two quantities" in problems[0]
    assert "mechanism.gravity: unknown key 'gravity' (allowed: type, masses, speed)" in problems[1]
    assert "drive: unknown key 'drive'" in problems[2]
    assert "joints.pair: found '3'; expected a section with the keys clearance, contact" in problems[3]
    assert "simulate.revolutions: unknown key 'revolutions' (allowed: impacts, " in problems[4]


@pytest.mark.parametrize("contact", ["", "    contact: [1, 2]\n"])
def test_a_key_that_a_law_decides_is_not_the_mistake_where_its_section_is(problems_in, contact):
    (problem,) = problems_in(
        "mechanism: {type: impact-pair, masses: [1 kg, 1 kg], speed: 1 m/s}\njoints:\n"
        f"  pair:\n    clearance: 1 mm\n    bearing_radius: 10 mm\n{contact}simulate: {{impacts: 1}}\n"
    )
    assert "joints.pair.contact: " in problem
    assert "section" in problem


def test_the_nearest_name_has_the_same_words_in_another_order():
    names = ["rod_slider_pv_peak", "rod_slider_load_peak"]
    assert did_you_mean("rod_slider_peak_load", names) == "; did you mean 'rod_slider_load_peak'?"
    assert did_you_mean("rod_slider_pv_peek", names) == "; did you mean 'rod_slider_pv_peak'?"


UNREADABLE = {
    "empty": ("", "grid.yaml:1:1: the file is empty"),
    "comment": ("# nothing\n", "grid.yaml:1:1: the file is empty"),
    "list": ("- 1\n", "grid.yaml:1:1: found a list; expected a grid"),
    "text": ("hello\n", "grid.yaml:1:1: found 'hello'; expected a grid"),
    "syntax": ("a: [1, 2\nb: 3\n", "grid.yaml:2:"),
    "tab": ("a:\n\tb: 1\n", "grid.yaml:2:1: not valid YAML: a tab in the indentation; indent with spaces"),
    "one space less": ("a:\n  b: 1\n c: 2\n", "grid.yaml:3:2: not valid YAML: this line is indented differently"),
    "unit in a key": ("a: {time [s]: [0, 1]}\n", "grid.yaml:1:10: not valid YAML: a bracket within a key; inside"),
    "two documents": ("a: 1\n---\nb: 2\n", "grid.yaml:2:1: not valid YAML"),
    "unknown alias": ("a: *b\n", "grid.yaml:1:4: not valid YAML"),
    "control": ("a: \x00\n", "grid.yaml: not valid YAML"),
    "deep": ("[" * 5000, "grid.yaml"),
}


@pytest.mark.parametrize(("text", "message"), UNREADABLE.values(), ids=UNREADABLE)
def test_what_is_no_grid_at_all_is_reported_with_its_location(problems_in, text, message):
    (problem,) = problems_in(text)
    assert problem.startswith(message)
    assert "\n" not in problem


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    (tmp_path / "latin.yaml").write_bytes("name: Wälzlager".encode("latin-1"))
    for path, reason in (
        (tmp_path / "none.yaml", "No such file"),
        (tmp_path, "directory"),
        (tmp_path / "latin.yaml", "UTF-8"),
    ):
        with pytest.raises(InputError, match=reason) as caught:
            load(path)
        assert str(caught.value).startswith(str(path))


def test_what_never_ends_is_not_read(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe.yaml")
    with open(tmp_path / "large.yaml", "wb") as file:
        file.truncate(65 * 2**20)
    began = time.process_time()
    for path, reason in (
        ("/dev/zero", "not a regular file"),
        (tmp_path / "pipe.yaml", "not a regular file"),
        (tmp_path / "large.yaml", "68,157,440 bytes, more than the 67,108,864 that are read"),
    ):
        with pytest.raises(InputError, match=f"cannot be read: it .*{reason}"):
            load(path)
    assert time.process_time() - began < 2.0


def test_a_table_that_never_ends_is_not_read(at, tmp_path):
    (tmp_path / "cases.csv").symlink_to("/dev/zero")
    with pytest.raises(InputError, match=r"cases.csv cannot be read: it is not a regular file"):
        at(f"{TEXT}cases: cases.csv\n")


@pytest.mark.parametrize("axes", [2, 3, 7])
def test_more_cases_than_can_be_run_are_refused_at_once(base, axes):
    paths = ["drive.speed", "mechanism.gravity", "mechanism.crank.mass", "mechanism.rod.mass", "mechanism.slider.mass"]
    paths += ["mechanism.rod.inertia", "mechanism.crank.inertia"]
    count = 20_000 if axes == 2 else 1000
    sweep = {path: {"linspace": [1.0, 2.0, count]} for path in paths[:axes]}
    began = time.process_time()
    with pytest.raises(InputError, match=f"has {count**axes:,} cases; at most 200,000,000 can be run"):
        load(base | {"sweep": sweep})
    assert time.process_time() - began < 10.0


def test_an_alias_costs_no_more_than_what_it_represents(problems_in):
    bomb = "\n".join(f"a{k + 1}: &a{k + 1} [{', '.join([f'*a{k}'] * 9)}]" for k in range(9))
    began = time.process_time()
    problems_in(f"a0: &a0 [1]\n{bomb}\n")
    assert time.process_time() - began < 2.0


def test_yaml_is_read_as_version_1_2(at):
    case = at(
        TEXT.replace("restitution: 0.9", "restitution: 1e-1").replace("revolutions: 10,", "revolutions: 012,")
    ).written_case(0)
    assert case["joints"]["rod-slider"]["contact"]["restitution"] == 0.1
    assert case["simulate"]["revolutions"] == 12.0


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(
                    [
                        "mechanism",
                        "type",
                        "joints",
                        "rod-slider",
                        "contact",
                        "law",
                        "sweep",
                        "drive.speed",
                        "linspace",
                        "x",
                    ]
                ),
                inner,
                max_size=4,
            )
        ),
    )
)
def test_any_nonsense_gives_an_input_error(nonsense):
    with pytest.raises(InputError):
        load({"mechanism": {"type": "slider-crank"}, "sweep": nonsense, "joints": nonsense})
    with pytest.raises(InputError):
        load(nonsense if isinstance(nonsense, dict) else {"mechanism": nonsense})


@pytest.mark.parametrize("ending", ["", "joints: {}\n"])
def test_a_slider_crank_without_any_clearance_is_refused(problems_in, ending):
    head = TEXT[: TEXT.index("joints:")]
    problems = problems_in(head + ending)
    assert len(problems) == 1
    assert "joints: no joint has clearance; name at least one of ground-crank, crank-rod, rod-slider" in problems[0]


@pytest.mark.parametrize(
    ("joints", "sentences"),
    [
        ("", ("driven: is missing; first add what it names", "no joint has clearance; add one that can to mechanism")),
        (
            "\n  joints: {pivot: {type: hinge, between: [ground.o, arm.p]}}",
            ("type: unknown word 'hinge'; did you mean 'revolute'?", "driven: is missing; write one of pivot"),
        ),
    ],
)
def test_a_planar_machine_with_few_parts_is_told_what_to_add(problems_in, joints, sentences):
    bodies = "{ground: {points: {o: [0 m, 0 m]}}, arm: {mass: 1 kg, inertia: 1 kg*m^2, points: {p: [0 m, 1 m]}}}"
    problems = problems_in(f"mechanism:\n  type: planar\n  bodies: {bodies}{joints}\njoints: {{}}\n")
    assert all(any(sentence in problem for problem in problems) for sentence in sentences)


def test_a_swept_value_in_a_section_whose_name_is_wrong_is_a_mistake_like_others(problems_in):
    problems = problems_in(TEXT.replace("contact:", "contactx:") + f"sweep: {{{CONTACT}.restitution: [0.5, 0.9]}}\n")
    assert len(problems) == 1
    assert "unknown key 'contactx'; did you mean 'contact'?" in problems[0]


def test_a_misspelt_joint_is_reported_once_and_the_rest_is_read(problems_in):
    more = "sweep: {joints.rod-slider.clearance: [0.2 mm, 0.4 mm]}\nlimits: {rod_slider_force_peak: 5 kN}\n"
    (problem,) = problems_in(TEXT.replace("rod-slider:", "rod-slidr:") + more)
    assert "joints.rod-slidr: unknown key 'rod-slidr'; did you mean 'rod-slider'?" in problem


#: the lines under `sweep:`, and what the message begins with
AXES = {
    "empty": ("", "21:1: sweep: nothing is swept; write `dotted.path: [value, ...]`"),
    "no values": (f"{JOINT}.clearance: []", f"22:32: sweep.{JOINT}.clearance: the list is empty"),
    "one value": (
        "drive.speed: 5000 rpm",
        "22:16: sweep.drive.speed: found '5000 rpm'; expected a list such as [a, b], {label: a",
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
        f"22:3: sweep.{JOINT}.clearanse: is no key of this grid; did you mean '{JOINT}.clearance'? (allowed next to "
        "it: ",
    ),
    "section": ("drive: [1]", "22:3: sweep.drive: is a section, not a value; write a key in it, such as drive.speed"),
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
        "22:34: sweep.mechanism.gravity: geomspace: first and last must be both",
    ),
    "huge exponent": (
        "drive.speed: {logspace: [0, 400, 3]}",
        "22:27: sweep.drive.speed: logspace: the exponents 0 and 400 exceed the range",
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
        f"18:39: {JOINT}.wear.coefficient: found 2e-14 m^2/N; its product with the hardness",
    ),
}


@pytest.mark.parametrize(("lines", "message"), AXES.values(), ids=AXES)
def test_a_mistake_in_a_sweep_is_reported_with_its_place(problems_in, lines, message):
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


def nested(depth):
    value = 1
    for _ in range(depth):
        value = [value]
    return value


LOOP: dict = {}
LOOP["a"] = LOOP
DEEP = "[" * 99 + "]" * 99
TOO_DEEP = {
    "a list of lists": lambda: read_document({"a": nested(100)}, Problems()),
    "a dict in itself": lambda: read_document(LOOP, Problems()),
    "a long option": lambda: apply_overrides(ROOT, OverriddenGrid({}, {"a": "[" * 700}), Problems()),
    "an option": lambda: apply_overrides(ROOT, OverriddenGrid({}, {"a": DEEP}), Problems()),
    "values of an axis": lambda: apply_overrides(ROOT, OverriddenGrid({}, {}, {"a": DEEP}), Problems()),
    "a long path": lambda: apply_overrides(ROOT, OverriddenGrid({}, {"a." * 3000 + "a": "1"}), Problems()),
}


@pytest.mark.parametrize("name", TOO_DEEP)
def test_what_is_nested_too_deeply_is_refused_in_a_line(name):
    with pytest.raises(InputError, match="nested too deeply, or contains itself"):
        TOO_DEEP[name]()


def test_aliases_count_as_nesting(problems_in):
    aliases = "a0: &a0 [1]\n" + "".join(f"a{k}: &a{k} [*a{k - 1}]\n" for k in range(1, 1500))
    (problem,) = problems_in(aliases + TEXT)
    assert "nested too deeply" in problem


def test_a_huge_number_is_cited_without_its_digits():
    assert quoted(10**5000) == "a whole number of thousands of digits"


OIL = {"at_40C": "46 mm^2/s", "at_100C": "6.8 mm^2/s", "density": 870}
FILM = "joints.rod-slider.film"


@pytest.mark.parametrize(
    ("value", "meant"), [("60", True), ("20", True), ("1 K", True), ("-5 degC", None), ("5000", False)]
)
def test_a_temperature_of_an_oil_without_its_unit_is_asked_about(value, meant):
    if meant is None:
        load(CONFIGS / "pump.yaml", {f"{FILM}.temperature": value, "sweep": None})
        return
    with pytest.raises(InputError) as caught:
        load(CONFIGS / "pump.yaml", {f"{FILM}.temperature": value, "sweep": None})
    (problem,) = caught.value.problems
    number = value.removesuffix(" K")
    assert f"temperature: found {number} K (" in problem
    assert "allowed for an oil: 200 K to 700 K" in problem
    assert (f"did you mean {number} degC?" in problem) == meant


def test_so_is_that_of_the_surroundings_of_a_film():
    thermal = {"conductance": "20 W/K", "ambient": 40}
    film = {f"{FILM}.thermal": thermal, f"{FILM}.temperature": None, "sweep": None}
    with pytest.raises(InputError, match=r"thermal.ambient: found 40 K .*did you mean 40 degC"):
        load(CONFIGS / "pump.yaml", film)


def test_no_temperature_of_a_sample_ends_in_an_overflow():
    assert Oil(4.6e-5, 6.8e-6, 870.0).viscosity(5.0) < 1e300
