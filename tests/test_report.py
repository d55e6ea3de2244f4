"""The report says what a run contains, in units, in one file that needs nothing else."""

import csv
import html.parser
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections import defaultdict

import fake_physics
import numpy as np
import pytest
from fake_physics import sweep
from fake_runs import RPM, SWEEP, Run
from mechanism_cases import PAIR, changed
from right_grids import grid_of

import clearsweep
from clearsweep import grid, report, simulation, store
from clearsweep.answers.judged import variance_shares
from clearsweep.contracts import results
from clearsweep.grid.cases import nest
from clearsweep.grid.keys import Number
from clearsweep.grid.keys.key_table import table_of_keys
from clearsweep.language import quantity, wording
from clearsweep.language.errors import InputError
from clearsweep.report.blocks.section import Columns, Facts, page_script
from clearsweep.report.documents import page as single
from clearsweep.report.documents.page import case_to_draw
from clearsweep.report.effects import MatchedCases
from clearsweep.report.sections import cases
from clearsweep.report.sections.answer import law_range_remarks
from clearsweep.report.sections.setup import setup_sections
from clearsweep.report.study import CASE_SECTIONS, prepare
from clearsweep.sweeping.pool.case_runner import SIMULATION

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


@pytest.mark.few(*(name for name in RUNS if name not in LARGE))
@pytest.mark.parametrize("name", RUNS)
def test_page_is_whole_small_and_refers_to_nothing_outside(pages, name):
    text = pages(name).read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    assert len(page.ids) == len(set(page.ids))
    inner = {reference[1:] for reference in page.references if reference.startswith("#")}
    cases = {f"case-{case_id}" for case_id in Run(**RUNS[name]).summary["case_id"]}  # to which the explorer leads
    assert inner <= {*page.ids, *cases}
    assert all(reference.startswith(("#", "data:")) for reference in page.references)
    assert page.scripts in ([], [str(page_script().text)])
    assert bool(page.scripts) == bool(page.data) == ("script-src" in text)
    assert all(json.loads(data) for data in page.data)
    assert "@import" not in text
    assert len(text.encode()) < 3_000_000
    assert "nan" not in re.findall(r"[a-z]+", page.text.lower())
    for drawing in re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL):
        ET.fromstring(drawing)
    assert page.figures == text.count("<svg ")


@pytest.mark.few("impact pair")
@pytest.mark.parametrize("name", ["full", "impact pair"])
def test_same_run_gives_the_same_bytes(pages, tmp_path, name):
    again = report.write(Run(**RUNS[name]), tmp_path / "again.html")
    assert again.read_bytes() == pages(name).read_bytes()


def test_page_names_worst_case_and_drivers_with_units(pages):
    text = Page(pages("full").read_text(encoding="utf-8")).text
    assert "100 of 108" in text
    assert "Largest force peak: " in text
    assert "Force peak rises from" in text
    assert "crank speed 1000, 3000, 5000 rpm" in text
    assert "8 \u00d7 step-budget" in text
    assert "the step budget of 1000000 steps" in text
    assert "Every motion repeats every revolution, so its peaks recur." in text
    assert "largest wear" not in text
    assert "Deepest wear" in text


def test_page_shows_the_drawings_of_the_motion(pages):
    text = Page(pages("full").read_text(encoding="utf-8")).text
    for title in (
        "Journal orbit unrolled",
        "Slider position error",
        "Contact onsets",
        "Fastest wear, joint rod-slider",
        "Force peak: clearance \u00d7 crank speed",
    ):
        assert title in text
    assert text.count("Force peak: ") == 6  # every pair of four axes


@pytest.mark.slow
def test_long_tables_say_that_they_are_cut(pages):
    text = Page(pages("big").read_text(encoding="utf-8")).text
    assert "The first 50 of 10000 rows are shown" in text
    assert pages("big").read_text(encoding="utf-8").count("<tr>") < 400


def test_elastic_range_is_reported_with_figures():
    run = Run(strength=600e6)
    run.summary["rod_slider_yield_speed"] = 0.05
    (message,) = law_range_remarks(prepare(run))
    assert "in 108 of 108 cases" in message
    assert "the fastest approaches at 4.4 m/s, 88 times the 0.05 m/s" in message
    assert any(f"case {case_id[:8]}, rod-slider" in message for case_id in run.summary["case_id"])
    run.summary["rod_slider_yield_speed"] = 4.5
    assert law_range_remarks(prepare(run)) == []
    assert law_range_remarks(prepare(Run())) == []  # of unknown strength


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
    run.grid["labels"] = {"drive.speed": {f"{evil}{k}": speed for k, speed in enumerate(SWEEP["drive.speed"])}}
    page = report.write(run, tmp_path / "evil.html").read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert "&lt;script&gt;" in page
    read = Page(page)
    assert read.open == []
    assert read.scripts == [str(page_script().text)]
    explored = next(data for data in map(json.loads, read.data) if "columns" in data)
    assert evil in explored["columns"][0]["words"]


