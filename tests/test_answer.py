"""The wording of answers, in one golden page, and where an answer is stored and shown."""

import json
import zlib
from pathlib import Path

import numpy as np
import pytest
from answer_grids import MadeUp
from click.testing import CliRunner
from judged_cases import CLEARANCE, FORCE, IMPACTS, OTHER, RPM, SPEED, UNITS, answer_of, record_of, table_of
from right_grids import text_of

import clearsweep
from clearsweep import grid as grids
from clearsweep import report, simulation
from clearsweep.answers import figure_sentences
from clearsweep.answers.ranking import column_texts, ranking_of
from clearsweep.answers.sentences import sentences
from clearsweep.answers.verdict import Limit, column_label, limit_label
from clearsweep.answers.words import Words, digits_of, varied_text
from clearsweep.cli import verbs
from clearsweep.contracts import results
from clearsweep.contracts.layout import Column, JointLayout, Layout
from clearsweep.sweeping.summary import derived_lines, plain
from clearsweep.sweeping.sweep import Options, run_sweep

PIN = "pin"
GOLDEN = {
    "a design that was not run at every speed": (
        "1 of 2 designs meets the limits at every crank speed: force peak at most 500 N; 1 undecided.",
        "Undecided: clearance 0.2 mm was not run at crank speed 2000 rpm.",
        "Met by clearance 0.02 mm (margin 12 %).",
        "Force peak rises from 28.9 to 440 N as crank speed grows from 500 to 2000 rpm; "
        "it rises from 28.9 to 100 N as clearance grows from 0.02 to 0.2 mm.",
    ),
    "a limit of zero": (
        "1 of 2 designs meets the limits at every crank speed: impacts per revolution at most 0.",
        "Met up to clearance 0.02 mm; clearance 0.2 mm has impacts per revolution 2.00 beyond the limit of 0 "
        "at crank speed 2000 rpm.",
        "Impacts per revolution rises from 0 to 1.50 as clearance grows from 0.02 to 0.2 mm; "
        "it rises from 0.500 to 1.00 as crank speed grows from 500 to 2000 rpm.",
    ),
    "the hardest speed failed": (
        "No design is known to meet the limits at every crank speed: force peak at most 500 N; both are undecided.",
        "Undecided: both designs failed at crank speed 2000 rpm (time-limit).",
        "Force peak rises from 30.0 to 90.0 N as clearance grows from 0.02 to 0.2 mm.",
    ),
    "one failed, the other exceeds anyway": (
        "None of 2 designs meets the limits at every crank speed: force peak at most 50 N; 1 undecided.",
        "Undecided: clearance 0.02 mm failed at crank speed 2000 rpm (time-limit).",
        "Nearest: clearance 0.2 mm, 1.8 times the limit of force peak at crank speed 500 rpm.",
        "Force peak rises from 30.0 to 90.0 N as clearance grows from 0.02 to 0.2 mm.",
    ),
    "the nearest design": (
        "None of 2 designs meets the limits at every crank speed: force peak at most 20 N.",
        "Nearest: clearance 0.02 mm, 2.0 times the limit of force peak at crank speed 2000 rpm.",
        "Force peak rises from 35.0 to 100 N as clearance grows from 0.02 to 0.2 mm; "
        "it rises from 60.0 to 75.0 N as crank speed grows from 500 to 2000 rpm.",
    ),
    "one of three comparisons turns back": (
        "All 3 designs meet the limits at every crank speed: force peak at most 500 N.",
        "Best first: clearance 0.02 mm (margin 82 %); clearance 0.1 mm (margin 82 %); clearance 0.2 mm (margin 82 %).",
        "Force peak rises from 30.0 to 90.0 N as crank speed grows from 500 to 2000 rpm, "
        "but not steadily in 1 of 3 comparisons.",
        "Force peak has no steady trend with clearance.",
    ),
    "the finest tolerance": (
        "The case does not meet the limits: force peak at most 170 N.",
        "Worst: 1.2 times the limit of force peak.",
        "The finest tolerance decides (force peak 203 N); tolerance 0.01: 150 N, 26 % off, not converged.",
    ),
}
CASES = {
    "a design that was not run at every speed": (
        {FORCE: 500.0},
        [(2e-5, 500, 28.9), (2e-5, 2000, 440.0), (2e-4, 500, 100.1)],
    ),
    "the hardest speed failed": (
        {FORCE: 500.0},
        [(2e-5, 500, 30.0), (2e-5, 2000, None), (2e-4, 500, 90.0), (2e-4, 2000, None)],
    ),
    "one failed, the other exceeds anyway": (
        {FORCE: 50.0},
        [(2e-5, 500, 30.0), (2e-5, 2000, None), (2e-4, 500, 90.0), (2e-4, 2000, None)],
    ),
    "the nearest design": (
        {FORCE: 20.0},
        [(2e-5, 500, 30.0), (2e-5, 2000, 40.0), (2e-4, 500, 90.0), (2e-4, 2000, 110.0)],
    ),
    "one of three comparisons turns back": (
        {FORCE: 500.0},
        [
            *((2e-5, speed, force) for speed, force in ((500, 30.0), (1000, 50.0), (2000, 90.0))),
            *((1e-4, speed, force) for speed, force in ((500, 30.0), (1000, 50.0), (2000, 90.0))),
            *((2e-4, speed, force) for speed, force in ((500, 50.0), (1000, 30.0), (2000, 90.0))),
        ],
    ),
    "a limit of zero": ({IMPACTS: 0.0}, [(2e-5, 500, 0.0), (2e-5, 2000, 0.0), (2e-4, 500, 1.0), (2e-4, 2000, 2.0)]),
}


