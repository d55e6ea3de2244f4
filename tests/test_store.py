"""What is committed survives, what is damaged is found, and the merged files hold what the batches kept."""

import dataclasses
import json
import math
import os
from pathlib import Path

import duckdb
import fake_physics
import h5py
import numpy as np
import pandas as pd
import polars
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fake_physics import FAILS, GOOD, Fake, grid, sweep
from fake_runs import TEXT

import clearsweep
from clearsweep import grid as grids
from clearsweep import report, store
from clearsweep.contracts import results
from clearsweep.language.errors import DirectoryError, InputError, StorageError
from clearsweep.report.one_case.motion import motion_pictures, saved_channels
from clearsweep.report.study import prepare
from clearsweep.store import batch as batches
from clearsweep.store import datasets, directory, durable, merged
from clearsweep.store.record import record_checksum
from clearsweep.sweeping.pool.case_runner import SIMULATION


def loaded(source):
    return grids.load(source, fake_physics.CATALOGUE)


def rows_of(held_grid, indices):
    return [store.Row(held_grid.case_id(i), held_grid.point(i), Fake.solve(held_grid.case(i))) for i in indices]


def filled(directory, held_grid, batches):
    """Commit the batches, each a list of case indices, and merge them."""
    with store.RunDirectory(directory).open_for(held_grid) as contents:
        for number, indices in enumerate(batches):
            store.commit(directory, store.ResultSchema.of(held_grid), f"{number:016x}", rows_of(held_grid, indices))
        contents.load_intact_batches()
        merged = store.merge(contents, store.ResultSchema.of(held_grid), contents.rows())
        contents.write_record(held_grid, merged=merged)
    return store.open(directory)


def edit_record(directory, **changes):
    """Change values in the frame of a run.json as another version would have written them, its checksum too."""
    record = json.loads((directory / "run.json").read_text())
    record["frame"] |= changes
    record["checksum"] = record_checksum(record)
    (directory / "run.json").write_text(json.dumps(record))


@pytest.fixture
def mixed(tmp_path):
    """Twelve cases with wear and histories in three batches, four of them failed."""
    held_grid = loaded(grid(4, (GOOD, GOOD + 0.001, FAILS), wear=True))
    return held_grid, filled(tmp_path / "run", held_grid, [range(5), range(5, 11), [11]])


def test_summary_holds_every_case_once_in_case_id_order(mixed):
    held_grid, run = mixed
    assert list(run.summary["case_id"]) == sorted(held_grid.case_id(i) for i in range(len(held_grid)))


def test_summary_columns_are_those_of_the_layout_with_their_units(mixed):
    held_grid, run = mixed
    figures = held_grid.layout.columns
    names = ["case_id", *held_grid.axes, "status", "message", *(column.name for column in figures)]
    assert list(run.summary.columns) == names
    assert run.summary.attrs["units"]["mechanism.slider.mass"] == "kg"
    assert {column.name: run.summary.attrs["units"][column.name] for column in figures} == {
        column.name: column.unit for column in figures
    }


def test_what_was_not_computed_is_null_and_never_nan(mixed):
    _, run = mixed
    table = pq.read_table(run.directory / "summary.parquet")
    failed = [status != "ok" for status in table["status"].to_pylist()]
    assert sum(failed) == 4
    for name in table.schema.names[5:]:
        values = table[name].to_pylist()
        assert [value is None for value in values] == failed
        assert not any(isinstance(value, float) and math.isnan(value) for value in values)


def test_orbits_come_back_bit_by_bit(mixed):
    held_grid, run = mixed
    for index in range(len(held_grid)):
        expected = Fake.solve(held_grid.case(index))
        orbit, events = run.orbit(held_grid.case_id(index)), run.events(held_grid.case_id(index))
        if expected.status != "ok":
            assert len(orbit) == len(events) == 0
            continue
        for name, values in expected.channels.items():
            np.testing.assert_array_equal(orbit[name], values)
        for name in results.EVENT_DTYPE.names:
            np.testing.assert_array_equal(events[name].to_numpy(), expected.events[name])
        np.testing.assert_array_equal(run.wear(held_grid.case_id(index))["rod_slider"], expected.wear["rod_slider"])
    assert orbit.attrs["units"]["joints/rod_slider/force_normal"] == "N"


