"""What a run says about its elastic links: a warning where they would bend, a section of the report, the drawing."""

import copy
import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import simulation
from clearsweep.report.sections.answer import reliability_points
from clearsweep.report.sections.laws import elastic_links_sections
from clearsweep.report.study import prepare

STIFFNESS, CONTACT = 3.85e8, 6.61e10  # N/m, N/m^1.5
ROD = {"mechanism.rod.elastic": {"axial_stiffness": STIFFNESS, "damping": 0.01}}
STUDY = {
    "name": "elastic",
    "simulate": {"revolutions": 1, "discard": 0, "tolerance": 1e-6},
    "save": {"orbits": "none"},
    "drive": {"speed": "2000 rpm"},
    "joints.rod-slider.contact": {"law": "lankarani-nikravesh", "stiffness": CONTACT, "restitution": 0.9},
}


def link_of(source):
    (link,) = simulation.elastic_links(simulation.load_case(source).case)
    return link


def crank(**changes):
    """Return the slider-crank of configs/one_case.yaml with an elastic rod."""
    return slider_crank("rod-slider", changes=copy.deepcopy(ROD | changes))


def test_an_elastic_link_has_its_axial_mode_impedance_and_bending_share():
    link = link_of(crank(**{"drive.speed": "5000 rpm"}))
    mass, length = 0.21, 0.12
    assert link.first_mode == pytest.approx(math.pi * math.sqrt(STIFFNESS / mass))
    assert link.impedance == pytest.approx(math.sqrt(STIFFNESS * mass))
    # omega l . l / d . 4 / (pi^2 c) of a round steel bar, c = sqrt(E / rho) with the density that makes up its mass
    diameter = math.sqrt(4.0 * STIFFNESS * length / (math.pi * 210e9))
    speed_of_sound = math.sqrt(210e9 / (mass / (0.25 * math.pi * diameter**2 * length)))
    expected = 5000 * math.pi / 30.0 * length * (length / diameter) * 4.0 / (math.pi**2 * speed_of_sound)
    assert link.bending == pytest.approx(expected, rel=1e-9)
    assert link.bending == pytest.approx(0.035, abs=1e-3)  # docs/model.md
    assert link.joints == ("crank-rod", "rod-slider")


def test_a_link_that_would_bend_is_warned_of_and_a_short_or_slow_one_is_not():
    slow, fast = (crank(**{"drive.speed": speed}) for speed in ("5000 rpm", "30000 rpm"))
    assert simulation.warnings(simulation.load_case(slow).case) == []
    (warning,) = simulation.warnings(simulation.load_case(fast).case)
    assert "mechanism.rod.elastic: the drive turns at 0.21 of the first bending mode" in warning
    motor = {"drive": {"motor": {"stall_torque": 20.0, "no_load_speed": "30000 rpm"}, "initial_speed": "1000 rpm"}}
    run_up = simulation.load_case(crank(**motor, **{"simulate.time_limit": 1.0})).case
    assert simulation.warnings(run_up) == [warning]
    rigid = slider_crank("rod-slider", changes={"drive.speed": "30000 rpm"})
    assert simulation.warnings(simulation.load_case(rigid).case) == []


def test_the_drawing_marks_an_elastic_link_between_its_pins():
    bodies = {body.name: body for body in simulation.sketch(simulation.load_case(crank()).case).bodies}
    assert bodies["crank"].elastic_ends is None
    assert bodies["rod"].elastic_ends == pytest.approx(np.array([[0.05, 0.0], [0.17, 0.0]]), abs=1e-12)


def study_of(directory, **sweep):
    source = slider_crank("rod-slider", changes=copy.deepcopy(ROD | STUDY)) | ({"sweep": sweep} if sweep else {})
    clearsweep.sweep(source, out=directory, executor="serial", show_progress=False)
    return prepare(clearsweep.open(directory))


def test_the_report_says_how_much_harder_an_impact_on_rigid_links_would_be(tmp_path):
    study = study_of(tmp_path / "run")
    (section,) = elastic_links_sections(study)
    (case_id,) = study.cases.index
    depth = study.cases.at(case_id, "rod_slider_penetration_max")
    slope = 1.5 * CONTACT * math.sqrt(depth)
    compared, estimated, bending = section.sentences
    assert f"the contact stiffness is {1e-6 * slope:.0f}" in compared
    assert "rod has a stiffness of 385" in compared
    assert f"at least {math.sqrt(1.0 + slope / STIFFNESS):.1f} times as hard" in estimated
    assert "0.014 times the first bending frequency of rod" in bending
    (table,) = section.tables
    assert table.rows[0][:3] == ("rod", "4", STIFFNESS)
    assert any(compared in str(point) for point in reliability_points(study))
    # the estimate is of the same machine with a rigid rod
    rigid = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=copy.deepcopy(STUDY))))
    ratio = rigid.summary["rod_slider_force_peak"] / study.cases.at(case_id, "rod_slider_force_peak")
    assert math.sqrt(1.0 + slope / STIFFNESS) < ratio < 1.4 * math.sqrt(1.0 + slope / STIFFNESS)


def test_where_the_stiffness_of_a_link_is_swept_the_report_compares_computed_peaks(tmp_path):
    study = study_of(tmp_path / "run", **{"mechanism.rod.elastic.axial_stiffness": [STIFFNESS, 10.0 * STIFFNESS]})
    (section,) = elastic_links_sections(study)
    (sentence,) = (text for text in section.sentences if "the force peak depends on" in text)
    peaks = study.texts(*((case_id, "rod_slider_force_peak") for case_id in study.cases.index))
    assert all(peak in sentence for peak in peaks)
    assert "times as hard" not in " ".join(section.sentences)


def test_a_run_of_rigid_links_has_no_such_section(tmp_path):
    source = slider_crank("rod-slider", changes=copy.deepcopy(STUDY))
    clearsweep.sweep(source, out=tmp_path / "run", executor="serial", show_progress=False)
    assert elastic_links_sections(prepare(clearsweep.open(tmp_path / "run"))) == []
