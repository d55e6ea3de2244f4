"""Values from the command line are put in the grid as if its file had them, and their mistakes name the option."""

import pytest
from fake_runs import TEXT, load

from clearsweep.grid import SET_OPTION, SWEEP_OPTION, OverriddenGrid, read_options
from clearsweep.language.errors import InputError

JOINT = "joints.rod-slider"
SWEPT = TEXT + "sweep:\n  drive.speed: [1000 rpm, 2000 rpm]\n"


@pytest.fixture
def changed(tmp_path):
    """Return a function that loads a text with the values of options."""
    path = tmp_path / "grid.yaml"

    def loaded(text, fixed=(), swept=()):
        path.write_text(text, encoding="utf-8")
        return load(OverriddenGrid(path, read_options(SET_OPTION, fixed), read_options(SWEEP_OPTION, swept)))

    return loaded


def same(first, second):
    """Return whether two grids have the same cases and would leave the same run.json."""
    alike = (first.resolved(), first.fixed_settings(), list(first.identities())) == (
        second.resolved(),
        second.fixed_settings(),
        list(second.identities()),
    )
    return alike and list(first.axes) == list(second.axes)


def test_a_grid_with_options_is_the_grid_with_these_values_written_in(changed):
    written = TEXT.replace("5000 rpm", "3000 rpm").replace("clearance: 0.5 mm", "clearance: 0.1 mm")
    assert same(changed(TEXT, ["drive.speed=3000rpm", f"{JOINT}.clearance = 0.1 mm"]), changed(written))
    assert same(changed(SWEPT, ["drive.speed=3000 rpm"]), changed(TEXT.replace("5000 rpm", "3000 rpm")))
    assert same(changed(TEXT, [], ["drive.speed=1000rpm,2000 rpm"]), changed(SWEPT))
    assert same(changed(SWEPT, [], ["drive.speed=7 rpm"]), changed(SWEPT.replace("1000 rpm, 2000", "7")))
    spaced = "{linspace: [1000 rpm, 2000 rpm, 2]}"
    assert same(changed(TEXT, [], [f"drive.speed={spaced}"]), changed(SWEPT))
    laws = f"{JOINT}.contact.law"
    assert changed(TEXT, [], [f"{laws}=flores,exact"]).axes == {laws: ("flores", "exact")}


def test_sections_are_set_whole_and_nothing_takes_a_key_away(changed):
    hertz = "{law: hertz, stiffness: 1e9}"
    case = changed(TEXT, [f"{JOINT}.contact={hertz}", f"{JOINT}.friction=", f"{JOINT}.wear=", "name=other"])
    assert case.name == "other"
    joint = case.written_case(0)["joints"]["rod-slider"]
    assert joint["contact"]["law"] == "hertz"
    assert "friction" not in joint


@pytest.mark.parametrize(
    ("fixed", "swept", "message"),
    [
        (["drive.speed=3 mm"], [], "--set drive.speed: found '3 mm', whose unit mm has another dimension"),
        (["drive.sped=3 rpm"], [], "--set drive.sped: unknown key 'sped'; did you mean 'speed'?"),
        (["drive.speed.x=3"], [], "--set drive.speed.x: continues below '5000 rpm'"),
        ([], ["drive.speed=200rpm,500"], "--sweep drive.speed: found 500 without a unit next to"),
        ([], ["drive.speed=1 rpm,1 rpm"], "--sweep drive.speed: duplicate value '1 rpm'"),
        ([], ["drive.sped=1,2"], "--sweep drive.sped: is no key of this grid; did you mean 'drive.speed'?"),
        (["drive.speed=1 rpm"], ["drive.speed=2 rpm"], "--set: drive.speed: is given with --sweep, too"),
        (["drive.speed"], [], "--set drive.speed: expected PATH=VALUE, such as --set drive.speed=3000rpm"),
        ([], ["drive.speed="], "--sweep drive.speed=: expected PATH=VALUE"),
        (["drive.speed=1", "drive.speed=2"], [], "--set drive.speed: is given twice"),
        (
            [f"{JOINT}.contact={{law: hertz"],
            [],
            f"--set {JOINT}.contact: found '{{law: hertz', which is not valid YAML",
        ),
    ],
)
def test_a_mistake_names_the_option_and_the_path(changed, fixed, swept, message):
    with pytest.raises(InputError) as caught:
        changed(TEXT, fixed, swept)
    assert any(problem.startswith(message) for problem in caught.value.problems), caught.value.problems