def test_a_failed_case_has_length_zero_and_no_wear(mixed):
    _held_grid, run = mixed
    case_id = run.summary["case_id"][list(run.summary["status"] != "ok").index(True)]
    assert len(run.orbit(case_id)) == 0
    assert np.isnan(run.wear(case_id)["rod_slider"]).all()


def test_what_a_failed_case_went_through_before_is_not_kept(tmp_path):
    held_grid, directory = loaded(grid(2)), tmp_path / "run"
    good, other = (Fake.solve(held_grid.case(k)) for k in range(2))
    failed = results.Trajectory("timeout", "", good.summary, good.channels, good.events, good.wear)
    rows = [store.Row(held_grid.case_id(k), held_grid.point(k), path) for k, path in enumerate((failed, other))]
    with store.RunDirectory(directory).open_for(held_grid) as contents:
        store.commit(directory, store.ResultSchema.of(held_grid), "0" * 16, rows)
        contents.load_intact_batches()
        with h5py.File(contents.batches[0].orbits, "r") as file:
            assert len(good.t) > 0
            assert list(file["offsets"]) == [0, 0, len(other.t)]
            assert np.array_equal(file["t"], other.t)


def test_the_events_that_a_failed_case_kept_are_stored(tmp_path):
    held_grid, directory = loaded(grid(2)), tmp_path / "run"
    met = np.array([(0.1, "rod_slider", "on", 0.2, 0.0), (0.3, "rod_slider", "off", -0.1, 7.0)], results.EVENT_DTYPE)
    other = Fake.solve(held_grid.case(1))
    paths = results.Trajectory("left-bearing", "it left", {}, events=met), dataclasses.replace(other, events=met[:1])
    rows = [store.Row(held_grid.case_id(k), held_grid.point(k), path) for k, path in enumerate(paths)]
    with store.RunDirectory(directory).open_for(held_grid) as contents:
        store.commit(directory, store.ResultSchema.of(held_grid), "0" * 16, rows)
        contents.load_intact_batches()
        merged = store.merge(contents, store.ResultSchema.of(held_grid), contents.rows())
        contents.write_record(held_grid, merged=merged)
    run = store.open(directory)
    assert [len(run.events(row.case_id)) for row in rows] == [2, 1]
    assert run.events(rows[0].case_id)["force_peak"].tolist() == [0.0, 7.0]
    assert len(run.orbit(rows[0].case_id)) == 0


def test_orbits_file_reads_as_the_contract_says(mixed):
    held_grid, run = mixed
    with h5py.File(run.directory / "orbits.h5", "r") as file:
        assert file["offsets"].shape == (len(held_grid) + 1,)
        assert file["offsets"][-1] == len(file["t"])
        assert file["events/offsets"][-1] == len(file["events/t"])
        assert h5py.check_enum_dtype(file["events/joint"].dtype) == {"rod_slider": 0}
        assert h5py.check_enum_dtype(file["events/kind"].dtype) == {"on": 0, "off": 1}
        assert file["wear/rod_slider/bearing"].shape == (len(held_grid), 36)
        assert file["t"].compression == "gzip"
        assert file["t"].shuffle
        result = {}
        file.visititems(lambda name, item: result.update({name: dict(item.attrs)} if hasattr(item, "shape") else {}))
        assert all(attributes["units"] and attributes["description"] for attributes in result.values())
        assert {channel.name for channel in held_grid.layout.channels} <= set(result)


