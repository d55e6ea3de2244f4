"""The error budget of a report: which cases are one, whose bar is how long, and what all unknowns do together."""

import math

import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.report.sections.setup import bars_of, budget_sections, combined_change, one_at_a_time_design
from clearsweep.report.study import prepare

pytestmark = pytest.mark.heavy

JOINT = "joints.rod-slider"
#: The base is the third row; each other row changes one of the four.
DESIGN = {
    f"{JOINT}.clearance": [2e-4, 5e-5, 1e-4, 1e-4, 1e-4, 1e-4],
    f"{JOINT}.contact.restitution": [0.9, 0.9, 0.9, 0.5, 0.9, 0.9],
    f"{JOINT}.contact.stiffness": [6.61e10, 6.61e10, 6.61e10, 6.61e10, 1e10, 6.61e10],
    "drive.speed": [200.0, 200.0, 200.0, 200.0, 200.0, 100.0],
}


def study_of(directory, **sections):
    source = slider_crank("rod-slider") | {"name": "budget", "save": {"orbits": "none"}} | sections
    source["simulate"] = {"revolutions": 3, "discard": 1, "tolerance": 1e-6}
    return prepare(clearsweep.sweep(source, directory, executor="serial", show_progress=False).open())


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return study_of(tmp_path_factory.mktemp("budget") / "run", zip=DESIGN)


def test_the_case_that_all_others_differ_from_in_one_unknown_is_the_base(study):
    base, unknowns = one_at_a_time_design(study)
    assert study.value(base, f"{JOINT}.clearance") == 1e-4
    assert {unknown.axes[0].path: len(unknown.cases) for unknown in unknowns} == {
        f"{JOINT}.clearance": 2,
        f"{JOINT}.contact.restitution": 1,
        f"{JOINT}.contact.stiffness": 1,
        "drive.speed": 1,
    }


def test_a_bar_reaches_from_least_to_largest_change_the_longest_first(study):
    base, unknowns = one_at_a_time_design(study)
    column = "rod_slider_force_peak"
    bars = bars_of(study, column, base, unknowns)
    lengths = [bar.increase - bar.decrease for bar in bars]
    assert lengths == sorted(lengths, reverse=True)
    (speed,) = (bar for bar in bars if bar.unknown.axes[0].path == "drive.speed")
    start = study.cases.at(base, column)
    assert speed.decrease == pytest.approx(study.cases.at(speed.unknown.cases[0], column) / start - 1.0)
    assert speed.decrease < -0.5  # half the speed: about a quarter of the force
    assert (speed.increase, speed.case_of_increase) == (0.0, "")
    down, up = combined_change(bars)
    assert math.log(1.0 + down) == pytest.approx(-math.sqrt(sum(math.log(1.0 + bar.decrease) ** 2 for bar in bars)))
    assert math.log(1.0 + up) == pytest.approx(math.sqrt(sum(math.log(1.0 + bar.increase) ** 2 for bar in bars)))
    assert min(bar.decrease for bar in bars) > down > -1.0


def test_the_section_says_what_decides_and_has_a_chart_and_its_numbers(study):
    (section,) = budget_sections(study)
    sentences, gallery, table = section.blocks
    assert "crank speed" in sentences.texts[1]
    assert len(gallery.pictures) == 1
    assert len(table.rows) == 4
    assert np.isfinite([row[2].value for row in table.rows]).all()


def test_a_product_of_axes_is_no_error_budget(tmp_path):
    product = {
        f"{JOINT}.clearance": [1e-4, 2e-4],
        f"{JOINT}.contact.restitution": [0.5, 0.9],
        "drive.speed": [50.0, 90.0],
    }
    assert budget_sections(study_of(tmp_path / "run", sweep=product)) == []
