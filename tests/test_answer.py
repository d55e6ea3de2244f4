"""The answer of a run: the same sentences on the page and in its closing lines, each from its own figures."""

import re

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

import clearsweep
from clearsweep import report
from clearsweep.answers import (
    advice,
    answer,
    designs,
    dominance,
    effects,
    films,
    interactions,
    labels,
    probability,
    sampled,
    start_up,
    validity,
    wear,
)
from clearsweep.answers.case_ranking import Candidate, CaseRanking, ranking_of
from clearsweep.answers.cases import FinishedCases, column_texts, range_text
from clearsweep.answers.verdict import MARGIN, Limit
from clearsweep.cli import verbs
from clearsweep.contracts.layout import Column, JointLayout, Layout
from clearsweep.report.data import study
from clearsweep.report.data.answered import answer_sentences

PIN = "pin"


def layout(*figures):
    """Return the layout of one joint with these columns."""
    columns = tuple(Column(f"{PIN}_{name}", "1", "", figure=name, joint=PIN) for name in figures)
    return Layout("planar", True, "", (JointLayout(PIN, 360),), columns, ())


def cases(columns, axes, lead=None, record=None, figures=()):
    """Return finished cases with these columns, whose words are bare numbers."""
    made, count = layout(*figures), len(next(iter(columns.values())))
    return FinishedCases(
        record or {},
        made,
        lead or ranking_of(made, ()),
        axes,
        [f"{place:016d}" for place in range(count)],
        lambda name: np.asarray(columns[name]),
        lambda name, values: [f"{value:.4g}" for value in values],
        lambda index, path: (path.split(".")[-1], str(columns[path][index])),
    )


FIT, SPEED = "joints.pin.clearance", "drive.speed"


LIMITED = {"limits": {"pin_load_peak": 1.0}}


def limited(columns, axes, record=LIMITED):
    """Return the answer to limits on a load that is constant, with plain spaces."""
    columns = {"pin_load_peak": np.ones(len(columns[SPEED]))} | columns
    lead = ranking_of(layout("load_peak"), [Limit("pin_load_peak", "at_most", 1.0)])
    return [
        text.replace("\u00a0", " ")
        for text in answer.limit_sentences(cases(columns, axes, lead, record, ("load_peak",)))
    ]


def test_a_design_keeps_to_the_limits_if_it_does_at_every_speed():
    columns = {FIT: [1, 1, 2, 2, 3, 3], SPEED: [7, 8] * 3, MARGIN: [0.9, 0.1, 0.5, 0.4, 0.95, -0.2]}
    first, *_ = limited(columns, (FIT, SPEED))
    assert first.startswith("2 of 3 designs meet the limits at every crank speed: load peak at most 1.")
    assert "The limits are met up to clearance 2 (smallest margin 40 %)." in first
    assert first.endswith("From 3 a limit is exceeded (margin \u221220 % there, at speed 8).")
    columns[MARGIN] = [0.9, 0.1, 0.5, 0.04, 0.95, -0.2]
    assert "(smallest margin 4 %). Such a small margin is not certain: " in limited(columns, (FIT, SPEED))[0]
    columns[MARGIN] = [0.9, -0.1, 0.5, np.nan, 0.95, -0.2]  # the second cannot be assessed at one speed
    first, *_ = limited(columns, (FIT, SPEED))
    assert first.startswith("No design meets the limits at every crank speed")
    assert first.endswith("Nearest: clearance 1 \u221210 % (smallest margin).")
    columns[MARGIN] = [0.9, 0.1, -0.5, 0.4, 0.95, 0.2]  # not monotone: the best first
    assert limited(columns, (FIT, SPEED))[0].endswith("best first: clearance 3 20 %; clearance 1 10 %.")


def test_cases_without_designs_are_counted_with_the_boundary_of_their_only_axis():
    first, *_ = limited({SPEED: [1, 2, 3], MARGIN: [-0.1, 0.2, 0.3]}, (SPEED,))
    assert first.startswith("2 of 3 cases meet the limits: load peak at most 1. The limits are met from speed 2")
    assert "Up to 1 a limit is exceeded" in first
    assert limited({SPEED: [1, 2], MARGIN: [0.1, 0.2]}, (SPEED,))[0].startswith("All cases meet the limits")
    assert limited({SPEED: [1], MARGIN: [-0.1]}, ())[0].startswith("The case does not meet the limits")


@pytest.mark.parametrize("axes", [(FIT,), (SPEED,)])
def test_there_are_no_designs_without_conditions_and_none_without_designs(axes):
    columns = {FIT: [1, 2, 3], SPEED: [1, 2, 3], MARGIN: [0.1, 0.2, 0.3]}
    assert designs.designs_of(axes, columns.__getitem__, 3) is None


