"""What a user types, what is printed where, and which exit code comes back."""

import functools
import json
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import fake_physics
import pytest
from fake_physics import FAILS, GOOD, Fake, grid
from ruamel.yaml import YAML

import clearsweep
from clearsweep import cli, simulation
from clearsweep.grid import SCHEMA_VERSION
from clearsweep.language.errors import SchedulerLostError, StorageError
from clearsweep.store.record import record_checksum
from clearsweep.sweeping import estimate, sweep
from clearsweep.sweeping.pool.system import Stopped
from clearsweep.tracing import objects

pytestmark = pytest.mark.heavy

ROOT = Path(__file__).parent.parent
MODULES = 160  # that `--help` loads at most: those of the interpreter, of click, and few of its own
SERIAL = ("--executor", "serial")  # without processes, where these are not the claim
HEAVY = ("llvmlite", "pandas", "h5py", "pyarrow", "numpy", "matplotlib", "pydantic", "ruamel")


@pytest.fixture
def run_cli(monkeypatch, capsys, tmp_path):
    """Return a function that runs a command line on made-up mechanics and returns (exit code, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sweep, "sweep", fake_physics.sweep)
    monkeypatch.setattr(estimate, "estimate", functools.partial(estimate.estimate, simulator=Fake))

    def run(*arguments):
        with pytest.raises(SystemExit) as ended:
            cli.main([str(argument) for argument in arguments])
        return ended.value.code, *capsys.readouterr()

    return run


def written(path, source):
    """Write a grid as a user would and return its path."""
    with open(path, "w", encoding="utf-8") as file:
        YAML().dump(source, file)
    return path


def subprocess_cli(*arguments, cwd=None):
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "clearsweep", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        env=environment,
        timeout=300,
        check=False,
    )


def test_help_answers_in_a_fifth_of_a_second_and_imports_click_alone():
    def spent():  # s of the processor by programs that have ended: a busy machine changes it little
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    times = []
    for _ in range(5):
        before = spent()
        result = subprocess_cli("--help")
        times.append(spent() - before)
    assert result.returncode == 0
    assert "verify" in result.stdout
    assert min(times) < 0.2
    loaded = f"[m for m in {HEAVY} if m in sys.modules] or len(sys.modules) > {MODULES} and sorted(sys.modules) or 0"
    code = f"import sys, clearsweep.cli; sys.exit({loaded})"
    result = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert result.returncode == 0, result.stderr


def test_no_arguments_print_the_help(run_cli):
    code, _, err = run_cli()
    assert code == 0
    assert "Commands:" in err


def test_version_says_what_a_report_of_an_error_needs(run_cli):
    code, out, _ = run_cli("--version")
    assert code == 0
    first, level, directory = out.splitlines()
    assert first == f"clearsweep, version {clearsweep.__version__}, model version {clearsweep.MODEL_VERSION}"
    assert level == f"processor level: {objects.level()}"
    assert directory == f"compiled code: {os.environ['CLEARSWEEP_CACHE_DIR']}"


@pytest.mark.parametrize("verb", ["run", "status", "report", "report --all", "show", "merge"])
@pytest.mark.parametrize("schema", [SCHEMA_VERSION - 1, 99, "<b>"])
def test_every_verb_refuses_a_directory_of_another_format_and_leaves_it_as_it_was(run_cli, tmp_path, verb, schema):
    path = written(tmp_path / "g.yaml", grid(3))
    assert run_cli("run", path, "--out", "old", *SERIAL)[0] == 0
    file = tmp_path / "old" / "run.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["frame"]["schema"] = schema
    file.write_text(json.dumps(content | {"checksum": record_checksum(content)}), encoding="utf-8")
    before = {p: p.read_bytes() for p in (tmp_path / "old").rglob("*") if p.is_file() and p.name != "lock"}
    rest = {"run": (path, "--out", "old", *SERIAL), "show": ("old", "a"), "merge": ("old", "--out", "all")}
    code, _, err = run_cli(*verb.split(), *rest.get(verb, ("old",)))
    assert code == 2
    assert "another directory" in err  # what to do
    assert re.search(f"(schema: there|has format) ['\"]?{schema}", err)
    assert {p: p.read_bytes() for p in before} == before


def test_run_prints_a_short_table_of_the_worst_cases_in_units_for_people(run_cli, tmp_path):
    code, out, _err = run_cli("run", written(tmp_path / "g.yaml", grid(9)), *SERIAL)
    assert code == 0
    lines = out.splitlines()
    assert lines[0].startswith("9 cases ran in")
    assert "9 ok, 0 failed" in lines[0]
    table = lines[lines.index("Largest normal force") + 1 :][:6]
    assert table[0].split("  ")[1] == "case_id"
    assert "slider mass" in table[0]
    assert "108 g" in table[1] or "0.108 kg" in table[1]
    assert "results/made-up" in out
    assert "clearsweep report" in out
    assert (tmp_path / "results" / "made-up" / "summary.parquet").exists()


def test_run_again_says_that_nothing_was_left(run_cli, tmp_path):
    path = written(tmp_path / "g.yaml", grid(3))
    run_cli("run", path, "--out", "x", *SERIAL)
    code, out, _ = run_cli("run", path, "--out", "x", *SERIAL)
    assert code == 0
    assert out.startswith("0 cases ran")
    assert "(3 reused)" in out


def test_failed_cases_are_listed_with_their_reason_and_give_exit_code_3(run_cli, tmp_path):
    code, out, _ = run_cli("run", written(tmp_path / "g.yaml", grid(5, (GOOD, FAILS))), *SERIAL)
    assert code == 3
    assert "Failed cases: 5 step-budget" in out
    assert "the step budget was used up" in out
    assert "--retry-failed" in out


def test_json_contains_the_same_in_si(run_cli, tmp_path):
    code, out, _ = run_cli("run", written(tmp_path / "g.yaml", grid(3, (GOOD, FAILS))), "--json", *SERIAL)
    facts = json.loads(out)
    assert code == 3
    assert (facts["cases"], facts["ok"], facts["failed"], facts["statuses"]) == (6, 3, 3, {"ok": 3, "step-budget": 3})
    assert facts["worst"][0]["swept"]["mechanism.slider.mass"] == pytest.approx(0.102)
    assert facts["worst"][0]["force_peak"] == pytest.approx(0.102)
    assert Path(facts["files"]["orbits.h5"]).exists()
    assert facts["derived"]["joints.rod-slider.contact.stiffness"]["unit"] == "N/m^1.5"


def test_dry_run_prints_counts_derived_values_time_and_bytes_and_writes_nothing(run_cli, tmp_path):
    code, out, _ = run_cli("run", written(tmp_path / "g.yaml", grid(3)), "--dry-run")
    assert code == 0
    assert out.startswith("3 cases to run")
    assert "stiffness = 6.61e+10 N/m^1.5" in out
    assert "time: about" in out
    assert "storage: about" in out
    assert not (tmp_path / "results").exists()


def test_options_replace_values_of_the_file(run_cli, tmp_path):
    path = written(tmp_path / "g.yaml", grid(3))
    options = ("--set", "drive.speed=3000rpm", "--sweep", "mechanism.slider.mass=0.2,0.3")
    assert run_cli("run", path, *options, "--dry-run")[1].startswith("2 cases to run")
    code, out, _ = run_cli("run", path, *options, "--out", "changed", *SERIAL)
    assert code == 0
    assert out.startswith("2 cases ran in")
    changed = grid(3, drive={"speed": "3000 rpm"})
    changed["sweep"]["mechanism.slider.mass"] = ["0.2 kg", "0.3 kg"]
    assert "(2 reused)" in run_cli("run", written(tmp_path / "h.yaml", changed), "--out", "changed", *SERIAL)[1]


def test_directories_that_do_not_fit_are_exit_code_2(run_cli, tmp_path):
    path = written(tmp_path / "g.yaml", grid(1))
    (tmp_path / "file").write_text("")
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("")
    run_cli("run", path, "--out", "x", *SERIAL)
    other = written(tmp_path / "h.yaml", grid(1, drive={"speed": "3000 rpm"}))
    refused = [
        ((path, "--out", "file"), "not a directory"),
        ((path, "--out", "thesis"), "chapter.tex"),
        ((other, "--out", "x"), "drive.speed"),
        ((path, "--out", "file/below"), "cannot be written"),
    ]
    for arguments, text in refused:
        code, out, err = run_cli("run", *arguments)
        assert code == 2
        assert out == ""
        assert text in err
    code, _, err = run_cli("report", "thesis")
    assert code == 2
    assert "contains no run" in err


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (StorageError("disk full"), 4),
        (Stopped(2, "stopped"), 130),
        (Stopped(15, "stopped"), 143),
        (Stopped(1, "stopped"), 129),
        (SchedulerLostError("gone"), 4),
        (KeyboardInterrupt(), 130),
        (ZeroDivisionError("bug"), 1),
    ],
)
def test_every_outcome_has_its_exit_code(run_cli, monkeypatch, error, expected):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(sweep, "sweep", fail)
    code, out, err = run_cli("run", "g.yaml")
    assert code == expected
    assert out == ""
    assert str(error) in err


def test_init_writes_a_grid_that_loads_and_never_overwrites(run_cli, tmp_path):
    code, out, _ = run_cli("init", "new.yaml")
    assert code == 0
    assert "new.yaml" in out
    text = (tmp_path / "new.yaml").read_text()
    assert run_cli("init")[1] == text
    mark, schema_name = text.splitlines()[0].split("$schema=")
    assert mark == "# yaml-language-server: "
    assert (tmp_path / schema_name).read_text() + "\n" == run_cli("schema")[1]
    (tmp_path / "new.yaml").write_text("mine")
    code, _, err = run_cli("init", "new.yaml")
    assert code == 2
    assert "already exists" in err
    assert (tmp_path / "new.yaml").read_text() == "mine"
    assert run_cli("init", "no/such/place.yaml")[0] == 2


def test_schema_is_a_json_schema(run_cli, monkeypatch):
    monkeypatch.setattr(simulation, "catalogue", lambda: fake_physics.CATALOGUE)
    code, out, _ = run_cli("schema")
    assert code == 0
    assert json.loads(out)["type"] == "object"


def test_a_grid_runs_resumes_and_reports_from_the_command_line(run_cli, tmp_path):
    source = grid(2, (0.0,), wear=True) | {"simulate": {"revolutions": 3, "discard": 1}}
    path = written(tmp_path / "g.yaml", source)
    first = subprocess_cli("run", path, "--json", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    facts = json.loads(first.stdout)
    assert facts["ran"] == facts["ok"] == 2
    assert facts["worst"][0]["force_peak"] > 100.0
    again = subprocess_cli("run", path, cwd=tmp_path)
    assert again.returncode == 0
    assert again.stdout.startswith("0 cases ran")
    code, printed, errors = run_cli("report")
    assert code == 0, errors
    assert (tmp_path / printed.strip()).stat().st_size > 10_000


def test_exceeded_limits_end_with_code_5_when_asked(run_cli, tmp_path):
    judged = written(tmp_path / "g.yaml", grid(2) | {"limits": {"rod_slider_force_peak": "1e-12 N"}})
    assert run_cli("run", judged, *SERIAL)[0] == 0
    code, _, errors = run_cli("run", judged, *SERIAL, "--fail-on-limits")
    assert code == 5
    assert "exceed a limit" in errors
    met = written(tmp_path / "met.yaml", grid(2) | {"name": "met", "limits": {"rod_slider_force_peak": "1e12 N"}})
    assert run_cli("run", met, *SERIAL, "--fail-on-limits")[0] == 0


def test_failed_cases_come_before_limits(run_cli, tmp_path):
    failing = written(tmp_path / "g.yaml", grid(2, (GOOD, FAILS)) | {"limits": {"rod_slider_force_peak": "1e-12 N"}})
    code, _, errors = run_cli("run", failing, *SERIAL, "--fail-on-limits")
    assert code == 3
    assert "2 cases undecided" in errors
