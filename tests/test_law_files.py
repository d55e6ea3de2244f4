"""Law files: what runs, when it runs, and that every file which is no law file ends with a message."""

import json
import os
import pickle
import signal
import subprocess
import sys
import time

import pytest
from click.testing import CliRunner
from fake_physics import BODIES
from fake_runs import forget_laws
from right_grids import grid_of

import clearsweep
from clearsweep import grid as grids
from clearsweep import simulation
from clearsweep.cli import verbs
from clearsweep.grid.written import law_execution, law_files
from clearsweep.language.errors import InputError
from clearsweep.mechanics.laws import contract
from clearsweep.simulation import catalogue

HEAD = "from clearsweep import laws\n"
SPRING = '@laws.elastic("spring", k="N/m")\ndef spring(penetration, p):\n    return p.k * penetration\n'
GOOD = HEAD + SPRING
GRID = grid_of("an impact pair with a law of a file")


pytestmark = pytest.mark.usefixtures("place")


def grid_of(content, name="my_laws.py", trusted=True):
    """Return a grid in a file whose law file has this content, after trust in it."""
    path = os.path.abspath(name)
    with open(path, "wb") as file:
        file.write(content if isinstance(content, bytes) else content.encode())
    with open("grid.json", "w", encoding="utf-8") as file:
        json.dump(GRID | {"laws": name}, file)
    if trusted:
        grids.trust(law_execution.Path(name))
    return "grid.json"


def load(source):
    return grids.load(source, catalogue())


# ---------------------------------------------------------------------------------------------- hostile files

DEEP = "x = " + "(" * 300 + "1" + ")" * 300 + "\n"
SUM = "x = " + "+".join("1" for _ in range(490)) + "\n"
HOSTILE = {
    "neighbour by importlib": (
        HEAD + "import importlib, sys\nsys.path.append('.')\nimportlib.import_module('helper')\n" + SPRING,
        ":4: opens ",
    ),
    "endless": (HEAD + "while True:\n    pass\n", ": does not end within 0."),
    "sleeps": (HEAD + "import time\ntime.sleep(1e6)\n", ":3: does not end within 0.6 s"),
    "endless law": (GOOD.replace("return", "while True:\n        x = 1.0\n    return"), "does not end within 0."),
    "memory": (HEAD + "x = bytearray(10**18)\n", ":2: MemoryError"),
    "many lines": ("x = 1\n" * 10**6, "has more than the 262,144 bytes"),
    "long line": (GOOD + "x = 1" + " " * 2000 + "; import os\n", ":5: has 2,016 characters"),
    "deep brackets": (HEAD + DEEP, "too many nested parentheses"),
    "deep sum": (HEAD + SUM + SPRING, "my_laws.py: is nested too deeply; divide its longest expressions"),
    "null byte": (GOOD.encode() + b"\0", ":5: has the invisible character U+0000"),
    "latin": (HEAD.encode() + b"# \xe9\n", "not UTF-8 text (byte 30)"),
    "utf-16": (GOOD.encode("utf-16"), "not UTF-8 text (byte 0)"),
    "hidden line": (HEAD + "# a comment\rimport os\n" + SPRING, ":2: has the invisible character U+000D"),
    "turned text": (HEAD + "# \u202e\n" + SPRING, ":2: has the invisible character U+202E"),
    "look-alike": (HEAD + "\u0440 = 1\n" + SPRING, ":2: '\\u0440' has letters that look like others"),
    "look-alike law": (
        GOOD.replace('"spring"', '"s\u0440ring"'),
        ":2: laws.elastic 's\u0440ring': its name is not valid",
    ),
    "no call": (
        HEAD + "@laws.elastic\ndef f(penetration, p): return 1.0\n",
        ':2: has no name; write @laws.elastic("NAME", KEY="unit") above it',
    ),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_law_file_ends_with_a_message(kind, monkeypatch, place):
    content, expected = HOSTILE[kind]
    (place / "helper.py").write_text("x = 1\nraise SystemExit('the neighbour ran')\n", encoding="utf-8")
    monkeypatch.setattr(law_execution, "TIME_LIMITS", {signal.SIGPROF: 0.2, signal.SIGALRM: 0.6})
    before = len, os.getcwd(), list(sys.path), signal.getsignal(signal.SIGALRM), os._exit
    with pytest.raises(InputError) as caught:
        load(grid_of(content))
    assert expected in str(caught.value)
    assert "my_laws.py" in str(caught.value)
    assert before == (len, os.getcwd(), list(sys.path), signal.getsignal(signal.SIGALRM), os._exit)
    assert sorted(x.name for x in place.iterdir() if x.suffix != ".json") in (["helper.py", "my_laws.py"],)


def _link(path):
    (path.parent / "real.py").write_text(GOOD, encoding="utf-8")
    path.symlink_to("real.py")


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (_link, "it is a link"),
        (os.mkfifo, "it is not a regular file"),
        (os.mkdir, "it is not a regular file"),
        (lambda path: path.symlink_to("/dev/zero"), "it is a link"),
        (lambda path: None, "No such file or directory"),
    ],
)
def test_a_name_of_no_regular_file_is_refused_at_once(place, make, expected):
    make(place / "my_laws.py")
    for act in (lambda: load(GRID | {"laws": "my_laws.py"}), lambda: grids.trust(place / "my_laws.py")):
        with pytest.raises(InputError, match=f"my_laws.py: cannot be read: {expected}"):
            act()


