"""The template of a workflow runs what there is here, and keeps what that writes."""

import os
import re
import subprocess
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def steps():
    """Return the steps of the template."""
    workflow = YAML(typ="safe").load((ROOT / "docs/workflow.yaml").read_text(encoding="utf-8"))
    (job,) = workflow["jobs"].values()
    return job["steps"]


def step_of(steps, action):
    """Return the settings of the step that uses an action."""
    (step,) = (step for step in steps if step.get("uses", "").startswith(f"actions/{action}@"))
    return step["with"]


def test_the_report_that_make_run_writes_is_kept(steps):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    (reported,) = re.findall(r"^\t\$\(BIN\)/clearsweep report (\S+)$", makefile, re.MULTILINE)
    assert any(re.search(r"\bmake run\b", step.get("run", "")) for step in steps)
    assert step_of(steps, "upload-artifact")["path"] == f"{reported}/report.html"


def test_the_key_of_the_cache_follows_from_all_that_compiled_code_depends_on(steps):
    settings = step_of(steps, "cache")
    assert settings["path"] == "~/.cache/clearsweep"
    patterns = re.findall(r"'([^']+)'", settings["key"])
    covered = {path for pattern in patterns for path in ROOT.glob(pattern)}
    assert covered >= {*(ROOT / "clearsweep/mechanics").rglob("*.py"), ROOT / "constraints.txt"}
    assert re.search(r"^llvmlite==", (ROOT / "constraints.txt").read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.slow
def test_every_command_runs_in_a_fresh_clone(steps, tmp_path):
    """With an empty home and a bare environment, as on a runner; only the actions of the service are left out."""
    clone, home = tmp_path / "clone", tmp_path / "home"
    home.mkdir()
    subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
    kept = {name: os.environ[name] for name in os.environ if name.upper().startswith(("PATH", "LANG", "PIP_", "HTTP"))}
    for step in steps:
        if "run" in step:
            command = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]]
            environment = kept | {"HOME": str(home), "CI": "true"}
            done = subprocess.run(command, cwd=clone, env=environment, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{step['run']}\n{done.stdout}\n{done.stderr}"
    assert (clone / step_of(steps, "upload-artifact")["path"]).is_file()
