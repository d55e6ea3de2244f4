"""The rooms of the package and the direction of imports between them: one the wrong way, or in a circle, is found."""

import ast
import collections
import functools
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import conftest
import pytest
from mutate import MUTATIONS, Mutation

import clearsweep
from clearsweep import simulation

ROOT = Path(__file__).parents[1]


def lint(place: Path) -> subprocess.CompletedProcess:
    """Return what import-linter says of the copy of the package in `place`."""
    command = [sys.executable, "-c", "import sys; from importlinter.cli import lint_imports_command as run; run()"]
    wide = os.environ | {"COLUMNS": "1000"}  # no line is broken
    options = {"capture_output": True, "text": True, "timeout": 120}
    return subprocess.run([*command, "--no-cache"], cwd=place, env=wide, check=False, **options)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    place = tmp_path_factory.mktemp("house")
    shutil.copy(ROOT / "pyproject.toml", place)
    shutil.copytree(ROOT / "clearsweep", place / "clearsweep", ignore=shutil.ignore_patterns("__pycache__"))
    return place


def test_the_imports_of_the_package_point_one_way(copy):
    message = lint(copy)
    assert message.returncode == 0, message.stdout


def planted() -> Iterator[tuple[str, str]]:
    """Yield modules and what they may not import: the next layer above, one on its floor, what another room keeps."""
    house = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    for contract in house["contracts"]:
        for hidden in contract.get("protected_modules", ()):
            yield "clearsweep.report.study", hidden
        for container in contract.get("containers", ()):
            layers = [re.split(" ([|:]) ", layer) for layer in contract["layers"]]
            for above, layer in zip([[], *layers], layers, strict=False):
                siblings = [other for mark, other in zip(layer[1::2], layer[2::2], strict=True) if mark == "|"]
                yield from ((f"{container}.{layer[0]}", f"{container}.{other}") for other in [*above[:1], *siblings])


def test_planted_imports_the_wrong_way_are_found(copy):
    """Each of them by itself, with its line, and not as a part of a longer way."""
    lines = {}
    for module, other in planted():
        path = copy / module.replace(".", "/")
        source = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
        text = f"{source.read_text()}\nimport {other}\n"
        source.write_text(text)
        lines[module, str(text.count("\n"))] = other
    message = lint(copy)
    assert message.returncode != 0
    matched = re.findall(r"^[-&] (\S+) -> \S+ \(l\.(\d+)\)\n(?!  )", message.stdout, re.MULTILINE)
    assert [(*place, other) for place, other in lines.items() if place not in matched] == []
    assert len(lines) == len([*planted()]) > 60


def test_no_module_imports_another_by_its_name_in_a_string():
    result = [
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "clearsweep").rglob("*.py")
        if "import_module" in path.read_text() or "__import__" in path.read_text()
    ]
    assert result == ["clearsweep/__init__.py"]  # public names are resolved when they are first used


@functools.cache
def sources():
    """Return path -> syntax tree of every module of the package."""
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted((ROOT / "clearsweep").rglob("*.py"))}