def test_a_fit_whose_largest_clearance_was_not_covered_is_to_be_run_with_it():
    fits = [
        {"name": name, "low": 0.0, "mean": 1.0 * mean, "high": high}
        for name, mean, high in (("a", 1, 1.5), ("b", 2, 3e-6))
    ]
    fits[1]["high"] = 2.5
    columns = {FIT: np.array([1.0, 1.0, 2.0, 2.0]), SPEED: [7, 8] * 2, MARGIN: np.full(4, 0.5)}
    chosen, counted, *_ = limited(columns, (FIT, SPEED), LIMITED | {"fits": {FIT: fits}})
    assert chosen.startswith("a meets the limits up to its largest clearance, which lies below one that meets them")
    assert "At their mean clearances, the load peak is at most 1." in chosen
    assert "down to 0 µm, were not run." in chosen
    assert "add 0 µm" not in chosen  # that is no clearance
    fits[0]["low"] = 1.0
    chosen, *_ = limited(columns, (FIT, SPEED), LIMITED | {"fits": {FIT: fits}})
    assert chosen.startswith("a meets the limits over its whole tolerance: its largest clearance lies below one")
    assert "b is open: its largest clearance, 2.5e+06 µm, lies above 2e+06 µm (met), the largest" in chosen
    assert counted.startswith("At the mean clearances of the fits, all designs meet the limits at every crank speed")
    columns[MARGIN] = [0.5, 0.5, -0.5, 0.5]
    chosen, *_ = limited(columns, (FIT, SPEED), LIMITED | {"fits": {FIT: fits}})
    assert chosen.startswith("No fit is known to meet the limits over its whole tolerance. a is open: its largest")
    assert "1.5e+06 µm, lies between 1e+06 µm (met) and 2e+06 µm (exceeded)" in chosen
    assert "Exceeding a limit at the mean clearance: b." in chosen
    assert "fit" not in " ".join(limited(columns, (FIT, SPEED)))


def test_the_open_end_and_the_end_that_nobody_ran_are_named():
    fits = [{"name": "a", "low": 0.5, "mean": 1.0, "high": 1.5}, {"name": "b", "low": 1.0, "mean": 2.0, "high": 2.5}]
    columns = {FIT: np.array([1.0, 2.0, 3.0]), SPEED: [7] * 3, MARGIN: np.array([0.5, 0.4, -0.5])}
    chosen, *_ = limited(columns, (FIT,), LIMITED | {"fits": {FIT: fits}})
    assert "To decide, add 2.5e+06 µm to the sweep." in chosen
    assert chosen.startswith("a meets the limits up to its largest clearance, which lies below one that meets them")
    assert chosen.endswith(
        "Clearances below 1e+06 µm, down to 5e+05 µm, were not run. The margin does not shrink towards them; to check "
        "them, add 5e+05 µm to the sweep. Wear may widen the largest clearances up to 2e+06 µm: by 5e+05 µm for a."
    )
    columns[MARGIN][0] = 0.3
    shrinking = limited(columns, (FIT,), LIMITED | {"fits": {FIT: fits}})[0]
    assert "were not run. To check them, add 5e+05 µm to the sweep." in shrinking
    fits[0]["low"] = 1.0
    assert "not run" not in limited(columns, (FIT,), LIMITED | {"fits": {FIT: fits}})[0]


def test_of_a_limit_that_small_clearances_exceed_the_smallest_clearance_of_a_fit_decides():
    fits = [
        {"name": name, "low": low, "mean": mean, "high": 9.0} for name, low, mean in (("a", 1, 2.0), ("b", 2.5, 3.0))
    ]
    columns = {FIT: np.array([1.5, 2.0, 3.0]), SPEED: [7, 7, 7], MARGIN: np.array([-0.1, 0.1, 0.2])}
    chosen, *_ = limited(columns, (FIT,), LIMITED | {"fits": {FIT: fits}})
    assert chosen.startswith("b meets the limits down to its smallest clearance, which lies above one that meets them")
    assert "Clearances above 3e+06 µm, up to 9e+06 µm, were not run." in chosen
    assert "Wear may widen" not in chosen  # wear moves them away from the limit
    assert "a is open: its smallest clearance, 1e+06 µm, lies below 1.5e+06 µm (exceeded)" in chosen
    ends = [fit | {"mean": fit["mean"] + 0.25} for fit in fits]  # none of them ran
    assert not any("fit" in said for said in limited(columns, (FIT,), LIMITED | {"fits": {FIT: ends}}))
    columns[MARGIN] = np.array([0.1, -0.1, 0.2])  # not monotone
    columns[FIT][:] = [1.0, 2.5, 3.0]
    chosen, *_ = limited(columns, (FIT,), LIMITED | {"fits": {FIT: fits}})
    assert chosen.startswith("No fit is known")


def test_a_probability_is_that_of_the_counted_revolutions_and_grows_with_longer_runs():
    record = {"simulate": {"revolutions": 4.0, "discard": 1.0, "until": None}, "limits": {"pin_force_peak": 3.5}}
    assert " within the 3 counted revolutions. " in probability.exceedance_sentence((0.2, 0.1, 0.3), record)
    for changed in (
        {"simulate": {"revolutions": 4.0, "until": {"column": "x"}}},
        {"units": {"simulate.revolutions": "1"}},
    ):
        assert "within the counted revolutions" in probability.exceedance_sentence((0.2, 0.1, 0.3), record | changed)
    columns = {"pin_force_peak": [3.0, 4.0, 5.0], "period": np.array([1.0, np.nan, np.nan]), SPEED: [1, 2, 3]}
    made = cases(columns, (SPEED,), record=record, figures=("force_peak",))
    period = Column("period", "1", "")
    made = made._replace(layout=made.layout._replace(columns=(*made.layout.columns, period)))
    first, second = sampled.sentences(made)
    assert first == (
        "2 of 3 motions did not become periodic within the run: longer runs exceed limits on peaks more often. "
        "The order of the drivers may change, too. The probability is a lower bound: double the revolutions, "
        "to 8 next, until it no longer rises. If it keeps rising, limit the median peak or p99 instead of the largest "
        "peak."
    )
    assert second.startswith(
        "Force peak at most 3.5: exceeded with a probability of 67 % (95 %: 9.4 to 99 %); the worst is 5 at speed 3. "
        "Its median is"
    )
    columns["pin_force_peak_median"] = np.array([1.0, 2.0, 4.0])
    typical = cases(columns, (SPEED,), record=record, figures=("force_peak", "force_peak_median"))
    assert "speed 3. By the median peak per revolution, 1 of 3 cases exceeds it. Its" in sampled.sentences(typical)[0]
    assert "to 8 next" not in sampled.longer_run_warning(
        made._replace(varied_paths=("simulate.revolutions",)), ["pin_force_peak"]
    )
    columns["period"] = np.ones(3)
    assert not any("longer runs" in sentence for sentence in sampled.sentences(made))


