"""The documentation shows what is there: commands, programs, keys of grids, links, pictures, figures of merit."""

import inspect
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import types
from pathlib import Path

import pytest
from click.testing import CliRunner
from ruamel.yaml import YAML

import clearsweep
from clearsweep import cli, grid
from clearsweep.cli import verbs
from clearsweep.contracts.catalogue import ANY
from clearsweep.grid.keys.outline import key_trees
from clearsweep.grid.pages.schema import whole_schema
from clearsweep.simulation.setup.scene import catalogue
from clearsweep.sweeping.sweep import sweep

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md"))]
MARKED = (
    "README.md",
    "docs/python.md",
    "docs/tutorial.md",
    "docs/rig.md",
)  # whose blocks that have a mark tests of their own look at
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


def test_the_page_of_commands_has_every_option_of_every_verb():
    rows = dict(re.findall(r"^\| `clearsweep (\w+)[^`]*` \|(.*)$", page_of_commands(), re.MULTILINE))
    assert rows.keys() == verbs.commands.keys()
    for name, command in verbs.commands.items():
        texts = "\n".join(re.findall(rf"^\| `clearsweep {name}\b.*$", page_of_commands(), re.MULTILINE))
        options = {option for parameter in command.params for option in parameter.opts if option.startswith("--")}
        missing = {option for option in options - {"--json"} if f"`{option}" not in texts and f" {option}" not in texts}
        assert not missing, name
        own = re.sub(r"`\w+ --[a-z-]+`", "", texts)  # without `run --option` in the row of another verb
        mentioned = set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", own))
        assert mentioned <= options, name


def page_of_commands():
    return (ROOT / "docs/commands.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("block", blocks("console", "bash"))
def test_commands_exist_and_take_these_options(block, monkeypatch):
    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    contributing = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    shown = {f"--{name}" for name in re.findall(r"^\+    (\w+): Annotated\[", contributing, re.MULTILINE)}
    for words in commands(re.sub(r"\$(\{\{.*?\}\}|\w+)", "1", block)):
        if words[:1] == ["make"]:
            assert words[1] in targets
        elif words[:1] == ["clearsweep"]:
            command = verbs.commands[words[1]]
            options = command.make_context(words[1], [word for word in words[2:] if word not in shown])
            assert options is not None
        elif words:
            assert words[0] in ("python", "git")


@pytest.mark.parametrize("block", [block for block in blocks("console") if not block.id.startswith("CONTRIBUTING")])
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
    given = YAML(typ="safe").load(block)
    whole = YAML(typ="safe").load((ROOT / "configs/slider_crank_restitution.yaml").read_text(encoding="utf-8"))
    del whole["sweep"]
    if "name" in given:  # it is complete
        whole.clear()
    for key, value in given.items():
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
def test_commands_and_files_named_in_a_text_exist(page):
    text = TEXTS[page]
    assert set(re.findall(r"`clearsweep (\w+)", text)) <= set(verbs.commands)
    if page == "CHANGELOG.md":
        return  # of the past
    for name in re.findall(r"`((?:clearsweep|tests|docs|configs|results)/[\w/.]+\.\w+)`", text):
        written = name.startswith("results/slider-crank-clearance")  # by a run
        assert written or (ROOT / name).exists(), name


def test_every_file_of_the_map_exists():
    table = TEXTS["docs/design.md"].partition("## Where to change what")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (?!what |--- )(.+?) \| (.+) \|$", table, re.MULTILINE)
    assert len(rows) > 30
    for what, where in rows:
        named = re.findall(r"`([\w/.]+(?:/|\.(?:py|j2|css)))`", where)
        assert named, what
        home = ROOT / "clearsweep"
        for path in named:
            home = home if "/" not in path else ROOT / "clearsweep"
            assert (home / path).exists(), f"{what}: {path}"
            home = (home / path).parent


def test_every_figure_is_defined():
    table_of_columns = runpy.run_path(str(ROOT / "docs/tools/columns.py"))["columns_markdown"]
    known = set(re.findall(r"^\| `(\w+)`", table_of_columns(catalogue()), re.MULTILINE))
    table = TEXTS["docs/model.md"].partition("## Figures of merit")[2].partition("\n## ")[0]
    defined = {
        name for row in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)
    }
    assert known == defined - {"F_difference"}
    assert len(known) > 20


