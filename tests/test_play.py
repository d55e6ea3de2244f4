"""Play in rotation: gears and couplings against closed solutions, and what grids may say about them."""

import json
import math
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

import clearsweep
from clearsweep import grid, laws
from clearsweep.language.errors import InputError
from clearsweep.simulation.setup import scene

TRUTH = json.loads(Path(__file__).with_name("one_sided_play.json").read_text())
INPUT, PAIR = TRUTH["input"], TRUTH["gear_pair"]
PERIOD = 2.0 * math.pi / INPUT["W_rad_s"]
SPEED = INPUT["W0_rad_s"]
ORIGIN = [0.0, 0.0]


def wheels(joint, play, ratio=1.0, sense=1.0, **changes):
    """Return two wheels on the ground, the first driven at a speed that would turn the second at SPEED."""
    start = {"angle": -sense * INPUT["delta0_rad"], "rate": sense * SPEED}
    tree = {
        "mechanism": {
            "type": "planar",
            "bodies": {
                "ground": {"points": {"first": ORIGIN, "second": [0.09, 0.0]}},
                "pinion": {"mass": 1.0, "inertia": 1e-3, "points": {"axle": ORIGIN}},
                "wheel": {
                    "mass": 1.0,
                    "inertia": INPUT["inertia_kg_m2"],
                    "points": {"axle": ORIGIN},
                    "initial": start,
                },
            },
            "joints": {
                "shaft": {"type": "revolute", "between": ["ground.first", "pinion.axle"]},
                "bearing": {"type": "revolute", "between": ["ground.second", "wheel.axle"]},
                "mesh": {"between": ["pinion", "wheel"], **joint},
            },
            "driven": "shaft",
            "output": {"body": "wheel"},
        },
        "drive": {"speed": ratio * SPEED},
        "joints": {"mesh": {"drag": INPUT["drag_relative_N_m_s_per_rad"], **play}},
        "simulate": {
            "revolutions": 40.0 * PERIOD * ratio * SPEED / (2.0 * math.pi),
            "discard": 0,
            "tolerance": 1e-12,
        },
        "save": {"orbits": "all", "samples": 4},
    }
    for path, value in changes.items():
        *sections, key = path.split(".")
        section = tree
        for name in sections:
            section = section.setdefault(name, {})
        section[key] = value
    return tree


def coupling(**changes):
    """Return two wheels with a coupling between them."""
    contact = {"law": "kelvin-voigt", "stiffness": INPUT["stiffness_N_m_per_rad"], "damping": 0.0}
    play = {"play": 2.0 * INPUT["half_play_rad"], "contact": contact}
    return wheels({"type": "coupling"}, play, **changes)


def gear(**changes):
    """Return two wheels in mesh, the pair that is equivalent to the coupling."""
    ratio = PAIR["r2_m"] / PAIR["r1_m"]
    stiffness = PAIR["contact_stiffness_along_line_of_action_N_m"]
    contact = {"law": "kelvin-voigt", "stiffness": stiffness, "damping": 0.0}
    joint = {"type": "gear", "ratio": ratio, "radius": PAIR["r1_m"], "pressure_angle": "20 deg"}
    play = {"backlash": PAIR["backlash_circumferential_m"], "contact": contact}
    return wheels(joint, play, ratio, -1.0, **changes)


def shaken(tree, sense):
    """Return the scene of a grid whose second wheel is loaded, and shaken as if the drive were.

    In a frame that turns with the first wheel the uneven drive is the torque J2 theta1'' on the second.
    """
    with laws.collecting() as records:

        @laws.load("shaking", mean="N*m", amplitude="N*m", rate="rad/s")
        def shaking(t, angle, position, velocity, p):
            return 0.0, 0.0, p.mean + p.amplitude * math.sin(p.rate * t)

    amplitude = INPUT["inertia_kg_m2"] * INPUT["A_rad_s"] * INPUT["W_rad_s"]
    sizes = {"mean": -sense * INPUT["load_torque_N_m"], "amplitude": sense * amplitude, "rate": INPUT["W_rad_s"]}
    tree["loads"] = {"shake": {"on": "wheel", "law": "shaking", **sizes}}
    digest = "play" if sense > 0.0 else "gear"
    return scene.build(grid.load(tree, scene.catalogue().with_laws(records, digest)).case(0))