def worded(answer, record, table):
    """Return the sentences of an answer with plain spaces."""
    known = {name: np.array(values, object) for name, values in table.items()}
    known_words = Words(
        record, Layout.read(record["layout"]), lambda name: np.array([value or 0.0 for value in known[name]], float)
    )
    return tuple(line.replace("\u00a0", " ") for line in sentences(answer, known_words))


def test_the_golden_page():
    said = {}
    for name, (limits, rows) in CASES.items():
        figure = next(iter(limits))
        record, table = record_of(limits), table_of({CLEARANCE: 0, SPEED: 1, figure: 2}, rows)
        said[name] = worded(answer_of(record, table), record, table)
    record = record_of({FORCE: 170.0}, roles={"simulate.tolerance": "numerics"}, units={"simulate.tolerance": "1"})
    table = table_of({"simulate.tolerance": 0, FORCE: 1}, [(1e-2, 149.94), (1e-4, 203.0), (1e-9, 203.08)])
    said["the finest tolerance"] = worded(answer_of(record, table), record, table)
    assert said == GOLDEN


def test_more_than_two_limits_are_counted():
    record = record_of({FORCE: 100.0, IMPACTS: 5.0, OTHER: 1.0})
    rows = [(2e-5, 500, 30.0, 0.0, 0.5), (2e-4, 500, 110.0, 0.0, 0.5)]
    table = table_of({CLEARANCE: 0, SPEED: 1, FORCE: 2, IMPACTS: 3, OTHER: 4}, rows)
    assert worded(answer_of(record, table), record, table)[0] == "1 of 2 designs meets all 3 limits."


def test_a_sample_holds_in_every_draw():
    record = record_of({FORCE: 100.0}, {CLEARANCE: "choice", SPEED: "uncertainty"}, sample={"drawn": {SPEED: {}}})
    table = table_of({CLEARANCE: 0, SPEED: 1, FORCE: 2}, [(2e-5, 500, 30.0), (2e-5, 600, 40.0)])
    assert worded(answer_of(record, table), record, table)[0] == (
        "The machine meets the limits in every draw: force peak at most 100 N."
    )


@pytest.mark.parametrize("roles", [{SPEED: "condition"}, {SPEED: "choice", CLEARANCE: "condition"}])
def test_an_answer_says_where_its_limit_decides(roles):
    record = record_of({FORCE: 500.0}, {}, UNITS, seek={"largest": CLEARANCE, "for": "all"})
    answer = {"question": "seek", "complete": True, "roles": roles, "nearest": [], "cases": None}
    bounds = {f"seek.{CLEARANCE}": 1e-4, "seek_low": 1e-4, "seek_high": 2e-4, "limiting": FORCE}
    answer["search"] = [{SPEED: 65 * RPM, **bounds}]
    assert worded(answer, record, {FORCE: [1000.0]}) == (
        "The largest clearance within the limits at every crank speed: 0.1 mm, limited by force peak at crank speed 65 "
        "rpm.",
        "From there to 0.2 mm it is not known to be safe.",
    )