def test_values_that_a_case_does_not_use_are_left_out(tmp_path):
    law, restitution = "joints.rod-slider.contact.law", "joints.rod-slider.contact.restitution"
    run = Run(sweep={law: ["hertz", "flores"], restitution: [0.5, 0.9], "drive.speed": SWEEP["drive.speed"]})
    idle = (run.summary[law] == "hertz") & (run.summary[restitution] == 0.9)
    run.summary = run.summary[~idle].reset_index(drop=True)
    run.summary.loc[run.summary[law] == "hertz", restitution] = None
    given = prepare(run)
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


def test_a_state_and_a_page_load_only_what_they_read(tmp_path):
    fake_physics.sweep(fake_physics.grid(masses=2, wear=True), tmp_path / "run", executor="serial", show_progress=False)
    program = (
        "import pathlib, sys; from clearsweep import store; "
        "store.status(pathlib.Path({0!r})); print(*{1} & {{*sys.modules}}); "
        "from clearsweep import report; report.page_of(report.open({0!r})).text(); print(*{2} & {{*sys.modules}})"
    )
    for_pages = {"pandas", "scipy", "matplotlib", "ruamel.yaml"}
    program = program.format(str(tmp_path / "run"), for_pages | {"h5py"}, for_pages - {"ruamel.yaml"})
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_matched_cases_are_reduced_by_group_and_level():
    chance = np.random.default_rng(5)
    groups, rows, codes = chance.integers(0, 6, 40), chance.integers(0, 30, 40), chance.integers(-1, 3, 40)
    values = np.where(chance.random(30) < 0.3, np.nan, chance.random(30))
    table = MatchedCases(None, groups, rows, np.array([1.0, 2.0, 4.0]), codes).table(values)
    expected = {}
    for group in range(6):
        cells = [values[rows[(groups == group) & (codes == code)]] for code in range(3)]
        medians = [np.median(cell[np.isfinite(cell)]) if np.isfinite(cell).any() else np.nan for cell in cells]
        if np.isfinite(medians).sum() > 1:
            expected[group] = medians
    assert table.groups.tolist() == [*expected]
    np.testing.assert_array_equal(table.values, [*expected.values()])


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


def test_an_axis_that_does_nothing_explains_nothing():
    chance = np.random.default_rng(1)
    places = [np.repeat(np.arange(4), 12), np.tile(np.repeat(np.arange(3), 4), 4)]
    drawn = [variance_shares(np.exp(chance.normal(size=48)), places) for _ in range(200)]
    assert 0.0 <= np.array(drawn)[:, 0].mean() < 0.04


def test_a_weak_axis_is_seen_next_to_a_strong_one():
    chance = np.random.default_rng(1)
    strong, weak = np.repeat(np.arange(4), 12), np.tile(np.repeat(np.arange(3), 4), 4)
    values = np.exp(1.0 * strong + 0.2 * weak + 0.05 * chance.normal(size=48))
    most, least = variance_shares(values, [strong, weak])
    total = np.log(values).var()
    assert most == pytest.approx(1.25 / total, rel=0.05)  # the variance of 0, 1, 2, 3
    assert least == pytest.approx(0.04 * 2.0 / 3.0 / total, rel=0.3)


def test_without_two_cases_per_value_there_is_no_scatter_to_compare_with():
    (share,) = variance_shares(np.array([1.0, 2.0, 3.0]), [np.arange(3)])
    assert np.isnan(share)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
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
def test_quantities_read_like_an_engineer_writes_them(value, unit, text):
    assert wording.quantity_text(value, unit).replace("\u00a0", " ") == text


def test_swept_speeds_are_given_in_revolutions_per_minute():
    assert wording.scale("rad/s", [1000 * RPM, 5000 * RPM], speed=True).exact_text(3000 * RPM) == "3000\u00a0rpm"


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
    again = single.simulation.solve(case_to_draw(prepare(run), case_id))
    assert again.summary["rod_slider_force_peak"] == run.summary["rod_slider_force_peak"][0]
    assert len(again.t) > 1440
    assert report.show(run, case_id, tmp_path / "case.svg").stat().st_size > 10_000


