"""Claims about mechanisms, drives and loads as a grid describes them: what is read, what a mistake is answered."""

import json
import math

import pytest
from mechanism_cases import changed
from right_grids import grid_of

from clearsweep import grid, simulation
from clearsweep.contracts.catalogue import LoadOutline
from clearsweep.contracts.machine import Motor, Push, Schedule, Spring, TabledPush
from clearsweep.language.errors import InputError
from clearsweep.mechanics.machines.loads import load_keys
from clearsweep.mechanics.machines.planar.form import Planar
from clearsweep.report.documents.page import draw_grid
from clearsweep.simulation.machine.ideal import ideal_peaks, mechanism_of
from clearsweep.simulation.setup.scene import scheduled_clock

CATALOGUE = simulation.catalogue()
RPM = 2.0 * math.pi / 60.0
SLIDER_CRANK = grid_of("a slider-crank of text")
FOUR_BAR = grid_of("a four-bar")
PLANAR = grid_of("a planar machine")
GAS = {"crank_angle [deg]": [0, 90, 360], "fx": ["0 N", "-1 kN", "0 N"]}


def machine_case(source):
    return grid.load(source, CATALOGUE).case(0)


def machine_of(source):
    case = machine_case(source)
    return mechanism_of(case).machine(case)


def messages_of(source):
    with pytest.raises(InputError) as caught:
        grid.load(source, CATALOGUE)
    return caught.value.problems


def test_a_table_is_part_of_a_case_by_its_content_not_by_its_name(tmp_path):
    ids = []
    for name, text in (
        ("a.csv", "0,0\n90,-1000\n360,0"),
        ("b.csv", "0,0\n90,-1000\n360,0"),
        ("c.csv", "0,0\n90,-999\n360,0"),
    ):
        (tmp_path / name).write_text(f"crank_angle [deg],fx [N]\n{text}\n")
        file = tmp_path / "grid.json"
        file.write_text(json.dumps(changed(SLIDER_CRANK, loads={"gas": {"on": "slider", "table": name}})))
        ids.append(grid.load(file, CATALOGUE).case_id(0))
    assert ids[0] == ids[1] != ids[2]


def test_what_is_kept_of_an_ideal_machine_belongs_to_every_row_of_its_tables():
    peaks = []
    for force in (0.0, 1e5):  # in the middle of a long table
        knots, forces = [0.18 * row for row in range(2001)], [0.0] * 2001
        forces[1000] = force
        load = {"on": "slider", "table": {"crank_angle [deg]": knots, "fx": forces}}
        result = grid.load(changed(SLIDER_CRANK, loads={"gas": load}), CATALOGUE)
        peaks.append(ideal_peaks(result.case(0))["rod-slider"])
    assert peaks[1] > 10.0 * peaks[0]


@pytest.mark.parametrize("name", ["film", "wear", "contact", "friction", "journal", "thermal", "type", "joints"])
def test_a_joint_may_have_the_name_of_one_of_its_keys(name):
    source = json.loads(json.dumps(PLANAR).replace("small-end", name))
    assert grid.load(source, CATALOGUE).case(0).joints[0].clearance == machine_case(PLANAR).joints[0].clearance
    (message,) = (line for line in messages_of(changed(source, life={})) if "life.joint" in line)
    assert f"write one of main, big-end, {name} (" in message


def test_every_number_of_a_load_and_of_a_body_can_be_swept():
    source = changed(PLANAR, loads={"press": {"on": "slider", "force": ["-1 kN", 0]}})
    source["sweep"] = {
        "loads.press.force.0": ["-1 kN", "-2 kN"],
        "mechanism.bodies.rod.mass": [0.1, 0.2],
        "mechanism.bodies.rod.points.small.0": ["120 mm", "121 mm"],
    }
    cases = grid.load(source, CATALOGUE)
    assert len({cases.case_id(k) for k in range(len(cases))}) == 8
    assert [load.values["force.0"] for load in (cases.case(0).loads[0], cases.case(7).loads[0])] == [-1e3, -2e3]


def test_new_keys_are_no_part_of_a_case_that_does_not_use_them():
    written = grid.load(SLIDER_CRANK, CATALOGUE).written_case(0)
    assert set(written) == {"mechanism", "drive", "joints", "simulate", "save"}
    assert set(written["drive"]) == {"speed"}
    assert set(written["mechanism"]["slider"]) == {"mass"}
    assert "time_limit" not in written["simulate"]


@pytest.mark.parametrize("changes", [{}, {"mechanism__slider__offset": "5 mm"}, {"drive__start_angle": "30 deg"}])
def test_every_slider_crank_of_the_plane_is_a_planar_machine(changes):
    assert isinstance(simulation.load_case(changed(SLIDER_CRANK, **changes)).value.mechanism, Planar)


