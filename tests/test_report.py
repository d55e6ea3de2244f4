"""The report says what a run contains, in units, in one file that needs nothing else."""

import csv
import html.parser
import json
import re
import xml.etree.ElementTree as ET

import fake_physics
import numpy as np
import pytest
from fake_runs import RPM, SWEEP, Run

import clearsweep
from clearsweep import report, store
from clearsweep.contracts import results
from clearsweep.language import wording
from clearsweep.language.errors import InputError
from clearsweep.report import interactive, main_effects, single, study
from clearsweep.report.sections import headline

pytestmark = pytest.mark.heavy

BIG = {
    "joints.rod-slider.clearance": list(np.geomspace(5e-5, 5e-4, 25)),
    "joints.rod-slider.contact.stiffness": list(np.geomspace(1e9, 1e11, 4)),
    "joints.rod-slider.contact.restitution": list(np.linspace(0.5, 0.95, 10)),
    "drive.speed": list(np.linspace(1000, 5000, 10) * RPM),
}
RUNS = {
    "full": {"failures": 8},
    "one case": {"sweep": {}},
    "one axis": {"sweep": {"drive.speed": SWEEP["drive.speed"]}, "wear": False},
    "law names": {"sweep": {"joints.rod-slider.contact.law": ["hertz", "flores"], "drive.speed": SWEEP["drive.speed"]}},
    "no histories": {"histories": False, "wear": False},
    "all failed": {"failures": 108},
    "impact pair": {"sweep": {}, "joints": ("pair",), "mechanism": "impact-pair", "wear": False},
    "three joints": {"joints": ("ground_crank", "crank_rod", "rod_slider")},
    "swept pair": {
        "sweep": {"joints.pair.clearance": [1e-4, 5e-4], "joints.pair.contact.restitution": [0.5, 0.7, 0.9]},
        "joints": ("pair",),
        "mechanism": "impact-pair",
        "wear": False,
    },
    "big": {"sweep": BIG},
}
VOID = {"meta", "link", "br", "img", "input", "hr"}


