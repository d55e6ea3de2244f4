"""A results directory is read like a file from a stranger: what is not as it was written is refused in a sentence."""

import copy
import json

import fake_physics
import pytest
from test_seek import searching
from test_sweep import same_results

import clearsweep
from clearsweep import store
from clearsweep.cli import _exit_code
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
def test_an_answer_file_that_is_not_as_written_is_refused_and_made_anew_without_a_case(source, run, harm):
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


def test_an_answer_without_a_checksum_as_older_versions_left_it_is_refused_with_the_way_out(source, run):
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
        assert _exit_code(verb) == 2
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


@pytest.mark.parametrize("schema", [1, 99, "<b>"])
def test_another_form_of_directories_is_refused_by_every_verb_with_what_to_do(run, schema, capsys):
    crafted(run, lambda content: content["frame"].update(schema=schema))
    for verb in (["report"], ["report", "--all"], ["status"], ["show", "0"]):
        assert _exit_code([verb[0], str(run), *verb[1:]]) == 2
        message = capsys.readouterr().err
        assert "run the grid again into another directory, or read it with that version" in message


@pytest.mark.parametrize("key", ["layout", "units", "keys", "frame"])
def test_a_record_without_what_every_one_has_is_refused(run, key):
    crafted(run, lambda content: content.pop(key))
    with pytest.raises(DamagedError, match="run the grid again"):
        clearsweep.open(run)


def test_all_cases_of_another_model_version_are_not_put_together(run, capsys):
    crafted(run, lambda content: content.update(model_version="1"))
    assert _exit_code(["report", str(run), "--all"]) == 2
    assert "another version wrote its cases" in capsys.readouterr().err
