"""A grid that is cut into blocks gives what the same grid gives in one piece."""

import json
import shutil
from collections import Counter
from concurrent.futures import Future
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from fake_faults import DiesFinishing
from fake_physics import CATALOGUE, FAILS, GOOD, Fake, grid, merge
from test_sweep import quiet

import clearsweep
from clearsweep import grid as grids
from clearsweep import report, store
from clearsweep.language.errors import DamagedError, DirectoryError, InputError
from clearsweep.report.blocks.section import Note, Points, Sentences
from clearsweep.store import blocks, dataset, durable, merged, results
from clearsweep.store.record import record_checksum
from clearsweep.sweeping import blockwise, estimate, summary
from clearsweep.sweeping.merge import complete_run

MIXED = grid(12, (GOOD, GOOD + 0.001, FAILS), wear=True)  # 36 cases, 12 of them fail


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Cut grids of more than eight cases."""
    monkeypatch.setattr(blocks, "BLOCK", 8)


@pytest.fixture(scope="module")
def mixed_once(tmp_path_factory):
    """Return the directory of a run of MIXED in blocks of eight cases."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "BLOCK", 8)
        return quiet(MIXED, tmp_path_factory.mktemp("mixed") / "run", executor="serial").directory


@pytest.fixture
def mixed(mixed_once, tmp_path):
    """Leave a copy of that run in the directory of the test."""
    shutil.copytree(mixed_once, tmp_path / "run")


def rows_of(directory):
    tables = [pq.read_table(path) for path in sorted((directory / "summary").glob("*.parquet"))]
    return {row["case_id"]: row for table in tables for row in table.to_pylist()}


def test_blocks_have_the_rows_of_one_piece(tmp_path, monkeypatch):
    cut = quiet(MIXED, tmp_path / "cut", executor="serial")
    monkeypatch.setattr(blocks, "BLOCK", 2**17)
    whole = quiet(MIXED, tmp_path / "whole", executor="serial")
    assert (cut.cases, cut.ran, cut.ok, cut.failed, cut.missing) == (36, 36, 24, 12, 0)
    assert (whole.ok, whole.failed) == (24, 12)
    expected = {row["case_id"]: row for row in pq.read_table(tmp_path / "whole" / "summary.parquet").to_pylist()}
    assert rows_of(tmp_path / "cut") == expected
    assert len(list((tmp_path / "cut" / "summary").iterdir())) == 5
    for path in (tmp_path / "cut" / "summary").iterdir():
        ids = pq.read_table(path)["case_id"].to_pylist()
        assert ids == sorted(ids)
    assert not (tmp_path / "cut" / "summary.parquet").exists()
    assert len(store.open(tmp_path / "cut").summary) == 36


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """Return the directories of MIXED in blocks of eight cases and in one piece."""
    folder = tmp_path_factory.mktemp("blocks")
    limited = MIXED | {"limits": {"rod_slider_force_peak": 0.105}, "save": MIXED["save"] | {"worst": 2}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocks, "BLOCK", 8)
        cut = quiet(limited, folder / "cut", executor="serial")
    whole = quiet(limited, folder / "whole", executor="serial")
    return cut, whole


def test_the_closing_table_says_the_same(pair):
    cut, whole = (summary.of_run(result) for result in pair)
    for name in ("directory", "seconds", "case_seconds", "files", "failures", "derived", "warnings", "slowest"):
        cut.pop(name), whole.pop(name)
    assert whole["answer"]
    assert cut == whole
    assert whole["limits"]["exceeding"] > 0
    assert summary.run_text(summary.of_run(pair[0])).count("Smallest margin")


