"""The how-tos: each is found from the guide, and its grids print what the page shows."""

import re
import runpy
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from clearsweep import cli

ROOT = Path(__file__).parents[1]
PRINTED = runpy.run_path(str(ROOT / "docs/tools/printed.py"))
PAGES = PRINTED["HOWTOS"]


def test_the_guide_leads_to_every_how_to():
    guide = (ROOT / "docs/guide.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\]\(howto/([\w-]+\.md)\)", guide)) == {page.name for page in PAGES}


def test_every_output_follows_a_grid():
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    matches = sum(len(list(PRINTED["examples"](page))) for page in PAGES)
    assert sum(text.count(PRINTED["MARK"]) for text in texts) == matches > 10


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if list(PRINTED["examples"](page))], ids=lambda p: p.stem)
def test_a_grid_of_a_how_to_prints_what_the_page_shows(page):
    for example in PRINTED["examples"](page):
        assert PRINTED["missing"](example.shown, PRINTED["printed"](example)) == []


@pytest.mark.slow
def test_limits_decide_the_exit_code_as_the_how_to_shows(tmp_path, monkeypatch, capsys):
    page = ROOT / "docs/howto/ci.md"
    (example,) = PRINTED["examples"](page)
    YAML(typ="safe").dump(example.grid, tmp_path / "grid.yaml")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        cli.main(["run", "grid.yaml", "-j", "1", "--fail-on-limits"])
    assert ended.value.code == 5
    assert f"```text\n{capsys.readouterr().err.splitlines()[-1]}\n```" in page.read_text(encoding="utf-8")


def test_a_line_that_is_no_longer_printed_is_replaced_by_the_one_most_like_it():
    shown = "3 cases ran in 2 s\n  a  1.5 kN\n  b  2.0 kN\n"
    lines = ["3 cases ran in 9 s", "  a  1.7 kN", "  b  2.0 kN", "  c  3.0 kN"]
    assert PRINTED["missing"](shown, lines) == ["  a  1.5 kN"]
    assert PRINTED["renewed"](shown, lines) == "3 cases ran in 2 s\n  a  1.7 kN\n  b  2.0 kN\n"