def test_curves_without_the_force_peak_say_so():
    made = prepare(Run())
    case_id = made.cases.index[0]
    peak = made.cases.at(case_id, "rod_slider_force_peak")
    for share, remark in ((0.5, True), (0.95, False)):
        channels = {"joints/rod_slider/force_normal": np.array([0.0, share * peak])}
        text = cases.peak_note(made, case_id, channels)
        assert text.startswith("The curves do not contain the force peak") == remark
    assert cases.peak_note(made, case_id, {}) == ""


def test_show_refuses_what_it_cannot_draw(tmp_path):
    with pytest.raises(InputError, match=r"\.pdf.*\.html, \.png, \.svg"):
        report.show(Run(), "0" * 16, tmp_path / "case.pdf")
    with pytest.raises(InputError, match="no case '0000000000000000'"):
        report.show(Run(), "0" * 16, tmp_path / "case.png")


@pytest.mark.parametrize("ending", ["html", "csv"])
def test_show_says_why_there_is_nothing_to_draw(tmp_path, ending):
    """A crank that gravity stops has no history."""
    drive = {"torque": "1e-3 N*m", "initial_speed": "5 rpm"}
    grid = BASE | {"mechanism": BASE["mechanism"] | {"gravity": 9.81}, "drive": drive, "simulate": {"revolutions": 1}}
    clearsweep.sweep(grid | {"name": "stalled"}, out=tmp_path / "run", executor="serial", show_progress=False)
    run = store.open(tmp_path / "run")
    with pytest.raises(InputError, match="nothing to draw, the case ended with 'stalled': the drive stalls"):
        report.show(run, run.summary["case_id"][0], tmp_path / f"case.{ending}")


CATALOGUE = simulation.catalogue()
JOINT = "joints.rod-slider"
BASE = grid_of("a crank of a report")
LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹·", "-0123456789.")
STEEL = {"young": 207e9, "poisson": 0.3}


def shown(record) -> dict[str, str]:
    """Return dotted path -> what the page shows of the values that all cases share."""
    run = Run(sweep={}, histories=False, wear=False)
    run.grid = {key: value for key, value in run.grid.items() if key not in CASE_SECTIONS} | record
    (section,) = setup_sections(prepare(run))
    (columns,) = (block for block in section.blocks if isinstance(block, Columns))
    facts = next(block for block in columns.columns[0] if isinstance(block, Facts) and block.label == "Fixed values")
    return dict(facts.rows)


def resolved(contact, friction=None, axes=None):
    """Return the record of a slider-crank with these sections."""
    joint = BASE["joints"]["rod-slider"] | {"contact": contact} | ({"friction": friction} if friction else {})
    source = BASE | {"joints": {"rod-slider": joint}} | ({"sweep": axes} if axes else {})
    return grid.load(source, CATALOGUE).resolved()


def written(text: str) -> str:
    """Return a quantity as a person would write it in a grid: '2 N*s/m^1.5' for '2 N s/m¹·⁵'."""
    number, _, unit = text.partition("\u00a0")
    unit = re.sub(r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹·]+", lambda power: f"^{power[0].translate(LOWERED)}", unit)
    return f"{number} {unit}".replace("\u00a0", "*").strip()


NAMED = tuple(mechanism for mechanism in CATALOGUE.mechanisms if mechanism.joints)  # else a grid names its keys


@pytest.mark.few("slider-crank")
@pytest.mark.parametrize("mechanism", NAMED, ids=[mechanism.name for mechanism in NAMED])
def test_every_key_is_shown_in_the_unit_that_the_key_table_gives(mechanism):
    together = defaultdict(dict)  # depth of keys and words they depend on -> these keys, which one page can show
    for path, node in table_of_keys(mechanism, CATALOGUE).items():
        for use in node.uses if isinstance(node, Number) else ():
            words = tuple((chooser, min(names)) for chooser, names in use.when)
            together[path.count("."), words][path] = use.field.unit
    for (_, words), units in together.items():
        exponents = {f"{path.rpartition('.')[0]}.exponent": 2.5 for path in units if "^exponent" in units[path]}
        record = {"mechanism.type": mechanism.name} | dict.fromkeys(units, 2.0) | exponents | dict(words)
        texts = shown(nest(record, ()))
        for path in units.keys() - exponents.keys():
            unit = quantity.replace_exponent(units[path], 2.5)
            assert quantity.read(written(texts[path]), unit) == pytest.approx(2.0, rel=1e-5), (path, texts[path], unit)
    assert sum(map(len, together.values())) > 40


