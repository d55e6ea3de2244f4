"""The rooms of the package and the direction of imports between them: an import the wrong way is found."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def lint(place: Path) -> subprocess.CompletedProcess:
    """Return what import-linter says of the copy of the package in `place`."""
    command = [sys.executable, "-c", "import sys; from importlinter.cli import lint_imports_command as run; run()"]
    return subprocess.run([*command, "--no-cache"], cwd=place, capture_output=True, text=True, check=False, timeout=120)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    place = tmp_path_factory.mktemp("house")
    shutil.copy(ROOT / "pyproject.toml", place)
    shutil.copytree(ROOT / "clearsweep", place / "clearsweep", ignore=shutil.ignore_patterns("__pycache__"))
    return place


def test_the_imports_of_the_package_point_one_way(copy):
    told = lint(copy)
    assert told.returncode == 0, told.stdout


@pytest.mark.parametrize(
    ("file", "planted"),
    [
        ("mechanics/joint/dry.py", "from ...grid import load"),
        ("grid/grid.py", "from ..mechanics import rates"),
        ("report/study.py", "import numba"),
        ("store/batch.py", "from ..sweeping import sweep"),
        ("results.py", "from .store import Run"),
    ],
)
def test_a_planted_import_the_wrong_way_is_found(copy, file, planted):
    source = copy / "clearsweep" / file
    before = source.read_text()
    source.write_text(f"{before}\n{planted}\n")
    try:
        told = lint(copy)
    finally:
        source.write_text(before)
    assert told.returncode != 0
    assert "BROKEN" in told.stdout


def test_no_module_imports_another_by_its_name_in_a_string():
    found = [
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "clearsweep").rglob("*.py")
        if "import_module" in path.read_text() or "__import__" in path.read_text()
    ]
    assert found == ["clearsweep/__init__.py"]  # public names are resolved when they are first used