def test_datasets_longer_than_a_chunk_are_put_together_exactly(tmp_path, monkeypatch):
    monkeypatch.setattr(merged, "CHUNK_VALUES", 50)
    monkeypatch.setattr(merged, "CHUNKS_AT_ONCE", 3)
    monkeypatch.setattr(merged, "OPEN_FILES", 2)
    monkeypatch.setattr(merged, "GROUP_ROWS", 4)
    monkeypatch.setattr(merged, "ROWS_IN_MEMORY", 6)
    held_grid = loaded(grid(30, wear=True))
    run = filled(tmp_path / "run", held_grid, [range(k, 30, 7) for k in range(7)])
    assert run.summary["case_id"].tolist() == sorted(held_grid.case_id(index) for index in range(30))
    for index in range(30):
        expected = Fake.solve(held_grid.case(index))
        case_id = held_grid.case_id(index)
        (row,) = run.summary[run.summary["case_id"] == case_id].to_dict("records")
        assert {name: row[name] for name in expected.summary} == pytest.approx(expected.summary, rel=0, nan_ok=True)
        np.testing.assert_array_equal(run.orbit(case_id)["slider/x"], expected.channels["slider/x"])
        np.testing.assert_array_equal(run.wear(case_id)["rod_slider"], expected.wear["rod_slider"])


def test_however_many_groups_a_summary_has_every_batch_is_read_once(tmp_path, monkeypatch):
    monkeypatch.setattr(merged, "GROUP_ROWS", 2)
    monkeypatch.setattr(merged, "ROWS_IN_MEMORY", 5)
    read, original = [], merged.read_summary
    monkeypatch.setattr(merged, "read_summary", lambda path, names: (read.append(path), original(path, names))[1])
    held_grid = loaded(grid(24, orbits="none"))
    filled(tmp_path / "run", held_grid, [range(k, 24, 8) for k in range(8)])
    assert len(read) == len(set(read)) == 8


def test_histories_that_batches_share_are_opened_once(tmp_path, monkeypatch):
    monkeypatch.setattr(merged, "ROWS_IN_MEMORY", 5)
    held_grid = loaded(grid(12))
    schema, run = store.ResultSchema.of(held_grid), store.RunDirectory(tmp_path / "run")
    filled(run.path, held_grid, [range(7), range(7, 12)])
    with run.open_for(held_grid):
        run.load_intact_batches()
        store.keep_histories_once(run, schema, run.rows(), durable.checksum(run.path / "orbits.h5"))
    opened, original = [], directory.open_orbits
    monkeypatch.setattr(
        directory, "open_orbits", lambda path, *args, **how: opened.append(path) or original(path, *args, **how)
    )
    assert not run.load_batches(contents=True)
    assert len(run.batches) == 3
    assert len(opened) == 1
    with merged.OrbitFiles(run, schema) as orbits:
        assert orbits.extents("sample", 1, run.rows())[1].all()
    assert len(opened) == 2


@pytest.mark.parametrize("stage", ["read", "checksum"])
def test_batches_that_a_merge_replaces_meanwhile_are_listed_again(tmp_path, monkeypatch, stage):
    held_grid = loaded(grid(12))
    schema, run = store.ResultSchema.of(held_grid), store.RunDirectory(tmp_path / "run")
    filled(run.path, held_grid, [range(7), range(7, 12)])
    original, listed = getattr(durable, stage), []

    def after_the_end_of_a_merge(path):
        if not listed:
            listed.append(path)
            with run.open_for(held_grid):
                run.load_intact_batches()
                store.keep_histories_once(run, schema, run.rows(), durable.checksum(run.path / "orbits.h5"))
        return original(path)

    reader = store.RunDirectory(run.path, schema)
    monkeypatch.setattr(durable, stage, after_the_end_of_a_merge)
    assert not reader.load_batches(contents=True)
    assert [batch.name for batch in reader.batches] == sorted(batch.name for batch in run.batches)
    assert not listed[0].exists()