def test_a_stiffness_beside_a_swept_law_has_the_law_s_default_exponent():
    contact = {"law": "exact", "stiffness": 2e4, "restitution": 0.9}
    record = resolved(contact, axes={f"{JOINT}.contact.law": ["exact", "flores"]})
    assert grid.key_units(record, CATALOGUE)[f"{JOINT}.contact.stiffness"] == "N/m^1.5"


def test_a_value_that_laws_of_different_units_share_is_shown_with_both():
    contact = {"law": "ristow", "stiffness": 1e10, "damping": 100.0}
    record = resolved(contact, axes={f"{JOINT}.contact.law": ["ristow", "kuwabara-kono"]})
    assert grid.key_units(record, CATALOGUE)[f"{JOINT}.contact.damping"] == "N*s/m or N*s/m^1.5"


def test_a_swept_exponent_leaves_the_unit_open():
    record = resolved(BASE["joints"]["rod-slider"]["contact"], axes={f"{JOINT}.contact.exponent": [1.0, 1.5]})
    assert grid.key_units(record, CATALOGUE)[f"{JOINT}.contact.stiffness"] == "N/m^exponent"


def test_the_masses_of_a_pair_are_shown_in_kilograms():
    assert shown(grid.load(PAIR, CATALOGUE).resolved())["mechanism.masses"].count("kg") == 2


def test_laws_of_another_version_leave_their_values_bare_and_the_rest_in_units():
    record = changed(BASE, {f"{JOINT}.contact.law": "forgotten", f"{JOINT}.contact.gain": 3.0})
    facts = shown(record)
    assert facts[f"{JOINT}.contact.gain"] == "3"
    assert facts[f"{JOINT}.clearance"] == "0.1\u00a0mm"


@pytest.mark.parametrize("name", ["law_comparison", "two_joints", "impact_pair", "slider_crank", "thousand_cases"])
def test_swept_values_have_the_unit_that_the_grid_gives(name):
    cases = grid.load(f"configs/{name}.yaml", CATALOGUE)
    units = grid.key_units(cases.resolved(), CATALOGUE)
    assert {path: cases.unit(path) for path in cases.axes} == {path: units.get(path, "") for path in cases.axes}


class MadeUp(fake_physics.Fake):
    """Made-up results of any law there is."""

    catalogue = staticmethod(SIMULATION.catalogue)

    @staticmethod
    def derived(case):
        """Return nothing that follows from other values."""
        return {}


def test_values_of_a_stored_run_are_shown_in_the_units_that_they_are_taken_in(tmp_path):
    expected = {
        "mechanism.crank.length": "50 mm",
        "mechanism.crank.mass": "0.3 kg",
        "mechanism.crank.inertia": "0.0001 kg m²",
        "mechanism.rod.center": "60 mm",
        "drive.speed": "5000 rpm",
        "simulate.tolerance": "1 \u00d7 10⁻⁸",
        "simulate.revolutions": "10",
        f"{JOINT}.clearance": "0.5 mm",
        f"{JOINT}.contact.stiffness": "6.61 \u00d7 10¹⁰ N/m¹·⁵",
        f"{JOINT}.contact.damping": "120 N s/m¹·⁵",
        f"{JOINT}.friction.bristle_stiffness": "5000 1/m",
        f"{JOINT}.friction.bristle_damping": "316 s/m",
    }
    source = fake_physics.grid(1, orbits="none")
    contact = {"law": "kuwabara-kono", "stiffness": "6.61e10 N/m^1.5", "damping": 120.0}
    friction = {"law": "lugre", "coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 2e-3}
    friction |= {"bristle_stiffness": 5000.0, "bristle_damping": 316.0}
    source["joints"]["rod-slider"] |= {"contact": contact, "friction": friction}
    run = sweep(source, tmp_path / "run", executor="serial", show_progress=False, simulator=MadeUp).open()
    page = report.write(run, tmp_path / "page.html").read_text(encoding="utf-8").replace("\u00a0", " ")
    rows = dict(re.findall(r'<th scope="row">([^<]*)</th><td>([^<]*)</td>', page))
    assert {path: rows[path] for path in expected} == expected