@pytest.mark.parametrize(("tree", "sense"), [(coupling, 1.0), (gear, -1.0)])
def test_one_sided_impacts_begin_and_end_when_the_closed_solution_says(tree, sense):
    built = shaken(tree(), sense)
    result = clearsweep.simulate(built, TRUTH["state_times_s"])
    events = result.events
    assert events["kind"].tolist() == TRUTH["kinds"]
    assert set(events["joint"].tolist()) == {"mesh_drive"}
    assert np.max(np.abs(events["t"] - TRUTH["times_s"])) < 1e-9 * PERIOD
    arm = abs(built.value.joints[0].arm_distal)  # of the position along the line of action
    assert events["rate"] / arm == pytest.approx(np.array(TRUTH["rates_rad_s"]), rel=1e-7)
    assert result["joints/mesh/x"] / arm == pytest.approx(np.array(TRUTH["delta_rad"]), rel=1e-7)
    assert result.summary["energy_residual"] < 1e-11


def test_figures_of_play_follow_from_the_closed_solution():
    figures = clearsweep.simulate(shaken(gear(), -1.0), []).summary
    half_play, times = INPUT["half_play_rad"], TRUTH["times_s"]
    low, high = (bound * half_play for bound in TRUTH["delta_range_over_b"])
    onsets = TRUTH["kinds"].count("on")
    turns = 40.0 * PERIOD * 2.0 * SPEED / (2.0 * math.pi)
    free = sum(end - begin for begin, end in zip(times[::2], times[1::2], strict=True)) / (40.0 * PERIOD)
    assert figures["mesh_impacts_per_cycle"] == pytest.approx(onsets / turns, rel=1e-12)
    assert figures["mesh_free_share"] == pytest.approx(free, rel=1e-8)
    assert figures["mesh_lost_motion"] == pytest.approx(high - low, rel=1e-3)  # four digits are known
    assert figures["mesh_transmission_error"] == pytest.approx(high, rel=1e-3)
    torque = INPUT["stiffness_N_m_per_rad"] * (high - half_play)
    assert figures["mesh_torque_peak"] == pytest.approx(torque, rel=1e-3)
    base_radius = PAIR["r2_m"] * math.cos(math.radians(PAIR["pressure_angle_deg"]))
    assert figures["mesh_force_peak"] == pytest.approx(figures["mesh_torque_peak"] / base_radius, rel=1e-12)
    assert figures["mesh_torque_peak_ideal"] == pytest.approx(
        INPUT["load_torque_N_m"] + INPUT["inertia_kg_m2"] * INPUT["A_rad_s"] * INPUT["W_rad_s"], rel=1e-3
    )


def refused(tree, *words):
    """Assert that a grid is refused with a message that has these words."""
    with pytest.raises(InputError) as error:
        clearsweep.load_case(tree)
    for word in words:
        assert word in str(error.value)


def changed(tree, path, value):
    """Return a grid with another value at a path; None removes it."""
    tree = deepcopy(tree)
    *sections, key = path.split(".")
    section = tree
    for name in sections:
        section = section[name]
    if value is None:
        del section[key]
    else:
        section[key] = value
    return tree


@pytest.mark.parametrize(
    ("tree", "path", "value", "words"),
    [
        (gear, "mechanism.joints.mesh.ratio", 0.0, ("mesh.ratio", "found 0")),
        (gear, "mechanism.joints.mesh.ratio", -1.0, ("mesh.ratio", "type: coupling")),
        (gear, "mechanism.joints.mesh.radius", 0.031, ("mesh.radius", "90 mm apart", "93 mm")),
        (gear, "mechanism.joints.mesh.radius", -0.03, ("mesh.radius", "above 0")),
        (gear, "joints.mesh.backlash", -1e-5, ("mesh.backlash", "above 0")),
        (gear, "joints.mesh.backlash", None, ("mesh.backlash", "missing")),
        (gear, "joints.mesh.play", 1e-3, ("mesh.play",)),
        (coupling, "joints.mesh.backlash", 1e-3, ("mesh.backlash",)),
        (coupling, "joints.mesh.contact.stiffness", "1 kN/m", ("contact.stiffness", "N*m/rad")),
        (coupling, "mechanism.bodies.wheel.initial.angle", "90 deg", ("joints.mesh", "flanks overlap")),
        (coupling, "mechanism.bodies.wheel.initial.x", "1 mm", ("initial.x", "angle and rate")),
        (gear, "mechanism.joints.bearing.between", ["pinion.axle", "wheel.axle"], ("mesh.between", "no pins")),
    ],
)
def test_grids_that_make_no_sense_are_refused_with_the_place_and_the_remedy(tree, path, value, words):
    refused(changed(tree(), path, value), *words)