def test_a_start_that_was_cut_off_is_no_rival_of_one_that_reached_its_speed():
    lead = CaseRanking("start-up", "", (), False, (Candidate("", ("start_up_time", "crank_speed_max")),))
    record = {"drive": {"motor": {"no_load_speed": 150.0}}, "simulate": {"revolutions": 8.0, "discard": 0.0}}
    columns = {"start_up_time": [0.1, 0.3, np.nan], "crank_speed_max": [160.0, 151.0, 99.0], SPEED: [1, 2, 3]}
    columns["pin_force_peak"] = [2.0, 5.0, 9.0]
    made = cases(columns, (SPEED,), lead, record, ("force_peak",))
    started = (Column("start_up_time", "s", ""), Column("crank_speed_max", "rad/s", ""))
    made = made._replace(layout=made.layout._replace(columns=(*made.layout.columns, *started)))
    first, second, force = answer.sentences(made)
    assert first.startswith(
        "2 of 3 cases reach 142.5, 95 % of the motor's no-load speed of 150, for the first time after 0.1 to 0.3. "
        "Every case with speed 1 or 2 does."
    )
    fraction = 99.0 / 150.0
    needed = 8.0 * (-np.log(0.05) - 0.95) / (-np.log(1.0 - fraction) - fraction)
    assert second == (
        f"No case with speed 3 reaches it within 8 revolutions: at most 99. This case needs about {needed:.0f} "
        f"revolutions by the motor's torque: run {np.ceil(1.25 * needed):.0f} or more."
    )
    assert force.startswith("Largest normal force of the started cases: 5 at speed 2 (case 0000000")
    last = "The peak is unknown with speed 3: 9 until the end of the run, but it may become the highest."
    assert force.endswith(f"{last} In longer runs the started cases may have higher peaks, too.")
    period = Column("period", "1", "")
    repeating = made._replace(layout=made.layout._replace(columns=(*made.layout.columns, period)))
    columns["period"] = [1.0, 2.0, np.nan]  # the start that was cut off does not count
    assert answer.sentences(repeating)[2].endswith(last)
    columns["period"] = [1.0, np.nan, np.nan]
    assert answer.sentences(repeating)[2].endswith("may have higher peaks, too.")
    loaded = answer.sentences(made._replace(record=record | {"loads": {"pump": {}}}))[1]
    assert "If the speed still rises at the end of the run, run 16 revolutions or more. Otherwise the loads" in loaded
    (card, *_) = start_up.start_up_cards(made)
    assert card == ("Cases that reach 142.5", "2 of 3", "after 0.1 to 0.3; not with speed 3 within 8 revolutions")
    columns["start_up_time"][2] = 0.9
    assert "Largest normal force: 9 at speed 3" in " ".join(answer.sentences(made))
    columns["start_up_time"][:] = [np.nan] * 3
    columns["crank_speed_max"][:] = [90.0, 91.0, 92.0]
    assert answer.sentences(made)[0].startswith(
        "No case reaches 142.5, 95 % of the motor's no-load speed of 150, within 8 revolutions: at most 92 at speed 3."
    )


def test_starts_are_only_blamed_on_values_that_explain_all_of_them():
    columns = {"start_up_time": [0.1, np.nan, np.nan, 0.2], "crank_speed_max": [160.0, 99.0, 98.0, 155.0]}
    columns |= {SPEED: [1, 1, 2, 2], FIT: [3, 4, 3, 4]}
    made = cases(columns, (SPEED, FIT), record={"drive": {"motor": {"no_load_speed": 150.0}}})
    started = tuple(Column(name, "1", "") for name in ("start_up_time", "crank_speed_max"))
    made = made._replace(layout=made.layout._replace(columns=(*made.layout.columns, *started)))
    first, second = start_up.sentences(made)
    assert "does" not in first
    assert second.startswith("2 of 4 cases do not reach it within its run: at most 99 at speed 1, clearance 4. To see")
    columns["start_up_time"][:] = [0.1, 0.2, np.nan, np.nan]
    assert start_up.sentences(made)[1].startswith("No case with speed 2 reaches it")