def test_loads_and_drives_come_to_a_machine_in_its_own_words():
    loads = {
        "press": {"on": "slider", "force": ["-1 kN", "2 N"], "torque": 3},
        "gas": {"on": "slider", "table": GAS, "scale": 2},
        "spring": {"between": ["ground", "slider"], "anchor": ["300 mm", 0], "stiffness": "2 kN/m", "damping": 5},
    }
    source = changed(SLIDER_CRANK, loads=loads, drive={"torque": 5, "initial_speed": "300 rpm", "inertia": 0.1})
    made = machine_of(source)
    press, gas, spring = made.loads
    assert press == Push("press", ("slider", "pin"), -1000.0, 2.0, 3.0)
    assert isinstance(gas, TabledPush)
    assert (gas.over, gas.scale, list(gas.fx)) == ("angle", 2.0, [0.0, -1000.0, 0.0])
    assert isinstance(spring, Spring)
    assert made.bodies["ground"].points[spring.first.point] == (0.3, 0.0)
    assert made.drive == Motor(5.0, math.inf, pytest.approx(300 * RPM), 0.1, 0.0)


@pytest.mark.parametrize(("branch", "side"), [("open", 1.0), ("crossed", -1.0)])
def test_the_branches_of_a_four_bar_lie_on_either_side(branch, side):
    case = grid.load(changed(FOUR_BAR, mechanism__branch=branch, drive__start_angle="70 deg"), CATALOGUE).case(0)
    sketch = simulation.sketch(case)
    places = {joint.name: joint.position for joint in sketch.joints}
    pin, pivot, coupler = places["crank-coupler"], places["rocker-ground"], places["coupler-rocker"]
    distance, to = pivot - pin, coupler - pin
    assert side * (distance[0] * to[1] - distance[1] * to[0]) > 0.0
    assert math.dist(pin, coupler) == pytest.approx(0.12, rel=1e-12)
    assert math.dist(pivot, coupler) == pytest.approx(0.10, rel=1e-12)


def test_the_revolutions_of_a_speed_table_end_where_its_angle_says():
    schedule = scheduled_clock(Schedule(times=_array(0.0, 1.0, 3.0), speeds=_array(0.0, 10.0, 4.0)))
    assert schedule.value_after(5.0 / (2.0 * math.pi)) == pytest.approx(1.0, rel=1e-12)
    assert schedule.value_after(19.0 / (2.0 * math.pi)) == pytest.approx(3.0, rel=1e-12)
    assert schedule.value_after(23.0 / (2.0 * math.pi)) == pytest.approx(4.0, rel=1e-12)
    turns = 1.25 / (2.0 * math.pi)  # after half a second, at half of the acceleration
    assert schedule.value_after(turns) == pytest.approx(0.5, rel=1e-12)


def _array(*values):
    import numpy as np

    return np.array(values)


def test_the_picture_names_every_body_joint_and_load(tmp_path):
    file = tmp_path / "grid.json"
    file.write_text(json.dumps(changed(FOUR_BAR, loads={"brake": {"on": "rocker", "torque": -3}})))
    text = draw_grid(file, tmp_path / "mechanism.svg").read_text()
    for name in ("crank", "coupler", "rocker", "ground-crank", "coupler-rocker (clearance)", "brake"):
        assert f">{name}<" in text
    assert draw_grid(file, tmp_path / "mechanism.png").stat().st_size > 5_000


def test_the_keys_say_where_a_spring_holds_its_second_body_and_it_does():
    between = {"anchor": ["300 mm", 0], "stiffness": "2 kN/m"}
    loads = {body: {"between": ["ground", body], **between} for body in ("rod", "slider")}
    source = changed(SLIDER_CRANK, loads=loads)
    made = machine_of(source)
    far = {spring.name: made.bodies[spring.name].points[spring.second.point] for spring in made.loads}
    assert far == {"rod": made.bodies["rod"].center, "slider": (0.0, 0.0)}  # the slider's frame is at its pin
    messages_of = load_keys(LoadOutline("rod", "spring", "rod"), {"ground": (), "rod": (), "slider": ()}, ())
    (section,) = (each for each in messages_of if each.path.endswith(".between"))
    assert "on the second at its pin if that body is a slider, otherwise at its centre of mass" in section.text
    planar = load_keys(LoadOutline("rod", "spring", "rod"), {"ground": ("rail",), "rod": ("big",)}, ())
    words = {choice.name: choice.text for each in planar for choice in each.words}
    assert words["point"] == "point of the body at which the load acts; center: the centre of mass"