def test_a_search_of_three_answers_says_what_matters_most():
    """Its cases were run for this line."""
    effect = {
        "path": "mechanism.crank.length",
        "value": 0.05,
        "margin": -1.0,
        "unit": "m",
        "lower": -0.5,
        "upper": None,
    }
    nearest = {"needed": {FORCE: "at most 1 kN"}, "effects": [effect]}
    record = record_of({FORCE: 500.0}, {}, UNITS, seek={"largest": CLEARANCE, "for": "each"}, nearest=nearest)
    of_search = {"case": "0", "tried": 5, "failed": 1, "margin": -1.0, "limit": FORCE, "values": {CLEARANCE: 1e-5}}
    answer = {"question": "seek", "complete": True, "roles": {SPEED: "condition"}, "cases": None}
    answer["nearest"] = [of_search | {"excess": None}]
    answer["search"] = [
        {SPEED: speed * RPM, f"seek.{CLEARANCE}": None, "seek_low": None, "limiting": FORCE} for speed in (1, 2, 3)
    ]
    said = worded(answer, record, {FORCE: [1000.0]})
    assert said[4:] == (
        "None of 5 values tried meets the limits and 1 failed; nearest: 2.0 times the limit of force peak at "
        "clearance 0.01 mm.",
        "Of the other keys crank length matters most: 10 % less gives 1.5 times the limit, 10 % more a failed case.",
    )


def test_equal_values_of_several_joints_are_said_once():
    record = record_of({FORCE: 1.0}, units={f"joints.{name}.clearance": "m" for name in "abc"})
    known_words = Words(record, Layout.read(record["layout"]), lambda name: np.zeros(0))
    paths = [f"joints.{name}.clearance" for name in "abc"]
    assert known_words.setting(dict.fromkeys(paths, "H7/e8")) == "clearance H7/e8 in 3 joints"
    mixed = known_words.setting(dict(zip(paths, ("H7/e8", "H7/e8", "H7/g6"), strict=True)))
    assert mixed == "clearance H7/e8 in 2 joints, clearance (c) H7/g6"


def tied(second, **more):
    """Return the sentences on two pins whose clearances change together; second : clearances (m) of the other pin."""
    paths, firsts = [f"joints.{name}.clearance" for name in "ab"], [1e-4, 2e-4]
    written = {"unit": "mm", "factor": 1e-3, "offset": 0.0}
    zipped = dict(zip(paths, (firsts, second), strict=True))
    record = record_of({FORCE: 500.0}, {}, dict.fromkeys(paths, "m"), zip=zipped, **more)
    record["written_units"] = dict.fromkeys(paths, written)
    rows = [(first, other, force) for first, other, force in zip(firsts, second, (100.0, 300.0), strict=True)]
    table = table_of({**{path: place for place, path in enumerate(paths)}, FORCE: 2}, rows)
    answer = answer_of(record | {"roles": dict.fromkeys(paths, "choice")}, table)
    return worded(answer, record, table)


def test_clearances_that_change_together_are_named_once():
    assert (
        tied([1e-4, 2e-4])[-1]
        == "Force peak rises from 100 to 300 N as clearance in 2 joints grows from 0.1 to 0.2 mm."
    )


def test_clearances_that_change_against_each_other_are_named_both():
    assert "as clearance (a) grows from 0.1 to 0.2 mm and clearance (b) changes with it" in tied([2e-4, 1e-4])[-1]


def test_a_value_without_effect_is_said_to_change_a_figure_by_one_per_cent_at_most():
    record = record_of({FORCE: 500.0})
    rows = [(2e-5, 500, 100.0), (2e-5, 2000, 100.9), (2e-4, 500, 100.0), (2e-4, 2000, 100.9)]
    table = table_of({CLEARANCE: 0, SPEED: 1, FORCE: 2}, rows)
    said = worded(answer_of(record, table), record, table)
    assert said[-1] == "Crank speed and clearance change force peak by at most 1 %."


