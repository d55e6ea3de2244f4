"""`run --watch`: the page of what is finished is whole at all times, reloads itself, and ends as the normal page."""

import json
import subprocess
import sys
import time
from pathlib import Path

import fake_physics
import pytest
from fake_physics import Fake, grid, sweep
from ruamel.yaml import YAML

from clearsweep.report.documents import page as live_page

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
