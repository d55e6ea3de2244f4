"""Links that give along the line between their pins, against the continuous bar, other equations and rigid links."""

import copy
import math

import elastic_bar
import numpy as np
import planar_machines
import pytest
from elastic_machine import Rod
from mechanism_cases import slider_crank
from right_grids import grid_of

import clearsweep
from clearsweep import simulation
from clearsweep.contracts.machine import Elastic
from clearsweep.mechanics.machines.planar.build import axial_rate, with_segments
from clearsweep.report.sections.answer import reliability_points
from clearsweep.report.sections.laws import elastic_links_sections
from clearsweep.report.study import prepare
from clearsweep.simulation.remarks import ElasticLink, segments_to_resolve

STIFFNESS = 3.9e8  # N/m: a steel rod of 190 mm^2 and 0.12 m between its pins has 3.3e8
SPEED = 5000.0 * math.pi / 30.0  # rad/s
ROD = {"axial_stiffness": STIFFNESS, "segments": 4, "damping": 0.02}


def solved(elastic=None, times=None, **changes):
    """Return the motion of the slider-crank with clearance at the slider's pin over a quarter of a turn."""
    given = {"simulate.revolutions": 0.25, "simulate.tolerance": 1e-10, "joints.rod-slider.contact.onset": "first"}
    given |= {"mechanism.rod.elastic": elastic} if elastic else {}
    return clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=given | changes)), times=times)


@pytest.mark.few("1.0")
@pytest.mark.parametrize("speed", [0.2, 1.0, 4.4])
def test_an_impact_on_six_segments_is_that_on_the_continuous_bar(speed):
    peak, duration = elastic_bar.continuous(speed)
    result = elastic_bar.in_segments(speed, 6)
    assert result == pytest.approx((peak, duration), rel=0.01)


@pytest.mark.slow
def test_more_segments_come_nearer_to_the_continuous_bar():
    peak, _ = elastic_bar.continuous(4.4, steps=8000)
    errors = [abs(elastic_bar.in_segments(4.4, segments)[0] / peak - 1.0) for segments in (1, 4, 12)]
    assert errors[0] > 0.2
    assert errors[1] < 0.02
    assert errors[2] < 0.0015


SOFT = 1e8  # N/m


@pytest.mark.parametrize(
    ("stiffness", "speed"),
    [(STIFFNESS, 0.2), (STIFFNESS, 4.4), (SOFT, 0.2), pytest.param(SOFT, 1.0, marks=pytest.mark.slow)],
)
def test_a_link_with_the_segments_that_an_impact_needs_errs_by_a_few_per_cent(stiffness, speed, monkeypatch):
    monkeypatch.setattr(elastic_bar, "STIFFNESS", stiffness)
    peak, _ = elastic_bar.continuous(speed, steps=8000)
    needed = segments_needed(stiffness, peak, speed)
    assert elastic_bar.in_segments(speed, needed)[0] == pytest.approx(peak, rel=0.03)


def segments_needed(stiffness, peak, speed):
    """Return the segments that the bar needs for an impact with this peak (N) at this speed (m/s)."""
    impedance = math.sqrt(stiffness * elastic_bar.MASS)
    rod = ElasticLink("rod", stiffness, 1, math.nan, impedance, math.nan, ())
    return segments_to_resolve(rod, peak, (peak / elastic_bar.CONTACT) ** (2.0 / 3.0), speed)


@pytest.mark.slow
def test_a_soft_link_needs_more_than_twelve_segments(monkeypatch):
    monkeypatch.setattr(elastic_bar, "STIFFNESS", SOFT)
    peak, _ = elastic_bar.continuous(4.4, steps=8000)
    coarse, fine = (elastic_bar.in_segments(4.4, segments)[0] / peak - 1.0 for segments in (12, 24))
    assert abs(coarse) > 0.03
    assert abs(fine) < 0.005
    assert 12 < segments_needed(SOFT, peak, 4.4) < 24


def test_a_link_with_too_few_segments_for_its_impacts_is_flagged():
    assert "coarse-link" not in solved(ROD).message
    soft = solved(ROD | {"axial_stiffness": SOFT})
    assert "coarse-link: rod has 4 segments, but the fastest impact in rod-slider needs " in soft.message


def test_a_single_segment_is_warned_of():
    def warned(segments):
        elastic = {"mechanism.rod.elastic": ROD | {"segments": segments}}
        return simulation.warnings(clearsweep.load_case(slider_crank("rod-slider", changes=elastic)).case)

    assert any("mechanism.rod.elastic.segments: a single spring" in sentence for sentence in warned(1))
    assert not any("segments" in sentence for sentence in warned(2))


