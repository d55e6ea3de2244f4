"""The wheel is all that a user needs: built without git, installed into an empty environment, used there."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PYTHONS = ("3.11", "3.12", "3.13")
LEFT_OUT = shutil.ignore_patterns(".git", ".venv*", "build", "dist", "*.egg-info", "__pycache__", "results", ".*_cache")


def done(command: list, place: Path, **environment: str) -> str:
    """Return what a command prints; it finds no program but those named by their path, and no module of this tree."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA"))}
    result = subprocess.run(
        [str(word) for word in command],
        cwd=place,
        env=kept | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=900,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def interpreter(version: str) -> Path:
    """Return a Python of this version: this one, one on the path, or one that pyenv keeps."""
    names = [sys.executable] if version == f"{sys.version_info[0]}.{sys.version_info[1]}" else []
    names += [name] if (name := shutil.which(f"python{version}")) else []
    names += sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python"))
    for name in names:  # pyenv puts a name on the path that says no where the version is not chosen
        asked = subprocess.run([name, "-c", "import ensurepip, venv"], capture_output=True, check=False)
        if asked.returncode == 0:
            return Path(name)
    pytest.skip(f"there is no Python {version} here")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Return the wheel, built from a copy of the sources that is no repository, with no git to be found."""
    place = tmp_path_factory.mktemp("wheel")
    shutil.copytree(ROOT, place / "source", ignore=LEFT_OUT)
    (place / "bin").mkdir()
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", place, place / "source"]
    done(command, place, PATH=str(place / "bin"))
    (built,) = place.glob("*.whl")
    return built


@pytest.mark.slow
@pytest.mark.parametrize("version", PYTHONS)
def test_the_wheel_runs_in_an_empty_environment(wheel, version, tmp_path):
    done([interpreter(version), "-m", "venv", "venv"], tmp_path)
    programs = tmp_path / "venv" / "bin"
    done([programs / "pip", "install", "--quiet", "--constraint", ROOT / "constraints.txt", wheel], tmp_path)
    place, home = tmp_path / "work", {"PATH": str(programs), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    place.mkdir()
    command = programs / "clearsweep"
    assert (
        done([programs / "python", "-c", "import sys; print(*sys.version_info[:2], sep='.')"], place).strip() == version
    )
    done([command, "init", "grid.yaml"], place, **home)
    done([command, "run", "grid.yaml", "--out", "run", "--jobs", "1"], place, **home)
    done([command, "report", "run"], place, **home)
    page = (place / "run" / "report.html").read_text(encoding="utf-8")
    assert "<svg" in page
    assert "cases" in done([command, "run", "grid.yaml", "--out", "run"], place, **home)
