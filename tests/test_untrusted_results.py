"""A results directory is read like a file from a stranger: what is not as it was written is refused in a sentence."""

import copy
import errno
import html.parser
import json
import os
import shutil

import fake_physics
import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from test_seek import searching
from test_sweep import same_results

import clearsweep
from clearsweep import exit_codes, store
from clearsweep.cli import verbs
from clearsweep.language.errors import DamagedError, DirectoryError, StorageError
from clearsweep.report import page_of
from clearsweep.report.blocks.table import Column, Table
from clearsweep.store import durable, record

LIMITED = {"figures": {"excess": "rod_slider_force_peak - '0.1 N'"}, "limits": {"excess": "1 N"}}
PAYLOAD = "../<img src=x onerror=alert(1)>"


def swept(source, out):
    return fake_physics.sweep(source, out, executor="serial", show_progress=False)


@pytest.fixture(scope="module")
def source():
    return searching() | {"figures": LIMITED["figures"]}


@pytest.fixture(scope="module")
def ran(source, tmp_path_factory):
    out = tmp_path_factory.mktemp("untrusted") / "run"
    swept(source, out)
    return out


@pytest.fixture
def run(ran, tmp_path):
    """Return a copy of a finished run with an answer."""
    out = tmp_path / "run"
    for file in sorted(ran.rglob("*")):
        target = out / file.relative_to(ran)
        target.parent.mkdir(parents=True, exist_ok=True)
        if file.is_file():
            target.write_bytes(file.read_bytes())
        else:
            target.mkdir(exist_ok=True)
    return out


def crafted(run, change):
    """Change run.json as somebody would who knows how its checksum is made."""
    content = json.loads((run / "run.json").read_text())
    change(content)
    content["checksum"] = record.record_checksum(content)
    (run / "run.json").write_text(json.dumps(content))


def flipped(content):
    return content[:200] + bytes([content[200] ^ 1]) + content[201:]


HARMS = {
    "an answer changed": flipped,
    "deleted": lambda content: None,
    "empty": lambda content: b"",
    "cut off": lambda content: content[:100],
}


@pytest.mark.parametrize("harm", HARMS)
def test_a_damaged_answer_file_is_refused_and_made_anew_without_a_case(source, run, harm):
    file = run / "seek.parquet"
    before = file.read_bytes()
    after = HARMS[harm](before)
    file.unlink() if after is None else file.write_bytes(after)
    with pytest.raises(DirectoryError, match=r"seek.parquet.*run the grid again"):
        clearsweep.open(run)
    assert any("seek.parquet" in sentence for sentence in store.status(run)["damage"])
    assert swept(source, run).ran == 0
    assert file.read_bytes() == before
    assert store.status(run, every_file=True)["damage"] == []


def test_an_answer_file_of_another_run_is_refused(run, tmp_path):
    swept(searching(limit=0.5), tmp_path / "other")
    (run / "seek.parquet").write_bytes((tmp_path / "other" / "seek.parquet").read_bytes())
    with pytest.raises(DamagedError, match=r"seek\.parquet"):
        clearsweep.open(run)


def test_an_answer_that_nobody_sought_is_refused(ran, tmp_path):
    swept(fake_physics.grid(1), tmp_path / "plain")
    assert clearsweep.open(tmp_path / "plain").seek is None
    (tmp_path / "plain" / "seek.parquet").write_bytes((ran / "seek.parquet").read_bytes())
    with pytest.raises(DamagedError, match=r"seek\.parquet"):
        clearsweep.open(tmp_path / "plain")


def test_an_answer_without_a_checksum_is_refused_with_the_way_out(source, run):
    crafted(run, lambda content: content.pop("answers"))
    with pytest.raises(DamagedError, match=r"older version wrote it.*run the grid again"):
        clearsweep.open(run)
    swept(source, run)
    assert clearsweep.open(run).seek is not None


@pytest.mark.parametrize("name", ["seek.parquet", "summary.parquet"])
def test_a_table_of_other_columns_is_refused_even_with_a_good_checksum(run, name):
    other = {"seek.parquet": "summary.parquet", "summary.parquet": "seek.parquet"}[name]
    (run / name).write_bytes((run / other).read_bytes())

    def accept(content):
        content["answers" if name == "seek.parquet" else "merged"][name] = durable.checksum(run / name)

    crafted(run, accept)
    with pytest.raises(DamagedError, match="its columns differ from those"):
        clearsweep.open(run)