def test_a_first_touch_of_the_speed_is_not_steady_running_and_the_force_until_then_is_not_that_of_the_run():
    lead = CaseRanking("start-up", "", (), False, (Candidate("", ("start_up_time", "crank_speed_max")),))
    record = {"drive": {"motor": {"no_load_speed": 150.0}}, "simulate": {"revolutions": 8.0, "discard": 0.0}}
    columns = {"start_up_time": [0.1, 0.3], "crank_speed_max": [180.0, 151.0], "crank_speed_after": [100.0, 141.0]}
    columns |= {SPEED: [1, 2], "pin_force_peak": [2.0, 5.0], "pin_force_peak_start": [2.0, 1.5]}
    made = cases(columns, (SPEED,), lead, record, ("force_peak", "force_peak_start"))
    started = tuple(Column(name, "1", "") for name in ("start_up_time", "crank_speed_max", "crank_speed_after"))
    made = made._replace(layout=made.layout._replace(columns=(*made.layout.columns, *started)))
    _, swing, force = (text.replace("\u00a0", " ") for text in answer.sentences(made))
    assert swing == (
        "After that, the speed swings around 140 to 146, the middle of its extremes. The largest swing is ±29 %, "
        "between 100 and 180, up to 20 % above no load at speed 1. Swing falls from 80 to 10 as speed grows from 1 "
        "to 2. 2 of 2 started cases fall below 142.5 again."
    )
    assert force.startswith("Largest normal force within 8 revolutions: 5 at speed 2")
    assert force.endswith("Until the start-up time: 2 at speed 1. In longer runs the peak may be higher.")
    columns["crank_speed_after"][:] = [143.0, 144.0]
    assert "No started case falls below 142.5 again." in answer.sentences(made)[1]
    first, second = start_up.start_up_cards(made)
    assert first[0] == "Start-up time"
    assert second == ("Speed after that", "143 to 180", "largest swing, around 161.5, speed 1")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([1.0, 2.0, 4.0], "Force peak rises from 1 to 4 as speed grows from 1 to 3."),
        ([4.0, 2.0, 1.0], "Force peak falls from 4 to 1 as speed grows from 1 to 3."),
        ([1.0, 4.0, 2.0], "Force peak is smallest, 1, at speed 1 and largest, 4, at 2."),
        ([2.0, 2.0, 2.01], "No varied value has a clear effect on the force peak."),
    ],
)
def test_an_effect_has_its_direction_and_its_size(values, words):
    made = cases({SPEED: np.array([1.0, 2.0, 3.0]).astype(int)}, (SPEED,))
    said = effects.sentences(made, "force peak", np.array(values), lambda known: [f"{value:g}" for value in known])
    assert said == [words]


def test_effects_are_ordered_by_their_share_of_the_variation():
    columns = {SPEED: np.repeat([1, 2, 3], 6), FIT: np.tile([1, 1, 2, 2, 4, 4], 3), "idle.key": np.tile([0, 1], 9)}
    values = columns[SPEED] ** 2.0 / columns[FIT] ** 0.5
    made = cases(columns, tuple(columns))
    first, second, last = effects.sentences(made, "film", values, lambda known: [f"{value:.3g}" for value in known])
    assert first == "Strongest effect: film rises from 0.707 to 6.36 (medians) as speed grows from 1 to 3."
    assert second == "Next: it falls from 4 to 2 as clearance grows from 1 to 4."
    assert last == "Little or no effect: key."


def test_an_axis_of_names_has_its_smallest_and_its_largest_value():
    made = cases({"law": np.array(["b", "a"], object)}, ("law",))
    (said,) = effects.sentences(made, "force", np.array([3.0, 1.0]), lambda known: [f"{value:g}" for value in known])
    assert said == "Force is smallest, 1, at law a and largest, 3, at b."


def test_a_unit_is_written_once_in_a_range_and_is_that_of_the_column():
    assert range_text("1\u00a0mm", "2\u00a0mm") == "from 1 to 2\u00a0mm"
    assert range_text("1 mm (H7/g6)", "2 mm (H8/e8)") == "from 1 mm (H7/g6) to 2 mm (H8/e8)"
    films = np.array([5e-6, 60e-6, 180e-6])
    assert column_texts("pin_film_thickness_min", "m", films, [180e-6]) == ["180\u00a0µm"]  # not 0.180 mm
    assert column_texts("pin_force_peak", "N", np.array([400.0] * 99 + [2600.0]), [2600.0]) == ["2600\u00a0N"]
    assert column_texts("pin_wear_depth_max", "m", np.array([1e-9]), [15e-3]) == ["15.0\u00a0mm"]  # nm do not suit it


def test_columns_have_the_same_label_on_the_page_and_in_the_closing_lines():
    made = layout("film_thickness_min", "load_peak")
    assert labels.column_label(made, "pin_film_thickness_min") == "least film"
    assert labels.column_label(made, "hours_to_50_um") == "hours to 50 µm"
    limit = Limit("pin_load_peak", "at_most", 2.0, "pin_film_thickness_min")
    assert labels.limit_label(made, limit, "N") == "load peak at most 2 times the least film"


FILM = ("film_thickness_min", "dry_load_share", "film_loss", "film_limit_fraction")


