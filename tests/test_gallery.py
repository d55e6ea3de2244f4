"""The gallery: its grids are those of configs/, print what the page shows, and look like its pictures."""

import re
import runpy
from pathlib import Path

import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

from clearsweep.cli import verbs

ROOT = Path(__file__).parents[1]
PRINTED = runpy.run_path(str(ROOT / "docs/tools/printed.py"))
PAGE = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
ENTRIES = re.findall(
    r"!\[[^]]*\]\(gallery/(\w+)\.svg\)\n(?:.*\n)*?```text\n((?:(?!```).*\n)*)```\n(?:.*\n)*?"
    r"<!-- output: (\w+) -->\n```text\n((?:(?!```).*\n)*)```",
    PAGE,
)


def test_every_machine_of_the_gallery_has_picture_grid_and_output():
    assert [(picture, output) for picture, _, output, _ in ENTRIES] == [
        (name, name) for name in ("wiper", "pump", "engine")
    ]
    for grid in re.findall(r"`(configs/\w+\.yaml)`", PAGE):
        assert (ROOT / grid).is_file()


@pytest.mark.parametrize(("name", "part"), [(name, part) for name, part, _, _ in ENTRIES])
def test_what_the_page_shows_of_a_grid_is_in_its_file(name, part):
    whole = YAML(typ="safe").load((ROOT / f"configs/{name}.yaml").read_text(encoding="utf-8"))
    for key, value in YAML(typ="safe").load(part).items():
        assert whole[key] == value


@pytest.mark.parametrize("name", [name for name, *_ in ENTRIES])
def test_a_picture_is_what_draw_makes_of_the_grid(name, tmp_path):
    drawn = tmp_path / f"{name}.svg"
    result = CliRunner().invoke(verbs, ["draw", str(ROOT / f"configs/{name}.yaml"), "--out", str(drawn)])
    assert result.exit_code == 0, result.output
    assert drawn.read_text(encoding="utf-8") == (ROOT / f"docs/gallery/{name}.svg").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_grid_of_the_gallery_prints_what_the_page_shows():
    for example in PRINTED["examples"](ROOT / "docs/gallery.md"):
        assert PRINTED["missing"](example.shown, PRINTED["printed"](example)) == []