def test_without_orbits_there_are_no_histories_but_wear_stays(tmp_path):
    held_grid = loaded(grid(2, orbits="none", wear=True))
    run = filled(tmp_path / "run", held_grid, [[0, 1]])
    with h5py.File(run.directory / "orbits.h5", "r") as file:
        assert set(file) == {"case_id", "offsets", "wear"}
        assert not file["offsets"][:].any()
    assert run.orbit(held_grid.case_id(0)).empty
    assert run.events(held_grid.case_id(0)).empty


def test_a_scene_without_wear_and_orbits_writes_no_shard(tmp_path):
    run = filled(tmp_path / "run", loaded(grid(2, orbits="none")), [[0, 1]])
    assert not list((run.directory / "shards").iterdir())
    assert not any("wear" in name for name in run.summary.columns)
    assert run.wear(run.summary["case_id"][0]) == {}


def test_pandas_polars_and_duckdb_agree_on_the_summary(mixed):
    _, run = mixed
    path = run.directory / "summary.parquet"
    by_pandas = pd.read_parquet(path)
    by_polars = polars.read_parquet(path)
    by_duckdb = duckdb.sql(f"select * from '{path}'").fetchall()
    assert by_polars.columns == list(by_pandas.columns)
    assert by_polars.rows() == by_duckdb
    assert list(by_pandas["case_id"]) == [row[0] for row in by_duckdb]


def test_run_json_contains_the_grid_from_which_the_same_cases_follow(mixed):
    held_grid, run = mixed
    record = json.loads((run.directory / "run.json").read_text())
    again = loaded({key: record[key] for key in held_grid.resolved()})
    assert [again.case_id(i) for i in range(len(again))] == [held_grid.case_id(i) for i in range(len(held_grid))]
    assert run.layout == held_grid.layout


def test_the_newest_result_of_a_case_counts_but_a_good_one_first(tmp_path):
    held_grid, directory = loaded(grid(1)), tmp_path / "run"
    case_id, point = held_grid.case_id(0), held_grid.point(0)
    with store.RunDirectory(directory).open_for(held_grid) as contents:
        for number, status in enumerate(("crashed", "ok", "timeout")):
            path = results.Trajectory(status, "", {}) if status != "ok" else Fake.solve(held_grid.case(0))
            store.commit(
                directory, store.ResultSchema.of(held_grid), f"{number:016x}", [store.Row(case_id, point, path)]
            )
        contents.load_intact_batches()
        assert [bool(row["failed"]) for row in contents.rows()] == [False]


def committed(directory, held_grid, batch):
    """Commit a good result of the first case as a batch of this name."""
    case_id, point = held_grid.case_id(0), held_grid.point(0)
    store.commit(
        directory, store.ResultSchema.of(held_grid), batch, [store.Row(case_id, point, Fake.solve(held_grid.case(0)))]
    )


@pytest.mark.parametrize("names", [("0" * 16, "1" * 16), ("1" * 16, "0" * 16)])
def test_of_two_good_results_the_newer_counts_whatever_its_batch_is_called(tmp_path, names):
    held_grid, directory = loaded(grid(1)), tmp_path / "run"
    with store.RunDirectory(directory).open_for(held_grid) as contents:
        for name in names:
            committed(directory, held_grid, name)
        contents.load_intact_batches()
        (row,) = contents.rows()
        assert contents.batches[row["batch"]].name.startswith(names[1])


def test_batches_taken_over_twice_exist_once(tmp_path):
    held_grid = loaded(grid(1))
    with store.RunDirectory(tmp_path / "one").open_for(held_grid) as first:
        committed(tmp_path / "one", held_grid, "0" * 16)
        first.load_intact_batches()
        with store.RunDirectory(tmp_path / "other").open_for(held_grid) as other:
            for _ in range(2):
                other.link_batches(first)
            assert [batch.name for batch in other.batches] == [batch.name for batch in first.batches]


