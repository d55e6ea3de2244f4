"""The answer of a run: the same sentences on the page and in its closing lines, each from its own figures."""

import numpy as np
import pytest
from click.testing import CliRunner

import clearsweep
from clearsweep import report
from clearsweep.cli import verbs
from clearsweep.contracts.layout import Column, JointLayout, Layout
from clearsweep.judging import answer, designs, sampled
from clearsweep.judging.order import lead_of
from clearsweep.judging.verdict import MARGIN, Limit
from clearsweep.report.data import study
from clearsweep.report.data.answered import answers

PIN = "pin"


def layout(*figures):
    """Return the layout of one joint with these columns."""
    columns = tuple(Column(f"{PIN}_{name}", "1", "", figure=name, joint=PIN) for name in figures)
    return Layout("planar", True, "", (JointLayout(PIN, 360),), columns, ())


def cases(columns, axes, lead=None, record=None, figures=()):
    """Return finished cases with these columns, whose words are bare numbers."""
    made, count = layout(*figures), len(next(iter(columns.values())))
    return answer.Cases(
        record or {},
        made,
        lead or lead_of(made, ()),
        axes,
        [f"{place:016d}" for place in range(count)],
        lambda name: np.asarray(columns[name]),
        lambda name, values: [f"{value:.4g}" for value in values],
        lambda index, paths: ", ".join(f"{path.split('.')[-1]} {columns[path][index]}" for path in paths),
    )


FIT, SPEED = "joints.pin.clearance", "drive.speed"


def test_a_design_keeps_to_the_limits_if_it_does_at_every_speed():
    columns = {FIT: [1, 1, 2, 2, 3, 3], SPEED: [7, 8] * 3, MARGIN: [0.9, 0.1, 0.5, 0.4, 0.95, -0.2]}
    made = cases(columns, (FIT, SPEED), lead_of(layout("load_peak"), [Limit("pin_load_peak", "at_most", 1.0)]))
    (sentence,) = answer.limited(made)
    assert sentence.startswith("2 of 3 designs keep to the limits at every crank speed")
    assert sentence.replace("\u00a0", " ").endswith(": clearance 2 40 %; clearance 1 10 %.")  # the safest first
    columns[MARGIN] = [0.9, -0.1, 0.5, np.nan, 0.95, -0.2]  # the second cannot be assessed at one speed
    (sentence,) = answer.limited(made)
    assert sentence.startswith("No design keeps to the limits at every crank speed. Nearest: clearance 1 \u221210")


@pytest.mark.parametrize("axes", [(FIT,), (SPEED,)])
def test_there_are_no_designs_without_conditions_and_none_without_designs(axes):
    columns = {FIT: [1, 2, 3], SPEED: [1, 2, 3], MARGIN: [0.1, 0.2, 0.3]}
    assert designs.of_cases(axes, columns.__getitem__, 3) is None


def test_a_fit_is_said_to_be_computed_at_its_mean():
    columns = {FIT: [1, 1, 2, 2], SPEED: [7, 8] * 2, MARGIN: np.full(4, 0.5)}
    lead = lead_of(layout("load_peak"), [Limit("pin_load_peak", "at_most", 1.0)])
    assert "mean clearance" in answer.limited(cases(columns, (FIT, SPEED), lead, {"fits": {FIT: []}}))[-1]
    assert "mean clearance" not in " ".join(answer.limited(cases(columns, (FIT, SPEED), lead)))


FILM = ("film_thickness_min", "dry_load_share", "film_loss", "film_limit_fraction")


def film(**changed):
    """Return three cases with films."""
    known = {"film_thickness_min": [3.0, 1.0, 2.0], "dry_load_share": [0.1, 0.2, 0.3], "film_loss": [9.0, 5.0, 1.0]}
    known |= {"film_limit_fraction": [0.0, 0.0, 0.0]} | changed
    columns = {f"{PIN}_{name}": np.array(values) for name, values in known.items()} | {SPEED: [1, 2, 3]}
    return [text.replace("\u00a0", " ") for text in answer.films(cases(columns, (SPEED,), figures=FILM))]


def test_a_film_that_its_law_does_not_cover_is_said_to_be_so_beside_it():
    first, loss = film()
    assert first == "Thinnest film: 1 at speed 2 (case 00000000). There: loss 5, dry load share 20 %."
    assert loss == "Largest loss: 9 at speed 1. Smallest: 1 at speed 3."
    first, second, _ = film(film_limit_fraction=[0.0, 0.04, 0.0])
    assert first.endswith(" The film is thinner than its law covers for 4 % of the time.")
    assert second == "Thinnest film within the range of its law: 2 at speed 3."


@pytest.mark.parametrize(
    ("settled", "words"),
    [
        ([1, 1], "Each reached its accuracy or a periodic motion."),
        ([1, 0], "1 of 2 cases reached neither the accuracy nor a periodic motion."),
    ],
)
def test_the_lengths_of_runs_until_a_figure_is_known_are_part_of_the_answer(settled, words):
    known = layout()._replace(columns=(Column("revolutions_run", "1", ""), Column("settled", "1", "")))
    columns = {"revolutions_run": [6.0, 300.0], "settled": settled, SPEED: [1, 2]}
    made = cases(columns, (SPEED,))._replace(layout=known)
    assert answer.lengths(made) == [f"A case ran 6 to 300 revolutions. {words}"]
    assert answer.lengths(cases(columns, (SPEED,))) == []