class Page(html.parser.HTMLParser):
    """What a test wants to know of a page: ids, references, text, scripts, and whether every element is closed."""

    def __init__(self, text: str):
        super().__init__()
        self.ids, self.references, self.open, self.texts, self.figures = [], [], [], [], 0
        self.scripts, self.data = [], []  # those that run, those that only hold data
        self.feed(text)
        self.text = " ".join("".join(self.texts).split()).replace("\u00a0", " ")

    def handle_starttag(self, tag, attributes):
        """Take in one element."""
        values = dict(attributes)
        self.figures += tag == "svg" and values.get("role") in ("img", "group") and bool(values.get("aria-label"))
        self.ids += [values["id"]] if "id" in values else []
        self.references += [value for name, value in attributes if name in ("href", "src", "xlink:href", "srcset")]
        self.references += re.findall(r"url\(([^)]*)\)", " ".join(value or "" for _, value in attributes))
        if tag == "script":
            (self.data if values.get("type") == "application/json" else self.scripts).append("")
            self.written = self.data if values.get("type") == "application/json" else self.scripts
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        """Take in an element that closes itself."""
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        """Check that it closes the element opened last."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Collect text outside the style sheet, scripts apart."""
        if "script" in self.open:
            self.written[-1] += data
        elif "style" not in self.open:
            self.texts.append(data)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Return name -> path of the page of each run, written when it is first asked for."""
    directory, written = tmp_path_factory.mktemp("report"), {}

    def page(name):
        if name not in written:
            written[name] = report.write(Run(**RUNS[name]), directory / f"{name}.html")
        return written[name]

    return page


LARGE = ("three joints", "big")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in LARGE else name for name in RUNS]
)
def test_page_is_whole_small_and_refers_to_nothing_outside(pages, name):
    text = pages(name).read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))
    inner = {reference[1:] for reference in page.references if reference.startswith("#")}
    cases = {f"case-{case_id}" for case_id in Run(**RUNS[name]).summary["case_id"]}  # to which the explorer leads
    assert inner <= {*page.ids, *cases}
    assert all(reference.startswith(("#", "data:")) for reference in page.references)
    assert page.scripts in ([], [str(interactive.script().text)])
    assert bool(page.scripts) == bool(page.data) == ("script-src" in text)
    assert all(json.loads(data) for data in page.data)
    assert "@import" not in text
    assert len(text.encode()) < 3_000_000
    assert "nan" not in re.findall(r"[a-z]+", page.text.lower())
    for drawing in re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL):
        ET.fromstring(drawing)
    assert page.figures == text.count("<svg ")


@pytest.mark.parametrize("name", [pytest.param("full", marks=pytest.mark.slow), "impact pair"])
def test_same_run_gives_the_same_bytes(pages, tmp_path, name):
    again = report.write(Run(**RUNS[name]), tmp_path / "again.html")
    assert again.read_bytes() == pages(name).read_bytes()


def test_page_names_worst_case_and_drivers_with_units(pages):
    text = Page(pages("full").read_text(encoding="utf-8")).text
    assert "100 of 108" in text
    assert "Worst case at clearance 0.5 mm" in text
    assert "What drives the force peak, strongest first: crank speed" in text
    assert "crank speed 1000, 3000, 5000 rpm" in text
    assert "8 \u00d7 step-budget" in text
    assert "the step budget of 1000000 steps" in text
    assert "All motions repeat themselves (revolutions: 100 after 1)" in text
    assert "largest wear" not in text
    assert "Deepest wear" in text


def test_page_shows_the_drawings_of_the_motion(pages):
    text = Page(pages("full").read_text(encoding="utf-8")).text
    for title in (
        "Journal orbit unrolled",
        "Slider position error",
        "Contact onsets",
        "Deepest wear, joint rod-slider",
        "Force peak: clearance \u00d7 crank speed",
    ):
        assert title in text
    assert text.count("Force peak: ") == 6  # every pair of four axes


@pytest.mark.slow
def test_long_tables_say_that_they_are_cut(pages):
    text = Page(pages("big").read_text(encoding="utf-8")).text
    assert "The first 50 of 10000 rows are shown" in text
    assert pages("big").read_text(encoding="utf-8").count("<tr>") < 400


def test_elastic_range_is_told_with_figures():
    run = Run(strength=600e6)
    run.summary["rod_slider_yield_speed"] = 0.05
    (message,) = headline.limits(study.prepare(run))
    assert "in 108 of 108 cases" in message
    assert "the worst closes at 4.4 m/s, 88 times the 0.05 m/s" in message
    assert any(f"case {case_id[:8]}, rod-slider" in message for case_id in run.summary["case_id"])
    run.summary["rod_slider_yield_speed"] = 4.5
    assert headline.limits(study.prepare(run)) == []
    assert headline.limits(study.prepare(Run())) == []  # of unknown strength


def test_runs_without_slider_wear_or_history_do_not_speak_of_them(pages):
    pair = Page(pages("impact pair").read_text(encoding="utf-8")).text
    assert "restitution" in pair
    assert "slider" not in pair.replace("slider-crank-clearance", "")
    assert "Wear" not in pair
    bare = Page(pages("no histories").read_text(encoding="utf-8")).text
    assert "Wear" not in bare
    assert "Journal orbit" not in bare
    assert "clearsweep show" in bare
    failed = Page(pages("all failed").read_text(encoding="utf-8")).text
    assert "None of the 108 cases finished" in failed


def test_text_of_the_grid_is_escaped(tmp_path):
    evil = "<script>alert(1)</script>&\"'"
    run = Run(
        sweep={"joints.rod-slider.contact.law": [evil, "hertz"], "drive.speed": SWEEP["drive.speed"]},
        name=evil,
        failures=2,
    )
    run.summary["message"] = evil
    run.grid["source"] = evil
    page = report.write(run, tmp_path / "evil.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "&lt;script&gt;" in page
    read = Page(page)
    assert read.open == []
    assert read.scripts == [str(interactive.script().text)]
    explored = next(data for data in map(json.loads, read.data) if "columns" in data)
    assert evil in explored["columns"][0]["words"]


def test_values_that_a_case_does_not_use_are_left_out(tmp_path):
    law, restitution = "joints.rod-slider.contact.law", "joints.rod-slider.contact.restitution"
    run = Run(sweep={law: ["hertz", "flores"], restitution: [0.5, 0.9], "drive.speed": SWEEP["drive.speed"]})
    idle = (run.summary[law] == "hertz") & (run.summary[restitution] == 0.9)
    run.summary = run.summary[~idle].reset_index(drop=True)
    run.summary.loc[run.summary[law] == "hertz", restitution] = None
    given = study.prepare(run)
    hertz = given.cases.index[given.cases[law] == "hertz"][0]
    assert given.setting(hertz).startswith("contact law hertz, crank speed")
    assert given.value(hertz, restitution) is None
    assert Page(report.write(run, tmp_path / "ragged.html").read_text(encoding="utf-8")).open == []


def test_stored_run_is_read_as_the_store_hands_it_out(tmp_path):
    grid = fake_physics.grid(masses=3, gravities=(fake_physics.GOOD, fake_physics.FAILS), wear=True)
    fake_physics.sweep(grid, tmp_path / "run", executor="serial", show_progress=False)
    run = store.open(tmp_path / "run")
    text = Page(report.write(run, tmp_path / "run.html").read_text(encoding="utf-8")).text
    assert "3 of 6" in text
    assert "the step budget was used up" in text
    assert "Journal orbit" in text
    assert len(report.tables(run, tmp_path / "tables")) >= 5


def test_tables_hold_every_case_in_si_with_units(tmp_path):
    run = Run(failures=8)
    files = report.tables(run, tmp_path / "tables")
    assert {file.with_suffix(".md") for file in files} <= {*files}
    assert sorted(file.name for file in files if file.suffix == ".csv") == [
        "by_speed.csv",
        "certainty.csv",
        "effects.csv",
        "failed.csv",
        "kinds_of_motion.csv",
        "peaks_rod_slider.csv",
        "slider.csv",
        "wear_rod_slider.csv",
        "wear_trends.csv",
    ]
    rows = list(csv.DictReader((tmp_path / "tables/peaks_rod_slider.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 100
    summary = run.summary.set_index("case_id")
    for row in rows:
        assert float(row["force p99 [N]"]) == summary.at[row["case_id"], "rod_slider_force_p99"]
        assert float(row["clearance [m]"]) == summary.at[row["case_id"], "joints.rod-slider.clearance"]
    peaks = [float(row["force peak [N]"]) for row in rows]
    assert peaks == sorted(peaks, reverse=True)
    failed = list(csv.DictReader((tmp_path / "tables/failed.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["status"] for row in failed} == {"step-budget"}


def test_an_axis_that_does_nothing_explains_nothing_and_is_not_clear():
    chance = np.random.default_rng(1)
    places = [np.repeat(np.arange(4), 12), np.tile(np.repeat(np.arange(3), 4), 4)]
    drawn = [main_effects.explained(np.exp(chance.normal(size=48)), places) for _ in range(200)]
    shares, contrasts = np.array(drawn)[:, 0, 0], np.array(drawn)[:, 0, 1]
    assert 0.0 <= shares.mean() < 0.04
    assert (contrasts >= main_effects.CLEAR_CONTRAST).mean() < 0.05


def test_a_weak_axis_is_seen_beside_a_strong_one():
    chance = np.random.default_rng(1)
    strong, weak = np.repeat(np.arange(4), 12), np.tile(np.repeat(np.arange(3), 4), 4)
    values = np.exp(1.0 * strong + 0.2 * weak + 0.05 * chance.normal(size=48))
    (most, _), (least, contrast) = main_effects.explained(values, [strong, weak])
    total = np.log(values).var()
    assert most == pytest.approx(1.25 / total, rel=0.05)  # the variance of 0, 1, 2, 3
    assert least == pytest.approx(0.04 * 2.0 / 3.0 / total, rel=0.3)
    assert contrast > 20.0


def test_without_two_cases_per_value_there_is_no_scatter_to_compare_with():
    share, contrast = main_effects.explained(np.array([1.0, 2.0, 3.0]), [np.arange(3)])[0]
    assert np.isnan(share)
    assert np.isnan(contrast)


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (0.0005, "m", "0.500 mm"),
        (7.8e-5, "m", "78.0 µm"),
        (45871.65, "N", "45.9 kN"),
        (3.27e5, "m/s^2", "327 km/s²"),
        (4.3857831, "m/s", "4.39 m/s"),
        (2.3e-8, "m/s", "23.0 nm/s"),
        (0.0, "N", "0 N"),
        (None, "N", "\u2013"),
        (0.25, "1", "0.250"),
        (6.61e10, "N/m^1.5", "6.61 \u00d7 10¹⁰ N/m¹·⁵"),
        (2e-14, "m^2/N", "2.00 \u00d7 10⁻¹⁴ m²/N"),
        (4e-13, "m^3", "400 \u00d7 10³ µm³"),
    ],
)
def test_quantities_read_like_an_engineer_writes_them(value, unit, said):
    assert wording.text(value, unit).replace("\u00a0", " ") == said


def test_swept_speeds_are_given_in_revolutions_per_minute():
    assert wording.scale("rad/s", [1000 * RPM, 5000 * RPM], speed=True).given(3000 * RPM) == "3000\u00a0rpm"


def _trajectory(run):
    channels = {name: np.asarray(values) for name, values in run.orbit(run.summary["case_id"][0]).items()}
    table = run.events("")
    events = np.zeros(len(table), results.EVENT_DTYPE)
    for name in results.EVENT_DTYPE.names:
        events[name] = table[name]
    return results.Trajectory("ok", "", {"rod_slider_force_p99": 1e4}, channels, events)


@pytest.mark.parametrize("ending", ["png", "svg", "html"])
def test_one_case_is_simulated_again_and_drawn(monkeypatch, tmp_path, ending):
    run, asked = Run(), []
    monkeypatch.setattr(single.simulation, "solve", lambda case: asked.append(case) or _trajectory(run))
    case_id = run.summary["case_id"][5]
    out = report.show(run, case_id, tmp_path / "deep" / f"case.{ending}")
    assert out.stat().st_size > 10_000
    row = run.summary.set_index("case_id").loc[case_id]
    (case,) = asked
    assert case.joints[0].clearance == row["joints.rod-slider.clearance"]
    assert case.joints[0].contact.values["stiffness"] == row["joints.rod-slider.contact.stiffness"]
    assert case.save.orbits == "last"
    assert "sweep" not in case
    if ending != "png":
        assert "Contact onsets" in out.read_text(encoding="utf-8")


@pytest.mark.slow
def test_shown_case_is_the_one_that_was_stored(tmp_path):
    contact = {"law": "lankarani-nikravesh", "stiffness": "1e10 N/m^1.5", "restitution": 0.7}
    joint = {"clearance": "0.2 mm", "bearing_radius": "10 mm", "contact": contact}
    grid = {
        "name": "shown",
        "mechanism": fake_physics.BODIES,
        "drive": {"speed": "3000 rpm"},
        "joints": {"rod-slider": joint},
        "simulate": {"revolutions": 2, "discard": 1},
        "save": {"orbits": "none"},
        "sweep": {"joints.rod-slider.clearance": ["0.1 mm", "0.2 mm"]},
    }
    clearsweep.sweep(grid, out=tmp_path / "run", executor="serial", show_progress=False)
    run = store.open(tmp_path / "run")
    case_id = run.summary["case_id"][0]
    again = single.simulation.solve(single.to_draw(study.prepare(run), case_id))
    assert again.summary["rod_slider_force_peak"] == run.summary["rod_slider_force_peak"][0]
    assert len(again.t) > 1440
    assert report.show(run, case_id, tmp_path / "case.svg").stat().st_size > 10_000


def test_show_refuses_what_it_cannot_draw(tmp_path):
    with pytest.raises(InputError, match=r"\.pdf.*\.html, \.png, \.svg"):
        report.show(Run(), "0" * 16, tmp_path / "case.pdf")
    with pytest.raises(InputError, match="no case '0000000000000000'"):
        report.show(Run(), "0" * 16, tmp_path / "case.png")
