"""clearsweep beside measurements and published solutions: the claims of results/measured.md, and its own form."""

import json
from collections.abc import Iterable

import pytest
from click.testing import CliRunner

from clearsweep import cli
from clearsweep.verify import measured
from clearsweep.verify.measured import film_at_rest, hertz, page
from clearsweep.verify.measured.points import KINDS, Row

pytestmark = pytest.mark.heavy

KEYS = {"benchmark", "kind", "source", "point", "quantity", "unit", "reference", "computed", "difference"}
slow = pytest.mark.slow


def largest(rows: Iterable[Row], quantity: str, variant: str = "") -> float:
    """Return the largest difference of a quantity; there has to be one."""
    found = [abs(row.difference) for row in rows if (row.quantity, row.variant) == (quantity, variant)]
    assert found
    return max(found)


def test_a_hertz_impact_is_as_deep_hard_and_long_as_the_closed_form():
    rows = hertz.measure()
    assert len(rows) == 12
    assert all(row.computed == pytest.approx(row.reference, rel=5e-5) for row in rows)


def test_a_housing_settles_where_the_table_of_its_film_says():
    rows = film_at_rest.measure(quick=True)
    assert largest(rows, "eccentricity ratio", "reynolds") < 0.003
    assert largest(rows, "attitude", "reynolds") < 4.0
    assert largest(rows, "eccentricity ratio", "finite") < 0.01


@slow
def test_every_film_settles_where_both_tables_say_and_drags_as_tabulated():
    rows = film_at_rest.measure()
    published = [row for row in rows if row.kind == "published"]
    assert len({row.point for row in published}) >= 24
    assert largest(published, "eccentricity ratio", "reynolds") < 0.003
    assert largest(published, "attitude", "reynolds") < 4.0
    drag = [row for row in rows if row.quantity == "friction variable"]
    assert all(row.computed == pytest.approx(row.reference, rel=0.012) for row in drag)


@pytest.fixture
def few(monkeypatch):
    """Leave only what takes no time."""
    monkeypatch.setattr(measured, "BENCHMARKS", (hertz,))


@pytest.mark.usefixtures("few")
def test_the_command_prints_rows_of_the_contract_as_json():
    told = CliRunner().invoke(cli.verbs, ["verify", "--measured", "--json"])
    assert told.exit_code == 0, told.output
    rows = json.loads(told.stdout)
    assert len(rows) == 12
    for row in rows:
        assert set(row) >= KEYS
        assert row["kind"] in KINDS
        assert row["difference"] == pytest.approx(row["computed"] - row["reference"])


def test_the_page_has_every_point_its_source_and_its_spread(tmp_path):
    rows = hertz.measure()
    words = page.write(rows, tmp_path, (hertz,)).read_text(encoding="utf-8")
    assert words.count("| Hertz impacts |") == 12
    assert rows[0].source in words
    assert "| depth |  | published | 4 |" in words
    assert "Hertz impacts, depth" in page.text(rows)
