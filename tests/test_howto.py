"""The how-tos: each is found from the guide, and its grids print what the page shows."""

import re
import runpy
from pathlib import Path

import pytest

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


def test_a_line_that_is_no_longer_printed_is_replaced_by_the_one_most_like_it():
    shown = "3 cases ran in 2 s\n  a  1.5 kN\n  b  2.0 kN\n"
    lines = ["3 cases ran in 9 s", "  a  1.7 kN", "  b  2.0 kN", "  c  3.0 kN"]
    assert PRINTED["missing"](shown, lines) == ["  a  1.5 kN"]
    assert PRINTED["renewed"](shown, lines) == "3 cases ran in 2 s\n  a  1.7 kN\n  b  2.0 kN\n"
