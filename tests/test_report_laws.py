"""The report shows what the choice of a law does: spread between laws, restitution given back, elastic forces."""

import csv
import re

import numpy as np
import pytest
from fake_runs import RPM, Run
from mechanism_cases import PAIR, changed
from test_report import Page

from clearsweep import grid, report, simulation
from clearsweep.contracts.case import Contact, Joint, Material, Materials
from clearsweep.judging import verdict
from clearsweep.report import elastic_comparison, study
from clearsweep.report.picture import svg
from clearsweep.report.section import Gallery, Sentences
from clearsweep.report.sections import elastic_laws, law_choice
from clearsweep.sweeping import sweep
from clearsweep.sweeping.simulator import SIMULATION

pytestmark = pytest.mark.heavy

JOINT = "joints.rod-slider"
LAW, ELASTIC, RESTITUTION = f"{JOINT}.contact.law", f"{JOINT}.contact.elastic", f"{JOINT}.contact.restitution"
SPEEDS = {"drive.speed": [1000 * RPM, 2000 * RPM, 3000 * RPM]}
STEEL = {"law": "exact", "material": {"young": 207e9, "poisson": 0.3}, "thickness": 5e-3, "restitution": 0.7}
PEAK = "rod_slider_force_peak"


def of_laws(more=SPEEDS):
    """Return a run over two laws whose force peaks differ by 3, at the highest speed by 6, and by nothing else."""
    run = Run(sweep={LAW: ["lankarani-nikravesh", "exact"], **more}, histories=False, wear=False)
    run.summary[PEAK] = 100.0 * run.summary["drive.speed"]
    factor = np.where(run.summary["drive.speed"] == max(SPEEDS["drive.speed"]), 6.0, 3.0)
    run.summary[PEAK] *= np.where(run.summary[LAW] == "exact", factor, 1.0)
    return run


def of_elastic(names, contact=STEEL):
    """Return a run over elastic laws of a steel joint; over none the law is `power`."""
    run = Run(sweep={ELASTIC: names} if names else {}, histories=False, wear=False)
    run.grid["joints"]["rod-slider"]["contact"] = dict(contact)
    return run


def of_choice(run):
    """Return the sections about the choice of a law."""
    given = study.prepare(run)
    return [*law_choice.sections(given), *elastic_laws.sections(given)]


def blocks(run, kind):
    """Return the blocks of one kind in the first section about the choice of a law."""
    return [block for block in of_choice(run)[0].blocks if isinstance(block, kind)]


def tables(run):
    return [table for section in of_choice(run) for table in section.tables]


def table(run, key):
    return next(table for table in tables(run) if table.key.endswith(key))


def text(run, tmp_path):
    return Page(report.write(run, tmp_path / "page.html").read_text(encoding="utf-8")).text


def test_spread_is_taken_between_cases_that_differ_in_the_law_alone():
    spread = table(of_laws(), "contact_law_spread")
    figure, joint, count, median, largest, low, weakest, high, strongest, at = spread.rows[0]
    assert (figure, joint, count.value) == ("force peak", "rod-slider", 3)
    assert (median, largest) == (pytest.approx(3.0), pytest.approx(6.0))
    assert (weakest, strongest, at) == ("lankarani-nikravesh", "exact", "crank speed 3000\u00a0rpm")
    assert high.value / low.value == pytest.approx(6.0)


def test_a_law_is_measured_against_the_others_at_equal_values():
    rows = {row[0]: row for row in table(of_laws(), "contact_law_rod_slider").rows}
    assert rows["exact"][5] == pytest.approx(3.0 / 2.0)  # median of 2 values: their mean
    assert rows["lankarani-nikravesh"][5] == pytest.approx(1.0 / 2.0)


def test_a_failed_case_leaves_its_comparison_out():
    run = of_laws()
    fastest = run.summary["drive.speed"] == max(SPEEDS["drive.speed"])
    run.summary.loc[fastest & (run.summary[LAW] == "exact"), ["status", PEAK]] = ["step-budget", None]
    row = table(run, "contact_law_spread").rows[0]
    assert row[2].value == 2
    assert row[4] == pytest.approx(3.0)


def test_a_law_without_a_swept_value_stands_beside_all_of_its_values():
    run = Run(sweep={LAW: ["hertz", "exact"], RESTITUTION: [0.5, 0.9], **SPEEDS})
    idle = (run.summary[LAW] == "hertz") & (run.summary[RESTITUTION] == 0.9)
    run.summary = run.summary[~idle].reset_index(drop=True)
    run.summary.loc[run.summary[LAW] == "hertz", RESTITUTION] = None
    row = table(run, "contact_law_spread").rows[0]
    assert row[2].value == 6
    given = {row[0]: row[1:3] for row in table(run, "restitution").rows if row[0] == "hertz"}
    assert np.isnan(given["hertz"][0])
    assert given["hertz"][1] == 1.0