def test_sentences_of_the_answer_have_at_most_25_words():
    figures = ("force_peak", "force_peak_ratio", "load_peak", "wear_rate_max", "wear_depth_max", "film_loss", *FILM)
    paths = (SPEED, FIT, "mechanism.rod.mass", "joints.pin.contact.restitution")
    columns = {f"{PIN}_{name}": np.array([1.5, 2.5]) for name in figures} | {"headroom": [3.5, 4.5]}
    columns |= {path: [1.25, 2.25] for path in paths}
    made = cases(columns, paths, figures=figures, record={"figures": {"headroom": ""}})
    said = [*answer.largest_force(made), *answer.films(made), *answer.wear(made), *answer.own_figures(made)]
    assert len(said) == 5
    for sentence in " ".join(said).split(". "):
        assert len(sentence.split()) <= 25, sentence


def test_a_dry_share_without_contact_is_not_modelled():
    first, *_ = film(dry_load_share=[np.nan] * 3)
    assert "dry load share not modelled" in first


def test_the_position_error_is_part_of_the_answer_on_forces():
    known = layout("force_peak")
    known = known._replace(
        output="rocker", columns=(*known.columns, Column("rocker_error_max", "rad", "", figure="error_max"))
    )
    columns = {"pin_force_peak": [3.0, 5.0, 4.0], "rocker_error_max": [0.1, 0.2, 0.4], SPEED: [1, 2, 3]}
    made = cases(columns, (SPEED,))._replace(layout=known, lead=lead_of(known, ()))
    assert answer.sentences(made) == [
        "Largest normal force: 5 at speed 2 (case 00000000).",
        "Largest rocker error: 0.4 at speed 3.",
    ]
    assert answer.position_error(cases(columns, (SPEED,))) == []  # no output body


def test_a_measured_restitution_is_compared_with_the_requested_one_where_this_varies():
    path = f"joints.{PIN}.contact.restitution"
    columns = {"pin_force_peak": [1.0, 2.0], "pin_restitution": [0.48, 0.89], path: [0.5, 0.9]}
    figures = ("force_peak", "restitution")
    first, last = answer.largest_force(cases(columns, (path,), figures=figures, lead=lead_of(layout(*figures), ())))
    assert first.startswith("Largest normal force: 2")
    assert last == "Measured restitution differs from the requested one by at most 0.020: 0.480 at restitution 0.5."
    columns[SPEED] = [1, 2]
    assert len(answer.largest_force(cases(columns, (SPEED,), figures=figures, lead=lead_of(layout(*figures), ())))) == 1


MOTOR = """
name: start
mechanism:
  type: slider-crank
  crank:  {length: 50 mm, mass: 0.30 kg, inertia: 1e-4 kg*m^2}
  rod:    {length: 120 mm, mass: 0.21 kg, inertia: 2.5e-4 kg*m^2}
  slider: {mass: 0.14 kg}
drive: {motor: {stall_torque: 4 N*m, no_load_speed: 1500 rpm}, initial_speed: 0 rpm, inertia: 2e-3 kg*m^2}
joints:
  rod-slider: {clearance: 0.1 mm, bearing_radius: 10 mm, contact: {law: hertz, stiffness: 1e9 N/m^1.5}}
simulate: {revolutions: 5, discard: 0, tolerance: 1e-6}
save: {orbits: all, samples: 720}
sweep: {drive.inertia: [1e-3 kg*m^2, 2e-2 kg*m^2]}
"""


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
    rest = run.summary[run.summary["start_up_time"].isna()]
    assert (rest["crank_speed_max"] < wanted).all()


def test_a_start_up_is_answered_in_the_last_lines_and_at_the_top_of_the_page(started):
    run, output = started
    last = "\n".join(output.splitlines()[-10:])
    assert "Start-up to 1425 rpm, 95 % of the motor's no-load speed, takes" in last
    assert "1 of 2 cases did not reach 1425 rpm within the run: at most" in last
    sentences = answers(study.prepare(run))
    assert sentences[0].startswith("Start-up to 1425")
    page = report.of(run)
    assert any("Start-up time" in str(part.blocks) for part in page.parts if part.key == "summary")
    titles = [part.title for part in page.parts]
    assert "Impacts and kinds of motion" not in titles  # there is no steady state
    assert "start-up" in next(str(part.blocks) for part in page.parts if part.key == "trust")


def test_the_causes_of_a_spread_are_those_of_clear_correlations():
    random = np.random.default_rng(3)
    drawn = {"a": random.normal(size=60), "b": random.normal(size=60)}
    known = sampled.correlations(drawn, drawn["a"] + 0.01 * random.normal(size=60))
    text = sampled.causes("the force", known, {"a": "play", "b": "colour"})
    assert "fixed: play (" in text
    assert text.endswith("No clear effect on it: colour.")
    assert sampled.correlations(drawn, np.ones(60)) == []
    assert sampled.correlations({"a": np.arange(5.0)}, np.arange(5.0)) == []  # too few


def test_wear_is_that_of_the_fastest_rate_not_of_the_deepest_window():
    columns = {"pin_wear_rate_max": [1.0, 3.0, 2.0], "pin_wear_depth_max": [9.0, 1.0, 2.0], SPEED: [1, 2, 3]}
    made = cases(columns, (SPEED,), figures=("wear_rate_max", "wear_depth_max"))
    (sentence,) = answer.wear(made)
    assert sentence == "Deepest wear of one body: 1.08e+07 per 1000 h at speed 2."


def test_the_figures_of_a_grid_are_answered_with_the_cases_at_their_ends():
    columns = {"headroom": [2.0, 5.0, 3.0], SPEED: [1, 2, 3]}
    (sentence,) = answer.own_figures(cases(columns, (SPEED,), record={"figures": {"headroom": ""}}))
    assert sentence == "headroom: smallest 2 at speed 1. Largest: 5 at speed 2."