def flap(**changes):
    """Return a flap on a torsion spring, whose free angle lies beyond the lower of two stops."""
    contact = {"law": "kelvin-voigt", "stiffness": 2e4, "damping": 0.0}
    tree = coupling(**changes)
    bodies, joints = tree["mechanism"]["bodies"], tree["mechanism"]["joints"]
    bodies["wheel"] |= {"inertia": 2e-3, "initial": {"angle": 0.3, "rate": 0.0}}
    del joints["mesh"]
    tree["mechanism"]["output"] = {"body": "pinion"}
    tree["loads"] = {"spring": {"between": ["ground", "wheel"], "torsional_stiffness": 5.0, "free_angle": -0.2}}
    tree["joints"] = {"bearing": {"stops": {"at": [-0.05, 0.5], "contact": contact}}}
    tree["simulate"] |= {"revolutions": 1.0, "tolerance": 1e-10}
    return tree


def test_a_flap_meets_its_stop_when_the_spring_has_turned_it_there():
    result = clearsweep.simulate(clearsweep.load_case(flap()), [])
    rate = math.sqrt(5.0 / 2e-3)
    time = math.acos(0.15 / 0.5) / rate
    first, second = result.events[:2]
    assert (first["joint"], first["kind"], second["kind"]) == ("bearing_lower", "on", "off")
    assert first["t"] == pytest.approx(time, rel=1e-9)
    assert first["rate"] == pytest.approx(0.5 * rate * math.sin(rate * time), rel=1e-9)
    assert second["rate"] == pytest.approx(-first["rate"], rel=1e-8)
    assert result.summary["energy_residual"] < 1e-12
    assert result.units["bearing_penetration_max"] == "rad"


def test_stops_that_make_no_sense_are_refused():
    refused(
        changed(flap(), "joints.bearing.stops.at", [0.5, -0.05]), "joints.bearing.stops.at", "lower stop comes first"
    )
    refused(changed(flap(), "mechanism.bodies.wheel.initial.angle", 0.6), "bearing.stops.at", "beyond a stop")
    refused(changed(flap(), "joints.bearing.clearance", 1e-5), "joints.bearing.clearance")
    refused(changed(flap(), "loads", None), "bearing", "wheel")


def test_a_guide_meets_its_stop_where_its_slider_is():
    contact = {"law": "kelvin-voigt", "stiffness": 1e6, "damping": 0.0}
    tree = {
        "mechanism": {
            "type": "planar",
            "bodies": {
                "ground": {"points": {"main": ORIGIN}},
                "crank": {"mass": 1.0, "inertia": 1e-3, "points": {"axle": ORIGIN, "pin": [0.05, 0.0]}},
                "rod": {"mass": 0.2, "inertia": 1e-4, "points": {"big": ORIGIN, "small": [0.12, 0.0]}},
                "slider": {"mass": 0.5, "inertia": 1e-4, "points": {"pin": ORIGIN}},
            },
            "joints": {
                "axle": {"type": "revolute", "between": ["ground.main", "crank.axle"]},
                "big": {"type": "revolute", "between": ["crank.pin", "rod.big"]},
                "small": {"type": "revolute", "between": ["rod.small", "slider.pin"]},
                "rail": {"type": "prismatic", "between": ["ground.main", "slider.pin"]},
            },
            "driven": "axle",
            "output": {"body": "slider", "point": "pin"},
        },
        "drive": {"torque": 2.0, "initial_speed": 10.0, "inertia": 0.01},
        "joints": {"rail": {"stops": {"at": [0.1, 0.18], "contact": contact}}},
        "simulate": {"revolutions": 0.285, "discard": 0, "tolerance": 1e-10},
        "save": {"orbits": "all"},
    }
    result = clearsweep.simulate(clearsweep.load_case(tree))
    begin = result.events[0]
    assert (begin["joint"], begin["kind"]) == ("rail_lower", "on")
    assert np.interp(begin["t"], result.t, result["slider/x"]) == pytest.approx(0.1, abs=1e-5)
    assert result.summary["energy_residual"] < 1e-9