def test_the_answer_of_very_many_cases_counts_them_all_and_judges_no_design(pair, monkeypatch):
    cut, whole = (clearsweep.open(result.directory).answer for result in pair)
    monkeypatch.setattr(results, "MOST_READ", 8)
    part = clearsweep.open(pair[0].directory).answer
    assert part["cases"] == cut["cases"] == whole["cases"]
    assert (part["complete"], part["designs"], part["effects"]) == (False, [], [])
    assert part["extremes"] == whole["extremes"]
    assert clearsweep.open(pair[1].directory).answer == whole  # one piece is always read as a whole


def test_a_case_is_found_and_read_as_in_one_piece(pair):
    cut, whole = (clearsweep.open(result.directory) for result in pair)
    for case_id in whole.summary["case_id"]:
        assert cut.full_id(case_id[:12]) == case_id
        pd.testing.assert_frame_equal(cut.orbit(case_id), whole.orbit(case_id))
        pd.testing.assert_frame_equal(cut.events(case_id), whole.events(case_id))
        np.testing.assert_array_equal(cut.wear(case_id)["rod_slider"], whole.wear(case_id)["rod_slider"])
    with pytest.raises(InputError, match=r"no case 'zz'"):
        cut.orbit("zz")
    (letter, count), *_ = Counter(case_id[0] for case_id in whole.summary["case_id"]).most_common()
    assert count > 1
    with pytest.raises(InputError, match="write more"):
        cut.full_id(letter)
    worst = cut.worst
    assert set(whole.worst) <= set(worst)
    pd.testing.assert_frame_equal(cut.peak_revolution(whole.worst[0]), whole.peak_revolution(whole.worst[0]))


def test_the_summary_is_read_as_far_as_it_is_requested(pair, monkeypatch):
    cut, whole = (clearsweep.open(result.directory) for result in pair)
    lazy, frame = cut.summary, whole.summary
    assert (len(lazy), list(lazy.columns)) == (len(frame), list(frame.columns))
    assert lazy.attrs == frame.attrs
    mass, steps = "mechanism.slider.mass", "steps"

    def same(actual, expected):
        actual = actual.sort_values("case_id").reset_index(drop=True)
        pd.testing.assert_frame_equal(actual, expected.reset_index(drop=True), check_dtype=False)

    same(lazy[lazy[mass] > 0.105], frame[frame[mass] > 0.105])
    same(lazy[(lazy[mass] <= 0.105) & (lazy.status == "ok")], frame[(frame[mass] <= 0.105) & (frame.status == "ok")])
    same(lazy[lazy.status != "ok"], frame[frame.status != "ok"])
    same(lazy[lazy[mass].isin([0.1, 0.111])], frame[frame[mass].isin([0.1, 0.111])])
    same(lazy[lazy[steps] < 10_500], frame[frame[steps] < 10_500])
    same(lazy.frame(), frame)
    assert lazy[steps].sum() == frame[steps].sum()
    assert np.asarray(lazy["case_id"]).size == 36
    opened = []
    original = dataset.scan
    monkeypatch.setattr(dataset, "scan", lambda *of: opened.append(of) or original(*of))
    case_id = frame["case_id"][7]
    same(lazy[lazy["case_id"] == case_id], frame[frame["case_id"] == case_id])
    assert len(opened) == 1
    assert not len(lazy[lazy["case_id"] == "no such case"])
    opened.clear()
    assert len(lazy[lazy[mass] > 0.1105]) == 3
    assert len(opened) == 1  # the masses of a block are in its mark


def test_a_second_run_looks_at_marks_alone(pair, monkeypatch):
    result = pair[0]
    monkeypatch.setattr(blockwise.BlockJob, "cases", None)
    monkeypatch.setattr(store.Block, "directory", None)
    source = store.read_record(result.directory)
    again = quiet({key: source[key] for key in source["keys"]}, result.directory, executor="serial")
    assert (again.ran, again.reused, again.ok, again.failed, again.missing) == (0, 36, 24, 12, 0)