def test_a_velocity_of_vibration_is_in_the_unit_of_its_zones():
    assert column_texts("foot_velocity_rms", "m/s", np.array([0.04]), [0.0336, 2.0]) == [
        "33.6\u00a0mm/s",
        "2000\u00a0mm/s",
    ]


def test_a_figure_that_is_zero_in_every_case_is_said_to_be_zero():
    record = record_of({IMPACTS: 1.0})
    rows = [(gap, speed, 0.0) for gap in (2e-5, 2e-4) for speed in (500, 2000)]
    table = table_of({CLEARANCE: 0, SPEED: 1, IMPACTS: 2}, rows)
    said = worded(answer_of(record, table), record, table)
    assert said[-1] == "Impacts per revolution is 0 in every finished case."


def test_the_largest_force_is_not_sought_among_torques():
    record = record_of()
    columns = record["layout"]["columns"]
    columns += [columns[0] | {"name": "claw_force_peak", "joint": "claw", "unit": "N*m"}]
    record["layout"]["joints"] += [{"name": "claw", "wear_bins": 0, "flanked": "coupling"}]
    ends = {FORCE: 30.0, "claw_force_peak": 500.0}
    place = {"case": "0" * 16, "values": {}}
    extremes = [
        {"figure": name, "smallest": place | {"value": value}, "largest": place | {"value": value}}
        for name, value in ends.items()
    ]
    layout = Layout.read(record["layout"])
    known_words = Words(record, layout, lambda name: np.array([ends[name]]))
    answer = {"question": "force", "complete": True, "extremes": extremes, "effects": [], "designs": []}
    said = [line.replace("\u00a0", " ") for line in sentences(answer | {"convergence": []}, known_words)]
    assert said == ["Largest force peak (pin): 30.0 N.", "Largest force peak (claw): 500 N m."]
    assert ranking_of(layout, ()).candidates[0].joint == "pin"
    assert len(ranking_of(layout, ()).candidates) == 1
    assert ranking_of(layout, ()).title == "Largest normal force"
    only_torques = layout._replace(columns=layout.columns[-1:], joints=layout.joints[-1:])
    assert ranking_of(only_torques, ()).title == "Largest torque"


@pytest.mark.parametrize(
    ("count", "lead"),
    [
        (1, "The best of 60 cases: "),
        (3, "The front has 3 of 60 cases: "),
        (9, "The front has 9 of 60 cases, such as: "),
    ],
)
def test_a_front_is_listed_whole_or_by_examples(count, lead):
    record = record_of() | {"optimise": {"minimise": [FORCE]}}
    known_words = Words(record, Layout.read(record["layout"]), lambda name: np.array([30.0]))
    answer = {"search": [{FORCE: 30.0 + k, SPEED: 1.0} for k in range(count)], "tried": 60}
    said = list(figure_sentences.optimise_sentences(answer, known_words))
    assert said[0].startswith(lead)
    assert (said[-1] == "5 more are in optimise.parquet.") == (count == 9)


def test_a_design_of_a_table_is_called_by_its_name():
    record = record_of({FORCE: 200.0}, {CLEARANCE: "choice"}, {CLEARANCE: "m"}, case_labels=["variant"])
    table = table_of({CLEARANCE: 0, FORCE: 1}, [(2e-5, 100.0), (2e-4, 300.0)]) | {"variant": ["new", "worn"]}
    said = worded(answer_of(record, table), record, table)
    assert said[1] == (
        "Met up to new, clearance 0.02 mm (margin 50 %); worn, clearance 0.2 mm has 1.5 times the limit of force peak."
    )


def test_a_search_without_answer_says_what_would_help():
    effect = {"path": "mechanism.crank.length", "value": 0.05, "margin": -1.0, "unit": "m"}
    nearest = {"needed": {FORCE: "at most 1 kN"}, "effects": [effect | {"lower": -0.5, "upper": None}]}
    seek = {"largest": CLEARANCE, "for": "all"}
    record = record_of({FORCE: 500.0}, {}, UNITS, seek=seek, nearest=nearest)
    answer = {"question": "seek", "complete": True, "roles": {SPEED: "condition"}, "nearest": [], "cases": None}
    answer["search"] = [{SPEED: 100.0, f"seek.{CLEARANCE}": None, "seek_low": None, "limiting": FORCE}]
    assert worded(answer, record, {FORCE: [1000.0]}) == (
        "The largest clearance within the limits at every crank speed: none in the range.",
        "Of the other keys crank length matters most: 10 % less gives 1.5 times the limit, 10 % more a failed case.",
        "The limits that would be met: force peak at most 1 kN.",
    )