def film(**changed):
    """Return three cases with films."""
    known = {"film_thickness_min": [3.0, 1.0, 2.0], "dry_load_share": [0.1, 0.2, 0.3], "film_loss": [9.0, 5.0, 1.0]}
    known |= {"film_limit_fraction": [0.0, 0.0, 0.0]} | changed
    columns = {f"{PIN}_{name}": np.array(values) for name, values in known.items()} | {SPEED: [1, 2, 3]}
    return [text.replace("\u00a0", " ") for text in films.sentences(cases(columns, (SPEED,), figures=FILM))]


def test_a_film_that_its_law_does_not_cover_is_said_to_be_so_beside_it():
    over, premises, first, moved, loss, share = film()
    assert premises.endswith("The thinnest film, 1, allows a combined roughness of 0.3333.")
    assert over.startswith("Over crank speed, the film is safe in every case. Safe means within the range")
    assert first == "Thinnest film: 1 at speed 2 (case 00000000). Every case is within the range of the film law."
    assert moved == "Least film is smallest, 1, at speed 2 and largest, 3, at 1."
    assert (
        loss == "Film loss: 1 to 9. It is largest at speed 1. Film loss falls from 9 to 1 as speed grows from 1 to 3."
    )
    assert share == "Dry load share in the case of the thinnest film: 20 %."
    over, _, first, *_ = film(film_limit_fraction=[0.0, 0.04, 0.0])
    assert over.startswith("Over crank speed, the film is unsafe in 1 of 3 cases.")
    assert first.endswith(
        " It is thinner than its law covers for 4 % of the time: do not rely on it. 2 of 3 cases are within the law. "
        "The thinnest that its law covers: 2 at speed 3."
    )
    _, _, first, *_ = film(film_limit_fraction=[0.1, 0.04, 0.0])
    assert "1 of 3 cases is within the law. Outside, too: speed 1. The thinnest" in first


def lubricated(record=None, **changed):
    """Return two speeds by two clearances by two viscosities with films, as cases."""
    viscosity = "joints.pin.film.viscosity"
    columns = {SPEED: [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0], FIT: [0.2e-3, 0.2e-3, 0.5e-3, 0.5e-3] * 2}
    columns |= {viscosity: [3, 4] * 4}
    known = {"film_thickness_min": [6.0, 9.0, 7.0, 8.0, 5.0, 7.0, 1.0, 3.0], "dry_load_share": [np.nan] * 8}
    known |= {"film_loss": [1.0, 2.0, 3.0, 2.0, 20.0, 15.0, 40.0, 50.0], "film_limit_fraction": [0.0] * 6 + [0.1, 0.0]}
    columns |= {f"{PIN}_{name}": np.array(values, float) for name, values in (known | changed).items()}
    columns[FIT] = np.array(columns[FIT])
    return cases(columns, (SPEED, FIT, viscosity), figures=FILM, record=record)


def test_the_safest_combination_is_the_one_with_the_thickest_film_at_every_speed_and_its_loss():
    first, *_ = films.sentences(lubricated())
    assert first.startswith("Thickest film at the worst crank speed: clearance 0.0002, viscosity 4. Its film is at ")
    assert (
        "least 7, its loss at most 15. No other safe combination has a smaller largest loss. It is at the end" in first
    )
    assert (
        "the range of clearance and film viscosity: a better one may lie outside. 3 of 4 combinations are safe" in first
    )
    assert films.sentences(lubricated())[2] == (
        "No roughness is given: a film should exceed 3 times the combined roughness, the root of the summed squares of "
        "both surfaces. The thinnest safe film, 3, allows a combined roughness of 1. The viscosity is that of the warm "
        "oil in the running joint."
    )
    assert first.endswith(" Unsafe: clearance 0.0005, viscosity 3 (1 of 2 cases).")
    assert films.sentences(lubricated())[1] == (
        "Also safe: clearance 0.0002, viscosity 3: film at least 5, loss at most 20. Clearance 0.0005, viscosity 4: "
        "film at least 3, loss at most 50."
    )
    dear, *_ = films.sentences(lubricated(film_loss=[1.0] * 5 + [30.0, 40.0, 20.0]))
    assert "its loss at most 30. It is at the end" in dear  # another safe one loses less
    none, *_ = films.sentences(lubricated(film_limit_fraction=[0.1] * 8))
    assert none.startswith("No combination of the values is safe under every condition.")


ROUGH = {"joints": {PIN: {"film": {"limit": 0.99, "transition": {"roughness": 2.0}}}}}


def test_a_film_thinner_than_three_roughnesses_is_not_safe_and_the_suggested_limit_follows_them():
    first, *_ = films.sentences(lubricated(ROUGH))
    assert "1 of 4 combinations is safe at every crank speed: within the range of the film law and above 3" in first
    assert "limits: {pin_film_thickness_min: {at_least: 6000000 um}}" in advice.suggest_limit(lubricated(ROUGH))
    smooth = advice.suggest_limit(lubricated({"joints": {PIN: {"film": {"limit": 0.99}}}}))
    assert "No roughness is given: a film should exceed 3 times the combined roughness of the surfaces." in smooth
    assert "ends at 5 um for the largest clearance" in smooth  # (1 - 0.99) times 0.5 mm
    assert smooth.endswith("limits: {pin_film_thickness_min: {at_least: 5 um}}")
    assert "add to the grid" not in advice.suggest_limit(lubricated())  # neither roughness nor limit


