"""The site of the documentation builds without a warning, needs no network, and its search answers from the disk."""

import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import clearsweep

ROOT = Path(__file__).parents[1]
LOADED = re.compile(r'<(?:script|img|iframe)\b[^>]*\bsrc="([^"]*)"|<link\b[^>]*\bhref="([^"]*)"')


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return the directory of the site; any warning is an error."""
    place = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--site-dir", str(place)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return place


@pytest.mark.slow
def test_pages_load_nothing_from_a_network_and_all_that_they_load_exists(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 20
    for page in pages:
        loaded = [a or b for a, b in LOADED.findall(page.read_text(encoding="utf-8"))]
        assert len(loaded) >= 3, page  # the style, the index and the search
        missing = [path for path in loaded if path.startswith(("http", "//")) or not (page.parent / path).exists()]
        assert missing == [], page


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "query", "location"),
    [("index.html", "truncated-normal", "grid.html#"), ("reference/public.html", "load_case", "public.html#")],
)
def test_the_search_answers_where_a_page_is_opened_from_the_disk(site, tmp_path, page, query, location):
    browser = shutil.which("chromium")
    if browser is None and not os.environ.get("CI"):
        pytest.skip("chromium is not installed")
    assert browser, "chromium is not installed: apt-get install chromium"
    flags = ("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking")
    done = subprocess.run(
        [
            *(browser, *flags, f"--user-data-dir={tmp_path}", "--virtual-time-budget=4000", "--dump-dom"),
            f"{(site / page).as_uri()}?q={query}",
        ],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    results = re.search(r'<section id="results".*?</section>', done.stdout, re.DOTALL)[0]
    targets = re.findall(r'<a href="([^"]*)"', results)
    assert any(location in target for target in targets), targets
    for target in targets:
        file, _, anchor = target.partition("#")
        text = ((site / page).parent / file).read_text(encoding="utf-8")
        assert not anchor or f'id="{anchor}"' in text, target


def test_every_public_name_has_an_entry_in_the_reference(monkeypatch):
    pytest.importorskip("mkdocs")
    monkeypatch.syspath_prepend(str(ROOT / "docs/tools"))
    page = runpy.run_path(str(ROOT / "docs/tools/site.py"))["public"]()
    names = set(clearsweep.__all__) - {"MODEL_VERSION", "__version__"}
    assert names == set(re.findall(r"^### `(\w+)`$", page, re.MULTILINE))