@pytest.mark.parametrize("folder", ["shards", "parts"])
@pytest.mark.parametrize("harm", ["flip", "cut", "empty", "remove"])
def test_a_damaged_batch_is_found_named_and_forgotten(mixed, folder, harm):
    held_grid, run = mixed
    victim = sorted((run.directory / folder).iterdir())[1]
    content = bytearray(victim.read_bytes())
    content[len(content) // 2] ^= 1
    victim.write_bytes({"flip": content, "cut": content[: len(content) // 2], "empty": b"", "remove": b""}[harm])
    if harm == "remove":
        victim.unlink()
    with store.RunDirectory(run.directory).open_for(held_grid) as contents:
        damage = contents.load_intact_batches()
        assert len(contents.rows()) == 6  # 5 + 6 + 1 without the batch of 6
    if (folder, harm) == ("parts", "remove"):
        assert damage == []  # a batch without a part was never committed
    else:
        assert len(damage) == 1
        assert f"{folder}/{victim.name}" in damage[0]
    assert len(list(run.directory.glob("shards/*.h5"))) == len(list(run.directory.glob("parts/*.parquet"))) == 2
    kept = [victim.parent / f"{victim.name}.damaged"] if harm != "remove" else []
    assert list(run.directory.glob("*/*.damaged")) == kept


def test_a_second_holder_of_the_directory_is_refused(tmp_path):
    held_grid = loaded(grid(1))
    refused = pytest.raises(DirectoryError, match=r"another run works here \(process")
    with (
        store.RunDirectory(tmp_path / "run").open_for(held_grid),
        refused,
        store.RunDirectory(tmp_path / "run").open_for(held_grid),
    ):
        pass
    with store.RunDirectory(tmp_path / "run").open_for(held_grid):
        pass


def test_a_run_that_waited_for_the_lock_works_where_the_one_before_has_cleared_up(tmp_path, monkeypatch):
    held_grid, lock = loaded(grid(1)), store.RunDirectory._lock

    def granted_late(run, file):  # the other run ends while this one waits
        if run.scratch.exists():
            run.scratch.rmdir()
        lock(run, file)

    monkeypatch.setattr(store.RunDirectory, "_lock", granted_late)
    with store.RunDirectory(tmp_path / "run").open_for(held_grid) as contents:
        assert contents.scratch.is_dir()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"drive": {"speed": "3000 rpm"}}, "drive.speed"),
        ({"save": {"orbits": "none"}}, "save.orbits"),
        ({"sweep": {"drive.speed": [100.0]}}, "swept"),
    ],
)
def test_results_of_another_grid_are_refused_with_what_differs(mixed, change, named):
    _, run = mixed
    before = {path: path.read_bytes() for path in run.directory.rglob("*") if path.is_file() and path.name != "lock"}
    with pytest.raises(DirectoryError, match="contains the results of another grid") as caught:
        store.RunDirectory(run.directory).check(loaded(grid(4, (GOOD, GOOD + 0.001, FAILS), wear=True) | change))
    assert named in str(caught.value)
    assert all(path.read_bytes() == content for path, content in before.items())


def test_of_many_differences_to_another_grid_the_first_are_listed_others_counted(mixed):
    _, run = mixed
    with pytest.raises(DirectoryError, match="contains the results of another grid") as caught:
        store.RunDirectory(run.directory).check(loaded({"mechanism": {"type": "four-bar"}} | grid(1, (GOOD,))))
    _, *lines, last = str(caught.value).splitlines()
    assert len(lines) == 5
    assert lines == sorted(lines)
    assert last == "  and 1 more"


def test_a_larger_grid_fits_the_same_directory(mixed):
    _, run = mixed
    store.RunDirectory(run.directory).check(loaded(grid(9, (GOOD,), wear=True)))


def test_results_of_another_model_version_are_refused(mixed):
    held_grid, run = mixed
    edit_record(run.directory, model_version="0")
    with pytest.raises(DirectoryError, match="model_version"):
        store.RunDirectory(run.directory).check(held_grid)


