"""Wear in the report: what is drawn is what was stored, and trends are reported as the cases have them."""

import base64

import numpy as np
import pytest
from click.testing import CliRunner
from fake_runs import CONFIGS, RPM, Run
from matplotlib.figure import Figure

from clearsweep.cli import verbs
from clearsweep.contracts.results import Trajectory
from clearsweep.language.wording import TIMES
from clearsweep.report import section, sections, single, study, worn
from clearsweep.report.table import Table

CLEARANCE, STIFFNESS = "joints.rod-slider.clearance", "joints.rod-slider.contact.stiffness"
SWEEP = {CLEARANCE: [5e-5, 1e-4, 2e-4], STIFFNESS: [1e9, 1e10], "drive.speed": [1000 * RPM, 3000 * RPM]}


def drawn(picture):
    """Return the axes that a picture is painted on."""
    axes = Figure().subplots(subplot_kw={"projection": picture.projection})
    picture.paint(axes)
    return axes


def blocks(run, kind):
    return [
        block for part in sections.wear.sections(study.prepare(run)) for block in part.blocks if type(block) is kind
    ]


def test_depths_round_both_bodies_are_drawn_where_they_are_and_on_one_scale():
    run = Run(sweep=SWEEP)
    (deepest,) = blocks(run, section.Detail)
    assert deepest.case_id == run.summary.set_index("case_id")["rod_slider_wear_depth_max"].idxmax()
    stored = run.wear(deepest.case_id)["rod_slider"]
    bearing, journal, along = deepest.pictures
    assert (bearing.title, journal.title) == ("Bearing in the slider", "Journal on the rod")
    axes = [drawn(picture) for picture in (bearing, journal)]
    for ax, depth in zip(axes, stored, strict=True):
        pairs = depth.reshape(180, 2)  # bins of two degrees, the deeper of two
        angles, shown = ax.patches[0].get_xy()[:-1].T
        assert np.degrees(angles) == pytest.approx(np.arange(1.0, 360.0, 2.0))
        assert shown == pytest.approx(pairs.max(axis=1) * 1e9)
        mean, mark = ax.lines
        assert mean.get_ydata() == pytest.approx(depth.mean() * 1e9)
        assert mark.get_ydata() == pytest.approx(depth.max() * 1e9)
        assert np.degrees(mark.get_xdata()) == pytest.approx(depth.argmax() + 0.5)
    assert axes[0].get_ylim() == axes[1].get_ylim()
    for line, depth in zip(drawn(along).lines, stored, strict=True):
        assert line.get_ydata() == pytest.approx(depth.reshape(180, 2).max(axis=1) * 1e9)
    assert "deepest 3.00 nm at 0°" in bearing.caption.replace("\u00a0", " ")


def test_a_body_that_does_not_wear_has_no_circle_of_its_own():
    depth = np.linspace(0.0, 1e-6, 90)
    prepared = study.prepare(Run(sweep={}))
    joint, case_id = prepared.joints[0], prepared.cases.index[0]
    pictures = worn.pictures(prepared, joint, case_id, (depth, np.zeros(90)))
    assert [picture.title for picture in pictures] == ["Bearing in the slider", "Depth along the surface"]
    assert worn.pictures(prepared, joint, case_id, (np.zeros(90), np.zeros(90))) == []


def test_any_case_can_be_chosen_the_deepest_first():
    run = Run(sweep=SWEEP)
    (choice,) = blocks(run, section.Interactive)
    prepared = study.prepare(run)
    order = prepared.cases["rod_slider_wear_depth_max"].sort_values(ascending=False).index
    assert [case["name"].split(":")[0] for case in choice.data["cases"]] == [prepared.setting(each) for each in order]
    depths = run.wear(order[0])["rod_slider"]
    most = max(depth.max() for depth in depths)
    for place, depth in enumerate(depths):
        case = choice.data["cases"][0]
        shares = np.frombuffer(base64.b64decode(case["depths"][place]), np.uint8) / 255.0
        assert shares == pytest.approx(depth.reshape(120, 3).max(axis=1) / most, abs=0.501 / 255.0, rel=0.0)
        assert case["mean"][place] == pytest.approx(depth.mean() / most)
    assert blocks(Run(sweep={}), section.Interactive) == []  # of one case there is nothing to choose