def test_effects_that_cancel_over_another_value_are_said_to_be_opposite():
    columns = {SPEED: np.array([1, 2, 1, 2]), FIT: np.array([1, 1, 2, 2])}
    made, values = cases(columns, (SPEED, FIT)), np.array([1.0, 4.0, 8.0, 2.0])
    words = (made, SPEED, "loss", values, lambda known: [f"{value:g}" for value in known])
    assert interactions.crossover_interaction_sentence(*words) == (
        "Opposite effects: as speed grows, loss rises in 1 of 2 combinations of the other values and falls in 1. "
        "In the medians, at clearance 1 it rises from 1 to 4; at clearance 2 it falls from 8 to 2."
    )
    values[:] = [1.0, 4.0, 2.0, 8.0]
    assert interactions.crossover_interaction_sentence(*words) == ""
    values[:] = [1.0, 1.01, 2.0, 1.0]  # no clear rise
    assert interactions.crossover_interaction_sentence(*words) == ""


def test_clearances_are_compared_at_equal_other_values():
    columns = {"pin_film_thickness_min": [3.0, 1.0, 5.0, 2.0], "pin_film_loss": [1.0, 2.0, 4.0, 3.0]}
    columns |= {FIT: [0.2, 0.5, 0.2, 0.5], SPEED: [1, 1, 2, 2]}
    figures = ("film_thickness_min", "film_loss")
    made = cases(columns, (FIT, SPEED), figures=figures)
    said = dominance.sentences(made, "pin_film_thickness_min", "pin_film_loss")
    assert said == [
        "Clearance 0.2 has the thickest film in 2 of 2 combinations of the other values, and the least loss in 1 of 2."
    ]
    columns["pin_film_thickness_min"] = [3.0, 4.0, 5.0, 6.0]
    (other,) = dominance.sentences(made, "pin_film_thickness_min", "pin_film_loss")
    assert other.startswith("Clearance 0.5 has the thickest film in 2 of 2")
    assert dominance.sentences(cases(columns, (FIT,), figures=figures), "pin_film_thickness_min", "pin_film_loss") == []


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
    assert answer.run_length_sentences(made) == [f"A case ran 6 to 300 revolutions. {words}"]
    assert answer.run_length_sentences(cases(columns, (SPEED,))) == []


def test_sentences_of_the_answer_have_at_most_25_words():
    figures = ("force_peak", "force_peak_ratio", "load_peak", "wear_rate_max", "wear_depth_max", "film_loss", *FILM)
    paths = (SPEED, FIT, "mechanism.rod.mass", "joints.pin.contact.restitution")
    columns = {f"{PIN}_{name}": np.array([1.5, 2.5]) for name in figures} | {"headroom": [3.5, 4.5]}
    columns |= {path: [1.25, 2.25] for path in paths}
    made = cases(columns, paths, figures=figures, record={"figures": {"headroom": ""}})
    said = [
        *answer.largest_force_sentences(made),
        *films.sentences(made),
        *wear.sentences(made),
        *answer.figure_range_sentences(made),
    ]
    assert len(said) == 10
    said += [
        *films.sentences(lubricated()),
        *films.sentences(lubricated(ROUGH)),
        advice.suggest_limit(lubricated(ROUGH)),
    ]
    for sentence in " ".join(said).split(". "):
        assert len(sentence.split()) <= 25, sentence


def test_a_dry_share_without_contact_is_not_part_of_the_answer():
    assert not any("ry load share" in text for text in film(dry_load_share=[np.nan] * 3))
    assert films.dry_share_text(np.nan) == "not modelled"


def test_the_position_error_is_part_of_the_answer_on_forces():
    known = layout("force_peak")
    known = known._replace(
        output="rocker", columns=(*known.columns, Column("rocker_error_max", "rad", "", figure="error_max"))
    )
    columns = {"pin_force_peak": [3.0, 5.0, 4.0], "rocker_error_max": [0.1, 0.2, 0.4], SPEED: [1, 2, 3]}
    made = cases(columns, (SPEED,))._replace(layout=known, ranking=ranking_of(known, ()))
    assert answer.sentences(made) == [
        "Largest normal force: 5 at speed 2 (case 00000000).",
        "Force peak is smallest, 3, at speed 1 and largest, 5, at 2.",
        "Largest rocker error: 0.4 at speed 3. It rises from 0.1 to 0.4 as speed grows from 1 to 3.",
    ]
    assert answer.position_error_sentences(cases(columns, (SPEED,))) == []  # no output body


def test_a_measured_restitution_is_compared_with_the_requested_one_where_this_varies():
    path = f"joints.{PIN}.contact.restitution"
    columns = {"pin_force_peak": [1.0, 2.0], "pin_restitution": [0.48, 0.89], path: [0.5, 0.9]}
    figures = ("force_peak", "restitution")
    first, _, last = answer.largest_force_sentences(
        cases(columns, (path,), figures=figures, lead=ranking_of(layout(*figures), ()))
    )
    assert first.startswith("Largest normal force: 2")
    assert last == "Measured restitution differs from the requested one by at most 0.020: 0.480 at restitution 0.5."
    columns[SPEED] = [1, 2]
    said = answer.largest_force_sentences(
        cases(columns, (SPEED,), figures=figures, lead=ranking_of(layout(*figures), ()))
    )
    assert not any("Measured" in sentence for sentence in said)


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
    row, rates, force = (
        reached.iloc[0],
        np.asarray(path["crank/rate"]),
        np.asarray(path["joints/rod_slider/force_normal"]),
    )
    assert rates[after:].min() - 2.0 < row["crank_speed_after"] <= rates[after:].min()
    assert np.abs(force[:after]).max() <= row["rod_slider_force_peak_start"] <= row["rod_slider_force_peak"]
    rest = run.summary[run.summary["start_up_time"].isna()]
    assert rest[["crank_speed_after", "rod_slider_force_peak_start"]].isna().all(axis=None)
    assert (rest["crank_speed_max"] < wanted).all()