def test_a_directory_with_other_files_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("do not touch")
    with pytest.raises(DirectoryError, match=r"thesis\.tex"), store.RunDirectory(tmp_path).open_for(loaded(grid(1))):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_batches_whose_run_json_was_lost_are_left_alone(mixed):
    held_grid, run = mixed
    (run.directory / "run.json").unlink()
    with pytest.raises(DirectoryError, match=r"parts/.* and no run\.json"):
        store.RunDirectory(run.directory).check(held_grid)


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(DirectoryError), store.RunDirectory(place).open_for(loaded(grid(1))):
            pass


def test_opening_what_is_no_run_says_so(tmp_path, mixed):
    with pytest.raises(DirectoryError, match="contains no run"):
        store.open(tmp_path / "nothing")
    _, run = mixed
    with pytest.raises(InputError, match="no case 'abcx'"):
        run.orbit("abcx")
    with pytest.raises(InputError, match="no case ''"):
        run.orbit("")
    (run.directory / "orbits.h5").unlink()
    with pytest.raises(DirectoryError, match="not finished"):
        store.open(run.directory)


def test_the_first_characters_name_a_case_if_they_are_unique(mixed):
    ids = mixed[1].summary["case_id"].tolist()
    for case_id in ids:
        least = next(k for k in range(1, 17) if sum(other.startswith(case_id[:k]) for other in ids) == 1)
        assert mixed[1].full_id(case_id[:least]) == mixed[1].full_id(case_id) == case_id
        with pytest.raises(InputError, match="no case"):
            mixed[1].full_id(f"{case_id}0")
        assert mixed[1].orbit(case_id[:least]).equals(mixed[1].orbit(case_id))
        if least > 1:
            with pytest.raises(InputError, match="cases begin with"):
                mixed[1].full_id(case_id[: least - 1])