@pytest.mark.parametrize("package", ["machines", "joints", "laws"])
def test_every_family_of_a_contract_is_described(package):
    source = (ROOT / f"clearsweep/mechanics/{package}/contract.py").read_text(encoding="utf-8")
    families = re.findall(r"^@family(?:_with_default)?\ndef (\w+)", source, re.MULTILINE)
    assert families
    assert not [name for name in families if f"`{name}(" not in TEXTS["docs/design.md"]]


def test_the_picture_shows_the_rooms_that_there_are():
    drawn = runpy.run_path(str(ROOT / "docs/tools/rooms.py"))["picture"]()
    assert (ROOT / "docs/rooms.svg").read_text(encoding="utf-8") == drawn
    rooms = [path.name for path in (ROOT / "clearsweep").iterdir() if (path / "__init__.py").exists()]
    assert all(f'class="name">{package}<' in drawn for package in rooms)


def test_the_citation_is_of_this_version():
    citation = YAML(typ="safe").load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == clearsweep.__version__
    assert {"cff-version", "message", "title", "authors"} <= set(citation)


PAGE = (Path(__file__).parents[1] / "docs/grid.md").read_text(encoding="utf-8")


def test_the_page_is_what_the_program_writes():
    assert CliRunner().invoke(verbs, ["schema", "--markdown"]).stdout == PAGE


def keys(schema, path=()):
    """Yield (path, keys) of every object in a JSON Schema that contains keys of its own."""
    inner, others = schema.get("properties", {}), schema.get("additionalProperties")
    if isinstance(others, dict) and "properties" in others:
        inner = inner | {ANY: others}
    if inner:
        yield ".".join(path), set(inner)
    for key, value in inner.items():
        yield from keys(value, (*path, key))


def sections():
    """Return the text under the heading of each section; several with the same keys share a heading."""
    parts = re.findall(r"^## (.*)\n((?:.|\n)*?)(?=^## |\Z)", PAGE, re.MULTILINE)
    return {path: text for title, text in parts for path in re.findall(r"`(.*?)`", title)}


def common(path):
    """Return the path of a section as the page has it: joints are one, a list is a row."""
    return re.sub(r"^joints\.[^.]+", f"joints.{ANY}", path)


def is_row(known, path):
    """Return whether a path is a row of the section above it."""
    above, _, key = common(path).rpartition(".")
    return f"| `{key}` |" in known.get(above, "")


def test_every_key_of_the_schema_is_under_its_section():
    schema = whole_schema(catalogue())
    apart = ("sample", "seek", "refine", "optimise", "identify")  # under "Choosing cases"
    objects = {path: names for path, names in keys(schema) if path.partition(".")[0] not in apart}
    known, missing = sections(), []
    for path, names in objects.items():
        if names <= {"0", "1", "2"} and is_row(known, path):
            continue
        text = known.get(common(path), "") if path else PAGE.partition("\n## Choosing cases\n")[2]
        for name in names:
            full = f"{path}.{name}".lstrip(".")
            if (
                full not in objects
                and not any(each.startswith(common(full)) for each in known)
                and f"| `{name}` |" not in text
            ):
                missing.append(full)
    assert not missing
    assert len(objects) > 5


def test_a_section_appears_once_and_says_which_mechanisms_have_a_key():
    headings = re.findall(r"^## .*", PAGE, re.MULTILINE)
    assert len(headings) == len(set(headings))
    assert "| `branch` |  | `open`, `crossed` | `open` | *four-bar*: side of the line from crank pin to" in PAGE
    assert "; *rolling bearing, in space, gear*: all but `karnopp`, `dahl`, `lugre`, `elasto-plastic` |" in PAGE
    assert "| `horizon` |  | `true`, `false` | `false` | *not impact-pair*: " in PAGE


