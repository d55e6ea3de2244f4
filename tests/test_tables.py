"""Tables as designers bring them: separators, decimal commas, workbooks, headers of their own, labels, pressures."""

import math
import zipfile
from pathlib import Path

import clearsweep_xlsx
import numpy as np
import pytest
from fake_runs import JOINT, TEXT
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import grid, simulation
from clearsweep.language.errors import InputError
from clearsweep.report.blocks.table import case_table
from clearsweep.report.study import prepare
from clearsweep.simulation.machine.ideal import machine_of, mechanism_of

GAP, SPEED = f"{JOINT}.clearance", "drive.speed"
ROWS = f"{SPEED} [rpm];{GAP} [mm]\n500;0,05\n1000;0,1\n"


def points(cases):
    return [cases.point(k) for k in range(len(cases))]


@pytest.fixture
def table(at):
    """Return a function that loads the demo grid with the cases of a table."""

    def loaded(content, cases="cases: cases.csv\n", name="cases.csv"):
        Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return at(TEXT + cases)

    return loaded


@pytest.mark.parametrize(
    "content",
    [
        ROWS,
        "\N{ZERO WIDTH NO-BREAK SPACE}" + ROWS,  # a byte order mark
        ROWS.replace(";", "\t"),
        ROWS.replace(",", "."),
        ROWS.replace(",", ".").replace(";", ","),
        ROWS.replace(";", "\t").replace(",", "."),
        ROWS.replace("0,05", "0,050").replace("0,1", "0,100"),  # no thousands begin with 0
        ROWS.replace("\n", "\r\n"),
    ],
)
def test_every_usual_separator_and_decimal_sign_gives_the_same_cases(table, content):
    expected = [{SPEED: 500 * math.pi / 30, GAP: 5e-5}, {SPEED: 1000 * math.pi / 30, GAP: 1e-4}]
    assert points(table(content)) == [pytest.approx(point, rel=1e-15) for point in expected]


def test_headers_of_ones_own_are_mapped_to_paths(table):
    content = "gap;n [rpm]\n50;500\n60;600\n"
    cases = table(content, f"cases: {{table: cases.csv, columns: {{gap: '{GAP} [um]', n: {SPEED}}}}}\n")
    assert points(cases)[0] == pytest.approx({GAP: 5e-5, SPEED: 500 * math.pi / 30})


def test_a_workbook_gives_the_cases_of_its_sheet(table):
    sheets = [
        [["name", "gap", f"{SPEED} [rpm]"], ["V1", 50.5, 500], ["V2", 60, 600], []],
        [[f"{SPEED} [rpm]"], [700]],
    ]
    clearsweep_xlsx.write("cases.xlsx", sheets)
    content = Path("cases.xlsx").read_bytes()
    mapped = f"cases: {{table: cases.xlsx, columns: {{gap: '{GAP} [um]'}}, label: name}}\n"
    cases = table(content, mapped, "cases.xlsx")
    assert points(cases)[0] == pytest.approx({GAP: 5.05e-5, SPEED: 500 * math.pi / 30})
    assert dict(cases.case_labels) == {"name": ["V1", "V2"]}
    second = table(content, "cases: {table: cases.xlsx, sheet: 2}\n", "cases.xlsx")
    assert points(second) == [pytest.approx({SPEED: 700 * math.pi / 30})]
    with pytest.raises(InputError, match="has 2 sheets; there is no sheet 3"):
        table(content, "cases: {table: cases.xlsx, sheet: 3}\n", "cases.xlsx")
    with pytest.raises(InputError, match=r"is no Excel workbook \(.xlsx\)"):
        table("text", "cases: cases.xlsx\n", "cases.xlsx")


@pytest.mark.parametrize(
    ("header", "label"), [("label", ""), ("variant", ""), ("label", "x"), ("No.", ", label: 'No.'")]
)
def test_texts_ride_along_without_being_an_axis(table, header, label):
    texts = ("12", "13") if header == "No." or label == "x" else ("V01", "V02")
    keys = label if label.startswith(",") else ""
    cases = table(f"{header},{SPEED} [rpm]\n{texts[0]},500\n{texts[1]},600\n", f"cases: {{table: cases.csv{keys}}}\n")
    assert list(cases.axes) == [SPEED]
    assert dict(cases.case_labels) == {header: list(texts)}
    plain = table(f"{SPEED} [rpm]\n500\n600\n")
    assert [cases.case_id(k) for k in range(2)] == [plain.case_id(k) for k in range(2)]