@pytest.mark.usefixtures("mixed")
def test_reworded_descriptions_finish_no_block_again_and_mix_with_earlier_ones(tmp_path, monkeypatch):
    marks = {path: path.read_bytes() for path in tmp_path.glob("run/blocks/*/block.json")}
    reworded = [each._replace(text="reworded") for each in CATALOGUE.figures]
    monkeypatch.setattr(Fake, "catalogue", lambda: CATALOGUE._replace(figures=tuple(reworded)))
    again = quiet(MIXED, tmp_path / "run", executor="serial")
    assert (again.ran, {path: path.read_bytes() for path in marks}) == (0, marks)
    (tmp_path / "run" / "blocks" / "00001" / "block.json").unlink()
    quiet(MIXED, tmp_path / "run", executor="serial")
    texts = [pq.read_schema(path).field("steps").metadata for path in sorted(tmp_path.glob("run/summary/*.parquet"))]
    assert [text[b"description"] == b"reworded" for text in texts] == [False, True, False, False, False]
    run = store.open(tmp_path / "run")
    assert len(run.summary.frame()) == 36
    assert report.write(run, tmp_path / "page.html").exists()


@pytest.mark.parametrize("name", ["summary/00001.parquet", "blocks/00001/orbits.h5", "blocks/00001/block.json"])
@pytest.mark.usefixtures("mixed")
def test_a_file_that_is_lost_is_rewritten_from_the_batches(tmp_path, name):
    before = {path: path.read_bytes() for path in (tmp_path / "run").rglob("*.parquet")}
    (tmp_path / "run" / name).unlink()
    again = quiet(MIXED, tmp_path / "run", executor="serial")
    assert (again.ran, again.reused) == (0, 36)
    assert {path: path.read_bytes() for path in (tmp_path / "run").rglob("*.parquet")} == before


@pytest.mark.usefixtures("mixed")
def test_a_lost_batch_of_an_unfinished_block_runs_again(tmp_path):
    before = rows_of(tmp_path / "run")
    block = tmp_path / "run" / "blocks" / "00002"
    (block / "block.json").unlink()
    victim = next((block / "parts").iterdir())
    lost = len(pq.read_table(victim))
    victim.unlink()
    assert quiet(MIXED, tmp_path / "run", executor="serial").ran == lost
    assert rows_of(tmp_path / "run") == before


def test_workers_run_and_finish_blocks(tmp_path):
    result = quiet(MIXED, tmp_path / "run", jobs=2)
    assert (result.ran, result.ok, result.failed) == (36, 24, 12)
    assert len(rows_of(tmp_path / "run")) == 36
    assert not list((tmp_path / "run").glob("blocks/*/tmp"))


def test_an_axis_that_grows_at_its_slow_end_reuses_blocks(tmp_path):
    quiet(grid(8, (0.0, 0.001)), tmp_path / "run", executor="serial")
    again = quiet(grid(12, (0.0, 0.001)), tmp_path / "run", executor="serial")
    assert (again.cases, again.ran, again.reused) == (24, 8, 16)
    fewer = quiet(grid(8, (0.0, 0.001)), tmp_path / "run", executor="serial")
    assert (fewer.cases, fewer.ran, fewer.ok) == (16, 0, 16)
    assert len(rows_of(tmp_path / "run")) == 16


def test_a_run_that_was_in_one_piece_continues_in_blocks(tmp_path):
    quiet(grid(4, (0.0, 0.001)), tmp_path / "run", executor="serial")
    again = quiet(grid(12, (0.0, 0.001)), tmp_path / "run", executor="serial")
    assert (again.cases, again.ran, again.reused) == (24, 16, 8)
    assert not (tmp_path / "run" / "summary.parquet").exists()
    assert len(rows_of(tmp_path / "run")) == 24


