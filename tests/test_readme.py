"""The README shows what is there: its grid, its commands, its table, its program."""

import re
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from clearsweep.cli import verbs

pytestmark = pytest.mark.heavy

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(mark):
    """Return the fenced block after a mark."""
    return re.search(rf"<!-- {re.escape(mark)} -->\n```\w+\n(.*?)```", README, re.DOTALL).group(1)


def test_the_grid_shown_is_the_one_that_make_run_runs():
    assert block("grid: configs/slider_crank.yaml") == (ROOT / "configs/slider_crank.yaml").read_text(encoding="utf-8")
    assert "configs/slider_crank.yaml" in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_every_command_is_named_and_every_command_named_exists():
    page = (ROOT / "docs/commands.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^\| `clearsweep (\w+)", page, re.MULTILINE))
    assert named == set(verbs.commands)
    for name in named:
        message = CliRunner().invoke(verbs, [name, "--help"])
        assert message.exit_code == 0
        assert len(message.output.splitlines()) > 4


def test_links_and_figures_exist():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


@pytest.fixture(scope="module")
def small_run(tmp_path_factory):
    """Return a folder with the configs and the results of a thinned version of the README's sweep."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copytree(ROOT / "configs", folder / "configs")
    grid = (ROOT / "configs/slider_crank.yaml").read_text(encoding="utf-8")
    thin = re.sub(
        r"drive\.speed: .*", "drive.speed: [1000 rpm, 2000 rpm]", grid.replace("revolutions: 10,", "revolutions: 3,")
    )
    (folder / "configs/slider_crank.yaml").write_text(thin, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        message = CliRunner().invoke(verbs, ["run", "configs/slider_crank.yaml", "-j", "1"])
    assert message.exit_code == 0, message.output
    return folder, message.stdout


def test_a_run_prints_the_table_that_is_shown(small_run):
    shown, printed = block("output: clearsweep run configs/slider_crank.yaml"), small_run[1]
    heads = [
        re.split(r"  +", line.strip()) for text in (shown, printed) for line in text.splitlines() if "case_id" in line
    ]
    assert len(heads) == 2
    assert heads[0] == heads[1]
    assert re.search(r"^\d+ cases ran in .*: \d+ ok, 0 failed$", shown, re.MULTILINE)
    assert re.search(r"^\d+ cases ran in .*: \d+ ok, 0 failed$", printed, re.MULTILINE)
    assert shown.strip().splitlines()[-1] == printed.strip().splitlines()[-1]


def test_the_program_shown_runs(small_run, monkeypatch, capsys):
    monkeypatch.chdir(small_run[0])
    exec(compile(block("python"), "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("ok ")
