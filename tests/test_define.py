"""Claims about `define`: quantities of a grid's own, and expressions of them in place of numbers."""

from fractions import Fraction

import pytest
from fake_runs import JOINT, TEXT, load

from clearsweep.grid import SET_OPTION, SWEEP_OPTION, OverriddenGrid, read_options
from clearsweep.language.errors import InputError
from clearsweep.language.expression import _rounded

DEFINED = TEXT.replace("name: demo\n", "name: demo\ndefine: {play: 0.5 mm, d: 20 mm, r: = d / 2}\n").replace(
    "clearance: 0.5 mm", "clearance: = play"
)
WHOLE = DEFINED.replace("bearing_radius: 10 mm", "bearing_radius: = r")


def ids(grid):
    return [grid.case_id(index) for index in range(len(grid))]


def swept(text, values="[20 um, 50 um]"):
    return f"{text}sweep: {{define.play: {values}}}\n"


def test_a_defined_quantity_is_the_number_it_represents(at):
    assert ids(at(WHOLE)) == ids(at(TEXT))


def test_arithmetic_is_exact_until_the_last_rounding(at):
    text = TEXT.replace("clearance: 0.5 mm", "clearance: = 3 * '0.1 mm'")
    assert ids(at(text)) == ids(at(TEXT, {f"{JOINT}.clearance": "0.3 mm"}))


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("= min(play, d)", 5e-4),
        ("= max(play, '1 mm') / 4", 2.5e-4),
        ("= abs(-play)", 5e-4),
        ("= sqrt(play * play)", 5e-4),
        ("= (d - r) / 20", 5e-4),
        ("= play + '5 um'", 5.05e-4),
    ],
)
def test_every_form_of_an_expression_is_computed(at, written, value):
    text = WHOLE.replace("clearance: = play", f'clearance: "{written}"')
    if "play" not in written:
        text = text.replace("play: 0.5 mm, ", "")
    assert at(text).case(0).joints[0].clearance == value


def test_expressions_are_allowed_wherever_a_number_is(at):
    text = WHOLE.replace("play: 0.5 mm", "play: 0.5 mm, n: 4, top: 5 kN")
    text += f"sweep: {{{JOINT}.length: {{linspace: [= d, = 2 * d, = n]}}, drive.speed: [= '100 rpm' * n]}}\n"
    text += "limits: {rod_slider_force_peak: = top}\n"
    grid = at(text)
    assert len(grid) == 4
    assert grid.limits == {"rod_slider_force_peak": 5000.0}
    assert grid.axes[f"{JOINT}.length"][-1] == 0.04


def test_a_swept_name_is_computed_for_every_case(at):
    text = swept(WHOLE.replace("r: = d / 2", "r: = play * 20"))
    text = text.replace("length: 20 mm", "length: = d")
    grid = at(text)
    joints = [grid.case(index).joints[0] for index in range(2)]
    assert [(joint.clearance, joint.bearing_radius) for joint in joints] == [(20e-6, 4e-4), (50e-6, 1e-3)]
    written = [
        at(TEXT, {f"{JOINT}.clearance": play, f"{JOINT}.bearing_radius": radius})
        for play, radius in (("20 um", "0.4 mm"), ("50 um", "1 mm"))
    ]
    assert ids(grid) == [each.case_id(0) for each in written]
    assert [*grid.identities()] == [int(case_id, 16) for case_id in ids(grid)]
    assert grid.unit("define.play") == "m"


def test_a_number_may_follow_from_two_axes(at):
    text = swept(WHOLE.replace("r: = d / 2", "r: = 20 * play + d")).replace(
        "define.play:", "define.d: [2 mm, 3 mm], define.play:"
    )
    grid = at(text)
    result = {(point["define.d"], point["define.play"]) for point in map(grid.point, range(4))}
    assert len(result) == 4
    assert len(set(ids(grid))) == 4
    assert all(int(name, 16) == number for name, number in zip(ids(grid), grid.identities(), strict=True))


def test_a_resolved_grid_gives_the_same_cases(at):
    for text in (WHOLE, swept(WHOLE), swept(WHOLE.replace("r: = d / 2", "r: = play * 20 + d"))):
        grid = at(text)
        again = load(grid.resolved())
        assert ids(again) == ids(grid)
        assert again.fixed_settings() == grid.fixed_settings()


def test_the_defaults_of_a_number_that_follows_follow_too(at):
    text = swept(TEXT.replace("name: demo\n", "name: demo\ndefine: {play: 50 mm}\n")).replace(
        "crank:  {length: 50 mm", "crank:  {length: = play"
    )
    text = text.replace("[20 um, 50 um]", "[40 mm, 50 mm]")
    grid = at(text)
    assert [grid.written_case(k)["mechanism"]["crank"]["center"] for k in range(2)] == [0.02, 0.025]
    assert ids(load(grid.resolved())) == ids(grid)


def test_an_override_of_a_name_holds(at):
    assert at(WHOLE, {"define.play": "0.4 mm"}).case(0).joints[0].clearance == 4e-4


def test_numbers_of_one_name_vary_together(at):
    text = swept(WHOLE.replace("r: = d / 2", "r: = play + d / 2"), "[1 mm, 20 mm]")
    assert len(at(text)) == 2


def test_a_grid_without_expressions_has_the_bits_it_had(at):
    assert at(TEXT).defined.dependents == {}
    assert "define" not in at(TEXT).resolved()


PRODUCTS = "".join(f"  b{k}: = {'*'.join([f'b{k - 1}'] * 60)}\n" for k in range(1, 7))
BOMBS = {
    "products of products": f"  b0: 1.000000001\n{PRODUCTS}  value: = b6 / b6\n",
    "sums of fractions": "".join(
        f"  b{k}: = {' + '.join(f'1/{60 * k + n + 2}' for n in range(60))}\n" for k in range(9)
    )
    + f"  b: = {' + '.join(f'b{k}' for k in range(9))}\n  value: = b / b\n",
    "a chain of 2,000 names": "".join(f"  b{k}: = b{k + 1}\n" for k in range(2000)) + "  b2000: 1\n  value: = b0\n",
    "names that double": "  b0: 1\n  b1: 1\n"
    + "".join(f"  b{k}: = b{k - 1} + b{k - 2}\n" for k in range(2, 300))
    + "  value: = b299 / b299\n",
}


@pytest.mark.parametrize("name", BOMBS)
@pytest.mark.timeout(20)
def test_a_small_grid_of_definitions_is_evaluated_in_a_moment(at, name):
    text = TEXT.replace("clearance: 0.5 mm", "clearance: = value * '0.5 mm'")
    assert ids(at(f"{text}define:\n{BOMBS[name]}")) == ids(at(TEXT))


def test_sixty_digits_of_an_exact_value_are_kept():
    exact = Fraction(10**70 + 3 * 10**11, 10**70)
    assert _rounded(exact) == 1 + Fraction(3, 10**59)
    assert _rounded(Fraction(1, 3)) == Fraction(1, 3)
    with pytest.raises(ValueError, match="of the size 1e1200"):
        _rounded(Fraction(10**1200))


def test_a_circle_of_many_names_is_said_in_a_line(at):
    names = "".join(f"  b{k}: = b{(k + 1) % 1500}\n" for k in range(1500))
    with pytest.raises(InputError, match=r"b0 -> b1 -> .* -> \.\.\. -> b1499 -> b0; break the circle"):
        at(f"{TEXT}define:\n{names}")


# Values from the command line are put in the grid as if its file had them, and their mistakes name the option.


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