def test_a_case_that_two_indices_have_is_in_the_block_of_the_first(tmp_path):
    source = grid(1, (0.0,), define={"a": "0.1 kg", "b": "0.2 kg"})
    source["mechanism"] = source["mechanism"] | {"slider": {"mass": "= max(a, b)"}}
    values = [0.1 + 0.01 * k for k in range(5)]
    source["sweep"] = {"define.a": values, "define.b": values}
    result = quiet(source, tmp_path / "run", executor="serial")
    assert (result.cases, result.ran, result.missing) == (5, 5, 0)
    assert len(pq.read_table(tmp_path / "run" / "summary" / "00000.parquet")) == 5
    assert len(rows_of(tmp_path / "run")) == 5
    assert quiet(source, tmp_path / "run", executor="serial").ran == 0


@pytest.mark.usefixtures("mixed")
def test_failed_cases_run_again_where_that_is_requested(tmp_path):
    again = quiet(MIXED, tmp_path / "run", executor="serial", retry_failed=True)
    assert (again.ran, again.ok, again.failed) == (12, 24, 12)


def test_too_many_failures_leave_the_rest_and_a_later_run_continues(tmp_path):
    result = quiet(MIXED, tmp_path / "run", executor="serial", max_failures=3)
    assert result.missing > 0
    assert result.failed >= 4
    assert len(store.open(result.directory)) == result.ok + result.failed
    again = quiet(MIXED, tmp_path / "run", executor="serial")
    assert (again.missing, again.ok, again.failed) == (0, 24, 12)


@pytest.mark.parametrize("is_shared", [False, True])
def test_files_of_other_drivers_in_a_block_are_kept(tmp_path, is_shared):
    job = SimpleNamespace(directory=tmp_path)
    runner = blockwise.BlockRunner(job, SimpleNamespace(workers=None))
    directory = store.Block(tmp_path, 0).directory(store.ResultSchema.of(grids.load(grid(1), CATALOGUE)))
    other = durable.scratch_file(directory.scratch, "0123456789abcdef.part")
    other.write_bytes(b"half of a commit")
    future = Future()
    future.set_result({})
    runner.finishing[0] = (future, lambda: future)
    runner.shared |= {0} if is_shared else set()
    runner.collect()
    assert other.exists() == is_shared


def test_shards_of_blocks_are_joined_block_by_block(tmp_path, pair):
    shards = [quiet(MIXED, tmp_path / str(k), executor="serial", shard=f"{k}/3") for k in (1, 2, 3)]
    assert sum(shard.cases for shard in shards) == 36
    assert all(not shard.missing for shard in shards)
    with pytest.raises(DirectoryError, match=r"cases are in none .* shard 2/3, or .*--partial"):
        merge([tmp_path / "1", tmp_path / "3"], tmp_path / "all")
    assert not (tmp_path / "all").exists()
    result = merge([tmp_path / name for name in "123"], tmp_path / "all")
    assert (result.cases, result.ok, result.failed, result.missing) == (36, 24, 12, 0)
    assert rows_of(tmp_path / "all").keys() == rows_of(pair[0].directory).keys()
    again = quiet(MIXED, tmp_path / "all", executor="serial")
    assert (again.ran, again.reused) == (0, 36)


@pytest.mark.usefixtures("mixed")
def test_status_counts_marks_and_compares_checksums_if_requested(tmp_path):
    facts = store.status(tmp_path / "run")
    assert (facts["state"], facts["cases"], facts["ok"], facts["failed"], facts["missing"]) == (
        "finished",
        36,
        24,
        12,
        0,
    )
    assert store.status(tmp_path / "run", every_file=True)["state"] == "finished"
    path = tmp_path / "run" / "summary" / "00003.parquet"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    facts = store.status(tmp_path / "run", every_file=True)
    assert facts["state"] == "damaged"
    assert "00003.parquet" in facts["damage"][0]
    path.unlink()
    assert store.status(tmp_path / "run")["state"] == "damaged"
    with pytest.raises(DirectoryError, match=r"00003.parquet: damaged \(it is missing\)"):
        clearsweep.open(tmp_path / "run")


