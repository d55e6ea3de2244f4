"""Environments and disks that are not as usual: a run and its report go on, or say which file could not be written."""

import json
import os
import resource
import subprocess
import sys

import fake_physics
import pytest
from fake_physics import grid
from test_sweep import parts, program, same_results

import clearsweep
from clearsweep.language.errors import InputError


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    out = tmp_path_factory.mktemp("surroundings") / "run"
    fake_physics.sweep(grid(6), out, executor="serial", show_progress=False)
    return out


def report(run, *options, limit=None, **environment):
    """Return what `report` comes to, its files limited to some bytes."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    return subprocess.run(
        [sys.executable, "-m", "clearsweep", "report", str(run), *map(str, options)],
        env=os.environ | environment,
        preexec_fn=limited if limit else None,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_figures_do_not_depend_on_settings_of_matplotlib_by_others(ran, tmp_path):
    odd = {"MPLBACKEND": "nope", "SOURCE_DATE_EPOCH": "x"}
    for name, variables in (("usual", {}), ("odd", odd)):
        done = report(
            ran, "--out", tmp_path / f"{name}.html", "--figures", tmp_path / name, "--format", "pdf", **variables
        )
        assert done.returncode == 0, done.stderr
    files = sorted(file.name for file in (tmp_path / "usual").iterdir())
    assert len(files) > 1
    for name in files:
        assert (tmp_path / "usual" / name).read_bytes() == (tmp_path / "odd" / name).read_bytes()


@pytest.mark.slow
def test_a_page_that_does_not_fit_is_named_and_nothing_is_left_of_it(ran, tmp_path):
    done = report(ran, "--out", tmp_path / "page.html", limit=40_000)
    assert done.returncode == 2
    assert f"{tmp_path / 'page.html'}: cannot be written (File too large); make room or choose" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("source", ["grid.yaml", {"mechanism": {}}, None, 1.0])
def test_simulate_says_what_it_takes(source):
    with pytest.raises(InputError, match=r"expected the result of load_case, as in clearsweep\.simulate"):
        clearsweep.simulate(source)


@pytest.mark.parametrize("limit", [9_000])
def test_a_disk_that_fills_in_the_middle_costs_what_was_not_committed(tmp_path, limit):
    source = grid(40, wear=True)
    fake_physics.sweep(source, tmp_path / "undisturbed", executor="serial", show_progress=False)
    out = tmp_path / "run"
    resource_limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))\n"
    script = resource_limit + (
        "import sys, json; sys.path[:0] = json.loads(sys.argv[3])\n"
        "from fake_physics import sweep; from clearsweep.language.errors import ClearsweepError\n"
        'try: sweep(json.loads(sys.argv[1]), sys.argv[2], executor="serial", show_progress=False)\n'
        "except ClearsweepError as error: print(error, file=sys.stderr); sys.exit(error.exit_code)\n"
    )
    arguments = [json.dumps(source), str(out), json.dumps(sys.path)]
    done = subprocess.run([sys.executable, "-c", script, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode in (2, 4), done.stderr
    assert "Traceback" not in done.stderr
    assert str(out) in done.stderr
    program(out, source, show_progress=False).communicate(timeout=100)
    assert same_results(tmp_path / "undisturbed", out)
    assert parts(out) == len(list((out / "shards").iterdir()))