def test_pressure_and_wear_are_mapped_over_the_axes_that_move_them():
    run = Run(sweep=SWEEP)
    frame = run.summary
    frame["rod_slider_pressure_peak"] = 1e6 * frame[CLEARANCE] / 5e-5 * frame[STIFFNESS] / 1e9
    frame["rod_slider_pv_peak"] = 2e6  # the same everywhere: nothing to map
    (gallery,) = blocks(run, section.Gallery)
    titles = {picture.title: picture for picture in gallery.pictures}
    pressure = f"Pressure peak: clearance {TIMES} stiffness"
    assert list(titles) == [f"Wear depth per 1000 h: clearance {TIMES} crank speed", pressure]
    mesh = drawn(titles[pressure]).collections[0]
    assert np.asarray(mesh.get_array()).reshape(2, 3) == pytest.approx(np.outer([1.0, 10.0], [1.0, 2.0, 4.0]))
    (line,) = blocks(Run(sweep={CLEARANCE: SWEEP[CLEARANCE]}), section.Gallery)
    assert [picture.title for picture in line.pictures] == ["Wear depth per 1000 h over clearance"]


def answers(run):
    """Return (what is said, rows of the table) of the trends of a run."""
    (part,) = sections.trends.sections(study.prepare(run))
    said = next(block for block in part.blocks if isinstance(block, section.Points)).texts
    table = next(block for block in part.blocks if isinstance(block, Table))
    return said, {row[0]: row for row in table.rows}


def with_depths(depth):
    """Return a run whose depths are those of a formula of clearance, stiffness and speed."""
    run = Run(sweep=SWEEP)
    frame = run.summary
    frame["rod_slider_wear_depth_max"] = depth(frame[CLEARANCE], frame[STIFFNESS], frame["drive.speed"])
    return run


def test_trends_that_are_there_are_shown_with_their_size_and_others_contradicted():
    said, rows = answers(with_depths(lambda c, k, v: 1e-9 * c**0.5 * v**2 * k**-0.3))
    assert said == [
        "Shown: deeper with larger clearance, deeper with higher crank speed, deeper with lower stiffness, uneven "
        "round the bearing and uneven round the journal."
    ]
    assert rows["deeper with larger clearance"][4:7] == pytest.approx((2**0.5,) * 3)
    assert rows["deeper with higher crank speed"][4:7] == pytest.approx((4.0,) * 3)
    assert rows["deeper with lower stiffness"][4:7] == pytest.approx((2**-0.3,) * 3)
    said, _ = answers(with_depths(lambda c, k, v: 1e-9 * c**-0.5 * v * k**0.3))
    assert said[1] == "Contradicted: deeper with larger clearance and deeper with lower stiffness."


def test_a_trend_that_chance_may_have_made_is_not_decided():
    chance = np.random.default_rng(2)
    said, rows = answers(with_depths(lambda c, k, v: 1e-9 * v * chance.lognormal(0.0, 0.2, len(c))))
    assert said[-1] == "Not decided: deeper with larger clearance and deeper with lower stiffness."
    assert rows["deeper with larger clearance"][5] < 1.0 < rows["deeper with larger clearance"][6]


def test_of_what_is_not_swept_nothing_is_said_and_of_one_case_nothing_decided():
    said, rows = answers(Run(sweep={}))
    assert list(rows) == ["uneven round the bearing", "uneven round the journal"]
    assert said == ["Not decided: uneven round the bearing and uneven round the journal."]
    assert sections.trends.sections(study.prepare(Run(wear=False))) == []


def test_an_even_wear_is_told_from_an_uneven_one(monkeypatch):
    run = Run(sweep=SWEEP)
    even = {"rod_slider": (np.full(360, 1e-9), 1e-9 * (1.2 + np.sin(np.radians(np.arange(360)))))}
    monkeypatch.setattr(run, "wear", lambda case_id: even)
    _, rows = answers(run)
    assert rows["uneven round the bearing"][2:4] == ("contradicted", "deepest over mean depth")
    assert rows["uneven round the bearing"][4:7] == pytest.approx((1.0, 1.0, 1.0))
    assert rows["uneven round the journal"][4] == pytest.approx(2.2 / 1.2)
    assert rows["uneven round the journal"][2] == "shown"