def test_a_start_up_is_answered_in_the_last_lines_and_at_the_top_of_the_page(started):
    run, output = started
    last = "\n".join(output.splitlines()[-10:])
    assert "1 of 2 cases reaches 1425 rpm, 95 % of the motor's no-load speed of 1500 rpm, for the first time" in last
    missing = "No case with drive inertia 0.02 kg*m^2 reaches it within 5 revolutions: at most"
    assert missing in last
    sentences = [text.replace("\u00a0", " ") for text in answer_sentences(study.prepare(run))]
    assert sentences[1].startswith(missing.replace("kg*m^2", "kg m²"))
    page = report.page_of(run)
    (summary,) = (part for part in page.sections if part.key == "summary")
    assert summary.blocks[0].cards[0][:2] == ("Cases that reach 1425\u00a0rpm", "1 of 2")
    assert "cut off" in output.split("Answer")[0]  # in the table
    titles = [part.title for part in page.sections]
    assert "Impacts and kinds of motion" not in titles  # there is no steady state
    assert "start-up" in next(str(part.blocks) for part in page.sections if part.key == "trust")


def test_the_causes_of_a_spread_are_those_of_clear_correlations():
    random = np.random.default_rng(3)
    drawn = {"a": random.normal(size=60), "b": random.normal(size=60)}
    known = sampled.variable_correlations(drawn, drawn["a"] + 0.01 * random.normal(size=60))
    values = drawn["a"] + 0.01 * random.normal(size=60)
    assert [path for path, *_ in known] == ["a", "b"]
    names = {"a": "play", "b": "colour"}
    text = " ".join(sampled.driver_sentences(drawn, values, names, lambda numbers: [f"{each:.2g}" for each in numbers]))
    low, high = np.quantile(drawn["a"], [0.25, 0.75])
    low, high = (np.median(values[where]) for where in (drawn["a"] <= low, drawn["a"] >= high))
    assert text.startswith("It rises most with play (strength 1.0)")
    assert text.endswith(f"median {low:.2g} in its lowest quarter, {high:.2g} in its highest.")
    assert "colour" not in text
    assert sampled.variable_correlations(drawn, np.ones(60)) == []
    assert sampled.variable_correlations({"a": np.arange(5.0)}, np.arange(5.0)) == []  # too few


def test_wear_is_that_of_the_fastest_rate_not_of_the_deepest_window():
    columns = {"pin_wear_rate_max": [1.0, 3.0, 2.0], "pin_wear_depth_max": [9.0, 1.0, 2.0], SPEED: [1, 2, 3]}
    made = cases(columns, (SPEED,), figures=("wear_rate_max", "wear_depth_max"))
    (sentence,) = wear.sentences(made)
    assert sentence.startswith("Deepest wear of one body: 1.08")  # 3 m/s for 3.6e6 s
    assert " per 1000 h at speed 2. It is smallest, " in sentence
    worn = made._replace(record={"joints": {PIN: {"bearing_radius": 1e6}}})
    assert "In 3 of 3 cases the bearing is worn away" in wear.sentences(worn)[0]
    assert ". The depth is smallest, " in wear.sentences(worn)[0]


def test_wear_beyond_the_clearance_is_no_forecast():
    columns = {
        "pin_wear_rate_max": np.array([1e-9, 1e-12]),
        "pin_wear_depth_max": np.ones(2),
        FIT: np.array([1e-4, 2e-4]),
    }
    made = cases(columns, (FIT,), figures=("wear_rate_max", "wear_depth_max"))
    (joint,) = made.layout.joints
    (said,) = wear.forecast_remark(made, joint, 0, 3.6e-3)
    assert "after 28 h the wear reaches the clearance of 0.100" in said  # 1000 h * 0.1 mm / 3.6 mm
    assert wear.forecast_remark(made, joint, 1, 3.6e-6) == []


def test_a_sample_that_wears_beyond_its_clearance_has_hours_instead_of_a_depth():
    rates = np.geomspace(1e-10, 4e-10, 20)
    columns = {"pin_wear_rate_max": rates, "pin_wear_depth_max": np.ones(20), FIT: np.full(20, 1e-4)}
    columns["joints.pin.wear.coefficient"] = rates
    axes = (FIT, "joints.pin.wear.coefficient")
    made = cases(columns, axes, figures=("wear_rate_max", "wear_depth_max"))
    worn = sampled.sentences(made)[-1].replace("\u00a0", " ")
    assert "worn away" not in worn
    radius = {"joints": {PIN: {"bearing_radius": 1e-3}}}
    alarmed = sampled.sentences(made._replace(record=radius))[-1]
    count = int((rates > 1e-3 / 3.6e6).sum())
    assert f"In {count} of 20 cases the bearing is worn away within 1000 h: check the wear coefficient" in alarmed
    assert 0 < count < 20
    (card,) = sampled.driver_cards(made)
    assert card == ("Wear rate rises most with", "coefficient", "strength 1.0")
    assert worn.startswith("Hours until the wear equals the clearance, at the rate of the run: median 139 h; 90 %")
    assert "so no depth is forecast. The wear rate rises most with coefficient (strength 1.0): median 0.417" in worn
    assert "per 1000 h" not in worn
    columns["pin_wear_rate_max"] = 1e-3 * rates
    assert sampled.sentences(made)[-1].startswith("Wear depth per 1000 h: median 0.720")


