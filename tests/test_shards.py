"""Shards of a grid run apart and, joined, are what one run would have left."""

import functools
import os
import shutil
from pathlib import Path

import h5py
import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from fake_physics import CATALOGUE, FAILS, GOOD, Fake, grid, merge, sweep
from ruamel.yaml import YAML
from test_store import edit_record
from test_sweep import quiet, same_results

from clearsweep import cli, store
from clearsweep import grid as grids
from clearsweep.language.errors import DirectoryError
from clearsweep.sweeping import merge as merging
from clearsweep.sweeping import sweep as sweeping
from clearsweep.sweeping.pool.case_runner import Shard, case_ids

pytestmark = pytest.mark.heavy

MIXED = grid(5, (GOOD, GOOD + 0.001, FAILS), wear=True)  # 15 cases, 5 of them fail


@pytest.fixture(scope="module")
def pieces(tmp_path_factory):
    """Return a folder with the whole run of MIXED and three shards of it."""
    folder = tmp_path_factory.mktemp("shards")
    quiet(MIXED, folder / "whole", executor="serial")
    for index in (1, 2, 3):
        quiet(MIXED, folder / str(index), executor="serial", shard=f"{index}/3")
    return folder


def copies(pieces, tmp_path):
    shutil.copytree(pieces, tmp_path / "pieces")
    return [tmp_path / "pieces" / name for name in "123"]


def test_every_case_is_in_one_shard_and_shards_are_equally_large():
    ids = np.random.default_rng(1).integers(0, 2**63, 103, dtype="u8")
    parts = [Shard(k, 8).ids(ids) for k in range(1, 9)]
    assert sorted(np.concatenate(parts)) == sorted(ids)
    assert {len(part) for part in parts} == {12, 13}


def test_no_axis_falls_to_one_shard_alone():
    contents = grids.load(grid(4, [0.1 * k for k in range(16)]), CATALOGUE)
    ids = case_ids(contents)
    for k in range(1, 5):
        mine = np.flatnonzero(np.isin(ids, Shard(k, 4).ids(ids)))
        assert len({contents.point(i)["mechanism.slider.mass"] for i in mine.tolist()}) > 1


def test_joined_shards_are_the_whole_run_row_for_row_and_value_for_value(pieces, tmp_path):
    result = merge([pieces / "3", pieces / "1", pieces / "2"], tmp_path / "all")
    assert (result.cases, result.ran, result.ok, result.failed, result.missing) == (15, 0, 10, 5, 0)
    assert same_results(tmp_path / "all", pieces / "whole")
    assert len(pq.read_table(pieces / "1" / "summary.parquet")) == 5


def test_joining_where_links_are_not_possible_copies(pieces, tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise OSError(18, "Invalid cross-device link")

    monkeypatch.setattr(os, "link", refuse)
    merge([pieces / name for name in "123"], tmp_path / "all")
    assert same_results(tmp_path / "all", pieces / "whole")
    assert all(path.stat().st_nlink == 1 for path in (tmp_path / "all" / "parts").iterdir())


def test_a_joined_run_continues_like_any_other(pieces, tmp_path):
    merge([pieces / name for name in "123"], tmp_path / "all")
    again = quiet(MIXED, tmp_path / "all")
    assert (again.ran, again.reused) == (0, 15)
    repeated = merge([pieces / name for name in "123"], tmp_path / "all")
    assert repeated.cases == 15
    assert len(list((tmp_path / "all" / "parts").iterdir())) == sum(
        len(list((pieces / name / "parts").iterdir())) for name in "123"
    )


def test_a_shard_resumes_and_takes_no_case_of_another(pieces, tmp_path):
    shutil.copytree(pieces / "2", tmp_path / "2")
    victim = next(iter((tmp_path / "2" / "parts").iterdir()))
    lost = len(pq.read_table(victim))
    victim.unlink()
    again = quiet(MIXED, tmp_path / "2", executor="serial", shard="2/3")
    assert (again.cases, again.ran, again.reused) == (5, lost, 5 - lost)
    assert same_results(tmp_path / "2", pieces / "2")


def test_more_shards_than_cases_leave_some_empty(tmp_path):
    results = [quiet(grid(2), tmp_path / str(k), executor="serial", shard=f"{k}/3") for k in (1, 2, 3)]
    assert [result.cases for result in results] == [1, 1, 0]
    assert results[2].exit_code == 0
    assert merge([tmp_path / str(k) for k in (1, 2, 3)], tmp_path / "all").ok == 2


def test_missing_cases_are_counted_and_their_shard_named_unless_a_part_is_enough(pieces, tmp_path):
    with pytest.raises(DirectoryError, match=r"5 of 15 cases are in none .* shard 2/3, or .*--partial"):
        merge([pieces / "1", pieces / "3"], tmp_path / "all")
    assert not (tmp_path / "all").exists()
    result = merge([pieces / "1", pieces / "3"], tmp_path / "all", partial=True)
    assert (result.ok + result.failed, result.missing, result.exit_code) == (10, 5, 3)
    assert "merged without all cases; merge all shards again" in store.status_text(store.status(tmp_path / "all"))
    assert quiet(MIXED, tmp_path / "all", executor="serial").ran == 5
    assert same_results(tmp_path / "all", pieces / "whole")


def test_a_damaged_batch_counts_as_missing_and_is_named(pieces, tmp_path, capfd):
    places = copies(pieces, tmp_path)
    shard = next(iter((places[1] / "shards").iterdir()))
    shard.write_bytes(shard.read_bytes()[:-9])
    with pytest.raises(DirectoryError, match="shard 2/3"):
        merge(places, tmp_path / "all")
    assert f"shards/{shard.name}: damaged" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"drive": {"speed": "3000 rpm"}}, "drive.speed"),
        ({"save": {"orbits": "none"}}, "save.orbits"),
        ({"sweep": MIXED["sweep"] | {"mechanism.gravity": [GOOD]}}, r"sweep.mechanism.gravity"),
    ],
)
def test_runs_of_another_grid_are_refused_with_the_keys_that_differ(pieces, tmp_path, change, named):
    quiet(MIXED | change, tmp_path / "other", executor="serial", shard="1/9")
    with pytest.raises(DirectoryError, match=named):
        merge([pieces / "1", tmp_path / "other"], tmp_path / "all")
    assert not (tmp_path / "all").exists()


