"""Data of the player of a page: journals in circles, blocks and pins between straight walls."""

import base64
import copy
import io
import json
import subprocess
import sys
import time
from pathlib import Path

import fake_physics
import numpy as np
import pytest
from fake_physics import Fake, grid, sweep
from PIL import Image
from right_grids import grid_of
from ruamel.yaml import YAML
from test_slot import GRID as SLOT

import clearsweep
from clearsweep.language.errors import InputError
from clearsweep.report.documents import page
from clearsweep.report.documents import page as live_page
from clearsweep.report.one_case.motion import crank_speed, history_of, motion_pictures, saved_channels
from clearsweep.report.sections.cases import DRAWN_HOUSING, DRAWN_PENETRATION, load_sketch, player_data
from clearsweep.report.study import prepare
from clearsweep.store import durable

CLEARANCE, LENGTH = 1e-4, 0.05
GUIDE = grid_of("a guide in the player")


def unpacked(text):
    return np.frombuffer(base64.b64decode(text), "<f4").astype(float)


def moving(source, tmp_path):
    """Return the study of a run of one case, the id of the case, its channels, and the player's data of its joint."""
    clearsweep.sweep(source, out=tmp_path / "run", executor="serial", show_progress=False)
    study = prepare(clearsweep.open(tmp_path / "run"))
    case_id = study.cases.index[0]
    path = saved_channels(study.run, case_id)
    return study, case_id, path, player_data(study, case_id, path).data["joints"][0]


@pytest.mark.slow
def test_a_block_is_shown_between_its_walls_which_its_ends_reach_and_hardly_cross(tmp_path):
    study, case_id, path, joint = moving(GUIDE, tmp_path)
    half_length, tilt = joint["walls"]["half_length"], unpacked(joint["walls"]["tilt"])
    assert half_length == LENGTH / 2
    np.testing.assert_allclose(tilt, path["slider/angle"], rtol=1e-6, atol=1e-12)
    assert np.ptp(tilt) > 1e-6
    farthest = np.max(np.abs(path["joints/slider_ground/y"]) + half_length * np.abs(np.sin(tilt)))
    assert CLEARANCE < farthest < 1.1 * CLEARANCE
    assert joint["magnified"] == pytest.approx(DRAWN_PENETRATION * CLEARANCE / (farthest - CLEARANCE), rel=0.06)
    assert not any("orbit" in picture.title for picture in motion_pictures(study, case_id, path))


def test_a_pin_in_a_slot_is_shown_between_walls_without_ends(tmp_path):
    source = copy.deepcopy(SLOT) | {"name": "slot"}
    study, case_id, path, joint = moving(source, tmp_path)
    assert joint["walls"]["half_length"] == 0.0
    assert not unpacked(joint["walls"]["tilt"]).any()
    assert not any("orbit" in picture.title for picture in motion_pictures(study, case_id, path))