def test_laws_that_never_meet_at_equal_values_are_not_compared():
    run = of_laws()
    run.grid["zip"] = run.grid.pop("sweep")
    run.summary = run.summary[(run.summary[LAW] == "exact") == (run.summary["drive.speed"] > 200.0)]
    run.summary = run.summary.reset_index(drop=True)
    assert "No two finished cases differ in the contact law alone" in blocks(run, Sentences)[0].texts[0]
    assert not any(first.key.endswith("spread") for first in tables(run))


def test_restitution_asked_for_stands_beside_what_each_law_gives_back(tmp_path):
    run = of_laws({RESTITUTION: [0.5, 0.9], **SPEEDS})
    rows = {row[:2]: row[2] for row in table(run, "restitution").rows}
    assert rows["lankarani-nikravesh", 0.5] == pytest.approx(0.7252, abs=5e-5)
    assert rows["lankarani-nikravesh", 0.9] == pytest.approx(0.9132, abs=5e-5)
    assert rows["exact", 0.5] == pytest.approx(0.5, abs=1e-9)
    assert "Asked for a restitution of 0.5, a free impact gives back 0.500 (exact) to 0.725 (lankarani-" in text(
        run, tmp_path
    )


def test_an_impact_pair_measures_what_its_laws_give_back():
    path = "joints.pair.contact.law"
    names = ["lankarani-nikravesh", "exact"]
    run = Run(sweep={path: names}, joints=("pair",), mechanism="impact-pair", wear=False)
    pair = changed(PAIR, {"joints.pair.contact.restitution": 0.9, "sweep": {path: names}})
    run.grid |= grid.load(pair, simulation.catalogue()).resolved()
    run.summary["pair_restitution"] = np.where(run.summary[path] == "exact", 0.9, 0.91)
    rows = {row[0]: row for row in table(run, "restitution").rows}
    assert (rows["exact"][-1], rows["lankarani-nikravesh"][-1]) == (0.9, 0.91)


def test_the_choice_of_the_elastic_law_moves_the_force_fourteenfold(tmp_path):
    run = of_elastic(["winkler", "power", "johnson"])
    message = text(run, tmp_path)
    assert (
        "At a penetration of 1 µm these elastic laws differ by a factor of 14.2: 66.1 N (power) to 939 N "
        "(winkler); by 30.2 at 0.1 µm"
    ) in message
    assert "elastic law winkler, power, johnson" in message
    rows = {row[0]: row for row in table(run, "elastic_force_rod_slider").rows}
    assert rows["johnson"][2:7] == pytest.approx((63.068, 814.618, 5158.36, 11700.0, 27138.3), rel=1e-4)
    assert rows["johnson"][8] == pytest.approx(0.1991e-3, rel=1e-3)
    assert np.isnan(rows["power"][8])


def test_a_material_shows_what_other_elastic_laws_would_give(tmp_path):
    run = of_elastic([], {**STEEL, "elastic": "johnson"})
    del run.grid["joints"]["rod-slider"]["contact"]["thickness"]
    rows = {row[0]: row for row in table(run, "elastic_force_rod_slider").rows}
    assert rows["johnson"][1] == "yes"
    assert not any(row[1] for law, row in rows.items() if law != "johnson")
    assert "winkler" not in rows  # nothing says how thick its layer would be
    assert "What another elastic law would give in joint rod-slider" in text(run, tmp_path)
    assert of_choice(Run()) == []  # no material, no law swept


ROUGH = {"law": "fractal", "dimension": 1.5, "scale": 1e-11, "hardness": 5.5e9}


def of_rough(laws):
    """Return a run over roughness laws of a steel joint, of which over none the law is `fractal`."""
    path = f"{JOINT}.roughness.law"
    run = of_elastic([], {**STEEL, "elastic": "johnson"})
    del run.grid["joints"]["rod-slider"]["contact"]["thickness"]
    swept = Run(sweep={path: laws} if laws else {}, histories=False, wear=False)
    swept.grid["joints"] = run.grid["joints"]
    swept.grid["joints"]["rod-slider"]["roughness"] = dict(ROUGH)
    return swept


def test_rough_surfaces_stand_beside_smooth_ones(tmp_path):
    run = of_rough(["smooth", "fractal", "kogut-etsion"])
    rows = {row[0]: row for row in table(run, "elastic_force_rod_slider").rows}
    assert rows["smooth"][3] == pytest.approx(814.618, rel=1e-4)
    assert rows["kogut-etsion"][3] < rows["fractal"][3] < rows["smooth"][3]
    assert "What the choice of roughness law does" in text(run, tmp_path)


def test_a_rough_joint_shows_other_elastic_laws_and_surfaces():
    rows = {row[0]: row for row in table(of_rough([]), "elastic_force_rod_slider").rows}
    assert rows["johnson with fractal roughness"][1] == "yes"
    assert rows["johnson with fractal roughness"][3] < rows["johnson"][3]
    assert {"johnson with kogut-etsion roughness", "compatible with fractal roughness"} <= set(rows)


