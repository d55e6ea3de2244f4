"""Nothing of the user's is touched in a run's directory, nothing damaged is read as if it were not, nothing blocks."""

import fcntl
import json
import os
import random
import re
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from fake_physics import FAILS, GOOD, Fake, grid
from test_store import loaded
from test_sweep import quiet

import clearsweep
from clearsweep import cli, store
from clearsweep.contracts import results
from clearsweep.language.errors import DamagedError, DirectoryError
from clearsweep.report.documents.page import write_page
from clearsweep.store import datasets, directory
from clearsweep.store.batch import file_name

pytestmark = pytest.mark.heavy

GRID = grid(3, (GOOD, FAILS), wear=True)
FINAL = ("summary.parquet", "orbits.h5", "run.json")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return the directory of a finished run of GRID."""
    directory = tmp_path_factory.mktemp("finished") / "run"
    quiet(GRID, directory, executor="serial")
    return directory


@pytest.fixture
def run(finished, tmp_path):
    """Return a copy of a finished run."""
    shutil.copytree(finished, tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture
def command(monkeypatch, capsys):
    """Return a function that runs a command line and returns (exit code, stdout, stderr)."""

    def call(*arguments):
        with pytest.raises(SystemExit) as ended:
            cli.main([str(argument) for argument in arguments])
        return ended.value.code, *capsys.readouterr()

    return call


def again(directory):
    return quiet(GRID, directory, executor="serial")


def all_results_text(directory) -> str:
    """Return all that a reader gets of a run, timings and the names of its batches aside."""
    result = clearsweep.open(directory)
    known = {
        key: value for key, value in result.grid.items() if key not in ("start", "end", "counts", "checksum", "merged")
    }
    parts = [known, result.summary.to_dict("list"), result.summary.attrs]
    for case_id in result.summary["case_id"]:
        parts += [result.orbit(case_id).to_dict("list"), result.events(case_id).to_dict("list")]
        parts += [[depths.tobytes() for depths in pair] for pair in result.wear(case_id).values()]
    return repr(parts)


STRANGERS = ("parts/notes.txt", "parts/.DS_Store", "parts/.nfs0001", "parts/mine.parquet", "shards/mine.h5", "tmp/mine")


def test_files_of_the_user_between_those_of_a_run_stay_what_they_are(run):
    (run / "tmp").mkdir()
    for name in STRANGERS:
        (run / name).write_text("precious")
    for name in ("shards/sub", "parts/sub.parquet", "tmp/sub"):
        (run / name).mkdir()
    assert again(run).reused == 6
    assert [(run / name).read_text() for name in STRANGERS] == ["precious"] * len(STRANGERS)
    assert all((run / name).is_dir() for name in ("shards/sub", "parts/sub.parquet", "tmp/sub"))


@pytest.mark.parametrize("name", ["shards/mine.h5", "tmp/mine", "parts/notes.txt"])
def test_a_directory_that_holds_such_files_and_no_run_is_refused_with_their_name(tmp_path, name):
    (tmp_path / name).parent.mkdir()
    (tmp_path / name).write_text("precious")
    with pytest.raises(DirectoryError, match=name):
        again(tmp_path)
    assert [path.read_text() for path in tmp_path.rglob("*") if path.is_file()] == ["precious"]


def test_what_a_killed_run_left_is_removed(run):
    (run / "tmp").mkdir()
    for name in (f".clearsweep-{'0' * 16}.part", f".clearsweep-{'1' * 16}.note", ".clearsweep-stop"):
        (run / "tmp" / name).write_bytes(b"half")
    orphan = run / "shards" / file_name("0" * 16, "f" * 64, "h5")
    orphan.write_bytes(b"no summary names it")
    again(run)
    assert not orphan.exists()
    assert not (run / "tmp").exists()


KINDS = {"link": "is a link", "pipe": "is a pipe", "folder": "is a directory"}


def plant(path, kind, victim):
    """Put something that is no file, a link to `victim` for one, in the place of a file."""
    path.unlink(missing_ok=True)
    {"link": lambda: path.symlink_to(victim), "pipe": lambda: os.mkfifo(path), "folder": path.mkdir}[kind]()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("place", ["lock", "shards/*.h5", "parts/*.parquet", *FINAL])
def test_what_stands_in_the_place_of_a_file_is_refused_and_not_followed(run, kind, place):
    victim = run.parent / "victim"
    victim.write_text("precious")
    path = next(run.glob(place), run / place)
    plant(path, kind, victim)
    with pytest.raises(DirectoryError, match=f"{path.name}: {KINDS[kind]}"):
        again(run)
    if path.name in FINAL:
        with pytest.raises(DirectoryError, match=f"{path.name}: {KINDS[kind]}"):
            clearsweep.open(run)
    assert victim.read_text() == "precious"
    assert os.path.lexists(path)


@pytest.mark.parametrize("folder", ["tmp", "parts", "shards"])
def test_a_folder_that_is_a_link_is_refused_and_what_it_leads_to_stays(run, folder):
    elsewhere = run.parent / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "mine").write_text("precious")
    if (run / folder).exists():
        (run / folder).rename(run.parent / "before")
    (run / folder).symlink_to(elsewhere)
    with pytest.raises(DirectoryError, match=f"{folder}: is a link"):
        again(run)
    assert [path.name for path in elsewhere.iterdir()] == ["mine"]


def test_a_lock_that_is_a_file_of_the_user_is_refused(run):
    (run / "lock").write_text("precious")
    with pytest.raises(DirectoryError, match="lock: is not the lock file of a run"):
        again(run)
    assert (run / "lock").read_text() == "precious"


def test_a_batch_that_may_not_be_read_is_refused_by_name(run, monkeypatch):
    victim, opening = next(run.glob("parts/*.parquet")), os.open

    def denied(path, *rest, **more):
        if Path(path) == victim:
            raise PermissionError(13, "Permission denied", str(path))
        return opening(path, *rest, **more)

    monkeypatch.setattr(os, "open", denied)
    with pytest.raises(DirectoryError, match=f"{victim.name}: cannot be read .Permission denied.; make it readable"):
        again(run)


def test_batches_of_another_grid_are_left_alone_and_left_out(run, tmp_path, capfd):
    quiet(GRID | {"drive": {"speed": "3000 rpm"}}, tmp_path / "other", executor="serial")
    for folder in ("shards", "parts"):
        shutil.copytree(tmp_path / "other" / folder, run / folder, dirs_exist_ok=True)
    before = {path for path in run.rglob("*") if path.is_file()}
    assert again(run).reused == 6
    assert "of another grid; left alone" in capfd.readouterr().err
    assert before <= set(run.rglob("*"))


NO_RECORD = {
    "empty": "{}",
    "list": "[]",
    "text": "no",
    "nested": "[" * 100_000 + "]" * 100_000,
    "frame": '{"frame": {}}',
}


@pytest.mark.parametrize("content", NO_RECORD.values(), ids=NO_RECORD)
def test_a_run_json_that_is_none_is_named_and_restored(run, content, command, tmp_path):
    (run / "run.json").write_text(content)
    for arguments in (
        ["report", run],
        ["show", run, "0" * 16],
        ["status", run],
        ["merge", run, "--out", tmp_path / "x"],
    ):
        code, out, err = command(*arguments)
        assert (code, out) == (2, "")
        assert str(run) in err
        assert "Traceback" not in err
    if content == NO_RECORD["frame"]:  # it could be that of another version
        with pytest.raises(DirectoryError, match="another grid"):
            again(run)
        return
    assert again(run).reused == 6
    assert len(clearsweep.open(run).summary) == 6


def test_a_run_json_that_is_none_and_no_batches_are_left_alone(tmp_path):
    (tmp_path / "run.json").write_text('{"mine": 1}')
    with pytest.raises(DirectoryError, match=r"run\.json: damaged"):
        again(tmp_path)
    assert [path.read_text() for path in tmp_path.iterdir()] == ['{"mine": 1}']


def test_a_run_json_of_another_layout_is_as_good(run):
    record = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps(dict(reversed(record.items()))))
    assert len(clearsweep.open(run).summary) == 6
    del record["checksum"]
    (run / "run.json").write_text(json.dumps(record))
    with pytest.raises(DamagedError, match="checksum"):
        clearsweep.open(run)


def damage_of(run, path, written) -> str:
    """Return what a reader and `status` say of a run in which one file was changed, which may not be nothing."""
    try:
        assert all_results_text(run) == written, f"{path} is read as if it were what was written"
        message = ""
    except DirectoryError as error:
        message = str(error)
    if path.name == "run.json":
        return message
    assert path.name in message or not message
    return " ".join(store.status(run, every_file=True)["damage"])


def survives(finished, run, places, chance):
    """See to it that a flipped bit in one of the files is named, and undone by the next run."""
    shutil.rmtree(run, ignore_errors=True)
    shutil.copytree(finished, run)
    path = chance.choice(sorted(path for place in places for path in run.glob(place)))
    content = bytearray(path.read_bytes())
    content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    path.write_bytes(content)
    written = all_results_text(finished)
    assert path.name in damage_of(run, path, written)
    again(run)
    assert all_results_text(run) == written
    return path.name


PLACES = ("shards/*.h5", "parts/*.parquet", *FINAL)


@pytest.mark.parametrize("place", PLACES)
def test_one_flipped_bit_is_named_and_undone(finished, tmp_path, capfd, place):
    assert survives(finished, tmp_path / "run", [place], random.Random(place)) in capfd.readouterr().err


@pytest.mark.slow
def test_two_hundred_flipped_bits_are_named_and_undone(finished, tmp_path):
    chance = random.Random(1)
    for _ in range(200):
        survives(finished, tmp_path / "run", PLACES, chance)


@pytest.mark.parametrize("name", FINAL)
def test_a_damaged_final_file_is_exit_code_2_with_what_restores_it(run, command, name, tmp_path):
    case_id = clearsweep.open(run).summary["case_id"][0]
    (run / name).write_bytes((run / name).read_bytes()[:-200])
    for arguments in (
        ["report", run],
        ["show", run, case_id],
        ["merge", run, "--out", tmp_path / "x"],
        ["status", run, "--verify"],
    ):
        code, _, err = command(*arguments)
        assert code == 2
        assert re.search(rf"{name}: damaged .*run the grid again with --out {run}, which restores it", err)
    again(run)
    assert command("status", run, "--verify")[0] == 0


def test_orbits_of_another_run_of_the_grid_are_not_taken_for_those_of_this_one(run, tmp_path):
    quiet(GRID | {"sweep": GRID["sweep"] | {"mechanism.gravity": [GOOD]}}, tmp_path / "other", executor="serial")
    shutil.copy(tmp_path / "other" / "orbits.h5", run / "orbits.h5")
    with pytest.raises(DamagedError, match=r"orbits\.h5: damaged .it belongs to another run than summary\.parquet"):
        clearsweep.open(run)


def test_a_damaged_piece_of_a_history_is_found_when_it_is_read(run):
    result = clearsweep.open(run)
    case_id = result.summary.query("status == 'ok'")["case_id"].iloc[0]
    with h5py.File(run / "orbits.h5", "r") as file:
        place = file["slider/x"].id.get_chunk_info(0)
    with open(run / "orbits.h5", "r+b") as file:
        file.seek(place.byte_offset + place.size - 1)  # in the checksum itself, which inflating does not look at
        (last,) = file.read(1)
        file.seek(-1, os.SEEK_CUR)
        file.write(bytes([last ^ 1]))
    assert len(clearsweep.open(run).summary) == 6
    with pytest.raises(DamagedError, match=r"orbits\.h5: damaged"):
        clearsweep.open(run).orbit(case_id)


@pytest.mark.parametrize("size", [0, 1, 2, 719, 720, 721, 5000])
@pytest.mark.parametrize("fill", [None, 0, 255])
def test_the_checksum_of_a_piece_is_that_of_hdf5(size, fill):
    values = np.random.default_rng(size).integers(0, 256, size, "u1") if fill is None else np.full(size, fill, "u1")
    if not size:
        assert datasets.fletcher32(b"") == 0
        return
    with h5py.File("made up", "w", driver="core", backing_store=False) as file:
        dataset = file.create_dataset("x", data=values, chunks=(size,), fletcher32=True)
        file.flush()
        _, content = dataset.id.read_direct_chunk((0,))
    assert int.from_bytes(content[-4:], "little") == datasets.fletcher32(values.tobytes())


def test_final_files_are_made_anew_where_the_same_batch_gives_other_rows(tmp_path):
    held_grid = loaded(grid(1))
    case_id, point = held_grid.case_id(0), held_grid.point(0)
    tries = [results.Trajectory("crashed", "", {}), Fake.solve(held_grid.case(0))]
    with store.RunDirectory(tmp_path / "run").open_for(held_grid) as contents:
        form = store.ResultSchema.of(held_grid)
        store.commit(contents.path, form, "0" * 16, [store.Row(case_id, point, each) for each in tries])
        contents.load_intact_batches()
        (good,) = rows = contents.rows()
        assert good["row"] == 1
        for place, status in ((1, "ok"), (0, "crashed")):
            rows["row"] = place
            contents.write_record(held_grid, merged=store.merge(contents, form, rows))
            assert store.open(contents.path).summary["status"].tolist() == [status]


def test_a_report_is_written_over_no_device_link_or_directory(tmp_path, run, command):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (tmp_path / "link.html").symlink_to(victim)
    os.mkfifo(tmp_path / "pipe.html")
    (tmp_path / "folder.html").mkdir()
    before = sorted(tmp_path.iterdir())
    for name, kind in (
        ("link.html", "link"),
        ("pipe.html", "pipe"),
        ("folder.html", "directory"),
        ("/dev/full", "device"),
    ):
        code, out, err = command("report", run, "--out", tmp_path / name)
        assert (code, out) == (2, "")
        assert f"{name}: is a {kind}, not a file" in err
    assert sorted(tmp_path.iterdir()) == before
    assert victim.read_text() == "precious"
    with pytest.raises(DirectoryError, match="clearsweep did not write it"):
        write_page("new", victim)
    assert victim.read_text() == "precious"
    assert command("report", run, "--out", victim / "x.html")[0] == 2
    code, out, err = command("status", victim)
    assert (code, out) == (2, "")
    assert f"{victim}: contains no run" in err


def test_status_says_how_far_a_run_is_and_who_works_there(tmp_path, command, monkeypatch):
    place, held_grid = tmp_path / "run", loaded(GRID)
    with store.RunDirectory(place).open_for(held_grid, counts={"cases": 6}) as contents:
        row = store.Row(held_grid.case_id(0), held_grid.point(0), Fake.solve(held_grid.case(0)))
        store.commit(contents.path, store.ResultSchema.of(held_grid), "0" * 16, [row])
        working = json.loads(command("status", place, "--json")[1])
        assert (working["state"], working["cases"], working["ok"], working["missing"]) == ("under way", 6, 1, 5)
        assert f"process {os.getpid()} on" in working["holder"]
    code, out, _ = command("status", place)
    assert code == 0
    assert "interrupted; run the same command again to continue" in out
    assert "1 of 6 cases are there: 1 ok, 0 failed, 5 left" in out
    again(place)
    code, out, err = command("status", place, "--verify")
    assert (code, err) == (0, "")
    assert "finished" in out
    assert "6 of 6 cases are there: 3 ok, 3 failed" in out
    assert "all checksums agree" in out
    facts = json.loads(command("status", place, "--json")[1])
    assert list(facts["files"]) == ["summary.parquet", "orbits.h5", "run.json"]
    assert command("status", tmp_path / "nowhere")[0] == 2


def test_who_looks_at_the_lock_as_a_run_begins_does_not_keep_it_out(run, monkeypatch):
    with open(run / "lock", "rb") as looking:
        fcntl.flock(looking, fcntl.LOCK_SH)
        monkeypatch.setattr(directory.time, "sleep", lambda seconds: fcntl.flock(looking, fcntl.LOCK_UN))
        assert again(run).reused == 6


def test_the_name_of_a_directory_that_is_too_long_is_refused(tmp_path):
    with pytest.raises(DirectoryError, match="File name too long"):
        again(tmp_path / ("x" * 300))