@pytest.mark.few("0.13")
@pytest.mark.parametrize("share", [0.13, 1.0])
def test_a_crank_with_an_elastic_rod_moves_as_equations_of_its_own_say(share):
    end = share * math.pi / SPEED
    begun, state = Rod(SPEED, STIFFNESS, 4, damping=0.02).run(end)
    path = solved(ROD, times=np.array([0.0, end]), **{"simulate.revolutions": 0.5, "simulate.tolerance": 1e-11})
    events = path.events[(path.events["kind"] == "on") & (path.events["t"] <= end)]
    assert len(events) == len(begun) > 1
    np.testing.assert_allclose(events["t"], [time for time, _ in begun], rtol=1e-6)
    np.testing.assert_allclose(events["rate"], [rate for _, rate in begun], rtol=1e-5)
    result = [path[name][-1] for name in ("slider/x", "slider/v", "rod/angle", "rod/extension")]
    assert result == pytest.approx([state[5], state[11], state[0], state[4]], rel=1e-6)
    assert path.summary["energy_residual"] < 1e-9


def test_a_seated_rod_begins_with_the_extension_of_its_static_load():
    """At the outer dead centre the rod pulls the slider and its own masses towards the crank."""
    times = np.array([0.0, 2e-5])
    path = solved(ROD, times=times, **{"simulate.start": "seated"})
    crank, length, mass, slider = 0.05, 0.12, 0.21, 0.14  # m, m, kg, kg
    distances = length * np.arange(5) / 4
    masses = mass * np.array([0.125, 0.25, 0.25, 0.25, 0.125])
    accelerations = crank * SPEED**2 * (1.0 + distances * crank / length**2)
    slider_tension = slider * accelerations[-1]
    tensions = [slider_tension + np.sum((masses * accelerations)[first:]) for first in range(1, 5)]
    assert path["rod/extension"][0] == pytest.approx(np.sum(tensions) / (4.0 * STIFFNESS), rel=1e-9)
    assert path["joints/rod_slider/force_normal"] == pytest.approx(slider_tension, rel=0.02)


def test_a_centred_rod_begins_without_stretch():
    assert solved(ROD, times=np.zeros(1))["rod/extension"][0] == pytest.approx(0.0, abs=1e-15)


def test_a_rod_that_hardly_gives_moves_as_a_rigid_one():
    rigid, stiff = (solved(elastic).summary for elastic in (None, ROD | {"axial_stiffness": 1e4 * STIFFNESS}))
    for figure in ("rod_slider_force_peak", "rod_slider_force_rms", "slider_acceleration_peak", "crank_torque_peak"):
        assert stiff[figure] == pytest.approx(rigid[figure], rel=1e-4)
    assert stiff["rod_slider_force_peak_ideal"] == rigid["rod_slider_force_peak_ideal"]


def test_a_steel_rod_halves_the_first_peak():
    rigid, elastic = (solved(given).summary["rod_slider_force_peak"] for given in (None, ROD | {"damping": 0.0}))
    assert rigid == pytest.approx(45.9e3, rel=0.005)
    assert elastic == pytest.approx(24.0e3, rel=0.02)


def test_a_machine_without_elastic_links_is_left_as_it_is():
    made = planar_machines.slider_crank()
    assert with_segments(made) is made


@pytest.mark.compiled
def test_a_rod_of_four_segments_takes_a_few_times_the_evaluations_of_a_rigid_one():
    """One of them costs a third more: run time is 5 to 8 times that of the rigid rod, which has half the impacts."""
    long = {"simulate.revolutions": 3.0, "simulate.tolerance": 1e-8}
    rigid, elastic = (solved(given, **long).summary for given in (None, ROD | {"damping": 0.01}))
    assert elastic["rhs_evaluations"] < 6.5 * rigid["rhs_evaluations"]


def test_mass_centre_and_inertia_are_as_given_where_nothing_is_stretched():
    made = planar_machines.slider_crank()
    points = {"big": (0.01, 0.02), "small": (0.11, -0.03)}
    rod = made.bodies["rod"]._replace(center=(0.04, 0.03), points=points, elastic=Elastic("big", "small", 1e8, 3, 0.1))
    split = with_segments(made._replace(bodies={**made.bodies, "rod": rod}))
    masses = [body for name, body in split.bodies.items() if name.startswith("rod")]
    assert len(masses) == 4
    assert sum(body.mass for body in masses) == pytest.approx(rod.mass, rel=1e-14)
    center = sum(body.mass * np.array(body.center) for body in masses) / rod.mass
    np.testing.assert_allclose(center, rod.center, rtol=1e-13)
    inertia = sum(body.inertia + body.mass * np.sum((np.array(body.center) - center) ** 2) for body in masses)
    assert inertia == pytest.approx(rod.inertia, rel=1e-12)


