"""The wheel is all that a user needs: built without git, installed into an empty environment, used there."""

import os
import platform
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import clearsweep
from clearsweep.tracing.cache import compiler_stamp
from clearsweep.tracing.objects import LEVELS

ROOT = Path(__file__).parents[1]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
LEFT_OUT = shutil.ignore_patterns(".git", ".venv*", "build", "dist", "*.egg-info", "__pycache__", "results", ".*_cache")


def done(command: list, place: Path, **environment: str) -> str:
    """Return what a command prints; it finds no program but those named by their path, and no module of this tree."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "CLEARSWEEP"))}
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


def build(place: Path) -> list[Path]:
    """Return the wheel and the sdist, built from a copy of the sources that is no repository, with no git to be found.

    The wheel is built of what is in the sdist.
    """
    shutil.copytree(ROOT, place / "source", ignore=LEFT_OUT)
    (place / "bin").mkdir()
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", place / "dist", place / "source"]
    done(command, place, PATH=str(place / "bin"))
    return sorted((place / "dist").iterdir(), key=lambda path: path.suffix, reverse=True)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Return the wheel of this platform."""
    return build(tmp_path_factory.mktemp("wheel"))[0]


def test_windows_is_refused_with_what_to_use():
    script = "import os; os.name = 'nt'; import clearsweep"
    result = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "clearsweep does not run on Windows" in result.stderr
    assert "WSL 2" in result.stderr


@pytest.mark.parametrize("name", ["linux-aarch64", "linux-sparc"])
def test_a_wheel_of_another_platform_is_tagged_or_refused(name):
    script = "import hatch_build; print(*hatch_build.wanted())"
    result = subprocess.run(
        [sys.executable, "-c", script],
        cwd=ROOT,
        env=os.environ | {"CLEARSWEEP_PLATFORM": name},
        capture_output=True,
        text=True,
        check=False,
    )
    if name == "linux-aarch64":
        assert result.stdout == "('aarch64',) manylinux_2_17_aarch64\n"
    else:
        assert "CLEARSWEEP_PLATFORM is linux-sparc; code can be made here for: linux-x86_64" in result.stderr


@pytest.mark.slow
def test_the_sdist_builds_the_same_wheel_with_what_it_asks_for_alone(wheel, tmp_path):
    (sdist,) = wheel.parent.glob("*.tar.gz")
    done([sys.executable, "-m", "venv", "venv"], tmp_path)
    done([tmp_path / "venv/bin/pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", "built", sdist], tmp_path)
    (other,) = (tmp_path / "built").glob("*.whl")
    assert other.name == wheel.name
    first, second = (set(zipfile.ZipFile(path).namelist()) for path in (wheel, other))
    # another release of llvmlite gives another stamp
    assert {name for name in first if "/objects/" not in name} == {name for name in second if "/objects/" not in name}
    assert sum("/objects/" in name for name in first) == sum("/objects/" in name for name in second)


@pytest.mark.slow
def test_two_builds_are_the_same_bytes(wheel, tmp_path):
    first, second = (wheel, next(wheel.parent.glob("*.tar.gz"))), build(tmp_path)
    assert [path.name for path in first] == [path.name for path in second]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


@pytest.mark.slow
def test_the_wheel_has_types_one_version_and_the_loop_of_these_sources(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert "clearsweep/py.typed" in names
    assert wheel.name.startswith(f"clearsweep-{clearsweep.__version__}-py3-none-")
    if sys.platform == "linux" and platform.machine() == "x86_64":
        assert wheel.name.endswith("-manylinux_2_17_x86_64.whl")
        of_loop = [name for name in names if f"mechanics/objects/{compiler_stamp()}/integrate_at-" in name]
        assert sum(name.endswith(".o") for name in of_loop) == len(LEVELS)
        assert sum(name.endswith(".json") for name in of_loop) == len(LEVELS)


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
    kept = [path.name for path in (tmp_path / "cache").rglob("*.o")]
    assert kept  # the kind of scene was compiled here
    assert not [name for name in kept if name.startswith("integrate_at")]  # the loop came with the wheel
    page = (place / "run" / "report.html").read_text(encoding="utf-8")
    assert "<svg" in page
    assert "cases" in done([command, "run", "grid.yaml", "--out", "run"], place, **home)