def test_a_case_that_is_shown_by_itself_shows_its_wear():
    run = Run(sweep=SWEEP)
    case_id = run.summary["case_id"].iloc[0]
    path = {name: values.to_numpy() for name, values in run.orbit(case_id).items()}
    result = Trajectory("ok", "", {}, path, wear=run.wear(case_id))
    titles = [picture.title for picture in single.drawn(study.prepare(run), case_id, result)]
    assert titles[-3:] == ["Bearing in the slider", "Journal on the rod", "Depth along the surface"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["worn_slider_crank", "wear_trends", "ptfe_bushing", "press_life"])
def test_a_ready_study_of_wear_is_looked_over_by_a_dry_run(name):
    result = CliRunner().invoke(verbs, ["run", str(CONFIGS / f"{name}.yaml"), "--dry-run"])
    assert result.exit_code == 0, result.output
    assert "to run" in result.output


def living():
    """Return a run whose joint grows evenly by 50 um, the faster the larger its clearance."""
    run = Run(sweep=SWEEP)
    frame = run.summary
    turns = 1e6 * 5e-5 / frame[CLEARANCE]
    run.layout = run.layout._replace(life="rod_slider")
    run.grid["life"] = {"limit": 5e-5, "of": "clearance_growth", "joint": "rod-slider"}
    for name, values in {"revolutions": turns, "hours": turns / 6e4, "low": 0.9 * turns, "high": 1.2 * turns}.items():
        frame[f"rod_slider_life_{name}"] = values
        frame.attrs["units"][f"rod_slider_life_{name}"] = "h" if name == "hours" else "1"

    def history(case_id):
        case = frame.set_index("case_id").loc[case_id]
        at = np.linspace(0.0, 1.0, 5)
        return {
            "revolutions": at * case["rod_slider_life_revolutions"],
            "rod_slider/wear_depth_max": 4e-5 * at,
            "rod_slider/clearance": case[CLEARANCE] + 5e-5 * at,
            "rod_slider/force_peak": 1e3 * (1.0 + at),
        }

    run.history = history
    return run


def test_lives_are_told_mapped_and_drawn_with_their_intervals():
    (part,) = sections.life.sections(study.prepare(living()))
    points, gallery = part.blocks
    said = [text.replace("\u00a0", " ").replace("\u2009", "") for text in points.texts]
    assert said[0].startswith(
        "Shortest life until the growth of the clearance in joint rod-slider is 50.0 µm: 4.17 h "
        "(95 %, numerics alone: 3.75 h to 5.00 h), 250000 revolutions, at clearance 0.2 mm"
    )
    assert said[1].startswith("Longest life")
    assert "16.7 h" in said[1]
    mapped, depth, growth, force = gallery.pictures
    assert "Life" in mapped.title
    shortest, bar, median = drawn(growth).lines[:3]
    assert shortest.get_ydata() == pytest.approx([0.0, 12.5, 25.0, 37.5, 50.0])
    assert shortest.get_xdata() == pytest.approx(np.linspace(0.0, 0.25, 5))  # millions
    assert bar.get_xdata() == pytest.approx([0.225, 0.3])
    assert median.get_xdata()[-1] > 0.25
    assert drawn(depth).lines[0].get_ydata()[-1] == pytest.approx(40.0)
    assert drawn(force).lines[0].get_ydata() == pytest.approx([1.0, 1.25, 1.5, 1.75, 2.0])


def test_a_life_without_an_end_says_so_and_runs_without_a_life_say_nothing():
    run = living()
    run.summary.loc[0, ["rod_slider_life_hours", "rod_slider_life_high"]] = np.nan
    (part,) = sections.life.sections(study.prepare(run))
    assert part.blocks[0].texts[-1].startswith("1 case did not come to the limit")
    assert sections.life.sections(study.prepare(Run(sweep=SWEEP))) == []