def test_an_unfinished_run_is_read_as_far_as_its_blocks_are_finished(tmp_path):
    quiet(MIXED, tmp_path / "run", executor="serial", max_failures=3)
    record = store.read_record(tmp_path / "run")
    left = {key: value for key, value in record.items() if key not in ("merged", "checksum")}
    (tmp_path / "run" / "run.json").write_text(json.dumps(left | {"checksum": record_checksum(left)}))
    with pytest.raises(DirectoryError, match="not finished"):
        clearsweep.open(tmp_path / "run")
    assert len(clearsweep.open(tmp_path / "run", partial=True)) == record["counts"]["ok"] + record["counts"]["failed"]
    facts = store.status(tmp_path / "run")
    assert facts["state"] == "interrupted"
    assert facts["ok"] + facts["failed"] + facts["missing"] == 36


def test_a_dry_run_counts_the_cases_of_all_blocks(tmp_path):
    facts = estimate.estimate(grid(12, (0.0, 0.001)), tmp_path / "run", simulator=Fake)
    assert (facts.cases, facts.pending) == (24, 24)


def test_the_page_of_a_run_in_blocks_says_that_it_shows_a_sample(pair, tmp_path):
    page = clearsweep.open(pair[0].directory).report(tmp_path / "page.html").read_text(encoding="utf-8")
    assert "36" in page
    assert "a random sample" in page


def said(sections, *keys):
    """Return the sentences and the numbers of cases in the tables of some sections of a page."""
    matches = {}
    for each in (section for section in sections if section.key in keys):
        texts = [text for block in each.blocks if isinstance(block, (Points, Sentences)) for text in block.texts]
        matches[each.key] = (
            texts,
            [row[2:5] for table in each.tables if table.key == "limits_kept" for row in table.rows],
        )
    return matches


def test_counts_on_the_page_of_a_sample_are_of_all_cases_or_say_of_which(pair, tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "SAMPLED_ROWS", 0)
    monkeypatch.setattr(blocks, "MIN_SAMPLED_ROWS", 1)
    limits = {"rod_slider_force_peak": {"at_most": 0.105, "times": "rod_slider_force_peak_ideal"}}
    limits |= {"rod_slider_penetration_max": {"at_least": 0.11}}
    limited = MIXED | {"limits": limits}
    quiet(limited, tmp_path / "cut", executor="serial")
    sample = report.page_of(clearsweep.open(tmp_path / "cut")).sections
    monkeypatch.setattr(blocks, "BLOCK", 2**17)
    quiet(limited, tmp_path / "whole", executor="serial")
    whole = report.page_of(clearsweep.open(tmp_path / "whole")).sections
    counted = "summary", "verdict", "failures", "trust"
    assert said(sample, *counted) == said(whole, *counted)
    shown = {card[0]: card[1] for card in next(each for each in sample if each.key == "summary").blocks[0].cards}
    assert shown["Cases finished"] == "24 of 36"
    assert int(shown["Shown on this page"].split()[0]) < 36
    for section in sample:
        if section.title and section.key not in ("mechanism", "setup"):
            assert isinstance(section.blocks[0], Note), section.key
            assert "the sample" in section.blocks[0].text, section.key
    assert not any("the sample" in block.text for each in whole for block in each.blocks if isinstance(block, Note))


def test_a_summary_with_groups_of_another_size_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr(merged, "GROUP_ROWS", 3)
    quiet(MIXED, tmp_path / "run", executor="serial")
    rows = clearsweep.open(tmp_path / "run").summary
    for case_id in rows.frame()["case_id"]:
        assert rows[rows["case_id"] == case_id]["case_id"].tolist() == [case_id]


@pytest.mark.usefixtures("mixed")
def test_a_damaged_record_of_a_run_in_blocks_is_restored(tmp_path, capfd):
    (tmp_path / "run" / "run.json").write_text("{")
    again = quiet(MIXED, tmp_path / "run", executor="serial")
    assert (again.ran, again.reused) == (0, 36)
    assert "restored from the batches" in capfd.readouterr().err
    assert len(clearsweep.open(tmp_path / "run")) == 36