def test_the_damping_is_that_of_the_first_axial_mode():
    made = planar_machines.slider_crank()
    rod = made.bodies["rod"]._replace(elastic=Elastic("big", "small", STIFFNESS, 12, 0.05))
    split = with_segments(made._replace(bodies={**made.bodies, "rod": rod}))
    springs = [joint for joint in split.joints if joint.name.startswith("rod~")]
    mass = np.diag([body.mass for name, body in split.bodies.items() if name.startswith("rod")])
    pull = np.zeros((13, 13))
    for i in range(12):
        pull[i : i + 2, i : i + 2] += [[1.0, -1.0], [-1.0, 1.0]]
    rates = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, springs[0].stiffness * pull)).real)[1:])
    assert rates[0] == pytest.approx(axial_rate(rod), rel=0.005)
    assert springs[0].damping / springs[0].stiffness * axial_rate(rod) / 2.0 == pytest.approx(0.05, rel=1e-12)


@pytest.mark.slow
def test_every_planar_mechanism_takes_elastic_links():
    path = clearsweep.simulate(clearsweep.load_case(grid_of("a four-bar whose links stretch")))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-7
    for link in ("coupler", "rocker"):
        assert 1e-9 < np.max(np.abs(path[f"{link}/extension"])) < 1e-4


def test_a_planar_grid_says_where_a_link_gives():
    grid = copy.deepcopy(PLANAR)
    assert clearsweep.simulate(clearsweep.load_case(grid)).summary["rod_slider_force_peak"] == pytest.approx(
        solved({"axial_stiffness": STIFFNESS}).summary["rod_slider_force_peak"], rel=1e-6
    )


def test_a_load_at_the_pin_of_an_elastic_link_acts_there():
    grid = copy.deepcopy(PLANAR) | {"loads": {"push": {"on": "rod", "point": "small", "force": ["-50 N", "0 N"]}}}
    path = clearsweep.simulate(clearsweep.load_case(grid))
    assert path.status == "ok"
    assert path.summary["energy_residual"] < 1e-9


def points(**named):
    """Return the points of a body as a grid has them."""
    return {name: [x, 0.0] for name, x in named.items()}


PLANAR = grid_of("an elastic rod")


# ---------------------------------------------------------------------------------------------- the report


AXIAL, CONTACT = 3.85e8, 6.61e10  # N/m, N/m^1.5
ELASTIC_ROD = {"mechanism.rod.elastic": {"axial_stiffness": AXIAL, "damping": 0.01}}
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
    return slider_crank("rod-slider", changes=copy.deepcopy(ELASTIC_ROD | changes))


def test_an_elastic_link_has_its_axial_mode_impedance_and_bending_share():
    link = link_of(crank(**{"drive.speed": "5000 rpm"}))
    mass, length = 0.21, 0.12
    assert link.first_mode == pytest.approx(math.pi * math.sqrt(AXIAL / mass))
    assert link.impedance == pytest.approx(math.sqrt(AXIAL * mass))
    # omega l . l / d . 4 / (pi^2 c) of a round steel bar, c = sqrt(E / rho) with the density that makes up its mass
    diameter = math.sqrt(4.0 * AXIAL * length / (math.pi * 210e9))
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
    source = slider_crank("rod-slider", changes=copy.deepcopy(ELASTIC_ROD | STUDY)) | (
        {"sweep": sweep} if sweep else {}
    )
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
    assert f"at least {math.sqrt(1.0 + slope / AXIAL):.1f} times as hard" in estimated
    assert "0.014 times the first bending frequency of rod" in bending
    (table,) = section.tables
    assert table.rows[0][:3] == ("rod", "4", AXIAL)
    assert any(compared in str(point) for point in reliability_points(study))
    # the estimate is of the same machine with a rigid rod
    rigid = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=copy.deepcopy(STUDY))))
    ratio = rigid.summary["rod_slider_force_peak"] / study.cases.at(case_id, "rod_slider_force_peak")
    assert math.sqrt(1.0 + slope / AXIAL) < ratio < 1.4 * math.sqrt(1.0 + slope / AXIAL)


def test_where_the_stiffness_of_a_link_is_swept_the_report_compares_computed_peaks(tmp_path):
    study = study_of(tmp_path / "run", **{"mechanism.rod.elastic.axial_stiffness": [AXIAL, 10.0 * AXIAL]})
    (section,) = elastic_links_sections(study)
    (sentence,) = (text for text in section.sentences if "the force peak depends on" in text)
    peaks = study.texts(*((case_id, "rod_slider_force_peak") for case_id in study.cases.index))
    assert all(peak in sentence for peak in peaks)
    assert "times as hard" not in " ".join(section.sentences)


def test_a_run_of_rigid_links_has_no_such_section(tmp_path):
    source = slider_crank("rod-slider", changes=copy.deepcopy(STUDY))
    clearsweep.sweep(source, out=tmp_path / "run", executor="serial", show_progress=False)
    assert elastic_links_sections(prepare(clearsweep.open(tmp_path / "run"))) == []