def test_a_list_is_a_row_and_a_key_in_two_units_has_both():
    assert "| `tilt` | rad | two, each any | 0 | *in space*: rotation vector of the bearing" in PAGE
    assert "| `velocity_scale` | m/s or rad/s | above 0 | required | `threlfall`: " in PAGE
    assert "## `joints.NAME.contact.material.bearing`, `joints.NAME.contact.material.journal`\n" in PAGE


def test_joints_with_one_place_on_the_page_have_the_same_keys():
    """The page shows the pins of the first mechanism alone, so that they have to be like all others."""
    trees = [tree for tree in key_trees(catalogue()) if "revolute" in tree.joints.values()]
    assert len(trees) == 2
    keys = [
        {inner.removeprefix(f"joints.{joint}") for inner in tree.keys if inner.startswith(f"joints.{joint}.")}
        for tree in trees
        for joint, kind in tree.joints.items()
        if kind == "revolute"
    ]
    assert len(keys) == 7
    assert all(key == keys[0] for key in keys)


@pytest.mark.parametrize("section", ["seek", "refine", "optimise", "identify"])
def test_every_key_of_what_adds_cases_is_under_its_heading(section):
    text = PAGE.partition(f"\n### `{section}`\n")[2].partition("\n### ")[0]
    named = {name for row in re.findall(r"^\| (.*?) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)}
    assert named == dict(keys(whole_schema(catalogue())))[section]


def test_a_quantity_appears_with_unit_range_default_and_meaning():
    assert re.search(r"\| `clearance` \| m \| above 0 \| required \| .*radial clearance, or a fit of ISO 286 as", PAGE)
    assert "| `bins` |  | whole, 8 to 1e6 | 360 | number of angular bins around each body; *fixed* |" in PAGE


# The how-tos: each is found from the guide, and its grids print what the page shows.


PRINTED = runpy.run_path(str(ROOT / "docs/tools/printed.py"))
HOWTOS = PRINTED["HOWTOS"]


def test_the_guide_leads_to_every_how_to():
    guide = (ROOT / "docs/guide.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\]\(howto/([\w-]+\.md)\)", guide)) == {page.name for page in HOWTOS}


def test_every_output_follows_a_grid():
    texts = [page.read_text(encoding="utf-8") for page in HOWTOS]
    matches = sum(len(list(PRINTED["examples"](page))) for page in HOWTOS)
    assert sum(text.count(PRINTED["MARK"]) for text in texts) == matches > 10


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in HOWTOS if list(PRINTED["examples"](page))], ids=lambda p: p.stem)
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


# The gallery: its grids are those of configs/, print what the page shows, and look like its pictures.


GALLERY = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
ENTRIES = re.findall(
    r"!\[[^]]*\]\(gallery/(\w+)\.svg\)\n(?:.*\n)*?```text\n((?:(?!```).*\n)*)```\n(?:.*\n)*?"
    r"<!-- output: (\w+) -->\n```text\n((?:(?!```).*\n)*)```",
    GALLERY,
)


def test_every_machine_of_the_gallery_has_picture_grid_and_output():
    assert [(picture, output) for picture, _, output, _ in ENTRIES] == [
        (name, name) for name in ("wiper", "pump", "engine")
    ]
    for name in re.findall(r"`(configs/\w+\.yaml)`", GALLERY):
        assert (ROOT / name).is_file()


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


# The site of the documentation builds without a warning, needs no network, and its search answers from the disk.


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


# ---------------------------------------------------------------------------------------------- the README


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


@pytest.mark.heavy
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


@pytest.mark.heavy
def test_the_program_shown_runs(small_run, monkeypatch, capsys):
    monkeypatch.chdir(small_run[0])
    exec(compile(block("python"), "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("ok ")