@pytest.mark.parametrize("name", ["blocks", "summary"])
def test_a_link_in_the_place_of_a_folder_is_refused(tmp_path, name):
    quiet(grid(2), tmp_path / "run", executor="serial")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "run" / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(DirectoryError, match=f"{name}: is a link"):
        quiet(grid(9), tmp_path / "run", executor="serial")
    assert not list((tmp_path / "elsewhere").iterdir())


@pytest.mark.few("change0", "change2")
@pytest.mark.parametrize(
    "change", [{"ok": "x"}, {"ranges": []}, {"ranges": {"steps": [0.0]}}, {"counts": {}}, {"drawn": -1}, {"block": 1}]
)
@pytest.mark.usefixtures("mixed")
def test_a_mark_that_nobody_wrote_counts_for_nothing(tmp_path, change):
    path = tmp_path / "run" / "blocks" / "00000" / "block.json"
    mark = {key: value for key, value in json.loads(path.read_text()).items() if key != "checksum"} | change
    path.write_text(json.dumps(mark | {"checksum": store.sha256_of(json.dumps(mark, sort_keys=True))}))
    with pytest.raises(DirectoryError, match=r"block\.json: damaged"):
        clearsweep.open(tmp_path / "run").marks()
    assert quiet(MIXED, tmp_path / "run", executor="serial").ran == 0
    assert len(clearsweep.open(tmp_path / "run").marks()) == 5


def crafted_block(directory, number, name):
    """Write an infinite figure into a table of a block, as somebody would who knows how its mark is made."""
    block = store.Block(directory, number)
    path = block.files[name]
    table = pq.read_table(path)
    index = table.schema.get_field_index("rod_slider_force_peak")
    infinite = table.set_column(index, table.schema.field(index), pa.array([np.inf] * len(table)))
    pq.write_table(infinite, path, write_page_checksum=True)
    mark = json.loads(block.mark.read_text())
    mark.pop("checksum")
    mark["files"][name] = [durable.checksum(path), path.stat().st_size]
    block.mark.write_text(json.dumps(mark | {"checksum": store.sha256_of(json.dumps(mark, sort_keys=True))}))


@pytest.mark.parametrize("name", ["summary.parquet", "sample.parquet"])
@pytest.mark.usefixtures("mixed")
def test_a_crafted_table_of_a_block_is_refused_and_the_next_run_restores_it(tmp_path, name, capfd):
    before = rows_of(tmp_path / "run")
    crafted_block(tmp_path / "run", 1, name)
    run = clearsweep.open(tmp_path / "run")
    with pytest.raises(DamagedError, match="rod_slider_force_peak has values that no run writes"):
        run.summary.frame() if name == "summary.parquet" else report.page_of(run)
    again = quiet(MIXED, tmp_path / "run", executor="serial")
    assert (again.ran, again.reused) == (0, 36)
    assert "written again from the batches" in capfd.readouterr().err
    assert rows_of(tmp_path / "run") == before
    assert len(clearsweep.open(tmp_path / "run").summary.frame()) == 36