def test_derived_values_of_several_joints_share_a_line():
    value = {"unit": "m", "min": 1e-5, "max": 2e-5}
    names = [f"joints.{name}.clearance (H7/g6, {side})" for name in "abc" for side in ("radial", "diametral")]
    (line,) = derived_lines(dict.fromkeys(names, value))
    sizes = "10 µm to 20 µm radial, 10 µm to 20 µm diametral"
    assert plain(line) == f"derived: clearance (H7/g6) of a, b and c = {sizes}"


def test_no_line_is_long_and_no_answer_has_many():
    limits = {FORCE: 500.0, IMPACTS: 1.0}
    names = {CLEARANCE: 0, SPEED: 1, FORCE: 2, IMPACTS: 3}
    rows = [(1e-6 * k, 100.0 * j, 20.0 * k * j, 0.01 * k * j) for k in range(1, 30) for j in range(1, 9)]
    record, table = record_of(limits), table_of(names, rows)
    said = worded(answer_of(record, table), record, table)
    assert 1 < len(said) <= 6
    assert max(map(len, said)) <= 160


CONFIGS = sorted((Path(__file__).parent.parent / "configs").glob("*.yaml"))


class Varied(MadeUp):
    """Mechanics by formula for any grid: figures from 1 to 15 that scatter over the cases."""

    @staticmethod
    def catalogue():
        """Return the laws and figures of the program."""
        return simulation.catalogue()

    @staticmethod
    def alternatives(case):
        """Return no other laws."""
        return {}

    def solve(self, case, log=None):
        """Return made-up figures, wear and history of a case."""
        chance, layout = zlib.crc32(repr(case).encode()), Layout.of(case, self.catalogue())
        columns = {
            column.name: 1 if column.kind == "int" else 1.0 + (chance >> place % 20) % 97 / 7.0
            for place, column in enumerate(layout.columns)
        }
        bins = {joint.name: joint.wear_bins for joint in layout.joints if joint.wear_bins}
        rows = {joint.name: (joint.wear_rows,) if joint.wear_rows > 1 else () for joint in layout.joints}
        wear = {name: (np.ones((count, *rows[name])),) * 2 for name, count in bins.items()}
        return results.Trajectory("ok", "", columns, wear=wear, history=History(bins) if layout.life else {})


class History(dict):
    """Two nodes of a life."""

    def __init__(self, bins):
        super().__init__()
        self.bins = bins

    def __missing__(self, name):
        if "profile" not in name:
            return np.arange(2.0)
        return np.zeros((2, self.bins[name.partition("/")[0]]))


@pytest.mark.few("slider_crank", "two_joints", "rig", "press_joint_best", "spatial_four_bar")
@pytest.mark.parametrize("path", CONFIGS, ids=[path.stem for path in CONFIGS])
def test_answers_of_configs_have_six_lines_at_most(path, tmp_path):
    if "identify" in path.read_text(encoding="utf-8"):
        pytest.skip("compares time histories with a measurement")
    changed = grids.OverriddenGrid(path, {"save.orbits": "none"}, {})
    run_sweep(changed, tmp_path / "run", Options(executor="serial", show_progress=False), Varied({}))
    said = json.loads((tmp_path / "run" / "answer.json").read_text(encoding="utf-8"))["sentences"]
    assert 1 <= len(said) <= 6
    assert max(len(plain(line)) for line in said) <= 160
    assert [line for line in said if line.endswith(" ...")] == []


def test_the_unit_of_a_column_suits_most_of_its_values():
    films = np.array([5e-6, 60e-6, 180e-6])
    assert column_texts("pin_film_thickness_min", "m", films, [180e-6]) == ["180\u00a0µm"]  # not 0.180 mm
    assert column_texts("pin_force_peak", "N", np.array([400.0] * 99 + [2600.0]), [2600.0]) == ["2600\u00a0N"]
    assert column_texts("pin_wear_depth_max", "m", np.array([1e-9]), [15e-3]) == ["15.0\u00a0mm"]  # nm do not suit it