CRAFTED = {
    "layout.output": "../escaped",
    "layout.joints": "rod_slider",
    "layout.columns": [{"name": "x<script>", "unit": "1", "description": ""}],
    "layout.until": ["x"],
    "layout.until ": "../x",
    "layout.turns": "yes",
    "layout.more": 1,
    "layout.channels": [{"name": "../../x", "unit": "1", "description": ""}],
    "units": {"mechanism.slider.mass": "<b>"},
    "units ": {"../x": "m"},
    "name": "../../x",
    "sweep": {"mechanism.gravity": [[1.0]]},
    "limits": {"rod_slider_force_peak": "much"},
    "limits ": {"rod_slider_force_peak": {"at_most": [1]}},
    "limits  ": {"rod_slider_force_peak": 10**400},
    "warnings": "none",
    "source": "a\nb",
    "derived": {"x": 1},
    "counts": {"cases": "many"},
    "merged": {"../../x.h5": "0"},
    "keys": ["name", "missing"],
    "seek": {"largest": "../x"},
    "seek ": {"largest": ["joints.rod-slider.clearance", "../x"]},
    "seek  ": {"smallest": [5]},
    "fits": {"joints.a.clearance": [{"name": "H7/f7"}]},
    "joints": {"../a": {}},
    "shard": "../1",
    "figures": {"excess": 1.0},
}


@pytest.mark.parametrize("path", CRAFTED)
def test_a_crafted_record_is_refused_in_a_sentence_and_writes_nothing(run, path, capsys):
    def change(content):
        *sections, key = path.strip().split(".")
        for section in sections:
            content = content[section]
        content[key] = CRAFTED[path]

    crafted(run, change)
    there = sorted(run.parent.rglob("*"))
    for verb in (["report", str(run), "--tables", str(run.parent / "sub")], ["status", str(run)]):
        assert exit_codes.run(verbs, verb) == 2
        message = capsys.readouterr().err
        assert "Traceback" not in message
        assert str(run) in message
    assert sorted(run.parent.rglob("*")) == there


def leaves(value, path=()):
    """Yield the path of every text of a record, keys included."""
    if isinstance(value, dict):
        for key, each in value.items():
            yield (*path, key), key
            yield from leaves(each, (*path, key))
    elif isinstance(value, list):
        for place, each in enumerate(value[:2]):
            yield from leaves(each, (*path, place))
    elif isinstance(value, str):
        yield path, None


@pytest.mark.few("None")
@pytest.mark.parametrize("other", [PAYLOAD, None, 7, [], {"a": []}])
def test_whatever_stands_in_a_record_it_opens_or_is_refused(ran, run, other):
    original = json.loads((ran / "run.json").read_text())
    for path, key in leaves(original):
        content = copy.deepcopy(original)
        place = content
        for step in path[:-1]:
            place = place[step]
        if key is not None and isinstance(other, str):
            place[other] = place.pop(key)
        else:
            place[path[-1]] = other
        content["checksum"] = record.record_checksum(content)
        (run / "run.json").write_text(json.dumps(content))
        try:
            opened = clearsweep.open(run)
            assert len(opened.summary) == len(opened)
        except DirectoryError as error:
            assert str(run) in str(error), path  # noqa: PT017 - most are refused


def test_what_may_be_any_text_is_no_markup_in_the_page_and_its_tables(run, tmp_path):
    def change(content):
        content["warnings"] = [PAYLOAD]
        content["source"] = PAYLOAD
        for column in content["layout"]["columns"]:
            column["description"] = PAYLOAD

    crafted(run, change)
    page = page_of(clearsweep.open(run))
    file = page.write(tmp_path / "page.html")
    page.write_tables(tmp_path / "tables")
    for each in (file, *(tmp_path / "tables").glob("*.md")):
        assert "<img" not in each.read_text().replace('<img src="data:', "")