def area(outline):
    """Return the area within a closed outline (n, 2)."""
    x, y = np.asarray(outline).T
    return 0.5 * abs(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


def test_a_slot_is_drawn_as_a_slot_on_its_body_and_the_animation_has_frames(tmp_path, monkeypatch):
    study, case_id, path, _ = moving(copy.deepcopy(SLOT) | {"name": "slot"}, tmp_path)
    (slot,) = [joint for joint in load_sketch(study, case_id).joints if joint.slot is not None]
    length, radius = (study.value(case_id, f"joints.{slot.name}.{key}") for key in ("slot_length", "bearing_radius"))
    assert area(slot.slot) == pytest.approx(2.0 * radius * length + np.pi * radius**2, rel=0.01)
    walls = [wall for body in player_data(study, case_id, path).data["bodies"] for wall in body["walls"]]
    assert [area(wall) for wall in walls] == pytest.approx([area(slot.slot)])
    monkeypatch.setattr(page, "FRAMES", 3)
    for ending in page.ANIMATIONS:
        content = page.animation_bytes(study, case_id, path, ending)
        with Image.open(io.BytesIO(content)) as image:
            assert image.n_frames == 3
        (tmp_path / f"case{ending}").write_bytes(content)
        durable.check_output(tmp_path / f"case{ending}")  # which may be replaced
    monkeypatch.setitem(sys.modules, "PIL", None)
    with pytest.raises(InputError, match="needs Pillow"):
        page.animation_bytes(study, case_id, path, ".gif")


@pytest.mark.slow
def test_a_start_up_is_over_time_from_its_beginning(tmp_path):
    source = YAML(typ="safe").load(Path(__file__).parents[1] / "configs/start_up.yaml")
    del source["sweep"]
    source["simulate"]["revolutions"] = 3
    study, case_id, path, _ = moving(source, tmp_path)
    time, turned = path["t"], np.ptp(path["crank_angle"])
    speed = crank_speed(history_of(study, case_id, path))
    assert (time[0], speed[0]) == (0.0, 0.0)
    assert np.trapezoid(speed, time) == pytest.approx(turned, rel=1e-3)
    data = player_data(study, case_id, path).data
    np.testing.assert_allclose(unpacked(data["time"]), time, rtol=1e-6)
    assert [chart["name"] for chart in data["charts"]][:2] == ["crank speed", "normal force"]
    assert data["charts"][0]["unit"] == "rpm"
    titles = [picture.title for picture in motion_pictures(study, case_id, path)]
    assert {"Crank speed", "Crank torque", "Normal force"} <= set(titles)


def test_a_journal_has_an_orbit_and_no_straight_walls(tmp_path):
    block = GUIDE["joints"]["slider-ground"]
    pin = {key: value for key, value in block.items() if key != "height"} | {"bearing_radius": 0.01}
    study, case_id, path, joint = moving(GUIDE | {"joints": {"rod-slider": pin}}, tmp_path)
    assert joint["walls"] is None
    assert any("orbit" in picture.title for picture in motion_pictures(study, case_id, path))


ROLLING = grid_of("a rolling bearing in the player")


@pytest.mark.slow
def test_the_player_turns_the_elements_of_each_bearing_and_moves_the_housing(tmp_path):
    """The loads along their elements add up to the force between the rings; 6205 has an element more than 6204."""
    clearsweep.sweep(ROLLING, out=tmp_path / "run", executor="serial", show_progress=False)
    study = prepare(clearsweep.open(tmp_path / "run"))
    counts = {"6204": 8, "6205": 9}
    for case_id in study.cases.index:
        path = saved_channels(study.run, case_id)
        data = player_data(study, case_id, path).data
        elements, (support,) = data["joints"][0]["elements"], data["ground"]
        name = study.cases.at(case_id, "joints.crank-rod.bearing")
        assert len(elements["loads"]) == counts[name]
        angles = unpacked(elements["angle"]) + 2.0 * np.pi * np.arange(counts[name])[:, None] / counts[name]
        loads = np.stack([*map(unpacked, elements["loads"])])
        resultant = np.abs((loads * np.exp(1j * angles)).sum(axis=0))
        force = np.asarray(path["joints/crank_rod/force_normal"])
        largest = force[force.argmax()] / resultant[force.argmax()]
        assert largest * resultant == pytest.approx(force, abs=1e-4 * force.max())
        assert unpacked(support["x"]) == pytest.approx(path["joints/ground_crank/mount_x"], rel=1e-6, abs=1e-12)
        drawn = support["magnified"] * np.hypot(unpacked(support["x"]), unpacked(support["y"])).max()
        assert 0.5 * DRAWN_HOUSING < drawn / 0.17 < 1.5 * DRAWN_HOUSING


# `run --watch`: the page of what is finished is whole at all times, reloads itself, and ends as the normal page.


ROOT = Path(__file__).parents[1]


def test_the_page_of_a_run_without_finished_cases_reloads_itself(tmp_path):
    directory, out, drawn = tmp_path / "run", tmp_path / "run/report.html", []

    class Drawing(Fake):
        @staticmethod
        def solve(case, log=None):
            """Draw the page of the run in which this case is."""
            drawn.append(live_page.draw_page(directory, out, None))
            drawn.append(live_page.draw_page(directory, out, drawn[-1]))
            return fake_physics.trajectory(case)

    sweep(grid(1), directory, executor="serial", show_progress=False, simulator=Drawing)
    text = out.read_text(encoding="utf-8")
    assert drawn == [[0, 0], [0, 0]]
    assert '<meta http-equiv="refresh" content="5">' in text.partition("</head>")[0]
    assert "under way" in text.partition("<h1>")[0]
    modified = out.stat().st_mtime_ns
    assert live_page.draw_page(directory, out, None) is None  # the run has ended
    assert out.stat().st_mtime_ns == modified


@pytest.mark.slow
def test_a_watched_run_has_a_whole_page_at_all_times_and_ends_with_the_normal_one(tmp_path):
    source = YAML().load(ROOT / "configs/slider_crank_restitution.yaml")
    source["sweep"] = {"drive.speed": [f"{speed} rpm" for speed in range(1000, 5000, 50)]}
    source["simulate"] = {"revolutions": 200, "discard": 5}
    source["save"] = {"orbits": "none"}
    YAML().dump(source, tmp_path / "grid.yaml")
    command = [sys.executable, "-m", "clearsweep", "run", "grid.yaml", "-j", "1", "--out", "run"]
    page, seen = tmp_path / "run/report.html", set()
    with subprocess.Popen([*command, "--watch"], cwd=tmp_path, stderr=subprocess.PIPE, text=True) as run:
        while run.poll() is None:
            if page.exists():
                text = page.read_text(encoding="utf-8")
                assert text.rstrip().endswith("</html>")
                seen.add((live_page.REFRESH in text, "under way" in text, 'id="trust"' in text))
            time.sleep(0.1)
        errors = run.stderr.read()
    assert run.returncode == 0, errors
    assert "watch run/report.html" in errors
    assert (True, True, True) in seen  # with finished cases, before the end
    last = page.read_bytes()
    report = [sys.executable, "-m", "clearsweep", "report", "run", "--json"]
    named = json.loads(subprocess.run(report, cwd=tmp_path, capture_output=True, check=True).stdout)
    assert (tmp_path / named["report"]).read_bytes() == last
