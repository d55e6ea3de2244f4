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


def test_mistakes_of_a_dict_are_reported_without_a_place(base):
    base["drive"]["speed"] = "5 kg"
    base["joints"]["rod-slider"]["contact"]["law"] = 7
    with pytest.raises(InputError) as caught:
        load(base)
    assert [problem.split(": ")[0] for problem in caught.value.problems] == ["drive.speed", f"{CONTACT}.law"]


def test_the_nearest_name_has_the_same_words_in_another_order():
    names = ["rod_slider_pv_peak", "rod_slider_load_peak"]
    assert did_you_mean("rod_slider_peak_load", names) == "; did you mean 'rod_slider_load_peak'?"
    assert did_you_mean("rod_slider_pv_peek", names) == "; did you mean 'rod_slider_pv_peak'?"


@pytest.mark.parametrize(("text", "message"), [("a: \x00\n", "grid.yaml: not valid YAML"), ("[" * 5000, "grid.yaml")])
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


def test_an_oil_may_be_below_freezing():
    assert load(CONFIGS / "pump.yaml", {"joints.rod-slider.film.temperature": "-5 degC", "sweep": None})


def test_no_temperature_of_a_sample_ends_in_an_overflow():
    assert Oil(4.6e-5, 6.8e-6, 870.0).viscosity(5.0) < 1e300
