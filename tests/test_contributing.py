"""Each change that CONTRIBUTING.md shows is made in a copy of the repository; the commands after it run there."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import clearsweep

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
CHANGES = {
    match[1]: (match[2], match[3])
    for match in re.finditer(
        r"^<!-- change: (\w+) -->\n```diff\n(.*?)^```\n(?:(?!^<!-- ).)*?^```console\n(.*?)^```",
        TEXT,
        re.MULTILINE | re.DOTALL,
    )
}


def run(words, place):
    """Return what a command says, run as plain Python in a copy of the repository; it has to succeed."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(place),
        "CLEARSWEEP_DISABLE_JIT": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    done = subprocess.run(words, cwd=place, env=environment, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_change_shown_is_made_here():
    assert list(CHANGES) == list(SAID)
    assert TEXT.count("```diff") == len(CHANGES)


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_still_fits_the_sources(name, tmp_path):
    (tmp_path / "change.diff").write_text(CHANGES[name][0], encoding="utf-8")
    command = ["git", "apply", "--check", str(tmp_path / "change.diff")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_a_change_works(name, tmp_path):
    change, commands = CHANGES[name]
    for part in ("clearsweep", "tests", "configs"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    for part in ("pyproject.toml", "README.md", "Makefile"):
        shutil.copy(ROOT / part, tmp_path)
    (tmp_path / "change.diff").write_text(change, encoding="utf-8")
    run(["git", "apply", "--verbose", "change.diff"], tmp_path)
    programs = {"clearsweep": [sys.executable, "-m", "clearsweep"], "python": [sys.executable]}
    text = ""
    for line in commands.splitlines():
        words = shlex.split(line.removeprefix("$ "), comments=True)
        if "CASE_ID" in words:  # of the one case of the run that is named before it
            directory = tmp_path / words[words.index("CASE_ID") - 1]
            words[words.index("CASE_ID")] = clearsweep.open(directory).summary["case_id"][0]
        text += run([*programs[words[0]], *words[1:]], tmp_path)
    assert SAID[name] <= set(re.findall(r"[\w-]+", text))


#: What has to be in what the commands say.
SAID = {
    "law": {"arctan", "tanh", "passed"},
    "mechanism": {"falling-mass", "slot", "html", "passed"},
    "figure": {"pair_force_crest", "float64"},
    "section": {"case_id", "steps"},
    "search": {"Within", "speed", "Index"},
    "option": {"polite", "2"},
}
