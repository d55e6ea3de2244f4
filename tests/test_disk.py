"""`clean` removes what nothing needs, and nothing else; `status` says what the files of a run take."""

import json
import shutil

import pytest
from fake_physics import FAILS, GOOD, grid, sweep
from test_store import filled, loaded, rows_of

from clearsweep import store
from clearsweep.language.errors import DirectoryError
from clearsweep.store import durable, state


def tree(directory):
    """Return the files of a directory by their path, with their content."""
    return {
        path.relative_to(directory).as_posix(): path.read_bytes() for path in directory.rglob("*") if path.is_file()
    }


@pytest.fixture
def run(tmp_path, monkeypatch):
    """A finished run of twelve cases in three batches with histories; its lock says the same time at every hold."""
    monkeypatch.setattr("clearsweep.store.directory.utc_now", lambda: "2026-01-01T00:00:00+00:00")
    filled(tmp_path / "run", loaded(grid(4, (GOOD, GOOD + 0.001, FAILS), wear=True)), [range(5), range(5, 11), [11]])
    return tmp_path / "run"


def removed(facts):
    return {fact["kind"]: fact["files"] for fact in facts["removed"]}


def test_a_run_without_waste_stays_as_it_is(run):
    before = tree(run)
    facts = store.clean(run)
    assert (facts["removed"], facts["bytes"], tree(run)) == ([], 0, before)
    assert facts["left"]["all"] == sum(map(len, before.values()))
    assert "0 B removed" in store.clean_text(facts)


def test_every_kind_of_waste_is_removed_and_what_others_wrote_remains(run):
    before = tree(run)
    held_grid = loaded(grid(4, (GOOD, GOOD + 0.001, FAILS), wear=True))
    form = store.ResultSchema.of(held_grid)
    scratch = run / "tmp"
    scratch.mkdir()
    (scratch / ".clearsweep-0123456789abcdef.part").write_bytes(b"x" * 100)
    (run / ".clearsweep-0123456789abcdef.part").write_bytes(b"page")
    (scratch / "mine").write_bytes(b"mine")
    good = store.open(run).summary.query("status == 'ok'")["case_id"]
    durable.scratch_file(scratch, f"{good.iloc[0]}.life").write_bytes(b"blocks")
    durable.scratch_file(scratch, f"{'f' * 16}.life").write_bytes(b"blocks of a case without a row")
    (run / "parts" / f"{'1' * 16}-{'2' * 16}.parquet.damaged").write_bytes(b"bad")
    (run / "parts" / "notes.damaged").write_bytes(b"not a copy")
    again = store.commit(run, form, f"{7:016x}", rows_of(held_grid, range(5)))  # takes the place of the first batch
    alone = store.commit(run, form, f"{8:016x}", rows_of(held_grid, range(5, 11)))
    (run / "parts" / alone).unlink()
    tried = store.clean(run, dry_run=True)
    assert removed(tried) == {"writes": 2, "histories": 1, "repeated": 2, "lives": 1, "damaged": 1}
    at_first = tree(run)
    assert store.clean(run, dry_run=True) == tried
    assert tree(run) == at_first
    facts = store.clean(run)
    assert removed(facts) == removed(tried)
    assert facts["bytes"] == tried["bytes"] == sum(map(len, at_first.values())) - sum(map(len, tree(run).values()))
    first = {name for name in before if f"/{0:016x}-" in name}
    new = set(tree(run)) - set(before)
    assert set(before) - set(tree(run)) == first
    assert f"parts/{again}" in new
    assert {"tmp/mine", f"tmp/.clearsweep-{'f' * 16}.life", "parts/notes.damaged"} < new
    assert store.status(run, every_file=True)["state"] == "finished"
    assert removed(store.clean(run)) == {}


def test_batches_go_where_they_are_requested_and_the_results_remain_readable(run):
    before = store.open(run).summary
    facts = store.clean(run, batches=True)
    assert removed(facts) == {"batches": 6}
    assert facts["left"]["batches"] == 0
    assert store.open(run).summary.equals(before)
    assert store.status(run, every_file=True)["damage"] == []


def test_the_next_run_after_that_computes_its_cases_again(tmp_path):
    result = sweep(grid(3), tmp_path / "run", executor="serial")
    store.clean(tmp_path / "run", batches=True)
    assert sweep(grid(3), tmp_path / "run", executor="serial").ran == result.ran == 3
    assert store.open(tmp_path / "run").summary["status"].tolist() == ["ok"] * 3


def test_cases_that_only_batches_hold_are_counted(tmp_path):
    sweep(grid(5), tmp_path / "run", executor="serial")
    sweep(grid(3), tmp_path / "run", executor="serial")
    facts = store.clean(tmp_path / "run", batches=True, dry_run=True)
    assert facts["other_cases"] == 2
    assert "2 cases that the last grid does not contain" in store.clean_text(facts)


def test_the_batches_of_an_unfinished_run_remain(run):
    record = json.loads((run / "run.json").read_text())
    for key in ("merged", "checksum"):
        record.pop(key)
    (run / "run.json").write_text(json.dumps(record | {"checksum": store.record.record_checksum(record)}))
    facts = store.clean(run, batches=True)
    assert (facts["finished"], facts["removed"]) == (False, [])
    assert "its batches are kept" in store.clean_text(facts)


def test_damaged_results_and_damaged_batches_are_not_made_worse(run):
    with open(run / "orbits.h5", "ab") as file:
        file.write(b"x")
    with pytest.raises(DirectoryError, match=r"orbits\.h5"):
        store.clean(run, batches=True)
    summary = next((run / "parts").iterdir())
    summary.write_bytes(summary.read_bytes()[:-1] + b"x")
    before = tree(run)
    assert store.clean(run)["removed"] == []  # the next run sets both files of this batch aside or computes it again
    assert tree(run) == before


def test_a_directory_without_a_run_or_with_a_running_one_is_refused(run, tmp_path):
    with pytest.raises(DirectoryError):
        store.clean(tmp_path)
    with store.RunDirectory(run).locked(), pytest.raises(DirectoryError, match="another run works here"):
        store.clean(run)


def test_status_says_what_the_files_take(run):
    (run / "report.html").write_bytes(b"x" * 2000)
    facts = store.status(run)
    sizes = facts["disk"]
    assert sizes["all"] == sum(map(len, tree(run).values())) == sizes["results"] + sizes["batches"] + sizes["other"]
    assert sizes["other"] == 2000 + len((run / "lock").read_bytes())
    assert f"Disk: {state.disk_use_text(sizes)}" in store.status_text(facts)
    shutil.rmtree(run / "shards")
    assert store.status(run)["disk"]["batches"] < sizes["batches"]