@pytest.mark.parametrize("key", ["model_version", "schema"])
def test_runs_of_another_version_are_refused(pieces, tmp_path, key):
    places = copies(pieces, tmp_path)
    edit_record(places[2], **{key: "0"})
    with pytest.raises(DirectoryError, match=key):
        merge(places, tmp_path / "all")


def test_overlaps_that_agree_are_joined(pieces, tmp_path):
    merge([pieces / "whole", pieces / "1", pieces / "3"], tmp_path / "all")
    assert same_results(tmp_path / "all", pieces / "whole")


class Elsewhere(Fake):
    """The same mechanics on a machine that rounds one thing differently."""

    what = ""

    @classmethod
    def solve(cls, case):
        """Return the result of a case, a little off in one thing."""
        path = Fake.solve(case)
        if path.status == "ok" and cls.what in path.summary:
            path.summary[cls.what] *= 1.0 + 1e-15
        if path.status == "ok" and cls.what in path.channels:
            path.channels[cls.what][7] += 1e-9
        return path


@pytest.mark.parametrize("what", ["crank_torque_peak", "slider/x"])
def test_overlaps_that_disagree_are_refused_with_the_case(pieces, tmp_path, monkeypatch, what):
    monkeypatch.setattr(Elsewhere, "what", what)
    sweep(MIXED, tmp_path / "other", executor="serial", show_progress=False, simulator=Elsewhere, shard="2/3")
    contents = set(pq.read_table(pieces / "2" / "summary.parquet")["case_id"].to_pylist())
    with pytest.raises(DirectoryError, match=f"{what} is") as caught:
        merge([pieces / name for name in "123"] + [tmp_path / "other"], tmp_path / "all")
    assert str(caught.value).split()[1].rstrip(":") in contents
    assert not (tmp_path / "all").exists()


def test_timing_alone_is_no_disagreement(pieces, tmp_path, monkeypatch):
    monkeypatch.setattr(Elsewhere, "what", "run_time")
    sweep(MIXED, tmp_path / "other", executor="serial", show_progress=False, simulator=Elsewhere, shard="2/3")
    merge([pieces / name for name in "123"] + [tmp_path / "other"], tmp_path / "all")
    assert same_results(tmp_path / "all", pieces / "whole")


@pytest.mark.parametrize("content", ["{", "[]", "{}"])
def test_a_record_that_is_none_is_refused(pieces, tmp_path, content):
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(DirectoryError, match=r"run\.json"):
        merge([pieces / "1", tmp_path], tmp_path / "all")


def test_shards_run_merge_and_report_from_the_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sweeping, "sweep", sweep)
    monkeypatch.setattr(merging, "merge", functools.partial(merging.merge, simulator=Fake))
    with open("g.yaml", "w", encoding="utf-8") as file:
        YAML().dump(grid(6, wear=True), file)
    run = functools.partial(CliRunner().invoke, cli.verbs)
    for k in (1, 2):
        assert run(["run", "g.yaml", "--executor", "serial", "--shard", f"{k}/2"]).output.startswith("3 cases ran")
    shards = [f"results/made-up-shard-{k}-of-2" for k in (1, 2)]
    message = run(["merge", *shards, "--out", "results/made-up"])
    assert message.exit_code == 0
    assert message.output.startswith("6 cases of 2 directories merged")
    assert run(["report", "results/made-up"]).exit_code == 0
    assert Path("results/made-up/report.html").stat().st_size > 10_000
    with h5py.File("results/made-up/orbits.h5") as file:
        assert len(file["case_id"]) == 6
    message = run(["merge", *shards, "nowhere", "--out", "x"])
    assert "contains no run" in str(message.exception)