def test_columns_have_labels_in_words():
    columns = tuple(
        Column(f"{PIN}_{name}", "1", "", figure=name, joint=PIN) for name in ("film_thickness_min", "load_peak")
    )
    made = Layout("planar", True, "", (JointLayout(PIN, 360),), columns, ())
    assert column_label(made, "pin_film_thickness_min") == "least film"
    assert column_label(made, "hours_to_50_um") == "hours to 50 µm"
    warm = Limit("pin_temperature", "at_most", 333.15)
    assert limit_label(made, warm, "K") == "pin temperature at most 60\u00a0°C"
    limit = Limit("pin_load_peak", "at_most", 2.0, "pin_film_thickness_min")
    assert limit_label(made, limit, "N") == "load peak at most 2 times the least film"


def test_values_of_an_axis_that_differ_print_differently():
    values = [0.11998, 0.12, 0.12002]
    record = {"units": {"mechanism.rod.length": "m"}, "sweep": {"mechanism.rod.length": values}}
    record["written_units"] = {"mechanism.rod.length": {"unit": "mm", "factor": 1e-3, "offset": 0.0}}
    digits = digits_of(record, "mechanism.rod.length", record["written_units"])
    texts = [varied_text("mechanism.rod.length", value, "m", record["written_units"], digits) for value in values]
    assert texts == ["119.98 mm", "120 mm", "120.02 mm"]


MOTOR = text_of("a crank with a motor")


@pytest.fixture(scope="module")
def started(tmp_path_factory):
    """Return a run of a motor that reaches its speed with one flywheel only, and its closing lines."""
    directory = tmp_path_factory.mktemp("start")
    (directory / "grid.yaml").write_text(MOTOR, encoding="utf-8")
    done = CliRunner().invoke(
        verbs, ["run", str(directory / "grid.yaml"), "--executor", "serial", "--out", str(directory / "out")]
    )
    assert done.exit_code == 0, done.output
    return clearsweep.open(directory / "out"), done.output


def test_the_start_up_time_lies_between_the_samples_around_its_speed(started):
    run, _ = started
    reached = run.summary.dropna(subset="start_up_time")
    assert len(reached) == 1
    path, wanted = run.orbit(reached["case_id"].iloc[0]), 0.95 * 1500.0 * np.pi / 30.0
    after = int(np.argmax(np.asarray(path["crank/rate"]) >= wanted))
    times = np.asarray(path["t"])
    assert after > 0
    assert times[after - 1] < reached["start_up_time"].iloc[0] <= times[after]
    row = reached.iloc[0]
    rates = np.asarray(path["crank/rate"])
    force = np.asarray(path["joints/rod_slider/force_normal"])
    assert rates[after:].min() - 2.0 < row["crank_speed_after"] <= rates[after:].min()
    assert np.abs(force[:after]).max() <= row["rod_slider_force_peak_start"] <= row["rod_slider_force_peak"]
    rest = run.summary[run.summary["start_up_time"].isna()]
    assert rest[["crank_speed_after", "rod_slider_force_peak_start"]].isna().all(axis=None)
    assert (rest["crank_speed_max"] < wanted).all()


def test_an_answer_is_stored_and_shown_as_one_value(started):
    run, output = started
    stored = json.loads((run.directory / "answer.json").read_text(encoding="utf-8"))
    assert (stored["question"], stored["complete"], stored["cases"]) == ("start-up", True, None)
    assert stored["roles"] == {"drive.inertia": "choice"}
    last = output.split("Answer\n")[1].split("\n\n")[0].splitlines()
    assert [line.strip() for line in last] == [line.replace("\u00a0", " ") for line in stored["sentences"]]
    page = report.page_of(run)
    (verdict,) = (part for part in page.sections if part.key == "verdict")
    assert list(verdict.blocks[0].texts) == stored["sentences"]
    (summary,) = (part for part in page.sections if part.key == "summary")
    assert len(summary.blocks[0].cards) <= 8