def test_labels_are_in_the_summary_and_in_the_last_lines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("cases.csv").write_text("variant,mechanism.speed [m/s]\nslow,0.5\nfast,1.5\n", encoding="utf-8")
    source = (Path(__file__).parent.parent / "configs/impact_pair.yaml").read_text(encoding="utf-8")
    Path("g.yaml").write_text(
        f"{source.partition('sweep:')[0]}cases: cases.csv\nlimits: {{pair_force_peak: 1 MN}}\n", encoding="utf-8"
    )
    result = clearsweep.sweep("g.yaml", executor="serial", show_progress=False)
    summary = result.open().summary
    assert dict(zip(summary["mechanism.speed"], summary["variant"], strict=True)) == {0.5: "slow", 1.5: "fast"}
    from clearsweep.sweeping import summary as run_summary

    facts = run_summary.of_run(result)
    assert {entry["swept"]["variant"] for entry in facts["worst"]} == {"slow", "fast"}
    assert "slow" in run_summary.run_text(facts)
    (design,) = facts["answer"]["designs"]
    assert set(design["labels"]["variant"]) == {"slow", "fast"}
    study = prepare(result.open())
    table = case_table(study, "peaks", "Peaks", [("pair_force_peak", "peak")], "pair_force_peak")
    assert [column.name for column in table.columns][:2] == ["case_id", "variant"]
    assert {row[1] for row in table.rows} == {"slow", "fast"}
    assert study.setting(table.rows[0][0]).startswith(f"variant {table.rows[0][1]}")


PRESSURES = {"crank_angle [deg]": [0, 90, 180, 270, 360], "pressure [bar]": [10.5, 3.25, 1.0, 2.0, 10.5]}


def gas(**keys):
    load = {"on": "slider", "table": PRESSURES} | keys
    return grid.load(slider_crank("rod-slider") | {"loads": {"gas": load}}, simulation.catalogue())


def pushes(cases, index=0):
    case = cases.case(index)
    (load,) = machine_of(mechanism_of(case), case).loads
    return np.array([load.fx, load.fy])


def test_a_pressure_pushes_the_piston_towards_the_crank():
    expected = -0.25 * math.pi * 0.06**2 * 1e5 * (np.array(PRESSURES["pressure [bar]"]) - 1.0)
    assert np.allclose(pushes(gas(bore="60 mm", ambient="1 bar")), [expected, np.zeros(5)], rtol=1e-14, atol=0.0)
    above = pushes(gas(bore="60 mm", ambient="1 bar", direction="90 deg"))
    assert np.allclose(above, [np.zeros(5), -expected], rtol=1e-14, atol=1e-9)
    relative = pushes(gas(bore="60 mm"))
    assert np.allclose(relative - [expected, np.zeros(5)], [[-0.25 * math.pi * 0.06**2 * 1e5] * 5, [0.0] * 5])


def test_a_workbook_that_unpacks_to_too_much_is_refused(table, monkeypatch):
    from clearsweep.grid import written as document

    monkeypatch.setattr(document, "MAX_PART_BYTES", 10_000)
    with zipfile.ZipFile("bomb.xlsx", "w", zipfile.ZIP_DEFLATED) as book:
        book.writestr("xl/worksheets/sheet1.xml", " " * 1_000_000)
    with pytest.raises(InputError, match="has more than 10,000 bytes"):
        table(Path("bomb.xlsx").read_bytes(), "cases: bomb.xlsx\n", "bomb.xlsx")


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ('<c r="A2" t="b"><v>1</v></c>', "found 'TRUE rpm'"),
        ('<c r="A2"><f>1/10</f></c>', "found '=1/10 rpm'"),
        ('<c r="A2" t="s"><v>7</v></c>', r"is no Excel workbook \(.xlsx\)"),
        ('<c r="ZZZZZZZ2"><v>700</v></c>', None),
    ],
)
def test_odd_cells_of_a_workbook(table, cell, message):
    """A truth value is no number, a formula needs its stored value, and an address has at most three letters."""
    with zipfile.ZipFile("odd.xlsx", "w") as book:
        header = f'<c r="A1" t="inlineStr"><is><t>{SPEED} [rpm]</t></is></c>'
        document = f'<row r="1">{header}</row><row r="2">{cell}</row>'
        book.writestr("xl/sharedStrings.xml", "<sst/>")
        book.writestr("xl/worksheets/sheet1.xml", f"<worksheet><sheetData>{document}</sheetData></worksheet>")
    content = Path("odd.xlsx").read_bytes()
    if message is None:
        assert points(table(content, "cases: odd.xlsx\n", "odd.xlsx")) == [pytest.approx({SPEED: 700 * math.pi / 30})]
    else:
        with pytest.raises(InputError, match=message):
            table(content, "cases: odd.xlsx\n", "odd.xlsx")