def test_the_other_elastic_laws_are_those_that_a_grid_with_this_joint_may_name():
    steel = Material(207e9, 0.3)
    contact = Contact("exact", "power", {"exponent": 1.5, "restitution": 0.7}, Materials(steel, steel))
    joint = Joint("rod-slider", clearance=2e-6, contact=contact, bearing_radius=0.01)
    without_length = {"power", "lankarani-nikravesh-cylindrical", "bai-zhao-literal"}
    assert set(simulation.elastic_choices(joint)) == without_length
    allowed = set(simulation.elastic_choices(joint._replace(length=0.02)))
    assert "johnson" in allowed
    assert "pereira" not in allowed  # fitted to clearances from 5 µm on
    spring = Contact("kelvin-voigt", None, {"stiffness": 1e9, "damping": 1.0})
    assert simulation.elastic_choices(joint._replace(contact=spring)) == {}


def test_laws_of_another_version_leave_the_rest_of_the_page(tmp_path):
    run = of_laws()
    run.grid["sweep"][LAW] = ["lankarani-nikravesh", "forgotten"]
    run.summary[LAW] = run.summary[LAW].replace("exact", "forgotten")
    message = text(run, tmp_path)
    assert "Spread between the contact laws" in message
    assert "This version does not know every law of this run" in message
    assert "given back" not in message


def test_tables_of_laws_are_written_with_their_units(tmp_path):
    report.tables(of_elastic(["power", "johnson"]), tmp_path)
    rows = list(csv.reader((tmp_path / "elastic_force_rod_slider.csv").read_text(encoding="utf-8").splitlines()))
    assert rows[0][:4] == ["elastic law", "used here", "at 0.1\u00a0µm [N]", "at 1\u00a0µm [N]"]
    assert float(rows[1][3]) == pytest.approx(66.102, rel=1e-4)
    heads = next(
        csv.reader(
            (tmp_path / "laws_rod_slider_contact_elastic_rod_slider.csv").read_text(encoding="utf-8").splitlines()
        )
    )
    assert "force peak [N]" in heads


def test_a_case_is_resolved_again_with_the_keys_that_it_uses():
    cases = grid.load("configs/law_comparison.yaml", simulation.catalogue())
    run = Run(sweep={path: list(values) for path, values in cases.axes.items()}, wear=False)
    run.grid |= cases.resolved()
    given = study.prepare(run)
    for case_id in given.cases.index[::10]:
        (case,) = study.resolved(given, [case_id])
        uses = case.joints[0].contact.elastic
        assert uses == given.value(case_id, ELASTIC)
        assert ("thickness" in case.joints[0].contact.values) == (uses == "winkler")


def test_ranges_of_what_is_derived_hold_one_unit_each():
    cases = grid.load("configs/law_comparison.yaml", simulation.catalogue())
    derived, _ = sweep.facts(cases, SIMULATION)
    stiff = {name: first for name, first in derived.items() if "contact.stiffness" in name}
    assert {first["unit"] for first in stiff.values()} == {"N/m^1.5", "N/m^1.16257", "N/m^1.02531"}
    assert all(first["min"] == first["max"] for first in stiff.values())


def test_every_law_that_is_drawn_is_named():
    names = ["power", "johnson", "radzimovsky", "esdu-78035", "dubowsky-freudenstein", "liu", "winkler", "persson"]
    (gallery,) = blocks(of_elastic(names), Gallery)
    drawing = svg(gallery.pictures[-1], "f1")
    assert all(f">{name}<" in drawing for name in names)
    assert len(set(re.findall(r"#[0-9a-f]{6}", drawing.lower()))) >= 8
    assert len(elastic_comparison.CURVE) > 20


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        (70000.0, "decides whether the limits are kept in 1 of 3 designs, such as at crank speed 3000 rpm: kept with "),
        (1e9, "does not move the verdict on 3 designs: each keeps to the limits with every one"),
        (1.0, "does not move the verdict on 3 designs: each exceeds a limit with every one"),
        (20000.0, "lankarani-nikravesh, exceeded with exact"),
    ],
)
def test_whether_the_choice_moves_the_verdict_is_said_first(limit, message):
    run = of_laws()
    peak = run.summary[PEAK]
    run.grid["limits"] = {PEAK: limit}
    run.summary[verdict.EXCEEDED] = np.where(peak > limit, PEAK, "")
    run.summary[verdict.MARGIN] = 1.0 - peak / limit
    (part,) = [part for part in of_choice(run) if part.key.endswith("contact_law")]
    first = part.blocks[0].texts[0].replace("\u00a0", " ")
    assert message in first
    table = next(table for table in part.tables if table.key.endswith("_verdict"))
    for law, designs, beyond, smallest, _ in table.rows:
        mine = peak[run.summary[LAW] == law]
        assert (designs.value, beyond.value) == (3, int((mine > limit).sum()))
        assert smallest == pytest.approx(1.0 - mine.max() / limit, rel=1e-12)


def test_without_limits_nothing_is_said_of_a_verdict():
    assert not any(table.key.endswith("_verdict") for part in of_choice(of_laws()) for table in part.tables)