def test_a_full_disk_is_a_storage_error_that_names_the_file(tmp_path, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(durable.os, "fsync", full)
    path = tmp_path / "batch.h5"
    with pytest.raises(StorageError, match=r"batch\.h5.*No space left.*finished cases are safe"), durable.storing(path):
        durable.replace(path, b"", tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_file_is_on_the_disk_before_its_name_and_that_before_what_follows(tmp_path, monkeypatch):
    done = []

    def seen(name, function, message):
        def call(*arguments, **options):
            done.append((name, *message(*arguments)))
            return function(*arguments, **options)

        monkeypatch.setattr(durable.os, name, call)

    seen("fsync", os.fsync, lambda handle: (Path(os.readlink(f"/proc/self/fd/{handle}")).name,))
    seen("replace", os.replace, lambda source, target: (Path(source).name, Path(target).name))
    monkeypatch.setattr(durable.secrets, "token_hex", lambda size: "ab" * size)
    (tmp_path / "tmp").mkdir()
    (tmp_path / "parts").mkdir()
    durable.replace(tmp_path / "parts" / "a", b"content", tmp_path / "tmp")
    scratch = f".clearsweep-{'ab' * 8}.part"
    assert done == [("fsync", scratch), ("replace", scratch, "a"), ("fsync", "parts")]


def test_a_batch_is_committed_after_its_histories(tmp_path, monkeypatch):
    written = []
    monkeypatch.setattr(durable, "replace", lambda path, content, scratch: written.append(path.parent.name))
    held_grid = loaded(grid(2, wear=True))
    store.commit(tmp_path, store.ResultSchema.of(held_grid), "0" * 16, rows_of(held_grid, [0, 1]))
    assert written == ["shards", "parts"]


def test_the_newest_run_is_the_one_whose_record_was_written_last(tmp_path):
    for name, age in (("first", 200), ("last", 100), ("second", 150)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.json").write_text("{}")
        os.utime(tmp_path / name / "run.json", (1e9 - age, 1e9 - age))
    assert store.newest_run(tmp_path) == tmp_path / "last"


def test_words_of_a_column_are_its_values():
    column = pa.array(["ok", None, "", "ok", "no contact", None, "ok"])
    for first, count in ((0, 7), (1, 4), (3, 0), (5, 2)):
        part = column.slice(first, count)
        assert batches.words_of(part).tolist() == batches.values_of(part).tolist() == part.to_pylist()


def test_numbers_of_a_column_are_nan_where_it_is_null():
    column = pa.array([1.5, None, 3.0, None, 5.0])
    np.testing.assert_array_equal(batches.values_of(column), [1.5, np.nan, 3.0, np.nan, 5.0])
    np.testing.assert_array_equal(batches.values_of(column.slice(2, 2)), [3.0, np.nan])
    np.testing.assert_array_equal(batches.values_of(column.slice(4)), [5.0])


@pytest.mark.parametrize("kind", [pa.float64(), pa.int64(), pa.string()])
def test_rows_of_a_column_are_those_that_arrow_takes(kind):
    values = ["ab", None, "", "\u00b5m", "ab"] if kind == pa.string() else [3, None, 2**60, -1, 0]
    for column in (datasets.column_of(values, kind).slice(1), datasets.column_of(values, kind), pa.array(["a"] * 5)):
        for positions in (np.array([3, 0, 2, 2]), np.zeros(0, int)):
            rows = datasets.rows_at(column, positions)
            rows.validate(full=True)
            assert rows.equals(column.take(pa.array(positions, pa.int64())))


# ---------------------------------------------------------------------------------------------- channels that are saved


LISTED = ("slider/a", "joints/rod_slider/force_normal")


def saving(text):
    """Return the demo grid with another `save`."""
    return TEXT.replace("save: {orbits: last, samples: 720}", f"save: {text}")


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Directories of one run with all histories, and of one with two of them."""
    folder = tmp_path_factory.mktemp("channels")
    for name, more in (("all", {}), ("some", {"channels": list(LISTED)})):
        source = grid(3)
        source["save"] = source["save"] | more
        sweep(source, folder / name, executor="serial", show_progress=False)
    return folder


def test_only_the_listed_channels_are_stored_besides_time_and_angle(ran):
    whole, some = clearsweep.open(ran / "all"), clearsweep.open(ran / "some")
    case_id = str(some.summary["case_id"][0])
    assert [*some.orbit(case_id)] == [name for name in whole.orbit(case_id) if name in ("t", "crank_angle", *LISTED)]
    assert some.orbit(case_id).equals(whole.orbit(case_id)[[*some.orbit(case_id)]])
    assert len(some.events(case_id)) == len(whole.events(case_id))
    with h5py.File(ran / "some/orbits.h5") as file:
        assert "slider/x" not in file
        assert "slider/a" in file


def test_fewer_channels_take_less_room_on_the_disk_but_not_in_memory():
    source = grid(3)
    angle_rate = grids.load(source, SIMULATION.catalogue())
    some = grids.load(source | {"save": source["save"] | {"channels": ["slider/a"]}}, SIMULATION.catalogue())
    fewer = len(angle_rate.layout.channels) - len(some.layout.stored)
    assert len(some.layout.stored) == 3
    assert grids.largest_history(angle_rate) - grids.largest_history(some) == 8.0 * 2 * 20 * fewer
    assert grids.recorded_history(some) == grids.largest_history(angle_rate)


def test_the_report_draws_what_exists(ran, tmp_path):
    prepared = prepare(clearsweep.open(ran / "some"))
    case_id = str(prepared.cases.index[0])
    titles = [picture.title for picture in motion_pictures(prepared, case_id, saved_channels(prepared.run, case_id))]
    assert "Normal force" in titles
    assert not any("orbit" in title for title in titles)
    assert report.write(clearsweep.open(ran / "some"), tmp_path / "page.html").exists()


def test_a_resolved_grid_stores_the_same(at):
    first = at(saving("{orbits: last, channels: [slider/a, slider/x, slider/a]}"))
    assert first.resolved()["save"]["channels"] == ["slider/a", "slider/x"]
    again = grids.load(first.resolved(), SIMULATION.catalogue())
    assert again.layout.listed == first.layout.listed == ("slider/a", "slider/x")
    assert first.case_id(0) == at(TEXT).case_id(0)  # what is saved is no part of a case