# ---------------------------------------------------------------------------------------------- what runs, and when

MARKS = HEAD + "import builtins\nbuiltins.a_law_file_has_run = True\n" + SPRING  # adds a name, and changes none


@pytest.fixture
def has_run():
    """A function that says whether MARKS has run since the last call."""
    import builtins

    yield lambda: vars(builtins).pop("a_law_file_has_run", False)
    vars(builtins).pop("a_law_file_has_run", None)


def invoke(*arguments):
    return CliRunner().invoke(verbs, [*arguments], standalone_mode=False)


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "grid.json"),
        ("run", "grid.json", "--dry-run"),
        ("run", "grid.json", "--fail-on-limits"),
        ("run", "grid.json", "--set", "joints.pair.contact.restitution=0.5"),
        ("draw", "grid.json"),
        ("check", "grid.json"),
        ("list", "flores", "--for", "grid.json"),
    ],
)
def test_a_verb_does_not_run_a_file_that_is_not_trusted(arguments, has_run, place):
    grid_of(MARKS, trusted=False)
    error = invoke(*arguments).exception
    assert isinstance(error, InputError)
    assert error.exit_code == 2
    digest = law_execution.hashlib.sha256(MARKS.encode()).hexdigest()
    for part in (
        "my_laws.py is not trusted, and nothing of it has run",
        f"{place}/my_laws.py: {len(MARKS)} bytes, sha256 {digest}",
        "declares elastic spring (k)",
        "`clearsweep trust my_laws.py`",
        f"--trust-laws my_laws.py={digest}",
    ):
        assert part in str(error)
    assert not has_run()


@pytest.mark.parametrize("call", [clearsweep.sweep, clearsweep.load_case])
def test_a_call_from_python_does_not_run_a_file_that_is_not_trusted(call, has_run):
    grid_of(MARKS, trusted=False)
    for source in ("grid.json", GRID | {"laws": "my_laws.py"}, GRID | {"laws": ["my_laws.py"]}):
        with pytest.raises(InputError, match="is not trusted, and nothing of it has run"):
            call(source)
    assert not has_run()


def test_trust_runs_nothing_and_lasts_until_the_text_changes(place, has_run):
    source = grid_of(MARKS, trusted=False)
    output = invoke("trust", "my_laws.py").output
    assert "declares elastic spring (k)\n  imports clearsweep and builtins\ntrusted: remembered in " in output
    assert not has_run()
    assert load(source).law_files[0].laws[0].name == "spring"
    assert has_run()
    assert invoke("trust", "--list").output.endswith(f"  {place}/my_laws.py\n")
    grid_of(MARKS + "# changed\n", trusted=False)
    with pytest.raises(InputError, match=r"my_laws.py has changed since it was trusted"):
        load(source)
    assert not has_run()