def test_a_table_is_no_markup_no_formula_and_stays_where_it_is_written(tmp_path):
    cells = [("=1+1", 1.0), ("<b>|`x`[y](z)", -2.0), ("plain", 3.0)]
    table = Table("../up", "T <i>", "N <i>", (Column("@head"), Column("value", "m")), cells)
    files = table.write(tmp_path)
    assert [file.resolve().parent for file in files] == [tmp_path.resolve()] * 2
    csv, markdown = (file.read_text() for file in files)
    assert csv.splitlines() == ["'@head,value [m]", "'=1+1,1.0", "<b>|`x`[y](z),-2.0", "plain,3.0"]
    assert "<" not in markdown
    assert r"&lt;b&gt;\|\`x\`\[y](z)" in markdown


HARMED = {
    "parts": {"cut": lambda b: b[: len(b) // 2], "empty": lambda b: b"", "gone": lambda b: None, "flipped": flipped},
    "shards": {"cut": lambda b: b[: len(b) // 2], "gone": lambda b: None},
}


@pytest.mark.few("parts-cut", "shards-gone")
@pytest.mark.parametrize(("folder", "harm"), [(folder, harm) for folder in HARMED for harm in HARMED[folder]])
def test_a_batch_that_is_damaged_while_a_run_works_is_said_and_runs_again(tmp_path, monkeypatch, folder, harm):
    source, out, commit, done = fake_physics.grid(6, wear=True), tmp_path / "run", store.commit, []

    def harming(directory, form, batch, rows):
        name = commit(directory, form, batch, rows)
        if not done:
            (file,) = (out / folder).glob(f"{batch}*")
            after = HARMED[folder][harm](file.read_bytes())
            file.unlink() if after is None else file.write_bytes(after)
        done.append(name)
        return name

    with monkeypatch.context() as patched:
        patched.setattr(store, "commit", harming)
        with pytest.raises(StorageError, match=r"damaged or removed .*run the same command again"):
            swept(source, out)
    again = swept(source, out)
    assert again.ran > 0
    assert (again.ok, again.missing) == (6, 0)
    swept(source, tmp_path / "undisturbed")
    assert same_results(tmp_path / "undisturbed", out)


@pytest.mark.parametrize("verb", ["status", "report", "clean", "run"])
def test_a_record_of_an_older_version_is_refused_by_its_version(source, run, verb, capsys):
    def of_version_12(content):
        content["model_version"], content["versions"]["clearsweep"] = "12", "0.0.9"
        content["layout"]["joints"][0]["naming"] = True  # an entry that this version had

    crafted(run, of_version_12)
    if verb == "run":
        with pytest.raises(DirectoryError) as caught:
            swept(source, run)
        message = str(caught.value)
    else:
        assert exit_codes.run(verbs, [verb, str(run)]) == 2
        message = capsys.readouterr().err
    assert "is of model version '12', written by clearsweep '0.0.9'" in message
    assert "Run the grid again into another directory, or read it with that version" in message
    assert "damaged" not in message


@pytest.mark.parametrize("key", ["layout", "units", "keys", "frame"])
def test_a_record_without_what_every_one_has_is_refused(run, key):
    crafted(run, lambda content: content.pop(key))
    with pytest.raises(DamagedError, match="run the grid again"):
        clearsweep.open(run)


def test_all_cases_of_another_model_version_are_not_put_together(run, capsys):
    crafted(run, lambda content: content.update(model_version="1"))
    assert exit_codes.run(verbs, ["report", str(run), "--all"]) == 2
    assert "another version wrote its cases" in capsys.readouterr().err


# ---------------------------------------------------------------------------------------------- other content


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Return the directory of a finished run of two cases with histories, a secret and a pipe next to it."""
    place = tmp_path_factory.mktemp("crafted")
    swept(fake_physics.grid(2), place / "run")
    (place / "secret").write_bytes(b"S" * 9000)
    os.mkfifo(place / "pipe")
    return place / "run"


@pytest.fixture
def copied(plain, tmp_path):
    shutil.copytree(plain, tmp_path / "run")
    return tmp_path / "run"


def crafted_orbits(run, change):
    """Change orbits.h5 as somebody would who signs run.json again."""
    with h5py.File(run / "orbits.h5", "r+") as file:
        change(file)
    crafted(run, lambda content: content["merged"].update({"orbits.h5": durable.checksum(run / "orbits.h5")}))


def replaced(name, values):
    def change(file):
        new = values(file[name][()])
        del file[name]
        file[name] = new

    return change


def external(name, kind, place):
    def change(file):
        count = file[name].shape[0]
        del file[name]
        file.create_dataset(name, (count,), kind, external=[(str(place), 0, count * np.dtype(kind).itemsize)])

    return change


def linked(name, link):
    def change(file):
        del file[name]
        file[name] = link

    return change


def virtual(name, place):
    def change(file):
        layout = h5py.VirtualLayout(file[name].shape, "f8")
        layout[:] = h5py.VirtualSource(str(place), name, file[name].shape)
        del file[name]
        file.create_virtual_dataset(name, layout)

    return change


ORBITS = {
    "a file in place of values": lambda there: external("t", "f8", there / "secret"),
    "a pipe in place of values": lambda there: external("t", "f8", there / "pipe"),
    "a pipe in place of cases": lambda there: external("case_id", "S16", there / "pipe"),
    "a link to a pipe": lambda there: linked("t", h5py.ExternalLink(str(there / "pipe"), "t")),
    "a link to another run": lambda there: linked("events", h5py.ExternalLink(str(there / "run/orbits.h5"), "events")),
    "peaks elsewhere": lambda there: lambda file: file.update(worst=h5py.ExternalLink(str(there / "pipe"), "/")),
    "a soft link": lambda there: linked("t", h5py.SoftLink("/crank_angle")),
    "a virtual dataset": lambda there: virtual("t", there / "run/orbits.h5"),
    "another dataset": lambda there: lambda file: file.update(x=1.0),
    "a dataset missing": lambda there: lambda file: file.pop("t"),
    "a group": lambda there: lambda file: (file.pop("t"), file.create_group("t")),
    "texts": lambda there: replaced("t", lambda values: np.array([b"x"] * len(values))),
    "single precision": lambda there: replaced("t", lambda values: values.astype("f4")),
    "a value less": lambda there: replaced("t", lambda values: values[:-1]),
    "a case less": lambda there: replaced("case_id", lambda values: values[:-1]),
    "cases in another order": lambda there: replaced("case_id", lambda values: values[::-1]),
    "cases with other names": lambda there: replaced("case_id", lambda values: np.full_like(values, b"zz")),
    "offsets beyond the end": lambda there: replaced("offsets", lambda values: values + 10**12),
    "offsets that descend": lambda there: replaced("offsets", lambda values: values[::-1].copy()),
    "a mark of another type": lambda there: lambda file: file.attrs.update(clearsweep=np.zeros(3)),
}


@pytest.mark.parametrize("name", ORBITS)
def test_orbits_with_other_datasets_than_the_contract_are_refused_and_restored(plain, copied, name, capsys):
    crafted_orbits(copied, ORBITS[name](plain.parent))
    with pytest.raises(DamagedError, match=r"orbits\.h5: damaged .*run the grid again"):
        clearsweep.open(copied)
    assert exit_codes.run(verbs, ["report", str(copied)]) == 2
    assert "Traceback" not in capsys.readouterr().err
    assert swept(fake_physics.grid(2), copied).ran == 0
    assert same_results(plain, copied)


@pytest.mark.parametrize(("name", "value"), [("t", np.nan), ("t", 1e16), ("crank_angle", np.inf), ("slider/a", 1e101)])
def test_values_that_no_run_writes_are_refused_when_they_are_read(plain, copied, name, value):
    crafted_orbits(copied, lambda file: file[name].__setitem__(slice(None), value))
    run = clearsweep.open(copied)
    said = rf"{name} has values that no run writes, move the file away first\); run the grid again .*restores it"
    with pytest.raises(DamagedError, match=said):
        run.orbit(run.summary.case_id[0])
    (copied / "orbits.h5").unlink()
    assert swept(fake_physics.grid(2), copied).ran == 0
    assert same_results(plain, copied)


def test_a_code_of_no_joint_is_refused(copied):
    crafted_orbits(copied, lambda file: file["events/joint"].__setitem__(slice(None), 77))
    with pytest.raises(DamagedError, match="events/joint has values that no run writes"):
        list(clearsweep.open(copied).event_blocks())


def crafted_table(path, change):
    """Change a Parquet file; its metadata stay."""
    table = pq.read_table(path)
    pq.write_table(change(table).replace_schema_metadata(table.schema.metadata), path, write_page_checksum=True)


def with_column(name, values):
    def change(table):
        index = table.schema.get_field_index(name)
        content = pa.array([values] * len(table), pa.string() if isinstance(values, str) else pa.float64())
        return table.set_column(index, table.schema.field(index).with_type(content.type), content)

    return change


PEAK, MASS = "rod_slider_force_peak", "mechanism.slider.mass"
TABLES = {
    "no rows": lambda table: table.slice(0, 0),
    "repeated rows": lambda table: pa.concat_tables([table, table]),
    "rows in another order": lambda table: table.take([1, 0]),
    "infinite figures": with_column(PEAK, np.inf),
    "figures beyond any": with_column(PEAK, -1e308),
    "infinite figures that no answer needs": with_column("rod_slider_force_rms", np.inf),
    "NaN": with_column(PEAK, np.nan),
    "a figure of texts": with_column(PEAK, "a"),
    "an axis of texts": with_column(MASS, "a"),
    "an axis without values": with_column(MASS, None),
    "other values of the axis": with_column(MASS, 7.0),
    "other cases": with_column("case_id", "0" * 16),
    "no identities": with_column("case_id", "zz"),
    "a column twice": lambda table: table.append_column(table.schema.field("status"), table["status"]),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_summary_of_other_rows_or_values_is_refused_and_restored(plain, copied, name, capsys):
    crafted_table(copied / "summary.parquet", TABLES[name])
    crafted(
        copied,
        lambda content: content["merged"].update({"summary.parquet": durable.checksum(copied / "summary.parquet")}),
    )
    assert exit_codes.run(verbs, ["report", str(copied)]) == 2
    message = capsys.readouterr().err
    assert "Traceback" not in message
    assert "summary.parquet" in message or "its cases are not those of summary.parquet" in message
    with pytest.raises(DamagedError):
        len(clearsweep.open(copied).summary)
    swept(fake_physics.grid(2), copied)
    assert same_results(plain, copied)


def batch_of(run, change, folder="parts"):
    """Change a batch as somebody would who knows how it is named; remove what was merged from it."""
    path = sorted((run / folder).iterdir())[0]
    change(path)
    named = path.with_name(f"{path.name[:17]}{durable.checksum(path)[:16]}{path.suffix}")
    path.rename(named)
    for name in ("summary.parquet", "orbits.h5"):
        (run / name).unlink(missing_ok=True)
    return named


def facts(**changed):
    def change(path):
        table = pq.read_table(path)
        content = json.loads(table.schema.metadata[b"clearsweep"]) | changed
        content = {key: value for key, value in content.items() if value is not facts}
        pq.write_table(table.replace_schema_metadata({"clearsweep": json.dumps(content)}), path)

    return change


def metadata(text):
    return lambda path: pq.write_table(pq.read_table(path).replace_schema_metadata({"clearsweep": text}), path)


BATCHES = {
    "histories of the system": facts(shard="/etc/passwd"),
    "histories above": facts(shard="../../../../../../../../etc/passwd"),
    "histories of another batch": facts(shard=f"{'0' * 16}-{'0' * 16}.h5"),
    "histories that are a number": facts(shard=5),
    "no checksum": facts(sha256=facts),
    "no time": facts(written=facts),
    "a list": metadata("[]"),
    "no JSON": metadata("{"),
    "deep JSON": metadata("[" * 100_000),
    "no facts": lambda path: pq.write_table(pq.read_table(path).replace_schema_metadata({}), path),
    "empty": lambda path: path.write_bytes(b""),
    "no Parquet": lambda path: path.write_bytes(b"hello"),
    **{
        name: lambda path, change=change: crafted_table(path, change)
        for name, change in TABLES.items()
        if name
        not in (
            "repeated rows",
            "rows in another order",
            "no rows",
            "other values of the axis",
            "an axis without values",
        )
    },
    "no status": lambda path: crafted_table(path, lambda table: table.drop_columns(["status"])),
    "capital letters": lambda path: crafted_table(path, with_column("case_id", "ABCDEF0123456789")),
}


@pytest.mark.parametrize("name", BATCHES)
def test_a_batch_that_no_run_writes_is_named_by_every_verb_and_runs_again(plain, copied, name, capsys):
    batch_of(copied, BATCHES[name])
    for verb in (["status", str(copied)], ["clean", str(copied), "--dry-run"]):
        assert exit_codes.run(verbs, verb) in (0, 2)
        assert "Traceback" not in capsys.readouterr().err
    damage = store.status(copied, every_file=True)["damage"]
    assert any(place in sentence for place in ("parts/", "shards/") for sentence in damage)
    again = swept(fake_physics.grid(2), copied)
    assert (again.ran > 0, again.ok, again.missing) == (True, 2, 0)
    assert same_results(plain, copied)


HISTORIES = {"external": ORBITS["a pipe in place of values"], "no t": ORBITS["a dataset missing"]}
HISTORIES |= {name: ORBITS[name] for name in ("texts", "a value less", "offsets beyond the end", "a soft link")}
HISTORIES["infinite"] = lambda there: lambda file: file["slider/a"].__setitem__(slice(None), np.inf)
HISTORIES["no HDF5"] = None


@pytest.mark.parametrize("name", HISTORIES)
def test_histories_of_a_batch_that_no_run_writes_are_set_aside_and_run_again(plain, copied, name):
    def change(path):
        if HISTORIES[name] is None:
            path.write_bytes(b"hello")
            return
        with h5py.File(path, "r+") as file:
            HISTORIES[name](plain.parent)(file)

    histories = batch_of(copied, change, "shards")
    batch_of(copied, facts(shard=histories.name, sha256=durable.checksum(histories)))
    with pytest.raises(StorageError, match=r"damaged .*run the same command again"):
        swept(fake_physics.grid(2), copied)
    assert swept(fake_physics.grid(2), copied).ran > 0
    assert same_results(plain, copied)


def test_a_record_with_countless_contacts_is_refused_at_once(copied):
    crafted(copied, lambda content: content["layout"]["joints"][0].update(corners=10**12))
    with pytest.raises(DamagedError, match="corners"):
        clearsweep.open(copied)


# ---------------------------------------------------------------------------------------------- reading and writing


def test_a_read_that_returns_less_than_asked_is_continued(plain, tmp_path, monkeypatch):
    calls, pread = [], os.pread

    def short(handle, size, offset):
        calls.append(size)
        return pread(handle, max(size - 8, 1) if len(calls) % 3 == 0 else size, offset)

    with monkeypatch.context() as patched:
        patched.setattr(os, "pread", short)
        swept(fake_physics.grid(2), tmp_path / "run")
    assert len(calls) > 10
    assert same_results(plain, tmp_path / "run")


def test_a_file_that_ends_early_is_never_merged(tmp_path, monkeypatch):
    pread = os.pread
    monkeypatch.setattr(os, "pread", lambda handle, size, offset: pread(handle, size, offset)[:-8])
    monkeypatch.setattr(durable, "read_span", lambda file, offset, size: os.pread(file.fileno(), size, offset))
    with pytest.raises(StorageError, match=r"bytes of histories were read, not"):  # the merge counts, too
        swept(fake_physics.grid(2), tmp_path / "run")


def test_a_span_beyond_the_end_of_a_file_is_an_error(tmp_path):
    (tmp_path / "file").write_bytes(b"0123456789")
    with durable.open_regular(tmp_path / "file") as file:
        assert durable.read_span(file, 2, 5) == b"23456"
        with pytest.raises(EOFError, match="3 bytes early"):
            durable.read_span(file, 8, 5)


@pytest.mark.parametrize(("name", "verb"), [("orbits.h5", "read"), ("summary.parquet", "read")])
def test_an_unreadable_file_is_not_called_damaged(copied, monkeypatch, name, verb):
    opening = os.open

    def refuse(path, *arguments, **options):
        if str(path).endswith(name):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
        return opening(path, *arguments, **options)

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(DirectoryError, match=rf"{name}: cannot be {verb} \(Permission denied\)") as caught:
        clearsweep.open(copied)
    assert not isinstance(caught.value, DamagedError)


@pytest.mark.parametrize("folder", ["shards", "parts", "tmp"])
def test_a_link_in_place_of_a_folder_of_a_run_is_not_followed_while_it_works(tmp_path, monkeypatch, folder):
    out, elsewhere, commit = tmp_path / "run", tmp_path / "elsewhere", store.commit
    elsewhere.mkdir()

    def exchanging(directory, *arguments):
        if not (out / folder).is_symlink():
            (out / folder).rename(tmp_path / "moved")
            (out / folder).symlink_to(elsewhere)
        return commit(directory, *arguments)

    monkeypatch.setattr(store, "commit", exchanging)
    with pytest.raises(DirectoryError, match=rf"{folder}: is a link, not a folder"):
        swept(fake_physics.grid(2), out)
    assert list(elsewhere.iterdir()) == []


def test_the_directory_of_a_run_may_be_behind_a_link_of_the_user(tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "run").symlink_to(tmp_path / "disk")
    assert swept(fake_physics.grid(2), tmp_path / "run").ok == 2


@pytest.mark.parametrize("ending", ["yaml", "html", "csv", "png"])
def test_a_file_that_clearsweep_did_not_write_is_not_replaced(tmp_path, ending):
    file = tmp_path / f"mine.{ending}"
    file.write_text("# a grid for clearsweep\nname: t\n")
    with pytest.raises(DirectoryError, match="clearsweep did not write it"):
        durable.replace_output(file, b"new")
    with pytest.raises(DirectoryError, match="exists with other columns"):
        durable.replace_output(file, b"new", b"t,force")
    assert file.read_text().startswith("# a grid")


@pytest.mark.parametrize(
    "old", [b"", b"t,force\n1,2\n", b'<!doctype html>\n<meta name="generator" content="clearsweep">']
)
def test_an_empty_file_and_what_clearsweep_wrote_are_replaced(tmp_path, old):
    (tmp_path / "out").write_bytes(old)
    durable.replace_output(tmp_path / "out", b"new", b"t,force")
    assert (tmp_path / "out").read_bytes() == b"new"


def test_a_report_is_written_again_but_never_over_a_grid(copied, tmp_path, capsys):
    grid = tmp_path / "g.yaml"
    grid.write_text("name: mine\n")
    assert exit_codes.run(verbs, ["report", str(copied), "--out", str(grid)]) == 2
    assert grid.read_text() == "name: mine\n"
    outputs = ["--tables", str(tmp_path / "tables"), "--figures", str(tmp_path / "figures")]
    for _ in range(2):
        assert exit_codes.run(verbs, ["report", str(copied), *outputs]) == 0


@pytest.mark.parametrize("start", ["=", "+", "-", "@", " =", "\t=", "\uff1d"])
def test_no_cell_of_a_table_begins_like_a_formula_also_after_a_semicolon(start):
    table = Table("t", "T", "", (Column("name"), Column("other")), [(f"{start}1+1", f"plain;{start}cmd()")])
    first, second = table.csv().splitlines()[1].split(",")
    assert first.strip('"').startswith("'")
    assert second.strip('"').startswith("plain;'")


class Elements(html.parser.HTMLParser):
    """Collects the elements of a page that could run something."""

    def __init__(self, text):
        super().__init__()
        self.active = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag in ("img", "iframe", "object", "embed", "base") or any(name.startswith("on") for name, _ in attrs):
            self.active.append((tag, attrs))


@pytest.mark.parametrize("text", ["a</script><img src=x onerror=pwn()>", "\"'><svg onload=pwn()>b`c"])
def test_labels_and_messages_of_a_stranger_are_no_elements_of_a_page(tmp_path, text):
    axes = {MASS: {text: 0.1, "b": 0.2}, "joints.rod-slider.clearance": {f"c{text}": "0.1 mm", "d": "0.2 mm"}}
    swept(fake_physics.grid(2, sweep=axes), tmp_path / "run")
    crafted_table(tmp_path / "run" / "summary.parquet", with_column("message", f"{text}\u202e"))
    new = {"summary.parquet": durable.checksum(tmp_path / "run" / "summary.parquet")}
    crafted(tmp_path / "run", lambda content: content["merged"].update(new))
    page = page_of(clearsweep.open(tmp_path / "run")).text()
    assert page.count("pwn()") > 2
    assert Elements(page).active == []
