"""The report asks the layout what a mechanism has: one that was not there when it was written is reported, too."""

import numpy as np
import pandas as pd
import pytest
from report_fake import CRANK, ROD, RPM, Run
from test_report import Page

from clearsweep import report, simulation
from clearsweep.contracts.catalogue import Channel, Field, JointSite, Keys, Mechanism, Output
from clearsweep.mechanics.mechanism import MECHANISMS
from clearsweep.report import motion, single, study
from clearsweep.report.sections import headline, summary

LEAD, AMPLITUDE = 0.25, 0.4  # rad
GRAVITY = Field("gravity", "m/s^2", "gravity, down", low_open=False, default=9.81)


def rocker(case, angles):
    """Return a made-up rocker that swings with the crank."""
    drive, angle = case.drive.speed, AMPLITUDE * np.sin(angles + LEAD)
    forces = {"rod-rocker": np.zeros((*np.shape(angles), 2))}
    return simulation.IdealMotion(angle, drive * AMPLITUDE * np.cos(angles + LEAD), -(drive**2) * angle, forces)


MADE_UP = (
    Mechanism(
        *("four-bar", "made up", "", "", ""),
        bodies=("ground", "crank", "rod", "rocker"),
        joints=(JointSite("rod-rocker", "rod", "rocker"),),
        keys=(Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied"),),
        channels=(
            Channel("rocker/angle", "rad", "angle of the rocker"),
            Channel("rocker/rate", "rad/s", "its rate"),
            Channel("rocker/acceleration", "rad/s^2", "its acceleration"),
            Channel("crank/torque", "N*m", "drive torque on the crank"),
        ),
        turns=True,
        build=None,
        output=Output("rocker", "rad"),
    ),
    Mechanism(
        *("falling-mass", "made up", "", "", ""),
        bodies=("slot", "mass"),
        joints=(JointSite("slot", "slot", "mass", "line"),),
        keys=(Keys("mechanism", "", (Field("mass", "kg"), GRAVITY)),),
        channels=(Channel("mass/x", "m", "height of the mass"), Channel("mass/v", "m/s", "its rate")),
        turns=False,
        build=None,
    ),
    Mechanism(
        *("wheel", "made up", "", "", ""),
        bodies=("ground", "wheel"),
        joints=(JointSite("hub", "ground", "wheel"),),
        keys=(Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied"),),
        channels=(Channel("wheel/charge", "A*s", "what it carries"),),
        turns=True,
        build=None,
    ),
)
JOINTS = {"four-bar": "rod_rocker", "falling-mass": "slot", "wheel": "hub"}
TITLES = {
    "four-bar": [
        "Journal orbit",
        "Journal orbit unrolled",
        "Normal force",
        "Rocker acceleration against the ideal mechanism",
        "Rocker position error",
        "Crank torque",
    ],
    "falling-mass": ["Mass x", "Phase portrait: mass v over mass x", "Normal force"],
    "wheel": ["Wheel charge", "Journal orbit", "Journal orbit unrolled", "Normal force"],
}


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    for mechanism in MADE_UP:
        monkeypatch.setitem(MECHANISMS, mechanism.name, mechanism)
    real = simulation.ideal_motion
    known = {"four-bar": rocker}
    monkeypatch.setattr(simulation, "ideal_motion", lambda case, at: known.get(case.mechanism.type, real)(case, at))


def run_of(name, **changes):
    bodies = {"mass": 0.1, "gravity": 9.81} if name == "falling-mass" else {}
    given = {"sweep": {}, "joints": (JOINTS[name],), "mechanism": name, "wear": False, "bodies": bodies, "name": name}
    return Run(**given | changes)


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize("swept", [False, True])
def test_a_mechanism_that_the_report_does_not_know_is_reported(name, swept, tmp_path):
    sweep = {f"joints.{JOINTS[name].replace('_', '-')}.clearance": [1e-4, 2e-4, 5e-4]} if swept else {}
    page = Page(report.write(run_of(name, sweep=sweep), tmp_path / "page.html").read_text(encoding="utf-8"))
    assert page.open == []
    assert "slider" not in page.text.lower()
    for title in TITLES[name]:
        assert title in page.text
    assert report.tables(run_of(name, sweep=sweep), tmp_path / "tables")


@pytest.mark.parametrize("name", JOINTS)
def test_and_one_case_of_it_is_shown(name, tmp_path, monkeypatch):
    run = run_of(name)
    case_id = run.summary["case_id"][0]
    channels = {channel: np.asarray(values) for channel, values in run.orbit(case_id).items()}
    prepared = study.prepare(run)
    assert [picture.title for picture in motion.pictures(prepared, case_id, channels)] == TITLES[name]
    events = np.zeros(0, [("t", float), ("kind", "U3"), ("rate", float)])
    given = simulation.Trajectory("ok", "", {"steps": 100}, channels, events)
    monkeypatch.setattr(single.simulation, "solve", lambda case: given)
    assert report.show(run, case_id, tmp_path / "case.html").stat().st_size > 10_000


def test_the_output_is_judged_by_its_own_ideal_motion_and_in_its_own_unit():
    t = np.linspace(16 * np.pi, 20 * np.pi, 1441) / (5000 * RPM)
    ideal = AMPLITUDE * np.sin(5000 * RPM * t + LEAD)
    run = run_of("four-bar", further={"rocker/angle": ideal + np.radians(0.5)})
    prepared, case_id = study.prepare(run), run.summary["case_id"][0]
    message = {picture.title: picture.alt for picture in motion.pictures(prepared, case_id, run.orbit(case_id))}
    assert message["Rocker position error"] == "Rocker error, at most 0.500°."
    assert "the ideal mechanism reaches" in message["Rocker acceleration against the ideal mechanism"]
    run.summary["rocker_error_max"] = np.radians(0.5)
    (said,) = [sentence for sentence in headline.sentences(study.prepare(run)) if "ideal place" in sentence]
    assert said.startswith("The rocker is off its ideal place by up to 0.500°; its acceleration reaches")
    (section,) = summary.sections(study.prepare(run))
    assert ("Largest rocker error", "0.500°", "off the ideal place") in section.blocks[0].cards


def test_the_ideal_motion_of_the_slider_crank_is_the_closed_form_that_the_grid_gives():
    run = Run(sweep={})
    prepared, case_id = study.prepare(run), run.summary["case_id"][0]
    angle = np.linspace(16 * np.pi, 20 * np.pi, 1441)
    place = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    path = pd.DataFrame(run.orbit(case_id)).assign(**{"slider/place": place + 2e-6})
    message = {picture.title: picture.alt for picture in motion.pictures(prepared, case_id, path)}
    assert message["Slider position error"].replace("\u00a0", " ") == "Slider error, at most 2.00 µm."
