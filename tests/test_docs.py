"""The documentation shows what is there: its commands, programs, grids, links, pictures and figures of merit."""

import inspect
import re
import runpy
import shlex
import shutil
import sys
import types
from pathlib import Path

import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

import clearsweep
from clearsweep import grid
from clearsweep.cli import verbs
from clearsweep.contracts import layout
from clearsweep.simulation.scene import catalogue
from clearsweep.sweeping.sweep import sweep

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
MARKED = ("README.md", "docs/tutorial.md", "docs/rig.md")  # whose blocks that have a mark tests of their own look at
TEXTS = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in PAGES}


def blocks(*languages):
    """Return every fenced block in one of these languages, but those that tests of their page run."""
    result = []
    for page, text in TEXTS.items():
        for match in re.finditer(r"(<!-- .* -->\n)?^```(\w+)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            if match[2] in languages and not (match[1] and page in MARKED):
                result.append(pytest.param(match[3], id=f"{page}:{text[: match.start()].count(chr(10)) + 1}"))
    return result


def commands(block):
    """Return the commands of a block of a shell, without comments, joined where a line goes on."""
    lines = block.replace("\\\n", " ").splitlines()
    return [shlex.split(line.removeprefix("$ "), comments=True) for line in lines if line.strip()]


@pytest.fixture
def place(tmp_path, monkeypatch):
    """Return a working directory with the grids of the repository."""
    shutil.copytree(ROOT / "configs", tmp_path / "configs")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("block", blocks("console", "bash"))
def test_commands_are_there_and_take_these_options(block, monkeypatch):
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for words in commands(re.sub(r"\$(\{\{.*?\}\}|\w+)", "1", block)):
        if words[:1] == ["make"]:
            assert words[1] in targets
        elif words[:1] == ["clearsweep"]:
            command = verbs.commands[words[1]]
            command.make_context(words[1], words[2:])
        elif words:
            assert words[0] in ("python", "git")


@pytest.mark.parametrize("block", [each for each in blocks("console") if not each.id.startswith("CONTRIBUTING")])
def test_what_a_console_shows_runs(block, place):
    for words in commands(block):
        if words[:2] == ["clearsweep", "laws"]:
            done = CliRunner().invoke(verbs, words[1:])
            assert done.exit_code == 0, done.output
            assert done.output.strip()


@pytest.mark.parametrize("block", blocks("python"))
def test_programs_run(block, place, monkeypatch, capsys):
    asked = []

    def record(*arguments, **options):
        asked.append(inspect.signature(sweep).bind(*arguments, **options))

    cluster = types.SimpleNamespace(scale=int, scheduler_address="tcp://a:1")
    monkeypatch.setitem(
        sys.modules, "dask_jobqueue", types.SimpleNamespace(SLURMCluster=lambda **options: cluster)
    )  # of a scheduler that is not here
    monkeypatch.setattr(clearsweep, "sweep", record, raising=False)
    exec(compile(block, "docs", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip() or asked


@pytest.mark.parametrize("block", blocks("yaml"))
def test_grids_are_read(block, place, monkeypatch):
    monkeypatch.chdir(ROOT / "configs")  # where the tables are that they name
    whole = YAML(typ="safe").load((ROOT / "configs/slider_crank.yaml").read_text(encoding="utf-8"))
    del whole["sweep"]
    for key, value in YAML(typ="safe").load(block).items():
        whole[key] = {**whole[key], **value} if key in whole else value
    assert len(grid.load(whole, catalogue())) >= 1


def anchors(text):
    """Return the anchors of the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", TEXTS)
def test_links_lead_somewhere(page):
    for target, anchor in re.findall(r"\]\(([^)#]*)#?([^)]*)\)", TEXTS[page]):
        if target.startswith("http"):
            continue
        path = ((ROOT / page).parent / target).resolve() if target else ROOT / page
        assert path.exists(), target
        assert not anchor or anchor in anchors(path.read_text(encoding="utf-8")), f"{target}#{anchor}"


@pytest.mark.parametrize("page", TEXTS)
def test_commands_and_files_named_in_a_text_are_there(page):
    text = TEXTS[page]
    assert set(re.findall(r"`clearsweep (\w+)", text)) <= set(verbs.commands)
    if page == "CHANGELOG.md":
        return  # of the past
    for name in re.findall(r"`((?:clearsweep|tests|docs|configs|results)/[\w/.]+\.\w+)`", text):
        written = name.startswith("results/slider-crank-clearance")  # by a run
        assert written or (ROOT / name).exists(), name


def test_every_file_of_the_map_is_there():
    table = TEXTS["docs/design.md"].partition("## Where to change what")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (.+?) \| (.+) \|$", table, re.MULTILINE)[2:]
    assert len(rows) > 30
    for what, where in rows:
        named = re.findall(r"`([\w/.]+(?:/|\.(?:py|j2|css)))`", where)
        assert named, what
        home = ROOT / "clearsweep" / Path(named[0]).parent
        for path in named:
            assert (ROOT / "clearsweep" / path).exists() or (home / path).exists(), f"{what}: {path}"


def test_every_figure_is_defined():
    known = set(re.findall(r"^\| `(\w+)`", layout.markdown(catalogue()), re.MULTILINE))
    table = TEXTS["docs/model.md"].partition("## Figures of merit")[2].partition("\n## ")[0]
    defined = {
        name for row in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)
    }
    assert known == defined - {"F_difference"}
    assert len(known) > 20


@pytest.mark.parametrize("room", ["mechanism", "joint"])
def test_every_family_of_a_contract_is_described(room):
    source = (ROOT / f"clearsweep/mechanics/{room}/contract.py").read_text(encoding="utf-8")
    families = re.findall(r"^@family\ndef (\w+)", source, re.MULTILINE)
    assert families
    assert not [name for name in families if f"`{name}(" not in TEXTS["docs/design.md"]]


def test_the_picture_shows_the_rooms_that_there_are():
    drawn = runpy.run_path(str(ROOT / "docs/tools/rooms.py"))["picture"]()
    assert (ROOT / "docs/rooms.svg").read_text(encoding="utf-8") == drawn
    rooms = [path.name for path in (ROOT / "clearsweep").iterdir() if (path / "__init__.py").exists()]
    assert all(f'class="name">{room}<' in drawn for room in rooms)


def test_the_citation_is_of_this_version():
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == clearsweep.__version__
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