@functools.cache
def graph_of_imports() -> dict[str, set[str]]:
    """Return module -> the modules of the package that it imports, lazily or for types alone, too."""
    names = {}
    for path in sources():
        parts = path.relative_to(ROOT).with_suffix("").parts
        names[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return {module: set(imports(module, path, names)) for module, path in names.items()}


def imports(module, path, names):
    """Yield the modules among `names` that one module imports."""
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(sources()[path]):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in names)
        elif isinstance(node, ast.ImportFrom):
            start = package.split(".")[: 1 - node.level or None] if node.level else []
            base = ".".join([*start, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{base}.{alias.name}"
                yield from (name for name in ([inner] if inner in names else [base]) if name in names)


def circle(graph) -> list[str]:
    """Return modules that import each other in a circle, the first one again as the last, or [] if there is none."""
    done, way = set(), []

    def walk(module):
        if module in way:
            return [*way[way.index(module) :], module]
        if module in done:
            return []
        way.append(module)
        met = next(filter(None, map(walk, sorted(graph[module]))), [])
        way.pop()
        done.add(module)
        return met

    return next(filter(None, map(walk, sorted(graph))), [])


def test_no_modules_import_each_other_in_a_circle():
    graph = graph_of_imports()
    assert "clearsweep.language.quantity" in graph["clearsweep.grid.reading.values"]
    assert " -> ".join(circle(graph)) == ""


def test_a_planted_circle_is_found():
    graph = graph_of_imports() | {"clearsweep.language.quantity": {"clearsweep.grid.grid"}}
    assert {"clearsweep.language.quantity", "clearsweep.grid.grid"} <= set(circle(graph))


@functools.cache
def program(path):
    """Return what a module is to Python, whatever its layout and its comments."""
    return ast.dump(sources()[path])


def public(tree: ast.Module):
    """Yield the public functions and classes of a module, and the public methods of its public classes."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from (part for part in node.body if isinstance(part, ast.FunctionDef) and part.name[0] != "_")


def place(path: Path, node: ast.AST) -> str:
    return f"{path.relative_to(ROOT)}:{node.lineno}"


def test_everything_public_says_what_it_is():
    silent = [
        f"{place(path, node)}: {node.name}"
        for path, tree in sources().items()
        for node in public(tree)
        if not ast.get_docstring(node)
    ]
    assert silent == []


def test_every_module_says_what_it_is():
    assert [str(path) for path, tree in sources().items() if not ast.get_docstring(tree)] == []


def unused(trees: dict, texts: list[str]) -> list[str]:
    """Return the functions, classes and constants of modules that no other word of `texts` names.

    A decorator may register what it decorates, and several constants in one assignment are an enumeration.
    """
    words = collections.Counter(word for text in texts for word in re.findall(r"[A-Za-z_]\w*", text))
    unused_names = []
    for path, tree in trees.items():
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.decorator_list:
                names = [node.name]
            elif isinstance(node, ast.Assign):
                names = [target.id for target in node.targets if isinstance(target, ast.Name)]
            else:
                names = []
            unused_names += [f"{place(path, node)}: {name}" for name in names if words[name] < 2 and name[:2] != "__"]
    return unused_names


def test_everything_that_a_module_defines_is_used():
    files = [*sources(), *(ROOT / "tests").rglob("*.py"), ROOT / "pyproject.toml"]
    assert unused(sources(), [path.read_text(encoding="utf-8") for path in files]) == []


def unused_offers(package: str, text: str, others: list[str]) -> list[str]:
    """Return the names that the `__init__` of a package imports and that neither itself nor another file uses."""
    tree = ast.parse(text)
    offered = [
        alias.asname or alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names
    ]
    own = collections.Counter(re.findall(r"\w+", text))
    words = {word for other in others for word in re.findall(r"\w+", other)}
    return [f"{package}: {name}" for name in offered if own[name] < 2 and name not in words]


@pytest.mark.parametrize("package", ["grid", "simulation", "store", "mechanics/machines/planar"])
def test_what_a_package_offers_is_used_elsewhere(package):
    outside = [path for path in sources() if not path.is_relative_to(ROOT / "clearsweep" / package)]
    files = [path.read_text(encoding="utf-8") for path in [*outside, *(ROOT / "tests").rglob("*.py")]]
    offers = (ROOT / "clearsweep" / package / "__init__.py").read_text(encoding="utf-8")
    assert unused_offers(package, offers, files) == []
    assert unused_offers(package, "from .batch import nobodys" + f"_name\n{offers}", files) == [
        f"{package}: nobodys" + "_name"
    ]


def test_a_planted_function_that_nobody_uses_is_found():
    planted = "def helper():\n    return SIZE\n\n\nSIZE, LEFT = 3, 4\nLENGTH = 2\n"
    path = ROOT / "clearsweep" / "planted.py"
    assert [line.split()[1] for line in unused({path: ast.parse(planted)}, [planted])] == ["helper", "LENGTH"]


def stale_names(texts: dict[str, list[str]], known: set[str]) -> list[str]:
    """Return the names in docstrings and comments, by file, that nothing has: `names` in backquotes, and CONSTANTS."""
    return [
        f"{path}: {name}"
        for path, sentences in texts.items()
        for sentence in sentences
        for quoted, constant in re.findall(r"`([A-Za-z_][\w.]*)`|\b([A-Z][A-Z_]{4,})\b", sentence)
        if (name := quoted or constant).rpartition(".")[2] not in known
    ]


def prose_and_code(path: Path) -> tuple[list[str], str]:
    """Return the docstrings and comments of a file, and the rest of it."""
    text = path.read_text(encoding="utf-8")
    docstrings, comments = re.compile(r'"""(.*?)"""', re.DOTALL), re.compile(r"(?<!\S)#.*")
    code = docstrings.sub("", text)
    return [*docstrings.findall(text), *comments.findall(code)], comments.sub("", code)


def test_docstrings_and_comments_name_only_what_exists():
    known = {"contact_pressure_MPa", "INFORMS", "MCJIT", "LEVEL"}  # a column of a file, a journal, names of LLVM
    for path in [*sources(), *(ROOT / "tests").glob("*.py")]:
        known.update([path.stem, *re.findall(r"\w+", prose_and_code(path)[1])])
    texts = {str(path.relative_to(ROOT)): prose_and_code(path)[0] for path in sources()}
    assert stale_names(texts, known) == []


def test_a_name_that_no_longer_exists_is_found():
    texts = {"a.py": ['"""Return what `former` returned, at most LIMIT of `module.kept`."""']}
    assert stale_names(texts, {"kept"}) == ["a.py: former", "a.py: LIMIT"]


def test_no_file_exceeds_600_lines():
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in sources()}
    assert [f"{path.relative_to(ROOT)}: {length}" for path, length in lengths.items() if length > 600] == []


def test_the_name_of_a_test_has_less_than_80_characters():
    texts = (path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py"))
    names = re.findall(r"^ *def (\w+)\(", "\n".join(texts), re.MULTILINE)
    assert len(names) > 2000
    assert not [name for name in names if len(name) >= 80]


def test_no_function_exceeds_80_lines():
    long = [
        f"{place(path, node)}: {node.name}, {node.end_lineno - node.lineno + 1} lines"
        for path, tree in sources().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.end_lineno - node.lineno + 1 > 80
    ]
    assert long == []


def test_mechanisms_are_distinguished_by_what_they_are_and_not_by_their_name():
    names = {mechanism.name for mechanism in simulation.catalogue().mechanisms}
    compared = [
        f"{place(path, node)}: {ast.unparse(node)}"
        for path, tree in sources().items()
        if not path.is_relative_to(ROOT / "clearsweep" / "mechanics" / "machines")
        for node in ast.walk(tree)
        if isinstance(node, ast.Compare)
        and any(isinstance(part, ast.Constant) and part.value in names for part in ast.walk(node))
    ]
    assert compared == []


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda first: f"{first.file}-{first.where}")
def test_every_mutation_still_applies(mutation):
    """So that `make mutate`, which takes long, does not rot: another program results, and it can be compiled."""
    path = ROOT / "clearsweep" / mutation.file
    applied = mutation.applied(path.read_text(encoding="utf-8"))
    assert ast.dump(ast.parse(applied)) != program(path)


SOURCE = """def force(
    depth,
    rate,
):
    return max(
        stiffness * depth,
        0.0,
    )


class Law:
    def force(self, depth):
        return 2.0 * depth
"""


def test_a_mutation_applies_whatever_the_formatter_and_the_other_functions_do():
    mutation = Mutation("law.py", "force", "max(stiffness * depth, 0.0)", "0.0", "")
    assert "return 0.0\n" in mutation.applied(SOURCE)
    moved = SOURCE.replace("Law", "OtherLaw").replace("depth,\n    rate,", "depth, rate, begin")
    assert "return 0.0\n" in mutation.applied(moved)
    assert "return 3.0 * depth" in mutation._replace(where="Law.force", old="2.0", new="3.0").applied(SOURCE)


@pytest.mark.parametrize(
    ("where", "old", "message"),
    [
        ("torque", "depth", "torque is there 0 times"),
        ("force", "friction", "force has the pattern 0 times"),
        ("force", "depth", "force has the pattern 2 times"),
        ("Law.force", "dept", "Law.force has the pattern 0 times"),
    ],
)
def test_a_mutation_that_no_longer_applies_says_why(where, old, message):
    with pytest.raises(LookupError, match=message):
        Mutation("law.py", where, old, "0.0", "").applied(SOURCE)


def test_all_plain_tests_are_run_by_make_test_plain():
    marked = {path.stem for path in (ROOT / "tests").glob("test_*.py") if "mark.plain" in path.read_text("utf-8")}
    made = (ROOT / "Makefile").read_text("utf-8").partition("PLAIN :=")[2].partition("test-plain:")[0]
    assert {name for name in marked if name.removeprefix("test_") not in re.findall(r"\w+", made)} == {"test_house"}


@pytest.mark.parametrize("plain", [True, False])
def test_plain_tests_run_only_as_plain_python(monkeypatch, plain):
    class Item(set):
        """A test with these marks."""

        path, name = Path(__file__), "test"

        def get_closest_marker(self, name):
            return name in self or None

        def add_marker(self, mark):
            self.limit = mark.args

    monkeypatch.setattr(conftest, "is_plain", lambda: plain)
    items, deselected = [Item({"plain"}), Item({"compiled"}), Item()], []

    def pytest_deselected(items):
        deselected.extend(items)

    hook = SimpleNamespace(pytest_deselected=pytest_deselected)
    conftest.pytest_collection_modifyitems(SimpleNamespace(hook=hook), items)
    assert deselected == ([] if plain else [{"plain"}])
    assert items == [*([{"plain"}] if plain else []), {"compiled"}, set()]
    assert [hasattr(item, "limit") for item in items] == [plain] * len(items)  # what is not compiled takes long


# ------------------------------------------------------------------------------------- changes that CONTRIBUTING shows


TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
CHANGES = {
    match[1]: (match[2], match[3])
    for match in re.finditer(
        r"^<!-- change: (\w+) -->\n```diff\n(.*?)^```\n(?:(?!^<!-- ).)*?^```console\n(.*?)^```",
        TEXT,
        re.MULTILINE | re.DOTALL,
    )
}


def run(words, place):
    """Return what a command says, run as plain Python in a copy of the repository; it has to succeed."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(place),
        "CLEARSWEEP_DISABLE_JIT": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    done = subprocess.run(words, cwd=place, env=environment, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_change_shown_is_made_here():
    assert list(CHANGES) == list(SAID)
    assert TEXT.count("```diff") == len(CHANGES)


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_still_fits_the_sources(name, tmp_path):
    (tmp_path / "change.diff").write_text(CHANGES[name][0], encoding="utf-8")
    command = ["git", "apply", "--check", str(tmp_path / "change.diff")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGES)
def test_a_change_works(name, tmp_path):
    change, commands = CHANGES[name]
    for part in ("clearsweep", "tests", "configs"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    for part in ("pyproject.toml", "README.md", "Makefile"):
        shutil.copy(ROOT / part, tmp_path)
    (tmp_path / "change.diff").write_text(change, encoding="utf-8")
    run(["git", "apply", "--verbose", "change.diff"], tmp_path)
    programs = {"clearsweep": [sys.executable, "-m", "clearsweep"], "python": [sys.executable]}
    text = ""
    for line in commands.splitlines():
        words = shlex.split(line.removeprefix("$ "), comments=True)
        if "CASE_ID" in words:  # of the one case of the run that is named before it
            directory = tmp_path / words[words.index("CASE_ID") - 1]
            words[words.index("CASE_ID")] = clearsweep.open(directory).summary["case_id"][0]
        text += run([*programs[words[0]], *words[1:]], tmp_path)
    assert SAID[name] <= set(re.findall(r"[\w-]+", text))


#: What has to be in what the commands say.
SAID = {
    "law": {"arctan", "tanh", "passed"},
    "mechanism": {"falling-mass", "slot", "html", "passed"},
    "figure": {"pair_force_crest", "float64"},
    "section": {"case_id", "steps"},
    "search": {"Within", "speed", "Index"},
    "option": {"polite", "2"},
}