def test_conditions_on_columns_combine_as_those_of_a_frame(pair):
    cut, whole = (clearsweep.open(result.directory) for result in pair)
    lazy, frame = cut.summary, whole.summary
    mass, peak = "mechanism.slider.mass", "rod_slider_force_peak"  # of failed cases there is no peak

    def ids(rows):
        return sorted(rows["case_id"])

    first = frame["case_id"][0]
    assert frame[peak].isna().any()
    assert ids(lazy[(lazy[mass] > 0.107) | (lazy[peak] < 0.101)]) == ids(
        frame[(frame[mass] > 0.107) | (frame[peak] < 0.101)]
    )
    assert ids(lazy[(lazy["case_id"] == first) | (lazy[mass] > 0.11)]) == ids(
        frame[(frame["case_id"] == first) | (frame[mass] > 0.11)]
    )
    assert ids(lazy[(lazy[peak] < 1.0) | (lazy[mass] > 0.11)]) == ids(
        frame[(frame[peak] < 1.0) | (frame[mass] > 0.11)]
    )  # of every peak of a block, but not of the null ones
    assert ids(lazy[~(lazy[peak] > 0.105)]) == ids(frame[frame[peak] <= 0.105])  # null meets nothing
    assert ids(lazy[~(lazy["case_id"] == first)]) == ids(frame[frame["case_id"] != first])
    assert not len(lazy[(lazy["case_id"] == first) & (lazy["case_id"] == frame["case_id"][1])])
    assert not len(lazy[lazy[mass].isin([])])
    with pytest.raises(InputError, match=r"status: is compared with 1; expected a text"):
        lazy["status"].__eq__(1)
    with pytest.raises(InputError, match=r"expected a number"):
        lazy[mass].__gt__("0.1")


def test_a_link_in_place_of_a_part_is_refused_not_followed(pair, tmp_path):
    shutil.copytree(pair[0].directory, tmp_path / "run")
    path = tmp_path / "run" / "summary" / "00001.parquet"
    path.rename(tmp_path / "elsewhere.parquet")
    path.symlink_to(tmp_path / "elsewhere.parquet")
    with pytest.raises(DirectoryError, match=r"00001\.parquet: is a link"):
        clearsweep.open(tmp_path / "run").summary.frame()


def test_all_cases_of_a_run_in_blocks_are_those_of_its_grid(pair):
    with complete_run(pair[0].directory, Fake) as run:
        assert len(run) == 36


@pytest.mark.slow
@pytest.mark.heavy
def test_workers_of_a_cluster_run_and_finish_blocks(tmp_path):
    pytest.importorskip("distributed")
    result = quiet(grid(12, (GOOD, FAILS)), tmp_path / "run", executor="dask", jobs=1)
    assert (result.ran, result.ok, result.failed, result.missing) == (24, 12, 12, 0)
    assert len(rows_of(tmp_path / "run")) == 24
    assert store.status(tmp_path / "run", every_file=True)["state"] == "finished"


@pytest.mark.parametrize("count", [0, 1, 5, 3000, 50_000])
def test_an_identity_is_located_in_a_file_of_many(tmp_path, count):
    chance = np.random.default_rng(count)
    ids = np.sort(chance.integers(0, 2**64, count, dtype="u8"))
    if count == 50_000:
        ids[: count // 2] = np.arange(count // 2)  # not evenly spread at all
    block = store.Block(tmp_path, 3)
    block.path.mkdir(parents=True)
    ids.astype("<u8").tofile(block.path / "ids.bin")
    part = store.Part(block.files, None)
    values = [0, 1, 2**63, 2**64 - 1, *ids[:: max(count // 40, 1)].tolist()]
    for low in values:
        for high in (low, min(low + 2**60, 2**64 - 1)):
            expected = [np.count_nonzero(ids < np.uint64(low)), np.count_nonzero(ids <= np.uint64(high))]
            assert list(part.rows_between(low, high)) == expected


@pytest.mark.heavy
def test_a_block_whose_worker_dies_while_it_is_finished_is_finished_by_another(tmp_path, monkeypatch):
    monkeypatch.setenv("CLEARSWEEP_TEST_MARKER", str(tmp_path / "died"))
    source = MIXED | {"save": MIXED["save"] | {"worst": 1}}
    result = quiet(source, tmp_path / "run", jobs=2, simulator=DiesFinishing)
    assert (tmp_path / "died").exists()
    assert (result.ok, result.failed, result.missing) == (24, 12, 0)
    assert store.status(tmp_path / "run", every_file=True)["state"] == "finished"
    assert len(store.open(tmp_path / "run").worst) == 5
