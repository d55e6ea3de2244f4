"""The default directory of a grid: an earlier run of another grid is moved aside, never deleted; reports of grids."""

import shutil
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner
from fake_physics import GOOD, Fake, grid, sweep

import clearsweep
from clearsweep import cli
from clearsweep.language.errors import DirectoryError
from clearsweep.sweeping import estimate
from clearsweep.sweeping.sweep import latest_run

pytestmark = pytest.mark.heavy


def run(source, out=None, **options):
    return sweep(source, out, executor="serial", **options)


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != "lock")
    return {path.relative_to(folder): path.read_bytes() for path in files}


def test_the_run_of_another_grid_is_moved_aside_in_one_line(here, capfd):
    first = run(grid(2), show_progress=False)
    kept = {path: path.read_bytes() for path in first.directory.rglob("*.parquet")}
    capfd.readouterr()
    changed = grid(2, drive={"speed": "3000 rpm"})
    second = run(changed)
    name = first.directory.name
    (line,) = [line for line in capfd.readouterr().err.splitlines() if "contained" in line]
    assert line == f"results/{name} contained the run of another grid (drive.speed), which is now in results/{name}-2"
    assert second.directory == first.directory
    assert second.ran == 2
    moved = Path(f"results/{name}-2")
    assert {moved / path.relative_to(first.directory): content for path, content in kept.items()}.items() <= {
        path: path.read_bytes() for path in moved.rglob("*.parquet")
    }.items()
    assert len(clearsweep.open(moved).summary) == 2
    run(grid(2, drive={"speed": "4000 rpm"}), show_progress=False)
    assert sorted(path.name for path in Path("results").iterdir()) == [name, f"{name}-2", f"{name}-3"]


def test_fresh_moves_an_equal_run_aside_too(here):
    assert run(grid(2), show_progress=False).ran == 2
    assert run(grid(2), show_progress=False).ran == 0
    again = run(grid(2), show_progress=False, fresh=True)
    assert again.ran == 2
    assert Path(f"{again.directory}-2").is_dir()


def test_a_directory_that_was_named_is_not_moved_unless_asked(here):
    run(grid(2), "mine", show_progress=False)
    before = contents(here / "mine")
    with pytest.raises(DirectoryError, match=r"another grid.*--out, or move it aside with --fresh"):
        run(grid(2, drive={"speed": "3000 rpm"}), "mine", show_progress=False)
    assert contents(here / "mine") == before
    run(grid(2, drive={"speed": "3000 rpm"}), "mine", show_progress=False, fresh=True)
    assert Path("mine-2").is_dir()


def test_a_dry_run_does_not_look_at_results(here):
    before = estimate.estimate(grid(2), jobs=1, simulator=Fake)
    run(grid(2), show_progress=False)
    directory = next(Path("results").iterdir())
    (directory / "run.json").write_text("damaged", encoding="utf-8")
    after = estimate.estimate(grid(2, (GOOD,), drive={"speed": "3000 rpm"}), jobs=1, simulator=Fake)
    assert (before.cases, before.pending) == (after.cases, after.pending) == (2, 2)


GRID = Path(__file__).parent.parent / "configs/impact_pair.yaml"


def test_the_report_of_a_grid_file_is_that_of_its_latest_run(here):
    shutil.copy(GRID, "pair.yaml")
    command = CliRunner()
    missing = command.invoke(cli.verbs, ["report", "pair.yaml"])
    assert "contains no run of pair.yaml; `clearsweep run pair.yaml` makes one" in str(missing.exception)
    clearsweep.sweep("pair.yaml", executor="serial", show_progress=False)
    directory, changed = latest_run(Path("pair.yaml"))
    assert changed == ""
    assert directory.parent == Path("results")
    content = yaml.safe_load(Path("pair.yaml").read_text(encoding="utf-8"))
    content["mechanism"]["speed"] = "1.5 m/s"
    content["limits"] = {"pair_force_peak": "1 kN"}
    Path("pair.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    _, changed = latest_run(Path("pair.yaml"))
    assert changed.startswith(f"pair.yaml has changed since the run in {directory}: ")
    assert "mechanism.speed" in changed
    assert "limits.pair_force_peak" in changed