def test_the_figures_of_a_grid_are_answered_with_the_cases_at_their_ends():
    columns = {"headroom": [2.0, 5.0, 3.0], SPEED: [1, 2, 3]}
    (sentence,) = answer.figure_range_sentences(cases(columns, (SPEED,), record={"figures": {"headroom": ""}}))
    assert sentence == "Headroom: 2 to 5. It is smallest, 2, at speed 1 and largest, 5, at 2."


def test_a_figure_also_has_its_range_in_the_designs_that_meet_the_limits():
    columns = {"hours": [9.0, 7.0, 2.0, 8.0], FIT: [1, 1, 2, 2], SPEED: [1, 2, 1, 2], MARGIN: [0.1, 0.2, -0.1, 0.3]}
    columns |= {"pin_load_peak": np.ones(4)}
    made = cases(columns, (FIT, SPEED), record=LIMITED | {"figures": {"hours": ""}}, figures=("load_peak",))
    (sentence,) = answer.figure_range_sentences(made)
    assert sentence.startswith("Hours: 2 to 9. Where the limits are met: 7 to 9.")
    columns[MARGIN] = [0.1, 0.2, 0.1, 0.3]
    assert "Where the limits" not in answer.figure_range_sentences(made)[0]


def test_the_range_of_a_figure_leaves_out_fits_that_are_open_and_wear_is_said_to_widen_the_clearance():
    fits = [{"name": name, "low": 1.0, "mean": mean, "high": high} for name, mean, high in (("a", 1, 1.5), ("b", 2, 9))]
    columns = {"hours": [9.0, 7.0, 2.0, 8.0], FIT: np.array([1.0, 1.0, 2.0, 2.0]), SPEED: [1, 2, 1, 2]}
    columns |= {MARGIN: np.full(4, 0.5), "pin_load_peak": np.ones(4)}
    record = LIMITED | {"figures": {"hours": "1 / pin_wear_rate_max"}, "fits": {FIT: fits}}
    lead = ranking_of(layout("load_peak"), [Limit("pin_load_peak", "at_most", 1.0)])
    made = cases(columns, (FIT, SPEED), lead, record, ("load_peak",))
    (sentence,) = answer.figure_range_sentences(made)
    assert sentence.startswith("Hours: 2 to 9. For a: 7 to 9.")
    assert sentence.endswith("wear widens the clearance, so they may not hold until then.")
    assert (
        "they may not hold"
        not in answer.figure_range_sentences(
            made._replace(record=record | {"figures": {"hours": "1 / pin_load_peak"}})
        )[0]
    )


@pytest.mark.parametrize(("margin", "is_small"), [(0.024, True), (0.0, True), (0.1, False), (-0.01, False)])
def test_a_small_margin_is_not_stated_without_reservation(margin, is_small):
    columns = {MARGIN: np.array([margin, 0.5]), "limits_exceeded": ["", ""], SPEED: [1, 2], "pin_load_peak": np.ones(2)}
    (sentence,) = answer.end_of_life_limit_sentences(cases(columns, (SPEED,), record=LIMITED, figures=("load_peak",)))
    assert ("Such a small margin is not certain" in sentence) == is_small


def test_the_advice_on_wide_smoothing_is_text_of_the_grid_that_loads():
    advice_text = validity.smoothing_remark([("rod-slider", 1.0)])
    source = yaml.safe_load(MOTOR)
    joint = source["joints"]["rod-slider"]
    joint |= {"length": "20 mm", "wear": {"law": "archard", "coefficient": "1e-16 m^2/N"}}
    stiff = {"contact": {"law": "flores", "restitution": 0.6}}
    joint["contact"] = stiff["contact"]
    given = [yaml.safe_load(text) for text in re.findall("`([^`]*)`", advice_text)]
    assert [next(iter(each)) for each in given] == ["contact", "wear"]
    for each in given:
        for section, keys in each.items():
            joint[section] |= keys
    del source["sweep"]
    assert clearsweep.load_case(source).layout.joints[0].wear_bins


def test_a_life_says_the_clearance_at_its_start():
    hours = Column(f"{PIN}_life_hours", "h", "", figure="life_hours", joint=PIN)
    known = Layout("planar", True, "", (JointLayout(PIN, 360),), (hours,), (), life=PIN)
    record = {"joints": {PIN: {"clearance": 45e-6}}}
    made = cases({hours.name: np.array([3.0, 9.0]), SPEED: [2, 1]}, (SPEED,), ranking_of(known, ()), record)
    made = made._replace(layout=known)
    assert any("The clearance at the start is 45.0" in said for said in answer.life_effect_sentences(made))
    assert not any("at the start" in said for said in answer.life_effect_sentences(made._replace(record={})))