def test_trust_that_is_revoked_or_of_another_place_does_not_count(place):
    grid_of(MARKS)
    (place / "copy.py").write_text(MARKS, encoding="utf-8")
    with pytest.raises(InputError, match=r"copy.py is not trusted"):
        load(GRID | {"laws": "copy.py"})
    assert invoke("trust", "--revoke", "my_laws.py").output == "1 contents of my_laws.py are no longer trusted\n"
    with pytest.raises(InputError, match=r"my_laws.py is not trusted"):
        load("grid.json")


def test_trust_covers_the_files_that_a_text_names(place):
    (place / "table.csv").write_text("1.0\n", encoding="utf-8")
    reads = "from pathlib import Path\nSIZE = float(Path(__file__).with_name('table.csv').read_text())\n"
    source = grid_of(HEAD + reads + SPRING)
    before = load(source).case_id(0)
    (place / "table.csv").write_text("2.0\n", encoding="utf-8")
    with pytest.raises(InputError, match="has changed since it was trusted"):
        load(source)
    grids.trust(place / "my_laws.py")
    assert load(source).case_id(0) != before  # the table decides, too


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [
        (lambda file: file.chmod(0o644), "is not a private file of yours"),
        (lambda file: file.parent.chmod(0o777), "can be written by other users"),
        (lambda file: file.write_text("{", encoding="utf-8"), "is damaged; delete it and trust your files again"),
        (lambda file: (file.rename(file.with_name("x")), file.symlink_to("x")), "it is a link"),
    ],
)
def test_a_list_of_trust_that_others_could_have_written_counts_for_nothing(spoil, expected):
    source = grid_of(GOOD)
    assert law_files.store_file().stat().st_mode & 0o777 == 0o600
    spoil(law_files.store_file())
    with pytest.raises(InputError, match="is not trusted") as caught:
        load(source)
    assert expected in str(caught.value)


def test_without_a_home_nothing_is_trusted_and_the_message_says_what_to_do(monkeypatch):
    monkeypatch.delenv("XDG_CONFIG_HOME")

    def fail():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(law_files.Path, "home", fail)
    for act in (lambda: load(grid_of(GOOD, trusted=False)), lambda: grids.trust(law_files.Path("my_laws.py"))):
        with pytest.raises(InputError, match="set HOME or XDG_CONFIG_HOME, or run with --trust-laws"):
            act()


@pytest.mark.parametrize(
    ("permission", "is_allowed"),
    [
        ("own-folder", True),
        ("my_laws.py={laws}", False),  # the table, too
        ("my_laws.py={laws},table.csv={table}", True),
        ("my_laws.py={table},table.csv={laws}", False),
        ("other.py={laws},table.csv={table}", False),
    ],
)
def test_an_option_allows_the_files_in_the_folder_or_those_of_these_contents(place, permission, is_allowed):
    (place / "table.csv").write_text("1.0\n", encoding="utf-8")
    source = grid_of(HEAD + "TABLE = 'table.csv'\n" + SPRING, trusted=False)
    digests = {"laws": law_files.hash_of("my_laws.py"), "table": law_files.hash_of("table.csv")}
    with grids.allowing(permission.format(**digests)):
        if is_allowed:
            assert load(source).law_files[0].is_allowed
            return
        with pytest.raises(InputError, match="is not trusted"):
            load(source)


def test_an_option_without_files_does_not_reach_beyond_the_folder(place):
    (place / "further").mkdir()
    (place / "further" / "table.csv").write_text("1.0\n", encoding="utf-8")
    (place / "link.csv").symlink_to("further/table.csv")
    for name, content in (("further/laws.py", GOOD), ("my_laws.py", HEAD + "TABLE = 'link.csv'\n" + SPRING)):
        with grids.allowing("own-folder"), pytest.raises(InputError, match="is not trusted"):
            load(grid_of(content, name, trusted=False))


# ---------------------------------------------------------------------------------------------- texts in runs


def test_a_resolved_grid_reads_without_running_its_laws(has_run, place, monkeypatch):
    grid = load(grid_of(MARKS))
    assert has_run()
    resolved = json.loads(json.dumps(grid.resolved()))
    grids.revoke(place / "my_laws.py")
    forget_laws(monkeypatch)
    again = load(resolved)
    assert again.case_id(0) == grid.case_id(0)
    assert again.law_files == grid.law_files
    with pytest.raises(InputError, match=r"my_laws.py is not trusted"):
        law_execution.run_all(again.case(0).law_files)
    assert not has_run()


