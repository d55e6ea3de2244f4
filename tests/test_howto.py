"""The how-tos: each is found from the guide, and its grids print what the page shows."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

from clearsweep.cli import verbs

ROOT = Path(__file__).parents[1]
PAGES = sorted((ROOT / "docs/howto").glob("*.md"))
MARK = "<!-- output -->\n"


def grids(text):
    """Yield (grid, lines) of each grid of a page with an output that follows it."""
    for block, output in re.findall(
        rf"^```yaml\n((?:(?!^```).*\n)*)```\n(?:(?!^```).*\n)*{MARK}```text\n((?:(?!^```).*\n)*)```", text, re.MULTILINE
    ):
        yield block, [line for line in output.splitlines() if line]


def test_the_guide_leads_to_every_how_to():
    guide = (ROOT / "docs/guide.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\]\(howto/([\w-]+\.md)\)", guide)) == {page.name for page in PAGES}


def test_every_output_follows_a_grid():
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    assert sum(text.count(MARK) for text in texts) == sum(len(list(grids(text))) for text in texts) > 10


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [page for page in PAGES if MARK in page.read_text(encoding="utf-8")], ids=lambda p: p.stem
)
def test_a_grid_of_a_how_to_prints_what_the_page_shows(page, tmp_path, monkeypatch):
    monkeypatch.chdir(ROOT / "configs")
    for block, lines in grids(page.read_text(encoding="utf-8")):
        whole = YAML(typ="safe").load((ROOT / "configs/slider_crank.yaml").read_text(encoding="utf-8"))
        del whole["sweep"]
        for key, value in YAML(typ="safe").load(block).items():
            whole[key] = {**whole[key], **value} if key in whole else value
        grid = tmp_path / f"{len(list(tmp_path.iterdir()))}.yaml"
        YAML(typ="safe").dump(whole, grid)
        result = CliRunner().invoke(verbs, ["run", str(grid), "--out", str(grid.with_suffix("")), "-j", "1"])
        assert result.exit_code == 0, result.output
        printed = [line.rstrip() for line in result.stdout.splitlines()]
        assert [line for line in lines if line not in printed] == []