def test_a_worker_runs_the_text_of_the_launcher_and_not_the_file(has_run, place, monkeypatch):
    content = pickle.dumps(load(grid_of(MARKS)).case(0))
    assert has_run()
    (place / "my_laws.py").write_text("raise SystemExit('the file was read again')", encoding="utf-8")
    grids.revoke(place / "my_laws.py")
    forget_laws(monkeypatch)
    (law,) = law_execution.run_all(pickle.loads(content).law_files)
    assert has_run()
    assert law.function(2.0, type("P", (), {"k": 3.0})) == 6.0


def test_a_worker_refuses_a_table_that_is_not_that_of_the_launcher(place, monkeypatch):
    (place / "table.csv").write_text("1.0\n", encoding="utf-8")
    content = pickle.dumps(load(grid_of(HEAD + "TABLE = 'table.csv'\n" + SPRING)).case(0))
    (place / "table.csv").write_text("2.0\n", encoding="utf-8")
    monkeypatch.setattr(law_execution, "RECORDS", {})
    with pytest.raises(InputError, match=r"table.csv is not what was trusted"):
        law_execution.run_all(pickle.loads(content).law_files)


TEXTS = dict.fromkeys(("family", "summary", "formula", "source"), "law")


@pytest.mark.parametrize(
    "damage",
    [
        {"text": ["x ="]},
        {"text": 3},
        {"named": 3},
        {"laws": []},
        {"laws": [{"family": "law"}]},
        {"laws": [TEXTS | {"name": "a.b", "fields": []}]},
        {"laws": [TEXTS | {"name": "a", "fields": [], "ranges": 1}]},
        {"laws": [TEXTS | {"name": "a", "fields": [{"name": "k", "unit": 3}]}]},
        {"package": None},
    ],
)
def test_a_recorded_file_of_another_form_is_refused(damage):
    resolved = load(grid_of(GOOD)).resolved()
    resolved["laws"] = [resolved["laws"][0] | damage]
    with pytest.raises(InputError, match=r"laws: (is a section that|my_laws.py:1:4: not valid Python)"):
        load(resolved)


HELPED = """\
from clearsweep import laws
FACTOR = 2.0
def double(x): return FACTOR * x
def triple(x): return 3.0 * x
@laws.elastic("spring", k="N/m")
def spring(penetration, p): return double(p.k) * penetration
@laws.elastic("other", k="N/m")
def other(penetration, p): return triple(p.k) * penetration
"""


@pytest.mark.parametrize(
    ("old", "new", "differs"),
    [
        ("FACTOR = 2.0", "FACTOR = 2.0  # of safety\n\n", False),
        ("p): return double(p.k)", "p):\n    '''A spring.'''\n    return double( p.k )", False),
        ('"spring", k="N/m"', '"spring", doc="F = k d", k="N/m"', False),
        ("3.0 * x", "4.0 * x", False),  # only the other law calls this
        ("2.0", "2.5", True),
        ("FACTOR * x", "FACTOR + x", True),
        ("double(p.k) * penetration", "double(p.k) * penetration**2", True),
        ('"spring", k="N/m"', '"spring", k=laws.key("N/m", above=1.0)', True),
    ],
)
def test_the_identity_of_a_case_is_of_its_law_with_what_this_calls(old, new, differs):
    before = load(grid_of(HELPED)).case_id(0)
    assert HELPED.count(old) == 1
    assert (load(grid_of(HELPED.replace(old, new))).case_id(0) != before) == differs


def test_laws_that_no_case_uses_do_not_change_its_identity():
    plain = GRID | {"joints": {"pair": GRID["joints"]["pair"] | {"contact": {"law": "flores", "elastic": "spring"}}}}
    plain["joints"]["pair"]["contact"] = {"law": "flores", "stiffness": "1e8 N/m^1.5", "restitution": 0.9}
    grid_of(GOOD)
    assert load(plain | {"laws": "my_laws.py"}).case_id(0) == load(plain).case_id(0)


def test_prints_of_a_law_file_do_not_reach_stdout(capfd):
    prints = "import os, sys\nprint('a')\nos.write(1, b'b')\nsys.__stdout__.write('c')\n"
    load(grid_of(HEAD + prints + SPRING))
    written, errors = capfd.readouterr()
    assert written == ""
    assert {"a", "b", "c"} <= set(errors)


PATIENT = HEAD + "while True:\n try:\n  while True:\n   x = 1\n except BaseException: pass\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("content", "limit", "code", "message"),
    [
        (PATIENT, 0.2, 2, "a law file does not end, and catches what would end it"),
        (HEAD + "while True: pass\n", 60.0, 130, "stopped"),
    ],
)
def test_a_file_that_does_not_end_is_ended(content, limit, code, message):
    grid_of(content)
    program = (
        "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); "  # ignored in a background job
        "from clearsweep import cli; from clearsweep.grid.written import law_execution as x; "
        f"x.TIME_LIMITS, x.PATIENCE = dict.fromkeys(x.TIME_LIMITS, {limit}), 0.2; "
        "print('ready', flush=True); cli.main(['draw', 'grid.json'])"
    )
    command = [sys.executable, "-c", program]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "ready\n"
        if code == 130:
            time.sleep(3.0)
            process.send_signal(signal.SIGINT)
        assert message in process.communicate(timeout=30.0)[1]
    assert process.returncode == code


@pytest.mark.slow
def test_a_results_directory_runs_nothing_and_show_asks_again(has_run, place, monkeypatch):
    source = grid_of(MARKS + "print('a text')\n")
    estimate = json.loads(invoke("run", source, "--dry-run", "--json", "-j", "1").stdout)  # what it prints is elsewhere
    assert estimate["case"]["values"]["joints.pair.contact.elastic"] == "spring"
    run = clearsweep.sweep(source, "results", executor="serial").open()
    assert has_run()
    (place / "my_laws.py").unlink()
    grids.revoke(place / "my_laws.py")
    forget_laws(monkeypatch)
    contract.OWN_RECIPES.clear()
    case_id = run.summary.case_id[0]
    for verb in (["report", "results"], ["report", "--all", "results"], ["merge", "results", "--out", "merged"]):
        assert invoke(*verb).exception is None
    assert clearsweep.open("merged").grid["derived"] == run.grid["derived"]
    error = invoke("show", "results", case_id).exception
    assert "my_laws.py is not trusted, and nothing of it has run" in str(error)
    assert "`clearsweep trust results`" in str(error)
    assert not has_run()
    assert "declares elastic spring (k)" in invoke("trust", "results").output
    assert not has_run()
    assert invoke("show", "results", case_id).stdout == f"results/{case_id}.html\n"
    assert has_run()
    (again,) = (place / "results").glob("run.json")
    again.write_text(again.read_text(encoding="utf-8").replace("return p.k", "return 2 * p.k"), encoding="utf-8")
    assert "run.json: damaged" in str(invoke("show", "results", case_id).exception)


FORCES = """
@laws.load("drag", c="N*s/m")
def drag(t, angle, position, velocity, p):
    return -p.c * velocity[0], 0.0, 0.0

@laws.motor("falling", stall="N*m")
def falling(speed, t, p):
    return p.stall * (1.0 - speed / 100.0)
"""


@pytest.mark.slow
def test_a_run_with_a_load_and_a_motor_of_a_law_file_is_reported_without_running_it(place, monkeypatch):
    (place / "my_laws.py").write_text(HEAD + FORCES, encoding="utf-8")
    machine = {
        "mechanism": BODIES,
        "drive": {"motor": {"law": "falling", "stall": "2 N*m"}, "initial_speed": "60 rad/s", "inertia": "1e-3 kg*m^2"},
        "loads": {"drag": {"on": "slider", "law": "drag", "c": "3 N*s/m"}},
        "joints": {
            "rod-slider": {
                "clearance": "0.1 mm",
                "bearing_radius": "10 mm",
                "contact": {"law": "flores", "stiffness": "1e9 N/m^1.5", "restitution": 0.5},
            }
        },
        "simulate": {"revolutions": 4, "discard": 0, "tolerance": 1e-6},
        "vibration": {},
        "laws": "my_laws.py",
    }
    (place / "grid.json").write_text(json.dumps(machine), encoding="utf-8")
    grids.trust(place / "my_laws.py")
    clearsweep.sweep("grid.json", "results", executor="serial")
    monkeypatch.setattr(law_execution, "RECORDS", {})
    contract.OWN_RECIPES.clear()
    assert invoke("report", "results").exception is None
    case_id = clearsweep.open("results").summary.case_id[0]
    assert contract.OWN_RECIPES == {}
    assert invoke("trust", "results").exception is None
    assert invoke("show", "results", case_id).stdout == f"results/{case_id}.html\n"


@pytest.fixture
def library(tmp_path, monkeypatch):
    """A folder with an installed library of laws, which is on the path of Python."""
    folder = tmp_path / "site"
    (folder / "my_library").mkdir(parents=True)
    (folder / "my_library" / "__init__.py").write_text("", encoding="utf-8")
    (folder / "my_library" / "numbers.py").write_text("FACTOR = 2.0\n", encoding="utf-8")
    springs = MARKS.replace("from clearsweep", "from .numbers import FACTOR\nfrom clearsweep")
    (folder / "my_library" / "springs.py").write_text(springs, encoding="utf-8")
    metadata = folder / "my_library-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: my-library\nVersion: 1.0\n", encoding="utf-8")
    (metadata / "entry_points.txt").write_text("[clearsweep.laws]\nmine = my_library.springs\n", encoding="utf-8")
    monkeypatch.syspath_prepend(folder)
    yield folder
    for name in [name for name in sys.modules if name.startswith("my_library")]:
        del sys.modules[name]


def test_an_installed_library_runs_where_a_grid_names_it(library, has_run):
    load({key: part for key, part in GRID.items() if key != "laws"} | {"laws": "mine"})
    assert has_run()
    load(GRID | {"laws": "mine"} | {"joints": GRID["joints"]})
    (file,) = load(GRID | {"laws": "mine"}).law_files
    assert (file.name, file.package, file.path) == ("mine", "my_library", str(library / "my_library" / "springs.py"))


def test_a_library_in_the_current_folder_does_not_count(library, has_run, monkeypatch):
    monkeypatch.chdir(library)
    with pytest.raises(InputError, match="no installed package has laws of the name 'mine'"):
        load(GRID | {"laws": "mine"})
    assert not has_run()


def test_a_text_that_claims_to_be_of_a_library_does_not_run(library, has_run, monkeypatch):
    resolved = load(GRID | {"laws": "mine"}).resolved()
    assert has_run()
    resolved["laws"][0]["text"].append("raise SystemExit")
    case = load(resolved).case(0)
    with pytest.raises(InputError, match="mine is not trusted"):
        law_execution.run_all(case.law_files)


def test_laws_of_a_base_and_of_an_option_are_beside_these(place, monkeypatch):
    grid_of(GOOD)
    (place / "base.json").write_text(json.dumps(GRID | {"laws": "my_laws.py"}), encoding="utf-8")
    (place / "own.json").write_text(json.dumps({"extends": "base.json"}), encoding="utf-8")
    (place / "elsewhere").mkdir()
    monkeypatch.chdir(place / "elsewhere")
    assert load(place / "own.json").law_files[0].path == str(place / "my_laws.py")
    (place / "bare.json").write_text(json.dumps(GRID), encoding="utf-8")
    option = grids.OverriddenGrid(place / "bare.json", {"laws": "../my_laws.py"})
    assert load(option).case_id(0) == load(place / "own.json").case_id(0)
    assert load(grids.OverriddenGrid(place / "own.json", {"joints.pair.contact.k": "2e8 N/m"})).law_files


def test_two_texts_of_one_name_do_not_mix():
    first = load(grid_of(GOOD)).case(0)
    second = load(grid_of(GOOD.replace("p.k *", "2.0 * p.k *"))).case(0)
    for case, force in ((first, 3e2), (second, 6e2), (first, 3e2)):
        assert simulation.elastic_forces(case.joints[0], (3e-6,))[0] == pytest.approx(force)
